"""Meshes of bed and wall with their tags, and the distance to the wall.

x[0] runs along the flow, x[1] across it: from the symmetry plane (mold) or the axis (pipe) through the bed to the
wall, in a whole cavity from the wall opposite, with the middle at 0, and in an annulus from its core; in three dimensions
x[2] runs from a second symmetry plane (`SIDE`) to the wall beside, or to a third plane of symmetry (`SIDE` too). The bed's
cells have the tag `BED`, those of the wall `WALL`, or of its layers outwards `WALL`, `WALL` + 1, ..., then those of the wall
opposite outwards; the boundary's parts have the tags `INLET` ... below. One mesh carries both, so that one temperature is
continuous across the interface.
"""

import functools
import math
import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeAlias

import numpy as np
import ufl
from dolfinx import fem, mesh
from scipy.optimize import brentq

from ..arrays import Booleans, Floats, Integers
from . import fenicsx, ranks
from .aliases import Communicator, Constant, Expression, Mesh
from .nodes import facet_corners
from .point_values import nodal_values
from .quadrature_rules import column_rule, flow_axis, vertex_rule

BED, WALL = 1, 2
INLET, OUTLET, INTERFACE, OUTER, SYMMETRY, SIDE = 1, 2, 3, 4, 5, 6

ACROSS = 1.0 - 1e-9
"""Of the normal of a plane of symmetry, its part along an axis that it is across."""

Marker: TypeAlias = Callable[[Floats], Booleans]
Marked: TypeAlias = Sequence[tuple[int, Marker]]
"""Tags, each with a function that tells which of the points (coordinates, points) it belongs to."""

FACETS = {
    "triangle": "interval",
    "quadrilateral": "interval",
    "tetrahedron": "triangle",
    "hexahedron": "quadrilateral",
}
"""Of cells."""


Stations: TypeAlias = Callable[[float], dict[str, tuple[float, ...]]]
"""Gives named points (m) at a fraction of the length."""


