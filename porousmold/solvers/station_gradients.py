"""Pressure gradients of a developed flow at its stations, found with the profiles so that the same mass flow passes all of them.

They follow by elimination: g = dp/dx at each station and the mass flow M that passes all of them. With du/dg and du/dp of each
station from two more solves with the same factors, its mass flow is linear in its g and in its p, which is that of the stations
downstream, delta p = P delta g (`Columns.pressure_matrix`):

    M_i + (dM/dg)_i delta g_i + (dM/dp)_i (P delta g)_i = M + D_i,  D_i what the fluid displaces upstream as it expands,

and the pressure drop (or the mass flow) that the scene imposes closes this small system. Without the last term on the left, the
density of a gas would lag behind its pressure, and the iteration would converge linearly: by 0.67 where the velocity is given at
an inlet with 2.9 times the outlet's pressure.
"""

import contextlib
import functools
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from dolfinx import fem
from petsc4py import PETSc

from ..arrays import Floats, Integers
from ..equations.flow import FlowEquations
from ..laws.functions import Value
from ..mesh import fenicsx
from ..mesh.deferred_forms import DeferredForm
from .newton import NewtonSystem
from .parts import LEAST_VALUE, PartSizes
from .protocols import Inflow
from .stations import PressureAlong

PRESSURE_DIFFERENCE = 1e-4
"""Part of the reference pressure by which residual and mass flow are differentiated: a gas's density is linear in it."""
NOTICEABLE_CHANGE = 0.2
"""Change of the pressure along the bed, over the reference pressure, from which the lagging density slows the iteration."""
NEAR = 0.1
"""Relative changes of profiles and dp/dx below which the density follows the pressure: far off, that leads astray."""
LARGEST_CHANGE = 0.3
"""Largest change of dp/dx in one iteration, as a part of the largest of all stations or of the scale."""


class AtStations(NamedTuple):
    """What belongs to the stations: `push` is the residual's derivative in their gradients and `through` the mass flow through
    each against a test function, forms; `column_of_unknown` is the station of each unknown, `displaced()` (kg/s) what adds to
    the mass flow upstream of them."""

    push: Value
    through: Value
    column_of_unknown: Integers
    displaced: Callable[[], Floats]


