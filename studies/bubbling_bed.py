"""The bubbling bed of Henry et al. (table 1): 80 000 glass beads, a floor that is blocked in the middle.

Writes docs/bubbling-bed.png and prints what is compared with the paper's words. Run: make bubbling-bed (15 minutes, two cores).
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from porousmold.fluidised.column import Column
from porousmold.fluidised.column_input import ColumnInput
from porousmold.output.figures import STYLE, plt, save

DOCS = Path(__file__).parent.parent / "docs"
VELOCITIES, END_TIME = (1.2, 1.71), 0.3
GIVEN = {
    "width": 0.08, "depth": 0.015, "height": 0.25, "bed_height": 0.0415, "bead_diameter": 0.9e-3, "blocked_width": 0.012,
    "density": 1.204, "viscosity": 2e-5, "heat_capacity": 1010.0, "conductivity": 0.025,
    "bead_density": 2500.0, "bead_heat_capacity": 840.0,
    "initial_temperature": 363.15, "inlet_temperature": 290.0, "cell_size": 4.0,
}  # fmt: skip
"""Of the paper, but for the bead diameter (0.8 to 1 mm there) and the initial temperature, which it does not print."""


def integrated(velocity):
    """Places and temperatures of the beads at the end, their velocity upwards, and what was recorded."""
    column = Column(ColumnInput(velocity=velocity, **GIVEN))
    column.integrate(END_TIME)
    return column.beads.places, column.beads.temperature, column.beads.velocity[0], column.rows


def main():
    """Both velocities, one on each core."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=DOCS / "bubbling-bed.png")
    out = parser.parse_args().out
    with ProcessPoolExecutor(2, mp_context=get_context("fork")) as pool:
        runs = dict(zip(VELOCITIES, pool.map(integrated, VELOCITIES), strict=True))
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, len(runs), figsize=(8.0, 6.4), layout="constrained", sharey=True)
        for panel, (velocity, (places, warm, _, _)) in zip(axes, runs.items(), strict=True):
            style = {"cmap": "plasma", "vmin": 75.0, "vmax": 90.0, "linewidths": 0.0}
            drawn = panel.scatter(*(1e3 * places.T), s=0.4, c=warm - 273.15, **style)
            panel.grid(visible=False)
            panel.set(aspect="equal", title=f"{velocity:g} m/s, {END_TIME:g} s", xlabel="across in mm")
            panel.set(xlim=(-500.0 * GIVEN["width"], 500.0 * GIVEN["width"]), ylim=(0.0, 1e3 * GIVEN["height"]))
        axes[0].set_ylabel("height in mm")
        figure.colorbar(drawn, ax=axes, label="bead temperature in °C", fraction=0.03)
        save(figure, out)
    for velocity, (places, warm, upwards, rows) in runs.items():
        late = rows[len(rows) // 3 :]
        cooling = (late[0]["bead_temperature"] - late[-1]["bead_temperature"]) / (late[-1]["time"] - late[0]["time"])
        at_wall, low, above = np.abs(places[:, 0]) > 0.032, places[:, 1] < 0.01, places[:, 1] > 0.03
        walls, between = upwards[at_wall].mean(), upwards[~at_wall].mean()
        print(
            f"{velocity:g} m/s: {len(warm)} beads, cooling {cooling:.2f} K/s, heat imbalance {rows[-1]['heat_imbalance']:.0e}"
        )
        print(f"  below 10 mm {warm[low].mean() - 273.15:.2f} °C, above {warm[~low].mean() - 273.15:.2f} °C")
        print(f"  beads per mm of width above 30 mm: {(at_wall & above).sum() / 16.0:.0f} at the walls, "
              f"{(~at_wall & above).sum() / 64.0:.0f} between")  # fmt: skip
        print(f"  velocity upwards {walls:.2f} m/s at the walls, {between:.2f} m/s between")


if __name__ == "__main__":
    main()
