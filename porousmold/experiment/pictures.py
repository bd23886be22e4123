"""The picture of a comparison, like figures 6.7 and 7.8 of the thesis."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..output.figures import STYLE, plt, save
from .comparison import SENSOR_ERROR, Deviation

MOST_MARKERS = 40
"""Measured points of a sensor that are drawn one by one."""


def draw_comparison(path: Path, deviations: Sequence[Deviation]) -> Path:
    """Measured points and the whole run as lines, by sensor, both with their errors as bands; below, how far they are apart.
    Gives the path."""
    with plt.rc_context(STYLE):
        figure, (axes, residuals) = plt.subplots(2, 1, figsize=(10.5, 7.0), sharex=True, height_ratios=(2.2, 1.0))
        figure.subplots_adjust(left=0.07, right=0.74, bottom=0.08, top=0.97, hspace=0.08)
        for number, each in enumerate(deviations):
            colour, minutes = f"C{number % 10}", each.time / 60.0
            marker = "osD^v<>pXP"[number // 10 % 10]
            few = max(len(minutes) // MOST_MARKERS, 1)
            times, values = each.whole
            axes.plot(times / 60.0, values - 273.15, "-", color=colour, linewidth=1.4,
                      label=f"{each.name}: {each.average:.2f} K apart")  # fmt: skip
            measured_error = np.full_like(each.measured, SENSOR_ERROR)
            for middle, error, alpha in (
                (each.simulated, each.uncertainty, 0.35),
                (each.measured, measured_error, 0.15),
            ):
                axes.fill_between(minutes, middle - error - 273.15, middle + error - 273.15, color=colour, alpha=alpha,
                                  linewidth=0.0)  # fmt: skip
            points = {"color": colour, "markersize": 4.5, "markerfacecolor": "white", "markevery": few}
            axes.plot(minutes, each.measured - 273.15, marker, **points)
            residuals.plot(minutes, each.simulated - each.measured, f"{marker}-", linewidth=0.8, **points)
        axes.set(ylabel="temperature, °C")
        residuals.axhspan(-SENSOR_ERROR, SENSOR_ERROR, color="0.9", zorder=0)
        residuals.axhline(0.0, color="0.5", linewidth=0.8)
        residuals.set(xlabel="time, min", ylabel="run - measured, K")
        axes.legend(
            fontsize=8,
            title=f"points: measured ± {SENSOR_ERROR:g} K\nlines: run ± its uncertainty",
            loc="upper left",
            bbox_to_anchor=(1.01, 1.0),
            title_fontsize=8,
        )
        return save(figure, path)
