"""Commands that are killed at random moments and given again until they end. Run: make kill-test (about half an hour).

A run on one rank and on two, a study, an optimum, a packing, a column and a sheared bed, all small, are killed (SIGKILL to all
of their processes, of the run on two ranks to one rank alone) at a moment drawn between the start of Python and the end, and
given again from changing working directories until they are done. Their answer must be that of an undisturbed one, to 1e-10
(on two ranks 1e-8).
"""

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from porousmold.output.stored import read_table

SCENE = Path(__file__).parent / "mold" / "aluminium.toml"
COARSE = {"solver.axial_cells": 8, "solver.cell_growth": 1.6, "operation.heating_margin": "50 K"}
RUN = ["run", str(SCENE), "--resume", "--set", "output.checkpoint_interval=0", "--set", "output.pictures=false"]
RUN += [part for name, value in COARSE.items() for part in ("--set", f"{name}={value}")]
STUDY = f"""[study]
scene = "{SCENE}"
record = ["heating_time", "mean_power"]
[set]
solver.axial_cells = 8
solver.cell_growth = 1.6
operation.heating_margin = "55 K"
model.flow = "plug"
[vary]
operation.pressure_drop = ["6 kPa", "8 kPa", "10 kPa"]
bed.bead_diameter = ["4 mm", "4.5 mm", "5 mm"]
"""
OPTIMUM = STUDY + '[optimum]\nminimise = "heating_time"\nbelow = { mean_power = "3 kW" }\n'
PACKING = "pack|--container|cylinder|--bead-diameter|6 mm|--diameter|40 mm|--beads|250"
COLUMN = "fluidise|--width|10 mm|--depth|7 mm|--height|40 mm|--bed-height|8 mm|--bead-diameter|1 mm|--beads|glass"
COLUMN += "|--velocity|0.9 m/s|--time|0.05 s"
SHEAR = "shear|--solid-fraction|0.5|--shear-rate|1e-2|--strains|4|--distance|8|--width|7"
LONGEST_HANG = 120.0
"""Seconds after which a command is lost that was killed in part, or given again for the last time."""

MOST_KILLS = 16
"""Of one command, after which it may come to its end: on a busy machine one that keeps nothing on the way never would."""

Answer = dict[str, NDArray[np.float64]]


def run_answer(place: Path) -> Answer:
    """Of the folder of a run: heating time, energy imbalance, history."""
    summary = json.loads((place / "out" / "result.json").read_text())
    history = {name: np.asarray(column) for name, column in read_table(place / "out" / "history.csv").columns.items()}
    return {"summary": np.array([summary["heating_time"], summary["energy_imbalance"]])} | history


def study_answer(place: Path) -> Answer:
    """Of the folder of a study."""
    rows = json.loads((place / "out" / "table.json").read_text())
    return {"table": np.array([[row["heating_time"], row["mean_power"]] for row in rows])}


def optimum_answer(place: Path) -> Answer:
    """Of the folder of an optimum: every number of optimum.json, in its order."""

    def numbers(content: object) -> list[float]:
        if isinstance(content, bool) or content is None or isinstance(content, str):
            return []
        if isinstance(content, int | float):
            return [float(content)]
        parts = content.values() if isinstance(content, dict) else content
        return [number for part in parts for number in numbers(part)]

    return {"optimum": np.array(numbers(json.loads((place / "out" / "optimum.json").read_text())))}


def packing_answer(place: Path) -> Answer:
    """Of a packing: its places."""
    with h5py.File(place / "out.h5") as file:
        return {"positions": file["positions"][()]}


def table_answer(name: str) -> Callable[[Path], Answer]:
    """Of a table of numbers."""

    def answer(place: Path) -> Answer:
        return {"table": np.genfromtxt(place / name, delimiter=",", skip_header=1)}

    return answer


@dataclass(frozen=True)
class Command:
    """What is killed: its arguments with OUT for the place to write and FILE for its `file`, how its answer is read, and the
    ranks that it runs on."""

    arguments: list[str]
    answer: Callable[[Path], Answer]
    out: str = "out"
    file: str = ""
    ranks: int = 1

    def start(self, place: Path, directory: Path) -> "subprocess.Popen[bytes]":
        """A process that begins it in a place, or goes on there."""
        (place / "given.toml").write_text(self.file)
        words = {"OUT": str(place / self.out), "FILE": str(place / "given.toml")}
        command = [sys.executable, "-m", "porousmold", *(words.get(word, word) for word in self.arguments), "--quiet"]
        if self.ranks > 1:
            command = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", str(self.ranks), *command]
        return subprocess.Popen(
            command, cwd=directory, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True
        )


