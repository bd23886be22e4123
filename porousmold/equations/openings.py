"""Boundary conditions at inlets and outlets: their terms in the equations of momentum, mass and turbulence.

The pressure of an opening enters weakly as -phi (p - p_b) n.v. An inlet with a given mass flux imposes it in the mass balance
and, for the momentum that comes in, as flux times (u - u_in).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import ufl

from ..laws.functions import Value

if TYPE_CHECKING:
    from .flow import FlowEquations, FlowState, Momentum

INFLOW_WEIGHT = 1e3
"""Weight of the inflow's turbulence at the inlet against what diffuses back to it."""


@dataclass(frozen=True)
class Opening:
    """An inlet or outlet: its measure, and one of the gauge pressure outside (Pa), the mass flux in (kg/m2/s) and the
    superficial velocity in (m/s), whose fluid comes at `temperature` (K).

    `mean_square` (m2/s2) is used with a pressure: the inflow then has a uniform total pressure (plenum), which is `pressure`
    and the dynamic pressure of that speed. As the mean square of the entering velocity it makes `pressure` the static one.
    """

    ds: ufl.Measure
    pressure: Value = None
    mass_flux: Value = None
    velocity: Value = None
    temperature: Value = None
    mean_square: Value = None


def residual(
    equations: "FlowEquations", opening: Opening, state: "FlowState", tests: Sequence[Value], m: "Momentum"
) -> Value:
    """Boundary terms of an inlet or outlet in the momentum and mass residuals."""
    v, q = tests[0], tests[1]
    momentum_scale, mass_scale = 1.0 / equations.scales.pressure, 1.0 / equations.scales.speed
    normal = ufl.FacetNormal(equations.coordinates.mesh)
    weight, phi = equations.coordinates.weight, equations.bed.porosity
    outward = phi * m.density * ufl.dot(state.velocity, normal)
    # without mu (grad u)^T n the flow would have to leave free of shear, which parallel flow is not
    parallel = phi * m.effective_viscosity * ufl.dot(ufl.grad(state.velocity).T, normal)
    form = -weight * momentum_scale * ufl.dot(parallel, v) * opening.ds
    if opening.pressure is not None:
        pressure = state.pressure - opening.pressure
        traction = phi * pressure * ufl.dot(normal, v)
        if opening.mean_square is not None:
            inward = inward_speed(equations, state)
            along = state.velocity + inward * normal
            traction += phi * m.density * (0.5 * inward**2 - 0.5 * opening.mean_square) * ufl.dot(normal, v)
            traction -= phi * m.density * inward * ufl.dot(along, v)
        return form + weight * (mass_scale * outward * q - momentum_scale * traction) * opening.ds
    flux = flux_given(equations, opening, state)
    incoming = -flux / (phi * m.density) * normal
    momentum = flux * ufl.dot(state.velocity - incoming, v)
    return form + weight * (momentum_scale * momentum - mass_scale * flux * q) * opening.ds


def inward_speed(equations: "FlowEquations", state: "FlowState") -> Value:
    """Speed (m/s) at which the fluid comes in through a boundary; 0 where it leaves."""
    inward = -ufl.dot(state.velocity, ufl.FacetNormal(equations.coordinates.mesh))
    return ufl.conditional(ufl.gt(inward, 0.0), inward, 0.0)


def entering(
    equations: "FlowEquations", opening: Opening, state: "FlowState", temperature: Value
) -> tuple[Value, Value]:
    """Forms of the mass flow (kg/s) that comes in, and of that times its speed squared (kg m2/s3)."""
    density, inward = equations.fluid.density(state.pressure, temperature), inward_speed(equations, state)
    flux = equations.coordinates.weight * equations.bed.porosity * density * inward
    return flux * opening.ds, flux * inward**2 * opening.ds


def flux_given(equations: "FlowEquations", opening: Opening, state: "FlowState") -> Value:
    """Mass flux in (kg/m2/s) that an opening gives; None where its pressure is given. The velocity there follows it only
    in the mean, so that it is this flux that the mass balance knows."""
    if opening.velocity is not None:
        return equations.fluid.density(state.pressure, opening.temperature) * opening.velocity
    return opening.mass_flux


def turbulence_inflow(
    equations: "FlowEquations", opening: Opening, state: "FlowState", tests: Sequence[Value], m: "Momentum"
) -> Value:
    """The model's `inflow` at the inlet.

    Each node of the inlet by itself, and with a large weight: what diffuses back from the wall's layer behind it would
    undershoot beside the layer, to a k far below zero.
    """
    assert equations.model is not None
    inward = equations.bed.porosity * m.density * inward_speed(equations, state)
    entering = equations.model.inflow(equations.local_flow(m.density, m.viscosity, m.speed))
    normal = ufl.FacetNormal(equations.coordinates.mesh)
    cell = ufl.Jacobian(equations.coordinates.mesh)

    def lumped(value: Value, test: Value) -> Value:
        """What the integral of a product of linear functions lacks of its values at the nodes, along the inlet."""
        slopes = [ufl.grad(f) - ufl.dot(ufl.grad(f), normal) * normal for f in (value, test)]
        return ufl.dot(slopes[0], ufl.dot(cell * cell.T, slopes[1])) / 6.0

    difference = sum(
        size * ((value - given) * test + lumped(value, test))
        for size, value, given, test in zip(
            equations.turbulence_sizes(), state.turbulence, entering, tests[2:], strict=True
        )
    )
    return INFLOW_WEIGHT * equations.coordinates.weight * inward * difference * opening.ds
