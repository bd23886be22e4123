"""The materials as a table for the console."""

from pathlib import Path

from ..files.tables import read_toml
from .material_files import read_materials
from .material_library import FLUIDS, SOLIDS
from .materials import Fluid, Solid

PRESSURE, TEMPERATURE = 101325.0, 300.0


def table(path: Path | None) -> str:
    """Every material of the library, or of a file, with its properties at 300 K (or the nearest temperature of its range) and
    their sources. Raises `InputError` for a file that is none of materials."""
    materials: dict[str, Solid | Fluid]
    if path is None:
        materials = {**SOLIDS, **FLUIDS}
    else:
        tables = read_toml("materials", path)
        materials = read_materials(tables.get("materials", tables), path.parent, str(path))
    return "\n".join(line for name, material in materials.items() for line in _lines(name, material))


def _lines(name: str, material: Solid | Fluid) -> list[str]:
    kind = "fluid" if isinstance(material, Fluid) else "solid"
    lines = [f"{name} ({kind}{', cures' if isinstance(material, Solid) and material.cure else ''})"]
    for entry, law in material.laws().items():
        low, high = law.temperature_range
        place = min(max(TEMPERATURE, low), high)
        arguments = (PRESSURE, place) if isinstance(material, Fluid) and entry == "density" else (place,)
        span = f"{low:.0f} to {high:.0f} K" if high < float("inf") else "any temperature"
        value = f"{float(law(*arguments)):.4g} {law.unit} at {place:.0f} K"
        lines.append(f"  {entry:22s} {value:28s} {span:18s} {law.source}")
    return lines
