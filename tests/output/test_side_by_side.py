"""Two runs side by side: what differs, and their results."""

import json

import pytest
from mpi4py import MPI

from porousmold import run
from porousmold.cli import main
from porousmold.scene.keys import flat

from ..support import coarse_scene


def test_tables_in_lists_have_numbers():
    tables = {"a": {"b": 1, "c": [{"d": 2}, {"d": 3}]}, "target": [{"e": "f"}], "g": {"h": [1, 2]}}
    assert flat(tables) == {"a.b": 1, "a.c[1].d": 2, "a.c[2].d": 3, "target[1].e": "f", "g.h": [1, 2]}


def test_what_differs_between_two_runs(tmp_path, capsys):
    ends = {"operation.end_time": 60.0}
    run(coarse_scene(ends), tmp_path / "a", MPI.COMM_SELF)
    run(
        coarse_scene({**ends, "wall.thickness": "2 mm", "operation.heating_margin": "5 K"}),
        tmp_path / "b",
        MPI.COMM_SELF,
    )
    assert main(["compare", str(tmp_path / "a"), str(tmp_path / "b"), "--out", str(tmp_path / "both")]) == 0
    content = json.loads((tmp_path / "both" / "beside.json").read_text())
    assert content["scenes"]["wall.thickness"] == [pytest.approx(3e-3), pytest.approx(2e-3)]
    assert content["scenes"]["operation.heating_margin"] == [2.0, 5.0] and len(content["scenes"]) == 2
    assert content["results"]["mass_flow_initial"][0] > 0.0
    assert (tmp_path / "both" / "beside.png").stat().st_size > 10_000
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["wall.thickness", "mm", "3", "2"] in rows and ["operation.heating_margin", "K", "2", "5"] in rows


def test_a_number_beside_a_series(tmp_path, capsys):
    """It ended in a traceback, with its file and picture written."""
    (tmp_path / "inlet.csv").write_text("time [s], temperature [degC]\n0, 90\n1000, 95\n")
    for name, inlet in (("a", 363.15), ("b", str(tmp_path / "inlet.csv"))):
        changes = {"operation.end_time": 30.0, "operation.inlet_temperature": inlet, "model.flow": "plug"}
        run(coarse_scene(changes | {"model.turbulence": "none"}), tmp_path / name, MPI.COMM_SELF)
    assert main(["compare", str(tmp_path / "a"), str(tmp_path / "b"), "--out", str(tmp_path / "both")]) == 0
    row = next(line for line in capsys.readouterr().out.splitlines() if "operation.inlet_temperature" in line)
    assert "363.15" in row and "inlet.csv" in row


def test_a_folder_without_a_run_is_refused(tmp_path, capsys):
    (tmp_path / "empty").mkdir()
    assert main(["compare", str(tmp_path / "empty"), str(tmp_path / "empty")]) == 2
    assert "not the folder of a whole run" in capsys.readouterr().err
