"""Modes of a bead against the exact sphere with a convective boundary, and their limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.optimize import brentq

from porousmold.laws.bead_interior import eigenvalues, overall_coefficient, remaining_resistance


def sphere(biot, fourier):
    """Mean and surface of (T - T_f)/(T_0 - T_f) of a sphere with Bi = h R/lambda at Fo = alpha t/R^2 (Carslaw, Jaeger, 9.4)."""
    roots = [
        brentq(lambda b: b * np.cos(b) + (biot - 1.0) * np.sin(b), n * np.pi + 1e-9, (n + 1) * np.pi - 1e-9)
        for n in range(200)
    ]
    beta = np.array(roots)
    decay = np.exp(-(beta**2) * fourier) / (beta**2 + biot * (biot - 1.0))
    return np.sum(6.0 * biot**2 / beta**2 * decay), np.sum(2.0 * biot * decay)


def sphere_by_modes(biot, fourier, count):
    """The same by modes: unknowns T_s and w_n of dT_s/dt = 3 q, dw_n/dt = 2 q - mu_n^2 w_n, all in units of R, lambda, alpha."""
    kept = eigenvalues(count)
    conductance = overall_coefficient(biot, remaining_resistance(kept))
    gains, decays = np.array([3.0, *[2.0] * count]), np.array([0.0, *np.square(kept)])
    matrix = -conductance * np.outer(gains, np.ones(count + 1)) - np.diag(decays)
    state = expm(matrix * fourier) @ np.array([1.0, *[0.0] * count])
    flux = -conductance * state.sum()
    return state[0], state.sum() + remaining_resistance(kept) * flux


@pytest.mark.parametrize("biot", [0.3, 3.0, 30.0])
def test_modes_converge_to_the_exact_sphere(biot):
    """What is left out is of the order of the sum of 1/mu_n^4 over the modes not kept; 8 modes are within 1e-4 in the mean."""
    times = np.array([0.02, 0.1, 0.3]) / min(biot, 1.0)
    exact = np.array([sphere(biot, t) for t in times])
    coarse, fine = (np.max(np.abs([sphere_by_modes(biot, t, n) for t in times] - exact), axis=0) for n in (4, 8))
    fourth_powers = np.array(eigenvalues(1000)) ** -4.0
    expected = fourth_powers[4:].sum() / fourth_powers[8:].sum()
    assert 5.7 < expected < 5.9
    assert np.all(coarse / fine > 0.95 * expected)
    assert fine[0] < 1e-4
    assert fine[1] < 5e-4


def test_eigenvalues():
    """Roots of tan mu = mu (Carslaw, Jaeger, table VI: 4.4934, 7.7253, 10.9041, 14.0662) and what is left of their sum."""
    assert eigenvalues(4) == pytest.approx([4.4934, 7.7253, 10.9041, 14.0662], abs=5e-5)
    assert 0.0 < remaining_resistance(eigenvalues(400)) < 2.0 / (np.pi**2 * 400)
    assert remaining_resistance([]) == 0.2


@given(biot=st.floats(1e-6, 1e-3), fourier=st.floats(1.0, 50.0), count=st.integers(0, 3))
def test_isothermal_limit(biot, fourier, count):
    """A bead that conducts well cools like a lumped one, exp(-3 Bi Fo), whatever is kept."""
    mean, surface = sphere_by_modes(biot, fourier, count)
    assert mean == pytest.approx(np.exp(-3.0 * biot * fourier), abs=biot)
    assert surface == pytest.approx(mean, abs=biot)


def test_a_film_in_series():
    assert overall_coefficient(100.0, 0.0) == 100.0
    assert overall_coefficient(0.0, 5.0) == 0.0
    assert 1.0 / overall_coefficient(100.0, 0.03) == pytest.approx(1.0 / 100.0 + 0.03)
