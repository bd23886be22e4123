r"""Steps in time of any system of UFL forms: L-stable SDIRK methods.

Three stages, third order, L-stable and stiffly accurate (Alexander, SIAM J. Numer. Anal. 14 (1977) 1006-1021). With S(U) what is
stored and A(U) what leaves (vectors against the tests), stage i solves

    [S(U_i) - S(U_n)]/(gamma dt) + A(U_i) + sum_{j<i} a_ij/gamma A(U_j) = 0,   U_{n+1} = U_3.

All stages have the same matrix; it is factorised once a step, and Newton's method iterates the residual to convergence on these
factors. Because S is what is stored itself, the discrete balance closes to the tolerance of that iteration.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeAlias

from dolfinx import fem
from petsc4py import PETSc

from ..mesh.aliases import Constant
from .newton import NewtonSystem
from .protocols import StageUpdate
from .stages import StageSolver

GAMMA = 0.43586652150845899942
"""Root of gamma^3 - 3 gamma^2 + 3/2 gamma - 1/6 = 0 between 0 and 1/2."""
LAST_ROW = (-(6 * GAMMA**2 - 16 * GAMMA + 1) / 4, (6 * GAMMA**2 - 20 * GAMMA + 5) / 4, GAMMA)
Stages: TypeAlias = tuple[tuple[float, ...], ...]
"""Rows of the coefficients a_ij of a method."""
STAGES: Stages = ((GAMMA,), ((1 - GAMMA) / 2, GAMMA), LAST_ROW)
BACKWARD_EULER: Stages = ((1.0,),)


class ErrorWeights(NamedTuple):
    """The error of a step is dt times `of_start` A(U_n) and `of_stages` A(U_i), up to sign; it is of an `order` in dt."""

    order: int
    of_start: float
    of_stages: Sequence[float]


EMBEDDED = ErrorWeights(3, 0.0, (GAMMA, -2.0 * GAMMA, GAMMA))
"""Difference of the last stage from an embedded method of second order."""
TRAPEZOIDAL = ErrorWeights(2, -0.5, (0.5,))
"""Difference of the backward Euler method from the trapezoidal rule."""


class Sdirk:
    """Integrates the unknown of a `system`, whose residual is `inverse_stage` S(U) + A(U) with 1/(gamma dt) in that constant.

    `stored(vector)` assembles S(U) of the present; `solver` solves a stage; `set_time(t)` is called before each stage to update
    what is given, `renew()` at the start of a step to take its coefficients; `updates()` gives what is updated beside it.
    """

    def __init__(
        self,
        system: NewtonSystem,
        stored: Callable[[PETSc.Vec], None],
        inverse_stage: Constant,
        solver: StageSolver,
        set_time: Callable[[float], None],
        renew: Callable[[], None] = lambda: None,
        updates: Callable[[], Sequence[StageUpdate]] = tuple,
    ) -> None:
        self._system, self._stored, self._inverse_stage, self._solver = system, stored, inverse_stage, solver
        self._set_time, self._renew, self._updates = set_time, renew, updates
        self._start = fem.Function(system.space)
        vectors = (system.new_vector() for _ in range(4))
        self._stored_start, self.stored_now, self._addend, self._difference = vectors
        self._outflows = [system.new_vector() for _ in STAGES]
        self._outflow_before = system.new_vector()

    def note_start(self) -> None:
        """Take the present unknown for that of a step's start."""
        self._start.x.array[:] = self._system.unknown.x.array
        self._stored(self._stored_start)

    def gained(self) -> float:
        """What is stored now beyond that at the start (collective)."""
        self._stored(self.stored_now)
        return float(self.stored_now.sum() - self._stored_start.sum())

    def take(self, time: float, step: float, stages: Stages, passed: Callable[[float], None]) -> float:
        """All stages of a step (s) from a time (s); gives what is stored more. `passed(weight)` is called after each of them: its
        weight (s) times what then flows, added up, is what has flowed. Raises `SolveError`."""
        system, values, gamma = self._system, self._system.unknown.x.array, stages[0][0]
        self._inverse_stage.value = 1.0 / (gamma * step)
        for part in self._updates():
            part.begin_step(step, gamma)
        self._renew()
        system.renew_jacobian()
        self.note_start()
        if stages is BACKWARD_EULER:
            self._note_outflow_before()
        for stage, row in enumerate(stages):
            self._set_time(time + sum(row) * step)
            for part in self._updates():
                part.begin_stage([weight * step for weight in row[:-1]])
            self._stored_start.copy(self._addend)
            self._addend.scale(-self._inverse_stage.value)
            for weight, outflow in zip(row[:-1], self._outflows, strict=False):
                self._addend.axpy(weight / gamma, outflow)
            if stage > 0:  # first guess: the last stage's slope from the start goes on
                values[:] = self._start.x.array + (values - self._start.x.array) * sum(row) / sum(stages[stage - 1])
            self._solver.solve(time, step, self._addend)
            for part in self._updates():
                part.end_stage()
            self._stored(self.stored_now)
            # A(U_i) from the stage's own equation
            self.stored_now.copy(self._outflows[stage])
            self._outflows[stage].scale(-self._inverse_stage.value)
            self._outflows[stage].axpy(-1.0, self._addend)
            passed(step * stages[-1][stage])
        return float(self.stored_now.sum() - self._stored_start.sum())

    def _note_outflow_before(self) -> None:
        """A(U) of the start of a step, by the present coefficients and boundary values."""
        self._system.addend = None
        self._system.assemble_residual_into(self._outflow_before)
        self._outflow_before.axpy(-self._inverse_stage.value, self._stored_start)

    def difference(self, stages: Stages) -> tuple[PETSc.Vec, ErrorWeights]:
        """Residual that the error of the step that was taken last leaves: the system's inverse makes the error of it."""
        weights = TRAPEZOIDAL if stages is BACKWARD_EULER else EMBEDDED
        self._difference.set(0.0)
        if weights.of_start:
            self._difference.axpy(-weights.of_start / stages[0][0], self._outflow_before)
        for weight, outflow in zip(weights.of_stages, self._outflows, strict=False):
            self._difference.axpy(-weight / stages[0][0], outflow)
        return self._difference, weights
