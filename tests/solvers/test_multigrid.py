"""Temperatures solved by iteration: as many iterations on any mesh and step, and the same temperatures as by factors."""

import numpy as np
import pytest
from mpi4py import MPI

from porousmold.solvers import multigrid

from ..support import coarse_scene, simulation_of

NARROW = {"geometry.width": 0.15, "model.turbulence": "none", "solver.mesh_refinement": 0.4}
LAYERS = [
    {"name": "skin", "material": "cfrp", "thickness": 0.004},
    {"name": "wool", "material": "mineral_wool", "thickness": 0.03},
]
MOST_ITERATIONS = 30


def stepped(settings, monkeypatch, *, iterated):
    """A problem after two steps from the local equilibrium's flow, and the iterations of its linear systems."""
    least = dict.fromkeys((2, 3), 0 if iterated else 10**9)
    monkeypatch.setattr("porousmold.solvers.heat_preconditioner.LEAST_UNKNOWNS", least)
    problem = simulation_of(coarse_scene(NARROW | settings), MPI.COMM_SELF).problem
    problem.flow.initial_guess()
    jacobian, iterations = problem.heat._system._jacobian, []
    once = jacobian.count

    def counted(linear_solver):
        once(linear_solver)
        iterations.append(linear_solver.getIterationNumber())

    jacobian.count = counted
    time = 0.0
    for step in (12.0, 60.0):
        problem.heat.step(time, step)
        time += step
    return problem, iterations


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"model.closures": "measured"},
        {"model.energy": "one-temperature"},
        {"model.wall": "thin"},
        {
            "wall.layer": LAYERS,
            "wall.material": None,
            "wall.thickness": None,
            "operation.outer_coefficient": 8.0,
            "operation.ambient_temperature": 293.0,
        },
        {"model.bead_modes": 2},
    ],
    ids=["thesis", "measured", "one temperature", "thin wall", "layers", "inside of beads"],
)
def test_the_same_temperatures_as_by_factors(settings, monkeypatch):
    """Within the 3e-4 K of a stage that they may differ by, in two steps."""
    by_factors, _ = stepped(settings, monkeypatch, iterated=False)
    problem, iterations = stepped(settings, monkeypatch, iterated=True)
    assert problem.heat._system.is_iterated and 1 < max(iterations) <= MOST_ITERATIONS
    difference = problem.heat.unknown.x.array - by_factors.heat.unknown.x.array
    assert np.abs(difference).max() < 5e-3
    assert np.sqrt(np.mean(difference**2)) < 1e-3


def test_iterations_do_not_grow_with_the_mesh(monkeypatch):
    most = [max(stepped({"solver.mesh_refinement": size}, monkeypatch, iterated=True)[1]) for size in (0.3, 0.4, 0.6)]
    assert max(most) <= 1.3 * min(most) + 2


def test_factors_take_over_where_iteration_fails(monkeypatch):
    by_factors, _ = stepped({}, monkeypatch, iterated=False)
    monkeypatch.setattr(multigrid, "MOST_ITERATIONS", 1)
    problem, _ = stepped({}, monkeypatch, iterated=True)
    assert not problem.heat._system.is_iterated
    assert problem.heat.unknown.x.array == pytest.approx(by_factors.heat.unknown.x.array, abs=5e-3)


def test_zeros_of_a_matrix_are_left_out():
    from petsc4py import PETSc

    dense = np.array([[2.0, 0.0, -1.0], [1e-18, 3.0, 0.0], [-1.0, 0.0, 0.0]])
    full = PETSc.Mat().createAIJ((3, 3), comm=MPI.COMM_SELF)
    full.setUp()
    full.setValues(range(3), range(3), dense)
    full.assemble()
    thinned = multigrid.Thinned(full)
    first, columns, values = thinned.matrix.getValuesCSR()
    assert list(columns) == [0, 2, 1, 0, 2] and list(first) == [0, 2, 3, 5]  # the diagonal stays
    assert list(values) == [2.0, -1.0, 3.0, -1.0, 0.0]
    full.scale(2.0)
    thinned.renew()
    assert list(thinned.matrix.getValuesCSR()[2]) == [4.0, -2.0, 6.0, -2.0, 0.0]
