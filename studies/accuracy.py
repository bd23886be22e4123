"""Whether `solver.accuracy` can be trusted: its estimate against the true error, and what it costs. Writes docs/accuracy.md.

Run: make accuracy (about 15 minutes, two cores). Scenes are drawn at random as for docs/random-scenes.md, and as for
docs/crossed-scenes.md where they are heated, both from other seeds; the reference has twice the cells in each direction and twice
the steps of the run that was settled on.
"""

import argparse
import multiprocessing
import time
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from mpi4py import MPI

from porousmold import Scene
from porousmold.errors import InputError, SolveError
from porousmold.simulation.accuracy import Answer, Refinements, refinements_of, run_to_accuracy
from porousmold.simulation.answers import HEATING_TIME, answers_of, doubt_of, hidden_directions
from porousmold.simulation.specs import specs_of
from porousmold.simulation.time_integration import Simulation
from studies import crossed_draws, crossed_scenes
from studies.page import Page
from studies.random_scenes import scenes

SEED, COUNT = 21, 40
CROSSED_SEED = 34
"""Of scenes across all features; no order of `simulation.accuracy` was chosen on them, nor on those of `SEED`."""
FACTOR = 3.0
"""Between an error and its estimate, that counts as right."""
NEGLIGIBLE = 1e-4
"""Errors and estimates below it count as right."""
MOST_CPU = 20.0
"""Seconds of a default run beyond which a scene has no reference here."""
DOCS = Path(__file__).parent.parent / "docs"


@dataclass
class Runs:
    """Marches of a scene: refinements, heating time and seconds of CPU of each."""

    refinements: list[Refinements] = field(default_factory=list)
    times: list[float | None] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    doubt: str = ""

    def hidden(self) -> Refinements:
        """Directions in which coarser cells do not show the error of the last integration."""
        return hidden_directions(self.doubt)

    def __call__(self, scene: Scene) -> dict[str, Answer]:
        start = time.process_time()
        self.refinements.append(refinements_of(scene))
        try:
            self.times.append(None)
            simulation = Simulation(specs_of(scene), MPI.COMM_SELF)
            recorder = simulation.integrate().recorder
            self.times[-1], self.doubt = recorder.heating_time, doubt_of(recorder, answers_of(recorder))
            simulation.free()
        finally:
            self.seconds.append(time.process_time() - start)
        return {} if self.times[-1] is None else {HEATING_TIME: Answer.by_itself(self.times[-1])}


@dataclass
class Outcome:
    """True and estimated relative error, seconds of all runs over those of the last one, its refinements; or why not."""

    true: float = float("nan")
    estimated: float = float("nan")
    cost: float = float("nan")
    refinements: Refinements = field(default_factory=Refinements)
    reason: str = ""

    @property
    def is_right(self) -> bool:
        """Whether the estimate is within `FACTOR` of the error, or both are negligible."""
        if max(self.true, self.estimated) < NEGLIGIBLE:
            return True
        return self.true / FACTOR <= self.estimated <= FACTOR * self.true


def crossed_numbers() -> list[int]:
    """One of some crossed scenes, but for meshes of one's own, which no accuracy refines."""
    step = crossed_draws.COUNT // crossed_scenes.SAMPLE
    drawn = [choice for choice, _ in crossed_draws.scenes(seed=CROSSED_SEED)]
    return [number for number in range(0, crossed_draws.COUNT, step) if drawn[number]["kind"] not in ("narrow", "mesh")]


