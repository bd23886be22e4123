r"""Intrinsic time scales of the residual-based stabilisation (SUPG, PSPG) on anisotropic cells.

With the metric G = 4 K^T K of the map from the reference cell (K its inverse Jacobian; G -> 4/h^2 on a rectangle's
axes), tau = [ (a.G a) + (12/4)^2 m^2 G:G + s^2 ]^-1/2 for advection a, diffusion m and reaction s: the smallest of
h/2|a|, h^2/12m and 1/s, direction by direction (Shakib, Hughes, Johan, CMAME 89 (1991) 141-219).
"""

from dataclasses import dataclass
from typing import Any

import ufl
from dolfinx import fem

from ..laws.functions import Value
from .coordinates import Coordinates


def metric(mesh: Any) -> Value:
    """G = 4 K^T K of the mesh's cells."""
    inverse = ufl.JacobianInverse(mesh)
    return 4.0 * inverse.T * inverse


def time_scale(metric_tensor: Value, advection: Value, diffusion: Value, reaction: Value) -> Value:
    """tau for a vector `advection` and scalars `diffusion` and `reaction`, in the inverse unit of `reaction`."""
    return 1.0 / ufl.sqrt(
        ufl.dot(advection, ufl.dot(metric_tensor, advection))
        + 9.0 * diffusion**2 * ufl.inner(metric_tensor, metric_tensor)
        + reaction**2
    )


def streamline_time_scale(metric_tensor: Value, advection: Value, diffusion: Value) -> Value:
    """tau = [a.G a + 9 m^2 (a.G a/|a|^2)^2]^-1/2: the cell's size along the flow only, whatever its height."""
    along = ufl.dot(advection, ufl.dot(metric_tensor, advection)) + 1e-30
    spread = diffusion * along / (ufl.dot(advection, advection) + 1e-30)
    return 1.0 / ufl.sqrt(along + 9.0 * spread**2)


def _is_tensor(conductivity: Value) -> bool:
    return bool(getattr(conductivity, "ufl_shape", ()))


def flux_density(conductivity: Value, gradient: Value) -> Value:
    """K grad f of a number or a tensor K."""
    return ufl.dot(conductivity, gradient) if _is_tensor(conductivity) else conductivity * gradient


