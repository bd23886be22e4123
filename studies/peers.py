"""Another program beside this one on a scene whose solution is known: error against CPU seconds. Writes docs/peers.md and .png.

Run: make peers (10 minutes). OpenTerrace 0.1.4 (PyPI) wants Python 3.11.8 to 3.12 and an environment of its own.
"""

import argparse
import json
import statistics
import subprocess
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mpi4py import MPI

from porousmold import Scene, run
from porousmold.laws.nusselt import NUSSELT_CORRELATIONS, prandtl_number, specific_surface
from porousmold.output.figures import STYLE, plt, save
from porousmold.simulation.specs import specs_of
from studies.exact_solutions import schumann
from studies.page import Page

HERE, DOCS = Path(__file__).parent, Path(__file__).parent.parent / "docs"
SCENE = HERE / "stores" / "schumann.toml"
CELLS = (13, 25, 50, 100)
"""Of OpenTerrace along the bed."""
SETTINGS = (
    {"solver.mesh_refinement": 0.25},
    {"solver.mesh_refinement": 0.5},
    {},
    {"solver.mesh_refinement": 2.0},
    {"solver.mesh_refinement": 2.0, "solver.step_tolerance": 0.1},
    {"solver.mesh_refinement": 4.0, "solver.step_tolerance": 0.03},
)
"""Of this program; none are its defaults."""
REPEATS = 5
"""Runs of this program whose median seconds count: they are short."""


class Front(NamedTuple):
    """What a program computed, in CPU seconds with all code compiled: fluid temperatures (K) at the outlet and in the middle."""

    program: str
    words: str
    seconds: float
    steps: int
    time: np.ndarray
    outlet: np.ndarray
    middle: np.ndarray

    def errors(self, store: dict[str, Any]) -> tuple[float, float]:
        """Largest difference (K) from Schumann's front at the outlet and in the middle."""
        length = store["length"]
        return tuple(
            float(np.abs(found - exact(store, place, self.time)).max())
            for place, found in ((length, self.outlet), (0.5 * length, self.middle))
        )


def store_of(scene: Scene) -> dict[str, Any]:
    """The store as numbers, for programs that know no closures."""
    specs, bed, operation = specs_of(scene), scene.bed, scene.operation
    fluid, beads, temperature = specs.laws.fluid, specs.laws.beads, operation.initial_temperature
    density = float(fluid.density(specs.flow.outlet_pressure, temperature))
    capacity, viscosity, conductivity = (
        float(law(temperature)) for law in (fluid.heat_capacity, fluid.viscosity, fluid.conductivity)
    )
    mass_flow, diameter = operation.mass_flow.values[0], scene.geometry.diameter
    reynolds_number = mass_flow / (0.25 * np.pi * diameter**2) * bed.bead_diameter / viscosity
    prandtl = prandtl_number(viscosity, capacity, conductivity)
    nusselt_number = NUSSELT_CORRELATIONS["wakao"](reynolds_number, prandtl, bed.bulk_porosity)
    return {
        "length": scene.geometry.length,
        "diameter": diameter,
        "bead_diameter": bed.bead_diameter,
        "porosity": bed.bulk_porosity,
        "fluid": {"rho": density, "cp": capacity, "k": conductivity},
        "beads": {"rho": float(beads.density(temperature)), "cp": float(beads.heat_capacity(temperature)), "k": 1.0},
        "coefficient": float(nusselt_number) * conductivity / bed.bead_diameter,
        "mass_flow": mass_flow,
        "initial_temperature": temperature,
        "inlet_temperature": operation.inlet_temperature.values[0],
        "end_time": operation.end_time,
    }


def exact(store: dict[str, Any], place: float, times: np.ndarray) -> np.ndarray:
    """Temperature (K) of the fluid at a place and at times, without conduction along the bed."""
    flux = store["mass_flow"] / (0.25 * np.pi * store["diameter"] ** 2)
    exchange = specific_surface(store["porosity"], store["bead_diameter"]) * store["coefficient"]
    beads = (1.0 - store["porosity"]) * store["beads"]["rho"] * store["beads"]["cp"]
    since = times - place * store["porosity"] * store["fluid"]["rho"] / flux
    units = exchange * place / (flux * store["fluid"]["cp"])
    front = [schumann(units, exchange * one / beads) if one > 0.0 else 0.0 for one in since]
    return store["initial_temperature"] + (store["inlet_temperature"] - store["initial_temperature"]) * np.array(front)


