"""Flow that reverses and rests, and phases that repeat: against an independent computation, and by symmetry."""

import json

import numpy as np
import pytest
from mpi4py import MPI
from scipy.signal import lfilter

from porousmold import InputError, Scene, run
from porousmold.cli import main
from porousmold.files.xdmf import read_fields
from porousmold.scene.features.phases import phases_of
from porousmold.simulation.cycles import _cycle
from porousmold.simulation.running import RunInterrupted
from porousmold.simulation.specs import specs_of
from porousmold.simulation.time_integration import Simulation
from tests.support import FIELD_CASES, coarse_scene

STORE = FIELD_CASES / "17-tes-cycle" / "tes.toml"
HOT, COLD = 773.15, 298.15
QUIET = {"output.pictures": False, "output.fields": False}


def phases(charge="2 h", rest="1 h", discharge="2 h", **more):
    """The table of a store that is charged, waits, and is discharged."""
    return [
        {"name": "charge", "mass_flow": 0.01, "temperature": HOT, "duration": charge, **more},
        {"name": "rest", "duration": rest},
        {"name": "discharge", "mass_flow": -0.01, "temperature": COLD, "duration": discharge},
    ]


def store(given=None, **operation):
    """The store with phases, and other keys of [operation]."""
    settings = dict.fromkeys(("operation.mass_flow", "operation.inlet_temperature", "operation.end_time"))
    settings |= {
        "operation.phase": given or phases(),
        **{f"operation.{key}": value for key, value in operation.items()},
    }
    return Scene.load(STORE, settings | QUIET)


def computed(scene, **more):
    return run(scene, communicator=MPI.COMM_SELF, **more)


def fine_store(durations):
    """Outlet temperatures at the ends of charges and discharges of the store: the two equations of Schumann without the fluid's
    own storage, by exact exponentials in 2000 cells and the midpoint rule."""
    cells, steps = 2000, 2000
    mass_flux, prandtl = 0.01 / (np.pi * 0.09 / 4.0), 3e-5 * 1005.0 / 0.04
    film = (2.0 + 1.1 * (mass_flux * 0.02 / 3e-5) ** 0.6 * prandtl ** (1 / 3)) * 0.04 / 0.02 * 6.0 * 0.6 / 0.02
    kept = np.exp(-film / cells / (mass_flux * 1005.0))
    beads, found = np.full(cells, COLD), []

    def leaving(beads, entering):
        return lfilter([1.0 - kept], [1.0, -kept], beads, zi=[kept * entering])[0]

    for number, duration in enumerate(durations):
        entering, step = (COLD if number % 2 else HOT), duration / steps

        def rate(beads, entering=entering):
            after = leaving(beads, entering)
            before = np.append(entering, after[:-1])
            return mass_flux * 1005.0 * (before - after) * cells / (0.6 * 4e6)

        for _ in range(steps):
            beads = beads + step * rate(beads + 0.5 * step * rate(beads))
        found.append(leaving(beads, entering)[-1])
        beads = beads[::-1]
    return found


def test_out_and_back_twice_is_that_of_another_program():
    scene = store([phases()[0], phases()[2]], cycles=2)
    result = computed(scene)
    outlets = [phase["outlet_temperature"] for cycle in result.summary["cycles"] for phase in cycle["phases"]]
    assert outlets == pytest.approx(fine_store([7200.0] * 4), abs=0.01 * (HOT - COLD))
    assert abs(result.summary["energy_imbalance"]) < 1e-9


def test_refinement_goes_to_the_other_program():
    scene = store([phases()[0], phases()[2]]).changed({"solver.mesh_refinement": 4.0, "solver.step_refinement": 4.0})
    found = [phase["outlet_temperature"] for phase in computed(scene).summary["cycles"][0]["phases"]]
    assert found == pytest.approx(fine_store([7200.0] * 2), abs=0.003 * (HOT - COLD))


