"""A scene: what the user writes in TOML, validated before anything is computed."""

import copy
import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..files.tables import read_toml
from ..laws import registry
from ..laws.porosity import POROSITY_MODELS, LawPorosity, Porosity
from ..laws.porosity_profile import PorosityProfile
from .checks import check_together
from .closures import completed
from .geometries import GEOMETRIES
from .keys import checked_names, checked_values, full_names, unknown
from .language import KEYS
from .series import TimeSeries


class Table:
    """The values of one table of a scene as attributes, SI; they cannot be assigned."""

    def __init__(self, name: str, values: Mapping[str, Any]) -> None:
        object.__setattr__(self, "_name", name)
        self.__dict__.update(values)

    def __getattr__(self, key: str) -> Any:
        raise AttributeError(f"a scene has no key {self.__dict__.get('_name')}.{key}")

    def __setattr__(self, key: str, value: Any) -> None:
        raise AttributeError(f"a scene is frozen: use scene.changed({{'{self._name}.{key}': ...}})")

    def __iter__(self) -> Iterator[tuple[str, Any]]:
        return ((name, value) for name, value in vars(self).items() if not name.startswith("_"))


class Scene:
    """A validated scene, frozen. `scene.wall.thickness` and the like are SI values; series keys hold `TimeSeries`.

    `source` is the file it came from, or None. `file_digests` tell the contents of
    the files that it names, as they were when it was made. `tables` are {table: {key: value}} as they stand in a TOML file;
    numbers may also be texts with a unit, and series keys take a CSV file, a function of the time (s), or (times, values).

    Raises `InputError` for a key that is unknown or a value that is impossible, and where `extensions.python` names a file
    without `allow_extensions`: that file's code is run.
    """

    geometry: Table
    bed: Table
    wall: Table
    fluid: Table
    operation: Table
    model: Table
    solver: Table
    output: Table
    tolerance: Table
    extensions: Table

    def __init__(
        self, tables: Mapping[str, Any], source: str | Path | None = None, *, allow_extensions: bool = False
    ) -> None:
        found: dict[str, Any] = {"source": str(source) if source else None, "_allow_extensions": allow_extensions}
        base = Path(source).parent if source else Path()
        if not tables:
            allowed = "is empty: it needs at least [geometry], [bed] and [operation]"
            raise InputError("scene", None, allowed, found["source"])
        registry.load_entry_points()
        found["_given"] = checked_names(_flat_tolerances(tables), KEYS, found["source"])
        if not allow_extensions and (name := found["_given"].get("extensions", {}).get("python")) is not None:
            allowed = "holds code, which is run only if you trust it: --allow-extensions"
            raise InputError("extensions.python", name, allowed, found["source"])
        extensions = checked_values(
            {"extensions": found["_given"].get("extensions", {})},
            {"extensions": KEYS["extensions"]},
            base,
            found["source"],
        )
        if (path := extensions["extensions"]["python"]) is not None:
            registry.load_file(path)
        values = checked_values(completed(found["_given"]), KEYS, base, found["source"])
        found |= {table: Table(table, content) for table, content in values.items()}
        found["file_digests"] = {
            f"{table}.{name}": hashlib.sha256(value.read_bytes()).hexdigest()
            for table, content in values.items()
            for name, value in content.items()
            if isinstance(value, Path)
        }
        self.__dict__.update(found)
        check_together(self)
        profile = self.bed.porosity_profile
        read = None if profile is None else PorosityProfile.read("bed.porosity_profile", profile)
        self.__dict__["_profile"] = read

    source: str | None
    file_digests: Mapping[str, str]
    _given: Mapping[str, Any]
    _allow_extensions: bool
    _profile: PorosityProfile | None

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError("a scene is frozen: use scene.changed({'table.key': value})")

    @classmethod
    def load(
        cls, path: str | Path, settings: Mapping[str, Any] | None = None, *, allow_extensions: bool = False
    ) -> "Scene":
        """Read a TOML file and apply settings {"table.key": value} on top."""
        return cls(_with(read_toml("scene", Path(path)), settings or {}), path, allow_extensions=allow_extensions)

    def changed(self, settings: Mapping[str, Any]) -> "Scene":
        """A copy with other values {"table.key": value}; None takes a value away."""
        tables = _with(copy.deepcopy(dict(self._given)), settings)
        return Scene(tables, self.source, allow_extensions=self._allow_extensions)

    def is_given(self, full_name: str) -> bool:
        """Whether the key "table.key" has a value of its own, not a default."""
        table, _, name = full_name.partition(".")
        return self._given.get(table, {}).get(name) is not None

    @property
    def porosity(self) -> Porosity:
        """What the bed's porosity follows: its profile as it was read, or a law."""
        if self._profile is not None:
            return self._profile
        return LawPorosity(POROSITY_MODELS[self.bed.porosity_model], self.bed.bulk_porosity)

    def as_tables(self) -> dict[str, dict[str, Any]]:
        """Every key with its value, defaults included, ready for TOML; keys without a value are left out."""
        tables: dict[str, dict[str, Any]] = {}
        for table, keys in KEYS.items():
            content = {}
            for name in keys:
                if f"{table}.{name}" in GEOMETRIES[self.geometry.kind].foreign:
                    continue
                value = getattr(getattr(self, table), name)
                if isinstance(value, TimeSeries):
                    value = value.as_value()
                if value is not None:
                    content[name] = str(value) if isinstance(value, Path) else value
            if content:
                tables[table] = content
        return tables


def _flat_tolerances(tables: Mapping[str, Any]) -> Mapping[str, Any]:
    """The tables with [tolerance] by full names: `wall.thickness = "2 %"` there is a table in a table to TOML."""
    given = tables.get("tolerance")
    if not isinstance(given, dict):
        return tables
    flat: dict[str, Any] = {}
    for name, value in given.items():
        flat |= {f"{name}.{key}": entry for key, entry in value.items()} if isinstance(value, dict) else {name: value}
    return {**tables, "tolerance": flat}


def _with(tables: dict[str, Any], settings: Mapping[str, Any]) -> dict[str, Any]:
    """The tables with settings {"table.key": value} on top; None takes a value away."""
    for full_name, value in settings.items():
        table, dot, key = full_name.partition(".")
        if not dot or table not in KEYS:
            raise InputError(full_name, value, unknown(full_name, full_names(KEYS)), "--set")
        if not isinstance(tables.setdefault(table, {}), dict):
            raise InputError(table, tables[table], "must be a table")
        tables[table] = {**tables[table], key: value}
        if value is None:
            del tables[table][key]
    return tables
