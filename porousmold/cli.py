"""The command `porousmold`."""

import argparse
import json
import os
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from . import __version__
from .errors import InputError, OutputError, SolveError
from .experiment.cli import add_commands as add_experiment_commands
from .files.stop_signals import StopSignals, acknowledge
from .fluidised.cli import add_commands as add_fluidised_commands
from .fluidised.column_cli import add_commands as add_column_commands
from .fluidised.droplet_cli import add_commands as add_droplet_commands
from .output.console import add_extension_option, add_settings_option, add_verbosity_option, printed, settings_of
from .packing.cli import add_commands as add_packing_commands
from .permeability.cli import add_commands as add_permeability_commands
from .shear.cli import add_commands as add_shear_commands
from .study.cli import add_commands as add_study_commands

DONE, LACKING, BAD_INPUT, UNFINISHED, INTERRUPTED = 0, 1, 2, 3, 130
COMPILED = {
    "dolfinx": "python3-dolfinx",
    "petsc4py": "python3-petsc4py",
    "mpi4py": "python3-mpi4py",
    "gmsh": "python3-gmsh",
    "h5py": "python3-h5py",
    "numba": "python3-numba",
    "scipy": "python3-scipy",
    "numpy": "python3-numpy",
    "matplotlib": "python3-matplotlib",
    "pint": "python3-pint",
    "tqdm": "python3-tqdm",
    "tomli_w": "python3-tomli-w",
}
"""Packages that come from Debian, by what Python imports."""
STATUSES = """exit status:
  0    done
  1    a package is missing (one-line message), or an internal error (traceback)
  2    invalid input (one-line message), nothing was written. Of a study: cases were refused
  3    a solve did not converge, or the disk is full; the results up to then are kept. Of a study: cases failed
  130  interrupted (Ctrl-C, SIGTERM); continue with --resume, or a study with the same command
"""
EXAMPLES = {
    "run": ["SCENE.toml", "SCENE.toml --set wall.thickness='2 mm' --out runs/thin"],
    "check": ["SCENE.toml --set solver.mesh_refinement=2"],
    "materials": ["", "my_materials.toml"],
    "pack": ["--container cylinder --diameter '100 mm' --bead-diameter '6 mm' --bed-height '150 mm' --out runs/bed.h5"],
    "porosity": ["runs/bed.h5 --bed-height '150 mm' --out runs/profile.csv"],
    "conductivity": ["runs/bed.h5 --beads steel --fluid air --temperature '350 K' --out runs/conductivity.csv"],
    "permeability": ["scale.csv --setup setup.toml"],
    "test-range": ["setup.toml --error 0.05"],
    "rotameter": ["log.csv --diameter '101.6 mm' --reference-temperature '21 degC' --interval '120 s' --out inlet"],
    "compare": ["runs/mold measured.csv", "runs/mold runs/thin"],
    "study": ["STUDY.toml", "STUDY.toml --part 1/3 --out runs/study", "STUDY.toml --plot"],
    "sensitivity": ["SCENE.toml"],
    "simplify": ["SCENE.toml --accuracy 0.01"],
    "uncertainty": ["SCENE.toml --sample 100"],
    "solve-for": ["SCENE.toml --key wall.thickness --target 'heating_time = 15 min'"],
    "optimum": ["STUDY.toml"],
    "fluidised": ["SCENE.toml --set operation.mass_flow='0.01 kg/s'"],
    "fluidise": [
        "--width '14 mm' --depth '7 mm' --height '60 mm' --bed-height '18 mm' --bead-diameter '1 mm' --beads glass "
        "--velocity '0.9 m/s' --time '0.3 s' --out runs/fluidise"
    ],
    "droplet": ["--bed-temperature '400 degC' --time '0.2 s' --out runs/droplet"],
    "shear": ["--solid-fraction 0.5 0.56 0.6 --shear-rate 1e-2 --peclet 1 100 --biot 0 1 --out runs/shear.csv"],
    "keys": ["", "wall", "--result", "--json-schema"],
    "show": ["runs/mold", "runs/mold --animate", "runs/mold --format pdf"],
    "report": ["runs/mold"],
    "cite": ["runs/mold"],
    "cache": ["", "--prune '30 days'"],
}
"""Arguments of each command as they are used, shown below its help."""


