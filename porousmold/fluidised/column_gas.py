"""The gas of a column: its equations (`equations.flow`, `equations.suspended_beads`) on quadrilaterals, step by step."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np
import ufl
from dolfinx import fem

from ..arrays import Floats
from ..equations.coordinates import Coordinates
from ..equations.flow import BedMeasures, FlowEquations, FlowScales, FlowState
from ..equations.medium import Bed, FluidState
from ..equations.openings import Opening
from ..equations.suspended_beads import GasAmongBeads, GivenDrag, SuspendedBeads
from ..errors import SolveError
from ..laws.drag import DragLaw
from ..laws.fluidisation import GRAVITY
from ..laws.functions import Value
from ..laws.materials import Fluid, Solid
from ..laws.nusselt import NUSSELT_CORRELATIONS
from ..mesh import domain as geometry
from ..mesh import fenicsx
from ..mesh.aliases import Form, Space
from ..mpi import MPI
from ..solvers.newton import NewtonSystem, free_systems
from .column_grid import ColumnGrid
from .column_input import ColumnInput

MOST_ITERATIONS, CONVERGED = 4, 1e-5
QUADRATURE = 3


class ColumnGas:
    """Velocity, pressure and temperature of the gas at the nodes of a `ColumnGrid`; `weight` (Pa) scales the pressure."""

    def __init__(self, given: ColumnInput, grid: ColumnGrid, weight: float) -> None:
        self.given, self._grid = given, grid
        axial = np.linspace(0.0, given.height, grid.cells[0] + 1)
        across = geometry.Across.to_wall(np.linspace(0.0, given.width, grid.cells[1] + 1), [])
        self._domain = geometry.straight_bed(MPI.COMM_SELF, axial, [across])
        mesh = self._domain.mesh
        scalar, vector = fenicsx.lagrange_space(mesh), fenicsx.lagrange_space(mesh, 1, 2)
        mixed = fenicsx.mixed_space(mesh, [fenicsx.lagrange_element(mesh, 1, 2), fenicsx.lagrange_element(mesh, 1)])
        self._unknown, self._previous = fem.Function(mixed), fem.Function(mixed)
        self._nodes, self._vector_nodes = (
            grid.nodes_of(space.tabulate_dof_coordinates()) for space in (scalar, vector)
        )
        velocity_space, self._velocity_dofs = fenicsx.collapse(mixed, 0)
        pressure_space, self._pressure_dofs = fenicsx.collapse(mixed, 1)
        self._velocity_nodes, self._pressure_nodes = (
            grid.nodes_of(space.tabulate_dof_coordinates()) for space in (velocity_space, pressure_space)
        )
        self._porosity, self._old_porosity, self._drag, self._share, self._theta, self._yielding = (
            fem.Function(scalar) for _ in range(6)
        )
        self._temperature, self._old_temperature, self._potential, self._imbalance, self._exchange, self._heating = (
            fem.Function(scalar) for _ in range(6)
        )
        self._bead_velocity, self._inflow = fem.Function(vector), fem.Function(scalar)
        self._temperature.x.array[:] = given.initial_temperature
        open_to_gas = _open_parts(grid.cells[1], given.width, given.blocked_width)
        self._inflow.x.array[self._nodes] = given.velocity * open_to_gas
        self.volume_flow = given.depth * given.velocity * float(grid.parts[1] @ open_to_gas)
        speed = max(given.velocity, 1e-2 * math.sqrt(GRAVITY * given.bead_diameter))
        number = self._domain.constant
        self._scales = FlowScales(number(speed), number(weight), number(given.bead_diameter))
        self._inverse_step = number(1.0 / given.time_step)
        self._make_flow(mixed)

    def _make_flow(self, mixed: Space) -> None:
        given, number, scales, mesh = self.given, self._domain.constant, self._scales, self._domain.mesh
        gas = _Gas(number(given.density), number(given.viscosity))
        solid, law = Solid("beads", given.bead_density, given.bead_heat_capacity, 1.0), GivenDrag(self._drag)
        distance, given_drag = self._domain.wall_distance, cast(DragLaw, law)
        bed = Bed(
            self._porosity, number(0.4), distance, scales.length, solid, given_drag, NUSSELT_CORRELATIONS[given.nusselt]
        )
        equations = FlowEquations(bed, FluidState(cast(Fluid, gas), number(0.0)), Coordinates(mesh, False), scales)
        dx, ds = self._domain.cell_measure(QUADRATURE)(geometry.BED), self._domain.facet_measure(QUADRATURE)
        measures = BedMeasures(dx, self._domain.nodal_measure()(geometry.BED))
        tests = ufl.TestFunctions(mixed)
        state = equations.state_of(ufl.split(self._unknown))
        openings = [
            Opening(ds(geometry.INLET), mass_flux=number(given.density) * self._inflow),
            Opening(ds(geometry.OUTLET), pressure=number(0.0)),
        ]
        zero = number(0.0)
        old = equations.state_of(ufl.split(self._previous))
        beads = SuspendedBeads(self._bead_velocity, self._share, self._theta, self._yielding)
        force = beads.force(state, self._drag) - number(given.depth_drag) * state.velocity
        form = equations.residual_of(state, old, tests, self._inverse_step, zero, openings, measures, (force, zero))
        form += beads.residual(equations, state, tests[1], gas.density_of, dx)
        across_space, _ = mixed.sub(0).sub(1).collapse()
        sides = [
            fem.locate_dofs_geometrical((mixed.sub(0).sub(1), across_space), lambda x, at=at: np.isclose(x[1], at))[0]
            for at in (0.0, given.width)
        ]
        self._flow = NewtonSystem("gas", form, self._unknown, np.unique(np.concatenate(sides)))
        self._make_heat(equations, state, force, measures, ds)

    def _make_heat(
        self,
        equations: FlowEquations,
        state: FlowState,
        force: Value,
        measures: BedMeasures,
        ds: ufl.Measure,
    ) -> None:
        given, number, scalar = self.given, self._domain.constant, self._porosity.function_space
        before = equations.state_of(ufl.split(self._previous)).velocity
        momentum = equations.momentum(state, number(0.0), before, self._inverse_step, force)
        gas_flux = self._porosity * (state.velocity + momentum.fine_scale_velocity)
        inlet, outlet = ds(geometry.INLET), ds(geometry.OUTLET)
        capacity, inflow = number(given.density * given.heat_capacity), self._inflow
        flux = gas_flux + ufl.grad(self._potential)
        heat = GasAmongBeads(equations.coordinates, flux, self._porosity, self._old_porosity, capacity,
                             number(given.conductivity), self._exchange, self._heating, *measures, inlet, outlet)  # fmt: skip
        # what the discrete mass balance lets out has no fine scales
        leaving = self._porosity * ufl.dot(state.velocity, ufl.FacetNormal(self._domain.mesh))
        test = ufl.TestFunction(scalar)
        self._gained = fenicsx.compiled_form(heat.imbalance(test, self._inverse_step, gas_flux, inflow, leaving))
        correction, pinned = heat.correction(self._potential, self._imbalance), np.array([0], np.int32)
        self._correction = NewtonSystem("gas_flux", correction, self._potential, pinned, keep_jacobian=True)
        form = heat.residual(self._temperature, self._old_temperature, self._inverse_step, inflow,
                             number(given.inlet_temperature), leaving)  # fmt: skip
        self._heat = NewtonSystem("gas_energy", form, self._temperature, np.empty(0, np.int32))
        self._carried_off = fenicsx.compiled_form(capacity * leaving * self._temperature * outlet)
        self._nodal_mass = fem.Function(scalar)
        _assembled(self._nodal_mass, fenicsx.compiled_form(test * measures.nodes))

    @property
    def porosity(self) -> Floats:
        """At the nodes, as all that follows."""
        return np.asarray(self._porosity.x.array[self._nodes])

    @property
    def temperature(self) -> Floats:
        """K."""
        return np.asarray(self._temperature.x.array[self._nodes])

    @property
    def velocity(self) -> list[Floats]:
        """Upwards and across, m/s."""
        values = self._unknown.x.array[self._velocity_dofs].reshape(-1, 2) * float(self._scales.speed.value)
        return [values[self._velocity_nodes, axis] for axis in (0, 1)]

    @property
    def pressure(self) -> Floats:
        """Above that of the outlet, Pa."""
        return np.asarray(
            self._unknown.x.array[self._pressure_dofs][self._pressure_nodes] * float(self._scales.pressure.value)
        )

    def keep(self) -> None:
        """Take velocity, temperature and porosity as those before the step."""
        self._previous.x.array[:] = self._unknown.x.array
        self._old_porosity.x.array[:] = self._porosity.x.array
        self._old_temperature.x.array[:] = self._temperature.x.array

    def surround(
        self,
        share: Floats,
        bead_velocity: list[Floats],
        drag: Floats,
        theta: Floats,
        yielding: Floats,
    ) -> None:
        """Set what the beads are at the nodes, as `equations.suspended_beads` names it."""
        for function, values in (
            (self._porosity, 1.0 - share),
            (self._drag, drag * (1.0 - theta)),
            (self._share, share),
            (self._theta, theta),
            (self._yielding, yielding),
        ):
            function.x.array[self._nodes] = values
        for axis in (0, 1):
            self._bead_velocity.x.array[2 * self._vector_nodes + axis] = bead_velocity[axis]

    def flow(self, time: float) -> None:
        """Velocity and pressure at the end of the step. Raises `SolveError` where there are none."""
        for _ in range(MOST_ITERATIONS):
            self._flow.renew_jacobian()
            update = self._flow.iterate()
            if not update > CONVERGED:
                break
        if not np.isfinite(update):
            raise SolveError("fluidise", time, "the gas among the beads", "larger cells (--cell-size)")

    def heat_up(self, exchange: Floats, heating: Floats) -> float:
        """Temperature at the end of the step, with sum K per volume (W/m3/K) and sum K T_i (W/m3) at the nodes; gives the heat
        (W) that leaves through the outlet."""
        self._exchange.x.array[self._nodes], self._heating.x.array[self._nodes] = exchange, heating
        _assembled(self._imbalance, self._gained)
        self._imbalance.x.array[:] /= self._nodal_mass.x.array
        self._correction.iterate()
        self._heat.renew_jacobian()
        self._heat.iterate()
        return float(fem.assemble_scalar(self._carried_off)) * self.given.depth

    def save(self) -> dict[str, Floats]:
        """Everything that the next step goes on from."""
        return {name: function.x.array for name, function in self._kept().items()}

    def restore(self, saved: Mapping[str, object]) -> None:
        """Go on from what `save` gave."""
        for name, function in self._kept().items():
            function.x.array[:] = saved[name]

    def _kept(self) -> dict[str, fem.Function]:
        return {
            "flow": self._unknown,
            "porosity": self._porosity,
            "temperature": self._temperature,
            "potential": self._potential,
        }

    def free(self) -> None:
        """Free what PETSc holds."""
        free_systems(self._domain.mesh)


@dataclass(frozen=True)
class _Gas:
    """A fluid of constant properties, as UFL constants."""

    density_of: Value
    viscosity_of: Value

    def density(self, pressure: Value, temperature: Value) -> Value:
        return self.density_of

    def viscosity(self, temperature: Value) -> Value:
        return self.viscosity_of


def _assembled(function: fem.Function, form: Form) -> None:
    """A linear form into the array of a function."""
    fenicsx.assemble_vector(fenicsx.petsc_vector(function), form)


def _open_parts(cells: int, width: float, blocked_width: float) -> Floats:
    """Of what each node of the floor stands for, half a cell to either side, the part that is open, not in the blocked middle."""
    places = np.linspace(-0.5, 0.5, cells + 1) * width
    low, high = (np.clip(places + side * width / cells, -0.5 * width, 0.5 * width) for side in (-0.5, 0.5))
    blocked = np.minimum(high, 0.5 * blocked_width) - np.maximum(low, -0.5 * blocked_width)
    return np.asarray(1.0 - np.maximum(blocked, 0.0) / (high - low))
