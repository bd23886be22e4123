"""Refinement and turbulence tables of the shipped scenes: writes docs/tables.md. Run: make tables (about 20 minutes)."""

import argparse
import time
from pathlib import Path

from mpi4py import MPI
from scipy.optimize import brentq

from porousmold import Scene
from porousmold.simulation.specs import specs_of
from porousmold.simulation.time_integration import Simulation
from studies.page import Page

HERE = Path(__file__).parent
SCENES = {
    "aluminium mold": (HERE / "mold" / "aluminium.toml", 1470.0),
    "FRP mold": (HERE / "mold" / "frp.toml", 1275.0),
    "pipe": (HERE / "pipe" / "baseline.toml", None),
}
MESHES, STEPS = (1, 2, 3), (0.5, 1, 2)
TURBULENCE = ("none", "k-epsilon", "nakayama-kuwahara", "damped-nakayama-kuwahara")


def refined(scene, mesh, steps):
    """The scene with every cell cut by `mesh` in both directions and every step by `steps`."""
    return scene.changed({"solver.mesh_refinement": float(mesh), "solver.step_refinement": float(steps)})


def heated(scene):
    """(simulation after its integration, seconds of flow and energy)."""
    simulation = Simulation(specs_of(scene), MPI.COMM_WORLD).integrate()
    return simulation, simulation.problem.stopwatch.seconds["flow"] + simulation.problem.stopwatch.seconds["energy"]


def extrapolated(first, second, third):
    """(limit, order) of values on meshes 1, 2, 3 whose error falls with a power of the mesh; the third one and None where they
    do not show one between 0.8 and 4."""

    def mismatch(order):
        return (first - second) * (2.0**-order - 3.0**-order) - (second - third) * (1.0 - 2.0**-order)

    if mismatch(0.8) * mismatch(4.0) >= 0.0:
        return third, None
    order = brentq(mismatch, 0.8, 4.0)
    return third + (third - second) * 3.0**-order / (2.0**-order - 3.0**-order), order


def main():
    """Compute the tables and write them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=HERE.parent / "docs" / "tables.md")
    out = parser.parse_args().out
    page = Page(
        "# Refinement and turbulence models",
        "",
        "Written by `make tables`; do not edit. Heating times in s.",
        "",
        "## Mesh and time step",
        "",
        "Mesh 1 and steps / 1 are the scene's defaults; meshes 2 and 3 have two and three times as many cells in each "
        "direction; steps / 2 halves every step and steps / 0.5 doubles it. "
        "Seconds are those of flow and energy with the default steps, on one core.",
    )
    start = time.perf_counter()
    for name, (path, published) in SCENES.items():
        scene = Scene.load(path)
        times = {}
        page.add("", f"### {name}")
        page.head("mesh", "cells", "steps / 0.5", "steps / 1", "steps / 2", "seconds", "imbalance")
        for mesh in MESHES:
            worst, shown_seconds = 0.0, 0.0
            for steps in STEPS if mesh == 1 else (1,):
                simulation, seconds = heated(refined(scene, mesh, steps))
                times[mesh, steps] = simulation.recorder.heating_time
                worst = max(worst, abs(simulation.problem.heat.balance.imbalance))
                if steps == 1:
                    shown_seconds = seconds
            cells = simulation.problem.domain.mesh.topology.index_map(2).size_global
            found = [f"{times[mesh, steps]:.2f}" if (mesh, steps) in times else "" for steps in STEPS]
            page.row(mesh, cells, *found, f"{shown_seconds:.1f}", f"{worst:.1e}")
        best, order = extrapolated(*(times[mesh, 1] for mesh in MESHES))
        best += (times[1, 2] - times[1, 1]) * 4.0 / 3.0
        how = f"observed order {order:.1f}" if order else "no order observed: the finest mesh"
        text = (
            f"Extrapolated ({how} in the mesh, second order in the steps): {best:.1f} s; the default is "
            f"{times[1, 1] / best - 1:+.2%} off."
        )
        if published:
            text += f" Published: {published:.0f} s, from which the extrapolated value deviates by {best / published - 1:+.1%}."
        page.add("", text)
    page.add("", "## Turbulence models (default mesh and steps)")
    page.head("scene", *TURBULENCE, "largest imbalance")
    for name, (path, _) in SCENES.items():
        runs = [heated(Scene.load(path, {"model.turbulence": model}))[0] for model in TURBULENCE]
        worst = max(abs(run.problem.heat.balance.imbalance) for run in runs)
        page.row(name, *(f"{run.recorder.heating_time:.1f}" for run in runs), f"{worst:.1e}")
    page.add("", f"All of this took {time.perf_counter() - start:.0f} s on one core.")
    page.write(out)


if __name__ == "__main__":
    main()
