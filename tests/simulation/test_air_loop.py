"""Tools supplied by a blower, a heater and returned air: limits that are known, balances, restart, ranks."""

import json

import numpy as np
import pytest
from mpi4py import MPI
from scipy.integrate import trapezoid

from porousmold import InputError, Scene, run
from porousmold.simulation.air_loop_spec import blower_of
from porousmold.simulation.running import RunInterrupted
from porousmold.simulation.specs import specs_of

from ..support import ALUMINIUM, STUDIES, coarse_scene, simulation_of

BLOWER = {
    "operation.pressure_drop": None,
    "operation.blower_pressure": "20 kPa",
    "operation.blower_flow": "400 m^3/h",
    "operation.duct_resistance": 1e5,
}
LOOP = {"operation.recirculation": 0.7, "operation.heater_power": "3 kW", "operation.duct_conductance": "15 W/K"}


def summary_of(changes):
    return run(coarse_scene(ALUMINIUM, changes), communicator=MPI.COMM_SELF)


def test_an_unlimited_heater_without_return_is_a_given_inlet_temperature():
    given = summary_of({})
    heated = summary_of({"operation.recirculation": 0.0})
    assert heated.heating_time == pytest.approx(given.heating_time, rel=1e-10)
    assert heated["outlet_temperature"] == pytest.approx(np.array(given["outlet_temperature"]), rel=1e-10)


def test_full_return_without_losses_heats_bed_and_wall_alone():
    energy = summary_of({"operation.recirculation": 1.0, "operation.heater_power": "2 kW"}).summary["energy"]
    assert energy["exhaust"] == energy["return_duct"] == 0.0
    assert energy["heater"] == pytest.approx(energy["fluid"] + energy["beads"] + energy["wall"], rel=1e-4)
    assert energy["peak_power"] == pytest.approx(2000.0)


def test_a_loop_with_everything_balances():
    result = summary_of({**BLOWER, **LOOP, "solver.step_refinement": 2.0})
    energy = result.summary["energy"]
    assert abs(energy["loop_imbalance"]) < 1e-4 and abs(result.summary["energy_imbalance"]) < 1e-4
    lost = energy["exhaust"] + energy["return_duct"]
    kept = energy["fluid"] + energy["wall"] + energy["beads"]
    assert energy["spent"] == pytest.approx(kept + lost, rel=2e-4)
    # the powers' history gives the same as the stages
    time, power = (np.array(result[name]) for name in ("time", "heater_power"))
    assert trapezoid(power, time) == pytest.approx(energy["heater"], rel=0.01)
    assert np.max(power) == pytest.approx(3000.0)
    inlet = np.array(result["inlet_temperature"])
    assert inlet[0] < 350.0 and np.max(inlet) == inlet[-1] == pytest.approx(363.15)


def test_energy_and_cost_are_those_up_to_the_answer_not_to_the_end_of_its_step():
    """They follow a margin that moves the answer within one step, and longer steps cost the same."""
    supply = {"operation.heater_power": "5 kW", "operation.recirculation": 0.0, "operation.energy_price": 0.3}
    late, early = (summary_of({**supply, "operation.heating_margin": margin}) for margin in (9.0, 9.2))
    coarse = summary_of({**supply, "operation.heating_margin": 9.0, "solver.step_refinement": 0.25})
    assert late.summary["energy"]["until"] == late.heating_time > early.heating_time
    power = late.summary["energy"]["peak_power"]  # the heater's power is steady
    spent = [result.summary["energy"]["spent"] for result in (late, early, coarse)]
    assert spent[0] - spent[1] == pytest.approx(power * (late.heating_time - early.heating_time), rel=1e-6)
    assert spent[2] / coarse.heating_time == pytest.approx(spent[0] / late.heating_time, rel=1e-3)
    assert late.summary["energy"]["cost"] == pytest.approx(0.3 * spent[0] / 3.6e6, rel=1e-12)