@pytest.mark.parametrize("flow", ["plug", "developed", "full"])
def test_a_flow_that_begins_backwards_is_the_forward_one_mirrored(flow):
    """Two phases of the same direction, so that the mesh of both is the one of a flow that reverses."""
    both = {"temperature": HOT, "duration": "1 h"}
    results = [
        computed(
            store([{"mass_flow": sign * 0.01, **both}, {"mass_flow": -sign * 0.01, **both}]).changed(
                {"model.flow": flow}
            )
        )
        for sign in (1.0, -1.0)
    ]
    there, back = (result.history for result in results)
    for name in ("time", "outlet_temperature", "heat_by_fluid", "lowest_wall"):
        assert np.array(there[name]) == pytest.approx(np.array(back[name]), rel=1e-9)
    assert np.array(there["mass_flow"]) == pytest.approx(-np.array(back["mass_flow"]))
    middle = "temperature_bed_side_L/2"
    assert np.array(there[middle]) == pytest.approx(np.array(back[middle]), abs=1e-6)


def test_places_stay_where_they_are_when_the_flow_turns():
    result = computed(store())
    times, turned = np.array(result["time"]), 3.0 * 3600.0
    last = np.flatnonzero(times <= turned * (1.0 + 1e-12))[-1]
    for place in ("L/8", "L/4", "L/2"):
        values = np.array(result[f"temperature_bed_side_{place}"])
        assert abs(values[last + 1] - values[last]) < 30.0  # what enters changes by 475 K
    assert result["temperature_bed_side_L"][last + 1] < COLD + 1.0
    assert result["temperature_bed_side_L/8"][last] > result["temperature_bed_side_L/2"][last] + 100.0


def test_heat_is_kept_where_the_flow_turns_and_lost_nowhere():
    (cycle,) = computed(store()).summary["cycles"]
    charge, rest, discharge = cycle["phases"]
    assert charge["heat_stored"] == pytest.approx(charge["heat"], rel=1e-9)
    assert rest["heat"] == pytest.approx(0.0, abs=1e-9 * charge["heat"])
    assert discharge["heat_stored"] == pytest.approx(charge["heat"] + discharge["heat"], rel=1e-9)
    assert cycle["energy_efficiency"] == pytest.approx(-discharge["heat"] / charge["heat"])
    assert 0.0 < cycle["exergy_efficiency"] < cycle["energy_efficiency"] < 1.0


def test_exergy_of_a_charge_is_that_of_its_heat_at_the_inlet():
    """Of a charge from which the fluid leaves as cold as the surroundings, by the integral of C_f."""
    charge = computed(store()).summary["cycles"][0]["phases"][0]
    exact = 7200.0 * 0.01 * 1005.0 * ((HOT - COLD) - 298.15 * np.log(HOT / COLD))
    assert charge["exergy"] == pytest.approx(exact, rel=1e-3)
    assert charge["pumping_work"] > 0.0


def test_nothing_leaves_while_the_full_flow_rests():
    """A flow that is computed rests with a rounding error of the mass flow, which carries nothing."""
    rest = {"name": "rest", "duration": "2 min"}
    given = [
        {"name": "charge", "pressure_drop": 30.0, "temperature": HOT, "duration": "10 min"},
        rest,
        {"name": "discharge", "pressure_drop": -30.0, "temperature": COLD, "duration": "10 min"},
    ]
    scene = store(given).changed({"model.flow": "full", "solver.mesh_refinement": 0.5})
    charge, resting, _ = computed(scene).summary["cycles"][0]["phases"]
    assert resting["mean_outlet_temperature"] is None and resting["pumping_work"] == resting["exergy"] == 0.0
    assert charge["mean_outlet_temperature"] < HOT and charge["pumping_work"] > 0.0


def test_a_store_of_losses_gives_back_less():
    given = {"model.wall": "conjugate", "operation.outer_coefficient": 20.0, "operation.ambient_temperature": COLD}
    cycle = computed(store().changed(given)).summary["cycles"][0]
    lost = cycle["heat_in"] - cycle["heat_out"] - cycle["heat_stored"]
    assert cycle["heat_lost"] > 0.0 and cycle["heat_lost"] == pytest.approx(lost, rel=1e-6)


