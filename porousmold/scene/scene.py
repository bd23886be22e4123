"""A scene: what the user writes in TOML, validated before anything is computed."""

import copy
import hashlib
import html
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NoReturn

from ..errors import InputError
from ..files.gmsh_files import merged_files, refusal
from ..files.tables import read_toml
from ..laws import registry
from ..laws.conductivity_profile import ConductivityProfile
from ..laws.materials import Fluid, Solid
from ..laws.porosity import POROSITY_MODELS, LawPorosity, Porosity
from ..laws.porosity_profile import PorosityProfile
from .closures import completed
from .features import KEYS, check_together
from .features.geometries import GEOMETRIES
from .features.inlet import temperature_of
from .features.phases import drive_name, representative
from .features.wall import BedWall
from .keys import (
    LISTED,
    Settings,
    Table,
    Tables,
    checked_names,
    checked_values,
    flat,
    key_of,
    unit_and_meaning,
)
from .materials import own_materials, schema_with
from .start import Profile, Start
from .tables import as_toml, flat_tolerances, with_absolute_files, with_lists_in_tables, with_settings


class Scene:
    """A validated scene, frozen. `scene.wall.thickness` and the like are SI values; series keys hold `TimeSeries`.

    `materials` are its own ones by name; `start` is what it starts from where that is not one temperature, of which
    `operation.initial_temperature` is then the mean; `source` is the file it came from, or None. `file_digests` stand for the
    contents of the files that it names, as they were when it was made. `tables` are {table: {key: value}} as they stand in a
    TOML file; numbers may also be texts with a unit, and series keys take a CSV file, a function of the time (s), or (times,
    values).

    Raises `InputError` for a key that is unknown or a value that is impossible, and where `extensions.python` names a file
    without `allow_extensions`, as that file's code is run, or a mesh's script that starts processes or opens files.
    """

    geometry: Table
    bed: Table
    wall: Table
    fluid: Table
    operation: Table
    target: Table
    model: Table
    solver: Table
    output: Table
    tolerance: Table
    extensions: Table

    def __init__(self, tables: Tables, source: str | Path | None = None, *, allow_extensions: bool = False) -> None:
        found: Settings = {"source": str(source) if source else None, "allow_extensions": allow_extensions}
        base = Path(source).parent if source else Path()
        if not tables:
            allowed = "is empty: it needs at least [geometry], [bed] and [operation]"
            raise InputError("scene", None, allowed, found["source"])
        registry.load_entry_points()
        tables = with_lists_in_tables(flat_tolerances(tables))
        own = tables.get("materials", {})
        found["materials"] = own_materials(own, base, found["source"])
        ordinary = {table: content for table, content in tables.items() if table != "materials"}
        found["_given"] = checked_names(ordinary, KEYS, found["source"]) | ({"materials": own} if own else {})
        _load_extensions(found["_given"].get("extensions", {}), base, found["source"], trusted=allow_extensions)
        schema = schema_with(KEYS, found["materials"])  # after the extensions, which register materials, too
        values = checked_values(completed(ordinary), schema, base, found["source"])
        found |= {table: Table(table, content) for table, content in values.items()}
        found["file_digests"] = _digests_of_files(values)
        if (mesh := values["geometry"]["mesh"]) is not None:
            found["file_digests"]["geometry.mesh"] += _checked_mesh(mesh, found["source"], trusted=allow_extensions)
        operation, start = _with_temperatures(values["operation"], values["geometry"]["length"], found["source"])
        found |= {"operation": Table("operation", operation), "start": start}
        if start is not None:
            found["file_digests"][start.key] = start.digest()
        self.__dict__.update(found)
        check_together(self)
        profile, table = self.bed.porosity_profile, self.bed.conductivity_profile
        read = None if profile is None else PorosityProfile.read("bed.porosity_profile", profile)
        conducts = None if table is None else ConductivityProfile.read("bed.conductivity_profile", table)
        self.__dict__.update(_profile=read, conductivity_profile=conducts)

    source: str | None
    materials: Mapping[str, Solid | Fluid]
    file_digests: Mapping[str, str]
    _given: Mapping[str, Any]
    allow_extensions: bool
    _profile: PorosityProfile | None
    conductivity_profile: ConductivityProfile | None
    start: Start | None

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError("a scene is frozen: use scene.changed({'table.key': value})")

    @classmethod
    def load(
        cls,
        path: str | Path | Mapping[str, object],
        settings: Tables | None = None,
        *,
        allow_extensions: bool = False,
    ) -> "Scene":
        """Read a TOML file, or take its tables as a dict, and apply settings {"table.key": value} on top."""
        if isinstance(path, Mapping):
            return cls(with_settings(copy.deepcopy(dict(path)), settings or {}), allow_extensions=allow_extensions)
        if not isinstance(path, str | Path):
            raise InputError("scene", str(path), "must be the name of a file, or tables as a dict")
        tables = with_settings(read_toml("scene", Path(path)), settings or {})
        try:
            return cls(tables, path, allow_extensions=allow_extensions)
        except InputError as error:
            if error.key in (settings or {}) and error.where == str(path):
                raise InputError(error.key, error.value, error.allowed, "--set") from None
            raise

    def changed(self, settings: Tables) -> "Scene":
        """A copy with other values {"table.key": value}; None takes a value away."""
        tables = with_settings(copy.deepcopy(dict(self._given)), settings)
        return Scene(tables, self.source, allow_extensions=self.allow_extensions)

    def with_tables(self, tables: Mapping[str, Table]) -> "Scene":
        """A copy with other tables of values, which are taken as they are."""
        copied = copy.copy(self)
        copied.__dict__.update(tables)
        return copied

    def __repr__(self) -> str:
        given = ", ".join(
            f"{name} = {value}" for name, value in self.given().items() if not name.startswith("materials.")
        )
        return f"<Scene{f' {self.source}' if self.source else ''}: {given}>"

    def _repr_html_(self) -> str:
        """A table of the keys that are given, for notebooks."""
        rows = []
        for name, value in self.given().items():
            _, meaning = unit_and_meaning(KEYS, name)
            rows.append("".join(f"<td>{html.escape(text)}</td>" for text in (name, value, meaning)))
        return f"<table><tr><th>key</th><th>value</th><th>meaning</th></tr><tr>{'</tr><tr>'.join(rows)}</tr></table>"

    def is_given(self, full_name: str) -> bool:
        """Whether the key "table.key" has a value of its own, not a default."""
        table, _, name = full_name.partition(".")
        return self._given.get(table, {}).get(name) is not None

    def has_unit(self, full_name: str) -> bool:
        """Whether the key "table.key" is given as a text with a unit, or by a file."""
        table, _, name = full_name.partition(".")
        return isinstance(self._given.get(table, {}).get(name), str)

    def differs_from_default(self, full_name: str) -> bool:
        """Whether the key "table.key" has another value than where nothing is given."""
        table, _, name = full_name.partition(".")
        default = completed({table: {}, "model": {"closures": self.model.closures}}).get(table, {}).get(name)
        return bool(self.value(full_name) != (KEYS[table][name].default if default is None else default))

    def require(self, full_name: str) -> None:
        """Raise `InputError` where the key "table.key" has no value."""
        if self.value(full_name) is None:
            raise InputError(full_name, None, f"is missing; {key_of(KEYS, full_name).meaning}", self.source)

    def refuse(self, full_name: str, allowed: str, *, value: object = ...) -> NoReturn:
        """Raise the `InputError` of a key and its value, as it is given where that is a text, or another one that is shown."""
        if value is ...:
            value = self.given()[full_name] if self.has_unit(full_name) else self.value(full_name)
        raise InputError(full_name, value, allowed, self.source)

    @property
    def has_no_stations(self) -> bool:
        """Whether the bed is no straight one in a plane, with stations along the flow."""
        return self.geometry.width is not None or self.geometry.kind == "mesh"

    @property
    def is_locally_developed(self) -> bool:
        """Whether its developed flow is that over any mesh, by local profiles."""
        return self.has_no_stations and self.model.flow == "developed"

    def given(self) -> dict[str, str]:
        """{"table.key": text} of what was given, as it was written."""
        return {name: str(value) for name, value in flat(self._given).items()}

    def value(self, full_name: str) -> Any:
        """The value (SI) of "table.key", of "wall.layer[2].thickness" or "target[1].within"; None where there is none.

        Raises `KeyError` for a name that is no key.
        """
        key_of(KEYS, full_name)
        listed = LISTED.fullmatch(full_name)
        table, _, name = (listed["list"] if listed else full_name).partition(".")
        found = getattr(getattr(self, table), name or "list")
        if not listed:
            return found
        entries, number = found or (), int(listed["number"])
        return getattr(entries[number - 1], listed["key"]) if 1 <= number <= len(entries) else None

    @property
    def layers(self) -> Settings:
        """The layers of the wall and of the wall opposite, each from the bed outwards, by their keys; a plain wall has none."""
        return BedWall.of(self).listed

    @property
    def porosity(self) -> Porosity:
        """What the bed's porosity follows: its profile as it was read, or a law."""
        if self._profile is not None:
            return self._profile
        return LawPorosity(POROSITY_MODELS[self.bed.porosity_model], self.bed.bulk_porosity)

    def as_tables(self) -> dict[str, Settings]:
        """Every key with its value, defaults included, ready for TOML; keys without a value are left out."""
        tables: dict[str, Settings] = {}
        without_place = _without_place(self)
        for table, keys in KEYS.items():
            content = {}
            for name in keys:
                if f"{table}.{name}" in without_place:
                    continue
                value = getattr(getattr(self, table), name)
                if (table, name) == ("operation", "initial_temperature") and self.start is not None:
                    value = self.start if isinstance(self.start, Profile) else None
                if value is not None:
                    content[name] = as_toml(value)
            if content:
                tables[table] = content
        tables |= {name: content["list"] for name, content in tables.items() if list(content) == ["list"]}
        if own := self._given.get("materials"):
            tables["materials"] = with_absolute_files(own, Path(self.source).parent if self.source else Path())
        return tables


