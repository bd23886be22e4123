"""Quantities that may vary in time, and along the flow: a number, or a CSV file."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Floats, Integers
from ..errors import InputError, first_line
from ..files.tables import Columns, column_name, existing_file, read_columns, time_offset
from ..files.units import to_si

SAMPLES, FINEST_SAMPLE, SAMPLING_TOLERANCE = 200, 0.05, 1e-4
"""First samples of a function, the interval (s) below which a change counts as a jump, and the part of its range that straight
lines between samples may miss."""


MOST_ROWS = 400
"""Rows of a series beyond which those that lie closer than an even spacing of so many may be replaced by means over that."""
LITTLE, LITTLE_ALONE = 0.02, 0.1
"""Of all that a series says, a change between rows that are replaced by their mean: in the product of two such series, flow times
temperature, its square is lost at most, and of one alone an eighth of its square, by the drag; a pulse that is smaller and
shorter than such an interval is lost."""
STRAIGHT = 1e-13
"""Of that, by which a row that says nothing may lie beside the line through its neighbours."""
FASTEST = 0.1
"""Seconds within which nothing that follows the series, the smallest bead neither, follows a change."""


OTHER_QUANTITIES = (
    *("inlet_temperature", "outlet_temperature", "wall_temperature", "ambient_temperature", "bead_temperature"),
    *("fluid_temperature", "pressure_drop", "outlet_pressure", "inlet_pressure", "inlet_velocity", "outer_heat_flux"),
)
"""Names of columns that belong to one quantity alone."""


def _name_of(function: object) -> str:
    return str(getattr(function, "__name__", function))


@dataclass(frozen=True)
class TimeSeries:
    """Piecewise linear in time, constant beyond its ends. `times` in s, `values` in SI; `source` is the file, if any.

    `corners` are the times at which the slope changes where these are not all `times`, as of a smooth function; `gaps` is how
    many values the file lacked, which are interpolated; `channel` is the table {"file", "column", "unit", "time_offset"} that
    named it.
    """

    times: tuple[float, ...]
    values: tuple[Any, ...]
    source: str | None = None
    corners: tuple[float, ...] | None = None
    gaps: int = 0
    channel: Mapping[str, str] | None = None

    @classmethod
    def constant(cls, value: float) -> "TimeSeries":
        """The same value at all times."""
        return cls((0.0,), (value,))

    @classmethod
    def of_pair(cls, key: str, pair: Any, unit: str, where: str | None) -> "TimeSeries":
        """Of (times in s, values); numbers, or texts with a unit. Raises `InputError` where they do not match or increase."""
        try:
            times, values = (list(part) for part in pair)
        except (TypeError, ValueError) as error:
            raise InputError(key, str(pair), "must be a pair of lists: times, values", where) from error
        seconds = tuple(to_si(key, time, "s", where) for time in times)
        if len(times) != len(values) or not times or np.any(np.diff(seconds) <= 0.0):
            allowed = "must be a pair of lists of one length, the times increasing"
            raise InputError(key, f"{len(times)} times, {len(values)} values", allowed, where)
        return cls(seconds, tuple(to_si(key, value, unit, where) for value in values))

    @classmethod
    def sampled(cls, key: str, function: Callable[[float], float], end: float) -> "TimeSeries":
        """Of a function of the time (s) from 0 to `end`, to 1e-4 of its range: its samples are no corners, its jumps are.

        Raises `InputError` where the function raises or gives no finite number.
        """

        def value(time: float) -> float:
            try:
                result = float(function(time))
            except Exception as error:
                allowed = f"fails at {time:g} s: {first_line(error)}"
                raise InputError(key, f"the function {_name_of(function)}", allowed) from error
            if not np.isfinite(result):
                raise InputError(key, f"the function {_name_of(function)}", f"gives {result} at {time:g} s")
            return result

        times = [0.0, *np.geomspace(FINEST_SAMPLE, end, SAMPLES)]
        samples = {float(time): value(float(time)) for time in times}
        tolerance = SAMPLING_TOLERANCE * max(max(samples.values()) - min(samples.values()), 1e-300)
        corners = []
        intervals = list(zip(sorted(samples)[:-1], sorted(samples)[1:], strict=True))
        while intervals:
            first, last = intervals.pop()
            middle = 0.5 * (first + last)
            now = value(middle)
            if abs(now - 0.5 * (samples[first] + samples[last])) <= tolerance:
                continue
            samples[middle] = now
            if last - first < FINEST_SAMPLE:
                corners += [first, last]
            else:
                intervals += [(first, middle), (middle, last)]
        ordered = sorted(samples)
        return cls(tuple(ordered), tuple(samples[time] for time in ordered), None, tuple(sorted(set(corners))))

    def as_value(self) -> Any:
        """What a TOML file would have: the file's name, its channel, a number, or the pair of times and values."""
        if self.channel is not None:
            return {**self.channel, "file": self.source}
        if self.source or len(self.times) == 1:
            return self.source or self.values[0]
        return [list(self.times), list(self.values)]

    @classmethod
    def of(cls, columns: Columns, unit: str) -> "TimeSeries":
        """Of two `Columns`: time [s], name [unit]. Raises `InputError` if there are more, or times do not increase."""
        if len(columns.names) != 2:
            several = ", ".join(map(repr, columns.names[1:]))
            allowed = "must have two columns: time [s], value [unit]"
            allowed += f'; of {several} name one, {{ file = "...", column = "..." }}' if several else ""
            raise InputError(columns.key, columns.path, allowed)
        times, values = columns.times(), columns.in_si(1, unit)
        return cls(tuple(times.tolist()), tuple(values.tolist()), columns.path, gaps=columns.gaps)

    def thinned(self, end: float, scale: float, little: float = LITTLE) -> "TimeSeries":
        """The same up to a time `end` (s), with `MOST_ROWS` rows or not many more where it changes by less than the part `little`
        of a `scale` between them, or within `FASTEST`: what changes faster is averaged, so that its integral over time stays.

        Bed and wall follow the integral; a step of the simulation for every row of a fast logger's noise would bring nothing.
        Jumps, larger pulses and reversals are no noise, and stay as they are. Rows on the line through their neighbours go.
        """
        if self.corners is not None or len(self.times) <= 2:
            return self
        times, values = np.array(self.times), np.array(self.values).reshape(len(self.times), -1)
        bent = _bends(times, values, STRAIGHT * scale)
        times, values = times[bent], values[bent]
        if len(times) > MOST_ROWS:
            last = min(int(np.searchsorted(times, end)), len(times) - 1)
            times, values = times[: last + 1], values[: last + 1]
            kept = _ends_of_windows(times, values, little * scale)
            times, values = times[kept], _means(times, values, kept)
        if len(times) == len(self.times):
            return self
        rows = tuple(map(tuple, values.tolist())) if np.ndim(self.values) > 1 else tuple(values[:, 0].tolist())
        return replace(self, times=tuple(times.tolist()), values=rows)

    def __call__(self, time: float) -> float:
        """Value at the time (s)."""
        return float(np.interp(time, self.times, self.values))

    @property
    def content(self) -> list[Any]:
        """All that the series is, whatever file it came from."""
        return [value for name, value in vars(self).items() if name not in ("source", "channel")]

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times at which the slope changes: steps in time should end there."""
        if self.corners is not None:
            return self.corners
        return self.times if len(self.times) > 1 else ()

    def kinks(self, scale: float) -> dict[float, float]:
        """By how much the slope changes at each of the `breakpoints`, over a `scale` of the values (1/s); a jump of a function
        counts as infinite."""
        if self.corners is not None or len(self.times) < 2:
            return dict.fromkeys(self.breakpoints, np.inf)
        values = np.array(self.values).reshape(len(self.times), -1)
        slopes = np.diff(values, axis=0) / np.diff(self.times)[:, None]
        changes = np.abs(np.diff(slopes, axis=0, prepend=0.0, append=0.0)).max(axis=1)
        return dict(zip(self.times, (changes / max(scale, 1e-300)).tolist(), strict=True))

    @property
    def range(self) -> tuple[float, float]:
        """Smallest and largest value."""
        return min(self.values), max(self.values)


@dataclass(frozen=True)
class ProfileSeries(TimeSeries):
    """The same along the flow: `values` at each time are those at `positions` (m from the inlet), linear between them and
    constant beyond."""

    positions: tuple[float, ...] = ()

    def __call__(self, time: float) -> Any:
        """Values at the positions, at the time (s)."""
        return np.array([np.interp(time, self.times, column) for column in np.transpose(self.values)])

    @property
    def range(self) -> tuple[float, float]:
        """Smallest and largest value anywhere."""
        return float(np.min(self.values)), float(np.max(self.values))


def _bends(times: Floats, values: Floats, little: float) -> Integers:
    """Numbers of the rows that do not lie on the line through their neighbours, within `little` and rounding; the first and the
    last are among them."""
    part = ((times[1:-1] - times[:-2]) / (times[2:] - times[:-2]))[:, None]
    beside = np.abs(values[1:-1] - values[:-2] - part * (values[2:] - values[:-2]))
    bent = np.any(beside > little + 4.0 * np.finfo(float).eps * np.abs(values[1:-1]), axis=1)
    return np.flatnonzero(np.concatenate([[True], bent, [True]]))


def _ends_of_windows(times: Floats, values: Floats, little: float) -> Integers:
    """Numbers of the rows between which all change by less than `little`, or lie within `FASTEST`, and not more than an even
    spacing of `MOST_ROWS` apart; where rows change by more each is one."""
    spacing = (times[-1] - times[0]) / MOST_ROWS * (1.0 + 1e-9)
    kept = [0]
    while kept[-1] < len(times) - 1:
        first = kept[-1]
        reached = int(np.searchsorted(times, times[first] + spacing, side="right"))
        part = values[first:reached]
        change = np.max(np.maximum.accumulate(part) - np.minimum.accumulate(part), axis=1, initial=0.0)
        merged = np.flatnonzero((change <= little) | (times[first:reached] - times[first] <= FASTEST))
        kept.append(max(first + int(merged[-1]) if len(merged) else 0, first + 1))
    return np.array(kept)


def _means(times: Floats, values: Floats, kept: Integers) -> Floats:
    """Values (rows, columns) of the rows that are `kept`: means weighted by their hat functions where rows between them are left
    out, else their own. Simpson's rule is exact for products of linear functions."""
    begins, ends = kept[:-1], kept[1:]
    window = np.repeat(np.arange(len(begins)), ends - begins)
    rise = ((times - times[begins[np.append(window, window[-1])]])[:-1], times[1:] - times[begins[window]])
    lengths, steps = times[ends] - times[begins], np.diff(times)[:, None]
    of_start, of_end = (part[:, None] / lengths[window, None] for part in rise)
    middle = 0.25 * (of_start + of_end) * (values[:-1] + values[1:])
    to_end = np.add.reduceat(
        steps / 6.0 * (of_start * values[:-1] + 4.0 * middle + of_end * values[1:]), begins, axis=0
    )
    whole = np.add.reduceat(0.5 * steps * (values[:-1] + values[1:]), begins, axis=0)
    single = (ends - begins == 1)[:, None]
    to_end = np.where(single, 0.5 * lengths[:, None] * values[ends], to_end)
    sums, weights = np.zeros((len(kept), values.shape[1])), np.zeros((len(kept), 1))
    sums[1:] += to_end
    sums[:-1] += whole - to_end
    weights[1:, 0] += 0.5 * lengths
    weights[:-1, 0] += 0.5 * lengths
    return np.asarray(sums / weights)