def main(arguments: list[str] | None = None) -> int:
    """Entry point: parse, dispatch, and turn errors into one line and an exit status."""
    parser = _parser()
    if "_ARGCOMPLETE" in os.environ:  # a shell asks what may stand here
        import argcomplete

        argcomplete.autocomplete(parser)
    options = parser.parse_args(arguments)
    if hasattr(options, "serial"):
        return _on_one_rank(options.serial, options)
    return _status_of(options.command, options)


def _status_of(command: Callable[..., Any], options: argparse.Namespace) -> int:
    """Exit status of a command; its errors are printed in one line. An internal error aborts all ranks: no rank waits
    for one that has failed."""
    try:
        return command(options)
    except (SolveError, OutputError) as error:
        return _end(UNFINISHED, error)
    except InputError as error:
        return _end(BAD_INPUT, error)
    except KeyboardInterrupt:
        acknowledge()
        return _end(INTERRUPTED, "interrupted before the run began")
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package not in COMPILED:
            raise
        print(
            f"porousmold: needs {package}, which pip does not install: apt install {COMPILED[package]}", file=sys.stderr
        )
        return LACKING
    except Exception as error:
        from .files.atomic_files import FULL
        from .mpi import MPI

        if (
            isinstance(error, OSError) and error.errno in FULL and MPI.COMM_WORLD.size == 1
        ):  # of a library's own cache, say
            return _end(UNFINISHED, f"a file cannot be written: {error}; with room there, the same command goes on")
        if MPI.COMM_WORLD.size > 1:
            traceback.print_exc()
            MPI.COMM_WORLD.Abort(1)
        raise


def _end(status: int, message: object) -> int:
    if _rank() == 0:
        print(f"porousmold: {message}", file=sys.stderr)
    return status


def _on_one_rank(command: Callable[..., Any], options: argparse.Namespace) -> int:
    """A command without parallel work, which gives its text: rank 0 does it, the others wait for its status."""
    from .mpi import MPI

    if MPI.COMM_WORLD.size > 1:
        from petsc4py import PETSc  # noqa: F401  all ranks initialise it together, or rank 0 waits for the others in there

    def printing(options: argparse.Namespace) -> int:
        try:
            text = command(options)
        except KeyboardInterrupt as interruption:
            acknowledge()
            return _end(INTERRUPTED, str(interruption) or "interrupted; nothing was written")
        if text:
            printed(text)
        return DONE

    status = DONE
    try:
        if MPI.COMM_WORLD.rank == 0:
            status = _status_of(printing, options)
    finally:
        status = MPI.COMM_WORLD.bcast(status)
    return status


