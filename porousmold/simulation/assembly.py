"""From the parts of a scene to equations and solvers on a mesh.

`assemble` makes a `Problem` of `Specs`: the mesh, what fills it (`build_medium`), its flow (`build_flow`), its temperatures
(`build_heat`) and the forms that balance them (`build_balances`). Numbers of a scene become UFL constants, so that another
value needs no compilation.
"""

import math
from dataclasses import replace
from functools import partial
from typing import Any, cast

import numpy as np
import ufl
from dolfinx import fem

from ..equations.bead_interior import BeadInterior
from ..equations.coordinates import Coordinates
from ..equations.developed import CarriedByStreamfunction
from ..equations.energy import EnergyEquations, Interface
from ..equations.flow import FlowEquations, FlowScales
from ..equations.medium import Bed, FluidState, rev_vector
from ..equations.moving_beads import MovingBeads
from ..equations.openings import Opening
from ..equations.wall import ThinWall, Wall, WallLayer
from ..errors import InputError
from ..laws import bead_interior
from ..laws.functions import Value
from ..laws.materials import Solid
from ..mesh import domain as geometry
from ..mesh import fenicsx, ranks
from ..mesh.aliases import Communicator, Expression
from ..mesh.deferred_forms import DeferredForm, finish_compiling
from ..mesh.domain import Domain
from ..mesh.nodes import leaves
from ..mesh.point_values import nodal_values
from ..scene.features.geometries import BedSize
from ..scene.features.own_mesh import OwnMesh
from ..scene.series import TimeSeries
from ..scene.start import Profile
from ..solvers.coupled import CoupledTransient
from ..solvers.developed import DevelopedFlow
from ..solvers.developed_profiles import STATIONS, ProfilesOfGradient, ProfileTable
from ..solvers.displacement import Displacement
from ..solvers.flow import FullFlow
from ..solvers.heating import ErrorControl, TransientHeat
from ..solvers.locally_developed import LocallyDevelopedFlow
from ..solvers.newton import free_systems
from ..solvers.plug import PlugFlow
from ..solvers.protocols import Flow, Heat, Inflow, Observer, silent
from ..solvers.relaxation import Relaxation
from .air_loop import AirLoop
from .boundary_values import BoundaryValues
from .estimates import Estimates
from .expansion import counts_expansion
from .heat_capacity_peaks import SMOOTH_CHANGE, melts, sharpest_change_of_stores, stage_error
from .initial_guess import InitialGuesses
from .meshing import QUADRATURE_DEGREE, area_of_inlet, build_domain, plane_of_stations
from .problem import Balances, Medium, Problem, starting_temperatures
from .specs import Specs
from .stopwatch import Stopwatch
from .wall_estimates import volumetric_capacity

CHOKED = 2.0
"""Pressure that a gas loses, twice that over the outlet's at the inlet's density, beyond which no flow is sought."""
LEAST_STORAGE = 1e-3
"""Of the beads' heat capacity per volume, below which a layer counts as storing nothing."""


def assemble(specs: Specs, communicator: Communicator, observe: Observer = silent) -> Problem:
    """The discrete problem of a scene on a communicator (collective); `observe(text)` gets the name of each phase.

    Raises `InputError` for a mesh that cannot be used.
    """
    stopwatch = Stopwatch()
    with stopwatch("mesh"):
        domain, size, estimates = build_domain(specs, communicator, observe)
    observe("compiling")
    with stopwatch("compile"):
        medium = build_medium(specs, domain, estimates, size)
        flow = build_flow(specs, medium, observe)
        equations = _energy_equations(specs, medium, flow)
        heat = build_heat(specs, medium, flow, equations)
        balances = build_balances(medium, flow, heat, equations)
        air_loop = _air_loop(specs, medium, heat, equations)
        finish_compiling()
    return Problem(specs, medium, flow, heat, balances, equations, stopwatch, air_loop)


