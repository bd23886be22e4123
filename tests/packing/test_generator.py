"""Packings that the generator makes: at rest, within their container, the same for the same seed."""

import numpy as np
import pytest

from porousmold.errors import InputError
from porousmold.packing.container import Box, Cylinder, Slab
from porousmold.packing.generator import LARGEST_KINETIC_ENERGY, LARGEST_RESIDUAL_FORCE, Mixture, pack

BEADS = Mixture((5e-3,))
CONTAINERS = [Cylinder(0.03), Box(0.03, 0.025), Slab(0.03, 0.035)]


@pytest.mark.parametrize("container", CONTAINERS, ids=["cylinder", "box", "slab"])
def test_packing_rests_in_its_container(container):
    packing = pack(container, BEADS, beads=150)
    assert packing.made["kinetic_energy"] < LARGEST_KINETIC_ENERGY
    assert packing.made["residual_force"] < LARGEST_RESIDUAL_FORCE
    assert (container.wall_distance(packing.positions) > 0.48 * 5e-3).all() and (
        packing.positions[:, 2] > 0.48 * 5e-3
    ).all()
    assert packing.mean_overlap < 1e-3
    # frictional beads at rest need four contacts; equal spheres touch at most twelve
    assert 3.5 < packing.coordination_number < 7.0
    assert 0.38 < packing.void_fraction() < 0.52


def test_floor_and_walls_carry_the_weight():
    """At rest the forces on each bead cancel, so that the contacts form one connected bed."""
    packing = pack(Cylinder(0.03), BEADS, beads=150)
    pairs, _ = packing.contacts
    floating = np.setdiff1d(np.arange(150), pairs)
    on_something = (packing.positions[:, 2] <= 2.5e-3) | (packing.container.wall_distance(packing.positions) <= 2.5e-3)
    assert on_something[floating].all()


def test_same_seed_same_packing():
    first, again, other = (pack(Cylinder(0.03), BEADS, beads=80, seed=seed) for seed in (3, 3, 4))
    assert np.array_equal(first.positions, again.positions)
    assert not np.allclose(first.positions, other.positions)


def test_friction_loosens_and_a_void_fraction_is_reached():
    smooth, rough = (pack(Cylinder(0.05), BEADS, beads=400, friction=mu).void_fraction() for mu in (0.0, 0.5))
    assert rough > smooth + 0.02
    wanted = 0.5 * (smooth + rough)
    packing = pack(Cylinder(0.05), BEADS, beads=400, void_fraction=wanted)
    assert packing.void_fraction() == pytest.approx(wanted, abs=1.01e-3)
    assert 0.0 < packing.made["friction"] < 0.5


def test_bed_height_is_covered():
    packing = pack(Cylinder(0.04), BEADS, bed_height=0.05)
    assert packing.positions[:, 2].max() > 0.05
    assert 0.36 < packing.void_fraction(0.05) < 0.46


@pytest.mark.parametrize("by", ["mass", "number"])
def test_mixture_has_its_shares(by):
    mixture = Mixture((4e-3, 6e-3), (1.0, 3.0), by)
    diameters = mixture.draw(1000)
    assert diameters.size == 1000 and (np.diff(diameters) <= 0).all()
    weight = diameters**3 if by == "mass" else np.ones(1000)
    assert weight[diameters == 6e-3].sum() / weight.sum() == pytest.approx(0.75, abs=2e-3)
    assert mixture.mean_bead_volume == pytest.approx(np.pi / 6 * (diameters**3).mean(), rel=2e-3)


def test_mixture_has_a_bead_of_each_size():
    with pytest.raises(InputError, match="one size gets none"):
        Mixture((3e-3, 6e-3), (1.0, 1e-6)).draw(100)
    with np.errstate(all="raise"):
        assert Mixture((3e-3, 6e-3), (1e308, 1e308), "number").draw(4).size == 4


def test_large_beads_of_a_mixture_overlap_no_more_than_small_ones():
    packing = pack(Slab(0.04, 0.056), Mixture((3e-3, 8e-3), (0.3, 0.7)), bed_height=0.03)
    pairs, overlap = packing.contacts
    large = (packing.diameters[pairs] == 8e-3).all(axis=1)
    assert large.sum() > 20 and overlap[large].mean() < 2e-3 * 8e-3


def test_mixture_is_denser_than_one_size():
    equal = pack(Cylinder(0.05), Mixture((4e-3,)), bed_height=0.05)
    mixed = pack(Cylinder(0.05), Mixture((3e-3, 9e-3), (0.4, 0.6)), bed_height=0.05)
    assert set(mixed.diameters) == {3e-3, 9e-3}
    assert mixed.mean_overlap < 1e-3
    assert mixed.void_fraction(0.05) < equal.void_fraction(0.05)


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"beads": 0}, "beads"),
        ({"beads": -3}, "beads"),
        ({"beads": 2.5}, "beads"),
        ({}, "bed_height"),
        ({"bed_height": 1e-3}, "one bead"),
        ({"bed_height": float("nan")}, "one bead"),
        ({"beads": 10, "friction": -0.1}, "friction"),
        ({"beads": 10, "friction": 0.1, "void_fraction": 0.4}, "friction"),
        ({"beads": 10, "void_fraction": 1.4}, "void_fraction"),
        ({"beads": 60, "void_fraction": 0.2}, "out of reach"),
        ({"beads": 60, "bed_height": 1.0}, "60 beads fill at most"),
        ({"beads": 10, "seed": -1}, "seed"),
    ],
)
def test_impossible_wishes_get_one_line(options, word):
    with pytest.raises(InputError, match=word) as caught:
        pack(Cylinder(0.03), BEADS, **options)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("container", "mixture", "word"),
    [
        (Cylinder(5e-3), BEADS, "width of the container"),
        (Slab(0.03, 0.015), BEADS, "periodic"),
        (Cylinder(50.0), Mixture((1e-3,)), "beads; 10000000 are the most"),
    ],
)
def test_beads_too_large_for_the_container(container, mixture, word):
    with pytest.raises(InputError, match=word):
        pack(container, mixture, bed_height=1.0)


@pytest.mark.parametrize(
    ("diameters", "shares", "by", "word"),
    [
        ((), (), "mass", "one share"),
        ((1e-3, 2e-3), (1.0,), "mass", "one share"),
        ((1e-3, -2e-3), (1.0, 1.0), "mass", "bead_diameter"),
        ((1e-3, 2e-3), (1.0, 0.0), "mass", "share"),
        ((1e-120,), (1.0,), "mass", "bead_diameter"),
        ((1e-3, 2e-3), (1.0, 1.0), "volume", "number"),
        ((1e-3, 9e-3), (1.0, 1.0), "mass", "factor of 5"),
    ],
)
def test_mixtures_that_cannot_be(diameters, shares, by, word):
    with pytest.raises(InputError, match=word):
        Mixture(diameters, shares, by)
