"""Estimated errors of time steps: their orders, and that they bound the true ones."""

import numpy as np
import pytest
from mpi4py import MPI

from porousmold.solvers.sdirk import BACKWARD_EULER, STAGES
from porousmold.solvers.step_error import RegionNorm, StepError

from ..equations.test_wall_layers import solid, wall_alone


@pytest.mark.parametrize(("stages", "order"), [(STAGES, 3), (BACKWARD_EULER, 2)])
def test_the_estimate_is_of_its_order_and_no_smaller_than_the_error(monkeypatch, stages, order):
    """A wall that cools through a film, once its profile is smooth: against the same time in sixteen steps."""
    heat, _ = wall_alone([(solid(), 0.1, 20, None)], coefficient=5.0)
    for number in range(10):
        heat.step(100.0 * number, 100.0)
    start, estimates, errors = heat.unknown.x.array.copy(), [], []
    for step in (20.0, 10.0, 5.0):
        heat.unknown.x.array[:] = start
        with monkeypatch.context() as patched:
            patched.setattr("porousmold.solvers.bounded_steps.STAGES", stages)
            estimates.append(heat.step(1000.0, step))
        end = heat.unknown.x.array.copy()
        heat.unknown.x.array[:] = start
        for number in range(16):
            heat.step(1000.0 + number * step / 16.0, step / 16.0)
        errors.append(heat.error.norm(end - heat.unknown.x.array))
    assert all(estimate.order == order and estimate.cure == 0.0 for estimate in estimates)
    found = np.array([estimate.temperature for estimate in estimates])
    assert np.log2(found[:-1] / found[1:])[-1] == pytest.approx(order, abs=0.25)
    assert np.all(np.array(errors) < 1.2 * found), (errors, found)


def test_the_norm_is_that_of_the_worst_region():
    norm = RegionNorm(MPI.COMM_SELF, np.array([1.0, 3.0, 2.0, 2.0]), [np.array([0, 1]), np.array([2, 3])])
    assert norm(np.array([2.0, 0.0, 0.0, 0.0])) == pytest.approx(1.0)
    assert norm(np.array([2.0, 0.0, 3.0, 0.0])) == pytest.approx(3.0 / np.sqrt(2.0))


def test_errors_of_steps_in_succession_add_up():
    assert StepError(1.0, 0.1, 2).plus(StepError(2.0, 0.2, 3)) == pytest.approx((3.0, 0.3, 2))
