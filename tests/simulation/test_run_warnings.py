"""What a run says of itself where its numbers mean less, or other, than one would think."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI
from scipy.integrate import trapezoid

from porousmold import InputError, Scene, run
from porousmold.errors import SolveError
from porousmold.simulation.checking import check
from porousmold.simulation.run_warnings import _of_the_openings
from porousmold.simulation.specs import specs_of

from ..support import ALUMINIUM, RESIN, STUDIES, coarse_scene

PLUG = {"model.flow": "plug", "model.turbulence": "none"}


def warnings_of(*changes):
    """Of a coarse run of the aluminium mold."""
    return run(coarse_scene(PLUG, *changes), communicator=MPI.COMM_SELF).summary["warnings"]


@pytest.mark.parametrize("place", ["run", "check"])
def test_a_thin_wall_that_resists_is_told(place):
    """8 mm of FRP are 7 % too fast when they are lumped; aluminium is none the worse for it."""

    def told(changes):
        thin = {"model.wall": "thin", "operation.end_time": 5.0, **changes}
        found = warnings_of(thin) if place == "run" else check(coarse_scene(PLUG, thin), MPI.COMM_SELF).warnings
        return [text for text in found if "'thin' leaves both out" in text]

    assert told({"wall.material": "frp", "wall.thickness": 0.008})
    assert not told({})
    outside = {"operation.outer_coefficient": 400.0, "operation.ambient_temperature": 293.0}
    assert "times that to the surroundings" in told({"wall.material": "acrylic", "wall.thickness": 0.001} | outside)[0]
    assert not told(outside)


REAL = {"fluid.material": "carbon_dioxide", "fluid.real_gas": True, "operation.outlet_pressure": "30 bar"}
WATER = {"fluid.material": "water", "operation.inlet_temperature": 350.0, "operation.pressure_drop": 500.0}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"operation.inlet_temperature": "600 degC"},
            "ceramic is used for 25.0 to 600.0 °C, given for -23.1 to 226.9 °C (heat_capacity)",
        ),
        (
            {"operation.inlet_temperature": "600 degC"},
            "aluminium is used for 25.0 to 600.0 °C, given for -73.1 to 226.9 °C (heat_capacity)",
        ),
        ({"fluid.material": "argon", "operation.outlet_pressure": "10 bar"}, "argon is no ideal gas"),
        (
            {"fluid.material": "argon", "operation.outlet_pressure": "10 bar", "fluid.viscosity": 2e-5},
            "is no ideal gas",
        ),
        (REAL | {"operation.pressure_drop": "15 bar"}, "at the inlet's 45 bar"),
        (WATER | {"model.nusselt": "achenbach"}, "the Prandtl number"),
        (WATER | {"model.closures": "measured", "bed.emissivity": 0.9}, "a liquid absorbs that"),
        ({"model.drag": "eisfeld-schnitzlein", "model.flow": "developed"}, "it counts the wall twice"),
    ],
)
def test_what_a_law_is_not_made_for_is_told(changes, words):
    """Each was off by 3 to 30 % without a word."""
    told = check(coarse_scene(PLUG, changes), MPI.COMM_SELF).warnings
    assert any(words in text for text in told)
    assert not any(words in text for text in check(coarse_scene(PLUG), MPI.COMM_SELF).warnings)


def test_a_wall_that_the_surroundings_cool_before_the_flow_comes_is_not_said_to_stay():
    cold = {"operation.outer_coefficient": 10.0, "operation.ambient_temperature": 273.15, "operation.end_time": 200.0}
    text = next(one for one in warnings_of(cold) if "not heated" in one)
    assert "hardly heated yet, farther than at the start" in text and "stays there" not in text


def test_a_bed_without_a_wall_and_an_inlet_that_cools_again_are_not_said_to_approach():
    told = {"model.wall": "insulated", "operation.end_time": 20.0}
    text = next(one for one in warnings_of(told) if "not heated" in one)
    assert "the wall is" not in text and "the side of the bed is" in text
    turned = {
        "operation.inlet_temperature": ([0.0, 400.0, 401.0], [363.15, 363.15, 300.0]),
        "operation.end_time": 900.0,
    }
    text = next(one for one in warnings_of(turned) if "not " in one and "away" in one)
    assert "by -" not in text


def test_surroundings_hotter_than_the_inlet_are_no_heat_losses():
    hot = {"operation.outer_coefficient": 20.0, "operation.ambient_temperature": 423.15, "operation.end_time": 2e4}
    text = next(one for one in warnings_of(hot) if "not heated" in one)
    assert "heat that comes in through the outer wall balances" in text


def test_a_cooling_that_has_not_ended_is_called_so():
    cooling = {
        "operation.initial_temperature": 363.15,
        "operation.inlet_temperature": 298.15,
        "operation.end_time": 100.0,
    }
    assert any(
        "not cooled to within 2 K" in text and "its hottest point hardly cooled yet" in text
        for text in warnings_of(cooling)
    )


def test_a_wall_beyond_the_inlet_is_told():
    """A heat flux carries the wall past the inlet's temperature: within 2 K is then that of its coldest point."""
    found = warnings_of({"operation.outer_heat_flux": 3000.0})
    assert any("hotter than the inlet, by heat from elsewhere" in text for text in found)
    assert not any("by heat from elsewhere" in text for text in warnings_of())


