r"""Flow of any geometry whose profile from the wall is everywhere the developed one of the local pressure gradient.

    div q = 0,   q = phi rho u,   u = (d^2/mu) m(y/d, G) D,   D = rho g - grad p,   G = rho |D| d^3/mu^2

In units of nu/d developed profiles depend on the wall distance y/d and on G alone, and so do the turbulence's unknowns in
theirs, k = (nu/d)^2 K(y/d, G), epsilon = (nu^3/d^4) E(y/d, G): neither temperature nor pressure changes them otherwise, where
nu does not change across the layer at the wall. m, K and E come from developed flow over a plane bed
(`solvers.developed_profiles`). What is left is one scalar equation of the pressure. Walls and symmetry are its natural
conditions, inlet and outlet

    q.n = (phi rho d^2/mu) m (p - p_b)/l

with l a millionth of the bed's length, so that p = p_b as nearly: every test function is free there, and the heat that q
carries is conserved. With the profile m in it, p - p_b is the same from wall to wall; a constant there drives the fluid across
the last cells. Left out are the entrance, the inertia of the fluid where the section changes, what a corner of two walls adds
to the nearer one, and how the viscosity changes across the layer at a wall that is colder or hotter than the bed. About a node
the profiles follow a power law of G, f = f_n exp[s_n (ln G - g_n)].
"""

from dataclasses import dataclass
from typing import Any

import ufl

from ..laws.functions import Value
from .flow import FlowEquations, FlowState

LEAST_DRIVE = 1e-9
"""Of the reference pressure over a bead: keeps the logarithm finite where nothing drives the fluid."""


@dataclass(frozen=True)
class NodalProfile:
    """A profile at the nodes: its `value` f_n and `slope` s_n, functions."""

    value: Value
    slope: Value


@dataclass(frozen=True)
class NodalProfiles:
    """Profiles about the nodes' own `logarithm` g_n of G: m, then those of the turbulence's unknowns."""

    logarithm: Value
    fields: tuple[NodalProfile, ...]

    def at(self, logarithm: Value) -> list[Value]:
        """All of them where G has a logarithm."""
        away = logarithm - self.logarithm
        return [field.value * ufl.exp(field.slope * away) for field in self.fields]


@dataclass(frozen=True)
class LocallyDeveloped:
    """Forms of that flow for a gauge `pressure` (Pa, a function), at a `temperature` (K), with `profiles`.

    `at_boundary` (Pa, a function) is p_b at the nodes of inlet and outlet, `length_of_loss` l (m), a constant.
    """

    equations: FlowEquations
    pressure: Value
    temperature: Value
    profiles: NodalProfiles
    at_boundary: Value
    length_of_loss: Value

    @property
    def _density(self) -> Value:
        return self.equations.fluid.density(self.pressure, self.temperature)

    @property
    def _viscosity(self) -> Value:
        return self.equations.fluid.fluid.viscosity(self.temperature)

    @property
    def driving(self) -> Value:
        """D, Pa/m."""
        force = -ufl.grad(self.pressure)
        gravity = self.equations.gravity
        return force if gravity is None else force + self._density * gravity

    @property
    def logarithm(self) -> Value:
        """ln G."""
        scales, diameter = self.equations.scales, self.equations.bed.bead_diameter
        least = LEAST_DRIVE * scales.pressure / scales.length
        squared = ufl.dot(self.driving, self.driving) + least**2
        return 0.5 * ufl.ln(squared) + ufl.ln(self._density * diameter**3 / self._viscosity**2)

    @property
    def state(self) -> FlowState:
        """Velocity, pressure and turbulence, with units."""
        bed, model = self.equations.bed, self.equations.model
        mobility, *turbulence = self.profiles.at(self.logarithm)
        speed = self._viscosity / self._density / bed.bead_diameter
        sizes = () if model is None else model.magnitudes(speed, bed.bead_diameter)
        velocity = bed.bead_diameter**2 / self._viscosity * mobility * self.driving
        unknowns = tuple(size * profile for size, profile in zip(sizes, turbulence, strict=True))
        return FlowState(velocity, self.pressure, unknowns)

    @property
    def mass_flux(self) -> Value:
        """q, kg/m2/s."""
        return self.equations.bed.porosity * self._density * self.state.velocity

    @property
    def conductance(self) -> Value:
        """Of inlet and outlet, kg/m2/s/Pa, with the nodes' profile as it was found last."""
        return self._permeance(self.profiles.fields[0].value) / self.length_of_loss

    def _permeance(self, mobility: Value) -> Value:
        bed = self.equations.bed
        return bed.porosity * self._density * bed.bead_diameter**2 / self._viscosity * mobility

    @property
    def outward(self) -> Value:
        """q.n at inlet and outlet, kg/m2/s."""
        return self.conductance * (self.pressure - self.at_boundary)

    def residual(self, test: Value, dx: ufl.Measure, openings: ufl.Measure) -> Value:
        """Form of the mass balance over the bed `dx` with its `openings`, kg/s against the test."""
        weight = self.equations.coordinates.weight
        form = weight * self.outward * test * openings - weight * ufl.dot(self.mass_flux, ufl.grad(test)) * dx
        expansion = self.equations.expansion
        return form if expansion is None else form - weight * expansion * test * dx

    def nearby(self, trial: Value, test: Value, permeance: Value, nodes: ufl.Measure, openings: ufl.Measure) -> Value:
        """Bilinear form near its derivative with products at the nodes, an M-matrix of flat hexahedra: `permeance` is
        `middle_permeance` in the cells' middles (else the line of nodes in a corner of two walls would conduct nothing)."""
        along = permeance * ufl.dot(ufl.grad(trial), ufl.grad(test))
        weight = self.equations.coordinates.nodal_weight
        return weight * along * nodes + weight * self.conductance * trial * test * openings

    @property
    def middle_permeance(self) -> Value:
        """q over D, kg/m/s/Pa."""
        return self._permeance(self.profiles.at(self.logarithm)[0])


@dataclass(frozen=True)
class CarriedByPressure(FlowEquations):
    """`FlowEquations` whose mass flux is that of a `LocallyDeveloped` flow."""

    local: Any = None

    def mass_flux(self, state: FlowState, temperature: Value) -> Value:
        return self.local.mass_flux

    def mass_flux_through_boundary(self, state: FlowState, temperature: Value) -> Value:
        return self.local.outward * ufl.FacetNormal(self.coordinates.mesh)
