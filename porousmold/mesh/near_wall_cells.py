"""Insertion of graded cells at the wall into a mesh that is too coarse there.

Each node of the bed on the interface is duplicated, and the copy is moved into the bed along the wall normal by a fraction of the
height of the first cells. The existing cells of the bed keep the copies. The gap between interface and copies is filled with the
given number of layers of prisms over the facets of the interface: quadrilaterals over segments, hexahedra over quadrilaterals. In
meshes of triangles and tetrahedra each prism is divided into simplices, along diagonals that neighbouring prisms share.
"""

import functools
from itertools import pairwise

import numpy as np

from ..arrays import Booleans, Floats, Integers
from .distances import normals_towards, unit_normals
from .gmsh_model import PlainMesh, lone, sides_of

SHARE = 0.7
"""Of the height of the bed's first cells, which the new cells get."""
LEAST_GAP = 1e-6
"""Of the median, that the gap at a node must have."""
SHARPEST_EDGE = 0.5
"""Least cosine between the wall's normals at a node and their mean: of an edge of 120 degrees between two planes."""


def gaps(mesh: PlainMesh, bed: int, interface: int) -> Floats:
    """Width (m) of the gap that can be opened at each node of the interface (sorted): a share of the height of the bed's first
    cells over any of the wall's facets there, the least of those cells, and nowhere more than its median."""
    nodes, facets = np.unique(mesh.facets[interface]), mesh.facets[interface]
    normals = _facet_normals(mesh, bed, interface)
    heights = np.full(len(mesh.points), np.inf)
    cells = mesh.cells[bed]
    touching = cells[np.isin(cells, nodes).any(axis=1)]
    inner = ~np.isin(touching, nodes)
    cells_at = _rows_at(touching, len(mesh.points))
    for number, facet in enumerate(facets):
        for node in facet:
            rows = cells_at[node]
            depths = (mesh.points[touching[rows]] - mesh.points[node]) @ normals[number]
            heights[node] = min(heights[node], np.min(depths, where=inner[rows], initial=np.inf))
    return SHARE * np.minimum(heights[nodes], np.median(heights[nodes]))


