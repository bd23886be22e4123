"""Real gases against published states, and what they change in a run."""

import numpy as np
import pytest
from mpi4py import MPI

from porousmold import InputError, run
from porousmold.laws.material_library import FLUIDS
from porousmold.laws.real_gas import real_gas
from porousmold.simulation.checking import check

from ..support import coarse_scene


@pytest.mark.parametrize(
    ("name", "pressure", "temperature", "factor"),
    [  # steam by IAPWS-IF97; carbon dioxide, helium and argon as in test_phases
        ("steam", 10e5, 500.0, 0.95607),
        ("steam", 15e5, 480.0, 0.91632),
        ("steam", 40e5, 600.0, 0.91094),
        ("carbon_dioxide", 10e5, 300.0, 0.949),
    ],
)
def test_compressibility_factors(name, pressure, temperature, factor):
    gas = FLUIDS[name]
    real = real_gas(gas, pressure)
    found = gas.density(pressure, temperature) / real.density(pressure, temperature)
    assert found == pytest.approx(factor, abs=2e-3)
    # the virial equation about that pressure goes to the ideal gas without it
    assert real.density(1.0, temperature) == pytest.approx(gas.density(1.0, temperature), rel=1e-5)


def test_properties_at_one_bar_are_those_of_the_library():
    for name in ("air", "nitrogen", "helium", "argon"):
        gas, real = FLUIDS[name], real_gas(FLUIDS[name], 101325.0)
        for temperature in np.linspace(300.0, 1200.0, 10):
            for law in ("viscosity", "heat_capacity", "conductivity"):
                assert getattr(real, law)(temperature) == pytest.approx(getattr(gas, law)(temperature), rel=3e-3)


@pytest.mark.parametrize(("name", "pressure"), [("water", 10e5), ("thesis_air", 10e5), ("air", 80e5), ("air", 0.5e5)])
def test_what_is_not_tabulated_is_refused(name, pressure):
    with pytest.raises(InputError, match=r"is tabulated for air|must be 1\.01 to 50 bar"):
        real_gas(FLUIDS[name], pressure)


def test_gas_under_pressure_carries_the_heat_of_the_real_one():
    """Carbon dioxide at 20 bar and 27 to 60 degC: heat capacity 13 % above that of 1 bar; so much less time at one mass flow."""
    settings = {
        **{"model.flow": "plug", "operation.pressure_drop": None, "operation.mass_flow": 0.03},
        **{"fluid.material": "carbon_dioxide", "operation.outlet_pressure": 20e5},
        **{"operation.initial_temperature": 300.0, "operation.inlet_temperature": 333.0, "output.pictures": False},
    }
    scenes = [coarse_scene(settings | {"fluid.real_gas": flag}) for flag in (False, True)]
    ideal, real = (run(scene, communicator=MPI.COMM_SELF) for scene in scenes)
    capacities = [
        fluid.heat_capacity(320.0) for fluid in (FLUIDS["carbon_dioxide"], real_gas(FLUIDS["carbon_dioxide"], 20e5))
    ]
    assert capacities[1] / capacities[0] > 1.1
    assert ideal.heating_time / real.heating_time == pytest.approx(capacities[1] / capacities[0], rel=0.03)
    assert abs(ideal.summary["energy_imbalance"]) < 1e-5
    assert abs(real.summary["energy_imbalance"]) < 5e-5  # kinks of the table within a step
    told = [" ".join(check(scene, MPI.COMM_SELF).warnings) for scene in scenes]
    assert "fluid.real_gas" in told[0] and "no ideal gas" not in told[1]
