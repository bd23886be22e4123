"""Means at the nodes of what the cells around them have there, weighted by their volumes in the bed."""

import functools

import numpy as np
import ufl
from dolfinx import fem

from ..arrays import Floats
from ..laws.functions import Value
from ..mesh import fenicsx
from ..mesh.aliases import Form, Space
from ..mesh.deferred_forms import DeferredForm
from ..mesh.domain import BED, Domain


class NodalMeans:
    """Means over the bed at the nodes of a scalar `space`; `weight` is that of the coordinates at the nodes (all collective)."""

    def __init__(self, domain: Domain, space: Space, weight: Value) -> None:
        self._factor, self._nodes = weight * ufl.TestFunction(space), domain.nodal_measure()(BED)
        self._space = space
        self._volume_form = DeferredForm(self.form(fem.Constant(domain.mesh, 1.0)))

    def form(self, expression: Value) -> Value:
        """Form of an expression at the nodes, times their volumes."""
        return expression * self._factor * self._nodes

    @functools.cached_property
    def volumes(self) -> Floats:
        """Of the bed at each owned node, m3; tiny where there is none."""
        sums = fem.Function(self._space)
        vector = fenicsx.petsc_vector(sums)
        fenicsx.assemble_vector(vector, self._volume_form.form)
        return np.maximum(vector.array.copy(), 1e-300)

    def take(self, form: Form, result: fem.Function) -> None:
        """Have `result` be the means of what a compiled `form` is of."""
        vector = fenicsx.petsc_vector(result)
        fenicsx.assemble_vector(vector, form)
        vector.array[:] /= self.volumes
        result.x.scatter_forward()
