"""phi_V and phi_A of averaging spheres: exactness, lattices, invariance, and the bed of the thesis."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from porousmold.errors import InputError
from porousmold.laws.oscillating_porosity import de_klerk
from porousmold.packing.averaging import (
    grid_profile,
    lens_area,
    lens_volume,
    rev_porosities,
    stratified_profile,
    thin_shell_porosity,
)
from porousmold.packing.container import Cylinder, Slab
from porousmold.packing.fitting import model_scores
from porousmold.packing.generator import Mixture, pack
from porousmold.packing.packing import Packing

PUBLISHED = tomllib.loads((Path(__file__).parent.parent / "published.toml").read_text(encoding="utf-8"))["packing"]
OPEN = Cylinder(1e3)
sizes = st.floats(0.05, 5.0)


class Space:
    """A container without walls, for clusters of beads anywhere."""

    period, planes, radius = (0.0, 0.0), (), 0.0

    @staticmethod
    def wall_distance(points):
        """Far from everywhere."""
        return np.full(len(points), 1e6)


def lens_by_quadrature(rev, bead, s):
    """Volume of the common part of two spheres: the overlap of discs along the line of centres."""
    low, high = max(-rev, s - bead), min(rev, s + bead)
    x = low + (high - low) * np.arange(0.5, 20_000) / 20_000
    disc = np.minimum(np.clip(rev**2 - x**2, 0.0, None), np.clip(bead**2 - (x - s) ** 2, 0.0, None))
    return np.pi * disc.mean() * max(high - low, 0.0)


@given(sizes, sizes, st.floats(0.0, 10.0))
def test_lens_equals_quadrature(rev, bead, s):
    assert lens_volume(rev, bead, s) == pytest.approx(lens_by_quadrature(rev, bead, s), rel=1e-6, abs=1e-12)


@given(sizes, sizes, st.floats(0.0, 1.0))
def test_surface_is_the_derivative_of_the_volume(rev, bead, fraction):
    """dV_i/dR = A_i, so that d(phi_V V)/dR = phi_A A: to 1e-8 by a fourth-order difference, all cases."""
    s = fraction * (rev + bead) * 1.1
    h = 1e-3 * min(rev, bead)
    edges = np.array([abs(rev - bead) - s, rev + bead - s])
    if np.abs(edges).min() < 5.0 * h:  # the formulas change there
        return
    around = lens_volume(rev + h * np.array([-2.0, -1.0, 1.0, 2.0]), bead, s)
    slope = (around[0] - 8.0 * around[1] + 8.0 * around[2] - around[3]) / (12.0 * h)
    assert slope == pytest.approx(float(lens_area(rev, bead, s)), abs=1e-8 * 4.0 * math.pi * rev**2 + 1e-8)


def test_derivative_holds_for_a_whole_packing():
    rng = np.random.default_rng(0)
    packing = Packing(rng.uniform(-3.0, 3.0, (60, 3)), rng.uniform(0.4, 1.2, 60), Space())
    radius, h = 1.7, 1e-4
    radii = radius + h * np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
    phi_v, phi_a = rev_porosities(packing, np.zeros((5, 3)), radii)
    void = phi_v * 4.0 / 3.0 * np.pi * radii**3
    slope = (void[0] - 8.0 * void[1] + 8.0 * void[3] - void[4]) / (12.0 * h)
    assert slope == pytest.approx(phi_a[2] * 4.0 * np.pi * radius**2, rel=1e-8)


def test_nested_spheres():
    assert lens_volume(2.0, 0.5, 1.0) == pytest.approx(4.0 / 3.0 * math.pi * 0.125) and lens_area(2.0, 0.5, 1.0) == 0.0
    assert lens_volume(0.5, 2.0, 1.0) == pytest.approx(4.0 / 3.0 * math.pi * 0.125)
    assert lens_area(0.5, 2.0, 1.0) == pytest.approx(math.pi)
    assert lens_volume(1.0, 1.0, 0.0) == pytest.approx(4.0 / 3.0 * math.pi)
    assert lens_volume(1.0, 1.0, 2.0) == 0.0 and lens_area(1.0, 1.0, 2.0) == 0.0


def test_monte_carlo_agrees():
    rng = np.random.default_rng(1)
    packing = pack(Cylinder(0.03), Mixture((5e-3,)), beads=150)
    centre, radius, number = np.array([2e-3, -1e-3, 15e-3]), 7e-3, 200_000
    phi_v, phi_a = rev_porosities(packing, centre[None], [radius])
    direction = rng.normal(size=(number, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    shell, ball = centre + radius * direction, centre + radius * rng.random((number, 1)) ** (1 / 3) * direction
    for exact, points in ((phi_v[0], ball), (phi_a[0], shell)):
        void = (packing.tree.query(points)[0] > 2.5e-3).mean()
        assert exact == pytest.approx(void, abs=4.0 * math.sqrt(void * (1 - void) / number))


def test_translation_and_rotation_leave_porosities():
    rng = np.random.default_rng(2)
    places, diameters = rng.uniform(-3.0, 3.0, (80, 3)), rng.uniform(0.3, 1.0, 80)
    centres, radii = rng.uniform(-1.0, 1.0, (5, 3)), rng.uniform(0.2, 2.5, 5)
    turn, shift = Rotation.random(random_state=3), np.array([5.0, -2.0, 7.0])
    before = rev_porosities(Packing(places, diameters, Space()), centres, radii)
    after = rev_porosities(Packing(turn.apply(places) + shift, diameters, Space()), turn.apply(centres) + shift, radii)
    assert np.allclose(before, after, rtol=0, atol=1e-12)


LATTICES = {
    "simple cubic": (1.0, np.zeros((1, 3)), 1.0 - math.pi / 6.0),
    "fcc": (
        math.sqrt(2.0),
        np.array([[0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]]),
        1.0 - math.pi / math.sqrt(18.0),
    ),
}


@pytest.mark.parametrize("name", LATTICES)
@pytest.mark.parametrize("radius", [0.3, 1.0, 2.2])
def test_lattice_porosity_is_the_mean_over_a_cell(name, radius):
    """phi_V and phi_A averaged over centres in one cell of a periodic medium are its porosity, for every radius."""
    edge, base, porosity = LATTICES[name]
    cells = np.stack(np.meshgrid(*[np.arange(-4, 5)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3)
    places = edge * (cells + base).reshape(-1, 3)
    packing = Packing(places, np.ones(len(places)), Space())
    nodes = (np.stack(np.meshgrid(*[np.arange(24)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) + 0.5) / 24
    phi_v, phi_a = rev_porosities(packing, edge * nodes, np.full(len(nodes), radius))
    assert phi_v.mean() == pytest.approx(porosity, abs=2e-4)
    assert phi_a.mean() == pytest.approx(porosity, abs=2e-3)


def layered_slab():
    """Simple cubic layers that touch both walls of a slab 8 beads wide, periodic in y, 20 high."""
    grid = (
        np.stack(np.meshgrid(np.arange(8), np.arange(12), np.arange(20), indexing="ij"), axis=-1).reshape(-1, 3) + 0.5
    )
    return Packing(grid - [4.0, 6.0, 0.0], np.ones(len(grid)), Slab(8.0, 12.0))


def test_thin_shells_of_layers_are_known():
    position, void, _ = thin_shell_porosity(layered_slab(), 20.0, width=0.02, depth=3.0, samples=4000)
    depth = position % 1.0
    # the mean over a shell's width of pi (r^2 - (y - r)^2) d^-2
    exact = 1.0 - np.pi * (depth * (1.0 - depth) - 0.02**2 / 12.0)
    scatter = np.sqrt(exact * (1.0 - exact) / 4000)
    assert (np.abs(void - exact) < 5.0 * scatter).all()


def test_standard_errors_tell_the_scatter():
    """Repeated draws scatter about their mean within what the standard errors say, and about the same value."""
    packing = pack(Cylinder(0.05), Mixture((5e-3,)), bed_height=0.1)
    strata = np.array([0.0, 0.2, 0.4, 1.0, 2.0])
    draws = [stratified_profile(packing, 0.1, samples=60, strata=strata, seed=seed) for seed in range(6)]
    spread = np.std([draw.phi_v[1:] for draw in draws], axis=0, ddof=1)
    assert (spread < 3.0 * np.mean([draw.phi_v_error[1:] for draw in draws], axis=0)).all()


def test_beds_that_no_averaging_sphere_fits_are_refused():
    packing = layered_slab()
    for height, word in ((5.0, "averaging spheres"), (21.0, "top of the bed")):
        with pytest.raises(InputError, match=word):
            stratified_profile(packing, height, samples=10)
    narrow = Packing(packing.positions[np.abs(packing.positions[:, 1]) < 3.0], np.ones(8 * 6 * 20), Slab(8.0, 6.0))
    with pytest.raises(InputError, match="two images"):
        stratified_profile(narrow, 20.0, samples=10)
    with pytest.raises(InputError, match="nodes"):
        grid_profile(packing, 1e-3, 20.0)


def test_profile_starts_at_the_wall():
    profile = stratified_profile(layered_slab(), 20.0, samples=50, strata=np.array([0.0, 0.01, 0.5, 3.0, 4.0]))
    assert (profile.position[0], profile.phi_v[0], profile.phi_a[0]) == (0.0, 1.0, 1.0)
    assert profile.phi_v[1] > 0.97
    assert (np.diff(profile.position) > 0).all() and profile.position[-1] < 4.0


@pytest.fixture(scope="module")
def bed():
    """The bed of the thesis, section 5.6."""
    return pack(Cylinder(PUBLISHED["bed_diameter"]), Mixture((PUBLISHED["bead_diameter"],)), beads=PUBLISHED["beads"],
                bed_height=PUBLISHED["bed_height"])  # fmt: skip


def test_bed_of_the_thesis(bed):
    height = PUBLISHED["bed_height"]
    assert bed.void_fraction(height) == pytest.approx(PUBLISHED["void_fraction"], abs=3e-3)
    assert bed.mean_overlap <= 1e-3
    assert 5.3 < bed.coordination_number < 5.8


def test_profiles_of_the_thesis(bed):
    height = PUBLISHED["bed_height"]
    fine, grid = stratified_profile(bed, height, samples=200), grid_profile(bed, PUBLISHED["grid"], height)
    assert grid.position.size == 46  # the wall and the 45 radii of the 5 mm grid
    for profile in (fine, grid):
        difference, place = profile.largest_difference
        assert -0.09 < difference < -0.06 and 0.4 < place < 0.7
    # phi_V is not monotone: a minimum near 0.45-0.5 d
    near = fine.position < 1.0
    assert 0.4 < fine.position[near][np.argmin(fine.phi_v[near])] < 0.55
    scores = model_scores(grid.position[1:], grid.phi_v[1:])
    assert scores["hunt-tien"].given == pytest.approx(PUBLISHED["r2_hunt_tien"], abs=0.04)
    assert (
        scores["hunt-tien"].given
        > scores["white-tien"].given
        > scores["cheng-hsu"].given
        > scores["vortmeyer-schuster"].given
    )
    # closer to the wall the grid has a few points per radius only
    inner = grid.position > 0.3
    assert (np.abs(np.interp(grid.position[inner], fine.position, fine.phi_v) - grid.phi_v[inner]) < 0.01).all()


def test_thin_shells_oscillate_as_measured(bed):
    height = PUBLISHED["bed_height"]
    # two beds: the shells of a single one scatter by 0.01
    other = pack(bed.container, Mixture((bed.bead_diameter,)), beads=bed.diameters.size, bed_height=height, seed=2)
    shells = [thin_shell_porosity(each, height) for each in (bed, other)]
    position, void = shells[0][0], np.mean([each[1] for each in shells], axis=0)
    bulk = stratified_profile(bed, height, samples=50).bulk_porosity
    assert np.sqrt(np.mean((void - de_klerk(position, bulk)) ** 2)) < 0.035
    for low, high, pick in (
        (0.3, 0.8, np.argmin),
        (0.8, 1.2, np.argmax),
        (1.2, 1.65, np.argmin),
        (1.65, 2.1, np.argmax),
    ):
        part = (position > low) & (position < high)
        expected = {0.3: 0.55, 0.8: 1.0, 1.2: 1.4, 1.65: 1.9}[low]
        assert position[part][pick(void[part])] == pytest.approx(expected, abs=0.1)
