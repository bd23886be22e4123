r"""Heat in the wall: its part of the energy balance (`equations.energy`).

    rho_w C_w dT_w/dt = div(lambda_w grad T_w) + rho_w H d alpha/dt + q

The wall may have layers, each with its own rho_w, C_w, lambda_w (along the layer another one than through it), heat of cure H
of its degree of cure alpha (`laws.cure`) and source q. As -rho_w H alpha is part of the stored heat, the balance closes with it.
A thin wall (`ThinWall`) has no cells: its storage and its conduction along the surface are terms on the interface.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import ufl

from ..laws.conductivity import STEFAN_BOLTZMANN
from ..laws.functions import Value
from ..laws.materials import Solid
from .coordinates import Coordinates


def volumetric_heat(solid: Solid, temperature: Value) -> Value:
    """Enthalpy per volume rho int C dT of a solid, J/m3."""
    return solid.density(temperature) * solid.heat_capacity.integral(temperature)


@dataclass(frozen=True)
class OuterWall:
    """Heat exchange of the outer wall: `heat_flux` into the wall (W/m2), `coefficient` (W/m2/K) and radiation by an `emissivity`
    to `ambient` (K), which is large and dark."""

    ds: ufl.Measure
    heat_flux: Value = None
    coefficient: Value = None
    ambient: Value = None
    emissivity: Value = None

    def into_wall(self, temperature: Value) -> Value:
        """Heat flux into the wall, W/m2."""
        flux = 0.0
        if self.heat_flux is not None:
            flux += self.heat_flux
        if self.coefficient is not None:
            flux += self.coefficient * (self.ambient - temperature)
        if self.emissivity is not None:
            flux += self.emissivity * STEFAN_BOLTZMANN * (self.ambient**4 - temperature**4)
        return flux


@dataclass(frozen=True)
class ThinWall:
    """A wall of one temperature through its thickness, on the facets `ds` of the interface, `nodes` with quadrature at the nodes.

    `volume` is its volume and `outer_area` its outer surface, per area of the interface (m, 1).
    """

    ds: ufl.Measure
    volume: Value
    outer_area: Value
    nodes: ufl.Measure


@dataclass(frozen=True)
class WallLayer:
    """A layer of the wall: its `solid` over the cell measures `dx` and `nodes` (with quadrature at the nodes), a heat `source`
    (W/m3) and the `degree` of cure of a material that cures, None without. Where it `melts`, it is lumped at the nodes in all
    cells: each node then has its own peak of the heat capacity, over which Newton's method finds its way."""

    solid: Solid
    dx: ufl.Measure
    nodes: ufl.Measure
    source: Value = None
    degree: Value = None
    melts: bool = False

    def stored_heat(self, temperature: Value) -> Value:
        """Heat per volume, that of the reaction to come included, J/m3."""
        heat = volumetric_heat(self.solid, temperature)
        if self.degree is None or self.solid.cure is None:
            return heat
        return heat - self.solid.density(temperature) * self.solid.cure.heat * self.degree


