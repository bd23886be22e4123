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
LATTICE = 1.12
"""Distance of the beads of one layer, in diameters, before they fall."""
SETTLED = 0.867
"""Part of the area that circles cover which have fallen: how many beads a bed takes follows from it."""
SETTLING = 0.25
"""s of falling with damping, at `DAMPING` (1/s), after which beads are at rest."""
DAMPING = 10.0


class ColumnBeads:
    """The beads at `positions` (n, 3; m), of `diameters` over the largest (n; default 1); `temperature` (n) is theirs, K."""

    restitution = RESTITUTION
    bonds: Floats | None = None
    """By name, in weights of a bead: the smaller one of two beads in contact pulls them together."""

    def __init__(self, given: BedInput, positions: Floats, diameters: Floats | None = None) -> None:
        self.given, d = given, given.bead_diameter
        slab, count = Slab(given.width, given.depth), len(positions)
        diameters = np.ones(count) if diameters is None else diameters
        self._body = np.zeros((count, 9))
        self._body[:, :3] = positions / d
        self._size = np.column_stack((0.5 * diameters, diameters**3))
        self._name, self._load = np.arange(count), np.zeros((count, 6))
        self.temperature = np.full(count, given.initial_temperature)
        planes = np.array(slab.planes) * (1.0, 1.0, 1.0, 1.0 / d)
        self._walls = (planes, 0.0, np.array(slab.period) / d, np.zeros((len(planes) + 1, 3)))
        self._wall_spring = np.zeros((count, len(planes) + 1, 3))
        self._pairs = dynamics.no_pairs(count)
        self._slack = 0.0
        stiffness = self._stiffness(count)
        self._material = dynamics.material_of(stiffness, self.restitution, given.friction)
        contact = dynamics.contact_time(stiffness, self.restitution, float(self._size[:, 1].min()))
        chunk = given.relative_step / CHUNKS
        self._contact_steps = math.ceil(chunk / (contact / STEPS_PER_CONTACT))
        self._contact_step = chunk / self._contact_steps
        self.gravity = -GRAVITY * (1.0 - given.density / given.bead_density)
        self._unit = math.sqrt(GRAVITY * d)
        self._pushed = np.zeros((count, 2))  # by name: a bed at rest stays at rest

    def come_to_rest(self) -> None:
        """Fall, with damping."""
        still = np.zeros(len(self))
        for _ in range(math.ceil(SETTLING / self.given.time_step)):
            self.move([still, still], [still, still], np.full(len(self), DAMPING))

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
    def volumes(self) -> Floats:
        """Of the beads, m3."""
        return math.pi / 6.0 * self.given.bead_diameter**3 * self._size[:, 1]

    @property
    def masses(self) -> Floats:
        """Of the beads, kg."""
        return self.given.bead_density * self.volumes

    @property
    def surfaces(self) -> Floats:
        """Of the beads, m2."""
        return math.pi * (2.0 * self.given.bead_diameter * self._size[:, 0]) ** 2

    @property
    def sauter_diameter(self) -> float:
        """Of beads that have the volume per surface of all, m."""
        return float(6.0 * self.volumes.sum() / self.surfaces.sum())

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
                beads = dynamics.Beads(self._body, self._load, self._size, self._wall_spring)
                steps = dynamics.Span(self._contact_step, left, self._slack)
                done, self._slack = dynamics.advance(
                    beads, self._pairs, self._walls, self._material, weight, steps, None, bonds
                )
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
        state |= {
            "pushed": self._pushed,
            "size": self._size,
            "bead_temperature": self.temperature,
            "slack": np.array(self._slack),
        }
        return state | {f"pairs_{number}": part for number, part in enumerate(self._pairs)}

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Go on from what `save` gave."""
        self._body, self._name, self._load, self._size = (saved[part] for part in ("body", "name", "load", "size"))
        self._wall_spring, self._pushed = saved["wall_spring"], saved["pushed"]
        self.temperature, self._slack = saved["bead_temperature"], float(saved["slack"])
        start, partner, dashpot, spring = (saved[f"pairs_{number}"] for number in range(len(self._pairs)))
        self._pairs = start, partner, dashpot, spring


def bed_at_rest(given: BedInput) -> ColumnBeads:
    """A bed that has come to rest: packed, or one layer that has fallen."""
    if given.is_one_layer:
        beads = ColumnBeads(given, *lattice(given))
        beads.come_to_rest()
        return ColumnBeads(given, given.bead_diameter * beads._body[:, :3], 2.0 * beads._size[:, 0])
    sizes = tuple(given.bead_diameter * given.relative_diameters)
    mixture = Mixture(sizes, (1.0,) * len(sizes), "number")
    packing = pack(Slab(given.width, given.depth), mixture, bed_height=given.bed_height, seed=given.seed)
    below = packing.positions[:, 2] < given.bed_height
    return ColumnBeads(given, packing.positions[below], packing.diameters[below] / given.bead_diameter)


def lattice(given: BedInput) -> tuple[Floats, Floats]:
    """Places (n, 3; m) of one layer of beads, disturbed by chance, from which they fall, and their diameters over the largest.

    The same seed gives the same ones."""
    rng, d, sizes = np.random.default_rng(given.seed), given.bead_diameter, given.relative_diameters
    columns = int(given.width / (LATTICE * d))
    circle = 0.25 * math.pi * d**2 * float(np.mean(sizes**2))
    rows = math.ceil(SETTLED * given.width * given.bed_height / (circle * columns))
    spacing = given.width / columns
    row, column = (numbers.ravel() for numbers in np.indices((rows, columns)))
    places = np.zeros((rows * columns, 3))
    places[:, 0] = (column + 0.5 + np.where(row % 2, 0.25, -0.25)) * spacing - 0.5 * given.width
    places[:, 2] = (row + 0.5) * LATTICE * d
    places[:, [0, 2]] += 0.05 * d * rng.uniform(-1.0, 1.0, (len(places), 2))
    room = 0.5 * (given.width - d)
    places[:, 0] = np.clip(places[:, 0], -room, room)
    return places, rng.choice(sizes, len(places))