@dataclass(frozen=True)
class Streamline:
    r"""Upwinding of heat that a flow carries through the cells and exchanges with the beads on its way.

    `reach` is half a cell along the flow (a vector, m); D f = reach.grad f is half the change of f over a cell. `upwind`
    is chi = 2 tau |a|/h: 1 where the flow wins over conduction across the cell and over exchange, 0 where it loses.
    Cells with `monotone` = 1, else 0, trade second order for bounds: there chi = 1, what is stored and exchanged is lumped
    along the flow, the fluid's balance is that of the cell's downstream end, and `fitting` (beta) leaves to that end as
    much of the exchange as keeps every node an average of its upstream neighbour and its beads. Where the cells lie along
    the flow, all of it is lumped `across` the flow, too: pairs of an axis and the square of half a cell (m2).
    """

    reach: Any
    upwind: Any
    fitting: Any
    exchange: Any
    monotone: Any
    from_middle: Any
    across: tuple[tuple[int, Value], ...] = ()

    @classmethod
    def of(
        cls,
        coordinates: Coordinates,
        advection: Value,
        diffusion: Value,
        exchange: Value,
        entrance: Value,
        monotone: Value,
        straight: bool,
    ) -> Value:
        """For heat carried along `advection` (W/m2/K), conducted by `diffusion` (W/m/K), exchanged by `exchange` (W/m3/K
        or None).

        `entrance` is 1 in the cells at the inlet, where conduction across flat cells must not weaken the upwinding.
        """
        metric_tensor = metric(coordinates.mesh)
        speed = ufl.sqrt(ufl.dot(advection, advection) + 1e-30)
        if exchange is None:
            exchange = fem.Constant(coordinates.mesh, 0.0)
        direction = advection / speed
        if straight:  # monotone only along the cells themselves: a slight slope crosses many of the flat ones
            sign = ufl.conditional(ufl.lt(advection[0], 0.0), -1.0, 1.0)
            along = ufl.as_vector([sign] + [0.0] * (len(advection) - 1))
            direction = ufl.conditional(ufl.gt(monotone, 0.5), along, direction)
        inverse = ufl.sqrt(ufl.dot(direction, ufl.dot(metric_tensor, direction)) + 1e-30)  # of the reach
        carried = speed * inverse
        along = ufl.dot(direction, flux_density(diffusion, direction)) * inverse**2
        if _is_tensor(diffusion):
            all_round = ufl.sqrt(ufl.inner(ufl.dot(metric_tensor, diffusion), ufl.dot(diffusion, metric_tensor)))
        else:
            all_round = diffusion * ufl.sqrt(ufl.inner(metric_tensor, metric_tensor))
        spread = ufl.conditional(ufl.gt(entrance, 0.5), along, all_round)
        reaction = (1.0 - monotone) * exchange
        upwind = carried / ufl.sqrt(carried**2 + (3.0 * spread) ** 2 + reaction**2 + 1e-60)
        upwind = monotone + (1.0 - monotone) * upwind
        fitting = 1.0 - carried / (exchange + 1e-30)
        fitting = ufl.conditional(ufl.gt(fitting, 0.0), fitting, 0.0)
        across = tuple((axis, 1.0 / metric_tensor[axis, axis]) for axis in range(1, len(advection))) if straight else ()
        return cls(direction / inverse, upwind, fitting, exchange, monotone, coordinates.from_middle, across)

    def changes_across(self, *functions: Any) -> Value:
        """Weights with the functions' changes across the cell: what lumps a product, added up, where monotone.

        For linear f and g, the integral of f g + 2/3 (h/2)^2 f' g' is that of their product at the nodes.
        """
        terms = [(1.0, functions)]
        for axis, square in self.across:
            factor = 2.0 / 3.0 * self.monotone * square
            terms += [(w * factor, tuple(f.dx(axis) for f in changed)) for w, changed in terms]
        return terms[1:]

    def along(self, function: Value) -> Value:
        """D f."""
        return ufl.dot(self.reach, ufl.grad(function))

    def downstream(self, test: Value) -> Value:
        """Test function of what the flow carries; where monotone, uniform along the flow within the cell."""
        change = self.along(test)
        place = ufl.dot(self.from_middle, self.reach) / (ufl.dot(self.reach, self.reach) + 1e-60)
        return test + (self.upwind - self.monotone * place) * change

    def conducted(self, conductivity: Value, function: Value, test: Value) -> Value:
        """grad v.(K grad f), lumped along the flow where monotone; K is a number or a tensor."""
        change, test_change = (ufl.dot(ufl.grad(ufl.grad(f)), self.reach) for f in (function, test))
        plain = ufl.dot(flux_density(conductivity, ufl.grad(function)), ufl.grad(test))
        lumped = ufl.dot(flux_density(conductivity, change), test_change)
        return plain + 2.0 / 3.0 * self.monotone * lumped

    def lumped(self, value: Value, change: Value, test: Value) -> Value:
        """Storage of `value`, with `change` = D value, where nothing flows."""
        return value * test + 2.0 / 3.0 * self.monotone * change * self.along(test)

    def lumped_downstream(self, value: Value, change: Value, test: Value) -> Value:
        """Storage of `value`, with `change` = D value, in what flows."""
        upwinded, lumped = (1.0 - self.monotone) * self.upwind * value, 2.0 / 3.0 * self.monotone * change
        return value * test + (upwinded + lumped) * self.along(test)

    def exchanged(self, coefficient: Value, value: Value, test: Value) -> Value:
        """Exchange of `value` as the beads have it, with the local `coefficient` or, where monotone, the cell's."""
        change, test_change = self.along(value), self.along(test)
        nodal = value * test + 2.0 / 3.0 * change * test_change + self.fitting * (change * test + value * test_change)
        return (1.0 - self.monotone) * coefficient * value * test + self.monotone * self.exchange * nodal

    def exchanged_downstream(self, coefficient: Value, value: Value, test: Value) -> Value:
        """Exchange of `value` as the fluid has it; for a uniform test the same as `exchanged`."""
        change, test_change = self.along(value), self.along(test)
        nodal = (value + self.fitting * change) * (test + test_change) - change * test_change / 3.0
        upwinded = coefficient * value * (test + self.upwind * test_change)
        return (1.0 - self.monotone) * upwinded + self.monotone * self.exchange * nodal
