"""Accuracy on request: its estimate, its refinements, and the true error of scenes drawn at random."""

import math

import pytest

from porousmold import InputError
from porousmold.errors import SolveError
from porousmold.scene.scene import Scene
from porousmold.simulation.accuracy import (
    COARSER,
    OBSERVED_ORDER,
    STEPS_ORDER,
    Errors,
    errors_after,
    estimated_errors,
    needed_factor,
    run_to_accuracy,
)
from studies.accuracy import outcome_of

from ..support import ALUMINIUM


@pytest.mark.parametrize("number", [2, *(pytest.param(n, marks=pytest.mark.heavy) for n in (5, 21, 33))])
def test_the_estimate_is_that_of_the_true_error(number):
    """Within a factor of 3, on scenes drawn at random; `make accuracy` shows it on 40."""
    outcome = outcome_of((number, 0.003))
    assert outcome.is_right and outcome.true <= 0.003


class March:
    """Heating times whose errors by mesh and steps fall with an order each."""

    def __init__(self, mesh, steps, order=2.0):
        self._mesh, self._steps, self._order, self.asked = mesh, steps, order, []

    def error(self, mesh, steps):
        return self._mesh / mesh**self._order + self._steps / steps**STEPS_ORDER

    def __call__(self, scene):
        mesh, steps = scene.solver.mesh_refinement, scene.solver.step_refinement
        self.asked.append((mesh, steps))
        return 1000.0 * (1.0 + self.error(mesh, steps))


@pytest.mark.parametrize(("mesh", "steps"), [(0.02, 0.001), (0.001, 0.02), (0.01, 0.01), (1e-5, 1e-5)])
@pytest.mark.parametrize("wanted", [1e-3, 1e-4])
def test_mesh_and_steps_are_refined_as_each_needs_it(mesh, steps, wanted):
    march = March(mesh, steps)
    error = run_to_accuracy(Scene.load(ALUMINIUM, {"solver.accuracy": wanted}), march)
    at_mesh, at_steps = march.asked[-1]
    true = march.error(at_mesh, at_steps)
    assert error is not None and (error <= wanted or max(at_mesh, at_steps) == 8.0)
    # at order 2 itself (0.7^-2 - 1) / (0.7^-2.5 - 1) of the mesh's error is seen
    assert true < 1.5 * error
    if mesh > 3.0 * steps:
        assert at_mesh > at_steps
    if steps > 3.0 * mesh:
        assert at_steps > at_mesh
    assert len(march.asked) <= 5


def test_estimate_is_zero_only_without_any_difference():
    assert estimated_errors(100.0, 100.0, 100.0).both == 0.0
    assert estimated_errors(101.0, 100.0, 100.0).steps > 0.0 and estimated_errors(99.0, 99.0, 100.0).mesh < 0.0


def test_errors_that_cancel_count_by_half_at_least():
    assert Errors(3e-3, 1e-3).both == pytest.approx(4e-3)
    assert Errors(3e-3, -1e-3).both == pytest.approx(2e-3)
    assert Errors(3e-3, -3e-3).both == pytest.approx(0.5 * math.sqrt(2.0) * 3e-3)


def test_richardson_is_exact_at_the_order_that_is_taken():
    march = March(3e-3, -2e-3, OBSERVED_ORDER)
    scene = Scene.load(ALUMINIUM)
    times = [march(scene.changed({"solver.mesh_refinement": m, "solver.step_refinement": s}))
             for m, s in ((COARSER, 0.5), (COARSER, 1.0), (1.0, 1.0))]  # fmt: skip
    errors = estimated_errors(*times)
    assert errors.mesh == pytest.approx(3e-3, rel=5e-3) and errors.steps == pytest.approx(-2e-3, rel=5e-3)


def test_a_run_that_moves_more_than_foreseen_is_estimated_by_its_move():
    foreseen = errors_after(Errors(1e-3, 0.0), 2.0, 1.0, 7.5e-4)
    assert foreseen.both == pytest.approx(2.5e-4)
    moved = errors_after(Errors(1e-3, 0.0), 2.0, 1.0, 7.5e-3)
    assert moved.both == pytest.approx(7.5e-3 / (2.0**OBSERVED_ORDER - 1.0))


def test_the_factor_brings_each_error_to_its_share():
    assert needed_factor(1e-5, 1e-3) == 1.0
    assert 4e-3 / needed_factor(4e-3, 1e-3) ** 2 < 1e-3 / 2.0


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