class StationGradients:
    """Gradients `along` the bed that a `system` of profiles, whose parts have `sizes`, depends on, with what is `at_stations`."""

    def __init__(
        self,
        equations: FlowEquations,
        inflow: Inflow,
        along: PressureAlong,
        system: NewtonSystem,
        sizes: PartSizes,
        at_stations: AtStations,
    ) -> None:
        self._equations, self._inflow, self._along, self._columns = equations, inflow, along, along.columns
        self._system, self._unknown, self._sizes = system, system.unknown, sizes
        self._push_form, self._through = DeferredForm(at_stations.push), DeferredForm(at_stations.through)
        self._column_of_unknown, self._displaced = at_stations.column_of_unknown, at_stations.displaced
        self._gains = fem.Function(system.space), fem.Function(system.space)
        self._weights, self._push_of_pressure = system.new_vector(), system.new_vector()
        self.update = np.inf
        """Of profiles and gradients in the last iteration."""

    def complete(self, update: PETSc.Vec) -> None:
        """Change a Newton update of the profiles so that, with new pressure gradients, the mass flow is as it has to be."""
        system, before, columns = self._system, self._unknown.x.array.copy(), self._columns
        gradients, scale = self._along.gradients, float(self._equations.scales.pressure.value) / columns.along[-1]
        inlet, matrix = float(self._along.of(gradients)[0]), self._along.matrix(gradients)
        expands = self._inflow.fluid.density.compressible and abs(inlet) > NOTICEABLE_CHANGE * self._reference_pressure
        if expands:
            with self._denser() as difference:
                system.assemble_residual_into(self._push_of_pressure)
        self._take(update)
        size = self._sizes.updates(before)[0]
        by_gradient, by_pressure = self._gains
        self._solve_for(by_gradient, self._push)
        flow, slope = self._through_stations(self._unknown, by_gradient)
        displaced = self._displaced()
        change = self._changes(inlet, matrix, flow - displaced, slope)
        largest = max(np.max(np.abs(gradients)), scale)
        follows = expands and size < NEAR and np.max(np.abs(change)) < NEAR * largest
        if follows:
            self._push_of_pressure.axpy(-1.0, system.vector)
            self._push_of_pressure.scale(-1.0 / difference)
            self._solve_for(by_pressure, self._push_of_pressure)
            with self._denser():
                (denser,) = self._through_stations(self._unknown)
            slope_in_pressure = self._through_stations(by_pressure)[0] + (denser - flow) / difference
            change = self._changes(inlet, matrix, flow - displaced, slope, slope_in_pressure)
        self.update = np.inf
        if not np.isfinite(change).all():
            return
        change = np.clip(change, -LARGEST_CHANGE * largest, LARGEST_CHANGE * largest)
        more = by_gradient.x.array * change[self._column_of_unknown]
        if follows:
            more += by_pressure.x.array * (matrix @ change)[self._column_of_unknown]
        update.array -= more[: len(update.array)]
        self._unknown.x.array[:] += more
        gradients += change
        relative = np.max(np.abs(change)) / max(np.max(np.abs(gradients)), LEAST_VALUE * scale)
        self._along.set_gradients(gradients)
        self.update = max(self._sizes.updates(before)[0], float(relative))

    def given_mass_flow(self, inlet_pressure: float) -> float | None:
        """Mass flow (kg/s) that the drive gives at a gauge pressure (Pa) at the inlet; None where it gives the pressure drop."""
        return self._inflow.mass_flow(inlet_pressure + self._reference_pressure)

    @property
    def _reference_pressure(self) -> float:
        return float(self._equations.fluid.reference_pressure.value)

    @functools.cached_property
    def _push(self) -> PETSc.Vec:
        """Residual's fall by 1 Pa/m of dp/dx: the same for every flow."""
        push = self._system.new_vector()
        fenicsx.assemble_vector(push, self._push_form.form)
        push.scale(-1.0)
        return push

    def _through_stations(self, *scaled: fem.Function) -> list[Floats]:
        """Mass flow (kg/s) through every station for each of some functions like the unknown.

        The quadrature is at the nodes along the flow, so that a node counts at its own station alone.
        """
        fenicsx.assemble_vector(self._weights, self._through.form)
        weights = self._weights.array
        column = self._column_of_unknown[: len(weights)]
        return [
            self._columns.total(column, weights * function.x.array[: len(weights)]) / self._columns.widths
            for function in scaled
        ]

    def _take(self, update: PETSc.Vec) -> None:
        """Take a Newton update."""
        fenicsx.petsc_vector(self._unknown).axpy(-1.0, update)
        self._unknown.x.scatter_forward()

    @contextlib.contextmanager
    def _denser(self) -> Iterator[float]:
        """The pressure raised everywhere for a while; gives by how much (Pa)."""
        pressure = self._along.pressure
        present = pressure.x.array.copy()
        difference = PRESSURE_DIFFERENCE * self._reference_pressure
        pressure.x.array[:] += difference
        try:
            yield difference
        finally:
            pressure.x.array[:] = present

    def _solve_for(self, gain: fem.Function, push: PETSc.Vec) -> None:
        """Have `gain` be what the unknown changes by, as the residual falls by `push`."""
        self._system.apply_inverse(push, fenicsx.petsc_vector(gain))
        gain.x.scatter_forward()

    def _changes(
        self, inlet: float, matrix: Floats, flow: Floats, slope: Floats, slope_in_pressure: Floats | None = None
    ) -> Floats:
        """`changes_of_gradient` with what the drive gives at a gauge pressure (Pa) at the inlet."""
        given, more = (self.given_mass_flow(pressure) for pressure in (inlet, inlet + 1.0))
        drive = (self._inflow.drive().value - inlet, 0.0) if given is None or more is None else (given, more - given)
        return changes_of_gradient(matrix, flow, slope, slope_in_pressure, drive, is_pressure_drop=given is None)


def changes_of_gradient(
    pressure: Floats,
    flow: Floats,
    slope: Floats,
    slope_in_pressure: Floats | None,
    drive: tuple[float, float],
    *,
    is_pressure_drop: bool,
) -> Floats:
    """Changes of dp/dx (Pa/m) at the stations with which the same mass flow passes all of them; NaN where there are none.

    `pressure` is the derivative of their pressures in dp/dx, `flow` what passes them (kg/s) that entered, `slope` that in dp/dx,
    `slope_in_pressure` that in the pressure; without it all densities stay as they are. `drive` is how much more the
    pressure drop is to be (Pa), or the mass flow (kg/s) and its slope in the pressure at the inlet.
    """
    value, slope_at_inlet = drive
    if slope_in_pressure is None:  # each station by itself; delta p at the inlet is that of the pressure drop
        wanted = (value + pressure[0] @ (flow / slope)) / (pressure[0] @ (1.0 / slope)) if is_pressure_drop else value
        return (wanted - flow) / slope
    matrix = np.diag(slope) + slope_in_pressure[:, None] * pressure
    right = -flow
    if is_pressure_drop:
        matrix = np.block([[matrix, -np.ones((len(flow), 1))], [pressure[:1], np.zeros((1, 1))]])
        right = np.append(right, value)
    else:
        matrix, right = matrix - slope_at_inlet * pressure[0], right + value
    try:
        return np.linalg.solve(matrix, right)[: len(flow)]
    except np.linalg.LinAlgError:
        return np.full_like(flow, np.nan)
