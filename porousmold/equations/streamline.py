r"""Upwinding of heat that a flow carries through the cells and exchanges with the beads on its way.

Two sets of forms do the same in a cell: `Upwinded` ones of second order, and monotone ones that trade that for bounds, `Lumped`
along the cell's sides or `LumpedAtVertices` in triangles and tetrahedra that lie in any way. A `Streamline` takes them by turns,
cell by cell. D f = reach.grad f is half the change of f over a cell along the flow.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import ufl
from dolfinx import fem
from ufl.checks import is_cellwise_constant

from ..laws.functions import Value
from ..mesh import fenicsx
from .coordinates import Coordinates
from .corners import Corners, CornersOfBox, CornersOfSimplex, Law
from .stabilisation import flux_density, is_tensor, metric


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


class CellForms(ABC):
    """Forms of heat that is carried, conducted, stored and exchanged, of a function f against a test v."""

    @abstractmethod
    def carried(self, advection: Value, function: Value, test: Value) -> Value:
        """a.grad f, what flows into a cell from upstream."""

    @abstractmethod
    def conducted(self, conductivity: Value, function: Value, test: Value) -> Value:
        """grad v.(K grad f); K is a number or a tensor."""

    @abstractmethod
    def stored(self, law: Law, function: Value, test: Value) -> Value:
        """Storage of a law of the function where nothing flows."""

    @abstractmethod
    def stored_downstream(self, law: Law, function: Value, test: Value) -> Value:
        """The same in what flows."""

    @abstractmethod
    def exchanged(self, coefficient: Value, value: Value, test: Value) -> Value:
        """Exchange of `value` as the beads have it, with the local `coefficient` or, where monotone, the cell's."""

    @abstractmethod
    def exchanged_downstream(self, coefficient: Value, value: Value, test: Value) -> Value:
        """Exchange of `value` as the fluid has it; for a uniform test the same as `exchanged`."""


@dataclass(frozen=True)
class Upwinded(CellForms):
    """Second order: `reach` is half a cell along the flow (a vector, m), `upwind` is chi = 2 tau |a|/h, 1 where the flow wins
    over conduction across the cell and over exchange, 0 where it loses; what melts is interpolated between `corners`."""

    reach: Value
    upwind: Value
    corners: Corners | None

    def along(self, function: Value) -> Value:
        """D f."""
        return ufl.dot(self.reach, ufl.grad(function))

    def upwinding(self, test: Value) -> Value:
        """What upwinding adds to the test function."""
        return self.upwind * self.along(test)

    def carried(self, advection: Value, function: Value, test: Value) -> Value:
        return ufl.dot(advection, ufl.grad(function)) * (test + self.upwinding(test))

    def conducted(self, conductivity: Value, function: Value, test: Value) -> Value:
        return ufl.dot(flux_density(conductivity, ufl.grad(function)), ufl.grad(test))

    def interpolated(self, law: Law, function: Value) -> Value:
        """A law of a function: of what melts, between the corners."""
        return law(function) if self.corners is None else self.corners.interpolated(law, function)

    def stored(self, law: Law, function: Value, test: Value) -> Value:
        return self.interpolated(law, function) * test

    def stored_downstream(self, law: Law, function: Value, test: Value) -> Value:
        return self.interpolated(law, function) * (test + self.upwinding(test))

    def exchanged(self, coefficient: Value, value: Value, test: Value) -> Value:
        return coefficient * value * test

    def exchanged_downstream(self, coefficient: Value, value: Value, test: Value) -> Value:
        return coefficient * value * (test + self.upwinding(test))

    def held(self, at_points: Callable[[Value], Value], corners: Corners | None) -> "Upwinded":
        """The same of held values: those `at_points(expression)`, and those that the `corners` have."""
        return Upwinded(at_points(self.reach), at_points(self.upwind), corners)


