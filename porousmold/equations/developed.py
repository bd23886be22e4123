r"""Locally developed flow and plug flow: the cheaper flow models.

Developed: at each axial station only derivatives across the flow are kept,

    0 = -phi dp/dx + (1/w) d/dy (w phi (mu + mu_t) du/dy) + b_y (mu + mu_t) du/dy + phi rho g - drag,     w = 1 or 2 pi r,

likewise for k and epsilon. The same mass flow passes every station, but for what the fluid displaces upstream as its density
changes; dp/dx, one number a station, sees to that, and the pressure is integrated with it. Left out are the entrance and the
inertia of the gas as it expands.

Plug: the superficial mass flux is uniform over the section, and the drag of the bulk alone takes the pressure. There is
no turbulence in it.

In both the heat is convected by the curl of a stream function, which is exactly divergence-free; where the fluid expands, times
the `growth` of the mass flow along the bed.
"""

import math
from dataclasses import dataclass

import ufl

from ..laws.functions import Value
from .flow import BedMeasures, FlowEquations, FlowState
from .stabilisation import metric


def developed_state(equations: FlowEquations, unknown: Value, pressure: Value) -> Value:
    """`FlowState` of the scaled unknown (u and the turbulence's unknowns) and the gauge pressure (Pa)."""
    sizes = equations.turbulent_scales
    speed, *turbulence = ufl.split(unknown) if sizes else (unknown,)
    velocity = ufl.as_vector([speed * equations.scales.speed, 0.0])
    return FlowState(velocity, pressure, tuple(part * size for part, size in zip(turbulence, sizes, strict=True)))


def developed_residual(
    equations: FlowEquations,
    unknown: Value,
    previous: Value,
    inverse_step: Value,
    pressure: Value,
    gradient: Value,
    temperature: Value,
    measures: BedMeasures,
) -> Value:
    """Form of the scaled residual at all stations; `measures.dx` has its quadrature at the nodes along the flow.

    `equations` are `FlowEquations`, `gradient` is dp/dx (Pa/m), `inverse_step` (1/s) that of a pseudo-time step.
    """
    bed, scales, coordinates = equations.bed, equations.scales, equations.coordinates
    state, old = (developed_state(equations, f, pressure) for f in (unknown, previous))
    space = unknown.function_space
    tests = ufl.TestFunctions(space) if state.turbulence else (ufl.TestFunction(space),)
    phi, u = bed.porosity, state.velocity[0]
    viscosity, density = equations.fluid.fluid.viscosity(temperature), equations.fluid.density(pressure, temperature)
    layers = equations.turbulence_state(state, density, viscosity, u.dx(1) ** 2)
    effective = viscosity if layers is None else viscosity + layers.eddy_viscosity
    relative = equations.past_the_beads(state)
    speed = relative.speed(scales)
    resistance = bed.drag.coefficient(phi, bed.bead_diameter, density, viscosity, speed)
    storage = phi * density * inverse_step
    force = resistance * relative.velocity[0] + phi * gradient + storage * (u - old.velocity[0])
    if equations.gravity is not None:
        force -= phi * density * equations.gravity[0]
    if bed.rev_vector is not None:
        force -= effective * bed.rev_vector[1] * u.dx(1)
    test = tests[0] * equations.bed.bead_diameter / scales.pressure
    form = force * test + phi * effective * u.dx(1) * test.dx(1)
    local = 0.0 * test
    if equations.model is not None and state.turbulence:
        flow = equations.local_flow(density, viscosity, speed)
        terms = equations.model.terms(state.turbulence, flow, layers, u.dx(1) ** 2)
        for field, before, term, size, test in zip(
            state.turbulence, old.turbulence, terms, equations.turbulence_sizes(), tests[1:], strict=True
        ):
            gained = storage * (field - before) - term.production
            form += size * (gained * test + term.diffusivity * field.dx(1) * test.dx(1))
            local += size * term.reaction * test
    return coordinates.weight * form * measures.dx + coordinates.nodal_weight * local * measures.nodes


@dataclass(frozen=True)
class CarriedByStreamfunction(FlowEquations):
    """`FlowEquations` whose mass flux is the curl of `streamfunction` (kg/s, or kg/s per metre of width), times `growth`, the
    mass flow over that at the inlet, if there is one."""

    streamfunction: Value = None
    growth: Value | None = None

    def mass_flux(self, state: FlowState, temperature: Value) -> Value:
        """The curl, and its growth."""
        return self._curl if self.growth is None else self.growth * self._curl

    @property
    def source_of_flux(self) -> Value | None:
        return None if self.growth is None else ufl.dot(self._curl, ufl.grad(self.growth))

    @property
    def _curl(self) -> Value:
        """About an axis the nodal values are joined by lines in r^2, not r: else the flux would not be uniform
        within a cell, and a cell at the axis would give its inner node too much of it."""
        gradient, coordinates = ufl.grad(self.streamfunction), self.coordinates
        if not coordinates.axisymmetric:
            return ufl.as_vector([gradient[1], -gradient[0]])
        radius, offset = ufl.SpatialCoordinate(coordinates.mesh)[1], coordinates.from_middle[1]
        middle = radius - offset
        bow = (offset**2 - 1.0 / metric(coordinates.mesh)[1, 1]) / (2.0 * middle)
        across = gradient[0] + ufl.grad(gradient[0])[1] * bow
        return ufl.as_vector([gradient[1] / middle, -across / radius]) / (2.0 * math.pi)

    mass_flux_through_boundary = mass_flux
