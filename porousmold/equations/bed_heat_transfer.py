"""Conduction and heat exchange of fluid and beads at a point of the bed, for given flow fields: the coefficients of the energy
equations, by the laws that the bed has chosen."""

from dataclasses import dataclass

import ufl

from ..laws.bead_interior import overall_coefficient
from ..laws.conductivity import Anisotropic, LocalBed, added
from ..laws.functions import Value
from ..laws.nusselt import prandtl_number, specific_surface
from .bead_interior import BeadInterior
from .flow import FlowEquations, FlowState
from .medium import Bed


@dataclass(frozen=True)
class BedHeatTransfer:
    """Of the `flow` with the fields `flow_state`, solved for `flow_temperature` (K); `exchange_factor` multiplies the film's
    coefficient, `interior` is what the beads have inside, None where they are isothermal."""

    flow: FlowEquations
    flow_state: FlowState
    flow_temperature: Value
    exchange_factor: Value
    interior: BeadInterior | None

    @property
    def bed(self) -> Bed:
        return self.flow.bed

    @property
    def _laws(self) -> Value:
        return self.flow.fluid.fluid

    @property
    def density(self) -> Value:
        """Of the fluid, kg/m3."""
        return self.flow.fluid.density(self.flow_state.pressure, self.flow_temperature)

    @property
    def speed_past_the_beads(self) -> Value:
        """|u - v_s|, m/s."""
        return self.flow.past_the_beads(self.flow_state).speed(self.flow.scales)

    def bead_coefficient(self, temperature: Value) -> Value:
        """Heat transfer coefficient between fluid and bead, its inside included, per bead surface, W/m2/K."""
        bed, laws = self.bed, self._laws
        conductivity, viscosity = laws.conductivity(temperature), laws.viscosity(temperature)
        speed = self.speed_past_the_beads
        nusselt = bed.nusselt(
            bed.reynolds_number(self.density, speed, viscosity),
            prandtl_number(viscosity, laws.heat_capacity(temperature), conductivity),
            bed.porosity,
        )
        film = self.exchange_factor * nusselt * conductivity / bed.bead_diameter
        return film if self.interior is None else overall_coefficient(film, self.interior.resistance(temperature))

    def exchange_coefficient(self, temperature: Value) -> Value:
        """a_v h_sf per total volume, the beads' inside included, W/m3/K."""
        surface = specific_surface(self.bed.porosity, self.bed.bead_diameter)
        return surface * self.bead_coefficient(temperature)

    def bead_heat_flux(self, temperature: Value, bead_temperature: Value, property_temperature: Value) -> Value:
        """Heat flux into the beads' surface, W/m2."""
        return self.bead_coefficient(property_temperature) * self.excess(temperature, bead_temperature)

    def excess(self, temperature: Value, bead_temperature: Value) -> Value:
        """What drives heat into the beads, K."""
        difference = temperature - bead_temperature
        return difference if self.interior is None else difference - self.interior.lag

    def local_bed(self, temperature: Value, bead_temperature: Value) -> LocalBed:
        """Arguments of a conductivity law, with properties at these temperatures (K)."""
        bed, laws, speed = self.bed, self._laws, self.speed_past_the_beads
        turbulence = self.flow.turbulence_state(
            self.flow_state, self.density, self._laws.viscosity(self.flow_temperature)
        )
        return LocalBed(
            porosity=bed.porosity,
            wall_distance=bed.wall_distance,
            bead_diameter=bed.bead_diameter,
            density=self.density,
            viscosity=laws.viscosity(temperature),
            heat_capacity=laws.heat_capacity(temperature),
            speed=speed,
            eddy_viscosity=0.0 if turbulence is None else turbulence.eddy_viscosity,
            fluid_conductivity=laws.conductivity(temperature),
            bead_conductivity=bed.beads.conductivity(bead_temperature),
            bulk_porosity=bed.bulk_porosity,
            core_speed=self.flow.core_speed(self.flow_state, self.flow_temperature),
            temperature=bead_temperature,
            emissivity=bed.emissivity,
            contact_flattening=bed.beads.contact_flattening,
            bead_heat_capacity=bed.beads.density(bead_temperature) * bed.beads.heat_capacity(bead_temperature),
        )

    def fluid_conduction(self, temperature: Value) -> Value:
        """Conductivity of the fluid per total volume, W/m/K: a number or a tensor."""
        local = self.local_bed(temperature, temperature)
        return self._tensor(added(self.bed.bead_conduction.fluid(local), self.bed.dispersion.mixed(local)))

    def dispersion(self, temperature: Value) -> Value:
        """The part of it that mixing gives, W/m/K."""
        return self._tensor(self.bed.dispersion.mixed(self.local_bed(temperature, temperature)))

    def bead_conduction(self, bead_temperature: Value) -> Value:
        """Conductivity of the beads per total volume, W/m/K: a number or a tensor."""
        return self._tensor(self.bed.bead_conduction.beads(self.local_bed(bead_temperature, bead_temperature)))

    def _tensor(self, conductivity: Value) -> Value:
        """A law's conductivity as a number, or where it is `Anisotropic` as the tensor with its axis along the flow."""
        if not isinstance(conductivity, Anisotropic):
            return conductivity
        velocity = self.flow_state.velocity
        squared = ufl.dot(velocity, velocity) + (1e-5 * self.flow.scales.speed) ** 2
        along = ufl.outer(velocity, velocity) / squared
        identity = ufl.Identity(self.flow.coordinates.mesh.geometry.dim)
        return conductivity.across * identity + (conductivity.along - conductivity.across) * along
