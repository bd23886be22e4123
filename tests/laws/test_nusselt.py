"""Nusselt correlations: printed forms, the `ht` package, limits."""

import ht
import numpy as np
import pytest
import ufl
from hypothesis import given
from hypothesis import strategies as st

from porousmold.laws.nusselt import NUSSELT_CORRELATIONS, bead_reynolds_number, specific_surface

ALL = sorted(NUSSELT_CORRELATIONS)


@given(re=st.floats(50.0, 8000.0), pr=st.floats(0.6, 500.0))
def test_wakao_matches_ht(re, pr):
    """ht writes Wakao and Kagei with the interstitial velocity's Reynolds number taken as ours."""
    theirs = ht.conv_packed_bed.Nu_Wakao_Kagei(re, pr)
    assert NUSSELT_CORRELATIONS["wakao"](re, pr, 0.4) == pytest.approx(theirs, rel=1e-12)


@given(re=st.floats(10.0, 1e4), phi=st.floats(0.3, 0.6))
def test_achenbach_matches_ht(re, phi):
    theirs = ht.conv_packed_bed.Nu_Achenbach(re, 0.71, phi)
    assert NUSSELT_CORRELATIONS["achenbach"](re, 0.71, phi) == pytest.approx(theirs, rel=1e-12)


@pytest.mark.parametrize(
    ("name", "re", "expected"),
    [
        # by hand from table 2.1 and eq. 2.8 at Pr = 0.7, phi = 0.4
        ("de-acetis-thodos", 100.0, 1.1 * 0.7 ** (1 / 3) * 100.0 / (100.0**0.41 - 1.5)),
        ("gupta-thodos", 100.0, 0.7 ** (1 / 3) / 0.4 * 100.0 * (0.0108 + 0.929 / (100.0**0.58 - 0.483))),
        ("resnick", 100.0, 0.922 * 0.7 ** (1 / 3) * 100.0**0.66),
        ("nsofor-adebiyi", 100.0, 8.74 + 9.34 * 3.6**0.2 * 0.7 ** (1 / 3) * 100.0**0.2),
        ("nie", 100.0, 0.052 * 0.6**0.14 / 0.4 * 0.7 ** (1 / 3) * 100.0**0.86),
        ("pen", 50.0, 0.048 * 0.6**0.3 / 0.4 * 0.7 ** (1 / 3) * 50.0**0.7),
        (
            "whitaker",
            100.0,
            (0.5 * 100.0**-0.1 * 0.6**0.5 / 0.4 + 0.2 * 100.0 ** (1 / 15) * 0.6 ** (1 / 3) / 0.4)
            * 0.7 ** (1 / 3)
            * 100.0**0.6,
        ),
    ],
)
def test_printed_forms(name, re, expected):
    assert NUSSELT_CORRELATIONS[name](re, 0.7, 0.4) == pytest.approx(expected, rel=1e-12)


def test_henry_in_its_laminar_limit():
    """Eq. 13 at vanishing Reynolds number: g -> phi^-1.8, f -> 1, Nu -> phi^-1.8 1.39^2 Pr^0.4."""
    value = NUSSELT_CORRELATIONS["henry"](1e-3, 0.7, 0.45)
    assert value == pytest.approx(0.45**-1.8 * (0.18 * 1e-3**0.5 + 1.39) ** 2 * 0.7**0.4, rel=2e-3)


@pytest.mark.parametrize("name", ALL)
def test_finite_at_rest_at_the_wall_and_beyond_and_growing_with_flow(name):
    correlation = NUSSELT_CORRELATIONS[name]
    reynolds = np.concatenate([[0.0], np.geomspace(1e-3, 1e5, 200)])
    for phi in (0.4, 0.99, 1.0):
        values = correlation(reynolds, 0.7, phi)
        assert np.all(np.isfinite(values)) and np.all(values >= 0.0)
    inside = np.geomspace(*correlation.reynolds_range, 50)
    assert np.all(np.diff(correlation(inside, 0.7, 0.4)) > 0.0)


@pytest.mark.parametrize("name", ALL)
def test_ufl_agrees_with_floats(name):
    correlation = NUSSELT_CORRELATIONS[name]
    symbolic = correlation(ufl.as_ufl(300.0), ufl.as_ufl(0.7), ufl.as_ufl(0.4))
    assert float(symbolic) == pytest.approx(correlation(300.0, 0.7, 0.4), rel=1e-12)


def test_specific_surface_is_that_of_spheres():
    """n spheres of diameter d in unit volume: surface n pi d^2, volume n pi d^3/6 = 1 - phi."""
    n, d = 1000.0, 5e-3
    assert specific_surface(1.0 - n * np.pi * d**3 / 6, d) == pytest.approx(n * np.pi * d**2)


def test_reynolds_number_is_superficial():
    assert bead_reynolds_number(0.4, 1.0, 5.0, 5e-3, 2e-5) == pytest.approx(2.0 * 5e-3 / 2e-5)


@pytest.mark.parametrize(
    ("reynolds", "ratio"),
    [(0.1, 3.15), (1.0, 2.00), (10.0, 1.07), (30.0, 0.99), (100.0, 1.09), (300.0, 1.19), (1e4, 1.06)],
)
def test_equation_13_of_henry_beside_wakao(reynolds, ratio):
    """Their fig. 2: porosity 0.45, air. The same within 20 % from Re 10 on; three times as much at Re 0.1."""
    correlations = [NUSSELT_CORRELATIONS[name](reynolds, 0.7, 0.45) for name in ("henry", "wakao")]
    assert correlations[0] / correlations[1] == pytest.approx(ratio, abs=0.006)