def test_a_spread_at_the_edge_of_the_inlet_is_told():
    """FRP's hottest point is the edge of the inlet, where finer cells come nearer to the gas."""
    frp = {"wall.material": "frp", "wall.thickness": 0.006, "operation.end_time": 3000.0}
    losses = {"operation.outer_coefficient": 5.0, "operation.ambient_temperature": 293.15}
    even = {"target": [{"name": "even", "place": "wall", "spread": 20.0}]}
    scene = Scene(coarse_scene(PLUG, frp, losses).as_tables() | even)
    found = run(scene, communicator=MPI.COMM_SELF).summary["warnings"]
    assert any("is at the edge of the inlet" in text for text in found)


def test_the_spread_at_the_end_of_a_wall_that_loses_heat_is_told():
    """The hottest point of a steady wall with losses is the inlet's edge: 335, 344, 349 K of spread with 1, 2 and 8 times the
    cells in a hot mold of 1 m, while a bed that has the inlet's temperature has no such edge."""
    hot = {"operation.inlet_temperature": 1200.0, "operation.outer_coefficient": 40.0, "model.wall": "thin"}
    hot |= {"operation.ambient_temperature": 293.15, "operation.end_time": 4000.0}
    assert any("and with it spread_at_end" in text for text in warnings_of(hot))
    assert not any("spread_at_end" in text for text in warnings_of())


def test_a_bed_of_moving_beads_is_as_cold_as_those_that_enter():
    """Where the exchange is shorter than a cell, no node is: a target would be met that never can be."""
    beads = {"operation.bead_velocity": 5e-4, "operation.bead_inlet_temperature": 293.15, "operation.end_time": 5000.0}
    scene = coarse_scene(PLUG, beads, {"model.wall": "insulated", "operation.initial_temperature": 293.15})
    targets = {"target": [{"name": "hot", "place": "bed", "above": 300.0}]}
    result = run(Scene(scene.as_tables() | targets), communicator=MPI.COMM_SELF)
    assert result.summary["targets"]["hot"] is None
    assert result["lowest_bed"][-1] == pytest.approx(293.15)
    assert result["highest_bed"][-1] == pytest.approx(scene.operation.inlet_temperature.values[-1], abs=1e-6)


def test_heat_that_moving_beads_carry_off_is_not_called_a_loss_of_the_wall():
    beads = {"operation.bead_velocity": -2e-3, "operation.bead_inlet_temperature": 298.15, "operation.end_time": 1.2e4}
    told = warnings_of(beads, {"operation.outer_coefficient": 1e-3, "operation.ambient_temperature": 298.15})
    text = next(one for one in told if "not heated" in one)
    assert "beads that enter cold carry off the heat" in text and "losses" not in text


def test_hot_oil_into_cold_oil_is_told_and_tried_on_finer_cells():
    """Fingers: 337.5 s where twice the cells and steps say 322.5 in a mold of 1 m, and a coarser run may agree by accident."""
    oil = {"fluid.material": "thermal_oil", "operation.initial_temperature": "20 degC", "model.flow": "developed"}
    oil |= {"operation.inlet_temperature": "150 degC", "operation.pressure_drop": 1e4, "model.turbulence": "none"}
    scene = Scene.load(ALUMINIUM, oil | {"geometry.length": 0.3, "output.fields": False, "output.pictures": False})
    assert any("viscous fingering" in text for text in check(scene, MPI.COMM_SELF).warnings)
    summary = run(scene, communicator=MPI.COMM_SELF).summary
    assert max(summary["refinements"].values()) > 1.0 and summary["heating_time_error"] > 0.0
    assert any("flows easily" in text for text in summary["warnings"])