def _rank() -> int:
    from .mpi import MPI

    return MPI.COMM_WORLD.rank


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="porousmold", description="Heating and cooling of bead-filled molds and pipes.", epilog=STATUSES
    )
    parser.add_argument("--version", action="version", version=f"porousmold {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    run = commands.add_parser("run", help="run a scene to its heating time")
    run.add_argument("scene", metavar="SCENE.toml")
    add_settings_option(run)
    run.add_argument("--out", metavar="DIR", help="folder to write (default: runs/NAME OF SCENE)")
    add_extension_option(run)
    add_verbosity_option(run)
    run.add_argument("--resume", action="store_true", help="continue from the checkpoint in DIR, if there is one")
    run.add_argument("--force", action="store_true", help="overwrite another run in DIR")
    run.add_argument("--quiet", action="store_true", help="no progress bar, no summary")
    run.set_defaults(command=_run)
    check = commands.add_parser(
        "check", help="check a scene without running it: mesh, groups, expected computing time, warnings"
    )
    check.add_argument("scene", metavar="SCENE.toml")
    add_settings_option(check)
    add_extension_option(check)
    check.set_defaults(command=_check)
    materials = commands.add_parser("materials", help="list the materials of the library, with ranges and sources")
    materials.add_argument(
        "file", nargs="?", metavar="FILE.toml", help="list the materials of this file instead of the library's"
    )
    materials.set_defaults(serial=_materials)
    keys = commands.add_parser("keys", help="list every key of a scene, or of a result, with unit, default and meaning")
    keys.add_argument("table", nargs="?", metavar="TABLE", help="only those of one table, such as wall")
    keys.add_argument("--result", action="store_true", help="those of result.json")
    keys.add_argument("--json-schema", action="store_true", help="as JSON Schema, for editors and other programs")
    keys.set_defaults(command=_keys)  # without MPI, whose import takes as long as the rest
    show = commands.add_parser("show", help="draw the pictures of a run again")
    show.add_argument("run", metavar="RUN")
    show.add_argument(
        "--animate", action="store_true", help="also heating.gif, the fields over time (see output.field_times)"
    )
    show.add_argument(
        "--format", choices=("png", "pdf", "svg"), default="png", help="kind of the pictures (default png)"
    )
    show.set_defaults(command=_show)
    report = commands.add_parser("report", help="write a self-contained HTML report of a run or a study")
    report.add_argument("folder", metavar="RUN|STUDY")
    report.set_defaults(serial=_report)
    cite = commands.add_parser("cite", help="BibTeX of the program, the model, and the sources that a run used")
    cite.add_argument("run", metavar="RUN")
    cite.set_defaults(serial=_cite)
    cache = commands.add_parser("cache", help="show how much the compiled forms take, or prune them")
    cache.add_argument(
        "--prune", metavar="TIME", help="take away what was not used for so long, and what nobody reads of the rest"
    )
    cache.set_defaults(serial=_cache)
    add_study_commands(commands)
    add_experiment_commands(commands)
    add_packing_commands(commands)  # from here on beside the core: nothing of it imports them
    add_permeability_commands(commands)
    add_fluidised_commands(commands)
    add_column_commands(commands)
    add_droplet_commands(commands)
    add_shear_commands(commands)
    for name, command in commands.choices.items():
        lines = [f"  porousmold {name} {arguments}".rstrip() for arguments in EXAMPLES[name]]
        command.epilog = "\n".join([f"example{'s' if len(lines) > 1 else ''}:", *lines])
    return parser


class _Parser(argparse.ArgumentParser):
    """Reports errors in one line; its help keeps the line breaks of the epilog."""

    def __init__(self, **options: Any) -> None:
        super().__init__(formatter_class=argparse.RawDescriptionHelpFormatter, **options)

    def error(self, message: str) -> NoReturn:
        """End the program with one line and the status of bad input."""
        if message.startswith("unrecognized arguments") and "=" in " ".join(sys.argv):
            message += "; a value with a blank needs quotes: --set wall.thickness='2 mm'"
        if message.startswith("argument -") and message.endswith("expected one argument"):
            message += "; a value that begins with '-' is written with '=': --velocity='-1 m/s'"
        sys.exit(_end(BAD_INPUT, f"{message} (see {self.prog} --help)"))


def _run(options: argparse.Namespace) -> int:
    from .output.console import Bar, RunProgress, log_to_console, summary_text
    from .output.picture_process import PictureProcess
    from .scene.scene import Scene

    settings = settings_of(options)
    scene = Scene.load(options.scene, settings, allow_extensions=options.allow_extensions)
    signals = StopSignals()
    out = Path(options.out) if options.out else Path("runs") / Path(options.scene).stem
    drawing = None
    # dolfinx takes a while to import: only a scene that is sound pays for it
    try:
        from .mpi import MPI

        rank = MPI.COMM_WORLD.rank
        if rank == 0 and scene.output.pictures:
            drawing = PictureProcess()  # as early as it can be: it imports matplotlib beside all that follows
        from .simulation.running import RunInterrupted, run
    except ImportError:
        if signals:  # an interrupted import of a compiled module comes as this
            raise KeyboardInterrupt from None
        raise
    signals.listen()
    log_to_console(options.verbose, first_rank=rank == 0, file=options.log)
    bar = Bar(quiet=options.quiet or bool(rank) or options.verbose > 0)
    progress = RunProgress(bar, scene.operation.heating_margin, scene.operation.end_time)
    try:
        result = run(
            scene,
            out,
            progress=progress,
            stop=signals.__bool__,
            resume=options.resume,
            force=options.force,
            observe=progress.phase,
        )
        pictures = drawing.draw(out) if drawing is not None else []
    except RunInterrupted as error:
        return _end(INTERRUPTED, f"{error}; partial results are in {out}, continue with --resume")
    except SolveError:
        if rank == 0 and (out / "history.csv").is_file():
            _end(UNFINISHED, f"partial results are in {out}")
            for warning in json.loads((out / "result.json").read_text(encoding="utf-8"))["warnings"]:
                _end(UNFINISHED, f"warning: {warning}")  # some tell why: a fluid far beyond its range, say
        raise
    finally:
        bar.close()
        if drawing is not None:
            drawing.close()
    if rank == 0:
        if result.recalled:
            lacking = scene.output.fields and not (out / "fields.xdmf").is_file()
            note = ", without fields, which that run did not write" if lacking else ""
            printed(f"done already: the folder holds the result of this scene (--force computes it again){note}")
        if not options.quiet:
            if result.resumed_at is not None:
                printed(f"continued from the checkpoint at t = {result.resumed_at:.6g} s")
            printed(summary_text(scene, result.summary, out, pictures))
    return DONE


def _check(options: argparse.Namespace) -> int:
    from .scene.scene import Scene

    scene = Scene.load(options.scene, settings_of(options), allow_extensions=options.allow_extensions)
    from .mpi import MPI
    from .simulation.checking import check

    found = check(scene, MPI.COMM_WORLD)
    if _rank() == 0:
        printed("\n".join([*found.facts, *(f"warning: {text}" for text in found.warnings)]))
        printed("the scene can be run" + (", but see the warnings" if found.warnings else ""))
    return DONE


def _materials(options: argparse.Namespace) -> str:
    from .laws.material_table import table

    return table(None if options.file is None else Path(options.file))


def _keys(options: argparse.Namespace) -> int:
    from .output import result_keys
    from .scene import json_schema, reference

    if options.json_schema:
        printed(json.dumps(result_keys.result_schema() if options.result else json_schema.scene_schema(), indent=2))
    else:
        printed((result_keys.reference() if options.result else reference.reference(options.table)).removesuffix("\n"))
    return DONE


def _show(options: argparse.Namespace) -> int:
    from .output.pictures import animate, draw

    if _rank() == 0:
        for path in [*draw(options.run, kind=options.format), *([animate(options.run)] if options.animate else [])]:
            printed(path)
    return DONE


def _report(options: argparse.Namespace) -> str:
    from .output.report import write_report

    return str(write_report(options.folder))


def _cite(options: argparse.Namespace) -> str:
    from .output.citation import citations

    return citations(Path(options.run))


def _cache(options: argparse.Namespace) -> str:
    from .files.cache_folder import cache_home, contents, prune
    from .files.units import to_si

    folder = cache_home() / "fenics" / "porousmold"
    found = contents(folder)
    text = f"{folder}: {found.forms} compiled forms, {found.size / 1e6:.0f} MB"
    if options.prune is None:
        return f"{text}, {found.needless / 1e6:.0f} MB of them read by nobody (--prune '30 days')"
    unused = to_si("--prune", options.prune, "s")
    if unused < 0.0:
        raise InputError("--prune", options.prune, "must not be negative")
    left = prune(folder, unused)
    return f"{text}\nleft: {left.forms} compiled forms, {left.size / 1e6:.0f} MB"


if __name__ == "__main__":
    sys.exit(main())
