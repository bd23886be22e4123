"""A run beside a measurement at the same sensors: how far they are apart."""

from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from ..results import read_table
from ..tables import read_columns

SENSOR_ERROR = 1.1
"""K, of the thesis's thermocouples (section 6.4)."""


@dataclass(frozen=True)
class Deviation:
    """Of one sensor over the times that run and measurement share: `measured` and `simulated` (K) at `time` (s)."""

    name: str
    time: np.ndarray
    measured: np.ndarray
    simulated: np.ndarray

    @property
    def average(self):
        """Mean of |measured - simulated|, K (eq. 7.30 for one sensor)."""
        return float(np.mean(np.abs(self.measured - self.simulated)))

    @property
    def bias(self):
        """Mean of simulated - measured, K."""
        return float(np.mean(self.simulated - self.measured))

    @property
    def largest(self):
        """Largest |measured - simulated|, K."""
        return float(np.max(np.abs(self.measured - self.simulated)))


def compare(folder, path):
    """`Deviation` of every sensor that both the run in `folder` (made with geometry.sensors) and the CSV file have.

    The file has the head `time [s], NAME [degC], ...` with the sensors' names; the run is interpolated linearly to its times.
    Raises `InputError` where they have no sensor or no time in common.
    """
    if not (folder / "history.csv").is_file():
        raise InputError("RUN", str(folder), "is not the folder of a run (no history.csv)")
    try:
        history, _ = read_table(folder / "history.csv")
    except (ValueError, LookupError) as error:
        raise InputError("RUN", str(folder), f"has a damaged history.csv: {error}") from error
    sensors = {name.removeprefix("sensor_"): values for name, values in history.items() if name.startswith("sensor_")}
    if not sensors:
        raise InputError("RUN", str(folder), "has no sensors: its scene needs geometry.sensors")
    columns = read_columns("MEASURED", path)
    time = columns.times()
    shared = time <= history["time"][-1]
    shared &= time >= history["time"][0]
    if len(set(columns.names)) != len(columns.names) or len(columns.names) < 2:
        raise InputError("MEASURED", str(path), "must have columns of different sensors beside the time")
    unknown = [name for name in columns.names[1:] if name not in sensors]
    if unknown or not shared.any():
        raise InputError("MEASURED", str(path), f"has {unknown[0]!r}, which is no sensor of the run ({', '.join(sensors)})"
                         if unknown else "has no time within the run's")  # fmt: skip
    return [
        Deviation(
            name,
            time[shared],
            columns.in_si(number, "K")[shared],
            np.interp(time[shared], history["time"], sensors[name]),
        )
        for number, name in enumerate(columns.names[1:], start=1)
    ]


def average_deviation(deviations):
    """S_ave over all points of all sensors, K (eq. 7.30)."""
    return float(np.mean(np.concatenate([np.abs(d.measured - d.simulated) for d in deviations])))
