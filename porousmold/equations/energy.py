r"""Weak form of the two-temperature energy equations with a conjugate wall.

    fluid: phi rho C_f (dT_f/dt + u.grad T_f) = div(K_f grad T_f) + b.(K_f/phi grad T_f) - a_v h_sf (T_f - T_s)
    beads: (1-phi) rho_s C_s dT_s/dt = div(K_s grad T_s) - b.(lambda_s grad T_s) - a_v h_sf (T_s - T_f)
    wall:  rho_w C_w dT_w/dt = div(lambda_w grad T_w) + rho_w H d alpha/dt + q

The conductivities K_f, K_s per total volume are those of `laws.conductivity`; as published K_f = phi (lambda_f + C_f mu_t/Pr_t)
and K_s = (1-phi) lambda_s. One continuous field T is T_f in the bed and T_w in the wall, which gives T_f = T_w and the balance
of fluxes at the interface. As published no flux enters the wall from the beads. Where K_f and K_s share the conductivity of the
whole bed, beads at rest take the wall's temperature (`laws.conductivity`). As that conduction crosses both phases it has no REV
term: b is (phi_V - phi_A) grad V/V, and both are 1 for the whole volume.

The inlet condition is Danckwerts': - int (rho phi u.n)(h(T) - h(T_in)) v ds over the inlet where fluid comes in, h the
enthalpy. Fixing the inlet's nodes instead would heat a conducting wall through their common corner (4 % of the
heating time with an aluminium skin). The outlet has no diffusive flux. `equations.rev_heat` has the terms with b.

With one temperature T_f = T_s the two equations are summed and the exchange is gone. `equations.wall` has the wall's part.

Beads that are not isothermal (`BeadInterior`) have their mean as T_s, and another surface than that takes part in the exchange.

Storage of beads and wall is written with the enthalpy per volume H(T), of what melts interpolated between the nodes
(`equations.corners`), so that the discrete balance closes whatever C(T); that of the fluid (10^-3 of the total of a gas, half
of a liquid's) with phi rho h(T), rho at the temperature of the flow's last solution. With C_f of that, too, 1.2 % of the heat
was missing in a liquid whose C_f triples over 100 K. What the fluid stores is upwinded as what it carries is: lumped at the
nodes and not upwinded, a front in a liquid was 2.1 % of all differences off on default cells (Schumann). The flow carries
C_f(T) grad T = grad h, of the same enthalpy as through inlet and outlet.
"""

import functools
from dataclasses import dataclass

import ufl

from ..laws.conductivity import wall_coefficient
from ..laws.functions import Value
from .bead_interior import BeadInterior
from .bed_heat_transfer import BedHeatTransfer
from .coordinates import Coordinates
from .flow import FlowEquations, FlowState
from .medium import Bed
from .moving_beads import MovingBeads
from .openings import Opening, flux_given
from .rev_heat import RevHeat
from .stabilisation import flux_density
from .streamline import Carried, Streamline
from .wall import Wall, volumetric_heat

OF_ONE_TEMPERATURE = 0.25
"""Part of the upwinding with one temperature: behind a sharp front nothing is left after two cells; all of it costs 0.6 % of the
heating time on coarse cells (18 along), none leaves wiggles of 5 %."""


@dataclass(frozen=True)
class Interface:
    """The facets between bed and wall: `measure` is over the interior facets where the wall has cells (then `in_bed` is 1 in the
    bed's cells and 0 in the wall's), else over the bed's boundary."""

    measure: ufl.Measure
    in_bed: Value

    def integral(self, of_bed: Value, elsewhere: Value) -> Value:
        """Of `of_bed`, constant in each of the bed's cells and 0 in the wall's, times `elsewhere`, the same on both sides."""
        if self.measure.integral_type() == "interior_facet":
            return (2.0 * ufl.avg(of_bed) * ufl.avg(elsewhere)) * self.measure
        return of_bed * elsewhere * self.measure


@dataclass(frozen=True)
class Transport:
    """What carries the heat in the bed: `mass_flux` phi rho u (kg/m2/s), `conduction` of the fluid and `bead_conduction`
    (W/m/K per total volume), `exchange` a_v h_sf (W/m3/K; None with one temperature), `touching` (W/m2/K) between beads and the
    wall, a constant of each cell (None where beads are insulated), the `streamline` along which the cells are upwinded, and with
    one temperature `heat_conducted`, the heat (W/m3) that conduction brings to each node, a part of the upwinded balance."""

    mass_flux: Value
    conduction: Value
    bead_conduction: Value
    exchange: Value
    touching: Value
    streamline: Streamline
    heat_conducted: Value = 0.0


