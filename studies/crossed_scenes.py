"""Three hundred scenes that cross every feature: is there an answer, how far is it from that of twice finer cells and steps,
which feature is the worst? Writes docs/crossed-scenes.md. Run: make crossed-scenes (about an hour, two cores).

A Latin hypercube with a fixed seed. What a scene answers are its heating time, when its targets are met, the highest temperature
of layers that cure, and without a heating time the temperatures and the heat stored at the end.
"""

import argparse
import json
import math
import multiprocessing
import time
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from porousmold import InputError, Scene, run
from porousmold.errors import SolveError
from porousmold.simulation.result import Result
from porousmold.simulation.running import RunInterrupted
from porousmold.simulation.targets import highest_until_met
from studies.crossed_draws import CHOICES, COUNT, SEED, scene_of, scenes
from studies.page import Page, strategies

HERE = Path(__file__).parent
DOCS = HERE.parent / "docs"
SAMPLE = 80
PATIENCE = 240.0
"""CPU seconds after which a run counts as without answer."""
PATIENCE_FINER = 360.0
"""The same of a finer run, without which a scene is not compared."""
WANTED = 0.003
"""Error that defaults are to keep."""
FAR_OFF = 0.01
"""Error that a run should warn of."""
NOTHING = 0.01
"""K of difference between all temperatures of a run below which nothing happens in it, and it has no answer to compare."""
LEAST_HEAT = 1e-3
"""J stored, below which it is the rounding of heat that passes."""


@dataclass
class Outcome:
    """What came of a run: its answers, (value, what a relative error is of), seconds of CPU and warnings, or why it has none."""

    answers: dict[str, tuple[float | None, float]] = field(default_factory=dict)
    seconds: float = 0.0
    steps: int = 0
    rejected: int = 0
    repeated: int = 0
    imbalance: float = 0.0
    beyond: float = 0.0
    reason: str = ""
    warnings: list[str] = field(default_factory=list)
    strategies: dict[str, int] = field(default_factory=dict)
    refinements: dict[str, float] = field(default_factory=dict)


def answers_of(scene: Scene, result: Result) -> dict[str, tuple[float | None, float]]:
    """Times over themselves, temperatures over the range of all temperatures, heat over the most that was stored.

    The extremes of a region are none of them: where gas meets a wall of another temperature at the inlet they are those of a
    corner, which is singular (scene 42: 674.4, 679.0 and 682.1 K with 1, 2 and 4 times the cells).
    """
    summary, history = result.summary, result.history
    found: dict[str, tuple[float | None, float]] = {}
    given = abs(scene.operation.initial_temperature - float(np.max(history["inlet_temperature"])))
    difference = max(given, float(np.max(history["highest_temperature"]) - np.min(history["lowest_temperature"])))
    if summary["heating_time"] is not None:
        found["heating time"] = summary["heating_time"], summary["heating_time"]
    for name, instant in summary["targets"].items():
        if instant is not None:
            found[f"target {name}"] = instant, instant
    for name in history:
        if name.startswith("cure_"):
            place = name.removeprefix("cure_")
            met = summary["targets"].values()
            peak = highest_until_met(list(history["time"]), list(history[f"highest_{place}"]), met)
            found[f"peak of {place}"] = peak, difference
    if summary["heating_time"] is None and summary["end_time"] >= scene.operation.end_time * (1.0 - 1e-9):
        for name in history:
            if name == "outlet_temperature" or name.startswith("temperature_"):
                found[name.replace("_", " ")] = float(history[name][-1]), difference
        found["heat stored"] = float(history["heat_stored"][-1]), float(np.max(np.abs(history["heat_stored"])))
    return found


def outcome(task: tuple[int, dict[str, Any], float]) -> Outcome:
    """`Outcome` of a scene with changes, (number, changes, CPU seconds)."""
    number, changes, patience = task
    drawn = scene_of(number)
    start = time.process_time()
    try:
        scene = drawn.changed(changes)
        result = run(scene, communicator=MPI.COMM_SELF, stop=lambda: time.process_time() - start > patience)
    except (InputError, SolveError, RunInterrupted) as failure:
        return Outcome(seconds=time.process_time() - start, reason=f"{type(failure).__name__}: {failure}")
    summary = result.summary
    beyond = next((w for w in summary["warnings"] if "beyond those given" in w), "")
    return Outcome(
        answers_of(scene, result),
        time.process_time() - start,
        summary["time_steps"],
        summary["rejected_steps"],
        summary["repeated_steps"],
        summary["energy_imbalance"],
        float(beyond.split(" K")[0].split()[-1]) if beyond else 0.0,
        warnings=summary["warnings"],
        strategies=summary["flow_strategies"],
        refinements=summary["refinements"],
    )


