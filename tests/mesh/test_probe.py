"""Values at points."""

import numpy as np
import pytest
import ufl
from hypothesis import given
from hypothesis import strategies as st
from mpi4py import MPI

from porousmold.mesh import domain as geometry
from porousmold.mesh.probe import PointProbe, _reference_coordinates, _shape_functions

from ..support import box, nodal


def test_linear_functions_are_exact_and_outside_is_refused():
    domain = box((5, 7), length=2.0, wall=0.3, wall_cells=2)
    x = ufl.SpatialCoordinate(domain.mesh)
    function = nodal(domain, 3.0 + 2.0 * x[0] - 5.0 * x[1] + x[0] * x[1])
    points = np.array([[0.0, 0.0], [2.0, 1.3], [0.4, 1.0], [0.713, 0.291], [1.2, 1.0 + 1e-12]])
    expected = 3.0 + 2.0 * points[:, 0] - 5.0 * points[:, 1] + points[:, 0] * points[:, 1]
    assert PointProbe(domain, points)(function)[:, 0] == pytest.approx(expected, abs=1e-9)
    slopes = np.column_stack([2.0 + points[:, 1], points[:, 0] - 5.0])
    assert PointProbe(domain, points).steepness(function) == pytest.approx(np.linalg.norm(slopes, axis=1), abs=1e-8)
    with pytest.raises(ValueError, match="outside"):
        PointProbe(domain, [(2.1, 0.5)])


def test_steepness_at_a_kink_is_that_of_the_steeper_side():
    domain = box((4, 4), wall=0.25, wall_cells=2)
    y = ufl.SpatialCoordinate(domain.mesh)[1]
    function = nodal(domain, ufl.conditional(ufl.lt(y, 1.0 + 1e-9), 3.0 * y, 3.0 + 70.0 * (y - 1.0)))
    points = [(0.5, 1.0), (0.3, 1.0), (0.3, 0.9), (0.3, 1.1)]
    assert PointProbe(domain, points).steepness(function) == pytest.approx([70.0, 70.0, 3.0, 70.0])


def test_linear_functions_in_three_dimensions():
    middle = np.array([0.0, 0.4, 1.0])
    domain = geometry.straight_bed(MPI.COMM_SELF, middle, [geometry.Across(middle, 2), geometry.Across(middle, 2)])
    x = ufl.SpatialCoordinate(domain.mesh)
    function = nodal(domain, 3.0 + 2.0 * x[0] - 5.0 * x[1] + 7.0 * x[2] + x[0] * x[1] * x[2])
    points = np.array([[0.0, 0.0, 1.0], [0.4, 1.0, 0.4], [0.713, 0.291, 0.9]])
    expected = 3.0 + points @ [2.0, -5.0, 7.0]
    corrected = PointProbe(domain, points)(function)[:, 0] - points.prod(axis=1)
    assert corrected == pytest.approx(expected, abs=0.02)
    assert corrected[:2] == pytest.approx(expected[:2], abs=1e-9)


@given(s=st.floats(0.0, 1.0), t=st.floats(0.0, 1.0), flat=st.floats(1e-6, 1.0))
def test_reference_coordinates_invert_the_map_of_flat_cells(s, t, flat):
    corners = np.array([[0.0, 0.0], [1.0, 0.1 * flat], [0.05, flat], [1.1, 1.2 * flat]])
    point = _shape_functions((s, t), 4) @ corners
    assert _reference_coordinates(point, corners) == pytest.approx([s, t], abs=1e-8)
