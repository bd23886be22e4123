"""A droplet of water on a hot bed of grains (Henry et al., section 4): temperatures, seeds, what the numerics and the model's
open choices are worth.

Writes docs/droplet.md and docs/droplet.png. Run: make droplet (about 40 minutes, two cores).
"""

import argparse
import json
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from porousmold.errors import SolveError
from porousmold.fluidised.droplet_cli import PAPER_BEADS, PAPER_GAS
from porousmold.fluidised.droplet_column import DropletColumn
from porousmold.fluidised.droplet_input import DropletInput
from porousmold.output.figures import STYLE, plt, save
from studies.page import Page

DOCS = Path(__file__).parent.parent / "docs"
TEMPERATURES, SEEDS, END_TIME = (200.0, 300.0, 350.0, 400.0, 500.0, 600.0), (1, 2, 3), 2.0
SIZES = {
    "width": 8e-3, "depth": 0.25e-3, "height": 30e-3, "bed_height": 9.5e-3, "bead_diameter": 0.25e-3,
    "droplet_diameter": 2.5e-3, "release_height": 1.5e-3, "grain_diameter": 55e-6,
}  # fmt: skip
VARIANTS: dict[str, dict[str, Any]] = {
    "cells of a diameter": {"cell_size": 1.0},
    "half the step": {"relative_step": 0.025},
    "parcels of 0.2 mm": {"bead_diameter": 0.2e-3, "depth": 0.2e-3, "cell_size": 1.875},
    "no bonds": {"bond": 0.0},
    "heat through the gas alone": {"conduction": "gas"},
    "hot grains kept out (film)": {"contact": "film"},
    "half of the volume solid": {"solid_fraction": 0.5},
    "drag of equation (12)": {"drag": "di-felice"},
    "twice the width": {"width": 16e-3},
}
VARIED_AT = (400.0, 600.0)
FALL = 0.15
"""s after which the droplet has come down onto the bed."""


def integrated(case: tuple[float, dict[str, Any]]) -> dict[str, Any]:
    """What a run at a temperature (°C) with settings gives."""
    celsius, settings = case
    given = {**SIZES, **PAPER_GAS, **PAPER_BEADS, "initial_temperature": celsius + 273.15, **settings}
    column = DropletColumn(DropletInput(**given))
    start, ended = time.process_time(), ""
    try:
        column.integrate(END_TIME)
    except SolveError as error:
        ended = str(error)
    rows = column.rows
    chimney = column.beads.places[:, 1] > column.surface + 2.0 * column.given.bead_diameter

    def over(name: str, low: float, high: float) -> Any:
        return np.array([row[name] for row in rows if low < row["time"] <= high])

    def late(name: str) -> Any:
        return over(name, END_TIME - 0.5, END_TIME)

    def at(moment: float) -> float:
        values = over("depth", moment - 0.1, moment)
        return float(values.mean()) / column.given.droplet_diameter if len(values) else float("nan")

    def rate(low: float, high: float) -> float:
        return float(over("weight", low, high).mean() / 9.80665 / over("evaporation", low, high).mean())

    heat = late("heat_by_gas").mean() + late("heat_by_beads").mean()
    warm = column.beads.temperature[chimney] - 273.15
    return {
        "celsius": celsius, "settings": settings, "ended": ended, "seconds": (time.process_time() - start) / column.time,
        "depth": [at(moment) for moment in (0.5, 1.0, 1.5, 2.0)],
        "early": rate(0.15, 0.25), "late": rate(END_TIME - 0.5, END_TIME),
        "bouncing": float(late("speed").std()), "by_beads": float(late("heat_by_beads").mean() / heat),
        "inside": float(late("beads_inside").mean()),
        "forces": float(((late("force_by_gas") + late("force_by_beads")) / late("weight")).mean()),
        "floor": float(((late("force_by_gas") + late("force_on_beads")).mean()) / late("force_on_floor").mean()),
        "highest": float((max(row["highest_bead"] for row in rows) - column.surface) / column.given.droplet_diameter),
        "chimney": float(warm.mean() / celsius) if chimney.sum() > 2 else float("nan"),
        "water": rows[-1]["water"], "imbalance": abs(rows[-1]["heat_imbalance"]),
        "times": [row["time"] for row in rows[::40]],
        "depths": [row["depth"] / column.given.droplet_diameter for row in rows[::40]],
    }  # fmt: skip


