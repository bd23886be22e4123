"""Steps in time: their order, their error estimate, their balance; a tracer as a second transported quantity."""

import numpy as np
import pytest
import ufl
from dolfinx import fem

from porousmold.mesh import fenicsx
from porousmold.solvers.newton import NewtonSystem
from porousmold.solvers.sdirk import BACKWARD_EULER, STAGES, Sdirk
from porousmold.solvers.stages import StageSolver
from studies.tracer import breakthrough

from ..support import box, coarse_scene, observed_orders


def cooled(stages, count, end=1.0):
    """(u(end), what is stored more, what has left, the largest estimated error of a step) of d(u + u^2)/dt = -u, u(0) = 1."""
    domain = box((1, 1))
    unknown, inverse = fem.Function(fenicsx.lagrange_space(domain.mesh)), fem.Constant(domain.mesh, 1.0)
    unknown.x.array[:] = 1.0
    test, dx = ufl.TestFunction(unknown.function_space), domain.cell_measure(4)(1)
    stored, leaving = (unknown + unknown**2) * test * dx, unknown * test * dx
    held = np.empty(0, np.int32)
    system = NewtonSystem("test", inverse * stored + leaving, unknown, held, keep_jacobian=True)
    stored, out = fenicsx.compiled_form(stored), fenicsx.compiled_form(unknown * dx)
    steps = Sdirk(
        system,
        lambda vector: fenicsx.assemble_vector(vector, stored),
        inverse,
        StageSolver(system, tuple, 1e-12),
        lambda time: None,
    )
    left, gained, errors = [], 0.0, []
    for number in range(count):
        gained += steps.take(
            number * end / count, end / count, stages, lambda w: left.append(w * fem.assemble_scalar(out))
        )
        difference, weights = steps.difference(stages)
        error = system.new_vector()
        system.apply_inverse(difference, error)
        errors.append(np.abs(error.array).max())
    return unknown.x.array[0], gained, sum(left), max(errors), weights.order


@pytest.mark.parametrize(("stages", "order"), [(STAGES, 3), (BACKWARD_EULER, 1)])
def test_the_order_and_that_of_the_error_estimate_are_those_of_theory(stages, order):
    """Against ln u + 2 u = 2 - t; the estimate is of the order of its embedded method, in one step."""
    from scipy.special import lambertw

    exact = float(lambertw(2.0 * np.exp(2.0 - 1.0)).real) / 2.0
    runs = [cooled(stages, count) for count in (4, 8, 16)]
    assert observed_orders(np.array([abs(run[0] - exact) for run in runs]))[-1] == pytest.approx(order, abs=0.2)
    assert observed_orders(np.array([run[3] for run in runs]))[-1] == pytest.approx(runs[0][4], abs=0.25)


@pytest.mark.parametrize("stages", [STAGES, BACKWARD_EULER])
def test_what_is_stored_is_what_has_not_left(stages):
    _, gained, left, *_ = cooled(stages, 5)
    assert gained == pytest.approx(-left, rel=1e-10)


def test_a_tracer_leaves_after_the_residence_time():
    """The mean time of the fluid in the bed is its mass over the mass flow (Danckwerts), whatever the velocity's profile."""
    changes = {"model.turbulence": "none", "solver.mesh_refinement": 0.5}
    times, out, mean, missing = breakthrough(coarse_scene(changes))
    assert mean == pytest.approx(1.0, abs=1e-3)
    assert abs(missing) < 1e-10
    assert out[-1] == pytest.approx(1.0, abs=0.01)  # what is next to the wall is late
    assert 0.9 < np.interp(0.5, out, times) < 1.1
