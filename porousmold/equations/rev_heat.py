r"""What a varying averaging volume (REV) adds to the energy equations, with b = (phi_V - phi_A) grad V/V:

    fluid: + b.(K_f/phi grad T_f),    beads: - b.(lambda_s grad T_s)

with the conductivities of the phases' own volumes. With b the sum of both keeps b.(lambda_fe grad T_f - lambda_s grad T_s), which
is no divergence. Where one conductivity is that of the whole bed it crosses both phases and has no REV term: only what the moving
fluid mixes has one.
"""

from dataclasses import dataclass

import ufl

from ..laws.functions import Value, scaled
from .bed_heat_transfer import BedHeatTransfer
from .stabilisation import flux_density


@dataclass(frozen=True)
class RevHeat:
    """Of the bed with the coefficients of `transfer`, whose fluid enters with the `inlet_temperature` (K); `dx` measures it."""

    transfer: BedHeatTransfer
    inlet_temperature: Value
    dx: ufl.Measure

    @property
    def _weight(self) -> Value:
        return self.transfer.flow.coordinates.weight

    def outflow_of_heat(self, temperature: Value, bead_temperature: Value, test: Value, bead_test: Value) -> Value:
        """Form of what leaves fluid and beads, W against the tests."""
        of_fluid, of_beads = self._fluxes(temperature, bead_temperature)
        return self._weight * (of_beads * bead_test - of_fluid * test) * self.dx

    def heat(self, temperature: Value, bead_temperature: Value) -> Value:
        """Form (scalar, W) of the heat that the REV terms create, and of the enthalpy (against that at the inlet) of the mass
        b.(rho u) that the mass balance takes from the flow."""
        flow, state = self.transfer.flow, self.transfer.flow_state
        enthalpy = flow.fluid.fluid.heat_capacity.integral
        fluid, beads = self._fluxes(temperature, bead_temperature)
        taken = self.transfer.density * ufl.dot(flow.bed.rev_vector, state.velocity)
        mass = taken * (enthalpy(temperature) - enthalpy(self.inlet_temperature))
        return self._weight * (fluid - beads - mass) * self.dx

    def _fluxes(self, temperature: Value, bead_temperature: Value) -> tuple[Value, Value]:
        """b.(lambda_fe grad T_f) and b.(lambda_s grad T_s), W/m3."""
        bed = self.transfer.bed
        b, phi = bed.rev_vector, bed.porosity
        if bed.bead_conduction.whole_bed:
            mixed = self.transfer.dispersion(temperature)
            return ufl.dot(b, flux_density(mixed / phi, ufl.grad(temperature))), 0.0 * bead_temperature
        fluid = flux_density(self.transfer.fluid_conduction(temperature) / phi, ufl.grad(temperature))
        conductivity = scaled(bed.beads.conductivity(bead_temperature), bed.bead_conduction.factor)
        return ufl.dot(b, fluid), conductivity * ufl.dot(b, ufl.grad(bead_temperature))
