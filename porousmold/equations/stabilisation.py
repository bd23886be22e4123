r"""Intrinsic time scales of the residual-based stabilisation (SUPG, PSPG) on anisotropic cells.

With the metric G = 4 K^T K of the map from the reference cell (K its inverse Jacobian; G -> 4/h^2 on a rectangle's
axes), tau = [ (a.G a) + (12/4)^2 m^2 G:G + s^2 ]^-1/2 for advection a, diffusion m and reaction s: the smallest of
h/2|a|, h^2/12m and 1/s, direction by direction (Shakib, Hughes, Johan, CMAME 89 (1991) 141-219).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

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


class Crossing(NamedTuple):
    """What a cell has across the flow: half a cell as `direction` times the root of `square` (m2, or m and 1), and the `covector`
    whose product with a vector is its component by `direction`."""

    direction: Value
    square: Value
    covector: Value


class _Sides(NamedTuple):
    """Sides of a cell: half a cell `along` the flow, downstream (a vector, m), the flow's component by it `rate`, and what there
    is `across`."""

    along: Value
    rate: Value
    across: tuple[Crossing, ...]


def _sides(coordinates: Coordinates, advection: Value, metric_tensor: Value, straight: bool) -> _Sides | None:
    """Sides of a cell with a flow; None of simplices that lie in any way."""
    dimension = len(advection)
    if straight:
        axes = [ufl.as_vector([float(i == axis) for i in range(dimension)]) for axis in range(dimension)]
        across = tuple(Crossing(axes[i], 1.0 / metric_tensor[i, i], axes[i]) for i in range(1, dimension))
        row = ufl.sqrt(metric_tensor[0, 0])
        return _Sides(_sign(advection[0]) / row * axes[0], row * abs(advection[0]), across)
    if fenicsx.cell_name(coordinates.mesh) not in ("quadrilateral", "hexahedron"):
        return None
    jacobian, inverse = ufl.Jacobian(coordinates.mesh), ufl.JacobianInverse(coordinates.mesh)
    halves = [0.5 * jacobian[:, i] for i in range(dimension)]
    rows = [2.0 * inverse[i, :] for i in range(dimension)]  # a = sum of (row.a) half
    for i in range(1, dimension):
        # the side that has most of the flow, not that it crosses fastest: a flat cell's height is crossed to and fro by little
        more = ufl.gt(_part_along(halves[i], rows[i], advection), _part_along(halves[0], rows[0], advection))
        for parts in (halves, rows):
            parts[0], parts[i] = (
                ufl.conditional(more, parts[i], parts[0]),
                ufl.conditional(more, parts[0], parts[i]),
            )
    across = tuple(Crossing(half, 1.0, row) for half, row in zip(halves[1:], rows[1:], strict=True))
    rate = ufl.dot(rows[0], advection)
    return _Sides(_sign(rate) * halves[0], abs(rate), across)


def _part_along(half: Value, row: Value, advection: Value) -> Value:
    """Square of what a side has of a flow."""
    return ufl.dot(row, advection) ** 2 * ufl.dot(half, half)


def _sign(value: Value) -> Value:
    return ufl.conditional(ufl.lt(value, 0.0), -1.0, 1.0)


@dataclass(frozen=True)
class Streamline:
    r"""Upwinding of heat that a flow carries through the cells and exchanges with the beads on its way.

    `reach` is half a cell along the flow (a vector, m), in monotone cells half of the cell's own `side`; D f = reach.grad f is
    half the change of f over a cell. `upwind` is chi = 2 tau |a|/h: 1 where the flow wins over conduction across the cell and
    over exchange, 0 where it loses.
    Cells with `monotone` = 1, else 0, trade second order for bounds: there chi = 1, what is stored and exchanged is lumped
    along the flow, the fluid's balance is that of the cell's downstream end, and `fitting` (beta) leaves to that end as
    much of the exchange as keeps every node an average of its upstream neighbour and its beads. There the flow counts as
    along the cell's own sides, what crosses them is upwinded from node to node, and all is lumped `across` the flow, too.
    Triangles and tetrahedra but for those of a straight bed are `SimplexStreamline`.
    """

    along_flow: Any
    side: Any
    upwind: Any
    fitting: Any
    exchange: Any
    monotone: Any
    from_middle: Any
    across: tuple[Crossing, ...] = ()

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
        upwinding: float = 1.0,
    ) -> Value:
        """For heat carried along `advection` (W/m2/K), conducted by `diffusion` (W/m/K), exchanged by `exchange` (W/m3/K
        or None).

        `entrance` is 1 in the cells at the inlet, where conduction across flat cells must not weaken the upwinding. Cells
        that are not monotone have the part `upwinding` of it.
        """
        metric_tensor = metric(coordinates.mesh)
        speed = ufl.sqrt(ufl.dot(advection, advection) + 1e-30)
        if exchange is None:
            exchange = fem.Constant(coordinates.mesh, 0.0)
        direction = advection / speed
        sides = _sides(coordinates, advection, metric_tensor, straight)
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
        upwind = monotone + (1.0 - monotone) * upwinding * upwind
        # monotone only along the cells themselves: a slight slope crosses many of the flat ones
        side = direction / inverse if sides is None else sides.along
        fitting = 1.0 - (carried if sides is None else sides.rate) / (exchange + 1e-30)
        fitting = ufl.conditional(ufl.gt(fitting, 0.0), fitting, 0.0)
        parts = direction / inverse, side, upwind, fitting, exchange, monotone, coordinates.from_middle
        if sides is not None:
            return cls(*parts, sides.across)
        return SimplexStreamline(*parts, **SimplexStreamline.of_cell(coordinates.mesh, advection, diffusion))

    def held(self, of_cell: Callable[[Value], Value], at_points: Callable[[Value], Value]) -> "Streamline":
        """The same of held values: those `of_cell(expression)`, one in each cell, and those `at_points(expression)`."""
        return replace(
            self,
            along_flow=at_points(self.along_flow),
            side=_held(self.side, of_cell),  # one decision in all of the cell
            upwind=at_points(self.upwind),
            fitting=of_cell(self.fitting),
            exchange=of_cell(self.exchange),
            # half a cell is held, as the gradient of a gradient along it is taken
            across=tuple(Crossing(*(_held(part, of_cell) for part in crossing)) for crossing in self.across),
        )

    def without_monotone_cells(self) -> "Streamline":
        """The same where no cell is monotone: what only those need costs most of the assembly."""
        return replace(self, monotone=0.0, across=())

    @property
    def reach(self) -> Value:
        """Half a cell along the flow, m."""
        if isinstance(self.monotone, float):
            return self.along_flow
        return ufl.conditional(ufl.gt(self.monotone, 0.5), self.side, self.along_flow)

    def changes_across(self, *functions: Any) -> Value:
        """Weights with the functions' changes across the cell: what lumps a product, added up, where monotone.

        For linear f and g, the integral of f g + 2/3 (h/2)^2 f' g' is that of their product at the nodes.
        """
        terms = [(1.0, functions)]
        for direction, square, _ in self.across:
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

    def upwinding(self, test: Value) -> Value:
        """What upwinding adds to the test function in cells that are not monotone."""
        return (1.0 - self.monotone) * self.upwind * self.along(test)

    def carried(self, advection: Value, function: Value, test: Value) -> Value:
        """a.grad f, what flows into a cell from upstream."""
        along, crossing = ufl.dot(advection, ufl.grad(function)), 0.0
        for direction, square, covector in self.across:
            component = self.monotone * ufl.dot(covector, advection)
            change, test_change = (ufl.dot(direction, ufl.grad(f)) for f in (function, test))
            along -= component * change
            crossing += self._nodal(component, change, test)
            crossing += self._nodal(abs(component) * ufl.sqrt(square), change, test_change)
        form = along * self.downstream(test) + crossing
        for w, (f, v) in self.changes_across(function, test):
            form += w * ufl.dot(advection, ufl.grad(f)) * self.downstream(v)
        return form

    def _nodal(self, coefficient: Value, function: Value, test: Value) -> Value:
        """Product of two functions that are linear along the flow, at the nodes."""
        return coefficient * (function * test + 2.0 / 3.0 * self.along(function) * self.along(test))

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
        return ufl.dot(gradient, self.vertices * ufl.grad(test)) / (len(self.side) + 2.0)

    def carried(self, advection: Value, function: Value, test: Value) -> Value:
        return ufl.dot(advection, ufl.grad(function)) * self.downstream(test)

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
        dimension = len(self.side)
        ones = ufl.as_vector([1.0] * (dimension - 1))
        vertices = jacobian * (ufl.Identity(dimension - 1) - ufl.outer(ones, ones) / dimension) * jacobian.T
        lumping = ufl.dot(ufl.grad(value), vertices * ufl.grad(test)) / (dimension + 1.0)
        return self.monotone * coefficient * lumping


def _held(value: Value, of_cell: Callable[[Value], Value]) -> Value:
    return value if isinstance(value, float) or is_cellwise_constant(value) else of_cell(value)


def _largest(values: list[Value]) -> Value:
    largest = values[0]
    for value in values[1:]:
        largest = ufl.max_value(largest, value)
    return largest
