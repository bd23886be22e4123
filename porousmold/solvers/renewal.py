"""Solution of a steady nonlinear system anew after a small change of what it depends on: Newton's method with a reused Jacobian.

The factors of the Jacobian serve from change to change, while updates with them fall fast; else the Jacobian is renewed.
"""

import numpy as np

from .newton_iterations import Contraction, Iterations
from .steady import SteadySolver

KEPT_TOLERANCE = 0.005
"""Part of the tolerance that the error left by a reused Jacobian may be: its contraction is an estimate."""
LOOSER_TURBULENCE = 20.0
"""Factor on that error for the turbulence: the heat feels it through the eddies alone, while an error of the mass flow is one of
the heat."""
SLOWEST_CONTRACTION = 0.7
"""Ratio of successive updates beyond which a reused Jacobian is given up."""
LARGEST_KEPT_UPDATE = 0.1
"""Update by a new Jacobian after which its factors are tried again."""
LOOSER_PARTS = 5.0
"""Times the tolerance that the update of every part (k, epsilon, ...) may have on its own."""
FRESH_ITERATIONS = 8
"""Iterations with a new Jacobian each before the flow is solved from its start; where turbulence sets in or dies k may pass
through negative values on the way."""


class Renewal:
    """Brings what a `solver` has found to the present temperatures, say, by at most `kept_iterations` on the same factors."""

    def __init__(self, solver: SteadySolver, kept_iterations: int) -> None:
        self._solver, self._kept_iterations = solver, kept_iterations

    def find(self, tolerance: float) -> bool:
        """Newton iterations from the present state until the update is below `tolerance`; tells whether they got there.

        By a new Jacobian that of the velocity at every node, too: what is left in a few of them, and extrapolated from step to
        step, grows there, as saw teeth across the flow, until no iteration finds back. A failure puts the state back.
        """
        solver = self._solver
        start, unknown = solver.solution.arrays(), solver.system.unknown
        if self._find_on_kept_factors(tolerance):
            return solver.counts.note("reused Jacobian", found=True)
        for _ in range(FRESH_ITERATIONS):
            before = unknown.x.array.copy()
            solver.system.renew_jacobian()
            update = solver.counted_iteration()
            if not np.isfinite(update):
                break
            update = max(update, solver.sizes.updates(before)[1] / LOOSER_PARTS)
            is_near = max(update, solver.sizes.largest_local_update(before)) < tolerance
            is_found = is_near and solver.is_physical()
            if is_found or (update < LARGEST_KEPT_UPDATE and self._find_on_kept_factors(tolerance)):
                return solver.counts.note("renewed Jacobian", found=True)
        solver.solution.set(start)
        return solver.counts.note("renewed Jacobian", found=False)

    def _find_on_kept_factors(self, tolerance: float) -> bool:
        """The same on the present factors alone, whose error is what their contraction tells; where that is slow the state is put
        back."""
        solver = self._solver
        start, unknown, unknowns = solver.solution.arrays(), solver.system.unknown, solver.unknowns

        def gives_up(update: float, last: float) -> bool:
            if update < SLOWEST_CONTRACTION * last:
                return False
            solver.solution.set(start)
            return True

        before = np.empty(0)

        def prepare(update: float, last: float) -> None:
            nonlocal before
            before = unknown.x.array.copy()

        def size_of(update: float) -> float:
            """Update of velocity and pressure, or what counts of all if that is more."""
            if not unknowns.turbulence or not np.isfinite(update):
                return update
            motion = range(len(unknowns.motion))
            return max(solver.sizes.updates(before, motion)[0], update / LOOSER_TURBULENCE)

        def converged(error: float) -> bool:
            solver.count(solver.system.relative_update)
            solver.observe("")
            return error < KEPT_TOLERANCE * tolerance and solver.is_physical()

        iterations = Iterations(self._kept_iterations, converged, prepare, gives_up, Contraction(), size_of)
        return solver.system.solve(iterations)
