"""The stations of a straight bed, which are its columns of nodes: sums over them, and the stream function of their flow."""

import functools
import math

import numpy as np
import ufl
from dolfinx import fem

from ..arrays import Floats, Integers
from ..equations.flow import FlowEquations
from ..laws.functions import Value
from ..mesh import fenicsx, ranks
from ..mesh.deferred_forms import DeferredForm
from ..mesh.domain import BED, Domain
from ..mesh.quadrature_rules import column_rule, flow_axis

GAUSS_DEGREE = 3
LEAST_FLOW = 1e-2
"""Of the largest at any station: below, its profile is that of the nearest station with more."""
LEAST_PRESSURE = 1e-3
"""Of a gas at the outlet: it has no less anywhere in an iteration that goes astray."""


def columns_of(domain: Domain) -> tuple[Floats, Floats]:
    """Nodes (m) along and across the bed, of a straight one in two dimensions."""
    assert domain.columns is not None, "only a straight bed in two dimensions has stations"
    return domain.columns


class Columns:
    """Sums over the columns of nodes of a straight bed, its stations, on all ranks alike. Lengths in m."""

    def __init__(self, domain: Domain) -> None:
        self.domain = domain
        self.along, self.across = columns_of(domain)
        steps = np.diff(self.along)
        self.widths = 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))

    def of(self, points: Floats) -> Integers:
        """Number of the station of each point."""
        return nearest(self.along, np.asarray(points)[:, 0])

    def total(self, columns: Integers, values: Floats) -> Floats:
        """Sum of owned values by their column, over all ranks."""
        sums = np.bincount(columns, weights=values, minlength=len(self.along))
        return ranks.total(self.domain.communicator, sums)

    def pressure(self, gradient: Floats, gas_at: float | None = None) -> Floats:
        """Gauge pressure (Pa) at the stations for dp/dx (Pa/m), 0 at the last: the trapezoidal rule; of a gas that has the
        pressure `gas_at` (Pa) there that of p dp/dx, which does not change along an ideal gas of one temperature."""
        steps = np.diff(self.along)
        if gas_at is None:
            steps = 0.5 * steps * (gradient[1:] + gradient[:-1])
            return np.append(-np.cumsum(steps[::-1])[::-1], 0.0)
        pressure, slopes, least = [gas_at], gradient.tolist(), LEAST_PRESSURE * gas_at
        for here, step in reversed(list(enumerate(steps.tolist()))):
            after, half = pressure[-1], 0.5 * step * slopes[here]
            square = after * (after - step * slopes[here + 1]) + half**2
            pressure.append(max(math.sqrt(max(square, 0.0)) - half, least))
        return np.array(pressure[::-1]) - gas_at

    @functools.cached_property
    def _trapezoidal(self) -> Floats:
        return np.column_stack([self.pressure(gradient) for gradient in np.eye(len(self.along))])

    def pressure_matrix(self, gradient: Floats, gas_at: float | None = None) -> Floats:
        """Derivative of `pressure` in dp/dx (m), a row for each station."""
        if gas_at is None:
            return self._trapezoidal
        pressure, trapezoidal = gas_at + self.pressure(gradient, gas_at), self._trapezoidal
        # of p^2 = gas_at^2 + 2 T (p dp/dx), T the trapezoidal rule
        matrix = np.diag(pressure) - trapezoidal * gradient
        np.fill_diagonal(matrix, np.maximum(matrix.diagonal(), LEAST_PRESSURE * gas_at))
        return np.asarray(np.linalg.solve(matrix, trapezoidal * pressure))


class PressureAlong:
    """Gauge pressure (Pa) and dp/dx (Pa/m) along a straight bed, alike across it: functions `pressure` and `gradient`.

    `gas_at` is the pressure (Pa) of a gas at the last station, None for a liquid.
    """

    def __init__(self, columns: Columns, gas_at: float | None) -> None:
        space = fenicsx.lagrange_space(columns.domain.mesh)
        self.pressure, self.gradient = fem.Function(space), fem.Function(space)
        self.columns, self._gas_at, self._owned = columns, gas_at, space.dofmap.index_map.size_local
        self._column = columns.of(space.tabulate_dof_coordinates())
        self._nodes = columns.total(self._column[: self._owned], np.ones(self._owned))

    @property
    def gradients(self) -> Floats:
        """dp/dx (Pa/m) at the stations (collective)."""
        sums = self.columns.total(self._column[: self._owned], self.gradient.x.array[: self._owned])
        return sums / self._nodes

    @property
    def at_inlet(self) -> float:
        """Gauge pressure (Pa) at the first station (collective)."""
        return float(self.of(self.gradients)[0])

    def of(self, gradients: Floats) -> Floats:
        """Gauge pressures (Pa) at the stations for dp/dx (Pa/m)."""
        return self.columns.pressure(gradients, self._gas_at)

    def even_gradients(self, pressure_drop: float) -> Floats:
        """dp/dx (Pa/m) at the stations with which a pressure drop (Pa) falls evenly: p itself, of a gas its square."""
        along = self.columns.along
        if self._gas_at is None:
            return np.full(len(along), -pressure_drop / along[-1])
        squares = self._gas_at**2, (self._gas_at + pressure_drop) ** 2
        slope = (squares[0] - squares[1]) / along[-1]
        return 0.5 * slope / np.sqrt(squares[1] + slope * along)

    def at_nodes(self, values: Floats) -> Floats:
        """Values of the stations at the nodes of `pressure`."""
        return values[self._column]

    def matrix(self, gradients: Floats) -> Floats:
        """Their derivative in dp/dx (m)."""
        return self.columns.pressure_matrix(gradients, self._gas_at)

    def set_gradients(self, gradients: Floats) -> None:
        """Have dp/dx (Pa/m) at the stations be these, and the pressure what follows."""
        self.gradient.x.array[:] = gradients[self._column]
        self.pressure.x.array[:] = self.of(gradients)[self._column]


