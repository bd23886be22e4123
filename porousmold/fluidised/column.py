r"""A column of beads that a gas flows through and may lift: beads one by one (DEM), the gas averaged over the space between them.

The column is a slab: between two walls across x[1], periodic in depth, with the gas from below along x[0]. The gas is
two-dimensional, on quadrilaterals of some bead diameters; the beads are spheres in three dimensions. Every bead gives its volume,
velocity and heat to the four nodes around it by their hat functions, and takes the values of the gas by the same.

A step: porosity and drag (`laws.fluidisation.suspension_drag`) at the nodes; velocity and pressure of the gas by Newton's method,
implicit in the drag of both sides (`equations.suspended_beads`); its temperature; then the beads, in `CHUNKS` parts,

    dv/dt = beta/(a rho_s) (u - v) - grad p/rho_s + g (1 - rho/rho_s),    implicit in v,

each followed by steps of their contacts (`packing.dynamics`). A bead takes up K (T - T_i) over the step with
K = M C (1 - exp(-h A dt/(M C)))/dt, so that it never overshoots, h by the correlation `NUSSELT`. The gas has constant properties.
The prediction of the beads' motion does not know what holds a bed at rest: its pressure drop is low by the part theta, 1 to 5 %.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias, cast

import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray

from ..equations.coordinates import Coordinates
from ..equations.flow import FlowEquations, FlowScales, FlowState
from ..equations.medium import Bed, FluidState
from ..equations.openings import Opening
from ..equations.suspended_beads import GasAmongBeads, GivenDrag, SuspendedBeads
from ..errors import InputError, SolveError
from ..laws.drag import DragLaw
from ..laws.fluidisation import GRAVITY, archimedes_number, suspension_drag
from ..laws.materials import Fluid, Solid
from ..laws.nusselt import NUSSELT_CORRELATIONS, prandtl_number
from ..mesh import domain as geometry
from ..mesh import fenicsx
from ..mpi import MPI
from ..packing import dynamics
from ..packing.container import Slab
from ..packing.generator import MEAN_OVERLAP, Mixture, pack
from ..solvers.newton import NewtonSystem, free_systems

NUSSELT = NUSSELT_CORRELATIONS["wakao"]
CHUNKS = 5
STEP = 0.05
"""Of the gas, in sqrt(d/g)."""
STEPS_PER_CONTACT = 10
RESTITUTION = 0.9
MOST_ITERATIONS, CONVERGED = 4, 1e-5
LARGEST_SHARE = 0.72
"""Of the beads at a node: denser than that no packing is."""
QUADRATURE = 3


Weights: TypeAlias = tuple[NDArray[Any], ...]
"""Of each bead: its cell along and across, and its place therein."""


@dataclass(frozen=True)
class ColumnInput:
    """SI. The bed at rest is `bed_height` high in a slab of `width` and `depth`, in a column of `height`. The gas enters with the
    superficial `velocity` and `inlet_temperature`, but for the `blocked_width` in the middle. `density`, `viscosity`,
    `heat_capacity` and `conductivity` are the gas's.

    Raises `InputError` for lengths that do not fit each other."""

    width: float
    depth: float
    height: float
    bed_height: float
    bead_diameter: float
    velocity: float
    density: float
    viscosity: float
    heat_capacity: float
    conductivity: float
    bead_density: float
    bead_heat_capacity: float
    initial_temperature: float = 293.15
    inlet_temperature: float = 353.15
    blocked_width: float = 0.0
    friction: float = 0.3
    cell_size: float = 3.5
    seed: int = 1

    def __post_init__(self) -> None:
        d = self.bead_diameter
        for key, least in (("width", 8.0 * d), ("height", 1.2 * self.bed_height), ("bed_height", 4.0 * d)):
            if getattr(self, key) < least:
                raise InputError(f"--{key.replace('_', '-')}", getattr(self, key), f"must be >= {least:g} m")
        if not 2.0 <= self.cell_size <= 10.0:
            raise InputError("--cell-size", self.cell_size, "must be >= 2 and <= 10 bead diameters")
        if not 0.0 <= self.blocked_width < 0.9 * self.width:
            raise InputError("--blocked-width", self.blocked_width, f"must be >= 0 and < {0.9 * self.width:g} m")
        if not self.velocity >= 0.0:
            raise InputError("--velocity", self.velocity, "must be >= 0 m/s")
        archimedes_number(d, self.density, self.bead_density, self.viscosity)

    @property
    def bead_mass(self) -> float:
        """Of a bead, kg."""
        return self.bead_density * math.pi / 6.0 * self.bead_diameter**3


class Column:
    """The state of a `ColumnInput`; `step()` advances it by `time_step` (s), `rows` has what is recorded of every step."""

    def __init__(self, given: ColumnInput, positions: NDArray[Any] | None = None) -> None:
        self.given, d = given, given.bead_diameter
        slab = Slab(given.width, given.depth)
        if positions is None:
            positions = pack(slab, Mixture((d,)), bed_height=given.bed_height, seed=given.seed).positions
            positions = positions[positions[:, 2] < given.bed_height]
        self.time_step = STEP * math.sqrt(d / GRAVITY)
        self.time = 0.0
        self.rows: list[dict[str, float]] = []
        self._make_beads(slab, positions)
        self._make_gas()
        self.heat_given = self.heat_carried_off = 0.0
        self._deposit()
        self._old_porosity.x.array[:] = self._porosity.x.array
        self._heat_at_first = self._stored_heat()

    def _make_beads(self, slab: Slab, positions: NDArray[Any]) -> None:
        given, d, count = self.given, self.given.bead_diameter, len(positions)
        self._body = np.zeros((count, 9))
        self._body[:, :3] = positions / d
        self._size = np.column_stack((np.full(count, 0.5), np.ones(count)))
        self._name, self._load = np.arange(count), np.zeros((count, 6))
        self.bead_temperature = np.full(count, given.initial_temperature)
        planes = np.array(slab.planes) * (1.0, 1.0, 1.0, 1.0 / d)
        self._walls = (planes, 0.0, np.array(slab.period) / d, np.zeros((len(planes) + 1, 3)))
        self._wall_spring = np.zeros((count, len(planes) + 1, 3))
        self._pairs = dynamics.no_pairs(count)
        self._slack = 0.0
        deep = count * math.pi / 6.0 * d / given.width * d / given.depth / 0.6  # in bead diameters
        stiffness = max(3.0 * deep / (5.5 * 2.0 * MEAN_OVERLAP), 1e4)
        self._material = dynamics.material_of(stiffness, RESTITUTION, given.friction)
        contact = dynamics.contact_time(stiffness, RESTITUTION)
        chunk = STEP / CHUNKS
        self._contact_steps = math.ceil(chunk / (contact / STEPS_PER_CONTACT))
        self._contact_step = chunk / self._contact_steps
        self._gravity = np.array([0.0, 0.0, -(1.0 - given.density / given.bead_density)])

    def _make_gas(self) -> None:
        given, size = self.given, self.given.cell_size * self.given.bead_diameter
        self._cells = (max(4, round(given.height / size)), max(3, round(given.width / size)))
        axial = np.linspace(0.0, given.height, self._cells[0] + 1)
        across = geometry.Across.to_wall(np.linspace(0.0, given.width, self._cells[1] + 1), [])
        self._domain = geometry.straight_bed(MPI.COMM_SELF, axial, [across])
        mesh, number = self._domain.mesh, self._domain.constant
        scalar, vector = fenicsx.lagrange_space(mesh), fenicsx.lagrange_space(mesh, 1, 2)
        mixed = fenicsx.mixed_space(mesh, [fenicsx.lagrange_element(mesh, 1, 2), fenicsx.lagrange_element(mesh, 1)])
        self._unknown, self._previous = fem.Function(mixed), fem.Function(mixed)
        self._grid = self._grid_of(scalar)
        self._vector_grid = self._grid_of(vector)
        velocity_space, self._velocity_dofs = fenicsx.collapse(mixed, 0)
        pressure_space, self._pressure_dofs = fenicsx.collapse(mixed, 1)
        self._velocity_grid, self._pressure_grid = self._grid_of(velocity_space), self._grid_of(pressure_space)
        parts = [np.full(n + 1, length / n) for n, length in zip(self._cells, (given.height, given.width), strict=True)]
        for part in parts:
            part[[0, -1]] *= 0.5
        self._volumes = np.outer(*parts) * given.depth
        self._porosity, self._old_porosity, self._drag, self._share, self._theta, self._yielding = (
            fem.Function(scalar) for _ in range(6)
        )
        self._bead_velocity, self._inflow = fem.Function(vector), fem.Function(scalar)
        open_to_gas = np.abs(np.linspace(-0.5, 0.5, self._cells[1] + 1) * given.width) >= 0.5 * given.blocked_width
        self._inflow.x.array[self._grid] = given.velocity * open_to_gas
        self._volume_flow = given.depth * given.velocity * float(parts[1] @ open_to_gas)
        speed = max(given.velocity, 1e-2 * math.sqrt(GRAVITY * given.bead_diameter))
        scales = FlowScales(number(speed), number(self.weight), number(given.bead_diameter))
        gas = _Gas(number(given.density), number(given.viscosity))
        solid, law = Solid("beads", given.bead_density, given.bead_heat_capacity, 1.0), GivenDrag(self._drag)
        distance, given_drag = self._domain.wall_distance, cast(DragLaw, law)
        bed = Bed(self._porosity, number(0.4), distance, scales.length, solid, given_drag, NUSSELT)
        equations = FlowEquations(bed, FluidState(cast(Fluid, gas), number(0.0)), Coordinates(mesh, False), scales)
        dx, ds = self._domain.cell_measure(QUADRATURE)(geometry.BED), self._domain.facet_measure(QUADRATURE)
        nodes = self._domain.nodal_measure()(geometry.BED)
        tests = ufl.TestFunctions(mixed)
        state = equations.state_of(ufl.split(self._unknown))
        self._inverse_step = number(1.0 / self.time_step)
        openings = [
            Opening(ds(geometry.INLET), mass_flux=number(given.density) * self._inflow),
            Opening(ds(geometry.OUTLET), pressure=number(0.0)),
        ]
        zero = number(0.0)
        old, sources = equations.state_of(ufl.split(self._previous)), (self._drag * self._bead_velocity, zero)
        form = equations.residual_of(state, old, tests, self._inverse_step, zero, openings, dx, nodes, sources)
        beads = SuspendedBeads(self._bead_velocity, self._share, self._theta, self._yielding)
        form += beads.residual(equations, state, tests, gas.density_of, dx)
        across_space, _ = mixed.sub(0).sub(1).collapse()
        sides = [
            fem.locate_dofs_geometrical((mixed.sub(0).sub(1), across_space), lambda x, at=at: np.isclose(x[1], at))[0]
            for at in (0.0, given.width)
        ]
        self._flow = NewtonSystem(form, self._unknown, np.unique(np.concatenate(sides)))
        self._scales = scales
        self._make_heat(equations, state, dx, nodes, ds)

    def _make_heat(
        self, equations: FlowEquations, state: FlowState, dx: ufl.Measure, nodes: ufl.Measure, ds: ufl.Measure
    ) -> None:
        given, number, scalar = self.given, self._domain.constant, self._porosity.function_space
        self.temperature, self._old_temperature, potential, imbalance, self._exchange, self._heating = (
            fem.Function(scalar) for _ in range(6)
        )
        self._imbalance = imbalance
        self.temperature.x.array[:] = given.initial_temperature
        before = equations.state_of(ufl.split(self._previous)).velocity
        momentum = equations.momentum(state, number(0.0), before, self._inverse_step, self._drag * self._bead_velocity)
        gas_flux = self._porosity * (state.velocity + momentum.fine_scale_velocity)
        normal = ufl.FacetNormal(self._domain.mesh)
        inlet, outlet = ds(geometry.INLET), ds(geometry.OUTLET)
        capacity, inflow = number(given.density * given.heat_capacity), self._inflow
        heat = GasAmongBeads(equations.coordinates, gas_flux + ufl.grad(potential), self._porosity, self._old_porosity, capacity,
                             number(given.conductivity), self._exchange, self._heating, dx, nodes, inlet, outlet)  # fmt: skip
        # what the discrete mass balance lets out has no fine scales
        leaving = self._porosity * ufl.dot(state.velocity, normal)
        test = ufl.TestFunction(scalar)
        gained = heat.imbalance(test, self._inverse_step, gas_flux, inflow, leaving)
        self._gained = fenicsx.compiled_form(gained)
        pinned = np.array([0], np.int32)
        self._correction = NewtonSystem(heat.correction(potential, imbalance), potential, pinned, keep_jacobian=True)
        form = heat.residual(
            self.temperature,
            self._old_temperature,
            self._inverse_step,
            inflow,
            number(given.inlet_temperature),
            leaving,
        )
        self._heat = NewtonSystem(form, self.temperature, np.empty(0, np.int32))
        self._carried_off = fenicsx.compiled_form(capacity * leaving * self.temperature * outlet)
        self._nodal_mass = fem.Function(scalar)
        _assembled(self._nodal_mass, fenicsx.compiled_form(test * nodes))

    def _grid_of(self, space: Any) -> NDArray[Any]:
        """Node of the space at each place of the grid."""
        at = space.tabulate_dof_coordinates()
        lengths = (self.given.height, self.given.width)
        i, j = (np.rint(at[:, a] / lengths[a] * self._cells[a]).astype(int) for a in (0, 1))
        grid = np.empty((self._cells[0] + 1, self._cells[1] + 1), int)
        grid[i, j] = np.arange(len(at))
        return grid

    def _weights(self) -> Weights:
        """Cell of each bead and its place therein, along and across."""
        d, given = self.given.bead_diameter, self.given
        along = np.clip(self._body[:, 2] * d / given.height * self._cells[0], 0.0, self._cells[0] - 1e-9)
        across = np.clip((self._body[:, 0] * d / given.width + 0.5) * self._cells[1], 0.0, self._cells[1] - 1e-9)
        i, j = along.astype(int), across.astype(int)
        return i, j, along - i, across - j

    def _spread(self, weights: Weights, values: NDArray[Any]) -> NDArray[Any]:
        """Sums of what beads have, on the grid."""
        i, j, a, b = weights
        row, size = self._cells[1] + 1, (self._cells[0] + 1) * (self._cells[1] + 1)
        found = np.zeros(size)
        for di, wa in ((0, 1.0 - a), (1, a)):
            for dj, wb in ((0, 1.0 - b), (1, b)):
                found += np.bincount((i + di) * row + j + dj, wa * wb * values, size)
        return found.reshape(-1, row)

    @staticmethod
    def _at(weights: Weights, field: NDArray[Any]) -> NDArray[Any]:
        """A field of the grid at the beads."""
        i, j, a, b = weights
        low = (1.0 - b) * field[i, j] + b * field[i, j + 1]
        return np.asarray((1.0 - a) * low + a * ((1.0 - b) * field[i + 1, j] + b * field[i + 1, j + 1]))

    def _gas_velocity(self) -> list[NDArray[Any]]:
        """Along and across, on the grid, m/s."""
        values = self._unknown.x.array[self._velocity_dofs].reshape(-1, 2) * float(self._scales.speed.value)
        return [values[self._velocity_grid, axis] for axis in (0, 1)]

    def _deposit(self) -> tuple[Weights, NDArray[Any], NDArray[Any], NDArray[Any]]:
        """Porosity, drag and the rest at the nodes, from beads and gas; gives weights, share, relative speed and drag."""
        given, d = self.given, self.given.bead_diameter
        weights, volume = self._weights(), np.pi / 6.0 * d**3
        share = np.minimum(self._spread(weights, np.full(len(self._body), volume)) / self._volumes, LARGEST_SHARE)
        unit = math.sqrt(GRAVITY * d)
        safe = np.maximum(share, 1e-9)
        beads = [
            self._spread(weights, volume * unit * self._body[:, 3 + axis]) / self._volumes / safe for axis in (2, 0)
        ]
        gas = self._gas_velocity()
        slip = np.hypot(gas[0] - beads[0], gas[1] - beads[1])
        drag = suspension_drag(1.0 - share, d, given.density, given.viscosity, slip)
        inertia = share * given.bead_density / self.time_step
        theta = drag / np.maximum(inertia + drag, 1e-30)
        beads[0] = beads[0] + GRAVITY * self._gravity[2] * self.time_step * (share > 0.0)
        for function, values in (
            (self._porosity, 1.0 - share),
            (self._drag, drag * (1.0 - theta)),
            (self._share, share),
            (self._theta, theta),
            (self._yielding, np.where(share > 0.0, share**2 / np.maximum(inertia + drag, 1e-30), 0.0)),
        ):
            function.x.array[self._grid] = values
        for axis in (0, 1):
            self._bead_velocity.x.array[2 * self._vector_grid + axis] = beads[axis]
        return weights, share, slip, drag

    def step(self) -> None:
        """One step. Raises `SolveError` where the gas finds no solution, or a bead leaves the column."""
        given, d = self.given, self.given.bead_diameter
        self._old_porosity.x.array[:] = self._porosity.x.array
        weights, share, slip, drag = self._deposit()
        self._previous.x.array[:] = self._unknown.x.array
        for _ in range(MOST_ITERATIONS):
            self._flow.renew_jacobian()
            update = self._flow.iterate()
            if not update > CONVERGED:
                break
        if not np.isfinite(update):
            raise SolveError("fluidise", self.time, "the gas among the beads", "larger cells (--cell-size)")
        pressure = self._unknown.x.array[self._pressure_dofs][self._pressure_grid] * float(self._scales.pressure.value)
        self._heat_up(weights, slip)
        gas = [self._at(weights, values) for values in self._gas_velocity()]
        push = [-slope / given.bead_density for slope in self._gradient(weights, pressure)]
        rate = self._at(weights, drag / np.maximum(share, 1e-9) / given.bead_density)
        before = self.upwards
        self._move(gas, push, rate)
        self.time += self.time_step
        unit = math.sqrt(GRAVITY * d)
        area, mass = given.width * given.depth, given.bead_mass
        force = mass * (push[0] + rate * (gas[0] - before)).sum() / area
        gained = self._stored_heat() - self._heat_at_first
        moved = self.heat_given - self.heat_carried_off
        self.rows.append({
            "time": self.time,
            "pressure_drop": float(pressure[0].mean() - pressure[-1].mean()),
            "force_on_beads": float(force),
            "bed_height": float(2.0 * d * self._body[:, 2].mean()),
            "highest_bead": float(d * self._body[:, 2].max()),
            "fastest_bead": float(unit * np.sqrt((self._body[:, 3:6] ** 2).sum(axis=1).max())),
            "bead_temperature": float(self.bead_temperature.mean()),
            "outlet_temperature": float(self.temperature.x.array[self._grid[-1]].mean()),
            "heat_imbalance": float((gained - moved) / max(abs(self.heat_given), 1e-30)),
        })  # fmt: skip
        if self.rows[-1]["highest_bead"] > given.height:
            raise SolveError("fluidise", self.time, "a bead leaves the column", "a higher one (--height), or less gas")

    def _gradient(self, weights: Weights, field: NDArray[Any]) -> list[NDArray[Any]]:
        """Along and across, in the cells of the beads."""
        i, j, a, b = weights
        sizes = [length / n for length, n in zip((self.given.height, self.given.width), self._cells, strict=True)]
        along = (1.0 - b) * (field[i + 1, j] - field[i, j]) + b * (field[i + 1, j + 1] - field[i, j + 1])
        across = (1.0 - a) * (field[i, j + 1] - field[i, j]) + a * (field[i + 1, j + 1] - field[i + 1, j])
        return [along / sizes[0], across / sizes[1]]

    def _move(self, gas: list[NDArray[Any]], push: list[NDArray[Any]], rate: NDArray[Any]) -> None:
        """The beads over a step, by what the gas does to each."""
        unit = math.sqrt(GRAVITY * self.given.bead_diameter)
        names = self._name.copy()
        by_name = np.empty((len(names), 5))
        by_name[names] = np.column_stack((*gas, *push, rate))
        span = self.time_step / CHUNKS
        for _ in range(CHUNKS):
            along, across, push_along, push_across, drag = by_name[self._name].T
            for axis, velocity, acceleration in ((5, along, push_along), (3, across, push_across), (4, 0.0, 0.0)):
                now = unit * self._body[:, axis]
                self._body[:, axis] = (now + span * (acceleration + drag * velocity)) / (1.0 + span * drag) / unit
            left = self._contact_steps
            while left > 0:
                if self._slack <= 0.0:
                    self._renew_pairs()
                done, self._slack = dynamics.advance(
                    self._body, self._load, self._size, self._pairs, self._walls, self._wall_spring, self._material,
                    self._gravity, self._contact_step, left, self._slack)  # fmt: skip
                left -= done

    def _renew_pairs(self) -> None:
        fastest = math.sqrt((self._body[:, 3:6] ** 2).sum(axis=1).max())
        skin = min(max(0.06, 60.0 * self._contact_step * fastest), 0.35)
        before = self._name.copy()
        self._pairs = dynamics.renew_pairs(
            self._body, self._size, self._name, self._wall_spring, self._pairs, skin, self._walls[2], self._material[1]
        )
        place = np.empty_like(before)
        place[before] = np.arange(len(before))
        self.bead_temperature = self.bead_temperature[place[self._name]]
        self._slack = 0.5 * skin

    def _heat_up(self, weights: Weights, slip: NDArray[Any]) -> None:
        """Temperatures of gas and beads over a step."""
        given, d = self.given, self.given.bead_diameter
        porosity = self._porosity.x.array[self._grid]
        reynolds = porosity * given.density * slip * d / given.viscosity
        prandtl = prandtl_number(given.viscosity, given.heat_capacity, given.conductivity)
        film = np.asarray(NUSSELT(reynolds, prandtl, porosity)) * given.conductivity / d
        capacity = given.bead_mass * given.bead_heat_capacity
        along = self._at(weights, film) * np.pi * d**2 * self.time_step / capacity
        conductance = -capacity / self.time_step * np.expm1(-along)
        self._exchange.x.array[self._grid] = self._spread(weights, conductance) / self._volumes
        self._heating.x.array[self._grid] = self._spread(weights, conductance * self.bead_temperature) / self._volumes
        _assembled(self._imbalance, self._gained)
        self._imbalance.x.array[:] /= self._nodal_mass.x.array
        self._correction.iterate()
        self._old_temperature.x.array[:] = self.temperature.x.array
        self._heat.renew_jacobian()
        self._heat.iterate()
        warm = self._at(weights, self.temperature.x.array[self._grid])
        self.bead_temperature += conductance * (warm - self.bead_temperature) * self.time_step / capacity
        flow = given.density * given.heat_capacity * self._volume_flow
        self.heat_given += flow * (given.inlet_temperature - given.initial_temperature) * self.time_step
        outlet = float(fem.assemble_scalar(self._carried_off))
        self.heat_carried_off += (outlet * given.depth - flow * given.initial_temperature) * self.time_step

    def _stored_heat(self) -> float:
        """Of beads and gas, above the initial temperature, J."""
        given, start = self.given, self.given.initial_temperature
        gas = self._porosity.x.array * (self.temperature.x.array - start)
        in_gas = given.density * given.heat_capacity * (self._volumes * gas[self._grid]).sum()
        return float(in_gas + given.bead_mass * given.bead_heat_capacity * (self.bead_temperature - start).sum())

    @property
    def places(self) -> NDArray[Any]:
        """Of the beads across and up (n, 2), m."""
        return self.given.bead_diameter * self._body[:, [0, 2]]

    @property
    def upwards(self) -> NDArray[Any]:
        """Velocities of the beads, m/s."""
        return math.sqrt(GRAVITY * self.given.bead_diameter) * self._body[:, 5]

    @property
    def weight(self) -> float:
        """Of the beads less buoyancy, over the cross-section, Pa."""
        given = self.given
        mass = len(self._body) * given.bead_mass * (1.0 - given.density / given.bead_density)
        return mass * GRAVITY / (given.width * given.depth)

    def march(self, end_time: float, progress: Callable[[float, float, str], None] | None = None) -> None:
        """Step until `end_time` (s); progress(time, end time, text)."""
        while self.time < end_time - 0.5 * self.time_step:
            self.step()
            if progress is not None:
                progress(self.time, end_time, f"{self.rows[-1]['bead_temperature'] - 273.15:.1f} °C")

    def free(self) -> None:
        """Free what PETSc holds."""
        free_systems(self._domain.mesh)


@dataclass(frozen=True)
class _Gas:
    """A fluid of constant properties, as UFL constants."""

    density_of: Any
    viscosity_of: Any

    def density(self, pressure: Any, temperature: Any) -> Any:
        return self.density_of

    def viscosity(self, temperature: Any) -> Any:
        return self.viscosity_of


def _assembled(function: fem.Function, form: Any) -> None:
    """A linear form into the array of a function."""
    fenicsx.assemble_vector(fenicsx.petsc_vector(function), form)
