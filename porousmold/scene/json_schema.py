"""JSON Schema (draft 2020-12) of a scene file, from the same keys that check it: for editors that complete and check TOML."""

from collections.abc import Mapping
from typing import Any

from .features import KEYS
from .keys import INFINITY, Key

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def scene_schema() -> dict[str, Any]:
    """The schema of a scene, wider than the program's own checks: units, files, and what keys must be together are not in it, and
    any text is allowed where a number with a unit or a material of the scene's own may stand."""
    tables = {name: _table(keys) for name, keys in KEYS.items()}
    tables["target"] = _key(KEYS["target"]["list"])
    tables["materials"] = {"type": "object", "description": "materials of the scene's own, by name"}
    return {
        "$schema": DIALECT,
        "title": "Scene of porousmold",
        "type": "object",
        "properties": tables,
        "required": ["geometry", "bed", "operation"],
        "additionalProperties": False,
    }


def _table(keys: Mapping[str, Key]) -> dict[str, Any]:
    return {"type": "object", "properties": {n: _key(key) for n, key in keys.items()}, "additionalProperties": False}


def _key(key: Key) -> dict[str, Any]:
    found: dict[str, Any] = {"description": f"{key.meaning} [{key.unit}]" if key.unit else key.meaning}
    if key.default is not None:
        found["default"] = key.default
    if key.kind == "choice":
        return found | {"type": "string"} | ({} if "material" in key.meaning else {"enum": sorted(key.choices)})
    if key.kind == "list":
        return found | {"type": "array", "items": _table(key.entries)}
    if key.kind == "names":
        return found | {"type": "object", "additionalProperties": {"type": "string"}}
    if key.kind in ("file", "text", "line"):
        return found | {"type": "string"}
    if key.kind == "flag":
        return found | {"type": "boolean"}
    number: dict[str, Any] = {"type": "integer" if key.kind == "integer" else "number"}
    for bound, value in (("minimum", key.low), ("maximum", key.high)):
        if abs(value) < INFINITY:
            number[bound if key.closed else f"exclusive{bound.capitalize()}"] = value
    return found | {
        "anyOf": [number, {"type": "string"}, *([{"type": "array"}, {"type": "object"}] if key.series else [])]
    }
