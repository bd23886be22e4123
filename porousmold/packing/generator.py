"""Beads poured into a container: placed at random without touching, they fall and come to rest (`dynamics`).

Rest means: kinetic energy per bead below 1e-6 m g d, and mean residual force below 1e-2 m g, with d and m the mean
diameter and the mass of such a bead. The springs are as stiff as a mean overlap of about 0.09 % of d needs under the
bed's own weight: softer beds are denser than beds of hard beads (0.65 % costs 0.02 in porosity), stiffer ones take
longer. The start at a solid fraction of 0.30 keeps the layers at the wall sharp.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from scipy.optimize import root_scalar

from ..arrays import Floats
from ..errors import InputError, SolveError
from . import dynamics
from .container import Container
from .packing import Packing

LARGEST_KINETIC_ENERGY, LARGEST_RESIDUAL_FORCE = 1e-6, 1e-2
START_SOLID_FRACTION = 0.30
MEAN_OVERLAP, CONTACTS_PER_BEAD = 1e-3, 5.5
RESTITUTION, SPIN_DECAY = 0.5, 10.0
# below 5 the steps are unstable where a bead has many contacts
STEPS_PER_CONTACT = 5.5
DEFAULT_FRICTION, LARGEST_FRICTION = 0.1, 1.0
# beads without any friction in a narrow cylinder slide about for ever
SMALLEST_TUNED_FRICTION = 0.003
VOID_FRACTION_TOLERANCE = 1e-3
# beds fill between so much and so much; mixtures more than equal beads
LOOSE_SOLID_FRACTION, DENSE_SOLID_FRACTION, DENSE_MIXTURE = 0.45, 0.64, 0.78
SMALLEST_DIAMETER, LARGEST_NUMBER = 1e-6, 10_000_000
LARGEST_TRIES = 200_000
# in sqrt(d/g), after the time that the topmost bead falls
LONGEST_SETTLING = 100.0
STEPS_BETWEEN_CHECKS = 200
# in largest diameters: an averaging sphere of 5.5 d must not meet both images of a bead
SMALLEST_PERIOD = 7.0


Progress: TypeAlias = Callable[[float, float, float], None]


@dataclass(frozen=True)
class Mixture:
    """Bead sizes: `diameters` in m and the share of each, by mass or by number (shares need not add up to 1).

    Beads are of one density. Raises `InputError` for sizes or shares that cannot be.
    """

    diameters: tuple[float, ...]
    shares: tuple[float, ...] = (1.0,)
    by: str = "mass"

    def __post_init__(self) -> None:
        if not self.diameters or len(self.diameters) != len(self.shares):
            raise InputError("mixture", str(self.diameters), "must have one share for each of its diameters")
        for diameter in self.diameters:
            if not SMALLEST_DIAMETER <= diameter < 1e3:
                raise InputError("bead_diameter", diameter, f"must be >= {SMALLEST_DIAMETER:g} and < 1000 m")
        for share in self.shares:
            if not 0.0 < share < math.inf:
                raise InputError("share", share, "must be > 0")
        if self.by not in ("mass", "number"):
            raise InputError("fractions", self.by, "must be 'mass' or 'number'")
        if max(self.diameters) > 5.0 * min(self.diameters):
            raise InputError("mixture", str(self.diameters), "must have diameters within a factor of 5")

    @property
    def _number_shares(self) -> Floats:
        numbers = np.array(self.shares, float) / max(self.shares)
        if self.by == "mass":
            numbers /= np.array(self.diameters) ** 3
        return numbers / numbers.sum()

    @property
    def mean_bead_volume(self) -> float:
        """Mean over the number of beads (m³)."""
        return float(np.pi / 6.0 * (self._number_shares * np.array(self.diameters) ** 3).sum())

    def draw(self, number: int) -> Floats:
        """Diameters (number) in m, largest first; counts by largest remainder, so that they are the nearest whole ones."""
        exact = self._number_shares * number
        counts = np.floor(exact).astype(int)
        counts[np.argsort(counts - exact, kind="stable")[: number - counts.sum()]] += 1
        if not counts.all() and number > 1:
            raise InputError(
                "mixture", str(self.diameters), f"must have a bead of each size: of {number}, one size gets none"
            )
        return np.sort(np.repeat(self.diameters, counts))[::-1].copy()


def pack(
    container: Container,
    mixture: Mixture,
    *,
    beads: int | None = None,
    bed_height: float | None = None,
    void_fraction: float | None = None,
    friction: float | None = None,
    seed: int = 1,
    progress: Progress | None = None,
) -> Packing:
    """A packing at rest of a `Mixture` in a container (`packing.container`), as `Packing`.

    beads: how many; without it as many as fill the container a little above `bed_height` (m). void_fraction: reached to
    0.001 by a search over the friction coefficient (of beads and walls alike), each trial being a packing; it is
    measured between the floor and bed_height, or the levelled height where none is given. friction: default 0.1.
    progress(time, kinetic_energy, residual_force) is called now and then, in sqrt(d/g), m g d and m g.

    Raises `InputError` for a container too small, no beads, or a void fraction out of reach; `SolveError` for a bed that
    does not come to rest.
    """
    number = _checked(container, mixture, beads, bed_height, void_fraction, friction, seed)
    diameters = mixture.draw(number)
    settings = {"bed_height": bed_height, "seed": seed}
    if void_fraction is None:
        return _poured(container, diameters, DEFAULT_FRICTION if friction is None else friction, settings, progress)

    trials: dict[float, Packing] = {}
    aim = void_fraction

    def excess(root_of_friction: float) -> float:
        friction = root_of_friction**2
        if friction not in trials:
            trials[friction] = _poured(container, diameters, friction, settings, progress)
        found = trials[friction].void_fraction(bed_height) - aim
        return 0.0 if abs(found) <= VOID_FRACTION_TOLERANCE else found

    # the void fraction rises steeply at small friction and saturates: the square root makes it nearly straight
    bracket = math.sqrt(SMALLEST_TUNED_FRICTION), math.sqrt(LARGEST_FRICTION)
    low, high = (excess(end) for end in bracket)
    if low > 0.0 or high < 0.0:
        raise InputError("void_fraction", void_fraction,
                         f"is out of reach: friction {SMALLEST_TUNED_FRICTION:g} to {LARGEST_FRICTION:g} gives "
                         f"{void_fraction + low:.3f} to {void_fraction + high:.3f}")  # fmt: skip
    if low < 0.0 < high:
        root_scalar(excess, bracket=bracket, xtol=1e-4)
    nearest = min(trials.values(), key=lambda packing: abs(packing.void_fraction(bed_height) - aim))
    if abs(nearest.void_fraction(bed_height) - void_fraction) > VOID_FRACTION_TOLERANCE:
        raise SolveError("packing", 0.0, f"void fraction {void_fraction} not met to {VOID_FRACTION_TOLERANCE}",
                         "more beads: small beds scatter")  # fmt: skip
    return nearest


def _checked(
    container: Container,
    mixture: Mixture,
    beads: int | None,
    bed_height: float | None,
    void_fraction: float | None,
    friction: float | None,
    seed: int,
) -> int:
    largest = max(mixture.diameters)
    if largest >= container.smallest_width:
        raise InputError(
            "bead_diameter", largest, f"must be < {container.smallest_width:g} m, the width of the container"
        )
    for period in container.period:
        if 0.0 < period < SMALLEST_PERIOD * largest:
            raise InputError(
                "width",
                period,
                f"must be >= {SMALLEST_PERIOD * largest:g} m: {SMALLEST_PERIOD:g} beads, for periodic sides",
            )
    if bed_height is not None and not largest <= bed_height < 1e3:
        raise InputError("bed_height", bed_height, f"must be >= {largest:g} (one bead) and < 1000 m")
    if void_fraction is not None and not 0.0 < void_fraction < 1.0:
        raise InputError("void_fraction", void_fraction, "must be > 0 and < 1")
    if void_fraction is not None and friction is not None:
        raise InputError("friction", friction, "has no place beside void_fraction, which it is tuned for")
    if friction is not None and not 0.0 <= friction <= LARGEST_FRICTION:
        raise InputError("friction", friction, f"must be >= 0 and <= {LARGEST_FRICTION:g}")
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise InputError("seed", seed, "must be a whole number >= 0")
    if beads is None:
        if bed_height is None:
            raise InputError("beads", None, "is missing: give a number of beads or a bed_height")
        fraction = DENSE_SOLID_FRACTION if len(mixture.diameters) == 1 else DENSE_MIXTURE
        number = math.ceil(fraction * container.cross_section * (bed_height + largest) / mixture.mean_bead_volume)
        if number > LARGEST_NUMBER:
            raise InputError("bed_height", bed_height, f"needs {number:.1e} beads; {LARGEST_NUMBER} are the most")
        return number
    if isinstance(beads, bool) or not isinstance(beads, int) or not 1 <= beads <= LARGEST_NUMBER:
        raise InputError("beads", beads, f"must be a whole number from 1 to {LARGEST_NUMBER}")
    if bed_height is not None:
        reached = beads * mixture.mean_bead_volume / (LOOSE_SOLID_FRACTION * container.cross_section)
        if bed_height > reached:
            raise InputError("bed_height", bed_height, f"must be < {reached:.3g} m, which {beads} beads fill at most")
    return beads


def _poured(
    container: Container, diameters: Floats, friction: float, settings: dict[str, Any], progress: Progress | None
) -> Packing:
    """One packing: placed, dropped, at rest."""
    unit = diameters.mean()
    count = diameters.size
    size = np.column_stack((0.5 * diameters / unit, (diameters / unit) ** 3))
    area, period = container.cross_section / unit**2, np.array(container.period) / unit
    planes = np.array(container.planes) * (1.0, 1.0, 1.0, 1.0 / unit)
    walls = (planes, container.radius / unit, period, np.zeros((len(planes) + 1, 3)))
    gravity = np.array([0.0, 0.0, -1.0])
    solid = np.pi / 6.0 * size[:, 1].sum()

    body, top = _placed(container, size, solid / area, settings["seed"], unit)
    name, load = np.arange(count), np.zeros((count, 6))
    wall_spring = np.zeros((count, len(planes) + 1, 3))
    pairs = dynamics.no_pairs(count)

    # a bed of height H carries its own weight, H/2 in the mean, on CONTACTS_PER_BEAD contacts: F = 6 m g (H/2) / (d Z)
    height = solid / (0.6 * area)
    # on beads of size 1; forces grow with d^2, so that beads larger than the mean need stiffer springs
    stiffness = 3.0 * max(height, 1.0) / (CONTACTS_PER_BEAD * MEAN_OVERLAP) * 2.0 * size[:, 0].max()
    material = dynamics.material_of(stiffness, RESTITUTION, friction, spin_decay=SPIN_DECAY)
    dt = dynamics.contact_time(stiffness, RESTITUTION, size[:, 1].min()) / STEPS_PER_CONTACT
    fall = math.sqrt(2.0 * top)

    time = 0.0
    while True:
        fastest = math.sqrt((body[:, 3:6] ** 2).sum(axis=1).max())
        # long lists where beads fall, short ones where they rest: both cost time, as renewals and as idle pairs
        skin = min(max(0.04, 40.0 * dt * fastest), 0.35)
        pairs = dynamics.renew_pairs(body, size, name, wall_spring, pairs, skin, period, material[1])
        span = dynamics.Span(dt, STEPS_BETWEEN_CHECKS, 0.5 * skin)
        steps, _ = dynamics.advance(
            dynamics.Beads(body, load, size, wall_spring), pairs, walls, material, gravity, span
        )
        time += dt * steps
        energy = 0.5 * (size[:, 1] * (body[:, 3:6] ** 2).sum(axis=1)).mean()
        residual = np.linalg.norm(load[:, :3], axis=1).mean()
        if progress is not None:
            progress(time, energy, residual)
        if not np.isfinite(energy) or time > fall + LONGEST_SETTLING:
            raise SolveError("packing", time * math.sqrt(unit / 9.81),
                             f"not at rest: kinetic energy {energy:.1e} m g d, residual force {residual:.1e} m g per bead",
                             "another seed, or a friction above 0")  # fmt: skip
        if time > 0.5 * fall and energy < LARGEST_KINETIC_ENERGY and residual < LARGEST_RESIDUAL_FORCE:
            break

    back = np.argsort(name)
    made = {**{key: value for key, value in settings.items() if value is not None}, "friction": friction,
            "stiffness": stiffness, "restitution": RESTITUTION, "kinetic_energy": energy, "residual_force": residual}  # fmt: skip
    return Packing(body[back, :3] * unit, 2.0 * size[back, 0] * unit, container, made)


def _placed(container: Container, size: Floats, solid_height: float, seed: int, unit: float) -> tuple[Floats, float]:
    """Bodies (n, 9) at rest without contact, and the height of their column."""
    body = np.zeros((len(size), 9))
    place, radius = np.empty((len(size), 3)), size[:, 0].copy()
    half_x, half_y = container.half_widths / unit
    fraction = START_SOLID_FRACTION
    while fraction > 0.02:
        top = max(solid_height / fraction, 2.0 * radius.max())
        low, high = np.array([-half_x, -half_y, 0.0]), np.array([half_x, half_y, top])
        period = np.array(container.period) / unit
        if dynamics.place(np.random.default_rng(seed), place, radius, low, high, container.radius / unit, period,
                          LARGEST_TRIES) == len(size):  # fmt: skip
            body[:, :3] = place
            return body, top
        fraction *= 0.8  # narrow containers hold fewer loose beads per volume
    raise InputError(
        "bead_diameter", float(2.0 * radius.max() * unit), f"is too large for {container}: beads find no place"
    )
