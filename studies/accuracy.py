"""Whether `solver.accuracy` can be trusted: its estimate against the true error on 30 scenes. Run: make accuracy (8 minutes).

Prints a line a scene, and how many estimates cover the error against a reference of twice the cells and steps.
"""

import argparse
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mpi4py import MPI

from porousmold import Scene, run
from porousmold.simulation.march import Simulation
from porousmold.simulation.specs import specs_of

HERE = Path(__file__).parent
PATHS = HERE / "mold" / "aluminium.toml", HERE / "mold" / "frp.toml", HERE / "pipe" / "baseline.toml"
SCENES = 30
COVERED = 1.5
"""Estimated errors that a true one may be large."""


class Errors(NamedTuple):
    """Relative errors of a heating time: the true one and the estimate."""

    true: float
    estimated: float


def scene_of(number: int) -> Scene:
    """Scene `number`: a shipped one with other sizes, materials, drives and models, laminar for speed."""
    random = np.random.default_rng(number)
    path = PATHS[number % 3]
    changes = {
        "model.flow": ("developed", "developed", "plug", "full")[number % 4],
        "model.turbulence": "none",
        "model.energy": "one-temperature" if number % 10 == 9 else "two-temperature",
        "model.wall": "thin" if number % 7 == 6 else "conjugate",
        "model.nusselt": ("wakao", "whitaker")[number % 2],
        "wall.thickness": random.uniform(1e-3, 5e-3),
        "bed.bulk_porosity": random.uniform(0.36, 0.44),
    }
    if number % 3 != 2:
        changes |= {
            "operation.pressure_drop": 10.0 ** random.uniform(3.0, 4.3),
            "bed.bead_diameter": random.uniform(3e-3, 5e-3),
        }
    changes["operation.end_time"] = 3e4
    return Scene.load(path, changes)


def errors_of(number: int) -> Errors:
    """True and estimated error of scene `number` at an accuracy of 5 %."""
    scene = scene_of(number)
    found = run(scene.changed({"solver.accuracy": 0.05}), communicator=MPI.COMM_SELF).summary
    finer = scene.changed({"solver.mesh_refinement": 2.0, "solver.step_refinement": 2.0})
    reference = Simulation(specs_of(finer), MPI.COMM_SELF).march().recorder.heating_time
    assert reference is not None
    return Errors(abs(found["heating_time"] / reference - 1.0), found["heating_time_error"])


def main() -> None:
    argparse.ArgumentParser(description=__doc__).parse_args()
    all_errors = []
    for number in range(SCENES):
        errors = errors_of(number)
        all_errors.append(errors)
        print(f"scene {number}: error {errors.true:.2e}, estimated {errors.estimated:.2e}", flush=True)
    covered = sum(errors.true < COVERED * errors.estimated for errors in all_errors)
    print(f"{covered} of {SCENES} errors are below {COVERED} times the estimate")


if __name__ == "__main__":
    main()
