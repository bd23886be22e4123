"""A scene made discrete and marched in time: the only place that knows scene, equations and solvers alike."""

import contextlib
import time as clock
from dataclasses import dataclass, field, replace

import numpy as np
import ufl
from dolfinx import fem

from . import fenicsx, geometry
from .closures.drag import DRAG_LAWS
from .closures.nusselt import NUSSELT_CORRELATIONS
from .equations.coordinates import Coordinates
from .equations.energy import EnergyEquations, OuterWall
from .equations.flow import FlowEquations, FlowScales, FlowState, Opening
from .equations.medium import Bed, FluidState, rev_vector
from .equations.turbulence import TurbulenceModel, TwoLayerState
from .errors import InputError, SolveError
from .estimates import estimate
from .heating_time import crossing_time
from .materials import FLUIDS, SOLIDS, ConstantDensity, constant
from .porosity.models import POROSITY_MODELS
from .porosity.profile import PorosityProfile
from .probe import PointProbe
from .solvers.flow import SteadyFlow
from .solvers.heating import HeatBalance, TransientHeat
from .solvers.time_control import TimeControl

QUADRATURE_DEGREE = 2
STATION_FRACTIONS = {"L/8": 0.125, "L/4": 0.25, "L/2": 0.5, "L": 1.0}
TURBULENCE_MODELS = {
    "none": None,
    "k-epsilon": TurbulenceModel(),
    "nakayama-kuwahara": TurbulenceModel(bead_sources=True),
    "damped-nakayama-kuwahara": TurbulenceModel(bead_sources=True, damped=True),
}
MOST_SNAPSHOTS = 16
AXIAL_GRADING = 1.5
"""Axial nodes at L (i/n)^1.5: the thermal front that starts sharp at the inlet meets small cells, and widens as they do."""


def fluid_of(scene):
    """The scene's fluid: its material, with constant properties in place of those given."""
    fluid, given = FLUIDS[scene.fluid.material], scene.fluid
    changes = {
        name: constant(value, "", "scene")
        for name in ("viscosity", "heat_capacity", "conductivity")
        if (value := getattr(given, name)) is not None
    }
    if given.density is not None:
        changes |= {"density": ConstantDensity(given.density, "scene"), "name": "liquid"}
    return replace(fluid, **changes)


def solid_of(material, density, heat_capacity, conductivity):
    """A material of the library with constant properties in place of those given."""
    given = {"density": density, "heat_capacity": heat_capacity, "conductivity": conductivity}
    changes = {name: constant(value, "", "scene") for name, value in given.items() if value is not None}
    return replace(SOLIDS[material], **changes)


@dataclass
class History:
    """What is recorded at every step: columns by name, each a list; `units` by the same names."""

    columns: dict[str, list[float]] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)

    def add(self, **values_and_units):
        """Append one row: name=(value, unit)."""
        for name, (value, unit) in values_and_units.items():
            self.columns.setdefault(name, []).append(float(value))
            self.units[name] = unit

    def __getitem__(self, name):
        return self.columns[name]


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


