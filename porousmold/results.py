"""The folder of a run: result.json, history.csv, near_wall.csv, fields.h5 + fields.xdmf, scene.toml."""

import csv
import json
import shutil
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import tomli_w
from dolfinx import io

from . import fenicsx
from .checkpoint import NAME, NodeOrders, fingerprint, packed, read
from .errors import InputError
from .observation import field_snapshots, profile_near_wall
from .whole_files import held, whole_file

COMPARISON = ("comparison.json", "comparison.png")
OUTPUTS = [
    *("result.json", "history.csv", "near_wall.csv", "fields.h5", "fields.xdmf", "scene.toml"),
    *("temperatures.png", "near_wall.png", "fields.png", *COMPARISON, "report.html", NAME),
]
LOCK = ".lock"
"""File that a process which writes the folder holds."""
FIELDS_PART = ".fields.part"
"""Folder in which the two files of the fields are written, to take their places together."""


def hold(folder, purpose):
    """The lock of a run's folder, held until it is closed; `InputError` where it cannot be had, so that nothing can be
    `purpose` ("drawn", ...)."""
    try:
        return held(folder / LOCK)
    except OSError as error:
        raise InputError("RUN", str(folder), f"cannot be {purpose}: {error.strerror or error}") from error


class RunFolder:
    """A folder that a run writes, held against other processes until `close()`.

    Made at once, so that one that cannot be written is found before the run: `InputError`. Files of an older run go, as they
    would pass for this one's, unless it is `kept` to go on from.
    """

    def __init__(self, path, communicator, *, kept=False):
        self.path, self._communicator = Path(path), communicator
        self._orders: Any = None
        self._lock = None
        with self._on_first_rank() as first:
            if first:
                self.path.mkdir(parents=True, exist_ok=True)
                self._lock = held(self.path / LOCK)
        if not kept:
            self._clear()

    def _clear(self):
        with self._on_first_rank() as first:
            if first:
                shutil.rmtree(self.path / FIELDS_PART, ignore_errors=True)
                for name in OUTPUTS:
                    (self.path / name).unlink(missing_ok=True)

    @contextmanager
    def _on_first_rank(self):
        """Whether this rank is to write; an `OSError` there ends in an `InputError` on every rank (collective)."""
        problem = None
        try:
            yield self._communicator.rank == 0
        except OSError as error:
            problem = f"cannot be written: {error.strerror or error}"
        problem = self._communicator.bcast(problem)
        if problem:
            self.close()
            raise InputError("--out", str(self.path), problem)

    def close(self):
        """Let other processes have the folder."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def require(self, size):
        """Refuse (`InputError`) a disk without room for `size` bytes (collective)."""
        with self._on_first_rank() as first:
            if first and shutil.disk_usage(self.path).free < size:
                raise OSError(f"the disk has less than {size / 2**20:.0f} MiB left")

    def finished(self, scene):
        """Summary, history and its units of a run of this very scene that was done here, else None (collective)."""
        summary = None
        if self._communicator.rank == 0:
            with suppress(OSError, ValueError, LookupError):
                found = json.loads((self.path / "result.json").read_text(encoding="utf-8"))
                same = isinstance(found, dict) and found.get("fingerprint") == fingerprint(scene)
                if same and found.get("status") == "done":
                    summary = found, *read_table(self.path / "history.csv")
        return self._communicator.bcast(summary)

    def saved(self):
        """(fingerprint, `Saved`) of the checkpoint here (collective); None where there is none: the folder is then emptied."""
        found = read(self.path / NAME, self._communicator)
        if found is None:
            self._clear()
        return found

    def save(self, simulation, outcomes, mark):
        """Write the checkpoint, whole or not at all (collective)."""
        if self._orders is None or self._orders[0] is not simulation:
            self._orders = simulation, NodeOrders()
        content = packed(simulation, outcomes, self._orders[1], mark)
        with self._on_first_rank() as first:
            if first:
                with whole_file(self.path / NAME) as temporary:
                    temporary.write_bytes(content)

    def forget_checkpoint(self):
        """After the run has ended well."""
        if self._communicator.rank == 0:
            (self.path / NAME).unlink(missing_ok=True)

    def write_data(self, simulation):
        """Tables and fields (collective)."""
        profile = profile_near_wall(simulation.problem)
        with self._on_first_rank() as first:
            if first:
                for name in COMPARISON:  # of an earlier part of the run
                    (self.path / name).unlink(missing_ok=True)
                history = simulation.history
                self._write_table("history.csv", history.columns, history.units)
                if profile is not None:
                    self._write_table("near_wall.csv", *profile)
        if simulation.scene.output.fields:
            self._write_fields(simulation)

    def write_summary(self, summary, scene):
        """scene.toml and, when all else is there, result.json (rank 0 writes)."""
        with self._on_first_rank() as first:
            if first:
                self._replace("scene.toml", tomli_w.dumps(scene.as_tables()))
                self._replace("result.json", json.dumps(summary, indent=2) + "\n")

    def _write_table(self, name, columns, units):
        with whole_file(self.path / name) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow([f"{column} [{units[column]}]" for column in columns])
            writer.writerows(zip(*columns.values(), strict=True))

    def _replace(self, name, text):
        with whole_file(self.path / name) as temporary:
            temporary.write_text(text, encoding="utf-8")

    def _write_fields(self, simulation):
        part = self.path / FIELDS_PART
        with self._on_first_rank() as first:
            if first:
                shutil.rmtree(part, ignore_errors=True)
                part.mkdir()
        with io.XDMFFile(simulation.problem.domain.communicator, str(part / "fields.xdmf"), "w") as file:
            fenicsx.write_mesh(file, simulation.problem.domain.mesh)
            for time, functions in field_snapshots(simulation.problem, simulation.snapshots, simulation.time):
                for function in functions:
                    file.write_function(function, time)
        with self._on_first_rank() as first:
            if first:  # fields.xdmf names fields.h5, which is to be there before it
                for name in ("fields.h5", "fields.xdmf"):
                    (part / name).replace(self.path / name)
                part.rmdir()


def read_table(path):
    """Columns and units of a table that `RunFolder` wrote: ({name: list of floats}, {name: unit})."""
    with Path(path).open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    names = [cell.split(" [")[0] for cell in head]
    units = {name: cell.split("[")[1].rstrip("]") for name, cell in zip(names, head, strict=True)}
    columns = {name: [float(row[i]) for row in rows] for i, name in enumerate(names)}
    return columns, units
