"""The commands that run many cases: study, sensitivity, simplify, uncertainty, solve-for, optimum."""

import argparse
import itertools
import math
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from ..files.stop_signals import StopSignals
from ..files.units import to_si
from ..output.console import Bar, Commands, add_extension_option, add_settings_option, printed, settings_of
from ..output.stored import read_study

if TYPE_CHECKING:
    from .definition import Study
    from .running import Row

DONE, REFUSED, FAILED, INTERRUPTED = 0, 2, 3, 130
"""Exit statuses: of a study in which cases were refused, or failed, too."""
MOST_RUNS = 8
"""That compare models: the fullest one, and one for each simplification."""


def add_commands(commands: Commands) -> None:
    """Add the commands to the program's subparsers."""
    study = commands.add_parser("study", help="run the cases of the parameter study in STUDY.toml")
    study.add_argument("study", metavar="STUDY.toml")
    study.add_argument("--out", metavar="DIR", help="folder to write (default: runs/NAME OF STUDY)")
    study.add_argument("--group", type=int, default=1, metavar="M", help="ranks per case under mpirun (default 1)")
    study.add_argument(
        "--part", default="1/1", metavar="I/N", help="only every N-th case from the I-th: for array jobs"
    )
    study.add_argument("--collect", action="store_true", help="run nothing, write the tables of what is there")
    study.add_argument("--quiet", action="store_true", help="no progress bar, no summary")
    study.add_argument("--plot", action="store_true", help="draw the first record in the terminal, too")
    add_extension_option(study)
    study.set_defaults(command=_study)
    sensitivity = commands.add_parser(
        "sensitivity", help="elasticities of the heating time, or of another result, to every parameter of a scene"
    )
    sensitivity.add_argument("scene", metavar="SCENE.toml")
    sensitivity.add_argument("--out", metavar="DIR", help="folder to write (default: runs/NAME OF SCENE-sensitivity)")
    _add_quantity(sensitivity)
    sensitivity.add_argument("--step", default="0.05", help="relative change of every parameter (default 0.05)")
    sensitivity.add_argument("--quiet", action="store_true", help="no progress bar, no summary")
    add_extension_option(sensitivity)
    sensitivity.set_defaults(command=_sensitivity)
    uncertainty = commands.add_parser(
        "uncertainty", help="uncertainty of the heating time, or of another result, and the contribution of each input"
    )
    uncertainty.add_argument(
        "scene", metavar="SCENE.toml", help="its table [tolerance] gives the tolerances of the inputs"
    )
    uncertainty.add_argument("--out", metavar="DIR", help="folder to write (default: runs/NAME OF SCENE-uncertainty)")
    add_settings_option(uncertainty)
    _add_quantity(uncertainty)
    uncertainty.add_argument(
        "--sample", type=int, default=0, metavar="N", help="verify it by a Latin hypercube sample of N runs"
    )
    uncertainty.add_argument("--seed", type=int, default=1, metavar="S", help="random seed of the sample (default 1)")
    uncertainty.add_argument("--quiet", action="store_true", help="no progress bar, no summary")
    add_extension_option(uncertainty)
    uncertainty.set_defaults(command=_uncertainty)
    simplify = commands.add_parser(
        "simplify", help="what of the model a scene's heating time does not notice: sought once for a family of scenes"
    )
    simplify.add_argument("scene", metavar="SCENE.toml")
    simplify.add_argument("--accuracy", default="0.01", metavar="PART",
                          help="largest relative change of the heating time in all (default 0.01)")  # fmt: skip
    add_settings_option(simplify)
    simplify.add_argument("--quiet", action="store_true", help="no progress bar")
    add_extension_option(simplify)
    simplify.set_defaults(command=_simplify)
    solve = commands.add_parser("solve-for", help="the value of a key with which a scene reaches a target")
    solve.add_argument("scene", metavar="SCENE.toml")
    solve.add_argument("--key", action="append", required=True, metavar="TABLE.KEY", dest="keys",
                       help="key to vary; may be repeated, each key is varied on its own")  # fmt: skip
    solve.add_argument("--target", required=True, metavar="RECORD=VALUE",
                       help="for example 'heating_time = 15 min' or 'targets.cured = 2 h'")  # fmt: skip
    solve.add_argument("--out", metavar="DIR", help="folder to write (default: runs/NAME OF SCENE-solve-for)")
    add_settings_option(solve)
    solve.add_argument("--quiet", action="store_true", help="no progress bar, no summary")
    add_extension_option(solve)
    solve.set_defaults(command=_solve_for)
    optimum = commands.add_parser(
        "optimum", help="optimum parameters of a study under the constraints of its table [optimum]"
    )
    optimum.add_argument("study", metavar="STUDY.toml")
    optimum.add_argument("--out", metavar="DIR", help="folder to write (default: runs/NAME OF STUDY)")
    optimum.add_argument("--quiet", action="store_true", help="no progress bar, no summary")
    add_extension_option(optimum)
    optimum.set_defaults(command=_optimum)


