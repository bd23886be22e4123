"""Time step control: growth up to a maximum and as the estimated error allows, reduced at breakpoints of series and after failed
steps (Hairer, Wanner, Solving Ordinary Differential Equations II, section IV.8)."""

import math
from dataclasses import dataclass, field
from itertools import pairwise

from ..errors import SolveError

SMALLEST_FRACTION = 1e-6
"""Steps below this fraction of the first step mean that no step converges."""

MOST_FAILURES = 4
"""Steps in succession that may fail to converge."""

JUMP_STEPS = 3.0
"""First steps' lengths after a jump that count as near it. Jumps are the start, and the end of a change shorter than one step."""

SMALL_ERROR = 0.01
"""Estimated error over that which is allowed, up to which steps grow beyond the largest one: that is a part of the time in which
a front passes, with an error of 0.05 to 0.5 on the shipped scenes, and shorter than a slow ramp needs."""

SAFETY, LEAST_FACTOR = 0.85, 0.2
"""Part of the step that the estimated error would allow, and the least factor on a step."""


@dataclass
class TimeControl:
    """Proposes steps (s).

    `breakpoints` are times at which given series change slope: steps end there and start small again. At
    `weak_breakpoints`, where they change it by little, and at `stops` steps only end.
    The largest step grows with the time since anything given last changed, to its `late_part`: what takes a hundred of the
    estimated steps is slower than was estimated. It is exceeded, too, as far as the estimated error stays at `SMALL_ERROR`. Where
    the `late_part` is 0 it is the largest one whatever happens.

    State is `step` (the next one), `jumps`, times (s) at which everything given changed at once, and counters.
    """

    first_step: float
    growth: float
    largest_step: float
    end_time: float
    breakpoints: tuple[float, ...] = ()
    stops: tuple[float, ...] = ()
    weak_breakpoints: tuple[float, ...] = ()
    late_part: float = 0.0
    step: float = field(init=False)
    jumps: list[float] = field(init=False, default_factory=list)
    rejected: int = field(init=False, default=0)
    _failures: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        self.first_step = min(self.first_step, self.largest_step)
        self.step = self.first_step

    def after_jump(self, time: float) -> bool:
        """Whether a step from `time` is among the first few after a jump, where the fluid may jump, too: after the start, and
        after two breakpoints close together, unless they are rows among many that lie as close."""
        far = (-math.inf, *self.breakpoints, math.inf)
        close = [end - begin < self.first_step for begin, end in pairwise(far)]
        ends = (end for n, end in enumerate(far[1:]) if close[n] and not (close[n - 1] or close[n + 1]))
        last = max(instant for instant in (0.0, *self.jumps[-1:], *ends) if instant <= time * (1 + 1e-9))
        return time - last < self.first_step * JUMP_STEPS

    def jump(self, time: float) -> None:
        """Everything given changes at a time (s): steps start small again."""
        self.jumps = [time]
        self.step = self.first_step

    def propose(self, time: float, longest: float = math.inf, at_most: float = math.inf) -> float:
        """The step to try from `time`, `at_most` so long, and no longer than `longest` where that is not below the first step:
        never across a breakpoint or the end."""
        self.step = min(self.step, max(longest, self.first_step), at_most)
        ends = (*self.breakpoints, *self.weak_breakpoints, *self.stops, self.end_time)
        stops = [stop for stop in ends if stop > time * (1 + 1e-12)]
        room = min(stops, default=self.end_time) - time
        if room <= self.step * (1 + 1e-9):
            self.step = max(self.step, room)
            return room
        return room / 2 if room < 2 * self.step else self.step

    def accept(self, time: float, step: float, error: float, order: int = 3, *, is_quiet: bool = False) -> bool:
        """After a good step to `time`: give True, or False if its estimated `error` asks for a repetition.

        The error is over that which is allowed, and of the `order` in the step's length. After a quiet step, in which nothing
        changed anywhere, the next may be longer than the largest one.
        """
        self._failures = 0
        allowed = SAFETY * max(error, 1e-12) ** (-1.0 / order)
        if error > 1.0 and step > self.first_step * SMALLEST_FRACTION:
            self.rejected += 1
            self.step = step * max(LEAST_FACTOR, allowed)
            return False
        if self._restarts_at(time):
            self.step = min(self.first_step, self.step)
            return True
        grown = max(self.step, step) * min(self.growth, max(LEAST_FACTOR, allowed))
        late = self.late_part * (time - self._last_change(time))
        exact = step * (SMALL_ERROR / max(error, 1e-12)) ** (1.0 / order) if self.late_part else 0.0
        self.step = grown if is_quiet else min(max(self.largest_step, late, exact), grown)
        return True

    def _last_change(self, time: float) -> float:
        """Time (s) at which what is given changed last: the start, a breakpoint of any kind, or a jump."""
        changes = (0.0, *self.jumps[-1:], *self.breakpoints, *self.weak_breakpoints)
        return max(instant for instant in changes if instant <= time * (1 + 1e-9))

    def _restarts_at(self, time: float) -> bool:
        """Whether a series changes its slope at a time (s), unless it does so before and after within a largest step: then it
        is a row among many, of a course that the steps follow."""
        reach = 1e-9 * max(time, 1.0)
        if not any(abs(time - instant) <= reach for instant in self.breakpoints):
            return False
        before = any(reach < time - instant < self.largest_step for instant in self.breakpoints)
        after = any(reach < instant - time < self.largest_step for instant in self.breakpoints)
        return not (before and after) or self.after_jump(time)

    def go_on_with(self, step: float) -> None:
        """Propose `step` next, or start small again where that was cut back so far that the solves gave up."""
        given_up = step < self.first_step * SMALLEST_FRACTION
        self.step = self.first_step if given_up else step

    def reject_failed(self, step: float, failure: SolveError) -> None:
        """After a step that did not converge: a quarter of it next; raises `failure` after `MOST_FAILURES` in succession."""
        self.rejected += 1
        self._failures += 1
        self.step = step / 4.0
        if self._failures >= MOST_FAILURES or self.step < self.first_step * SMALLEST_FRACTION:
            raise failure