def finer(number: int, own: Outcome) -> dict[str, Any]:
    """Settings for twice the cells in each direction of those that a run ended with, and twice the steps."""
    along, across, steps = own.refinements.values()
    cells = {"solver.mesh_refinement": 2.0 * across, "solver.step_refinement": 2.0 * steps}
    return cells | ({"solver.axial_refinement": along / across} if along != across else {})


def pair(task: tuple[int, bool]) -> dict[str, Outcome]:
    """Outcomes of a scene: "own", and where asked for and there is an answer "finer"."""
    number, is_compared = task
    own = outcome((number, {}, PATIENCE))
    if not is_compared or own.reason:
        return {"own": own}
    return {"own": own, "finer": outcome((number, finer(number, own), PATIENCE_FINER))}


def errors(own: Outcome, finer: Outcome) -> dict[str, float]:
    """Relative error of every answer that both runs have; infinite where only one has it; none where nothing happens."""
    found: dict[str, float] = {}
    differences = [scale for name, (_, scale) in own.answers.items() if name.startswith(("temperature", "outlet"))]
    if differences and max(differences) < NOTHING:
        return found
    for name in sorted({*own.answers, *finer.answers}):
        if name == "heat stored" and own.answers.get(name, (0.0, 1.0))[1] < LEAST_HEAT:
            continue
        if name not in own.answers or name not in finer.answers:
            found[name] = math.inf
            continue
        (value, scale), (other, _) = own.answers[name], finer.answers[name]
        assert value is not None and other is not None
        found[name] = abs(value - other) / max(scale, 1e-12)
    return found


