"""Quantities that may vary in time: a number, or a two-column CSV file."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .errors import InputError
from .tables import read_rows
from .units import to_si


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
        rows = read_rows(key, path)
        if len(rows) < 2 or any(len(row) != 2 for row in rows):
            raise InputError(key, str(path), "must have a head and rows of two columns: time [s], value [unit]")
        units = [head[head.find("[") + 1 : head.find("]")] if "[" in head and "]" in head else None for head in rows[0]]
        if None in units:
            raise InputError(key, str(path), "needs units in its head, like 'time [s], temperature [degC]'")
        columns: list[list[float]] = [[], []]
        for number, row in enumerate(rows[1:], start=2):
            for column, cell, given, wanted in zip(columns, row, units, ("s", unit), strict=True):
                column.append(to_si(key, f"{cell.strip()} {given}", wanted, f"{path}, row {number}"))
        times, values = columns
        if np.any(np.diff(times) <= 0.0):
            row_number = int(np.argmax(np.diff(times) <= 0.0)) + 3
            raise InputError(key, str(path), f"must have increasing times; row {row_number} does not increase")
        return cls(tuple(times), tuple(values), str(path))

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
