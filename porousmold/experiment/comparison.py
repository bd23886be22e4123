"""A run beside a measurement at the same sensors: how far they are apart."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator

from ..arrays import Floats
from ..errors import InputError
from ..files.tables import column_name, read_columns
from ..output.stored import read_table, require_run

SENSOR_ERROR = 1.1
"""K, of the thesis's thermocouples (section 6.4)."""
POSITION_ERROR = 0.5e-3
"""m, of their places (figure 6.5)."""


@dataclass(frozen=True)
class Deviation:
    """Of one sensor over the times that run and measurement share: `measured` and `simulated` (K) at `time` (s).

    `uncertainty` (K) is that of the simulated value, because of the sensor's place and of what the run was given. `whole` is the
    run at that sensor from its start to its end, (times, temperatures).
    """

    name: str
    time: Floats
    measured: Floats
    simulated: Floats
    uncertainty: Floats
    whole: tuple[Floats, Floats]

    @property
    def average(self) -> float:
        """Mean of |measured - simulated|, K (eq. 7.30 for one sensor)."""
        return float(np.mean(np.abs(self.measured - self.simulated)))

    @property
    def bias(self) -> float:
        """Mean of simulated - measured, K."""
        return float(np.mean(self.simulated - self.measured))

    @property
    def largest(self) -> float:
        """Largest |measured - simulated|, K."""
        return float(np.max(np.abs(self.measured - self.simulated)))

    @property
    def within(self) -> bool:
        """Whether measured and simulated are as close as the errors of both allow (root of the sum of squares), by time."""
        return np.abs(self.measured - self.simulated) <= np.hypot(SENSOR_ERROR, self.uncertainty)


class Comparison(NamedTuple):
    """The sensors that were compared, channels of the file that are no sensor of the run, and how many values it lacks."""

    deviations: list[Deviation]
    left_out: tuple[str, ...]
    gaps: int
    beyond: int
    """Values at times that the run does not have."""


def compare(
    folder: Path,
    path: Path,
    bounds: Sequence[Path] = (),
    columns: Mapping[str, str] | None = None,
    time_offset: float | None = 0.0,
) -> Comparison:
    """A `Deviation` of every sensor that both the run in `folder` (made with geometry.sensors) and the CSV file have.

    The file has the head `time [s], NAME [degC], ...` with the sensors' names, or those that `columns` gives, {sensor: column};
    `time_offset` (s; None: that of the first row) is taken from its times. The run is interpolated to these (`between_steps`).
    Other channels, and values that are missing, are left out. `bounds` are folders of runs of the same scene with what it was
    given at the ends of its error, such as operation.outer_heat_flux_factor 0.95 and 1.05: the largest distance from them, as
    long as they last, is one uncertainty, `POSITION_ERROR` along the steepest gradient at the sensor the other. Raises
    `InputError` where run and measurement have no sensor or no time in common.
    """
    history, sensors = _read_run("RUN", folder)
    others = [_read_run("--bounds", other) for other in bounds]
    for other, (_, found) in zip(bounds, others, strict=True):
        if set(found) != set(sensors):
            raise InputError("--bounds", str(other), f"must have the sensors of the run ({', '.join(sensors)})")
    names = {name: name for name in sensors}
    for name, column in (columns or {}).items():
        if name not in sensors:
            raise InputError("--column", name, f"is no sensor of the run ({', '.join(sensors)})")
        names[name] = column_name(column)
    read = read_columns("MEASURED", path, lambda name: name in names.values(), keep_gaps=True)
    if len(set(read.names)) != len(read.names):
        raise InputError("MEASURED", str(path), "must have columns of different sensors beside the time")
    if len(read.names) < 2 or any(column_name(column) not in read.names for column in (columns or {}).values()):
        has = ", ".join(map(repr, (*read.names[1:], *read.others))) or "nothing but the time"
        asked = ", ".join(map(repr, names.values()))
        raise InputError("MEASURED", str(path), f"must have columns {asked}, or some of them: it has {has}; --column")
    time = read.times()
    time = time - (time[0] if time_offset is None else time_offset)
    begins, ends = history["time"][0], history["time"][-1]
    shared = (time >= begins) & (time <= ends)
    if not shared.any():
        allowed = f"has no time within the run's: {time[0]:g} to {time[-1]:g} s beside {begins:g} to {ends:g} s; --time-offset"
        raise InputError("MEASURED", str(path), allowed)
    deviations, beyond = [], 0
    for name, column in names.items():
        if column not in read.names:
            continue
        measured = read.in_si(read.names.index(column), "K")
        if np.any(measured < 0.0):
            row = int(np.argmax(measured < 0.0))
            allowed = (
                f"is {measured[row]:g} K at {time[row]:g} s: no temperature; leave out what a logger writes for none"
            )
            raise InputError("MEASURED", f"{path}, column {column!r}", allowed)
        beyond += int(np.sum(~shared & np.isfinite(measured)))
        there = shared & np.isfinite(measured)
        if there.any():
            deviations.append(_deviation(name, time[there], measured[there], (history, sensors), others))
    return Comparison(deviations, read.others, int(np.isnan(read.values[shared]).sum()), beyond)


def between_steps(times: Floats, steps: Floats, temperatures: Floats) -> Floats:
    """Temperatures (K) at some times (s) of a run that has them at the ends of its steps; constant beyond.

    By monotone cubic polynomials (Fritsch and Carlson, SIAM J. Numer. Anal. 17 (1980) 238-246): no extremes between steps that
    are none at their ends, where straight lines miss a kelvin of the long steps of a slow end.
    """
    if len(steps) < 2:
        return np.full(len(times), temperatures[0])
    return np.asarray(PchipInterpolator(steps, temperatures)(np.clip(times, steps[0], steps[-1])))


def _deviation(name: str, times: Floats, measured: Floats, run: Any, others: Any) -> Deviation:
    """Of a sensor at the times (s) of its measured values (K); `run` and `others` are (history, sensors)."""
    history, sensors = run
    simulated = between_steps(times, history["time"], sensors[name])
    by_place = POSITION_ERROR * np.interp(times, history["time"], history[f"gradient_{name}"])
    by_bounds = np.zeros(len(times))
    for other, found in others:
        there = np.where(times <= other["time"][-1], between_steps(times, other["time"], found[name]), np.nan)
        by_bounds = np.fmax(by_bounds, np.abs(there - simulated))
    uncertainty = np.hypot(by_place, by_bounds)
    return Deviation(name, times, measured, simulated, uncertainty, (history["time"], sensors[name]))


def _read_run(key: str, folder: Path) -> tuple[Any, ...]:
    """(history, {sensor: temperatures in K}) of a run's folder."""
    if not (folder / "history.csv").is_file():
        raise InputError(key, str(folder), "is not the folder of a run (no history.csv)")
    require_run(folder, key)
    try:
        history = {name: np.array(values) for name, values in read_table(folder / "history.csv").items()}
    except (ValueError, LookupError) as error:
        raise InputError(key, str(folder), f"has a damaged history.csv: {error}") from error
    sensors = {name.removeprefix("sensor_"): values for name, values in history.items() if name.startswith("sensor_")}
    if not sensors or any(f"gradient_{name}" not in history for name in sensors):
        raise InputError(
            key, str(folder), "has no sensors, or is of an older version: its scene needs geometry.sensors"
        )
    return history, sensors


def average_deviation(deviations: Sequence[Any]) -> float:
    """S_ave over all points of all sensors, K (eq. 7.30)."""
    return float(np.mean(np.concatenate([np.abs(d.measured - d.simulated) for d in deviations])))
