"""Answers that a coarser run does not confirm: what is repeated, on which cells, and what is told."""

from types import SimpleNamespace

import pytest

from porousmold import InputError, run
from porousmold.errors import SolveError
from porousmold.scene.scene import Scene
from porousmold.simulation import running
from porousmold.simulation.accuracy import (
    ALL_IN_DOUBT,
    AT_END,
    COARSER,
    FINEST_IN_DOUBT,
    IN_DOUBT,
    LARGEST_DIFFERENCE,
    STILL_IN_DOUBT,
    Answer,
    Refinements,
    is_still_in_doubt,
    refinements_in_doubt,
)
from porousmold.simulation.answers import BEGINS_LATE, FINGERS, doubt_of
from porousmold.simulation.running import RunInterrupted
from porousmold.simulation.time_integration import Simulation

from ..support import STUDIES, coarse_scene
from .test_accuracy import Integration, front_in_the_bed


def test_a_front_that_stands_in_the_bed_at_the_end_is_compared_with_a_coarser_run():
    """Its difference bounds the true error on cells near the default's size, and is warned of; a run that is heated costs nothing
    more."""
    result = run(front_in_the_bed({"solver.mesh_refinement": 2.0}))
    errors, warned = result.summary["end_errors"], [w for w in result.summary["warnings"] if "coarser cells" in w]
    finer = run(front_in_the_bed({"solver.mesh_refinement": 4.0, "solver.step_refinement": 2.0}))
    span = max(finer["highest_temperature"]) - min(finer["lowest_temperature"])
    true = max(
        abs(result[name][-1] - finer[name][-1]) / span for name in result.history if name.startswith("temperature_")
    )
    assert max(errors.values()) > 0.5 * true and bool(warned) == (max(errors.values()) > LARGEST_DIFFERENCE)
    heated = run(coarse_scene({"model.flow": "plug", "model.turbulence": "none"}))
    assert heated.summary["end_errors"] == {} and heated.summary["heating_time_error"] is None


@pytest.mark.parametrize("direction", [0, 1, 2])
def test_what_is_in_doubt_is_refined_in_the_direction_of_its_error(direction):
    """Of temperatures at the end; of times coarse steps hide what cells do."""
    errors = [1e-5] * 3
    errors[direction] = 0.01
    times, scene = Integration(*errors), coarse_scene()

    def at_end(scene):
        return {f"{AT_END}outlet_temperature": answer for answer in times(scene).values()}

    refinements = refinements_in_doubt(scene, at_end(scene), at_end(COARSER.of(scene)), at_end)
    assert refinements == Refinements(*(IN_DOUBT if each == direction else 1.0 for each in range(3)))
    assert refinements_in_doubt(scene, times(scene), times(COARSER.of(scene)), times) == ALL_IN_DOUBT


def test_all_directions_are_refined_where_coarse_runs_say_nothing():
    def fails(scene):
        raise SolveError("flow", 0.0, "no steady flow", "")

    own = {f"{AT_END}outlet_temperature": Answer.by_itself(1000.0)}
    assert refinements_in_doubt(coarse_scene(), own, own, fails) == ALL_IN_DOUBT


def test_a_repeat_that_moves_an_answer_far_is_repeated_once_more():
    little, much = {"heating_time": 0.9 * STILL_IN_DOUBT}, {"heating_time": 1.1 * STILL_IN_DOUBT}
    once = Refinements(along=IN_DOUBT)
    assert is_still_in_doubt(much, once) and not is_still_in_doubt(little, once) and not is_still_in_doubt({}, once)
    assert not is_still_in_doubt(much, Refinements(steps=FINEST_IN_DOUBT))


WITH_DEFAULT_CELLS = {"solver.axial_cells": None, "solver.cell_growth": None}


