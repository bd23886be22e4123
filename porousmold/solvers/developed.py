"""Developed flow at all stations of a straight bed at once, plug flow, and the stream function that carries their heat.

The stations' profiles are one nonlinear system, solved as the full flow is; dp/dx at each station and the mass flow that
passes all of them follow by elimination: with s = du/d(dp/dx) from one more solve with the same factors, the mass flow
of a station is linear in its dp/dx, and the pressure drop (or the mass flow) that the scene imposes closes the system.
"""

import numpy as np
import ufl
from dolfinx import fem
from scipy.optimize import brentq

from .. import fenicsx
from ..equations.developed import developed_residual, developed_state
from ..equations.flow import FlowState
from ..errors import SolveError
from ..geometry import BED, INTERFACE, WALL
from .equilibrium import local_equilibrium
from .flow import LEAST_VALUE, SteadyFlow, unknowns_outside
from .newton import NewtonSystem

GAUSS_DEGREE = 3
LARGEST_CHANGE = 0.3
"""Largest change of dp/dx in one iteration, as a part of the largest of all stations or of the scale."""


class Columns:
    """Sums over the columns of nodes of a straight bed, its stations, on all ranks alike. Lengths in m."""

    def __init__(self, domain):
        self.domain = domain
        self.along, self.across = domain.columns
        steps = np.diff(self.along)
        self.widths = 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))

    def of(self, points):
        """Number of the station of each point."""
        return nearest(self.along, np.asarray(points)[:, 0])

    def total(self, columns, values):
        """Sum of owned values by their column, over all ranks."""
        sums = np.bincount(columns, weights=values, minlength=len(self.along))
        return self.domain.communicator.allreduce(sums)

    def pressure(self, gradient):
        """Gauge pressure (Pa) at the stations for dp/dx (Pa/m), 0 at the last: the trapezoidal rule."""
        steps = 0.5 * np.diff(self.along) * (gradient[1:] + gradient[:-1])
        return np.append(-np.cumsum(steps[::-1])[::-1], 0.0)


def nearest(grid, values):
    """Index of the nearest of the rising grid's nodes to each value."""
    return np.searchsorted(0.5 * (grid[1:] + grid[:-1]), values)