def build_medium(specs: Specs, domain: Domain, estimates: Estimates, size: BedSize) -> Medium:
    """What fills the mesh: bed, fluid, the flow's equations, and the boundary's values."""
    constant, flow, laws = domain.constant, specs.flow, specs.laws
    bead_diameter = constant(specs.mesh.bead_diameter)
    wall_distance = ufl.max_value(
        domain.wall_distance, 0.0
    )  # rounding leaves nodes of the wall beyond it, where phi > 1
    bed = Bed(
        specs.porosity.over(wall_distance, bead_diameter, constant, lambda f: _at_nodes(domain, f)),
        constant(specs.porosity.bulk_porosity),
        wall_distance,
        bead_diameter,
        with_constants(laws.beads, domain),
        _with_constant_factor(laws.drag, domain),
        laws.nusselt,
        _rev_vector(specs, domain),
        _with_constant_factor(laws.bead_conduction, domain),
        _with_constant_factor(laws.dispersion, domain),
        constant(specs.heat.emissivity) if specs.heat.emissivity else 0.0,
        constant(specs.heat.bead_motion.velocity) if specs.heat.bead_motion.velocity else None,
    )
    fluid = FluidState(with_constants(laws.fluid, domain), constant(flow.outlet_pressure))
    scales = FlowScales(constant(estimates.speed), constant(estimates.pressure_gradient * domain.length), bead_diameter)
    gravity = None
    if flow.gravity != 0.0:
        others = [0.0] * (domain.mesh.geometry.dim - 1)
        gravity = ufl.as_vector([constant(flow.gravity), *others])
    model = None if laws.turbulence is None else laws.turbulence.with_parameters(constant)
    inlet_area = area_of_inlet(domain)
    boundary = BoundaryValues(flow, specs.heat, domain, inlet_area)
    space = fenicsx.lagrange_space(domain.mesh)
    of_flow, of_properties = fem.Function(space), fem.Function(space)
    for function in (of_flow, of_properties):
        function.x.array[:] = specs.heat.initial_temperature
        _start(specs, function, domain)
    displacement = None
    if counts_expansion(specs, estimates):
        displacement = Displacement(of_flow, partial(laws.fluid.density, flow.outlet_pressure))
    equations = FlowEquations(
        bed,
        fluid,
        Coordinates(domain.mesh, domain.axisymmetric),
        scales,
        model,
        gravity,
        published_pressure_term=flow.averaging.terms == "as-published",
        expansion=None if displacement is None else bed.porosity * displacement.rate,
    )
    kept = of_flow, of_properties, Relaxation(space), displacement
    return Medium(domain, size, estimates, equations, boundary, inlet_area, *kept)


def _start(specs: Specs, function: fem.Function, domain: Domain) -> None:
    """Give a function of the temperatures, T or T and T_s, the values at the start where these differ from place to place."""
    start, mesh = specs.heat.start, domain.mesh
    if start is None:
        return
    if isinstance(start, Profile):
        start.require_place(domain.length)
    else:
        start.require_kind(axisymmetric=domain.axisymmetric)
        nodes = fenicsx.lagrange_space(mesh)
        of_bed = fem.locate_dofs_topological(nodes, mesh.topology.dim, domain.cells(geometry.BED))
        for require, points in (
            (start.require_place, mesh.geometry.x),
            (start.require_bed, nodes.tabulate_dof_coordinates()[of_bed]),
        ):
            ends = [ranks.extremes(mesh.comm, points[:, axis]) for axis in range(mesh.geometry.dim)]
            require(*np.transpose(ends))
    for part, (space, numbers) in enumerate(leaves(function.function_space)):
        function.x.array[numbers] = starting_temperatures(start, space, domain, of_beads=bool(part))
    function.x.scatter_forward()


def build_flow(specs: Specs, medium: Medium, observe: Observer = silent) -> Flow:
    """The flow that the scene asks for."""
    _require_steady_flow(specs, medium.estimates)
    if specs.flow.model.kind == "plug":
        return _plug_flow(specs, medium)
    if specs.flow.model.kind == "developed":
        if medium.domain.columns is None:
            return locally_developed_flow(specs, medium)
        return developed_flow(specs, medium)
    developed = None if medium.domain.columns is None else developed_flow(specs, medium)
    anywhere = partial(locally_developed_flow, specs, medium)
    guesses = InitialGuesses(specs, medium, developed, _flow_in_the_plane, anywhere, observe)
    return FullFlow(
        medium.domain,
        medium.equations,
        _openings(medium),
        medium.flow_temperature,
        medium.domain.cell_measure(QUADRATURE_DEGREE),
        guesses=guesses,
        simpler=developed,
    )


