"""Runs that start from a profile along the flow, or from the last state of another run."""

import numpy as np
import pytest
from mpi4py import MPI

from porousmold import InputError, Scene, run
from porousmold.scene.identity import identity_of
from porousmold.scene.start import LastState
from porousmold.simulation.observation import field_snapshots
from porousmold.simulation.specs import specs_of
from tests.support import FIELD_CASES, STUDIES, coarse_scene, problem_of, simulation_of

STORE = FIELD_CASES / "17-tes-cycle" / "tes.toml"
PROFILE = "x [cm], temperature [degC]\n0, 500\n30, 480\n50, 200\n100, 25\n"
QUIET = {"output.pictures": False}


@pytest.fixture
def profile(tmp_path):
    path = tmp_path / "start.csv"
    path.write_text(PROFILE)
    return str(path)


@pytest.mark.parametrize("energy", ["two-temperature", "one-temperature"])
def test_a_profile_is_what_the_bed_starts_from(profile, energy):
    problem = problem_of(Scene.load(STORE, {"operation.initial_temperature": profile, "model.energy": energy}))
    along = np.linspace(0.0, 1.0, 101)
    off_corners = np.abs(along[:, None] - [0.3, 0.5]).min(axis=1) > 0.12  # two cells
    exact = 273.15 + np.interp(along, [0.0, 0.3, 0.5, 1.0], [500.0, 480.0, 200.0, 25.0])
    for function in (problem.temperature, problem.bead_temperature):
        found = problem.along_the_bed(function)[:, 0]
        assert found[off_corners] == pytest.approx(exact[off_corners], abs=1e-9) and found == pytest.approx(
            exact, abs=20.0
        )
    assert problem.heat_kept()["beads"] == pytest.approx(0.0, abs=1.0)


@pytest.mark.parametrize("place", [0.3, 0.3111, 0.3222, 0.3333])
def test_a_step_of_the_profile_keeps_its_heat_wherever_it_lies_between_nodes(tmp_path, place):
    """Values at the nodes alone put it up to half a cell off: 5 % of what a bed of 30 cells stores."""
    path = tmp_path / "step.csv"
    path.write_text(f"x [m], temperature [degC]\n0, 500\n{place}, 500\n{place + 1e-6}, 25\n1, 25\n")
    problem = problem_of(Scene.load(STORE, {"operation.initial_temperature": str(path)}))
    for function in (problem.temperature, problem.bead_temperature):
        assert problem.bed.mean(function) == pytest.approx(298.15 + 475.0 * (place + 5e-7), rel=1e-6)
        assert function.x.array.min() >= 298.15 - 1e-9 and function.x.array.max() <= 773.15 + 1e-9


def test_heat_of_a_profile_is_given_back_to_cold_gas(profile):
    settings = {
        "operation.initial_temperature": profile,
        "operation.inlet_temperature": "25 degC",
        "operation.end_time": "20 h",
    }
    result = run(Scene.load(STORE, settings | QUIET), communicator=MPI.COMM_SELF)
    bed = 0.6 * 5000.0 * 800.0 * np.pi * 0.09 / 4.0
    profile_area = np.trapezoid if hasattr(np, "trapezoid") else np.trapz
    stored = bed * profile_area([475.0, 455.0, 175.0, 0.0], [0.0, 0.3, 0.5, 1.0])
    assert -result["heat_stored"][-1] == pytest.approx(stored, rel=0.01)
    assert result.summary["temperature_bounds"][1] < 773.15 + 0.3


def test_a_state_goes_to_a_mesh_in_its_place_alone(tmp_path):
    """Temperatures beyond those of the run are not made up: half a mold is no whole one, nor a wider one, nor in 3-D."""
    short = {"model.flow": "plug", "model.turbulence": "none", "operation.end_time": 30.0}
    layer = [{"name": "other", "material": "aluminium", "thickness": 0.003}]
    run(coarse_scene(short), tmp_path / "half", MPI.COMM_SELF)
    start = {"operation.initial_temperature": None, "operation.initial_state": str(tmp_path / "half")}
    for change, words in (
        (
            {"geometry.cavity": "whole", "wall.opposite_layer": layer},
            r"x\[1\] = 0 and 0.028 m, and this mesh lies between -0.02",
        ),
        ({"geometry.cavity_height": 0.1}, "it has no temperatures there"),
        ({"geometry.width": 0.2, "model.flow": "developed"}, "2 dimensions, and this one has 3"),
    ):
        with pytest.raises(InputError, match=words):
            simulation_of(coarse_scene(short | start | change), MPI.COMM_SELF)
    thin = simulation_of(coarse_scene(short | start | {"model.wall": "thin"}), MPI.COMM_SELF).problem
    assert thin.places.extremes("bed")[1] > 320.0


