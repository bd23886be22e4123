"""Pictures of sheared beds: profiles across the cell, fluxes, and the beads in motion."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes

from ..output.figures import STYLE, plt, save

MOST_CURVES = 8
FRAMES_A_SECOND = 12


def draw_shear(path: Path, results: list[Any]) -> Path:
    """Velocity, solid fraction and temperature against height, and the fluxes; gives the path. `results`: of `Sheared`."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 4, figsize=(16.0, 4.4), layout="constrained")
        velocity, fraction, temperature, fluxes = axes
        shown = results[:: -(-len(results) // MOST_CURVES)]
        for result in shown:
            label = _label(result.cell, results)
            velocity.plot(result.velocity / result.cell.distance, result.height, label=label)
            fraction.plot(result.solid_fraction, result.height)
        for number, (peclet, biot) in enumerate(shown[0].cell.pairs[:MOST_CURVES]):
            temperature.plot(shown[0].temperature[:, number], shown[0].height, label=f"Pe {peclet:g}, Bi {biot:g}")
        velocity.set(xlabel="velocity / (shear rate · H)", ylabel="height / bead diameter", xlim=(-0.55, 0.55))
        fraction.set(xlabel="solid fraction", xlim=(0.0, None))
        title = _label(shown[0].cell, results)
        temperature.set(xlabel="temperature / difference of the walls", xlim=(-0.55, 0.55))
        temperature.set_title(title, fontsize=10)
        temperature.legend(fontsize=8)
        if len(shown) > 1:
            velocity.legend(fontsize=8)
        _fluxes(fluxes, results)
        return save(figure, path)


def _fluxes(axes: Axes, results: list[Any]) -> None:
    """Conduction (full marks) and convection (open ones) over what varies."""
    key, name = _varied([result.cell for result in results])
    groups: dict[tuple[Any, ...], list[Any]] = {}
    for result in results:
        other = tuple(getattr(result.cell, k) for k in ("solid_fraction", "shear_rate", "friction") if k != key)
        groups.setdefault(other, []).append(result)
    colours = iter(plt.rcParams["axes.prop_cycle"].by_key()["color"] * 20)
    for members in groups.values():
        for number, (peclet, biot) in enumerate(results[0].cell.pairs):
            x = [getattr(member.cell, key) for member in members]
            colour, label = next(colours), f"Pe {peclet:g}, Bi {biot:g}"
            if len(groups) > 1:
                label += f", {_label(members[0].cell, results, without=key)}"
            for flux, fill in (("conduction", colour), ("convection", "none")):
                values = np.array([getattr(member, flux)[number] for member in members])
                positive = values[:, 0] > 0.0
                style = {"fmt": "o-", "color": colour, "markersize": 5, "markerfacecolor": fill, "linewidth": 1.0}
                name_of_case = label if fill == colour else None
                axes.errorbar(
                    np.array(x)[positive], values[positive, 0], values[positive, 1], label=name_of_case, **style
                )
    axes.set(xlabel=name, yscale="log", ylabel="flux / (λ ΔT/H)")
    if key != "solid_fraction":
        axes.set_xscale("log")
    axes.set_title("conduction ●, convection ○", fontsize=10)
    axes.legend(fontsize=7)


def _varied(cells: list[Any]) -> tuple[str, str]:
    """The key that varies, and its name."""
    for key, name in (
        ("solid_fraction", "solid fraction"),
        ("shear_rate", "dimensionless shear rate"),
        ("friction", "friction"),
    ):
        if len({getattr(cell, key) for cell in cells}) > 1:
            return key, name
    return "solid_fraction", "solid fraction"


def _label(cell: object, results: list[Any], without: str = "") -> str:
    """What tells this cell from the others."""
    cells, parts = [result.cell for result in results], []
    for key, symbol in (("solid_fraction", "solid fraction"), ("shear_rate", "γ*"), ("friction", "friction")):
        if key != without and (len({getattr(other, key) for other in cells}) > 1 or len(cells) == 1):
            parts.append(f"{symbol} {getattr(cell, key):g}")
    return ", ".join(parts)


def draw_motion(path: Path, result: Any) -> Path:
    """An animation (GIF) of the front layer of beads during the last block, coloured by temperature; gives the path."""
    cell = result.cell
    with plt.rc_context(STYLE | {"axes.grid": False}):
        figure, axes = plt.subplots(figsize=(4.0, 6.2), layout="constrained")
        axes.set(xlim=(-0.5 * cell.width, 0.5 * cell.width), ylim=(-0.6, cell.distance + 0.6), aspect="equal")
        axes.set(xlabel="x / bead diameter", ylabel="z / bead diameter")
        figure.canvas.draw()
        points = axes.transData.transform([(0.0, 0.0), (1.0, 0.0)])
        diameter = (points[1, 0] - points[0, 0]) * 72.0 / figure.dpi
        first = result.pictured[0]
        beads = axes.scatter(first[:, 0], first[:, 1], s=diameter**2, c=first[:, 2], cmap="coolwarm", vmin=-0.5, vmax=0.5,
                             edgecolors="k", linewidths=0.3)  # fmt: skip
        figure.colorbar(beads, ax=axes, label="temperature / difference of the walls", fraction=0.08)

        def show(frame: int) -> None:
            rows = result.pictured[frame]
            x = (rows[:, 0] + 0.5 * cell.width) % cell.width - 0.5 * cell.width
            beads.set_offsets(np.column_stack((x, rows[:, 1])))
            beads.set_array(rows[:, 2])

        movie = FuncAnimation(figure, show, frames=len(result.pictured))
        movie.save(path, PillowWriter(fps=FRAMES_A_SECOND), dpi=90)
        plt.close(figure)
    return path