def read_series(key: str, path: Path, unit: str, *, along: bool = False) -> TimeSeries:
    """`TimeSeries` of a CSV file; with `along` also `ProfileSeries`, of a head `time [s], 0.1 m [unit], 0.2 m [unit], ...` that
    tells the positions.

    Raises `InputError` that names the key, the file and the line.
    """
    return _series_of(read_columns(key, path), key, path, unit, along=along)


CHANNEL = ("file", "column", "unit", "time_offset")
"""Keys of a table that names one channel of a logger's file."""


def read_channel(
    key: str, table: Mapping[str, Any], base: Path, unit: str, *, along: bool, where: str | None
) -> TimeSeries:
    """`TimeSeries` of a table with the `file` (relative to `base`), which `column` of it, its `unit` where the head has none, and
    the `time_offset` that is taken from its times: a time, one of day (10:01:30), or "first" for that of the first row.

    Raises `InputError` that names the key, the file and what is wrong.
    """
    for name, text in table.items():
        if name not in CHANNEL or not isinstance(text, str):
            allowed = f'must be a text, and one of {", ".join(CHANNEL)}, such as {{ file = "log.csv", column = "T 3" }}'
            raise InputError(f"{key}.{name}", str(text), allowed, where)
    path = existing_file(f"{key}.file", table.get("file"), base, where)
    column, offset = table.get("column"), table.get("time_offset")
    shift = 0.0 if offset is None or offset == "first" else time_offset(f"{key}.time_offset", offset, where)
    wanted = None if column is None else column_name(column)
    columns = read_columns(key, path, None if wanted is None else lambda name: name == wanted, unit=table.get("unit"))
    if column is not None and len(columns.names) != 2:
        there = "has no such column" if len(columns.names) == 1 else "has it twice"
        names = ", ".join(map(repr, columns.others or columns.names))
        raise InputError(f"{key}.column", column, f"{there} ({names})", str(path))
    own, head = (
        [to_si(f"{key}.unit", f"{number} {one}", unit, where) for number in (0, 1)]
        for one in (table.get("unit") or columns.units[-1], columns.units[-1])
    )
    if own != head:
        raise InputError(f"{key}.unit", table["unit"], f"is not that of the head, {columns.units[-1]}", str(path))
    series = _series_of(columns, key, path, unit, along=along and column is None, named=column is not None)
    shift = series.times[0] if offset == "first" else shift
    times = tuple((np.array(series.times) - shift).tolist())
    return replace(series, times=times, channel={name: text for name, text in table.items() if name != "file"})


def _series_of(columns: Columns, key: str, path: Path, unit: str, *, along: bool, named: bool = False) -> TimeSeries:
    named_for, own = columns.names[-1].strip().lower().replace(" ", "_"), key.rpartition(".")[2]
    if len(columns.names) == 2 and not named and named_for != own and named_for in OTHER_QUANTITIES:
        raise InputError(key, columns.names[-1], f"is named for another quantity than {own}", str(path))
    if not along or len(columns.names) == 2:
        return TimeSeries.of(columns, unit)
    positions = [to_si(key, name, "m", f"{path}, head") for name in columns.names[1:]]
    if np.any(np.diff(positions) <= 0.0):
        raise InputError(key, str(path), "must have columns at increasing positions")
    values = np.column_stack([columns.in_si(number, unit) for number in range(1, len(columns.names))])
    times = tuple(columns.times().tolist())
    return ProfileSeries(times, tuple(values.tolist()), str(path), None, columns.gaps, positions=tuple(positions))
