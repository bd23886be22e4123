"""Accuracy on request: the mesh and the steps that bring the heating time within a wanted relative error.

With t(m, s) the heating time at mesh and step refinements m and s, the errors of a run come from two cheaper ones with 0.7 of
its cells in each direction, one with its own steps and one with half of those as well (Richardson):

    e_m = [t(0.7 m, s) - t(m, s)] / (0.7^-p - 1),    e_s = [t(0.7 m, s/2) - t(0.7 m, s)] / (2^3 - 1),

both with their signs, as they may cancel; the estimate is |e_m + e_s|, and half of sqrt(e_m^2 + e_s^2) at least. The steps are of
third order. Meshes converge faster than with their order 2, because the layer at the wall is only beginning to be resolved:
p = 2.5 is what random scenes show (docs/accuracy.md has others). If the estimate exceeds the target, one finer run follows, with
mesh and steps each refined as required at order 2. Its error estimate is e_m and e_s scaled at that order, or the estimate from
its difference to the previous run, whichever is larger. This is the discretisation error, not the model error.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from ..errors import SolveError
from ..scene.scene import Scene

OBSERVED_ORDER, ORDER, STEPS_ORDER = 2.5, 2.0, 3.0
"""Of convergence from coarse meshes, of the methods in space, and of those in time."""
COARSER = 0.7
"""Part of the cells in each direction of the runs that the errors are estimated from."""
FINEST = 8.0
"""Largest refinement that is tried."""
FINER = 1.5
"""Factor on the cells in each direction where a solve has failed."""
COARSEST_OF_ALL = 2.0
"""Refinement from which on a failed solve is the scene's own failure."""
MARGIN = 1.1
"""Factor on a refinement beyond what the estimate asks for."""


class Errors(NamedTuple):
    """Relative errors of a heating time by its mesh and by its steps, with their signs."""

    mesh: float
    steps: float

    @property
    def both(self) -> float:
        """Of both together, where they cancel half of what they are as independent ones at least."""
        return max(abs(self.mesh + self.steps), 0.5 * math.hypot(self.mesh, self.steps))


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
    wanted, mesh, steps = scene.solver.accuracy, 1.0, 1.0
    while True:
        try:
            times = [
                march(_refined(scene, mesh * part_of_mesh, steps * part_of_steps))
                for part_of_mesh, part_of_steps in ((COARSER, 0.5), (COARSER, 1.0), (1.0, 1.0))
            ]
        except SolveError:  # coarse cells may have no steady flow
            if mesh >= COARSEST_OF_ALL:
                raise
            mesh *= 2.0
            continue
        break
    coarse, coarse_mesh, now = times
    if coarse is None or coarse_mesh is None or now is None:
        return None
    errors = estimated_errors(coarse, coarse_mesh, now)
    while errors.both > wanted and max(mesh, steps) < FINEST:
        finer_mesh, finer_steps = (
            min(FINEST, refinement * needed_factor(error, wanted))
            for refinement, error in ((mesh, abs(errors.mesh)), (steps, abs(errors.steps)))
        )
        before, now = now, march(_refined(scene, finer_mesh, finer_steps))
        if now is None:
            return None
        errors = errors_after(errors, finer_mesh / mesh, finer_steps / steps, abs(now - before) / now)
        mesh, steps = finer_mesh, finer_steps
    return errors.both


def _refined(scene: Scene, mesh: float, steps: float) -> Scene:
    return scene.changed({"solver.accuracy": None, "solver.mesh_refinement": mesh, "solver.step_refinement": steps})


def estimated_errors(coarse: float, coarse_mesh: float, fine: float) -> Errors:
    """Errors of the heating time `fine` (s) beside those of `COARSER` cells and half the steps, and of such cells alone."""
    by_mesh = (coarse_mesh - fine) / (COARSER**-OBSERVED_ORDER - 1.0)
    by_steps = (coarse - coarse_mesh) / (2.0**STEPS_ORDER - 1.0)
    return Errors(by_mesh / fine, by_steps / fine)


def needed_factor(error: float, wanted: float) -> float:
    """Factor on a refinement that brings its error down to half of what is wanted in all, 1 at least."""
    return max(1.0, MARGIN * (2.0 * error / wanted) ** (1.0 / ORDER))


def errors_after(errors: Errors, mesh_factor: float, steps_factor: float, difference: float) -> Errors:
    """Errors of a run refined by these factors, whose relative difference from the run before is known as well."""
    scaled = Errors(errors.mesh / mesh_factor**ORDER, errors.steps / steps_factor**ORDER)
    estimated = difference / (max(mesh_factor, steps_factor) ** OBSERVED_ORDER - 1.0)
    more = max(1.0, estimated / scaled.both) if scaled.both else 1.0
    return Errors(more * scaled.mesh, more * scaled.steps)
