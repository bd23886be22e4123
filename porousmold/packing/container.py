"""Containers that beads are packed in: axis z upwards from the floor z = 0, centred at x = y = 0.

A wall is known by its distance function alone wherever porosity is averaged: any object with `wall_distance`,
`half_widths` and `period` serves there. The generator needs planes and a cylinder besides (`planes`, `radius`).
"""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ..arrays import Floats
from ..errors import InputError

Planes: TypeAlias = tuple[tuple[float, float, float, float], ...]
"""Inward unit normals and offsets (m)."""
_FLOOR = (0.0, 0.0, 1.0, 0.0)


@dataclass(frozen=True)
class Cylinder:
    """Upright cylinder of inner `diameter` (m)."""

    diameter: float

    @property
    def half_widths(self) -> Floats:
        """Half extents in x and y (m)."""
        return np.array([0.5 * self.diameter, 0.5 * self.diameter])

    @property
    def cross_section(self) -> float:
        """Area (m²)."""
        return np.pi * self.diameter**2 / 4.0

    @property
    def smallest_width(self) -> float:
        """Distance between opposite walls (m)."""
        return self.diameter

    period = (0.0, 0.0)
    planes = (_FLOOR,)

    @property
    def radius(self) -> float:
        """Of the cylindrical wall (m)."""
        return 0.5 * self.diameter

    def wall_distance(self, points: Floats) -> Floats:
        """Distance (n) to the wall (not the floor) of points (n, 3), negative outside, in m."""
        return self.radius - np.hypot(points[:, 0], points[:, 1])


@dataclass(frozen=True)
class Box:
    """Four upright walls, `width` apart in x and `depth` apart in y (m)."""

    width: float
    depth: float
    period = (0.0, 0.0)
    radius = 0.0

    @property
    def half_widths(self) -> Floats:
        """Half extents in x and y (m)."""
        return np.array([0.5 * self.width, 0.5 * self.depth])

    @property
    def cross_section(self) -> float:
        """Area (m²)."""
        return self.width * self.depth

    @property
    def smallest_width(self) -> float:
        """Distance between the closer pair of walls (m)."""
        return min(self.width, self.depth)

    @property
    def planes(self) -> Planes:
        """Inward unit normals and offsets of floor and walls."""
        x, y = self.half_widths
        return (_FLOOR, (1.0, 0.0, 0.0, x), (-1.0, 0.0, 0.0, x), (0.0, 1.0, 0.0, y), (0.0, -1.0, 0.0, y))

    def wall_distance(self, points: Floats) -> Floats:
        """Distance (n) to the nearest wall (not the floor) of points (n, 3), negative outside, in m."""
        return (self.half_widths - np.abs(points[:, :2])).min(axis=1)


@dataclass(frozen=True)
class Slab:
    """Two upright walls, `gap` apart in x; periodic in y with period `width` (m)."""

    gap: float
    width: float
    radius = 0.0

    @property
    def half_widths(self) -> Floats:
        """Half extents in x and y (m)."""
        return np.array([0.5 * self.gap, 0.5 * self.width])

    @property
    def cross_section(self) -> float:
        """Area (m²)."""
        return self.gap * self.width

    @property
    def smallest_width(self) -> float:
        """Distance between the walls (m)."""
        return self.gap

    @property
    def period(self) -> tuple[float, float]:
        """Periods in x (none) and y (m)."""
        return (0.0, self.width)

    @property
    def planes(self) -> Planes:
        """Inward unit normals and offsets of floor and walls."""
        return (_FLOOR, (1.0, 0.0, 0.0, 0.5 * self.gap), (-1.0, 0.0, 0.0, 0.5 * self.gap))

    def wall_distance(self, points: Floats) -> Floats:
        """Distance (n) to the nearer wall (not the floor) of points (n, 3), negative outside, in m."""
        return 0.5 * self.gap - np.abs(points[:, 0])


Container: TypeAlias = Cylinder | Box | Slab
CONTAINERS: Mapping[str, type[Container]] = {"cylinder": Cylinder, "box": Box, "slab": Slab}


def container(kind: str, sizes: Mapping[str, float]) -> Container:
    """The container of a kind from its sizes {name: m}; `InputError` for a kind, a size or a value that cannot be."""
    if kind not in CONTAINERS:
        raise InputError("container", kind, f"must be one of {', '.join(map(repr, CONTAINERS))}")
    needed = [field.name for field in dataclasses.fields(CONTAINERS[kind])]
    for name, value in sizes.items():
        if name not in needed:
            raise InputError(name, value, f"has no place in a {kind}, which has {' and '.join(needed)}")
        if not 0.0 < value < 1e4:
            raise InputError(name, value, "must be > 0 and < 10000 m")
    for name in needed:
        if name not in sizes:
            raise InputError(name, None, f"is missing: a {kind} has {' and '.join(needed)}")
    return CONTAINERS[kind](**sizes)


def description(box: Container) -> tuple[str, dict[str, float]]:
    """(kind, {size: m}) from which `container` makes it again."""
    return next(kind for kind, made in CONTAINERS.items() if isinstance(box, made)), dataclasses.asdict(box)
