"""Plane meshes whose cells are halved: the same shape, groups and orientation on four times the cells."""

import numpy as np
import pytest
from dolfinx import fem
from mpi4py import MPI

from porousmold.mesh.domain import BED, INLET, INTERFACE, OUTLET, WALL
from porousmold.mesh.from_gmsh import Finer, from_file
from porousmold.mesh.gmsh_model import PlainMesh
from porousmold.mesh.halving import halved

from ..support import MESHES, integral

SQUARE = np.array(
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.2, 1.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.5, 0.0]]
)
QUADRILATERALS = PlainMesh(
    SQUARE, {BED: np.array([[0, 1, 2, 3]]), WALL: np.array([[4, 5, 2, 1]])}, {INTERFACE: np.array([[2, 1]])}
)
TRIANGLES = PlainMesh(
    SQUARE,
    {BED: np.array([[0, 1, 2], [0, 2, 3]]), WALL: np.array([[1, 4, 2], [4, 5, 2]])},
    {INTERFACE: np.array([[2, 1]])},
)


def areas(mesh, tag):
    """Signed areas of the cells, by the shoelace formula."""
    x, y = np.moveaxis(mesh.points[mesh.cells[tag]][:, :, :2], 2, 0)
    return 0.5 * np.sum(x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y, axis=1)


@pytest.mark.parametrize("mesh", [QUADRILATERALS, TRIANGLES], ids=["quadrilaterals", "triangles"])
def test_every_cell_is_four_of_its_shape(mesh):
    """Areas are the same and of one sign; sides that cells share have one node in their middle (Euler's formula counts it)."""
    fine = halved(mesh)
    for tag, cells in mesh.cells.items():
        assert len(fine.cells[tag]) == 4 * len(cells)
        before, after = areas(mesh, tag), areas(fine, tag)
        assert after.sum() == pytest.approx(before.sum(), rel=1e-14) and (after > 0.0).all() == (before > 0.0).all()
    cells = np.concatenate(list(fine.cells.values()))
    sides = np.unique(np.sort(np.stack([cells, np.roll(cells, -1, axis=1)], axis=2).reshape(-1, 2), axis=1), axis=0)
    assert len(fine.points) - len(sides) + len(cells) == 1 and len(np.unique(cells)) == len(fine.points)
    ends = fine.points[fine.facets[INTERFACE]]
    assert len(ends) == 2 and np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(np.hypot(0.2, 1.0))


def test_a_file_with_halved_cells_has_its_groups():
    plain, fine = (from_file(MPI.COMM_SELF, MESHES / "mold.geo", finer=Finer(halvings=times)) for times in (0, 2))
    for tag in (BED, WALL):
        assert len(fine.cells(tag)) == 16 * len(plain.cells(tag))
    for tag in (INLET, OUTLET, INTERFACE):
        assert len(fine.facets(tag)) == 4 * len(plain.facets(tag))
    assert fine.length == pytest.approx(plain.length, rel=1e-12)
    for domain in (plain, fine):
        assert integral(fem.Constant(domain.mesh, 1.0) * domain.wall_measure(2)) == pytest.approx(0.003)
