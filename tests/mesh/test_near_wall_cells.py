"""Cells put between wall and bed, on meshes of a few cells."""

import numpy as np
import pytest

from porousmold.mesh.gmsh_model import PlainMesh
from porousmold.mesh.near_wall_cells import SHARE, gaps, with_cells_at_wall

BED, WALL, INLET, INTERFACE = 1, 2, 1, 3


def strip(slope=0.0):
    """Three quadrilaterals side by side, 1 wide and 2 high, below a wall along y = 2 + slope x."""
    x = np.arange(4.0)
    zero = np.zeros(4)
    points = np.column_stack([np.tile(x, 2), np.concatenate([zero, 2.0 + slope * x]), np.zeros(8)])
    cells = np.array([[i, i + 1, i + 5, i + 4] for i in range(3)])
    return PlainMesh(points, {BED: cells}, {INTERFACE: np.array([[4, 5], [5, 6], [6, 7]]), INLET: np.array([[0, 4]])})


def refined(mesh, fractions):
    """The mesh with cells in the gaps that can be opened."""
    return with_cells_at_wall(mesh, BED, INTERFACE, gaps(mesh, BED, INTERFACE), fractions)


def test_the_gap_is_a_share_of_the_first_cells():
    assert gaps(strip(), BED, INTERFACE) == pytest.approx(2.0 * SHARE)


def test_new_nodes_lie_at_the_fractions_of_the_gap():
    fractions = np.array([0.0, 0.1, 0.4, 1.0])
    found = refined(strip(), fractions)
    depths = 2.0 - found.points[found.points[:, 0] == 1.0, 1]
    assert sorted(depths) == pytest.approx([0.0, *(2.0 * SHARE * fractions[1:]), 2.0])
    assert len(found.cells[BED]) == 3 * 4 and len(found.facets[INLET]) == 4
    assert np.array_equal(found.facets[INTERFACE], strip().facets[INTERFACE])


def test_the_inlet_stays_in_its_plane_beside_a_sloping_wall():
    found = refined(strip(0.2), np.linspace(0.0, 1.0, 4))
    assert found.points[np.unique(found.facets[INLET]), 0] == pytest.approx(0.0, abs=1e-12)


def test_an_end_without_a_group_stays_in_its_plane_too():
    """The bed of a tool with closed ports was larger by a millionth, and refused for that."""
    found = refined(strip(0.2), np.linspace(0.0, 1.0, 4))
    assert np.sum(np.abs(found.points[:, 0] - 3.0) < 1e-12) == 2 + 3 and found.points[:, 0].max() == pytest.approx(3.0)


def test_a_wall_with_a_sharp_edge_is_refused():
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.3, 0.0]])
    wedge = PlainMesh(points, {BED: np.array([[0, 1, 2]])}, {INTERFACE: np.array([[0, 1], [0, 2]])})
    with pytest.raises(ValueError, match="edge too sharp"):
        with_cells_at_wall(wedge, BED, INTERFACE, np.full(3, 0.1), np.linspace(0.0, 1.0, 3))


def test_an_interface_beside_no_cell_is_refused():
    mesh = strip()
    mesh.facets[INTERFACE] = np.array([[0, 7]])
    with pytest.raises(ValueError, match="beside the bed"):
        gaps(mesh, BED, INTERFACE)
