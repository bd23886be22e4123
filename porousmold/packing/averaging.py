r"""phi_V and phi_A of spherical averaging volumes (REVs) in a packing, and profiles of them against wall distance.

A bead of radius r whose centre lies at distance s from that of an REV of radius R takes from its volume and surface

    V_i = pi (R + r - s)^2 (s^2 + 2 s r - 3 r^2 + 2 s R + 6 r R - 3 R^2) / (12 s)      (thesis eq. 5.59)
    A_i = 2 pi R (r^2 - (R - s)^2) / (2 s)                                             (thesis eq. 5.60)

where the spheres cut each other, |R - r| < s < R + r. The print leaves out the nested cases: a bead within the REV
(s <= R - r) takes its whole volume and no surface, an REV within a bead (s <= r - R) has no void at all. Then
phi_V = 1 - sum V_i / V, phi_A = 1 - sum A_i / A, and d(phi_V V)/dR = phi_A A, as for any body that grows with R.

The REV at wall distance y has the diameter D = min(2 y, D_max), D_max = 5.5 d (thesis eq. 5.5), d being the Sauter
mean diameter of a mixture. The wall is known by its distance function alone (`packing.container`).

Profiles: the thesis's five steps on a grid (section 5.6.1), and samples drawn evenly over strata of wall distance. Its
5 mm grid meets only 45 different radii of the 101.6 mm bed. Standard errors come from the scatter of blocks of the bed
along its axis, because REVs overlap: samples within a block are not independent. In beds lower than some 16 d
neighbouring blocks are not independent either, and the errors are too small.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from ..arrays import Booleans, Floats, Integers
from ..errors import InputError
from .packing import Packing

MAXIMUM_DIAMETER_RATIO = 5.5
BLOCKS = 6
# strata in y/d: fine where phi falls, and of about the width that the REVs themselves resolve further in
STRATA = np.concatenate((np.arange(0.0, 1.0, 0.05), np.arange(1.0, 3.0, 0.1), np.arange(3.0, 30.01, 0.25)))
SAMPLES = 1000
LARGEST_GRID = 5_000_000


def _broadcast(rev_radius: ArrayLike, bead_radius: ArrayLike, distance: ArrayLike) -> Sequence[Floats]:
    return np.broadcast_arrays(*(np.asarray(value, float) for value in (rev_radius, bead_radius, distance)))


def lens_volume(rev_radius: ArrayLike, bead_radius: ArrayLike, distance: ArrayLike) -> Floats:
    """Volume (m³) that a bead takes from an REV, eq. 5.59 with the nested cases; arrays in m that broadcast, R and r > 0."""
    rev, bead, s = _broadcast(rev_radius, bead_radius, distance)
    nested = s <= np.abs(rev - bead)
    # divided by s inside, where |R - r| < s keeps every term small: s may be tiny for equal spheres
    inner = s + 2.0 * (bead + rev) - 3.0 * (rev - bead) ** 2 / np.where(nested, 1.0, s)
    lens = np.pi / 12.0 * (rev + bead - s) ** 2 * inner
    whole = 4.0 / 3.0 * np.pi * np.minimum(rev, bead) ** 3
    return np.where(nested, whole, np.where(s >= rev + bead, 0.0, lens))


def lens_area(rev_radius: ArrayLike, bead_radius: ArrayLike, distance: ArrayLike) -> Floats:
    """Surface (m²) of an REV that lies within a bead, eq. 5.60 with the nested cases; as `lens_volume`."""
    rev, bead, s = _broadcast(rev_radius, bead_radius, distance)
    nested = s <= np.abs(rev - bead)
    cap = np.pi * rev * (bead + rev - s) * (1.0 + (bead - rev) / np.where(nested, 1.0, s))
    whole = np.where(bead > rev, 4.0 * np.pi * rev**2, 0.0)
    return np.where(nested, whole, np.where(s >= rev + bead, 0.0, cap))


def rev_porosities(packing: Packing, centres: Floats, radii: Floats) -> tuple[Floats, Floats]:
    """(phi_V, phi_A), arrays (m), of REVs with centres (m, 3) and radii (m) > 0 in m.

    Raises `InputError` where periodic sides are so close that an REV would meet a bead twice.
    """
    centres, radii = packing.wrapped(centres), np.asarray(radii, float)
    largest = 0.5 * packing.diameters.max()
    for period in packing.container.period:
        if 0.0 < period < 2.0 * (radii.max() + largest):
            raise InputError("width", period, f"must be >= {2.0 * (radii.max() + largest):g} m: else an averaging sphere "
                             "meets two images of a bead across the periodic sides")  # fmt: skip
    solid_volume, solid_area = np.zeros(radii.size), np.zeros(radii.size)
    # in batches, so that the list of all lenses stays within some 100 MB
    for batch in np.array_split(np.arange(radii.size), max(1, radii.size // 20_000)):
        found = packing.tree.query_ball_point(centres[batch], radii[batch] + largest)
        counts = np.fromiter(map(len, found), int, len(found))
        bead = np.concatenate([np.asarray(beads, int) for beads in found]) if counts.sum() else np.zeros(0, int)
        rev = np.repeat(batch, counts)
        distance = np.linalg.norm(packing.shortest(centres[rev] - packing.tree.data[bead]), axis=1)
        lenses = radii[rev], 0.5 * packing.diameters[bead], distance
        solid_volume += np.bincount(rev, lens_volume(*lenses), radii.size)
        solid_area += np.bincount(rev, lens_area(*lenses), radii.size)
    return 1.0 - solid_volume / (4.0 / 3.0 * np.pi * radii**3), 1.0 - solid_area / (4.0 * np.pi * radii**2)


@dataclass(frozen=True)
class MeasuredProfile:
    """Means over samples at wall distances `position` (over the bead diameter), with standard errors and counts.

    phi_v and phi_a are the porosities of the averaging spheres; the first row is the wall itself, where both are 1.
    """

    position: Floats
    phi_v: Floats
    phi_a: Floats
    phi_v_error: Floats
    phi_a_error: Floats
    samples: Floats

    @property
    def has_bulk(self) -> bool:
        """Whether some averaging sphere has its full size."""
        return bool(self.position[-1] >= 0.5 * MAXIMUM_DIAMETER_RATIO)

    @property
    def bulk_porosity(self) -> float:
        """Mean phi_V where the averaging sphere has its full size, y >= D_max / 2; the last phi_V if none has."""
        bulk = self.position >= 0.5 * MAXIMUM_DIAMETER_RATIO
        return float(np.average(self.phi_v[bulk], weights=self.samples[bulk])) if bulk.any() else float(self.phi_v[-1])

    @property
    def largest_difference(self) -> tuple[float, float]:
        """(phi_V - phi_A where it is largest in size, its place y/d)."""
        at = int(np.argmax(np.abs(self.phi_v - self.phi_a)))
        return float(self.phi_v[at] - self.phi_a[at]), float(self.position[at])


def _limits(packing: Packing, bed_height: float | None) -> tuple[float, float]:
    """Lowest and highest centre (m) of an REV of full size in the bed (step 5 of the thesis).

    Raises `InputError` for a bed that none fits into, or one that ends below `bed_height`.
    """
    high = packing.levelled_height if bed_height is None else bed_height
    largest = MAXIMUM_DIAMETER_RATIO * packing.bead_diameter
    top = packing.top
    if not 1.05 * largest <= high <= top * (1.0 + 1e-9):
        raise InputError("bed_height", float(high), f"must be >= {1.05 * largest:.4g} m, so that averaging spheres of "
                         f"{MAXIMUM_DIAMETER_RATIO:g} bead diameters fit, and <= {top:.4g} m, the top of the bed")  # fmt: skip
    return 0.5 * largest, high - 0.5 * largest


def _profile(packing: Packing, points: Floats, distance: Floats, group: Integers, groups: int) -> MeasuredProfile:
    """A `MeasuredProfile` of REVs at points, whose wall distances are in the groups given."""
    diameter = packing.bead_diameter
    radii = np.minimum(distance, 0.5 * MAXIMUM_DIAMETER_RATIO * diameter)
    values = np.column_stack((distance / diameter, *rev_porosities(packing, points, radii)))
    counts = np.bincount(group, minlength=groups)
    means = (
        np.column_stack([np.bincount(group, column, groups) for column in values.T]) / np.maximum(counts, 1)[:, None]
    )
    errors = [_block_error(column, points[:, 2], group, groups) for column in values.T[1:]]
    rows = np.flatnonzero(counts)
    rows = rows[np.argsort(means[rows, 0])]
    first = ([0.0], [1.0], [1.0], [0.0], [0.0], [0])
    columns = (*means[rows].T, errors[0][rows], errors[1][rows], counts[rows])
    return MeasuredProfile(*(np.concatenate((start, column)) for start, column in zip(first, columns, strict=True)))


def _block_error(values: Floats, height: Floats, group: Integers, groups: int) -> Floats:
    """Standard errors (groups) of group means from the scatter of blocks of the bed along z; nan from a single block."""
    low, high = height.min(), height.max()
    block = np.minimum((BLOCKS * (height - low) / max(high - low, 1e-300)).astype(int), BLOCKS - 1)
    cell, shape = group * BLOCKS + block, (groups, BLOCKS)
    held = np.bincount(cell, minlength=groups * BLOCKS).reshape(shape)
    means = np.bincount(cell, values, groups * BLOCKS).reshape(shape) / np.maximum(held, 1)
    means[held == 0] = np.nan
    used = (held > 0).sum(axis=1)
    centre = np.nansum(means, axis=1) / np.maximum(used, 1)
    spread = np.nansum((means - centre[:, None]) ** 2, axis=1)
    return np.where(used > 1, np.sqrt(spread / np.maximum(used - 1, 1) / np.maximum(used, 1)), np.nan)


def grid_profile(packing: Packing, spacing: float = 5e-3, bed_height: float | None = None) -> MeasuredProfile:
    """The thesis's profile: REVs at the nodes of a grid of `spacing` (m) about the axis, averaged per wall distance.

    Raises `InputError` for a bed too low for its averaging spheres, or more than `LARGEST_GRID` nodes.
    """
    low, high = _limits(packing, bed_height)
    half_x, half_y = packing.container.half_widths
    nodes = 4.0 * half_x * half_y * (high - low) / spacing**3
    if nodes > LARGEST_GRID:
        raise InputError("grid", spacing, f"gives {nodes:.1e} nodes; {LARGEST_GRID} are the most")
    axes = [spacing * np.arange(-np.floor(half / spacing), np.floor(half / spacing) + 1) for half in (half_x, half_y)]
    x, y, z = np.meshgrid(*axes, np.arange(low, high + 1e-9, spacing), indexing="ij")
    points = np.column_stack((x.ravel(), y.ravel(), z.ravel()))
    distance = packing.container.wall_distance(points)
    points, distance = points[distance > 0.0], distance[distance > 0.0]
    _, group = np.unique(np.round(distance / packing.bead_diameter, 9), return_inverse=True)
    return _profile(packing, points, distance, group, group.max() + 1)


def stratified_profile(
    packing: Packing, bed_height: float | None = None, samples: int = SAMPLES, strata: Floats = STRATA, seed: int = 1
) -> MeasuredProfile:
    """A finer profile: REVs in each of the strata of y/d that the bed reaches, drawn evenly over their volume.

    `samples` in each where the REV has its full size, and up to ten times as many where it is smaller and scatters more.
    """
    middles = 0.5 * (strata[1:] + strata[:-1])
    wanted = (samples * np.clip((0.5 * MAXIMUM_DIAMETER_RATIO / middles) ** 2, 1.0, 10.0)).astype(int)
    low, high = _limits(packing, bed_height)
    points, group, strata = stratified_points(packing, low, high, wanted, strata, seed)
    return _profile(packing, points, packing.container.wall_distance(points), group, len(strata) - 1)


def stratified_points(
    packing: Packing, low: float, high: float, samples: Integers, strata: Floats, seed: int
) -> tuple[Floats, Integers, Floats]:
    """Points (m, 3) between heights low and high (m), `samples` (one number each) in the strata of y/d, with the numbers
    of their strata; and the edges of the strata that the container reaches by at least half their width."""
    rng = np.random.default_rng(seed)
    half_x, half_y = packing.container.half_widths
    deepest = packing.container.wall_distance(_even_points(rng, 100_000, half_x, half_y, low, high)).max()
    strata = strata[: 1 + max(int((deepest / packing.bead_diameter > 0.5 * (strata[1:] + strata[:-1])).sum()), 1)]
    missing = np.array(samples[: len(strata) - 1])
    points, groups = [], []
    for _ in range(10_000):
        batch = _even_points(rng, 200_000, half_x, half_y, low, high)
        distance = packing.container.wall_distance(batch) / packing.bead_diameter
        group = np.searchsorted(strata, distance, side="right") - 1
        sound = (distance > 0.0) & (group < len(strata) - 1)
        batch, group = batch[sound], group[sound]
        order = np.argsort(group, kind="stable")
        batch, group = batch[order], group[order]
        rank = np.arange(group.size) - np.searchsorted(group, group)
        taken = rank < missing[group]
        points.append(batch[taken])
        groups.append(group[taken])
        missing -= np.bincount(group[taken], minlength=missing.size)
        if not missing.any():
            break
    return np.concatenate(points), np.concatenate(groups), strata


def _even_points(
    rng: np.random.Generator, number: int, half_x: float, half_y: float, low: float, high: float
) -> Floats:
    return rng.uniform((-half_x, -half_y, low), (half_x, half_y, high), (number, 3))


def thin_shell_porosity(
    packing: Packing,
    bed_height: float | None = None,
    width: float = 0.05,
    depth: float = 5.0,
    samples: int = 10_000,
    seed: int = 1,
) -> tuple[Floats, Floats, Floats]:
    """(y/d, void fraction, standard error) of shells of `width` (in d) along the wall down to `depth` (in d).

    The void fraction of a shell oscillates with wall distance, unlike that of the REVs. Points are drawn evenly in each
    shell and tested against the beads.
    """
    low, high = _limits(packing, bed_height)
    strata = np.arange(0.0, depth + 0.5 * width, width)
    wanted = np.full(len(strata) - 1, samples)
    points, group, strata = stratified_points(packing, low, high, wanted, strata, seed)
    within = _within_beads(packing, packing.wrapped(points))
    number = np.bincount(group, minlength=len(strata) - 1)
    void = 1.0 - np.bincount(group, within, len(strata) - 1) / number
    return 0.5 * (strata[1:] + strata[:-1]), void, _block_error(1.0 - within, points[:, 2], group, len(strata) - 1)


def _within_beads(packing: Packing, places: Floats) -> Booleans:
    """Which wrapped points lie within a bead: for each size of bead, is the nearest one close enough?"""
    within = np.zeros(len(places), bool)
    # sizes within a fiftieth of the mean count as one: continuous distributions have as many as beads
    sizes = np.round(50.0 * packing.diameters / packing.diameters.mean())
    for size in np.unique(sizes):
        own = sizes == size
        beads, radius = (
            cKDTree(packing.tree.data[own], boxsize=packing.tree.boxsize),
            0.5 * packing.diameters[own].mean(),
        )
        within |= np.isfinite(beads.query(places, distance_upper_bound=radius)[0])
    return within
