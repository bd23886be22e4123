"""CSV and TOML files that the user gives."""

import codecs
import csv
import datetime
import difflib
import itertools
import math
import re
import stat
import tomllib
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Floats
from ..errors import InputError
from .units import to_si

SEPARATORS = ";\t,"
GAPS = ("", "nan", "na", "n/a", "null", "none", "-", "--")
"""Cells of loggers, in small letters, that hold no number."""
LONGEST_GAP = 5
"""Such cells in succession that are interpolated."""
_NAME_AND_UNIT = re.compile(r"\s*(?P<name>[^\[\]()]*?)\s*(?:\[(?P<a>[^\[\]]*)\]|\((?P<b>[^()]*)\))\s*")
_TIME_OF_DAY = re.compile(r"(\d{1,4}):(\d\d)(?::(\d\d(?:\.\d+)?))?")
_OTHER_DATE = re.compile(r"\d{1,2}[./-]\d{1,2}[./-]\d{2,4}")
_DECIMAL = re.compile(r"[-+]?\d+([.,])\d+")
_DATE = re.compile(r"\d{4}-\d\d-\d\d")
LARGEST_TEXT, DEEPEST_TOML = 200 * 2**20, 20
"""Bytes of a text file, and levels of tables and lists in TOML, that are read."""
FORMULA = re.compile(r"\s*(?:[=@]|[+-](?!\d[\d.]*(?:[eE][-+]?\d+)?(?: ?[A-Za-z°%][\w°%/*^]*)?$))")
"""Beginning of a text that a spreadsheet would take for a formula, but for numbers with a unit."""
NOT_UTF_8 = "must be text in UTF-8: save it so in the editor"


def _hint(problem: str) -> str:
    """What to look at where the TOML parser says this."""
    if "twice" in problem:
        return "a table that is given several times, as layers and targets are, has two brackets: [[wall.layer]]"
    return 'texts need quotes at both ends, like "4 mm", and so do keys with brackets'


def _line_of(path: Path, error: UnicodeDecodeError) -> int:
    """Line of the first character that is no UTF-8."""
    return path.read_bytes()[: error.start].count(b"\n") + 1


def existing_file(key: str, name: object, base: Path, where: str | None) -> Path:
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
        refuse_odd(key, path)
        with path.open(newline="", encoding="utf-8-sig") as file:
            return [row for row in csv.reader(file) if row and not row[0].lstrip().startswith("#")]
    except UnicodeDecodeError as error:
        raise InputError(key, str(path), NOT_UTF_8) from error
    except InputError:
        raise
    except (OSError, ValueError, csv.Error) as error:
        raise InputError(key, str(path), f"must be a readable CSV file: {error}") from error


def read_toml(key: str, path: Path) -> dict[str, Any]:
    """Tables of a TOML file; `InputError` naming `key` if it is not there, not readable, not valid or no regular file."""
    try:
        refuse_odd(key, path)
        return _parsed(key, path)
    except RecursionError as error:
        raise InputError(key, str(path), "is nested too deeply") from error
    except UnicodeDecodeError as error:
        raise InputError(key, str(path), f"{NOT_UTF_8} (line {_line_of(path, error)})") from error
    except FileNotFoundError as error:
        raise InputError(key, str(path), f"no such file{_nearest(path)}") from error
    except tomllib.TOMLDecodeError as error:
        raise InputError(key, str(path), f"is not valid TOML: {error}; {_hint(str(error))}") from error
    except InputError:
        raise
    except (OSError, ValueError) as error:  # no text, or a path with a null byte
        raise InputError(key, str(path), "must be a readable TOML text file") from error


def refuse_odd(key: str, path: Path) -> None:
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


def _depth(value: object) -> int:
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


def text_cells(row: Iterable[object]) -> list[Any]:
    """A row to be written as CSV: texts that a spreadsheet would take for a formula begin with an apostrophe."""
    return [f"'{cell}" if isinstance(cell, str) and FORMULA.match(cell) else cell for cell in row]


def column_name(head: str) -> str:
    """The name of a column by its head, whose unit may stand in brackets behind it."""
    match = _NAME_AND_UNIT.fullmatch(head)
    return head.strip() if match is None else match["name"].strip()


@dataclass(frozen=True)
class Columns:
    """A CSV file of numbers: `names` and `units` of its columns, `values` (rows, columns), the `lines` they stand on, how many
    values were missing (`gaps`) and are interpolated, and the names of columns that were not asked for (`others`)."""

    key: str
    path: str
    names: list[str]
    units: list[str]
    values: Floats
    lines: list[int]
    gaps: int = 0
    others: tuple[str, ...] = ()

    def in_si(self, column: int, unit: str) -> Floats:
        """A column in SI. Raises `InputError` if it has another dimension."""
        where = f"{self.path}, column {self.names[column]!r}"
        if unit and not self.units[column].strip():
            raise InputError(self.key, where, f"needs its unit in the head, such as {unit}")
        zero, one = (to_si(self.key, f"{number} {self.units[column]}", unit, where) for number in (0, 1))
        return zero + (one - zero) * self.values[:, column]

    def times(self) -> Floats:
        """The first column in s. Raises `InputError` where it does not increase, naming the line."""
        times = self.in_si(0, "s")
        if np.any(np.diff(times) <= 0.0):
            line = self.lines[int(np.argmax(np.diff(times) <= 0.0)) + 1]
            raise InputError(self.key, self.path, f"must have increasing times; row {line} does not increase")
        return times


