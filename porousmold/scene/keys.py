"""The schema of input files: keys with their unit, default, bounds and meaning, and the validation of a file.

A schema is {table: {name: `Key`}}. Values are SI numbers or texts with a unit. A key that is unknown, of the wrong dimension
or out of bounds is refused by one line that names it.
"""

import copy
import difflib
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ..errors import InputError
from ..files.tables import existing_file
from ..files.units import given_in_si, to_si
from .series import TimeSeries, read_channel, read_series
from .start import LastState, Profile

Settings: TypeAlias = dict[str, Any]
"""Values by the names of keys, full ones or those of a table."""
Tables: TypeAlias = Mapping[str, Any]
"""Tables as a TOML file has them."""

INFINITY = float("inf")
WITHOUT_UNIT = ("choice", "flag", "file", "run", "times", "text", "line", "names", "list", "tolerance", "integer")
LONGEST_SPAN = 1e5
"""Time (s) up to which a given function of the time is sampled."""


@dataclass(frozen=True)
class Key:
    """One key: `kind` is a unit of `units.to_si`, or 'choice', 'integer', 'flag', 'file', 'run' (the folder of a run), 'text',
    'names' (a table of texts), 'times' (a list of times that increase, in s), 'list' (of tables, whose keys are `entries`),
    'tolerance' (of a key whose unit is `tolerated`; such a value stays as it is written).

    Numbers lie strictly between `low` and `high` (or at them, if `closed`). `choices` are looked up when a value is checked.
    `else_allowed` says what else a choice may be made to take. A key `of_law` also takes a `Part` of a material's.
    `series` keys also take a CSV file or a channel of one (`series.CHANNEL`), with `along` one of columns along the flow, a
    function of the time (s), or a pair (times in s, values). A `profile` key also takes a CSV file of values along the flow.
    """

    kind: str
    meaning: str
    default: object = None
    low: float = -INFINITY
    high: float = INFINITY
    closed: bool = False
    choices: Collection[str] = ()
    series: bool = False
    along: bool = False
    profile: bool = False
    tolerated: str = ""
    of_law: bool = False
    else_allowed: str = ""
    entries: Mapping[str, "Key"] = field(default_factory=dict)

    @property
    def unit(self) -> str:
        """Unit of the SI value; empty where it has none."""
        return {"delta_degC": "K"}.get(self.kind, "" if self.kind in WITHOUT_UNIT else self.kind)

    def allowed(self) -> str:
        """The bounds in words."""
        unit = {"delta_degC": "K"}.get(self.kind, self.kind)
        if self.low == -INFINITY and self.high == INFINITY:
            return f"must be a number in {unit}"
        less, more = ("<=", ">=") if self.closed else ("<", ">")
        bounds = [f"{more} {self.low:g}"] if self.low > -INFINITY else []
        bounds += [f"{less} {self.high:g}"] if self.high < INFINITY else []
        return f"must be {' and '.join(bounds)} {unit}".rstrip()


Schema: TypeAlias = Mapping[str, Mapping[str, Key]]
LARGEST_PART = 10.0
"""Of a material's property, that a scene may give in its place: more is a slip of the pen, such as "2700 %" for 2700 kg/m3."""


@dataclass(frozen=True)
class Part:
    """A property as a `factor` on the law of its material, given as "105 %"."""

    factor: float

    def __str__(self) -> str:
        return f"{100.0 * self.factor:.12g} %"


class Table:
    """The values of one table of a file as attributes, SI; they cannot be assigned."""

    def __init__(self, name: str, values: Mapping[str, object]) -> None:
        object.__setattr__(self, "_name", name)
        self.__dict__.update(values)

    def __getattr__(self, key: str) -> Any:
        raise AttributeError(f"a scene has no key {self.__dict__.get('_name')}.{key}")

    def __setattr__(self, key: str, value: object) -> None:
        raise AttributeError(f"a scene is frozen: use scene.changed({{'{self._name}.{key}': ...}})")

    def __iter__(self) -> Iterator[tuple[str, Any]]:
        return ((name, value) for name, value in vars(self).items() if not name.startswith("_"))

    def with_values(self, values: Mapping[str, object]) -> "Table":
        """A copy with other values."""
        return Table(vars(self)["_name"], dict(self) | dict(values))


def full_names(schema: Schema) -> list[str]:
    """table.name of every key."""
    return [f"{table}.{name}" for table, keys in schema.items() for name in keys]


LISTED = re.compile(r"(?P<list>\w+(\.\w+)?)\[(?P<number>\d+)\]\.(?P<key>\w+)")
"""The name of a value in a list of tables, such as wall.layer[2].thickness or target[1].within."""


def key_of(schema: Schema, full_name: str) -> Key:
    """The key of a name, one in a list of tables included. Raises `KeyError` for a name that is none."""
    listed = LISTED.fullmatch(full_name)
    table, _, name = (listed["list"] if listed else full_name).partition(".")
    key = schema[table][name or "list"]
    return key.entries[listed["key"]] if listed else key


