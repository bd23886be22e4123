"""A fluidised bed: its velocities, and temperatures of bed and wall against the exact solution of two bodies."""

import json
import math
import tomllib

import numpy as np
import pytest
from scipy.linalg import expm

from porousmold import InputError, Scene
from porousmold.cli import main
from porousmold.fluidised.model import FluidisedBed

from ..support import FIELD_CASES, STUDIES

SCENE = STUDIES / "beds" / "fluidised.toml"
CONSTANT = {
    "bed.bead_density": 2600.0,
    "bed.bead_heat_capacity": 800.0,
    "bed.bead_conductivity": 1.0,
    "wall.density": 7800.0,
    "wall.heat_capacity": 480.0,
    "wall.conductivity": 50.0,
    "fluid.density": 0.8,
    "fluid.viscosity": 2.5e-5,
    "fluid.heat_capacity": 1010.0,
    "fluid.conductivity": 0.035,
}


def test_two_bodies_warm_up_as_the_exponential_of_their_matrix():
    bed = FluidisedBed(Scene.load(SCENE, CONSTANT))
    state, (summary, history) = bed.state(0.0, 450.0), bed.integrate()
    beads = math.pi * 0.075**2 * 0.4 * 0.58 * 2600.0 * 800.0
    beads += math.pi * 0.075**2 * (state.height - 0.4 * 0.58) * 0.8 * 1010.0  # the gas in the voids
    wall = math.pi * (0.15 + 0.004) * 0.004 * state.height * 7800.0 * 480.0
    film = state.wall_coefficient * math.pi * 0.15 * state.height
    gas = 0.009 * 1010.0 * -math.expm1(-state.transfer_units)
    matrix = np.array([[-(gas + film) / beads, film / beads], [film / wall, -film / wall]])
    time = summary["heating_time"]
    missing = expm(matrix * time) @ [160.0, 160.0]
    # with constant density the coefficient hardly depends on the temperature: l does
    assert missing[1] == pytest.approx(2.0, rel=0.02)
    assert abs(summary["energy_imbalance"]) < 1e-6
    assert history["wall_temperature"][-1] == pytest.approx(453.15 - 2.0, abs=1e-6)


def test_faster_gas_expands_the_bed_and_heats_sooner():
    slow, fast = (
        FluidisedBed(Scene.load(SCENE, {"operation.mass_flow": flow})).integrate()[0] for flow in (0.006, 0.012)
    )
    assert fast["porosity"] > slow["porosity"] > 0.42 and fast["height"] > slow["height"] > 0.4
    assert fast["heating_time"] < slow["heating_time"]
    assert fast["pressure_drop"] == slow["pressure_drop"] == pytest.approx(0.58 * 0.4 * 9.80665 * 2600.0, rel=0.05)


def test_beads_in_a_liquid_are_lighter_by_their_buoyancy_and_store_less_heat_than_it():
    """Alumina beads in water: (1-phi)(rho_s - rho) g H = 14.9 kPa, not 20.6; the water takes most of the heat."""
    bed = FluidisedBed(Scene.load(FIELD_CASES / "16-fluidised" / "fb.toml"))
    summary, _ = bed.integrate()
    assert summary["minimum_fluidisation_velocity"] == pytest.approx(0.0526, rel=2e-3)
    density = bed._laws.fluid.density(101325.0, 333.15)
    assert summary["pressure_drop"] == pytest.approx(0.585 * (3586.0 - density) * 9.80665, rel=1e-6)
    assert summary["pressure_drop"] == pytest.approx(14937.0, rel=0.01)  # of cold water
    beads = math.pi * 0.05**2 * 0.585 * 3586.0 * 880.0 * 40.0
    assert summary["heat_stored"] > 2.5 * beads
    assert abs(summary["energy_imbalance"]) < 1e-6
    assert any("is a liquid" in text for text in summary["warnings"])


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"operation.mass_flow": 0.0005}, "which lifts the beads"),
        ({"operation.mass_flow": 0.5}, "carries them away"),
        ({"operation.mass_flow": None, "operation.pressure_drop": "1 kPa"}, "operation.inlet_velocity"),
        ({"model.wall": "insulated"}, "model.wall"),
        ({"operation.outer_heat_flux": -100.0}, "outer_heat_flux.*no effect"),
        ({"model.bead_modes": 2}, "bead_modes.*no effect"),
        (
            {"fluid.material": "water", "operation.inlet_temperature": 350.0, "bed.bead_density": 500.0},
            "these beads float",
        ),
        ({"fluid.material": "steam"}, "steam condenses"),
    ],
)
def test_what_is_no_fluidised_bed_is_refused(settings, words):
    with pytest.raises(InputError, match=words):
        FluidisedBed(Scene.load(SCENE, settings)).integrate()


def test_gas_that_becomes_warm_at_once_heats_as_gas_that_is():
    """Its velocity was that of the cold gas, its density that of the warm: 54 % too much of it."""
    given = {"operation.mass_flow": None, "operation.inlet_velocity": 0.9}
    steps = {"operation.inlet_temperature": ([0.0, 1.0], [293.15, 453.15])}
    found = [FluidisedBed(Scene.load(SCENE, given | more)).integrate()[0] for more in ({}, steps)]
    assert found[1]["velocity"] == pytest.approx(found[0]["velocity"], rel=1e-9)
    assert found[1]["heating_time"] == pytest.approx(found[0]["heating_time"], abs=2.0)


