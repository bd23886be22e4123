r"""Intrinsic time scales of the residual-based stabilisation (SUPG, PSPG) on anisotropic cells.

With the metric G = 4 K^T K of the map from the reference cell (K its inverse Jacobian; G -> 4/h^2 on a rectangle's
axes), tau = [ (a.G a) + (12/4)^2 m^2 G:G + s^2 ]^-1/2 for advection a, diffusion m and reaction s: the smallest of
h/2|a|, h^2/12m and 1/s, direction by direction (Shakib, Hughes, Johan, CMAME 89 (1991) 141-219).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import ufl
from dolfinx import fem
from ufl.checks import is_cellwise_constant

from ..laws.functions import Value
from ..mesh import fenicsx
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


def _sides(
    coordinates: Coordinates, advection: Value, metric_tensor: Value, straight: bool
) -> tuple[Value, tuple[tuple[Value, Value], ...]]:
    """Direction of the side that a cell has along the flow (None for simplices), and what it has across it, as
    `Streamline.across`."""
    dimension = len(advection)
    if straight:
        axes = [ufl.as_vector([float(i == axis) for i in range(dimension)]) for axis in range(dimension)]
        sign = ufl.conditional(ufl.lt(advection[0], 0.0), -1.0, 1.0)
        return sign * axes[0], tuple((axes[i], 1.0 / metric_tensor[i, i]) for i in range(1, dimension))
    if fenicsx.cell_name(coordinates.mesh) not in ("quadrilateral", "hexahedron"):
        return None, ()
    jacobian = ufl.Jacobian(coordinates.mesh)
    crossed = ufl.dot(ufl.JacobianInverse(coordinates.mesh), advection)  # reference cells a second, nearly
    along, flow, others = 0.5 * jacobian[:, 0], crossed[0], [0.5 * jacobian[:, i] for i in range(1, dimension)]
    for i in range(1, dimension):
        more = ufl.gt(abs(crossed[i]), abs(flow))
        this = 0.5 * jacobian[:, i]
        others[i - 1] = ufl.conditional(more, along, this)
        along, flow = ufl.conditional(more, this, along), ufl.conditional(more, crossed[i], flow)
    side = ufl.conditional(ufl.lt(flow, 0.0), -1.0, 1.0) * along
    return side / ufl.sqrt(ufl.dot(side, side)), tuple((other, 1.0) for other in others)


@dataclass(frozen=True)
class Streamline:
    r"""Upwinding of heat that a flow carries through the cells and exchanges with the beads on its way.

    `reach` is half a cell along the flow (a vector, m); D f = reach.grad f is half the change of f over a cell. `upwind`
    is chi = 2 tau |a|/h: 1 where the flow wins over conduction across the cell and over exchange, 0 where it loses.
    Cells with `monotone` = 1, else 0, trade second order for bounds: there chi = 1, what is stored and exchanged is lumped
    along the flow, the fluid's balance is that of the cell's downstream end, and `fitting` (beta) leaves to that end as
    much of the exchange as keeps every node an average of its upstream neighbour and its beads. There the flow counts as
    along the cell's own sides, and all of it is lumped `across` the flow, too: pairs of a direction and the square of half a
    cell (m2), or of half a cell (m) and 1. Triangles and tetrahedra but for those of a straight bed are `SimplexStreamline`.
    """

    reach: Any
    upwind: Any
    fitting: Any
    exchange: Any
    monotone: Any
    from_middle: Any
    across: tuple[tuple[Value, Value], ...] = ()

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
        *,
        upwinded: bool = True,
    ) -> Value:
        """For heat carried along `advection` (W/m2/K), conducted by `diffusion` (W/m/K), exchanged by `exchange` (W/m3/K
        or None).

        `entrance` is 1 in the cells at the inlet, where conduction across flat cells must not weaken the upwinding. What is not
        `upwinded` is upwinded in monotone cells alone.
        """
        metric_tensor = metric(coordinates.mesh)
        speed = ufl.sqrt(ufl.dot(advection, advection) + 1e-30)
        if exchange is None:
            exchange = fem.Constant(coordinates.mesh, 0.0)
        direction = advection / speed
        side, across = _sides(coordinates, advection, metric_tensor, straight)
        if side is not None:  # monotone only along the cells themselves: a slight slope crosses many of the flat ones
            direction = ufl.conditional(ufl.gt(monotone, 0.5), side, direction)
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
        upwind = monotone + (1.0 - monotone) * upwind if upwinded else monotone + 0.0 * carried
        fitting = 1.0 - carried / (exchange + 1e-30)
        fitting = ufl.conditional(ufl.gt(fitting, 0.0), fitting, 0.0)
        parts = direction / inverse, upwind, fitting, exchange, monotone, coordinates.from_middle, across
        if side is not None:
            return cls(*parts)
        return SimplexStreamline(*parts, **SimplexStreamline.of_cell(coordinates.mesh, advection, diffusion))

    def held(self, of_cell: Callable[[Value], Value], at_points: Callable[[Value], Value]) -> "Streamline":
        """The same of held values: those `of_cell(expression)`, one in each cell, and those `at_points(expression)`."""
        return replace(
            self,
            reach=at_points(self.reach),
            upwind=at_points(self.upwind),
            fitting=of_cell(self.fitting),
            exchange=of_cell(self.exchange),
            # half a cell is held, as the gradient of a gradient along it is taken
            across=tuple((d if is_cellwise_constant(d) else of_cell(d), square) for d, square in self.across),
        )

    def changes_across(self, *functions: Any) -> Value:
        """Weights with the functions' changes across the cell: what lumps a product, added up, where monotone.

        For linear f and g, the integral of f g + 2/3 (h/2)^2 f' g' is that of their product at the nodes.
        """
        terms = [(1.0, functions)]
        for direction, square in self.across:
            factor = 2.0 / 3.0 * self.monotone * square
            terms += [(w * factor, tuple(ufl.dot(direction, ufl.grad(f)) for f in changed)) for w, changed in terms]
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

    def _lumping(self, gradient: Value, test: Value) -> Value:
        """What brings the integral of a function, with its `gradient`, times a test to that at the nodes."""
        return 2.0 / 3.0 * ufl.dot(self.reach, gradient) * self.along(test)

    def lumped(self, value: Value, gradient: Value, test: Value) -> Value:
        """Storage of `value`, with its `gradient`, where nothing flows."""
        return value * test + self.monotone * self._lumping(gradient, test)

    def lumped_downstream(self, value: Value, gradient: Value, test: Value) -> Value:
        """Storage of `value`, with its `gradient`, in what flows."""
        upwinded = (1.0 - self.monotone) * self.upwind * value * self.along(test)
        return value * test + upwinded + self.monotone * self._lumping(gradient, test)

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

    def entered(self, coefficient: Value, value: Value, test: Value) -> Value:
        """What entering through the inlet with a `coefficient` gains by the lumping, per area."""
        return sum(w * coefficient * f * v for w, (f, v) in self.changes_across(value, test))


@dataclass(frozen=True)
class SimplexStreamline(Streamline):
    r"""The same in triangles and tetrahedra that lie in any way: monotone cells are lumped at their vertices there.

    With V = sum (x_i - x_c)(x_i - x_c)^T of the vertices and their middle, in d dimensions,

        int f g + grad f.V grad g/(d+2) = |K|/(d+1) sum f_i g_i,    int grad f.V grad g = |K| sum (f_i - f_c)(g_i - g_c),

    so that m grad f.V grad g, m = `crossing` (W/m3/K), takes |K|/(d+1) m from each entry off the diagonal of the cell's matrix:
    with the largest of a.grad v_j of the nodes' functions, and (d+1) times that of grad v_i.K grad v_j, none is left positive
    (discrete upwinding: Guermond, Nazarov, Comput. Methods Appl. Mech. Eng. 272 (2014) 198-213).
    """

    vertices: Any = None
    crossing: Any = None

    @staticmethod
    def of_cell(mesh: Any, advection: Value, diffusion: Value) -> dict[str, Value]:
        """`vertices` and `crossing` of the cells for heat carried along `advection` (W/m2/K) and conducted by `diffusion`."""
        jacobian, inverse, dimension = ufl.Jacobian(mesh), ufl.JacobianInverse(mesh), mesh.geometry.dim
        ones = ufl.as_vector([1.0] * dimension)
        vertices = jacobian * (ufl.Identity(dimension) - ufl.outer(ones, ones) / (dimension + 1.0)) * jacobian.T
        gradients = [inverse[i, :] for i in range(dimension)]
        gradients = [-sum(gradients[1:], gradients[0]), *gradients]
        carried = [ufl.dot(advection, gradient) for gradient in gradients]
        conducted = [
            ufl.dot(gradients[i], flux_density(diffusion, gradients[j])) for j in range(dimension + 1) for i in range(j)
        ]
        return {
            "vertices": vertices,
            "crossing": _largest(carried) + (dimension + 1.0) * ufl.max_value(_largest(conducted), 0.0),
        }

    def held(self, of_cell: Callable[[Value], Value], at_points: Callable[[Value], Value]) -> Streamline:
        return replace(super().held(of_cell, at_points), crossing=at_points(self.crossing))

    def _lumping(self, gradient: Value, test: Value) -> Value:
        return ufl.dot(gradient, self.vertices * ufl.grad(test)) / (len(self.reach) + 2.0)

    def downstream(self, test: Value) -> Value:
        return test + (1.0 - self.monotone) * self.upwind * self.along(test)

    def conducted(self, conductivity: Value, function: Value, test: Value) -> Value:
        plain = ufl.dot(flux_density(conductivity, ufl.grad(function)), ufl.grad(test))
        return plain + self.monotone * self.crossing * ufl.dot(ufl.grad(function), self.vertices * ufl.grad(test))

    def exchanged(self, coefficient: Value, value: Value, test: Value) -> Value:
        nodal = value * test + self._lumping(ufl.grad(value), test)
        return (1.0 - self.monotone) * coefficient * value * test + self.monotone * self.exchange * nodal

    def exchanged_downstream(self, coefficient: Value, value: Value, test: Value) -> Value:
        nodal = value * test + self._lumping(ufl.grad(value), test)
        upwinded = coefficient * value * (test + self.upwind * self.along(test))
        return (1.0 - self.monotone) * upwinded + self.monotone * self.exchange * nodal

    def entered(self, coefficient: Value, value: Value, test: Value) -> Value:
        jacobian = ufl.classes.FacetJacobian(value.ufl_domain())
        dimension = len(self.reach)
        ones = ufl.as_vector([1.0] * (dimension - 1))
        vertices = jacobian * (ufl.Identity(dimension - 1) - ufl.outer(ones, ones) / dimension) * jacobian.T
        lumping = ufl.dot(ufl.grad(value), vertices * ufl.grad(test)) / (dimension + 1.0)
        return self.monotone * coefficient * lumping


def _largest(values: list[Value]) -> Value:
    largest = values[0]
    for value in values[1:]:
        largest = ufl.max_value(largest, value)
    return largest
