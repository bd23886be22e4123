"""Accuracy on request: the mesh and the steps that bring the heating time within a wanted relative error.

The error of a run is estimated from two cheaper ones with half as many cells in each direction, one with its own steps
and one with half as many of those as well: with t(m, s) the heating time at mesh and step refinements m and s,

    error = |t(m, s) - t(m/2, s)| / (2^p - 1) + |t(m/2, s) - t(m/2, s/2)| / (2^q - 1),

which is Richardson's estimate for each. The methods are of order 2 in the mesh and of 2 to 3 in the step; the orders taken
here, p = 1.2 and q = 1.5, are lower, because limiters and coarse wall layers cost some. The error is that of the
discretisation, not of the model.
"""

import math

from .errors import SolveError

MESH_ORDER, STEP_ORDER = 1.2, 1.5
FINEST = 8.0
"""Largest refinement that is tried."""
FINER = 1.5
"""Factor on the cells in each direction where a solve has failed."""
COARSEST_OF_ALL = 2.0
"""Refinement from which on a failed solve is the scene's own failure."""


def scenes_to_run(scene):
    """Generator of the scenes to march one after the other; send it the heating time (s, or None) of each.

    Where it failed, throw the `SolveError` in. The last one is the answer, and the generator's value its estimated relative
    error: without `solver.accuracy` the scene itself, or if that fails on finer cells, and None, also None where the wall was
    not heated.
    """
    if scene.solver.accuracy is None:
        try:
            yield scene
        except SolveError:
            if scene.geometry.kind == "mesh":
                raise
            yield scene.with_changes(solver__mesh_refinement=FINER * scene.solver.mesh_refinement)
        return None
    wanted, refinement = scene.solver.accuracy, first_refinement(scene.solver.accuracy)
    while True:
        times = []
        try:
            for mesh, steps in ((0.5, 0.5), (0.5, 1.0), (1.0, 1.0)):
                changes = {
                    "solver__mesh_refinement": refinement * mesh,
                    "solver__step_refinement": refinement * steps,
                }
                times.append((yield scene.with_changes(solver__accuracy=None, **changes)))
        except SolveError:  # coarse cells may have no steady flow
            if refinement >= COARSEST_OF_ALL:
                raise
            refinement *= 2.0
            continue
        if None in times:
            return None
        error = estimated_error(*times)
        if error <= wanted or refinement >= FINEST:
            return error
        refinement = min(FINEST, refinement * max(math.sqrt(2.0), (error / wanted) ** 0.5))


def first_refinement(accuracy):
    """Refinement to start from: 1, the default mesh and steps, is good for 0.3 %."""
    return max(1.0, min(FINEST, math.sqrt(0.003 / accuracy)))


def estimated_error(coarse, coarse_mesh, fine):
    """Relative error of the heating time `fine` (s) beside those of half the cells and steps, and half the cells."""
    mesh = abs(fine - coarse_mesh) / (2.0**MESH_ORDER - 1.0)
    steps = abs(coarse_mesh - coarse) / (2.0**STEP_ORDER - 1.0)
    return (mesh + steps) / fine