def test_an_answer_in_doubt_is_that_of_finer_cells():
    """A front of default cells and of twice as many along the flow: half of the error at most (steps add to both), which the
    difference bounds. Cells that the user chose are kept."""
    finest = WITH_DEFAULT_CELLS | {"solver.axial_refinement": 6.0, "solver.step_refinement": 2.0}
    reference = run(front_in_the_bed(finest))
    span = max(reference["highest_temperature"]) - min(reference["lowest_temperature"])
    names = [name for name in reference.history if name.startswith("temperature_")]
    refined, plain = (
        run(front_in_the_bed(WITH_DEFAULT_CELLS | {"solver.refine_in_doubt": doubt})) for doubt in (True, False)
    )
    error, of_default = (
        max(abs(result[name][-1] - reference[name][-1]) / span for name in names) for result in (refined, plain)
    )
    assert refined.summary["refinements"] == {"along": 2.0, "across": 1.0, "steps": 2.0}
    assert error < min(0.5 * of_default, max(refined.summary["end_errors"].values()))
    assert any("2 times the cells along the flow" in warning for warning in refined.summary["warnings"])
    assert plain.summary["refinements"] == {"along": 1.0, "across": 1.0, "steps": 1.0}
    assert run(front_in_the_bed()).summary["refinements"] == {"along": 1.0, "across": 1.0, "steps": 1.0}


def test_a_run_whose_finer_cells_have_no_flow_keeps_its_answer(monkeypatch):
    scene, integrate = front_in_the_bed(WITH_DEFAULT_CELLS), Simulation.integrate
    unknowns = run(scene.changed({"solver.refine_in_doubt": False})).summary["unknowns"]["energy"]

    def fails_on_finer_cells(self, *arguments, **keywords):
        if self.problem.unknowns["energy"] > unknowns:
            raise SolveError("flow", 0.0, "no steady flow", "another mesh")
        return integrate(self, *arguments, **keywords)

    monkeypatch.setattr(Simulation, "integrate", fails_on_finer_cells)
    result, plain = run(scene), run(scene.changed({"solver.refine_in_doubt": False}))
    assert result.summary["status"] == "done" and result.summary["end_errors"] == plain.summary["end_errors"]
    assert result["outlet_temperature"][-1] == plain["outlet_temperature"][-1]
    assert result.summary["warnings"] == plain.summary["warnings"]


def test_a_repeat_that_takes_many_iterations_is_given_up(monkeypatch):
    """As on cells on which each step seeks a steady flow in vain: water at a Reynolds number of 1500 with k-epsilon went on for
    hours. The answer is that of the first integration."""
    scene = front_in_the_bed(WITH_DEFAULT_CELLS | {"model.flow": "full"})
    plain = run(scene.changed({"solver.refine_in_doubt": False}))
    assert run(scene).summary["refinements"] != plain.summary["refinements"]
    monkeypatch.setattr(running, "MOST_ITERATIONS", 0.1)
    monkeypatch.setattr(running, "ITERATIONS_OF_START", 0)
    result = run(scene)
    assert result.summary["refinements"] == plain.summary["refinements"]
    assert result["outlet_temperature"][-1] == plain["outlet_temperature"][-1]


def test_a_second_integration_is_resumed_but_not_for_another_end(tmp_path):
    """What is resumed is the second integration, whose answer is compared with that of the first."""
    scene, integrations = front_in_the_bed(WITH_DEFAULT_CELLS), []
    whole = run(scene)

    def in_the_second(time, deficit, simulation):
        integrations.extend([simulation] if simulation not in integrations else [])
        return None

    with pytest.raises(RunInterrupted):
        run(scene, tmp_path / "run", progress=in_the_second, stop=lambda: len(integrations) > 1)
    with pytest.raises(InputError, match="--resume"):
        run(scene.changed({"operation.end_time": 150.0}), tmp_path / "run", resume=True)
    integrations.clear()
    resumed = run(scene, tmp_path / "run", progress=in_the_second, resume=True)
    assert len(integrations) == 1 and resumed.summary["refinements"]["along"] == 2.0
    assert resumed["outlet_temperature"][-1] == pytest.approx(whole["outlet_temperature"][-1], abs=1e-6)
    assert resumed.summary["end_errors"] == pytest.approx(whole.summary["end_errors"], abs=1e-7)


