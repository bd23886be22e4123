"""The cache of compiled forms, shared by processes that may be killed: who compiles a form, and its module once it is there."""

import contextlib
import fcntl
import importlib.machinery
import importlib.util
import os
import time
from pathlib import Path
from typing import Any

LOCK_INTERVAL = 0.05
"""Seconds between two looks at what another process compiles."""
_LOCKS: list[Any] = []
"""Open locks on what this process compiles: the system frees them when it ends, however it ends."""


def claim(module_name: str, cache: Path) -> None:
    """Return once a module stands in the cache, or once it is this process's to compile.

    FFCx takes an unfinished C file for the work of another process and waits for it, minutes if that was killed. Who compiles
    holds a lock on the file's name; who gets it finds the work of a process that is gone, and clears it away.
    """
    cache.mkdir(parents=True, exist_ok=True)
    begun, ready = (cache / f"{module_name}{ending}" for ending in (".c", ".c.cached"))
    if ready.exists():
        with contextlib.suppress(OSError):
            os.utime(ready)  # the date of its last use
        return
    lock = open(cache / f"{module_name}.lock", "w")  # noqa: SIM115
    while not ready.exists():
        with contextlib.suppress(BlockingIOError):
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if not ready.exists():
                begun.unlink(missing_ok=True)
            _LOCKS.append(lock)
            return
        time.sleep(LOCK_INTERVAL)
    lock.close()


def compiled_module(name: str, cache: Path) -> Any:
    """A module that stands ready in the cache; None for one that does not.

    FFCx lists the whole folder for every form: 30 ms each where 14 000 forms are kept, three seconds of a run.
    """
    if not (cache / f"{name}.c.cached").exists():
        return None
    paths = (cache / f"{name}{suffix}" for suffix in importlib.machinery.EXTENSION_SUFFIXES)
    path = next((path for path in paths if path.exists()), None)
    spec = None if path is None else importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        return None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
