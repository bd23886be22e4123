"""Tables of a scene as a TOML file has them: settings put on top of them, and values written back."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import InputError
from .features import KEYS
from .keys import LISTED, Part, Settings, Table, Tables, full_names, unknown
from .series import TimeSeries
from .start import LastState, Profile

LISTS = tuple(table for table, keys in KEYS.items() if list(keys) == ["list"])
"""Tables that stand in a scene as lists, [[target]]."""


def as_toml(value: object) -> Any:
    """A value as a TOML file has it."""
    if isinstance(value, TimeSeries | Profile | LastState):
        return value.as_value()
    if isinstance(value, tuple):
        return [as_toml(entry) for entry in value]
    if isinstance(value, Table):
        return {name: as_toml(part) for name, part in value if part is not None}
    return str(value) if isinstance(value, Path | Part) else value


def with_absolute_files(given: Tables, base: Path) -> Settings:
    """Tables of materials whose files are named from the root."""
    result: Settings = {}
    for name, value in given.items():
        if isinstance(value, dict):
            result[name] = with_absolute_files(value, base)
        else:
            result[name] = str((base / value).resolve()) if name in ("file", "table") else value
    return result


def with_lists_in_tables(tables: Tables) -> Tables:
    """The tables with [[target]] as the list of a table, as every key stands in one."""
    return {name: {"list": value} if isinstance(value, list) else value for name, value in tables.items()}


def flat_tolerances(tables: Tables) -> Tables:
    """The tables with [tolerance] by full names: `wall.thickness = "2 %"` there is a table in a table to TOML."""
    given = tables.get("tolerance")
    if not isinstance(given, dict):
        return tables
    flat: Settings = {}
    for name, value in given.items():
        flat |= {f"{name}.{key}": entry for key, entry in value.items()} if isinstance(value, dict) else {name: value}
    return {**tables, "tolerance": flat}


def with_settings(tables: Settings, settings: Tables) -> Settings:
    """The tables with settings {"table.key": value} on top; None takes a value away."""
    if not isinstance(settings, Mapping):
        raise InputError("settings", str(settings), 'must be a dict {"table.key": value}')
    for full_name, value in settings.items():
        if (listed := LISTED.fullmatch(full_name)) is not None:
            entries, key = _list_of(tables, listed["list"]), listed["key"]
            if not 1 <= int(listed["number"]) <= len(entries):
                there = (
                    f"must have a number from 1 to {len(entries)}" if entries else f"needs tables [[{listed['list']}]]"
                )
                raise InputError(full_name, value, there, "--set")
            entry = entries[int(listed["number"]) - 1]
            entry[key] = value
            if value is None:
                del entry[key]
            continue
        if (counted := re.fullmatch(r"(\w+(?:\.\w+)?)\.(\d+)\.(\w+)", full_name)) is not None:
            meant = "{}[{}].{}".format(*counted.groups())
            raise InputError(full_name, value, f"is not a known key; did you mean {meant!r}?", "--set")
        if full_name in LISTS:
            tables[full_name] = value
            if not value:
                del tables[full_name]
            continue
        table, dot, key = full_name.partition(".")
        if table == "materials":
            raise InputError(
                full_name, value, "stands in the scene's file alone: --set and studies cannot give it", "--set"
            )
        if not dot or table not in KEYS:
            raise InputError(full_name, value, unknown(full_name, full_names(KEYS)), "--set")
        if not isinstance(tables.setdefault(table, {}), dict):
            raise InputError(table, tables[table], "must be a table")
        tables[table] = {**tables[table], key: value}
        if value is None:
            del tables[table][key]
    return tables


def _list_of(tables: Tables, name: str) -> list[Settings]:
    """The list of tables of a name, as a scene or a file has it; empty where there is none."""
    table, _, key = name.partition(".")
    found = tables.get(table, {})
    if isinstance(found, dict):
        found = found.get(key or "list", [])
    return found if isinstance(found, list) and all(isinstance(entry, dict) for entry in found) else []