def test_a_cold_store_is_as_efficient_as_its_hot_twin():
    """Charged 60 K below or above its surroundings, with one fluid and losses: the cold that comes back counts, not the heat."""
    twin = {"model.wall": "conjugate", "operation.outer_coefficient": 20.0, "operation.ambient_temperature": COLD}
    efficiencies = []
    for charged in (COLD - 60.0, COLD + 60.0):
        given = phases(rest="0.5 h")
        given[0]["temperature"] = charged
        cycle = computed(store(given).changed(twin)).summary["cycles"][0]
        assert cycle["heat_in"] - cycle["heat_out"] == pytest.approx(
            cycle["heat_stored"] + cycle["heat_lost"], rel=1e-6
        )
        efficiencies.append(cycle["energy_efficiency"])
    assert efficiencies[0] < 1.0 and efficiencies[0] == pytest.approx(efficiencies[1], abs=0.01)


@pytest.mark.parametrize("flow", ["plug", "developed"])
@pytest.mark.parametrize("limit", [320.0, 500.0])
def test_a_phase_ends_where_what_leaves_is_as_warm(flow, limit):
    given = [{"mass_flow": 0.01, "temperature": HOT, "until_outlet_above": limit}, phases()[2]]
    first = computed(store(given, end_time="20 h").changed({"model.flow": flow})).summary["cycles"][0]["phases"][0]
    assert first["outlet_temperature"] == pytest.approx(limit, abs=2e-3 * (HOT - COLD))


def test_cycles_end_where_they_repeat_themselves():
    result = computed(store(phases(rest="1 min", charge="4 h", discharge="4 h"), cycles=50, cycle_tolerance=0.01))
    cycles = result.summary["cycles"]
    assert 2 <= len(cycles) < 50 and result.summary["last_cycle"]["is_periodic"]
    last, before = cycles[-1], cycles[-2]
    assert last["heat_in"] == pytest.approx(before["heat_in"], rel=0.01)
    assert last["energy_efficiency"] == pytest.approx(1.0, abs=0.03)
    few = computed(store(cycles=2, cycle_tolerance=1e-6))
    assert any("not periodic" in text for text in few.summary["warnings"])


def test_a_series_that_changes_its_sign_is_the_phases_of_it(tmp_path):
    (tmp_path / "flow.csv").write_text(
        "time [h],mass_flow [kg/s]\n0,0.01\n2,0.01\n2.0001,0\n3,0\n3.0001,-0.01\n5,-0.01\n"
    )
    settings = {
        "operation.mass_flow": str(tmp_path / "flow.csv"),
        "operation.return_temperature": COLD,
        "operation.end_time": "5 h",
    }
    result, given = computed(Scene.load(STORE, settings | QUIET)), computed(store())
    assert result["outlet_temperature"][-1] == pytest.approx(given["outlet_temperature"][-1], abs=0.01 * (HOT - COLD))
    assert result["heat_stored"][-1] == pytest.approx(given["heat_stored"][-1], rel=0.01)
    assert result["mass_flow"][-1] == pytest.approx(-0.01) and abs(result.summary["energy_imbalance"]) < 1e-4


def test_a_drive_that_crosses_zero_on_a_slope_turns_there(tmp_path):
    settings = {
        "operation.mass_flow": ([0.0, 3600.0, 10800.0], [0.01, 0.01, -0.01]),
        "operation.return_temperature": COLD,
    }
    result = computed(Scene.load(STORE, settings | QUIET | {"operation.end_time": "3 h"}))
    times, flows = np.array(result["time"]), np.array(result["mass_flow"])
    assert np.all(flows[times < 7199.0] > 0.0) and np.all(flows[times > 7201.0] < 0.0)
    assert abs(result.summary["energy_imbalance"]) < 1e-4


def test_flow_may_rest_in_a_series_of_any_drive():
    for drive, value in (("mass_flow", 0.01), ("inlet_velocity", 0.14), ("pressure_drop", 30.0)):
        settings = {"operation.mass_flow": None, f"operation.{drive}": ([0.0, 3600.0, 3601.0], [value, value, 0.0])}
        result = computed(Scene.load(STORE, settings | QUIET | {"operation.end_time": "2 h"}))
        assert abs(result["mass_flow"][-1]) < 1e-9 and result["mass_flow"][1] > 0.0
        assert result["heat_stored"][-1] == pytest.approx(
            np.interp(3605.0, result["time"], result["heat_stored"]), rel=1e-3
        )


