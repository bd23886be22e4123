"""`porousmold simplify` on scenes drawn at random: how far is the chosen model from the fullest one, and what does it cost?

Writes docs/model-choice.md. Run: make model-choice (about 10 minutes, two cores). The scenes are those of docs/accuracy.md with
all of [model] left open. Both models are run with the default cells and steps, whose errors nearly cancel in the difference.
"""

import argparse
import multiprocessing
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from mpi4py import MPI

from porousmold import Scene
from porousmold.errors import SolveError
from porousmold.simulation.specs import specs_of
from porousmold.simulation.time_integration import Simulation
from porousmold.study.model_choice import BEAD_MODES, choose_model
from studies.random_scenes import scenes

SEED, COUNT = 17, 40
DOCS = Path(__file__).parent.parent / "docs"
OPEN = {f"model.{name}": None for name in ("flow", "turbulence")}


@dataclass
class Outcome:
    """Relative difference of the chosen model from the fullest, what was estimated of it, CPU seconds of the fullest, the chosen
    and the choice, and what was left out; or why there is none."""

    difference: float = float("nan")
    worth: float = float("nan")
    full: float = float("nan")
    chosen: float = float("nan")
    choosing: float = 0.0
    left_out: list[str] = field(default_factory=list)
    reason: str = ""


def integrated(scene: Scene) -> tuple[float | None, float]:
    """Heating time, and seconds of CPU once the forms are compiled: those of a second run."""
    for _ in range(2):
        start = time.process_time()
        simulation = Simulation(specs_of(scene), MPI.COMM_SELF)
        found = simulation.integrate().recorder.heating_time
        seconds = time.process_time() - start
        simulation.free()
    return found, seconds


def outcome_of(task: tuple[int, float]) -> Outcome:
    """Of a scene (number) at an accuracy of the model."""
    number, accuracy = task
    scene = list(scenes(COUNT, SEED))[number].changed(OPEN)
    seconds = 0.0

    def integrate(coarse: Scene) -> float | None:
        nonlocal seconds
        found, spent = integrated(coarse)
        seconds += spent
        return found

    try:
        full, spent_by_full = integrated(scene.changed({"model.bead_modes": BEAD_MODES}))
        found = choose_model(scene, accuracy, integrate)
        chosen, spent = integrated(found.scene)
    except SolveError as error:
        return Outcome(reason=str(error)[:80])
    if full is None or chosen is None:
        return Outcome(reason="not heated")
    left_out = [f"{choice.key.partition('.')[2]}={choice.value}" for choice in found.choices if choice.chosen]
    return Outcome(chosen / full - 1.0, found.worth, spent_by_full, spent, seconds, left_out)


def main() -> None:
    """Run all and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--accuracies", type=float, nargs="*", default=[0.01, 0.1])
    parser.add_argument("--out", type=Path, default=DOCS / "model-choice.md")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    lines = [
        "# The cheapest model",
        "",
        f"Written by `make model-choice`; do not edit. {COUNT} scenes drawn at random (seed {SEED}), all of `[model]` left open,",
        "`porousmold simplify`: the chosen model beside the fullest one on the same cells. Seconds of CPU, compiled.",
    ]
    with ProcessPoolExecutor(options.processes, multiprocessing.get_context("spawn")) as pool:
        for accuracy in options.accuracies:
            lines += section(accuracy, list(pool.map(outcome_of, [(number, accuracy) for number in range(COUNT)])))
    options.out.write_text("\n".join([*lines, ""]), encoding="utf-8")


def section(accuracy: float, outcomes: list[Outcome]) -> list[str]:
    """The part of the page about one accuracy."""
    known = [one for one in outcomes if not one.reason]
    within = sum(abs(one.difference) <= accuracy for one in known)
    cheaper = sum(one.chosen < one.full for one in known)
    in_all = sum(one.chosen + one.choosing < one.full for one in known)
    gain = np.median([one.full / one.chosen for one in known])
    price = np.median([(one.chosen + one.choosing) / one.full for one in known])
    counts = Counter(name for one in known for name in one.left_out)
    summary = [
        "",
        f"## Allowed: {accuracy:.1%}",
        "",
        f"- {len(known)} of {COUNT} scenes have an answer.",
        f"- The chosen model is within {accuracy:.1%} of the fullest one in {within} of {len(known)}; largest difference "
        f"{max(abs(one.difference) for one in known):.2%}.",
        f"- It is cheaper in {cheaper} of {len(known)}: {gain:.1f} times on the median.",
        f"- With the runs that choose it, an answer costs {price:.2f} of the fullest model (median), less than 1 in {in_all}.",
        "- Left out: " + ", ".join(f"{name} ({count})" for name, count in counts.most_common()) + ".",
        "",
        "| scene | difference | sum of what was left out | full, s | chosen, s | choosing, s | left out |",
        "|---|---|---|---|---|---|---|",
    ]
    print("\n".join(summary[1:8]))
    for number, one in enumerate(outcomes):
        row = f"{one.difference:+.2%} | {one.worth:.2%} | {one.full:.2f} | {one.chosen:.2f} | {one.choosing:.2f} | "
        summary.append(
            f"| {number} | {one.reason + ' | | | | | |' if one.reason else row + ', '.join(one.left_out) + ' |'}"
        )
    return summary


if __name__ == "__main__":
    main()
