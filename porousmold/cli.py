"""The command `porousmold`."""

import argparse
import math
import sys
import traceback
from pathlib import Path

from .errors import InputError, SolveError
from .experiment.cli import add_commands as add_experiment_commands
from .packing.cli import add_commands as add_packing_commands
from .permeability.cli import add_commands as add_permeability_commands
from .stop_signals import StopSignals
from .study.cli import add_commands as add_study_commands

DONE, BAD_INPUT, SOLVE_FAILED, INTERRUPTED = 0, 2, 3, 130


def main(arguments=None):
    """Entry point: parse, dispatch, and turn errors into one line and an exit status."""
    options = _parser().parse_args(arguments)
    if hasattr(options, "serial"):
        return _on_one_rank(options.serial, options)
    return _status_of(options.command, options)


def _status_of(command, options):
    """Exit status of a command, its errors told in one line. A fault of the program itself ends all ranks: no rank waits
    for one that has fallen out."""
    try:
        return command(options)
    except InputError as error:
        return _end(BAD_INPUT, error)
    except SolveError as error:
        return _end(SOLVE_FAILED, error)
    except KeyboardInterrupt:
        return _end(INTERRUPTED, "interrupted before the run began")
    except Exception:
        from mpi4py import MPI

        if MPI.COMM_WORLD.size > 1:
            traceback.print_exc()
            MPI.COMM_WORLD.Abort(1)
        raise


def _end(status, message):
    if _rank() == 0:
        print(f"porousmold: {message}", file=sys.stderr)
    return status


def _on_one_rank(command, options):
    """A command without parallel work, which gives its text: rank 0 does it, the others wait for its status."""
    from mpi4py import MPI

    def told(options):
        try:
            text = command(options)
        except KeyboardInterrupt:
            return _end(INTERRUPTED, "interrupted; nothing was written")
        if text:
            print(text)
        return DONE

    status = None
    try:
        if MPI.COMM_WORLD.rank == 0:
            status = _status_of(told, options)
    finally:
        status = MPI.COMM_WORLD.bcast(status)
    return status


def _rank():
    from mpi4py import MPI

    return MPI.COMM_WORLD.rank


