r"""Beads that move as a plug along the flow or against it: a moving-bed heat exchanger.

    beads: (1-phi) (d rho_s h_s/dt + v_s d(rho_s h_s)/dx) = div(K_s grad T_s) - a_v h_sf (T_s - T_f)

with v_s the velocity of the beads (m/s, positive along x[0]) and h_s their enthalpy. They enter with a given temperature at the
end that they come from, and leave at the other one; both are fluxes through the boundary:

    (1-phi) |v_s| rho_s h_s(T_in) where they enter,    (1-phi) |v_s| rho_s h_s(T_s) where they leave,

so that the discrete heat balance closes. The test functions are upwinded along the motion of the beads (SUPG),

    v + chi D v,    chi = c/sqrt(c^2 + r^2),    c = (1-phi) rho_s C_s |v_s|/(h/2),    r = a_v h_sf,

in storage, advection and exchange alike, D v the change of v over half a cell along the motion. In monotone cells
(`streamline.Streamline`) chi is 1 in the advection and 0 in what is stored and exchanged, which is lumped there. Drag, heat
exchange, dispersion and the beads' sources of turbulence follow u - v_s. The porosity is that of the bed at rest.
"""

from dataclasses import dataclass

import ufl

from ..laws.functions import Value
from .coordinates import Coordinates
from .medium import Bed
from .stabilisation import metric
from .streamline import Streamline
from .wall import volumetric_heat


@dataclass(frozen=True, kw_only=True)
class MovingBeads:
    """Motion of the beads of a `bed`: `velocity` along x[0] (m/s, a constant other than 0), its `sign`, and their
    `inlet_temperature` (K); `entering` and `leaving` are the facets through which they come and go, `dx` measures the bed."""

    bed: Bed
    coordinates: Coordinates
    velocity: Value
    sign: float
    inlet_temperature: Value
    entering: ufl.Measure
    leaving: ufl.Measure
    dx: ufl.Measure

    @property
    def _solid_part(self) -> Value:
        return 1.0 - self.bed.porosity

    def _capacity(self, temperature: Value) -> Value:
        return self.bed.beads.density(temperature) * self.bed.beads.heat_capacity(temperature)

    def _carried(self, temperature: Value) -> Value:
        """Heat that beads of a temperature carry through a section, W/m2."""
        weight = self.coordinates.weight * self._solid_part
        return weight * abs(self.velocity) * volumetric_heat(self.bed.beads, temperature)

    def _change(self, test: Value) -> Value:
        """D v, downstream of the beads."""
        return self.sign / ufl.sqrt(metric(self.coordinates.mesh)[0, 0]) * test.dx(0)

    def upwinding(self, exchange: Value, test: Value, streamline: Streamline) -> Value:
        """chi D v: what the test function gains along the motion; `exchange` is a_v h_sf (W/m3/K)."""
        half_cell = 1.0 / ufl.sqrt(metric(self.coordinates.mesh)[0, 0])
        carried = self._solid_part * self._capacity(self.inlet_temperature) * abs(self.velocity) / half_cell
        return (1.0 - streamline.monotone) * carried / ufl.sqrt(carried**2 + exchange**2) * self._change(test)

    def outflow_of_heat(
        self, temperature: Value, test: Value, exchange: Value, excess: Value, streamline: Streamline
    ) -> Value:
        """Form of the heat that the motion carries away, and of the `exchange` (W/m3/K), driven by `excess` (K), along it."""
        upwinding, capacity = self.upwinding(exchange, test, streamline), self._capacity(temperature)
        fully = streamline.monotone * self._change(test)
        along = capacity * temperature.dx(0) * (upwinding + fully)
        along -= volumetric_heat(self.bed.beads, temperature) * test.dx(0)
        across = streamline.changes_across(temperature, test)
        for w, (f, v) in across:
            along += w * capacity * (f.dx(0) * self._change(v) - f * v.dx(0))
        form = (
            self.coordinates.weight
            * (self._solid_part * self.velocity * along - exchange * excess * upwinding)
            * self.dx
        )
        passing = self.coordinates.weight * self._solid_part * abs(self.velocity)
        form += self._carried(temperature) * test * self.leaving
        for w, (f, v) in across:
            form += passing * w * capacity * f * v * self.leaving
        return form - self._carried(self.inlet_temperature) * test * self.entering

    def carried_at_the_nodes(self, properties: Value, temperature: Value, test: Value) -> Value:
        """Heat that the motion carries from node to node, fully upwinded, with properties at a temperature (K), W/m3."""
        carried = self._solid_part * self._capacity(properties) * self.velocity
        return carried * temperature.dx(0) * (test + self._change(test))

    def heat_brought(self, temperature: Value) -> Value:
        """Form (scalar, W) of the heat that the beads bring beyond what they take away."""
        return self._carried(self.inlet_temperature) * self.entering - self._carried(temperature) * self.leaving