class Simulation:
    """Discrete problem of a scene on a communicator. `march()` heats it; `history`, `heating_time` and the rest tell how.

    Raises `InputError` for what only shows when the parts meet (a profile's file, a mesh's groups).
    """

    def __init__(self, scene, communicator):
        self.scene, self.communicator = scene, communicator
        self.stopwatch = Stopwatch()
        self.warnings: list[str] = []
        self.fluid = fluid_of(scene)
        bed, wall = scene.bed, scene.wall
        self.beads = solid_of(bed.bead_material, bed.bead_density, bed.bead_heat_capacity, bed.bead_conductivity)
        self.wall_material = solid_of(wall.material, wall.density, wall.heat_capacity, wall.conductivity)
        self.drag, self.nusselt = DRAG_LAWS[scene.model.drag], NUSSELT_CORRELATIONS[scene.model.nusselt]
        self.profile = None
        if bed.porosity_profile is not None:
            self.profile = PorosityProfile.read("bed.porosity_profile", bed.porosity_profile)
        elif scene.model.rev_terms != "off":
            raise InputError(
                "model.rev_terms", scene.model.rev_terms, "needs bed.porosity_profile: the models give no phi_A",
                scene.source,
            )  # fmt: skip
        bulk = bed.bulk_porosity if self.profile is None else self.profile.bulk_porosity
        self.estimates = estimate(
            scene, self.fluid, self.beads, self.wall_material, self.drag, self.nusselt, bulk
        )
        with self.stopwatch("mesh"):
            self.domain = self._make_domain()
        self._make_equations()
        self.heating_time = self.heating_time_bed_side = None
        self.time = 0.0
        self.history = History()
        self.snapshots: list[tuple[float, np.ndarray, np.ndarray]] = []
        self._snapshot_spacing = 0.0

    # -- the discrete problem ------------------------------------------------------------------------------------

    def _make_domain(self):
        scene, estimates = self.scene, self.estimates
        kind, solver = scene.geometry.kind, scene.solver
        if kind == "mesh":
            return geometry.from_file(
                self.communicator, scene.geometry.mesh, axisymmetric=scene.geometry.symmetry == "axisymmetric"
            )
        width = (scene.geometry.cavity_height if kind == "mold" else scene.geometry.diameter) / 2
        first_cell = solver.first_cell or estimates.first_cell
        return geometry.strip(
            self.communicator,
            length=scene.geometry.length,
            width=width,
            wall_thickness=scene.wall.thickness,
            axial_nodes=scene.geometry.length * np.linspace(0.0, 1.0, solver.axial_cells + 1) ** AXIAL_GRADING,
            bed_nodes=geometry.graded_coordinates(width, first_cell, solver.cell_growth),
            wall_nodes=np.linspace(0.0, scene.wall.thickness, (solver.wall_cells or estimates.wall_cells) + 1),
            axisymmetric=kind == "pipe",
        )

    def _constant(self, value):
        """A number of the scene as UFL constant, so that another value needs no new compilation."""
        return fem.Constant(self.domain.mesh, float(value))

    def _with_constants(self, material):
        """The material with its polynomials' coefficients as UFL constants."""
        return replace(
            material,
            **{
                name: law.with_coefficients(self._constant(c) for c in law.coefficients)
                for name, law in material.laws().items()
                if hasattr(law, "coefficients")
            },
        )

    def _porosity(self, bead_diameter):
        """phi_V and, with REV terms, phi_V - phi_A, over the mesh."""
        bed, distance = self.scene.bed, self.domain.wall_distance
        if self.profile is None:
            model = POROSITY_MODELS[bed.porosity_model]
            return model(distance, bead_diameter, self._constant(bed.bulk_porosity)), None
        space = fenicsx.lagrange_space(self.domain.mesh)
        at_nodes = fem.Function(space)
        at_nodes.interpolate(fenicsx.compiled_expression(distance, space))
        volume, difference = fem.Function(space), fem.Function(space)
        volume_porosity, area_porosity = self.profile(np.maximum(at_nodes.x.array, 0.0), bed.bead_diameter)
        volume.x.array[:] = volume_porosity
        difference.x.array[:] = volume_porosity - area_porosity
        return volume, difference

    def _make_equations(self):
        scene, domain = self.scene, self.domain
        model, operation = scene.model, scene.operation
        coordinates = Coordinates(domain.mesh, domain.axisymmetric)
        dx, ds = domain.cell_measure(QUADRATURE_DEGREE), domain.facet_measure(QUADRATURE_DEGREE)
        bead_diameter = self._constant(scene.bed.bead_diameter)
        porosity, difference = self._porosity(bead_diameter)
        rev = None
        if model.rev_terms != "off":
            largest = self._constant(scene.bed.averaging_diameter_ratio * scene.bed.bead_diameter)
            rev = rev_vector(difference, domain.wall_distance, largest)
        bed = Bed(
            porosity, domain.wall_distance, bead_diameter, self._with_constants(self.beads), self.drag, self.nusselt, rev
        )
        fluid = FluidState(self._with_constants(self.fluid), self._constant(operation.outlet_pressure))
        if isinstance(self.fluid.density, ConstantDensity):
            liquid = ConstantDensity(self._constant(self.fluid.density.value), "scene")
            fluid = replace(fluid, fluid=replace(fluid.fluid, density=liquid))
        estimates = self.estimates
        scales = FlowScales(
            self._constant(estimates.speed), self._constant(estimates.pressure_gradient * domain.length), bead_diameter
        )
        gravity = None
        if operation.gravity != 0.0:
            gravity = ufl.as_vector([self._constant(operation.gravity), 0.0])
        self.equations = FlowEquations(
            bed,
            fluid,
            coordinates,
            scales,
            TURBULENCE_MODELS[model.turbulence],
            gravity,
            published_pressure_term=model.rev_terms == "as-published",
        )
        self._inlet_temperature = self._constant(operation.inlet_temperature(0.0))
        self._drive = self._constant(0.0)
        self.flow_temperature = fem.Function(fenicsx.lagrange_space(domain.mesh))
        self.flow_temperature.x.array[:] = operation.initial_temperature
        self._inlet_area = self._integral(coordinates.weight * self._constant(1.0) * ds(geometry.INLET))
        inlet = Opening(ds(geometry.INLET), **self._inlet_drive(fluid))
        openings = [inlet, Opening(ds(geometry.OUTLET), pressure=self._constant(0.0))]
        self._set_boundary_values(0.0)
        with self.stopwatch("compile"):
            self.flow = SteadyFlow(domain, self.equations, openings, self.flow_temperature, dx)
            self.flow_state = FlowState.of(self.flow.unknown, scales)
            self.energy_equations = EnergyEquations(
                self.equations,
                self.flow_state,
                self.flow_temperature,
                domain.entrance(),
                self._with_constants(self.wall_material) if domain.has_wall else None,
                self._inlet_temperature,
                ds(geometry.INLET),
                ds(geometry.OUTLET),
                self._outer_wall(ds(geometry.OUTER)),
                dx(geometry.BED),
                dx(geometry.WALL),
            )
            self.heat = TransientHeat(
                domain,
                self.energy_equations,
                operation.initial_temperature,
                self._set_boundary_values,
                dx(geometry.WALL),
            )
            outflow = coordinates.weight * self.energy_equations.outward_mass_flux
            self._mass_out = fenicsx.compiled_form(outflow * ds(geometry.OUTLET))
            self._mass_in = fenicsx.compiled_form(-outflow * ds(geometry.INLET))
            temperature = ufl.split(self.heat.unknown)[0]
            self._outlet_heat = fenicsx.compiled_form(outflow * temperature * ds(geometry.OUTLET))
        self._make_probes()

    def _inlet_drive(self, fluid):
        operation = self.scene.operation
        if operation.pressure_drop is not None:
            return {"pressure": self._drive}
        if operation.mass_flow is not None:
            return {"mass_flux": self._drive / self._constant(self._inlet_area)}
        # the pressure just outside is the bed's own: its part of the density is taken at the outlet's pressure
        return {"mass_flux": fluid.density(0.0, self._inlet_temperature) * self._drive}

    def _outer_wall(self, ds):
        operation = self.scene.operation
        flux, coefficient = operation.outer_heat_flux, operation.outer_coefficient
        self._outer_flux = self._ambient = None
        if not self.domain.has_wall or (flux is None and coefficient is None):
            return None
        if flux is not None:
            self._outer_flux = self._constant(flux(0.0))
        if coefficient is None:
            return OuterWall(ds, heat_flux=self._outer_flux)
        self._ambient = self._constant(operation.ambient_temperature(0.0))
        return OuterWall(ds, self._outer_flux, self._constant(coefficient), self._ambient)

    def _set_boundary_values(self, time):
        operation = self.scene.operation
        self._inlet_temperature.value = operation.inlet_temperature(time)
        drive = operation.pressure_drop or operation.inlet_velocity or operation.mass_flow
        self._drive.value = drive(time)
        if getattr(self, "_outer_flux", None) is not None:
            self._outer_flux.value = operation.outer_heat_flux(time)
        if getattr(self, "_ambient", None) is not None:
            self._ambient.value = operation.ambient_temperature(time)

    def _make_probes(self):
        named = {
            f"{place}_{label}": point
            for label, fraction in STATION_FRACTIONS.items()
            for place, point in self.domain.stations(fraction).items()
        }
        self.station_names = list(named)
        self._stations = PointProbe(self.domain, list(named.values()))
        numbers = self.heat.temperature_unknowns
        space = self.flow_temperature.function_space
        dimension = self.domain.mesh.topology.dim
        where = {
            "wall": fem.locate_dofs_topological(space, dimension, self.domain.cells(geometry.WALL)),
            "bed_side": fem.locate_dofs_topological(space, dimension - 1, self.domain.facets(geometry.INTERFACE)),
            "bed": fem.locate_dofs_topological(space, dimension, self.domain.cells(geometry.BED)),
        }
        self._bed_nodes = where["bed"]
        if not self.domain.has_wall:
            where["wall"] = where["bed_side"]
        self._places = {name: numbers[nodes] for name, nodes in where.items()}

    # -- what can be asked of the present state ------------------------------------------------------------------

    def _integral(self, form):
        return self.communicator.allreduce(float(fem.assemble_scalar(fenicsx.compiled_form(form))))

    def _value(self, compiled):
        return self.communicator.allreduce(float(fem.assemble_scalar(compiled)))

    @property
    def temperature(self):
        """Fluid and wall temperature (K) as a function on the mesh, a copy."""
        return self._part(0)

    @property
    def bead_temperature(self):
        """Bead temperature (K) as a function on the mesh, a copy; meaningless in the wall."""
        return self._part(1)

    def _part(self, index):
        function = fem.Function(self.flow_temperature.function_space)
        function.x.array[:] = self.heat.unknown.x.array[fenicsx.collapse(self.heat.space, index)[1]]
        return function

    @property
    def mass_flow(self):
        """Mass flow out of the outlet, kg/s (per metre width and half cavity for a mold)."""
        return self._value(self._mass_out)

    @property
    def mass_imbalance(self):
        """(in - out)/out of the mass flow."""
        out = self.mass_flow
        return (self._value(self._mass_in) - out) / out if out else 0.0

    def extremes(self, place):
        """Smallest and largest temperature (K) at 'wall', 'bed_side' or 'bed'."""
        values = self.heat.unknown.x.array[self._places[place]]
        return (
            self.communicator.allreduce(float(np.min(values, initial=np.inf)), op=min),
            self.communicator.allreduce(float(np.max(values, initial=-np.inf)), op=max),
        )

    def _deficit(self, place):
        """Largest distance (K) of the place's temperatures from the inlet's, on the side they started from."""
        low, high = self.extremes(place)
        inlet = self.scene.operation.inlet_temperature
        target = inlet(self.time)
        return target - low if inlet.values[-1] >= self.scene.operation.initial_temperature else high - target

    def property_laws(self):
        """All property laws in use: (owner, name of the property, law)."""
        owners = [self.fluid, self.beads] + ([self.wall_material] if self.domain.has_wall else [])
        return [(owner.name, name, law) for owner in owners for name, law in owner.laws().items()]

    def sources(self):
        """Where the closures and properties of this run come from, by what they are used for."""
        bed = self.scene.bed
        porosity = POROSITY_MODELS[bed.porosity_model].source if self.profile is None else str(bed.porosity_profile)
        sources = {"drag": self.drag.source, "nusselt": self.nusselt.source, "porosity": porosity}
        return sources | {f"{owner} {name}": law.source for owner, name, law in self.property_laws()}

    def flow_fields(self):
        """Present flow fields as functions with units, by name (collective)."""
        scales = self.estimates
        pressure = scales.pressure_gradient * self.domain.length
        factors = {"velocity": scales.speed, "pressure": pressure}
        if self.equations.model is not None:
            factors["turbulent_kinetic_energy"] = scales.speed**2
            factors["dissipation_rate"] = scales.speed**3 / self.scene.bed.bead_diameter
        fields = {}
        for index, (name, factor) in enumerate(factors.items()):
            space, numbers = fenicsx.collapse(self.flow.space, index)
            fields[name] = fem.Function(space, name=name)
            fields[name].x.array[:] = factor * self.flow.unknown.x.array[numbers]
        return fields

    def highest_mach_number(self):
        """Largest nodal |u|/c with the speed of sound of an ideal gas; 0 for a liquid (collective)."""
        density = self.fluid.density
        if not density.compressible:
            return 0.0
        velocity = self.flow_fields()["velocity"].x.array
        fastest = self.communicator.allreduce(
            float(np.max(np.hypot(velocity[0::2], velocity[1::2]), initial=0.0)), op=max
        )
        temperature = self.scene.operation.inlet_temperature(self.time)
        heat_capacity = self.fluid.heat_capacity(temperature)
        ratio = heat_capacity / (heat_capacity - density.gas_constant)
        return fastest / np.sqrt(ratio * density.gas_constant * temperature)

    def profile_near_wall(self, fraction=0.5, points=120):
        """Columns and units of porosity and flow against wall distance on the line from wall to centre at a fraction
        of the length (collective); None where the domain has no centre line."""
        stations = self.domain.stations(fraction)
        if "centre" not in stations:
            return None
        wall, centre = np.array(stations["bed_side"]), np.array(stations["centre"])
        distance = np.linalg.norm(centre - wall) * np.concatenate([[0.0], np.geomspace(2e-4, 1.0, points - 1)])
        line = wall + np.outer(distance / distance[-1], centre - wall)
        probe = PointProbe(self.domain, line)
        values = {name: probe(function) for name, function in self.flow_fields().items()}
        temperature, beads = (probe(function)[:, 0] for function in (self.temperature, self.bead_temperature))
        if self.profile is None:
            bed = self.scene.bed
            porosity = POROSITY_MODELS[bed.porosity_model](distance, bed.bead_diameter, bed.bulk_porosity)
        else:
            porosity = self.profile(distance, self.scene.bed.bead_diameter)[0]
        columns = {
            "wall_distance": distance,
            "porosity": porosity + np.zeros_like(distance),
            "speed": np.linalg.norm(values["velocity"], axis=1),
            "fluid_temperature": temperature,
            "bead_temperature": beads,
        }
        units = {"wall_distance": "m", "porosity": "1", "speed": "m/s", "fluid_temperature": "K", "bead_temperature": "K"}
        if self.equations.model is not None:
            absolute = values["pressure"][:, 0] + self.scene.operation.outlet_pressure
            viscosity = self.fluid.viscosity(temperature)
            layers = TwoLayerState(
                values["turbulent_kinetic_energy"][:, 0],
                values["dissipation_rate"][:, 0],
                self.fluid.density(absolute, temperature),
                viscosity,
                np.maximum(distance, 1e-12),
                self.estimates.speed**2,
            )
            columns["turbulent_kinetic_energy"] = values["turbulent_kinetic_energy"][:, 0]
            columns["eddy_viscosity_ratio"] = layers.eddy_viscosity / viscosity
            units |= {"turbulent_kinetic_energy": "m2/s2", "eddy_viscosity_ratio": "1"}
        return {name: list(map(float, column)) for name, column in columns.items()}, units

    def field_snapshots(self):
        """(time, functions) at `output.field_times` times spread geometrically up to the end (collective)."""
        wanted = self.time * 0.5 ** np.arange(self.scene.output.field_times - 1, -1, -1)
        times = np.array([snapshot[0] for snapshot in self.snapshots])
        space = self.flow_temperature.function_space
        in_bed = fem.Function(space, name="in_bed")
        in_bed.x.array[self._bed_nodes] = 1.0
        now = self.heat.unknown.x.array.copy(), self.flow.unknown.x.array.copy()
        for index in sorted({int(np.argmin(np.abs(times - time))) for time in wanted}):
            time, self.heat.unknown.x.array[:], self.flow.unknown.x.array[:] = self.snapshots[index]
            temperature, beads = self.temperature, self.bead_temperature
            temperature.name, beads.name = "temperature", "bead_temperature"
            yield time, [in_bed, temperature, beads, *self.flow_fields().values()]
        self.heat.unknown.x.array[:], self.flow.unknown.x.array[:] = now

    # -- marching ------------------------------------------------------------------------------------------------

    def march(self, progress=lambda time, deficit: None):
        """Heat until the whole wall is within the margin or the end time is reached.

        `progress(time, deficit)` is called after every step. Raises `SolveError` when a solve fails for good; history,
        snapshots and balance then stand at the last good step.
        """
        scene, operation = self.scene, self.scene.operation
        series = [s for s in vars(operation).values() if hasattr(s, "kinks")]
        control = self.control = TimeControl(
            scene.solver.first_step,
            scene.solver.step_growth,
            scene.solver.largest_step or min(self.estimates.largest_step, operation.end_time),
            scene.solver.step_tolerance,
            operation.end_time,
            tuple(sorted({kink for s in series for kink in s.kinks if kink > 0.0})),
        )
        with self.stopwatch("flow"):
            self.flow.guess_uniform((1.0, 0.0))
            self.flow.solve()
        self._record(0.0)
        self._keep_snapshot()
        previous, last_step = None, None
        while self.time < operation.end_time * (1 - 1e-12) and self.heating_time is None:
            step = control.propose(self.time)
            old_balance = replace(self.heat.balance)
            start = self.heat.unknown.x.array.copy()
            flow_start = self.flow.unknown.x.array.copy()
            try:
                if scene.model.flow_update == "quasi-steady":
                    with self.stopwatch("flow"):
                        self._renew_flow(previous, last_step, step)
                with self.stopwatch("energy"):
                    error = self.heat.step(self.time, step)
            except SolveError as failure:
                self._restore(start, flow_start, old_balance)
                control.reject_failed(self.time, step, failure)
                continue
            if not control.accept(self.time + step, step, error):
                self._restore(start, flow_start, old_balance)
                continue
            previous, last_step = start, step
            self.time += step
            self._record(step)
            self._keep_snapshot()
            progress(self.time, self.history["deficit_wall"][-1])
        return self

    def _restore(self, start, flow_start, balance):
        self.heat.unknown.x.array[:] = start
        self.flow.unknown.x.array[:] = flow_start
        self.heat.balance = HeatBalance(**vars(balance))

    def _renew_flow(self, previous, last_step, step):
        """The flow at the temperature extrapolated to the step's middle, where its coefficients belong (second order)."""
        now = self.heat.unknown.x.array[self.heat.temperature_unknowns]
        ahead = now.copy()
        if previous is not None:
            ahead += 0.5 * step / last_step * (now - previous[self.heat.temperature_unknowns])
            ends = [self.scene.operation.initial_temperature, *self.scene.operation.inlet_temperature.range]
            np.clip(ahead, min(ends), max(ends), out=ahead)
        self.flow_temperature.x.array[:] = ahead
        self._set_boundary_values(self.time + 0.5 * step)
        self.flow.renew(self.time, self.scene.solver.flow_tolerance)

    def _record(self, step):
        operation, balance = self.scene.operation, self.heat.balance
        mass_flow = self.mass_flow
        outlet = self._value(self._outlet_heat) / mass_flow if mass_flow else float("nan")
        rows = {
            "time": (self.time, "s"),
            "step": (step, "s"),
            "inlet_temperature": (operation.inlet_temperature(self.time), "K"),
            "outlet_temperature": (outlet, "K"),
            "deficit_wall": (self._deficit("wall"), "K"),
            "deficit_bed_side": (self._deficit("bed_side"), "K"),
            "mass_flow": (mass_flow, "kg/s"),
            "heat_by_fluid": (balance.by_fluid, "J"),
            "heat_through_outer_wall": (balance.through_outer_wall, "J"),
            "heat_stored": (balance.stored, "J"),
            "heat_by_rev_terms": (balance.by_rev_terms, "J"),
        }
        bed, wall = self.extremes("bed"), self.extremes("wall")
        rows |= {"lowest_temperature": (min(bed[0], wall[0]), "K"), "highest_temperature": (max(bed[1], wall[1]), "K")}
        stations = self._stations(self.temperature)[:, 0]
        rows |= {f"temperature_{name}": (v, "K") for name, v in zip(self.station_names, stations, strict=True)}
        self.history.add(**rows)
        margin, times = operation.heating_margin, self.history["time"]
        self.heating_time = self.heating_time or crossing_time(times, self.history["deficit_wall"], margin)
        self.heating_time_bed_side = self.heating_time_bed_side or crossing_time(
            times, self.history["deficit_bed_side"], margin
        )

    def _keep_snapshot(self):
        """Keep the fields of this time; beyond `MOST_SNAPSHOTS` every second goes and the spacing doubles."""
        finished = self.heating_time is not None or self.time >= self.scene.operation.end_time
        if self.snapshots and not finished and self.time < self.snapshots[-1][0] + self._snapshot_spacing:
            return
        self.snapshots.append((self.time, self.heat.unknown.x.array.copy(), self.flow.unknown.x.array.copy()))
        if len(self.snapshots) > MOST_SNAPSHOTS and not finished:
            self.snapshots = self.snapshots[::2]
            self._snapshot_spacing = max(2.0 * self._snapshot_spacing, self.time / MOST_SNAPSHOTS)
