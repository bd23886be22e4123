"""Quantities that may vary in time: a number, or a two-column CSV file."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .errors import InputError
from .tables import read_columns


@dataclass(frozen=True)
class TimeSeries:
    """Piecewise linear in time, constant beyond its ends. `times` in s, `values` in SI; `source` is the file, if any."""

    times: tuple[float, ...]
    values: tuple[float, ...]
    source: str | None = None

    @classmethod
    def constant(cls, value):
        """The same value at all times."""
        return cls((0.0,), (value,))

    @classmethod
    def read(cls, key, path, unit):
        """From a CSV file with a head `time [s], name [unit]` and increasing times.

        Raises `InputError` that names the key, the file and the line.
        """
        path = Path(path)
        columns = read_columns(key, path)
        if len(columns.names) != 2:
            raise InputError(key, str(path), "must have two columns: time [s], value [unit]")
        return cls(tuple(columns.times().tolist()), tuple(columns.in_si(1, unit).tolist()), str(path))

    def __call__(self, time):
        """Value at the time (s)."""
        return float(np.interp(time, self.times, self.values))

    @property
    def kinks(self):
        """Times at which the slope changes: steps in time should end there."""
        return self.times if len(self.times) > 1 else ()

    @property
    def range(self):
        """Smallest and largest value."""
        return min(self.values), max(self.values)
