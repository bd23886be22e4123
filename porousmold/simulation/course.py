"""The course of a run whose flow reverses, rests, or goes through phases: which phase it is in, and what that gives.

The heat is computed as if the fluid always came in at the inlet: where the flow turns, the state is mirrored instead
(`mesh.mirror`), which is the same in a straight bed whose ends are alike. `direction` tells which way that is.
"""

import math
from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ..scene.features.phases import Phase, has_phases, phases_of
from ..scene.scene import Scene
from ..scene.series import TimeSeries
from ..solvers.state import SavedNumbers

NEAR_LIMIT = 1e-3
"""Part of all temperature differences within which the outlet has reached the limit of a phase."""
LEAST_PART = 0.05
"""Of a step, to which it is cut at least where a phase ends within it."""


@dataclass(frozen=True)
class Followed(TimeSeries):
    """A series whose present course only the run knows: `values` are all that it can have, `read(time)` gives that of a time."""

    read: Callable[[float], float] | None = None

    def __call__(self, time: float) -> Any:
        assert self.read is not None
        return self.read(time)


def followed(series: Sequence[TimeSeries], read: Callable[[float], float]) -> Followed:
    """What may have the magnitudes of some series, of which the last one's count most."""
    values = tuple(abs(value) for one in series for value in one.values)
    corners = tuple(sorted({instant for one in series for instant in one.breakpoints}))
    return Followed(tuple(float(number) for number in range(len(values))), values, corners=corners, read=read)


class Course:
    """The phases of a run, gone through `cycles` times; `ends` are the times (s) at which those so far have ended, `heats` the
    heat (J) that the fluid had given until then. It `waits_for_heat` where the same fluid comes from both ends; else it goes on
    to its end, and has no heating time. A phase waits for a temperature for the `longest_wait` (s) at most."""

    def __init__(
        self,
        phases: Sequence[Phase],
        cycles: int,
        tolerance: float | None,
        *,
        repeats: bool,
        waits_for_heat: bool = False,
        longest_wait: float = math.inf,
    ) -> None:
        self.longest_wait = longest_wait
        self.phases, self.cycles, self.tolerance = tuple(phases), cycles, tolerance
        self.repeats, self.waits_for_heat = repeats, waits_for_heat
        self.ends: list[float] = []
        self.heats: list[float] = []

    @classmethod
    def of(cls, scene: Scene) -> "Course | None":
        """That of a scene; None where the flow keeps its direction and has no phases."""
        phases = phases_of(scene)
        if not phases:
            return None
        operation = scene.operation
        waits = operation.reversal_period is not None
        return cls(
            phases,
            operation.cycles,
            operation.cycle_tolerance,
            repeats=has_phases(scene),
            waits_for_heat=waits,
            longest_wait=math.inf if scene.is_given("operation.end_time") else operation.end_time,
        )

    def _at(self, time: float) -> Phase:
        """The phase of a time (s); at the end of a phase that phase."""
        return self.phase_of(self.phase_number(time))

    def phase_number(self, time: float) -> int:
        """Number of the phase of a time (s), counted through all cycles from 0; at the end of a phase that phase's."""
        return bisect_left(self.ends, time)

    def phase_of(self, number: int) -> Phase:
        """The phase of a number, counted through all cycles from 0."""
        return self.phases[number % len(self.phases)]

    @property
    def number(self) -> int:
        """Of the present phase, counted through all cycles from 0."""
        return len(self.ends)

    @property
    def phase(self) -> Phase:
        """The present one."""
        return self.phase_of(self.number)

    @property
    def begun(self) -> float:
        """When (s) the present phase began."""
        return self.ends[-1] if self.ends else 0.0

    def drive(self, time: float) -> float:
        """Magnitude of what drives the flow at a time (s)."""
        return float(self._at(time).drive(time))

    def temperature(self, time: float) -> float:
        """Of the fluid that enters at a time (s), K."""
        return float(self._at(time).temperature(time))

    def direction_of(self, number: int) -> int:
        """1 where the fluid comes in at the inlet in the phase of a number, -1 where at the outlet; of a rest that before it."""
        signs = (self.phase_of(before).sign for before in range(number, -1, -1))
        return next((sign for sign in signs if sign), 1)

    def direction(self, time: float) -> int:
        """The same of a time (s)."""
        return self.direction_of(self.phase_number(time))

    @property
    def planned_end(self) -> float:
        """When (s) the present phase ends at the latest."""
        return self.begun + self.phase.duration

    def is_past(self, time: float, outlet: float, differences: float) -> bool:
        """Whether the present phase ends at a time (s), with a temperature of what leaves (K)."""
        phase = self.phase
        if time >= self.planned_end * (1.0 - 1e-12):
            return True
        return phase.side is not None and self._beyond(outlet) >= -NEAR_LIMIT * differences

    def part_of_step(self, before: float | None, outlet: float, differences: float) -> float:
        """Part of a step that leads to the limit of the present phase, from what left `before` (K; None where that is not known)
        to what does now; 1 where the step does not lead beyond."""
        beyond = self._beyond(outlet) if self.phase.side is not None else -math.inf
        if beyond <= NEAR_LIMIT * differences:
            return 1.0
        room = 0.0 if before is None else -self._beyond(before)
        if room <= NEAR_LIMIT * differences:
            return 1.0
        return max(LEAST_PART, room / (room + beyond))

    def _beyond(self, outlet: float) -> float:
        """How far (K) what leaves is beyond the limit of the present phase."""
        difference = outlet - self.phase.limit
        return difference if self.phase.side == "above" else -difference

    def end_phase(self, time: float, heat: float) -> None:
        """The present phase ends at a time (s), `heat` (J) given by the fluid so far."""
        self.ends.append(time)
        self.heats.append(heat)

    @property
    def last_cycle(self) -> float | None:
        """How long (s) as many phases as a cycle has took last; None before there were so many."""
        ends, count = [0.0, *self.ends], len(self.phases)
        return ends[-1] - ends[-1 - count] if len(ends) > count else None

    @property
    def is_periodic(self) -> bool:
        """Whether the last cycle gave every phase the heat of the one before, within the tolerance."""
        count = len(self.phases)
        if self.tolerance is None or len(self.ends) % count or len(self.ends) < 2 * count:
            return False
        heats = [after - before for before, after in zip([0.0, *self.heats], self.heats, strict=False)]
        last, earlier = heats[-count:], heats[-2 * count : -count]
        scale = max(abs(heat) for heat in last)
        return all(abs(new - old) <= self.tolerance * scale for new, old in zip(last, earlier, strict=True))

    @property
    def is_over(self) -> bool:
        """Whether all cycles are gone through, or the state is periodic; never of a series, which goes on."""
        return self.repeats and (self.number >= self.cycles * len(self.phases) or self.is_periodic)

    def has_waited(self, time: float) -> bool:
        """Whether the present phase has waited for a temperature as long as it may, at a time (s)."""
        return self.repeats and self.phase.side is not None and time - self.begun >= self.longest_wait

    @property
    def longest(self) -> float:
        """Time (s) that all cycles take at most; infinite where that is not known."""
        return self.cycles * sum(phase.duration for phase in self.phases)

    def save(self) -> SavedNumbers:
        """What a restart needs."""
        return {"ends": self.ends, "heats": self.heats}

    def restore(self, numbers: SavedNumbers) -> None:
        """Go on from what `save()` gave."""
        self.ends, self.heats = list(numbers["ends"]), list(numbers["heats"])