def _require_steady_flow(specs: Specs, estimates: Estimates) -> None:
    """Raise `InputError` for a gas that would have to enter faster than any pressure drives it: its density at the inlet grows
    with the pressure there, and with the resistance G = c p, (p_out/p_in)^2 = 1 - 2 G L/p has no root beyond 1. The flow at the
    wall leaves some of that resistance out."""
    flow = specs.flow
    missing = 2.0 * estimates.pressure_gradient * estimates.length / flow.outlet_pressure
    if flow.drive == "inlet_velocity" and specs.laws.fluid.density.compressible and missing > CHOKED:
        allowed = (
            f"has no steady flow: a gas that enters so fast would need (p_out/p_in)^2 = {1.0 - missing:.2g}; "
            "make it slower, the bed shorter, or give operation.mass_flow"
        )
        raise InputError("operation.inlet_velocity", flow.driven_by.range[1], allowed, specs.mesh.scene_file)


def _openings(medium: Medium) -> list[Opening]:
    domain, ds = medium.domain, medium.domain.facet_measure(QUADRATURE_DEGREE)
    atmosphere = {"pressure": domain.constant(0.0), "mean_square": domain.constant(0.0)}
    return [
        Opening(ds(geometry.INLET), **medium.boundary.drive()),
        Opening(ds(geometry.OUTLET), **atmosphere),
    ]


def developed_flow(specs: Specs, medium: Medium) -> DevelopedFlow:
    """Developed flow in a straight bed."""
    inflow = Inflow(medium.boundary.present_drive, medium.size.area, specs.laws.fluid)
    return DevelopedFlow(medium.domain, medium.equations, medium.flow_temperature, inflow)


def locally_developed_flow(specs: Specs, medium: Medium) -> LocallyDevelopedFlow:
    """Flow over any mesh, everywhere with the profile of its own pressure gradient."""
    estimates = medium.estimates
    return LocallyDevelopedFlow(
        medium.domain,
        medium.equations,
        medium.flow_temperature,
        Inflow(medium.boundary.present_drive, medium.inlet_area, specs.laws.fluid),
        lambda: profile_table(specs, estimates, medium.domain.depth),
        QUADRATURE_DEGREE,
    )


def profile_table(specs: Specs, estimates: Estimates, half_height: float) -> ProfileTable:
    """Developed profiles over a plane bed with the scene's cells at its wall, on this rank alone."""
    from ..mpi import MPI

    size = BedSize(length=1.0, half_height=half_height)
    mesh = replace(specs.mesh, size=size, own=OwnMesh(), dimension=2, axisymmetric=False)
    model = replace(specs.flow.model, update="frozen")  # nothing expands at stations that have each their own flow
    flow = replace(specs.flow, gravity=0.0, by_blower=False, model=model)
    heat = replace(specs.heat, air_loop=None, start=None, initial_temperature=specs.heat.inlet_temperature.range[1])
    flat = replace(specs, mesh=mesh, flow=flow, heat=heat)
    domain = plane_of_stations(mesh, estimates, MPI.COMM_SELF, STATIONS)
    medium = build_medium(flat, domain, estimates, size)
    inflow = Inflow(medium.boundary.present_drive, half_height, specs.laws.fluid)
    profiles = ProfilesOfGradient(domain, medium.equations, medium.flow_temperature, inflow)
    temperature, fluid = heat.initial_temperature, specs.laws.fluid
    density = float(fluid.density(flow.outlet_pressure, temperature))
    return ProfileTable(profiles, half_height, specs.mesh.bead_diameter, density, float(fluid.viscosity(temperature)))


