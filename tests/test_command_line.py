"""The command line as people expect it: help with examples that can be parsed, completion, a log file, exit statuses."""

import os
import re
import shlex
import subprocess
import sys

import pytest
from mpi4py import MPI

from porousmold import InputError, run
from porousmold.cli import EXAMPLES, STATUSES, _parser, main

from .support import ALUMINIUM, COARSE, coarse_scene

SETTINGS = [word for name, value in COARSE.items() for word in ("--set", f"{name}={value}")]


@pytest.mark.parametrize("command", EXAMPLES)
def test_each_command_has_examples_that_can_be_parsed(command, capsys):
    for arguments in EXAMPLES[command]:
        _parser().parse_args([command, *shlex.split(arguments)])
    with pytest.raises(SystemExit) as ended:
        main([command, "--help"])
    assert ended.value.code == 0 and f"porousmold {command}" in capsys.readouterr().out.split("example")[-1]


def test_help_tells_the_exit_statuses(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    assert STATUSES in capsys.readouterr().out


def test_a_shell_completes_commands(tmp_path):
    asked = {"_ARGCOMPLETE": "1", "COMP_LINE": "porousmold sens", "COMP_POINT": "15"}
    asked["_ARGCOMPLETE_STDOUT_FILENAME"] = str(tmp_path / "offered")
    subprocess.run([sys.executable, "-m", "porousmold"], env={**os.environ, **asked}, check=False, capture_output=True)
    offered = (tmp_path / "offered").read_text()
    assert "sensitivity" in offered and "report" not in offered


def test_the_log_holds_steps_and_iterations_and_the_console_nothing(tmp_path, capsys):
    log = tmp_path / "run.log"
    words = ["run", str(ALUMINIUM), *SETTINGS, "--set", "operation.end_time=20", "--out", str(tmp_path / "run")]
    assert main([*words, "--quiet", "--log", str(log)]) == 0
    text = log.read_text(encoding="utf-8")
    assert "iteration 1, " in text and "to 20 s: " in text and capsys.readouterr().err == ""
    assert main([*words, "--quiet", "--force", "--log", str(tmp_path / "absent" / "run.log")]) == 2
    assert "--log" in capsys.readouterr().err


def test_a_missing_package_is_told_in_one_line(tmp_path):
    """As after `pip install`, which brings nothing that is compiled."""
    (tmp_path / "dolfinx.py").write_text("raise ModuleNotFoundError(\"No module named 'dolfinx'\", name='dolfinx')")
    done = subprocess.run(
        [sys.executable, "-m", "porousmold", "run", str(ALUMINIUM), "--out", str(tmp_path / "run")],
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1 and "apt install python3-dolfinx" in done.stderr.splitlines()[-1]
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "run").exists()


def test_a_reader_that_leaves_early_is_no_crash():
    """As `| head -1`: PETSc would take the closed pipe for a crash and end in MPI's abort."""
    arguments = [sys.executable, "-m", "porousmold", "check", str(ALUMINIUM)]
    process = subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    process.stdout.close()
    assert process.stderr is not None
    errors = process.stderr.read()
    assert process.wait(timeout=100) == 0
    assert not [
        word for word in ("Traceback", "Broken pipe", "PETSC ERROR", "MPI_A") if word in errors
    ]  # MPI's own remarks may stand there


def test_a_run_takes_the_name_of_a_file_or_its_tables():
    settings = {"operation.end_time": 20.0, "output.pictures": False}
    tables = coarse_scene(settings).as_tables()
    one, other = run(tables, communicator=MPI.COMM_SELF), run(coarse_scene(settings), communicator=MPI.COMM_SELF)
    assert one["outlet_temperature"][-1] == other["outlet_temperature"][-1]
    with pytest.raises(InputError, match="no such file"):
        run("no_such_scene.toml")
    with pytest.raises(InputError, match="must be the name of a file"):
        run(3)


def test_a_failed_run_tells_what_its_answer_would_have_been_warned_of(tmp_path, capsys):
    """Heat is taken out of the wall until a temperature falls to 0 K, far below the ranges of all materials."""
    given = {
        "model.flow": "plug",
        "model.turbulence": "none",
        "operation.outer_heat_flux": -5e5,
        "output.pictures": "false",
    }
    settings = [word for name, value in given.items() for word in ("--set", f"{name}={value}")]
    status = main(["run", str(ALUMINIUM), "--out", str(tmp_path / "cold"), *SETTINGS, *settings])
    told = capsys.readouterr().err
    assert status == 3 and "falls to 0 K" in told
    assert re.search(r"warning: .* is used for .*, given for", told)