@dataclass
class Domain:
    """A tagged mesh. `wall_distance` is a UFL expression (m); `stations(fraction)` gives named points (m) at that
    fraction of the length. A `straight` one has its cells along x[0]; `layers` is the number of those of its wall; `columns` are
    the nodes along and across the bed (m) of a straight one in two dimensions, else None."""

    mesh: mesh.Mesh
    cell_tags: Any
    facet_tags: Any
    axisymmetric: bool
    wall_distance: ufl.core.expr.Expr
    length: float
    stations: Stations
    straight: bool = False
    layers: int = 1
    columns: tuple[Floats, Floats] | None = None

    @property
    def communicator(self) -> Communicator:
        return self.mesh.comm

    @property
    def has_wall(self) -> bool:
        """Whether any cell of any rank lies in the wall."""
        return ranks.anywhere(self.communicator, len(self.wall_cells) > 0)

    @property
    def wall_tags(self) -> range:
        """Tags of the wall's layers, outwards."""
        return range(WALL, WALL + self.layers)

    @property
    def wall_cells(self) -> Integers:
        """Local cells of the wall, sorted."""
        return self.cells(*self.wall_tags)

    def wall_measure(self, quadrature_degree: int) -> ufl.Measure:
        """dx over the whole wall."""
        dx = self.cell_measure(quadrature_degree)
        return functools.reduce(operator.add, (dx(tag) for tag in self.wall_tags))

    @property
    def has_outer_wall(self) -> bool:
        """Whether any facet of any rank lies on the outer wall."""
        return ranks.anywhere(self.communicator, len(self.facets(OUTER)) > 0)

    def constant(self, value: float) -> Constant:
        """A number as UFL constant, so that another value needs no new compilation."""
        return fem.Constant(self.mesh, float(value))

    def cells(self, *tags: int) -> Integers:
        """Local cells with any of the tags, sorted."""
        return np.sort(np.concatenate([self.cell_tags.find(tag) for tag in tags]).astype(np.int32))

    def facets(self, tag: int) -> Integers:
        """Local facets with the tag."""
        return self.facet_tags.find(tag)

    @functools.cached_property
    def ends(self) -> tuple[float, float]:
        """Lowest and highest x[0] of the bed (m); distances along the flow count from the first (collective)."""
        nodes = fenicsx.cell_vertices(self.mesh)[self.cells(BED)]
        return ranks.extremes(self.communicator, self.mesh.geometry.x[nodes.ravel(), 0])

    @property
    def begin(self) -> float:
        return self.ends[0]

    @functools.cached_property
    def from_inlet_to_outlet(self) -> Floats:
        """From the middle of the inlet's corners to that of the outlet's, m (collective)."""
        middles = []
        for tag in (INLET, OUTLET):
            corners = facet_corners(self.mesh, self.facets(tag)).reshape(-1, 3)
            sums = np.asarray(ranks.total(self.communicator, np.append(corners.sum(axis=0), len(corners))))
            middles.append(sums[:3] / max(sums[3], 1.0))
        return np.asarray(middles[1] - middles[0])

    @functools.cached_property
    def depth(self) -> float:
        """Largest distance from the wall in the bed, m (collective)."""
        space = fenicsx.lagrange_space(self.mesh)
        in_bed = fem.locate_dofs_topological(space, self.mesh.topology.dim, self.cells(BED))
        return ranks.largest_magnitude(self.communicator, nodal_values(self.wall_distance, space)[in_bed])

    def planes_of_symmetry(self) -> list[Integers]:
        """Local facets of the planes of symmetry (`SYMMETRY`, `SIDE`) across each axis. Oblique ones are in none: there, as at a
        boundary without a tag, no flow passes because none enters the mass balance."""
        facets, dimension = np.union1d(self.facets(SYMMETRY), self.facets(SIDE)), self.mesh.topology.dim
        corners = facet_corners(self.mesh, facets)
        along = corners[:, 1] - corners[:, 0]
        up = corners[:, 2] - corners[:, 0] if dimension == 3 else np.broadcast_to((0.0, 0.0, 1.0), along.shape)
        normals = np.abs(np.cross(along, up))
        normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
        return [facets[normals[:, axis] > ACROSS] for axis in range(dimension)]

    def entrance(self) -> fem.Function:
        """Function that is 1 in the cells with a node on the inlet, else 0."""
        dimension = self.mesh.topology.dim
        nodes = fem.Function(fenicsx.lagrange_space(self.mesh))
        space = nodes.function_space
        nodes.x.array[fem.locate_dofs_topological(space, dimension - 1, self.facets(INLET))] = 1.0
        nodes.x.scatter_forward()
        cells = fem.Function(fenicsx.cell_constant_space(self.mesh))
        touched = nodes.x.array[fenicsx.dof_table(space)].max(axis=1)
        cells.x.array[fenicsx.dof_table(cells.function_space)[:, 0]] = touched
        return cells

    def in_bed(self) -> fem.Function:
        """Function that is 1 in the bed's cells, else 0."""
        cells = fem.Function(fenicsx.cell_constant_space(self.mesh))
        cells.x.array[fenicsx.dof_table(cells.function_space)[self.cells(BED), 0]] = 1.0
        return cells

    def cell_measure(self, quadrature_degree: int) -> ufl.Measure:
        """dx with the regions' tags as subdomains."""
        metadata = {"quadrature_degree": quadrature_degree}
        return ufl.Measure("dx", domain=self.mesh, subdomain_data=self.cell_tags, metadata=metadata)

    def nodal_measure(self) -> ufl.Measure:
        """dx with quadrature at the nodes, which makes what is stored at a node its own affair."""
        metadata = vertex_rule(fenicsx.cell_name(self.mesh))
        return ufl.Measure("dx", domain=self.mesh, subdomain_data=self.cell_tags, metadata=metadata)

    def column_measure(self, quadrature_degree: int) -> ufl.Measure:
        """dx of a straight bed with quadrature at the nodes along the flow: every column of nodes is by itself."""
        rule = column_rule(flow_axis(self.mesh), quadrature_degree)
        return ufl.Measure("dx", domain=self.mesh, subdomain_data=self.cell_tags, metadata=rule)

    def interface_measure(self, quadrature_degree: int) -> ufl.Measure:
        """Measure of the facets between bed and wall: interior ones where the wall has cells, else the bed's boundary."""
        kind, metadata = "dS" if self.has_wall else "ds", {"quadrature_degree": quadrature_degree}
        measure = ufl.Measure(kind, domain=self.mesh, subdomain_data=self.facet_tags, metadata=metadata)
        return measure(INTERFACE)

    def facet_measure(self, quadrature_degree: int) -> ufl.Measure:
        """ds with the boundary's tags as subdomains."""
        metadata = {"quadrature_degree": quadrature_degree}
        return ufl.Measure("ds", domain=self.mesh, subdomain_data=self.facet_tags, metadata=metadata)

    def nodal_facet_measure(self) -> ufl.Measure:
        """ds with quadrature at the nodes."""
        metadata = vertex_rule(FACETS[fenicsx.cell_name(self.mesh)])
        return ufl.Measure("ds", domain=self.mesh, subdomain_data=self.facet_tags, metadata=metadata)


