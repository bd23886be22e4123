"""Blower, heater and returned air: curves, limits, and an energy balance that closes."""

from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st

from porousmold.laws.air_supply import AirSupply, Blower, temperature_of
from porousmold.laws.material_library import FLUIDS

CURVE = Blower((0.0, 0.05, 0.1), (20e3, 15e3, 4e3), 1.2, 1e5, 0.6)
enthalpy = FLUIDS["air"].heat_capacity.integral


def test_blower_between_and_beyond_the_points_of_its_curve():
    assert CURVE.pressure_rise(0.025, 1.2) == pytest.approx(17.5e3)
    assert CURVE.pressure_rise(0.11, 1.2) == pytest.approx(1.8e3)
    assert CURVE.pressure_rise(0.025, 0.6) == pytest.approx(8.75e3)
    assert CURVE.left_for_bed(0.05, 1.2) == pytest.approx(15e3 - 250.0)


def test_a_gas_is_compressed_and_a_liquid_is_not():
    """As if it kept its density, air took 30 and 55 % too much for 1 and 2 times the pressure it is drawn at."""
    water, air = FLUIDS["water"], FLUIDS["air"]
    pump = Blower((0.0, 0.1), (1e5, 1e5), float(water.density(1e5, 293.15)), 0.0, 0.6)
    assert pump.power(water, 0.05, 1e5, 293.15) == pytest.approx(1e5 * 0.05 / 0.6)
    for rise in (10.0, 1e5, 2e5):
        blower = Blower((0.0, 0.1), (rise, rise), float(air.density(1e5, 293.15)), 0.0, 0.6)
        heated = (1.0 + rise / 1e5) ** (0.4 / 1.4) - 1.0
        compressed = 1e5 * 0.05 / 0.6 * 3.5 * heated
        assert blower.power(air, 0.05, 1e5, 293.15) == pytest.approx(compressed, rel=3e-3)


@given(
    set_point=st.floats(300.0, 480.0),
    outlet=st.floats(280.0, 480.0),
    returned=st.floats(0.0, 1.0),
    limit=st.one_of(st.just(inf), st.floats(0.0, 2e4)),
    conductance=st.floats(0.0, 50.0),
    blower=st.floats(0.0, 2e3),
)
def test_what_heater_and_blower_give_is_taken_by_bed_exhaust_and_duct(
    set_point, outlet, returned, limit, conductance, blower
):
    mass_flow = 0.08
    found = AirSupply(limit, 293.15, conductance).supplied(
        FLUIDS["air"], mass_flow, mass_flow * enthalpy(outlet), set_point, returned, blower
    )
    bed = mass_flow * (enthalpy(found.temperature) - enthalpy(outlet))
    assert found.heater + blower == pytest.approx(bed + found.exhaust + found.duct_loss, abs=1e-5)
    assert 0.0 <= found.heater <= limit
    if found.temperature < set_point - 1e-9:
        assert found.heater == pytest.approx(limit)
    if found.temperature > set_point + 1e-9:
        assert found.heater == 0.0


def test_an_unlimited_heater_gives_the_set_point_itself():
    found = AirSupply(inf, 293.15, 0.0).supplied(FLUIDS["air"], 0.1, 0.1 * enthalpy(310.0), 363.15, 0.0, 0.0)
    assert found.temperature == 363.15
    assert found.heater == pytest.approx(0.1 * (enthalpy(363.15) - enthalpy(293.15)))


def test_a_long_duct_brings_the_air_to_the_surroundings():
    supply = AirSupply(0.0, 293.15, 1e6)
    found = supply.supplied(FLUIDS["air"], 0.1, 0.1 * enthalpy(400.0), 363.15, 1.0, 0.0)
    assert found.temperature == pytest.approx(293.15)
    assert temperature_of(FLUIDS["air"], enthalpy(333.3), 300.0) == pytest.approx(333.3)
