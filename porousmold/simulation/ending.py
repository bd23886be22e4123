"""When an integration ends: what was waited for is there, nothing changes any more, or the time is up."""

import bisect

from .estimates import Estimates
from .recorder import Recorder
from .specs import Specs

STEADY_AFTER = 3.0
"""Expected heating times before which nothing counts as steady: else a front may still be to come."""
STEADY_CHANGE = 1e-4
"""Part of all temperature differences, and of the heat stored, by which a steady state may still change."""
LEAST_ROWS = 10
"""Of the history, before which nothing counts as steady."""
ROUNDING = 1e-12
"""Of a time, over it."""


class Ending:
    """The end of an integration, told from what is recorded."""

    def __init__(self, specs: Specs, estimates: Estimates, recorder: Recorder) -> None:
        self._specs, self._estimates, self._recorder = specs, estimates, recorder

    def is_reached(self, time: float) -> bool:
        """Whether the integration ends at a time (s)."""
        course = self._specs.course
        if time >= self._specs.time.end_time * (1.0 - ROUNDING):
            return True
        if course is not None and course.repeats:
            is_met = bool(self._specs.time.targets) and self._recorder.reached and self._is_kept(time)
            return course.is_over or course.has_waited(time) or is_met
        return self._is_heated_for_good(time) or self.is_steady(time)

    def _is_heated_for_good(self, time: float) -> bool:
        """Whether the wall is heated, or all targets are met, and the inlet's temperature has no change ahead."""
        changes = list(self._specs.heat.inlet_temperature.breakpoints)
        if self._specs.course is not None and not self._specs.course.waits_for_heat:
            changes += self._specs.flow.driven_by.breakpoints
        last_change = max(changes, default=0.0)
        return self._recorder.reached and time >= last_change * (1.0 - ROUNDING) and self._is_kept(time)

    def _is_kept(self, time: float) -> bool:
        """Whether the targets to keep, all met by a time (s), are not to be lost any more: what anything given changes for the
        last time has come through, and where the flow has cycles they have held through a whole one."""
        course, kept = self._specs.course, [target.name for target in self._specs.time.targets if target.keep]
        if not kept:
            return True
        last = max(self._specs.time.breakpoints, default=0.0)
        if last > 0.0 and time < (last + self._estimates.heating_duration) * (1.0 - ROUNDING):
            return False
        met = [since for name in kept if (since := self._recorder.targets[name]) is not None]
        if course is None or not met or not (course.repeats or course.waits_for_heat):
            return True
        return course.last_cycle is not None and time - max(met) >= course.last_cycle * (1.0 - ROUNDING)

    def is_steady(self, time: float) -> bool:
        """Whether nothing has changed in the second half of the time (s), in a scene without operation.end_time: then what is
        still waited for never comes."""
        spec, history = self._specs.time, self._recorder.history
        begun = max(2.0 * max(spec.breakpoints, default=0.0), STEADY_AFTER * self._estimates.heating_duration)
        is_holding = any(
            self._recorder.held_since[one.name] is not None and self._recorder.targets[one.name] is None
            for one in spec.targets
        )
        if not spec.until_steady or time < begun or len(history) < LEAST_ROWS or is_holding:
            return False
        half = bisect.bisect_left(history["time"], 0.5 * time)
        range_of_all = max(history["highest_temperature"]) - min(history["lowest_temperature"])
        stored = max(abs(heat) for heat in history["heat_stored"])
        scales: dict[str, float] = {"temperature": range_of_all, "heat_stored": stored, "cure": 1.0}
        if any(one.asks == "cured" and self._recorder.targets[one.name] is None for one in spec.targets):
            cures = [history[name][-1] for name in history if _kind_of(name) == "cure"]
            scales["cure"] = min(cures, default=1.0)  # one that is waited for may begin slowly
        return all(
            max(history[name][half:]) - min(history[name][half:]) <= STEADY_CHANGE * scales[kind]
            for name in history
            if (kind := _kind_of(name)) is not None
        )


def _kind_of(column: str) -> str | None:
    """What a column of the history is, of those that do not change in a steady state."""
    if column.startswith(("temperature_", "sensor_", "lowest_", "highest_")) and not column.endswith("_place"):
        return "temperature"
    return column if column == "heat_stored" else "cure" if column.startswith("cure_") else None
