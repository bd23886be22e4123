"""When the present phase of a course ends, by the time or by what leaves the bed, and what begins anew then."""

from ..solvers.time_control import TimeControl
from .breakpoints import Breakpoints
from .course import Course
from .recorder import Recorder
from .step_rules import StepRules

SHORTEST_PART = 0.05
"""Of the first step: a shorter one is not cut again to meet the end of a phase."""


class PhaseEnds:
    """Of the phases of a `course`, which the steps of `control` meet; what ends is recorded."""

    def __init__(
        self, course: Course, recorder: Recorder, rules: StepRules, control: TimeControl, breakpoints: Breakpoints
    ) -> None:
        self._course, self._recorder, self._rules = course, recorder, rules
        self._control, self._breakpoints = control, breakpoints

    def follow(self, time: float) -> bool:
        """Go on to the next phase where the present one ends at a time (s); whether the flow turns then (collective)."""
        course, problem, number = self._course, self._recorder.problem, self._course.number
        is_past = course.is_past(time, self._recorder.history["outlet_temperature"][-1], self._differences(time))
        direction = course.direction_of(number)
        if is_past:
            course.end_phase(time, problem.heat.balance.by_fluid)
            self._recorder.end_phase(number, time)
            self._control.jump(time)
        self._control.breakpoints = self._breakpoints.present()
        return is_past and course.direction_of(course.number) != direction

    def part_of_step(self, time: float, step: float) -> float:
        """Part of a step (s) just taken from a time (s) that lies within the present phase, as far as what leaves tells its end
        (collective)."""
        course = self._course
        if course.phase.side is None or step < self._control.first_step * SHORTEST_PART:
            return 1.0
        before = self._recorder.history["outlet_temperature"][-1] if time > course.begun else None
        return course.part_of_step(before, self._recorder.problem.balances.outlet_temperature, self._differences(time))

    def _differences(self, time: float) -> float:
        """All temperature differences (K) that count at a time (s; collective)."""
        return self._rules.differences(time, *self._rules.range_now(), self._recorder.problem.inlet_temperature)