def _counting(bar: Bar, cases: Any) -> Any:
    """Progress that is called with the number of cases that have ended."""
    return lambda ended: bar.show(ended, cases, "cases")


def _part(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text)
    part = (int(match.group(1)), int(match.group(2))) if match else (0, 0)
    if not 1 <= part[0] <= part[1]:
        raise InputError("--part", text, "must be I/N with I from 1 to N, such as 2/3")
    return part


def _add_quantity(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--of",
        metavar="RECORD",
        help="what of result.json, such as targets.cured, energy.cost or spread_at_end (default: the first target's time, "
        "without targets the heating time)",
    )


def _sensitivity(options: argparse.Namespace) -> int:
    from ..scene.scene import Scene

    scene, step = (
        Scene.load(options.scene, allow_extensions=options.allow_extensions),
        to_si("--step", options.step, ""),
    )
    if not 0.0 < step < 1.0:
        raise InputError("--step", step, "must be > 0 and < 1")
    out = Path(options.out) if options.out else Path("runs") / f"{Path(options.scene).stem}-sensitivity"
    from ..mpi import MPI
    from .quantity import quantity_of
    from .sensitivity import cases_around, elasticities, not_varied, write

    quantity = quantity_of(scene, options.of)

    signals, first = StopSignals(), MPI.COMM_WORLD.rank == 0
    bar = Bar(quiet=options.quiet or not first)
    progress = _counting(bar, len(cases_around(scene, step)))
    try:
        found = elasticities(scene, out, quantity, step=step, progress=progress, stop=signals.__bool__)
    finally:
        bar.close()
    if found is None:
        return _interrupted(out, first=first)
    if first:
        picture = write(found, out, quantity)
        if not options.quiet:
            counted = "for a change of 1 % (of temperatures: of their difference to the start)"
            printed(f"{'parameter':30s} change of the {quantity.words} in % {counted}")
            for entry in found:
                value = "none:" if entry.value is None else f"{entry.value:+.3f}"
                printed(f"{entry.parameter:30s} {value} {entry.reason}".rstrip())
            if names := not_varied(scene):
                printed(f"given, but not varied: {', '.join(names)}")
            printed(f"written to {out}: elasticities.json, {picture.name}")
    return DONE


def _simplify(options: argparse.Namespace) -> int:
    from ..mpi import MPI
    from ..scene.scene import Scene
    from ..simulation.running import RunInterrupted, run
    from .model_choice import choose_model

    scene = Scene.load(options.scene, settings_of(options), allow_extensions=options.allow_extensions)
    accuracy = to_si("--accuracy", options.accuracy, "")
    if not 1e-4 <= accuracy <= 0.5:
        raise InputError("--accuracy", options.accuracy, "must be >= 0.0001 and <= 0.5")
    first, signals = MPI.COMM_WORLD.rank == 0, StopSignals()
    bar, runs = Bar(quiet=options.quiet or not first), itertools.count(1)

    def integrate(simpler: Scene) -> float | None:
        bar.show(next(runs), MOST_RUNS, "runs on coarse cells")
        return run(simpler, stop=signals.__bool__).heating_time

    try:
        found = choose_model(scene, accuracy, integrate)
    except RunInterrupted:
        return INTERRUPTED
    finally:
        bar.close()
    if first:
        printed(found.text)
    return DONE


def _uncertainty(options: argparse.Namespace) -> int:
    from ..scene.scene import Scene

    scene = Scene.load(options.scene, settings_of(options), allow_extensions=options.allow_extensions)
    if options.sample < 0 or options.sample == 1:
        raise InputError("--sample", options.sample, "must be 0, or at least 2")
    if options.seed < 0:
        raise InputError("--seed", options.seed, "must be >= 0")
    out = Path(options.out) if options.out else Path("runs") / f"{Path(options.scene).stem}-uncertainty"
    from ..mpi import MPI
    from .quantity import quantity_of
    from .uncertainty import budget, cases_of, sampled, summary_text, write

    quantity = quantity_of(scene, options.of)

    signals, first = StopSignals(), MPI.COMM_WORLD.rank == 0
    bar = Bar(quiet=options.quiet or not first)
    sample = None
    try:
        found = budget(scene, out, quantity, progress=_counting(bar, len(cases_of(scene))), stop=signals.__bool__)
        if found is not None and options.sample:
            counting = _counting(bar, options.sample)
            sample = sampled(
                scene, out / "sample", options.sample, options.seed, quantity, progress=counting, stop=signals.__bool__
            )
    finally:
        bar.close()
    if found is None or (options.sample and sample is None):
        return _interrupted(out, first=first)
    if first:
        written = write(found, sample, out)
        if not options.quiet:
            printed(summary_text(found, sample))
            printed(f"written to {out}: {', '.join(path.name for path in written)}")
    return DONE