def main() -> None:
    """All runs on two cores, the page and its picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument(
        "--raw", type=Path, default=Path("runs/droplet-study.json"), help="file that keeps the outcomes"
    )
    parser.add_argument("--page-of", type=Path, help="run nothing: the page of such a file")
    options = parser.parse_args()
    cases = [(celsius, {"seed": seed}) for seed in SEEDS for celsius in TEMPERATURES]
    cases += [(celsius, settings) for settings in VARIANTS.values() for celsius in VARIED_AT]
    if options.page_of is None:
        outcomes = []
        with ProcessPoolExecutor(options.processes, mp_context=get_context("fork")) as pool:
            for outcome in pool.map(integrated, cases):
                outcomes.append(outcome)
                shown = {name: value for name, value in outcome.items() if name not in ("times", "depths")}
                print(shown, flush=True)
        options.raw.parent.mkdir(parents=True, exist_ok=True)
        options.raw.write_text(json.dumps(outcomes))
    else:
        outcomes = json.loads(options.page_of.read_text())
    draw(DOCS / "droplet.png", outcomes)
    write_page(DOCS / "droplet.md", outcomes)


def _fastest(outcome: dict[str, Any]) -> float:
    """Of half a second after the fall onto the bed, m/s."""
    times, depths = np.array(outcome["times"]), np.array(outcome["depths"]) * SIZES["droplet_diameter"]
    later = np.interp(times + 0.5, times, depths)
    counted = (times > FALL) & (times + 0.5 <= times[-1])
    return float(((later - depths)[counted] / 0.5).max(initial=0.0))


def _of_seeds(outcomes: list[dict[str, Any]], celsius: float) -> list[dict[str, Any]]:
    return [one for one in outcomes if one["celsius"] == celsius and set(one["settings"]) == {"seed"}]


def draw(path: Path, outcomes: list[dict[str, Any]]) -> None:
    """Depth against time of all seeds, and against temperature at 2 s."""
    with plt.rc_context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(11.0, 4.4), layout="constrained")
        for number, celsius in enumerate(TEMPERATURES):
            colour = plt.colormaps["inferno"](0.1 + 0.75 * number / (len(TEMPERATURES) - 1))
            for count, one in enumerate(_of_seeds(outcomes, celsius)):
                left.plot(
                    one["times"],
                    one["depths"],
                    color=colour,
                    linewidth=1.0,
                    label=f"{celsius:g} °C" if not count else None,
                )
                right.plot(celsius, one["depth"][3], "o", color=colour)
        left.invert_yaxis()
        left.set(xlabel="time in s", ylabel="depth of the centre in droplet diameters")
        left.legend(fontsize=9)
        right.invert_yaxis()
        right.set(xlabel="temperature of the bed in °C", ylabel=f"depth at {END_TIME:g} s in droplet diameters")
        save(figure, path)


def write_page(path: Path, outcomes: list[dict[str, Any]]) -> None:
    """docs/droplet.md."""

    def spread(celsius: float, name: str, index: int | None = None, form: str = ".2f") -> str:
        some = _of_seeds(outcomes, celsius)
        if name == "speed":
            values = np.array([_fastest(one) for one in some])
        else:
            values = np.array([one[name] if index is None else one[name][index] for one in some])
        values = values[np.isfinite(values)] * (1e3 if name in ("speed", "bouncing") else 1.0)
        if not len(values):
            return "none"
        error = values.std(ddof=1) / np.sqrt(len(values)) if len(values) > 1 else 0.0
        return f"{values.mean():{form}} ± {error:{form}}"

    def depths(celsius: float) -> Any:
        return np.array([one["depth"][3] for one in _of_seeds(outcomes, celsius)])

    page = Page(TEXT)
    rows: list[tuple[Any, ...]] = []
    for label, name, index, form in (
        ("depth at 0.5 s", "depth", 0, ".2f"),
        ("depth at 1 s", "depth", 1, ".2f"),
        ("depth at 1.5 s", "depth", 2, ".2f"),
        ("depth at 2 s", "depth", 3, ".2f"),
        ("fastest half second after the fall, mm/s", "speed", None, ".1f"),
        ("m/ṁ at 0.2 s, s", "early", None, ".0f"),
        ("m/ṁ in the last half second, s", "late", None, ".0f"),
        ("rms of the speed, last half second, mm/s", "bouncing", None, ".1f"),
        ("part of the heat that grains inside bring", "by_beads", None, ".2f"),
        ("parcels inside", "inside", None, ".0f"),
        ("highest grain above the surface, D", "highest", None, ".1f"),
        ("grains above the surface: T over T_0, in °C", "chimney", None, ".2f"),
        ("forces over the weight, last half second", "forces", None, ".3f"),
    ):
        rows.append((label, *(spread(celsius, name, index, form) for celsius in TEMPERATURES)))
    page.table(("", *(f"{celsius:g} °C" for celsius in TEMPERATURES)), rows)
    hot, hotter = depths(400.0), depths(600.0)
    error = np.sqrt(hot.var(ddof=1) / len(hot) + hotter.var(ddof=1) / len(hotter))
    page.add(
        f"Mean depth at 400 °C and 2 s less that at 600 °C: {hot.mean() - hotter.mean():+.2f} D, standard error {error:.2f} D "
        f"({len(hot)} seeds each).",
        "",
        "![depth of the droplet](droplet.png)",
        "",
        "## What numerics and open choices are worth",
        "",
    )
    rows = []
    named = {"seeds 1 to 3": None, **VARIANTS}
    for label, settings in named.items():
        row: list[Any] = [label]
        for celsius in VARIED_AT:
            if settings is None:
                some = _of_seeds(outcomes, celsius)
            else:
                some = [one for one in outcomes if one["celsius"] == celsius and one["settings"] == settings]
            mean = np.mean([[*one["depth"][1::2], one["late"]] for one in some], axis=0)
            row += [f"{mean[0]:.2f}", f"{mean[1]:.2f}", f"{mean[2]:.0f}"]
        rows.append(tuple(row))
    heads = [f"{text}, {celsius:g} °C" for celsius in VARIED_AT for text in ("1 s", "2 s", "m/ṁ in s")]
    page.table(("depth in D at", *heads), rows)
    seconds = np.median([one["seconds"] for one in outcomes if set(one["settings"]) == {"seed"}])
    floor = [one["floor"] for one in outcomes if "contact" not in one["settings"]]  # there vapour pushes grains besides
    page.add(
        f"CPU seconds of a simulated second: {seconds:.0f} (1 400 parcels, median). Largest imbalance of heat "
        f"{max(one['imbalance'] for one in outcomes):.0e}; the gas's forces on grains and droplet over the pressure on the "
        f"floor: {min(floor):.3f} to {max(floor):.3f}.",
    )
    page.add("", "## What the paper says", "")
    page.table(("Henry et al., section 4", "here", "agrees"), statements(spread))
    page.add(DECIDES)
    stopped = [f"{one['celsius']:g} °C, {one['settings']}: {one['ended']}" for one in outcomes if one["ended"]]
    if stopped:
        page.add("", "Ended early: " + "; ".join(stopped) + ".")
    page.write(path)


def statements(spread: Callable[..., str]) -> list[tuple[str, str, str]]:
    """The paper's words beside what came out."""

    def series(name: str, index: int | None = None, form: str = ".2f", of: tuple[float, ...] = TEMPERATURES) -> str:
        return "; ".join(f"{spread(celsius, name, index, form)} at {celsius:g} °C" for celsius in of)

    hot = TEMPERATURES[2:]
    return [
        (
            "no digging, no ejection below 350 °C",
            f"highest grain, in D: {series('highest', None, '.1f')}",
            "yes; it sinks there as its water runs through grains at rest (Ergun: 0.9 mm/s), without throwing any up",
        ),
        (
            "digs and throws grains up from 350 °C on",
            f"depth at 1 s, in D: {series('depth', 1)}",
            "yes, from between 350 and 400 °C on; on finer cells from between 400 and 600 °C on",
        ),
        (
            "deepest, and fastest, at 400 °C",
            f"fastest half second, mm/s: {series('speed', None, '.1f')}",
            "not shown: depths from 400 °C on are within their errors",
        ),
        (
            "bounces back to the surface at 500 and 600 °C",
            f"depth at 2 s, in D: {series('depth', 3, of=hot)}",
            "bounces grow, no return; on the surface where hot grains are kept out (film)",
        ),
        (
            "the same speed in the first second, whatever the temperature",
            f"depth at 0.5 s, in D: {series('depth', 0, of=hot)}",
            "within a factor of 2.5",
        ),
        ("forces of gas and grains carry the weight", f"over the weight: {series('forces', None, '.3f')}", "yes"),
        ("grains inside bring less than half of the heat", series("by_beads"), "yes"),
        ("m/ṁ some 10 s at first", f"s: {series('early', None, '.0f')}", "yes"),
        (
            "m/ṁ minutes when the droplet is full of grains",
            f"s: {series('late', None, '.0f')}",
            "it grows two- to threefold in 2 s up to 400 °C; 45 s with heat through the gas alone",
        ),
        (
            "grains thrown up have half of the bed's temperature",
            series("chimney", of=hot),
            "yes at 500 and 600 °C; few are thrown up at 400 °C",
        ),
    ]


