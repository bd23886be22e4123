r"""Weak form of the volume-averaged Navier-Stokes equations, quasi-steady, for intrinsic averages u and p.

    mass:      div(phi rho u) + b.(rho u) = -phi d(rho)/dt
    momentum:  phi rho u.grad u = -phi grad p + div(phi tau) + b.tau + phi rho g - drag,  tau with mu + mu_t

b = (phi_V - phi_A) grad V/V is the vector of the non-constant averaging volume; in advective form the convective
terms with b of thesis eq. 6.4 cancel against the mass balance. The thesis's further term -b p follows from
Whitaker's lemma for a constant volume; Gray's theorem for a varying one has (1/V) int n dA = -grad phi_V - b, which
cancels it. `published_pressure_term` puts it back, for comparison: it makes the flow depend on the gauge of p.

The mass balance's right side, `expansion`, is given: what the fluid displaces as its temperature changes. It is left out where it
does not count (`None`); the fluid's inertia in time always is.

The pressure gradient is not integrated by parts, and the boundary's pressure enters weakly as -phi (p - p_b) n.v:
a uniform pressure then exerts exactly no force whatever the quadrature, and every pressure test function is free at
the boundary, so that the mass balance holds to the solver's tolerance. The turbulent normal stress 2/3 rho k is
part of p. Inlets with a given mass flux impose it in the mass balance and, for the momentum that comes in, as
flux times (u - u_in).

Equal-order linear elements with SUPG and PSPG: the fine-scale velocity is -tau r, r the momentum residual.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import ufl

from ..laws.functions import Value, sqrt
from ..laws.turbulence_models import LocalFlow, TurbulenceModel, TurbulentUnknown
from . import openings as openings_of
from . import turbulence as turbulence_of
from .coordinates import Coordinates
from .medium import Bed, FluidState
from .openings import Opening
from .stabilisation import metric, time_scale


class BedMeasures(NamedTuple):
    """Measures of integrals over the bed: `dx`, and `nodes` with quadrature at the nodes."""

    dx: ufl.Measure
    nodes: ufl.Measure


@dataclass(frozen=True)
class FlowScales:
    """Reference speed (m/s), pressure (Pa) and length (m, a bead's diameter), UFL constants: unknowns and equations are solved
    as multiples of them."""

    speed: Value
    pressure: Value
    length: Value

    def transit_time(self) -> float:
        """Time (s) in which the flow passes a bead."""
        return float(self.length.value / self.speed.value)


@dataclass(frozen=True)
class FlowState:
    """Flow fields with their units: velocity (m/s), gauge pressure (Pa), and the turbulence model's unknowns (SI)."""

    velocity: ufl.core.expr.Expr
    pressure: ufl.core.expr.Expr
    turbulence: tuple[ufl.core.expr.Expr, ...] = ()

    def speed(self, scales: "FlowScales") -> Value:
        """|u|, kept off zero by a thousandth of a percent of the reference."""
        return sqrt(ufl.dot(self.velocity, self.velocity) + (1e-5 * scales.speed) ** 2)


@dataclass(frozen=True)
class Momentum:
    """Parts of the momentum balance: `force` is its residual but for the stress (N/m3), `stress` that of mu + mu_t (Pa),
    `fine_scale_velocity` (m/s) the stabilisation's -tau r, `speed` that past the beads (m/s); `turbulence` is the model's state,
    None for laminar flow."""

    density: Value
    viscosity: Value
    effective_viscosity: Value
    speed: Value
    turbulence: Value
    stress: Value
    force: Value
    fine_scale_velocity: Value


@dataclass(frozen=True)
class FlowEquations:
    """The flow's forms over a bed. `model` is a `TurbulenceModel`, or None for laminar flow."""

    bed: Bed
    fluid: FluidState
    coordinates: Coordinates
    scales: FlowScales
    model: TurbulenceModel | None = None
    gravity: ufl.core.expr.Expr | None = None
    published_pressure_term: bool = False
    expansion: Value | None = None

    @property
    def source_of_flux(self) -> Value | None:
        """div(phi rho u), kg/m3/s, as the flow has it; None where it is 0."""
        return self.expansion

    @property
    def turbulent_unknowns(self) -> tuple[TurbulentUnknown, ...]:
        """What the turbulence model transports; nothing for laminar flow."""
        return () if self.model is None else self.model.unknowns

    @property
    def turbulent_scales(self) -> tuple[Value, ...]:
        """Values (SI) that count as 1 of those unknowns."""
        return () if self.model is None else self.model.magnitudes(self.scales.speed, self.scales.length)

    def state_of(self, parts: Sequence[Value]) -> FlowState:
        """The fields of the parts (velocity, pressure, turbulence) of the scaled unknown."""
        velocity, pressure, *turbulence = parts
        sizes = self.turbulent_scales
        return FlowState(
            velocity * self.scales.speed,
            pressure * self.scales.pressure,
            tuple(part * size for part, size in zip(turbulence, sizes, strict=True)),
        )

    def local_flow(self, density: Value, viscosity: Value, speed: Value) -> LocalFlow:
        """Arguments of the turbulence model at a point of the flow."""
        bed = self.bed
        distance = ufl.max_value(bed.wall_distance, LEAST_WALL_DISTANCE * bed.bead_diameter)
        return LocalFlow(bed.porosity, bed.bead_diameter, distance, density, viscosity, speed, self.scales.speed)

    def turbulence_state(
        self, state: FlowState, density: Value, viscosity: Value, shear_rate_squared: Value = None
    ) -> Value:
        """The model's state of a flow state; None for laminar flow."""
        if self.model is None:
            return None
        flow = self.local_flow(density, viscosity, self.past_the_beads(state).speed(self.scales))
        shear = (
            self.coordinates.shear_rate_squared(state.velocity) if shear_rate_squared is None else shear_rate_squared
        )
        return self.model.state(state.turbulence, flow, shear)

    def past_the_beads(self, state: FlowState) -> FlowState:
        """The state with the velocity relative to beads that move, which drag and correlations follow."""
        if self.bed.bead_velocity is None:
            return state
        of_beads = [self.bed.bead_velocity] + [0.0] * (self.coordinates.mesh.geometry.dim - 1)
        return replace(state, velocity=state.velocity - ufl.as_vector(of_beads))

    def momentum(
        self,
        state: FlowState,
        temperature: Value,
        old_velocity: Value = None,
        inverse_step: float = 0.0,
        body_force: Value = None,
    ) -> Value:
        """What the momentum balance is made of, as `Momentum`."""
        bed, coordinates = self.bed, self.coordinates
        phi, u = bed.porosity, state.velocity
        viscosity = self.fluid.fluid.viscosity(temperature)
        density = self.fluid.density(state.pressure, temperature)
        turbulence = self.turbulence_state(state, density, viscosity)
        effective_viscosity = viscosity if turbulence is None else viscosity + turbulence.eddy_viscosity
        relative = self.past_the_beads(state)
        speed = relative.speed(self.scales)
        resistance = bed.drag.coefficient(phi, bed.bead_diameter, density, viscosity, speed)
        advection = phi * density * u
        stress = coordinates.stress(u, effective_viscosity)
        plane_stress = coordinates.meridional(stress)
        force = ufl.dot(ufl.grad(u), advection) + phi * ufl.grad(state.pressure) + resistance * relative.velocity
        if old_velocity is not None:
            force += phi * density * inverse_step * (u - old_velocity)
        if self.gravity is not None:
            force -= phi * density * self.gravity
        if bed.rev_vector is not None:
            force -= ufl.dot(plane_stress, bed.rev_vector)
            if self.published_pressure_term:
                force += state.pressure * bed.rev_vector
        if body_force is not None:
            force -= body_force
        tau = time_scale(
            metric(coordinates.mesh),
            advection,
            phi * effective_viscosity,
            resistance + phi * density * inverse_step,
        )
        fine_scale = -tau * (force - ufl.dot(plane_stress, ufl.grad(phi)))
        return Momentum(density, viscosity, effective_viscosity, speed, turbulence, stress, force, fine_scale)

    def core_speed(self, state: FlowState, temperature: Value) -> Value:
        """Superficial speed (m/s) that the local pressure gradient drives through the core, far from any wall."""
        bed, phi = self.bed, self.bed.bulk_porosity
        density, viscosity = self.fluid.density(state.pressure, temperature), self.fluid.fluid.viscosity(temperature)
        driving = ufl.grad(state.pressure)
        if self.gravity is not None:
            driving -= density * self.gravity
        least = LEAST_GRADIENT * self.scales.pressure / self.scales.length  # keeps the root off zero
        force = phi * sqrt(ufl.dot(driving, driving) + least**2)
        return phi * bed.drag.speed(force, phi, bed.bead_diameter, density, viscosity)

    def mass_flux(self, state: FlowState, temperature: Value) -> Value:
        """Superficial mass flux phi rho (u + u') (kg/m2/s) with the fine-scale velocity u', which the discrete mass
        balance conserves: heat carried by it is conserved too."""
        momentum = self.momentum(state, temperature)
        return self.bed.porosity * momentum.density * (state.velocity + momentum.fine_scale_velocity)

    def mass_flux_through_boundary(self, state: FlowState, temperature: Value) -> Value:
        """Superficial mass flux phi rho u (kg/m2/s) as inlets and outlets have it."""
        return self.bed.porosity * self.fluid.density(state.pressure, temperature) * state.velocity

    def residual(
        self,
        scaled: Value,
        previous: Value,
        inverse_step: Value,
        temperature: Value,
        openings: Sequence[Opening],
        measures: BedMeasures,
        sources: Sequence[Value] | None = None,
    ) -> Value:
        """Form of the scaled unknown's residual.

        `previous` is the scaled unknown one pseudo-time step ago and `inverse_step` (1/s) the step's inverse, 0 for
        the steady equations; `temperature` (K) is given; `sources` (momentum in N/m3, mass in kg/m3/s, and those of the
        turbulence's unknowns) are for manufactured solutions.
        """
        state, old = (self.state_of(ufl.split(f)) for f in (scaled, previous))
        tests = ufl.TestFunctions(scaled.function_space)
        return self.residual_of(state, old, tests, inverse_step, temperature, openings, measures, sources)

    def residual_of(
        self,
        state: FlowState,
        old: FlowState,
        tests: Sequence[Value],
        inverse_step: Value,
        temperature: Value,
        openings: Sequence[Opening],
        measures: BedMeasures,
        sources: Sequence[Value] | None = None,
    ) -> Value:
        """`residual` of two `FlowState`s and the test functions of the flow's unknowns."""
        coordinates, scales, dx = self.coordinates, self.scales, measures.dx
        weight, phi = coordinates.weight, self.bed.porosity
        u, v, q = state.velocity, tests[0], tests[1]
        m = self.momentum(state, temperature, old.velocity, inverse_step, sources[0] if sources else None)
        advection = phi * m.density * u
        momentum_scale = 1.0 / scales.pressure
        mass_scale = 1.0 / scales.speed
        momentum = (
            ufl.dot(m.force, v)
            + phi * ufl.inner(m.stress, coordinates.velocity_gradient(v))
            - ufl.dot(m.fine_scale_velocity, ufl.dot(ufl.grad(v), advection))
        )
        mass = -ufl.dot(phi * m.density * (u + m.fine_scale_velocity), ufl.grad(q))
        if self.bed.rev_vector is not None:
            mass += m.density * ufl.dot(self.bed.rev_vector, u) * q
        if self.expansion is not None:
            mass -= self.expansion * q
        if sources:
            mass -= sources[1] * q
        form = weight * (momentum_scale * momentum + mass_scale * mass) * dx
        for opening in openings:
            form += openings_of.residual(self, opening, state, tests, m)
        if self.turbulent_unknowns:
            form += turbulence_of.residual(self, state, old, tests, m, inverse_step, measures)
            for opening in openings:
                form += openings_of.turbulence_inflow(self, opening, state, tests, m)
            if sources:
                for test, source, size in zip(tests[2:], sources[2:], self.turbulence_sizes(), strict=True):
                    form -= weight * size * source * test * dx
        return form

    def turbulence_sizes(self) -> tuple[Value, ...]:
        """Factors that bring the turbulence's equations to the size of one."""
        rate = self.scales.speed / self.scales.length
        return tuple(1.0 / (scale * rate) for scale in self.turbulent_scales)


LEAST_GRADIENT = 1e-6
"""Of the reference pressure over a bead."""
LEAST_WALL_DISTANCE = 1e-6
"""In bead diameters, at the nodes on the wall: k is 0 there, whatever acts on it."""