def _plug_flow(specs: Specs, medium: Medium) -> PlugFlow:
    laws, phi, diameter = specs.laws, specs.porosity.bulk_porosity, specs.mesh.bead_diameter

    def resistance(mass_flux: Value, density: Value, viscosity: Value) -> Value:
        speed = mass_flux / (phi * density)
        relative = speed - specs.heat.bead_motion.velocity
        coefficient = laws.drag.coefficient(phi, diameter, density, viscosity, abs(relative))
        return coefficient * relative / phi - density * specs.flow.gravity

    given = medium.domain, medium.equations, medium.flow_temperature, medium.boundary.present_drive, medium.size.area
    return PlugFlow(*given, laws.fluid, resistance)


def _flow_in_the_plane(specs: Specs) -> tuple[Domain, dict[str, fem.Function]]:
    """The steady flow of a three-dimensional scene in two dimensions, on one rank."""
    from ..mpi import MPI

    size = specs.mesh.size
    assert size is not None
    flat = replace(specs.mesh, size=replace(size, half_width=None, walled_sides=False))
    flow = replace(specs.flow, by_blower=False)
    if flow.drive == "mass_flow":
        share = size.half_height / size.area
        if specs.course is None:
            narrower = tuple(value * share for value in flow.driven_by.values)
            flow = replace(flow, driven_by=replace(flow.driven_by, values=narrower))
        else:
            flow = replace(flow, driven_by=TimeSeries.constant(share * flow.driven_by.range[1]))
    heat = replace(specs.heat, air_loop=None)
    plane = assemble(replace(specs, mesh=flat, flow=flow, heat=heat), MPI.COMM_SELF)
    plane.flow.start()
    fields = plane.flow.fields()
    free_systems(plane.domain.mesh)
    return plane.domain, fields


def _energy_equations(specs: Specs, medium: Medium, flow: Flow) -> EnergyEquations:
    heat, domain = specs.heat, medium.domain
    dx, ds = domain.cell_measure(QUADRATURE_DEGREE), domain.facet_measure(QUADRATURE_DEGREE)
    carrier = medium.equations
    if flow.streamfunction is not None:
        carrier = CarriedByStreamfunction(**vars(carrier), streamfunction=flow.streamfunction, growth=flow.growth)
    elif isinstance(flow, LocallyDevelopedFlow):
        carrier = flow.carrier(carrier)
    return EnergyEquations(
        flow=carrier,
        flow_state=flow.state,
        flow_temperature=medium.flow_temperature,
        entrance=domain.entrance(),
        wall=_wall(specs, medium, ds),
        inlet_temperature=medium.boundary.inlet_temperature,
        initial_temperature=domain.constant(heat.initial_temperature),
        inlet=ds(geometry.INLET),
        outlet=ds(geometry.OUTLET),
        dx_bed=dx(geometry.BED),
        nodes_bed=domain.nodal_measure()(geometry.BED),
        two_temperatures=heat.model.two_temperatures,
        exchange_factor=domain.constant(heat.model.exchange_factor),
        straight=domain.straight,
        opening=flow.inlet,
        interface=Interface(domain.interface_measure(QUADRATURE_DEGREE), domain.in_bed()),
        interior=_bead_interior(specs, medium),
        moving_beads=_moving_beads(specs, medium, ds, dx(geometry.BED)),
        melts=melts(specs.laws.beads.heat_capacity, heat),
    )


def _moving_beads(specs: Specs, medium: Medium, ds: Expression, dx_bed: Expression) -> MovingBeads | None:
    heat, bed = specs.heat, medium.equations.bed
    if bed.bead_velocity is None or heat.bead_motion.inlet_temperature is None:
        return None
    ends = ds(geometry.INLET), ds(geometry.OUTLET)
    entering, leaving = ends if heat.bead_motion.velocity > 0.0 else reversed(ends)
    return MovingBeads(
        bed=bed,
        coordinates=medium.equations.coordinates,
        velocity=bed.bead_velocity,
        sign=math.copysign(1.0, heat.bead_motion.velocity),
        inlet_temperature=medium.boundary.following(heat.bead_motion.inlet_temperature),
        entering=entering,
        leaving=leaving,
        dx=dx_bed,
    )


