r"""A droplet of water in a slab: a circle that keeps its shape, of water and of the grains that have entered it.

    pi R^2 depth = m_w/rho_w + sum of V of the grains inside
    L dm_w/dt = -(Q_f + Q_p)
    m_w dU/dt = F_f + F_p - m_w g,    F_f = -closed integral of p n over the circle

Q_f is conducted to it by the bed and the gas, Q_p comes with grains that enter; F_p is what the grains inside do to its water
(drag and buoyancy, the opposite of what it does to them). It is at its boiling temperature from the start (Henry et al., section
4).
"""

import math
from dataclasses import dataclass

import numpy as np

from ..arrays import Booleans, Floats
from ..laws.evaporation import BOILING_TEMPERATURE
from ..laws.fluidisation import ATMOSPHERE, GRAVITY
from ..laws.material_library import FLUIDS
from .column_grid import ColumnGrid, both_sides
from .droplet_input import DropletInput

RING = 96
"""Points of the circle at which its vapour leaves and the pressure is taken."""
SAMPLES = 6
"""Along each side of a node's cell, of which the share within the circle is counted."""
LEAST_PART = 0.1
"""Of the way between two nodes that the circle cuts, which counts at least as outside."""
HELD = 1e3
"""Conductance of a node within the circle to its temperature, over that to the next node."""


@dataclass(frozen=True)
class Water:
    """Of boiling water: kg/m3, Pa s, W/m/K."""

    density: float
    viscosity: float
    conductivity: float


def boiling_water() -> Water:
    """At atmospheric pressure, from the library of materials."""
    water, at = FLUIDS["water"], BOILING_TEMPERATURE
    return Water(*map(float, (water.density(ATMOSPHERE, at), water.viscosity(at), water.conductivity(at))))


class Droplet:
    """The droplet of a `DropletInput` over a bed whose surface is at `surface` (m): its centre's `place` (across from the
    middle, and up; m) and `velocity` (the same; m/s), the `mass` of its water (kg) and its `radius` (m)."""

    def __init__(self, given: DropletInput, grid: ColumnGrid, surface: float) -> None:
        self.given, self._grid, self.water = given, grid, boiling_water()
        self.radius = 0.5 * given.droplet_diameter
        self.mass = self.water.density * math.pi * self.radius**2 * given.depth
        above = max(given.release_height, self.radius + 0.5 * given.bead_diameter)
        self.place, self.velocity = np.array([0.0, surface + above]), np.zeros(2)
        self._cell = min(grid.sizes)
        self._up = np.linspace(0.0, given.height, grid.cells[0] + 1)
        self._across = np.linspace(-0.5 * given.width, 0.5 * given.width, grid.cells[1] + 1)

    def is_inside(self, places: Floats) -> Booleans:
        """Whether the centres of beads at `places` (n, 2; m) are within the circle."""
        return np.asarray(((places - self.place) ** 2).sum(axis=1) < self.radius**2)

    def share(self) -> Floats:
        """Part of each node's cell that is within the circle."""
        offsets = self._cell * ((np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5)
        up = (self._up[:, None] + offsets - self.place[1]) ** 2
        across = (self._across[:, None] + offsets - self.place[0]) ** 2
        within = up[:, None, :, None] + across[None, :, None, :] < self.radius**2
        return np.asarray(within.mean(axis=(2, 3)))

    def ring(self, gap: float) -> Floats:
        """Points (n, 2; m) on the circle that is `gap` (m) outside, within the column."""
        angle = 2.0 * np.pi * (np.arange(RING) + 0.5) / RING
        points = self.place + (self.radius + gap) * np.column_stack((np.sin(angle), np.cos(angle)))
        return np.clip(points, (self._across[0], 0.0), (self._across[-1], self.given.height))

    def source(self, rate: float, share: Floats) -> Floats:
        """Vapour (kg/m3/s) at the nodes where a `rate` (kg/s) leaves the circle evenly: each part of it into the nodes around
        that are free of the circle, as what is made within it would press on it."""
        weights = self._grid.weights(self.ring(0.5 * self._cell))
        free = np.where(share < 0.5, 1.0, 1e-9)
        from_each = rate / RING / self._grid.at(weights, free)
        return np.asarray(free * self._grid.spread(weights, from_each) / self._grid.volumes)

    def pressure_force(self, pressure: Floats) -> Floats:
        """F_f across and up (N), of the pressure (Pa) one cell outside, where the nodes are free of the circle."""
        ring = self.ring(self._cell)
        outwards = (ring - self.place) / np.hypot(*(ring - self.place).T)[:, None]
        around = 2.0 * np.pi * self.radius / RING * self.given.depth
        return np.asarray(-around * self._grid.at(self._grid.weights(ring), pressure) @ outwards)

    def is_free(self) -> Booleans:
        """Whether nodes are outside the circle."""
        up, across = self._up[:, None] - self.place[1], self._across - self.place[0]
        return np.asarray(up**2 + across**2 > self.radius**2)

    def between(self, values: Floats, free: Booleans) -> list[Floats]:
        """Conductivities at the faces across each axis of those of nodes: harmonic means; where the circle cuts the way between
        two nodes, that of the outer one over the part of the way outside, as the circle has the droplet's temperature (Shortley,
        Weller 1938)."""
        up, across = np.abs(self._up[:, None] - self.place[1]), np.abs(self._across - self.place[0])
        found = []
        for axis, (gap, size) in enumerate(
            zip((up - self._chord(across), across - self._chord(up)), self._grid.sizes, strict=True)
        ):
            part = np.clip(gap / size, LEAST_PART, 1.0)
            is_outer, is_other_outer = both_sides(free, axis)
            first, second = both_sides(values, axis)
            outer = np.where(is_outer, *both_sides(values / part, axis))
            found.append(np.where(is_outer == is_other_outer, 2.0 / (1.0 / first + 1.0 / second), outer))
        return found

    def _chord(self, off: Floats) -> Floats:
        """Half of the circle's chord at a distance (m) off its centre."""
        return np.sqrt(np.maximum(self.radius**2 - off**2, 0.0))

    def held(self, free: Booleans, conductivity: float) -> Floats:
        """Conductance (W/m3/K) that holds nodes within the circle at its temperature."""
        return np.where(free, 0.0, HELD * conductivity / self._cell**2)

    def move(self, force: Floats, span: float) -> None:
        """Over a span (s) under a force (N; across, up) and its weight; floor and sides stop it."""
        self.velocity += span * (force / self.mass - (0.0, GRAVITY))
        self.place += span * self.velocity
        room = 0.5 * self.given.width - self.radius
        if self.place[1] < self.radius:
            self.place[1], self.velocity[1] = self.radius, max(self.velocity[1], 0.0)
        if abs(self.place[0]) > room:
            self.place[0], self.velocity[0] = math.copysign(room, self.place[0]), 0.0

    def swell(self, volume_inside: float) -> None:
        """Take the radius of its water and of the grains' volume (m3) inside."""
        self.radius = math.sqrt((self.mass / self.water.density + volume_inside) / (math.pi * self.given.depth))
