"""Processes forked from this one."""

import os
import subprocess
import sys
import time

import pytest

from porousmold.files.children import forked


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
    code = (
        "import time; from porousmold.files.children import forked; print(forked(lambda: time.sleep(60)), flush=True)"
    )
    parent = subprocess.Popen([sys.executable, "-c", f"{code}; time.sleep(60)"], stdout=subprocess.PIPE, text=True)
    assert parent.stdout is not None
    child = int(parent.stdout.readline())
    parent.kill()
    parent.wait()
    for _ in range(100):
        try:
            os.kill(child, 0)
        except ProcessLookupError:
            return
        with open(f"/proc/{child}/stat") as status:
            if status.read().split(")")[1].split()[0] == "Z":  # ended; whoever took it over has not looked yet
                return
        time.sleep(0.05)
    pytest.fail("the child has outlived its parent")
