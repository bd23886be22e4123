"""Values of fields at chosen points, the same on every rank."""

import numpy as np

from . import fenicsx

TOLERANCE = 1e-6
"""How far, in the cell's own coordinates from 0 to 1, a point may lie outside a cell that is taken to hold it."""


class PointProbe:
    """Evaluates linear functions at fixed points (rows x, y in m); each point belongs to the lowest rank that holds it.

    Raises `ValueError` naming a point that lies in no cell.
    """

    def __init__(self, domain, points):
        self._communicator = domain.communicator
        points = np.asarray(points, dtype=float)
        corners = domain.mesh.geometry.x[fenicsx.cell_vertices(domain.mesh)][:, :, :2]
        found = [_locate(point, corners) for point in points]
        rank, size = self._communicator.rank, self._communicator.size
        finders = np.array(self._communicator.allgather([size if f is None else rank for f in found])).min(axis=0)
        if np.any(finders == size):
            x, y = points[finders == size][0]
            raise ValueError(f"the point ({x:g}, {y:g}) m lies outside the mesh")
        self._mine = [(number, *found[number]) for number in np.flatnonzero(finders == rank)]
        self._count = len(points)

    def __call__(self, function):
        """Values at the points, one row a point, on every rank."""
        space = function.function_space
        table, components = fenicsx.dof_table(space), space.dofmap.index_map_bs
        values = function.x.array.reshape(-1, components)
        result = np.zeros((self._count, components))
        for number, cell, weights in self._mine:
            result[number] = weights @ values[table[cell]]
        return self._communicator.allreduce(result)


def _locate(point, corners):
    """The cell that holds the point and the weights of its corners; None if there is none among `corners`."""
    low, high = corners.min(axis=1), corners.max(axis=1)
    room = TOLERANCE * (high - low)
    candidates = np.flatnonzero(np.all((point >= low - room) & (point <= high + room), axis=1))
    for cell in candidates:
        place = _reference_coordinates(point, corners[cell])
        weights = _shape_functions(place, len(corners[cell]))
        if weights.min() >= -TOLERANCE:
            return cell, weights
    return None


def _shape_functions(place, count):
    s, t = place
    if count == 3:
        return np.array([1.0 - s - t, s, t])
    return np.array([(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t])


def _reference_coordinates(point, corners):
    """Newton's method on the cell's (bi)linear map; one iteration is exact for triangles and parallelograms."""
    place = np.full(2, 0.5 if len(corners) == 4 else 1.0 / 3.0)
    for _ in range(10):
        s, t = place
        if len(corners) == 3:
            slopes = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
        else:
            slopes = np.array([[t - 1.0, s - 1.0], [1.0 - t, -s], [-t, 1.0 - s], [t, s]])
        change = np.linalg.solve(corners.T @ slopes, point - _shape_functions(place, len(corners)) @ corners)
        place = place + change
        if np.max(np.abs(change)) < 1e-12:
            break
    return place
