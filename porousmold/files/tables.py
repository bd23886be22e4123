"""CSV and TOML files that the user gives."""

import csv
import difflib
import re
import stat
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .units import to_si

SEPARATORS = ";\t,"
LARGEST_TEXT, DEEPEST_TOML = 200 * 2**20, 20
"""Bytes of a text file, and levels of tables and lists in TOML, that are read."""
FORMULA = re.compile(r"\s*(?:[=@]|[+-](?!\d[\d.]*(?:[eE][-+]?\d+)?(?: ?[A-Za-z°%][\w°%/*^]*)?$))")
"""Beginning of a text that a spreadsheet would take for a formula, but for numbers with a unit."""
NOT_UTF_8 = "must be text in UTF-8: save it so in the editor"


def _line_of(path: Path, error: UnicodeDecodeError) -> int:
    """Line of the first character that is no UTF-8."""
    return path.read_bytes()[: error.start].count(b"\n") + 1


def existing_file(key: str, name: Any, base: Path, where: str | None) -> Path:
    """Path of a file that is named relative to the folder `base`. Raises `InputError` where there is none."""
    path = (base / name).resolve() if isinstance(name, str) and "\0" not in name else None
    if path is None or not path.is_file():
        if path is None:
            place = ""
        elif path.is_dir():
            place = f"; {path} is a folder"
        else:
            place = f"; there is no {path}{_nearest(path)}"
        raise InputError(key, str(name), f"must name an existing file{place}", where)
    return path


def _nearest(path: Path) -> str:
    """A file beside it with nearly that name, as a question."""
    names = [other.name for other in path.parent.iterdir()] if path.parent.is_dir() else []
    near = difflib.get_close_matches(path.name, names, n=1)
    return f"; did you mean {near[0]!r}?" if near else ""


def read_rows(key: str, path: Path) -> list[Any]:
    """Rows of a CSV file but for blank ones and those that start with #; `InputError` naming `key` if unreadable."""
    try:
        _refuse_odd(key, path)
        with path.open(newline="", encoding="utf-8-sig") as file:
            return [row for row in csv.reader(file) if row and not row[0].lstrip().startswith("#")]
    except UnicodeDecodeError as error:
        raise InputError(key, str(path), NOT_UTF_8) from error
    except InputError:
        raise
    except (OSError, ValueError, csv.Error) as error:
        raise InputError(key, str(path), f"must be a readable CSV file: {error}") from error


def read_toml(key: str, path: Path) -> Any:
    """Tables of a TOML file; `InputError` naming `key` if it is not there, not readable, not valid or no regular file."""
    try:
        _refuse_odd(key, path)
        return _parsed(key, path)
    except RecursionError as error:
        raise InputError(key, str(path), "is nested too deeply") from error
    except UnicodeDecodeError as error:
        raise InputError(key, str(path), f"{NOT_UTF_8} (line {_line_of(path, error)})") from error
    except FileNotFoundError as error:
        raise InputError(key, str(path), f"no such file{_nearest(path)}") from error
    except tomllib.TOMLDecodeError as error:
        raise InputError(key, str(path), f'is not valid TOML: {error}; texts need quotes, like "4 mm"') from error
    except InputError:
        raise
    except (OSError, ValueError) as error:  # no text, or a path with a null byte
        raise InputError(key, str(path), "must be a readable TOML text file") from error


def _refuse_odd(key: str, path: Path) -> None:
    """Raise `InputError` for what is no file of text: a pipe or a device, which may never end, or one of any size."""
    status = path.stat()
    if not stat.S_ISREG(status.st_mode):
        raise InputError(key, str(path), "must be a regular file")
    if status.st_size > LARGEST_TEXT:
        raise InputError(key, str(path), f"must be smaller than {LARGEST_TEXT // 2**20} MiB")


def _parsed(key: str, path: Path) -> dict[str, Any]:
    text = path.read_text(encoding="utf-8-sig")
    tables = tomllib.loads(text)
    deepest = _depth(tables)
    if deepest > DEEPEST_TOML:
        raise InputError(key, str(path), f"is nested more than {DEEPEST_TOML} deep")
    return tables


