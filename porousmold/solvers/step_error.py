r"""The estimated error of a time step, of temperatures and degrees of cure.

Three stages (`solvers.heating`) have the embedded method of second order with the weights b_i - gamma (1, -2, 1), the only kind
that there is with these stages: their difference dt gamma (k_1 - 2 k_2 + k_3), k_i the stages' rates, is that of the order dt^3.
Backward Euler is compared with the trapezoidal rule: dt/2 (k_1 - k_0), k_0 the rate at the start, of the order dt^2.

The rates are those of the heat, so that the difference of the temperatures e follows from S'(T) e; of stiff parts, the fluid,
that is far more than their error. As usual it is solved for with the stages' own matrix (Hairer, Wanner, Solving Ordinary
Differential Equations II, equation IV.8.20):

    [S'/(gamma dt) + A'] e = S'/(gamma dt) (T - T_embedded),

which leaves slow parts as they are. Where something melts, next to nothing of an error of the heat is one of the temperature:
there the larger one counts of e and of [S(T + e) - S(T)]/C, C the mean capacity between the lowest and the highest temperature
(times of ten layers that melt were up to 0.8 % off by e alone). What is controlled is the root mean square over each region that
stores heat, the bed's beads and every layer of the wall, the largest of them.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Floats, Integers
from ..mesh import ranks
from ..mesh.aliases import Communicator


class StepError(NamedTuple):
    """Estimated error of a step: of `temperature` (K, root mean square of the worst region) and of the degree of `cure`; both are
    of the order `order` in the step's length."""

    temperature: float
    cure: float
    order: int

    def __str__(self) -> str:
        return f"{self.temperature:.2g} K, degree of cure {self.cure:.2g}"

    def plus(self, other: "StepError") -> "StepError":
        """Of two steps in succession, taken as one."""
        return StepError(self.temperature + other.temperature, self.cure + other.cure, min(self.order, other.order))


class RegionNorm:
    """Root mean square of local unknowns over regions, each given by the numbers of its unknowns; the largest of them.

    `weights` are those of the owned unknowns, their volumes.
    """

    def __init__(self, communicator: Communicator, weights: Floats, regions: Sequence[Integers]) -> None:
        self._communicator = communicator
        self._regions = [np.asarray(region)[np.asarray(region) < len(weights)] for region in regions]
        self._weights = [weights[region] for region in self._regions]
        self._sizes = ranks.total(communicator, np.array([part.sum() for part in self._weights]))

    def __call__(self, values: Floats) -> float:
        """The largest root mean square (collective)."""
        pairs = zip(self._weights, self._regions, strict=True)
        squares = ranks.total(self._communicator, np.array([w @ values[region] ** 2 for w, region in pairs]))
        return float(np.sqrt(np.max(squares / np.maximum(self._sizes, 1e-300), initial=0.0)))
