"""The folder of a run: result.json, history.csv, near_wall.csv, fields.h5 + fields.xdmf, scene.toml."""

import csv
import json
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import tomli_w
from dolfinx import io

from ..errors import InputError, OutputError
from ..files.atomic_files import Lock, locked, whole_file
from ..files.tables import text_cells
from ..files.xdmf import one_grid_a_time
from ..mesh import fenicsx
from ..mesh.aliases import Communicator, Mesh
from ..scene.scene import Scene
from ..solvers.state import Stateful
from .checkpoint import NAME, Checkpoint, NodeOrders, packed, read
from .quantities import Columns
from .result_keys import Summary
from .stored import LOCK, checksum_of, read_table

COMPARISON = ("comparison.json", "comparison.png")
OUTPUTS = [
    *("result.json", "history.csv", "near_wall.csv", "fields.h5", "fields.xdmf", "scene.toml"),
    *(
        f"{picture}.{kind}"
        for picture in ("profiles", "temperatures", "near_wall", "fields", "skin", "surface", "supply")
        for kind in ("png", "pdf", "svg")
    ),
    *("profiles.csv", "heating.gif", *COMPARISON, "report.html", NAME),
]
FIELDS_PART = ".fields.part"
"""Folder in which the two files of the fields are written, to take their places together."""


