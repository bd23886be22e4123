"""Patil's bubbling bed as Henry et al. compute it (section 3, table 1): one layer of beads of 0.8 to 1 mm, 5 kg per metre of
depth (75 g in 15 mm), heat lost to walls of 290 K, three velocities; means over 5 to 10 s.

Writes docs/patil-bed.png and docs/patil-bed.md. Run: make patil-bed (100 minutes of one core).
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from itertools import pairwise
from multiprocessing import get_context
from pathlib import Path
from time import process_time

import numpy as np

from porousmold.fluidised.column import Column
from porousmold.fluidised.column_input import ColumnInput
from porousmold.output.figures import STYLE, plt, save

DOCS = Path(__file__).parent.parent / "docs"
VELOCITIES, END_TIME = (1.2, 1.54, 1.71), 10.0
NOZZLE, WALL = 0.006, 0.008
"""Half of the closed nozzle, and what counts as beside a wall, m."""
GIVEN = {
    "width": 0.08, "depth": 0.9e-3, "height": 0.35, "bed_height": 0.0427, "bead_diameter": 1e-3, "smallest_diameter": 0.8e-3,
    "blocked_width": 2.0 * NOZZLE, "density": 1.204, "viscosity": 2e-5, "heat_capacity": 1010.0, "conductivity": 0.025,
    "bead_density": 2500.0, "bead_heat_capacity": 840.0, "initial_temperature": 363.15, "inlet_temperature": 290.0,
    "wall_temperature": 290.0, "wall_coefficient": 350.0, "depth_coefficient": 4e4, "depth_drag": 1.067,
    "cell_size": 4.0, "drag": "di-felice", "nusselt": "henry",
}  # fmt: skip
"""Of the paper, but for the initial temperature, which it does not print, and the height, which is 0.25 m there."""


def integrated(case):
    """A case (velocity in m/s, end in s): the column's summary, its means over the second half, and temperatures against time."""
    velocity, end, settings = case
    column = Column(ColumnInput(velocity=velocity, **GIVEN | settings))
    start, grid = process_time(), column.grid
    share, moved, heat = (np.zeros(grid.volumes.shape) for _ in range(3))
    while column.time < end:
        column.step()
        if column.time >= 0.5 * end:
            weights, volumes = grid.weights(column.beads.places), column.beads.volumes
            share += grid.spread(weights, volumes)
            moved += grid.spread(weights, volumes * column.beads.velocity[0])
            heat += grid.spread(weights, volumes * column.beads.temperature)
    late = column.rows[len(column.rows) // 2 :]
    mass = column.beads.masses.sum() / column.given.depth
    found = {
        "velocity": velocity,
        "beads": len(column.beads),
        "mass": mass,
        "weight": column.weight,
        "pressure_drop": float(np.mean([row["pressure_drop"] for row in late])),
        "bed_height": float(np.mean([row["bed_height"] for row in late])),
        "heat_imbalance": column.rows[-1]["heat_imbalance"],
        "to_walls": column.rows[-1]["heat_to_walls"] / (mass * column.given.depth * 840.0),
        "share": share / grid.volumes / len(late),
        "upwards": np.divide(moved, share, out=np.full_like(share, np.nan), where=share > 0.0),
        "temperature": np.divide(heat, share, out=np.full_like(share, np.nan), where=share > 0.0),
        "flux": moved / grid.volumes / len(late),
        "seconds": process_time() - start,
        "history": [(row["time"], row["bead_temperature"]) for row in column.rows[:: max(1, len(column.rows) // 400)]],
        "half_bed": column.rows[0]["bed_height"],
    }
    column.free()
    return found


def over(found, name, heights, columns):
    """Mean of a field over heights (m) and columns of the grid, each node by the beads that it has."""
    rows = slice(*(round(height / GIVEN["height"] * (found["share"].shape[0] - 1)) for height in heights))
    values, shares = found[name][rows][:, columns], found["share"][rows][:, columns]
    if name == "share":
        return float(values.mean())
    return float(np.nansum(values * shares) / shares.sum())


def regions(found):
    """Columns of the grid beside the walls, between, over the nozzle and over the open floor beside it."""
    across = np.abs(np.linspace(-0.5, 0.5, found["share"].shape[1]) * GIVEN["width"])
    walls, nozzle = across > 0.5 * GIVEN["width"] - WALL, across <= NOZZLE
    return walls, ~walls, nozzle, ~nozzle & ~walls


def draw(path, runs):
    """Shares and velocities, and the cooling."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(
            2, len(runs) + 1, figsize=(11.0, 7.0), layout="constrained", width_ratios=(1,) * len(runs) + (1.6,)
        )
        extent = (-500.0 * GIVEN["width"], 500.0 * GIVEN["width"], 0.0, 1e3 * GIVEN["height"])
        for number, found in enumerate(runs):
            style = {"origin": "lower", "extent": extent, "aspect": "equal"}
            solid = axes[0, number].imshow(found["share"], cmap="viridis", vmin=0.0, vmax=0.6, **style)
            speed = axes[1, number].imshow(found["upwards"], cmap="RdBu_r", vmin=-0.4, vmax=0.4, **style)
            axes[0, number].set(title=f"{found['velocity']:g} m/s")
            axes[1, number].set(xlabel="across in mm")
            for row in (0, 1):
                axes[row, number].set(ylim=(0.0, 150.0))
                axes[row, number].grid(visible=False)
        axes[0, 0].set_ylabel("height in mm")
        axes[1, 0].set_ylabel("height in mm")
        figure.colorbar(solid, ax=axes[0, : len(runs)], label="solid fraction, mean", fraction=0.04)
        figure.colorbar(speed, ax=axes[1, : len(runs)], label="beads upwards in m/s, mean", fraction=0.04)
        cooling, profile = axes[0, -1], axes[1, -1]
        for found in runs:
            time, warm = np.array(found["history"]).T
            cooling.plot(time, warm - 273.15, label=f"{found['velocity']:g} m/s")
            rows = slice(1, round(0.05 / GIVEN["height"] * (found["share"].shape[0] - 1)))
            across = np.linspace(-0.5, 0.5, found["share"].shape[1]) * 1e3 * GIVEN["width"]
            profile.plot(across, found["share"][rows].mean(axis=0), label=f"{found['velocity']:g} m/s")
        cooling.set(xlabel="time in s", ylabel="mean bead temperature in °C")
        profile.set(xlabel="across in mm", ylabel="solid fraction, mean below 50 mm", ylim=(0.0, None))
        cooling.legend(fontsize=9)
        profile.legend(fontsize=9)
        save(figure, path)


def statements(runs):
    """Rows: what the paper says, what is found, whether they agree: at each velocity, or once for all."""
    at = [regions(found) for found in runs]
    bed = (0.01, 0.08)
    dragged = [
        [over(f, "upwards", (0.004, 0.02), columns) for columns in where[2:]] for f, where in zip(runs, at, strict=True)
    ]
    walls = [[over(f, "upwards", bed, columns) for columns in where[:2]] for f, where in zip(runs, at, strict=True)]
    shares = [[over(f, "share", bed, columns) for columns in where[:2]] for f, where in zip(runs, at, strict=True)]
    everywhere = slice(None)
    warm = [[over(f, "temperature", h, everywhere) for h in ((0.0, 0.01), (0.03, 0.1))] for f in runs]
    ends = [f["history"][-1][1] - 273.15 for f in runs]
    mirrored = [float(np.nansum(f["flux"] * f["flux"][:, ::-1]) / np.nansum(f["flux"] ** 2)) for f in runs]

    def pairs(values, number="{:.2f}"):
        return "; ".join(f"{number.format(a)} and {number.format(b)}" for a, b in values)

    yield (
        "a central aisle over the closed nozzle, along which beads are not dragged",
        f"upwards over the nozzle and over the open floor, 4 to 20 mm high: {pairs(dragged)} m/s",
        [nozzle < beside for nozzle, beside in dragged],
    )
    yield (
        "beads rise in the middle and fall at the wall",
        f"upwards within 8 mm of the walls and between: {pairs(walls)} m/s",
        [wall < 0.0 < between for wall, between in walls],
    )
    yield (
        "two symmetrical vortices",
        "correlation of the mean flow of beads with its mirror image: "
        + ", ".join(f"{value:.2f}" for value in mirrored),
        [value > 0.5 for value in mirrored],
    )
    yield (
        "a higher solid fraction at the edges",
        f"within 8 mm of the walls and between, 10 to 80 mm high: {pairs(shares)}",
        [wall > between for wall, between in shares],
    )
    yield (
        "cooled beads accumulate at the bottom",
        f"below 10 mm and above 30 mm, mean from 5 s on: {pairs([(a - 273.15, b - 273.15) for a, b in warm])} °C",
        [low < high for low, high in warm],
    )
    yield (
        "a higher velocity cools faster",
        "mean bead temperature at the end: " + ", ".join(f"{value:.1f}" for value in ends) + " °C",
        [all(slow > fast for slow, fast in pairwise(ends))],
    )


def _verdict(agrees):
    if all(agrees) or not any(agrees):
        return "yes" if all(agrees) else "no"
    return (
        "at " + ", ".join(f"{velocity:g}" for velocity, does in zip(VELOCITIES, agrees, strict=True) if does) + " m/s"
    )


def page(runs, end):
    """The page's text."""
    table = "\n".join(
        f"| {f['velocity']:g} | {f['pressure_drop'] / f['weight']:.3f} | {1e3 * f['half_bed']:.1f} | "
        f"{1e3 * f['bed_height']:.1f} | {f['history'][-1][1] - 273.15:.1f} | {f['to_walls']:.1f} K | "
        f"{abs(f['heat_imbalance']):.0e} |"
        for f in runs
    )
    words = "\n".join(f"| {said} | {found} | {_verdict(agrees)} |" for said, found, agrees in statements(runs))
    first, velocities = runs[0], ", ".join(f"{f['velocity']:g}" for f in runs)
    return f"""# Patil's bubbling bed

Written by `make patil-bed`; do not edit. A bubbling bed that Patil measured and Henry et al. compute (their section 3, table 1):
{first["beads"]} glass beads of 0.8 to 1 mm in one layer, {first["mass"]:.2f} kg per metre of depth (75 g in 15 mm), 80 mm wide,
air of 290 K through a floor that is closed in its middle 12 mm, drag and film by their equations (12) and (13), from 90 °C (the
paper does not print the initial temperature). Heat goes to walls of 290 K: 350 W/m2/K at the sides, 4e4 W/m3/K in front and rear,
which the paper fitted to the measurement at 1.54 m/s; a drag of 1.067 kg/m3/s there (eq. 14). {end:g} s of simulated time, means
over the second half, {sum(f["seconds"] for f in runs) / 60.0:.0f} minutes of one core.

| velocity, m/s | pressure drop over weight | at rest, mm | height, mm | beads at the end, °C | to walls | imbalance |
|---|---|---|---|---|---|---|
{table}

| the paper says | found at {velocities} m/s | agrees |
|---|---|---|
{words}

![the bed](patil-bed.png)

The paper's curves of temperature stand in a figure without numbers, so none is compared here. Beads of one layer cannot pass each
other in depth, and their bed at rest is looser (porosity near 0.45) than one of many layers. What walls take is given as the
cooling of the beads that it is worth.
"""


def main():
    """All velocities, as many at once as there are cores."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=DOCS / "patil-bed.md")
    parser.add_argument("--seconds", type=float, default=END_TIME, help="of simulated time (default 10)")
    parser.add_argument("--coarse", action="store_true", help="a narrow bed of few beads: to try the study")
    options = parser.parse_args()
    settings = {"bed_height": 0.02} if options.coarse else {}
    with ProcessPoolExecutor(2, mp_context=get_context("fork")) as pool:
        runs = list(pool.map(integrated, [(velocity, options.seconds, settings) for velocity in VELOCITIES]))
    draw(options.out.with_suffix(".png"), runs)
    options.out.write_text(page(runs, options.seconds), encoding="utf-8")
    print(f"{sum(found['seconds'] for found in runs):.0f} CPU seconds; written to {options.out}")


if __name__ == "__main__":
    main()
