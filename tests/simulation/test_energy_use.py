"""What heating costs, against integrals done by hand."""

from dataclasses import replace

import numpy as np
import pytest

from porousmold import run
from porousmold.laws.material_library import FLUIDS
from porousmold.simulation.energy_use import energy_use

from ..support import coarse_scene, liquid

FLUID = liquid(density=1000.0, heat_capacity=4000.0)
START = {"outlet_pressure": 1e5, "initial_temperature": 298.15}


def test_heat_and_work_are_the_integrals_up_to_the_heating_time():
    time = np.array([0.0, 10.0, 30.0, 60.0])
    history = {
        "time": time,
        "mass_flow": 0.1 + 0.01 * time,  # linear: the trapezoidal rule is exact
        "pressure_drop": np.full(4, 5e3),
        "inlet_temperature": np.full(4, 308.15),
    }
    used = energy_use(history, FLUID, **START, end=30.0)
    mass = 0.1 * 30.0 + 0.005 * 30.0**2
    assert used["fluid_heat"] == pytest.approx(mass * 4000.0 * 10.0)
    assert used["pumping_work"] == pytest.approx(mass * 5e3 / 1000.0)
    assert used["mean_power"] * 30.0 == pytest.approx(used["energy_spent"])
    assert used["energy_spent"] == pytest.approx(used["fluid_heat"] + used["pumping_work"])
    whole = energy_use(history, FLUID, **START)
    assert whole["fluid_heat"] == pytest.approx((0.1 * 60.0 + 0.005 * 60.0**2) * 4000.0 * 10.0)


def test_a_step_from_where_a_phase_ends_has_the_rate_of_the_new_one():
    history = {
        "time": np.array([0.0, 100.0, 110.0, 200.0]),
        "mass_flow": np.array([0.0, 0.0, 1.0, 1.0]),  # at rest, then 1 kg/s
        "pressure_drop": np.array([0.0, 0.0, 5e3, 5e3]),
        "inlet_temperature": np.full(4, 308.15),
    }
    used = energy_use(history, FLUID, **START, jumps=[100.0])
    assert used["fluid_heat"] == pytest.approx(100.0 * 4000.0 * 10.0)
    assert used["pumping_work"] == pytest.approx(100.0 * 5e3 / 1000.0)


def test_cooling_costs_the_cold():
    history = {
        "time": [0.0, 1.0],
        "mass_flow": [1.0, 1.0],
        "pressure_drop": [0.0, 0.0],
        "inlet_temperature": [288.15] * 2,
    }
    assert energy_use(history, FLUID, **START)["fluid_heat"] == pytest.approx(4000.0 * 10.0)


def test_energy_of_a_target_is_that_up_to_it_and_not_to_the_end_of_its_step():
    """With the flow given, heat and work are proportional to the target's time: sensitivities had the wrong sign."""
    given = {
        "operation.pressure_drop": None,
        "operation.mass_flow": 0.02,
        "model.flow": "plug",
        "model.turbulence": "none",
    }
    found = [
        run(coarse_scene(given | {"target": [{"name": "warm", "place": "wall", "above": above}]})).summary
        for above in (330.0, 331.0, 334.0)
    ]
    powers = [one["fluid_heat"] / one["targets"]["warm"] for one in found]
    assert powers == pytest.approx([powers[0]] * 3, rel=1e-3)


def test_a_gas_is_compressed_by_its_pumping_work():
    """At twice the pressure the enthalpy of isentropic expansion from the inlet: the drop over its density is 21 % less."""
    fluid = replace(FLUIDS["air"], heat_capacity=1005.0)
    history = {
        "time": [0.0, 10.0],
        "mass_flow": [0.1, 0.1],
        "pressure_drop": [1e5, 1e5],
        "inlet_temperature": [400.0, 400.0],
    }
    specific = 2e5 / float(fluid.density(2e5, 400.0)) / 400.0
    exact = 1.0 * 1005.0 * 400.0 * (1.0 - 0.5 ** (specific / 1005.0))
    used = energy_use(history, fluid, outlet_pressure=1e5, initial_temperature=298.15)
    assert used["pumping_work"] == pytest.approx(exact, rel=1e-9)
    assert exact > 1.2 * 1e5 / float(fluid.density(2e5, 400.0))
    back = energy_use(
        history | {"mass_flow": [-0.1, -0.1], "pressure_drop": [-1e5, -1e5]},
        fluid,
        outlet_pressure=1e5,
        initial_temperature=298.15,
    )
    assert back["pumping_work"] == pytest.approx(exact, rel=1e-9)