@pytest.mark.parametrize("refined", [1.0, 1.7])
def test_a_run_goes_on_from_the_last_state_of_another_one(tmp_path, refined):
    """On the same mesh nothing is lost; on another one it is interpolated."""
    settings = {"operation.end_time": "2 h"} | QUIET
    first = run(Scene.load(STORE, settings), tmp_path / "charge", MPI.COMM_SELF)
    whole = run(Scene.load(STORE, settings | {"operation.end_time": "4 h"}), communicator=MPI.COMM_SELF)
    more = {"operation.initial_temperature": None, "operation.initial_state": str(tmp_path / "charge")}
    second = run(Scene.load(STORE, settings | more | {"solver.mesh_refinement": refined}), communicator=MPI.COMM_SELF)
    assert second["outlet_temperature"][-1] == pytest.approx(whole["outlet_temperature"][-1], abs=2.0)
    total = first["heat_stored"][-1] + second["heat_stored"][-1]
    assert total == pytest.approx(whole["heat_stored"][-1], rel=1e-4 if refined == 1.0 else 3e-3)


def test_the_state_on_the_same_mesh_is_the_same_to_the_last_digits(tmp_path):
    scene = Scene.load(STUDIES / "mold" / "aluminium.toml", {"operation.end_time": 300.0, "output.pictures": False})
    run(scene, tmp_path / "run", MPI.COMM_SELF)
    begun = scene.changed({"operation.initial_temperature": None, "operation.initial_state": str(tmp_path / "run")})
    problem = problem_of(begun)
    state = problem.specs.heat.start
    places = problem.temperature.function_space.tabulate_dof_coordinates()
    again = state.at(places, places, of_beads=False)
    assert problem.temperature.x.array == pytest.approx(again, rel=1e-15)
    assert problem.bed.mean(problem.bead_temperature) > 300.0
    assert begun.operation.initial_temperature == pytest.approx(state.mean(None))


def test_identity_follows_the_content_of_what_it_starts_from(tmp_path, profile):
    scene = Scene.load(STORE, {"operation.initial_temperature": profile})
    (tmp_path / "other.csv").write_text(PROFILE)
    (tmp_path / "changed.csv").write_text(PROFILE.replace("480", "481"))
    same, other = (
        scene.changed({"operation.initial_temperature": str(tmp_path / name)}) for name in ("other.csv", "changed.csv")
    )
    assert identity_of(scene) == identity_of(same) != identity_of(other)
    again = Scene(scene.as_tables())
    assert identity_of(again) == identity_of(scene) and specs_of(again).heat.start.values == scene.start.values


@pytest.mark.parametrize(("content", "words"), [
    ("x [m], temperature [degC]\n0, 20\n0, 30\n", "increase"),
    ("x [m], temperature [degC], more [degC]\n0, 20, 20\n1, 30, 20\n", "two columns"),
    ("x [s], temperature [degC]\n0, 20\n1, 30\n", "length"),
    ("x [m], temperature [degC]\n0, -300\n1, 30\n", "> 0 and < 5000 K"),
    ("x, temperature\n0, 20\n", "unit"),
])  # fmt: skip
def test_a_profile_that_is_none_is_refused_in_one_line(tmp_path, content, words):
    (tmp_path / "start.csv").write_text(content)
    with pytest.raises(InputError, match=words) as refusal:
        Scene.load(STORE, {"operation.initial_temperature": str(tmp_path / "start.csv")})
    assert "\n" not in str(refusal.value)


def test_a_state_that_is_none_is_refused_in_one_line(tmp_path):
    (tmp_path / "damaged").mkdir()
    (tmp_path / "damaged" / "fields.xdmf").write_text("<Xdmf")
    for folder, words in (
        (tmp_path, "wrote its fields"),
        (tmp_path / "damaged", "cannot be read"),
        (tmp_path / "none", "wrote"),
    ):
        with pytest.raises(InputError, match=words):
            Scene.load(STORE, {"operation.initial_temperature": None, "operation.initial_state": str(folder)})
    with pytest.raises(InputError, match="folder of a run"):
        Scene.load(STORE, {"operation.initial_state": 3})


def test_the_mean_of_a_profile_is_that_of_the_bed(tmp_path):
    """Rows beyond the bed, and unevenly spaced ones, count for what they say of it: programmes begin there."""
    path = tmp_path / "start.csv"
    path.write_text("x [m], temperature [degC]\n-1, 500\n0, 20\n0.5, 80\n400, 80\n")
    scene = coarse_scene({"operation.initial_temperature": str(path)})
    length = scene.geometry.length
    exact = 273.15 + (50.0 * 0.5 + 80.0 * (length - 0.5)) / length
    assert scene.operation.initial_temperature == pytest.approx(exact, abs=1e-9)
    result = run(scene.changed({"operation.end_time": 1.0, "model.flow": "plug", "model.turbulence": "none"}))
    assert any("distances in another unit?" in text for text in result.summary["warnings"])
    path.write_text("x [m], temperature [degC]\n10, 20\n20, 80\n")
    with pytest.raises(InputError, match="outside the bed"):
        run(coarse_scene({"operation.initial_temperature": str(path)}))


