r"""Inlet velocity from a rotameter's reading.

A rotameter tells the volume flow Q_ro that its float would show at reference pressure and temperature. At T_ro and P_ro its float
stands at the same place for Q_ro (rho_ref/rho_ro)^1/2 of the reference's volume flow, and what passes it passes the inlet at T_in
and P_in; so the superficial velocity there is (thesis eq. 6.24 and 7.19)

    u_in = (T_in/P_in) Q_ro [P_ref P_ro/(T_ro T_ref)]^1/2 / A,

with the empty cross-section A, all temperatures and pressures absolute. Chapter 6 takes T_ref = 21 degC, chapter 7 291.15 K:
1 % apart in T, 0.5 % in the velocity; the instrument's own has to be given.
"""

from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Floats
from ..errors import InputError
from ..files.tables import read_columns

REFERENCE_PRESSURE = 101325.0
"""Pa."""
COLUMNS = {
    "flow": "m^3/s",
    "rotameter_pressure": "Pa",
    "rotameter_temperature": "K",
    "inlet_pressure": "Pa",
    "inlet_temperature": "K",
}
"""What a log has beside the time, in which unit inside."""
LOWEST_PRESSURE = 5e4
"""Pa; what is below can only be a gauge pressure."""


def inlet_velocity(
    flow: float | Floats,
    rotameter_pressure: float | Floats,
    rotameter_temperature: float | Floats,
    inlet_pressure: float | Floats,
    inlet_temperature: float | Floats,
    area: float,
    reference_temperature: float,
) -> Any:
    """Superficial velocity (m/s) at the inlet, eq. 7.19: flow Q_ro (m3/s) as read, absolute pressures (Pa) and temperatures (K),
    area (m2). Floats or arrays."""
    correction = np.sqrt(REFERENCE_PRESSURE * rotameter_pressure / (rotameter_temperature * reference_temperature))
    return inlet_temperature / inlet_pressure * flow * correction / area


def read_log(path: Path) -> tuple[Any, ...]:
    """(time in s, {name: values in SI}, how many were missing and are interpolated) of a logger's CSV file with the columns of
    `COLUMNS` in any order after the time.

    Raises `InputError` for a missing column or a pressure that is not absolute.
    """
    columns = read_columns("LOG", path)
    if columns.names[0] != "time":
        raise InputError("LOG", str(path), "must have the column 'time [s]' first")
    values = {}
    for name, unit in COLUMNS.items():
        if name not in columns.names:
            raise InputError("LOG", str(path), f"needs the column {name!r} (it has {', '.join(columns.names)})")
        values[name] = columns.in_si(columns.names.index(name), unit)
        least = {"Pa": -np.inf, "K": 0.0, "m^3/s": -1e-12}[unit]
        if np.min(values[name]) <= least:
            row = columns.lines[int(np.argmin(values[name]))]
            raise InputError("LOG", str(path), f"row {row}: {name} must be positive")
        if unit == "Pa" and np.min(values[name]) < LOWEST_PRESSURE:
            row = columns.lines[int(np.argmin(values[name]))]
            raise InputError("LOG", str(path), f"row {row}: {name} must be absolute, at least {LOWEST_PRESSURE:g} Pa")
    times = columns.times()
    if len(times) < 2:
        raise InputError("LOG", str(path), "must have two rows at least")
    return times, values, columns.gaps


def averaged(time: Floats, values: Floats, interval: float) -> tuple[Floats, Floats]:
    """(time, values) as means over intervals of `interval` seconds, at the mean times of their readings; both ends stay.

    A series of an inlet has a breakpoint at every point, across which no time step goes: fewer points are faster.
    """
    _, number, count = np.unique(np.floor((time - time[0]) / interval), return_inverse=True, return_counts=True)
    middle, mean = (np.bincount(number, weights=weights) / count for weights in (time, values))
    inside = (middle > time[0]) & (middle < time[-1])
    return np.r_[time[0], middle[inside], time[-1]], np.r_[values[0], mean[inside], values[-1]]
