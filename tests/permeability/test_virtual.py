"""Virtual experiments against the statements of section 4.7.2."""

import numpy as np
import pytest

from porousmold.permeability.virtual import ReadingErrors, accuracy, measurable_range, virtual_test

from .test_falling_head import PRINTED, SILICONE, WATER

EXACT = ReadingErrors(initial_head=0.0, scale_resolution=0.0)


def deviation(setup, permeability, reading_error):
    """Relative error of k where only h0 is read wrong."""
    return virtual_test(
        setup, permeability, EXACT, np.random.default_rng(1), believed_head=setup.initial_head + reading_error
    )


@pytest.mark.parametrize("sign", [-1, 1])
def test_a_wrong_reading_of_h0_spoils_water_but_not_silicone_oil(sign):
    """Figure 4.11 at 1e-8 m2: about 40 % with water, below 0.5 % with silicone oil; nothing at 1e-10 m2."""
    error = sign * PRINTED["reading_error"]
    assert 0.2 < abs(deviation(WATER, 1e-8, error)) < 0.9
    assert abs(deviation(SILICONE, 1e-8, error)) < 0.005
    for liquid in (WATER, SILICONE):
        assert abs(deviation(liquid, 1e-10, error)) < 0.01


def test_without_errors_nothing_is_wrong():
    found = accuracy(SILICONE, 1e-8, EXACT, samples=3)
    assert abs(found.bias) < 1e-3 and found.error < 1e-3 and found.failed == 0.0


def test_every_error_adds_and_the_viscosity_s_passes_through():
    """k is proportional to the viscosity that is believed."""
    only = accuracy(SILICONE, 1e-9, ReadingErrors(0.0, 0.0, viscosity=0.02), samples=400)
    assert only.error == pytest.approx(1.96 * 0.02, rel=0.15)
    none, some = (accuracy(SILICONE, 1e-7, ReadingErrors(head, 0.0), samples=100).error for head in (0.0, 1e-3))
    assert some > 10.0 * none


def test_the_range_ends_where_the_set_up_outweighs_the_bed():
    """Silicone oil measures a hundred times more permeable beds than water (the article's claim)."""
    grid = 10.0 ** np.arange(-11.0, -5.9, 0.25)
    ends = {}
    for name, liquid in (("water", WATER), ("silicone", SILICONE)):
        found = [accuracy(liquid, k, ReadingErrors(), samples=40) for k in grid]
        ends[name] = measurable_range(found, 0.05, 1e9)[1]
        errors = [a.error for a in found]
        assert errors[-1] > errors[len(errors) // 2]
    assert 30.0 < ends["silicone"] / ends["water"] < 1000.0
    assert measurable_range(found, 1e-9, 1e9) is None
