"""Atomic file writes, and lock files."""

import errno
import fcntl
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from ..errors import InputError, OutputError

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""What the kernel says of a disk, a quota or a file size that is used up, and of a disk that fails."""


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
    """`whole_file` for a file that the user named: `InputError` if it cannot be written, `OutputError` if the disk is full."""
    try:
        with whole_file(path) as temporary:
            yield temporary
    except OSError as error:
        if error.errno in FULL:
            raise OutputError(path, error, "with room there, the same command writes it") from error
        raise InputError("--out", str(path), f"cannot be written: {error.strerror or error}") from error


def output_folder(path: Path) -> Path:
    """Make a folder that the user named, if it is not there; `InputError` if it cannot be made."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError("--out", str(path), f"cannot be written: {error.strerror or error}") from error
    return path


class InUseError(OSError):
    """Another process holds the file."""


class Lock:
    """A file that this process alone holds; `close()` takes it away, and the folders `made` for it that are empty then."""

    def __init__(self, path: Path, file: IO[str], made: Sequence[Path]) -> None:
        self._path, self._file, self._made = path, file, made

    def close(self) -> None:
        """Let others have it; the file is gone."""
        if not self._file.closed:
            self._path.unlink(missing_ok=True)
            self._file.close()
            with suppress(OSError):  # a folder with something in it stays
                for folder in self._made:
                    folder.rmdir()

    def __enter__(self) -> "Lock":
        return self

    def __exit__(self, *problem: object) -> None:
        self.close()


def locked(path: Path, *, wait: bool = False) -> Lock:
    """A `Lock` on a file until it is closed, or the process ends; `InUseError` if another process holds it, or with `wait` when
    that has let it go. Makes the file's folder; `OSError` if it cannot."""
    made = [folder for folder in path.parents if not folder.exists()]
    while True:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = path.open("w")
        try:
            fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except BlockingIOError as error:
            file.close()
            raise InUseError("another process is at work there") from error
        with suppress(FileNotFoundError):
            if os.fstat(file.fileno()).st_ino == path.stat().st_ino:
                return Lock(path, file, made)
        file.close()  # the one that held it took the file away in between
