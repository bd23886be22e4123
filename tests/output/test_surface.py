"""The outer surface of a tool in three dimensions."""

import numpy as np

from porousmold.output.surface import outer_faces

CUBES = np.array([[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 8, 9, 10, 11]])
"""Two hexahedra on top of one another: nodes 0 to 3 below, 4 to 7 between them, 8 to 11 on top."""


def test_the_outer_surface_is_what_touches_no_bed():
    in_bed = np.arange(12) < 8
    faces = outer_faces(CUBES, in_bed)
    assert [sorted(face) for face in faces] == [[8, 9, 10, 11]]


def test_without_a_bed_every_face_of_one_cell_is_outside():
    assert len(outer_faces(CUBES, np.zeros(12, bool))) == 10


def test_tetrahedra_have_triangles():
    faces = outer_faces(np.array([[0, 1, 2, 3], [1, 2, 3, 4]]), np.array([True, False, False, False, False]))
    assert sorted(sorted(face) for face in faces) == [[1, 2, 4], [1, 3, 4], [2, 3, 4]]
