"""Domains from gmsh files: physical groups by their names, the distance to the wall, cells at the wall on request."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from dolfinx import fem
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ..arrays import Floats, Integers
from ..errors import InputError
from ..files.units import FARTHEST
from . import fenicsx, gmsh_model
from .aliases import Communicator, GmshModel
from .distances import distance_to_facets, heights_of
from .domain import BED, INLET, INTERFACE, OUTER, OUTLET, SIDE, SYMMETRY, WALL, Domain
from .halving import halved
from .near_wall_cells import gaps, with_cells_at_wall
from .wall_stations import Surface, stations_along_curve, stations_along_surface

BOUNDARY_NAMES = {
    "inlet": INLET, "outlet": OUTLET, "interface": INTERFACE, "outer": OUTER, "symmetry": SYMMETRY, "side": SIDE,
}  # fmt: skip
REQUIRED = ("inlet", "outlet", "interface")
"""Boundaries that every mesh must have."""
PLAIN_WALL = ("wall",)
"""Group of a wall without layers, which a mesh may lack."""


class Finer(NamedTuple):
    """How a mesh gets finer than it is drawn: `cells_at_wall` gives the depths (m, from 0 on) of the nodes of cells that fill a
    gap of given width between wall and bed; after that the cells of a plane mesh are halved in both directions as often as
    `halvings` says."""

    cells_at_wall: Callable[[float], Floats] | None = None
    halvings: int = 0


AS_DRAWN = Finer()


def from_file(
    communicator: Communicator,
    path: Path,
    layers: Sequence[str] = PLAIN_WALL,
    *,
    dimension: int = 2,
    axisymmetric: bool = False,
    finer: Finer = AS_DRAWN,
    trusted: bool = False,
    conventions: gmsh_model.Conventions | None = None,
) -> Domain:
    """Domain of a gmsh file (.geo or .msh) whose physical groups are named bed, as the wall's `layers`, and by `BOUNDARY_NAMES`,
    unless `conventions` say otherwise (collective).

    Bed and layers are physical surfaces, in three dimensions volumes; the boundary's parts are curves, or surfaces. Symmetry,
    if any, lies along x[1] = constant, side along x[2] = constant, and in two dimensions the interface is a curve over x[0]. The
    distance to the wall is that to the nearest facet of the interface, at the nodes. `finer` are the cells that it gets. The
    commands of a .geo file that start processes or open files are run only if it is `trusted`. Raises `InputError` where the
    file cannot be read, holds such a command, lacks a group, or has no place for cells at the wall.
    """
    conventions = conventions or gmsh_model.Conventions()
    known = ("bed", *layers, *BOUNDARY_NAMES)
    if unknown := next((name for name in conventions.groups if name not in known), None):
        raise InputError("geometry.groups", unknown, f"must be one of {', '.join(known)}", str(path))
    if twice := conventions.named_twice(("bed", *layers), BOUNDARY_NAMES):
        allowed = f"must name a group once: {twice[0]!r} is both {twice[1]} and {twice[2]}"
        raise InputError("geometry.groups", dict(conventions.groups), allowed, str(path))
    regions = conventions.named({"bed": BED, **{name: WALL + number for number, name in enumerate(layers)}})
    required = [
        name
        for name, tag in regions.items()
        if tag == BED or tuple(layers) != PLAIN_WALL or conventions.groups.get("wall")
    ]
    boundaries = [
        one for name in BOUNDARY_NAMES if name in (*REQUIRED, *conventions.groups) for one in conventions.in_file(name)
    ]
    problem: str | None = None
    model: GmshModel = None
    facets: dict[int, Floats] = {}
    around = None
    if communicator.rank == 0:
        try:
            model = gmsh_model.open_model(path, dimension, required, boundaries, trusted=trusted)
            plain = _prepared(model, dimension, regions, finer.cells_at_wall, conventions, axisymmetric=axisymmetric)
            for _ in range(finer.halvings):
                plain = halved(plain)
            gmsh_model.replace_model(model, dimension, plain)
            facets = {tag: plain.points[nodes][:, :, :dimension] for tag, nodes in plain.facets.items()}
            around = surface_of(plain) if dimension == 3 else None
        except Exception as error:  # gmsh raises plain Exception for everything
            problem = str(error)
    problem, facets, around = communicator.bcast((problem, facets, around))
    try:
        if problem is not None:
            raise InputError("geometry.mesh", str(path), f"is no mesh that can be used: {problem}")
        domain, cell_tags, facet_tags = fenicsx.mesh_of_gmsh(model, communicator, dimension)
    finally:
        if model is not None:
            gmsh_model.close_model()
    space = fenicsx.lagrange_space(domain)
    distance = fem.Function(space)
    distance.x.array[:] = distance_to_facets(space.tabulate_dof_coordinates()[:, :dimension], facets[INTERFACE])
    length, stations = stations_along_curve(facets) if around is None else stations_along_surface(facets, around)
    return Domain(domain, cell_tags, facet_tags, axisymmetric, distance, length, stations, layers=len(layers))


def _prepared(
    model: GmshModel,
    dimension: int,
    regions: Mapping[str, int],
    cells_at_wall: Callable[[float], Floats] | None,
    conventions: gmsh_model.Conventions,
    *,
    axisymmetric: bool,
) -> gmsh_model.PlainMesh:
    """What a model has of the groups, in m, with the cells at the wall if they are asked for."""
    plain = gmsh_model.read_model(model, dimension, regions, conventions.named(BOUNDARY_NAMES))
    plain.points *= conventions.scale
    if conventions.join_nodes:
        plain = joined(plain)
    require_own_parts(plain.cells, {tag: name for name, tag in regions.items()}, "cells")
    require_own_parts(plain.facets, {tag: name for name, tag in BOUNDARY_NAMES.items()}, "sides of cells")
    require_place(plain, dimension, axisymmetric=axisymmetric)
    require_connection(plain, {tag: name for name, tag in regions.items()})
    if cells_at_wall is not None:
        widths = gaps(plain, BED, INTERFACE)
        depths = cells_at_wall(float(np.median(widths)))
        if len(depths) > 2:  # else the first cells are as low as they have to be
            plain = with_cells_at_wall(plain, BED, INTERFACE, widths, depths / depths[-1])
    return plain


SAME_PLACE = 1e-7
"""Distance of nodes, over the extent of their mesh, below which they are one where that is asked for."""
TOUCHING = 1e-3
"""Distance of sides of two regions, over their height, below which they are meant to be one: the sides of flat cells beside an
interface come nearer to it than a part of their length."""


def require_own_parts(parts: Mapping[int, Integers], names: Mapping[int, str], kind: str) -> None:
    """Raise `ValueError` where two groups, by the tags of their `names`, share elements (each by its corners) of a kind."""
    rows = np.sort(np.concatenate(list(parts.values())), axis=1)
    owner = np.concatenate([np.full(len(part), tag) for tag, part in parts.items()])
    element = np.unique(rows, axis=0, return_inverse=True)[1].reshape(-1)
    owners = np.unique(np.column_stack([element, owner]), axis=0)
    twice = np.flatnonzero(np.diff(owners[:, 0]) == 0)
    if len(twice):
        one, other = (names[int(owners[twice[0] + number, 1])] for number in (0, 1))
        raise ValueError(f"its groups {one!r} and {other!r} share {len(twice)} {kind}: each belongs to one of them")


def require_place(mesh: gmsh_model.PlainMesh, dimension: int, *, axisymmetric: bool) -> None:
    """Raise `ValueError` for nodes that are nowhere, a plane mesh outside the x-y plane, and an axisymmetric one whose flow is
    not along x."""
    if not (np.abs(mesh.points) < FARTHEST).all():
        raise ValueError(f"it has a node that is not within {FARTHEST:g} m")
    extent = np.ptp(mesh.points, axis=0)
    if dimension == 2 and extent[2] > 1e-9 * extent.max():
        in_x_z = extent[1] <= 1e-9 * extent.max()
        raise ValueError("it does not lie in the x-y plane" + (" but in the x-z plane: turn it" if in_x_z else ""))
    if not axisymmetric:
        return
    if mesh.points[:, 1].min() < -1e-6 * extent.max():
        raise ValueError("it reaches below y = 0, which is the axis of an axisymmetric mesh")
    across = np.ptp(mesh.points[np.unique(mesh.facets[INLET])], axis=0)
    if across[1] < across[0]:
        raise ValueError(
            "its inlet does not lie across x: the axis of an axisymmetric mesh is y = 0, and its flow along x"
        )


def require_connection(mesh: gmsh_model.PlainMesh, names: Mapping[int, str]) -> None:
    """Raise `ValueError` where regions, by the tags of their `names`, lie side by side without common nodes:
    no heat would pass."""
    dimension = 2 if next(iter(mesh.facets.values())).shape[1] == 2 else 3
    sides, owners = [], []
    for tag, cells in mesh.cells.items():
        corners = gmsh_model.sides_of(cells, dimension)
        sides.append(corners)
        owners.append(np.full(len(corners), tag))
    corners, owner = np.concatenate(sides), np.concatenate(owners)
    single = gmsh_model.lone(corners)
    corners, owner = corners[single], owner[single]
    places = mesh.points[corners][:, :, :dimension]
    middles, heights = places.mean(axis=1), heights_of(places)
    for tag in np.unique(owner)[:-1]:
        own, others = owner == tag, owner > tag
        near = distance_to_facets(middles[own], places[others]) < TOUCHING * heights[own]
        if near.any():
            other = names[int(owner[others][cKDTree(middles[others]).query(middles[own][near][0])[1]])]
            where = ", ".join(f"{value:.4g}" for value in middles[own][near][0])
            raise ValueError(
                f"{names[int(tag)]} and {other} have no common nodes at {int(near.sum())} sides of cells, as at ({where}) m: "
                "mesh them as one geometry (gmsh: Coherence; or BooleanFragments), or where their nodes lie at the same places, "
                "geometry.join_nodes = true"
            )


def joined(mesh: gmsh_model.PlainMesh) -> gmsh_model.PlainMesh:
    """The mesh with one node for all that lie within `SAME_PLACE` of its extent, and every facet once."""
    reach = SAME_PLACE * float(np.ptp(mesh.points, axis=0).max())
    pairs = cKDTree(mesh.points).query_pairs(reach, output_type="ndarray")
    count = len(mesh.points)
    graph = coo_matrix((np.ones(len(pairs)), tuple(pairs.T)), shape=(count, count))
    node = connected_components(graph, directed=False)[1]
    _, first, inverse = np.unique(node, return_index=True, return_inverse=True)
    cells = {tag: inverse[part] for tag, part in mesh.cells.items()}
    facets = {}
    for tag, part in mesh.facets.items():
        new = inverse[part]
        facets[tag] = new[np.unique(np.sort(new, axis=1), axis=0, return_index=True)[1]]
    return gmsh_model.PlainMesh(mesh.points[first], cells, facets)


def surface_of(mesh: gmsh_model.PlainMesh) -> Surface:
    """Of the bed in three dimensions. Raises `ValueError` for an interface elsewhere."""
    cells = mesh.cells[BED]
    if not np.isin(mesh.facets[INTERFACE], cells).all():
        raise ValueError("its interface must lie beside the bed")
    sides = gmsh_model.sides_of(cells, 3)
    single = gmsh_model.lone(sides)
    behind = mesh.points[cells[single // (len(sides) // len(cells))]].mean(axis=1)
    return Surface(mesh.points[sides[single]], behind, np.isin(sides[single], mesh.facets[INTERFACE]).all(axis=1))
