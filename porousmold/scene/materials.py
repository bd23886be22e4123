"""A scene's own materials: [materials.NAME] tables in it, or in the file that `materials.file` names (`laws.material_files`)."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from ..errors import InputError
from ..files.tables import existing_file, read_toml
from ..laws.material_files import read_materials
from ..laws.material_library import FLUIDS, SOLIDS
from ..laws.materials import Fluid, Solid
from .keys import Key, Schema, Tables

FILE = "file"


def materials_file(given: Tables, base: Path, where: str | None) -> Path | None:
    """The file that [materials] names, if any. Raises `InputError` where it is not there."""
    if FILE not in given or isinstance(given[FILE], dict):
        return None
    return existing_file(f"materials.{FILE}", given[FILE], base, where)


def own_materials(given: object, base: Path, where: str | None) -> dict[str, Solid | Fluid]:
    """The materials by name of [materials], whose files are relative to `base`. Raises `InputError` naming key and file."""
    if not isinstance(given, dict):
        raise InputError("materials", str(given), "must be tables [materials.NAME]", where)
    found: dict[str, Solid | Fluid] = {}
    path = materials_file(given, base, where)
    if path is not None:
        found |= read_materials(read_toml(f"materials.{FILE}", path), path.parent, str(path))
        given = {name: table for name, table in given.items() if name != FILE}
    for name, material in read_materials(given, base, where).items():
        if name in found:
            raise InputError(f"materials.{name}", None, f"stands in {path}, too", where)
        found[name] = material
    for name in found:
        if name in SOLIDS or name in FLUIDS:
            raise InputError(f"materials.{name}", None, "is a name that the library has: choose another", where)
    return found


def schema_with(schema: Schema, own: Mapping[str, Solid | Fluid]) -> Schema:
    """The schema in which keys that name a material take these, too."""
    if not own:
        return schema
    return {table: {name: _key_with(key, own) for name, key in keys.items()} for table, keys in schema.items()}


def _key_with(key: Key, own: Mapping[str, Solid | Fluid]) -> Key:
    for library, kind in ((SOLIDS, Solid), (FLUIDS, Fluid)):
        if key.choices is library:
            known = [*key.choices]
            names = [name for name, material in own.items() if isinstance(material, kind)]
            return replace(key, choices=known + names)
    if key.entries:
        return replace(key, entries={name: _key_with(entry, own) for name, entry in key.entries.items()})
    return key