def kind_of(schema: Schema, full_name: str) -> str:
    """Unit of a key's values as `units` knows it, differences of temperature as such; empty where it has none."""
    try:
        kind = key_of(schema, full_name).kind
    except KeyError:
        return ""
    return "" if kind in WITHOUT_UNIT else kind


def unit_and_meaning(schema: Schema, full_name: str) -> tuple[str, str]:
    """Of the key of a name; both empty for that of a material's own."""
    try:
        key = key_of(schema, full_name)
    except KeyError:
        return "", ""
    return key.unit, key.meaning


def flat(tables: Tables, prefix: str = "") -> Settings:
    """{"table.key": value} of nested tables; of tables in a list "table[1].key"."""
    found: Settings = {}
    for name, value in tables.items():
        full_name = prefix.removesuffix(".") if name == "list" else f"{prefix}{name}"
        if isinstance(value, Mapping):
            found |= flat(value, f"{full_name}.")
        elif isinstance(value, list) and value and all(isinstance(entry, Mapping) for entry in value):
            for number, entry in enumerate(value, start=1):
                found |= flat(entry, f"{full_name}[{number}].")
        else:
            found[full_name] = value
    return found


MOST_SHOWN = 12
"""Keys of a table that a message names: a line, not a page."""


def names_beside(schema: Schema, name: str) -> list[str]:
    """Full names of all keys, or of those of the list's entries that a name such as wall.layer[2].thick is one of."""
    listed = LISTED.fullmatch(name)
    if listed is None:
        return full_names(schema)
    table, _, key = listed["list"].partition(".")
    found = schema.get(table, {}).get(key or "list")
    return [f"{listed['list']}[{listed['number']}].{entry}" for entry in found.entries] if found else full_names(schema)


def unknown(name: str, known: Collection[str]) -> str:
    """What is said of a name that is none of the known: the one meant, if there is one, else what its table has.

    Where the table is known its keys' last parts count: `wall.kind` is not `wall.thickness`, though most letters agree.
    """
    table, _, key = name.rpartition(".")
    beside = [other.rpartition(".")[2] for other in known if table and other.rpartition(".")[0] == table]
    if beside:
        near = [f"{table}.{other}" for other in difflib.get_close_matches(key, beside, n=1, cutoff=0.6)]
    else:
        near = difflib.get_close_matches(name, known, n=1, cutoff=0.6)
    if near:
        return f"is not a known key; did you mean {near[0]!r}?"
    elsewhere = [other for other in known if other.rpartition(".")[2] == key]
    shown = ", ".join(beside[:MOST_SHOWN]) + (", ..." if len(beside) > MOST_SHOWN else "")
    of_the_table = f"; {table} has {shown}" if beside else ""
    return "is not a known key" + of_the_table + (f"; there is {elsewhere[0]!r}" if len(elsewhere) == 1 else "")


def checked_values(tables: Tables, schema: Schema, base: Path, where: str | None) -> dict[str, Settings]:
    """{table: {name: value}} of all keys, defaults where nothing is given. `base` is the folder that files are relative to.

    Raises `InputError` for an unknown name or an impossible value.
    """
    given = checked_names(tables, schema, where)
    return {
        table: {
            name: _checked_value(f"{table}.{name}", key, given.get(table, {}).get(name), base, where)
            for name, key in keys.items()
        }
        for table, keys in schema.items()
    }


def checked_names(tables: Tables, schema: Schema, where: str | None) -> Settings:
    """A copy of the tables, all of whose names are known (else `InputError`)."""
    for table, content in tables.items():
        if table not in schema:
            raise InputError(table, None, unknown(table, list(schema)), where)
        if not isinstance(content, dict):
            raise InputError(table, content, "must be a table", where)
        for name in content:
            if name not in schema[table]:
                full_name, given = f"{table}.{name}", content[name]
                shown = given if isinstance(given, int | float | str) else str(given)
                raise InputError(full_name, shown, unknown(full_name, full_names(schema)), where)
    return copy.deepcopy(dict(tables))


