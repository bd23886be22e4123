"""Heating time inside a step."""

import numpy as np
import pytest

from porousmold.simulation.heating_time import crossing_time


def test_exact_for_an_exponential_approach():
    times = [0.0, 100.0, 220.0]
    deficits = [65.0 * np.exp(-time / 60.0) for time in times]
    assert crossing_time(times, deficits, 2.0) == pytest.approx(60.0 * np.log(32.5), rel=1e-12)


def test_third_order_for_a_bent_approach():
    def deficit(time):
        return 65.0 * np.exp(-time / 60.0 - (time / 200.0) ** 2) * (1.0 + 0.3 * np.sin(time / 50.0))

    from scipy.optimize import brentq

    exact = brentq(lambda time: deficit(time) - 2.0, 50.0, 300.0)
    errors = []
    for step in (40.0, 20.0, 10.0):
        times = [exact - 1.6 * step, exact - 0.6 * step, exact + 0.4 * step]
        errors.append(abs(crossing_time(times, [deficit(t) for t in times], 2.0) - exact))
    assert errors[0] / errors[1] > 6.0 and errors[1] / errors[2] > 6.0


def test_none_before_and_none_while_there_is_nothing_to_heat_yet():
    """An inlet that starts at the initial temperature (thesis eq. 7.17) has a deficit of 0 at first."""
    assert crossing_time([0.0, 1.0], [65.0, 60.0], 2.0) is None
    assert crossing_time([0.0], [0.0], 2.0) is None
    assert crossing_time([0.0, 1.0], [0.0, 1.0], 2.0) is None


def test_linear_with_two_points():
    assert crossing_time([0.0, 10.0], [4.0, 0.0], 2.0) == pytest.approx(5.0)
