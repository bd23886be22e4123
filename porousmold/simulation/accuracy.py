"""Accuracy on request: the mesh and the steps that bring the heating time within a wanted relative error.

The error of a run is estimated from two cheaper ones with half as many cells in each direction, one with its own steps
and one with half as many of those as well: with t(m, s) the heating time at mesh and step refinements m and s,

    error = |t(m, s) - t(m/2, s)| / (2^p - 1) + |t(m/2, s) - t(m/2, s/2)| / (2^q - 1),

which is Richardson's estimate for each. The methods are of order 2 in the mesh and of 2 to 3 in the step; the orders taken
here, p = 1.2 and q = 1.5, are lower, because limiters and coarse wall layers cost some. The error is that of the
discretisation, not of the model.
"""

import math
from collections.abc import Callable

from ..errors import SolveError
from ..scene.scene import Scene

MESH_ORDER, STEP_ORDER = 1.2, 1.5
FINEST = 8.0
"""Largest refinement that is tried."""
FINER = 1.5
"""Factor on the cells in each direction where a solve has failed."""
COARSEST_OF_ALL = 2.0
"""Refinement from which on a failed solve is the scene's own failure."""


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
    wanted, refinement = scene.solver.accuracy, first_refinement(scene.solver.accuracy)
    while True:
        try:
            coarse, coarse_mesh, fine = (
                march(_refined(scene, refinement * mesh, refinement * steps))
                for mesh, steps in ((0.5, 0.5), (0.5, 1.0), (1.0, 1.0))
            )
        except SolveError:  # coarse cells may have no steady flow
            if refinement >= COARSEST_OF_ALL:
                raise
            refinement *= 2.0
            continue
        if coarse is None or coarse_mesh is None or fine is None:
            return None
        error = estimated_error(coarse, coarse_mesh, fine)
        if error <= wanted or refinement >= FINEST:
            return error
        refinement = min(FINEST, refinement * max(math.sqrt(2.0), (error / wanted) ** 0.5))


def _refined(scene: Scene, mesh: float, steps: float) -> Scene:
    return scene.changed({"solver.accuracy": None, "solver.mesh_refinement": mesh, "solver.step_refinement": steps})


def first_refinement(accuracy: float) -> float:
    """Refinement to start from: 1, the default mesh and steps, is good for 0.3 %."""
    return max(1.0, min(FINEST, math.sqrt(0.003 / accuracy)))


def estimated_error(coarse: float, coarse_mesh: float, fine: float) -> float:
    """Relative error of the heating time `fine` (s) beside those of half the cells and steps, and half the cells."""
    mesh = abs(fine - coarse_mesh) / (2.0**MESH_ORDER - 1.0)
    steps = abs(coarse_mesh - coarse) / (2.0**STEP_ORDER - 1.0)
    return (mesh + steps) / fine
