r"""Gas among beads that move one by one: what they add to the flow's equations, and the heat of the gas.

Beads fill the share a = 1 - phi and move with v. Over a step dt they follow the gas implicitly (Henry et al., eq. A.20, for the
predicted velocity v* of the beads at a place, per total volume):

    v* = theta u + (1 - theta) v' - a/(a rho_s/dt + beta) grad p,   theta = beta/(a rho_s/dt + beta),   v' = v + g' dt

with beta the drag per volume and relative velocity, and g' the acceleration by weight less buoyancy and by contacts. So the gas
feels, in its momentum,

    beta (1 - theta) (u - v') + theta a grad p      besides phi grad p,

and what beads displace makes room for it: div(phi u + a v*) = 0, the volume of both together.

The heat of the gas is balanced with the porosity that the beads really leave:

    d(phi rho C T)/dt + div(rho C w T) = div(phi lambda grad T) - sum_beads K (T - T_i)

For that phi, phi u has a small imbalance at every node, as v* is a prediction. w = phi u + grad psi with
div grad psi = imbalance conserves both the gas and its heat, and keeps a uniform temperature. Streamlines are upwinded fully;
what is stored and exchanged is lumped at the nodes.
"""

from dataclasses import dataclass

import ufl

from ..laws.functions import Value
from .coordinates import Coordinates
from .flow import FlowEquations, FlowState
from .stabilisation import metric


@dataclass(frozen=True)
class GivenDrag:
    """A drag law whose coefficient (kg/m3/s) is a field."""

    field: Value

    def coefficient(self, *of_the_bed: Value) -> Value:
        """The field."""
        return self.field


@dataclass(frozen=True)
class SuspendedBeads:
    """Fields at the nodes: `velocity` v', `share` a, `theta`, and `yielding` a^2/(a rho_s/dt + beta) (m3 s/kg)."""

    velocity: Value
    share: Value
    theta: Value
    yielding: Value

    def flux(self, state: FlowState) -> Value:
        """a v*, m/s."""
        own = self.share * (self.theta * state.velocity + (1.0 - self.theta) * self.velocity)
        return own - self.yielding * ufl.grad(state.pressure)

    def force(self, state: FlowState, drag: Value) -> Value:
        """On the gas (N/m3), with `drag` beta (1 - theta), beside what it resists to its own velocity."""
        return drag * self.velocity - self.theta * self.share * ufl.grad(state.pressure)

    def residual(
        self, equations: FlowEquations, state: FlowState, test: Value, density: Value, dx: ufl.Measure
    ) -> Value:
        """Form of what the beads add to the mass balance, of its test function, scaled like it."""
        mass = -density * ufl.dot(self.flux(state), ufl.grad(test)) / equations.scales.speed
        return equations.coordinates.weight * mass * dx


@dataclass(frozen=True)
class GasAmongBeads:
    """Heat of the gas: `flux` w (m/s), `porosity` now and `old_porosity` before, `capacity` rho C (J/m3/K), `conductivity`
    (W/m/K), `exchange` sum K per volume (W/m3/K) and `heating` sum K T_i (W/m3), fields at the nodes.

    Measures: `dx`, `nodes` (lumped there), `inlet` and `outlet`."""

    coordinates: Coordinates
    flux: Value
    porosity: Value
    old_porosity: Value
    capacity: Value
    conductivity: Value
    exchange: Value
    heating: Value
    dx: ufl.Measure
    nodes: ufl.Measure
    inlet: ufl.Measure
    outlet: ufl.Measure

    def correction(self, potential: Value, imbalance: Value) -> Value:
        """Form of div grad psi = `imbalance` (1/s, a field at the nodes)."""
        test = ufl.TestFunction(potential.function_space)
        return ufl.dot(ufl.grad(potential), ufl.grad(test)) * self.dx - imbalance * test * self.nodes

    def imbalance(
        self,
        test: Value,
        inverse_step: Value,
        flux: Value,
        inflow: Value,
        out: Value,
    ) -> Value:
        """Form of the volume that the gas gains beyond what `flux` (m/s) brings, with `out` and `inflow` at the boundary."""
        gained = inverse_step * (self.porosity - self.old_porosity) * test * self.nodes
        return gained - ufl.dot(flux, ufl.grad(test)) * self.dx + out * test * self.outlet - inflow * test * self.inlet

    def residual(
        self,
        temperature: Value,
        old: Value,
        inverse_step: Value,
        inflow: Value,
        inlet_temperature: Value,
        out: Value,
    ) -> Value:
        """Form of the heat balance, W against the test; `out` (m/s) leaves through the outlet, `inflow` enters."""
        test = ufl.TestFunction(temperature.function_space)
        stored = inverse_step * (self.porosity * temperature - self.old_porosity * old)
        form = (self.capacity * stored + self.exchange * temperature - self.heating) * test * self.nodes
        form -= self.capacity * temperature * ufl.dot(self.flux, ufl.grad(test)) * self.dx
        form += self.capacity * (
            out * temperature * test * self.outlet - inflow * inlet_temperature * test * self.inlet
        )
        form += self.porosity * self.conductivity * ufl.dot(ufl.grad(temperature), ufl.grad(test)) * self.dx
        along = ufl.dot(self.flux, ufl.dot(metric(self.coordinates.mesh), self.flux)) + 1e-20
        upwind = ufl.dot(self.flux, ufl.grad(temperature)) * ufl.dot(self.flux, ufl.grad(test)) / ufl.sqrt(along)
        return form + self.capacity * upwind * self.dx
