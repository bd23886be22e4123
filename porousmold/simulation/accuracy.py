"""Accuracy on request: the mesh and the steps that bring the heating time within a wanted relative error.

With t(l, c, s) the heating time at refinements of the cells along the flow and across it and of the steps, the errors of a run
come from two cheaper ones with 0.7 of its cells in each direction, one with its own steps and one with half of those as well
(Richardson):

    e_m = [t(0.7 l, 0.7 c, s) - t(l, c, s)] / (0.7^-p - 1),
    e_s = [t(0.7 l, 0.7 c, s/2) - t(0.7 l, 0.7 c, s)] / (2^3 - 1),

both with their signs, as they may cancel; the estimate is |e_m + e_s|, and half of sqrt(e_m^2 + e_s^2) at least. The steps are of
third order. Meshes converge faster than with their order 2, because the layer at the wall is only beginning to be resolved:
p = 2.5 is what random scenes show (docs/accuracy.md has others).

If the estimate exceeds the target, one more run, with t(0.7 l, c, s), parts e_m by its direction: e_l = [t(0.7 l, c, s) -
t(l, c, s)] / (0.7^-p - 1) is of the cells along, e_c = e_m - e_l of those across. A finer run follows, with cells along, cells
across and steps each refined as required at order 2. Its error estimate is e_l, e_c and e_s scaled at that order, or the estimate
from its difference to the previous run, whichever is larger. This is the discretisation error, not the model error.
"""

import contextlib
import math
from collections.abc import Callable
from typing import NamedTuple

from ..errors import SolveError
from ..scene.scene import Scene

OBSERVED_ORDER, ORDER, STEPS_ORDER = 2.5, 2.0, 3.0
"""Of convergence from coarse meshes, of the methods in space, and of those in time."""
COARSER = 0.7
"""Part of the cells in each direction of the runs that the errors are estimated from."""
COARSER_DIFFERENCE = COARSER**-OBSERVED_ORDER - 1.0
"""What a run of such cells is further off than one of all cells, in errors of that."""
FINEST = 8.0
"""Largest refinement that is tried."""
FINER = 1.5
"""Factor on the cells in each direction where a solve has failed."""
COARSEST_OF_ALL = 2.0
"""Refinement from which on a failed solve is the scene's own failure."""
MARGIN = 1.1
"""Factor on a refinement beyond what the estimate asks for."""


class Refinements(NamedTuple):
    """Factors on the cells along the flow and across it, and on the steps; or of one run over those of another."""

    along: float = 1.0
    across: float = 1.0
    steps: float = 1.0

    def times(self, along: float, across: float, steps: float) -> "Refinements":
        """These, times factors."""
        return Refinements(self.along * along, self.across * across, self.steps * steps)

    def of(self, scene: Scene) -> Scene:
        """The scene with these refinements."""
        return scene.changed(
            {
                "solver.accuracy": None,
                "solver.mesh_refinement": self.across,
                "solver.axial_refinement": self.along / self.across,
                "solver.step_refinement": self.steps,
            }
        )


class Errors(NamedTuple):
    """Relative errors of a heating time by its cells along and across the flow and by its steps, with their signs."""

    along: float
    across: float
    steps: float

    @property
    def all(self) -> float:
        """Of all together, where they cancel half of what those of mesh and steps are as independent ones at least."""
        mesh = self.along + self.across
        return max(abs(mesh + self.steps), 0.5 * math.hypot(mesh, self.steps))


def run_to_accuracy(scene: Scene, march: Callable[[Scene], float | None]) -> float | None:
    """March a scene as often as its `solver.accuracy` needs; gives the estimated relative error of the last march's answer.

    `march(scene)` gives a heating time (s; None where the wall was not heated) or raises `SolveError`. Without an accuracy that
    is the scene itself, or if that fails on finer cells, and no error is estimated: None, also where the wall was not heated.
    Raises `SolveError` where refinement does not help.
    """
    if scene.solver.accuracy is None:
        try:
            march(scene)
        except SolveError:
            if scene.geometry.kind == "mesh":
                raise
            march(scene.changed({"solver.mesh_refinement": FINER * scene.solver.mesh_refinement}))
        return None
    wanted, present = scene.solver.accuracy, Refinements()
    while True:
        coarser = present.times(COARSER, COARSER, 1.0)
        try:
            coarse, coarse_mesh, now = (
                march(refinements.of(scene)) for refinements in (coarser.times(1.0, 1.0, 0.5), coarser, present)
            )
        except SolveError:  # coarse cells may have no steady flow
            if present.across >= COARSEST_OF_ALL:
                raise
            present = present.times(2.0, 2.0, 1.0)
            continue
        break
    if coarse is None or coarse_mesh is None or now is None:
        return None
    by_mesh, by_steps = estimated_errors(coarse, coarse_mesh, now)
    errors = Errors(0.5 * by_mesh, 0.5 * by_mesh, by_steps)
    if errors.all > wanted:
        with contextlib.suppress(SolveError):  # then both directions count alike
            coarse_along = march(present.times(COARSER, 1.0, 1.0).of(scene))
            by_length = 0.0 if coarse_along is None else (coarse_along - now) / now / COARSER_DIFFERENCE
            errors = Errors(by_length, by_mesh - by_length, by_steps)
    while errors.all > wanted and max(present) < FINEST:
        finer = Refinements(
            *(min(FINEST, one * needed_factor(abs(error), wanted)) for one, error in zip(present, errors, strict=True))
        )
        before, now = now, march(finer.of(scene))
        if now is None:
            return None
        factors = Refinements(*(after / one for after, one in zip(finer, present, strict=True)))
        errors, present = errors_after(errors, factors, abs(now - before) / now), finer
    return errors.all


def estimated_errors(coarse: float, coarse_mesh: float, fine: float) -> tuple[float, float]:
    """Errors of the heating time `fine` (s) by its mesh and by its steps, from those of `COARSER` cells and half the steps and
    of such cells alone."""
    by_steps = (coarse - coarse_mesh) / (2.0**STEPS_ORDER - 1.0)
    return (coarse_mesh - fine) / fine / COARSER_DIFFERENCE, by_steps / fine


def needed_factor(error: float, wanted: float) -> float:
    """Factor on a refinement that brings its error down to a third of what is wanted in all, 1 at least."""
    return max(1.0, MARGIN * (3.0 * error / wanted) ** (1.0 / ORDER))


def errors_after(errors: Errors, factors: Refinements, difference: float) -> Errors:
    """Errors of a run refined by these factors, whose relative difference from the run before is known as well."""
    scaled = Errors(*(error / factor**ORDER for error, factor in zip(errors, factors, strict=True)))
    estimated = difference / (max(factors) ** OBSERVED_ORDER - 1.0)
    more = max(1.0, estimated / scaled.all) if scaled.all else 1.0
    return Errors(*(more * error for error in scaled))