def graded_coordinates(
    width: float, first_cell: float, growth: float, layer: float = 0.0, widest: float = math.inf
) -> Floats:
    """Nodes from 0 (the wall) to `width`: cells from `first_cell` grow by at most `growth`, by its root up to the depth `layer`.

    The number of cells is the smallest with that growth; the first cell is met exactly unless it is wider than a uniform
    cell. No other cell is wider than `widest`.
    """
    if first_cell >= width:
        return np.array([0.0, width])

    def nodes(exponent: float, count: int | None = None) -> Floats:
        size, depths = first_cell, [0.0]
        while depths[-1] < width if count is None else len(depths) <= count:
            depths.append(depths[-1] + size)
            ratio = growth ** (exponent * (0.5 if depths[-1] < layer else 1.0))
            size = min(size * ratio, max(widest, first_cell))
        return np.array(depths)

    count = len(nodes(1.0)) - 1
    if first_cell * count >= width:
        return np.linspace(0.0, width, count + 1)
    found = nodes(brentq(lambda exponent: nodes(exponent, count)[-1] - width, 0.0, 1.0), count)
    return found * (width / found[-1])


@dataclass(frozen=True)
class Across:
    """One direction across a straight bed, from its middle outwards: `nodes` (m) from 0, the first `bed_cells` cells of them
    in the bed, the others in the wall, whose layers have `layer_cells` outwards. Not `walled`, it ends at another plane of
    symmetry. A wall opposite, whose layers have `opposite_cells` outwards, comes before the bed, which is whole then, with its
    `middle` (m) at 0 in a cavity; about an axis the wall opposite is a core, and places are radii."""

    nodes: Floats
    bed_cells: int
    walled: bool = True
    layer_cells: tuple[int, ...] = ()
    opposite_cells: tuple[int, ...] = ()
    middle: float = 0.0

    @classmethod
    def to_wall(cls, bed_nodes: Floats, layers: Sequence[Floats] = ()) -> "Across":
        """`bed_nodes` are distances from the wall, 0 to the bed's width; `layers` depths into each of the wall's, from 0."""
        places = [bed_nodes[-1] - bed_nodes[::-1]]
        for depths in layers:
            places.append(places[-1][-1] + depths[1:])
        return cls(np.concatenate(places), len(bed_nodes) - 1, True, tuple(len(depths) - 1 for depths in layers))

    @classmethod
    def between_walls(
        cls, bed_nodes: Floats, layers: Sequence[Floats], opposite: Sequence[Floats], middle: float = 0.0
    ) -> "Across":
        """`bed_nodes` are distances from either wall, 0 to half of the bed's width; `layers` and those of the wall `opposite` are
        depths into each layer, from 0."""
        whole = np.concatenate([bed_nodes, 2.0 * bed_nodes[-1] - bed_nodes[-2::-1]])
        one, other = cls.to_wall(whole, layers), cls.to_wall(bed_nodes, opposite)
        outside = other.nodes[other.bed_cells + 1 :]
        nodes = np.concatenate([-outside[::-1], one.nodes - bed_nodes[-1]]) + middle
        return cls(nodes, one.bed_cells, True, one.layer_cells, other.layer_cells, middle)

    def layer_of(self, cells: Integers) -> Integers:
        """Number of the layer that each of the cells, counted from the first node, is in; 0 in the bed, 1, 2, ... outwards, those
        of the wall opposite after the others."""
        found = np.zeros(len(cells), int)
        for cells_of, beyond, before in (
            (self.layer_cells, cells - self.bed_end, 0),
            (self.opposite_cells, self.bed_begin - 1 - cells, len(self.layer_cells)),
        ):
            in_wall, begins = beyond >= 0, np.cumsum([0, *cells_of[:-1]])
            found[in_wall] = before + np.searchsorted(begins, beyond[in_wall], side="right")
        return found

    @property
    def bed_begin(self) -> int:
        """Number of the bed's first node."""
        return sum(self.opposite_cells)

    @property
    def bed_end(self) -> int:
        """Number of its last one."""
        return self.bed_begin + self.bed_cells

    @property
    def cells(self) -> int:
        return len(self.nodes) - 1

    @property
    def width(self) -> float:
        """Of the bed, m."""
        return float(self.nodes[self.bed_end] - self.nodes[self.bed_begin])


