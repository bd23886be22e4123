r"""Functions at the corners of a cell, and enthalpies interpolated between them.

With N_c the corners' own functions, linear or multilinear, and f_c a function's values at the corners, what a cell stores is
written with

    sum_c N_c h(f_c),

in cells whose storage is lumped at the nodes, sum_c N_c h(f_c) v_c, and in all others, sum_c N_c h(f_c) v: both have the same
integral, so that a cell that changes from one to the other keeps its heat. Lumping by the capacity at quadrature points couples
the nodes of a cell within which h bends: a front of beads that melt over 10 K left its bounds by 17 K. A linear h is the same
either way.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import ufl

from ..laws.functions import Value
from ..mesh.aliases import Mesh

Law: TypeAlias = Callable[[Value], Value]
"""A value as a function of another one, as an enthalpy of a temperature."""


class Corner(NamedTuple):
    """The corner's own `weight` N_c, and the values of functions there."""

    weight: Value
    values: tuple[Value, ...]


class Corners(ABC):
    """Those of a cell."""

    @abstractmethod
    def of(self, *functions: Value) -> list[Corner]:
        """Values of functions, linear or multilinear in the cell, at its corners."""

    def interpolated(self, law: Law, function: Value) -> Value:
        """sum N_c h(f_c)."""
        return sum(corner.weight * law(*corner.values) for corner in self.of(function))

    def lumped(self, law: Law, function: Value, test: Value) -> Value:
        """sum N_c h(f_c) v_c."""
        return sum(weight * law(value) * at_corner for weight, (value, at_corner) in self.of(function, test))


@dataclass(frozen=True)
class CornersOfBox(Corners):
    """Of an interval, quadrilateral or hexahedron: half a side (a vector, m), constant in the cell, and the place along it from
    -1 to 1, of each of the `axes`."""

    axes: Sequence[tuple[Value, Value]]

    def of(self, *functions: Value) -> list[Corner]:
        corners = [Corner(1.0, functions)]
        for half, place in self.axes:
            corners = [
                Corner(
                    0.5 * (1.0 + end * place) * weight,
                    tuple(f + (end - place) * ufl.dot(half, ufl.grad(f)) for f in values),
                )
                for weight, values in corners
                for end in (-1.0, 1.0)
            ]
        return corners


@dataclass(frozen=True)
class CornersOfSimplex(Corners):
    """Of a triangle or tetrahedron of a `mesh`, `from_middle` a place's vector from the cell's middle (m)."""

    mesh: Mesh
    from_middle: Value

    def of(self, *functions: Value) -> list[Corner]:
        jacobian, inverse, dimension = ufl.Jacobian(self.mesh), ufl.JacobianInverse(self.mesh), self.mesh.geometry.dim
        sides = [jacobian[:, i] for i in range(dimension)]
        gradients = [inverse[i, :] for i in range(dimension)]
        middle = sum(sides[1:], sides[0]) / (dimension + 1.0)
        places = [-middle, *(side - middle for side in sides)]
        gradients = [-sum(gradients[1:], gradients[0]), *gradients]
        return [
            Corner(
                1.0 / (dimension + 1.0) + ufl.dot(gradient, self.from_middle),
                tuple(f + ufl.dot(ufl.grad(f), place - self.from_middle) for f in functions),
            )
            for place, gradient in zip(places, gradients, strict=True)
        ]
