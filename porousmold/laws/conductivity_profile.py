"""Tabulated conductivity of a bed at rest against wall distance: CSV files, such as those of `porousmold conductivity`."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..files.tables import read_columns
from .conductivity import LocalBed
from .functions import Value, maximum

HEAD = ("wall_distance", "conductivity")


@dataclass(frozen=True)
class ConductivityProfile:
    """Conductivity (W/m/K, of bed and fluid together) at increasing wall distances (m): straight lines between them, constant
    before the first and after the last."""

    distances: tuple[float, ...]
    conductivities: tuple[float, ...]

    @classmethod
    def read(cls, key: str, path: Path) -> "ConductivityProfile":
        """From a CSV file with the columns `wall_distance [m]` and `conductivity [W/(m*K)]`, or in other units.

        Raises `InputError` for other columns, distances that are negative or do not increase, or conductivities <= 0.
        """
        columns = read_columns(key, path)
        if tuple(columns.names[:2]) != HEAD:
            raise InputError(key, str(path), "must begin with the head wall_distance [m],conductivity [W/(m*K)]")
        distances, conductivities = columns.in_si(0, "m"), columns.in_si(1, "W/(m*K)")
        if distances[0] < 0.0 or np.any(np.diff(distances) <= 0.0):
            raise InputError(key, str(path), "must have wall distances >= 0 that increase")
        if not np.all(conductivities > 0.0):
            raise InputError(key, str(path), "must have conductivities > 0")
        return cls(tuple(map(float, distances)), tuple(map(float, conductivities)))

    def __call__(self, bed: LocalBed) -> Value:
        """Conductivity at the bed's wall distance, W/m/K; numbers, arrays or UFL."""
        found, slope = self.conductivities[0] + 0.0 * bed.wall_distance, 0.0
        slopes = np.diff(self.conductivities) / np.diff(self.distances)
        for distance, next_slope in zip(self.distances, [*slopes, 0.0], strict=True):
            found += (float(next_slope) - slope) * maximum(bed.wall_distance - distance, 0.0)
            slope = float(next_slope)
        return found
