"""Values of fields at chosen points and places, the same on every rank."""

import numpy as np

from . import fenicsx


class PointProbe:
    """Evaluates functions at fixed points (rows x, y in m); each point belongs to the lowest rank that finds it."""

    def __init__(self, domain, points):
        self._communicator = domain.communicator
        coordinates = np.zeros((len(points), 3))
        coordinates[:, :2] = points
        cells = fenicsx.containing_cells(domain.mesh, coordinates)
        rank, size = self._communicator.rank, self._communicator.size
        finders = np.array(self._communicator.allgather(np.where(cells >= 0, rank, size))).min(axis=0)
        if np.any(finders == size):
            missing = np.asarray(points)[finders == size][0]
            raise ValueError(f"the point ({missing[0]:g}, {missing[1]:g}) m lies outside the mesh")
        self._mine = np.flatnonzero(finders == rank)
        self._points, self._cells = coordinates[self._mine], cells[self._mine].astype(np.int32)
        self._count = len(points)

    def __call__(self, function):
        """Values at the points, one row a point, on every rank."""
        size = int(np.prod(function.ufl_shape)) if function.ufl_shape else 1
        mine = np.zeros((self._count, size))
        if len(self._mine):
            mine[self._mine] = function.eval(self._points, self._cells).reshape(len(self._mine), -1)
        return self._communicator.allreduce(mine)


class Gathered:
    """Nodes and cells of the whole mesh on rank 0 (on other ranks empty), for pictures.

    `nodes` are (n, 2) in m, `cells` rows of node numbers in the order of dolfinx, `in_bed` flags of the cells.
    """

    def __init__(self, domain, space, bed_cells):
        communicator = domain.communicator
        index_map = space.dofmap.index_map
        owned = index_map.size_local
        coordinates = space.tabulate_dof_coordinates()[:owned, :2]
        local_cells = domain.mesh.topology.index_map(2).size_local
        table = fenicsx.dof_table(space)[:local_cells]
        numbers = index_map.local_to_global(table.ravel().astype(np.int32)).reshape(table.shape)
        flags = np.zeros(local_cells, dtype=bool)
        flags[bed_cells[bed_cells < local_cells]] = True
        self._owned, self._communicator = owned, communicator
        parts = communicator.gather((coordinates, numbers, flags))
        if communicator.rank == 0:
            self.nodes, self.cells, self.in_bed = (np.concatenate(part) for part in zip(*parts, strict=True))

    def values(self, array):
        """Owned nodal values of all ranks in the order of `nodes`, on rank 0; None elsewhere."""
        parts = self._communicator.gather(np.asarray(array[: self._owned]))
        return None if parts is None else np.concatenate(parts)