def text_of(key: str, path: Path) -> str:
    """Text of a file in UTF-8, or UTF-16 with its mark, else in the code page of Western Windows. Raises `InputError`."""
    try:
        refuse_odd(key, path)
        content = path.read_bytes()
        if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
            return content.decode("utf-16")
        try:
            return content.decode("utf-8-sig")
        except UnicodeDecodeError:
            return content.decode("cp1252")
    except UnicodeDecodeError as error:
        raise InputError(key, str(path), NOT_UTF_8) from error
    except InputError:
        raise
    except (OSError, ValueError) as error:  # a path with a null byte, too
        raise InputError(key, str(path), f"must be a readable CSV file: {error}") from error


def _head(line: str) -> tuple[str, list[tuple[str, str | None]]]:
    """Separator of a head and (name, unit) of its cells, None of those without a unit; the separator that makes most units, then
    most cells, of them."""
    best: tuple[str, list[tuple[str, str | None]]] = (",", [])
    for separator in SEPARATORS:
        cells: list[str] = next(csv.reader([line], delimiter=separator), [])
        found = [_NAME_AND_UNIT.fullmatch(cell) for cell in cells]
        heads = [
            (cell.strip(), None) if match is None else (match["name"].strip(), match["a"] or match["b"] or "")
            for cell, match in zip(cells, found, strict=True)
        ]
        sizes = [(sum(unit is not None for _, unit in one), len(one)) for one in (heads, best[1])]
        if sizes[0][0] and sizes[0] > sizes[1]:
            best = separator, heads
    return best


def _is_index(cells: Sequence[str]) -> bool:
    """Whether cells count the rows."""
    return all(cell.strip().isdecimal() for cell in cells) and all(
        int(later) - int(cell) == 1 for cell, later in itertools.pairwise(cells)
    )


