"""Places whose temperature is recorded, as thermocouples are placed in an experiment."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import InputError
from ...files.tables import read_rows
from ...files.units import to_si
from .feature import Feature, key
from .wall import RESERVED_PLACES

if TYPE_CHECKING:
    from ..scene import Scene

KEY = "geometry.sensors"
MOST_ON_A_LINE = 1000
"""Sensors of one row."""


@dataclass(frozen=True, kw_only=True)
class Sensors(Feature):
    """The file of recorded places."""

    file: Path | None = key(
        KEY,
        "file",
        "CSV file `name, x [mm], y [mm]`, in three dimensions with `z [mm]`, of points where the temperature is recorded: x "
        "along the flow, y from the middle, of a whole cavity > 0 towards [wall] and < 0 towards [opposite_wall], of pipe and "
        "annulus from the axis; of a mesh of one's own the mesh's own coordinates; "
        "`0:300:11` for a coordinate gives 11 sensors on a line",
    )

    def check(self, scene: "Scene") -> None:
        """Names are none of those that every scene has."""
        for name in sensor_names(self.file):
            if name in RESERVED_PLACES:
                scene.refuse(KEY, f"has a sensor {name!r}: that is the name of a place that every scene has")


def sensor_names(path: Path | None) -> list[str]:
    """The names that the rows give; nothing for no path."""
    if path is None:
        return []
    return [name for row in read_rows(KEY, path)[1:] for name in _names(row[0].strip(), _count(row[1:], str(path)))]


def _count(cells: list[str], where: str) -> int | None:
    """How many sensors a row has on a line: the last part of `start:end:count`; None for one sensor. Raises `InputError`."""
    counts = {[*cell.split(":"), ""][2].strip() for cell in cells if ":" in cell}
    if not counts:
        return None
    count = counts.pop()
    if (
        counts
        or max(cell.count(":") for cell in cells) > 2
        or not count.isdecimal()
        or not 2 <= int(count) <= MOST_ON_A_LINE
    ):
        allowed = f"must end with the same whole number from 2 to {MOST_ON_A_LINE} wherever a row has 'start:end:count'"
        raise InputError(KEY, ", ".join(cells), allowed, where)
    return int(count)


def _names(name: str, count: int | None) -> list[str]:
    return [name] if count is None else [f"{name} {number}" for number in range(1, count + 1)]


def read_sensors(path: Path | None, dimension: int) -> tuple[Any, ...]:
    """(names, places) of a CSV file with the head `name, x [unit], y [unit]` (and z in three dimensions); places in m, a row
    each. Nothing for no path. A row with `start:end:count` for a coordinate has so many sensors on a line, `name 1` and so on.

    In the bed a sensor has the fluid's temperature, in the wall the wall's. Raises `InputError` naming the row.
    """
    if path is None:
        return [], np.empty((0, dimension))
    head, *rows = read_rows(KEY, path) or [[]]
    wanted = ["name", "x", "y", "z"][: dimension + 1]
    units = [match.group(1) if (match := re.search(r"\[(.+)\]", cell)) else None for cell in head[1:]]
    if [cell.split("[")[0].strip() for cell in head] != wanted or None in units:
        example = ", ".join(["name", *(f"{axis} [mm]" for axis in wanted[1:])])
        raise InputError(KEY, str(path), f"must have the head '{example}'")
    names, places = [], []
    for number, row in enumerate(rows, start=2):
        name = row[0].strip()
        if len(row) != len(head) or not name or set(name) & set('[],"\n'):
            raise InputError(
                KEY, str(path), f"row {number} must have a name of its own, without brackets, and {dimension} numbers"
            )
        where = f"{path}, row {number}"
        count = _count(row[1:], where)
        names += _names(name, count)
        ends = [
            [to_si(KEY, f"{text.strip()} {unit}", "m", where) for text in (cell.split(":")[:2] if count else [cell])]
            for cell, unit in zip(row[1:], units, strict=True)
        ]
        places += np.column_stack([np.linspace(one[0], one[-1], count or 1) for one in ends]).tolist()
        if len(set(names)) < len(names):
            raise InputError(KEY, str(path), f"row {number} must have a name of its own: {name} is taken")
    if not names:
        raise InputError(KEY, str(path), "must have a row for every sensor")
    return names, np.array(places)
