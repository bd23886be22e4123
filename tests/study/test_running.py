"""Studies as they run: tables, restarts, parts, workers."""

import csv
import json
import os
import select
import subprocess
import sys

import pytest

from porousmold import InputError
from porousmold.cli import main
from porousmold.files.atomic_files import locked
from porousmold.simulation.accuracy import LARGEST_DIFFERENCE
from porousmold.study.definition import Case, Study
from porousmold.study.running import Row, collect, row_of, run_study

from ..support import ALUMINIUM, STUDIES, under_mpirun

TEXT = f"""
[study]
scene = "{ALUMINIUM}"
record = ["heating_time", "mass_flow_final", "unknowns.flow"]
[set]
model.turbulence = "none"
model.flow = "plug"
solver.axial_cells = 4
operation.heating_margin = "50 K"
[vary]
wall.thickness = ["1 mm", "2 mm"]
bed.bead_diameter = ["4 mm", "5 mm", "8 mm"]
"""


@pytest.fixture
def study_file(tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(TEXT)
    return path


def test_rows_stand_in_the_order_of_the_cases_and_failures_have_reasons(study_file, tmp_path):
    out = tmp_path / "out"
    rows = run_study(Study.load(study_file), out)
    assert [row.status for row in rows] == ["done", "done", "refused"] * 2
    assert "at least 10 bead diameters" in rows[2].reason
    assert rows[0].values["heating_time"] > rows[1].values["heating_time"]  # smaller beads let less air through
    with (out / "table.csv").open() as file:
        table = list(csv.DictReader(file))
    assert [float(row["bed.bead_diameter [m]"]) for row in table[:3]] == [
        0.004,
        0.005,
        0.008,
    ]  # the last one is refused
    entries = json.loads((out / "table.json").read_text())
    assert [entry["heating_time"] for entry in entries] == [row.values["heating_time"] for row in rows]
    assert float(table[0]["heating_time [s]"]) == entries[0]["heating_time"]


def test_a_target_that_a_case_has_not_is_told_and_leaves_its_other_records(tmp_path):
    """Its row was missing, and computed again at every start."""
    target = '[[case]]\ntarget = [{ name = "warm", place = "bed_side", above = "25.5 degC" }]\n'
    head, common = TEXT.partition("record = ")[0], TEXT.partition("[set]")[2].partition("[vary]")[0]
    head += 'design = "cases"\nrecord = ["targets.warm", "end_time"]\n[set]'
    (tmp_path / "cases.toml").write_text(head + common + target + "[[case]]\nwall.thickness = 0.001\n")
    warm, plain = run_study(Study.load(tmp_path / "cases.toml"), tmp_path / "out")
    assert warm.status == plain.status == "done" and 0.0 < warm.values["targets.warm"] <= warm.values["end_time"]
    assert plain.values["targets.warm"] is None and plain.values["end_time"] > 0.0
    assert "without targets.warm" in plain.reason and plain.is_reached and not warm.reason


def test_cases_have_one_mesh_and_rows_tell_where_that_is_coarse(tmp_path):
    """Runs that end while a front stands in the bed would be repeated on finer cells: as cases they are not, and say so."""
    path = tmp_path / "front.toml"
    text = TEXT.replace("solver.axial_cells = 4", "operation.end_time = 120.0").replace(
        '"4 mm", "5 mm", "8 mm"', '"1.5 mm", "4 mm"'
    )
    path.write_text(text.replace('["1 mm", "2 mm"]', '["2 mm"]').replace('operation.heating_margin = "50 K"', ""))
    out = tmp_path / "out"
    rows = run_study(Study.load(path), out)
    for row in rows:
        summary = json.loads((out / row.case.name / "result.json").read_text())
        assert summary["refinements"] == {"along": 1.0, "across": 1.0, "steps": 1.0}
        is_told = max(summary["end_errors"].values()) > LARGEST_DIFFERENCE
        assert ("coarser cells and steps move" in row.reason) == is_told
    assert any("coarser cells and steps move" in row.reason for row in rows)


def test_rows_tell_of_doubts_that_no_coarser_cells_can_settle(tmp_path):
    """A front that stands in a mesh of one's own."""
    path = tmp_path / "plastic.toml"
    path.write_text(
        f"""
[study]
scene = "{STUDIES / "mold" / "curved.toml"}"
record = ["heating_time"]
[set]
model.turbulence = "none"
model.flow = "developed"
operation.end_time = "60 s"
[vary]
wall.material = ["acrylic"]
"""
    )
    (row,) = run_study(Study.load(path), tmp_path / "out")
    assert "within one cell of the bed" in row.reason and row.reason.endswith("a finer mesh shows it")


@pytest.mark.parametrize(
    ("status", "reason", "reached"),
    [
        ("done", "", True),
        ("done", "a front; coarser cells and steps move the heating time by 0.5%, which", True),
        ("done", "not heated to within 2 K by operation.end_time 60 s; coarser cells and steps move", False),
        ("done", "not cooled to within 2 K at 300 s", False),
        ("done", "target 'warm' not met by operation.end_time", False),
        ("failed", "heat failed", False),
    ],
)
def test_a_case_in_doubt_has_reached_what_it_waits_for_all_the_same(status, reason, reached):
    """A search looks among these: a doubt about cells is no reason to leave the best one out."""
    assert Row(Case("case", {}, None, ""), status, reason, {}).is_reached == reached


def test_starting_again_runs_only_what_is_missing_or_changed(study_file, tmp_path):
    out, study = tmp_path / "out", Study.load(study_file)
    first = run_study(study, out)
    times = {case.name: (out / case.name / "case.json").stat().st_mtime_ns for case in study.cases}
    assert [row.values for row in run_study(study, out)] == [row.values for row in first]
    assert times == {case.name: (out / case.name / "case.json").stat().st_mtime_ns for case in study.cases}
    (out / study.cases[1].name / "case.json").write_text("{damaged")
    changed = TEXT.replace('"1 mm", "2 mm"', '"1 mm", "2.5 mm"')
    study_file.write_text(changed)
    again = run_study(Study.load(study_file), out)
    assert [row.values for row in again[:2]] == [row.values for row in first[:2]]
    assert [row.status for row in again] == ["done", "done", "refused"] * 2
    study_file.write_text(changed.replace('"50 K"', '"40 K"'))  # every case is another one now
    assert all(row_of(case, out, ["heating_time"]).status == "missing" for case in Study.load(study_file).cases[:2])


def test_a_case_whose_tables_were_edited_is_computed_again(study_file, tmp_path):
    """It stayed missing, whatever was done."""
    study, out = Study.load(study_file), tmp_path / "out"
    rows = run_study(study, out)
    done = next(row for row in rows if row.status == "done")
    table = out / done.case.name / "history.csv"
    table.write_text("\n".join(table.read_text().splitlines()[:-1]) + "\n")
    assert {row.status for row in collect(study, out)} >= {"missing"}
    assert [(row.status, row.values) for row in run_study(study, out)] == [(row.status, row.values) for row in rows]


def test_a_case_that_another_process_has_taken_is_left_to_it(study_file, tmp_path):
    out, study = tmp_path / "out", Study.load(study_file)
    (out / study.cases[0].name).mkdir(parents=True)
    claim = locked(out / study.cases[0].name / ".claim")
    assert [row.status for row in run_study(study, out)][:2] == ["missing", "done"]
    claim.close()
    assert [row.status for row in run_study(study, out)][:2] == ["done", "done"]


def test_stopping_keeps_what_is_done_and_the_next_start_goes_on(study_file, tmp_path):
    out, study = tmp_path / "out", Study.load(study_file)
    calls = []
    rows = run_study(study, out, stop=lambda: calls.append(None) or len(calls) > 60)
    assert [row.status for row in rows].count("missing") > 0
    whole = run_study(study, tmp_path / "whole")
    assert [row.values for row in run_study(study, out)] == [row.values for row in whole]


def test_parts_of_an_array_job_make_one_table(study_file, tmp_path, capsys):
    whole, out = tmp_path / "whole", tmp_path / "parts"
    assert main(["study", str(study_file), "--out", str(whole), "--quiet"]) == 2  # with a refused case
    for part in ("1/3", "2/3", "3/3"):
        assert main(["study", str(study_file), "--out", str(out), "--part", part, "--quiet"]) in (0, 2)
    assert main(["study", str(study_file), "--out", str(out), "--collect"]) == 2
    assert (out / "table.csv").read_text() == (whole / "table.csv").read_text()
    assert "4 done, 2 refused" in capsys.readouterr().out
    for part in ("0/3", "4/3", "x", "1"):
        assert main(["study", str(study_file), "--part", part]) == 2
    assert main(["study", str(study_file), "--out", str(tmp_path / "none"), "--collect"]) == 2
    nowhere = ["-m", "porousmold", "study", str(study_file), "--out", str(tmp_path / "none"), "--collect"]
    assert under_mpirun(2, *nowhere, timeout=60).returncode == 2  # every rank is told


def test_the_job_script_on_two_ranks_gives_the_table_of_one_process(study_file, tmp_path):
    """Task by task, as SLURM would start it."""
    alone, together = tmp_path / "alone", tmp_path / "together"
    run_study(Study.load(study_file), alone)
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("OMPI_", "PMIX_"))}
    environment["LAUNCH"] = f"mpirun --oversubscribe {'--allow-run-as-root' if os.geteuid() == 0 else ''} -n 2"
    command = tmp_path / "bin" / "porousmold"  # this one, installed or not
    command.parent.mkdir()
    command.write_text(f'#!/bin/sh\nexec {sys.executable} -m porousmold "$@"\n')
    command.chmod(0o755)
    environment["PATH"] = f"{command.parent}:{environment['PATH']}"
    for task in ("1", "2", "3"):
        tasks = {"SLURM_ARRAY_TASK_ID": task, "SLURM_ARRAY_TASK_COUNT": "3"}
        script = ["bash", str(STUDIES / "array_job.sh"), str(study_file), str(together)]
        assert subprocess.run(script, env=environment | tasks, timeout=300).returncode in (0, 2)  # with a refused case
    collect(Study.load(study_file), together)
    assert (together / "table.csv").read_text() == (alone / "table.csv").read_text()


