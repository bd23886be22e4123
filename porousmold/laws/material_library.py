"""The materials that a scene may name: fluids, and solids for beads and walls, each property with its source and range.

They stand in `library/solids.toml` and `library/fluids.toml`, as a user's own would (`material_files`); the fluids but for air
are fitted by `python -m studies.fluid_properties`. `porousmold materials` lists them.
"""

from pathlib import Path

from ..files.tables import read_toml
from .material_files import read_materials
from .materials import Fluid, Solid
from .registry import Registry

FLUIDS: Registry[Fluid] = Registry("fluid")
SOLIDS: Registry[Solid] = Registry("solid")
LIBRARY = Path(__file__).parent / "library"


def _register(path: Path) -> None:
    for name, material in read_materials(read_toml("materials", path), path.parent, None).items():
        if isinstance(material, Fluid):
            FLUIDS.register(name, material)
        else:
            SOLIDS.register(name, material)


for _name in ("solids.toml", "fluids.toml"):
    _register(LIBRARY / _name)
AIR, CERAMIC, ACRYLIC = FLUIDS["air"], SOLIDS["ceramic"], SOLIDS["acrylic"]