def test_the_flow_stays_at_the_blowers_operating_point():
    changes = {**BLOWER, "solver.flow_tolerance": 1e-3}
    simulation = simulation_of(coarse_scene(ALUMINIUM, changes), MPI.COMM_SELF).integrate()
    history = simulation.recorder.history
    fluid, pressure = simulation.specs.laws.fluid, simulation.specs.flow.outlet_pressure
    blower = blower_of(coarse_scene(ALUMINIUM, changes), fluid)
    cold = fluid.density(pressure, simulation.specs.heat.initial_temperature)
    given = [blower.left_for_bed(2.0 * flow / cold, cold) for flow in history["mass_flow"]]
    assert history["pressure_drop"][10:] == pytest.approx(given[10:], rel=1e-3)
    assert history["mass_flow"][-1] < 0.95 * history["mass_flow"][0]  # warm air meets more resistance


def test_the_blower_of_a_hot_tool_draws_hot_air_from_the_start():
    """It drew fresh air at 0 s: 34 % too much flow, and a first step of half of it."""
    hot = {"operation.initial_temperature": "180 degC", "operation.inlet_temperature": "190 degC"}
    hot |= {"operation.fresh_temperature": "15 degC", "operation.heater_power": "9 kW", "operation.end_time": 60.0}
    result = summary_of({**BLOWER, **LOOP, **hot, "operation.recirculation": 0.9})
    for name in ("mass_flow", "pressure_drop", "blower_power"):
        assert result[name] == pytest.approx(np.full(len(result[name]), result[name][0]), rel=0.01)


@pytest.mark.parametrize("flow", ["developed", "plug"])
def test_a_blower_has_a_column_of_what_it_draws_beside_an_upright_bed(flow):
    """A cold bed flows as it does lying, a hot one blown upwards like a chimney, blown downwards less."""
    upright = {**BLOWER, "operation.blower_pressure": "100 Pa", "operation.duct_resistance": 0.0, "model.flow": flow}
    upright |= {"operation.end_time": 1e-3, "solver.flow_tolerance": 1e-4, "model.turbulence": "none"}
    hot = {
        "operation.initial_temperature": 550.0,
        "operation.inlet_temperature": 560.0,
        "operation.heater_power": "9 kW",
    }
    hot |= {"operation.fresh_temperature": 300.0}
    cold = [summary_of({**upright, "operation.gravity": gravity}) for gravity in (0.0, 9.81, -9.81)]
    flows = [result.summary["mass_flow_initial"] for result in cold]
    assert flows == pytest.approx([flows[0]] * 3, rel=1e-3)
    lying, down, up = (summary_of({**upright, **hot, "operation.gravity": gravity}) for gravity in (0.0, 9.81, -9.81))
    fluid = specs_of(coarse_scene(ALUMINIUM, upright)).laws.fluid
    columns = [9.81 * 1.0 * float(fluid.density(101325.0, warm)) for warm in (300.0, 550.0)]
    for result, sign in ((lying, 0.0), (down, -1.0), (up, 1.0)):
        drop, volume = result["pressure_drop"][0], 2.0 * result["mass_flow"][0] / float(fluid.density(101325.0, 300.0))
        given = 100.0 * (1.0 - (volume / (400.0 / 3600.0)) ** 2)
        assert drop - sign * columns[0] == pytest.approx(given, rel=5e-3)
    driven = [100.0 + sign * (columns[0] - columns[1]) for sign in (-1.0, 1.0)]
    assert down.summary["mass_flow_initial"] < lying.summary["mass_flow_initial"] < up.summary["mass_flow_initial"]
    ratio = up.summary["mass_flow_initial"] / down.summary["mass_flow_initial"]
    assert 1.0 + 0.5 * (driven[1] / driven[0] - 1.0) < ratio < driven[1] / driven[0]


