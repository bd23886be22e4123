"""Parts of a flow's unknowns (velocity, pressure, each unknown of the turbulence): their sizes, and how far updates move them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from dolfinx import fem

from ..arrays import Floats, Integers
from ..mesh import ranks

TRACE_OF_TURBULENCE = 1e-3
"""k over the reference speed squared that counts as none: its eddies are no more viscous than the fluid."""
LEAST_VALUE = 1e-6
"""Scaled velocity or pressure that counts as none."""


class Unknowns(NamedTuple):
    """Local numbers of the unknowns of each part of a system: velocity (and pressure), and the turbulence's one by one.

    All but the pressure evolve in a false transient: it belongs to its velocity, however short the step.
    """

    motion: Sequence[Integers]
    turbulence: Sequence[Integers]

    @property
    def parts(self) -> list[Integers]:
        """Those of each part."""
        return [*self.motion, *self.turbulence]

    @property
    def traces(self) -> Floats:
        """Scaled size below which each part counts as 0."""
        return np.array([LEAST_VALUE] * len(self.motion) + [TRACE_OF_TURBULENCE] * len(self.turbulence))

    @property
    def evolving(self) -> list[int]:
        """Numbers of the parts that evolve in a false transient."""
        return [0, *range(len(self.motion), len(self.parts))]

    @property
    def of_turbulence(self) -> Integers:
        """All of the turbulence."""
        return np.concatenate([np.empty(0, int), *self.turbulence])

    @property
    def kinetic_energy(self) -> Integers:
        """Those of k, the first of the turbulence."""
        return self.turbulence[0] if self.turbulence else np.empty(0, int)


class PartSizes:
    """Sizes of the parts `numbers` of a scaled `unknown`, of which a rank owns the first `owned_size` values (all collective)."""

    def __init__(self, unknown: fem.Function, numbers: Unknowns, owned_size: int) -> None:
        self._unknown, self._evolving, self._kinetic_energy = unknown, numbers.evolving, numbers.kinetic_energy
        self._communicator = unknown.function_space.mesh.comm
        # ghosts are left out, as other ranks count them
        owned = [part[part < owned_size] for part in numbers.parts]
        self._velocity = owned[0]
        self._owned, self._lengths = np.concatenate(owned), [len(part) for part in owned]
        self._part_of_owned = np.repeat(np.arange(len(owned)), self._lengths)
        self._least = numbers.traces**2 * np.maximum(ranks.total(self._communicator, self._lengths), 1.0)

    def updates(self, before: Floats, parts: Sequence[int] = ()) -> tuple[float, float]:
        """Update since the array `before`, relative to the geometric mean of then and now, so that growth shows like decay.

        Of all unknowns of the parts (numbers; default: all), and the largest of a part, as k and epsilon hardly count in that of
        all.
        """
        now, old = self._unknown.x.array[self._owned], before[self._owned]
        with np.errstate(
            over="ignore", invalid="ignore"
        ):  # of an iterate that runs away: its update is infinite or no number
            squares = ranks.total(self._communicator, [self._squares(values) for values in (now - old, now, old)])
            changes, values, old_values, least = np.vstack([squares, self._least])[:, parts or slice(None)]
            of_all = np.sqrt(max(values.sum(), least.sum())) * np.sqrt(max(old_values.sum(), least.sum()))
            of_parts = np.sqrt(np.maximum(values, least)) * np.sqrt(np.maximum(old_values, least))
            return float(np.sqrt(changes.sum() / of_all)), float(np.sqrt(np.max(changes / of_parts)))

    def largest_update(self, before: Floats) -> float:
        """That of the part that changes most of those that evolve, since the array `before`."""
        return self.updates(before, self._evolving)[1]

    def largest_local_update(self, before: Floats) -> float:
        """Largest change of a component of the velocity at a node since the array `before`, relative to the largest there is."""
        now, old = self._unknown.x.array[self._velocity], before[self._velocity]
        change, size = (ranks.largest_magnitude(self._communicator, values) for values in (now - old, now))
        return change / max(size, LEAST_VALUE)

    def norms(self, values: Floats) -> list[float]:
        """Norms of the parts of an array like the unknown's."""
        return np.sqrt(ranks.total(self._communicator, self._squares(values[self._owned]))).tolist()

    def _squares(self, values: Floats) -> Floats:
        """Sum of squares of each part of this rank's values, which are those of `_owned`."""
        return np.bincount(self._part_of_owned, weights=values * values, minlength=len(self._lengths)).astype(float)

    @property
    def range_of_kinetic_energy(self) -> tuple[float, float]:
        """Lowest and largest k."""
        return ranks.extremes(self._communicator, self._unknown.x.array[self._kinetic_energy])