def _parser():
    parser = _Parser(prog="porousmold", description="Heating and cooling of bead-filled molds and pipes.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    run = commands.add_parser("run", help="run a scene to its heating time")
    run.add_argument("scene", metavar="SCENE.toml")
    run.add_argument("--set", action="append", default=[], metavar="TABLE.KEY=VALUE", dest="settings",
                     help="override a value of the scene, for example wall.thickness='2 mm'; may be repeated")  # fmt: skip
    run.add_argument("--out", metavar="DIR", help="folder to write (default: runs/NAME OF SCENE)")
    run.add_argument("--resume", action="store_true", help="go on from the checkpoint in DIR, if there is one")
    run.add_argument("--quiet", action="store_true", help="no progress bar, no summary")
    run.set_defaults(command=_run)
    add_packing_commands(commands)
    add_permeability_commands(commands)
    add_experiment_commands(commands)
    add_study_commands(commands)
    keys = commands.add_parser("keys", help="list every key of a scene with its unit, default and meaning")
    keys.set_defaults(command=_keys)
    show = commands.add_parser("show", help="draw the pictures of a run again")
    show.add_argument("run", metavar="RUN")
    show.set_defaults(command=_show)
    report = commands.add_parser("report", help="one HTML page about a run or a study, everything in it")
    report.add_argument("folder", metavar="RUN|STUDY")
    report.set_defaults(serial=_report)
    return parser


class _Parser(argparse.ArgumentParser):
    """Refuses with one line, like everything else."""

    def error(self, message):
        """End the program with one line and the status of bad input."""
        sys.exit(_end(BAD_INPUT, f"{message} (see {self.prog} --help)"))


def _settings(texts):
    settings = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            raise InputError("--set", text, "must be TABLE.KEY=VALUE")
        settings[name.strip()] = value.strip()
    return settings


def _run(options):
    from .scene import Scene

    scene = Scene.from_file(options.scene, _settings(options.settings))
    signals = StopSignals()
    out = Path(options.out) if options.out else Path("runs") / Path(options.scene).stem
    # dolfinx takes a second to import: only a scene that is sound pays for it
    try:
        from mpi4py import MPI

        from .running import RunInterrupted, run
    except ImportError:
        if signals:  # an interrupted import of a compiled module comes as this
            raise KeyboardInterrupt from None
        raise
    signals.listen()
    rank = MPI.COMM_WORLD.rank
    bar = None if options.quiet or rank else Bar(scene)
    try:
        observe = bar.phase if bar is not None else None
        result = run(scene, out, progress=bar, stop=lambda: bool(signals), resume=options.resume, observe=observe)
    except RunInterrupted as error:
        return _end(INTERRUPTED, f"{error}; what was computed is in {out}, --resume goes on")
    except SolveError:
        if (out / "history.csv").is_file():
            _end(SOLVE_FAILED, f"what was computed until then is in {out}")
        raise
    finally:
        if bar is not None:
            bar.close()
    if rank == 0:
        pictures = []
        if scene.output.pictures:
            from .plots import draw

            pictures = draw(out)
        if not options.quiet:
            print(summary_text(scene, result.summary, out, pictures))
    return DONE


def _keys(options):
    from .scene import reference

    print(reference(), end="")
    return DONE


def _show(options):
    from .plots import draw

    if _rank() == 0:
        for path in draw(options.run):
            print(path)
    return DONE


def _report(options):
    from .report import write_report

    return str(write_report(options.folder))


class Bar:
    """Progress bar over simulated time; its end is foreseen from how fast the wall approaches the inlet temperature."""

    def __init__(self, scene):
        from tqdm import tqdm

        self._margin, self._end_time = scene.operation.heating_margin, scene.operation.end_time
        self._bar = tqdm(total=1.0, unit="s", desc="starting", bar_format="{desc}, {elapsed} elapsed")
        self._last = None

    def phase(self, text):
        """Show what is being done before the first step of time, and within a long one."""
        if text and self._last is None:
            self._bar.set_description_str(text)

    def __call__(self, time, deficit, simulation):
        foreseen = 1.7 * simulation.problem.estimates.heating_duration
        if self._last is not None and 0.0 < deficit < 0.5 * self._last[2] and deficit < self._last[1]:
            rate = math.log(self._last[1] / deficit) / (time - self._last[0])
            foreseen = time + max(math.log(deficit / self._margin), 0.0) / rate
        first = self._last[2] if self._last is not None else deficit
        self._bar.bar_format = "{desc} |{bar}| {n:.0f}/{total:.0f} s simulated, {elapsed} elapsed, {remaining} left"
        self._last = (time, deficit, first)
        self._bar.total = min(max(foreseen, time), self._end_time)
        self._bar.n = time
        self._bar.set_description_str(f"wall within {deficit:.1f} K")

    def close(self):
        """Leave the bar as it stands."""
        self._bar.close()


def summary_text(scene, summary, out, pictures):
    """The short readable end of a run."""
    margin = scene.operation.heating_margin
    unit = "kg/s"
    if scene.geometry.kind == "mold":
        unit += " per metre width of half the cavity" if scene.geometry.width is None else " in a quarter of the cavity"

    def shown(seconds):
        return f"{seconds:.1f} s ({seconds / 60:.1f} min)" if seconds is not None else "not reached"

    seconds, low_high = summary["wall_seconds"], summary["temperature_bounds"]
    lines = [
        f"heating time (wall within {margin:g} K of the inlet): {shown(summary['heating_time'])}",
        f"  the wall's bed side alone:                  {shown(summary['heating_time_bed_side'])}",
        f"mass flow: {summary['mass_flow_initial']:.5g} at the start, {summary['mass_flow_final']:.5g} at the end, {unit}",
        f"heat balance: {summary['heat_by_fluid'] / 1e6:.4g} MJ from the fluid, "
        f"{summary['energy_imbalance']:.1e} of it unaccounted for; "
        f"temperatures {low_high[0] - 273.15:.2f} to {low_high[1] - 273.15:.2f} °C",
        f"spent: {summary['fluid_heat'] / 1e6:.4g} MJ to bring the fluid to the inlet temperature, "
        f"{summary['pumping_work'] / 1e6:.4g} MJ to drive it through the bed",
        f"{summary['unknowns']['flow']} + {summary['unknowns']['energy']} unknowns (flow + energy), "
        f"{summary['time_steps']} steps, {seconds['total']:.1f} s "
        f"(flow {seconds['flow']:.1f}, energy {seconds['energy']:.1f}, compiling {seconds['compile']:.1f})",
    ]
    lines += [f"warning: {text}" for text in summary["warnings"]]
    lines.append(f"written to {out}" + (f": {', '.join(path.name for path in pictures)}" if pictures else ""))
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
