"""The value of a key that reaches a target: found, impossible, refused; the same under MPI."""

import json
import re
from dataclasses import replace

import pytest
from mpi4py import MPI

from porousmold import InputError, Scene, run
from porousmold.cli import main
from porousmold.output.report import write_report
from porousmold.study.solve_for import Change, aim_of, solve_for, summary_text

from ..support import ALUMINIUM, COARSE, coarse_scene, under_mpirun


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """What a coarse mold needs for 1200 s."""
    keys = ["wall.thickness", "operation.pressure_drop", "bed.bead_diameter"]
    changes = solve_for(coarse_scene(), keys, aim_of("heating_time = 20 min"), tmp_path_factory.mktemp("search"))
    return {change.key: change for change in changes}


def test_what_is_found_is_a_run_that_reaches_the_target(found):
    thickness, pressure = found["wall.thickness"], found["operation.pressure_drop"]
    assert thickness.reached == pytest.approx(1200.0, rel=0.003) and thickness.needed < thickness.value == 3e-3
    assert pressure.reached == pytest.approx(1200.0, rel=0.003) and pressure.needed > pressure.value == 8e3
    assert pressure.beside["mean_power"] > thickness.beside["mean_power"] > 0.0


def test_beads_that_would_not_fit_are_no_answer(found):
    beads = found["bed.bead_diameter"]
    assert beads.needed is None and "allow_small_ratio" in beads.reason and beads.tried == beads.value
    assert list(found)[-1] == "bed.bead_diameter"


@pytest.mark.parametrize(
    ("target", "named"),
    [
        ("heating_time", "RECORD = VALUE"),
        ("warmth = 3 s", "records"),
        ("heating_time = -3 s", "> 0"),
        ("heating_time = 3 kg", "time"),
    ],
)
def test_impossible_targets_are_refused(target, named):
    with pytest.raises(InputError, match=named):
        aim_of(target)


@pytest.mark.parametrize("target", ["heating_time = 60 h", "targets.nothing = 3 s", "energy.cost = 3"])
def test_targets_that_the_scene_cannot_have_are_refused(target, tmp_path):
    with pytest.raises(InputError, match="--target"):
        solve_for(coarse_scene(), ["wall.thickness"], aim_of(target), tmp_path)


@pytest.mark.parametrize(
    ("key", "told"),
    [
        ("wall.thicknes", "did you mean 'wall.thickness'"),
        ("target[1].abov", r"did you mean 'target\[1\].above'"),
        ("operation.programme[1].temperature", r"operation.programme\[1\] has to, rate, over, hold"),
    ],
)
def test_a_key_that_is_none_is_told_which_there_are(key, told, tmp_path):
    with pytest.raises(InputError, match=told):
        solve_for(coarse_scene(), [key], aim_of("heating_time = 20 min"), tmp_path)


@pytest.mark.parametrize(
    "key", ["wall.thicknes", "target", "wall.layer", "model.flow", "geometry.width", "wall.layer[1].thickness"]
)
def test_keys_without_a_number_are_refused(key, tmp_path):
    with pytest.raises(InputError, match="--key"):
        solve_for(coarse_scene(), [key], aim_of("heating_time = 20 min"), tmp_path)


def test_a_profile_is_no_number(tmp_path):
    """Its mean counted as the scene's value, and its time as that of a uniform start."""
    (tmp_path / "start.csv").write_text("x [m], temperature [degC]\n0, 60\n0.5, 20\n")
    scene = coarse_scene({"operation.initial_temperature": str(tmp_path / "start.csv")})
    with pytest.raises(InputError, match="--key"):
        solve_for(scene, ["operation.initial_temperature"], aim_of("heating_time = 20 min"), tmp_path)