def _depth(value: Any) -> int:
    """Levels of tables and lists in a value, counted without recursion."""
    depth, level = 0, [value]
    while level := [
        inner
        for outer in level
        if isinstance(outer, dict | list)
        for inner in (outer.values() if isinstance(outer, dict) else outer)
    ]:
        depth += 1
        if depth > DEEPEST_TOML:
            break
    return depth


def text_cells(row: Iterable[Any]) -> list[Any]:
    """A row to be written as CSV: texts that a spreadsheet would take for a formula begin with an apostrophe."""
    return [f"'{cell}" if isinstance(cell, str) and FORMULA.match(cell) else cell for cell in row]


@dataclass(frozen=True)
class Columns:
    """A CSV file of numbers: `names` and `units` of its columns, `values` (rows, columns), and the `lines` they stand on."""

    key: str
    path: str
    names: list[str]
    units: list[str]
    values: NDArray[Any]
    lines: list[int]

    def in_si(self, column: int, unit: str) -> Any:
        """A column in SI. Raises `InputError` if it has another dimension."""
        where = f"{self.path}, column {self.names[column]!r}"
        if unit and not self.units[column].strip():
            raise InputError(self.key, where, f"needs its unit in the head, such as {unit}")
        zero, one = (to_si(self.key, f"{number} {self.units[column]}", unit, where) for number in (0, 1))
        return zero + (one - zero) * self.values[:, column]

    def times(self) -> Any:
        """The first column in s. Raises `InputError` where it does not increase, naming the line."""
        times = self.in_si(0, "s")
        if np.any(np.diff(times) <= 0.0):
            line = self.lines[int(np.argmax(np.diff(times) <= 0.0)) + 1]
            raise InputError(self.key, self.path, f"must have increasing times; row {line} does not increase")
        return times


def read_columns(key: str, path: Path) -> Any:
    """`Columns` of a CSV file with a head `name [unit]` of every column, separated by commas, semicolons or tabs.

    Beside semicolons a comma may stand for the decimal point. Blank lines and those that start with # are skipped. Raises
    `InputError` naming the key, the file and the row (line) of whatever is wrong.
    """
    try:
        _refuse_odd(key, path)
        with path.open(newline="", encoding="utf-8-sig") as file:
            text = [(n, line) for n, line in enumerate(file, 1) if line.strip() and not line.lstrip().startswith("#")]
    except UnicodeDecodeError as error:
        raise InputError(key, str(path), NOT_UTF_8) from error
    except InputError:
        raise
    except (OSError, ValueError) as error:  # a path with a null byte, too
        raise InputError(key, str(path), f"must be a readable CSV file: {error}") from error
    if len(text) < 2:
        raise InputError(key, str(path), "must have a head like 'time [s], name [unit]' and rows of numbers")
    separator = next((s for s in SEPARATORS if s in text[0][1]), ",")
    try:
        head, *rows = csv.reader((line for _, line in text), delimiter=separator, strict=True)
    except csv.Error as error:
        raise InputError(key, str(path), f"must be a readable CSV file: {error}") from error
    lines = [number for number, _ in text[1:]]
    if any(not 0 <= cell.find("[") < cell.find("]") for cell in head):
        raise InputError(key, str(path), "needs a head with units, like 'time [s], temperature [degC]'")
    for line, row in zip(lines, rows, strict=False):
        if len(row) != len(head):
            raise InputError(
                key, str(path), f"row {line} has {len(row)} cells, the head {len(head)}: are separators mixed?"
            )
    names, units = zip(*((cell[: cell.find("[")].strip(), cell[cell.find("[") + 1 : cell.find("]")]) for cell in head),
                       strict=True)  # fmt: skip
    if separator == ";":
        rows = [[cell.replace(",", ".") for cell in row] for row in rows]
    return Columns(key, str(path), list(names), list(units), _numbers(key, path, rows, lines), lines)


def _numbers(key: str, path: Path, rows: list[list[str]], lines: list[int]) -> Any:
    try:
        values = np.array(rows, dtype=float)
    except ValueError:
        values = None
    if values is not None and np.all(np.isfinite(values)):
        return values
    for line, row in zip(lines, rows, strict=True):
        for cell in row:
            try:
                good = bool(np.isfinite(float(cell)))
            except ValueError:
                good = False
            if not good:
                raise InputError(key, str(path), f"row {line} has {cell.strip()!r}, which is no number")
    raise AssertionError("some cell is no number")