class Streamfunction:
    """Stream function of an axial mass flux (kg/m2/s, UFL): `function`, constant along the wall and 0 on the symmetry line."""

    def __init__(self, domain, weighted_flux):
        self._domain = domain
        self.function = fem.Function(fenicsx.lagrange_space(domain.mesh))
        axis = fenicsx.flow_axis(domain.mesh)
        rule = fenicsx.column_rule(axis, GAUSS_DEGREE)
        self._values = fenicsx.evaluate(weighted_flux, domain.mesh, rule["quadrature_points"])
        self._weights = 2.0 * np.array(rule["quadrature_weights"])[: len(rule["quadrature_weights"]) // 2]
        along, across = domain.columns
        size = domain.mesh.topology.index_map(2).size_local
        middle = domain.mesh.geometry.x[fenicsx.cell_vertices(domain.mesh)[:size]].mean(axis=1)
        self._bed = np.flatnonzero(middle[:, 1] < across[-1])
        self._place = (
            np.searchsorted(along, middle[self._bed, 0]) - 1,
            np.searchsorted(across, middle[self._bed, 1]) - 1,
        )
        nodes = self.function.function_space.tabulate_dof_coordinates()
        self._node = tuple(nearest(grid, nodes[:, axis]) for axis, grid in enumerate((along, across)))

    def renew(self, total=None):
        """Integrate the present flux across the bed, as a part of `total` (kg/s, or per metre of width; default: the mean of
        all stations), so that the same mass flow passes every station whatever the iterations left."""
        along, across = self._domain.columns
        values = self._values()[self._bed].reshape(len(self._bed), 2, len(self._weights)) @ self._weights
        through = np.zeros((len(along), len(across) - 1, 2))
        heights = np.diff(across)[self._place[1]]
        for end in (0, 1):
            through[self._place[0] + end, self._place[1], end] = values[:, end] * heights
        through = self._domain.communicator.allreduce(through).max(axis=2, initial=0.0)
        table = np.hstack([np.zeros((len(along), 1)), np.cumsum(through, axis=1)])
        through = table[:, -1]
        total = through.mean() if total is None else total
        if np.all(through > 0.0):
            table *= total / through[:, None]
        self.function.x.array[:] = table[self._node]


class DevelopedFlow(SteadyFlow):
    """Developed flow over the bed of a straight domain. `equations` are `FlowEquations`.

    `drive()` gives what the scene imposes at present: ("pressure_drop", Pa), ("mass_flow", kg/s), or ("velocity", m/s,
    inlet temperature K), superficial; `area` (m2) is the section, `fluid` the scene's `Fluid` in plain numbers. `state` has
    the fields with units, `streamfunction` carries the mass flow.
    """

    kept_iterations = 0  # the stations' matrix takes less to factorise than an iteration with kept factors saves

    def __init__(self, domain, equations, temperature, drive, area, fluid):
        self.domain, self.equations, self.temperature = domain, equations, temperature
        self._drive, self._area, self._fluid = drive, area, fluid
        self._turbulent = equations.model is not None
        element = fenicsx.lagrange_element(domain.mesh, 1)
        self.space = (
            fenicsx.mixed_space(domain.mesh, [element] * 3) if self._turbulent else fenicsx.lagrange_space(domain.mesh)
        )
        self.unknown, self._previous, self._carried = (fem.Function(self.space) for _ in range(3))
        self._inverse_step = fem.Constant(domain.mesh, 0.0)
        scalars = fenicsx.lagrange_space(domain.mesh)
        self.pressure, self.gradient = fem.Function(scalars), fem.Function(scalars)
        self.columns = Columns(domain)
        dx = domain.column_measure(GAUSS_DEGREE)
        arguments = (self.unknown, self._previous, self._inverse_step, self.pressure, self.gradient, temperature)
        residual = developed_residual(equations, *arguments, dx(BED), domain.nodal_measure()(BED))
        push = ufl.derivative(residual, self.gradient, fem.Constant(domain.mesh, 1.0) * unit(scalars))
        nothing = fem.Constant(domain.mesh, 0.0)
        residual += nothing * ufl.inner(self.unknown, ufl.TestFunction(self.space)) * dx(WALL)
        held = self._held()
        self._system = NewtonSystem(residual, self.unknown, np.unique(held), keep_jacobian=True, pivoting=False)
        self._push = fenicsx.compiled_form(push)
        self.state = developed_state(self.unknown, self.pressure, equations.scales, self._turbulent)
        bed = equations.bed
        density = equations.fluid.density(self.pressure, temperature)
        weighted = equations.coordinates.weight * bed.porosity * density * equations.scales.speed
        carried = ufl.split(self._carried)[0] if self._turbulent else self._carried
        self._through = fenicsx.compiled_form(weighted * carried * ufl.TestFunction(scalars) * dx(BED))
        self._sums = fenicsx.petsc_vector(self.pressure).duplicate()
        self._owned = scalars.dofmap.index_map.size_local
        nodes = scalars.tabulate_dof_coordinates()
        self._column = self.columns.of(nodes)
        self._column_of_unknown = self.columns.of(self._coordinates_of_unknowns())
        present = ufl.split(self.unknown)[0] if self._turbulent else self.unknown
        self._streamfunction = Streamfunction(domain, weighted * present)
        self.streamfunction = self._streamfunction.function
        self._stations = self.columns.total(self._column[: self._owned], np.ones(self._owned))
        speed, *turbulence = (numbers for _, numbers in self._parts())
        self._take_parts([speed], turbulence)
        self._reset_counters()

    def _parts(self):
        return (
            [fenicsx.collapse(self.space, part) for part in range(3)]
            if self._turbulent
            else [(self.space, np.arange(len(self.unknown.x.array)))]
        )

    def _coordinates_of_unknowns(self):
        points = np.zeros((len(self.unknown.x.array), 3))
        for space, numbers in self._parts():
            points[numbers] = space.tabulate_dof_coordinates()
        return points

    def _held(self):
        domain, facets = self.domain, self.domain.facets(INTERFACE)
        if not self._turbulent:
            inside = fem.locate_dofs_topological(self.space, 2, domain.cells(BED))
            outside = np.setdiff1d(np.arange(len(self.unknown.x.array)), inside)
            return np.concatenate([outside, fem.locate_dofs_topological(self.space, 1, facets)])
        held = [unknowns_outside(domain, self.space, range(3), BED)]
        held += [fem.locate_dofs_topological(self.space.sub(part), 1, facets) for part in (0, 1)]
        return np.concatenate(held)

    @property
    def functions(self):
        return [self.unknown, self.pressure, self.gradient, self.streamfunction]

    def initial_guess(self) -> bool:
        """Start from the local equilibrium of drag and beads, with their undamped turbulence.

        The pressure gradient is that of the scales, or as the pressure drop imposes it at present.
        """
        equations, scales, space = self.equations, self.equations.scales, self.pressure.function_space
        kind, *value = self._drive()
        pressure_drop = value[0] if kind == "pressure_drop" else float(scales.pressure.value)
        gradient = pressure_drop / self.columns.along[-1]
        self._set_gradients(np.full(len(self.columns.along), -gradient))
        if not value[0]:
            self.unknown.x.array[:] = 0.0
            return True
        temperature, pressure = self.temperature.x.array, self.pressure.x.array
        fields = local_equilibrium(equations, self._fluid, space, gradient, temperature, pressure)
        speed, length = float(scales.speed.value), float(scales.length.value)
        fields = [field / size for field, size in zip(fields, (speed, speed**2, speed**3 / length), strict=False)]
        given = fem.Function(space)
        for values, (part, numbers) in zip(fields, self._parts(), strict=True):
            given.x.array[:] = values
            there = fem.Function(part)
            there.interpolate(given)
            self.unknown.x.array[numbers] = there.x.array
        self._clear_held()
        return not self._turbulent or (equations.model.bead_sources and not equations.model.damped)

    @property
    def _gradients(self):
        """dp/dx (Pa/m) at the stations."""
        sums = self.columns.total(self._column[: self._owned], self.gradient.x.array[: self._owned])
        return sums / self._stations

    def _set_gradients(self, gradients):
        self.gradient.x.array[:] = gradients[self._column]
        self.pressure.x.array[:] = self.columns.pressure(gradients)[self._column]

    def _through_stations(self, values):
        """Mass flow (kg/s) through every station for a scaled velocity in an array like the unknown's."""
        self._carried.x.array[:] = values
        fenicsx.assemble_vector(self._sums, self._through)
        return self.columns.total(self._column[: self._owned], self._sums.array[: self._owned]) / self.columns.widths

    def _iterate(self):
        """One Newton iteration of profiles, pressure gradients and mass flow together; its relative update."""
        before = self.unknown.x.array.copy()
        update = super()._iterate()
        if not np.isfinite(update):
            return np.inf
        push = fenicsx.petsc_vector(self.unknown).duplicate()
        fenicsx.assemble_vector(push, self._push)
        push.scale(-1.0)
        response = self._system.apply_inverse(push)
        gain = fem.Function(self.space)
        response.copy(fenicsx.petsc_vector(gain))
        gain.x.scatter_forward()
        flow, slope = self._through_stations(self.unknown.x.array), self._through_stations(gain.x.array)
        gradients, scale = self._gradients, float(self.equations.scales.pressure.value) / self.columns.along[-1]
        change = (self._imposed_mass_flow(gradients, flow, slope) - flow) / slope
        largest = LARGEST_CHANGE * max(np.max(np.abs(gradients)), scale)
        change = np.clip(change, -largest, largest)
        self.unknown.x.array[:] += gain.x.array * change[self._column_of_unknown]
        gradients += change
        relative = np.max(np.abs(change)) / max(np.max(np.abs(gradients)), LEAST_VALUE * scale)
        self._set_gradients(gradients)
        return max(self._updates(before)[0], relative)

    def _given_mass_flow(self, gradients):
        """Mass flow (kg/s) that the drive gives; None where it gives the pressure drop."""
        kind, *value = self._drive()
        if kind == "mass_flow":
            return value[0]
        if kind == "velocity":
            inlet = self.columns.pressure(gradients)[0]
            absolute = inlet + float(self.equations.fluid.reference_pressure.value)
            return value[0] * self._area * self._fluid.density(absolute, value[1])
        return None

    def _imposed_mass_flow(self, gradients, flow, slope):
        given = self._given_mass_flow(gradients)
        if given is not None:
            return given
        _, pressure_drop = self._drive()
        widths = self.columns.widths
        return (-pressure_drop - np.sum(widths * (gradients - flow / slope))) / np.sum(widths / slope)

    def _carry(self) -> None:
        """Have the stream function carry the mass flow that is imposed."""
        self._streamfunction.renew(self._given_mass_flow(self._gradients))

    def start(self, time: float = 0.0) -> None:
        """Find the profiles of all stations from the initial guess, and carry their mass flow by the stream function."""
        super().start(time)
        self._carry()

    def solve(self, time=0.0):
        """Converge the profiles of all stations, and carry their mass flow by the stream function."""
        super().solve(time)
        self._carry()

    def renew(self, time, tolerance):
        """Follow a changed temperature."""
        super().renew(time, tolerance)
        self._carry()

    def fields(self):
        """Present velocity, pressure and turbulence (SI) as functions by name (collective)."""
        scales = self.equations.scales
        speed = float(scales.speed.value)
        vectors = fem.Function(fenicsx.lagrange_space(self.domain.mesh, 1, 2), name="velocity")
        parts = self._parts()
        along = fem.Function(self.pressure.function_space)
        along.interpolate(self.unknown.sub(0) if self._turbulent else self.unknown)
        vectors.x.array[0::2] = speed * along.x.array
        pressure = fem.Function(self.pressure.function_space, name="pressure")
        pressure.x.array[:] = self.pressure.x.array
        fields = {"velocity": vectors, "pressure": pressure}
        for index, name, factor in (
            (1, "turbulent_kinetic_energy", speed**2),
            (2, "dissipation_rate", speed**3 / float(scales.length.value)),
        )[: len(parts) - 1]:
            space, numbers = parts[index]
            fields[name] = fem.Function(space, name=name)
            fields[name].x.array[:] = factor * self.unknown.x.array[numbers]
        return fields


def unit(space):
    """Function that is 1 everywhere."""
    function = fem.Function(space)
    function.x.array[:] = 1.0
    return function


class PlugFlow:
    """Uniform superficial mass flux, whose pressure drop is that of the bulk's porosity. `drive` as for `DevelopedFlow`.

    `resistance(mass_flux, density, viscosity)` is dp/dx (Pa/m) of the bulk at a superficial mass flux (kg/m2/s).
    """

    unknowns = 0

    def __init__(self, domain, equations, temperature, drive, area, fluid, resistance):
        self.domain, self.equations, self.temperature = domain, equations, temperature
        self._drive, self._area, self._fluid, self._resistance = drive, area, fluid, resistance
        scalars = fenicsx.lagrange_space(domain.mesh)
        self.pressure, self.streamfunction, self._mass_flux = (fem.Function(scalars) for _ in range(3))
        self.columns = Columns(domain)
        density = equations.fluid.density(self.pressure, temperature)
        velocity = ufl.as_vector([self._mass_flux / (equations.bed.porosity * density), 0.0])
        self.state = FlowState(velocity, self.pressure)
        nodes = scalars.tabulate_dof_coordinates()
        self._column, self._owned = self.columns.of(nodes), scalars.dofmap.index_map.size_local
        across = np.minimum(nodes[:, 1], self.columns.across[-1])
        self._section = np.pi * across**2 if domain.axisymmetric else across
        bed = nodes[: self._owned, 1] <= self.columns.across[-1] * (1 + 1e-9)
        self._in_bed = np.flatnonzero(bed)
        self.newton_iterations = self.solves = self.continuation_steps = 0
        self.largest_undershoot = 0.0

    @property
    def functions(self):
        """What the state of the flow is kept in."""
        return [self.pressure, self.streamfunction, self._mass_flux]

    def start(self, time: float = 0.0) -> None:
        """The same as `solve`: there is nothing to guess."""
        self.solve(time)

    def solve(self, time=0.0):
        """The mass flux that belongs to the pressure drop, or the pressure that belongs to the mass flux."""
        columns = self._column[self._in_bed]
        counts = self.columns.total(columns, np.ones(len(columns)))
        temperature = self.columns.total(columns, self.temperature.x.array[self._in_bed]) / counts
        law, reference = self._fluid, float(self.equations.fluid.reference_pressure.value)
        kind, *value = self._drive()

        def pressures(mass_flux):
            gauge = np.zeros(len(temperature))
            for _ in range(8):  # the density hardly depends on it
                density = law.density(gauge + reference, temperature) + 0.0 * temperature
                gradient = self._resistance(mass_flux, density, law.viscosity(temperature))
                gauge = self.columns.pressure(-gradient)
            return gauge

        if kind == "pressure_drop":
            largest = 1.0
            while pressures(largest)[0] < value[0]:
                largest *= 4.0
                if largest > 1e9:
                    raise SolveError("plug flow", time, "no mass flux has this pressure drop", "a smaller one")
            mass_flux = brentq(lambda flux: pressures(flux)[0] - value[0], 0.0, largest, rtol=1e-12)
        elif kind == "mass_flow":
            mass_flux = value[0] / self._area
        else:
            mass_flux = value[0] * law.density(self.pressure.x.array.max(initial=0.0) + reference, value[1])
        self._mass_flux.x.array[:] = mass_flux
        self.pressure.x.array[:] = pressures(mass_flux)[self._column]
        self.streamfunction.x.array[:] = mass_flux * self._section
        self.solves += 1

    def is_turbulent(self) -> bool:
        """It is not."""
        return False

    def extrapolate(self, previous, factor):
        """Nothing is iterated."""

    def renew(self, time, tolerance):
        """Follow a changed temperature."""
        self.solve(time)

    def factors(self):
        """Nothing is factorised."""

    def recall_factors(self, array_of, constants):
        """Nothing was factorised."""

    def fields(self):
        """Present velocity and pressure (SI) as functions by name (collective)."""
        vectors = fem.Function(fenicsx.lagrange_space(self.domain.mesh, 1, 2), name="velocity")
        vectors.interpolate(fenicsx.compiled_expression(self.state.velocity, vectors.function_space))
        pressure = fem.Function(self.pressure.function_space, name="pressure")
        pressure.x.array[:] = self.pressure.x.array
        return {"velocity": vectors, "pressure": pressure}
