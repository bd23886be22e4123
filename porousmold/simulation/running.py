"""One run from scene to result: integrate, sum up, write."""

import math
import time as clock
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..errors import InputError, SolveError
from ..mesh.aliases import Communicator
from ..mpi import MPI
from ..output.checkpoint import Checkpoint
from ..output.console import Bar, RunProgress
from ..output.folder import RunFolder
from ..output.quantities import Columns
from ..scene.identity import identity_of
from ..scene.scene import Scene
from ..solvers.protocols import Observer, silent
from .accuracy import (
    ALL_IN_DOUBT,
    COARSER,
    LARGEST_DIFFERENCE,
    MOST_WORK_AGAIN,
    Answer,
    Answers,
    Refinements,
    coarser_answers,
    differences,
    is_still_in_doubt,
    may_be_repeated,
    refinements_in_doubt,
    run_to_accuracy,
)
from .answers import AT_ONCE, FINGERS, MELTS, SLOW_TO_CONVERGE, answers_of, doubt_of, hidden_directions
from .mesh_quality import few_cells, of_few_cells
from .observation import field_snapshots, profile_near_wall
from .outcome import summarise
from .result import Result
from .specs import specs_of
from .time_integration import Simulation

FAILED = "failed"
ANSWERS, DOUBT, ITERATIONS = "answers", "doubt", "flow iterations"
MOST_ITERATIONS, ITERATIONS_OF_START = 3.0, 100
"""Iterations of the flow of a repeat with more cells and steps, over those of the first integration and the factor on its steps,
and those beyond that: where finer cells have no steady flow, each step seeks one in vain."""
SOONEST_SAVING, SAVING_PART = 1.0, 0.02
"""Seconds between two checkpoints at least, and the part of the time that they may take: a run that is killed loses little."""
ROOM, FIELDS_KEPT = 10 * 2**20, 120
"""Bytes on the disk, and copies of all unknowns, that a run's files may need: snapshots, fields, a checkpoint and the next."""


Progress = Callable[[float, float, Simulation], None]


class RunInterrupted(Exception):  # noqa: N818 - as KeyboardInterrupt, no error
    """The user stopped the run; what was computed is written."""


def run(
    scene: Scene,
    out: Any = None,
    communicator: Communicator = None,
    progress: Progress | bool | None = None,
    stop: Callable[[], bool] = lambda: False,
    resume: bool = False,
    force: bool = False,
    observe: Observer | None = None,
) -> Result:
    """Run a scene on a communicator (default: all ranks; collective) and give its `Result`.

    out: folder to write, or None to write nothing. progress: True shows a bar, a function is called as progress(time,
    deficit, simulation) after every step; observe: called as observe(text) with what is being done between steps. stop:
    called at every iteration; where it is true the run ends with `RunInterrupted`, its results written as of the last step.
    resume: go on from the checkpoint in `out`, if there is one. A run of the same scene and code that is done in `out` is
    given as it stands; the place of any other, and that of an interrupted one without `resume`, is taken only with `force`,
    which computes anew. Raises `InputError` before anything is written, and `SolveError` after what was computed has been
    written.
    """
    communicator = communicator or MPI.COMM_WORLD
    if isinstance(progress, bool):
        bar = Bar(quiet=not progress or communicator.rank > 0, always=True)
        shown = RunProgress(bar, scene.operation.heating_margin, scene.operation.end_time)
        try:
            return run(scene, out, communicator, shown, stop, resume, force, observe or shown.phase)
        finally:
            bar.close()
    if out is None:
        return _Run(scene, None, communicator, progress, stop, observe).result()
    folder = RunFolder(out, communicator, kept=True)
    try:
        done = None if force and not resume else folder.finished(identity_of(scene))
        if done is not None:
            return Result.of(*done, recalled=True)
        saved = folder.saved() if resume else None
        if not force and saved is None:
            folder.refuse_to_replace()
        if saved is None:
            folder.clear()
        return _Run(scene, folder, communicator, progress, stop, observe, saved).result()
    finally:
        folder.close()