def test_a_sensor_has_no_name_of_a_place(tmp_path):
    path = tmp_path / "sensors.csv"
    path.write_text("name, x [mm], y [mm]\nbed, 100, 5\n")
    with pytest.raises(InputError, match="bed"):
        coarse_scene({"geometry.sensors": str(path)}, ALUMINIUM)


def test_the_spread_at_the_end_is_that_when_the_wall_is_heated():
    """Not that of the last step, however far it goes beyond: nearly the same with steps of a quarter."""
    spreads = []
    for step in (80.0, 20.0):
        settings = {**PLUG, "solver.largest_step": step}
        result = run(coarse_scene(settings), communicator=MPI.COMM_SELF)
        assert result.summary["end_time"] > result.heating_time
        spreads.append(result.summary["spread_at_end"])
        history = result.history
        last = history["highest_bed_side"][-1] - history["lowest_bed_side"][-1]
        assert spreads[-1] > last
        assert spreads[-1] <= 2.0 * (1.0 + 1e-3)  # as the wall is within 2 K of the inlet's temperature
    assert spreads[0] == pytest.approx(spreads[1], rel=0.01)


STORE_OF_OIL = {
    "geometry": {"kind": "pipe", "length": 1.0, "diameter": "1 m"},
    "bed": {"bead_diameter": "15 mm", "bead_material": "quartzite", "porosity_model": "constant", "bulk_porosity": 0.4},
    "fluid": {"material": "therminol_vp1"},
    "operation": {
        "initial_temperature": "100 degC",
        "inlet_temperature": "350 degC",
        "mass_flow": "30 kg/s",
        "outlet_pressure": "15 bar",
        "end_time": "20 min",
    },
    "model": {"flow": "plug", "turbulence": "none", "wall": "insulated"},
    "output": {"pictures": False},
}


def test_a_frozen_flow_that_leaves_out_what_a_liquid_displaces_is_told():
    """The heat that is stored is too high by what the run says; a flow that follows the temperatures counts it."""
    scene = Scene(STORE_OF_OIL).changed({"model.flow_update": "frozen"})
    result = run(scene, communicator=MPI.COMM_SELF)
    (told,) = [text for text in result.summary["warnings"] if "density changes" in text]
    fluid, beads = specs_of(scene).laws.fluid, specs_of(scene).laws.beads
    cold, hot, volume = 373.15, 623.15, 0.25 * np.pi
    temperature = np.linspace(cold, hot, 401)
    in_fluid = 0.4 * fluid.density(15e5, hot) * trapezoid(fluid.heat_capacity(temperature), temperature)
    in_beads = 0.6 * trapezoid(beads.density(temperature) * beads.heat_capacity(temperature), temperature)
    off = result.summary["heat_stored"] / (volume * (in_fluid + in_beads)) - 1.0
    assert off == pytest.approx(float(re.search(r"by up to ([\d.]+)%", told)[1]) / 100, rel=0.15)
    for few in (
        scene.changed({"operation.inlet_temperature": "110 degC"}),
        scene.changed({"model.flow_update": "quasi-steady"}),
        coarse_scene(),
    ):
        assert not any("density changes" in text for text in check(few, MPI.COMM_SELF).warnings)


def test_friction_that_would_heat_a_liquid_is_told():
    drive = {
        "operation.mass_flow": None,
        "operation.pressure_drop": "10 bar",
        "operation.inlet_temperature": "110 degC",
    }
    scene = Scene(STORE_OF_OIL).changed({"bed.bead_diameter": "1 mm", **drive})
    (told,) = [text for text in check(scene, MPI.COMM_SELF).warnings if "friction" in text]
    fluid = specs_of(scene).laws.fluid
    rise = 10e5 / float(fluid.density(15e5, 383.15) * fluid.heat_capacity(383.15))
    assert f"up to {rise:.2g} K" in told
    weak = scene.changed({"operation.pressure_drop": "0.5 bar"})
    assert not any("friction" in text for text in check(weak, MPI.COMM_SELF).warnings)


