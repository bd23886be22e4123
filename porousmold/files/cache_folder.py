"""The user's folder for compiled forms: one that can be written, what stands there, and what of it nobody uses any more.

FFCx keeps four files of a form: its C text and object file, which nobody reads again, the library, and a mark that this is ready.
"""

import fcntl
import os
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

READY = ".c.cached"
"""Ending of the mark that a form is compiled; its date is that of the last use."""
_REPLACING: list[Path] = []


def cache_home() -> Path:
    """The user's folder for what can be computed again (XDG base directories)."""
    return Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))


def provide_cache() -> None:
    """Have a folder for compiled forms that can be written, before dolfinx asks for it: where the user's cannot, as in a
    container or on a compute node without a home, a private one for temporary files."""
    folder = cache_home() / "fenics"
    if folder.is_absolute():  # a user without a home has ~ itself
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
        if os.access(folder, os.W_OK | os.X_OK):
            return
    with suppress(OSError):
        os.environ["XDG_CACHE_HOME"] = str(_private_folder())
        os.environ.setdefault("MPLCONFIGDIR", str(Path(os.environ["XDG_CACHE_HOME"]) / "matplotlib"))
        _REPLACING.append(cache_home())


def _private_folder() -> Path:
    """A folder for temporary files that nobody else can write: always the same one, unless somebody has taken its name."""
    folder = Path(tempfile.gettempdir()) / f"porousmold-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    status = folder.lstat()
    if stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid() and not status.st_mode & 0o077:
        return folder
    return Path(tempfile.mkdtemp(prefix="porousmold-"))


def replacing_cache() -> Path | None:
    """The folder that stands in for the user's; None where that can be written, and when it was told before."""
    return _REPLACING.pop() if _REPLACING else None


class Contents(NamedTuple):
    """How many forms a folder holds, their size in bytes, and that of files that nobody reads again."""

    forms: int
    size: int
    needless: int


def contents(folder: Path) -> Contents:
    """Of a folder of compiled forms."""
    sizes = {path: path.stat().st_size for path in _files(folder)}
    needless = sum(
        size for path, size in sizes.items() if path.suffix == ".o" or (path.suffix == ".c" and _is_ready(path))
    )
    return Contents(sum(path.name.endswith(READY) for path in sizes), sum(sizes.values()), needless)


def prune(folder: Path, unused: float) -> Contents:
    """Take away forms that have not been used for so many seconds, and what nobody reads of the others; gives what is left.

    A form that is being compiled is left alone, whoever compiles it.
    """
    oldest = time.time() - unused
    for mark in [path for path in _files(folder) if path.name.endswith(READY)]:
        module = mark.name.removesuffix(READY)
        with _held(folder / f"{module}.lock") as is_held:
            if not is_held:
                continue
            if mark.stat().st_mtime < oldest:
                mark.unlink()
                for path in folder.glob(f"{module}.*"):
                    if path.suffix != ".lock":  # who waits for it holds that very file
                        path.unlink()
                continue
            (folder / f"{module}.o").unlink(missing_ok=True)
            os.truncate(folder / f"{module}.c", 0)
        (folder / f"{module}.lock").unlink(missing_ok=True)
    for path in (folder / "known").glob("*"):
        path.unlink()
    return contents(folder)


@contextmanager
def _held(lock: Path) -> Iterator[bool]:
    with lock.open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield False
        else:
            yield True


def _is_ready(text: Path) -> bool:
    return text.with_name(f"{text.name}.cached").exists()


def _files(folder: Path) -> list[Path]:
    return [path for path in folder.glob("libffcx_*") if path.is_file()]
