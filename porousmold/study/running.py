"""Runs the cases of a study: serially, by the ranks of `mpirun` as workers, or by the tasks of an array job.

Each group of ranks (one, or `--group M`) goes through the list of cases and computes each case that is neither finished nor
claimed by another group; there is no coordinating rank. A case is claimed by a lock on a file in its folder. The lock is
released when its process ends, so that the next start recomputes the cases of a killed worker.
"""

import csv
import io
import json
import os
import re
import signal
import tempfile
import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from ..errors import InputError, OutputError, SolveError
from ..files.atomic_files import InUseError, locked, whole_file
from ..files.subprocesses import forked
from ..files.tables import text_cells
from ..files.units import to_si
from ..mpi import IS_ALONE, MPI
from ..output.stored import checksum_of
from ..scene.features import KEYS
from ..scene.features.geometries import dimension_of
from ..scene.identity import identity_of
from ..scene.keys import WITHOUT_UNIT, key_of
from ..scene.scene import Scene
from ..scene.tables import as_toml
from ..simulation.running import RunInterrupted, run
from .definition import Case, Study, unit_of_record

MISSING, BEGUN = "missing", "begun"
SECONDS_BETWEEN_LOOKS = 0.5
GO_ON = "with room there, the same command goes on"


NOT_REACHED = re.compile("not heated to|not cooled to|target .* not met ")
"""Warnings of a run that does not reach what it waits for."""
ANSWERS = re.compile(r"heating_time(_bed_side)?$|targets\.")
"""Names of what a row tells that it has not."""
IN_DOUBT = re.compile("coarser cells and steps move|; a finer mesh shows it$|it may as well be")
"""Warnings of a run whose cells may be too few, or whose target hangs on less than the error."""


@dataclass(frozen=True)
class Row:
    """What came of a case: `status` is done, failed, refused or missing, `values` what is recorded (None where not there)."""

    case: Case
    status: str
    reason: str
    values: dict[str, Any]

    @property
    def is_reached(self) -> bool:
        """Whether it has run, and reached what it waits for."""
        return self.status == "done" and NOT_REACHED.search(self.reason) is None