def test_a_porosity_beside_its_profile_is_refused():
    profile = str(STUDIES / "profiles" / "slab_ratio_10.csv")
    with pytest.raises(InputError, match=r"bed.bulk_porosity = 0.3: has no place beside bed.porosity_profile"):
        coarse_scene({"bed.porosity_profile": profile, "bed.bulk_porosity": 0.3})


def test_beside_a_wall_that_is_held_only_the_bed_is_waited_for():
    held = {"model.wall": "fixed-temperature", "operation.wall_temperature": 363.15}
    result = run(coarse_scene(PLUG, held | {"operation.end_time": 20.0}))
    assert any("the wall is held at operation.wall_temperature" in text for text in result.summary["warnings"])
    waited = run(coarse_scene(PLUG, held | {"operation.heated_place": "bed"}))
    assert waited.heating_time is not None
    assert not any("is held" in text for text in waited.summary["warnings"])
    colder = held | {"operation.wall_temperature": 340.0, "operation.heated_place": "bed"}
    never = run(coarse_scene(PLUG, colder)).summary
    assert never["heating_time"] is None and any("stays there" in text for text in never["warnings"])


def test_heat_that_is_not_there_cannot_be_taken_out(tmp_path):
    """Losses that lead below 0 K end the run in one line, and what was computed before stays."""
    with pytest.raises(SolveError, match="a temperature falls to 0 K; try less heat taken out"):
        run(coarse_scene(PLUG, {"operation.outer_heat_flux": -5e5, "output.pictures": False}), out=tmp_path / "cold")
    assert json.loads((tmp_path / "cold" / "result.json").read_text())["status"] == "failed"


def test_one_temperature_with_little_exchange_is_told():
    poor = {"model.energy": "one-temperature", "operation.end_time": 20.0}
    assert any("transfer units over the bed" in text for text in warnings_of(poor))
    assert not any("transfer units" in text for text in warnings_of({"operation.end_time": 20.0}))


RAMP = {"operation.end_time": 4e4, "operation.heating_margin": 2.0, "operation.heated_place": "bed_side"}


def test_a_wall_that_follows_a_slow_ramp_is_heated_when_it_is_near_its_end():
    """It is never 2 K behind, so that it crosses no margin of the present set point: 30 K in 10 h, 2 K before the end."""
    ramp = ([0.0, 36000.0], [293.15, 323.15])
    result = run(
        coarse_scene(PLUG, RAMP, {"operation.inlet_temperature": ramp, "operation.initial_temperature": 293.15})
    )
    assert result.heating_time == pytest.approx(36000.0 * 28.0 / 30.0, abs=2000.0) and result.heating_time > 33600.0


def test_noise_about_the_start_heats_nothing():
    """A flat beginning whose noise is as large as the margin, then the step that heats."""
    times = np.arange(0.0, 1200.0, 2.0)
    noise = np.where(times < 1100.0, 2.5 * np.sin(1.7 * times), 0.0)
    values = np.where(times < 200.0, 293.15, 353.15) + noise
    changes = {"operation.inlet_temperature": (times, values), "operation.initial_temperature": 293.15}
    smooth = {"operation.inlet_temperature": ([0.0, 198.0, 200.0], [293.15, 293.15, 353.15])}
    margin = {"operation.heating_margin": 4.0, "operation.end_time": 4000.0}
    found = [run(coarse_scene(PLUG, changes, margin, more)).heating_time for more in ({}, smooth)]
    assert found[0] > 1000.0 and found[0] == pytest.approx(found[1], rel=0.05)


def test_a_set_point_that_runs_ahead_is_not_called_surroundings():
    ramp = ([0.0, 200.0], [293.15, 500.0])
    cut = {"operation.inlet_temperature": ramp, "operation.end_time": 100.0}
    text = next(one for one in warnings_of(cut) if "not heated" in one)
    assert "the inlet's temperature runs ahead" in text


