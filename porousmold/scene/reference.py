"""The page of all keys of a scene (`docs/scene.md`)."""

from collections.abc import Mapping

from ..errors import InputError
from .features import KEYS
from .keys import WITHOUT_UNIT, Key


def reference(only: str | None = None) -> str:
    """Markdown page of every key, or of those of one table: unit or kind, default, bounds or choices, meaning.

    Raises `InputError` for a table that is none.
    """
    if only is not None and only not in KEYS:
        raise InputError("TABLE", only, f"must be one of {', '.join(KEYS)}")
    lines = [
        "# Keys of a scene",
        "",
        'Written by `porousmold keys`. Numbers are SI, or texts with a unit (`"5 mm"`, `"90 degC"`, `"8 kPa"`). Keys marked',
        "with * also take a CSV file `time [s], name [unit]`. A property in a unit or % is a constant in place of the",
        'material\'s (`"2 W/(m K)"`), or a part of its law (`"105 %"`). Paths are relative to the scene\'s file. Materials of',
        "your own: [materials.md](materials.md).",
    ]
    for table, keys in KEYS.items():
        if only not in (None, table):
            continue
        lists = {name: key for name, key in keys.items() if key.kind == "list"}
        if len(lists) < len(keys):
            lines += _section(f"[{table}]", {name: key for name, key in keys.items() if name not in lists})
        for name, key in lists.items():
            full_name = f"{table}.{name}".removesuffix(".list")
            lines += _section(f"[[{full_name}]]", key.entries, key.meaning)
    return "\n".join(lines) + "\n"


def _section(title: str, keys: Mapping[str, Key], meaning: str = "") -> list[str]:
    lines = ["", f"## {title}", *(["", f"{meaning[0].upper()}{meaning[1:]}."] if meaning else [])]
    lines += ["", "| key | kind | default | allowed | meaning |", "|---|---|---|---|---|"]
    for name, key in keys.items():
        unit_of_key = f"{key.kind} or %" if key.of_law else key.kind
        kind = {"delta_degC": "K", "": "number", "tolerance": f"% or {key.tolerated or 'number'}"}.get(
            key.kind, unit_of_key
        )
        allowed = ", ".join(f"`{choice}`" for choice in key.choices)
        if not allowed and (key.kind == "integer" or key.kind not in WITHOUT_UNIT):
            allowed = key.allowed().removeprefix("must be ").removesuffix(f" {kind}")
        shown = str(key.default).lower() if key.kind == "flag" else key.default
        default = "" if key.default is None else f"`{shown}`"
        lines.append(f"| {name}{'*' if key.series else ''} | {kind} | {default} | {allowed} | {key.meaning} |")
    return lines
