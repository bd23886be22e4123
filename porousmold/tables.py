"""CSV files that the user gives: rows of cells, without comment lines."""

import csv

from .errors import InputError


def read_rows(key, path):
    """Rows of a CSV file but for blank ones and those that start with #; `InputError` naming `key` if unreadable."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            return [row for row in csv.reader(file) if row and not row[0].lstrip().startswith("#")]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(key, str(path), f"must be a readable CSV file: {error}") from error