def _checked_value(name: str, key: Key, value: Any, base: Path, where: str | None) -> Any:
    if isinstance(value, np.generic | np.ndarray) and value.ndim == 0:
        value = value.item()
    if value is None:
        value = key.default
        if value is None:
            return None
        return TimeSeries.constant(value) if key.series else value
    if key.kind == "choice":
        if not isinstance(value, str) or value not in key.choices:
            near = difflib.get_close_matches(str(value), list(key.choices), n=1, cutoff=0.7)
            hint = f"did you mean {near[0]!r}? " if near else ""
            other = f", or {key.else_allowed}" if key.else_allowed else ""
            allowed = f"{hint}must be one of {', '.join(map(repr, key.choices))}{other}"
            raise InputError(name, value, allowed, where)
        return value
    if key.kind == "tolerance":
        return value
    if key.kind == "line":
        if not isinstance(value, str) or not value.strip() or "\n" in value:
            raise InputError(name, str(value), "must be a line of text", where)
        return value
    if key.kind == "text":
        if not isinstance(value, str) or not value.strip() or set(value) & set('[].,"\n'):
            raise InputError(name, str(value), "must be a text without brackets, dots, commas and quotes", where)
        return value
    if key.kind == "names":
        if (
            not isinstance(value, Mapping)
            or not value
            or not all(isinstance(text, str) and text for text in value.values())
        ):
            allowed = 'must be a table of texts in the scene, such as { wall = "skin" } (--set gives none)'
            raise InputError(name, str(value), allowed, where)
        return dict(value)
    if key.kind == "list":
        return _checked_list(name, key, value, base, where)
    if key.kind == "flag":
        flags = {"true": True, "false": False}
        value = flags.get(value, value) if isinstance(value, str) else value
        if not isinstance(value, bool):
            raise InputError(name, value, "must be true or false", where)
        return value
    if key.kind == "file":
        return existing_file(name, value, base, where)
    if key.kind == "integer":
        if isinstance(value, str) and value.strip().isdecimal():
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int) or not key.low <= value <= key.high:
            raise InputError(name, value, f"must be a whole number from {key.low:g} to {key.high:g}", where)
        return value
    if key.kind == "times":
        return _checked_times(name, value, where)
    if key.kind == "run":
        if not isinstance(value, str) or "\0" in value:
            raise InputError(name, str(value), "must name the folder of a run", where)
        return LastState.read((base / value).resolve(), where)
    if key.profile and isinstance(value, str) and value.lower().endswith(".csv"):
        return Profile.read(existing_file(name, value, base, where))
    if key.series:
        return _checked_series(name, key, value, base, where)
    if key.of_law and isinstance(value, str) and value.strip().endswith("%"):
        factor = to_si(name, value, "", where)
        if not 0.0 < factor <= LARGEST_PART:
            allowed = f"must be > 0 % and <= {100.0 * LARGEST_PART:g} % of the material's"
            raise InputError(name, value, allowed, where)
        return Part(factor)
    number = given_in_si(name, value, key.kind, where)
    _check_bounds(name, number, key, where, value)
    return number


def _checked_list(name: str, key: Key, value: Any, base: Path, where: str | None) -> tuple[Table, ...]:
    if not isinstance(value, list | tuple) or not value or not all(isinstance(entry, dict) for entry in value):
        raise InputError(name, str(value), f"must be tables [[{name.removesuffix('.list')}]]", where)
    name = name.removesuffix(".list")
    entries = []
    for number, entry in enumerate(value, start=1):
        place = f"{name}[{number}]"
        values = checked_values({place: entry}, {place: key.entries}, base, where)[place]
        entries.append(Table(place, values))
    return tuple(entries)


def _checked_times(name: str, value: Any, where: str | None) -> tuple[float, ...]:
    if isinstance(value, str):  # of a command line
        value = [part.strip(" \"'") for part in value.strip("[] ").split(",")]
    if not isinstance(value, list | tuple) or not value:
        raise InputError(name, str(value), 'must be a list of times, such as ["10 min", "1 h"]', where)
    times = tuple(to_si(name, time, "s", where) for time in value)
    if times[0] <= 0.0 or any(late <= early for early, late in pairwise(times)):
        raise InputError(name, str(value), "must be times > 0 s that increase", where)
    return times


def _checked_series(name: str, key: Key, value: object, base: Path, where: str | None) -> TimeSeries:
    if isinstance(value, TimeSeries):
        series = value
    elif isinstance(value, str) and value.lower().endswith(".csv") and "\0" not in value:
        series = read_series(name, (base / value).resolve(), key.kind, along=key.along)
    elif isinstance(value, Mapping):
        series = read_channel(name, value, base, key.kind, along=key.along, where=where)
    elif callable(value):
        series = TimeSeries.sampled(name, value, LONGEST_SPAN)
    elif isinstance(value, list | tuple):
        series = TimeSeries.of_pair(name, value, key.kind, where)
    else:
        series = TimeSeries.constant(given_in_si(name, value, key.kind, where))
    values = np.reshape(series.values, (len(series.times), -1))
    for row, number in ((values.min(axis=1).argmin(), values.min()), (values.max(axis=1).argmax(), values.max())):
        given = f"{number:g} {key.unit}".rstrip() if series.source else value
        place = f"{series.source}, at {series.times[row]:g} s" if series.source else where
        _check_bounds(name, float(number), key, place, given)
    return series


def _check_bounds(name: str, number: float, key: Key, where: str | None, given: object = None) -> None:
    """Refuse a number out of bounds, shown as it is given where that is a text."""
    inside = key.low <= number <= key.high if key.closed else key.low < number < key.high
    if not inside:
        raise InputError(name, given if isinstance(given, str) else number, key.allowed(), where)
