"""Two measured heatings with flow through the bed, beside the program (docs/measured-stores.md).
Run: make measured-stores (a minute).

Each runs from its measured profile at the start, as its scene says, and with one assumption changed at a time. Deviations are
those at every measured point but those of the start. Nothing is tuned.
"""

import csv
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from porousmold import Scene, run
from porousmold.output.figures import STYLE, plt, save
from porousmold.output.stored import read_table
from studies.page import Page

HERE = Path(__file__).parent / "stores"
PAGE = Path(__file__).parent.parent / "docs" / "measured-stores.md"
Profiles = dict[float, tuple[NDArray[np.float64], NDArray[np.float64]]]
"""{time in s: (distances from the inlet in m, temperatures in degC)}."""

STONES = {
    "as assumed": {},
    "heat capacity 1200 J/kg/K throughout": {"materials.stone.heat_capacity": 1200.0},
    "heat capacity 1050 J/kg/K throughout": {"materials.stone.heat_capacity": 1050.0},
    "no radiation (emissivity 0)": {"bed.emissivity": 0.0},
    "no axial dispersion": {"model.dispersion": "winterberg-tsotsas"},
    "closures of the thesis": {"model.closures": "thesis", "model.dispersion": None, "bed.emissivity": None},
    "bead_modes = 4": {"model.bead_modes": 4},
    "exchange x 0.5": {"model.exchange_factor": 0.5},
    "exchange x 2": {"model.exchange_factor": 2.0},
    "conduction x 2": {"model.conduction_factor": 2.0},
    "flow - 5 %": {"operation.mass_flow": 0.95 * 0.01389},
    "flow + 5 %": {"operation.mass_flow": 1.05 * 0.01389},
    "inlet 700 degC": {"operation.inlet_temperature": "700 degC"},
    "air of the thesis": {"fluid.material": "thesis_air"},
    "full flow, 4 mm steel wall, adiabatic": {
        "model.flow": "full", "model.wall": "conjugate", "wall.material": "stainless_steel", "wall.thickness": "4 mm",
        "bed.porosity_model": None,
    },
    "twice the cells and steps": {"solver.mesh_refinement": 2.0, "solver.step_refinement": 2.0},
}  # fmt: skip
SALT = {
    "as assumed (Hoffmann's values)": {},
    "Niedermeier's values": {
        "operation.mass_flow": "7 kg/s", "bed.bead_density": "2640 kg/m^3", "bed.bead_heat_capacity": "1050 J/(kg K)",
        "operation.inlet_temperature": "290 degC", "bed.bead_diameter": "15 mm",
    },
    "measured closures": {"model.closures": "measured"},
    "measured closures, no axial dispersion": {"model.closures": "measured", "model.dispersion": "winterberg-tsotsas"},
    "bead_modes = 4": {"model.bead_modes": 4},
    "flow + 5 %": {"operation.mass_flow": 1.05 * 5.46},
    "twice the cells and steps": {"solver.mesh_refinement": 2.0, "solver.step_refinement": 2.0},
}  # fmt: skip


OPENING = """# Two measured heatings with flow

Written by `make measured-stores`; do not edit.

The only heatings with flow through the bed that we hold as numbers (`studies/stores/`, with where they come from and what is
missing). Both start from a measured profile (`operation.initial_temperature = "start.csv"`). **Nothing is tuned**: what is
not given is assumed, and each assumption is changed by itself. Deviations are those at the thermocouples, of the fluid.

## Stones heated from 25 to 682 °C by air

Range 657 K, twelve points at 1 and 2 h. Assumed: heat capacity of the stones from 900 J/kg/K (25 °C) to 1200 (700 °C),
linear, whose ends are the two values that the source gives; inlet 682 °C as the uppermost thermocouple reads; no loss, no
wall; emissivity 0.9. With 1200 J/kg/K throughout the measured heat would exceed what the air brought.

![Stones heated by air](measured-stores/alonso.png)"""
BETWEEN = """
The speed of the front tests the heat balance, its width the closures: it needs axial dispersion, radiation and a heat
capacity that rises. The trial that led to the linear heat capacity was made after seeing the deviations; its ends were not.

## Quartzite and sand, cooled from 395 to 289 °C by molten salt

Range 106 K, points from 0.3 to 5.9 m at 0.5, 1, 1.5 and 2 h. No loss, no wall, constant properties; beads of one size.

![Quartzite cooled by salt](measured-stores/pacheco.png)"""
ENDING = """
The measured front is a metre wide at the start against a few bead diameters of the closures: this set tests the heat balance
and nothing about closures. Its front moves 1.76, 2.03, 2.31 and 1.95 m/h in the four half hours, so that the flow was not
steady, or reading it off is worth 10 %.

## What was looked for

Other measured heatings with flow, as numbers, in an index of public repositories (November 2026). No numbers were found of
Haenchen et al., Meier et al., Zanganeh et al., Cascetta et al., Allen et al. and Gurnon, whose curves are cited often, nor a
radial profile or a wall's heat flux with flow. Found, and not used:

- Anderson et al. (2014), alumina of 6 mm heated by air, one profile (SolarTherm, commit ac89885ae11b): the flow that is given
  could heat 9 % of the bed only, and the front is four times as broad as Schumann's.
- Grabo et al. (2021), water through elements filled with what melts, temperatures at the outlet over 10 h (OpenTerrace, commit
  af9a48992e5c, read off a picture): the elements are no spheres, and their film and enthalpy are not given beside the curve."""


