"""Newton's method: how it ends, and what kept factors leave."""

import math

import numpy as np
import pytest
import ufl
from dolfinx import fem
from petsc4py import PETSc

from porousmold.mesh import fenicsx
from porousmold.solvers.newton import Beside, NewtonSystem
from porousmold.solvers.newton_iterations import Contraction, Iterations

from ..support import box


def contracting(ratio, first=1.0):
    """Updates of a sequence with this contraction."""
    updates = iter(first * ratio**number for number in range(100))
    return lambda: next(updates)


def note_all(iterations, updates):
    """Whether iterations with these updates end with a solution."""
    while not iterations.are_over:
        iterations.note(updates())
    return iterations.is_solved


@pytest.mark.parametrize("ratio", [0.4, 0.1, 1e-3])
def test_the_error_that_is_left_is_the_sum_of_the_updates_to_come(ratio):
    contraction, errors = Contraction(), []
    iterations = Iterations(4, lambda error: errors.append(error) or False, contraction=contraction)
    note_all(iterations, contracting(ratio))
    assert contraction.ratio == pytest.approx(ratio)
    assert errors[0] == pytest.approx(1.0)  # nothing is known of it: half of it is left at most, as of a slow sequence
    assert errors[-1] == pytest.approx(sum(ratio**number for number in range(4, 100)), rel=1e-6)


def test_without_a_contraction_the_update_itself_counts():
    assert not note_all(Iterations(3, lambda error: error < 5e-3), contracting(0.1))
    assert note_all(Iterations(4, lambda error: error < 5e-3), contracting(0.1))


def system(power, name="test", beside=None):
    """u^power = 2 in the mean over a box, from u = 1."""
    domain = box((2, 2))
    unknown = fem.Function(fenicsx.lagrange_space(domain.mesh))
    unknown.x.array[:] = 1.0
    test = ufl.TestFunction(unknown.function_space)
    residual = (unknown**power - domain.constant(2.0)) * test * domain.cell_measure(4)(1)
    return NewtonSystem(name, residual, unknown, np.empty(0, np.int32), keep_jacobian=True, beside=beside), unknown


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


def counting(name):
    """A system of options `name`, and a list that grows with every residual."""
    counted = []
    renew = Beside(renew=lambda: counted.append(1))
    return system(3.0, name, renew)[0], counted


def test_snes_drives_it_and_leaves_out_the_residual_after_the_last_update():
    solved, counted = counting("test")
    iterations = Iterations(20, lambda error: error < 1e-4)
    assert solved.solve(iterations)
    assert len(counted) == iterations.taken
    assert solved._snes.getType() == "newtonls"


def test_options_of_the_user_win():
    """A line search asked for in PETSc's options is taken, and sees every residual."""
    options = PETSc.Options()
    for name, value in {"snes_linesearch_type": "bt", "ksp_type": "gmres", "mat_mumps_icntl_14": 50}.items():
        options[f"porousmold_searched_{name}"] = value
    solved, counted = counting("searched")
    iterations = Iterations(20, lambda error: error < 1e-4)
    assert solved.solve(iterations)
    assert len(counted) > iterations.taken
    assert solved._snes.getKSP().getType() == "gmres"
    assert options["porousmold_searched_mat_mumps_icntl_14"] == "50"


def test_what_is_raised_on_the_way_passes_snes_and_leaves_it_in_order():
    due = [True]

    def interrupt():
        if due:
            due.pop()
            raise KeyboardInterrupt

    interrupted, unknown = system(3.0, "test", Beside(renew=interrupt))
    with pytest.raises(KeyboardInterrupt):
        interrupted.iterate()
    assert interrupted.solve(Iterations(20, lambda error: error < 1e-4))
    assert unknown.x.array == pytest.approx(2.0 ** (1.0 / 3.0), rel=1e-3)


def test_what_is_solved_beside_completes_the_update():
    """An update that is halved converges with the ratio 1/2."""
    halved, _ = system(1.0, "test", Beside(complete=lambda update: update.scale(0.5)))
    updates = [halved.iterate() for _ in range(12)]
    assert updates[-1] / updates[-2] == pytest.approx(0.5, rel=1e-3)


def test_an_iterate_that_is_not_finite_is_infinitely_far():
    broken, unknown = system(3.0)
    unknown.x.array[:] = float("nan")
    assert broken.iterate() == float("inf")