def read_columns(
    key: str,
    path: Path,
    wanted: Callable[[str], bool] | None = None,
    *,
    unit: str | None = None,
    keep_gaps: bool = False,
) -> Columns:
    """`Columns` of a CSV file with a head `name [unit]` or `name (unit)` of every column, between commas, semicolons or tabs.

    Beside semicolons and tabs a comma may stand for the decimal point. Blank lines, those that start with #, empty columns at
    the end and a column without a name that counts the rows are skipped. The first column may have times of day (`10:01:30`),
    taken as they stand, or dates (ISO 8601), which count from the first row. Up to `LONGEST_GAP` cells in succession that are
    empty or NaN are interpolated; with `keep_gaps` all of them stay NaN. Of the columns after the first only those whose
    names are `wanted` are read, whatever the others hold; `unit` is theirs where the head has none. Raises `InputError`
    naming the key, the file and the row (line) of whatever is wrong.
    """
    text = [
        (number, line)
        for number, line in enumerate(text_of(key, path).splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if len(text) < 2:
        raise InputError(key, str(path), "must have a head like 'time [s], name [unit]' and rows of numbers")
    separator, heads = _head(text[0][1])
    try:
        rows = list(csv.reader((line for _, line in text[1:]), delimiter=separator, strict=True))
    except csv.Error as error:
        raise InputError(key, str(path), f"must be a readable CSV file: {error}") from error
    lines = [number for number, _ in text[1:]]
    while heads and heads[-1] == ("", None) and not any("".join(row[len(heads) - 1 :]).strip() for row in rows):
        heads = heads[:-1]
    is_indexed = len(heads) > 1 and heads[0] == ("", None) and _is_index([row[0] for row in rows])
    chosen = [at for at in range(is_indexed, len(heads)) if at == is_indexed or not wanted or wanted(heads[at][0])]
    if not heads or (unit is None and any(heads[at][1] is None for at in chosen[1:])):
        raise InputError(key, str(path), "needs a head with units, like 'time [s], temperature [degC]'")
    rows = [row[: len(heads)] if not "".join(row[len(heads) :]).strip() else row for row in rows]
    for line, row in zip(lines, rows, strict=False):
        if len(row) != len(heads):
            raise InputError(
                key, str(path), f"row {line} has {len(row)} cells, the head {len(heads)}: are separators mixed?"
            )
    others = tuple(heads[at][0] for at in range(is_indexed, len(heads)) if at not in chosen)
    if len(chosen) < len(heads):
        heads, rows = [heads[at] for at in chosen], [[row[at] for at in chosen] for row in rows]
    if separator != ",":
        _require_one_decimal_sign(key, path, rows, lines)
        rows = [[cell.replace(",", ".") for cell in row] for row in rows]
    names = [name for name, _ in heads]
    units = [(unit or "") if own is None else own for _, own in heads]
    if (seconds := _clock(key, path, [row[0] for row in rows], lines, heads[0][1])) is not None:
        units[0], rows = "s", [[repr(time), *row[1:]] for time, row in zip(seconds, rows, strict=True)]
    elif heads[0][1] is None:
        raise InputError(key, str(path), "needs a head with units, like 'time [s], temperature [degC]'")
    values, gaps = _numbers(key, path, rows, lines, keep_gaps=keep_gaps)
    return Columns(key, str(path), names, units, values, lines, gaps, others)


def time_offset(key: str, text: str, where: str | None = None) -> float:
    """Seconds of a time with its unit, or of a time of day like 10:01:30. Raises `InputError`."""
    match = _TIME_OF_DAY.fullmatch(text.strip())
    return to_si(key, text, "s", where) if match is None else _seconds(match)


def _seconds(time_of_day: re.Match[str]) -> float:
    hours, minutes, seconds = time_of_day.groups(default="0")
    return 3600.0 * float(hours) + 60.0 * float(minutes) + float(seconds)


def _require_one_decimal_sign(key: str, path: Path, rows: list[list[str]], lines: list[int]) -> None:
    """Raise `InputError` where some numbers have a comma and some a point: one of them separates thousands."""
    found: dict[str, tuple[int, str]] = {}
    for line, row in zip(lines, rows, strict=True):
        for cell in row:
            if match := _DECIMAL.fullmatch(cell.strip()):
                found.setdefault(match[1], (line, cell.strip()))
    if len(found) == 2:
        (one, first), (other, second) = found.values()
        allowed = f"has {first!r} in row {one} and {second!r} in row {other}: which is the decimal sign? Write no thousands' sign"
        raise InputError(key, str(path), allowed)


def _clock(key: str, path: Path, cells: list[str], lines: list[int], unit: str | None) -> list[float] | None:
    """Seconds of times of day, h:mm:ss, as they stand, or of dates since the first row; None of other cells. `unit` is that of
    the head."""
    day = [_TIME_OF_DAY.fullmatch(cell.strip()) for cell in cells]
    if day[0] is not None:
        for line, cell, match in zip(lines, cells, day, strict=True):
            if match is None:
                raise InputError(key, str(path), f"row {line} has {cell.strip()!r}, which is no time like 10:01:30")
        if day[0][3] is None and unit not in (None, "", "h", "hh:mm"):
            allowed = f"row {lines[0]} has {cells[0].strip()!r} [{unit}]: h:mm, or min:s? Write h:mm:ss, and no unit"
            raise InputError(key, str(path), allowed)
        return [_seconds(match) for match in day if match is not None]
    if _OTHER_DATE.match(cells[0].strip()):  # day or month first?
        raise InputError(
            key, str(path), f"row {lines[0]} has {cells[0].strip()!r}: write dates like 2024-03-05 10:01:30"
        )
    if not _DATE.match(cells[0].strip()):
        return None
    first, since = None, []
    for line, cell in zip(lines, cells, strict=True):
        try:
            date = datetime.datetime.fromisoformat(cell.strip())
            since.append((date - (first := first or date)).total_seconds())
        except (ValueError, TypeError) as error:  # no date, or with and without a time zone
            allowed = f"row {line} has {cell.strip()!r}, which is no date like 2024-03-05 10:01:30"
            raise InputError(key, str(path), allowed) from error
    return since


def _numbers(key: str, path: Path, rows: list[list[str]], lines: list[int], *, keep_gaps: bool) -> tuple[Floats, int]:
    """The cells as numbers, short gaps interpolated unless they are kept, and how many were missing."""
    with suppress(ValueError):  # most tables, in a tenth of the time
        whole = np.array(rows, dtype=float)
        if np.all(np.isfinite(whole)):
            return whole, 0
    values = np.empty((len(rows), len(rows[0])))
    for number, (line, row) in enumerate(zip(lines, rows, strict=True)):
        for column, cell in enumerate(row):
            try:
                values[number, column] = math.nan if cell.strip().lower() in GAPS else float(cell)
            except ValueError:
                values[number, column] = math.inf
            if math.isinf(values[number, column]):
                raise InputError(key, str(path), f"row {line} has {cell.strip()!r}, which is no number")
    gaps = int(np.isnan(values).sum())
    for column in range(1 if keep_gaps else values.shape[1]):
        _fill(key, path, values, column, lines)
    return values, gaps


def _fill(key: str, path: Path, values: Floats, column: int, lines: list[int]) -> None:
    """Interpolate a column's gaps along the first column. Raises `InputError` for long ones, and for those at the ends."""
    gap = np.isnan(values[:, column])
    if not gap.any():
        return
    ends = np.flatnonzero(np.diff(np.concatenate([[False], gap, [False]]).astype(int)))
    for first, after in ends.reshape(-1, 2):
        if column == 0 or first == 0 or after == len(gap) or after - first > LONGEST_GAP:
            allowed = (
                f"row {lines[first]} has no number; up to {LONGEST_GAP} rows between numbers are interpolated, not"
            )
            raise InputError(key, str(path), f"{allowed} {after - first} here or those at the ends")
    values[gap, column] = np.interp(values[gap, 0], values[~gap, 0], values[~gap, column])
