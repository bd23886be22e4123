r"""A cell of beads sheared between two walls that move against each other (Forgber, Radl 2016; `docs/moving-beads.md`).

The walls lie at z = 0 and z = H and move along x with -gamma H/2 and gamma H/2; x and y are periodic, without gravity. Lengths
are in bead diameters, masses in masses of a bead, time in 1/gamma. The stiffness of the springs follows from the dimensionless
shear rate gamma* = gamma d^(3/2)/sqrt(k/rho) (eq. 14): k = (6/pi)/gamma*^2 in these units. Tangential springs are as stiff as
normal ones (section 2.1 of the paper).

`rough` walls are beads fixed on the planes z = 0 and z = H, as many as find place there at random; half of each counts as part of
the bed. `flat` walls with friction slip: dense beads then move as a block, and the core is not sheared.

Beads are placed at random with smaller radii, grow while they are sheared, and are sheared on until the motion is steady. Then
their temperatures begin on the straight line between the walls, and blocks of strain are measured; the first ones are left out of
the means. Standard errors are those of the mean of the other blocks. A flux counts as steady where both halves of these blocks
agree, and the beads store little heat (its moment about the middle is what tells the mean flux from that through the walls), both
within three standard errors or 5 %. Large Peclet numbers without a film take thousands of strains.

Stirring. Where beads wander across the gradient like molecules, the convective flux is that of a conductivity
c (1 - phi) rho C gamma d^2; c is measured in the middle half of the cell, with the shear rate, the solid fraction and the
temperature gradient there. The self-diffusion coefficient over gamma d^2 is c again, found without any temperature.
"""

import hashlib
import math
from dataclasses import asdict, dataclass

from ..errors import InputError

ROUGH, FLAT = "rough", "flat"
LIMITS: dict[str, tuple[float, float]] = {
    "solid_fraction": (0.3, 0.68),
    "shear_rate": (1e-5, 0.3),
    "friction": (0.0, 2.0),
    "restitution": (0.05, 1.0),
    "distance": (6.0, 100.0),
    "width": (5.0, 100.0),
    "strains": (1.0, 1e5),
    "steps_per_contact": (8, 200),
    "peclet": (1e-3, 1e6),
    "biot": (0.0, 1e4),
}
LARGEST_NUMBER = 1_000_000


@dataclass(frozen=True)
class ShearCell:
    """What is sheared, without units; `distance` of the walls and `width` of the periodic sides in bead diameters, `strains` that
    are measured, `shear_rate` gamma*. Raises `InputError` for values out of the ranges of `LIMITS`."""

    solid_fraction: float
    shear_rate: float
    friction: float = 0.5
    peclet: tuple[float, ...] = (1.0,)
    biot: tuple[float, ...] = (0.0,)
    walls: str = ROUGH
    restitution: float = 0.9
    distance: float = 15.0
    width: float = 8.0
    strains: float = 100.0
    steps_per_contact: int = 16
    seed: int = 1

    def __post_init__(self) -> None:
        for key, (low, high) in LIMITS.items():
            values = getattr(self, key)
            for value in values if isinstance(values, tuple) else (values,):
                if not low <= value <= high:
                    raise InputError(f"--{key.replace('_', '-')}", value, f"must be >= {low:g} and <= {high:g}")
        if self.walls not in (ROUGH, FLAT):
            raise InputError("--walls", self.walls, f"must be {ROUGH} or {FLAT}")
        if not self.peclet or not self.biot:
            raise InputError("--peclet", str(self.peclet), "give at least one Peclet and one Biot number")
        if self.seed < 0:
            raise InputError("--seed", self.seed, "must be >= 0")
        if self.volume * self.solid_fraction > LARGEST_NUMBER * math.pi / 6.0:
            raise InputError("--width", self.width, f"needs more than {LARGEST_NUMBER} beads")

    @property
    def volume(self) -> float:
        """In bead diameters cubed."""
        return self.width**2 * self.distance

    @property
    def stiffness(self) -> float:
        """Of the springs, in units of the mass of a bead and the shear rate."""
        return 6.0 / math.pi / self.shear_rate**2

    @property
    def pairs(self) -> list[tuple[float, float]]:
        """(Pe, Bi) of every case."""
        return [(peclet, biot) for peclet in self.peclet for biot in self.biot]

    @property
    def identity(self) -> str:
        """A short name of these values."""
        return hashlib.sha256(repr(sorted(asdict(self).items())).encode()).hexdigest()[:16]
