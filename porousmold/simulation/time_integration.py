"""Time integration: flow and energy in turn, until the wall is heated or the end time is reached."""

import logging
import math
from collections.abc import Callable

import numpy as np

from ..errors import SolveError
from ..mesh import ranks
from ..mesh.aliases import Communicator
from ..solvers.newton import free_systems
from ..solvers.protocols import Observer, silent
from ..solvers.state import ArrayOf, Copy, Saved, SavedNumbers
from ..solvers.step_error import StepError
from .assembly import assemble
from .breakpoints import Breakpoints
from .ending import Ending
from .phase_ends import PhaseEnds
from .problem import Problem
from .recorder import Recorder
from .regimes import Regimes
from .specs import Specs
from .step_rules import StepRules
from .steppers import STEPPERS, Ahead, Past

LOG = logging.getLogger(__name__)

MOST_CORRECTIONS = 2
"""Of what the fluid displaces in a step."""

BACKWARDS = 1e-3
"""Mass flow, as a part of the expected one, by which a flow may run backwards: that of rounding."""


class Simulation:
    """A scene on a communicator, integrated in time by `integrate()`; `recorder` has what is recorded of it.

    `problem` is the discrete one, `observe(text)` gets the name of each phase. Raises `InputError` like `assemble`.
    """

    def __init__(self, specs: Specs, communicator: Communicator, observe: Observer = silent) -> None:
        self.specs, self._observe = specs, observe
        self.problem = assemble(specs, communicator, observe)
        self.recorder = Recorder(self.problem)
        self._breakpoints = Breakpoints(specs, self.problem.medium.estimates.largest_step)
        self.control = self._breakpoints.control()
        self.time = 0.0
        self.regimes = Regimes(self.problem)
        self._past, self._turns = Past(), False
        self._stepper = STEPPERS[specs.flow.model.update](self.problem)
        self._rules = StepRules(self.problem, self.recorder)
        by_steps = self._rules, self.control, self._breakpoints
        self._phase_ends = None if specs.course is None else PhaseEnds(specs.course, self.recorder, *by_steps)
        self.ending = Ending(specs, self.problem.medium.estimates, self.recorder)

    def free(self) -> None:
        """Free what PETSc holds of it; what was recorded stays (collective)."""
        free_systems(self.problem.domain.mesh)

    def integrate(
        self,
        progress: Callable[[float, float], None] = lambda time, deficit: None,
        stop: Callable[[], bool] = lambda: False,
    ) -> "Simulation":
        """Heat until the whole wall is within the margin or the end time is reached.

        `progress(time, deficit)` is called after every step, `stop()` at every iteration of the flow: where it is true on any
        rank, all raise `KeyboardInterrupt` together. Raises `SolveError` when a solve fails for good. In both cases history,
        snapshots and balance stand at the last good step.
        """

        def observe(text: str) -> None:
            self._observe(text)
            if ranks.anywhere(self.problem.communicator, stop()):
                raise KeyboardInterrupt

        self.problem.flow.observe_with(observe)
        self.problem.heat.observe_with(observe)
        observe("flow: initial guess")
        if not len(self.recorder.history):  # else it goes on from a checkpoint
            self._start()
        if self._turns:  # it was stopped while it looked for that flow
            self._find_turned_flow()
        while not self.ending.is_reached(self.time):
            observe("")
            step = self._step()
            if step is not None:
                self.time += step
                self.regimes.note()
                self.recorder.record(self.time, step, self._stepper.flow_time(self.time, self._past))
                self.recorder.snapshots.keep(self.time, self._steps)
                self._follow_course()  # before a checkpoint is written, which goes on from the phase to come
                progress(self.time, self.recorder.history[f"deficit_{self.specs.time.heated.place}"][-1])
        self.recorder.snapshots.finish(self.time, self._steps)
        return self

    def keep_fields_of_the_stop(self) -> None:
        """Keep the fields of an integration that stopped before its end, but not of a state that is turned already for the phase
        to come, whose flow was not found (collective)."""
        if not self._turns:
            self.recorder.snapshots.finish(self.time, self._steps)

    def _follow_course(self) -> None:
        """Go on to the next phase where the present one ends, with the state mirrored where the flow then turns (collective)."""
        if self._phase_ends is None or not self._phase_ends.follow(self.time) or self.ending.is_reached(self.time):
            return
        self.problem.mirror(*self.problem.heated.functions.values())
        self._past, self._turns = Past(), True
        self._find_turned_flow()

    def _find_turned_flow(self) -> None:
        """Of a phase that has just begun the other way round."""
        with self.problem.stopwatch("flow"):
            self.problem.medium.boundary.set(np.nextafter(self.time, math.inf))
            self.problem.find_flow(self.problem.flow.start, self.time)
        self._turns = False

    @property
    def _steps(self) -> int:
        """Taken so far."""
        return len(self.recorder.history) - 1

    def _start(self) -> None:
        problem, course = self.problem, self.specs.course
        if course is not None and course.direction_of(0) < 0:  # profiles and states are given from the inlet on
            problem.mirror(*problem.heated.functions.values())
        with problem.stopwatch("flow"):
            problem.find_flow(problem.flow.start, 0.0)
            self.regimes.note()
            self.regimes.note_beside()
        _check_direction(problem, self.time)
        self.recorder.record(0.0, 0.0, 0.0)
        self.recorder.snapshots.keep(0.0, 0)

    def _step(self) -> float | None:
        """Take one step; gives its length (s), None where it is to be repeated with another one."""
        problem, control = self.problem, self.control
        step = control.propose(self.time, self._rules.longest_step(), self._rules.longest_of_cure())
        before, factored_at = problem.state.copy(), problem.flow.factored_at
        steps = self._past.steps
        try:
            error = self._advance(step, before, is_smooth=not control.after_jump(self.time - sum(steps)))
            _check_direction(problem, self.time)
            ratio = self._rules.error_ratio(self.time + step, error, self._stepper.flow_error)
        except KeyboardInterrupt:
            self._put_back(before)
            problem.flow.factored_at = factored_at  # this step begins with those factors when it is taken again
            raise
        except SolveError as failure:
            self._put_back(before)
            LOG.info("step of %g s from %g s not taken: %s", step, self.time, failure)
            control.reject_failed(step, failure)
            return None
        may_grow = self.specs.time.steps.largest is None and ratio <= 1.0
        is_quiet = may_grow and self._rules.is_quiet(before.arrays)
        if not control.accept(self.time + step, step, ratio, error.order, is_quiet=is_quiet):
            LOG.info("step of %g s from %g s repeated: %s, %.2g of what is allowed", step, self.time, error, ratio)
            self._put_back(before)
            return None
        part = 1.0 if self._phase_ends is None else self._phase_ends.part_of_step(self.time, step)
        if part < 1.0:
            self._put_back(before)
            control.step = part * step
            return None
        LOG.info(
            "step of %g s to %g s: estimated error %s, %d iterations of the flow, %d of the heat so far",
            *(step, self.time + step, error, problem.flow.counts.newton_iterations, problem.heat.newton_iterations),
        )
        self._past.go_on({name: before.arrays[name] for name in problem.solution.functions}, step)
        return step

    def _advance(self, step: float, before: Copy, *, is_smooth: bool) -> StepError:
        """Flow and heat of a step (s) from a state; gives the estimated error. Raises `SolveError`."""
        problem, at_end = self.problem, None
        ahead = Ahead(self.time, step, self._past, self._rules.limits(), is_smooth, self._rules.flow_alternates())
        for repetitions_left in reversed(range(1 + MOST_CORRECTIONS)):
            with problem.stopwatch("flow"):
                self._stepper.prepare(ahead, at_end)
            with problem.stopwatch("energy"):
                error = problem.heat.step(self.time, step, self._rules.bounds)
            at_end = self._stepper.better_end(step) if repetitions_left else None
            if at_end is None:
                break
            self._put_back(before)
        return error

    def _put_back(self, before: Copy) -> None:
        self.problem.state.put_back(before)
        self._set_boundary()

    def _set_boundary(self) -> None:
        """Give the boundary of the flow the values that the present flow was solved for, that of the heat those of now."""
        self.problem.medium.boundary.set(self._stepper.flow_time(self.time, self._past))
        self.problem.medium.boundary.set_heat(self.time)

    def save(self) -> Saved:
        """Everything the integration goes on from."""
        problem, recorder = self.problem.save(), self.recorder.save()
        numbers = {
            "time": self.time,
            "steps": self._past.steps,
            "turns": self._turns,
            "next_step": self.control.step,
            "rejected": self.control.rejected,
            "regimes": self.regimes.save(),
            "course": None if self.specs.course is None else self.specs.course.save(),
            "jumps": self.control.jumps,
            "problem": problem.numbers,
            "recorder": recorder.numbers,
        }
        past = self.problem.solution.spaces_of(self._past.solution, "past/") if self._past.solution else {}
        return Saved(numbers, problem.arrays | recorder.arrays | past)

    def restore(self, numbers: SavedNumbers, array_of: ArrayOf) -> None:
        """Go on from what `save()` gave; `array_of(name, space)` gives the local array of a name (collective)."""
        self.time = numbers["time"]
        self._turns = numbers["turns"]
        self.regimes.restore(numbers["regimes"])
        if self.specs.course is not None:
            self.specs.course.restore(numbers["course"])
            self.control.breakpoints = self._breakpoints.present()
        self.control.jumps = list(numbers["jumps"])
        self.control.go_on_with(numbers["next_step"])
        self.control.rejected = numbers["rejected"]
        if numbers["steps"]:
            self._past = Past(self.problem.solution.read(array_of, "past/"), numbers["steps"])
        self.recorder.restore(numbers["recorder"], array_of)
        self.problem.restore(numbers["problem"], array_of)
        self._set_boundary()


def _check_direction(problem: Problem, time: float) -> None:
    """Count what the flow draws in at the outlet; `SolveError` where it runs backwards (collective)."""
    counts, mass_flow = problem.flow.counts, problem.balances.mass_flow
    counts.largest_drawn_in = max(counts.largest_drawn_in, problem.balances.drawn_in)
    if mass_flow < -BACKWARDS * problem.medium.estimates.mass_flow:
        raise SolveError(
            "flow",
            time,
            f"it runs backwards, {mass_flow:.3g} kg/s",
            "a larger operation.pressure_drop, which must overcome operation.gravity and beads that move against it",
        )