class Monotone(CellForms):
    """What is stored and exchanged is lumped, so that no node gets hotter or colder than those around."""

    melts: bool

    @property
    @abstractmethod
    def corners(self) -> Corners:
        """Those of the cell."""

    @property
    def corners_of_melting(self) -> Corners | None:
        """The same where something melts."""
        return self.corners if self.melts else None

    @abstractmethod
    def lumping(self, coefficient: Value, function: Value, test: Value) -> Value:
        """What brings the integral of a coefficient times two functions to that of their values at the nodes."""

    @abstractmethod
    def held(self, of_cell: Callable[[Value], Value], at_points: Callable[[Value], Value]) -> "Monotone":
        """The same of held values: those `of_cell(expression)`, one in each cell, and those `at_points(expression)`."""

    @abstractmethod
    def entered(self, coefficient: Value, value: Value, test: Value) -> Value:
        """What entering through the inlet with a `coefficient` gains by the lumping, per area."""

    def stored(self, law: Law, function: Value, test: Value) -> Value:
        if self.melts:
            return self.corners.lumped(law, function, test)
        present = ufl.variable(function)
        capacity = ufl.diff(law(present), present)
        return law(function) * test + self.lumping(capacity, function, test)

    def stored_downstream(self, law: Law, function: Value, test: Value) -> Value:
        return self.stored(law, function, test)

    @abstractmethod
    def changes_across(self, *functions: Value) -> list[tuple[Value, tuple[Value, ...]]]:
        """Weights with the functions' changes across the cell: what lumps a product, added up."""


@dataclass(frozen=True)
class Lumped(Monotone):
    r"""Lumped along the flow, which counts as along the cell's own side `reach` (half of it, a vector, m): chi is 1 there, the
    fluid's balance is that of the cell's downstream end, and `fitting` (beta) leaves to that end as much of the `exchange`
    (W/m3/K) as keeps every node an average of its upstream neighbour and its beads. What crosses the other sides is upwinded from
    node to node, and all is lumped `across` the flow, too."""

    reach: Value
    fitting: Value
    exchange: Value
    from_middle: Value
    across: tuple[Crossing, ...]
    melts: bool = False

    @property
    def corners(self) -> Corners:
        axes = [(self.reach, self._place)]
        for direction, square, covector in self.across:
            half = ufl.sqrt(square)
            axes.append((half * direction, ufl.dot(covector, self.from_middle) / half))
        return CornersOfBox(axes)

    @property
    def _place(self) -> Value:
        """Along the flow, from -1 to 1."""
        return ufl.dot(self.from_middle, self.reach) / (ufl.dot(self.reach, self.reach) + 1e-60)

    def along(self, function: Value) -> Value:
        """D f."""
        return ufl.dot(self.reach, ufl.grad(function))

    def changes_across(self, *functions: Value) -> list[tuple[Value, tuple[Value, ...]]]:
        """For linear f and g, the integral of f g + 2/3 (h/2)^2 f' g' is that of their product at the nodes."""
        terms: list[tuple[Value, tuple[Value, ...]]] = [(1.0, functions)]
        for direction, square, _ in self.across:
            factor = 2.0 / 3.0 * square
            terms += [(w * factor, tuple(ufl.dot(direction, ufl.grad(f)) for f in changed)) for w, changed in terms]
        return terms[1:]

    def downstream(self, test: Value) -> Value:
        """Test function of what the flow carries: uniform along the flow within the cell."""
        return test + (1.0 - self._place) * self.along(test)

    def carried(self, advection: Value, function: Value, test: Value) -> Value:
        along, crossing = ufl.dot(advection, ufl.grad(function)), 0.0
        for direction, square, covector in self.across:
            component = ufl.dot(covector, advection)
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
        change, test_change = (ufl.dot(ufl.grad(ufl.grad(f)), self.reach) for f in (function, test))
        plain = ufl.dot(flux_density(conductivity, ufl.grad(function)), ufl.grad(test))
        return plain + 2.0 / 3.0 * ufl.dot(flux_density(conductivity, change), test_change)

    def lumping(self, coefficient: Value, function: Value, test: Value) -> Value:
        form = 2.0 / 3.0 * coefficient * self.along(function) * self.along(test)
        for w, (f, v) in self.changes_across(function, test):
            form += w * self._nodal(coefficient, f, v)
        return form

    def exchanged(self, coefficient: Value, value: Value, test: Value) -> Value:
        form = 0.0
        for w, (f, v) in [(1.0, (value, test)), *self.changes_across(value, test)]:
            change, test_change = self.along(f), self.along(v)
            nodal = f * v + 2.0 / 3.0 * change * test_change + self.fitting * (change * v + f * test_change)
            form += w * self.exchange * nodal
        return form

    def exchanged_downstream(self, coefficient: Value, value: Value, test: Value) -> Value:
        form = 0.0
        for w, (f, v) in [(1.0, (value, test)), *self.changes_across(value, test)]:
            change, test_change = self.along(f), self.along(v)
            form += w * self.exchange * ((f + self.fitting * change) * (v + test_change) - change * test_change / 3.0)
        return form

    def entered(self, coefficient: Value, value: Value, test: Value) -> Value:
        return sum(w * coefficient * f * v for w, (f, v) in self.changes_across(value, test))

    def held(self, of_cell: Callable[[Value], Value], at_points: Callable[[Value], Value]) -> "Lumped":
        # half a cell is held, as the gradient of a gradient along it is taken, and one decision in all of the cell
        across = tuple(Crossing(*(_held(part, of_cell) for part in crossing)) for crossing in self.across)
        values = of_cell(self.fitting), of_cell(self.exchange)
        return Lumped(_held(self.reach, of_cell), *values, self.from_middle, across, self.melts)


