"""What a fluid displaces as its density changes, step by step."""

import numpy as np
import pytest
from dolfinx import fem
from mpi4py import MPI

from porousmold.mesh import domain as geometry
from porousmold.mesh import fenicsx
from porousmold.solvers.displacement import Displacement

MESH = geometry.straight_bed(MPI.COMM_SELF, np.array([0.0, 1.0]), [geometry.Across.to_wall(np.array([0.0, 1.0]))]).mesh


def density(temperature):
    return 1000.0 - 0.8 * temperature - 1e-3 * temperature**2


def course(time):
    """A temperature (K) that rises to 100."""
    return 100.0 * (1.0 - np.exp(-time))


def followed(steps):
    """Largest error of the rate in steps (s) of that course, over the largest rate, after the first three; and the mass that is
    left to be displaced at the end."""
    temperature = fem.Function(fenicsx.lagrange_space(MESH))
    displacement, time, last, errors = Displacement(temperature, density), 0.0, 0.0, []
    for step in steps:
        now = np.full_like(temperature.x.array, course(time))
        ahead = now if not last else now + step / last * (now - course(time - last))
        displacement.follow(now, ahead, step, last, flows=True)
        exact = -(density(course(time + step)) - density(course(time))) / step
        errors.append(abs(displacement.rate.x.array[0] - exact))
        time, last = time + step, step
    left = displacement.missed(np.full_like(temperature.x.array, course(time)))[0]
    return max(errors[3:]), left


def test_the_rate_is_of_second_order():
    coarse, fine = (followed(np.full(cells, 2.0 / cells))[0] for cells in (40, 80))
    assert coarse / fine == pytest.approx(4.0, rel=0.15)


def test_mass_is_conserved_whatever_the_steps():
    steps = np.random.default_rng(3).uniform(0.02, 0.2, 60)
    _, left = followed(np.append(steps, [0.1] * 40))
    assert abs(left) < 1e-4 * abs(density(100.0) - density(0.0))


def test_a_short_step_does_not_catch_up_with_a_long_one_at_once():
    temperature = fem.Function(fenicsx.lagrange_space(MESH))
    displacement = Displacement(temperature, density)
    warm = np.full_like(temperature.x.array, 50.0)
    displacement.follow(temperature.x.array, temperature.x.array, 10.0, 0.0, flows=True)
    displacement.follow(warm, warm, 0.01, 10.0, flows=True)
    assert displacement.rate.x.array == pytest.approx((density(0.0) - density(50.0)) / 10.0)


def test_at_rest_nothing_is_displaced_and_nothing_is_owed():
    temperature = fem.Function(fenicsx.lagrange_space(MESH))
    displacement = Displacement(temperature, density)
    warm = np.full_like(temperature.x.array, 50.0)
    displacement.follow(temperature.x.array, warm, 1.0, 0.0, flows=False)
    assert not displacement.rate.x.array.any() and not displacement.missed(warm).any()
