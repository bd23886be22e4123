"""The mesh of a scene: of a straight bed from what the scene gives and what its estimates say, or one of its own that is read."""

import math
import os
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from dolfinx import fem

from ..arrays import Floats
from ..equations.coordinates import Coordinates
from ..errors import InputError
from ..mesh import domain as geometry
from ..mesh import fenicsx, ranks
from ..mesh.aliases import Communicator, Form
from ..mesh.domain import Domain
from ..mesh.from_gmsh import Finer, from_file
from ..scene.features.geometries import HALVINGS, BedSize
from ..scene.features.wall import Layer
from ..scene.series import ProfileSeries, TimeSeries
from ..scene.start import Profile
from ..solvers.protocols import Observer, silent
from .air_loop_spec import first_point
from .estimates import AXIAL_GRADING, Estimates, estimate
from .specs import MeshSpec, Specs

WIDEST_CELL, WIDEST_OF_CONDUCTION = 0.2, 0.05
"""Of the width from the wall to the middle of the bed; where conduction from the wall heats it sooner than the flow does."""
GROWTH_OF_CONDUCTION = 0.4
"""Exponent on the growth of the cells there: the front comes across the flow."""
FINE_LAYER = 1.5
"""Bead diameters from the wall within which cells grow slowly: porosity laws that fall as exp(-2 y / d) have a seventh of their
rise left at one of them, a twentieth here."""
FINER_PROFILES = 2.0
"""Factor on the cells across the bed of a table of profiles, which is cheap."""
BYTES_AN_UNKNOWN = {2: 10e3, 3: 40e3}
"""Memory that factors, matrices and the rest need for an unknown of the flow, by dimensions of space (docs/growth.md)."""
LEAST_CELLS = 2
"""In any direction."""
QUADRATURE_DEGREE = 2
"""Of all forms over bed and wall but those of developed flow, which are integrated station by station."""
ALONG, LEAST_LENGTH = 0.9, 0.5
"""Cosine of the angle between x[0] and the way from inlet to outlet that counts as along x[0]; part of that way that a mesh is
long at least."""
SAME_VOLUME = 1e-6
"""Relative difference of volumes that rounding explains."""


def build_domain(
    specs: Specs, communicator: Communicator, observe: Observer = silent
) -> tuple[Domain, BedSize, Estimates]:
    """The mesh, the size of its bed, and what is predicted of the flow in it (collective)."""
    mesh = specs.mesh
    if mesh.size is not None:
        estimates = estimate(specs, mesh.size)
        return straight_domain(mesh, estimates, communicator, observe), mesh.size, estimates
    assert mesh.own.mesh is not None
    names = [layer.name for layer in specs.heat.layers] or ["wall"]
    shape = {"dimension": mesh.dimension, "axisymmetric": mesh.axisymmetric}
    read = partial(
        from_file,
        communicator,
        mesh.own.mesh,
        names,
        **shape,
        trusted=mesh.trusted,
        conventions=mesh.conventions,
    )
    finer = Finer(halvings=HALVINGS[mesh.cells.refinement])
    domain = read(finer=finer)
    _require_direction(specs, domain)
    _require_parts(specs, domain)
    size = _size_of(domain)
    estimates = estimate(_with_blower(specs, size), size)
    if mesh.own.refine_wall:
        drawn, domain = domain, read(finer=finer._replace(cells_at_wall=partial(cells_at_wall, mesh, estimates)))
        if (
            abs(_bed_volume(domain) / _bed_volume(drawn) - 1.0) > SAME_VOLUME
        ):  # a cell that was turned over adds its own
            allowed = "finds no place for cells at the wall: the first cells of the mesh are too distorted"
            raise InputError("geometry.refine_wall", True, allowed, mesh.scene_file)
    outer = specs.heat.outer_wall
    if not domain.has_outer_wall and (outer.heat_flux is not None or outer.exchanges):
        raise InputError(
            "geometry.mesh", str(mesh.own.mesh), "needs a physical curve 'outer' for the outer wall's heat"
        )
    return domain, size, estimates


def _require_parts(specs: Specs, domain: Domain) -> None:
    """Raise `InputError` where blower or heater need to know whether a plane mesh without planes of symmetry is half of the tool
    (collective)."""
    mesh = specs.mesh
    if specs.heat.air_loop is None or mesh.own.symmetry != "planar" or mesh.own.parts is not None:
        return
    if not ranks.anywhere(domain.communicator, len(domain.facets(geometry.SYMMETRY)) > 0):
        allowed = (
            "is missing: the mesh has no group 'symmetry': 1 where it is the whole cavity, 2 where it is half of it"
        )
        raise InputError("geometry.parts", None, allowed, mesh.scene_file)


