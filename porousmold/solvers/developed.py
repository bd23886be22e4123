"""Developed flow at all stations of a straight bed at once.

The stations' profiles are one nonlinear system, solved as the full flow is; g = dp/dx at each station and the mass flow M that
passes all of them follow by elimination. With du/dg and du/dp of each station from two more solves with the same factors, its
mass flow is linear in its g and in its p, which is that of the stations downstream, p = P g (trapezoidal rule):

    M_i + (dM/dg)_i delta g_i + (dM/dp)_i (P delta g)_i = M,

and the pressure drop (or the mass flow) that the scene imposes closes this small system. Without the last term on the left, the
density of a gas would lag behind its pressure, and the iteration would converge linearly: by 0.67 where the velocity is given at
an inlet with 2.9 times the outlet's pressure.
"""

import contextlib
import functools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from ..arrays import Floats, Integers
from ..equations.developed import developed_residual, developed_state
from ..equations.flow import BedMeasures, FlowEquations
from ..laws.turbulence_models import TurbulentUnknown
from ..mesh import fenicsx
from ..mesh.aliases import Space
from ..mesh.domain import BED, INTERFACE, Domain
from .equilibrium import local_equilibrium
from .flow import NonlinearFlow, unknowns_outside
from .linear_solution import LinearSolution
from .newton import Beside, NewtonSystem
from .parts import LEAST_VALUE, Unknowns
from .protocols import Inflow
from .state import State
from .stations import GAUSS_DEGREE, Columns, PressureAlong, Streamfunction
from .steady import SteadySolver

PRESSURE_DIFFERENCE = 1e-4
"""Part of the reference pressure by which residual and mass flow are differentiated: a gas's density is linear in it."""
NOTICEABLE_CHANGE = 0.2
"""Change of the pressure along the bed, over the reference pressure, from which the lagging density slows the iteration."""
NEAR = 0.1
"""Relative changes of profiles and dp/dx below which the density follows the pressure: far off, that leads astray."""
LARGEST_CHANGE = 0.3
"""Largest change of dp/dx in one iteration, as a part of the largest of all stations or of the scale."""