COMMANDS = {
    "run": Command([*RUN, "--out", "OUT"], run_answer),
    "run on two ranks": Command([*RUN, "--out", "OUT"], run_answer, ranks=2),
    "study": Command(["study", "FILE", "--out", "OUT"], study_answer, file=STUDY),
    "optimum": Command(["optimum", "FILE", "--out", "OUT"], optimum_answer, file=OPTIMUM),
    "pack": Command([*PACKING.split("|"), "--out", "OUT"], packing_answer, "out.h5"),
    "fluidise": Command([*COLUMN.split("|"), "--out", "OUT"], table_answer("out/history.csv")),
    "droplet": Command(["droplet", "--time", "0.1 s", "--out", "OUT"], table_answer("out/history.csv")),
    "shear": Command([*SHEAR.split("|"), "--out", "OUT"], table_answer("out.csv"), "out.csv"),
}


def largest_difference(one: Answer, other: Answer) -> float:
    """Of two answers, over the largest value of each entry."""
    if one.keys() != other.keys() or any(one[name].shape != other[name].shape for name in one):
        return np.inf
    differences = [0.0]
    for name, values in one.items():
        gap = np.abs(np.where(np.isnan(values) & np.isnan(other[name]), 0.0, values - other[name])).max(initial=0.0)
        differences.append(float(gap / max(np.nanmax(np.abs(values), initial=0.0), 1e-300)) if gap else 0.0)
    return max(differences)


def kill(process: "subprocess.Popen[bytes]", command: Command, draw: random.Random) -> None:
    """All processes of the command, or one of its ranks."""
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    ranks = children.read_text().split() if command.ranks > 1 and children.exists() else []
    if ranks:
        os.kill(int(draw.choice(ranks)), signal.SIGKILL)
    else:
        os.killpg(process.pid, signal.SIGKILL)
    process.communicate(timeout=LONGEST_HANG)


def one_command(number: int, command: Command, seconds: float, expected: Answer) -> tuple[int, float, str]:
    """Kills until the command got through: how many there were, the difference of its answer, and what went wrong."""
    draw, kills = random.Random(number), 0
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        while True:
            directory = place / f"from {kills}"
            directory.mkdir()
            process = command.start(place, directory)
            try:
                patience = draw.uniform(0.3, 1.1) * seconds if kills < MOST_KILLS else LONGEST_HANG
                errors = process.communicate(timeout=patience)[1]
            except subprocess.TimeoutExpired:
                try:
                    kill(process, command, draw)
                except subprocess.TimeoutExpired:
                    os.killpg(process.pid, signal.SIGKILL)
                    return kills, np.inf, "the other ranks wait for the killed one"
                kills += 1
                continue
            if process.returncode:
                return kills, np.inf, f"status {process.returncode}: {errors.decode()[-300:]}"
            difference = largest_difference(expected, command.answer(place))
            return kills, difference, "" if difference < (1e-8 if command.ranks > 1 else 1e-10) else "another answer"


def undisturbed(command: Command) -> tuple[float, Answer]:
    """Seconds and answer; the first of two compiles."""
    for _ in range(2):
        place = Path(tempfile.mkdtemp())
        begun = time.perf_counter()
        process = command.start(place, place)
        errors = process.communicate(timeout=600)[1]
        if process.returncode:
            sys.exit(f"the undisturbed command failed: {errors.decode()[-300:]}")
        seconds, answer = time.perf_counter() - begun, command.answer(place)
        shutil.rmtree(place)
    return seconds, answer


def main() -> None:
    """Kill, give again, compare, and say how it went; the status is 1 if any command was lost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--commands", nargs="+", choices=COMMANDS, default=list(COMMANDS))
    options = parser.parse_args()
    alone = {name: undisturbed(COMMANDS[name]) for name in options.commands}
    kills, ended, worst = (dict.fromkeys(options.commands, 0) for _ in range(3))
    lost: list[str] = []

    def attempt(number: int) -> tuple[str, tuple[int, float, str]]:
        name = options.commands[number % len(options.commands)]
        return name, one_command(number, COMMANDS[name], *alone[name])

    begun = 0
    with ThreadPoolExecutor(2) as pool:
        while sum(kills.values()) < options.kills:
            for name, (more, difference, problem) in pool.map(attempt, range(begun, begun + 14)):
                kills[name], ended[name] = kills[name] + more, ended[name] + 1
                worst[name] = max(worst[name], difference)
                lost += [f"{name}: {problem}"] if problem else []
            begun += 14
            print(f"{sum(kills.values())} kills, {begun} commands, {len(lost)} wrong or lost", flush=True)
    for name in options.commands:
        print(
            f"{name}: {kills[name]} kills, {ended[name]} ended, {alone[name][0]:.1f} s, "
            f"largest difference {worst[name]:.1e}"
        )
    print(*lost, sep="\n")
    sys.exit(bool(lost))


if __name__ == "__main__":
    main()
