"""Functions on a mesh whose two ends are alike, mirrored along the flow."""

import numpy as np
from dolfinx import fem
from scipy.spatial import cKDTree

from ..arrays import Floats, Integers
from .aliases import Communicator, Space
from .domain import Domain
from .nodes import leaves

SAME_PLACE = 1e-9
"""Distance over the length of the bed within which a node is the image of another one."""


class Mirror:
    """Mirrors functions of any space with values at places; each place must have its image in the mesh.

    The nodes' order is gathered once for each space (collective); arrays go through rank 0.
    """

    def __init__(self, domain: Domain) -> None:
        self._length = domain.length
        self._spaces: list[tuple[Space, list[_Part]]] = []

    def __call__(self, *functions: fem.Function) -> None:
        """Mirror the values of functions in place; the components of vectors stay as they are (collective)."""
        for function in functions:
            for part in self._parts(function.function_space):
                part.mirror(function.x.array)
            function.x.scatter_forward()

    def vectors(self, *functions: fem.Function) -> None:
        """Mirror functions whose values are vectors, their components along the flow turned round (collective)."""
        self(*functions)
        for function in functions:
            function.x.array[:: function.function_space.dofmap.index_map_bs] *= -1.0

    def _parts(self, space: Space) -> list["_Part"]:
        for known, parts in self._spaces:
            if known is space or known == space:
                return parts
        parts = [_Part(leaf, numbers, self._length) for leaf, numbers in leaves(space)]
        self._spaces.append((space, parts))
        return parts


class _Part:
    """The scalar or vector part of a space with some `numbers` in the whole."""

    def __init__(self, space: Space, numbers: Integers, length: float) -> None:
        self._communicator: Communicator = space.mesh.comm
        size, owned = space.dofmap.index_map_bs, space.dofmap.index_map.size_local
        self._numbers = numbers[: owned * size].reshape(owned, size)
        places = self._communicator.gather(space.tabulate_dof_coordinates()[:owned])
        self._image: Integers | None = None
        self._counts: list[int] = []
        if places is not None:
            self._counts = [len(part) for part in places]
            everywhere = np.concatenate(places)
            mirrored = everywhere * [-1.0, 1.0, 1.0] + [length, 0.0, 0.0]
            distances, self._image = cKDTree(everywhere).query(mirrored)
            assert distances.max(initial=0.0) < SAME_PLACE * length, "the ends of the mesh are not alike"

    def mirror(self, array: Floats) -> None:
        pieces = self._communicator.gather(array[self._numbers])
        if pieces is not None:
            whole = np.concatenate(pieces)[self._image]
            pieces = np.split(whole, np.cumsum(self._counts)[:-1])
        array[self._numbers] = self._communicator.scatter(pieces)
