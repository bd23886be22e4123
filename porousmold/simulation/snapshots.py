"""Fields and profiles that are kept of an integration, to be written at its end."""

from typing import NamedTuple

import numpy as np

from ..arrays import Floats
from ..mesh.aliases import Space
from ..solvers.state import ArrayOf, Arrays, Saved, SavedNumbers
from .cycles import Profile
from .problem import Problem

LEAST_SNAPSHOTS = 32
"""That are kept during a run, for fields evenly spread over its time."""
SAME_TIME = 1e-9


SNAPSHOTS_A_FIELD = 4
"""Kept for each that is written, so that one stands near every time."""


class Snapshot(NamedTuple):
    """The arrays of the solution at a time (s), after so many steps."""

    time: float
    step: int
    solution: Arrays


class Snapshots:
    """`fields` has snapshots, spread over the integration; `profiles` the temperatures along the bed at the times
    asked for and at the ends of phases, the first cycle's and the last two's."""

    def __init__(self, problem: Problem) -> None:
        self._problem, self._output, self._course = problem, problem.specs.output, problem.specs.course
        self.fields: list[Snapshot] = []
        self.profiles: list[Profile] = []
        self._spacing = 0.0

    def keep(self, time: float, step: int) -> None:
        """Keep the fields of this time, after so many steps. At times that are asked for they stay, with a profile along the bed;
        beyond four times as many as are written every second of the others goes, and the spacing doubles (collective)."""
        if self._output.times:
            if any(abs(time - asked) <= SAME_TIME * time for asked in self._output.times):
                self._keep(time, step)
            return
        if self.fields and time < self.fields[-1].time + self._spacing:
            return
        self._keep(time, step)
        most = max(LEAST_SNAPSHOTS, SNAPSHOTS_A_FIELD * self._output.field_times)
        if len(self.fields) > most:
            self.fields = self.fields[::2]
            self._spacing = max(2.0 * self._spacing, time / most)

    def finish(self, time: float, step: int) -> None:
        """Keep the fields of the end, where they are not kept yet (collective)."""
        if not self.fields or self.fields[-1].step < step:
            self._keep(time, step)

    def _keep(self, time: float, step: int) -> None:
        self.fields.append(Snapshot(time, step, self._problem.solution.arrays()))
        if self._output.times:
            self._keep_profile(f"{time:.6g} s", time)

    def end_phase(self, number: int, time: float) -> None:
        """Keep the temperatures along the bed at the end (s) of a phase (collective)."""
        course = self._course
        assert course is not None
        count = len(course.phases)
        self._keep_profile(f"{1 + number // count} {course.phase_of(number).name}", time, number)
        latest = (number // count - 1) * count
        self.profiles = [
            one for one in self.profiles if one.number is None or one.number < count or one.number >= latest
        ]

    def _keep_profile(self, label: str, time: float, number: int | None = None) -> None:
        problem, two = self._problem, self._problem.specs.heat.model.two_temperatures
        parts = [problem.temperature, problem.bead_temperature if two else problem.temperature]
        if self._course is not None and self._course.direction(time) < 0:
            problem.mirror(*parts)
        fluid, beads = (problem.along_the_bed(part)[:, 0] for part in parts)
        self.profiles.append(Profile(label, time, fluid, beads, number))

    def save(self) -> Saved:
        """All of them."""
        arrays: dict[str, tuple[Space, Floats]] = {}
        for number, snapshot in enumerate(self.fields):
            arrays |= self._problem.solution.spaces_of(snapshot.solution, f"snapshot/{number}/")
        numbers = {
            "times": [snapshot.time for snapshot in self.fields],
            "steps": [snapshot.step for snapshot in self.fields],
            "spacing": self._spacing,
            "profiles": [
                [one.label, one.time, one.fluid.tolist(), one.beads.tolist(), one.number] for one in self.profiles
            ],
        }
        return Saved(numbers, arrays)

    def restore(self, numbers: SavedNumbers, array_of: ArrayOf) -> None:
        """Go on from what `save()` gave."""
        self._spacing = numbers["spacing"]
        self.profiles = [
            Profile(label, time, np.array(fluid), np.array(beads), number)
            for label, time, fluid, beads, number in numbers["profiles"]
        ]
        self.fields = [
            Snapshot(time, step, self._problem.solution.read(array_of, f"snapshot/{number}/"))
            for number, (time, step) in enumerate(zip(numbers["times"], numbers["steps"], strict=True))
        ]
