r"""Beads that move as a plug along the flow or against it: a moving-bed heat exchanger.

    beads: (1-phi) (d rho_s h_s/dt + v_s d(rho_s h_s)/dx) = div(K_s grad T_s) - a_v h_sf (T_s - T_f)

with v_s the velocity of the beads (m/s, positive along x[0]) and h_s their enthalpy. They enter with a given temperature at the
end that they come from, and leave at the other one; both are fluxes through the boundary:

    (1-phi) |v_s| rho_s h_s(T_in) where they enter,    (1-phi) |v_s| rho_s h_s(T_s) where they leave,

so that the discrete heat balance closes. The test functions are upwinded along the motion of the beads (SUPG),

    v + chi D v,    chi = c/sqrt(c^2 + r^2),    c = (1-phi) rho_s C_s |v_s|/(h/2),    r = a_v h_sf,

in storage, advection and exchange alike, D v the change of v over half a cell along the motion. Drag, heat exchange, dispersion
and the beads' sources of turbulence follow u - v_s. The porosity is that of the bed at rest.
"""

from dataclasses import dataclass
from typing import Any

import ufl

from ..laws.functions import Value
from ..laws.materials import Solid
from .coordinates import Coordinates
from .stabilisation import metric


@dataclass(frozen=True)
class MovingBeads:
    """Motion of the beads: `velocity` along x[0] (m/s, a constant other than 0), its `sign`, and their `inlet_temperature` (K);
    `entering` and `leaving` are the facets through which they come and go."""

    velocity: Any
    sign: float
    inlet_temperature: Any
    entering: ufl.Measure
    leaving: ufl.Measure

    def upwinding(
        self, coordinates: Coordinates, beads: Solid, solid_part: Value, exchange: Value, test: Value
    ) -> Value:
        """chi D v: what the test function gains along the motion. `solid_part` is 1 - phi, `exchange` a_v h_sf (W/m3/K)."""
        half_cell = 1.0 / ufl.sqrt(metric(coordinates.mesh)[0, 0])
        capacity = beads.density(self.inlet_temperature) * beads.heat_capacity(self.inlet_temperature)
        carried = solid_part * capacity * abs(self.velocity) / half_cell
        return carried / ufl.sqrt(carried**2 + exchange**2) * self.sign * half_cell * test.dx(0)

    def outflow(
        self,
        heat: Value,
        capacity: Value,
        temperature: Value,
        test: Value,
        upwinding: Value,
        weight: Value,
        dx: ufl.Measure,
    ) -> Value:
        """Form of the heat that the motion carries away, W against the test: of `heat` (J/m3) with `capacity` (J/m3/K) of the
        beads' volume; `weight` holds 1 - phi."""
        inside = self.velocity * (capacity * temperature.dx(0) * upwinding - heat * test.dx(0))
        return weight * inside * dx + weight * abs(self.velocity) * heat * test * self.leaving

    def inflow(self, heat: Value, test: Value, weight: Value) -> Value:
        """Form of the heat that comes in with beads of `heat` (J/m3), W against the test."""
        return weight * abs(self.velocity) * heat * test * self.entering
