"""Values of fields at chosen points, the same on every rank."""

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
from dolfinx import fem

from ..arrays import Floats
from . import fenicsx, ranks
from .domain import Domain

TOLERANCE = 1e-6
"""How far, in the cell's own coordinates from 0 to 1, a point may lie outside a cell that is taken to hold it."""


class PointProbe:
    """Evaluates linear functions at fixed points (m, a row each); a point belongs to the lowest rank that holds it.

    Raises `ValueError` naming a point that lies in no cell.
    """

    def __init__(self, domain: Domain, points: Floats) -> None:
        self._communicator = domain.communicator
        points = np.asarray(points, dtype=float)
        corners = domain.mesh.geometry.x[fenicsx.cell_vertices(domain.mesh)][:, :, : domain.mesh.geometry.dim]
        holders = [_locate(point, corners) for point in points]
        found = [cells[0] if cells else None for cells in holders]
        rank, size = self._communicator.rank, self._communicator.size
        finders = np.array(self._communicator.allgather([size if f is None else rank for f in found])).min(axis=0)
        if np.any(finders == size):
            place = ", ".join(f"{x:g}" for x in points[finders == size][0])
            raise ValueError(f"the point ({place}) m lies outside the mesh")
        self._mine = [(number, *found[number]) for number in np.flatnonzero(finders == rank)]
        self._holders = [
            (number, cell, points[number], corners[cell]) for number, cells in enumerate(holders) for cell, _ in cells
        ]
        self._count = len(points)

    def __call__(self, function: fem.Function) -> Floats:
        """Values at the points, one row a point, on every rank."""
        space = function.function_space
        table, components = fenicsx.dof_table(space), space.dofmap.index_map_bs
        values = function.x.array.reshape(-1, components)
        result = np.zeros((self._count, components))
        for number, cell, weights in self._mine:
            result[number] = weights @ values[table[cell]]
        return ranks.total(self._communicator, result)

    @functools.cached_property
    def _gradients_at_points(self) -> list[Any]:
        """Gradients of the shape functions in every cell that holds a point: (number of the point, cell, gradients)."""
        return [(number, cell, _gradients(point, corners)) for number, cell, point, corners in self._holders]

    def steepness(self, function: fem.Function) -> Floats:
        """Largest magnitude of a scalar function's gradient at each point, over all cells that hold it, on every rank."""
        table, values = fenicsx.dof_table(function.function_space), function.x.array
        result = np.zeros(self._count)
        for number, cell, slopes in self._gradients_at_points:
            result[number] = max(result[number], float(np.linalg.norm(values[table[cell]] @ slopes)))
        return ranks.maximum(self._communicator, result)


def _gradients(point: Floats, corners: Floats) -> Floats:
    """Gradients of the cell's shape functions at the point: (functions, coordinates)."""
    slopes = _slopes(_reference_coordinates(point, corners), len(corners))
    return slopes @ np.linalg.inv(corners.T @ slopes)


def _locate(point: Floats, corners: Floats) -> list[tuple[int, Floats]]:
    """The cells that hold the point, each with the weights of its corners."""
    low, high = corners.min(axis=1), corners.max(axis=1)
    room = TOLERANCE * (high - low)
    candidates = np.flatnonzero(np.all((point >= low - room) & (point <= high + room), axis=1))
    found = []
    for cell in candidates:
        place = _reference_coordinates(point, corners[cell])
        weights = _shape_functions(place, len(corners[cell]))
        if weights.min() >= -TOLERANCE:
            found.append((int(cell), weights))
    return found


def _factors(place: Floats) -> list[Any]:
    """1 - s and s of every coordinate: what the functions of a quadrilateral or hexahedron are products of."""
    return [np.array([1.0 - s, s]) for s in place]


def _product(factors: Sequence[Floats]) -> Floats:
    """Products of one entry of each factor, the first one's varying fastest."""
    result = np.ones(1)
    for factor in factors:
        result = np.outer(factor, result).ravel()
    return result


def _shape_functions(place: Floats, count: int | None) -> Floats:
    if count == len(place) + 1:  # a triangle
        return np.array([1.0 - sum(place), *place])
    return _product(_factors(place))


def _slopes(place: Floats, count: int | None) -> Floats:
    """Derivatives of the shape functions: (functions, coordinates)."""
    dimension = len(place)
    if count == dimension + 1:
        return np.vstack([-np.ones(dimension), np.eye(dimension)])
    columns = []
    for axis in range(dimension):
        factors = _factors(place)
        factors[axis] = np.array([-1.0, 1.0])
        columns.append(_product(factors))
    return np.column_stack(columns)


def _reference_coordinates(point: Floats, corners: Floats) -> Floats:
    """Newton's method on the cell's (multi)linear map; one iteration is exact for simplices and parallelepipeds."""
    count, dimension = corners.shape
    place = np.full(dimension, 1.0 / (dimension + 1) if count == dimension + 1 else 0.5)
    for _ in range(10):
        change = np.linalg.solve(corners.T @ _slopes(place, count), point - _shape_functions(place, count) @ corners)
        place = place + change
        if np.max(np.abs(change)) < 1e-12:
            break
    return place