def test_a_part_that_cures_at_rest_has_a_balance_of_the_heat_that_its_cure_sets_free():
    """Nothing comes in and nothing is stored but rounding, which was 100 % of the larger of the two."""
    skin = {"name": "skin", "material": "carbon_steel", "thickness": 1e-3}
    part = {"name": "part", "material": "resin", "thickness": 4e-3}
    at_rest = {
        "operation.pressure_drop": 0.0,
        "operation.initial_temperature": 420.0,
        "operation.inlet_temperature": 410.0,
    }
    scene = coarse_scene(PLUG, at_rest, {"operation.end_time": 600.0, "model.turbulence": "none"})
    tables = scene.as_tables() | {"wall": {"layer": [skin, part]}, "materials": {"resin": RESIN}}
    result = run(Scene(tables), communicator=MPI.COMM_SELF)
    summary = result.summary
    assert (
        max(result["highest_part"]) > 425.0
        and abs(summary["heat_stored"]) < 1.0
        and abs(summary["energy_imbalance"]) < 1e-4
    )
    assert not any("heat balance is off" in text for text in summary["warnings"])


def test_a_series_tells_when_it_begins_and_one_that_is_over_is_refused():
    """A channel whose time_offset moved it before the run held its last value in silence."""
    late = Scene.load(ALUMINIUM, {"operation.inlet_temperature": ([600.0, 4000.0], [363.15, 360.0])})
    assert any(
        "begins at 600 s: up to then it is its first value" in text for text in check(late, MPI.COMM_SELF).warnings
    )
    for times in ([-7200.0, -3600.0], [-60.0, 0.0]):
        with pytest.raises(InputError, match="time_offset"):
            Scene.load(ALUMINIUM, {"operation.inlet_temperature": (times, [363.15, 360.0])})


def test_a_series_of_one_late_row_and_times_after_the_end_are_told():
    late = {"operation.inlet_temperature": ([300.0], [363.15]), "output.times": (1.0, 900.0), "operation.end_time": 5.0}
    told = run(coarse_scene(PLUG, late)).summary["warnings"]
    assert any("begins at 300 s" in text for text in told)
    assert any("output.times from 900 s on" in text for text in told)


def test_the_heat_balance_is_beside_the_largest_heat_that_was_stored():
    """A mold that is heated and cooled again to where it was stores nothing at the end: its balance was off by 20 %."""
    inlet = ([0.0, 1500.0, 1501.0, 5000.0], [363.15, 363.15, 293.15, 293.15])
    scene = coarse_scene(
        {"operation.initial_temperature": 293.15, "operation.inlet_temperature": inlet, "operation.end_time": 5000.0,
         "model.flow": "plug", "model.turbulence": "none",
         "target.list": [{"name": "never", "above": 400.0}]}
    )  # fmt: skip
    summary = run(scene, communicator=MPI.COMM_SELF).summary
    assert abs(summary["heat_stored"]) < 1e3 and abs(summary["energy_imbalance"]) < 1e-4
    assert not any("heat balance" in text for text in summary["warnings"])


@pytest.mark.parametrize(("unit", "is_told"), [("m", True), ("mm", False)])
def test_a_heat_flux_told_far_beyond_the_bed_is_told(unit, is_told, tmp_path):
    """Its first column held all along the bed: 27 % of the heat, in silence."""
    (tmp_path / "flux.csv").write_text(
        f"time [s], 0 {unit} [W/m^2], 500 {unit} [W/m^2], 900 {unit} [W/m^2]\n0, 10, 20, 5\n"
    )
    given = {"operation.outer_heat_flux": str(tmp_path / "flux.csv"), "operation.end_time": 1.0}
    warnings = run(coarse_scene(PLUG, given)).summary["warnings"]
    assert any("distances in another unit?" in text for text in warnings) == is_told


def test_too_high_a_first_cell_is_told_of_plug_flow_too():
    """Heat passes to the wall through cells as low as a tenth of a millimetre: 4 % of the heating time, in silence."""
    given = {"operation.end_time": 1.0, "solver.cell_growth": None}
    low, high = (run(coarse_scene(PLUG, given | {"solver.first_cell": cell})).summary for cell in (5e-5, 5e-4))
    assert not any("first cell" in text for text in low["warnings"])
    assert any("the exchange of heat near the wall" in text for text in high["warnings"])


