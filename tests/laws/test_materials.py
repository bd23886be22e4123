"""Property laws: values, integrals, sources."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from porousmold.laws.materials import ACRYLIC, AIR, SOLIDS


def test_air_at_300_kelvin():
    """Textbook values (Incropera, table A.4): 1.846e-5 Pa s, 0.0263 W/m/K, 1007 J/kg/K, 1.161 kg/m3."""
    assert AIR.viscosity(300.0) == pytest.approx(1.846e-5, rel=5e-3)
    assert AIR.conductivity(300.0) == pytest.approx(0.0263, rel=2.5e-2)
    assert AIR.heat_capacity(300.0) == pytest.approx(1007.0, rel=5e-3)
    assert AIR.density(101325.0, 300.0) == pytest.approx(1.177, rel=1e-3)


@given(temperature=st.floats(250.0, 400.0))
def test_enthalpy_is_the_integral_of_the_heat_capacity(temperature):
    for law in (AIR.heat_capacity, ACRYLIC.heat_capacity):
        h = 1e-3
        slope = (law.integral(temperature + h) - law.integral(temperature - h)) / (2 * h)
        assert slope == pytest.approx(law(temperature), rel=1e-7)


def test_sutherland_returns_its_reference():
    assert AIR.viscosity(273.15) == pytest.approx(1.716e-5)


def test_every_law_has_unit_source_and_range():
    for material in (AIR, *SOLIDS.values()):
        for name, law in material.laws().items():
            assert law.source and law.unit, (material.name, name)
            low, high = law.temperature_range
            assert low < 300.0 < high


def test_arrays_and_coefficients_of_any_kind():
    law = ACRYLIC.heat_capacity
    temperatures = np.array([300.0, 320.0])
    assert law(temperatures) == pytest.approx([166.95 + 4.0289 * T for T in temperatures])
    assert law.with_coefficients(c for c in law.coefficients)(310.0) == law(310.0)
