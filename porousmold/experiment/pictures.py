"""The picture of a comparison, like figures 6.7 and 7.8 of the thesis."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..output.figures import STYLE, plt, save
from .comparison import SENSOR_ERROR


def draw_comparison(path: Path, deviations: Sequence[Any]) -> Path:
    """Measured points and the run as lines, by sensor, both with their errors as bands. Gives the path."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(10.5, 5.2))
        figure.subplots_adjust(left=0.07, right=0.74, bottom=0.11, top=0.97)
        for number, each in enumerate(deviations):
            colour, minutes, celsius = f"C{number % 10}", each.time / 60.0, each.measured - 273.15
            axes.fill_between(
                minutes, celsius - SENSOR_ERROR, celsius + SENSOR_ERROR, color=colour, alpha=0.15, linewidth=0.0
            )
            axes.plot(minutes, celsius, ".", color=colour, markersize=3)
            label = f"{each.name}: {each.average:.2f} K apart"
            simulated = each.simulated - 273.15
            axes.fill_between(
                minutes,
                simulated - each.uncertainty,
                simulated + each.uncertainty,
                color=colour,
                alpha=0.35,
                linewidth=0.0,
            )
            axes.plot(minutes, simulated, "-", color=colour, linewidth=1.2, label=label)
        axes.set(xlabel="time, min", ylabel="temperature, °C")
        axes.legend(
            fontsize=8,
            title=f"points: measured ± {SENSOR_ERROR:g} K\nlines: run ± its uncertainty",
            loc="upper left",
            bbox_to_anchor=(1.01, 1.0),
            title_fontsize=8,
        )
        return save(figure, path)