def _wall(specs: Specs, medium: Medium, ds: Any) -> Wall:
    outside = geometry.OUTER if medium.domain.has_outer_wall else geometry.INTERFACE
    return Wall(
        medium.equations.coordinates,
        medium.domain.wall_distance,
        _wall_layers(specs, medium),
        medium.boundary.outer_wall(ds(outside)),
        _thin_wall(specs, medium, ds(geometry.INTERFACE)),
    )


def _wall_layers(specs: Specs, medium: Medium) -> list[WallLayer]:
    domain, layers = medium.domain, []
    if not (domain.has_wall or specs.heat.wall.kind == "thin"):
        return []
    dx, nodes = domain.cell_measure(QUADRATURE_DEGREE), domain.nodal_measure()
    for tag, layer in zip(domain.wall_tags, specs.heat.all_layers, strict=True):
        source = None if layer.heat_source is None else medium.boundary.following(layer.heat_source)
        cured = None if layer.solid.cure is None else fem.Function(medium.flow_temperature.function_space)
        has_peak = melts(layer.solid.heat_capacity, specs.heat)
        layers.append(WallLayer(with_constants(layer.solid, domain), dx(tag), nodes(tag), source, cured, has_peak))
    return layers


def build_heat(specs: Specs, medium: Medium, flow: Flow, equations: EnergyEquations) -> Heat:
    """The temperatures, for a flow that follows them step by step, or as one system with the flow."""
    domain, sharpest = medium.domain, sharpest_change_of_stores(specs)
    heat = TransientHeat(
        domain,
        equations,
        specs.heat.initial_temperature,
        medium.boundary.set_heat,
        medium.property_temperature,
        QUADRATURE_DEGREE,
        ErrorControl(stage_error(sharpest), _stores(specs), specs.heat.reached if sharpest > SMOOTH_CHANGE else None),
    )
    _start(specs, heat.unknown, domain)
    if specs.flow.model.update != "transient":
        return heat
    return CoupledTransient(
        domain,
        cast(FullFlow, flow),
        heat,
        lambda state, warm: replace(equations, flow_state=state, flow_temperature=warm),
        medium.flow_temperature,
        medium.boundary.set,
        medium.estimates.mass_flux * 1e3,
    )


def _stores(specs: Specs) -> list[bool]:
    """Of each layer of the wall, whether it stores heat: what does not, as a contact, has the temperature of what is beside it,
    be it a gas behind a front."""
    temperature, beads = specs.heat.initial_temperature, specs.laws.beads
    of_beads = (1.0 - specs.porosity.bulk_porosity) * volumetric_capacity(beads, temperature)
    layers = (volumetric_capacity(layer.solid, temperature) for layer in specs.heat.all_layers)
    return [one > LEAST_STORAGE * of_beads for one in layers]


def _air_loop(specs: Specs, medium: Medium, heat: Heat, equations: EnergyEquations) -> AirLoop | None:
    spec, boundary = specs.heat.air_loop, medium.boundary
    if spec is None:
        return None
    assert isinstance(heat, TransientHeat), "checked with the scene"
    temperature = ufl.split(heat.unknown)[0] if equations.two_temperatures else heat.unknown
    given = specs.laws.fluid, specs.flow.outlet_pressure, boundary, equations, temperature, medium.domain.communicator
    heat.flows.supply = AirLoop(spec, *given, specs.flow.gravity * medium.domain.from_inlet_to_outlet[0])
    boundary.call_with_time(heat.flows.supply.set_time)
    return heat.flows.supply


NO_FLOW = 1e-6
"""Of the expected mass flux: what iterations leave of a flow that is none."""


