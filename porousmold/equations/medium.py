"""Properties of bed, beads and fluid for the equations, as UFL expressions and property laws."""

from dataclasses import dataclass

import ufl

from ..laws.conductivity import BEAD_CONDUCTION_LAWS, DISPERSION_LAWS, BeadConduction, Dispersion
from ..laws.drag import DragLaw
from ..laws.functions import Value
from ..laws.materials import Fluid, Solid
from ..laws.nusselt import NusseltCorrelation, bead_reynolds_number


@dataclass(frozen=True)
class Bed:
    """The packing: porosity phi_V, the REV vector b of section 2.1 (None: terms absent), beads and their laws.

    `bulk_porosity` is that of the core, which laws of conduction and dispersion ask for; `bead_velocity` that of the beads along
    x[0] (m/s; None at rest)."""

    porosity: ufl.core.expr.Expr
    bulk_porosity: Value
    wall_distance: ufl.core.expr.Expr
    bead_diameter: Value
    beads: Solid
    drag: DragLaw
    nusselt: NusseltCorrelation
    rev_vector: ufl.core.expr.Expr | None = None
    bead_conduction: BeadConduction = BEAD_CONDUCTION_LAWS["bulk"]
    dispersion: Dispersion = DISPERSION_LAWS["none"]
    emissivity: Value = 0.0
    bead_velocity: Value = None

    def reynolds_number(self, density: Value, speed: Value, viscosity: Value) -> Value:
        """Local superficial bead Reynolds number (eq. 6.12)."""
        return bead_reynolds_number(self.porosity, density, speed, self.bead_diameter, viscosity)


@dataclass(frozen=True)
class FluidState:
    """The fluid's laws and the absolute pressure that belongs to gauge pressure 0 (Pa)."""

    fluid: Fluid
    reference_pressure: Value

    def density(self, gauge_pressure: Value, temperature: Value) -> Value:
        """Density in kg/m3 at a gauge pressure (Pa) and temperature (K)."""
        return self.fluid.density(gauge_pressure + self.reference_pressure, temperature)


def rev_vector(porosity_difference: Value, wall_distance: Value, largest_diameter: Value) -> Value:
    r"""b = (phi_V - phi_A) grad V/V with the REV's diameter D = min(2 y, D_max) (thesis eq. 5.5).

    grad V/V = 3 grad y/y where 2 y < D_max, else 0. `porosity_difference` is phi_V - phi_A.
    """
    varying = ufl.conditional(ufl.lt(2.0 * wall_distance, largest_diameter), 3.0 / wall_distance, 0.0)
    return porosity_difference * varying * ufl.grad(wall_distance)
