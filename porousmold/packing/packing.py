"""A packing: beads in a container, with the checks that tell whether it is one."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ..arrays import Booleans, Floats, Integers
from ..errors import InputError
from ..files.units import FARTHEST
from .container import Container

HELD = 0.1
"""Gap between beads, over their diameter, up to which one holds the other."""
MOST_IN_FLIGHT = 0.05
"""Part of a packing's beads that may be in flight."""
REACH = 0.05
"""Part of its diameter by which every bead may reach into a wall, as soft contacts of other codes do."""
MOST_REACHING = 0.01
"""Part of a packing's beads that may reach further, by `FURTHEST_REACH` of their diameter at most."""
FURTHEST_REACH = 0.25
DEEPEST_OVERLAP, MOST_OVERLAPPING = 0.1, 0.01
"""Part of the smaller diameter by which two beads may overlap, as soft contacts do, and part of the beads that may further."""


@dataclass(frozen=True)
class Packing:
    """Centres (n, 3) and diameters (n) of beads in m, their container, and how they came about (`made`, plain values).

    Raises `InputError` for arrays that are no beads, for beads whose centres lie outside their container or below its floor, and
    where more than `MOST_REACHING` of them reach into a wall or the floor by more than `REACH` of their diameter.
    """

    positions: Floats
    diameters: Floats
    container: Container
    made: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        positions, diameters = np.asarray(self.positions, float), np.asarray(self.diameters, float)
        object.__setattr__(self, "positions", positions)
        object.__setattr__(self, "diameters", diameters)
        if (
            positions.ndim != 2
            or positions.shape[1] != 3
            or diameters.shape != positions.shape[:1]
            or not diameters.size
        ):
            raise InputError("packing", str(positions.shape), "must hold at least one bead of three coordinates")
        sound = (np.abs(positions) < FARTHEST).all(axis=1) & (diameters < FARTHEST) & (diameters > 0.0)
        if not sound.all():
            bad = int(np.argmin(sound))
            what = f"bead {bad + 1}: centre {positions[bad]}, diameter {diameters[bad]:g}"
            raise InputError(
                "packing", what, f"must have centres and diameters within {FARTHEST:g} m, and diameters > 0"
            )
        gaps = self._gaps
        place, count = f"{self.container} with its floor at z = 0", len(diameters)
        worst = int(np.argmin(gaps / diameters))
        for found, most, what in (
            (gaps < 0.0, 0.0, f"have their centres outside {place}"),
            (
                gaps < (0.5 - FURTHEST_REACH) * diameters,
                0.0,
                f"reach into the walls or the floor of {place} by more than {FURTHEST_REACH:.0%} of their diameter",
            ),
            (
                self.reaching,
                MOST_REACHING,
                f"reach into the walls or the floor of {place} by more than {REACH:.0%} of their diameter",
            ),
        ):
            if found.sum() > most * count:
                first = f"; the worst is bead {worst + 1} at {positions[worst].round(6).tolist()} m"
                raise InputError("packing", f"{found.sum()} of {count} beads", what + first)

    def check_overlaps(self) -> None:
        """Refuse (`InputError`) beads that are within one another, such as rows that stand twice in a file."""
        pairs, overlaps = self.contacts
        deep = pairs[overlaps > DEEPEST_OVERLAP * self.diameters[pairs].min(axis=1)] if len(pairs) else pairs
        count, of_all = len(np.unique(deep)), self.diameters.size
        if count > MOST_OVERLAPPING * of_all:
            allowed = f"overlap another one by more than {DEEPEST_OVERLAP:.0%} of the diameter: are rows there twice?"
            raise InputError("packing", f"{count} of {of_all} beads", allowed)

    @property
    def top(self) -> float:
        """Height (m) of the highest bead's top."""
        return float((self.positions[:, 2] + 0.5 * self.diameters).max())

    @cached_property
    def reaching(self) -> Booleans:
        """Which beads (n) reach into a wall or the floor by more than `REACH` of their diameter."""
        return np.asarray(self._gaps < (0.5 - REACH) * self.diameters)

    @cached_property
    def _gaps(self) -> Floats:
        """Distance (n) of the centres to the nearest wall or the floor, negative outside, in m."""
        return np.asarray(np.min([self.container.wall_distance(self.positions), *self._plane_distances()], axis=0))

    def _plane_distances(self) -> list[Floats]:
        return [self.positions @ np.array(plane[:3]) + plane[3] for plane in self.container.planes]

    def settled(self) -> tuple["Packing", int]:
        """The packing without beads in flight, and how many these are: above the highest bead that is held, from the floor up, by
        beads no further apart than `HELD` of their diameter.

        Raises `InputError` where they are more than `MOST_IN_FLIGHT` of all: then this is no bed yet.
        """
        radii = 0.5 * self.diameters
        first, second = self.tree.query_pairs((1.0 + HELD) * self.diameters.max(), output_type="ndarray").T
        apart = np.linalg.norm(self.shortest(self.positions[second] - self.positions[first]), axis=1)
        near = apart < radii[first] + radii[second] + HELD * np.minimum(self.diameters[first], self.diameters[second])
        count = len(radii)
        graph = coo_matrix((np.ones(near.sum()), (first[near], second[near])), shape=(count, count))
        groups = connected_components(graph, directed=False)[1]
        bottoms = self.positions[:, 2] - radii
        on_floor = bottoms < max(bottoms.min(), 0.0) + HELD * self.diameters
        held = np.isin(groups, groups[on_floor])
        stays = held | (self.positions[:, 2] <= self.positions[held, 2].max())
        left_out = int(count - stays.sum())
        if left_out > MOST_IN_FLIGHT * count:
            allowed = "are above the bed and touch none of its beads: let them settle, or leave them out"
            raise InputError("packing", f"{left_out} of {count} beads", allowed)
        if not left_out:
            return self, 0
        return replace(self, positions=self.positions[stays], diameters=self.diameters[stays]), left_out

    @property
    def bead_diameter(self) -> float:
        """Sauter mean diameter sum d³ / sum d² (m): the one diameter of beads of one size."""
        return float((self.diameters**3).sum() / (self.diameters**2).sum())

    @property
    def levelled_height(self) -> float:
        """Height (m) of an even bed with the same centre of gravity: twice the mean height of the solid."""
        return float(2.0 * np.average(self.positions[:, 2], weights=self.diameters**3))

    def void_fraction(self, high: float | None = None, low: float = 0.0) -> float:
        """Of the container between heights low and high (m; default 0 and the levelled height), spheres cut exactly."""
        high = self.levelled_height if high is None else high
        radii, heights = 0.5 * self.diameters, self.positions[:, 2]

        def below(plane: float) -> float:
            depth = np.clip(plane - heights + radii, 0.0, 2.0 * radii)
            return float((np.pi * depth**2 * (radii - depth / 3.0)).sum())

        return float(1.0 - (below(high) - below(low)) / (self.container.cross_section * (high - low)))

    @cached_property
    def tree(self) -> cKDTree:
        """k-d tree of the centres in the coordinates of `wrapped`."""
        return cKDTree(self.wrapped(self.positions), boxsize=(*self.container.period, 0.0))

    def wrapped(self, points: Floats) -> Floats:
        """Points in the coordinates of `tree`: periodic ones within [0, period)."""
        points = np.array(points, float)
        for axis, period in enumerate(self.container.period):
            if period > 0.0:
                points[:, axis] = np.mod(points[:, axis] + 0.5 * period, period)
                points[points[:, axis] >= period, axis] = 0.0  # np.mod rounds a tiny negative number to the period
        return points

    def shortest(self, steps: Floats) -> Floats:
        """Steps (n, 3) between points, each the shortest across periodic sides; changes and gives the array."""
        for axis, period in enumerate(self.container.period):
            if period > 0.0:
                steps[:, axis] -= period * np.round(steps[:, axis] / period)
        return steps

    @cached_property
    def contacts(self) -> tuple[Integers, Floats]:
        """(pairs (m, 2), overlaps (m) in m) of beads that touch."""
        pairs = self.tree.query_pairs(self.diameters.max(), output_type="ndarray")
        step = self.shortest(self.positions[pairs[:, 1]] - self.positions[pairs[:, 0]])
        overlap = 0.5 * self.diameters[pairs].sum(axis=1) - np.linalg.norm(step, axis=1)
        touching = overlap >= 0.0
        return pairs[touching], overlap[touching]

    @property
    def mean_overlap(self) -> float:
        """Of the contacts between beads, each over the mean diameter of its two (0 without contacts)."""
        pairs, overlap = self.contacts
        return float((overlap / self.diameters[pairs].mean(axis=1)).mean()) if overlap.size else 0.0

    @property
    def coordination_number(self) -> float:
        """Contacts per bead with other beads, walls and floor."""
        gaps = self._plane_distances()
        if self.container.radius > 0.0:
            gaps.append(self.container.wall_distance(self.positions))
        walls = sum(int((gap <= 0.5 * self.diameters).sum()) for gap in gaps)
        return (2 * len(self.contacts[1]) + walls) / self.diameters.size

    @property
    def bead_coordination_number(self) -> float:
        """Contacts per bead with other beads alone."""
        return 2 * len(self.contacts[1]) / self.diameters.size