def straight_bed(
    communicator: Communicator, axial_nodes: Floats, across: Sequence[Across], *, axisymmetric: bool = False
) -> Domain:
    """Mesh of a straight bed along x[0] (`axial_nodes` from 0, m) with a wall outside it.

    `across` has one `Across` for x[1], and a second one for x[2] in three dimensions; the first is walled.
    """
    cells = [len(axial_nodes) - 1, *(direction.cells for direction in across)]
    domain = fenicsx.box_mesh(communicator, cells)

    tags = _tag_regions(domain, across)
    facets = _tag_boundary(domain, *_boundary_markers(across, axisymmetric=axisymmetric))
    points = domain.geometry.x
    for axis, nodes in enumerate((axial_nodes, *(direction.nodes for direction in across))):
        points[:, axis] = np.asarray(nodes)[np.rint(points[:, axis] * cells[axis]).astype(int)]
    first = across[0]
    columns = (np.asarray(axial_nodes), first.nodes[first.bed_begin : first.bed_end + 1]) if len(across) == 1 else None
    length = float(axial_nodes[-1])
    layers = max(len(first.layer_cells) + len(first.opposite_cells), 1)
    stations = partial(_stations, length, across)
    return Domain(
        domain, tags, facets, axisymmetric, _wall_distance(domain, across), length, stations, True, layers, columns
    )