class RunFolder:
    """A folder that a run writes, held against other processes until `close()`.

    Made at once, so that one that cannot be written is found before the run: `InputError`; gone if it is empty at the end. Files
    of an older run go, as they would pass for this one's, unless it is `kept` to go on from.
    """

    def __init__(self, path: str | Path, communicator: Communicator, *, kept: bool = False) -> None:
        self.path, self._communicator = Path(path), communicator
        self._orders: Any = None
        self._lock: Lock | None = None
        with self._on_first_rank() as first:
            if first:
                if self.path.is_file():
                    raise OSError("it is a file")
                self._lock = locked(self.path / LOCK)
        if not kept:
            self.clear()

    def clear(self) -> None:
        """Take away the files of a run."""
        with self._on_first_rank() as first:
            if first:
                shutil.rmtree(self.path / FIELDS_PART, ignore_errors=True)
                for name in OUTPUTS:
                    (self.path / name).unlink(missing_ok=True)

    @contextmanager
    def _on_first_rank(self) -> Iterator[bool]:
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

    @contextmanager
    def _in_run(self) -> Iterator[bool]:
        """As `_on_first_rank`, of what the run writes, on any rank: ends in an `OutputError`."""
        problem = None
        try:
            yield self._communicator.rank == 0
        except (OSError, RuntimeError) as error:  # the HDF5 library's is the latter
            problem = error
        problem = next((found for found in self._communicator.allgather(problem) if found is not None), None)
        if problem is not None:
            self.close()
            raise OutputError(self.path, problem, "with room there, --resume goes on from what is saved")

    def close(self) -> None:
        """Let other processes have the folder."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def require(self, size: float) -> None:
        """Refuse (`InputError`) a disk without room for `size` bytes (collective)."""
        with self._on_first_rank() as first:
            if first and shutil.disk_usage(self.path).free < size:
                raise OSError(f"the disk has less than {size / 2**20:.0f} MiB left")

    def refuse_to_replace(self) -> None:
        """Refuse (`InputError`) to take the place of a run that is done or was interrupted here (collective)."""
        found = None
        if self._communicator.rank == 0:
            with suppress(OSError, ValueError):
                summary = json.loads((self.path / "result.json").read_text(encoding="utf-8"))
                whole = isinstance(summary, dict) and (self.path / "history.csv").is_file()
                found = summary.get("status") if whole else None
            if (self.path / NAME).is_file() and found != "failed":
                found = "interrupted"
        found = self._communicator.bcast(found)
        refusals = {
            "done": "holds the finished run of another scene, or of other program code: --force replaces it",
            "interrupted": "holds an interrupted run: --resume goes on with it, --force replaces it",
        }
        if found in refusals:
            self.close()
            raise InputError("--out", str(self.path), refusals[found])

    def finished(self, identity: str) -> tuple[dict[str, Any], Columns] | None:
        """Summary and history of the run of this identity that was done here, else None (collective). Raises `InputError` where
        they are no longer what was written."""
        found, damaged = None, False
        if self._communicator.rank == 0:
            with suppress(OSError, ValueError, LookupError):
                summary = json.loads((self.path / "result.json").read_text(encoding="utf-8"))
                same = isinstance(summary, dict) and summary.get("identity") == identity
                if same and summary.get("status") == "done":
                    written = summary.pop("checksum", None)
                    found = summary, read_table(self.path / "history.csv")
                    damaged = written != checksum_of(summary, self.path)
        found, damaged = self._communicator.bcast((found, damaged))
        if damaged:
            self.close()
            raise InputError(
                "--out", str(self.path), "has tables that are not what was written: --force computes them again"
            )
        return found

    def saved(self) -> Checkpoint | None:
        """The checkpoint here (collective); None where there is none."""
        return read(self.path / NAME, self._communicator)

    def save(self, part: Stateful, outcomes: list[Any], identity: str) -> None:
        """Write the checkpoint, whole or not at all (collective)."""
        if self._orders is None or self._orders[0] is not part:
            self._orders = part, NodeOrders()
        content = packed(part, outcomes, self._orders[1], identity, self._communicator.rank)
        with self._in_run() as first:
            if first and content is not None:
                with whole_file(self.path / NAME) as temporary:
                    temporary.write_bytes(content)

    def forget_checkpoint(self) -> None:
        """After the run has ended well."""
        if self._communicator.rank == 0:
            (self.path / NAME).unlink(missing_ok=True)

    def write_tables(self, history: Columns, near_wall: Columns | None, profiles: Columns | None = None) -> None:
        """The history, the profile near the wall, and those along the bed at the ends of phases (rank 0 writes)."""
        with self._in_run() as first:
            if first:
                for name in COMPARISON:  # of an earlier part of the run
                    (self.path / name).unlink(missing_ok=True)
                self._write_table("history.csv", history)
                if near_wall is not None:
                    self._write_table("near_wall.csv", near_wall)
                if profiles is not None:
                    self._write_table("profiles.csv", profiles)

    def write_summary(self, summary: Summary, scene: Scene, accuracy: float | None = None) -> None:
        """scene.toml and, when all else is there, result.json (rank 0 writes); an `accuracy` chose the scene's refinements."""
        chosen = "" if accuracy is None else f"# solver.accuracy = {accuracy:g} chose the refinements in [solver]\n"
        with self._in_run() as first:
            if first:
                self._replace("scene.toml", chosen + tomli_w.dumps(scene.as_tables()))
                content = {**summary, "checksum": checksum_of(summary, self.path)}
                self._replace("result.json", json.dumps(content, indent=2) + "\n")

    def _write_table(self, name: str, table: Columns) -> None:
        with whole_file(self.path / name) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(text_cells(f"{column} [{unit}]" for column, unit in table.units.items()))
            writer.writerows(zip(*table.columns.values(), strict=True))

    def _replace(self, name: str, text: str) -> None:
        with whole_file(self.path / name) as temporary:
            temporary.write_text(text, encoding="utf-8")

    def write_fields(self, mesh: Mesh, snapshots: Iterable[tuple[float, Sequence[Any]]]) -> None:
        """fields.xdmf and fields.h5 of functions at times (s) (collective)."""
        part = self.path / FIELDS_PART
        with self._in_run() as first:
            if first:
                shutil.rmtree(part, ignore_errors=True)
                part.mkdir()
        with self._in_run(), io.XDMFFile(mesh.comm, str(part / "fields.xdmf"), "w") as file:
            fenicsx.write_mesh(file, mesh)
            for time, functions in snapshots:
                for function in functions:
                    file.write_function(function, time)
        with self._in_run() as first:
            if first:  # fields.xdmf names fields.h5, which is to be there before it
                one_grid_a_time(part / "fields.xdmf")
                for name in ("fields.h5", "fields.xdmf"):
                    (part / name).replace(self.path / name)
                part.rmdir()