def test_a_second_integration_that_followed_at_once_is_resumed(tmp_path, monkeypatch):
    """Coarser cells confirm the answer of the first one, whose doubt they do not settle: it is kept in the checkpoint."""
    monkeypatch.setattr(running, "doubt_of", lambda recorder, answers: BEGINS_LATE)
    monkeypatch.setattr(running, "LARGEST_DIFFERENCE", 1.0)
    monkeypatch.setattr(running, "is_still_in_doubt", lambda moved, refined: False)
    scene, integrations = front_in_the_bed(WITH_DEFAULT_CELLS), []
    whole = run(scene)
    assert whole.summary["refinements"] == {"along": 2.0, "across": 1.0, "steps": 1.0}

    def in_the_second(time, deficit, simulation):
        integrations.extend([simulation] if simulation not in integrations else [])

    with pytest.raises(RunInterrupted):
        run(scene, tmp_path / "run", progress=in_the_second, stop=lambda: len(integrations) > 1)
    monkeypatch.setattr(running, "doubt_of", lambda recorder, answers: "")
    resumed = run(scene, tmp_path / "run", resume=True)
    assert resumed.summary["refinements"] == whole.summary["refinements"]
    assert resumed["outlet_temperature"][-1] == pytest.approx(whole["outlet_temperature"][-1], abs=1e-6)


def test_fingers_are_repeated_once_whatever_moved(monkeypatch):
    """No number of repeats settles them; the third integration takes most of the time."""
    scene = front_in_the_bed(WITH_DEFAULT_CELLS | {"solver.mesh_refinement": None})
    monkeypatch.setattr(running, "is_still_in_doubt", lambda moved, refined: max(refined) < FINEST_IN_DOUBT)
    monkeypatch.setattr(running, "doubt_of", lambda recorder, answers: FINGERS)
    assert run(scene).summary["refinements"] == {"along": 2.0, "across": 2.0, "steps": 2.0}


TRANSITION = {
    "geometry": {"kind": "mold", "length": 0.334, "cavity_height": 0.104},
    "bed": {"bead_diameter": 0.00373, "porosity_model": "white-tien", "bulk_porosity": 0.438,
            "bead_density": 1180.0, "bead_heat_capacity": 1700.0, "bead_conductivity": 0.48},
    "wall": {"thickness": 0.0028, "material": "aluminium"},
    "operation": {"initial_temperature": 522.0, "inlet_temperature": 372.0, "pressure_drop": 20186.0,
                  "heating_margin": 20.0},
    "model": {"flow": "full", "turbulence": "k-epsilon"},
}  # fmt: skip
"""Turbulence without bead sources that begins in the second quarter of a short bed."""


def test_turbulence_that_begins_within_the_bed_is_that_of_finer_cells():
    """Default cells were 1.4 % too soon, in silence, and solver.accuracy certified 0.07 %."""
    scene = Scene(TRANSITION)
    plain, refined = run(scene.changed({"solver.refine_in_doubt": False})), run(scene)
    finest = run(scene.changed({"solver.axial_refinement": 6.0}))
    error, of_default = (abs(one.heating_time / finest.heating_time - 1.0) for one in (refined, plain))
    assert error < 0.4 * of_default and error < refined.summary["heating_time_error"]
    assert refined.summary["refinements"] == {"along": 4.0, "across": 1.0, "steps": 1.0}
    assert any("begins within the bed" in warning for warning in refined.summary["warnings"])


def test_a_target_that_is_not_met_leaves_the_temperatures_at_the_end_to_be_estimated():
    targets = {"target": [{"name": "warm", "above": "60 degC"}, {"name": "hot", "above": "89.9 degC"}]}
    changes = {
        "model.flow": "plug",
        "model.turbulence": "none",
        "operation.end_time": "1500 s",
        "solver.accuracy": 0.02,
    }
    scene = coarse_scene(changes | {"solver.mesh_refinement": None, "solver.step_refinement": None})
    result = run(Scene(scene.as_tables() | targets))
    summary = result.summary
    assert summary["targets"]["hot"] is None and set(summary["target_errors"]) == {"warm"}
    assert 0.0 < max(summary["end_errors"].values()) <= 0.02 and "temperature_outer_L" in summary["end_errors"]


