"""Pictures of a droplet in a bed: depth, heat and forces over time, the grains at the end, and an animation."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from ..output.figures import STYLE, plt, save
from .column_pictures import draw_beads, draw_motion

SMOOTHED = 0.02
"""s over which forces and heat are averaged in the pictures: beads that touch make them jump from step to step."""


def draw_droplet(path: Path, column: Any) -> Path:
    """Depth, heat and forces over time, and grains and droplet at the end; gives the path."""
    rows = column.rows
    width = max(1, round(SMOOTHED / column.given.time_step))

    def of(name: str, smooth: bool = False) -> Any:
        values = np.array([row[name] for row in rows])
        if smooth and len(values) > width:
            return np.convolve(values, np.full(width, 1.0 / width), mode="valid")
        return values

    time = of("time")
    late = of("time", smooth=True)
    with plt.rc_context(STYLE):
        figure, axes = plt.subplot_mosaic(
            [["depth", "bed"], ["heat", "bed"], ["forces", "bed"]],
            figsize=(11.0, 8.0), layout="constrained", width_ratios=(1.4, 1.0))  # fmt: skip
        above, bed, below, forces = (axes[name] for name in ("depth", "bed", "heat", "forces"))
        above.plot(time, 1e3 * of("depth"), label="droplet's centre")
        above.axhline(0.0, color="0.4", linestyle="--", linewidth=1.0, label="surface of the bed at rest")
        above.invert_yaxis()
        above.set(xlabel="time in s", ylabel="depth in mm")
        above.legend(fontsize=9)
        below.plot(late, of("heat_by_gas", smooth=True), label="to the droplet by bed and gas")
        below.plot(late, of("heat_by_beads", smooth=True), label="by grains inside")
        below.set(xlabel="time in s", ylabel="heat in W", ylim=(0.0, None))
        below.legend(fontsize=9)
        weight = of("weight", smooth=True)
        forces.plot(late, of("force_by_gas", smooth=True) / weight, label="gas")
        forces.plot(late, of("force_by_beads", smooth=True) / weight, label="grains inside")
        forces.set(xlabel="time in s", ylabel="force in weights")
        forces.legend(fontsize=9)
        drawn = draw_beads(bed, column, column.beads.places, column.beads.temperature - 273.15)
        across, up = map(float, column.droplet.place)
        bed.add_patch(_circle(across, up, column.droplet.radius))
        figure.colorbar(drawn, ax=bed, label="grain temperature in °C")
        return save(figure, path)


def _circle(across: float, up: float, radius: float) -> Circle:
    return Circle((1e3 * across, 1e3 * up), 1e3 * radius, fill=False, edgecolor="tab:blue", linewidth=1.8)


def draw_moving_droplet(path: Path, column: Any, pictures: list[Any]) -> Path:
    """An animation (GIF) of (time, places, temperatures in °C), with the droplet of those times; gives the path."""
    times = np.array([row["time"] for row in column.rows])

    def droplet(axes: Axes) -> Any:
        circle = axes.add_patch(_circle(0.0, 0.0, 1e-3))

        def move(time: float) -> None:
            row = column.rows[int(np.argmin(np.abs(times - time)))]
            circle.set_center((1e3 * row["across"], 1e3 * (column.surface - row["depth"])))
            circle.set_radius(1e3 * row["radius"])

        return move

    return draw_motion(path, column, pictures, droplet)
