"""The beads of a column: their places, motion and contacts, by `packing.dynamics`; one bead diameter is its unit of length,
sqrt(d/g) that of time."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arrays import Floats
from ..laws.fluidisation import GRAVITY
from ..packing import dynamics
from ..packing.container import Slab
from ..packing.generator import MEAN_OVERLAP, Mixture, pack
from .column_input import BedInput

CHUNKS = 5
"""Parts of a step of the gas, after each of which the beads feel it anew."""
STEPS_PER_CONTACT = 10
RESTITUTION = 0.9


class ColumnBeads:
    """The beads, at given `positions` (n, 3; m) or packed; `temperature` (n) is theirs, K."""

    restitution = RESTITUTION
    bonds: Floats | None = None
    """By name, in weights of a bead: the smaller one of two beads in contact pulls them together."""

    def __init__(self, given: BedInput, positions: Floats | None = None) -> None:
        self.given, d = given, given.bead_diameter
        slab = Slab(given.width, given.depth)
        if positions is None:
            positions = pack(slab, Mixture((d,)), bed_height=given.bed_height, seed=given.seed).positions
            positions = positions[positions[:, 2] < given.bed_height]
        count = len(positions)
        self._body = np.zeros((count, 9))
        self._body[:, :3] = positions / d
        self._size = np.column_stack((np.full(count, 0.5), np.ones(count)))
        self._name, self._load = np.arange(count), np.zeros((count, 6))
        self.temperature = np.full(count, given.initial_temperature)
        planes = np.array(slab.planes) * (1.0, 1.0, 1.0, 1.0 / d)
        self._walls = (planes, 0.0, np.array(slab.period) / d, np.zeros((len(planes) + 1, 3)))
        self._wall_spring = np.zeros((count, len(planes) + 1, 3))
        self._pairs = dynamics.no_pairs(count)
        self._slack = 0.0
        stiffness = self._stiffness(count)
        self._material = dynamics.material_of(stiffness, self.restitution, given.friction)
        contact = dynamics.contact_time(stiffness, self.restitution)
        chunk = given.relative_step / CHUNKS
        self._contact_steps = math.ceil(chunk / (contact / STEPS_PER_CONTACT))
        self._contact_step = chunk / self._contact_steps
        self.gravity = -GRAVITY * (1.0 - given.density / given.bead_density)
        self._unit = math.sqrt(GRAVITY * d)
        self._pushed = np.zeros((count, 2))  # by name: a bed at rest stays at rest

    def _stiffness(self, count: int) -> float:
        """Of a contact, in weights of a bead per diameter: a bed of so many beads is hardly compressed by its weight."""
        given, d = self.given, self.given.bead_diameter
        deep = count * math.pi / 6.0 * d / given.width * d / given.depth / 0.6  # in bead diameters
        return max(3.0 * deep / (5.5 * 2.0 * MEAN_OVERLAP), 1e4)

    def __len__(self) -> int:
        return len(self._body)

    @property
    def places(self) -> Floats:
        """From the middle between the walls, and up (n, 2), m."""
        return self.given.bead_diameter * self._body[:, [0, 2]]

    @property
    def velocity(self) -> list[Floats]:
        """Upwards and across, m/s."""
        return [self._unit * self._body[:, 3 + axis] for axis in (2, 0)]

    @property
    def acceleration(self) -> list[Floats]:
        """By weight less buoyancy and by contacts in the last step, upwards and across, m/s2; 0 before the first one."""
        return [self._pushed[self._name, axis] for axis in (0, 1)]

    @property
    def fastest(self) -> float:
        """The largest speed, m/s."""
        return float(self._unit * np.sqrt((self._body[:, 3:6] ** 2).sum(axis=1).max()))

    def move(self, gas: list[Floats], push: list[Floats], rate: Floats) -> None:
        """Over a step of the gas, with its velocity at the beads (m/s), what else accelerates these (m/s2), both up and across,
        and the `rate` (1/s) at which its drag does."""
        names = self._name.copy()
        self._pushed[:] = 0.0
        by_name = np.empty((len(names), 5))
        by_name[names] = np.column_stack((*gas, *push, rate))
        span = self.given.time_step / CHUNKS
        weight = np.array([0.0, 0.0, self.gravity / GRAVITY])
        for _ in range(CHUNKS):  # half of the push before the contacts, half after: beads at rest end at rest
            self._feel(by_name, 0.5 * span)
            left = self._contact_steps
            while left > 0:
                if self._slack <= 0.0:
                    self._renew_pairs()
                before = self._body[:, [5, 3]]
                bonds = None if self.bonds is None else self.bonds[self._name]
                done, self._slack = dynamics.advance(
                    self._body, self._load, self._size, self._pairs, self._walls, self._wall_spring, self._material,
                    weight, self._contact_step, left, self._slack, None, bonds)  # fmt: skip
                self._pushed[self._name] += self._unit / self.given.time_step * (self._body[:, [5, 3]] - before)
                left -= done
            self._feel(by_name, 0.5 * span)

    def _feel(self, of_gas: Floats, span: float) -> None:
        """The gas over a span (s), implicit in its drag; `of_gas` is by name: its velocity, other acceleration, rate of drag."""
        along, across, push_along, push_across, drag = of_gas[self._name].T
        for axis, velocity, acceleration in ((5, along, push_along), (3, across, push_across), (4, 0.0, 0.0)):
            now = self._unit * self._body[:, axis]
            self._body[:, axis] = (now + span * (acceleration + drag * velocity)) / (1.0 + span * drag) / self._unit

    def _renew_pairs(self) -> None:
        fastest = math.sqrt((self._body[:, 3:6] ** 2).sum(axis=1).max())
        skin = min(max(0.06, 60.0 * self._contact_step * fastest), 0.35)
        before = self._name.copy()
        self._pairs = dynamics.renew_pairs(
            self._body, self._size, self._name, self._wall_spring, self._pairs, skin, self._walls[2], self._material[1]
        )
        place = np.empty_like(before)
        place[before] = np.arange(len(before))
        self.temperature = self.temperature[place[self._name]]
        self._slack = 0.5 * skin

    def save(self) -> dict[str, Any]:
        """Everything that the motion goes on from."""
        state = {"body": self._body, "name": self._name, "load": self._load, "wall_spring": self._wall_spring}
        state |= {"bead_temperature": self.temperature, "slack": np.array(self._slack), "pushed": self._pushed}
        return state | {f"pairs_{number}": part for number, part in enumerate(self._pairs)}

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Go on from what `save` gave."""
        self._body, self._name, self._load = saved["body"], saved["name"], saved["load"]
        self._wall_spring, self._pushed = saved["wall_spring"], saved["pushed"]
        self.temperature, self._slack = saved["bead_temperature"], float(saved["slack"])
        start, partner, dashpot, spring = (saved[f"pairs_{number}"] for number in range(len(self._pairs)))
        self._pairs = start, partner, dashpot, spring
