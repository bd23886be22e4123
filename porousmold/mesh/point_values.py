"""Values of expressions at nodes, quadrature points or in the middle of cells."""

from typing import Any

import basix
import numpy as np
import ufl
from dolfinx import fem

from ..arrays import Floats
from . import fenicsx
from .aliases import Expression, Mesh, Space


def nodal_values(expression: Expression, space: Space) -> Floats:
    """The expression's values at the nodes of a scalar Lagrange space of degree 1; of a vector's entries, a row each."""
    shape = expression.ufl_shape
    target = fenicsx.lagrange_space(space.mesh, 1, *shape) if shape else space
    function = fem.Function(target)
    function.interpolate(fenicsx.compiled_expression(expression, target))
    values = function.x.array.copy()
    return values.reshape(-1, *shape).T if shape else values


class PointValues:
    """Values of expressions at the quadrature points of the cells, or in the cells' middles where no degree is given, as
    functions for forms: `add()` them all, then `compile()`; `renew()` evaluates them together, in a third of the time."""

    def __init__(self, domain: Mesh, quadrature_degree: int | None = None) -> None:
        self._domain, self._degree = domain, quadrature_degree
        self._entries: list[Any] = []
        self._parts: list[tuple[fem.Function, slice, Floats]] = []

    def add(self, expression: Expression) -> Any:
        """A function (of a tensor the tensor of its entries) that has the expression's values once they are renewed."""
        shape = expression.ufl_shape
        entries = [expression[index] if index else expression for index in np.ndindex(*shape)]
        count = len(entries)
        space = (
            fenicsx.cell_constant_space(self._domain, count)
            if self._degree is None
            else fenicsx.quadrature_space(self._domain, self._degree, count)
        )
        function = fem.Function(space)
        table = fenicsx.dof_table(function.function_space)
        places = count * table[:, :, None] + np.arange(count)
        self._parts.append((function, slice(len(self._entries), len(self._entries) + count), places))
        self._entries += entries
        if len(shape) < 2:
            return function
        return ufl.as_tensor(
            [[function[row * shape[1] + column] for column in range(shape[1])] for row in range(shape[0])]
        )

    def compile(self) -> None:
        """Compile what evaluates them all."""
        cell = getattr(basix.CellType, fenicsx.cell_name(self._domain))
        points = basix.make_quadrature(cell, self._degree or 1)[0]
        self._values = fenicsx.evaluate(ufl.as_vector(self._entries), self._domain, points)
        self._shape = -1, len(points), len(self._entries)

    def renew(self) -> None:
        """Evaluate the expressions in all local cells, ghosts included."""
        values = self._values().reshape(self._shape)
        for function, columns, places in self._parts:
            function.x.array[places] = values[:, :, columns]