def main() -> None:
    """Run all and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=DOCS / "crossed-scenes.md")
    parser.add_argument("--only", type=int, nargs="*", help="numbers of scenes to run alone, without a page")
    parser.add_argument("--first", type=int, default=0, help="number of the first scene")
    parser.add_argument("--step", type=int, default=1, help="one scene in so many")
    parser.add_argument("--every", type=int, default=COUNT // SAMPLE, help="one scene in so many against a finer run")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--raw", type=Path, help="file for all outcomes as JSON")
    parser.add_argument("--note", default="", help="a sentence for the page")
    parser.add_argument("--page-of", type=Path, metavar="RAW", help="run nothing: the page of such a file")
    options = parser.parse_args()
    numbers = list(range(options.first, COUNT, options.step)) if options.only is None else options.only
    drawn = [choice for choice, _ in scenes()]
    sample = [
        number
        for number in numbers
        if options.only is not None
        or ((number - options.first) % options.every == 0 and drawn[number]["kind"] != "narrow")
    ]
    tasks = [(n, n in sample) for n in numbers]
    results: dict[tuple[int, str], Outcome] = {}
    if options.page_of:
        for entry in json.loads(options.page_of.read_text()):
            number, kind, _ = entry.pop("number"), entry.pop("kind"), entry.pop("drawn")
            results[number, kind] = Outcome(**entry)
        write_page(options.out, drawn, results, sample, options.note)
        return
    with ProcessPoolExecutor(options.processes, multiprocessing.get_context("spawn")) as pool:
        for (number, _), of_scene in zip(tasks, pool.map(pair, tasks), strict=True):
            for kind, result in of_scene.items():
                results[number, kind] = result
                line = f"{kind} {number}: {result.seconds:.1f} s, {result.steps} steps ({result.rejected}, {result.repeated})"
                values = {name: round(value, 4) for name, (value, _) in result.answers.items() if value}
                print(line, result.reason[:200] or values, list(result.refinements.values()), flush=True)
            if "finer" in of_scene:
                print("   ", _text(errors(of_scene["own"], of_scene["finer"])), drawn[number], flush=True)
            if options.raw:
                raw = [
                    {"number": n, "kind": kind, "drawn": drawn[n], **vars(one)} for (n, kind), one in results.items()
                ]
                options.raw.write_text(json.dumps(raw, indent=1))
    if options.only is None:
        write_page(options.out, drawn, results, sample, options.note)


def _text(found: Mapping[str, float]) -> str:
    largest = sorted(found.items(), key=lambda item: -item[1])[:3]
    return ", ".join(f"{name} {100 * value:.3f} %" for name, value in largest)


def write_page(
    path: Path, drawn: list[dict[str, Any]], results: Mapping[tuple[int, str], Outcome], sample: list[int], note: str
) -> None:
    """The page: scenes without an answer, errors, and errors by feature."""
    own = {n: result for (n, kind), result in results.items() if kind == "own"}
    refused = [n for n, result in own.items() if result.reason.startswith("InputError")]
    failed = [n for n, result in own.items() if result.reason and n not in refused]
    both = [n for n in sample if (n, "finer") in results and not results[n, "finer"].reason]
    slow = sum((n, "finer") in results for n in sample) - len(both)
    found = {n: errors(own[n], results[n, "finer"]) for n in both}
    worst = {n: max(found[n].values()) for n in both if found[n]}
    both = list(worst)
    if not both:
        print("No scene beside a finer run: no page.")
        return
    seconds = np.array([result.seconds for result in own.values() if not result.reason])
    values = np.array(list(worst.values()))
    far_off = [n for n in both if worst[n] > FAR_OFF]
    silent = [n for n in far_off if not _is_told(own[n])]
    alarms = [n for n in both if _is_told(own[n]) and worst[n] <= 0.5 * FAR_OFF]
    times = [value for n in both for name, value in found[n].items() if name.startswith(("heating", "target"))]
    page = Page(
        "# Scenes that cross every feature",
        "",
        f"Written by `make crossed-scenes`; do not edit. A Latin hypercube of {len(own)} scenes (seed {SEED}) over every",
        "closure and feature: layers, contacts, sources, cure, bead modes, one temperature, blower, heater, returned air,",
        "programmes and series, all fluids, gravity, moving beads, every kind of wall, no flow, heat from outside, meshes of",
        "one's own, narrow molds in three dimensions, full, developed and plug flow, differences of 0.2 to 500 K.",
        "",
        f"**{len(own) - len(refused) - len(failed)} of {len(own)} have an answer**, {len(refused)} are refused, {len(failed)} "
        f"failed or took more than {PATIENCE:g} s. CPU seconds of a run: median {np.median(seconds):.1f}, 95 % "
        f"{np.quantile(seconds, 0.95):.1f}, longest {seconds.max():.1f}. Largest imbalance of heat "
        f"{max(abs(result.imbalance) for result in own.values()):.1e}, largest excess over the temperatures given "
        f"{max(result.beyond for result in own.values()):.2g} K.",
        "",
        f"The worst answer of each of {len(both)} scenes in which anything happens, against twice the cells in each direction "
        f"and twice the steps: median "
        f"{100 * np.median(values):.3f} %, 95 % {100 * np.quantile(values, 0.95):.3f} %, largest {100 * values.max():.3g} %; "
        f"within {WANTED:.1%} are {np.sum(values <= WANTED)}. Of {slow} more the finer run takes over {PATIENCE_FINER:g} s.",
        f"Of {len(times)} heating times and times of targets: median {100 * np.median(times):.3f} %, "
        f"95 % {100 * np.quantile(times, 0.95):.3f} %, largest {100 * max(times):.3g} %.",
        "",
        f"{sum(max(result.refinements.values(), default=1.0) > 1.0 for result in own.values())} runs were repeated on finer "
        "cells, as a coarser run had other answers (solver.refine_in_doubt).",
        "",
        f"Off by more than {FAR_OFF:.0%} are {len(far_off)} scenes, {len(silent)} of them without a warning that says so"
        f"{': ' + ', '.join(map(str, silent)) if silent else ''}; {len(alarms)} scenes are warned of that are off by less "
        "than half of that.",
        note,
        "",
        "## By feature",
    )
    rows = []
    for name, choices in CHOICES.items():
        for choice in dict.fromkeys(str(choice).strip() for choice in choices):  # "air " is air drawn twice as often
            some = [worst[n] for n in both if str(drawn[n][name]).strip() == choice]
            if some:
                rows.append((name, choice, len(some), f"{100 * np.median(some):.3f} %", f"{100 * max(some):.3f} %"))
    page.table(("feature", "choice", "scenes", "median", "largest"), rows)
    page.add("## The worst scenes")
    largest = sorted(worst, key=lambda n: -worst[n])[:12]
    page.table(
        ("scene", "errors", "warnings", "what"),
        (
            (n, _text(errors(own[n], results[n, "finer"])), "; ".join(w[:80] for w in own[n].warnings), _what(drawn[n]))
            for n in largest
        ),
    )
    page.add("## Scenes without an answer")
    page.table(("scene", "reason", "what"), ((n, own[n].reason[:200], _what(drawn[n])) for n in (*refused, *failed)))
    page.add("## How the flows were found", "", *strategies(own[n].strategies for n in own if not own[n].reason))
    page.write(path)


def _is_told(outcome: Outcome) -> bool:
    """Whether the run warns that its answers may be off for the sake of its cells and steps."""
    return any("coarser cells and steps" in one or "within one cell of the bed" in one for one in outcome.warnings)


def _what(drawn: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} {drawn[name]}".strip() for name in CHOICES)


if __name__ == "__main__":
    main()