class MassFlowAlong:
    """What the fluid in a straight bed displaces as it expands: `displaced` (kg/s) adds to the mass flow from station to station,
    and `growth`, a function, is the mass flow over that at the inlet. Nothing, and None, where the equations leave it out."""

    def __init__(self, columns: Columns, equations: FlowEquations) -> None:
        self._columns = columns
        self.growth: fem.Function | None = None
        if equations.expansion is None:
            return
        space = fenicsx.lagrange_space(columns.domain.mesh)
        self.growth, self._totals = fem.Function(space), fem.Function(space)
        self.growth.x.array[:] = 1.0
        self._column = columns.of(space.tabulate_dof_coordinates())
        dx, test = columns.domain.column_measure(GAUSS_DEGREE)(BED), ufl.TestFunction(space)
        self._form = DeferredForm(equations.coordinates.weight * equations.expansion * test * dx)

    def displaced(self) -> Floats:
        """Upstream of each station, kg/s (collective)."""
        columns = self._columns
        if self.growth is None:
            return np.zeros(len(columns.along))
        vector = fenicsx.petsc_vector(self._totals)
        fenicsx.assemble_vector(vector, self._form.form)
        totals = columns.total(self._column[: len(vector.array)], vector.array)
        before = 0.5 * np.diff(columns.along, prepend=columns.along[0]) / columns.widths
        return np.cumsum(totals) - (1.0 - before) * totals

    def carry(self, at_inlet: float, displaced: Floats) -> None:
        """Have the flow that is `at_inlet` (kg/s) grow by what is `displaced` upstream of each station."""
        if self.growth is not None:
            self.growth.x.array[:] = (1.0 + displaced / at_inlet if at_inlet else np.ones(len(displaced)))[self._column]


def nearest(grid: Floats, values: Floats) -> Integers:
    """Index of the nearest of the rising grid's nodes to each value."""
    return np.searchsorted(0.5 * (grid[1:] + grid[:-1]), values)


class Streamfunction:
    """Stream function of an axial mass flux (kg/m2/s, UFL): `function`, constant along the wall and 0 on the symmetry line, or
    along the wall opposite."""

    def __init__(self, domain: Domain, weighted_flux: Value) -> None:
        self._domain = domain
        self.function = fem.Function(fenicsx.lagrange_space(domain.mesh))
        axis = flow_axis(domain.mesh)
        rule = column_rule(axis, GAUSS_DEGREE)
        self._values = fenicsx.evaluate(weighted_flux, domain.mesh, rule["quadrature_points"])
        self._weights = 2.0 * np.array(rule["quadrature_weights"])[: len(rule["quadrature_weights"]) // 2]
        along, across = columns_of(domain)
        size = domain.mesh.topology.index_map(2).size_local
        middle = domain.mesh.geometry.x[fenicsx.cell_vertices(domain.mesh)[:size]].mean(axis=1)
        self._bed = np.flatnonzero((across[0] < middle[:, 1]) & (middle[:, 1] < across[-1]))
        self._place = (
            np.searchsorted(along, middle[self._bed, 0]) - 1,
            np.searchsorted(across, middle[self._bed, 1]) - 1,
        )
        nodes = self.function.function_space.tabulate_dof_coordinates()
        self._node = tuple(nearest(grid, nodes[:, axis]) for axis, grid in enumerate((along, across)))

    def renew(self, total: float | None = None, displaced: Floats | float = 0.0) -> float:
        """Integrate the present flux across the bed, as a part of `total` (kg/s, or per metre of width; default: the mean of
        all stations without what is `displaced` upstream of each), so that the same mass flow passes every station whatever the
        iterations left; gives the total."""
        along, across = columns_of(self._domain)
        values = self._values()[self._bed].reshape(len(self._bed), 2, len(self._weights)) @ self._weights
        through = np.zeros((len(along), len(across) - 1, 2))
        heights = np.diff(across)[self._place[1]]
        for end in (0, 1):
            through[self._place[0] + end, self._place[1], end] = values[:, end] * heights
        from_behind, from_before = np.moveaxis(ranks.total(self._domain.communicator, through), 2, 0)
        # the same but at the bed's ends, which have one of them
        through = np.where(np.abs(from_behind) > np.abs(from_before), from_behind, from_before)
        table = np.hstack([np.zeros((len(along), 1)), np.cumsum(through, axis=1)])
        through = table[:, -1]
        total = float((through - displaced).mean()) if total is None else total
        if np.all(through > 0.0):
            table *= total / through[:, None]
        elif np.any(displaced):  # what flows back is that profile, too, times its growth
            known = np.flatnonzero(np.abs(through) > LEAST_FLOW * np.max(np.abs(through)))
            profile = known[nearest(along[known], along)]
            table = table[profile] * (total / through[profile, None])
        self.function.x.array[:] = table[self._node]
        return total
