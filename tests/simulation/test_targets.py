"""When a target is met, on histories whose answer is known."""

import numpy as np
import pytest

from porousmold.simulation.targets import Target

TIMES = np.linspace(0.0, 400.0, 81)


def first_time(target, **columns):
    """When a march along these columns meets the target."""
    for rows in range(1, len(TIMES) + 1):
        found = target.time({name: list(values[:rows]) for name, values in {"time": TIMES, **columns}.items()})
        if found is not None:
            return found
    return None


def target(asks, limit, **others):
    return Target(name="t", place="wall", asks=asks, limit=limit, initial=300.0, final=400.0, **others)


def approach(delay=0.0, scale=80.0):
    """A temperature that goes from 300 to 400 K."""
    return 400.0 - 100.0 * np.exp(-np.maximum(TIMES - delay, 0.0) / scale)


@pytest.mark.parametrize(
    ("asks", "limit", "expected"),
    [
        ("within", 5.0, 80.0 * np.log(20.0)),
        ("above", 390.0, 80.0 * np.log(10.0)),
        ("above", 399.5, 80.0 * np.log(200.0)),
        ("below", 410.0, 0.0),
    ],
)
def test_an_exponential_approach(asks, limit, expected):
    columns = {"lowest_wall": approach(), "highest_wall": approach()}
    found = first_time(target(asks, limit), **columns)
    assert (found is None and expected > TIMES[-1]) or found == pytest.approx(expected, abs=1e-6)


def test_a_spread_counts_from_half_way_on():
    low, high = approach(delay=40.0), approach()
    found = first_time(target("spread", 10.0), lowest_wall=low, highest_wall=high)
    exact = 80.0 * np.log(10.0 * (np.exp(0.5) - 1.0))  # difference 100 exp(-t/80) (exp(1/2) - 1)
    assert found == pytest.approx(exact, rel=1e-6)


def test_a_place_that_follows_a_ramp_is_within_near_its_end():
    ramp = np.minimum(300.0 + TIMES, 400.0)
    assert first_time(target("within", 5.0), lowest_wall=ramp - 1.0, highest_wall=ramp) == pytest.approx(96.0, abs=0.5)


def test_a_programme_that_cools_down_again():
    """Below a temperature counts after it was above, a spread from half-way to the hottest set-point on."""
    there = 300.0 + 0.5 * np.minimum(TIMES, 400.0 - TIMES)
    columns = {"lowest_wall": there - 1.0, "highest_wall": there + 1.0}
    assert first_time(target("below", 350.0), **columns) == pytest.approx(302.0, abs=0.2)
    assert first_time(target("spread", 5.0), **columns) == pytest.approx(100.0, abs=5.0)


def test_a_cure_and_a_place_that_gets_hotter_than_the_inlet():
    found = first_time(target("cured", 0.8), cure_wall=1.0 - np.exp(-TIMES / 50.0))
    assert found == pytest.approx(50.0 * np.log(5.0), rel=1e-6)
    hot = 300.0 + 0.5 * TIMES
    assert first_time(target("above", 450.0), lowest_wall=hot, highest_wall=hot) == pytest.approx(300.0)
    assert first_time(target("above", 600.0), lowest_wall=hot, highest_wall=hot) is None
