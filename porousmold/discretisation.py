"""A scene made discrete: mesh, equations, solvers, boundary values and the questions one can ask of the present state.

The only place that knows scene, closures, equations and solvers alike; `simulation` marches what stands here.
"""

import contextlib
import functools
import time as clock
from dataclasses import replace
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from . import fenicsx, geometry
from .boundary_values import BoundaryValues
from .closures import bead_interior
from .closures.turbulence import DAMPING_START
from .equations.bead_interior import BeadInterior
from .equations.coordinates import Coordinates
from .equations.developed import CarriedByStreamfunction
from .equations.energy import EnergyEquations, ThinWall
from .equations.flow import FlowEquations, FlowScales, Opening
from .equations.medium import Bed, FluidState, rev_vector
from .errors import InputError, SolveError
from .estimates import bed_size, estimate
from .laws import Laws
from .materials import ConstantDensity
from .meshing import straight_domain
from .porosity.models import POROSITY_MODELS
from .probe import PointProbe
from .sensors import read_sensors
from .solvers.coupled import CoupledTransient
from .solvers.developed import DevelopedFlow, PlugFlow
from .solvers.equilibrium import local_equilibrium
from .solvers.flow import SteadyFlow, silent
from .solvers.heating import TransientHeat

QUADRATURE_DEGREE = 2
STATION_FRACTIONS = {"L/8": 0.125, "L/4": 0.25, "L/2": 0.5, "L": 1.0}


class Stopwatch:
    """Wall seconds by purpose."""

    def __init__(self):
        self.seconds = dict.fromkeys(("compile", "mesh", "flow", "energy", "output"), 0.0)

    @contextlib.contextmanager
    def __call__(self, purpose):
        start = clock.perf_counter()
        try:
            yield
        finally:
            self.seconds[purpose] += clock.perf_counter() - start