@pytest.mark.parametrize(
    ("flow", "outlet", "is_told"), [("full", 1e4, False), ("full", 3e3, True), ("plug", 3e3, False)]
)
def test_a_gas_that_expands_in_the_last_cells_is_told(flow, outlet, is_told):
    """Full flow has half a per cent less of it on default cells; what is found station by station follows p dp/dx."""
    given = {"operation.pressure_drop": 2.2e4, "operation.outlet_pressure": outlet, "operation.end_time": 1e-3}
    given |= {"model.flow": flow, "bed.bead_diameter": 1e-4, "solver.refine_in_doubt": False}
    warnings = run(coarse_scene(PLUG, given)).summary["warnings"]
    assert any("-fold, most of that within the last cells" in text for text in warnings) == is_told


@pytest.mark.parametrize(("drop", "words"), [(2e4, ""), (8e4, "of low Mach numbers"), (9e4, "a real flow is choked")])
def test_a_flow_faster_than_sound_is_choked(drop, words):
    """It was told as one whose energy balance is not exact."""
    given = {"geometry.length": 0.06, "operation.pressure_drop": drop, "operation.outlet_pressure": 1e5 - drop}
    told = [text for text in warnings_of(given | {"operation.end_time": 1.0}) if "Mach" in text]
    assert [words in text for text in told] == [True] * bool(words)


@pytest.mark.parametrize(("found", "count"), [(5924.0, 1), (5979.0, 0), (-5924.0, 1)])
def test_a_pressure_drop_that_is_not_the_one_given_is_told(found, count):
    """Full flow through half of a side: 1.3 % on the mesh as drawn, 0.35 % on halved cells, of either sign."""
    flow = SimpleNamespace(drive="pressure_drop", by_blower=False, driven_by=lambda time: 6000.0)
    mesh = SimpleNamespace(own=SimpleNamespace(mesh="half.msh"))
    recorder = SimpleNamespace(history={"time": [0.0, 9.0], "pressure_drop": [6000.0, found]})
    assert (
        len(_of_the_openings(SimpleNamespace(specs=SimpleNamespace(flow=flow, mesh=mesh), recorder=recorder))) == count
    )


def test_a_heating_time_of_an_earlier_set_point_is_told():
    """60 degC, and 180 degC later: the run ends with the last change, with the wall 100 K and more from the inlet."""
    given = {"operation.inlet_temperature": ([0.0, 5000.0, 5060.0], [333.15, 333.15, 453.15])}
    result = run(coarse_scene(PLUG, given))
    assert result.heating_time < 5000.0
    assert any("that of an earlier set-point" in text for text in result.summary["warnings"])
    assert not any("earlier set-point" in text for text in run(coarse_scene(PLUG)).summary["warnings"])


def test_a_wall_that_a_source_keeps_ahead_of_the_inlet_is_not_said_to_lag():
    given = {"operation.inlet_temperature": ([0.0, 600.0, 601.0, 2000.0], [298.15, 363.15, 363.15, 362.15])}
    given |= {"operation.outer_heat_flux": 2000.0, "operation.end_time": 2500.0}
    warnings = run(coarse_scene(PLUG, given)).summary["warnings"]
    assert any("heat from elsewhere has the wall ahead of the inlet" in text for text in warnings)


def test_a_target_that_phases_end_without_is_told():
    """Without operation.end_time nothing was said of it."""
    phase = {"name": "charge", "pressure_drop": 8000.0, "temperature": 363.15, "until_outlet_above": 320.0}
    given = dict.fromkeys(("operation.pressure_drop", "operation.inlet_temperature", "operation.end_time"))
    given |= {"operation.phase": [phase], "target.list": [{"name": "hot", "above": "89 degC"}]}
    warnings = run(coarse_scene(PLUG, given)).summary["warnings"]
    assert any("target 'hot' not met when the phases were through" in text for text in warnings)


def test_a_target_that_held_from_the_start_says_so():
    given = {"operation.initial_temperature": 363.15, "operation.inlet_temperature": 298.15, "operation.end_time": 50.0}
    given |= {"target.list": [{"name": "warm", "above": "40 degC"}]}
    warnings = run(coarse_scene(PLUG, given)).summary["warnings"]
    assert any("it held from the start" in text for text in warnings)