def test_the_command_and_its_file(tmp_path, capsys):
    settings = [word for name, value in COARSE.items() for word in ("--set", f"{name}={value}")]
    words = ["solve-for", str(ALUMINIUM), "--key", "wall.thickness", "--target", "heating_time = 26 min", *settings]
    assert main([*words, "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert (
        printed.startswith("heating_time = 26 min by a single change of")
        and "wall.thickness" in printed
        and " mm: " in printed
    )
    change = json.loads((tmp_path / "solve_for.json").read_text())["changes"][0]
    assert change["reached"] == pytest.approx(1560.0, rel=0.003) and change["tried"] == change["needed"]
    report = write_report(tmp_path).read_text()
    assert "What must change" in report and "wall.thickness" in report and "1 done" not in report
    again = under_mpirun(2, "-m", "porousmold", *words, "--out", str(tmp_path), "--quiet")
    assert again.returncode == 0, again.stderr
    assert json.loads((tmp_path / "solve_for.json").read_text())["changes"][0] == change


def test_a_spread_is_a_difference_of_temperatures():
    """Given and shown in K, not in degrees Celsius."""
    scene, aim = coarse_scene({"model.flow": "plug", "model.turbulence": "none"}), aim_of("spread_at_end = 1.5 K")
    change = Change("wall.thickness", "m", 0.003, 0.002, 0.002, 1.5, {"mean_power": None, "energy_spent": None}, "")
    doubtful = replace(change, warning="coarser cells and steps move it by 5%")
    assert doubtful.warning in summary_text([doubtful], aim, scene)
    text = summary_text([change], aim, scene)
    assert aim.value == 1.5 and "spread_at_end = 1.5 K" in text and "1.5 K" in text and "°C" not in text


def test_the_initial_temperature_is_found_too(tmp_path):
    """It is varied from the inlet's temperature, as others are from the initial one: a warmer tool is heated sooner."""
    scene = coarse_scene({"model.flow": "plug", "model.turbulence": "none"})
    (change,) = solve_for(scene, ["operation.initial_temperature"], aim_of("heating_time = 30 min"), tmp_path)
    assert 298.15 < change.needed < 363.15 and change.reached == pytest.approx(1800.0, rel=2e-3)


AIR_LOOP = {
    "model.flow": "plug",
    "model.turbulence": "none",
    "operation.pressure_drop": None,
    "operation.blower_pressure": "6 kPa",
    "operation.blower_flow": "300 m^3/h",
    "operation.heater_power": "3 kW",
    "operation.recirculation": 0.6,
    "operation.energy_price": 0.3,
}


def test_a_search_goes_up_to_the_bound_of_its_key(tmp_path):
    """From a recirculation of 0.6 the second step would lead beyond 1: what 0.95 gives is found, 0.5 % from what 1 gives."""
    scene = coarse_scene(AIR_LOOP | {"operation.heater_power": "1.3 kW"})
    wanted = run(scene.changed({"operation.recirculation": 0.95}), communicator=MPI.COMM_SELF).heating_time
    (change,) = solve_for(scene, ["operation.recirculation"], aim_of(f"heating_time = {wanted} s"), tmp_path)
    assert change.reached == pytest.approx(wanted, rel=0.003) and change.needed == pytest.approx(0.95, abs=0.05)


def test_a_search_comes_near_to_what_is_refused(tmp_path):
    """More than 5 mm are refused in a cavity of 50 mm; 4.56 mm were the largest that was tried from 4 mm."""
    scene = coarse_scene({"bed.bead_diameter": "4 mm", "model.flow": "plug", "model.turbulence": "none"})
    wanted = run(scene.changed({"bed.bead_diameter": 4.93e-3}), communicator=MPI.COMM_SELF).heating_time
    (change,) = solve_for(scene, ["bed.bead_diameter"], aim_of(f"heating_time = {wanted} s"), tmp_path)
    assert change.reached == pytest.approx(wanted, rel=0.003) and 4.8e-3 < change.needed <= 5e-3


def test_surroundings_may_be_warmer_than_the_start(tmp_path):
    """They take heat at 20 degC and give some at 60: both sides of the initial temperature are searched."""
    losing = {"operation.outer_coefficient": 2.0, "operation.ambient_temperature": "20 degC", "model.flow": "plug"}
    scene = coarse_scene(losing | {"model.turbulence": "none", "operation.heating_margin": "8 K"})
    wanted = run(scene.changed({"operation.ambient_temperature": "60 degC"}), communicator=MPI.COMM_SELF).heating_time
    (change,) = solve_for(scene, ["operation.ambient_temperature"], aim_of(f"heating_time = {wanted} s"), tmp_path)
    assert change.needed == pytest.approx(333.15, abs=3.0)


def test_a_jump_is_not_all_that_is_told_of_a_search(tmp_path):
    """An inlet so near the start that the wall never comes within the margin takes for ever: no root lies there, and the nearest
    is the coldest inlet that was tried."""
    scene = Scene(
        {
            "geometry": {"kind": "mold", "length": 0.5, "cavity_height": 0.05},
            "bed": {"bead_diameter": 5e-3},
            "wall": {"material": "aluminium", "thickness": 3e-3},
            "operation": {
                **{
                    "initial_temperature": 298.15,
                    "inlet_temperature": 278.15,
                    "inlet_velocity": 0.8,
                    "end_time": 7200.0,
                },
                **{"outer_coefficient": 3.0, "ambient_temperature": 303.15, "heating_margin": 15.0},
            },
            "model": {"flow": "plug"},
            "solver": {"mesh_refinement": 0.5},
            "output": {"fields": False, "pictures": False},
        }
    )
    (change,) = solve_for(scene, ["operation.inlet_temperature"], aim_of("heating_time = 20 min"), tmp_path)
    assert change.needed is None and change.reason.startswith("not reached from ") and "jumps past it" in change.reason
    assert change.tried < 240.0 and change.reached > 1000.0


def test_what_was_tried_is_told(tmp_path):
    scene = coarse_scene({"model.flow": "plug", "model.turbulence": "none"})
    (change,) = solve_for(scene, ["wall.conductivity"], aim_of("heating_time = 10 min"), tmp_path)
    assert change.needed is None and change.reason.startswith("not reached from ")


def test_only_values_with_a_run_are_told_as_searched(tmp_path):
    """Beads too large for the bed are refused: their diameter is not among those searched."""
    scene = coarse_scene({"model.flow": "plug", "model.turbulence": "none"})
    (change,) = solve_for(scene, ["bed.bead_diameter"], aim_of("heating_time = 10 s"), tmp_path)
    cases = [json.loads(path.read_text()) for path in tmp_path.glob("*/case.json")]
    refused, done = (
        [
            case["settings"].get("bed.bead_diameter", scene.bed.bead_diameter)
            for case in cases
            if case["status"] == status
        ]
        for status in ("refused", "done")
    )
    low, high = (1e-3 * float(text) for text in re.findall(r"[0-9.]+", change.reason)[:2])
    assert refused and (low, high) == pytest.approx((min(done), max(done)), rel=1e-3)