def run_study(
    study: Study,
    out: Path,
    *,
    group: int = 1,
    part: tuple[int, int] = (1, 1),
    progress: Callable[[int], None] | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> list[Row]:
    """Run what is missing of a study (collective over all ranks) and give its rows on every rank.

    A single process of its own (`mpi.IS_ALONE`) forks others, one for each core, where the scenes are of two dimensions.
    group: ranks per case. part: (i, n) takes every n-th case from the i-th. progress: called on rank 0 as progress(cases
    ended) whenever it looks. stop: as for `run`; the rows that are there are given. Raises `InputError` if the folder cannot
    be written or `group` does not fit.
    """
    world, out = MPI.COMM_WORLD, Path(out)
    if not 1 <= group <= world.size:
        raise InputError("--group", group, f"must be from 1 to {world.size}, the number of ranks")
    _make_folder(out, world)
    workers = world.Split(world.rank // group, world.rank)
    cases = study.cases[part[0] - 1 :: part[1]]

    looked = [0.0]

    def show() -> None:
        if progress and world.rank == 0:
            progress(sum(row_of(case, out, study.record).status != MISSING for case in cases))
            looked[0] = clock.monotonic()

    def report(*_: object) -> None:
        if clock.monotonic() > looked[0] + SECONDS_BETWEEN_LOOKS:
            show()

    def work(stop: Callable[[], bool], report: Callable[..., None]) -> str | None:
        return _work_through(study, cases, out, workers, report, stop)

    children = _children(study, cases, out, work) if world.size == 1 and part == (1, 1) else []
    problem = work(stop, report)
    while children and not problem and not stop():
        children = [child for child in children if os.waitpid(child, os.WNOHANG) == (0, 0)]
        report()
        clock.sleep(0.05)
    for child in children:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    problem = problem or work(stop, report)  # what a child has left, if it died
    problems = [text for text in world.allgather(problem) if text]
    if problems:
        raise OutputError(out, problems[0], GO_ON)
    show()
    return collect(study, out)


def _children(study: Study, cases: Sequence[Case], out: Path, work: Callable[..., Any]) -> list[int]:
    """Numbers of processes that work through the missing cases beside this one, a core each."""
    missing = [
        case.scene for case in cases if case.scene is not None and row_of(case, out, study.record).status == MISSING
    ]
    if not IS_ALONE or any(dimension_of(scene.geometry) == 3 for scene in missing):  # one of those fills the memory
        return []
    count = min(len(os.sched_getaffinity(0)), len(missing)) - 1
    return [forked(partial(work, lambda: False, lambda *_: None)) for _ in range(count)]


def _work_through(
    study: Study,
    cases: Sequence[Case],
    out: Path,
    workers: MPI.Comm,
    report: Callable[..., None],
    stop: Callable[[], bool],
) -> str | None:
    """Run every case that is missing and not taken; gives what kept one from being written (collective)."""
    problem = None
    for case in cases:
        if workers.bcast(bool(stop())):
            break
        claim, problem = _take(case, out, study.record, workers)
        if problem:
            break
        if claim is None:
            continue
        try:
            problem = _run_case(case, out, workers, report, stop)
        except RunInterrupted:
            break
        finally:
            claim.close()
        problem = problem or _on_leader(workers, write_tables, study, out)[1]
        if problem:
            break
        report()
    return problem


def _on_leader(workers: MPI.Comm, action: Callable[..., Any], *arguments: object) -> tuple[Any, ...]:
    """(what the action gives on the group's rank 0, None on the others; what an `OSError` there says, on all of them)."""
    result = problem = None
    if workers.rank == 0:
        try:
            result = action(*arguments)
        except OSError as error:
            problem = error.strerror or str(error)
    return result, workers.bcast(problem)


def collect(study: Study, out: Path) -> list[Row]:
    """The rows of a study as they stand in its folder, written to table.csv and table.json (collective)."""
    world, out = MPI.COMM_WORLD, Path(out)
    rows, problem = _on_leader(world, write_tables, study, out)
    if problem:
        raise OutputError(out, problem, GO_ON)
    return world.bcast(rows)


def _make_folder(out: Path, world: MPI.Comm) -> None:
    problem = None
    if world.rank == 0:
        try:
            out.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=out):
                pass
        except OSError as error:
            problem = f"cannot be written: {error.strerror}"
    problem = world.bcast(problem)
    if problem:
        raise InputError("--out", str(out), problem)


class _NoClaim:
    """What the other ranks of a group hold."""

    def close(self) -> None:
        """Nothing to let go."""


def _take(case: Case, out: Path, record: Sequence[str], workers: MPI.Comm) -> tuple[Any, ...]:
    """A claim on a case that is missing and not taken, else None; and what kept it from being made (collective)."""
    claim, problem = _on_leader(workers, _claim, case, out, record)
    taken = workers.bcast(claim is not None)
    return (claim or _NoClaim()) if taken else None, problem


def _claim(case: Case, out: Path, record: Sequence[str]) -> Any:
    if row_of(case, out, record).status != MISSING:
        return None
    try:
        claim = locked(out / case.name / ".claim")
    except InUseError:
        return None
    if row_of(case, out, record).status != MISSING:  # done by another in the meantime
        claim.close()
        return None
    return claim


def _run_case(
    case: Case, out: Path, workers: MPI.Comm, report: Callable[..., None], stop: Callable[[], bool]
) -> str | None:
    """Run a case and record its outcome in its folder; gives what kept that from being written."""
    folder, status, reason = out / case.name, "refused", case.reason
    if case.scene is not None:
        recorded = _recorded(folder)  # what is done, but no longer as it was written, begins anew
        begun = workers.bcast(recorded.get("identity") == identity(case) and recorded.get("status") == BEGUN)
        problem = _on_leader(workers, _record_outcome, case, folder, BEGUN, "")[1]
        if problem:
            return problem
        status, reason = _outcome(case.scene, folder, workers, report, stop, begun)
    return _on_leader(workers, _record_outcome, case, folder, status, reason)[1]


def _outcome(
    scene: Scene,
    folder: Path,
    workers: MPI.Comm,
    report: Callable[..., None],
    stop: Callable[[], bool],
    resume: bool,
) -> tuple[str, str]:
    try:
        run(scene, folder, workers, progress=report, stop=stop, resume=resume, force=True)
        return "done", ""
    except SolveError as error:
        return "failed", str(error)
    except InputError as error:
        if error.key == "--resume":  # a damaged checkpoint is no use
            return _outcome(scene, folder, workers, report, stop, False)
        # what has to do with the folder and not the scene may be otherwise at the next start
        return BEGUN if error.key == "--out" else "refused", str(error)
    except (ArithmeticError, ValueError) as error:  # a fault of the program is a row too, not the end of the study
        if workers.size > 1:  # the others may wait for this rank: what ends all of them has to see it
            raise
        return "failed", f"{type(error).__name__}: {error}"


def _record_outcome(case: Case, folder: Path, status: int, reason: str) -> None:
    content = {"identity": identity(case), "status": status, "reason": reason, "settings": case.settings}
    with whole_file(folder / "case.json") as temporary:
        temporary.write_text(json.dumps(content, indent=2, default=str) + "\n", encoding="utf-8")


def _recorded(folder: Path) -> dict[str, Any]:
    """What stands in the folder's case.json; nothing if that is missing or damaged."""
    try:
        content = json.loads((folder / "case.json").read_text(encoding="utf-8"))
        return content if isinstance(content, dict) else {}
    except (OSError, ValueError):
        return {}


def identity(case: Case) -> str | None:
    """Text that changes with anything that could change the case's result."""
    return identity_of(case.scene) if case.scene is not None else case.reason


def row_of(case: Case, out: Path, record: Sequence[str]) -> Row:
    """The row of a case from its folder."""
    recorded, values = _recorded(out / case.name), dict.fromkeys(record)
    same = recorded.get("identity") == identity(case)
    missing = Row(case, MISSING, str(recorded.get("reason", "")) if same else "", dict.fromkeys(record))
    if not same or recorded.get("status") in (None, BEGUN):
        return missing
    try:
        if recorded["status"] == "done":
            summary = json.loads((out / case.name / "result.json").read_text(encoding="utf-8"))
            if summary["checksum"] != checksum_of(summary, out / case.name):
                return missing
            values = {name: _entry(summary, name) for name in record}
            reasons = [text for text in summary["warnings"] if NOT_REACHED.match(text) or IN_DOUBT.search(text)]
            without = [name for name, value in values.items() if value is None and ANSWERS.match(name)]
            if without and not reasons:
                reasons = [f"the run has ended without {', '.join(without)}"]
            return Row(case, "done", "; ".join(reasons), values)
        return Row(case, recorded["status"], recorded["reason"], values)
    except (OSError, ValueError, KeyError, TypeError):
        return missing


def _entry(summary: Any, name: str) -> Any:
    group, _, target = name.partition(".")
    if group in ("targets", "target_errors"):  # which not every scene, and not every target has
        return summary[group].get(target)
    for part in name.split("."):
        if not isinstance(summary, dict):
            return None
        summary = summary[part]
    return summary


def setting(case: Case, name: str) -> Any:
    """The value (SI) that a case has of a key; where it has no scene the one that is given, as written if it is none."""
    if case.scene is None:
        given, kind = case.settings.get(name), key_of(KEYS, name).kind
        if not isinstance(given, str) or kind in WITHOUT_UNIT:
            return given
        try:
            return to_si(name, given, kind)
        except InputError:
            return given
    value = case.scene.value(name)
    return json.dumps(as_toml(value)) if isinstance(value, tuple) else as_toml(value)  # a tuple: tables of a list


def write_tables(study: Study, out: Path) -> list[Row]:
    """table.csv and table.json of all cases in their order; gives the rows. Waits for another process that is at it."""
    with locked(out / ".table", wait=True):
        rows = [row_of(case, out, study.record) for case in study.cases]
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow([
            *map(_head, study.varied), "status", *(f"{name} [{unit_of_record(name)}]" for name in study.record),
            "reason", "folder",
        ])  # fmt: skip
        entries = []
        for row in rows:
            varied = {name: setting(row.case, name) for name in study.varied}
            writer.writerow(text_cells([*varied.values(), row.status, *row.values.values(), row.reason, row.case.name]))
            entries.append(
                {**varied, "status": row.status, **row.values, "reason": row.reason, "folder": row.case.name}
            )
        for name, content in (
            ("table.csv", text.getvalue()),
            ("table.json", json.dumps(entries, indent=2, default=str) + "\n"),
        ):
            with whole_file(out / name) as temporary:
                temporary.write_text(content, encoding="utf-8")
    return rows


def _head(name: str) -> str:
    """Head of the column of a key: with its unit, if it has one."""
    unit = key_of(KEYS, name).unit
    return f"{name} [{unit}]" if unit else name
