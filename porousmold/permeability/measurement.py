"""A falling-head test as it is measured: its set-up (TOML), what the scale wrote (CSV), and what follows from both."""

from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from ..errors import InputError
from ..files.tables import read_columns, read_toml
from ..laws.drag import DRAG_LAWS
from ..scene.keys import Key, checked_values
from .falling_head import (
    APPROACHES,
    DARCY_LIMIT,
    Levels,
    Setup,
    fit_baseline,
    globally,
    instantaneous,
    levels_of,
    mean_of,
    reynolds_number,
)

LIQUIDS = {
    "silicone-oil": (966.0, 0.099, "PMX-200 at 23 degC, thesis section 4.5.2"),
    "water": (997.5, 9.32e-4, "at 23 degC, IAPWS R12-08 and R6-95"),
}
"""Density (kg/m3), viscosity (Pa s) and source by name."""
SETUP: dict[str, dict[str, Key]] = {
    "setup": {
        "bed_length": Key("m", "length L of the bed", low=0.0, high=10.0),
        "pipe_diameter": Key("m", "inner diameter of the pipe, or", low=0.0, high=10.0),
        "cross_section": Key("m^2", "its cross-section S", low=0.0, high=100.0),
        "initial_head": Key("m", "level h0 above the top of the bed at the first reading", low=0.0, high=100.0),
        "outlet_resistance": Key("Pa*s/m^3", "c0 of the set-up below the bed", low=0.0, high=1e15, closed=True),
        "outlet_pressure": Key(
            "Pa", "c1 of the set-up, below 0 where the outlet lies below the bed", low=-1e6, high=1e6
        ),
        "baseline": Key("file", "CSV file of a run without beads, from which c0 and c1 are fitted"),
        "baseline_head": Key("m", "level h0 of that run, default initial_head", low=0.0, high=100.0),
        "averaging_time": Key("s", "interval over which readings are averaged", 2.0, low=0.0, high=1e5),
    },
    "liquid": {
        "name": Key("choice", "one of the library, or", choices=tuple(LIQUIDS)),
        "density": Key("kg/m^3", "its density", low=0.0, high=2e4),
        "viscosity": Key("Pa*s", "and viscosity", low=0.0, high=1e4),
    },
    "bed": {
        "bead_diameter": Key("m", "for Reynolds number and predictions", low=0.0, high=1.0),
        "porosity": Key("", "for predictions", low=0.0, high=1.0),
    },
}
READING_ERROR = 2e-3
"""m by which a file of levels may start beside the set-up's initial head."""
LARGE_SCATTER = 0.3
"""Relative standard deviation of the instantaneous values beyond which their mean is biased."""
SMALLEST_FALL = 0.01
"""Part of all the mass by which a reading may fall below an earlier one before it counts as an error of handling."""
IDLE, LEAST_IDLE = 0.01, 0.02
"""Part of the largest flow rate that is none, and of the time of a test for which there may be none without a word."""
LONG_GAP = 10.0
"""Times the usual interval between readings that counts as a gap."""


@dataclass(frozen=True)
class Test:
    """Set-up and bed as read, with the file's folder for what it names."""

    setup: Setup
    averaging_time: float
    bead_diameter: float | None
    porosity: float | None
    baseline: Levels | None
    warnings: tuple[str, ...] = ()


def read_setup(path: Path) -> Test:
    """`Test` of a TOML file. Raises `InputError` naming the key."""
    path = Path(path)
    values = checked_values(read_toml("setup", path), SETUP, path.parent, str(path))
    given, liquid, bed = (SimpleNamespace(**values[table]) for table in ("setup", "liquid", "bed"))

    def need(table: str, name: str) -> None:
        if values[table][name] is None:
            raise InputError(f"{table}.{name}", None, f"is missing; {SETUP[table][name].meaning}", str(path))

    need("setup", "bed_length")
    need("setup", "initial_head")
    if (given.pipe_diameter is None) == (given.cross_section is None):
        raise InputError("setup.pipe_diameter", given.pipe_diameter, "or setup.cross_section must be given", str(path))
    if liquid.name is None:
        need("liquid", "density")
        need("liquid", "viscosity")
        density, viscosity = liquid.density, liquid.viscosity
    else:
        density, viscosity, _ = LIQUIDS[liquid.name]
        density, viscosity = liquid.density or density, liquid.viscosity or viscosity
    numbers = sum(value is not None for value in (given.outlet_resistance, given.outlet_pressure))
    if numbers != (2 if given.baseline is None else 0):
        raise InputError("setup.baseline", None if given.baseline is None else str(given.baseline),
                         "or both setup.outlet_resistance and setup.outlet_pressure must be given", str(path))  # fmt: skip
    area = given.cross_section or 0.25 * np.pi * given.pipe_diameter**2
    setup = Setup(given.bed_length, area, given.initial_head, density, viscosity)
    baseline: Levels | None = None
    warnings: tuple[str, ...] = ()
    if given.baseline is not None:
        empty = replace(setup, initial_head=given.baseline_head or given.initial_head)
        baseline, warnings = read_levels(given.baseline, empty, given.averaging_time, "setup.baseline")
        try:
            c0, c1 = fit_baseline(empty, baseline)
        except RuntimeError as error:
            raise InputError(
                "setup.baseline", str(given.baseline), "does not fall exponentially: no c0 and c1 fit"
            ) from error
    else:
        c0, c1 = given.outlet_resistance, given.outlet_pressure
    setup = replace(setup, outlet_resistance=c0, outlet_pressure=c1)
    if setup.rate_and_offset(1.0)[1] <= 0.0:
        raise InputError("setup.outlet_pressure", c1, f"must be < {setup.bed_length * setup.specific_weight:g} Pa, the weight "
                         "of the liquid in the bed: else nothing drives it out", str(path))  # fmt: skip
    return Test(setup, given.averaging_time, bed.bead_diameter, bed.porosity, baseline, warnings)