@dataclass(frozen=True)
class LumpedAtVertices(Monotone):
    r"""Triangles and tetrahedra are lumped at their vertices.

    With V = sum (x_i - x_c)(x_i - x_c)^T of the vertices and their middle, in d dimensions,

        int f g + grad f.V grad g/(d+2) = |K|/(d+1) sum f_i g_i,    int grad f.V grad g = |K| sum (f_i - f_c)(g_i - g_c),

    so that m grad f.V grad g, m = `crossing` (W/m3/K), takes |K|/(d+1) m from each entry off the diagonal of the cell's matrix:
    with the largest of a.grad v_j of the nodes' functions, and (d+1) times that of grad v_i.K grad v_j, none is left positive
    (discrete upwinding: Guermond, Nazarov, Comput. Methods Appl. Mech. Eng. 272 (2014) 198-213).
    """

    exchange: Value
    vertices: Value
    crossing: Value
    coordinates: Coordinates
    melts: bool = False

    @classmethod
    def of_cell(
        cls, coordinates: Coordinates, advection: Value, diffusion: Value, exchange: Value, *, melts: bool
    ) -> "LumpedAtVertices":
        """Of the cells for heat carried along `advection` (W/m2/K), conducted by `diffusion` (W/m/K) and exchanged."""
        mesh = coordinates.mesh
        jacobian, inverse, dimension = ufl.Jacobian(mesh), ufl.JacobianInverse(mesh), mesh.geometry.dim
        ones = ufl.as_vector([1.0] * dimension)
        vertices = jacobian * (ufl.Identity(dimension) - ufl.outer(ones, ones) / (dimension + 1.0)) * jacobian.T
        gradients = [inverse[i, :] for i in range(dimension)]
        gradients = [-sum(gradients[1:], gradients[0]), *gradients]
        carried = [ufl.dot(advection, gradient) for gradient in gradients]
        conducted = [
            ufl.dot(gradients[i], flux_density(diffusion, gradients[j])) for j in range(dimension + 1) for i in range(j)
        ]
        crossing = _largest(carried) + (dimension + 1.0) * ufl.max_value(_largest(conducted), 0.0)
        return cls(exchange, vertices, crossing, coordinates, melts)

    @property
    def dimension(self) -> int:
        """Of the mesh."""
        return int(self.coordinates.mesh.geometry.dim)

    @property
    def corners(self) -> Corners:
        return CornersOfSimplex(self.coordinates.mesh, self.coordinates.from_middle)

    def changes_across(self, *functions: Value) -> list[tuple[Value, tuple[Value, ...]]]:
        return []

    def lumping(self, coefficient: Value, function: Value, test: Value) -> Value:
        return coefficient * ufl.dot(ufl.grad(function), self.vertices * ufl.grad(test)) / (self.dimension + 2.0)

    def carried(self, advection: Value, function: Value, test: Value) -> Value:
        return ufl.dot(advection, ufl.grad(function)) * test

    def conducted(self, conductivity: Value, function: Value, test: Value) -> Value:
        plain = ufl.dot(flux_density(conductivity, ufl.grad(function)), ufl.grad(test))
        return plain + self.crossing * ufl.dot(ufl.grad(function), self.vertices * ufl.grad(test))

    def exchanged(self, coefficient: Value, value: Value, test: Value) -> Value:
        return self.exchange * value * test + self.lumping(self.exchange, value, test)

    def exchanged_downstream(self, coefficient: Value, value: Value, test: Value) -> Value:
        return self.exchanged(coefficient, value, test)

    def entered(self, coefficient: Value, value: Value, test: Value) -> Value:
        jacobian = ufl.classes.FacetJacobian(value.ufl_domain())
        ones = ufl.as_vector([1.0] * (self.dimension - 1))
        vertices = jacobian * (ufl.Identity(self.dimension - 1) - ufl.outer(ones, ones) / self.dimension) * jacobian.T
        return coefficient * ufl.dot(ufl.grad(value), vertices * ufl.grad(test)) / (self.dimension + 1.0)

    def held(self, of_cell: Callable[[Value], Value], at_points: Callable[[Value], Value]) -> "LumpedAtVertices":
        return replace(self, exchange=of_cell(self.exchange), crossing=at_points(self.crossing))