def test_a_run_as_coarse_as_is_allowed_has_no_coarser_one():
    """The front alone is told then; the run has its answer."""
    result = run(front_in_the_bed({"solver.mesh_refinement": 0.12, "solver.step_refinement": 0.12}))
    assert result.summary["status"] == "done" and result.summary["end_errors"] == {}
    assert any("within one cell of the bed" in warning for warning in result.summary["warnings"])


def test_on_a_mesh_of_ones_own_a_front_at_the_end_is_that_of_halved_cells(monkeypatch):
    """What halving moves bounds what another halving does, which follows where it is much; without it the front is warned of."""
    settings = {"model.flow": "developed", "model.turbulence": "none", "operation.end_time": 60.0}
    scene = Scene.load(STUDIES / "mold" / "curved.toml", settings)
    twice, plain = run(scene), run(scene.changed({"solver.refine_in_doubt": False}))
    monkeypatch.setattr(running, "MOST_WORK_AGAIN", 0.0)
    once = run(scene)
    span = max(twice["highest_temperature"]) - min(twice["lowest_temperature"])
    error, of_plain = (
        max(abs(each[name][-1] - twice[name][-1]) / span for name in each.history if name.startswith("temperature_"))
        for each in (once, plain)
    )
    assert once.summary["refinements"] == {"along": 2.0, "across": 2.0, "steps": 2.0}
    assert twice.summary["refinements"] == {"along": 4.0, "across": 4.0, "steps": 4.0}
    assert max(twice.summary["end_errors"].values()) == pytest.approx(error, rel=0.05)
    assert error < min(0.25 * of_plain, max(once.summary["end_errors"].values()))
    assert any("within one cell of the bed" in warning for warning in plain.summary["warnings"])


@pytest.mark.parametrize("factor", [0.5, 3.0])
def test_cells_of_a_mesh_of_ones_own_are_halved_or_left(factor):
    with pytest.raises(InputError, match=r"solver\.mesh_refinement.*must be 1, 2, 4 or 8"):
        Scene.load(STUDIES / "mold" / "curved.toml", {"solver.mesh_refinement": factor})
    with pytest.raises(InputError, match=r"solver\.mesh_refinement.*no place in a mesh in three dimensions"):
        Scene.load(STUDIES / "mold" / "shell.toml", {"solver.mesh_refinement": 2.0})


def test_a_place_that_heat_from_elsewhere_brings_beyond_the_inlet_is_compared():
    """Its last side, cold beads at the inlet beside a wall that a flux heats, warms slowly: 0.6 % off on default cells."""
    scene = Scene.load(
        STUDIES / "pipe" / "baseline.toml",
        {
            "geometry.length": 0.2538,
            "geometry.diameter": 0.12715,
            "bed.bead_diameter": 5.65e-3,
            "bed.bead_material": "ceramic",
            "bed.bulk_porosity": 0.35485,
            "bed.porosity_model": "white-tien",
            "fluid.material": "air",
            "wall.material": "acrylic",
            "wall.thickness": 0.911e-3,
            "operation.initial_temperature": 513.93,
            "operation.inlet_temperature": 531.23,
            "operation.bead_inlet_temperature": 513.93,
            "operation.bead_velocity": 3.227e-4,
            "operation.outer_heat_flux": 300.0,
            "operation.heating_margin": 0.692,
            "operation.pressure_drop": 613.7,
            "operation.end_time": 600.0,
            "model.flow": "plug",
            "model.turbulence": "none",
            "model.closures": "measured",
        },
    )
    result, plain, finer = (
        run(scene.changed(settings))
        for settings in (
            {},
            {"solver.refine_in_doubt": False},
            {"solver.mesh_refinement": 4.0, "solver.step_refinement": 4.0},
        )
    )
    error, of_plain = (abs(each.heating_time / finer.heating_time - 1.0) for each in (result, plain))
    assert error < of_plain and error < min(4e-3, 2.0 * result.summary["heating_time_error"])
    assert any(
        "heat from elsewhere" in text and "moved the heating time" in text for text in result.summary["warnings"]
    )
    assert any("heat from elsewhere" in text and "move the heating time" in text for text in plain.summary["warnings"])