def test_an_interrupted_run_goes_on_in_its_phase(tmp_path):
    scene, whole = store(cycles=2).changed({"output.fields": True}), computed(store(cycles=2))
    for after in (20, 55):  # the second one where the flow has turned
        calls = []

        def stop(after=after, calls=calls):
            calls.append(1)
            return len(calls) > after

        with pytest.raises(RunInterrupted):
            run(scene, tmp_path / f"run{after}", MPI.COMM_SELF, stop=stop)
        stopped = json.loads((tmp_path / f"run{after}" / "result.json").read_text())["end_time"]
        assert max(read_fields(tmp_path / f"run{after}" / "fields.xdmf")[2]) == pytest.approx(stopped, abs=1e-6)
        result = run(scene, tmp_path / f"run{after}", MPI.COMM_SELF, resume=True)
        assert result["outlet_temperature"][-1] == pytest.approx(whole["outlet_temperature"][-1], rel=1e-9)
        assert result.summary["cycles"] == json.loads(json.dumps(result.summary["cycles"]))
        assert result.summary["last_cycle"]["heat_out"] == pytest.approx(
            whole.summary["last_cycle"]["heat_out"], rel=1e-9
        )


def test_a_run_that_stops_where_a_phase_ends_goes_on_with_the_next(tmp_path):
    """A checkpoint of that time was written before the phase changed: the phase went on for a step, and the last one did not
    end."""
    scene, whole = store(cycles=2), computed(store(cycles=2))
    durations = [phase.duration for phase in phases_of(scene)]
    for number, end in enumerate(np.cumsum(durations)):

        def stop(time, deficit, simulation, end=end):
            if time == pytest.approx(end):
                raise KeyboardInterrupt

        folder = tmp_path / f"run{number}"
        with pytest.raises(RunInterrupted):
            run(scene, folder, MPI.COMM_SELF, progress=stop)
        result = run(scene, folder, MPI.COMM_SELF, resume=True)
        assert len(result.summary["cycles"]) == 2
        for name in ("time", "outlet_temperature", "mass_flow"):
            assert result[name] == pytest.approx(whole[name], rel=1e-8)


def test_a_run_that_stops_while_the_turned_flow_is_sought_goes_on_to_the_same_answer(tmp_path, monkeypatch):
    """It went on with the flow of the way before: 0.016 K and other steps."""
    scene = coarse_scene(
        QUIET, {"model.flow": "developed", "operation.reversal_period": 60.0, "operation.end_time": 150.0}
    )
    whole = computed(scene)
    with monkeypatch.context() as patched:

        def stop(simulation):
            raise KeyboardInterrupt

        patched.setattr(Simulation, "_find_turned_flow", stop)
        with pytest.raises(RunInterrupted):
            run(scene, tmp_path, MPI.COMM_SELF)
    result = run(scene, tmp_path, MPI.COMM_SELF, resume=True)
    for name in ("time", "outlet_temperature", "mass_flow"):
        assert result[name] == pytest.approx(whole[name], rel=1e-8)


def test_profiles_and_pictures_of_phases_are_written(tmp_path):
    scene = store(cycles=2).changed({"output.pictures": True, "output.fields": True})
    tables = tmp_path / "scene.toml"
    import tomli_w

    tables.write_text(tomli_w.dumps(scene.as_tables()))
    assert main(["run", str(tables), "--out", str(tmp_path / "run"), "--quiet"]) == 0
    head = (tmp_path / "run" / "profiles.csv").read_text().splitlines()[0]
    assert head.startswith("distance_from_inlet [m],fluid_1 charge [K]") and "beads_2 discharge [K]" in head
    assert {"profiles.png", "fields.png"} <= {path.name for path in (tmp_path / "run").iterdir()}