def test_pumping_work_beside_a_heater_is_that_up_to_the_answer():
    """A target that is met long after the wall is heated: the work was that up to the heating time, half of it."""
    given = {"operation.heater_power": "200 kW", "operation.end_time": None}
    given |= {"target.list": [{"name": "even", "place": "wall", "within": 0.2}]}
    result = run(coarse_scene(PLUG, given))
    until, history = result.summary["energy"]["until"], result.history
    assert until == pytest.approx(result.summary["targets"]["even"]) and until > 1.3 * result.heating_time
    falls = (1.0 + np.array(history["pressure_drop"]) / 101325.0) ** (-287.05 / 1009.0)
    before = history["time"] < until
    power = history["mass_flow"] * 1009.0 * history["inlet_temperature"] * (1.0 - falls)
    times, powers = np.append(history["time"][before], until), np.append(power[before], power[-1])
    work = np.sum(0.5 * (powers[1:] + powers[:-1]) * np.diff(times))
    assert result.summary["pumping_work"] == pytest.approx(work, rel=0.02)


def test_what_the_heater_lacks_is_not_called_a_loss_of_the_wall():
    """The wall is as warm as what enters: its losses do not keep it from the set-point."""
    given = {"operation.heater_power": "400 W", "operation.end_time": 30000.0, "operation.outer_coefficient": 0.05}
    given |= {"operation.ambient_temperature": 298.15}
    text = next(one for one in run(coarse_scene(PLUG, given)).summary["warnings"] if one.startswith("not heated"))
    assert "the heater is at its limit" in text and "balance" not in text


PLUG = {"model.turbulence": "none", "model.flow": "plug"}


def test_a_frozen_flow_is_told_by_how_much_it_is_off():
    """The mass flow at the end is that of the start times what the warning says, its time off by half of that or more; of a given
    mass flow the pressure drop is off. Where nothing changes nothing is said."""
    driven = coarse_scene({"model.turbulence": "none", "model.flow": "developed"})
    followed, frozen = (run(driven.changed({"model.flow_update": one})) for one in ("quasi-steady", "frozen"))
    (told,) = [text for text in frozen.warnings if "frozen" in text]
    ratio = followed["mass_flow"][-1] / frozen["mass_flow"][-1]
    assert float(re.search(r"would be ([\d.]+) times", told)[1]) == pytest.approx(ratio, rel=0.01)
    assert 1.0 < followed.heating_time / frozen.heating_time < 1.0 / ratio
    given = driven.changed({"operation.pressure_drop": None, "operation.mass_flow": 0.04})
    followed, frozen = (run(given.changed({"model.flow_update": one})) for one in ("quasi-steady", "frozen"))
    (told,) = [text for text in frozen.warnings if "frozen" in text]
    drops = [one["pressure_drop"][-1] for one in (followed, frozen)]
    assert float(re.search(r"factor of up to ([\d.]+) more", told)[1]) == pytest.approx(drops[0] / drops[1], rel=0.05)
    assert followed.heating_time == pytest.approx(frozen.heating_time, rel=2e-3)
    same = {"model.flow_update": "frozen", "operation.initial_temperature": 363.0, "operation.heating_margin": 0.01}
    for quiet in (driven.changed(same), driven):
        assert not any("frozen" in text for text in check(quiet, MPI.COMM_SELF).warnings)


@pytest.mark.parametrize(
    ("settings", "at_least"),
    [
        ({"bed.bead_diameter": 5e-4, "operation.pressure_drop": 1e5}, 0.02),
        ({"bed.bead_diameter": 1e-3, "operation.pressure_drop": 6e4}, 0.05),
        ({"bed.bead_diameter": 1e-3, "operation.pressure_drop": 1e3, "fluid.material": "water"}, 0.01),
    ],
)
def test_the_film_at_the_wall_that_one_temperature_leaves_out_is_told(settings, at_least):
    """Beads that give no heat to the wall: two temperatures take longer by what is told, within a factor of four. Closures that
    let beads and wall share their conduction have no such film."""
    scene = coarse_scene(PLUG | settings)
    one, two = (run(scene.changed({"model.energy": f"{number}-temperature"})) for number in ("one", "two"))
    longer = two.heating_time / one.heating_time - 1.0
    (told,) = [text for text in one.warnings if "one temperature" in text]
    assert longer > at_least
    assert 0.25 < float(re.search(r"of the order of ([\d.]+)%", told)[1]) / 100.0 / longer < 4.0
    sharing = scene.changed({"model.energy": "one-temperature", "model.closures": "measured"})
    assert not any("gives no heat" in text or "give no heat" in text for text in check(sharing, MPI.COMM_SELF).warnings)
