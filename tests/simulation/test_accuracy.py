"""Accuracy on request: the estimated error covers the true one, over scenes of every kind."""

import pytest

from porousmold import InputError
from porousmold.errors import SolveError
from porousmold.scene.scene import Scene
from porousmold.simulation.accuracy import estimated_error, first_refinement, run_to_accuracy
from studies.accuracy import COVERED, errors_of

from ..support import ALUMINIUM


@pytest.mark.parametrize("number", [2, 6, *(pytest.param(n, marks=pytest.mark.heavy) for n in (5, 10))])
def test_estimate_covers_the_true_error(number):
    """1.5 times the estimate covers the error against twice the cells and steps; `make accuracy` shows it on 30 scenes."""
    errors = errors_of(number)
    assert errors.true < COVERED * errors.estimated


def test_refines_until_the_estimate_meets_what_is_wanted():
    """With errors that fall with the square of the refinement, it ends where its estimate is good enough."""
    refinements = []

    def march(scene):
        refinements.append(scene.solver.mesh_refinement)
        return 1000.0 + 20.0 / scene.solver.mesh_refinement**2

    error = run_to_accuracy(Scene.load(ALUMINIUM, {"solver.accuracy": 1e-3}), march)
    assert error <= 1e-3 and len(refinements) > 3
    assert refinements[-1] >= refinements[2] == pytest.approx(first_refinement(1e-3))
    assert error > 20.0 / refinements[-1] ** 2 / 1000.0, "the estimate must not be below the true error"


def test_estimate_is_zero_only_without_any_difference():
    assert estimated_error(100.0, 100.0, 100.0) == 0.0
    assert estimated_error(101.0, 100.0, 100.0) > 0.0 and estimated_error(100.0, 101.0, 100.0) > 0.0


def test_failed_coarse_run_is_followed_by_a_finer_one():
    refinements = []

    def march(scene):
        refinements.append(scene.solver.mesh_refinement)
        raise SolveError("flow", 0.0, "detail", "advice")

    with pytest.raises(SolveError):
        run_to_accuracy(Scene.load(ALUMINIUM, {"solver.accuracy": 0.003}), march)
    assert refinements[1] == 2.0 * refinements[0] and len(refinements) == 2


def test_accuracy_chooses_the_refinement_itself():
    with pytest.raises(InputError, match="accuracy"):
        Scene.load(ALUMINIUM, {"solver.accuracy": 0.01, "solver.mesh_refinement": 2.0})