def _load_extensions(given: Settings, base: Path, source: str | None, *, trusted: bool) -> None:
    """Run the file of laws that [extensions] names, if it is trusted; `InputError` where it is not."""
    if not trusted and (name := given.get("python")) is not None:
        allowed = "holds code, which is run only if you trust it: --allow-extensions"
        raise InputError("extensions.python", name, allowed, source)
    values = checked_values({"extensions": given}, {"extensions": KEYS["extensions"]}, base, source)
    if (path := values["extensions"]["python"]) is not None:
        registry.load_file(path)


def _without_place(scene: Scene) -> list[str]:
    """Full names of keys whose values come from elsewhere in a scene."""
    names = list(GEOMETRIES[scene.geometry.kind].foreign)
    names += ["operation.inlet_temperature"] if scene.operation.programme or scene.operation.phase else []
    names += [f"operation.{drive_name(scene.operation.phase)}"] if scene.operation.phase else []
    return names + (["wall.material"] if scene.wall.layer else [])


def _digests_of_files(values: Mapping[str, Settings]) -> dict[str, str]:
    """Of the contents of the files that keys name."""
    return {
        f"{table}.{name}": hashlib.sha256(value.read_bytes()).hexdigest()
        for table, content in values.items()
        for name, value in content.items()
        if isinstance(value, Path)
    }


def _with_temperatures(operation: Settings, length: float | None, where: str | None) -> tuple[Settings, Start | None]:
    """The values of [operation] with one temperature (K) at the start, the mean of a bed of a `length` (m), and a series at the
    inlet; and what the run starts from where that is not one temperature."""
    first, state = operation["initial_temperature"], operation["initial_state"]
    if state is not None and first is not None:
        allowed = "cannot be combined with operation.initial_temperature"
        raise InputError("operation.initial_state", str(state.folder), allowed, where)
    start: Start | None = state or (first if isinstance(first, Profile) else None)
    begun = first if start is None else start.mean(length)
    found = {**operation, "initial_temperature": begun}
    if begun and operation["programme"]:
        found["inlet_temperature"] = temperature_of(operation["programme"], begun, where)
    if begun and operation["phase"]:
        found |= representative(operation["phase"], begun)
    return found, start


def _checked_mesh(path: Path, source: str | None, *, trusted: bool) -> str:
    """What the mesh depends on besides its own file; `InputError` where gmsh is not to open that."""
    if not trusted and (reason := refusal(path)) is not None:
        raise InputError("geometry.mesh", str(path), reason, source)
    return "".join(hashlib.sha256(file.read_bytes()).hexdigest() for file in merged_files(path))
