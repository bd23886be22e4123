r"""The heat balance's integrals: what the fluid brings and displaces, and what fluid, beads and wall keep.

brought:    int over the outlet  (rho phi u.n) [h(T_in) - h(T)]        of what leaves, also through the inlet
displaced:  int over the bed     q [h(T) - h(T_0)]                     of fluid that expands out of its place, q its source
kept:       int over the bed     (1-phi) [H_s(T_s) - H_s(T_s0)]        and of the wall (`equations.wall`)
"""

from dataclasses import dataclass

from ..laws.functions import Value
from .energy import EnergyEquations
from .wall import volumetric_heat


@dataclass(frozen=True)
class HeatBudget:
    """Of the energy equations."""

    equations: EnergyEquations

    def _enthalpy(self, temperature: Value) -> Value:
        """h(T) of the fluid, J/kg."""
        return self.equations.flow.fluid.fluid.heat_capacity.integral(temperature)

    def brought_by_fluid(self, temperature: Value) -> Value:
        """Form (scalar, W) of the heat that the fluid leaves behind: what it lacks against T_in at the outlet, and where it
        turns back through the inlet; of what leaves beyond what comes in, as the fluid expands, less what that would have brought
        beyond the initial temperature."""
        equations, weight = self.equations, self.equations.coordinates.weight
        entering, source = self._enthalpy(equations.inlet_temperature), equations.flow.source_of_flux
        lost = entering - self._enthalpy(temperature)
        turned_back = equations.entering_mass_flux - equations.inward_mass_flux
        form = weight * lost * equations.outward_mass_flux * equations.outlet
        form += weight * lost * turned_back * equations.inlet
        if source is None:
            return form
        beyond = entering - self._enthalpy(equations.initial_temperature)
        return form - weight * source * beyond * equations.dx_bed

    def displaced(self, temperature: Value) -> Value | None:
        """Form (scalar, W) of what fluid that leaves its place as it expands takes along, beyond the initial temperature: a loss
        of what is stored. None where the flow leaves that out."""
        equations, source = self.equations, self.equations.flow.source_of_flux
        if source is None:
            return None
        taken = source * (self._enthalpy(temperature) - self._enthalpy(equations.initial_temperature))
        return -equations.coordinates.weight * taken * equations.dx_bed

    def kept(
        self, temperature: Value, bead_temperature: Value, initial: Value, initial_of_beads: Value
    ) -> dict[str, Value]:
        """Forms (scalar, J) of the heat that "beads" and "wall" have gained since their initial temperatures, and of what was set
        free by "cure"."""
        equations, beads = self.equations, self.equations.bed.beads
        gained = volumetric_heat(beads, bead_temperature) - volumetric_heat(beads, initial_of_beads)
        of_beads = equations.coordinates.weight * (1.0 - equations.bed.porosity) * gained * equations.dx_bed
        return {"beads": of_beads} | equations.wall.heat_kept(temperature, initial)

    def fluid_heat_capacity(self) -> Value:
        """Form (scalar, J/K) of phi rho C_f of the fluid in the bed."""
        return self.equations.coordinates.weight * self.equations.fluid_storage * self.equations.dx_bed