LISTS = f"""
[study]
scene = "{ALUMINIUM}"
design = "cases"
record = ["heating_time", "targets.warm"]
[set]
model.turbulence = "none"
model.flow = "plug"
solver.axial_cells = 4
operation.heating_margin = "50 K"
[[case]]
target = [{{ name = "warm", above = "50 degC" }}]
[[case]]
target = [{{ name = "warm", above = "60 degC" }}]
"""


def test_lists_of_tables_can_be_varied_and_stand_in_the_table_as_they_are_given(tmp_path):
    path, out = tmp_path / "lists.toml", tmp_path / "out"
    path.write_text(LISTS)
    rows = run_study(Study.load(path), out)
    assert [row.status for row in rows] == ["done", "done"]
    assert rows[0].values["targets.warm"] < rows[1].values["targets.warm"]
    entries = json.loads((out / "table.json").read_text())
    given = [json.loads(entry["target.list"] if "target.list" in entry else entry["target"]) for entry in entries]
    assert [one[0]["above"] for one in given] == pytest.approx([323.15, 333.15])
    assert "object at" not in (out / "table.csv").read_text()


def test_a_study_alone_on_a_machine_gives_the_table_of_one_process(study_file, tmp_path):
    """A command of its own forks a worker for every core: the same rows, and nobody is left behind."""
    alone, together = tmp_path / "alone", tmp_path / "together"
    run_study(Study.load(study_file), alone)
    code = "import os, sys; os.sched_getaffinity = lambda pid: {0, 1, 2}; from porousmold.cli import main; sys.exit(main())"
    command = [sys.executable, "-c", code, "study", str(study_file), "--out", str(together), "--quiet"]
    outside = {name: value for name, value in os.environ.items() if not name.startswith(("OMPI_", "PMIX_"))}
    reading, writing = os.pipe()  # all of its processes hold it open
    assert subprocess.run(command, env=outside, timeout=300, pass_fds=[writing]).returncode == 2  # with a refused case
    os.close(writing)
    assert select.select([reading], [], [], 5.0)[0] and os.read(reading, 1) == b""
    os.close(reading)
    assert (together / "table.csv").read_text() == (alone / "table.csv").read_text()