REFUSED = {
    "operation.mass_flow": (-0.01, "must be > 0"),
    "operation.cycles": (3, "needs"),
    "operation.return_temperature": (300.0, "never comes"),
}


@pytest.mark.parametrize("key", REFUSED)
def test_what_has_no_meaning_is_refused(key):
    value, words = REFUSED[key]
    with pytest.raises(InputError, match=words):
        Scene.load(STORE, {key: value})


@pytest.mark.parametrize(("given", "words"), [
    ([{"mass_flow": 0.01, "duration": 60.0}], "temperature"),
    ([{"mass_flow": 0.01, "temperature": HOT}], "duration"),
    ([{"duration": 60.0}], "one of pressure_drop"),
    ([{"mass_flow": 0.01, "temperature": HOT, "duration": 60.0}, {"pressure_drop": 10.0, "temperature": HOT, "duration": 1.0}],
     "must be mass_flow"),
    ([{"mass_flow": 0.01, "temperature": HOT, "until_outlet_above": 300.0, "until_outlet_below": 300.0}], "combined"),
    ([{"mass_flow": 0.01, "temperature": HOT, "duration": 9.0}, {"until_outlet_below": 300.0}], "needs a flow"),
])  # fmt: skip
def test_phases_that_lack_something_are_refused(given, words):
    with pytest.raises(InputError, match=words):
        store(given)


@pytest.mark.parametrize(("key", "value", "words"), [
    ("operation.gravity", 9.81, "buoyancy"),
    ("model.flow_update", "transient", "quasi-steady"),
    ("operation.heater_power", 1e3, "no place"),
    ("operation.inlet_temperature", 500.0, "cannot be combined"),
])  # fmt: skip
def test_what_does_not_go_with_phases_is_refused(key, value, words):
    with pytest.raises(InputError, match=words):
        store().changed({key: value})


@pytest.mark.mpi
@pytest.mark.parametrize(("flow", "same"), [("plug", 1e-8), ("full", 1e-3)])
def test_the_flow_turns_alike_on_any_number_of_ranks(flow, same):
    """The mirror image of a node lies on another rank. In full flow, which is solved to a tolerance in an order of messages that
    no run repeats, a step near its limit may be taken or not: answers are the same within an eighth of a step's error there, at
    the same times, not the steps."""
    given = store(phases(charge="30 min", rest="10 min", discharge="30 min"), end_time="2 h").changed(
        {"model.flow": flow, "solver.axial_cells": 10, "output.times": [1000.0, 3000.0]}
    )
    everywhere, here = run(given, communicator=MPI.COMM_WORLD), run(given, communicator=MPI.COMM_SELF)
    shared = [1000.0, 1800.0, 2400.0, 3000.0, 4200.0]  # of output and of the phases' ends, where all steps end
    rows = [[int(np.argmin(np.abs(np.array(one["time"]) - time))) for time in shared] for one in (everywhere, here)]
    for one, numbers in zip((everywhere, here), rows, strict=True):
        assert np.array(one["time"])[numbers] == pytest.approx(shared, rel=1e-9)
    for name in ("outlet_temperature", "heat_stored", "temperature_bed_side_L/8"):
        there, alone = (np.array(one[name])[numbers] for one, numbers in zip((everywhere, here), rows, strict=True))
        assert np.max(np.abs(there - alone)) < same * max(np.ptp(here[name]), 1.0)
    if flow == "plug":
        assert np.array(everywhere["time"]) == pytest.approx(np.array(here["time"]), rel=same)
    assert everywhere.summary["last_cycle"]["heat_out"] == pytest.approx(
        here.summary["last_cycle"]["heat_out"], rel=same
    )


@pytest.mark.mpi
def test_a_state_is_the_start_of_a_run_on_any_number_of_ranks(tmp_path):
    folder = MPI.COMM_WORLD.bcast(str(tmp_path))
    first = Scene.load(STORE, {"operation.end_time": "30 min", "output.pictures": False})
    run(first, folder, MPI.COMM_WORLD)
    more = {"operation.initial_temperature": None, "operation.initial_state": folder, "operation.end_time": "10 min"}
    second = Scene.load(STORE, more | QUIET)
    everywhere, here = run(second, communicator=MPI.COMM_WORLD), run(second, communicator=MPI.COMM_SELF)
    assert np.array(everywhere["outlet_temperature"]) == pytest.approx(np.array(here["outlet_temperature"]), rel=1e-8)


