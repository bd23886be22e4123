"""Iterative solution of large systems: the same iterate, and the same temperatures, as by factors of the whole."""

import numpy as np
import pytest
from mpi4py import MPI

from porousmold.scene.scene import Scene
from porousmold.simulation.specs import specs_of
from porousmold.simulation.time_integration import Simulation
from porousmold.solvers import field_splits, linear_solution

from ..support import ALUMINIUM, STUDIES

NARROW = STUDIES / "mold" / "narrow.toml"
WHOLE, BY_FIELDS = (dict.fromkeys((2, 3), largest) for largest in (10**9, 0))
"""Largest systems that are factorised."""


@pytest.mark.mpi
@pytest.mark.parametrize(("scene", "refinement"), [(ALUMINIUM, 0.6), (NARROW, 0.25)])
def test_an_iteration_by_fields_is_that_of_the_whole(scene, refinement, monkeypatch):
    """Of the flow with bead turbulence, in two and in three dimensions, within the reduction of the linear residual."""
    settings = {"model.turbulence": "nakayama-kuwahara", "solver.mesh_refinement": refinement}
    flow = Simulation(specs_of(Scene.load(scene, settings)), MPI.COMM_WORLD).problem.flow
    flow.initial_guess()
    system, unknown = flow.solver.system, flow.unknown.x.array
    guess, iterates, iterations = unknown.copy(), [], []
    monkeypatch.setattr(field_splits, "REDUCTION", 1e-4)
    for largest in (WHOLE, BY_FIELDS):
        monkeypatch.setattr(linear_solution, "LARGEST_FACTORISED", largest)
        unknown[:] = guess
        system.renew_jacobian()
        system.iterate()
        iterates.append(unknown.copy())
        iterations.append(system.linear_iterations)
        system.free()
    change = MPI.COMM_WORLD.allreduce(float(np.sum((iterates[1] - iterates[0]) ** 2)))
    size = MPI.COMM_WORLD.allreduce(float(np.sum(iterates[0] ** 2)))
    assert iterations[0] == 1 < iterations[1]
    assert (change / size) ** 0.5 < 20.0 * field_splits.REDUCTION


@pytest.mark.parametrize(("scene", "refinement"), [(ALUMINIUM, 0.4), (NARROW, 0.25)])
def test_temperatures_do_not_depend_on_how_the_flow_is_solved(scene, refinement, monkeypatch):
    """Nor does the number of Newton's iterations much."""
    settings = {"solver.mesh_refinement": refinement, "operation.end_time": 120.0}
    coldest, iterations = [], []
    for largest in (WHOLE, BY_FIELDS):
        monkeypatch.setattr(linear_solution, "LARGEST_FACTORISED", largest)
        problem = Simulation(specs_of(Scene.load(scene, settings)), MPI.COMM_SELF).integrate().problem
        coldest.append(problem.places.extremes("bed")[0])
        iterations.append(problem.flow.counts.newton_iterations)
    assert coldest[0] != coldest[1] and coldest[1] == pytest.approx(coldest[0], abs=0.01)
    assert iterations[1] < 1.5 * iterations[0]
