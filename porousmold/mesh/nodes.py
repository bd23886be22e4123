"""Numbers of unknowns in a space, and where nodes and corners of facets are."""

import numpy as np

from ..arrays import Floats, Integers
from . import fenicsx
from .aliases import Mesh, Space


def array_length(space: Space) -> int:
    """Length of the local array of a function of a space, ghosts included."""
    return int((space.dofmap.index_map.size_local + space.dofmap.index_map.num_ghosts) * space.dofmap.index_map_bs)


def leaves(space: Space) -> list[tuple[Space, Integers]]:
    """(space, numbers in the whole) of every scalar or vector part of a space."""
    if space.num_sub_spaces == 0 or space.dofmap.index_map_bs > 1:
        return [(space, np.arange(array_length(space)))]
    return [fenicsx.collapse(space, part) for part in range(space.num_sub_spaces)]


def facet_corners(domain: Mesh, facets: Integers) -> Floats:
    """Places (n, corners, 3) of the corners of local facets."""
    topology, dimension = domain.topology, domain.topology.dim
    topology.create_connectivity(dimension - 1, 0)
    topology.create_connectivity(dimension, 0)
    vertices = topology.connectivity(dimension, 0).array
    place_of = np.zeros((vertices.max() + 1 if vertices.size else 0, 3))
    place_of[vertices] = domain.geometry.x[fenicsx.cell_vertices(domain).ravel()]
    of_facet = topology.connectivity(dimension - 1, 0)
    corners = [of_facet.links(facet) for facet in facets]
    return place_of[np.array(corners)] if corners else np.zeros((0, dimension, 3))


def spans_along_flow(space: Space) -> Floats:
    """x[0] (n, 3) where what each node of a scalar space stands for begins, of the node, and where it ends: halfway to the far
    ends of its cells."""
    place, table = space.tabulate_dof_coordinates()[:, 0], fenicsx.dof_table(space)
    low, high = place.copy(), place.copy()
    ends = place[table]
    np.minimum.at(low, table, ends.min(axis=1)[:, None])
    np.maximum.at(high, table, ends.max(axis=1)[:, None])
    return np.column_stack((0.5 * (place + low), place, 0.5 * (place + high)))