@dataclass(frozen=True)
class Wall:
    """Forms of the wall's heat: its `layers` outwards, none where the scene has no wall, at a `distance` (m) from the bed's side;
    `outer` exchanges heat with the surroundings; `thin` where the wall has no cells."""

    coordinates: Coordinates
    distance: Value
    layers: Sequence[WallLayer] = ()
    outer: OuterWall | None = None
    thin: ThinWall | None = None

    @property
    def has_heat(self) -> bool:
        """Whether it stores or exchanges any."""
        return bool(self.layers) or self.outer is not None

    def at_nodes(self) -> "Wall":
        """The same with quadrature at the nodes where the wall has no cells, of which `monotone` does not tell."""
        return self if self.thin is None else replace(self, thin=replace(self.thin, ds=self.thin.nodes))

    def stored_heat(self, temperature: Value, test: Value, monotone: Value) -> Value:
        """Form of the heat per volume (J/m3) against the test; `monotone` cells are lumped at the nodes, as is what melts."""
        if self.thin is not None:
            return self._in_thin(self.layers[0].stored_heat(temperature) * test, self.thin)
        form = 0
        for layer in self.layers:
            heat = layer.stored_heat(temperature) * test
            form += self._in_layer(layer, heat, 1.0 if layer.melts else monotone)
        return form

    def heating_rate(self, temperature: Value, rate: Value, test: Value) -> Value:
        """Form of what `stored_heat` gains for dT/dt (K/s), `rate`."""
        form = 0
        for layer in self.layers:
            solid = layer.solid
            heating = solid.density(temperature) * solid.heat_capacity(temperature) * rate * test
            if self.thin is not None:
                return self._in_thin(heating, self.thin)
            form += self.coordinates.weight * heating * layer.dx
        return form

    def outflow_of_heat(self, temperature: Value, test: Value, monotone: Value) -> Value:
        """Form of everything but the storage: what leaves each place, W against the test."""
        form = 0
        if self.thin is not None:
            along, test_along = (self._along(ufl.grad(f)) for f in (temperature, test))
            solid = self.layers[0].solid
            conductivity = (solid.conductivity_in_plane or solid.conductivity)(temperature)
            form += self._in_thin(conductivity * ufl.dot(along, test_along), self.thin)
        else:
            for layer in self.layers:
                form += self._in_layer(layer, self._conducted_in(layer.solid, temperature, test), monotone)
                if layer.source is not None:
                    form -= self.coordinates.weight * layer.source * test * layer.dx
        if self.outer is not None:
            form -= self._outer_weight * self.outer.into_wall(temperature) * test * self.outer.ds
        return form

    def heat_kept(self, temperature: Value, initial: Value) -> dict[str, Value]:
        """Forms (scalar, J) of the heat that the "wall" has gained since the `initial` temperature, and of what was set free by
        "cure"."""
        weight = self.coordinates.weight
        kept: dict[str, list[Value]] = {"wall": [], "cure": []}
        for layer in self.layers:
            gained = volumetric_heat(layer.solid, temperature) - volumetric_heat(layer.solid, initial)
            kept["wall"].append(weight * gained * layer.dx if self.thin is None else self._in_thin(gained, self.thin))
            if layer.degree is not None and layer.solid.cure is not None:
                cure = layer.solid.cure
                released = layer.solid.density(temperature) * cure.heat * (layer.degree - cure.initial)
                kept["cure"].append(weight * released * layer.dx)
        return {name: sum(forms) for name, forms in kept.items() if forms}

    def heat_through_outer_wall(self, temperature: Value) -> Value:
        """Form (scalar, W) of the heat that enters through the outer wall; None where it is insulated."""
        if self.outer is None:
            return None
        return self._outer_weight * self.outer.into_wall(temperature) * self.outer.ds

    def heat_by_sources(self) -> Value:
        """Form (scalar, W) of what the sources in the wall's layers give; None without them."""
        given = [self.coordinates.weight * layer.source * layer.dx for layer in self.layers if layer.source is not None]
        return sum(given) if given else None

    @property
    def _outer_weight(self) -> Value:
        area = 1.0 if self.thin is None else self.thin.outer_area
        return self.coordinates.weight * area

    def _in_thin(self, integrand: Value, thin: ThinWall) -> Value:
        return self.coordinates.weight * thin.volume * integrand * thin.ds

    def _in_layer(self, layer: WallLayer, integrand: Value, monotone: Value) -> Value:
        """Integral over a layer of the wall, in monotone cells with quadrature at the nodes."""
        form = self.coordinates.weight * (1.0 - monotone) * integrand * layer.dx
        return form + self.coordinates.nodal_weight * monotone * integrand * layer.nodes

    def _conducted_in(self, solid: Solid, temperature: Value, test: Value) -> Value:
        """Conduction in a layer, W/m3 against the test: through it with one conductivity, along it with another if it has one."""
        gradient, test_gradient, through = ufl.grad(temperature), ufl.grad(test), solid.conductivity(temperature)
        if solid.conductivity_in_plane is None:
            return through * ufl.dot(gradient, test_gradient)
        along, outwards = solid.conductivity_in_plane(temperature), ufl.grad(self.distance)
        crossing = ufl.dot(gradient, outwards) * ufl.dot(test_gradient, outwards) / ufl.dot(outwards, outwards)
        return along * ufl.dot(gradient, test_gradient) + (through - along) * crossing

    def _along(self, vector: Value) -> Value:
        normal = ufl.FacetNormal(self.coordinates.mesh)
        return vector - ufl.dot(vector, normal) * normal
