"""Runs of a column of beads: progress, checkpoints on the way, and the pictures of an animation."""

import argparse
import json
import math
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from time import monotonic
from typing import Any
from zipfile import BadZipFile

import numpy as np

from ..errors import InputError, SolveError
from ..files.atomic_files import InUseError, locked
from ..files.stop_signals import StopSignals
from ..files.units import to_si
from ..output.console import SECONDS_AND_PARTS, Bar
from ..scene.identity import COMPUTING, code_digest

INTERVAL = 20.0
"""Seconds between checkpoints."""
FRAMES = 80
"""Of an animation."""


def add_run_options(command: argparse.ArgumentParser, name: str, animation: str) -> None:
    """What the commands that integrate a column have in common; `name` is that of the default folder."""
    command.add_argument("--time", default="1 s", metavar="VALUE", help="simulated (default 1 s)")
    command.add_argument("--seed", default="1", metavar="VALUE", help="same seed, same packing")
    command.add_argument("--out", default=f"runs/{name}", metavar="DIR", help=f"folder to write (default runs/{name})")
    command.add_argument("--force", action="store_true", help="replace the result of another column in the folder")
    command.add_argument("--animate", action="store_true", help=f"also {animation}")
    command.add_argument("--quiet", action="store_true", help="no progress bar, no summary")


def ran(kind: Any, given: object, write: Callable[[Any, Path, list[Any]], str], options: argparse.Namespace) -> str:
    """Integrate a column of a `kind` (a class), or go on from the checkpoint in its folder, and have `write` put there what came
    out of it, given the column, the folder and the pictures of its animation; gives its text.

    Raises `InputError` for --time that is not above 0, for a checkpoint of something else, for a folder in use and, unless it is
    to be replaced, for one with the result of another column; `SolveError` after what there is has been written,
    KeyboardInterrupt when it is stopped."""
    end, out = to_si("--time", options.time, "s"), Path(options.out)
    if not 0.0 < end < 1e4:
        raise InputError("--time", options.time, "must be > 0 and < 10000 s")
    try:
        lock = locked(out / ".lock")
    except InUseError as error:
        raise InputError("--out", str(out), "is in use by another run of porousmold") from error
    except OSError as error:
        raise InputError("--out", str(out), f"cannot be written: {error.strerror or error}") from error
    with lock:
        if not options.force and is_of_another(out, given):
            raise InputError("--out", str(out), "holds the result of another column: use --force to replace it")
        return _integrated(kind, given, write, options, end, out)


def is_of_another(out: Path, given: object) -> bool:
    """Whether the result in a folder is not that of what is given."""
    try:
        known = json.loads((out / "result.json").read_text(encoding="utf-8")).get("input")
    except FileNotFoundError:
        return False
    except (OSError, ValueError, AttributeError):
        return True
    return bool(known != json.loads(json.dumps(asdict(given))))


def _integrated(
    kind: Any,
    given: Any,
    write: Callable[[Any, Path, list[Any]], str],
    options: argparse.Namespace,
    end: float,
    out: Path,
) -> str:
    signals, bar = StopSignals(), Bar(quiet=options.quiet)
    bar.phase("beads come to rest")
    path, identity = out / "checkpoint.npz", f"{given} {code_digest((*COMPUTING, 'packing', 'fluidised'))}"
    saved = read_checkpoint(path, identity, end, given.time_step) if path.is_file() else None
    if end < 0.5 * given.time_step:
        raise InputError("--time", options.time, f"must be >= {0.5 * given.time_step:.3g} s, half a time step")
    column = kind(given) if saved is None else kind.restored(given, saved)
    kept = Kept(column, path, identity, end / FRAMES if options.animate else math.inf, saved)

    def progress(time: float, total: float, text: str) -> None:
        bar.show(round(time, 4), total, text, SECONDS_AND_PARTS)
        kept.look(time)
        if signals:
            kept.save()
            raise KeyboardInterrupt(f"stopped at t = {time:.4g} s; the same command goes on from there")

    problem = None
    try:
        column.integrate(end, progress)
    except SolveError as error:
        if not column.rows:
            raise
        problem = error
    finally:
        bar.close()
    text = write(column, out, kept.pictures)
    path.unlink(missing_ok=True)
    if problem is not None:
        raise problem
    return "" if options.quiet else text


def read_checkpoint(path: Path, identity: str, end: float, time_step: float) -> dict[str, Any]:
    """What is saved there. Raises `InputError` for a file that is damaged, of another column, or after the `end` (s). Steps of
    `time_step` (s) do not meet the end: the last one may pass it by half a step."""
    try:
        with np.load(path) as file:
            saved = {name: file[name] for name in file.files}
        is_another, time = str(saved["identity"]) != identity, float(saved["time"])
    except (OSError, ValueError, LookupError, BadZipFile) as error:
        raise InputError("--out", str(path), f"is damaged; delete it to start anew: {error}") from error
    if is_another:
        allowed = "is a checkpoint of another column, or of other program code; delete it to start anew"
        raise InputError("--out", str(path), allowed)
    if time >= end + 0.5 * time_step:
        raise InputError("--time", end, f"must be >= {time:.6g} s, the time of the checkpoint", str(path))
    return saved


class Kept:
    """A checkpoint on the way, every `INTERVAL`, and pictures of an animation `every` so many simulated seconds."""

    def __init__(self, column: Any, path: Path, identity: str, every: float, saved: dict[str, Any] | None) -> None:
        self._column, self.path, self._identity, self._every = column, path, identity, every
        names = [f"pictured_{name}" for name in ("times", "places", "temperatures")]
        self.pictures = list(zip(*(saved[name] for name in names), strict=True)) if saved is not None else []
        self._last = monotonic()

    def look(self, time: float) -> None:
        """Keep what is due."""
        if math.isfinite(self._every) and (not self.pictures or time >= self.pictures[-1][0] + self._every):
            beads = self._column.beads
            self.pictures.append((time, beads.places, beads.temperature - 273.15))
        if monotonic() > self._last + INTERVAL:
            self.save()

    def save(self) -> None:
        """Write the checkpoint."""
        times, places, warm = zip(*self.pictures, strict=True) if self.pictures else ((), (), ())
        pictures = {"pictured_times": times, "pictured_places": places, "pictured_temperatures": warm}
        more = {name: np.array(values) for name, values in pictures.items()}
        self._column.save(self.path, more | {"identity": np.array(self._identity)})
        self._last = monotonic()