class Carried(NamedTuple):
    """Heat, or another quantity, carried along `advection` (W/m2/K), conducted by `diffusion` (W/m/K), and exchanged by
    `exchange` (W/m3/K, or None)."""

    advection: Value
    diffusion: Value
    exchange: Value


@dataclass(frozen=True)
class Streamline:
    """The forms of `upwinded` cells, and of those `lumped` where `monotone` is 1, else 0; `lumped` is None where no cell is."""

    upwinded: Upwinded
    lumped: Monotone | None
    monotone: Value

    @classmethod
    def of(
        cls,
        coordinates: Coordinates,
        heat: Carried,
        entrance: Value,
        monotone: Value,
        straight: bool,
        *,
        upwinding: float = 1.0,
        melts: bool = False,
    ) -> "Streamline":
        """For such `heat`; cells are to be `monotone` where that is 1.

        `entrance` is 1 in the cells at the inlet, where conduction across flat cells must not weaken the upwinding. Cells
        that are not monotone have the part `upwinding` of it. Where the beads' heat capacity has a peak, something `melts`.
        """
        mesh, metric_tensor = coordinates.mesh, metric(coordinates.mesh)
        advection, diffusion, exchange = heat
        speed = ufl.sqrt(ufl.dot(advection, advection) + 1e-30)
        if exchange is None:
            exchange = fem.Constant(mesh, 0.0)
        direction = advection / speed
        inverse = ufl.sqrt(ufl.dot(direction, ufl.dot(metric_tensor, direction)) + 1e-30)  # of the reach
        carried = speed * inverse
        along = ufl.dot(direction, flux_density(diffusion, direction)) * inverse**2
        if is_tensor(diffusion):
            all_round = ufl.sqrt(ufl.inner(ufl.dot(metric_tensor, diffusion), ufl.dot(diffusion, metric_tensor)))
        else:
            all_round = diffusion * ufl.sqrt(ufl.inner(metric_tensor, metric_tensor))
        spread = ufl.conditional(ufl.gt(entrance, 0.5), along, all_round)
        upwind = upwinding * carried / ufl.sqrt(carried**2 + (3.0 * spread) ** 2 + exchange**2 + 1e-60)
        # monotone only along the cells themselves: a slight slope crosses many of the flat ones
        sides = _sides(coordinates, advection, metric_tensor, straight)
        if sides is None:
            lumped: Monotone = LumpedAtVertices.of_cell(coordinates, advection, diffusion, exchange, melts=melts)
        else:
            fitting = 1.0 - sides.rate / (exchange + 1e-30)
            fitting = ufl.conditional(ufl.gt(fitting, 0.0), fitting, 0.0)
            lumped = Lumped(sides.along, fitting, exchange, coordinates.from_middle, sides.across, melts)
        return cls(Upwinded(direction / inverse, upwind, lumped.corners_of_melting), lumped, monotone)

    def held(self, of_cell: Callable[[Value], Value], at_points: Callable[[Value], Value]) -> "Streamline":
        """The same of held values: those `of_cell(expression)`, one in each cell, and those `at_points(expression)`."""
        assert self.lumped is not None, "held as it is made"
        lumped = self.lumped.held(of_cell, at_points)
        return Streamline(self.upwinded.held(at_points, lumped.corners_of_melting), lumped, self.monotone)

    def without_monotone_cells(self) -> "Streamline":
        """The same where no cell is monotone: what only those need costs most of the assembly."""
        return Streamline(self.upwinded, None, 0.0)

    def _by_turns(self, form: str, *arguments: Value) -> Value:
        """A form of `CellForms`, cell by cell."""
        upwinded = getattr(self.upwinded, form)(*arguments)
        if self.lumped is None:
            return upwinded
        return (1.0 - self.monotone) * upwinded + self.monotone * getattr(self.lumped, form)(*arguments)

    def carried(self, advection: Value, function: Value, test: Value) -> Value:
        """See `CellForms`, as all that follows."""
        return self._by_turns("carried", advection, function, test)

    def conducted(self, conductivity: Value, function: Value, test: Value) -> Value:
        return self._by_turns("conducted", conductivity, function, test)

    def interpolated(self, law: Law, function: Value) -> Value:
        """See `Upwinded`."""
        return self.upwinded.interpolated(law, function)

    def stored(self, law: Law, function: Value, test: Value) -> Value:
        return self._by_turns("stored", law, function, test)

    def stored_downstream(self, law: Law, function: Value, test: Value) -> Value:
        return self._by_turns("stored_downstream", law, function, test)

    def exchanged(self, coefficient: Value, value: Value, test: Value) -> Value:
        return self._by_turns("exchanged", coefficient, value, test)

    def exchanged_downstream(self, coefficient: Value, value: Value, test: Value) -> Value:
        return self._by_turns("exchanged_downstream", coefficient, value, test)

    def entered(self, coefficient: Value, value: Value, test: Value) -> Value:
        """What entering through the inlet with a `coefficient` gains by the lumping, per area."""
        return 0.0 if self.lumped is None else self.monotone * self.lumped.entered(coefficient, value, test)

    def upwinding(self, test: Value) -> Value:
        """What upwinding adds to the test function in cells that are not monotone."""
        return (1.0 - self.monotone) * self.upwinded.upwinding(test)

    def changes_across(self, *functions: Value) -> list[tuple[Value, tuple[Value, ...]]]:
        """Weights with the functions' changes across monotone cells."""
        return (
            [(self.monotone * w, changed) for w, changed in self.lumped.changes_across(*functions)]
            if self.lumped
            else []
        )


def _held(value: Value, of_cell: Callable[[Value], Value]) -> Value:
    return value if isinstance(value, float) or is_cellwise_constant(value) else of_cell(value)


def _largest(values: list[Value]) -> Value:
    largest = values[0]
    for value in values[1:]:
        largest = ufl.max_value(largest, value)
    return largest