def outcome_of(task: tuple[str, int, float]) -> Outcome:
    """Of a scene ("random" or "crossed", its number) at an accuracy."""
    kind, number, accuracy = task
    runs = Runs()
    scene = list(scenes(COUNT, SEED))[number] if kind == "random" else crossed_draws.scene_of(number, CROSSED_SEED)
    try:
        if kind == "crossed" and not Runs()(scene):
            return Outcome(reason="not heated")
        estimated = run_to_accuracy(scene.changed({"solver.accuracy": accuracy}), runs, runs.hidden)
        if not estimated:
            return Outcome(reason="not heated")
        refinements = runs.refinements[-1]
        if runs.seconds[-1] > MOST_CPU:
            return Outcome(reason=f"{sum(runs.seconds):.0f} s of CPU: no reference")
        reference = Runs()(refinements.times(2.0, 2.0, 2.0).of(scene)).get(HEATING_TIME)
    except (InputError, SolveError) as error:
        return Outcome(reason=str(error)[:80])
    assert runs.times[-1] is not None and reference is not None
    error = abs(runs.times[-1] / reference.value - 1.0)
    return Outcome(error, estimated[HEATING_TIME], sum(runs.seconds) / runs.seconds[-1], refinements)


def main() -> None:
    """Run all and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--accuracy", type=float, default=0.003)
    parser.add_argument("--out", type=Path, default=DOCS / "accuracy.md")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--kind", choices=("random", "crossed"), nargs="+", default=("random", "crossed"))
    options = parser.parse_args()
    numbers = {"random": list(range(COUNT)), "crossed": crossed_numbers()}
    tasks = [(kind, number, options.accuracy) for kind in options.kind for number in numbers[kind]]
    with ProcessPoolExecutor(options.processes, multiprocessing.get_context("spawn")) as pool:
        outcomes = dict(zip(tasks, pool.map(outcome_of, tasks), strict=True))
    page = Page(
        "# Accuracy on request",
        "",
        f"Written by `make accuracy`; do not edit. Heating times with `solver.accuracy = {options.accuracy:g}`; true errors",
        "against twice the cells in each direction and twice the steps.",
    )
    for kind in options.kind:
        of_kind = {number: one for (other, number, _), one in outcomes.items() if other == kind}
        write_part(page, kind, of_kind, options.accuracy)
    page.write(options.out)


TITLES = {
    "random": f"## {COUNT} scenes drawn at random (seed {SEED})",
    "crossed": f"## Scenes across all features (as of docs/crossed-scenes.md, seed {CROSSED_SEED}, one in "
    f"{crossed_draws.COUNT // crossed_scenes.SAMPLE})",
}


def write_part(page: Page, kind: str, outcomes: Mapping[int, Outcome], accuracy: float) -> None:
    """What is to be said of one kind of scenes, and their table; those that are not heated are only counted."""
    heated = {number: one for number, one in outcomes.items() if one.reason != "not heated"}
    known = [outcome for outcome in heated.values() if not outcome.reason]
    right = sum(outcome.is_right for outcome in known)
    low = sum(outcome.true > max(FACTOR * outcome.estimated, NEGLIGIBLE) for outcome in known)
    met = sum(outcome.true <= accuracy for outcome in known)
    costs = [outcome.cost for outcome in known]
    page.add(
        "",
        TITLES[kind],
        "",
        f"- {len(known)} of {len(heated)} scenes that are heated have an answer and a reference.",
        f"- The error is within the requested accuracy in {met} of {len(known)}.",
        f"- The estimate is within a factor of {FACTOR:g} of the error in {right} of {len(known)} (errors below {NEGLIGIBLE:g}"
        f" count as right); it is too low by more than that in {low}.",
        f"- All runs together take {np.median(costs):.2f} times the computing time of the final run (median; 90 % below"
        f" {np.quantile(costs, 0.9):.2f}).",
        "",
        "| scene | error | estimated | cells along x | across x | steps x | all runs over the last |",
        "|---|---|---|---|---|---|---|",
    )
    for number, one in heated.items():
        factors = " | ".join(f"{factor:.2g}" for factor in one.refinements)
        row = f"{one.true:.1e} | {one.estimated:.1e} | {factors} | {one.cost:.2f}"
        page.add(f"| {number} | {one.reason or row} |" + (" | | | | |" if one.reason else ""))


if __name__ == "__main__":
    main()
