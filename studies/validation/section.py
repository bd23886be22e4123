"""Half the section of a gap or a tube with linear elements: sums, means and lateral conduction."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


@dataclass(frozen=True)
class Section:
    """`nodes` (m) from the middle to the wall. About an axis, areas and perimeters are per radian."""

    nodes: Array
    axisymmetric: bool

    @cached_property
    def weights(self) -> Array:
        """Areas of the nodes: their sum is that of the section."""
        r, h = (self.nodes if self.axisymmetric else np.ones_like(self.nodes)), np.diff(self.nodes)
        weights = np.zeros_like(self.nodes)
        weights[:-1] += h * (2.0 * r[:-1] + r[1:]) / 6.0
        weights[1:] += h * (r[:-1] + 2.0 * r[1:]) / 6.0
        return weights

    @property
    def perimeter(self) -> float:
        """Of the wall."""
        return float(self.nodes[-1]) if self.axisymmetric else 1.0

    def mean(self, values: Array) -> float:
        """Mean over the section."""
        return float(np.sum(self.weights * values) / np.sum(self.weights))

    def stiffness(self, conductivity: Array) -> Array:
        """Matrix of lateral conduction."""
        r = self.nodes if self.axisymmetric else np.ones_like(self.nodes)
        across = 0.25 * (conductivity[1:] + conductivity[:-1]) * (r[1:] + r[:-1]) / np.diff(self.nodes)
        matrix, i = np.zeros((len(r), len(r))), np.arange(len(r) - 1)
        matrix[i, i] += across
        matrix[i + 1, i + 1] += across
        matrix[i, i + 1] -= across
        matrix[i + 1, i] -= across
        return matrix