@dataclass(frozen=True)
class EnergyEquations:
    """Forms of the energy balance for given flow fields.

    `flow` with `flow_state` (velocity, pressure, k, epsilon with units) and `flow_temperature`, the temperature (K) that the
    flow was solved for; `entrance` is 1 in the cells that touch the inlet, else 0; `wall` has no layers where the scene has no
    wall; `inlet` and `outlet` are facet measures, `dx_bed` is a cell measure, `nodes_bed` that with
    quadrature at the nodes; `straight` tells that the flow runs along x[0], so that the cells lie along it; `opening` is the
    flow's inlet; `interface` is where beads touch the wall; `interior` is what the beads have inside, None where they are
    isothermal; `moving_beads` is None where they rest; `initial_temperature` (K) is what the heat counts from that fluid takes
    along as it expands; `melts` tells that beads have a heat capacity with a peak.
    """

    flow: FlowEquations
    flow_state: FlowState
    flow_temperature: Value
    entrance: Value
    wall: Wall
    inlet_temperature: Value
    inlet: ufl.Measure
    outlet: ufl.Measure
    dx_bed: ufl.Measure
    nodes_bed: ufl.Measure
    two_temperatures: bool = True
    exchange_factor: Value = 1.0
    straight: bool = True
    opening: Opening | None = None
    interface: Interface | None = None
    interior: BeadInterior | None = None
    moving_beads: MovingBeads | None = None
    initial_temperature: Value = 0.0
    melts: bool = False

    @property
    def bed(self) -> Bed:
        return self.flow.bed

    @property
    def coordinates(self) -> Coordinates:
        return self.flow.coordinates

    @property
    def _laws(self) -> Value:
        return self.flow.fluid.fluid

    @property
    def transfer(self) -> BedHeatTransfer:
        """Conduction in fluid and beads, and exchange between them."""
        return BedHeatTransfer(self.flow, self.flow_state, self.flow_temperature, self.exchange_factor, self.interior)

    @property
    def rev(self) -> RevHeat | None:
        """What the REV terms add; None without them."""
        if self.bed.rev_vector is None:
            return None
        return RevHeat(self.transfer, self.inlet_temperature, self.dx_bed)

    @property
    def _density(self) -> Value:
        return self.transfer.density

    @property
    def outward_mass_flux(self) -> Value:
        """phi rho u.n through inlet and outlet, kg/m2/s."""
        flux = self.flow.mass_flux_through_boundary(self.flow_state, self.flow_temperature)
        return ufl.dot(flux, ufl.FacetNormal(self.coordinates.mesh))

    @property
    def inward_mass_flux(self) -> Value:
        """phi rho u.n in through the inlet, kg/m2/s: as given by `opening`, if there is one that gives it."""
        given = None if self.opening is None else flux_given(self.flow, self.opening, self.flow_state)
        return -self.outward_mass_flux if given is None else given

    @property
    def entering_mass_flux(self) -> Value:
        """The same where it comes in, kg/m2/s; 0 where fluid turns back through the inlet, and takes its own heat along."""
        inward = self.inward_mass_flux
        return ufl.conditional(ufl.gt(inward, 0.0), inward, 0.0)

    @property
    def fluid_storage(self) -> Value:
        """phi rho C_f at the flow's temperature, J/m3/K."""
        return self.bed.porosity * self._density * self._laws.heat_capacity(self.flow_temperature)

    def fluid_enthalpy(self, temperature: Value) -> Value:
        """phi rho h(T) of the fluid, with the density at the flow's temperature, J/m3."""
        return self.bed.porosity * self._density * self._laws.heat_capacity.integral(temperature)

    def stored_heat(
        self, temperature: Value, bead_temperature: Value, test: Value, bead_test: Value, transport: Transport
    ) -> Value:
        """Form of the heat per volume (J/m3) against the tests; its change over time is the storage."""
        weight, streamline = self.coordinates.weight, transport.streamline
        form = weight * streamline.stored_downstream(self.fluid_enthalpy, temperature, test) * self.dx_bed
        of_beads = functools.partial(volumetric_heat, self.bed.beads)
        # with one temperature the beads' heat, too, is what the advection balances
        stored = streamline.stored if self.two_temperatures else streamline.stored_downstream
        bead = stored(of_beads, bead_temperature, bead_test)
        if self.moving_beads is not None:
            upwinding = self.moving_beads.upwinding(transport.exchange, bead_test, streamline)
            bead += streamline.interpolated(of_beads, bead_temperature) * upwinding
        bead *= 1.0 - self.bed.porosity
        form += weight * bead * self.dx_bed
        return form + self.wall.stored_heat(temperature, test, streamline.monotone)

    @property
    def _upwinding(self) -> float:
        """Part of the upwinding that ordinary cells have of the heat that the flow carries.

        Linear elements have no residual of conduction: where that is what advection balances, upwinding alone would conduct along
        the flow, an error of first order in the cells (2 % of the heating time with one temperature). Two temperatures with the
        whole bed's conduction need none, as the exchange spreads the front. With one temperature the residual is
        `Transport.heat_conducted`, and `OF_ONE_TEMPERATURE` is enough.
        """
        if self.two_temperatures:
            return 0.0 if self.bed.bead_conduction.whole_bed else 1.0
        return OF_ONE_TEMPERATURE

    def transport(self, temperature: Value, monotone: Value) -> Value:
        """`Transport` at a temperature (K), with cells that are to be monotone marked by 1 (`Streamline`)."""
        capacity = self._laws.heat_capacity(temperature)
        transfer = self.transfer
        exchange = transfer.exchange_coefficient(temperature) if self.two_temperatures else None
        conduction = transfer.fluid_conduction(temperature)
        mass_flux = self.flow.mass_flux(self.flow_state, self.flow_temperature)
        return Transport(
            mass_flux,
            conduction,
            transfer.bead_conduction(temperature),
            exchange,
            self._touching(temperature),
            Streamline.of(
                self.coordinates,
                Carried(capacity * mass_flux, conduction, exchange),
                *(self.entrance, monotone, self.straight),
                upwinding=self._upwinding,
                melts=self.melts,
            ),
        )

    def outflow_of_heat(
        self, temperature: Value, bead_temperature: Value, test: Value, bead_test: Value, transport: Transport
    ) -> Value:
        """Form of everything but the storage: what leaves each place, W against the tests.

        `transport` is what `transport()` gives, or its values held for a step. Upwinded along its `Streamline`, as what
        is stored is.
        """
        weight, streamline = self.coordinates.weight, transport.streamline
        # C_f of the present temperature: what the flow carries is the enthalpy, as through inlet and outlet
        advection = self._laws.heat_capacity(temperature) * transport.mass_flux
        fluid = streamline.carried(advection, temperature, test)
        fluid += streamline.conducted(transport.conduction, temperature, test)
        if not self.two_temperatures:
            fluid -= streamline.upwinding(test) * transport.heat_conducted
        bead = ufl.dot(flux_density(transport.bead_conduction, ufl.grad(bead_temperature)), ufl.grad(bead_test))
        if self.two_temperatures:
            difference = self.transfer.excess(temperature, bead_temperature)
            fluid += streamline.exchanged_downstream(transport.exchange, difference, test)
            bead -= streamline.exchanged(transport.exchange, difference, bead_test)
        form = weight * (fluid + bead) * self.dx_bed
        if self.rev is not None:
            form += self.rev.outflow_of_heat(temperature, bead_temperature, test, bead_test)
        if self.interface is not None and transport.touching is not None:
            crossing = weight * (temperature - bead_temperature) * (test - bead_test)
            form += self.interface.integral(transport.touching, crossing)
        if self.moving_beads is not None:
            excess = self.transfer.excess(temperature, bead_temperature)
            form += self.moving_beads.outflow_of_heat(
                bead_temperature, bead_test, transport.exchange, excess, streamline
            )
        form -= weight * self.enthalpy_entering(temperature) * test * self.inlet
        entering = self._laws.heat_capacity(temperature) * self.entering_mass_flux
        form += weight * streamline.entered(entering, temperature, test) * self.inlet
        return form + self.wall.outflow_of_heat(temperature, test, streamline.monotone)

    def heat_conducted(self, temperature: Value, test: Value, transport: Transport) -> Value:
        """Form of the heat that conduction in fluid and beads of one temperature brings to each place, W against the test."""
        gradient = ufl.grad(temperature)
        flux = flux_density(transport.conduction, gradient) + flux_density(transport.bead_conduction, gradient)
        return -self.coordinates.weight * ufl.dot(flux, ufl.grad(test)) * self.dx_bed

    def _touching(self, temperature: Value) -> Value:
        """Coefficient between beads and the wall, W/m2/K; None where beads are insulated or have the fluid's temperature."""
        if self.interface is None or not (self.bed.bead_conduction.whole_bed and self.two_temperatures):
            return None
        return self.interface.in_bed * wall_coefficient(self.transfer.local_bed(temperature, temperature))

    def enthalpy_entering(self, temperature: Value) -> Value:
        """-(rho phi u.n)(h(T_in) - h(T)) of what comes in: heat that it brings beyond what it finds, W/m2 of inlet."""
        enthalpy = self._laws.heat_capacity.integral
        return self.entering_mass_flux * (enthalpy(self.inlet_temperature) - enthalpy(temperature))