@pytest.fixture
def profile(tmp_path):
    """Hot near the inlet, cold at the outlet."""
    (tmp_path / "start.csv").write_text("x [m], temperature [degC]\n0, 500\n0.4, 500\n0.6, 25\n1, 25\n")
    return str(tmp_path / "start.csv")


def test_a_profile_lies_where_it_is_given_though_the_flow_begins_backwards(profile):
    """It was turned end for end: the discharge entered the hot end (found by a tester)."""
    discharge = phases()[2] | {"duration": "10 min"}
    backwards = computed(store([discharge], initial_temperature=profile))
    after_a_rest = computed(store([{"duration": "1 s"}, discharge], initial_temperature=profile))
    assert backwards["temperature_bed_side_L/8"][0] == pytest.approx(773.15, abs=1.0)
    assert backwards["temperature_bed_side_L"][0] == pytest.approx(COLD, abs=1.0)
    one, other = (result.summary["cycles"][0]["phases"][-1] for result in (backwards, after_a_rest))
    assert one["heat"] == pytest.approx(other["heat"], rel=0.01) and one["heat"] < -1e5
    assert one["outlet_temperature"] == pytest.approx(other["outlet_temperature"], abs=2.0)


def test_a_store_has_no_heating_time_and_runs_to_the_end_of_its_series():
    """The run ended when the wall was as warm as what enters, before the flow turned; with a flux from outside, or a part that
    cures, even a bed that was far hotter than what enters counted as heated (found by a tester)."""
    series = {
        "operation.mass_flow": ([0.0, 6.0 * 3600.0, 6.1 * 3600.0], [0.05, 0.05, -0.05]),
        "operation.end_time": "8 h",
    }
    for more in ({}, {"operation.outer_heat_flux": 50.0, "model.wall": "conjugate"}):
        scene = Scene.load(STORE, series | more | {"operation.return_temperature": COLD} | QUIET)
        result = computed(scene)
        assert result["time"][-1] == pytest.approx(8.0 * 3600.0) and result.heating_time is None
    assert computed(store()).heating_time is None


def test_utilisation_counts_the_fluid_that_stores():
    water = {"fluid.density": 980.0, "fluid.viscosity": 5e-4, "fluid.heat_capacity": 4190.0, "fluid.conductivity": 0.65}
    given = [
        {"mass_flow": 0.05, "temperature": 350.0, "duration": "6 h"},
        {"mass_flow": -0.05, "temperature": COLD, "duration": "6 h"},
    ]
    (cycle,) = computed(store(given).changed(water)).summary["cycles"]
    assert 0.5 < cycle["utilisation"] <= 1.01


def test_a_store_that_begins_beyond_its_phases_has_no_utilisation_then():
    """What it takes up from 25 degC on is no part of what it stores between the phases' 500 and 550 K."""
    given = [
        {"mass_flow": 0.05, "temperature": 550.0, "duration": "8 h"},
        {"mass_flow": -0.05, "temperature": 500.0, "duration": "8 h"},
    ]
    first, second = computed(store(given, cycles=2)).summary["cycles"]
    assert first["utilisation"] is None and first["heat_in"] > 0.0
    assert 0.2 < second["utilisation"] <= 1.01


@pytest.mark.parametrize(("side", "limit"), [("above", HOT), ("above", 900.0), ("below", COLD)])
def test_an_outlet_temperature_that_is_never_reached_is_refused(side, limit):
    given = [{"mass_flow": 0.01, "temperature": HOT, f"until_outlet_{side}": limit}]
    with pytest.raises(InputError, match="never reached"):
        store(given)