class _Run:
    """The integrations of one run: a single one, finer ones where its answers are in doubt, or those for `solver.accuracy`.

    `_outcomes` holds what came of the integrations before the present one: `ANSWERS`, `DOUBT` and `ITERATIONS`, or `FAILED`.
    `_refined` is by how much the last integration has more cells and steps than the first, whose answers were in `_doubt`; it is
    given up beyond `_most_iterations` of the flow.
    """

    def __init__(
        self,
        scene: Scene,
        folder: RunFolder | None,
        communicator: Communicator,
        progress: Progress | None,
        stop: Callable[[], bool],
        observe: Observer | None,
        saved: Checkpoint | None = None,
    ) -> None:
        self._start = clock.perf_counter()
        self._scene, self._folder, self._communicator = scene, folder, communicator
        self._progress, self._stop, self._observe = progress, stop, observe or silent
        if saved is not None and folder is not None and saved.identity != self._identity(saved.outcomes):
            allowed = "holds a checkpoint of another scene, or of other program code; start without --resume"
            raise InputError("--resume", str(folder.path), allowed)
        self._saved = saved
        self._resumed_at: float | None = None
        self._replayed: list[Any] = list(saved.outcomes) if saved is not None else []
        self._outcomes: list[Any] = []
        self._last: list[Any] = []
        self._simulation: Simulation
        self._integrated = scene
        self._doubt, self._refined, self._most_iterations = "", Refinements(), math.inf

    def _identity(self, outcomes: list[Any]) -> str:
        """Of the checkpoints after such integrations: several of one run, whose answers are compared, must be alike."""
        is_alone = self._scene.solver.accuracy is None and all(outcome == FAILED for outcome in outcomes)
        return identity_of(self._scene, going_on=is_alone)

    def result(self) -> Result:
        """Integrate to the end, write everything, and give the `Result`."""
        failure = interruption = errors = None
        try:
            errors = run_to_accuracy(self._scene, self._integrate, self._hidden)
            if errors is None:
                errors = self._compared()
        except SolveError as problem:
            failure = problem
        except KeyboardInterrupt as problem:
            if not hasattr(self, "_simulation"):
                raise
            interruption = problem
            self._stop()  # a rank stopped by another one acknowledges its own signal
        summary = self._write(errors, failure, interrupted=interruption is not None)
        self._free()
        if failure is not None:
            raise failure
        if interruption is not None:
            raise RunInterrupted(f"stopped at t = {self._simulation.time:.6g} s") from interruption
        return Result.of(summary, self._simulation.recorder.history, resumed_at=self._resumed_at)

    def _free(self) -> None:
        if hasattr(self, "_simulation"):
            self._simulation.free()

    def _compared(self) -> dict[str, float] | None:
        """Differences of the answers from those of a coarser run, where they are in doubt, else None (collective). If they are
        large, the integration is repeated on finer cells, and compared with the one before; at once on a mesh that is a file, and
        where fingers form, which no number of repeats settles: one."""
        scene, own, found = self._integrated, _as_answers(self._last[0]), None
        self._doubt = self._last[0][DOUBT]
        if not self._doubt:
            return None
        coarsest: Answers = {}
        if scene.geometry.kind != "mesh":
            self._observe("comparing with coarser cells and steps")
            coarser = COARSER._replace(steps=1.0) if self._doubt in SLOW_TO_CONVERGE else COARSER
            coarsest = coarser_answers(scene, coarser, self._integrate_aside)
            found = differences(coarsest, own)
            if self._doubt not in AT_ONCE and (not found or max(found.values()) <= _confirmed_below(self._doubt)):
                return found
        if not may_be_repeated(scene, self._work()):
            return found
        again = AT_ONCE.get(self._doubt, ALL_IN_DOUBT)
        factors = again
        if self._doubt not in AT_ONCE and self._doubt not in SLOW_TO_CONVERGE:
            factors = refinements_in_doubt(scene, own, coarsest, self._integrate_aside)
        iterations = MOST_ITERATIONS * self._last[0][ITERATIONS]
        while True:
            finer = self._refined.times(*factors)
            try:
                self._most_iterations = iterations * finer.steps + ITERATIONS_OF_START
                answers = self._integrate(finer.of(scene))
            except SolveError:  # finer cells may have no steady flow
                self._most_iterations = math.inf
                answers = self._integrate(self._refined.of(scene))
                break
            found, own, self._refined, factors = differences(answers, own), answers, finer, again
            most = MOST_WORK_AGAIN * math.prod(ALL_IN_DOUBT) / math.prod(again)
            is_settled = self._doubt == FINGERS or not is_still_in_doubt(found, finer)
            if is_settled or not may_be_repeated(scene, self._work(), most):
                break
        return found

    def _hidden(self) -> Refinements:
        """Factors above 1 in the directions in which coarser cells do not show the error of the last integration."""
        return of_few_cells(specs_of(self._scene), hidden_directions(self._last[0][DOUBT]))

    def _work(self) -> float:
        """Unknowns times steps of the present simulation; 0 where the checkpoint is that of a later integration."""
        if not hasattr(self, "_simulation"):
            return 0.0
        return float(sum(self._simulation.problem.unknowns.values()) * len(self._simulation.recorder.history))

    def _integrate_aside(self, scene: Scene) -> Answers:
        """Answers of a scene that leave the present simulation, and its checkpoint, as they are."""
        simulation = Simulation(specs_of(scene), self._communicator)
        try:
            return answers_of(simulation.integrate(stop=self._stop).recorder)
        finally:
            simulation.free()

    def _integrate(self, scene: Scene) -> dict[str, Answer]:
        """Integrate a scene, for its answers; one that was integrated before the checkpoint is only recalled."""
        self._outcomes += self._last
        self._last = []
        if self._replayed:
            outcome = self._replayed.pop(0)
            self._last, self._integrated = [outcome], scene
            if outcome == FAILED:
                raise SolveError("run", 0.0, "failed before the checkpoint", "")
            return _as_answers(outcome)
        self._free()
        simulation = Simulation(specs_of(scene), self._communicator, self._observe)
        if self._folder is not None and not self._outcomes:
            self._folder.require(ROOM + FIELDS_KEPT * 8 * sum(simulation.problem.unknowns.values()))
        if self._saved is not None:
            self._saved.restore(simulation)
            self._saved, self._resumed_at = None, simulation.time
        self._simulation, self._integrated = simulation, scene
        self._due = clock.perf_counter() + min(self._scene.output.checkpoint_interval, SOONEST_SAVING)
        try:
            simulation.integrate(self._after_step, self._stop)
        except SolveError:
            self._last = [FAILED]
            raise
        answers = answers_of(simulation.recorder)
        iterations = simulation.problem.flow.counts.newton_iterations
        self._last = [{ANSWERS: answers, DOUBT: _doubt_of(simulation, answers), ITERATIONS: iterations}]
        return dict(answers)

    def _after_step(self, time: float, deficit: float) -> None:
        if self._simulation.problem.flow.counts.newton_iterations > self._most_iterations:
            raise SolveError("flow", time, "too many iterations on finer cells", "solver.refine_in_doubt = false")
        if self._folder is not None and self._communicator.bcast(clock.perf_counter() >= self._due):
            begun = clock.perf_counter()
            self._save()
            now = clock.perf_counter()
            worth = max(SOONEST_SAVING, (now - begun) / SAVING_PART)
            self._due = now + min(self._scene.output.checkpoint_interval, worth)
        if self._progress:
            self._progress(time, deficit, self._simulation)

    def _save(self) -> None:
        if self._folder is not None:
            self._folder.save(self._simulation, self._outcomes, self._identity(self._outcomes))

    def _write(
        self, errors: dict[str, float] | None, failure: SolveError | None, *, interrupted: bool
    ) -> dict[str, Any]:
        """Everything that the folder is to hold; gives the summary."""
        simulation, folder, wanted = self._simulation, self._folder, self._scene.solver.accuracy
        summary = summarise(self._integrated, simulation, errors, failure, interrupted=interrupted)
        summary |= {"identity": identity_of(self._scene), "given": self._scene.given()}
        if failure is None and not interrupted:
            answers = answers_of(simulation.recorder)
            summary["warnings"] += (
                _of_comparison(errors, self._doubt, self._refined)
                if wanted is None
                else _of_accuracy(errors, answers, wanted, self._last[0][DOUBT])
            )
        if wanted is None and failure is None and self._outcomes[:1] == [FAILED]:
            summary["warnings"].append(
                "a solve failed on the mesh of the scene; this result is for mesh_refinement "
                f"{self._integrated.solver.mesh_refinement:g}"
            )
        unfinished = failure is not None or interrupted
        with simulation.problem.stopwatch("output"):
            if folder is not None and len(simulation.recorder.history):
                if unfinished:
                    self._save()
                    simulation.keep_fields_of_the_stop()  # none of a run that is resumed
                _write_data(folder, simulation)
        summary["wall_seconds"] = {"total": clock.perf_counter() - self._start} | simulation.problem.stopwatch.seconds
        if folder is not None:
            folder.write_summary(summary, self._integrated, wanted)
            if not unfinished:
                folder.forget_checkpoint()
        return summary