def _solve_for(options: argparse.Namespace) -> int:
    from ..scene.scene import Scene
    from .solve_for import aim_of, solve_for, summary_text, write

    aim = aim_of(options.target)
    scene = Scene.load(options.scene, settings_of(options), allow_extensions=options.allow_extensions)
    out = Path(options.out) if options.out else Path("runs") / f"{Path(options.scene).stem}-solve-for"
    from ..mpi import MPI

    signals, first = StopSignals(), MPI.COMM_WORLD.rank == 0
    bar = Bar(quiet=options.quiet or not first)

    def progress(key: str, runs: int) -> Any:
        bar.phase(f"{key}, run {runs + 1}")
        return lambda ended: None

    try:
        found = solve_for(scene, options.keys, aim, out, progress=progress, stop=signals.__bool__)
    finally:
        bar.close()
    if found is None:
        return _interrupted(out, first=first)
    if first:
        written = write(found, aim, out)
        if not options.quiet:
            printed(summary_text(found, aim, scene))
            printed(f"written to {out}: {written.name}")
    return DONE


def _optimum(options: argparse.Namespace) -> int:
    from .optimum import load, search, summary_text, write

    study, aim = load(options.study, allow_extensions=options.allow_extensions)
    out = Path(options.out) if options.out else Path("runs") / Path(options.study).stem
    from ..mpi import MPI

    signals, first = StopSignals(), MPI.COMM_WORLD.rank == 0
    bar = Bar(quiet=options.quiet or not first)
    try:
        found = search(study, aim, out, progress=lambda cases: _counting(bar, cases), stop=signals.__bool__)
    finally:
        bar.close()
    if found is None:
        return _interrupted(out, first=first)
    if first:
        written = write(found, study, aim, out)
        if not options.quiet:
            printed(summary_text(found, study, aim))
            printed(f"written to {out}: {', '.join(path.name for path in written)}")
    return DONE


def _interrupted(out: Path, *, first: bool) -> int:
    """Tell, on the first rank, that the same command goes on; gives the status."""
    if first:
        print(f"porousmold: interrupted; what was run is in {out}, the same command goes on", file=sys.stderr)
    return INTERRUPTED


def _study(options: argparse.Namespace) -> int:
    from .definition import Study

    study, part = Study.load(options.study, allow_extensions=options.allow_extensions), _part(options.part)
    out = Path(options.out) if options.out else Path("runs") / Path(options.study).stem
    from ..mpi import MPI
    from .running import collect, run_study

    signals = StopSignals()
    first = MPI.COMM_WORLD.rank == 0
    if options.collect:
        if not MPI.COMM_WORLD.bcast(out.is_dir()):
            raise InputError("--out", str(out), "holds no study to collect")
        rows = collect(study, out)
    else:
        bar = Bar(quiet=options.quiet or not first)
        progress = _counting(bar, len(study.cases[part[0] - 1 :: part[1]]))
        try:
            rows = run_study(study, out, group=options.group, part=part, progress=progress, stop=signals.__bool__)
        finally:
            bar.close()
    if first:
        from ..output.study_pictures import draw_study, plot_in_terminal

        entries, head = read_study(out)
        pictures = draw_study(out, entries, head)
        if not options.quiet:
            printed(summary_text(study, rows, out, pictures))
        if options.plot:
            printed(plot_in_terminal(entries, head))
    if signals:
        return INTERRUPTED
    for status, code in (("refused", REFUSED), ("failed", FAILED)):
        some = [row for row in rows if row.status == status]
        if some:
            if first and options.quiet:
                text = f"{len(some)} of {len(rows)} cases {status}, as {some[0].case.name}: {some[0].reason}"
                print(f"porousmold: {text}", file=sys.stderr)
            return code
    return DONE


def summary_text(study: "Study", rows: "Sequence[Row]", out: Path, pictures: Sequence[Path] = ()) -> str:
    """The short readable end of a study: how many cases ended how, the range of what was recorded, the reasons."""
    counts = {status: sum(row.status == status for row in rows) for status in ("done", "failed", "refused", "missing")}
    from .definition import unit_of_record

    lines = [f"{len(rows)} cases: " + ", ".join(f"{count} {status}" for status, count in counts.items() if count)]
    for name in study.record:
        values = [row.values[name] for row in rows if isinstance(row.values[name], int | float)]
        values = [value for value in values if math.isfinite(value)]
        if values:
            unit = unit_of_record(name)
            lines.append(f"{name}: {min(values):.6g} to {max(values):.6g}{'' if unit in (None, '1') else f' {unit}'}")
    lines += [f"{row.status}: {row.case.name}: {row.reason}" for row in rows if row.reason][:10]
    lines.append(f"written to {out}: {', '.join(['table.csv', 'table.json', *(path.name for path in pictures)])}")
    return "\n".join(lines)