def early_scene(tmp_path, *targets):
    """The aluminium mold with sensors 10 and 100 mm behind the inlet, and these targets of theirs (°C) by names."""
    sensors = tmp_path / "sensors.csv"
    sensors.write_text("name,x [mm],y [mm]\nfirst,10,5\nsecond,100,5\n")
    asked = [{"name": f"{place}_{limit}", "place": place, "above": f"{limit} degC"} for place, limit in targets]
    tables = coarse_scene({"geometry.sensors": str(sensors), **WITH_DEFAULT_CELLS, **PLUG}).as_tables()
    return Scene(tables | {"target": asked}).changed({"solver.mesh_refinement": None, "solver.step_refinement": None})


PLUG = {"model.flow": "plug", "model.turbulence": "none"}


def test_a_time_within_the_first_steps_is_that_of_finer_ones(tmp_path):
    """It was half of the true one, in silence: by the straight line through the first step. What is left is told."""
    scene = early_scene(tmp_path, ("first", 60))
    plain, refined = run(scene.changed({"solver.refine_in_doubt": False})), run(scene)
    finest = run(scene.changed({"solver.axial_refinement": 8.0, "solver.step_refinement": 16.0}))
    error, of_default = (
        abs(one.summary["targets"]["first_60"] / finest.summary["targets"]["first_60"] - 1.0)
        for one in (refined, plain)
    )
    assert of_default > 0.1 and error < 0.3 * of_default and error < refined.summary["target_errors"]["first_60"]
    assert any("within the first steps" in warning for warning in refined.summary["warnings"])


def test_a_sensor_near_the_inlet_is_that_of_finer_cells(tmp_path):
    """Where a front has just come in it is as sharp as few cells are long: 35 °C came 3.4 % too soon, 88 °C 2.6 % too late."""
    scene = early_scene(tmp_path, ("second", 35), ("second", 88))
    plain, refined = run(scene.changed({"solver.refine_in_doubt": False})), run(scene)
    finest = run(scene.changed({"solver.axial_refinement": 8.0, "solver.step_refinement": 4.0}))
    error, of_default = (
        max(abs(one.summary["targets"][name] / time - 1.0) for name, time in finest.summary["targets"].items())
        for one in (refined, plain)
    )
    assert of_default > 0.01 and error < 0.3 * of_default
    assert error < max(refined.summary["target_errors"].values())
    assert any("just come in" in warning for warning in refined.summary["warnings"])


@pytest.mark.parametrize(("part", "peak", "word"), [(0.2, 410.0, "one cell"), (0.01, 430.0, "cure"), (0.01, 401.0, "")])
def test_an_exotherm_is_in_doubt_whether_or_not_the_run_also_has_temperatures_at_its_end(part, peak, word):
    """A run without target that ends at operation.end_time has both: a quiet bed says nothing of the part that cures."""
    history = {
        "highest_temperature": [350.0, peak],
        "lowest_temperature": [350.0, 340.0],
        "inlet_temperature": [400.0, 400.0],
    }
    specs = SimpleNamespace(
        heat=SimpleNamespace(given_elsewhere=[]),
        time=SimpleNamespace(targets=()),
        mesh=SimpleNamespace(own=SimpleNamespace(mesh=None)),
        flow=SimpleNamespace(driven_by=SimpleNamespace(range=(0.0, 0.0))),
    )
    span = peak - 340.0
    medium = SimpleNamespace(estimates=SimpleNamespace(resistance_ratio=1.0))
    flow = SimpleNamespace(is_turbulent=lambda: False)
    problem = SimpleNamespace(specs=specs, medium=medium, flow=flow, largest_difference_in_a_cell=lambda: part * span)
    answers = {"peaks.part": Answer(peak, span), "end.heat_stored": Answer.by_itself(1e3)}
    doubt = doubt_of(SimpleNamespace(history=history, problem=problem), answers)
    assert word in doubt and bool(doubt) == bool(word)
