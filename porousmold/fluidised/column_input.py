"""What `fluidised.column` is given."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..arrays import Floats
from ..errors import InputError
from ..laws.fluidisation import GRAVITY, SUSPENSION_DRAGS, archimedes_number
from ..laws.nusselt import NUSSELT_CORRELATIONS, prandtl_number


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
    def bead_mass(self) -> float:
        """Of a bead, kg."""
        return self.bead_density * math.pi / 6.0 * self.bead_diameter**3

    @property
    def time_step(self) -> float:
        """Of the gas, s."""
        return self.relative_step * math.sqrt(self.bead_diameter / GRAVITY)


@dataclass(frozen=True, kw_only=True)
class ColumnInput(BedInput):
    """A bed that gas enters from below with the superficial `velocity` (m/s) and `inlet_temperature` (K), but for the
    `blocked_width` (m) in the middle.

    Raises `InputError` for lengths that do not fit each other."""

    velocity: float
    inlet_temperature: float = 353.15
    blocked_width: float = 0.0

    def __post_init__(self) -> None:
        d = self.bead_diameter
        for key, least in (("width", 8.0 * d), ("height", 1.2 * self.bed_height), ("bed_height", 4.0 * d)):
            if getattr(self, key) < least:
                raise InputError(f"--{key.replace('_', '-')}", getattr(self, key), f"must be >= {least:g} m")
        if not 2.0 <= self.cell_size <= 10.0:
            raise InputError("--cell-size", self.cell_size, "must be >= 2 and <= 10 bead diameters")
        if not 0.0 <= self.blocked_width < 0.9 * self.width:
            raise InputError("--blocked-width", self.blocked_width, f"must be >= 0 and < {0.9 * self.width:g} m")
        if not self.velocity >= 0.0:
            raise InputError("--velocity", self.velocity, "must be >= 0 m/s")
        super().__post_init__()