DECIDES = """## What decides

- **Whether grains enter the droplet** decides between digging and floating. Where its vapour keeps grains hotter than 200 °C out
  (film), it stays on the bed at 400 and 600 °C, as the paper says of 500 and 600 °C; where they enter freely (mixture, the
  paper's words), it digs at 400 °C, as the paper says, and does not come back at 600 °C. Neither rule gives both.
- **The heat at the droplet's edge** decides how long it lives, and whether it saturates. With parcels that mixed the heat of
  their cells it lived 6 s throughout and never saturated; with conduction as it is, m/ṁ grows as the grains around it cool down.
- **The threshold of digging lies where the vapour lifts grains**, and moves with cells, drag and packing: at 400 °C cells of 0.2
  R, a wider bed and the drag of equation (12) dig half as deep, at 600 °C hardly anything changes.
- Bonds, parcels and steps change depths by 0.1 to 0.3 D, as much as seeds do.

**What a model in two dimensions cannot say**: vapour of a sphere spreads in three directions, so that its thrust and its lift
fall off faster; grains flow around a sphere, not over a cylinder; a chimney is a tube, not a slit; the wall's heat in depth is
left out. Depths and times of a droplet are therefore not predicted here. Runs of minutes, in which the paper sees saturation,
were not made.
"""


