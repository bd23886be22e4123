"""Values at the corners of cells, and laws interpolated between them."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from porousmold.equations.coordinates import Coordinates
from porousmold.equations.corners import CornersOfBox, CornersOfSimplex
from porousmold.mesh import fenicsx

from ..support import integral

KINDS = ["quadrilateral", "hexahedron", "triangle", "tetrahedron"]


def cells(kind):
    """Cells of a square or cube that is sheared and stretched, with their corners and a function of random values: (corners,
    function)."""
    create, numbers = (mesh.create_unit_square, (2, 2)) if kind in KINDS[::2] else (mesh.create_unit_cube, (2, 1, 2))
    domain = create(MPI.COMM_SELF, *numbers, getattr(mesh.CellType, kind))
    dimension, generator = domain.geometry.dim, np.random.default_rng(3)
    shear = np.eye(dimension) * generator.uniform(0.1, 1.0, dimension) + generator.uniform(
        -0.05, 0.05, (dimension, dimension)
    )
    domain.geometry.x[:, :dimension] = domain.geometry.x[:, :dimension] @ shear
    function = fem.Function(fenicsx.lagrange_space(domain))
    function.x.array[:] = generator.uniform(1.0, 4.0, len(function.x.array))
    from_middle = Coordinates(domain, False).from_middle
    if kind in KINDS[2:]:
        return CornersOfSimplex(domain, from_middle), function
    sides = ufl.Jacobian(domain), ufl.JacobianInverse(domain)
    halves = [0.5 * sides[0][:, axis] for axis in range(dimension)]
    places = [2.0 * ufl.dot(sides[1][axis, :], from_middle) for axis in range(dimension)]
    held = [_of_cells(domain, half) for half in halves]
    return CornersOfBox(list(zip(held, places, strict=True))), function


def _of_cells(domain, vector):
    held = fem.Function(fenicsx.cell_constant_space(domain, domain.geometry.dim))
    held.interpolate(fenicsx.compiled_expression(vector, held.function_space))
    return held


@pytest.mark.parametrize("kind", KINDS)
def test_a_linear_law_is_the_function_itself(kind):
    corners, function = cells(kind)
    difference = corners.interpolated(lambda value: 3.0 * value - 1.0, function) - (3.0 * function - 1.0)
    assert integral(difference**2 * ufl.dx(degree=4)) == pytest.approx(0.0, abs=1e-24)


@pytest.mark.parametrize("kind", KINDS)
def test_any_other_is_that_of_the_values_at_the_nodes(kind):
    """As of a function of the same kind that has the law's values at the nodes."""
    corners, function = cells(kind)
    nodal = fem.Function(function.function_space)
    nodal.x.array[:] = np.exp(function.x.array)
    difference = corners.interpolated(ufl.exp, function) - nodal
    assert integral(difference**2 * ufl.dx(degree=4)) == pytest.approx(0.0, abs=1e-20)
