"""Files that are written whole or not at all, and files that only one process holds."""

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..errors import InputError


@contextmanager
def whole_file(path: Path) -> Iterator[Any]:
    """Gives a temporary path beside `path` to write; it takes the path's place at the end, or is gone if that fails."""
    path = Path(path)
    temporary = path.with_name(f".{path.name}.part")
    try:
        yield temporary
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


@contextmanager
def output_file(path: Path) -> Iterator[Any]:
    """`whole_file` for a file that the user named: `InputError` if it cannot be written."""
    try:
        with whole_file(path) as temporary:
            yield temporary
    except OSError as error:
        raise InputError("--out", str(path), f"cannot be written: {error.strerror or error}") from error


class InUseError(OSError):
    """Another process holds the file."""


def locked(path: Path, *, wait: bool = False) -> Any:
    """An open file that no other process holds until it is closed, or the process ends; `InUseError` if one does, or with
    `wait` when it has ended."""
    lock = path.open("w")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BlockingIOError as error:
        lock.close()
        raise InUseError("another process is at work there") from error
    return lock