def test_a_state_of_another_bed_is_refused(tmp_path):
    run(Scene.load(STORE, {"operation.end_time": 60.0, "output.pictures": False}), tmp_path, MPI.COMM_SELF)
    more = {"operation.initial_temperature": None, "operation.initial_state": str(tmp_path), "geometry.length": 1.5}
    with pytest.raises(InputError, match="of a bed of 1 m"):
        Scene.load(STORE, more)


def test_thousands_of_reversals_are_refused():
    with pytest.raises(InputError, match="more than 10000 reversals"):
        Scene.load(STORE, {"operation.reversal_period": 1e-3})


def test_the_default_end_is_that_of_each_phase_that_waits():
    """Cycles of a store took longer than the default of a heating, which cut them."""
    charge = {"mass_flow": 0.01, "temperature": HOT, "until_outlet_above": 400.0}
    back = {"mass_flow": -0.01, "temperature": COLD, "until_outlet_below": 600.0}
    assert specs_of(store([charge, back], cycles=4)).time.end_time == pytest.approx(8e5)
    assert specs_of(store([charge, back], cycles=4, end_time="9 h")).time.end_time == pytest.approx(9.0 * 3600.0)
    assert specs_of(store(cycles=2)).time.end_time == pytest.approx(10.0 * 3600.0)


def test_a_phase_waits_for_a_temperature_no_longer_than_it_may():
    """Without operation.end_time: a charge that takes far longer."""
    waiting = [{"name": "charge", "mass_flow": 1e-4, "temperature": HOT, "until_outlet_above": HOT - 1e-3}]
    result = computed(store([*waiting, *phases()[2:]]))
    assert result.summary["end_time"] == pytest.approx(1e5, rel=0.2)
    assert any("'charge' waits for a temperature" in text for text in result.summary["warnings"])


def test_a_cycle_that_lives_on_what_was_stored_is_told():
    short = [{"name": "charge", "mass_flow": 0.01, "temperature": HOT, "duration": "30 min"}, *phases()[2:]]
    result = computed(store(short, initial_temperature=600.0))
    assert any("empties what was stored before" in text for text in result.summary["warnings"])


@pytest.mark.parametrize(("heat", "efficiency"), [(1e-19, None), (4.0, 0.5)])
def test_a_cycle_that_takes_no_heat_has_no_efficiency(heat, efficiency):
    """What enters is as warm as the bed but for rounding, and its wall is heated by a cure: it was 1.8e13."""
    shared = {"begin": 0.0, "end": 9.0, "exergy": 0.1 * heat, "pumping_work": 0.0, "heat_stored": 4.0}
    given = [shared | {"heat": heat}, shared | {"heat": -0.5 * heat, "exergy": 0.0}]
    columns = {"time": np.array([0.0, 9.0]), "heat_stored": np.array([0.0, 4.0])}
    cycle = _cycle(1, given, columns | {"heat_through_outer_wall": np.zeros(2)}, 0.0)
    assert cycle["energy_efficiency"] == efficiency
    assert cycle["exergy_efficiency"] == (None if efficiency is None else 0.0)


def test_a_store_that_is_charged_alone_has_the_front_of_one_that_is_cycled():
    """Phases of one temperature have no difference of their own: the front's was 0.0 m thick."""
    alone_cycle = computed(store(phases()[:1])).summary["cycles"][0]
    (alone,) = alone_cycle["phases"]
    cycled = computed(store(phases())).summary["cycles"][0]["phases"][0]
    assert 0.2 < alone_cycle["utilisation"] < 1.01  # was 1e17 of a rounding error
    assert cycled["thermocline"] > 0.1 and 0.2 < cycled["thermocline_place"] < 0.9
    for name in ("thermocline", "thermocline_place"):
        assert alone[name] == pytest.approx(cycled[name], rel=1e-3)


def test_a_phase_that_is_over_when_it_begins_is_told():
    ended = [{"name": "charge", "mass_flow": 0.01, "temperature": HOT, "until_outlet_above": COLD - 20.0}, phases()[1]]
    warnings = computed(store(ended)).summary["warnings"]
    assert any("phase 'charge' ended with its first step, 1 times" in warning for warning in warnings)
    assert not any("ended with its first step" in one for one in computed(store(phases()[:1])).summary["warnings"])
