"""Plane sections of meshes in three dimensions, as triangles with the weights of the mesh's nodes."""

from typing import Any

import numpy as np
from scipy import sparse

from ..arrays import Floats, Integers

IN_A_HEXAHEDRON = np.array([[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]])
"""Corners of tetrahedra that fill one, around its diagonal."""
CUT_EDGES = {1: [(3, 0), (3, 1), (3, 2)], 2: [(0, 2), (0, 3), (1, 3), (1, 2)], 3: [(0, 1), (0, 2), (0, 3)]}
"""Edges of a tetrahedron that a plane cuts, around the section, by how many of its corners lie above it: corners in order of
their height."""


def triangles_of(cells: Integers) -> Any:
    """Triangles of cells that are triangles or quadrilaterals in drawing order."""
    return np.concatenate([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]]) if cells.shape[1] == 4 else cells


def slice_of(nodes: Floats, cells: Integers, axis: int, value: float) -> tuple[Any, ...]:
    """The section x[axis] = value of hexahedra or tetrahedra in drawing order: places (n, 2) in m, across the axis; triangles of
    them; and the sparse matrix that gives values there of values at the nodes. Fields are taken as linear in tetrahedra."""
    tetrahedra = cells[:, IN_A_HEXAHEDRON].reshape(-1, 4) if cells.shape[1] == 8 else cells
    height = nodes[:, axis] - value
    height = np.where(height == 0.0, 1e-12 * np.ptp(nodes[:, axis]), height)  # no corner lies in the plane itself
    tetrahedra = np.take_along_axis(tetrahedra, np.argsort(height[tetrahedra], axis=1), axis=1)
    above = np.sum(height[tetrahedra] > 0.0, axis=1)
    triangles: list[Floats] = []
    for count, edges in CUT_EDGES.items():
        cut = tetrahedra[above == count][:, np.array(edges)]  # (tetrahedra, edges, 2)
        triangles += [cut[:, [0, i, i + 1]] for i in range(1, len(edges) - 1)]
    corners = np.sort(np.concatenate(triangles).reshape(-1, 2), axis=1)
    pairs, numbers = np.unique(corners, axis=0, return_inverse=True)
    first, second = height[pairs].T
    share = first / (first - second)
    rows = np.arange(len(pairs))
    weights = sparse.csr_matrix(
        (np.concatenate([1.0 - share, share]), (np.tile(rows, 2), pairs.T.ravel())), shape=(len(pairs), len(nodes))
    )
    places = np.delete(weights @ nodes, axis, axis=1)[:, :: 1 if axis else -1]
    return places, numbers.reshape(-1, 3), weights