def build_balances(medium: Medium, flow: Flow, heat: Heat, equations: EnergyEquations) -> Balances:
    """The forms of what flows in and out."""
    domain, weight = medium.domain, medium.equations.coordinates.weight
    ds = domain.facet_measure(QUADRATURE_DEGREE)
    outflow = weight * equations.outward_mass_flux
    temperature = ufl.split(heat.unknown)[0] if equations.two_temperatures else heat.unknown
    area = domain.constant(medium.inlet_area)
    bead_outlet = None
    if equations.moving_beads is not None:
        solid, leaving = weight * (1.0 - equations.bed.porosity), equations.moving_beads.leaving
        bead_temperature = ufl.split(heat.unknown)[1]
        bead_outlet = DeferredForm(solid * bead_temperature * leaving), DeferredForm(solid * leaving)
    outlet, source = ds(geometry.OUTLET), equations.flow.source_of_flux
    return Balances(
        domain.communicator,
        NO_FLOW * medium.estimates.mass_flux,
        mass_in=DeferredForm(weight * equations.inward_mass_flux * ds(geometry.INLET)),
        mass_out=DeferredForm(outflow * ds(geometry.OUTLET)),
        mass_displaced=None if source is None else DeferredForm(weight * source * equations.dx_bed),
        is_mass_kept=equations.bed.rev_vector is None,
        inlet_pressure=DeferredForm(weight * flow.state.pressure / area * ds(geometry.INLET)),
        outlet_heat=DeferredForm(outflow * temperature * ds(geometry.OUTLET)),
        outlet_area=DeferredForm(weight * outlet),
        outlet_mean=DeferredForm(weight * temperature * outlet),
        bead_outlet=bead_outlet,
    )


def with_constants(material: Any, domain: Domain) -> Any:
    """The material with its polynomials' coefficients as UFL constants."""
    laws: dict[str, Any] = {
        name: law.with_coefficients(domain.constant(c) for c in law.coefficients)
        for name, law in material.laws().items()
        if hasattr(law, "coefficients")
    }
    if isinstance(material, Solid):
        laws["contact_flattening"] = domain.constant(material.contact_flattening)
    return replace(material, **laws)


def _with_constant_factor(law: Any, domain: Domain) -> Any:
    """The law with its factor as a UFL constant, unless that is 1, and the rate at which beads are mixed, unless that is 0."""
    given = {} if law.factor == 1.0 else {"factor": domain.constant(law.factor)}
    if getattr(law, "mixing_rate", 0.0):
        given["mixing_rate"] = domain.constant(law.mixing_rate)
    return replace(law, **given)


def _at_nodes(domain: Domain, function: Any) -> fem.Function:
    """A function of the wall distance (m) at the nodes."""
    space = fenicsx.lagrange_space(domain.mesh)
    result = fem.Function(space)
    result.x.array[:] = function(nodal_values(domain.wall_distance, space).clip(min=0.0))
    return result


def _rev_vector(specs: Specs, domain: Domain) -> Value | None:
    if specs.flow.averaging.terms == "off":
        return None
    porosity, diameter = specs.porosity, specs.mesh.bead_diameter
    difference = _at_nodes(domain, lambda y: porosity.volume(y, diameter) - porosity.area(y, diameter))
    largest_diameter = domain.constant(specs.flow.averaging.diameter_ratio * diameter)
    return rev_vector(difference, domain.wall_distance, largest_diameter)


def _thin_wall(specs: Specs, medium: Medium, ds: ufl.Measure) -> ThinWall | None:
    if specs.heat.wall.kind != "thin":
        return None
    thickness = specs.heat.layers[0].thickness
    assert thickness is not None, "checked with the scene"
    ratio = thickness / medium.size.half_height if medium.size.axisymmetric else 0.0
    constant = medium.domain.constant
    nodes = medium.domain.nodal_facet_measure()(geometry.INTERFACE)
    return ThinWall(ds, constant(thickness * (1.0 + 0.5 * ratio)), constant(1.0 + ratio), nodes)


def _bead_interior(specs: Specs, medium: Medium) -> BeadInterior | None:
    if specs.heat.model.bead_modes is None:
        return None
    bed = medium.equations.bed
    lag = fem.Function(medium.flow_temperature.function_space)
    eigenvalues = tuple(bead_interior.eigenvalues(specs.heat.model.bead_modes))
    return BeadInterior(eigenvalues, bed.beads, bed.bead_diameter, lag, medium.domain.constant(1.0))
