"""Plane sections of meshes in three dimensions."""

import numpy as np
import pytest

from porousmold.output.slices import IN_A_HEXAHEDRON, slice_of


def bricks(count=3):
    """A unit cube of bricks in drawing order: nodes and cells."""
    line = np.linspace(0.0, 1.0, count + 1)
    nodes = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(nodes)).reshape(3 * (count + 1,))
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    cells = [number[i : i + count, j : j + count, k : k + count].ravel() for i, j, k in corners]
    return nodes, np.column_stack(cells)


@pytest.mark.parametrize("split", [False, True])
@pytest.mark.parametrize(("axis", "value"), [(0, 0.5), (2, 1e-6), (1, 1.0 / 3.0)])
def test_a_section_of_a_cube_is_a_square_with_linear_fields(split, axis, value):
    nodes, cells = bricks()
    cells = cells[:, IN_A_HEXAHEDRON].reshape(-1, 4) if split else cells
    places, triangles, weights = slice_of(nodes, cells, axis, value)
    a, b, c = np.moveaxis(places[triangles], 1, 0)
    first, second = b - a, c - a
    assert np.sum(np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])) / 2.0 == pytest.approx(1.0)
    field = weights @ (nodes @ [2.0, -3.0, 5.0] + 7.0)
    there = np.insert(places[:, :: 1 if axis else -1], axis, value, axis=1)
    assert field == pytest.approx(there @ [2.0, -3.0, 5.0] + 7.0)