@pytest.mark.slow
def test_what_beads_and_wall_gain_counts_from_the_state_that_a_run_began_with(tmp_path):
    """It counted from the state's mean temperature: after 2 s the wall had lost 63 Wh."""
    supply = {**LOOP, "operation.end_time": 200.0, "output.pictures": False, "model.flow": "plug"}
    begun = coarse_scene(ALUMINIUM, supply | {"solver.refine_in_doubt": False})
    run(begun, tmp_path / "first", MPI.COMM_SELF)
    more = {"operation.initial_temperature": None, "operation.initial_state": str(tmp_path / "first")}
    with pytest.raises(InputError, match=r"operation\.fresh_temperature"):
        begun.changed(more)
    again = begun.changed(more | {"operation.fresh_temperature": 293.15, "operation.end_time": 100.0})
    summary = run(again, communicator=MPI.COMM_SELF).summary
    energy = summary["energy"]
    gained = energy["wall"] + energy["beads"]
    assert gained == pytest.approx(
        energy["share"] * summary["heat_stored"], rel=2e-3
    )  # a gas has next to nothing of it
    assert abs(energy["fluid"]) < 2e-3 * gained


def test_the_heat_in_a_liquid_is_among_the_uses():
    """A pump, a heater and returned water: half of the heat was in none of the parts."""
    water = {
        "fluid.material": "water",
        "operation.inlet_temperature": 350.0,
        "model.flow": "plug",
        "model.turbulence": "none",
    }
    supply = {"operation.pressure_drop": None, "operation.mass_flow": 0.2, "operation.recirculation": 1.0}
    energy = summary_of(water | supply | {"operation.heater_power": "40 kW"}).summary["energy"]
    given = energy["heater"] + energy["blower"]
    uses = ("fluid", "wall", "beads", "exhaust", "return_duct", "outer_wall")
    assert given == pytest.approx(sum(energy[name] for name in uses), rel=1e-4)
    assert energy["fluid"] > 0.2 * given


def test_air_that_comes_back_too_warm_is_told():
    """A tool that cools: hot beads keep the returned air above its set-point, where no heater helps."""
    hot = {"operation.initial_temperature": 390.0, "operation.inlet_temperature": 310.0, "operation.end_time": 100.0}
    told = summary_of(hot | {"operation.recirculation": 0.95}).summary["warnings"]
    assert any("K above its set-point" in text for text in told)


def test_an_interrupted_run_goes_on_to_the_same_answer(tmp_path):
    scene = coarse_scene(ALUMINIUM, {**BLOWER, **LOOP})
    whole = run(scene, communicator=MPI.COMM_SELF)
    calls = iter(range(10**6))
    with pytest.raises(RunInterrupted):
        run(scene, tmp_path, MPI.COMM_SELF, stop=lambda: next(calls) > 150)
    rest = run(scene, tmp_path, MPI.COMM_SELF, resume=True)
    assert rest.heating_time == pytest.approx(whole.heating_time, rel=1e-8)
    assert rest.summary["energy"]["heater"] == pytest.approx(whole.summary["energy"]["heater"], rel=1e-8)


@pytest.mark.mpi
def test_the_workshops_mold_on_any_number_of_ranks():
    changes = {"operation.end_time": 400.0, "solver.axial_cells": 6, "solver.cell_growth": 2.0}
    scene = Scene.load(STUDIES / "mold" / "workshop.toml", changes)
    alone, together = (
        simulation_of(scene, communicator).integrate() for communicator in (MPI.COMM_SELF, MPI.COMM_WORLD)
    )
    for name in ("heater_power", "inlet_temperature", "mass_flow", "coldest_place", "lowest_skin", "cure_part"):
        assert together.recorder.history[name] == pytest.approx(alone.recorder.history[name], rel=1e-5), name


def test_air_that_the_blower_makes_too_warm_is_a_bound_like_any_other():
    """It was none: behind the first front temperatures were 31 K above the air that enters."""
    settings = {
        **{"model.flow": "plug", "operation.pressure_drop": None, "bed.bead_diameter": 1.4e-3},
        **{"operation.blower_pressure": 6e4, "operation.blower_flow": 0.5, "operation.end_time": 60.0},
        **{"operation.initial_temperature": 393.0, "operation.inlet_temperature": 450.0, "output.pictures": False},
    }
    history = run(coarse_scene(settings), communicator=MPI.COMM_SELF).history
    assert max(history["inlet_temperature"]) > 480.0
    assert max(history["highest_temperature"]) < max(history["inlet_temperature"]) + 0.2


