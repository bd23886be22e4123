"""What `fluidised.column` is given."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..arrays import Floats
from ..errors import InputError
from ..laws.fluidisation import GRAVITY, SUSPENSION_DRAGS, archimedes_number
from ..laws.nusselt import NUSSELT_CORRELATIONS, prandtl_number
from ..packing.generator import SMALLEST_PERIOD


@dataclass(frozen=True, kw_only=True)
class BedInput:
    """A bed of beads one by one, and the gas between them, SI. The bed at rest is `bed_height` high in a slab of `width` and
    `depth`, in a column of `height`. `density`, `viscosity`, `heat_capacity` and `conductivity` are the gas's, `relative_step`
    its step in sqrt(d/g), `cell_size` its cells in bead diameters; `drag` and `nusselt` are names of
    `laws.fluidisation.SUSPENSION_DRAGS` and of `laws.nusselt.NUSSELT_CORRELATIONS`.

    Raises `InputError` for names that are unknown, and beads that float."""

    width: float
    depth: float
    height: float
    bed_height: float
    bead_diameter: float
    density: float
    viscosity: float
    heat_capacity: float
    conductivity: float
    bead_density: float
    bead_heat_capacity: float
    initial_temperature: float = 293.15
    friction: float = 0.3
    cell_size: float = 3.5
    seed: int = 1
    relative_step: float = 0.05
    drag: str = "gidaspow"
    nusselt: str = "wakao"

    def __post_init__(self) -> None:
        self.require_names(drag=SUSPENSION_DRAGS, nusselt=NUSSELT_CORRELATIONS)
        archimedes_number(self.bead_diameter, self.density, self.bead_density, self.viscosity)

    def require_names(self, **known: Iterable[str]) -> None:
        """Raise `InputError` for a field whose name is not among those known for it."""
        for key, names in known.items():
            if (name := getattr(self, key)) not in names:
                raise InputError(f"--{key}", name, f"must be one of {', '.join(names)}")

    def film_coefficient(self, diameter: float, mass_flux: Floats, porosity: Floats) -> Floats:
        """Between the gas and beads of a diameter (m), W/m2/K, at its mass flux past them (kg/m2/s) and a porosity."""
        reynolds = mass_flux * diameter / self.viscosity
        prandtl = prandtl_number(self.viscosity, self.heat_capacity, self.conductivity)
        nusselt = np.asarray(NUSSELT_CORRELATIONS[self.nusselt](reynolds, prandtl, porosity))
        return nusselt * self.conductivity / diameter

    @property
    def is_one_layer(self) -> bool:
        """Whether beads are one layer, which moves in its plane."""
        return self.depth <= self.bead_diameter

    @property
    def relative_diameters(self) -> Floats:
        """Those of a mixture, each of as many beads, over the largest."""
        return np.ones(1)

    @property
    def bead_mass(self) -> float:
        """Of the largest bead, kg."""
        return self.bead_density * math.pi / 6.0 * self.bead_diameter**3

    @property
    def time_step(self) -> float:
        """Of the gas, s."""
        return self.relative_step * math.sqrt(self.bead_diameter / GRAVITY)


SIZES, LEAST_RATIO = 9, 0.4
"""Diameters of a mixture, and the least ratio of its smallest to its largest."""


@dataclass(frozen=True, kw_only=True)
class ColumnInput(BedInput):
    """A bed that gas enters from below with the superficial `velocity` (m/s) and `inlet_temperature` (K), but for the
    `blocked_width` (m) in the middle.

    Diameters are spread evenly between `smallest_diameter` (default: that of all) and `bead_diameter`; where the slab is no
    deeper than a bead, beads are one layer that moves in its plane. Heat goes from the gas to the walls of `wall_temperature`
    (K): those at the sides by `wall_coefficient` (W/m2/K), front and rear by `depth_coefficient` (W/m3/K); these two resist the
    gas by `depth_drag` (kg/m3/s) times its velocity (Henry et al., eq. 14).

    Raises `InputError` for lengths that do not fit each other."""

    velocity: float
    inlet_temperature: float = 353.15
    blocked_width: float = 0.0
    smallest_diameter: float | None = None
    wall_temperature: float = 293.15
    wall_coefficient: float = 0.0
    depth_coefficient: float = 0.0
    depth_drag: float = 0.0

    def __post_init__(self) -> None:
        d = self.bead_diameter
        for key, least in (("width", 8.0 * d), ("height", 1.2 * self.bed_height), ("bed_height", 4.0 * d)):
            if getattr(self, key) < least:
                raise InputError(f"--{key.replace('_', '-')}", getattr(self, key), f"must be >= {least:g} m")
        if d < self.depth < SMALLEST_PERIOD * d:
            allowed = (
                f"must be <= {d:g} m (one layer of beads) or >= {SMALLEST_PERIOD * d:g} m ({SMALLEST_PERIOD:g} beads)"
            )
            raise InputError("--depth", self.depth, allowed)
        if not 2.0 <= self.cell_size <= 10.0:
            raise InputError("--cell-size", self.cell_size, "must be >= 2 and <= 10 bead diameters")
        if not 0.0 <= self.blocked_width < 0.9 * self.width:
            raise InputError("--blocked-width", self.blocked_width, f"must be >= 0 and < {0.9 * self.width:g} m")
        if not 0.0 <= self.friction <= 2.0:
            raise InputError("--friction", self.friction, "must be >= 0 and <= 2")
        for key, unit in (
            ("velocity", "m/s"),
            ("wall_coefficient", "W/m2/K"),
            ("depth_coefficient", "W/m3/K"),
            ("depth_drag", "kg/m3/s"),
        ):
            if not getattr(self, key) >= 0.0:
                raise InputError(f"--{key.replace('_', '-')}", getattr(self, key), f"must be >= 0 {unit}")
        if not LEAST_RATIO * d <= self.smallest <= d:
            allowed = f"must be >= {LEAST_RATIO * d:g} and <= {d:g} m"
            raise InputError("--smallest-diameter", self.smallest_diameter, allowed)
        if not self.depth >= self.smallest:
            raise InputError("--depth", self.depth, f"must be >= {self.smallest:g} m, the diameter of a bead")
        super().__post_init__()

    @property
    def smallest(self) -> float:
        """Diameter of the smallest bead, m."""
        return self.bead_diameter if self.smallest_diameter is None else self.smallest_diameter

    @property
    def relative_diameters(self) -> Floats:
        """Those of a mixture, each of as many beads, over the largest."""
        low = self.smallest / self.bead_diameter
        return np.ones(1) if low == 1.0 else np.linspace(low, 1.0, SIZES)
