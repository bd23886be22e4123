"""Values at nodes, quadrature points and in the middle of cells."""

import numpy as np
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI

from porousmold.mesh import fenicsx, ranks
from porousmold.mesh.point_values import PointValues, nodal_values


def test_nodal_values_of_a_vector_are_those_of_its_entries():
    domain = fenicsx.box_mesh(MPI.COMM_SELF, (3, 2))
    space, (x, y) = fenicsx.lagrange_space(domain), ufl.SpatialCoordinate(domain)
    together = nodal_values(ufl.as_vector([x + y, 3.0 * y]), space)
    assert np.array_equal(together, [nodal_values(x + y, space), nodal_values(3.0 * y, space)])


@pytest.mark.parametrize("degree", [None, 3])
def test_values_follow_what_they_are_of(degree):
    """Integrals of a linear expression and of a tensor are exact by the rule; renewed, they have the new values."""
    domain = fenicsx.box_mesh(MPI.COMM_SELF, (3, 2))
    x, y = ufl.SpatialCoordinate(domain)
    function = fem.Function(fenicsx.lagrange_space(domain))
    function.x.array[:] = 2.0
    values = PointValues(domain, degree)
    scalar = values.add(function * (x + y))
    tensor = values.add(ufl.as_tensor([[function, 3.0 * x], [0.0 * x, 1.0 + 0.0 * x]]))
    values.compile()
    measure = ufl.dx(metadata={"quadrature_degree": degree or 1})
    form = fenicsx.compiled_form((scalar + tensor[0, 1]) * measure)
    for factor in (2.0, 5.0):
        function.x.array[:] = factor
        values.renew()
        assert ranks.integral(MPI.COMM_SELF, form) == pytest.approx(factor + 1.5, rel=1e-12)
