"""Processes forked from this one."""

import os
import select
import subprocess
import sys

from porousmold.files.subprocesses import forked


def test_a_child_works_in_a_process_of_its_own_and_in_silence(tmp_path, capfd):
    def work():
        os.write(1, b"not to be seen")
        (tmp_path / "done").write_text(str(os.getpid()))
        raise RuntimeError("ends the child alone")

    child = forked(work)
    os.waitpid(child, 0)
    assert (tmp_path / "done").read_text() == str(child) != str(os.getpid())
    assert capfd.readouterr() == ("", "")


def test_a_child_ends_with_its_parent():
    """Nobody is left to hold the pipe open that both have."""
    reading, writing = os.pipe()
    code = "import time; from porousmold.files.subprocesses import forked; print(forked(lambda: time.sleep(60)), flush=True)"
    command = [sys.executable, "-c", f"{code}; time.sleep(60)"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, pass_fds=[writing]) as parent:
        os.close(writing)
        assert parent.stdout is not None and int(parent.stdout.readline()) != parent.pid
        assert not select.select([reading], [], [], 0.2)[0]
        parent.kill()
    ended, _, _ = select.select([reading], [], [], 10.0)
    assert ended and os.read(reading, 1) == b""
    os.close(reading)
