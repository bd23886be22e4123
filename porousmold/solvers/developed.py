"""Developed flow at all stations of a straight bed at once.

The stations' profiles are one nonlinear system, solved as the full flow is; the pressure gradient at each station and the mass
flow that passes all of them follow by elimination (`solvers.station_gradients`).
"""

from collections.abc import Sequence

import numpy as np
import ufl
from dolfinx import fem

from ..arrays import Floats, Integers
from ..equations.developed import developed_residual, developed_state
from ..equations.flow import BedMeasures, FlowEquations
from ..laws.functions import Value, number_of
from ..laws.turbulence_models import TurbulentUnknown
from ..mesh import fenicsx, ranks
from ..mesh.aliases import Space
from ..mesh.domain import BED, INTERFACE, Domain
from .equilibrium import local_equilibrium
from .flow import NonlinearFlow, unknowns_outside
from .linear_solution import LinearSolution
from .newton import Beside, NewtonSystem
from .parts import Unknowns
from .protocols import Inflow
from .state import State
from .station_gradients import AtStations, StationGradients
from .stations import GAUSS_DEGREE, Columns, MassFlowAlong, PressureAlong, Streamfunction
from .steady import SteadySolver


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
        is_gas, outlet_pressure = inflow.fluid.density.compressible, float(equations.fluid.reference_pressure.value)
        self._along = PressureAlong(self.columns, outlet_pressure if is_gas else None)
        self.pressure, gradient = self._along.pressure, self._along.gradient
        dx = domain.column_measure(GAUSS_DEGREE)
        arguments = (self.unknown, previous, inverse_step, self.pressure, gradient, temperature)
        residual = developed_residual(equations, *arguments, BedMeasures(dx(BED), domain.nodal_measure()(BED)))
        push = ufl.derivative(residual, gradient, fem.Constant(domain.mesh, 1.0) * unit(scalars))
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
        through = self._prepare_columns(equations, dx)
        motion, *others = (numbers for _, numbers in self._parts)
        along = {"pressure": self.pressure, "gradient": gradient, "streamfunction": self._streamfunction.function}
        self._mass_flow = MassFlowAlong(self.columns, equations)
        self.growth = self._mass_flow.growth
        if self.growth is not None:
            along["growth"] = self.growth
        solution, transit = State({"unknown": self.unknown} | along), equations.scales.transit_time
        solver = SteadySolver(system, Unknowns([motion], others), solution, previous, inverse_step, transit)
        stations = AtStations(push, through, self._column_of_unknown, self._mass_flow.displaced)
        self._gradients = StationGradients(equations, inflow, self._along, system, solver.sizes, stations)
        super().__init__(equations, solver, developed_state(equations, self.unknown, self.pressure))

    def _prepare_columns(self, equations: FlowEquations, dx: ufl.Measure) -> Value:
        """The stream function, and the form of what passes the stations."""
        density = equations.fluid.density(self.pressure, self.temperature)
        weighted = equations.coordinates.weight * equations.bed.porosity * density * equations.scales.speed
        mixed = len(self._parts) > 1
        test, present = (ufl.split(f)[0] if mixed else f for f in (ufl.TestFunction(self.space), self.unknown))
        points = np.zeros((len(self.unknown.x.array), 3))
        for space, numbers in self._parts:
            points[numbers] = space.tabulate_dof_coordinates()
        self._column_of_unknown = self.columns.of(points)
        self._streamfunction = Streamfunction(self.domain, weighted * present)
        self.streamfunction = self._streamfunction.function
        return weighted * test * dx(BED)

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

        The pressure gradient is that of the scales and of gravity, or as the pressure drop imposes it at present.
        """
        equations, scales = self.equations, self.equations.scales
        drive = self._inflow.drive()
        pressure_drop = drive.value if drive.kind == "pressure_drop" else float(scales.pressure.value) - self._weight()
        gradients = self._along.even_gradients(pressure_drop)
        self._along.set_gradients(gradients)
        if not drive.value and equations.gravity is None:
            self.unknown.x.array[:] = 0.0
            return True
        self._guess(-self._along.at_nodes(gradients))
        return equations.model is None or equations.model.starts_near()

    def _weight(self) -> float:
        """Pressure (Pa) that gravity gives the fluid on its way through the bed, at the middle of its temperatures."""
        if self.equations.gravity is None:
            return 0.0
        middle = np.mean(ranks.extremes(self.domain.communicator, self.temperature.x.array))
        density = self._inflow.fluid.density(float(self.equations.fluid.reference_pressure.value), middle)
        return float(density * number_of(self.equations.gravity[0]) * self.columns.along[-1])

    def _guess(self, gradient: Floats) -> None:
        """Local equilibrium of drag and beads at a pressure gradient (Pa/m) for each node."""
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

    def _beside(self) -> Beside:
        """The pressure gradients, found with the profiles."""
        return Beside(
            complete=lambda update: self._gradients.complete(update), size_of=lambda update: self._gradients.update
        )

    def found(self) -> None:
        """Have the stream function carry the mass flow that is imposed."""
        displaced, given = self._mass_flow.displaced(), self._gradients.given_mass_flow(self._along.at_inlet)
        self._mass_flow.carry(self._streamfunction.renew(given, displaced), displaced)

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