@pytest.mark.parametrize("group", [1, 2])
def test_workers_under_mpirun_give_the_same_table(study_file, tmp_path, group):
    alone, together = tmp_path / "alone", tmp_path / "together"
    run_study(Study.load(study_file), alone)
    command = ["-m", "porousmold", "study", str(study_file), "--out", str(together), "--group", str(group), "--quiet"]
    assert under_mpirun(2, *command).returncode == 2  # with a refused case
    if group == 1:
        assert (together / "table.csv").read_text() == (alone / "table.csv").read_text()
    study = Study.load(study_file)
    for one, other in zip(collect(study, alone), collect(study, together), strict=True):
        if one.status == "done":
            assert other.values["heating_time"] == pytest.approx(one.values["heating_time"], rel=1e-6)


def test_a_folder_in_the_way_is_told_and_what_it_kept_from_running_is_run_later(study_file, tmp_path):
    out, study = tmp_path / "out", Study.load(study_file)
    out.mkdir()
    (out / study.cases[1].name).write_text("a file where a folder should be")
    with pytest.raises(InputError, match="cannot be written"):
        run_study(study, out)
    (out / study.cases[1].name).unlink()
    assert [row.status for row in run_study(study, out)] == ["done", "done", "refused"] * 2


def test_trouble_with_a_folder_is_not_kept_as_the_case_s_answer(study_file, tmp_path):
    out, study = tmp_path / "out", Study.load(study_file)
    (out / study.cases[0].name).mkdir(parents=True)
    lock = locked(out / study.cases[0].name / ".lock")  # as a run of the user's own would
    row = run_study(study, out)[0]
    assert row.status == "missing" and "another process" in row.reason
    lock.close()
    assert run_study(study, out)[0].status == "done"


def test_bad_groups_and_folders_are_refused(study_file, tmp_path, capsys):
    assert main(["study", str(study_file), "--out", str(tmp_path / "a"), "--group", "2"]) == 2
    (tmp_path / "file").write_text("")
    assert main(["study", str(study_file), "--out", str(tmp_path / "file" / "x")]) == 2
    assert "--out" in capsys.readouterr().err
