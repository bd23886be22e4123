"""Nodes of a rectangular column: what beads give to them, and take from them, by hat functions."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..arrays import Floats, Scalar
from .column_input import BedInput

Weights: TypeAlias = tuple[Floats, ...]
"""Of each bead: its cell along and across, and its place therein."""


class ColumnGrid:
    """The nodes, (along, across); `volumes` are the nodes' shares of the column, `parts` those of its height and of its width,
    `sizes` those of a cell (m)."""

    def __init__(self, given: BedInput) -> None:
        size = given.cell_size * given.bead_diameter
        self.cells = (max(4, round(given.height / size)), max(3, round(given.width / size)))
        self.lengths = (given.height, given.width)
        self.sizes = [length / n for length, n in zip(self.lengths, self.cells, strict=True)]
        self.parts = [np.full(n + 1, size) for n, size in zip(self.cells, self.sizes, strict=True)]
        for part in self.parts:
            part[[0, -1]] *= 0.5
        self.volumes = np.outer(*self.parts) * given.depth

    def nodes_of(self, places: Floats) -> Floats:
        """Number of the node at each place of the grid, of nodes at `places` (n, 2), m."""
        i, j = (np.rint(places[:, a] / self.lengths[a] * self.cells[a]).astype(int) for a in (0, 1))
        grid = np.empty((self.cells[0] + 1, self.cells[1] + 1), int)
        grid[i, j] = np.arange(len(places))
        return grid

    def weights(self, places: Floats) -> Weights:
        """Of beads at `places` (n, 2): from the middle between the walls, and up, m."""
        along, across = places[:, 1] / self.lengths[0], places[:, 0] / self.lengths[1] + 0.5
        a, b = (np.clip(x * n, 0.0, n - 1e-9) for x, n in zip((along, across), self.cells, strict=True))
        i, j = a.astype(int), b.astype(int)
        return i, j, a - i, b - j

    def spread(self, weights: Weights, values: Floats) -> Floats:
        """Sums of what beads have, at the nodes."""
        i, j, a, b = weights
        row, size = self.cells[1] + 1, (self.cells[0] + 1) * (self.cells[1] + 1)
        found = np.zeros(size)
        for di, wa in ((0, 1.0 - a), (1, a)):
            for dj, wb in ((0, 1.0 - b), (1, b)):
                found += np.bincount((i + di) * row + j + dj, wa * wb * values, size)
        return found.reshape(-1, row)

    def at(self, weights: Weights, field: Floats) -> Floats:
        """A field of the nodes at the beads."""
        i, j, a, b = weights
        low = (1.0 - b) * field[i, j] + b * field[i, j + 1]
        return np.asarray((1.0 - a) * low + a * ((1.0 - b) * field[i + 1, j] + b * field[i + 1, j + 1]))

    def gradient(self, weights: Weights, field: Floats) -> list[Floats]:
        """Of a field, along and across, at the beads."""
        i, j, a, b = weights
        along = (1.0 - b) * (field[i + 1, j] - field[i, j]) + b * (field[i + 1, j + 1] - field[i, j + 1])
        across = (1.0 - a) * (field[i, j + 1] - field[i, j]) + a * (field[i + 1, j + 1] - field[i + 1, j])
        return [along / self.sizes[0], across / self.sizes[1]]


def both_sides(values: NDArray[Scalar], axis: int) -> tuple[NDArray[Scalar], NDArray[Scalar]]:
    """Views of the nodes on both sides of the faces across an axis (0 along, 1 across)."""
    return (values[:-1], values[1:]) if axis == 0 else (values[:, :-1], values[:, 1:])