def test_air_that_gets_colder_slowly_leaves_the_bed_its_bounds():
    """Its fall within a step raised the bound by twice that: a hot bed got 1.4 K hotter, behind the front of returned air."""
    settings = {
        **{
            "model.flow": "plug",
            "model.energy": "one-temperature",
            "model.closures": "measured",
            "model.turbulence": "none",
        },
        **{"operation.pressure_drop": None, "operation.inlet_velocity": 0.3, "operation.recirculation": 0.7},
        **{"operation.initial_temperature": 550.0, "operation.inlet_temperature": 330.0, "operation.end_time": 60.0},
        **{"model.wall": "fixed-temperature", "operation.wall_temperature": 330.0, "bed.bead_diameter": 1.5e-3},
        **{
            "solver.refine_in_doubt": False,
            "geometry.diameter": 0.021,
            "output.fields": False,
            "output.pictures": False,
        },
    }
    history = run(Scene.load(STUDIES / "pipe" / "baseline.toml", settings), communicator=MPI.COMM_SELF).history
    assert history["inlet_temperature"][-1] < 480.0
    assert max(history["highest_temperature"]) < 550.3


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"operation.blower_pressure": "20 kPa"}, "operation.pressure_drop"),
        ({**BLOWER, "operation.blower_flow": None}, "operation.blower_flow"),
        ({"operation.duct_resistance": 1e5, "operation.heater_power": 1e3}, "operation.duct_resistance"),
        ({"operation.recirculation": 1.5}, "operation.recirculation"),
        ({"operation.recirculation": 0.5, "model.flow_update": "transient"}, "model.flow_update"),
        ({"operation.energy_price": 0.3}, "operation.energy_price"),
        ({"operation.recirculation": 0.5, "operation.currency": "EUR"}, "operation.currency"),
        ({"operation.recirculation": 0.5, "operation.blower_density": 1.2}, "operation.blower_density"),
    ],
)
def test_impossible_supplies_are_refused(changes, named):
    with pytest.raises(InputError) as refused:
        coarse_scene(ALUMINIUM, changes)
    assert refused.value.key == named


def test_a_blowers_file_is_checked(tmp_path):
    for text in (
        "flow [m^3/h], pressure_rise [Pa]\n0, 1\n1, 0\n",
        "volume_flow [m^3/h], pressure_rise [Pa]\n5, 1\n6, 0\n",
    ):
        path = tmp_path / "curve.csv"
        path.write_text(text)
        with pytest.raises(InputError, match=r"operation\.blower"):
            coarse_scene(ALUMINIUM, {"operation.pressure_drop": None, "operation.blower": str(path)})


def test_a_curve_that_rises_first_has_an_operating_point(tmp_path):
    path = tmp_path / "curve.csv"
    path.write_text("volume_flow [m^3/h], pressure_rise [Pa]\n0, 1000\n200, 1200\n600, 0\n")
    changes = {"operation.pressure_drop": None, "operation.blower": str(path), "operation.end_time": 20.0}
    assert 900.0 < summary_of(changes)["pressure_drop"][-1] < 1250.0


def test_the_summary_is_json(tmp_path):
    run(coarse_scene(ALUMINIUM, {**BLOWER, **LOOP, "operation.end_time": 20.0}), tmp_path, MPI.COMM_SELF)
    assert json.loads((tmp_path / "result.json").read_text())["energy"]["share"] == 2.0


def test_a_pumps_curve_holds_at_the_density_of_its_liquid():
    """A pump of 500 Pa gives no more, whatever its liquid weighs; a density of air for it is refused."""
    pump = {"operation.pressure_drop": None, "operation.blower_pressure": 500.0, "operation.blower_flow": "3 m^3/h"}
    pump |= {"fluid.material": "water", "model.flow": "plug", "model.turbulence": "none", "operation.end_time": 20.0}
    result = run(coarse_scene(ALUMINIUM, pump), communicator=MPI.COMM_SELF)
    assert 10.0 < np.max(result["pressure_drop"]) < 500.0
    with pytest.raises(InputError, match=r"operation\.blower_density = 1\.2: .* 83\d times the pressure of its curve"):
        run(coarse_scene(ALUMINIUM, pump | {"operation.blower_density": 1.2}), communicator=MPI.COMM_SELF)