def _with_blower(specs: Specs, size: BedSize) -> Specs:
    """Specs whose blower begins at the operating point that a bed of this size has, which only the mesh tells."""
    loop = specs.heat.air_loop
    if loop is None or loop.blower is None:
        return specs
    pressure = first_point(size, specs.laws, loop.blower, loop.share, specs.flow.outlet_pressure,
                           specs.heat.initial_temperature, specs.mesh.bead_diameter)  # fmt: skip
    return replace(specs, flow=replace(specs.flow, driven_by=TimeSeries.constant(pressure)))


def _require_direction(specs: Specs, domain: Domain) -> None:
    """Raise `InputError` for a mesh of one's own whose flow does not run along x[0] where that counts (collective): in three
    dimensions for its length, and for gravity, profiles and heat fluxes along the flow."""
    way, mesh = domain.from_inlet_to_outlet, specs.mesh
    distance = float(np.linalg.norm(way))
    begin, end = domain.ends
    if mesh.dimension == 3 and end - begin < LEAST_LENGTH * distance:
        allowed = f"must have its flow along x[0]: it is {end - begin:.4g} m long there, {distance:.4g} m from inlet to outlet"
        raise InputError("geometry.mesh", str(mesh.own.mesh), allowed, mesh.scene_file)
    if way[0] > ALONG * distance:
        return
    flux, start = specs.heat.outer_wall.heat_flux, specs.heat.start
    for key, value in (
        ("operation.gravity", specs.flow.gravity or None),
        ("operation.initial_temperature", start.source if isinstance(start, Profile) else None),
        ("operation.outer_heat_flux", flux.source if isinstance(flux, ProfileSeries) else None),
    ):
        if value is not None:
            to = ", ".join(f"{part:.3g}" for part in way[: domain.mesh.geometry.dim])
            allowed = f"counts along x[0], and from inlet to outlet this mesh goes by ({to}) m: turn it"
            raise InputError(key, value, allowed, mesh.scene_file)


def straight_domain(
    spec: MeshSpec, estimates: Estimates, communicator: Communicator, observe: Callable[[str], None]
) -> Domain:
    """Domain of a straight bed; what the scene leaves open is as its `estimates` say.

    `observe(text)` gets its size as a text. Raises `InputError` where it would need more memory than the machine has.
    """
    size, finer = spec.size, spec.cells.refinement
    assert size is not None
    layers = [
        layer.thickness * _through(cells_through(layer, cells, finer), to_surfaces=thick)
        for layer, cells, thick in zip(
            spec.layers + spec.opposite_layers, estimates.wall_cells, estimates.thick_layers, strict=False
        )
        if layer.thickness is not None
    ]
    layers, opposite = layers[: len(spec.layers)], layers[len(spec.layers) :]
    conducts = estimates.conduction_time < estimates.flow_duration

    def from_wall(width: float) -> Floats:
        if estimates.uniform_across and spec.cells.first is None:
            return np.linspace(0.0, width, 1 + LEAST_CELLS)
        first_cell = spec.cells.first or estimates.first_cell
        layer, widest = FINE_LAYER * spec.bead_diameter, (WIDEST_OF_CONDUCTION if conducts else WIDEST_CELL) * width
        growth = spec.cells.growth ** (GROWTH_OF_CONDUCTION if conducts else 1.0)
        return refined(geometry.graded_coordinates(width, first_cell, growth, layer, widest), finer)

    to_wall = from_wall(size.half_height)
    across = [
        geometry.Across.between_walls(to_wall, layers, opposite, size.middle)
        if size.whole
        else geometry.Across.to_wall(to_wall, layers)
    ]
    if size.half_width is not None and size.walled_sides:
        across.append(geometry.Across.to_wall(from_wall(size.half_width), layers))
    elif size.half_width is not None:  # nothing changes across the width: cells as wide as the bed is high
        cells = max(2, round(finer * size.half_width / size.half_height))
        across.append(geometry.Across(np.linspace(0.0, size.half_width, cells + 1), cells, walled=False))
    nodes = symmetric_nodes if spec.is_symmetric else axial_nodes
    along = nodes(size.length, spec.cells.along or estimates.axial_cells, estimates.end_length)
    along = refined(along, finer * spec.cells.refinement_along)
    _announce(spec, len(along) - 1, across, observe)
    return geometry.straight_bed(communicator, along, across, axisymmetric=size.axisymmetric)


def plane_of_stations(spec: MeshSpec, estimates: Estimates, communicator: Communicator, stations: int) -> Domain:
    """Plane bed whose stations are those of a table of profiles: across it twice the cells that a scene has by default."""
    assert spec.size is not None
    width, first_cell = spec.size.half_height, spec.cells.first or estimates.first_cell
    layer = FINE_LAYER * spec.bead_diameter
    nodes = geometry.graded_coordinates(width, first_cell, spec.cells.growth, layer, WIDEST_CELL * width)
    across = geometry.Across.to_wall(refined(nodes, FINER_PROFILES * max(1.0, spec.cells.refinement)))
    return geometry.straight_bed(communicator, np.linspace(0.0, 1.0, stations), [across])


