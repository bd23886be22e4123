"""Read access to the folder of a run: its lock and its tables. No dolfinx."""

import csv
import hashlib
import json
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..files.atomic_files import Lock, locked
from .quantities import Columns
from .result_keys import Summary

LOCK = ".lock"
"""File that a process which writes the folder holds."""


def locked_folder(folder: Path, purpose: str) -> Lock:
    """The lock of a run's folder, held until it is closed; `InputError` where it cannot be had, so that nothing can be
    `purpose` ("drawn", ...)."""
    try:
        folder.stat()  # none is made
        return locked(folder / LOCK)
    except OSError as error:
        raise InputError("RUN", str(folder), f"cannot be {purpose}: {error.strerror or error}") from error


def read_table(path: Path) -> Columns:
    """A table that `folder.RunFolder` wrote."""
    with Path(path).open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    names = [cell.split(" [")[0] for cell in head]
    return Columns({name: [float(row[i]) for row in rows] for i, name in enumerate(names)})


def require_run(folder: Path, key: str = "RUN") -> None:
    """Raise `InputError` naming the key for a folder whose result.json is not that of `porousmold run`, or which is no longer as
    that has written it."""
    if not (folder / "result.json").is_file():
        return
    if not (folder / "scene.toml").is_file():
        raise InputError(
            key, str(folder), "is the folder of another command than `porousmold run`: it has no scene.toml"
        )
    try:
        summary = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        is_as_written = summary.get("checksum") == checksum_of(summary, folder)
    except (OSError, ValueError, AttributeError) as error:
        raise InputError(key, str(folder), "has a damaged result.json: run the scene again") from error
    if not is_as_written:
        raise InputError(key, str(folder), "has tables that are not what was written: run the scene again")


def read_study(folder: Path) -> tuple[list[dict[str, Any]], list[str]]:
    """Cases (entries of table.json) and head (of table.csv) of the folder of a study; raises `InputError` if it is damaged."""
    try:
        entries = json.loads((folder / "table.json").read_text(encoding="utf-8"))
        with (folder / "table.csv").open(newline="", encoding="utf-8") as file:
            head = next(csv.reader(file))
        if not all(isinstance(entry, dict) and "status" in entry for entry in entries):
            raise ValueError("a case without a status")
    except (OSError, ValueError, TypeError, StopIteration) as error:
        raise InputError("RUN", str(folder), f"has a damaged table: {error}") from error
    return entries, head


def checksum_of(summary: Summary, folder: Path) -> str:
    """SHA-256 of the content of result.json, but for itself, and of history.csv, if that is there."""
    content = json.dumps({name: value for name, value in summary.items() if name != "checksum"})
    text = json.dumps(json.loads(content), sort_keys=True)
    history = folder / "history.csv"
    return hashlib.sha256(text.encode() + (history.read_bytes() if history.is_file() else b"")).hexdigest()
