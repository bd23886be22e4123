"""Phases of the library's fluids against published states."""

import pytest

from porousmold import InputError, run
from porousmold.laws.phases import PHASES, departure, other_phase

from ..support import coarse_scene


@pytest.mark.parametrize(
    ("name", "pressure", "temperature"),
    [  # normal boiling points (Poling, Prausnitz, O'Connell), and steam tables
        ("nitrogen", 101325.0, 77.35),
        ("argon", 101325.0, 87.28),
        ("air", 101325.0, 80.2),
        ("water", 101325.0, 373.12),
        ("water", 1e6, 453.03),
        ("steam", 1e5, 372.76),
        ("steam", 10.13e5, 453.6),
    ],
)
def test_boiling_points(name, pressure, temperature):
    assert PHASES[name].boiling_temperature(pressure) == pytest.approx(temperature, rel=0.03 if name == "air" else 0.01)


@pytest.mark.parametrize(
    ("name", "pressure", "temperature", "factor"),
    [  # compressibility factors of air and argon (Perry), carbon dioxide, steam and helium (NIST)
        ("air", 1e5, 300.0, 0.9999),
        ("air", 60e5, 300.0, 0.9901),
        ("argon", 100e5, 300.0, 0.946),
        ("carbon_dioxide", 10e5, 300.0, 0.949),
        ("steam", 1e5, 400.0, 0.990),
        ("helium", 90e5, 300.0, 1.0426),
    ],
)
def test_departure_from_the_ideal_gas(name, pressure, temperature, factor):
    assert 1.0 + departure(name, pressure, temperature) == pytest.approx(factor, abs=0.016)


def test_other_phases():
    assert other_phase("water", 101325.0, 360.0) is None and other_phase("steam", 101325.0, 380.0) is None
    assert "boils at 100.0 °C" in (other_phase("water", 101325.0, 380.0) or "")
    assert "condenses" in (other_phase("steam", 5e5, 400.0) or "")
    assert other_phase("water", 5e5, 400.0) is None
    assert other_phase("water", 300e5, 640.0) is None  # beyond the critical pressure there is no boiling
    assert "no liquid above 373.9 °C" in (other_phase("water", 300e5, 700.0) or "")
    assert "freezes at 0 °C" in (other_phase("water", 1e5, 268.0) or "") and other_phase("water", 1e5, 274.0) is None
    assert other_phase("thermal_oil", 1e5, 900.0) is None and other_phase("own", 1e5, 300.0) is None


@pytest.mark.parametrize(
    ("settings", "key"),
    [
        ({"fluid.material": "water", "operation.inlet_temperature": "110 degC"}, "inlet_temperature"),
        ({"fluid.material": "steam", "operation.inlet_temperature": "150 degC"}, "initial_temperature"),
        ({"fluid.material": "water", "operation.initial_temperature": "-5 degC"}, "initial_temperature"),
        (
            {  # at the inlet's pressure, 1.6 bar, steam condenses at 113.7 degC
                **{"fluid.material": "steam", "operation.initial_temperature": "102 degC"},
                **{"operation.inlet_temperature": "160 degC", "operation.pressure_drop": "60 kPa"},
            },
            "initial_temperature",
        ),
    ],
)
def test_a_fluid_of_another_phase_is_refused(settings, key):
    with pytest.raises(InputError, match=rf"operation\.{key} = .* does not fit fluid\.material"):
        run(coarse_scene(settings | {"model.turbulence": "none", "model.flow": "plug"}))


def test_a_gas_that_is_not_ideal_is_warned_of():
    given = {
        "model.turbulence": "none",
        "model.flow": "plug",
        "operation.end_time": 20.0,
        "fluid.material": "carbon_dioxide",
    }
    warnings = run(coarse_scene(given | {"operation.outlet_pressure": "10 bar"})).summary["warnings"]
    assert any("carbon_dioxide is no ideal gas at 10" in warning and "more" in warning for warning in warnings)
    warnings = run(coarse_scene(given)).summary["warnings"]
    assert not any("ideal" in warning for warning in warnings)


def test_therminol_vp1_boils_as_its_supplier_says():
    """257 degC at 1 bar; vapour pressures of CoolProp's fit (INCOMP::TVP1) at 560 and 650 K, 5 %."""
    phase = PHASES["therminol_vp1"]
    assert phase.boiling_temperature(101325.0) == pytest.approx(257.0 + 273.15, abs=1.0)
    assert phase.saturation_pressure(560.0) == pytest.approx(1.868e5, rel=0.05)
    assert phase.saturation_pressure(650.0) == pytest.approx(8.046e5, rel=0.05)