def test_a_state_of_a_mold_is_none_of_a_pipe(tmp_path):
    plug = {"model.flow": "plug", "model.turbulence": "none", "operation.end_time": 5.0}
    mold = coarse_scene(plug | {"output.pictures": False})
    run(mold, out=tmp_path / "mold")
    height = mold.geometry.cavity_height
    pipe = {"geometry.kind": "pipe", "geometry.cavity_height": None, "geometry.diameter": height}
    with pytest.raises(InputError, match="is of a plane bed, and this one is a bed about an axis"):
        run(
            mold.changed(
                pipe | {"operation.initial_temperature": None, "operation.initial_state": str(tmp_path / "mold")}
            )
        )


def cycling(*more, **operation):
    """A store whose phases end by what leaves, and by `more` phases."""
    phases = [
        {"name": "charge", "mass_flow": 0.01, "temperature": "500 degC", "until_outlet_above": "100 degC"},
        {"name": "discharge", "mass_flow": -0.01, "temperature": "25 degC", "until_outlet_below": "470 degC"},
        *more,
    ]
    settings = dict.fromkeys(("operation.mass_flow", "operation.inlet_temperature", "operation.end_time"))
    settings |= {"operation.phase": phases, "solver.axial_cells": 20} | QUIET
    return Scene.load(STORE, settings | {f"operation.{name}": value for name, value in operation.items()})


@pytest.mark.parametrize("turns", [True, False])
def test_the_last_state_of_a_store_is_that_of_its_end(tmp_path, turns):
    """The last field was one kept up to 110 K earlier where phases end by a temperature, and turned end for end. (Cells of the
    other scene stand a little elsewhere.)"""
    rest = () if turns else ({"name": "rest", "duration": "10 min"},)
    scene = cycling(*rest, cycles=30, cycle_tolerance=0.02)
    result = run(scene, tmp_path / "run", communicator=MPI.COMM_SELF)
    assert len(result["time"]) > 40
    settings = dict.fromkeys(("operation.inlet_temperature", "operation.initial_temperature"))
    settings |= {
        "operation.initial_state": str(tmp_path / "run"),
        "operation.end_time": "1 s",
        "solver.axial_cells": 20,
    }
    settings |= {"operation.inlet_temperature": "25 degC"}
    after = run(Scene.load(STORE, settings | QUIET), communicator=MPI.COMM_SELF)
    for place in ("L/4", "L/2"):
        assert after[f"temperature_centre_{place}"][0] == pytest.approx(
            result[f"temperature_centre_{place}"][-1], abs=1.0
        )


def test_fields_of_a_store_are_of_their_times():
    """Between snapshots many steps apart, or of two phases, a straight line was up to 160 K off."""
    simulation = simulation_of(cycling(cycles=4).changed({"output.field_times": 10})).integrate()
    history, course = simulation.recorder.history, simulation.specs.course
    times, problem, count = np.array(history["time"]), simulation.problem, 0
    for time, (temperature, *_) in field_snapshots(problem, simulation.recorder.snapshots.fields, simulation.time):
        after = int(np.searchsorted(times, time * (1.0 - 1e-9)))
        steps = [n for n in (after - 1, after) if course.phase_number(times[n]) == course.phase_number(time)]
        values = [history["temperature_centre_L/4"][n] for n in steps]
        found = problem.along_the_bed(temperature)[:, 0]
        found = np.interp(0.25, np.linspace(0.0, 1.0, len(found)), found)
        assert min(values) - 1e-6 <= found <= max(values) + 1e-6
        count += 1
    assert count >= 8


def test_a_state_is_linear_along_the_rim_of_its_mesh(tmp_path):
    """Places that rounding puts beyond the outer surface got the nearest node's temperature: up to 14 K off."""
    hot = {"operation.end_time": 600.0, "model.flow": "plug", "model.turbulence": "none"}
    run(coarse_scene(hot | QUIET), tmp_path, MPI.COMM_SELF)
    state = LastState.read(tmp_path, None)
    nodes, *_ = state._last
    along, across = np.linspace(0.05, 0.95, 19), nodes[:, 1].max()
    within, on, beyond = (
        state.at(np.column_stack([along, np.full(19, y), 0.0 * along]), np.zeros(19), of_beads=False)
        for y in (across * (1.0 - 1e-7), across, across * (1.0 + 1e-12))
    )
    assert np.ptp(within) > 5.0
    assert on == pytest.approx(within, abs=1e-4) and beyond == pytest.approx(within, abs=1e-4)