class Discretisation:
    """The discrete problem of a scene on a communicator: `domain`, `equations`, `flow`, `heat` and what they were made of.

    Raises `InputError` for a mesh that cannot be used.
    """

    def __init__(self, scene, communicator, observe=silent):
        self.scene, self.communicator, self._observe = scene, communicator, observe
        self.stopwatch = Stopwatch()
        self.laws = laws = Laws.of(scene)
        with self.stopwatch("mesh"):
            if scene.geometry.kind == "mesh":
                axisymmetric = scene.geometry.symmetry == "axisymmetric"
                self.domain = geometry.from_file(communicator, scene.geometry.mesh, axisymmetric=axisymmetric)
                area = self._inlet_area
                self.estimates = estimate(scene, (self.domain.length, area, area), laws)
            else:
                self.estimates = estimate(scene, bed_size(scene), laws)
                self.domain = straight_domain(scene, self.estimates, communicator, observe)
        observe("compiling")
        self._make_equations()
        self._make_probes()

    @functools.cached_property
    def _inlet_area(self):
        weight = Coordinates(self.domain.mesh, self.domain.axisymmetric).weight
        ds = self.domain.facet_measure(QUADRATURE_DEGREE)
        return self._integral(weight * self.domain.constant(1.0) * ds(geometry.INLET))

    def _with_constants(self, material):
        """The material with its polynomials' coefficients as UFL constants."""
        return replace(
            material,
            **{
                name: law.with_coefficients(self.domain.constant(c) for c in law.coefficients)
                for name, law in material.laws().items()
                if hasattr(law, "coefficients")
            },
        )

    def _turbulence_model(self):
        """The laws' with its numbers as UFL constants; None without turbulence."""
        model = self.laws.turbulence
        if model is None:
            return None
        numbers = {name: getattr(model, name) for name in ("blend_half_width", "longest_eddy")}
        return replace(model, **{name: self.domain.constant(value) for name, value in numbers.items()})

    def _porosity(self, bead_diameter):
        """phi_V and, with REV terms, phi_V - phi_A, over the mesh."""
        bed, distance = self.scene.bed, self.domain.wall_distance
        profile = self.scene.profile
        if profile is None:
            model = POROSITY_MODELS[bed.porosity_model]
            return model(distance, bead_diameter, self.domain.constant(bed.bulk_porosity)), None
        space = fenicsx.lagrange_space(self.domain.mesh)
        at_nodes = np.maximum(fenicsx.nodal_values(distance, space), 0.0)
        volume, difference = fem.Function(space), fem.Function(space)
        volume_porosity, area_porosity = profile(at_nodes, bed.bead_diameter)
        volume.x.array[:] = volume_porosity
        difference.x.array[:] = volume_porosity - area_porosity
        return volume, difference

    def _make_equations(self):
        scene, domain = self.scene, self.domain
        model, operation = scene.model, scene.operation
        coordinates = Coordinates(domain.mesh, domain.axisymmetric)
        dx, ds = domain.cell_measure(QUADRATURE_DEGREE), domain.facet_measure(QUADRATURE_DEGREE)
        nodal_dx = domain.nodal_measure()
        bead_diameter = self.domain.constant(scene.bed.bead_diameter)
        porosity, difference = self._porosity(bead_diameter)
        rev = None
        if model.rev_terms != "off":
            largest = self.domain.constant(scene.bed.averaging_diameter_ratio * scene.bed.bead_diameter)
            rev = rev_vector(difference, domain.wall_distance, largest)
        bed = Bed(
            porosity,
            domain.wall_distance,
            bead_diameter,
            self._with_constants(self.laws.beads),
            self.laws.drag,
            self.laws.nusselt,
            rev,
        )
        fluid = FluidState(self._with_constants(self.laws.fluid), self.domain.constant(operation.outlet_pressure))
        if isinstance(self.laws.fluid.density, ConstantDensity):
            liquid = ConstantDensity(self.domain.constant(self.laws.fluid.density.value), "scene")
            fluid = replace(fluid, fluid=replace(fluid.fluid, density=liquid))
        estimates = self.estimates
        scales = FlowScales(
            self.domain.constant(estimates.speed),
            self.domain.constant(estimates.pressure_gradient * domain.length),
            bead_diameter,
        )
        gravity = None
        if operation.gravity != 0.0:
            others = [0.0] * (domain.mesh.geometry.dim - 1)
            gravity = ufl.as_vector([self.domain.constant(operation.gravity), *others])
        self.equations = FlowEquations(
            bed,
            fluid,
            coordinates,
            scales,
            self._turbulence_model(),
            gravity,
            published_pressure_term=model.rev_terms == "as-published",
        )
        self.boundary = BoundaryValues(scene, domain, self._inlet_area)
        self.flow_temperature = fem.Function(fenicsx.lagrange_space(domain.mesh))
        self.property_temperature = fem.Function(self.flow_temperature.function_space)
        for function in (self.flow_temperature, self.property_temperature):
            function.x.array[:] = operation.initial_temperature
        openings = [
            Opening(ds(geometry.INLET), **self.boundary.drive()),
            Opening(
                ds(geometry.OUTLET),
                pressure=self.domain.constant(0.0),
                mean_square=self.domain.constant(0.0),
            ),
        ]
        with self.stopwatch("compile"):
            self.flow: Any
            self.heat: Any
            carrier: FlowEquations = self.equations
            if model.flow == "full":
                self.flow = SteadyFlow(domain, self.equations, openings, self.flow_temperature, dx)
                self.flow.initial_guess = self._guess_flow
            else:
                self.flow = self._simpler_flow(model.flow)
                carrier = CarriedByStreamfunction(**vars(self.equations), streamfunction=self.flow.streamfunction)
            self.flow_state = self.flow.state
            self.energy_equations = EnergyEquations(
                carrier,
                self.flow_state,
                self.flow_temperature,
                domain.entrance(),
                self._with_constants(self.laws.wall) if self.has_wall else None,
                self.boundary.inlet_temperature,
                ds(geometry.INLET),
                ds(geometry.OUTLET),
                self.boundary.make_outer_wall(ds(geometry.OUTER if domain.has_outer_wall else geometry.INTERFACE)),
                dx(geometry.BED),
                nodal_dx(geometry.BED),
                dx(geometry.WALL),
                nodal_dx(geometry.WALL),
                self._thin_wall(ds(geometry.INTERFACE)),
                self.two_temperatures,
                self.domain.constant(model.exchange_factor),
                domain.straight,
                openings[0] if model.flow == "full" else None,
                self._bead_interior(bed),
            )
            self.heat = TransientHeat(
                domain,
                self.energy_equations,
                operation.initial_temperature,
                self.boundary.set_heat,
                dx(geometry.WALL),
                self.property_temperature,
                QUADRATURE_DEGREE,
            )
            if model.flow_update == "transient":
                self.heat = CoupledTransient(
                    domain,
                    self.flow,
                    self.heat,
                    lambda state, warm: replace(self.energy_equations, flow_state=state, flow_temperature=warm),
                    self.flow_temperature,
                    self.boundary.set,
                    estimates.mass_flux * 1e3,
                )
            outflow = coordinates.weight * self.energy_equations.outward_mass_flux
            self._mass_out = fenicsx.compiled_form(outflow * ds(geometry.OUTLET))
            inflow = coordinates.weight * self.energy_equations.inward_mass_flux
            self._mass_in = fenicsx.compiled_form(inflow * ds(geometry.INLET))
            self._inlet_pressure = fenicsx.compiled_form(
                coordinates.weight
                * self.flow_state.pressure
                / self.domain.constant(self._inlet_area)
                * ds(geometry.INLET)
            )
            temperature = ufl.split(self.heat.unknown)[0] if self.two_temperatures else self.heat.unknown
            self.outlet_heat = fenicsx.compiled_form(outflow * temperature * ds(geometry.OUTLET))

    def _guess_flow(self) -> bool:
        """Initial guess of the full flow: the developed profiles where the bed is straight, in three dimensions the flow over
        two of them at the same distance from the wall."""
        self.flow.guess_uniform()
        with contextlib.suppress(SolveError):  # then the uniform one has to do
            if self.domain.columns is not None:
                self._developed_flow.observe = self._observe
                self._developed_flow.start()
                self.flow.guess(self._developed_flow.fields())
                return True
            if self.domain.straight:
                self.flow.guess(self._flow_in_the_plane())
                return True
        if not self.domain.straight:
            self.flow.guess(self._local_equilibrium())
        return self.laws.turbulence is None

    def _local_equilibrium(self):
        """Fields of the local equilibrium of drag and beads along x[0], for a mesh whose stations are not known."""
        space = self.flow_temperature.function_space
        along = space.tabulate_dof_coordinates()[:, 0] / self.domain.length
        drive, estimates = self.boundary.drive_of_stations(), self.estimates
        pressure_drop = drive[1] if drive[0] == "pressure_drop" else estimates.pressure_gradient * self.domain.length
        pressure = pressure_drop * np.clip(1.0 - along, 0.0, 1.0)
        gradient = max(pressure_drop / self.domain.length, 1e-6 * estimates.pressure_gradient)
        temperature = self.flow_temperature.x.array
        arrays = local_equilibrium(self.equations, self.laws.fluid, space, gradient, temperature, pressure)

        def function_of(values):
            function = fem.Function(space)
            function.x.array[:] = values
            return function

        speed, *turbulence = map(function_of, arrays)
        velocity = fem.Function(fenicsx.lagrange_space(self.domain.mesh, 1, self.domain.mesh.geometry.dim))
        velocity.sub(0).interpolate(speed)
        names = ("turbulent_kinetic_energy", "dissipation_rate")
        fields = {"velocity": velocity, "pressure": function_of(pressure)}
        return fields | dict(zip(names, turbulence, strict=False))

    @functools.cached_property
    def _developed_flow(self):
        return self._simpler_flow("developed")

    def is_also_laminar(self) -> bool:
        """Whether beside the present turbulent flow there is a laminar one: sought where no bead source acts (collective).

        Of the developed flow, where the bed is straight.
        """
        if not self.flow.is_turbulent() or self._bead_sources_act():
            return False
        flow = self.flow if self.scene.model.flow != "full" or self.domain.columns is None else self._developed_flow
        return flow.is_also_laminar()

    def _bead_sources_act(self) -> bool:
        model = self.laws.turbulence
        if not (model.bead_sources and model.damped):
            return model.bead_sources
        m = self.equations.momentum(self.flow_state, self.flow_temperature)
        reynolds = self.equations.bed.reynolds_number(m.density, m.speed, m.viscosity)
        highest = np.nanmax(fenicsx.nodal_values(reynolds, self.flow_temperature.function_space), initial=0.0)
        return self.communicator.allreduce(float(highest), op=max) > DAMPING_START

    def observe_solvers(self, observe):
        """Have `observe(text)` called at every iteration of flow and heat; it may raise."""
        self._observe = self.flow.observe = self.heat.observe = observe

    def _flow_in_the_plane(self):
        """Fields of the same scene in two dimensions, on this three-dimensional mesh by distance along and to the wall."""
        operation = self.scene.operation
        narrower = {"geometry__width": None, "geometry__sides": None}
        if operation.mass_flow is not None:
            _, half_height, area = bed_size(self.scene)
            narrower["operation__mass_flow"] = operation.mass_flow(0.0) * half_height / area
        plane = Discretisation(self.scene.with_changes(**narrower), MPI.COMM_SELF)
        plane.flow.start()
        space = self.flow_temperature.function_space
        nodes = space.tabulate_dof_coordinates()
        distance = np.maximum(fenicsx.nodal_values(self.domain.wall_distance, space), 0.0)
        half_height = self.domain.stations(0.0)["bed_side"][1]
        probe = PointProbe(plane.domain, np.column_stack([nodes[:, 0], half_height - distance]))
        spread = {}
        for name, values in ((name, probe(function)) for name, function in plane.flow.fields().items()):
            components = self.domain.mesh.geometry.dim if name == "velocity" else 1
            spread[name] = fem.Function(fenicsx.lagrange_space(self.domain.mesh, 1, components))
            spread[name].x.array[::components] = values[:, 0]
        return spread

    def _simpler_flow(self, kind):
        scene, laws = self.scene, self.laws
        given = (
            self.domain,
            self.equations,
            self.flow_temperature,
            self.boundary.drive_of_stations,
            bed_size(scene)[2],
        )
        if kind == "developed":
            return DevelopedFlow(*given, laws.fluid)

        def resistance(mass_flux, density, viscosity):
            speed = mass_flux / (laws.bulk_porosity * density)
            coefficient = laws.drag.coefficient(laws.bulk_porosity, scene.bed.bead_diameter, density, viscosity, speed)
            return coefficient * speed / laws.bulk_porosity - density * scene.operation.gravity

        return PlugFlow(*given, laws.fluid, resistance)

    @property
    def has_wall(self):
        """Whether there is a wall that stores heat, resolved or thin."""
        return self.domain.has_wall or self.scene.model.wall == "thin"

    @property
    def two_temperatures(self):
        """Whether fluid and beads have a temperature each."""
        return self.scene.model.energy == "two-temperature"

    def _thin_wall(self, ds):
        if self.scene.model.wall != "thin":
            return None
        thickness, curved = self.scene.wall.thickness, self.scene.geometry.kind == "pipe"
        ratio = thickness / bed_size(self.scene)[1] if curved else 0.0
        return ThinWall(ds, self.domain.constant(thickness * (1.0 + 0.5 * ratio)), self.domain.constant(1.0 + ratio))

    def _bead_interior(self, bed):
        modes = self.scene.model.bead_modes
        if modes is None:
            return None
        lag = fem.Function(self.flow_temperature.function_space)
        eigenvalues = tuple(bead_interior.eigenvalues(modes))
        return BeadInterior(eigenvalues, bed.beads, bed.bead_diameter, lag, self.domain.constant(1.0))

    def _make_probes(self):
        named = {
            f"{place}_{label}": point
            for label, fraction in STATION_FRACTIONS.items()
            for place, point in self.domain.stations(fraction).items()
        }
        self.station_names = list(named)
        self.stations = PointProbe(self.domain, list(named.values()))
        self.sensor_names, places = read_sensors(self.scene.geometry.sensors, self.domain.mesh.geometry.dim)
        try:
            self.sensors = PointProbe(self.domain, places)
        except ValueError as error:
            raise InputError("geometry.sensors", str(self.scene.geometry.sensors), str(error)) from error
        space = self.heat.space.sub(0) if self.two_temperatures else self.heat.space
        dimension = self.domain.mesh.topology.dim
        where = {
            "wall": fem.locate_dofs_topological(space, dimension, self.domain.cells(geometry.WALL)),
            "bed_side": fem.locate_dofs_topological(space, dimension - 1, self.domain.facets(geometry.INTERFACE)),
            "bed": fem.locate_dofs_topological(space, dimension, self.domain.cells(geometry.BED)),
        }
        self._places = where
        if not self.domain.has_wall:
            where["wall"] = where["bed_side"]

    # -- what can be asked of the present state ---------------------------------------------------------------------

    def _integral(self, form):
        return self.value(fenicsx.compiled_form(form))

    def value(self, compiled):
        """Value of a compiled scalar form, the sum over all ranks."""
        return self.communicator.allreduce(float(fem.assemble_scalar(compiled)))

    @property
    def temperature(self):
        """Fluid and wall temperature (K) as a function on the mesh, a copy."""
        return self.part_of_heat(self.heat.unknown, 0)

    @property
    def bead_temperature(self):
        """Bead temperature (K) as a function on the mesh, a copy; meaningless in the wall."""
        return self.part_of_heat(self.heat.unknown, 1)

    def part_of_heat(self, unknown, part):
        """T (part 0) or T_s (part 1) of a function of the energy's space, as a function on the mesh.

        By interpolation: across ranks the spaces number their nodes differently.
        """
        function = fem.Function(self.flow_temperature.function_space)
        function.interpolate(unknown.sub(part) if self.two_temperatures else unknown)
        function.x.scatter_forward()
        return function

    @property
    def mass_flow(self):
        """Mass flow out of the outlet, kg/s, of what is computed (per metre width where that has no width)."""
        return self.value(self._mass_out)

    @property
    def pressure_drop(self):
        """Mean pressure over the inlet above that at the outlet, Pa."""
        return self.value(self._inlet_pressure)

    @property
    def mass_imbalance(self):
        """(in - out)/out of the mass flow."""
        out = self.mass_flow
        return (self.value(self._mass_in) - out) / out if out else 0.0

    @property
    def unknowns(self):
        """Numbers of unknowns solved for."""
        return {"flow": self.flow.unknowns, "energy": self.heat.unknowns}

    @property
    def functions(self):
        """What temperatures and flow are kept in."""
        return [*self.heat.functions, *self.flow.functions]

    @property
    def memory(self):
        """`functions`, and what else the next step depends on."""
        return [*self.functions, self.flow_temperature, self.property_temperature, self.heat.monotone_steps]

    def state(self):
        """Copies of the arrays of `functions`."""
        return [function.x.array.copy() for function in self.functions]

    def set_state(self, arrays):
        """Go back to what `state()` gave."""
        for function, array in zip(self.functions, arrays, strict=True):
            function.x.array[:] = array

    def extremes(self, place):
        """Smallest and largest temperature (K) at 'wall', 'bed_side' or 'bed'."""
        values = self.heat.unknown.x.array[self._places[place]]
        return (
            self.communicator.allreduce(float(np.min(values, initial=np.inf)), op=min),
            self.communicator.allreduce(float(np.max(values, initial=-np.inf)), op=max),
        )

    def highest_mach_number(self):
        """Largest nodal |u|/c with the speed of sound of an ideal gas; 0 for a liquid (collective)."""
        fluid = self.laws.fluid
        density = fluid.density
        if not density.compressible:
            return 0.0
        velocity = self.flow.fields()["velocity"].x.array.reshape(-1, self.domain.mesh.geometry.dim)
        fastest = self.communicator.allreduce(float(np.max(np.linalg.norm(velocity, axis=1), initial=0.0)), op=max)
        temperature = float(self.boundary.inlet_temperature.value)
        heat_capacity = fluid.heat_capacity(temperature)
        ratio = heat_capacity / (heat_capacity - density.gas_constant)
        return fastest / np.sqrt(ratio * density.gas_constant * temperature)
