"""Solution of a steady nonlinear system from an initial guess: Newton's method and a false transient.

The false transient takes one Newton iteration for each implicit step; the first step is a fraction of the time in which the
flow passes a bead, later ones grow as the updates fall, until they are infinite and the steady equations themselves are solved.
"""

import logging
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from dolfinx import fem

from ..arrays import Floats
from ..mesh import fenicsx
from .newton import NewtonSystem
from .newton_iterations import Iterations
from .parts import TRACE_OF_TURBULENCE, PartSizes, Unknowns
from .protocols import FlowCounts, Observer, silent
from .state import Arrays, State

LOG = logging.getLogger(__name__)

CONVERGED_UPDATE = 1e-8
"""Relative update of the scaled unknown at which the flow counts as converged."""
CONVERGED_PARTS = 1e-5
"""The same of velocity and each unknown of the turbulence, on its own."""

KEPT_UPDATE, KEPT_CONTRACTION = 1e-2, 0.1
"""Update of the steady equations, and ratio to the one before, below which the next iteration is taken on the same factors."""

FIRST_PSEUDO_STEP = 0.05
LONG_PSEUDO_STEP, INFINITE_PSEUDO_STEP = 10.0, 1e7
LEAST_PSEUDO_STEP = 1e-9
"""Pseudo-time steps, in transit times of one bead at the reference speed: the first one, that beyond which small updates tell
that the solution is near, that beyond which the steady equations themselves are solved, and that below which no solution is
expected."""

LEAST_FACTOR = 0.7
"""By which a pseudo-time step that is taken becomes smaller at most."""
LARGEST_UPDATE, FAILED_STEP_FACTOR = 1.0, 0.125
"""Update beyond which the state is not taken, and the factor of the pseudo-time step then: of 400 profile tables drawn at random
11 were not found when updates of 1.5 were taken, 1 with 1. That one is found by going back from an infinite step."""
MOST_NEWTON_ITERATIONS, HALF_OF_THEM, SMALL_AFTER_HALF = 16, 8, 0.7
"""Iterations of Newton's method, and those after which the update of every part must be below the third."""
LEAST_REMAINDER = 0.1
"""Part of the turbulence that a pseudo-time step, and one of turbulence that dies out, leaves at least."""

LARGEST_UNDERSHOOT = 0.2
"""Of the largest k: negative k in single cells, behind an inlet say, counts as none in all that follows from it."""


class Pace(NamedTuple):
    """Of a false transient: relative update of the part that changes most at which the pseudo-time step stays as it is, and what
    it grows by at most; it changes by the ratio of the two updates (switched evolution relaxation: Mulder, van Leer, J. Comput.
    Phys. 59 (1985) 232-246). `most_steps` are those after which another start is tried, and `first_update` that from which on the
    first step tells that the flow is far."""

    wanted_update: float
    most_growth: float
    most_steps: int
    first_update: float = np.inf


FAST, CAREFUL = Pace(0.7, 1e4, 150), Pace(0.2, 4.0, 30, first_update=0.2)
"""From a guess that is far, and from a flow that is near: where turbulence begins in one cell after another a step in which k
doubles leads away (a pipe of 60 mm with beads of 6 mm: 9 of 12 such transients were given up, none of 2 careful ones)."""


def _keeps(update: float, last: float) -> bool:
    """Whether updates of the steady equations fall so fast that the factors serve once more."""
    return update < min(KEPT_UPDATE, KEPT_CONTRACTION * last)