def _doubt_of(simulation: Simulation, answers: Answers) -> str:
    """Why the answers of a simulation may be off, '' where they should not be (collective)."""
    problem = simulation.problem
    doubt = doubt_of(simulation.recorder, answers)
    return doubt or (few_cells(problem.specs, problem.domain, problem.medium.size) if answers else "")


def _write_data(folder: RunFolder, simulation: Simulation) -> None:
    """Tables and fields of a simulation (collective)."""
    problem, recorder = simulation.problem, simulation.recorder
    folder.write_tables(recorder.history, profile_near_wall(problem), _profiles_along(simulation))
    if problem.specs.output.fields:
        folder.write_fields(problem.domain.mesh, field_snapshots(problem, recorder.snapshots.fields, simulation.time))


def _as_answers(outcome: Mapping[str, Any]) -> dict[str, Answer]:
    """Answers of an integration, which in a checkpoint are pairs of numbers."""
    return {name: Answer(*pair) for name, pair in outcome[ANSWERS].items()}


def _profiles_along(simulation: Simulation) -> Columns | None:
    """Columns of the temperatures along the bed at the times asked for, and at the ends of phases; None where there are none."""
    profiles = simulation.recorder.snapshots.profiles
    if not profiles:
        return None
    table = Columns()
    table.add("distance_from_inlet", np.linspace(0.0, simulation.problem.domain.length, len(profiles[0].fluid)))
    for profile in profiles:
        table.add(f"fluid_{profile.label}", profile.fluid)
        table.add(f"beads_{profile.label}", profile.beads)
    return table


