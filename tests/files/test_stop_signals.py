"""Commands that are told to stop: within seconds, with what was computed kept."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from porousmold.files.atomic_files import locked

from ..support import ALUMINIUM

PATIENCE = 4.0
"""Seconds that a stop may take here: two of the program's own, and a busy machine."""


def stopped(out, settings, wait, numbers, *, pause=0.0, **variables):
    """(status, what it printed, seconds from the first signal to the end) of a run stopped after `wait` seconds, or once a
    file of that name is in its folder and a `pause` (s) is over; with more environment variables."""
    words = [word for setting in settings for word in ("--set", setting)]
    command = [sys.executable, "-m", "porousmold", "run", str(ALUMINIUM), "--quiet", "--out", str(out), *words]
    environment = os.environ | {"OMP_NUM_THREADS": "1"} | variables
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment) as process:
        if isinstance(wait, str):
            deadline = time.perf_counter() + 200.0
            while not (out / wait).exists() and time.perf_counter() < deadline:
                time.sleep(0.1)
            time.sleep(pause)
        else:
            time.sleep(wait)
        start = time.perf_counter()
        for number in numbers:
            process.send_signal(number)
            time.sleep(0.3)
        process.wait(timeout=60)  # a compiler that it had started may keep the pipe open for a while
        seconds = time.perf_counter() - start
        _, printed = process.communicate(timeout=60)
        return process.returncode, printed, seconds


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_within_the_integration(number, tmp_path):
    status, printed, seconds = stopped(tmp_path / "out", ["solver.largest_step=0.05"], "checkpoint.h5", [number])
    assert status == 130 and "stopped at t =" in printed and "Traceback" not in printed
    assert seconds < PATIENCE
    summary = json.loads((tmp_path / "out" / "result.json").read_text())
    assert summary["status"] == "interrupted" and summary["end_time"] > 0.0


def test_while_it_starts(tmp_path):
    status, printed, seconds = stopped(tmp_path / "out", ["solver.mesh_refinement=10"], ".lock", [signal.SIGINT])
    assert status == 130 and "interrupted before the run began" in printed and "Traceback" not in printed
    assert seconds < PATIENCE


def test_an_interruption_that_is_lost():
    """Python prints an exception of a fork's hook and goes on: the command ends nevertheless."""
    program = (
        "import os, signal, time\n"
        "from porousmold.files.stop_signals import StopSignals\n"
        "signals = StopSignals()\n"
        "os.register_at_fork(before=lambda: os.kill(os.getpid(), signal.SIGTERM))\n"
        "if os.fork() == 0: os._exit(0)\n"
        "time.sleep(60.0)\n"
    )
    start = time.perf_counter()
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=100)
    assert "Exception ignored" in ended.stderr and "within a long call" in ended.stderr
    assert ended.returncode == -signal.SIGINT and time.perf_counter() - start < PATIENCE


def test_while_it_compiles(tmp_path):
    """The processes that compile end with the run: none keeps its folder from the next one."""
    cache = {"XDG_CACHE_HOME": str(tmp_path)}
    status, printed, seconds = stopped(tmp_path / "out", [], ".lock", [signal.SIGTERM], pause=2.0, **cache)
    assert status == 130 or (status < 0 and "within a long call" in printed), (status, printed)
    assert seconds < PATIENCE
    time.sleep(0.5)
    locked(tmp_path / "out" / ".lock").close()


def test_within_the_flow_of_a_large_mesh(tmp_path):
    status, printed, seconds = stopped(tmp_path / "out", ["solver.mesh_refinement=10"], 15.0, [signal.SIGTERM])
    assert status == 130 or (status < 0 and "within a long call" in printed)
    assert "Traceback" not in printed and seconds < PATIENCE


def test_a_second_signal_ends_it_at_once(tmp_path):
    status, _, seconds = stopped(tmp_path / "out", ["solver.mesh_refinement=10"], 15.0, [signal.SIGINT] * 2)
    assert status in (-signal.SIGINT, 130) and seconds < 2.0
