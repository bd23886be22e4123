"""Nothing is lost in silence: finished runs stay, and what is wrong in an input is named."""

import json

import pytest
from mpi4py import MPI

from porousmold import InputError, Scene, run
from porousmold.cli import main

from .support import ALUMINIUM, COARSE, coarse_scene, simulation_of

SHORT = {"operation.end_time": 5.0, "model.turbulence": "none", "model.flow": "plug"}
WORDS = [word for name, value in (COARSE | SHORT).items() for word in ("--set", f"{name}={value}")]


@pytest.mark.parametrize("resume", [False, True])
def test_a_finished_run_is_replaced_only_by_force(tmp_path, resume):
    first, other = coarse_scene(SHORT), coarse_scene({**SHORT, "wall.thickness": "2 mm"})
    run(first, tmp_path, MPI.COMM_SELF)
    before = (tmp_path / "result.json").read_text()
    with pytest.raises(InputError, match=r"--out.*--force replaces it"):
        run(other, tmp_path, MPI.COMM_SELF, resume=resume)
    assert (tmp_path / "result.json").read_text() == before and (tmp_path / "history.csv").is_file()
    run(other, tmp_path, MPI.COMM_SELF, force=True)
    assert json.loads((tmp_path / "result.json").read_text())["identity"] != json.loads(before)["identity"]
    assert not (tmp_path / ".lock").exists()


def test_the_same_scene_again_is_done_already(tmp_path, capsys):
    words = ["run", str(ALUMINIUM), *WORDS, "--out", str(tmp_path)]
    assert main(words) == 0
    before = (tmp_path / "result.json").stat().st_mtime_ns
    capsys.readouterr()
    assert main(words) == 0
    assert capsys.readouterr().out.startswith("done already")
    assert (tmp_path / "result.json").stat().st_mtime_ns == before


def test_a_file_in_the_folders_place_is_refused(tmp_path, capsys):
    path = tmp_path / "run"
    path.write_text("mine")
    assert main(["run", str(ALUMINIUM), *WORDS, "--out", str(path)]) == 2
    assert "it is a file" in capsys.readouterr().err and path.read_text() == "mine"


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("wall.thickness=-2 mm", ("wall.thickness", "--set")),
        ("operation.inlet_temperature=25 degC", ("operation.inlet_temperature", "nothing to heat")),
    ],
)
def test_a_bad_setting_is_named(setting, words, capsys):
    assert main(["run", str(ALUMINIUM), "--set", setting]) == 2
    error = capsys.readouterr().err
    assert all(word in error for word in words) and len(error.splitlines()) == 1


def test_texts_of_other_editors(tmp_path):
    text = ALUMINIUM.read_text()
    marked, latin = tmp_path / "marked.toml", tmp_path / "latin.toml"
    marked.write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert Scene.load(marked).wall.thickness == Scene.load(ALUMINIUM).wall.thickness
    latin.write_bytes(("# Größe\n" + text).encode("latin-1"))
    with pytest.raises(InputError, match=r"UTF-8.*line 1"):
        Scene.load(latin)


def test_a_column_named_for_another_quantity(tmp_path):
    path = tmp_path / "inlet.csv"
    path.write_text("time [s], outlet_temperature [degC]\n0, 20\n60, 90\n")
    with pytest.raises(InputError, match="another quantity"):
        coarse_scene({"operation.inlet_temperature": str(path)})
    path.write_text("time [s], T [degC]\n0, 20\n60, 90\n")
    coarse_scene({"operation.inlet_temperature": str(path)})


def test_values_that_look_like_a_slip_are_told():
    changes = {
        "operation.inlet_temperature": 190.0,
        "operation.initial_temperature": "20 degC",
        "wall.thickness": 3.0,
    }
    changes["operation.pressure_drop"] = 8.0
    warnings = run(coarse_scene({**SHORT, **changes}), communicator=MPI.COMM_SELF).summary["warnings"]
    assert any("meant in °C" in text for text in warnings) and any("meant in mm" in text for text in warnings)
    assert any("meant in kPa" in text for text in warnings)


@pytest.mark.parametrize("value", [90.0, "90", 20])
def test_a_temperature_that_no_mold_has_needs_a_unit(value):
    with pytest.raises(InputError, match=r"needs a unit: .(90|20) degC. or"):
        coarse_scene({"operation.inlet_temperature": value})


def test_why_a_wall_is_not_heated_is_told():
    """Short of time it still approaches the inlet temperature; with losses that balance the heat it stays below."""
    plug = {"model.flow": "plug", "model.turbulence": "none"}
    for end_time, expected in ((300.0, "hardly heated yet"), (1000.0, "and approaches it by")):
        short = run(coarse_scene({**plug, "operation.end_time": end_time}), communicator=MPI.COMM_SELF).summary[
            "warnings"
        ]
        assert any(expected in text for text in short)
    losses = {
        "operation.outer_coefficient": 200.0,
        "operation.ambient_temperature": "20 degC",
        "operation.end_time": 2e4,
    }
    steady = run(coarse_scene({**plug, **losses}), communicator=MPI.COMM_SELF).summary["warnings"]
    assert any("stays there: heat losses of the outer wall" in text for text in steady)
    ended = run(coarse_scene({**plug, **losses, "operation.end_time": None}), communicator=MPI.COMM_SELF).summary
    assert ended["status"] == "done" and ended["end_time"] < 2e4
    assert any("2 K at " in text and "stays there" in text for text in ended["warnings"])


def test_a_set_point_that_falls_to_the_wall_has_not_heated_it():
    """The wall is between 30 and 100 degC when the set-point, on its way down, passes its coldest point."""
    set_point = [0.0, 375.0, 495.0, 825.0, 2e4], [298.15, 423.15, 423.15, 313.15, 313.15]
    changes = {"model.flow": "plug", "model.turbulence": "none", "operation.end_time": "4 h"}
    simulation = simulation_of(coarse_scene({**changes, "operation.inlet_temperature": set_point})).integrate()
    history, time = simulation.recorder.history, simulation.recorder.heating_time
    assert time is not None and time > 1000.0
    assert history["highest_wall"][-1] < 313.15 + 2.5


def test_a_study_with_refused_cases_ends_with_a_status(tmp_path):
    study = tmp_path / "study.toml"
    lines = [
        f'[study]\nscene = "{ALUMINIUM}"\n[set]',
        *(f"{name} = {json.dumps(value)}" for name, value in (COARSE | SHORT).items()),
    ]
    study.write_text("\n".join([*lines, '[vary]\nwall.thickness = ["3 mm", "-1 mm"]']))
    assert main(["study", str(study), "--out", str(tmp_path / "cases"), "--quiet"]) == 2
    assert len(json.loads((tmp_path / "cases" / "table.json").read_text())) == 2
