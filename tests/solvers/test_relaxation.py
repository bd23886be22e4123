"""What is extrapolated from step to step and relaxed where it goes to and fro: a stiff answer decays, a front is left alone."""

from itertools import pairwise

import numpy as np
import pytest
from dolfinx import mesh
from mpi4py import MPI

from porousmold.mesh import fenicsx
from porousmold.solvers.relaxation import Relaxation

LEAST = 1e-3


@pytest.fixture
def relaxation():
    return Relaxation(fenicsx.lagrange_space(mesh.create_unit_interval(MPI.COMM_SELF, 4)))


def of_a_stiff_answer(relaxation, answer, steps=400):
    """Temperatures at the ends of steps of places that answer by -answer to the temperature assumed (K), from 1 K on."""
    nodes = len(relaxation.missed.x.array)
    before, now, assumed = np.zeros(nodes), np.ones(nodes), np.zeros(nodes)
    course = [now]
    for _ in range(steps):
        expected = now + 0.5 * (now - before)
        assumed = relaxation.relaxed(assumed, 0.5 * (now + before), expected, LEAST)
        before, now = now, -answer * assumed
        course.append(now)
    return np.array(course)


@pytest.mark.parametrize("answer", [0.4, 0.6, 1.0, 3.0, 10.0, 30.0])
def test_a_stiff_answer_decays(relaxation, answer):
    """Extrapolation alone grows from 1/2 on: a root of x^2 + 1.5 s x - 0.5 s leaves the unit circle there."""
    grows = max(abs(np.roots([1.0, 1.5 * answer, -0.5 * answer]))) > 1.0
    assert grows == (answer > 0.5)
    assert np.abs(of_a_stiff_answer(relaxation, answer)[-100:]).max() < LEAST


def test_a_front_that_passes_is_extrapolated(relaxation):
    """Nothing is relaxed where it is missed to one side and then to the other, as before and behind a front."""
    times = np.linspace(-4.0, 4.0, 41)
    course = [np.full(len(relaxation.missed.x.array), value) for value in 50.0 * (1.0 + np.tanh(times))]
    assumed = course[0]
    for before, now in pairwise(course):
        expected = now + 0.5 * (now - before)
        assumed = relaxation.relaxed(assumed, 0.5 * (now + before), expected, LEAST)
        assert np.array_equal(assumed, expected)


def test_a_jump_forgets_what_went_to_and_fro(relaxation):
    of_a_stiff_answer(relaxation, 3.0, steps=10)
    assert relaxation.turns.x.array.max() > 0.0
    relaxation.begin()
    assert not relaxation.turns.x.array.any() and not relaxation.missed.x.array.any()
