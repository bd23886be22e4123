"""The materials that a scene may name: fluids, and solids for beads and walls, each property with its source and range.

They stand in `library/solids.toml` and `library/fluids.toml`, as a user's own would (`material_files`); the fluids but for air
are fitted by `python -m studies.fluid_properties`. `porousmold materials` lists them.
"""

from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from ..errors import InputError
from ..files.tables import read_toml
from .material_files import read_materials
from .materials import Fluid, Solid
from .registry import Registry

FLUIDS: Registry[Fluid] = Registry("fluid")
SOLIDS: Registry[Solid] = Registry("solid")
M = TypeVar("M", Fluid, Solid)
LIBRARY = Path(__file__).parent / "library"


def _register(path: Path) -> None:
    """The materials of a file, each read when it is first asked for: a scene needs three of thirty."""
    for name, table in read_toml("materials", path).items():
        registry: Any = FLUIDS if "viscosity" in table else SOLIDS
        registry.register_later(name, partial(_read, name, table, path.parent))


def _read(name: str, table: dict[str, Any], folder: Path) -> Fluid | Solid:
    return read_materials({name: table}, folder, None)[name]


for _name in ("solids.toml", "fluids.toml"):
    _register(LIBRARY / _name)


def named(option: str, name: str, materials: Registry[M]) -> M:
    """A material of `SOLIDS` or `FLUIDS` by its name. Raises `InputError` that names the option for one that is not there."""
    if name not in materials:
        raise InputError(option, name, f"must be one of {', '.join(materials)}")
    return materials[name]
