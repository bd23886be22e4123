"""Quantities that may vary in time, and along the flow: a number, or a CSV file."""

from dataclasses import dataclass

import numpy as np

from .errors import InputError
from .tables import read_columns
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
    def of(cls, columns, unit):
        """Of two `Columns`: time [s], name [unit]. Raises `InputError` if there are more, or times do not increase."""
        if len(columns.names) != 2:
            raise InputError(columns.key, columns.path, "must have two columns: time [s], value [unit]")
        return cls(tuple(columns.times().tolist()), tuple(columns.in_si(1, unit).tolist()), columns.path)

    def __call__(self, time):
        """Value at the time (s)."""
        return float(np.interp(time, self.times, self.values))

    @property
    def content(self):
        """All that the series is, whatever file it came from."""
        return [value for name, value in vars(self).items() if name != "source"]

    @property
    def kinks(self):
        """Times at which the slope changes: steps in time should end there."""
        return self.times if len(self.times) > 1 else ()

    @property
    def range(self):
        """Smallest and largest value."""
        return min(self.values), max(self.values)


@dataclass(frozen=True)
class ProfileSeries(TimeSeries):
    """The same along the flow: `values` at each time are those at `positions` (m from the inlet), linear between them and
    constant beyond."""

    positions: tuple[float, ...] = ()

    def __call__(self, time):
        """Values at the positions, at the time (s)."""
        return np.array([np.interp(time, self.times, column) for column in np.transpose(self.values)])

    @property
    def range(self):
        """Smallest and largest value anywhere."""
        return float(np.min(self.values)), float(np.max(self.values))


def read_series(key, path, unit, *, along=False):
    """`TimeSeries` of a CSV file; with `along` also `ProfileSeries`, of a head `time [s], 0.1 m [unit], 0.2 m [unit], ...` that
    tells the positions.

    Raises `InputError` that names the key, the file and the line.
    """
    columns = read_columns(key, path)
    if not along or len(columns.names) == 2:
        return TimeSeries.of(columns, unit)
    positions = [to_si(key, name, "m", f"{path}, head") for name in columns.names[1:]]
    if np.any(np.diff(positions) <= 0.0):
        raise InputError(key, str(path), "must have columns at increasing positions")
    values = np.column_stack([columns.in_si(number, unit) for number in range(1, len(columns.names))])
    return ProfileSeries(tuple(columns.times().tolist()), tuple(values.tolist()), str(path), tuple(positions))