def _confirmed_below(doubt: str) -> float:
    """Relative difference from a coarser run up to which that confirms answers in doubt."""
    return LARGEST_DIFFERENCE * SLOW_TO_CONVERGE.get(doubt, 1.0)


def _of_comparison(errors: Mapping[str, float] | None, doubt: str, refined: Refinements) -> list[str]:
    """What is to be said of answers in doubt: that they are of finer cells, that a coarser run does not confirm them, or that
    there is none."""
    worst = max(errors, key=errors.__getitem__) if errors else ""
    if doubt == MELTS and errors and errors[worst] <= _confirmed_below(doubt):
        return []
    if refined != Refinements() and errors:
        more = {"cells along the flow": refined.along, "cells across it": refined.across, "steps": refined.steps}
        finer = ", ".join(f"{factor:.2g} times the {name}" for name, factor in more.items() if factor > 1.0)
        moved = f"coarser cells and steps moved the {_in_words(worst)} by {100.0 * errors[worst]:.2g}%"
        return [
            f"{doubt}{'; ' if doubt else ''}{moved}: this result is of {finer}, and may still be off by some part of that "
            "(see solver.accuracy, solver.refine_in_doubt)"
        ]
    if not doubt:
        return []
    if not errors:
        return [f"{doubt}: what depends on it may be off by some per cent; a finer mesh shows it"]
    if errors[worst] <= _confirmed_below(doubt):
        return []
    return [
        f"{doubt}; coarser cells and steps move the {_in_words(worst)} by {errors[worst]:.1%}, which bounds its error only "
        "roughly (see solver.accuracy)"
    ]


def _in_words(name: str) -> str:
    """An answer's name for a sentence."""
    kind, _, rest = name.rpartition(".")
    words = rest.replace("_", " ")
    return {"targets": f"time of target {words}", "peaks": f"peak of {words}", "end": f"{words} at the end"}.get(
        kind, words
    )


def _of_accuracy(errors: dict[str, float] | None, answers: Answers, wanted: float, doubt: str) -> list[str]:
    """What is to be said of the accuracy that was asked for."""
    if errors is None:
        return []
    found = [
        f"the estimated error {error:.2g} of {_in_words(name)} exceeds the accuracy asked for"
        for name, error in errors.items()
        if error > wanted
    ]
    found += [f"{doubt}: the estimated error may be too small by far"] if doubt == FINGERS else []
    found += [
        f"solver.accuracy has no estimate for {_in_words(name)}: a coarser run does not reach it"
        for name in answers
        if name not in errors
    ]
    if not errors and not answers:
        found.append(
            "solver.accuracy has nothing to act on: no heating time, no target that is met, no layer that cures, and "
            "temperatures at the end that do not change or belong to cycles"
        )
    return found
