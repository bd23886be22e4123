"""Whether a flow goes to and fro from step to step, as it does where it answers strongly to the temperature that it makes."""

import numpy as np

from ..output.quantities import Columns

TURNING_PART = 0.6
"""Of the changes from row to row, that have to turn for a course to go to and fro."""


def free_column(drive: str) -> str:
    """The column of the history that a drive leaves free."""
    return "mass_flow" if drive == "pressure_drop" else "pressure_drop"


def part_to_and_fro(history: Columns, column: str, rows: int) -> float:
    """By what part of itself a column goes to and fro in the last rows, half of the median change; 0 where it does not, or where
    there are fewer rows."""
    if len(history) < rows:  # one that has no row yet has no columns
        return 0.0
    last = np.array(history[column][-rows:])
    changes = np.diff(last)
    if np.mean(changes[1:] * changes[:-1] < 0.0) <= TURNING_PART:
        return 0.0
    return float(0.5 * np.median(np.abs(changes)) / np.abs(last).max())
