"""Steps that keep temperatures within bounds: cells around one that leaves them become monotone, and the step is repeated."""

import math
from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

from .heat_unknowns import HeatUnknowns
from .protocols import Bounds
from .sdirk import BACKWARD_EULER, STAGES, Stages
from .state import State
from .transport import MonotoneCells

DAMPING_PART = 0.05
"""Part of a repeated step that the backward Euler method takes first where marking cells alone did not help."""
MOST_REPETITIONS = 12
STEEPEST = 0.02
"""Part of all temperature differences, by which the temperature of a cell that is not monotone may change within it where beads
melt: fronts are then shocks, before which cells of second order find a wrong state within the bounds (with one temperature the
time was 13 % too short, and the heat balance closed)."""

Parts = Sequence[tuple[float, Stages]]
"""Successive parts (s) of a step, and the stages that each is taken by."""
Taken = TypeVar("Taken")


class BoundedSteps:
    """Repeats steps of the temperatures `unknowns` whose `cells` leave their bounds; `repetitions` counts them. Beads melt
    between two temperatures (K), `melting`; None where they do not."""

    def __init__(
        self, cells: MonotoneCells, unknowns: HeatUnknowns, melting: tuple[float, float] | None = None
    ) -> None:
        self._steepest = STEEPEST * (melting[1] - melting[0]) if melting else math.inf
        self._fields = len(unknowns.fields)
        self.cells, self.repetitions = cells, 0
        self._unknown, self._constrained = unknowns.function, unknowns.constrained

    def release(self) -> None:
        """Begin a step: cells that have been monotone for a while are so no longer; steep ones are where beads melt."""
        self.cells.release()
        if self._steepest < math.inf:
            self.cells.mark_steep(self._unknown.x.array, self._fields, self._steepest)

    def mark(self, bounds: Bounds) -> tuple[float, bool]:
        """Make cells out of `bounds` (K) monotone: by how much (K) they are at most, and whether there are new ones
        (collective)."""
        values = self._unknown.x.array.copy()
        values[self._constrained] = np.nan
        return self.cells.mark(values, bounds)

    def take(
        self,
        step: float,
        take_all: Callable[[Parts], Taken],
        bounds: Callable[[], Bounds],
        solution: State,
        restored: Callable[[], None],
    ) -> Taken:
        """A step of `step` seconds, whose parts `take_all` takes from `solution`; gives what the best of its repetitions gave.

        Where marking cells does not help: a step that is long beside the fluid's time constants lets what jumps swing, which the
        backward Euler method damps; and no method of higher order keeps bounds at any step. `restored` is called when the
        solution is not that of the last repetition.
        """
        self.release()
        damped, rest = (DAMPING_PART * step, BACKWARD_EULER), (1.0 - DAMPING_PART) * step
        ways: list[Parts] = [[(step, STAGES)], [damped, (rest, STAGES)], [damped, (rest, BACKWARD_EULER)]]
        way, last, least, starts = 0, math.inf, math.inf, solution.arrays()
        for left in reversed(range(MOST_REPETITIONS)):
            taken = take_all(ways[way])
            excess, new = self.mark(bounds())
            if excess < least:
                least, best = excess, taken
                ends = solution.arrays() if excess else starts  # nothing follows where there is none
            way += not (new and excess < last)
            if not excess or way == len(ways) or not left:
                break
            last = excess
            self.repetitions += 1
            solution.set(starts)
        if excess > least:  # more marked cells may make it worse
            solution.set(ends)
            restored()
        return best
