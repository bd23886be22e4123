"""Heat that parcels of grains and the nodes of a `ColumnGrid` give each other."""

from typing import Any

import numpy as np

from ..arrays import Booleans, Floats
from .column_grid import ColumnGrid


class ParcelHeat:
    """Parcels outside the droplet as nodes see them: by hat functions of the `free` nodes alone, that add up to 1 for each
    parcel.

    What nodes gain is given to parcels as a change of their temperatures, not by way of the temperature that nodes have: parcels
    that take on the mean of their cell again and again would conduct by themselves, h^2/3 per relaxation time: 8 times the
    bed."""

    def __init__(self, grid: ColumnGrid, weights: Any, free: Booleans, heat_capacity: Floats) -> None:
        self._grid, self._weights, self._free, self._each = grid, weights, free, heat_capacity
        self._sum = np.maximum(grid.at(weights, 1.0 * free), 1e-12)
        self.capacity = self._spread(np.ones(len(heat_capacity)))

    def _spread(self, values: Floats) -> Floats:
        """Sums of values times heat capacity at the nodes, J/K times theirs."""
        return np.asarray(self._free * self._grid.spread(self._weights, self._each * values / self._sum))

    def mean(self, values: Floats) -> Floats:
        """Of the parcels, at the nodes; 0 where there are none."""
        return np.asarray(self._spread(values) / np.maximum(self.capacity, 1e-30))

    def at(self, field: Floats) -> Floats:
        """A field at the parcels."""
        return self._grid.at(self._weights, self._free * field) / self._sum

    def add(self, temperature: Floats, mean: Floats, change: Floats, bounds: tuple[float, float]) -> None:
        """Change temperatures so that the nodes' means change so far (K): those of colder parcels less where they cool down, as
        their distance from the lower bound (K), and of hotter ones less where they warm up."""
        before = temperature.copy()
        for bound, part in zip(bounds, (np.minimum(change, 0.0), np.maximum(change, 0.0)), strict=True):
            off = mean - bound
            factor = np.divide(part, off, out=np.zeros_like(part), where=np.abs(off) > 1e-12)
            temperature += (self._each > 0.0) * self.at(factor) * (before - bound)

    def relax(self, temperature: Floats, part: float) -> None:
        """Take a part of what a parcel's temperature is off those around. A smooth profile, of which means are off by its
        curvature, stays: the operator is applied twice. None goes beyond those around, and what some give, the others get."""
        off = (self._each > 0.0) * (temperature - self.at(self.mean(temperature)))
        twice = off - self.at(self.mean(off))
        less = np.where(off * twice > 0.0, np.sign(off) * np.minimum(np.abs(off), np.abs(twice)), 0.0)
        given, taken = (float((self._each * np.maximum(way, 0.0)).sum()) for way in (less, -less))
        less *= np.where(less > 0.0, min(1.0, taken / max(given, 1e-30)), min(1.0, given / max(taken, 1e-30)))
        temperature -= part * less
