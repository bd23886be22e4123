"""Integrals and means over the bed's volume of values at the mesh's nodes."""

import functools

import numpy as np
import ufl
from dolfinx import fem

from ..arrays import Floats
from ..equations.coordinates import Coordinates
from ..mesh import fenicsx, ranks
from ..mesh.aliases import Space
from ..mesh.domain import BED, Domain

QUADRATURE = 2
"""Degree of the quadrature of means."""


class BedVolume:
    """The bed of a domain, by the volumes that the owned nodes of a `space` of scalars stand for."""

    def __init__(self, domain: Domain, space: Space, coordinates: Coordinates) -> None:
        self._domain, self._space, self._coordinates = domain, space, coordinates

    def mean(self, function: fem.Function) -> float:
        """Of a function on the mesh (collective)."""
        return self.integral(function.x.array) / self.size

    def integral(self, values: Floats) -> float:
        """Of values at the mesh's nodes, times m3 (collective)."""
        return self._of_all_ranks(float(self._weights @ values[: len(self._weights)]))

    @functools.cached_property
    def size(self) -> float:
        """Of the bed, m3 (collective)."""
        return self._of_all_ranks(float(self._weights.sum()))

    def _of_all_ranks(self, here: float) -> float:
        return float(ranks.total(self._domain.communicator, np.array([here]))[0])

    @functools.cached_property
    def _weights(self) -> Floats:
        """Volumes of the nodes, m3."""
        form = self._coordinates.weight * ufl.TestFunction(self._space)
        form *= self._domain.cell_measure(QUADRATURE)(BED)
        volumes = fem.Function(self._space)
        vector = fenicsx.petsc_vector(volumes)
        fenicsx.assemble_vector(vector, fenicsx.compiled_form(form))
        return np.array(vector.array)
