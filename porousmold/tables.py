"""CSV and TOML files that the user gives."""

import csv
import tomllib

from .errors import InputError


def read_rows(key, path):
    """Rows of a CSV file but for blank ones and those that start with #; `InputError` naming `key` if unreadable."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            return [row for row in csv.reader(file) if row and not row[0].lstrip().startswith("#")]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(key, str(path), f"must be a readable CSV file: {error}") from error


def read_toml(key, path):
    """Tables of a TOML file; `InputError` naming `key` if it is not there, not readable or not valid."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise InputError(key, str(path), "no such file") from error
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(key, str(path), "must be a readable TOML text file") from error
    except tomllib.TOMLDecodeError as error:
        raise InputError(key, str(path), f"is not valid TOML: {error}") from error
