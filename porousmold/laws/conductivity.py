r"""Effective conductivities of the fluid and of the beads in a bed, per total volume.

| law      | fluid                              | beads                |
|----------|------------------------------------|----------------------|
| parallel | phi (lambda_f + C_f mu_t/Pr_t)     | (1 - phi) lambda_s   |

"parallel" is the thesis's (eq. 7.11): both phases conduct as if they ran through the bed side by side. Measured beds conduct less
through beads of a good conductor, and more across a flow.

A law gives a number or, where conduction along and across the flow differ, `Anisotropic`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from .functions import Value
from .registry import Registry
from .turbulence import PRANDTL_TURBULENT


@dataclass(frozen=True)
class LocalBed:
    """The bed at a point, as a conductivity law sees it: porosity, lengths (m), the fluid's density (kg/m3), viscosity (Pa s),
    heat capacity (J/kg/K), intrinsic speed (m/s) and eddy viscosity (Pa s; 0 without turbulence), and the conductivities (W/m/K)
    of both. Numbers, arrays or UFL."""

    porosity: Value
    wall_distance: Value
    bead_diameter: Value
    density: Value
    viscosity: Value
    heat_capacity: Value
    speed: Value
    eddy_viscosity: Value
    fluid_conductivity: Value
    bead_conductivity: Value

    @property
    def peclet_number(self) -> Value:
        """rho C |u| phi d/lambda_f, on the superficial speed."""
        carried = self.density * self.heat_capacity * self.porosity * self.speed
        return carried * self.bead_diameter / self.fluid_conductivity


class Anisotropic(NamedTuple):
    """Conductivities along the flow and across it, W/m/K."""

    along: Value
    across: Value


@dataclass(frozen=True)
class ConductivityLaw:
    """Conductivities per total volume of a `LocalBed`: `fluid` and `beads` give W/m/K, numbers or `Anisotropic`."""

    fluid: Callable[[LocalBed], Value]
    beads: Callable[[LocalBed], Value]
    source: str


def eddy_conductivity(bed: LocalBed) -> Value:
    """C_f mu_t/Pr_t, W/m/K."""
    return bed.heat_capacity * bed.eddy_viscosity / PRANDTL_TURBULENT


def _parallel_fluid(bed: LocalBed) -> Value:
    return bed.porosity * (bed.fluid_conductivity + eddy_conductivity(bed))


def _parallel_beads(bed: LocalBed) -> Value:
    return (1.0 - bed.porosity) * bed.bead_conductivity


CONDUCTIVITY_LAWS: Registry[ConductivityLaw] = Registry("conductivity")
CONDUCTIVITY_LAWS.register("parallel", ConductivityLaw(_parallel_fluid, _parallel_beads, "thesis eq. 7.11"))
