"""Runs that are killed at random moments and resumed until they end. Run: make kill-test (about ten minutes).

Every run is the aluminium mold, shortened, with a checkpoint after every step, killed (SIGKILL to all of its processes) at
a moment drawn between the start of Python and the end of the run, and resumed, from changing working directories, until it
is done; its heating time, history and energy balance must be those of an uninterrupted run to 1e-10.
"""

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from porousmold.output.stored import read_table

SCENE = Path(__file__).parent / "mold" / "aluminium.toml"
SETTINGS = {
    "solver.axial_cells": 8, "solver.cell_growth": 1.6, "operation.heating_margin": "50 K",
    "output.checkpoint_interval": 0, "output.pictures": "false",
}  # fmt: skip


def start(folder, directory):
    """A process that runs the scene to `folder`, or goes on there."""
    command = [sys.executable, "-m", "porousmold", "run", str(SCENE), "--quiet", "--resume", "--out", str(folder)]
    for name, value in SETTINGS.items():
        command += ["--set", f"{name}={value}"]
    return subprocess.Popen(
        command, cwd=directory, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True
    )


def answer(folder):
    """What must not depend on kills: heating time, energy imbalance, history."""
    summary = json.loads((folder / "result.json").read_text())
    return [summary["heating_time"], summary["energy_imbalance"]], read_table(folder / "history.csv").columns


def same(one, other):
    """Whether two answers agree to 1e-10 of the largest value of each column."""
    numbers = zip(one[0], other[0], strict=True)
    if any(abs(a - b) > 1e-10 * max(abs(a), 1.0) for a, b in numbers) or one[1].keys() != other[1].keys():
        return False
    for name, column in one[1].items():
        size = max(map(abs, column)) + 1e-300
        pairs = zip(column, other[1][name], strict=True) if len(column) == len(other[1][name]) else [(0.0, 1.0)]
        if any(abs(a - b) > 1e-10 * size for a, b in pairs):
            return False
    return True


def one_run(number, seconds, expected):
    """Kills until the run got through: how many there were, and whether the answer is right."""
    draw, kills = random.Random(number), 0
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "run"
        while True:
            directory = Path(place) / f"from {kills}"
            directory.mkdir()
            process = start(folder, directory)
            try:
                errors = process.communicate(timeout=draw.uniform(0.3, 1.1) * seconds)[1]
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                process.communicate()
                kills += 1
                continue
            if process.returncode:
                return kills, f"status {process.returncode}: {errors.decode()[-300:]}"
            return kills, None if same(answer(folder), expected) else "another answer"


def main():
    """Kill, resume, compare, and say how it went; the status is 1 if any run was lost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=200)
    wanted = parser.parse_args().kills
    with tempfile.TemporaryDirectory() as place:
        for _ in range(2):  # the first one compiles
            begun = time.perf_counter()
            folder = Path(tempfile.mkdtemp(dir=place))
            if start(folder, place).wait():
                sys.exit("the uninterrupted run failed")
            seconds = time.perf_counter() - begun
        expected = answer(folder)
    kills = runs = 0
    lost = []
    with ThreadPoolExecutor(2) as pool:
        while kills < wanted:
            for more, problem in pool.map(lambda n: one_run(n, seconds, expected), range(runs, runs + 4)):
                kills, runs = kills + more, runs + 1
                lost += [problem] if problem else []
            print(f"{runs} runs, {kills} kills, {len(lost)} wrong or lost", flush=True)
    print(*lost, sep="\n")
    sys.exit(bool(lost))


if __name__ == "__main__":
    main()
