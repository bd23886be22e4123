"""Accuracy on request: the estimated error covers the true one, over scenes of every kind."""

import numpy as np
import pytest
from mpi4py import MPI

from porousmold import InputError, run
from porousmold.accuracy import estimated_error, first_refinement, scenes_to_run
from porousmold.errors import SolveError
from porousmold.scene import Scene
from porousmold.simulation import Simulation

from .support import ALUMINIUM, FRP, PIPE

SCENES = 30
PATHS = (ALUMINIUM, FRP, PIPE)


def varied(number):
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
    if path is not PIPE:
        changes |= {
            "operation.pressure_drop": 10.0 ** random.uniform(3.0, 4.3),
            "bed.bead_diameter": random.uniform(3e-3, 5e-3),
        }
    changes["operation.end_time"] = 3e4
    return Scene.from_file(path, changes)


@pytest.mark.parametrize("part", range(6))
def test_estimate_covers_the_true_error(part):
    """In 95 % of the scenes 1.5 times the estimate covers the error against a reference of twice the cells and steps."""
    found = []
    for number in range(part, SCENES, 6):
        scene = varied(number)
        estimated = run(scene.with_changes(solver__accuracy=0.05), communicator=MPI.COMM_SELF).summary
        finer = scene.with_changes(solver__mesh_refinement=2.0, solver__step_refinement=2.0)
        true = Simulation(finer, MPI.COMM_SELF).march().heating_time
        error = abs(estimated["heating_time"] / true - 1.0)
        found.append(error / estimated["heating_time_error"])
        print(f"scene {number}: error {error:.2e}, estimated {estimated['heating_time_error']:.2e}")
    # of five scenes none may fail: stricter than 95 % of thirty
    assert max(found) < 1.5


def test_refines_until_the_estimate_meets_what_is_wanted():
    """With errors that fall with the square of the refinement, the generator ends where its estimate is good enough."""
    scene = Scene.from_file(ALUMINIUM, {"solver.accuracy": 1e-3})
    scenes, refinements = scenes_to_run(scene), []
    current = next(scenes)
    try:
        while True:
            refinements.append(current.solver.mesh_refinement)
            current = scenes.send(1000.0 + 20.0 / current.solver.mesh_refinement**2)
    except StopIteration as end:
        error = end.value
    assert error <= 1e-3 and len(refinements) > 3
    assert refinements[-1] >= refinements[2] == pytest.approx(first_refinement(1e-3))
    assert error > 20.0 / refinements[-1] ** 2 / 1000.0, "the estimate must not be below the true error"


def test_estimate_is_zero_only_without_any_difference():
    assert estimated_error(100.0, 100.0, 100.0) == 0.0
    assert estimated_error(101.0, 100.0, 100.0) > 0.0 and estimated_error(100.0, 101.0, 100.0) > 0.0


def test_failed_coarse_run_is_followed_by_a_finer_one():
    scenes = scenes_to_run(Scene.from_file(ALUMINIUM, {"solver.accuracy": 0.003}))
    first = next(scenes).solver.mesh_refinement
    failure = SolveError("flow", 0.0, "detail", "advice")
    assert scenes.throw(failure).solver.mesh_refinement == 2.0 * first
    with pytest.raises(SolveError):
        scenes.throw(failure)


def test_accuracy_chooses_the_refinement_itself():
    with pytest.raises(InputError, match="accuracy"):
        Scene.from_file(ALUMINIUM, {"solver.accuracy": 0.01, "solver.mesh_refinement": 2.0})
