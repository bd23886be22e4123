"""When time steps start small again: where given series bend, and where phases of a course end."""

import math

from ..solvers.time_control import TimeControl
from .specs import Specs

FIRST_STEP = 0.05
"""The first time step at most, as a part of the largest one."""
LATE_PART = 0.01
"""Of the time since anything given last changed, that a step may take beyond the largest one: the aluminium mold takes some 40 of
those to its heating time, one whose heater is at its limit took two thousand."""


class Breakpoints:
    """Those of a scene whose steps are no longer than `largest_step` (s) by estimate."""

    def __init__(self, specs: Specs, largest_step: float) -> None:
        self._specs, self._largest = specs, specs.time.largest_step(largest_step)
        self._bends = specs.time.bends(self._largest)

    def present(self) -> tuple[float, ...]:
        """Times (s) of bends, and of the ends of phases that are known by now."""
        course = self._specs.course
        if course is None:
            return self._bends
        end = (course.planned_end,) if math.isfinite(course.planned_end) else ()
        return tuple(sorted({*self._bends, *course.ends[-1:], *end}))

    def control(self) -> TimeControl:
        """Of the steps from the start on; at weak bends and times of output they only end."""
        time, largest = self._specs.time, self._largest
        return TimeControl(
            min(time.steps.first or math.inf, FIRST_STEP * largest) / time.steps.refinement,
            time.steps.growth ** (1.0 / time.steps.refinement),
            largest / time.steps.refinement,
            time.end_time,
            self.present(),
            tuple(self._specs.output.times or ()),
            tuple(sorted(set(time.kinks) - set(self._bends))),
            0.0 if time.steps.largest else LATE_PART / time.steps.refinement,
        )