def measured(name: str, inlet_at: float | None = None) -> Profiles:
    """The measured profiles of a folder: heights count from the inlet, or down from the inlet at a height (m)."""
    with (HERE / name / "profiles.csv").open() as file:
        rows = [[float(cell) for cell in row] for row in list(csv.reader(file))[1:]]
    found: Profiles = {}
    for time in dict.fromkeys(row[0] for row in rows):
        part = np.array(sorted((z if inlet_at is None else inlet_at - z, warm) for at, z, warm in rows if at == time))
        found[3600.0 * time] = part[:, 0], part[:, 1]
    return found


def computed(name: str, times: list[float], changes: dict[str, Any] | None = None) -> Profiles:
    """The profiles of the scene of a folder at times (s), with some keys changed."""
    settings = {"output.times": times, "output.pictures": False, "output.fields": False} | (changes or {})
    tables = Scene.load(HERE / name / "scene.toml").changed(
        {k: v for k, v in settings.items() if not k.startswith("materials")}
    )
    own = {key.removeprefix("materials.stone."): v for key, v in settings.items() if key.startswith("materials")}
    if own:
        given = tables._given["materials"]
        tables = Scene({**tables._given, "materials": {"stone": {**given["stone"], **own}}}, tables.source)
    with tempfile.TemporaryDirectory() as folder:
        run(tables, folder, MPI.COMM_SELF)
        profiles = read_table(Path(folder) / "profiles.csv")
    along = np.array(profiles["distance_from_inlet"])
    return {time: (along, np.array(profiles[f"fluid_{time:.6g} s"]) - 273.15) for time in times}


def deviations(found: Profiles, data: Profiles, inside: tuple[float, float]) -> NDArray[np.float64]:
    """Computed minus measured (K) at every measured place inside, of all times that were computed."""
    parts = []
    for time, (along, warm) in found.items():
        places, values = data[time]
        kept = (places > inside[0]) & (places < inside[1])
        parts.append(np.interp(places[kept], along, warm) - values[kept])
    return np.concatenate(parts)


def report(
    name: str, data: Profiles, variants: dict[str, dict[str, Any]], inside: tuple[float, float]
) -> list[list[str]]:
    """Rows: variant, rms, that over the range of temperatures, bias."""
    times = [time for time in data if time > 0.0]
    span = max(warm.max() for _, warm in data.values()) - min(warm.min() for _, warm in data.values())
    rows = []
    for words, changes in variants.items():
        off = deviations(computed(name, times, changes), data, inside)
        rms = float(np.sqrt(np.mean(off**2)))
        rows.append([words, f"{rms:.1f} K", f"{rms / span:.1%}", f"{np.mean(off):+.1f} K"])
        print(*rows[-1], sep=", ", flush=True)
    return rows


def draw(name: str, data: Profiles, title: str) -> None:
    """Measured points and computed curves of all times."""
    found = computed(name, [time for time in data if time > 0.0])
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(8.0, 4.4))
        figure.subplots_adjust(left=0.1, right=0.97, bottom=0.13, top=0.92)
        for number, (time, (places, warm)) in enumerate(data.items()):
            label = f"{time / 3600.0:g} h" + (", start of both" if time == 0.0 else "")
            axes.plot(places, warm, "o", color=f"C{number}", markersize=4.5, label=label)
            if time in found:
                axes.plot(*found[time], color=f"C{number}")
        axes.set(xlabel="distance from the inlet in m", ylabel="temperature in °C", title=title, xlim=(0, None))
        axes.legend(fontsize=9, title="points measured,\nlines computed")
        save(figure, PAGE.parent / "measured-stores" / f"{name}.png")


def main() -> None:
    """Run everything and write the page."""
    (PAGE.parent / "measured-stores").mkdir(exist_ok=True)
    stones, salt = measured("alonso", 0.48), measured("pacheco")
    draw("alonso", stones, "Stones heated by air (Alonso & Rojas 2022)")
    draw("pacheco", salt, "Quartzite cooled by molten salt (Pacheco et al. 2002)")
    head = ["assumption changed", "rms", "of the range", "computed - measured, mean"]
    page = Page(*OPENING.splitlines())
    page.table(head, report("alonso", stones, STONES, (-1.0, 1.0)))
    page.add(*BETWEEN.splitlines())
    page.table(head, report("pacheco", salt, SALT, (0.3, 5.9)))
    page.add(*ENDING.splitlines())
    page.write(PAGE)


if __name__ == "__main__":
    main()
