r"""Weak form of the volume-averaged Navier-Stokes equations, quasi-steady, for intrinsic averages u and p.

    mass:      div(phi rho u) + b.(rho u) = 0
    momentum:  phi rho u.grad u = -phi grad p + div(phi tau) + b.tau + phi rho g - drag,  tau with mu + mu_t

b = (phi_V - phi_A) grad V/V is the vector of the non-constant averaging volume; in advective form the convective
terms with b of thesis eq. 6.4 cancel against the mass balance. The thesis's further term -b p follows from
Whitaker's lemma for a constant volume; Gray's theorem for a varying one has (1/V) int n dA = -grad phi_V - b, which
cancels it. `published_pressure_term` puts it back, for comparison: it makes the flow depend on the gauge of p.

The pressure gradient is not integrated by parts, and the boundary's pressure enters weakly as -phi (p - p_b) n.v:
a uniform pressure then exerts exactly no force whatever the quadrature, and every pressure test function is free at
the boundary, so that the mass balance holds to the solver's tolerance. The turbulent normal stress 2/3 rho k is
part of p. Inlets with a given mass flux impose it in the mass balance and, for the momentum that comes in, as
flux times (u - u_in).

Equal-order linear elements with SUPG and PSPG: the fine-scale velocity is -tau r, r the momentum residual.
"""

from dataclasses import dataclass
from typing import Any

import ufl

from ..closures import turbulence as closure
from ..closures.functions import sqrt
from .coordinates import Coordinates
from .medium import Bed, FluidState
from .stabilisation import metric, time_scale
from .turbulence import TwoLayerState, turbulence_residual


@dataclass(frozen=True)
class FlowScales:
    """Reference speed (m/s) and pressure (Pa): unknowns and equations are solved as multiples of them."""

    speed: Any
    pressure: Any
    length: Any

    @property
    def kinetic_energy(self):
        return self.speed**2

    @property
    def dissipation_rate(self):
        return self.speed**3 / self.length


@dataclass(frozen=True)
class FlowState:
    """Flow fields with their units: velocity (m/s), gauge pressure (Pa), k (m2/s2), epsilon (m2/s3) or None."""

    velocity: ufl.core.expr.Expr
    pressure: ufl.core.expr.Expr
    kinetic_energy: ufl.core.expr.Expr | None = None
    dissipation_rate: ufl.core.expr.Expr | None = None

    @classmethod
    def of(cls, parts, scales):
        """From the two or four parts of the scaled unknown."""
        velocity, pressure = parts[0] * scales.speed, parts[1] * scales.pressure
        if len(parts) == 2:
            return cls(velocity, pressure)
        return cls(velocity, pressure, parts[2] * scales.kinetic_energy, parts[3] * scales.dissipation_rate)

    def speed(self, scales):
        """|u|, kept off zero by a thousandth of a percent of the reference."""
        return sqrt(ufl.dot(self.velocity, self.velocity) + (1e-5 * scales.speed) ** 2)


@dataclass(frozen=True)
class Momentum:
    """Parts of the momentum balance: `force` is its residual but for the stress (N/m3), `stress` that of mu + mu_t (Pa),
    `fine_scale_velocity` (m/s) the stabilisation's -tau r."""

    density: Any
    viscosity: Any
    effective_viscosity: Any
    speed: Any
    turbulence: TwoLayerState | None
    stress: Any
    force: Any
    fine_scale_velocity: Any


@dataclass(frozen=True)
class Opening:
    """An inlet or outlet: its measure, and one of the gauge pressure outside (Pa), the mass flux in (kg/m2/s) and the
    superficial velocity in (m/s), whose fluid comes at `temperature` (K).

    `mean_square` (m2/s2) goes with a pressure: what flows in then comes from a room of one total pressure, which is `pressure`
    and the dynamic pressure of that speed. As the mean square of the entering velocity it makes `pressure` the static one.
    """

    ds: ufl.Measure
    pressure: Any = None
    mass_flux: Any = None
    velocity: Any = None
    temperature: Any = None
    mean_square: Any = None


