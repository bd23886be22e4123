"""The mesh of a straight bed: from what a scene gives and what its estimates say."""

import math
import os
from collections.abc import Callable

import numpy as np

from ..arrays import Floats
from ..errors import InputError
from ..mesh import domain
from ..mesh.aliases import Communicator
from ..mesh.domain import Domain
from .estimates import AXIAL_GRADING, Estimates
from .specs import MeshSpec

WIDEST_CELL, WIDEST_OF_CONDUCTION = 0.2, 0.05
"""Of the width from the wall to the middle of the bed; where conduction from the wall heats it sooner than the flow does."""
GROWTH_OF_CONDUCTION = 0.4
"""Exponent on the growth of the cells there: the front comes across the flow."""
FINER_PROFILES = 2.0
"""Factor on the cells across the bed of a table of profiles, which is cheap."""
BYTES_AN_UNKNOWN = {2: 10e3, 3: 40e3}
"""Memory that factors, matrices and the rest need for an unknown of the flow, by dimensions of space (docs/growth.md)."""


def straight_domain(
    spec: MeshSpec, estimates: Estimates, communicator: Communicator, observe: Callable[[str], None]
) -> Domain:
    """Domain of a straight bed; what the scene leaves open is as its `estimates` say.

    `observe(text)` gets its size as a text. Raises `InputError` where it would need more memory than the machine has.
    """
    size, finer = spec.size, spec.cells.refinement
    assert size is not None
    layers = [
        layer.thickness * _through(max(1, round((layer.cells or cells) * finer)), to_surfaces=thick)
        for layer, cells, thick in zip(
            spec.layers + spec.opposite_layers, estimates.wall_cells, estimates.thick_layers, strict=False
        )
        if layer.thickness is not None
    ]
    layers, opposite = layers[: len(spec.layers)], layers[len(spec.layers) :]
    conducts = estimates.conduction_time < estimates.flow_duration

    def from_wall(width: float) -> Floats:
        first_cell = spec.cells.first or estimates.first_cell
        layer, widest = spec.bead_diameter, (WIDEST_OF_CONDUCTION if conducts else WIDEST_CELL) * width
        growth = spec.cells.growth ** (GROWTH_OF_CONDUCTION if conducts else 1.0)
        return refined(domain.graded_coordinates(width, first_cell, growth, layer, widest), finer)

    to_wall = from_wall(size.half_height)
    across = [
        domain.Across.between_walls(to_wall, layers, opposite, size.middle)
        if size.whole
        else domain.Across.to_wall(to_wall, layers)
    ]
    if size.half_width is not None and size.walled_sides:
        across.append(domain.Across.to_wall(from_wall(size.half_width), layers))
    elif size.half_width is not None:  # nothing changes across the width: cells as wide as the bed is high
        cells = max(2, round(finer * size.half_width / size.half_height))
        across.append(domain.Across(np.linspace(0.0, size.half_width, cells + 1), cells, walled=False))
    nodes = symmetric_nodes if spec.is_symmetric else axial_nodes
    along = nodes(size.length, spec.cells.along or estimates.axial_cells, estimates.end_length)
    along = refined(along, finer * spec.cells.refinement_along)
    _announce(spec, len(along) - 1, across, observe)
    return domain.straight_bed(communicator, along, across, axisymmetric=size.axisymmetric)


def plane_of_stations(spec: MeshSpec, estimates: Estimates, communicator: Communicator, stations: int) -> Domain:
    """Plane bed whose stations are those of a table of profiles: across it twice the cells that a scene has by default."""
    assert spec.size is not None
    width, first_cell = spec.size.half_height, spec.cells.first or estimates.first_cell
    nodes = domain.graded_coordinates(width, first_cell, spec.cells.growth, spec.bead_diameter, WIDEST_CELL * width)
    across = domain.Across.to_wall(refined(nodes, FINER_PROFILES * max(1.0, spec.cells.refinement)))
    return domain.straight_bed(communicator, np.linspace(0.0, 1.0, stations), [across])


def _through(cells: int, *, to_surfaces: bool) -> Floats:
    """Nodes through a layer of the thickness 1: even, or small at both surfaces where heat does not come through in time."""
    even = np.linspace(0.0, 1.0, cells + 1)
    return 0.5 * (1.0 - np.cos(np.pi * even)) if to_surfaces else even


def _announce(spec: MeshSpec, cells_along: int, across: list[domain.Across], observe: Callable[[str], None]) -> None:
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
    return domain.graded_coordinates(gap, estimates.first_cell, spec.cells.growth, spec.bead_diameter)


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
    """Nodes of `factor` times as many cells, two at least: where it is a whole number every cell is cut evenly."""
    cells = max(2, round((len(nodes) - 1) * factor))
    return np.interp(np.linspace(0, len(nodes) - 1, cells + 1), np.arange(len(nodes)), nodes)
