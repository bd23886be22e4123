"""What `fluidised.droplet_column` is given."""

import math
from dataclasses import dataclass

from ..errors import InputError
from .column_input import BedInput

CONDUCTIONS = ("bed", "gas")
CONTACTS = ("mixture", "film")
LEAST_TEMPERATURE = 423.15
"""Of the bed, K: below, water wets the beads and boils between them, which is not modelled."""
LEAST_CELLS = 5.0
"""Across the droplet."""
LONGEST_STEP = 0.5
"""In sqrt(parcel diameter/g): in it a parcel falls an eighth of its diameter, while the gas stays as it was."""


@dataclass(frozen=True, kw_only=True)
class DropletInput(BedInput):
    """A droplet of water of `droplet_diameter` (m) that is let go with its centre `release_height` (m) above a bed of
    `initial_temperature` (K). The beads of the bed are parcels of grains: `bead_diameter` is that of a parcel, `grain_diameter`
    that of its grains, which drag and heat transfer know. The slab is one parcel deep. Filled by them is `solid_fraction` of the
    bed.

    `bead_conductivity` (W/m/K) is the grains', `bond` pulls grains in contact together where there is little vapour, in weights
    of a grain, `vapour_diffusivity` m2/s. `conduction` to the droplet: that of the 'bed' at rest (Zehner, Bauer, Schluender) or
    of its 'gas' alone. `contact`: grains enter the droplet ('mixture'), or its vapour keeps hot ones out ('film').

    Raises `InputError` for what does not fit each other."""

    droplet_diameter: float
    release_height: float
    grain_diameter: float
    bead_conductivity: float
    solid_fraction: float = 0.4
    bond: float = 10.0
    vapour_diffusivity: float = 2e-5
    conduction: str = "bed"
    contact: str = "mixture"
    friction: float = 0.3
    cell_size: float = 1.5
    relative_step: float = 0.05
    drag: str = "gidaspow"
    nusselt: str = "henry"

    def __post_init__(self) -> None:
        super().__post_init__()
        d, droplet = self.bead_diameter, self.droplet_diameter
        start = self.bed_height + max(self.release_height, 0.5 * droplet)
        for key, low, high in (
            ("parcel-diameter", self.grain_diameter, 0.2 * droplet),
            ("width", 2.0 * droplet, math.inf),
            ("bed-height", max(droplet, 8.0 * d), math.inf),
            ("height", start + droplet, math.inf),
            ("release-height", 0.0, math.inf),
        ):
            value = self.bead_diameter if key == "parcel-diameter" else getattr(self, key.replace("-", "_"))
            if not low <= value <= high:
                above = f" and <= {high:g} m" if math.isfinite(high) else ""
                raise InputError(f"--{key}", value, f"must be >= {low:g}{above or ' m'}")
        if not 0.5 * d <= self.cell_size * d <= droplet / LEAST_CELLS:
            most = droplet / LEAST_CELLS / d
            raise InputError("--cell-size", self.cell_size, f"must be >= 0.5 and <= {most:.3g} parcel diameters")
        if not self.initial_temperature >= LEAST_TEMPERATURE:
            allowed = f"must be >= {LEAST_TEMPERATURE:g} K: in a colder bed water wets the beads and boils, which is not modelled"
            raise InputError("--bed-temperature", self.initial_temperature, allowed)
        if not 0.2 <= self.solid_fraction <= 0.6:
            raise InputError("--solid-fraction", self.solid_fraction, "must be >= 0.2 and <= 0.6")
        if not self.bond >= 0.0:
            raise InputError("--bond", self.bond, "must be >= 0 weights of a grain")
        if not self.relative_step <= LONGEST_STEP:
            raise InputError("--relative-step", self.relative_step, f"must be <= {LONGEST_STEP:g}")
        self.require_names(conduction=CONDUCTIONS, contact=CONTACTS)