def read_levels(path: Path, setup: Setup, averaging_time: float, key: str = "DATA") -> tuple[Levels, tuple[str, ...]]:
    """(`Levels`, warnings) of a CSV file `time [s], mass [g]` or `time [s], level [mm]`.

    Raises `InputError` for anything that cannot be such a test.
    """
    path = Path(path)
    columns = read_columns(key, path)
    if len(columns.names) != 2 or columns.names[0] != "time" or columns.names[1] not in ("mass", "level"):
        raise InputError(key, str(path), "must have two columns, 'time [s]' and 'mass [g]' or 'level [mm]'")
    times = columns.times()
    if len(times) < 4:
        raise InputError(key, str(path), f"has {len(times)} rows, below 4")
    if columns.names[1] == "level":
        first = float(columns.in_si(1, "m")[0])
        if abs(first - setup.initial_head) > READING_ERROR:
            raise InputError(
                key, str(path), f"starts at {first:g} m, not at the set-up's initial head of {setup.initial_head:g} m"
            )
        mass = (setup.initial_head - columns.in_si(1, "m")) * setup.density * setup.cross_section
    else:
        mass = columns.in_si(1, "kg")
    if not mass[-1] > mass[0]:
        raise InputError(key, str(path), "must have mass running out: the last reading is not above the first")
    fallen = np.maximum.accumulate(mass) - mass
    if np.max(fallen) > SMALLEST_FALL * np.ptp(mass):
        line = columns.lines[int(np.argmax(fallen))]
        raise InputError(key, str(path), f"row {line}: the mass that has run out falls by {np.max(fallen):.3g} kg; "
                         "was the container moved, or is the level rising?")  # fmt: skip
    intervals = np.diff(times)
    warnings = [f"{path.name}: {columns.gaps} missing value(s), interpolated"] if columns.gaps else []
    if np.max(intervals, initial=0.0) > LONG_GAP * np.median(intervals):
        line = columns.lines[int(np.argmax(intervals)) + 1]
        warnings.append(f"{path.name}: gap of {np.max(intervals):.3g} s before row {line}, bridged by a straight line")
    whole = setup.initial_head * setup.density * setup.cross_section
    if np.ptp(mass) > 1.02 * whole:
        warnings.append(
            f"{path.name}: more runs out than stood above the bed; readings after the level reaches it do not count"
        )
    try:
        levels = levels_of(setup, times, mass, averaging_time)
    except ValueError as error:
        raise InputError(key, str(path), str(error)) from error
    return levels, (*warnings, *(f"{path.name}: {text}" for text in _idle_readings(levels)))


def _idle_readings(levels: Levels) -> list[str]:
    """Of readings at begin and end between which nothing runs out, which count as part of the fall."""
    runs = np.flatnonzero(levels.flow_rate > IDLE * np.max(levels.flow_rate))
    ends = {"first": (levels.time[0], levels.time[runs[0]]), "last": (levels.time[runs[-1] + 1], levels.time[-1])}
    return [
        f"nothing runs out in the {side} {last - first:.3g} s: cut these readings, they count as part of the fall"
        for side, (first, last) in ends.items()
        if last - first > LEAST_IDLE * (levels.time[-1] - levels.time[0])
    ]


def evaluate(test: Test, levels: Levels) -> dict[str, Any]:
    """What a test tells: 'approaches' {approach: {'instantaneous', 'global'}}, 'predictions', 'reynolds_number', 'warnings'."""
    setup, warnings = test.setup, list(test.warnings)
    approaches = {}
    for approach in APPROACHES:
        values = instantaneous(setup, levels, approach)
        if approach == "complete" and not np.all(values > 0.0):
            warnings.append(
                "the pressure that c0 and c1 take exceeds what there is in places: they do not fit this test"
            )
        try:
            fitted = globally(setup, levels, approach)
        except RuntimeError:
            fitted = None
            warnings.append(f"approach {approach!r}: no permeability fits the fall of the level")
        scatter = float(np.std(values) / np.mean(values)) if np.all(np.isfinite(values)) else float("inf")
        if approach == "complete" and not 0.0 <= scatter < LARGE_SCATTER:
            warnings.append(
                f"instantaneous values scatter by {abs(scatter):.0%}: their mean is biased, trust the global method"
            )
        approaches[approach] = {"instantaneous": mean_of(values[np.isfinite(values)]), "global": fitted}
    number = None
    if test.bead_diameter is not None:
        number = reynolds_number(setup, levels, test.bead_diameter)
        if number > DARCY_LIMIT:
            warnings.append(f"particle Reynolds number {number:.2g} > {DARCY_LIMIT:g}: Darcy's law does not hold; "
                            "take a more viscous liquid")  # fmt: skip
    predictions = {}
    if test.bead_diameter is not None and test.porosity is not None:
        predictions = {name: law.permeability(test.porosity, test.bead_diameter) for name, law in DRAG_LAWS.items()}
    best = approaches["complete"]["global"]
    if best is not None:
        bed = setup.viscosity * setup.bed_length / best.permeability
        share = bed / (bed + setup.outlet_resistance * setup.cross_section)
        if share < 0.05:
            warnings.append(
                f"the bed takes {share:.1%} of the pressure, the set-up the rest: the permeability is uncertain"
            )
    return {"approaches": approaches, "predictions": predictions, "reynolds_number": number, "warnings": warnings}
