"""Newton's method: how it ends, and what kept factors leave."""

import math

import numpy as np
import pytest
import ufl
from dolfinx import fem

from porousmold.mesh import fenicsx
from porousmold.solvers.newton import Contraction, NewtonSystem, modified_newton

from ..support import box


def contracting(ratio, first=1.0):
    """Updates of a sequence with this contraction."""
    updates = iter(first * ratio**number for number in range(100))
    return lambda: next(updates)


@pytest.mark.parametrize("ratio", [0.4, 0.1, 1e-3])
def test_the_error_that_is_left_is_the_sum_of_the_updates_to_come(ratio):
    contraction, errors = Contraction(), []
    modified_newton(
        contracting(ratio), most=4, converged=lambda error: errors.append(error) or False, contraction=contraction
    )
    assert contraction.ratio == pytest.approx(ratio)
    assert errors[0] == pytest.approx(1.0)  # nothing is known of it: half of it is left at most, as of a slow sequence
    assert errors[-1] == pytest.approx(sum(ratio**number for number in range(4, 100)), rel=1e-6)


def test_without_a_contraction_the_update_itself_counts():
    assert not modified_newton(contracting(0.1), most=3, converged=lambda error: error < 5e-3)
    assert modified_newton(contracting(0.1), most=4, converged=lambda error: error < 5e-3)


def system(power):
    """u^power = 2 in the mean over a box, from u = 1."""
    domain = box((2, 2))
    unknown = fem.Function(fenicsx.lagrange_space(domain.mesh))
    unknown.x.array[:] = 1.0
    test = ufl.TestFunction(unknown.function_space)
    residual = (unknown**power - domain.constant(2.0)) * test * domain.cell_measure(4)(1)
    return NewtonSystem(residual, unknown, np.empty(0, np.int32), keep_jacobian=True), unknown


def test_iterations_converge_as_newtons_method_does():
    """Quadratically with renewed factors, with the ratio 1 - f'(x)/f'(1) with those of the start."""
    renewed, unknown = system(3.0)
    updates = []
    for _ in range(6):
        renewed.renew_jacobian()
        updates.append(renewed.iterate())
    assert unknown.x.array == pytest.approx(2.0 ** (1.0 / 3.0), rel=1e-12)
    assert updates[4] < 10.0 * updates[3] ** 2
    kept, unknown = system(1.5)
    updates = [kept.iterate() for _ in range(12)]
    root = 2.0 ** (2.0 / 3.0)
    assert unknown.x.array == pytest.approx(root, rel=1e-6)
    assert updates[-1] / updates[-2] == pytest.approx(abs(1.0 - 1.5 * math.sqrt(root) / 1.5), rel=0.01)


def test_an_iterate_that_is_not_finite_is_infinitely_far():
    broken, unknown = system(3.0)
    unknown.x.array[:] = float("nan")
    assert broken.iterate() == float("inf")
