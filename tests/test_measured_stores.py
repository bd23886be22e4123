"""The two measured heatings with flow (docs/measured-stores.md): nothing is tuned."""

import numpy as np
import pytest

from studies import measured_stores

STONES_RANGE = 657.0


def off(name, data, inside, changes=None):
    """Root mean square of computed minus measured (K) at all times but the start."""
    found = measured_stores.computed(name, [time for time in data if time > 0.0], changes)
    return float(np.sqrt(np.mean(measured_stores.deviations(found, data, inside) ** 2)))


@pytest.fixture(scope="module")
def stones():
    return measured_stores.measured("alonso", 0.48)


def test_stones_heated_by_air_are_as_measured(stones):
    assert off("alonso", stones, (-1.0, 1.0)) < 0.025 * STONES_RANGE


def test_quartzite_cooled_by_salt_is_as_measured():
    assert off("pacheco", measured_stores.measured("pacheco"), (0.3, 5.9)) < 7.5


def test_the_heat_of_the_measurement_rules_out_the_larger_heat_capacity_throughout(stones):
    """Of the profiles themselves: what the stones stored in the first hour against what the air brought."""
    along = np.linspace(0.0, 0.48, 200)
    first, later = (np.interp(along, *stones[time]) for time in (0.0, 3600.0))
    rise = np.mean(later - first) * 0.48 * np.pi * 0.25**2 * 0.63 * 4211.0
    air = 3600.0 * 0.01389 * 1090.0 * (682.0 - np.mean([first[-1], later[-1]]))
    assert rise * 1200.0 > 1.1 * air > 1.1 * rise * 950.0


@pytest.mark.parametrize("words", [name for name in measured_stores.STONES if name != "as assumed"])
def test_no_single_assumption_brings_it_far_off(stones, words):
    assert off("alonso", stones, (-1.0, 1.0), measured_stores.STONES[words]) < 0.06 * STONES_RANGE
