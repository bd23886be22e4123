"""What a packing says about itself, on lattices and single beads."""

import math

import numpy as np
import pytest

from porousmold.errors import InputError
from porousmold.packing.container import Box, Cylinder, Slab, container
from porousmold.packing.packing import Packing


def simple_cubic(cells, size=1.0):
    """Beads of diameter 1 that touch, from the walls of a box of `cells` on."""
    grid = np.stack(np.meshgrid(*(np.arange(n) for n in cells), indexing="ij"), axis=-1).reshape(-1, 3) + 0.5
    grid[:, :2] -= 0.5 * np.array(cells[:2])
    return size * grid


def face_centred_cubic(cells):
    """Touching beads of diameter 1 in cubes of edge sqrt(2)."""
    corner = np.array([[0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]])
    shifts = np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3)
    places = math.sqrt(2.0) * ((corner + shifts).reshape(-1, 3) - 0.5 * cells)
    return places + np.array([0.0, 0.0, 0.5 - places[:, 2].min()])


def interior_contacts(packing, margin):
    """Contacts per bead, over the beads at least `margin` from walls, floor and top."""
    pairs, _ = packing.contacts
    per_bead = np.bincount(pairs.ravel(), minlength=packing.diameters.size)
    z = packing.positions[:, 2]
    inside = (packing.container.wall_distance(packing.positions) > margin) & (z > margin) & (z < z.max() + 0.5 - margin)
    return per_bead[inside]


def test_simple_cubic_lattice():
    packing = Packing(simple_cubic((6, 6, 6)), np.full(216, 1.0 + 1e-9), Box(6.0, 6.0))
    assert packing.void_fraction(6.0) == pytest.approx(1.0 - math.pi / 6.0, rel=1e-6)
    assert packing.levelled_height == pytest.approx(6.0)
    assert set(interior_contacts(packing, 1.0)) == {6}
    # any slice of whole layers, and the exact caps of half ones
    assert packing.void_fraction(4.5, 1.5) == pytest.approx(1.0 - math.pi / 6.0, rel=1e-6)
    assert packing.void_fraction(0.25) == pytest.approx(1.0 - math.pi * 0.25**2 * (0.5 - 0.25 / 3) / 0.25, rel=1e-6)


def test_face_centred_cubic_lattice():
    places = face_centred_cubic(5)
    packing = Packing(places, np.full(len(places), 1.0 + 1e-9), Box(8.2, 8.2))
    touching = interior_contacts(packing, 1.8)
    assert touching.size > 20 and set(touching) == {12}


def test_rows_that_stand_twice_are_refused():
    """They made negative porosities, and 0.27 of a bed whose beads were there twice by a fifth."""
    places = simple_cubic((6, 6, 6))
    for copies in (216, 43):
        twice = np.concatenate([places, places[:copies]])
        with pytest.raises(InputError, match="overlap another one"):
            Packing(twice, np.ones(len(twice)), Box(6.0, 6.0)).check_overlaps()
    Packing(places, np.full(216, 1.05), Box(6.1, 6.1)).check_overlaps()  # as soft contacts do


def test_contacts_across_periodic_sides():
    slab = Slab(3.0, 4.0)
    packing = Packing(np.array([[0.0, -1.95, 0.5], [0.0, 1.95, 0.5], [0.0, 0.0, 0.5]]), np.ones(3), slab)
    pairs, overlap = packing.contacts
    assert sorted(map(tuple, pairs)) == [(0, 1)] and overlap == pytest.approx([0.9])


def test_bead_in_a_corner_touches_three_walls():
    packing = Packing(np.array([[-1.0, -1.5, 0.5]]), np.ones(1) + 1e-12, Box(3.0, 4.0))
    assert packing.coordination_number == 3.0 and packing.bead_coordination_number == 0.0


def test_sauter_mean_of_a_mixture():
    packing = Packing(np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 3.0]]), np.array([1.0, 2.0]), Cylinder(4.0))
    assert packing.bead_diameter == pytest.approx(9.0 / 5.0)


@pytest.mark.parametrize(
    ("positions", "diameters", "word"),
    [
        (np.zeros((0, 3)), np.zeros(0), "at least one bead"),
        (np.zeros((2, 3)), np.ones(3), "at least one bead"),
        (np.array([[0.0, 0.0, np.nan]]), np.ones(1), "centres and diameters within"),
        (np.array([[0.0, 0.0, 0.5]]), np.array([-1.0]), "diameters > 0"),
        (np.array([[1.9, 0.0, 0.5]]), np.ones(1), "reach into"),
        (np.array([[2.1, 0.0, 0.5]]), np.ones(1), "outside"),
        (np.array([[0.0, 0.0, 0.5], [0.0, 0.0, -2.0]]), np.ones(2), "floor"),
    ],
)
def test_what_is_no_packing_is_refused(positions, diameters, word):
    with pytest.raises(InputError, match=word):
        Packing(positions, diameters, Cylinder(4.0))


@pytest.mark.parametrize(
    ("kind", "sizes", "word"),
    [
        ("sphere", {}, "must be one of"),
        ("cylinder", {}, "is missing"),
        ("cylinder", {"diameter": 0.0}, "must be > 0"),
        ("cylinder", {"diameter": 1.0, "width": 1.0}, "has no place"),
        ("box", {"width": 1.0}, "depth"),
    ],
)
def test_containers_that_cannot_be_are_refused(kind, sizes, word):
    with pytest.raises(InputError, match=word):
        container(kind, sizes)


def test_distance_functions():
    points = np.array([[0.5, -0.8, 3.0]])
    assert Cylinder(2.0).wall_distance(points) == pytest.approx(1.0 - math.hypot(0.5, 0.8))
    assert Box(2.0, 3.0).wall_distance(points) == pytest.approx(0.5)
    assert Slab(2.0, 3.0).wall_distance(points) == pytest.approx(0.5)


def test_beads_in_flight_are_left_out_and_many_are_refused():
    """A column of five beads in a cylinder, and others above it that touch nothing."""
    column = [[0.0, 0.0, 0.005 + 0.01 * number] for number in range(40)]
    beside = [[0.012, 0.0, 0.02]]  # a bead in a cage below the surface stays
    settled = Packing(np.array(column + beside), np.full(41, 0.01), Cylinder(0.05))
    assert settled.settled() == (settled, 0)
    stray = Packing(np.array([*column, *beside, [0.0, 0.0, 0.9]]), np.full(42, 0.01), Cylinder(0.05))
    bed, left_out = stray.settled()
    assert left_out == 1
    assert np.array_equal(bed.positions, settled.positions)
    assert bed.void_fraction() == pytest.approx(settled.void_fraction())
    flying = [[0.0, 0.0, 0.6 + 0.02 * number] for number in range(5)]
    many = Packing(np.array(column + flying), np.full(45, 0.01), Cylinder(0.05))
    with pytest.raises(InputError, match=r"5 of 45 beads.* let them settle"):
        many.settled()


def test_contacts_across_periodic_sides_hold_a_bead():
    places = np.array([[0.0, 0.0075, 0.005], [0.0, -0.0075, 0.0137]])
    assert Packing(places, np.full(2, 0.01), Slab(0.01, 0.02)).settled()[1] == 0
    with pytest.raises(InputError, match="1 of 2 beads"):
        Packing(places, np.full(2, 0.01), Box(0.01, 0.04)).settled()