class SteadySolver:
    """Brings the scaled `unknown` of a `system` to its solution.

    `solution` is all that an iteration changes, to restore after a failure; `previous` and `inverse_step` (1/s) are the
    false transient's last step in the system's residual; `transit()` gives the time (s) in which the flow passes a bead.
    `observe(text)` is called after every iteration, and may raise.
    """

    def __init__(
        self,
        system: NewtonSystem,
        unknowns: Unknowns,
        solution: State,
        previous: fem.Function,
        inverse_step: fem.Constant,
        transit: Callable[[], float],
    ) -> None:
        self.system, self.unknowns, self.solution = system, unknowns, solution
        self._previous, self._inverse_step, self._transit = previous, inverse_step, transit
        self._unknown = system.unknown
        self._of_turbulence = unknowns.of_turbulence
        self.sizes = PartSizes(self._unknown, unknowns, system.owned_size)
        self.counts = FlowCounts()
        self.update = np.inf
        self.observe: Observer = silent

    def find(self, step: float, time: float, near: float = 0.0, pace: Pace = FAST) -> bool:
        """Iterate from the present state until the steady equations are solved; tells whether they are.

        `step` is the first of the false transient in bead transits; inf is Newton's method alone. An update of every part below
        `near` is enough, too: for what only another flow starts from.
        """
        try:
            if np.isinf(step):
                return self.counts.note("newton", found=self._newton(time, near))
            name = "false transient" if pace is FAST else "careful false transient"
            return self.counts.note(name, found=self._false_transient(step, time, near, pace))
        finally:
            self._inverse_step.value = 0.0

    def _newton(self, time: float, near: float) -> bool:
        """Newton's method from the present state; see `find`."""
        before, parts = self._previous.x.array, [np.inf, np.inf]

        def prepare(update: float, last: float) -> None:
            before[:] = self._unknown.x.array
            if not _keeps(*parts):
                self.system.renew_jacobian()

        def converged(update: float) -> bool:
            self.count(update)
            parts[:] = self._largest_update(before), parts[0]
            self._tell(time, np.inf, parts[0])
            return self._converged(parts[0]) or (parts[0] < near and self.is_physical())

        iterations = Iterations(
            MOST_NEWTON_ITERATIONS,
            converged,
            prepare,
            gives_up=lambda update, last: (
                not parts[0] < (np.inf if iterations.taken < HALF_OF_THEM else SMALL_AFTER_HALF)
            ),
        )
        return self.system.solve(iterations)

    def _false_transient(self, step: float, time: float, near: float, pace: Pace) -> bool:
        """A false transient from the present state; see `find`."""
        update = last_update = np.inf
        for taken in range(pace.most_steps):
            before = self.solution.arrays()
            infinite = step > INFINITE_PSEUDO_STEP
            keeps = infinite and _keeps(update, last_update)
            last_update = update
            update = self._pseudo_step(np.inf if infinite else step * self._transit(), keeps_jacobian=keeps)
            self._tell(time, step, update)
            if infinite and self._converged(update):
                return True
            if step > LONG_PSEUDO_STEP and update < near and self.is_physical():
                return True
            if step < LEAST_PSEUDO_STEP or (taken == 0 and update > pace.first_update):
                break
            is_taken = update < LARGEST_UPDATE
            if not is_taken:
                self.solution.set(before)
            growth = float(np.clip(pace.wanted_update / max(update, 1e-300), LEAST_FACTOR, pace.most_growth))
            factor = growth if is_taken else FAILED_STEP_FACTOR
            if infinite and update > last_update:  # k goes to and fro about 0 where a flow beside it is turbulent
                step = LONG_PSEUDO_STEP
            elif factor < 1.0 or not infinite:
                step = min(step, INFINITE_PSEUDO_STEP) * factor
        return False

    def _tell(self, time: float, step: float, update: float) -> None:
        """Say how an iteration went, whose step (bead transits) and largest update of a part these are (collective)."""
        if LOG.isEnabledFor(logging.DEBUG):
            LOG.debug(
                "flow at %g s: iteration %d, step of %.1e bead transits, update %.1e, of a part %.1e; residuals %s",
                *(
                    time,
                    self.counts.newton_iterations,
                    step,
                    self.update,
                    update,
                    " ".join(f"{norm:.1e}" for norm in self._residual_norms()),
                ),
            )
        self.observe(f"flow: update {self.update:.0e}")

    def counted_iteration(self) -> float:
        """One iteration with the present factors, counted and observed; gives its relative update."""
        self.count(self.system.iterate())
        self.observe("")
        return self.update

    def count(self, update: float) -> None:
        """Note an iteration's update."""
        self.update = update
        self.counts.newton_iterations += 1

    def _pseudo_step(self, step: float, *, keeps_jacobian: bool) -> float:
        """One Newton iteration of an implicit step (s) of a false transient, or of the steady equations where it is infinite.

        Gives the relative update of the part that changes most, infinite where the iteration fails.
        """
        before = self._previous.x.array
        before[:] = self._unknown.x.array
        self._inverse_step.value = 1.0 / step
        if not keeps_jacobian:
            self.system.renew_jacobian()
        self.count(self.system.iterate())
        if np.isfinite(step):
            self.counts.continuation_steps += 1
        # where it dies out k would go to and fro between small values of either sign, without end
        if np.isfinite(self.update) and (np.isfinite(step) or not self.is_turbulent()):
            numbers = self._of_turbulence
            old, now = before[numbers], self._unknown.x.array[numbers]
            self._unknown.x.array[numbers] = np.where(old > 0.0, np.maximum(now, LEAST_REMAINDER * old), now)
        return self._largest_update(before)

    def _largest_update(self, before: Floats) -> float:
        """Relative update since the array `before` of the part that changes most, infinite where the iteration failed."""
        return self.sizes.largest_update(before) if np.isfinite(self.update) else np.inf

    def _residual_norms(self) -> list[float]:
        """Of the parts after the last iteration (collective)."""
        residual = fem.Function(self._unknown.function_space)
        self.system.vector.copy(fenicsx.petsc_vector(residual))
        return self.sizes.norms(residual.x.array)

    def _converged(self, update: float) -> bool:
        """Whether the steady equations are solved, from the last update of all and that of the part that changes most.

        With no more than a trace of turbulence velocity and pressure count alone: towards k = 0 its equations are singular.
        """
        if self.unknowns.turbulence and not self.is_turbulent():
            motion = range(len(self.unknowns.motion))
            return self.sizes.updates(self._previous.x.array, motion)[0] < CONVERGED_UPDATE and self.is_physical()
        return self.update < CONVERGED_UPDATE and update < CONVERGED_PARTS and self.is_physical()

    def extrapolate(self, previous: Arrays, factor: float) -> None:
        """Extrapolate the solution `factor` times as far ahead as `previous` (its arrays) lies behind."""
        turbulence = self._unknown.x.array[self._of_turbulence].copy()
        for name, function in self.solution.functions.items():
            function.x.array[:] += factor * (function.x.array - previous[name])
        predicted = self._unknown.x.array[self._of_turbulence]
        self._unknown.x.array[self._of_turbulence] = np.maximum(predicted, 0.3 * turbulence)

    def scale_turbulence(self, factor: float) -> None:
        """Multiply all turbulence by a factor."""
        self._unknown.x.array[self._of_turbulence] *= factor

    def is_turbulent(self) -> bool:
        """Whether k is more than negligible anywhere (collective)."""
        return self.sizes.range_of_kinetic_energy[1] > TRACE_OF_TURBULENCE

    def is_physical(self) -> bool:
        """No NaN, and k no further below zero than a part of its largest value, or a trace of the speed squared where there is
        no turbulence. `counts.largest_undershoot` notes the largest part that has passed."""
        if not self._of_turbulence.size:
            return True
        low, high = self.sizes.range_of_kinetic_energy
        if low < -max(LARGEST_UNDERSHOOT * high, TRACE_OF_TURBULENCE):
            return False
        if high > TRACE_OF_TURBULENCE:
            self.counts.largest_undershoot = max(self.counts.largest_undershoot, -low / high)
        return bool(np.isfinite(low))
