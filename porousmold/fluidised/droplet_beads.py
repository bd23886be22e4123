"""The beads around and in a droplet: parcels of grains, one layer deep. Those in the water feel its drag and buoyancy, and it
feels theirs; those that its vapour has not reached stick together (bonds); where its vapour keeps hot ones out, they are pushed
off its edge."""

import math

import numpy as np
from numpy.typing import NDArray

from ..arrays import Floats, Scalar
from ..errors import InputError
from ..laws.fluidisation import GRAVITY
from .column_beads import ColumnBeads, lattice
from .droplet import Droplet
from .droplet_input import DropletInput

STIFFNESS = 2e3
"""Of contacts, in weights of a parcel per diameter: 40 layers press their lowest together by 2 %."""
EDGE_STIFFNESS, EDGE_DAMPING = 0.2, 0.2
"""Of the vapour between a hot parcel and the water: part of `STIFFNESS`, and of critical damping."""


class DropletBeads(ColumnBeads):
    """The parcels at `positions` (n, 3; m); `fill` is the grains' share of a parcel's volume."""

    restitution = 0.5

    def __init__(self, given: DropletInput, positions: Floats, fill: float = 1.0) -> None:
        super().__init__(given, positions)
        self.fill = fill
        self.bonds = np.zeros(len(self))
        self.in_water = np.zeros(len(self))
        self.repelled = np.zeros(len(self), bool)
        self.droplet: Droplet | None = None
        self.pressure_force = np.zeros(2)
        self.on_water = np.zeros(2)

    @classmethod
    def at_rest(cls, given: DropletInput) -> "DropletBeads":
        """Parcels that have fallen and come to rest, filled so that the bed has its solid fraction. Raises `InputError` for one
        that parcels do not have."""
        beads = cls(given, lattice(given)[0])
        beads.come_to_rest()
        of_parcels = len(beads) * beads.volume / (given.width * given.depth * beads.surface)
        if given.solid_fraction > of_parcels:
            raise InputError(
                "--solid-fraction", given.solid_fraction, f"must be <= {of_parcels:.3g}, that of the parcels"
            )
        return cls(given, given.bead_diameter * beads._body[:, :3], given.solid_fraction / of_parcels)

    def _stiffness(self, count: int) -> float:
        return STIFFNESS

    @property
    def surface(self) -> float:
        """Height of the bed at rest, m."""
        return float(2.0 * self.places[:, 1].mean())

    @property
    def mass(self) -> float:
        """Of the grains of a parcel, kg."""
        return self.fill * self.given.bead_mass

    @property
    def volume(self) -> float:
        """Of the grains of a parcel, m3."""
        return self.fill * math.pi / 6.0 * self.given.bead_diameter**3

    def by_name(self, values: NDArray[Scalar]) -> NDArray[Scalar]:
        """Values of the beads in the order of their names, which does not change while they move."""
        named = np.empty_like(values)
        named[self._name] = values
        return named

    def move_with(
        self,
        droplet: Droplet,
        gas: list[Floats],
        push: list[Floats],
        rate: Floats,
    ) -> None:
        """`move` beads and droplet together: before, `in_water` (by name) has the rate (1/s) of the water's drag on those inside,
        `repelled` those that the vapour pushes off, `bonds` the bonds, `pressure_force` what the gas does to the droplet (N)."""
        self.droplet = droplet
        self.on_water = np.zeros(2)
        self.move(gas, push, rate)
        self.on_water /= self.given.time_step

    def _feel(self, of_gas: Floats, span: float) -> None:
        super()._feel(of_gas, span)
        droplet = self.droplet
        if droplet is None:
            return
        self._push_off(droplet, span)
        self._drag_by_water(droplet, span)
        droplet.move(self.pressure_force, span)

    def _drag_by_water(self, droplet: Droplet, span: float) -> None:
        """Drag of the water, implicit for both sides, and buoyancy: what one gets, the other gives."""
        rate = self.in_water[self._name]
        inside = np.flatnonzero(rate)
        if not inside.size:
            return
        mass, lift = self.mass, droplet.water.density / self.given.bead_density * GRAVITY
        per_bead = rate[inside] * span / (1.0 + rate[inside] * span)
        for slot, axis, rise in ((0, 3, 0.0), (1, 5, lift)):
            beads = self._unit * self._body[inside, axis] + span * rise
            before = droplet.velocity[slot]
            momentum = droplet.mass * before - mass * span * rise * inside.size + mass * (per_bead * beads).sum()
            after = momentum / (droplet.mass + mass * per_bead.sum())
            self._body[inside, axis] = (beads + per_bead * (after - beads)) / self._unit
            self.on_water[slot] += droplet.mass * (after - before)
            droplet.velocity[slot] = after

    def _push_off(self, droplet: Droplet, span: float) -> None:
        """The vapour's push on hot beads at the edge, and theirs on the droplet."""
        if not self.repelled.any():
            return
        places = self.places
        away = places - droplet.place
        distance = np.hypot(*away.T)
        overlap = droplet.radius + 0.5 * self.given.bead_diameter - distance
        near = np.flatnonzero((overlap > 0.0) & self.repelled[self._name])
        if not near.size:
            return
        outwards = away[near] / distance[near, None]
        stiffness = EDGE_STIFFNESS * STIFFNESS * GRAVITY / self.given.bead_diameter  # 1/s2, per mass
        velocity = np.column_stack([self._unit * self._body[near, axis] for axis in (3, 5)]) - droplet.velocity
        speed = (velocity * outwards).sum(axis=1)
        push = (
            np.maximum(stiffness * overlap[near] - 2.0 * EDGE_DAMPING * math.sqrt(stiffness) * speed, 0.0)[:, None]
            * outwards
        )
        for slot, axis in ((0, 3), (1, 5)):
            self._body[near, axis] += span * push[:, slot] / self._unit
            change = -self.mass * span * push[:, slot].sum()
            self.on_water[slot] += change
            droplet.velocity[slot] += change / droplet.mass