TEXT = """# A droplet that digs into a hot bed

Written by `make droplet`; do not edit. The last system of Henry, Coppin, Dorbolo, Legat and Lambrechts (a FEM-DEM model of hot
granular materials, section 4): a droplet of water on hot grains evaporates, its vapour lifts grains around it, and it may dig
itself in.

```sh
porousmold droplet --bed-temperature "400 °C" --time "0.2 s" --out runs/droplet --animate
```

`--droplet-diameter`, `--grain-diameter`, `--parcel-diameter`, `--bed-height`, `--beads`, `--bond`, `--conduction gas`,
`--contact film` and others: `porousmold droplet --help`. A run that was stopped goes on by the same command.

## What is computed

Gas in two dimensions by finite volumes, grains by the discrete element method as parcels of some 65 grains in a layer one parcel
deep (drag, film and drag of the water by the grain), the droplet as a circle that keeps its shape, of water and of the grains
that have entered it. Vapour leaves it evenly, made by the heat that bed and gas conduct to it and that grains bring which enter.
Grains in vapour stick together no more. Equations stand in the modules `fluidised/droplet*.py`. Constants are the paper's table
2 (grains of 55 um, 3200 kg/m3, gas and vapour as air at 20 °C); its solid fraction of 0.4 is that of the bed.

**It is a research model, not a prediction**: two dimensions, parcels, a circle, no capillarity (which at 18 Pa of the droplet's
own pressure neither lets hot grains in nor lets cold ones go), no radiation, no wetting. Depths scatter from seed to seed, and
move with the numerics, as the tables below say. The bed is smaller than the paper's (8 x 9.5 mm for 10 x 22.5 mm) and cools as a
whole.

## Checks (`tests/fluidised/test_droplet.py`, `tests/laws/test_evaporation.py`)

| check | found |
|---|---|
| conduction to the circle from a ring of 4 R, anywhere on the grid | within 3, 2, 1 % at cells of 0.3, 0.2, 0.1 R |
| heat from a bed at rest in 0.2 s, against radial conduction | -6, +1, +4 % at cells of 0.3, 0.2, 0.12 R |
| the same from 0.1 to 0.2 s | +14, +12, +7 % |
| thrust of vapour in a fixed bed under a free surface, against images | within 6, 3, 2 % at cells of 0.3, 0.2, 0.12 R |
| grain in the water | exp(-t/0.344 ms) to 1e-6 |
| d2 law, film below a droplet (closed forms, against their equations) | 1e-6 |
| momentum between water and grains inside | 1e-12 |
| mass, heat | 1e-10 |
| pressure on the floor against the gas's forces on grains and droplet | within 5 % |
| forces on a droplet that rests | its weight within 2 % |

The second row is the one that changes results most. Parcels that exchange heat with the nodes around them by the film of their
grains (10 ms) take on the mean of their cell, and so conduct by themselves: h^2/3 in 10 ms, eight times what a bed of 0.23 W/m/K
does on cells of 0.375 mm. A droplet then got 2.5 times its heat. Changes of the nodes' means are passed on to the parcels instead
(`fluidised/parcel_heat.py`).

## Temperatures

Means of three seeds and their standard error; depth is that of the centre below the surface at rest, in droplet diameters D,
over the 0.1 s before.
"""

if __name__ == "__main__":
    main()
