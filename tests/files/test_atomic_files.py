"""Files that take their place whole or not at all, and what a full disk does to commands that are at work."""

import errno
import os
import subprocess
import sys

import pytest

from porousmold.errors import InputError, OutputError
from porousmold.files.atomic_files import FULL, locked, output_file
from tests.support import STUDIES

COARSE = ("solver.axial_cells=4", "solver.cell_growth=2", "model.flow=plug", "operation.heating_margin=60 K")
COLUMN = {
    "--width": "10 mm", "--depth": "7 mm", "--height": "40 mm", "--bed-height": "8 mm", "--bead-diameter": "1 mm",
    "--beads": "glass", "--velocity": "0.9 m/s", "--time": "0.02 s",
}  # fmt: skip


@pytest.mark.parametrize("number", FULL)
def test_a_full_disk_is_no_bad_input(tmp_path, number):
    with pytest.raises(OutputError, match="the same command writes it"), output_file(tmp_path / "table.csv") as part:
        part.write_text("half")
        raise OSError(number, os.strerror(number))
    assert not list(tmp_path.iterdir())


def test_a_file_that_must_not_be_written_is_bad_input(tmp_path):
    with pytest.raises(InputError) as refusal, output_file(tmp_path / "table.csv"):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    assert not isinstance(refusal.value, OutputError)


def test_a_lock_leaves_no_empty_folder(tmp_path):
    locked(tmp_path / "runs" / "one" / ".lock").close()
    assert not list(tmp_path.iterdir())
    with locked(tmp_path / "runs" / "one" / ".lock"):
        (tmp_path / "runs" / "result.json").write_text("{}")
    assert [path.name for path in tmp_path.rglob("*")] == ["runs", "result.json"]


def limited(size, *arguments):
    """The command with no file of more than `size` bytes, which the kernel refuses as it does on a full disk. MPI has made its
    own files before; forms and functions are compiled by a call without that limit."""
    script = (
        f"import resource, sys; from mpi4py import MPI; resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size})); "
    )
    script += "from porousmold.cli import main; sys.exit(main())"
    command = [sys.executable, "-c", script, *map(str, arguments), "--quiet"]
    return subprocess.run(command, capture_output=True, text=True, timeout=120)


def said(finished):
    """The one line of the program."""
    lines = [line for line in finished.stderr.splitlines() if line.startswith("porousmold: ")]
    assert "Traceback" not in finished.stderr and len(lines) == 1
    return lines[0]


def test_a_run_on_a_full_disk_names_resume_and_goes_on(tmp_path):
    settings = [part for text in (*COARSE, "output.checkpoint_interval=0") for part in ("--set", text)]
    run = ("run", STUDIES / "mold" / "aluminium.toml", *settings, "--out", tmp_path / "run")
    assert limited(2**30, *run[:-1], tmp_path / "whole").returncode == 0
    ended = limited(2**13, *run)
    assert ended.returncode == 3 and "--resume goes on" in said(ended)
    assert not (tmp_path / "run").exists(), "nothing half-written"
    assert limited(2**26, *run, "--resume").returncode == 0


def test_a_picture_without_room_leaves_the_result_of_the_run(tmp_path):
    settings = [part for text in (*COARSE, "output.fields=false") for part in ("--set", text)]
    run = ("run", STUDIES / "mold" / "aluminium.toml", *settings, "--out")
    assert limited(2**30, *run, tmp_path / "whole").returncode == 0
    ended = limited(2**15, *run, tmp_path)
    assert ended.returncode == 3 and "'porousmold show'" in said(ended)
    assert (tmp_path / "result.json").is_file() and not list(tmp_path.glob("*.part"))
    assert subprocess.run([sys.executable, "-m", "porousmold", "show", str(tmp_path)], timeout=60).returncode == 0


def test_a_column_and_a_table_without_room(tmp_path):
    fluidise = ("fluidise", *[part for item in COLUMN.items() for part in item], "--out")
    without_room = limited(
        2**11, *fluidise, tmp_path / "column"
    )  # of compiled functions, on a fresh machine, or its own files
    assert without_room.returncode == 3 and "with room there, the same command" in said(without_room)
    assert limited(2**30, *fluidise, tmp_path / "whole").returncode == 0
    column = limited(2**11, *fluidise, tmp_path / "column")
    assert column.returncode == 3 and "the same command" in said(column)