def _rows_at(rows: Integers, count: int) -> list[Integers]:
    """For every node the numbers of the rows that hold it."""
    order = np.argsort(rows, axis=None, kind="stable")
    ends = np.cumsum(np.bincount(rows.ravel(), minlength=count))
    return np.split(order // rows.shape[1], ends[:-1])


def with_cells_at_wall(mesh: PlainMesh, bed: int, interface: int, widths: Floats, fractions: Floats) -> PlainMesh:
    """The mesh with cells between wall and bed, their nodes at these fractions (from 0 to 1) of the gap of `widths`, as `gaps`
    gives them.

    Raises `ValueError` where no gap can be opened: beside an edge too sharp, one that points into the bed, or where the interface
    ends in one plane with another part of the boundary, such as a port.
    """
    nodes = np.unique(mesh.facets[interface])
    if not widths.min() > LEAST_GAP * np.median(widths):
        where = ", ".join(f"{value:.4g}" for value in mesh.points[nodes[np.argmin(widths)]])
        raise ValueError(
            f"its interface ends within a side of the bed, or turns a corner that points into it, at ({where}) m: there is no "
            "room for cells along it"
        )
    normals, least_cosine = _normals(mesh, bed, interface)
    if least_cosine < SHARPEST_EDGE:
        raise ValueError("its wall has an edge too sharp for cells along it")
    moved = widths[:, None] * normals[nodes]
    moved = _along_boundary(mesh, bed, interface, nodes, moved)

    count, levels = len(mesh.points), len(fractions)
    new = [mesh.points[nodes] + fraction * moved for fraction in fractions[1:]]
    points = np.concatenate([mesh.points, *new])
    level = np.tile(np.arange(count), (levels, 1))  # the node of every level over a node of the interface
    for number in range(1, levels):
        level[number, nodes] = count + (number - 1) * len(nodes) + np.arange(len(nodes))

    def filled(bases: Integers) -> Integers:
        is_simplex = mesh.cells[bed].shape[1] == mesh.facets[interface].shape[1] + 1
        if is_simplex:
            bases = np.sort(bases, axis=1)
        return np.concatenate([_prisms(low[bases], high[bases], cut=is_simplex) for low, high in pairwise(level)])

    cells = dict(mesh.cells)
    cells[bed] = np.concatenate([level[-1][mesh.cells[bed]], filled(mesh.facets[interface])])
    facets = dict(mesh.facets)
    for tag in set(facets) - {interface}:
        inside = _of_bed(mesh, bed, facets[tag])
        rims = _rims(facets[tag][inside], mesh.facets[interface])
        parts = [facets[tag][~inside], level[-1][facets[tag][inside]]]
        facets[tag] = np.concatenate([*parts, filled(rims)] if len(rims) else parts)
    return PlainMesh(points, cells, facets)


def _prisms(low: Integers, high: Integers, *, cut: bool) -> Integers:
    """Cells between two copies of facets: (facets, corners) each. Cut, simplices that follow the order of the corners."""
    corners = low.shape[1]
    if cut:
        return np.concatenate([np.hstack([low[:, : k + 1], high[:, k:]]) for k in range(corners)])
    return np.hstack([low, high[:, ::-1] if corners == 2 else high])


def _of_bed(mesh: PlainMesh, bed: int, facets: Integers) -> Booleans:
    """Which of the boundary's facets belong to the bed's cells."""
    return np.isin(facets, np.unique(mesh.cells[bed])).all(axis=1)


def _sides(facets: Integers) -> Integers:
    """What bounds facets, a row each: points of segments, edges of triangles and quadrilaterals."""
    corners = facets.shape[1]
    if corners == 2:
        return facets.reshape(-1, 1)
    following = np.roll(facets, -1, axis=1)
    return np.stack([facets, following], axis=2).reshape(-1, 2)


def _rims(facets: Integers, interface: Integers) -> Integers:
    """Points or edges that facets of the boundary share with those of the interface."""
    of_wall = {tuple(sorted(side)) for side in _sides(interface).tolist()}
    return np.array([side for side in _sides(facets).tolist() if tuple(sorted(side)) in of_wall], dtype=np.int64)


def _facet_normals(mesh: PlainMesh, bed: int, interface: int) -> Floats:
    """Unit normals of the interface's facets, into the bed. Raises `ValueError` for a facet that no cell of the bed has."""
    facets, cells = mesh.facets[interface], mesh.cells[bed]
    cells_at = _rows_at(cells, len(mesh.points))
    behind = [functools.reduce(np.intersect1d, (cells_at[node] for node in facet)) for facet in facets]
    if not all(len(found) for found in behind):
        raise ValueError("its interface must lie beside the bed")
    middles = mesh.points[cells[[found[0] for found in behind]]].mean(axis=1)
    return normals_towards(middles, mesh.points[facets])


def _normals(mesh: PlainMesh, bed: int, interface: int) -> tuple[Floats, float]:
    """At every node of the interface the vector into the bed along which a step of 1 draws back from all its facets by 1 at
    least; and the least cosine between a facet's normal and the mean at its nodes."""
    facets, normals = mesh.facets[interface], _facet_normals(mesh, bed, interface)
    at_nodes = np.zeros_like(mesh.points)
    np.add.at(at_nodes, facets, normals[:, None])
    lengths = np.linalg.norm(at_nodes, axis=1, keepdims=True)
    at_nodes = np.divide(at_nodes, lengths, out=np.zeros_like(at_nodes), where=lengths > 0.0)
    cosines = np.einsum("nck,nk->nc", at_nodes[facets], normals)
    least = np.full(len(mesh.points), 1.0)
    np.minimum.at(least, facets, cosines)
    return at_nodes / np.maximum(least, SHARPEST_EDGE)[:, None], float(cosines.min())


def _along_boundary(mesh: PlainMesh, bed: int, interface: int, nodes: Integers, moved: Floats) -> Floats:
    """The displacements of the nodes, without their parts across the bed's boundary but for the interface, in a group or not: its
    facets stay in their planes."""
    result = np.zeros_like(mesh.points)
    result[nodes] = moved
    facets = _boundary(mesh.cells[bed], mesh.facets[interface])
    facets = facets[np.isin(facets, nodes).any(axis=1)]
    for facet, normal in zip(facets, unit_normals(mesh.points[facets]), strict=True):
        result[facet] -= np.outer(result[facet] @ normal, normal)
    return result[nodes]


def _boundary(cells: Integers, interface: Integers) -> Integers:
    """The facets that one of the cells has alone, but for those of the interface."""
    dimension = 2 if interface.shape[1] == 2 else 3
    facets = sides_of(cells, dimension)
    of_wall = {tuple(sorted(facet)) for facet in interface.tolist()}
    alone = facets[lone(facets)]
    return alone[[tuple(sorted(facet)) not in of_wall for facet in alone.tolist()]]