def _boundary_markers(across: Sequence[Across], *, axisymmetric: bool) -> tuple[Marked, Marked]:
    """Tags with what marks their facets, on the unit square or cube: of the boundary, and inside. The inside of a core lets no
    heat out, be it its axis or a hollow."""

    def in_bed(x: Floats, besides: int | None = None) -> Booleans:
        return np.all(
            [
                (x[axis] > (direction.bed_begin - 0.25) / direction.cells)
                & (x[axis] < (direction.bed_end + 0.25) / direction.cells)
                for axis, direction in enumerate(across, start=1)
                if axis != besides
            ]
            + [np.full(x.shape[1], True)],
            axis=0,
        )

    def at(axis: int, place: float) -> Marker:
        return lambda x: np.isclose(x[axis], place)

    def in_bed_at(axis: int, place: float) -> Marker:
        return lambda x: np.isclose(x[axis], place) & in_bed(x, besides=axis)

    exterior, interior = [(INLET, in_bed_at(0, 0.0)), (OUTLET, in_bed_at(0, 1.0))], []
    for axis, direction in enumerate(across, start=1):
        middle = (SYMMETRY, SIDE)[axis - 1]
        if direction.opposite_cells:
            exterior.append((middle if axisymmetric else OUTER, at(axis, 0.0)))
            interior.append((INTERFACE, in_bed_at(axis, direction.bed_begin / direction.cells)))
        else:
            exterior.append((middle, at(axis, 0.0)))
        if not direction.walled:
            exterior.append((middle, at(axis, 1.0)))
            continue
        if direction.cells > direction.bed_end:
            exterior.append((OUTER, at(axis, 1.0)))
        interior.append((INTERFACE, in_bed_at(axis, direction.bed_end / direction.cells)))
    return exterior, interior


def _stations(length: float, across: Sequence[Across], fraction: float) -> dict[str, tuple[float, ...]]:
    """Points (m) by name at a fraction of the length."""
    z, first = fraction * length, across[0]
    rest = (0.0,) * (len(across) - 1)
    named = {"centre": (z, first.middle, *rest), "bed_side": (z, first.nodes[first.bed_end], *rest)}
    if first.opposite_cells:
        named |= {"opposite_bed_side": (z, first.nodes[first.bed_begin]), "opposite_outer": (z, first.nodes[0])}
    if first.cells > first.bed_end:
        named["outer"] = (z, first.nodes[-1], *rest)
        if len(across) == 2 and across[1].walled:
            named["corner"] = (z, first.nodes[-1], across[1].nodes[-1])
    return named


def _wall_distance(domain: Mesh, across: Sequence[Across]) -> Expression:
    """Distance from the nearest wall (m, UFL)."""
    position = ufl.SpatialCoordinate(domain)
    ends = (float(direction.nodes[direction.bed_end]) - direction.middle for direction in across)
    widths = [fem.Constant(domain, end) for end in ends]  # another one needs no compilation
    whole, middle = bool(across[0].opposite_cells), fem.Constant(domain, float(across[0].middle))
    wall_distance = widths[0] - (abs(position[1] - middle) if whole else position[1])
    if len(across) == 2 and across[1].walled:
        beside = widths[1] - position[2]
        wall_distance = ufl.conditional(ufl.lt(beside, wall_distance), beside, wall_distance)
    return wall_distance


def _tag_regions(domain: Mesh, across: Sequence[Across]) -> Any:
    dimension = domain.topology.dim
    count = domain.topology.index_map(dimension).size_local + domain.topology.index_map(dimension).num_ghosts
    cells = np.arange(count, dtype=np.int32)
    middle = domain.geometry.x[fenicsx.cell_vertices(domain)].mean(axis=1)
    layers = [d.layer_of(np.floor(middle[:, axis] * d.cells).astype(int)) for axis, d in enumerate(across, start=1)]
    values = (BED + np.max(layers, axis=0)).astype(np.int32)
    return mesh.meshtags(domain, dimension, cells, values)


def _tag_boundary(domain: Mesh, exterior: Marked, interior: Marked) -> Any:
    dimension = domain.topology.dim - 1
    found = [(tag, mesh.locate_entities_boundary(domain, dimension, where)) for tag, where in exterior]
    found += [(tag, mesh.locate_entities(domain, dimension, where)) for tag, where in interior]
    facets = np.concatenate([part for _, part in found])
    values = np.concatenate([np.full(len(part), tag, dtype=np.int32) for tag, part in found])
    facets, first = np.unique(facets, return_index=True)
    return mesh.meshtags(domain, dimension, facets.astype(np.int32), values[first])
