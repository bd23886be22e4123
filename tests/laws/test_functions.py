"""The same formula for floats, arrays and UFL."""

import numpy as np
import pytest
import ufl
from hypothesis import given
from hypothesis import strategies as st

from porousmold.laws import functions

SMOOTH = [functions.exp, functions.sqrt, functions.one_minus_exp_over, functions.ln]


@pytest.mark.parametrize("function", SMOOTH)
@given(x=st.floats(1e-6, 50.0))
def test_float_array_and_ufl_agree(function, x):
    symbolic = ufl.as_ufl(x)
    assert functions.is_symbolic(symbolic) and not functions.is_symbolic(x)
    assert function(np.array([x, x]))[1] == pytest.approx(function(x), rel=1e-14)
    assert float(function(symbolic)) == pytest.approx(function(x), rel=1e-12)


@given(x=st.floats(0.0, 1e-3))
def test_series_of_one_minus_exp_over_joins_the_quotient(x):
    exact = -np.expm1(-x) / x if x > 0 else 1.0
    assert functions.one_minus_exp_over(x) == pytest.approx(exact, abs=2e-9)


@given(x=st.floats(-1e6, 1e6), width=st.floats(1e-9, 1.0))
def test_positive_part_is_positive_and_exact_far_from_zero(x, width):
    value = functions.positive_part(x, width)
    assert value > 0.0
    assert value == pytest.approx(max(x, 0.0), abs=1.01 * width)


def test_smooth_step_has_its_ends_and_zero_slopes():
    assert functions.smooth_step(800.0, 800.0, 900.0) == 0.0
    assert functions.smooth_step(900.0, 800.0, 900.0) == 1.0
    assert functions.smooth_step(850.0, 800.0, 900.0) == pytest.approx(0.5)
    h = 1e-4
    for end in (800.0, 900.0):
        slope = (functions.smooth_step(end + h, 800.0, 900.0) - functions.smooth_step(end - h, 800.0, 900.0)) / (2 * h)
        assert abs(slope) < 1e-6
