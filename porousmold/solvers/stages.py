"""Solution of the stages of a heating step: Newton's method on one Jacobian a step, in turn with what is updated beside it."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from petsc4py import PETSc

from ..errors import SolveError
from .newton import NewtonSystem
from .newton_iterations import Contraction, Iterations
from .protocols import StageUpdate

STAGE_ERROR = 3e-7
"""Relative error at which a stage counts as solved, if not given otherwise: 1e-4 K."""
ITERATED_STAGE_ERROR = 1e-6
"""The same of linear systems that are iterated: 3e-4 K."""
ALTERNATING_STAGE_ERROR = 1e-9
"""The same where a `StageUpdate` depends on the temperatures."""
LINEAR_PART = 0.2
"""Of the stage's error, that iterated linear systems may leave."""
MOST_REDUCTION, LEAST_REDUCTION = 1e-3, 0.1
"""Of their residual: one Jacobian serves all of a step, and Newton's method gains little by more."""
SLOW = 0.3
"""Part of the last update, from which on the next one asks for a new Jacobian where a stage was not solved with one: of heat
capacities that change by a factor."""
SURE_AFTER = 4
"""Iterations after which their contraction says whether a stage is solved in time."""
MOST_ITERATIONS, MOST_DAMPED_ITERATIONS = 20, 60
"""Of a stage, with one Jacobian, and of one that is renewed and damped."""
TURNED_BACK = 0.5
"""Part of a value's last update, by which a damped one turns back at most."""


class StageSolver:
    """Solves stages of the temperatures' `system` to the relative `error`, with the `updates()` of the present beside it."""

    def __init__(self, system: NewtonSystem, updates: Callable[[], Sequence[StageUpdate]], error: float) -> None:
        self._system, self._updates, self._error = system, updates, error
        self.contraction = Contraction()
        self.iterations = 0
        self._is_damped, self._last_update = False, np.zeros(0)

    def solve(self, time: float, step: float, addend: PETSc.Vec) -> None:
        """Solve a stage of a step (s) from a time (s), with `addend` (PETSc vector) in its residual. Raises `SolveError`."""
        self._system.addend = addend
        guess = self._system.unknown.x.array.copy()
        if self._solve():
            return
        self._system.unknown.x.array[:] = guess
        self._system.renew_jacobian()
        if not self._solve(renewed_from=SLOW):
            raise SolveError(
                "energy (T_f, T_s, T_w)",
                time,
                f"step of {step:.3g} s, residual {self._system.residual_norm:.3e}, "
                f"last update {self._system.relative_update:.3e}",
                "a smaller solver.largest_step or solver.first_step",
            )

    def damp(self, update: Any) -> None:
        """Have no value turn back by more than a part of how far it last went, where an update (PETSc vector) is not the first:
        within a peak of the heat capacity Newton's method goes to and fro over it, and so halves the way."""
        if not self._is_damped:
            return
        values = update.array
        if len(self._last_update):
            most = TURNED_BACK * np.abs(self._last_update)
            turned = (values * self._last_update < 0.0) & (np.abs(values) > most)
            values[turned] = np.sign(values[turned]) * most[turned]
            update.array = values
        self._last_update = np.array(values)

    def renew_beside(self) -> None:
        """Have everything updated that goes with the present temperatures (collective)."""
        for part in self._updates():
            part.update()

    def _solve(self, renewed_from: float = np.inf) -> bool:
        """Whether it is found, with a Jacobian that is renewed where an update is `renewed_from` times the last one or more."""
        # what depends on the temperatures is updated by turns with them: that contracts otherwise than Newton's method
        alternating = any(part.depends_on_temperature for part in self._updates())
        tolerance = ALTERNATING_STAGE_ERROR if alternating else self._error

        def prepare(update: float, last: float) -> None:
            if last < np.inf and update > renewed_from * last:
                self._system.renew_jacobian()
            self._system.solve_to(self._reduction(tolerance, update))

        def is_hopeless(update: float, last: float) -> bool:
            left, ratio = MOST_ITERATIONS - iterations.taken, update / last
            return renewed_from == np.inf and iterations.taken >= SURE_AFTER and update * ratio**left > tolerance

        self._is_damped, self._last_update = renewed_from < np.inf, np.zeros(0)
        iterations = Iterations(
            MOST_DAMPED_ITERATIONS if self._is_damped else MOST_ITERATIONS,
            converged=lambda error: error < tolerance,
            prepare=prepare,
            gives_up=is_hopeless,
            contraction=Contraction() if alternating else self.contraction,
        )
        is_solved = self._system.solve(iterations)
        self.iterations += iterations.taken
        return is_solved

    def _reduction(self, tolerance: float, last: float) -> float:
        """What the next iteration needs of the linear residual: none beyond the stage's tolerance of what the last one left."""
        expected = last * min(self.contraction.ratio, 1.0)
        return float(np.clip(LINEAR_PART * tolerance / expected, MOST_REDUCTION, LEAST_REDUCTION))
