"""Plane meshes of one's own with every cell cut in four: the same shape on cells half as long."""

import numpy as np

from ..arrays import Integers
from .gmsh_model import PlainMesh

TRIANGLE = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))
QUADRILATERAL = ((0, 4, 8, 7), (4, 1, 5, 8), (8, 5, 2, 6), (7, 8, 6, 3))
"""The four parts by nodes: corners, then middles of the sides in their order, then the middle."""


def halved(mesh: PlainMesh) -> PlainMesh:
    """A plane mesh of triangles or quadrilaterals with nodes at the middles of their sides, and of quadrilaterals: four cells for
    each, two facets for each. Sides stay straight, so that the shape of the mesh does not change."""
    corners = next(iter(mesh.cells.values())).shape[1]
    sides = np.concatenate([_sides(cells).reshape(-1, 2) for cells in mesh.cells.values()])
    unique, place = np.unique(sides, axis=0, return_inverse=True)
    count = len(mesh.points)
    points, cells, begin, middle = [mesh.points, mesh.points[unique].mean(axis=1)], {}, 0, count + len(unique)
    for tag, part in mesh.cells.items():
        size = len(part) * corners
        nodes = [part, count + place.reshape(-1)[begin : begin + size].reshape(-1, corners)]
        begin += size
        if corners == 4:
            points.append(mesh.points[part].mean(axis=1))
            nodes.append(middle + np.arange(len(part))[:, None])
            middle += len(part)
        parts = TRIANGLE if corners == 3 else QUADRILATERAL
        cells[tag] = np.concatenate([np.hstack(nodes)[:, list(one)] for one in parts])
    keys = unique[:, 0] * count + unique[:, 1]  # sorted, as `unique` is
    facets = {}
    for tag, part in mesh.facets.items():
        low, high = np.sort(part, axis=1).T
        between = count + np.searchsorted(keys, low * count + high)
        facets[tag] = np.concatenate([np.stack([part[:, end], between], axis=1) for end in (0, 1)])
    return PlainMesh(np.concatenate(points), cells, facets)


def _sides(cells: Integers) -> Integers:
    """Ends of the sides of cells (cells, corners, 2), the lower number first."""
    return np.sort(np.stack([cells, np.roll(cells, -1, axis=1)], axis=2), axis=2)