def ours(scene: Scene, settings: dict[str, float]) -> Front:
    """This program's front with some settings."""
    quiet = {"output.pictures": False, "output.fields": False, "solver.refine_in_doubt": False}
    changed, seconds = scene.changed(quiet | settings), []
    for _ in range(REPEATS + 1):  # the first one may compile
        begun = time.process_time()
        result = run(changed, communicator=MPI.COMM_SELF)
        seconds.append(time.process_time() - begun)
    history = result.history
    words = (
        ", ".join(f"{name.removeprefix('solver.')} {value:g}" for name, value in settings.items()) or "default settings"
    )
    columns = (np.array(history[name]) for name in ("time", "outlet_temperature", "temperature_centre_L/2"))
    return Front("porousmold", words, statistics.median(seconds[1:]), result.summary["time_steps"], *columns)


def openterrace(store: dict[str, Any], cells: int, python: str) -> Front:
    """OpenTerrace's front on a number of cells, by a Python that has it."""
    given = json.dumps(store | {"cells": cells})
    command = [python, str(HERE / "openterrace_store.py")]
    child = subprocess.run(command, input=given, capture_output=True, text=True, check=True)
    found = json.loads(child.stdout)
    columns = (np.array(found[name]) for name in ("time", "outlet", "middle"))
    return Front("OpenTerrace 0.1.4", f"{cells} cells", found["seconds"], found["steps"], *columns)


def draw(fronts: list[Front], store: dict[str, Any], path: Path) -> None:
    """Error against seconds, a line per program, and the front at the outlet as the default settings and 50 cells have it."""
    with plt.rc_context(STYLE):
        figure, (of_errors, of_fronts) = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained")
    for program in dict.fromkeys(front.program for front in fronts):
        part = [front for front in fronts if front.program == program]
        of_errors.loglog(
            [front.seconds for front in part], [max(front.errors(store)) for front in part], "o-", label=program
        )
    of_errors.set_xlabel("CPU seconds of the run")
    of_errors.set_ylabel("largest error of the fluid's temperature, K")
    of_errors.legend()
    for front in fronts:
        if front.words in ("default settings", "50 cells"):
            label = f"{front.program}, {front.words}"
            of_fronts.plot(front.time / 3600.0, front.outlet - 273.15, label=label)
    times = np.linspace(0.0, store["end_time"], 200)
    of_fronts.plot(times / 3600.0, exact(store, store["length"], times) - 273.15, "k:", label="Schumann")
    of_fronts.set_xlabel("time, h")
    of_fronts.set_ylabel("fluid at the outlet, °C")
    of_fronts.legend()
    save(figure, path)


def main() -> None:
    """Run everything and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--python", default="build/peers/bin/python", help="a Python that has OpenTerrace")
    parser.add_argument("--out", type=Path, default=DOCS / "peers.md")
    options = parser.parse_args()
    scene = Scene.load(SCENE)
    store = store_of(scene)
    page = Page(
        "# Beside other programs",
        "",
        "Written by `make peers`; do not edit.",
        "",
        "A store of stones charged with hot air, `studies/stores/schumann.toml`: constant properties, isothermal beads and a "
        f"heat transfer coefficient of {store['coefficient']:.4g} W/m²/K in both programs; what is right is Schumann's (1929) "
        "solution. It leaves out the fluid's conduction along the bed, as OpenTerrace does here; this program does not, and so "
        "tends to a few tenths of a kelvin.",
        "",
        "OpenTerrace (explicit steps, upwind differences of first order) runs with 0.9 of the longest step for which no "
        "temperature oscillates; this program chooses its steps. CPU seconds of the run, with all code compiled, one after the "
        "other. OpenTerrace wants Python 3.12 and an environment of its own (`make peers PEER_PYTHON=...`).",
    )
    fronts = []
    page.head("program", "settings", "time steps", "CPU s", "largest error at the outlet, K", "in the middle, K")
    runs = [lambda one=one: ours(scene, one) for one in SETTINGS]
    runs += [lambda cells=cells: openterrace(store, cells, options.python) for cells in CELLS]
    for one in runs:
        front = one()
        outlet, middle = front.errors(store)
        page.row(front.program, front.words, front.steps, f"{front.seconds:.3g}", f"{outlet:.3g}", f"{middle:.3g}")
        fronts.append(front)
    picture = options.out.with_suffix(".png")
    draw(fronts, store, picture)
    difference = store["inlet_temperature"] - store["initial_temperature"]
    page.add(
        "",
        f"![Error against seconds, and the front at the outlet]({picture.name})",
        "",
        f"Errors are of {difference:g} K.",
    )
    page.write(options.out)


if __name__ == "__main__":
    main()
