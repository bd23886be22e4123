"""Pictures of a column of beads: pressure drop and temperatures over time, the beads at the end, and an animation."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes

from ..output.figures import STYLE, plt, save

FRAMES_A_SECOND = 15


def draw_column(path: Path, column: Any) -> Path:
    """Pressure drop beside the weight, bed height, temperatures, and the beads at the end; gives the path."""
    rows = column.rows
    time = np.array([row["time"] for row in rows])

    def of(name: str) -> Any:
        return np.array([row[name] for row in rows])

    with plt.rc_context(STYLE):
        figure, (left, middle, right) = plt.subplots(
            1, 3, figsize=(13.0, 4.4), layout="constrained", width_ratios=(1.2, 1.2, 0.8)
        )
        left.plot(time, of("pressure_drop"), linewidth=1.0, label="pressure drop of the gas")
        left.axhline(column.weight, color="k", linestyle="--", linewidth=1.0, label="weight of the beads")
        left.set(xlabel="time in s", ylabel="Pa", ylim=(0.0, None))
        left.legend(fontsize=9)
        middle.plot(time, of("bead_temperature") - 273.15, label="beads, mean")
        middle.plot(time, of("outlet_temperature") - 273.15, label="gas at the outlet")
        middle.set(xlabel="time in s", ylabel="temperature in °C")
        middle.legend(fontsize=9)
        drawn = draw_beads(right, column, column.beads.places, column.beads.temperature - 273.15)
        figure.colorbar(drawn, ax=right, label="bead temperature in °C")
        return save(figure, path)


def draw_beads(axes: Axes, column: Any, places: Any, temperatures: Any) -> Any:
    """The beads as dots, in mm."""
    axes.set(
        xlim=(-500.0 * column.given.width, 500.0 * column.given.width),
        ylim=(0.0, 1e3 * column.given.height),
        aspect="equal",
    )
    axes.set(xlabel="across in mm", ylabel="height in mm")
    axes.grid(visible=False)
    return axes.scatter(1e3 * places[:, 0], 1e3 * places[:, 1], s=6.0, c=temperatures, cmap="inferno", linewidths=0.0)


def draw_motion(
    path: Path, column: Any, pictures: list[Any], extra: Callable[[Any], Callable[[float], None]] | None = None
) -> Path:
    """An animation (GIF) of (time, places, temperatures in °C); gives the path. `extra(axes)` draws something besides, and gives
    what moves it to a time (s)."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(4.4, 6.0), layout="constrained")
        low, high = (float(edge([edge(warm) for _, _, warm in pictures])) for edge in (np.min, np.max))
        drawn = draw_beads(axes, column, *pictures[0][1:])
        drawn.set_clim(low, max(high, low + 1e-3))
        figure.colorbar(drawn, ax=axes, label="bead temperature in °C")
        move = extra(axes) if extra is not None else None

        def show(frame: int) -> None:
            time, places, warm = pictures[frame]
            drawn.set_offsets(1e3 * places)
            drawn.set_array(warm)
            if move is not None:
                move(time)
            axes.set_title(f"t = {time:.2f} s", fontsize=10)

        movie = FuncAnimation(figure, show, frames=len(pictures))
        movie.save(path, PillowWriter(fps=FRAMES_A_SECOND), dpi=90)
        plt.close(figure)
    return path