@dataclass(frozen=True)
class FlowEquations:
    """The flow's forms over a bed. `model` is a `TurbulenceModel`, or None for laminar flow (no k and epsilon)."""

    bed: Bed
    fluid: FluidState
    coordinates: Coordinates
    scales: FlowScales
    model: Any = None
    gravity: ufl.core.expr.Expr | None = None
    published_pressure_term: bool = False

    def turbulence_state(self, state, density, viscosity):
        """Two-layer quantities of a flow state; None for laminar flow."""
        if self.model is None:
            return None
        return TwoLayerState(
            state.kinetic_energy,
            state.dissipation_rate,
            density,
            viscosity,
            ufl.max_value(self.bed.wall_distance, LEAST_WALL_DISTANCE * self.bed.bead_diameter),
            self.scales.kinetic_energy,
            self.model.blend_half_width,
            self.model.longest_eddy * self.bed.bead_diameter,
        )

    def momentum(self, state, temperature, old_velocity=None, inverse_step=0.0, body_force=None):
        """What the momentum balance is made of, as `Momentum`."""
        bed, coordinates = self.bed, self.coordinates
        phi, u = bed.porosity, state.velocity
        viscosity = self.fluid.fluid.viscosity(temperature)
        density = self.fluid.density(state.pressure, temperature)
        speed = state.speed(self.scales)
        turbulence = self.turbulence_state(state, density, viscosity)
        effective_viscosity = viscosity if turbulence is None else viscosity + turbulence.eddy_viscosity
        resistance = bed.drag.coefficient(phi, bed.bead_diameter, density, viscosity, speed)
        advection = phi * density * u
        stress = coordinates.stress(u, effective_viscosity)
        plane_stress = coordinates.meridional(stress)
        force = ufl.dot(ufl.grad(u), advection) + phi * ufl.grad(state.pressure) + resistance * u
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

    def mass_flux(self, state, temperature):
        """Superficial mass flux phi rho (u + u') (kg/m2/s) with the fine-scale velocity u', which the discrete mass
        balance conserves: heat carried by it is conserved too."""
        momentum = self.momentum(state, temperature)
        return self.bed.porosity * momentum.density * (state.velocity + momentum.fine_scale_velocity)

    def mass_flux_through_boundary(self, state, temperature):
        """Superficial mass flux phi rho u (kg/m2/s) as inlets and outlets have it."""
        return self.bed.porosity * self.fluid.density(state.pressure, temperature) * state.velocity

    def residual(self, scaled, previous, inverse_step, temperature, openings, dx, nodes, sources=None):
        """Form of the scaled unknown's residual.

        `previous` is the scaled unknown one pseudo-time step ago and `inverse_step` (1/s) the step's inverse, 0 for
        the steady equations; `temperature` (K) is given; `dx` is over the bed, `nodes` too with quadrature at the nodes;
        `sources` (momentum in N/m3, mass in kg/m3/s, and with turbulence those of k and epsilon) are for manufactured
        solutions.
        """
        state, old = (FlowState.of(ufl.split(f), self.scales) for f in (scaled, previous))
        tests = ufl.TestFunctions(scaled.function_space)
        return self.residual_of(state, old, tests, inverse_step, temperature, openings, dx, nodes, sources)

    def residual_of(self, state, old, tests, inverse_step, temperature, openings, dx, nodes, sources=None):
        """`residual` of two `FlowState`s and the test functions of the flow's unknowns."""
        coordinates, scales = self.coordinates, self.scales
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
        if sources:
            mass -= sources[1] * q
        form = weight * (momentum_scale * momentum + mass_scale * mass) * dx
        for opening in openings:
            form += self._opening(opening, state, v, q, m, momentum_scale, mass_scale)
        if self.model is not None:
            form += self._turbulence(state, old, tests, m, inverse_step, dx, nodes)
            for opening in openings:
                form += self._turbulence_inflow(opening, state, tests, m)
            if sources:
                for test, source, size in zip(tests[2:4], sources[2:], self.turbulence_sizes(), strict=True):
                    form -= weight * size * source * test * dx
        return form

    def _opening(self, opening, state, v, q, m, momentum_scale, mass_scale):
        normal = ufl.FacetNormal(self.coordinates.mesh)
        weight, phi = self.coordinates.weight, self.bed.porosity
        outward = phi * m.density * ufl.dot(state.velocity, normal)
        # without mu (grad u)^T n the flow would have to leave free of shear, which parallel flow is not
        parallel = phi * m.effective_viscosity * ufl.dot(ufl.grad(state.velocity).T, normal)
        form = -weight * momentum_scale * ufl.dot(parallel, v) * opening.ds
        if opening.pressure is not None:
            pressure = state.pressure - opening.pressure
            traction = phi * pressure * ufl.dot(normal, v)
            if opening.mean_square is not None:
                inward = self.inward_speed(state)
                along = state.velocity + inward * normal
                traction += phi * m.density * (0.5 * inward**2 - 0.5 * opening.mean_square) * ufl.dot(normal, v)
                traction -= phi * m.density * inward * ufl.dot(along, v)
            return form + weight * (mass_scale * outward * q - momentum_scale * traction) * opening.ds
        flux = self.flux_given(opening, state)
        incoming = -flux / (phi * m.density) * normal
        momentum = flux * ufl.dot(state.velocity - incoming, v)
        return form + weight * (momentum_scale * momentum - mass_scale * flux * q) * opening.ds

    def inward_speed(self, state):
        """Speed (m/s) at which the fluid comes in through a boundary; 0 where it leaves."""
        inward = -ufl.dot(state.velocity, ufl.FacetNormal(self.coordinates.mesh))
        return ufl.conditional(ufl.gt(inward, 0.0), inward, 0.0)

    def entering(self, opening, state, temperature):
        """Forms of the mass flow (kg/s) that comes in, and of that times its speed squared (kg m2/s3)."""
        density, inward = self.fluid.density(state.pressure, temperature), self.inward_speed(state)
        flux = self.coordinates.weight * self.bed.porosity * density * inward
        return flux * opening.ds, flux * inward**2 * opening.ds

    def flux_given(self, opening, state):
        """Mass flux in (kg/m2/s) that an opening gives; None where its pressure is given. The velocity there follows it only
        in the mean, so that it is this flux that the mass balance knows."""
        if opening.velocity is not None:
            return self.fluid.density(state.pressure, opening.temperature) * opening.velocity
        return opening.mass_flux

    def mass_storage(self, state, old, temperature, old_temperature, test, inverse_step, dx):
        """Form of d(phi rho)/dt against the mass balance's test, for pressures and temperatures of two times."""
        pressure, warm = ufl.variable(state.pressure), ufl.variable(temperature)
        density = self.fluid.density(pressure, warm)
        rate = ufl.diff(density, pressure) * (state.pressure - old.pressure)
        rate += ufl.diff(density, warm) * (temperature - old_temperature)
        return self.coordinates.weight * self.bed.porosity * inverse_step * rate * test / self.scales.speed * dx

    def turbulence_sizes(self):
        """Factors that bring the k and epsilon equations to the size of one."""
        rate = self.scales.speed / self.scales.length
        return 1.0 / (self.scales.kinetic_energy * rate), 1.0 / (self.scales.dissipation_rate * rate)

    def _turbulence(self, state, old, tests, m, inverse_step, dx, nodes):
        storage = self.coordinates.weight * self.bed.porosity * m.density * inverse_step
        k_test, epsilon_test = (size * test for size, test in zip(self.turbulence_sizes(), tests[2:4], strict=True))
        coordinates = self.coordinates
        form = turbulence_residual(
            state, (k_test, epsilon_test), m, self.bed, self.model, coordinates, metric(coordinates.mesh), dx, nodes
        )
        changes = (state.kinetic_energy - old.kinetic_energy) * k_test + (
            state.dissipation_rate - old.dissipation_rate
        ) * epsilon_test
        return form + storage * changes * dx

    def _turbulence_inflow(self, opening, state, tests, m):
        """What flows in is in equilibrium with the beads, k = f_d k_inf and epsilon = f_d eps_inf, on a small floor.

        Each node of the inlet by itself, and with a large weight: what diffuses back from the wall's layer behind it would
        undershoot beside the layer, to a k far below zero.
        """
        bed, speed = self.bed, m.speed
        inward = bed.porosity * m.density * self.inward_speed(state)
        fraction = self.model.source_fraction(bed.reynolds_number(m.density, speed, m.viscosity))
        k_in = fraction * closure.bead_kinetic_energy(bed.porosity, speed) + INLET_INTENSITY * speed**2
        epsilon_in = (
            fraction * closure.bead_dissipation_rate(bed.porosity, speed, bed.bead_diameter)
            + INLET_INTENSITY * speed**3 / bed.bead_diameter
        )
        k_size, epsilon_size = self.turbulence_sizes()
        normal = ufl.FacetNormal(self.coordinates.mesh)
        cell = ufl.Jacobian(self.coordinates.mesh)

        def lumped(value, test):
            """What the integral of a product of linear functions lacks of its values at the nodes, along the inlet."""
            slopes = [ufl.grad(f) - ufl.dot(ufl.grad(f), normal) * normal for f in (value, test)]
            return ufl.dot(slopes[0], ufl.dot(cell * cell.T, slopes[1])) / 6.0

        difference = (
            k_size * (state.kinetic_energy - k_in) * tests[2]
            + epsilon_size * (state.dissipation_rate - epsilon_in) * tests[3]
        )
        difference += k_size * lumped(state.kinetic_energy, tests[2]) + epsilon_size * lumped(
            state.dissipation_rate, tests[3]
        )
        return INFLOW_WEIGHT * self.coordinates.weight * inward * difference * opening.ds


INLET_INTENSITY = 1e-5
"""k of the inflow over |u|^2 where no bead source acts: 0.26 % intensity. Changes no heating time by > 0.01 %."""

INFLOW_WEIGHT = 1e3
"""Weight of the inflow's k and epsilon at the inlet against what diffuses back to it."""

LEAST_WALL_DISTANCE = 1e-6
"""In bead diameters, at the nodes on the wall: k is 0 there, whatever acts on it."""
