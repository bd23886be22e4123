"""Places whose temperature is recorded, as thermocouples are placed in an experiment."""

import re
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..files.tables import read_rows
from ..files.units import to_si

KEY = "geometry.sensors"


def sensor_names(path: Path | None) -> list[str]:
    """The first cells of the rows; nothing for no path."""
    return [] if path is None else [row[0].strip() for row in read_rows(KEY, path)[1:]]


def read_sensors(path: Path | None, dimension: int) -> tuple[Any, ...]:
    """(names, places) of a CSV file with the head `name, x [unit], y [unit]` (and z in three dimensions); places in m, a row
    each. Nothing for no path.

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
        if len(row) != len(head) or not name or name in names or set(name) & set('[],"\n'):
            raise InputError(
                KEY, str(path), f"row {number} must have a name of its own, without brackets, and {dimension} numbers"
            )
        names.append(name)
        places.append([to_si(KEY, f"{cell.strip()} {unit}", "m", f"{path}, row {number}")
                       for cell, unit in zip(row[1:], units, strict=True)])  # fmt: skip
    if not names:
        raise InputError(KEY, str(path), "must have a row for every sensor")
    return names, np.array(places)
