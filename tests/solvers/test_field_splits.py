"""Iterative solution of large systems: the same iterate as by factors of the whole."""

import numpy as np
import pytest
from mpi4py import MPI

from porousmold.scene.scene import Scene
from porousmold.simulation.march import Simulation
from porousmold.simulation.specs import specs_of
from porousmold.solvers import newton
from porousmold.solvers.field_splits import REDUCTION

from ..support import ALUMINIUM, STUDIES

NARROW = STUDIES / "mold" / "narrow.toml"


@pytest.mark.mpi
@pytest.mark.parametrize(("scene", "refinement"), [(ALUMINIUM, 0.6), (NARROW, 0.25)])
def test_an_iteration_by_fields_is_that_of_the_whole(scene, refinement, monkeypatch):
    """Of the flow with bead turbulence, in two and in three dimensions, within the reduction of the linear residual."""
    settings = {"model.turbulence": "nakayama-kuwahara", "solver.mesh_refinement": refinement}
    flow = Simulation(specs_of(Scene.load(scene, settings)), MPI.COMM_WORLD).problem.flow
    flow.initial_guess()
    system, unknown = flow.solver.system, flow.unknown.x.array
    guess, iterates, iterations = unknown.copy(), [], []
    for largest in (10**9, 0):
        monkeypatch.setattr(newton, "LARGEST_FACTORISED", dict.fromkeys((2, 3), largest))
        unknown[:] = guess
        system.renew_jacobian()
        system.iterate()
        iterates.append(unknown.copy())
        iterations.append(system.linear_iterations)
        system.free()
    change = MPI.COMM_WORLD.allreduce(float(np.sum((iterates[1] - iterates[0]) ** 2)))
    size = MPI.COMM_WORLD.allreduce(float(np.sum(iterates[0] ** 2)))
    assert iterations[0] == 1 < iterations[1]
    assert (change / size) ** 0.5 < 20.0 * REDUCTION
