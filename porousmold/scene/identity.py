"""The identity of a run: what its result depends on, as one text.

That is the scene with the contents of the files it names, the source of the laws that it takes from outside the package, and
the sources of everything in the package that computes. A result, a checkpoint or a case of a study that has another identity
is not the answer to the scene.
"""

import functools
import hashlib
import json
from pathlib import Path
from typing import Any

from ..laws.material_library import SOLIDS
from ..laws.registry import source_text
from .chosen_laws import CHOICES
from .features import KEYS
from .keys import Part, Table
from .scene import Scene
from .series import TimeSeries

COMPUTING = ("laws", "mesh", "equations", "solvers", "simulation", "scene", "files")
"""Subpackages whose sources are part of the identity: all that reads a scene and computes it."""
FREE_TO_CHANGE = {
    *("operation.end_time", "solver.first_step", "solver.step_growth", "solver.largest_step"),
    *("solver.step_tolerance", "solver.flow_tolerance"),
}
"""Keys that may have other values when a run goes on, besides all of [output] but `ENDS_OF_STEPS`."""
ENDS_OF_STEPS = ("output.times", "output.every")


@functools.cache
def code_digest(rooms: tuple[str, ...] = COMPUTING) -> str:
    """Digest of the sources of everything that computes in these subpackages, read once a process."""
    return digest_of(Path(__file__).parent.parent, rooms)


def digest_of(package: Path, rooms: tuple[str, ...]) -> str:
    """Digest of all sources, tables and libraries of some rooms of a package."""
    files = sorted(p for room in rooms for p in (package / room).rglob("*") if p.suffix in (".py", ".toml", ".csv"))
    digest = hashlib.sha256()
    for path in files:
        digest.update(str(path.relative_to(package)).encode() + path.read_bytes())
    return digest.hexdigest()


def identity_of(scene: Scene, *, going_on: bool = False) -> str:
    """Text that is the same for scenes with the same values, contents of their files, laws and computing code.

    With `going_on`, keys that may change in the middle of an integration do not count.
    """
    values: dict[str, Any] = {}
    for table, keys in KEYS.items():
        for name in keys:
            full_name = f"{table}.{name}"
            is_free = table in ("extensions", "tolerance") or (table == "output" and full_name not in ENDS_OF_STEPS)
            if is_free or (going_on and full_name in FREE_TO_CHANGE):
                continue
            value = getattr(getattr(scene, table), name)
            values[full_name] = scene.file_digests.get(full_name) or _content(value)
    laws = {
        full_name: source_text(registry[values[full_name]])
        for full_name, registry in CHOICES.items()
        if values[full_name] in registry and not registry.is_own(values[full_name])
    }
    for layer in scene.layers.values():
        if layer.material in SOLIDS and not SOLIDS.is_own(layer.material):
            laws[f"solid {layer.material}"] = source_text(SOLIDS[layer.material])
    laws |= {f"materials.{name}": source_text(material) for name, material in scene.materials.items()}
    return hashlib.sha256(json.dumps([code_digest(), laws, values], sort_keys=True).encode()).hexdigest()


def _content(value: object) -> Any:
    """A value without the name of a file that it came from."""
    if isinstance(value, TimeSeries):
        return value.content
    if isinstance(value, tuple):
        return [_content(entry) for entry in value]
    if isinstance(value, Table):
        return {name: _content(part) for name, part in value}
    return str(value) if isinstance(value, Part) else value