class DevelopedFlow(NonlinearFlow):
    """Developed flow over the bed of a straight domain. `equations` are `FlowEquations`.

    `inflow.area` is the section; `streamfunction` carries the mass flow.
    """

    kept_iterations = 0  # the stations' matrix takes less to factorise than an iteration with a reused Jacobian saves

    def __init__(
        self,
        domain: Domain,
        equations: FlowEquations,
        temperature: fem.Function,
        inflow: Inflow,
    ) -> None:
        self.domain, self.temperature = domain, temperature
        self._inflow = inflow
        self._update = np.inf
        turbulence = equations.turbulent_unknowns
        scalars = fenicsx.lagrange_space(domain.mesh)
        elements = [fenicsx.lagrange_element(domain.mesh, 1)] * (1 + len(turbulence))
        self.space = fenicsx.mixed_space(domain.mesh, elements) if turbulence else scalars
        self._parts = (
            [fenicsx.collapse(self.space, part) for part in range(len(elements))]
            if turbulence
            else [(self.space, np.arange(len(fem.Function(self.space).x.array)))]
        )
        self.unknown, previous = fem.Function(self.space), fem.Function(self.space)
        inverse_step = fem.Constant(domain.mesh, 0.0)
        self.columns = Columns(domain)
        self._along = PressureAlong(self.columns)
        self.pressure, gradient = self._along.pressure, self._along.gradient
        dx = domain.column_measure(GAUSS_DEGREE)
        arguments = (self.unknown, previous, inverse_step, self.pressure, gradient, temperature)
        residual = developed_residual(equations, *arguments, BedMeasures(dx(BED), domain.nodal_measure()(BED)))
        push = ufl.derivative(residual, gradient, fem.Constant(domain.mesh, 1.0) * unit(scalars))
        self._push_form = fenicsx.DeferredForm(push)
        nothing = fem.Constant(domain.mesh, 0.0)
        residual += nothing * ufl.inner(self.unknown, ufl.TestFunction(self.space)) * domain.wall_measure(1)
        constrained = np.unique(self._constrained(turbulence))
        system = NewtonSystem(
            "developed",
            residual,
            self.unknown,
            constrained,
            keep_jacobian=True,
            linear=LinearSolution(pivoting=False),
            beside=self._beside(),
        )
        self._gains = fem.Function(self.space), fem.Function(self.space)
        self._weights, self._push_of_pressure = system.new_vector(), system.new_vector()
        self._prepare_columns(equations, dx)
        motion, *others = (numbers for _, numbers in self._parts)
        along = {"pressure": self.pressure, "gradient": gradient, "streamfunction": self._streamfunction.function}
        solution, transit = State({"unknown": self.unknown} | along), equations.scales.transit_time
        solver = SteadySolver(system, Unknowns([motion], others), solution, previous, inverse_step, transit)
        super().__init__(equations, solver, developed_state(equations, self.unknown, self.pressure))

    def _prepare_columns(self, equations: FlowEquations, dx: ufl.Measure) -> None:
        """What sums over the stations, and the stream function."""
        density = equations.fluid.density(self.pressure, self.temperature)
        weighted = equations.coordinates.weight * equations.bed.porosity * density * equations.scales.speed
        mixed = len(self._parts) > 1
        test, present = (ufl.split(f)[0] if mixed else f for f in (ufl.TestFunction(self.space), self.unknown))
        self._through = fenicsx.DeferredForm(weighted * test * dx(BED))
        points = np.zeros((len(self.unknown.x.array), 3))
        for space, numbers in self._parts:
            points[numbers] = space.tabulate_dof_coordinates()
        self._column_of_unknown = self.columns.of(points)
        self._streamfunction = Streamfunction(self.domain, weighted * present)
        self.streamfunction = self._streamfunction.function

    def _constrained(self, turbulence: Sequence[TurbulentUnknown]) -> Integers:
        domain, facets = self.domain, self.domain.facets(INTERFACE)
        if not turbulence:
            inside = fem.locate_dofs_topological(self.space, 2, domain.cells(BED))
            outside = np.setdiff1d(np.arange(len(self.unknown.x.array)), inside)
            return np.concatenate([outside, fem.locate_dofs_topological(self.space, 1, facets)])
        constrained = [unknowns_outside(domain, self.space, range(1 + len(turbulence)), BED)]
        at_wall = [0, *(1 + number for number, unknown in enumerate(turbulence) if unknown.zero_at_wall)]
        constrained += [fem.locate_dofs_topological(self.space.sub(part), 1, facets) for part in at_wall]
        return np.concatenate(constrained)

    def initial_guess(self) -> bool:
        """Start from the local equilibrium of drag and beads, with their undamped turbulence.

        The pressure gradient is that of the scales, or as the pressure drop imposes it at present.
        """
        equations, scales = self.equations, self.equations.scales
        drive = self._inflow.drive()
        pressure_drop = drive.value if drive.kind == "pressure_drop" else float(scales.pressure.value)
        gradient = pressure_drop / self.columns.along[-1]
        self._along.set_gradients(np.full(len(self.columns.along), -gradient))
        if not drive.value and equations.gravity is None:
            self.unknown.x.array[:] = 0.0
            return True
        self._guess(gradient)
        return equations.model is None or equations.model.starts_near()

    def _guess(self, gradient: Any) -> None:
        """Local equilibrium of drag and beads at a pressure gradient (Pa/m), a number or one for each node."""
        space = self.pressure.function_space
        temperature, pressure = self.temperature.x.array, self.pressure.x.array
        fields = local_equilibrium(self.equations, self._inflow.fluid, space, gradient, temperature, pressure)
        sizes = [float(self.equations.scales.speed.value), *self.turbulent_factors().values()]
        given = fem.Function(space)
        for values, size, (part, numbers) in zip(fields, sizes, self._parts, strict=True):
            given.x.array[:] = values / size
            there = fem.Function(part)
            there.interpolate(given)
            self.unknown.x.array[numbers] = there.x.array
        self.unknown.x.array[self.solver.system.constrained] = 0.0
        self.unknown.x.scatter_forward()

    @functools.cached_property
    def _push(self) -> PETSc.Vec:
        """Residual's fall by 1 Pa/m of dp/dx: the same for every flow."""
        push = self.solver.system.new_vector()
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
            self.columns.total(column, weights * function.x.array[: len(weights)]) / self.columns.widths
            for function in scaled
        ]

    def _beside(self) -> Beside:
        """The pressure gradients, found with the profiles."""
        return Beside(complete=self._complete, size_of=lambda update: self._update)

    def _complete(self, update: PETSc.Vec) -> None:
        """Change a Newton update of the profiles so that, with new pressure gradients, the mass flow is as it has to be."""
        system, before = self.solver.system, self.unknown.x.array.copy()
        gradients, scale = self._along.gradients, float(self.equations.scales.pressure.value) / self.columns.along[-1]
        along_the_bed = abs(self.columns.pressure(gradients)[0])
        expands = (
            self._inflow.fluid.density.compressible and along_the_bed > NOTICEABLE_CHANGE * self._reference_pressure
        )
        if expands:
            with self._denser() as difference:
                system.assemble_residual_into(self._push_of_pressure)
        self._take(update)
        size = self.solver.sizes.updates(before)[0]
        by_gradient, by_pressure = self._gains
        self._solve_for(by_gradient, self._push)
        flow, slope = self._through_stations(self.unknown, by_gradient)
        change = self._changes(gradients, flow, slope)
        largest = max(np.max(np.abs(gradients)), scale)
        follows = expands and size < NEAR and np.max(np.abs(change)) < NEAR * largest
        if follows:
            self._push_of_pressure.axpy(-1.0, system.vector)
            self._push_of_pressure.scale(-1.0 / difference)
            self._solve_for(by_pressure, self._push_of_pressure)
            with self._denser():
                (denser,) = self._through_stations(self.unknown)
            slope_in_pressure = self._through_stations(by_pressure)[0] + (denser - flow) / difference
            change = self._changes(gradients, flow, slope, slope_in_pressure)
        self._update = np.inf
        if not np.isfinite(change).all():
            return
        change = np.clip(change, -LARGEST_CHANGE * largest, LARGEST_CHANGE * largest)
        more = by_gradient.x.array * change[self._column_of_unknown]
        if follows:
            more += by_pressure.x.array * self.columns.pressure(change)[self._column_of_unknown]
        update.array -= more[: len(update.array)]
        self.unknown.x.array[:] += more
        gradients += change
        relative = np.max(np.abs(change)) / max(np.max(np.abs(gradients)), LEAST_VALUE * scale)
        self._along.set_gradients(gradients)
        self._update = max(self.solver.sizes.updates(before)[0], float(relative))

    def _take(self, update: PETSc.Vec) -> None:
        """Take a Newton update."""
        fenicsx.petsc_vector(self.unknown).axpy(-1.0, update)
        self.unknown.x.scatter_forward()

    @contextlib.contextmanager
    def _denser(self) -> Iterator[float]:
        """The pressure raised everywhere for a while; gives by how much (Pa)."""
        present = self.pressure.x.array.copy()
        difference = PRESSURE_DIFFERENCE * self._reference_pressure
        self.pressure.x.array[:] += difference
        try:
            yield difference
        finally:
            self.pressure.x.array[:] = present

    def _solve_for(self, gain: fem.Function, push: PETSc.Vec) -> None:
        """Have `gain` be what the unknown changes by, as the residual falls by `push`."""
        self.solver.system.apply_inverse(push, fenicsx.petsc_vector(gain))
        gain.x.scatter_forward()

    @property
    def _reference_pressure(self) -> float:
        return float(self.equations.fluid.reference_pressure.value)

    def _given_mass_flow(self, inlet_pressure: float) -> float | None:
        """Mass flow (kg/s) that the drive gives at a gauge pressure (Pa) at the inlet; None where it gives the pressure drop."""
        return self._inflow.mass_flow(inlet_pressure + self._reference_pressure)

    def _changes(
        self, gradients: Floats, flow: Floats, slope: Floats, slope_in_pressure: Floats | None = None
    ) -> Floats:
        """`changes_of_gradient` with what the drive gives at present."""
        inlet = float(self.columns.pressure(gradients)[0])
        given, more = (self._given_mass_flow(pressure) for pressure in (inlet, inlet + 1.0))
        drive = (self._inflow.drive().value - inlet, 0.0) if given is None or more is None else (given, more - given)
        return changes_of_gradient(self.columns, flow, slope, slope_in_pressure, drive, is_pressure_drop=given is None)

    def found(self) -> None:
        """Have the stream function carry the mass flow that is imposed."""
        self._streamfunction.renew(self._given_mass_flow(self._along.at_inlet))

    def fields(self) -> dict[str, fem.Function]:
        (speeds, numbers), *turbulence = self._parts
        along, interpolated = fem.Function(speeds), fem.Function(self.pressure.function_space)
        along.x.array[:] = self.unknown.x.array[numbers]
        interpolated.interpolate(along)
        vectors = fem.Function(fenicsx.lagrange_space(self.domain.mesh, 1, 2), name="velocity")
        vectors.x.array[0::2] = float(self.equations.scales.speed.value) * interpolated.x.array
        pressure = fem.Function(self.pressure.function_space, name="pressure")
        pressure.x.array[:] = self.pressure.x.array
        fields = {"velocity": vectors, "pressure": pressure}
        for (space, numbers), (name, factor) in zip(turbulence, self.turbulent_factors().items(), strict=True):
            fields[name] = fem.Function(space, name=name)
            fields[name].x.array[:] = factor * self.unknown.x.array[numbers]
        return fields


def unit(space: Space) -> fem.Function:
    """Function that is 1 everywhere."""
    function = fem.Function(space)
    function.x.array[:] = 1.0
    return function


def changes_of_gradient(
    columns: Columns,
    flow: Floats,
    slope: Floats,
    slope_in_pressure: Floats | None,
    drive: tuple[float, float],
    *,
    is_pressure_drop: bool,
) -> Floats:
    """Changes of dp/dx (Pa/m) at the stations with which the same mass flow passes all of them; NaN where there are none.

    `flow` is what passes them (kg/s), `slope` that in dp/dx, `slope_in_pressure` that in the pressure; without it all densities
    stay as they are. `drive` is how much more the pressure drop is to be (Pa), or the mass flow (kg/s) and its slope in the
    pressure at the inlet.
    """
    pressure, (value, slope_at_inlet) = columns.pressure_matrix, drive
    if slope_in_pressure is None:  # each station by itself; P g at the inlet is the pressure drop
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