def cells_through(layer: Layer, usual: int, refinement: float) -> int:
    """How many cells a layer of the wall has, `usual` ones by default."""
    return max(1, round((layer.cells or usual) * refinement))


def _through(cells: int, *, to_surfaces: bool) -> Floats:
    """Nodes through a layer of the thickness 1: even, or small at both surfaces where heat does not come through in time."""
    even = np.linspace(0.0, 1.0, cells + 1)
    return 0.5 * (1.0 - np.cos(np.pi * even)) if to_surfaces else even


def _announce(spec: MeshSpec, cells_along: int, across: list[geometry.Across], observe: Callable[[str], None]) -> None:
    cells = cells_along * math.prod(direction.cells for direction in across)
    in_bed = cells_along * math.prod(direction.bed_cells for direction in across)
    unknowns = in_bed * spec.unknowns_per_node
    memory = BYTES_AN_UNKNOWN[1 + len(across)] * unknowns
    observe(f"mesh of {cells} cells, about {unknowns:.2g} unknowns of the flow and {memory / 2**30:.1g} GiB")
    machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if memory > machine:
        raise InputError(
            "solver.mesh_refinement",
            spec.cells.refinement,
            f"makes a mesh of {cells} cells, whose flow needs about {memory / 2**30:.0f} GiB of memory; this machine has "
            f"{machine / 2**30:.0f}",
            spec.scene_file,
        )


def cells_at_wall(spec: MeshSpec, estimates: Estimates, gap: float) -> Floats:
    """Depths (m) of the nodes that the wall of a mesh of one's own needs in a gap beside it."""
    return geometry.graded_coordinates(gap, estimates.first_cell, spec.cells.growth, FINE_LAYER * spec.bead_diameter)


def axial_nodes(length: float, cells: int, last_cell: float) -> Floats:
    """Nodes (m) along the flow from 0 to `length`: graded from the inlet, the last of the `cells` halved until it is at most
    `last_cell` (m) long, where the wall's end lets no heat out."""
    nodes = length * np.linspace(0.0, 1.0, cells + 1) ** AXIAL_GRADING
    while nodes[-1] - nodes[-2] > last_cell:
        nodes = np.insert(nodes, -1, 0.5 * (nodes[-2] + nodes[-1]))
    return nodes


def symmetric_nodes(length: float, cells: int, last_cell: float) -> Floats:
    """Nodes (m) of a bed that the fluid enters from either end: graded from both, the cells at the ends as `axial_nodes` has the
    last one."""
    half = axial_nodes(0.5 * length, -(-cells // 2), math.inf)
    outer = half[1]
    while outer > last_cell:
        outer *= 0.5
        half = np.insert(half, 1, outer)
    return np.concatenate([half, length - half[-2::-1]])


def refined(nodes: Floats, factor: float) -> Floats:
    """Nodes of `factor` times as many cells, `LEAST_CELLS` at least: where it is a whole number every cell is cut evenly."""
    cells = max(LEAST_CELLS, round((len(nodes) - 1) * factor))
    return np.interp(np.linspace(0, len(nodes) - 1, cells + 1), np.arange(len(nodes)), nodes)


def _size_of(domain: Domain) -> BedSize:
    """Of a mesh's bed, as if it were straight, as high as its inlet, and as long as its wall, or as the way from inlet to outlet
    where a wall is beside a part of that only (collective)."""
    area, length = area_of_inlet(domain), max(domain.length, float(np.linalg.norm(domain.from_inlet_to_outlet)))
    if domain.axisymmetric:
        return BedSize(length=length, half_height=math.sqrt(area / math.pi), axisymmetric=True)
    if domain.mesh.topology.dim == 2:
        return BedSize(length=length, half_height=area)
    at_inlet = fem.locate_dofs_topological(domain.wall_distance.function_space, 2, domain.facets(geometry.INLET))
    height = ranks.largest_magnitude(domain.communicator, domain.wall_distance.x.array[at_inlet])
    return BedSize(length=length, half_height=height, half_width=area / height)


def area_of_inlet(domain: Domain) -> float:
    """Area of the inlet (m2; m in a plane), about an axis of the whole ring (collective)."""
    weight = Coordinates(domain.mesh, domain.axisymmetric).weight
    return integral_over(
        domain, weight * domain.constant(1.0) * domain.facet_measure(QUADRATURE_DEGREE)(geometry.INLET)
    )


def _bed_volume(domain: Domain) -> float:
    return integral_over(domain, domain.constant(1.0) * domain.cell_measure(QUADRATURE_DEGREE)(geometry.BED))


def integral_over(domain: Domain, form: Form) -> float:
    """Of a form over a domain, on all ranks (collective)."""
    return ranks.integral(domain.communicator, fenicsx.compiled_form(form))