def test_large_beads_are_warned_of():
    scene = Scene.load(SCENE, {"bed.bead_diameter": "5 mm", "operation.mass_flow": "0.06 kg/s"})
    assert any("outside 0.05 to 3 mm" in text for text in FluidisedBed(scene).integrate()[0]["warnings"])


def test_the_command_writes_result_history_and_picture(tmp_path, capsys):
    assert main(["fluidised", str(SCENE), "--out", str(tmp_path)]) == 0
    told = capsys.readouterr().out
    summary = json.loads((tmp_path / "result.json").read_text())
    assert f"{summary['heating_time']:.1f} s" in told and (tmp_path / "temperatures.png").is_file()
    head = (tmp_path / "history.csv").read_text().splitlines()[0]
    assert head == "time [s],inlet_temperature [K],bead_temperature [K],wall_temperature [K]"
    assert main(["fluidised", str(SCENE), "--set", "operation.mass_flow=0.0001", "--out", str(tmp_path / "no")]) == 2
    assert capsys.readouterr().err.count("\n") == 1 and not (tmp_path / "no").exists()


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"operation.gravity": 9.81}, "operation.gravity"),
        ({"model.drag_factor": 2.0}, "model.drag_factor"),
        ({"solver.axial_cells": 40}, "solver.axial_cells"),
        ({"operation.outer_heat_flux": 100.0}, "operation.outer_heat_flux"),
    ],
)
def test_keys_without_effect_are_refused(changes, word):
    with pytest.raises(InputError, match=f"{word} = .*no effect on a fluidised bed"):
        FluidisedBed(Scene.load(SCENE, changes))


def test_a_source_in_a_layer_and_a_cure_are_refused():
    scene = tomllib.loads(SCENE.read_text())
    layer = {"material": "carbon_steel", "thickness": "4 mm", "heat_source": 5e6}
    with pytest.raises(InputError, match=r"wall.layer\[1\].heat_source .*no effect on a fluidised bed"):
        FluidisedBed(Scene(scene | {"wall": {"layer": [layer]}}))


RAMP = ([0.0, 3200.0, 8600.0], ["20 degC", "180 degC", "180 degC"])
DIP = ([0.0, 3000.0, 3600.0, 20000.0], ["180 degC", "180 degC", "60 degC", "60 degC"])


def wall_by_small_steps(bed, end):
    """Temperatures (K) of the wall by steps of 2 s of the same rates (Heun)."""
    height, state = bed.integrate()[0]["height"], np.array([293.15, 293.15])
    walls = [state[1]]
    for number in range(int(end / 2.0)):
        first = bed._rates(2.0 * number, state, height)[0]
        second = bed._rates(2.0 * number + 2.0, state + 2.0 * first, height)[0]
        state = state + first + second
        walls.append(state[1])
    return np.array(walls)


def test_a_ramp_that_begins_at_the_walls_temperature_does_not_count_as_heated():
    """When the wall lags by no more than 2 K behind the set-point at its end, not when that leaves it behind."""
    bed = FluidisedBed(Scene.load(SCENE, {"operation.inlet_temperature": RAMP}))
    summary, _ = bed.integrate()
    walls = wall_by_small_steps(bed, 10000.0)
    reached = 2.0 * int(np.argmax(walls >= 453.15 - 2.0))
    assert summary["heating_time"] == pytest.approx(reached, abs=4.0) and reached > 3200.0
    assert abs(summary["energy_imbalance"]) < 1e-6


def test_an_inlet_that_falls_past_the_wall_heats_nothing():
    summary, history = FluidisedBed(Scene.load(SCENE, {"operation.inlet_temperature": DIP})).integrate()
    assert summary["heating_time"] > 3600.0 and history["wall_temperature"][-1] == pytest.approx(333.15, abs=2.001)


@pytest.mark.parametrize("late", [4000.0, 9000.0])
def test_nothing_is_passed_over_in_a_quiet_start(late):
    """A pulse of 160 K over ten minutes gives what the gas then has to give."""
    times = [0.0, late, late + 10.0, late + 600.0, late + 610.0]
    pulse = (times, ["20 degC", "20 degC", "180 degC", "180 degC", "20 degC"])
    bed = FluidisedBed(Scene.load(SCENE, {"operation.inlet_temperature": pulse, "operation.end_time": late + 610.0}))
    summary, history = bed.integrate()
    most = 0.009 * 1010.0 * 160.0 * 600.0
    assert 0.5 * most < summary["heat_by_fluid"] < most and abs(summary["energy_imbalance"]) < 1e-6
    walls = wall_by_small_steps(bed, late + 610.0)
    assert history["wall_temperature"][-1] == pytest.approx(walls[-1], abs=0.02)


def test_a_flow_that_changes_is_refused():
    with pytest.raises(InputError, match=r"operation\.mass_flow.*same all the time"):
        FluidisedBed(Scene.load(SCENE, {"operation.mass_flow": ([0.0, 100.0], [0.009, 0.018])}))
