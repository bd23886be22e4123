"""Iterations of Newton's method: when they end, and what error they leave."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

LEAST_RATIO = 1e-5


@dataclass
class Contraction:
    """Ratio of two successive updates of Newton's method with a reused Jacobian, from the last system solved that had two; 1
    where there was none. Hairer, Wanner, Solving Ordinary Differential Equations II, section IV.8."""

    ratio: float = 1.0

    def error_after(self, update: float) -> float:
        """Error that an update leaves where it and those to come contract like that, at least by a half (equation IV.8.10)."""
        ratio = min(self.ratio, 0.5)
        return update * ratio / (1.0 - ratio)

    def age(self) -> None:
        """Trust the ratio less in another system, with the same factors or others, than in that it was measured in: as ratio^0.8
        (below equation IV.8.10), at least that of `LEAST_RATIO`: a linear system's is rounding alone."""
        self.ratio = min(max(self.ratio, LEAST_RATIO), 1.0) ** 0.8


@dataclass
class Iterations:
    """Those of one nonlinear solve: `most` at most, until `converged(error)`.

    The error is what `contraction`, which is kept from solve to solve, says that the last update leaves, and without that the
    update. Before an iteration `prepare(update, last)` is called with the two updates before (inf where there was none), and may
    renew the Jacobian; `gives_up(update, last)` ends them, as does an update that is not finite. Of a relative update it is
    `size_of(update)` that counts.
    """

    most: int
    converged: Callable[[float], bool]
    prepare: Callable[[float, float], None] = lambda update, last: None
    gives_up: Callable[[float, float], bool] = lambda update, last: False
    contraction: Contraction | None = None
    size_of: Callable[[float], float] = lambda update: update
    update: float = field(default=np.inf, init=False)
    last: float = field(default=np.inf, init=False)
    taken: int = field(default=0, init=False)
    is_solved: bool = field(default=False, init=False)
    are_over: bool = field(default=False, init=False)

    def __post_init__(self) -> None:
        self.are_over = self.most < 1
        if self.contraction is not None:
            self.contraction.age()

    def begin(self) -> None:
        """Before an iteration."""
        self.prepare(self.update, self.last)

    def note(self, update: float) -> None:
        """After an iteration: take note of its relative `update`, infinite where it failed, and whether it was the last one."""
        update = self.size_of(update)
        self.last, self.update, self.taken = self.update, update, self.taken + 1
        if self.contraction is not None and 0.0 < self.last < np.inf:
            self.contraction.ratio = update / self.last
        error = update if self.contraction is None else self.contraction.error_after(update)
        self.is_solved = self.converged(error)
        is_lost = not self.is_solved and (self.gives_up(update, self.last) or not np.isfinite(update))
        self.are_over = self.is_solved or is_lost or self.taken == self.most
