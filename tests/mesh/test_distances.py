"""Places on facets, and lines that meet them."""

import numpy as np
import pytest

from porousmold.mesh.distances import along_line_to, are_plane, distances_from, nearest_on_facets, unit_normals

SQUARE = np.array([[[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]])
BENT = SQUARE + np.array([0.0, 0, 1]) * np.array([[0.0], [0], [0.2], [0]])


def test_the_nearest_place_on_segments_lies_between_their_nodes():
    segments = np.array([[[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [2.0, 1.0]]])
    assert nearest_on_facets(np.array([0.3, 0.5]), segments) == pytest.approx([0.3, 0.0])
    assert nearest_on_facets(np.array([2.0, 0.0]), segments) == pytest.approx([1.5, 0.5])


@pytest.mark.parametrize("facets", [SQUARE, SQUARE[:, [0, 1, 2]]])
def test_the_nearest_place_on_a_plane_facet_lies_below_the_point(facets):
    assert nearest_on_facets(np.array([0.6, 0.3, 2.0]), facets) == pytest.approx([0.6, 0.3, 0.0])
    assert nearest_on_facets(np.array([0.6, -1.0, 2.0]), facets) == pytest.approx([0.6, 0.0, 0.0])


def test_the_nearest_place_on_a_quadrilateral_that_is_not_plane_is_on_its_sides():
    """Between them no plane tells where it is, and a point beside it would be in no cell."""
    assert are_plane(np.concatenate([SQUARE, BENT])).tolist() == [True, False]
    place = nearest_on_facets(np.array([0.4, 0.5, 1.0]), BENT)
    assert min(abs(place[0]), abs(place[0] - 1), abs(place[1]), abs(place[1] - 1)) < 1e-12


def test_a_line_meets_the_facets_that_lie_across_it():
    facets = np.concatenate([SQUARE + np.array(shift) for shift in ([0.0, 0, 0], [0.0, 0, 2], [3.0, 0, 1])])
    found = np.unique(np.round(along_line_to(np.array([0.5, 0.5, 0.5]), np.array([0.0, 0, 1]), facets), 12))
    assert found == pytest.approx([-0.5, 1.5])
    assert not len(along_line_to(np.array([-1.0, 0.5, 0.0]), np.array([1.0, 0, 0]), SQUARE)), "it runs along this one"
    assert np.abs(unit_normals(facets)) == pytest.approx(np.tile([0.0, 0, 1], (3, 1)))


def test_facets_that_cannot_be_at_a_place_are_not_looked_at():
    facets = np.concatenate([SQUARE, SQUARE + np.array([0.0, 0, 9])])
    assert distances_from(np.array([0.5, 0.5, 0.25]), facets).tolist() == [0.25, np.inf]
    assert np.isinf(distances_from(np.array([0.5, 0.5, -5.0]), facets)).all()
