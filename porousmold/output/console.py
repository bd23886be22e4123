"""What a run shows on the console: a progress bar, and a short summary at its end."""

import argparse
import logging
import math
import os
import sys
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from ..errors import InputError
from ..scene.features.geometries import modelled_part
from ..scene.scene import Scene
from .quantities import ENERGY_GIVEN, ENERGY_NAMES, JOULES_A_KWH
from .result_keys import Summary

Commands: TypeAlias = "argparse._SubParsersAction[Any]"
"""What commands are added to."""

STARTING = "{desc}, {elapsed} elapsed"
CASES = "{desc} |{bar}| {n:.0f}/{total:.0f}, {elapsed} elapsed, {remaining} left"
SECONDS = "{desc} |{bar}| {n:.0f}/{total:.0f} s simulated, {elapsed} elapsed, {remaining} left"
LEAST_SHOWN = 1e-3
"""Of the largest use of energy, below which one is not printed."""
LEAST_DIFFERENCE = 1e-3
"""Relative, of the heating time of the wall's bed side from that of the whole wall, for it to be shown."""
SECONDS_AND_PARTS = "{desc} |{bar}| {n:.3g}/{total:.3g} s simulated, {elapsed} elapsed, {remaining} left"
PART = "{desc} |{bar}| {percentage:.0f} %, {elapsed} elapsed"


def printed(text: object) -> None:
    """Print, and flush at once; a reader that closed the pipe (`| head`) ends the output, not the program."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def add_extension_option(command: argparse.ArgumentParser) -> None:
    """The option that lets a scene run the Python file that it names."""
    command.add_argument(
        "--allow-extensions",
        action="store_true",
        help="run the Python file that the scene names as extensions.python: only if you trust it",
    )


def add_settings_option(command: argparse.ArgumentParser) -> None:
    """--set TABLE.KEY=VALUE."""
    command.add_argument("--set", action="append", default=[], metavar="TABLE.KEY=VALUE", dest="settings",
                         help="override a value of the scene, for example wall.thickness='2 mm'; may be repeated")  # fmt: skip


def settings_of(options: argparse.Namespace) -> dict[str, str]:
    """{"table.key": value} of that option. Raises `InputError` for a text without a value."""
    settings = {}
    for text in options.settings:
        name, equals, value = text.partition("=")
        if not equals:
            raise InputError("--set", text, "must be TABLE.KEY=VALUE")
        value = value.strip()
        if len(value) > 1 and value[0] == value[-1] and value[0] in "\"'":  # as in TOML
            value = value[1:-1]
        settings[name.strip()] = value
    return settings


def add_verbosity_option(command: argparse.ArgumentParser) -> None:
    """-v for every time step, -vv for every iteration of a flow that is sought, --log for both in a file."""
    command.add_argument(
        "-v",
        "--verbose",
        action="count",
        default=0,
        help="print every time step; twice: every iteration of the flow, with the residual of each part",
    )
    command.add_argument("--log", metavar="FILE", help="write every step and iteration into a file")


def log_to_console(verbosity: int, *, first_rank: bool, file: str | None = None) -> None:
    """Have the program's loggers write to stderr what `-v` asks for, and everything in a file; all ranks take part, the first one
    tells. Raises `InputError` for a file that cannot be written."""
    logger = logging.getLogger(__package__.split(".")[0])
    console = (logging.WARNING, logging.INFO, logging.DEBUG)[min(verbosity, 2)]
    logger.setLevel(console if file is None else logging.DEBUG)
    logger.propagate = False
    logger.handlers = [logging.StreamHandler() if first_rank else logging.NullHandler()]
    logger.handlers[0].setLevel(console)
    if file is not None and first_rank:
        try:
            kept = logging.FileHandler(file, mode="w", encoding="utf-8")
        except OSError as error:
            raise InputError("--log", file, f"cannot be written: {error.strerror}") from error
        kept.setFormatter(logging.Formatter("%(asctime)s %(name)s: %(message)s"))
        logger.addHandler(kept)


class Bar:
    """The progress bar of every command, of tqdm; not there until something is shown, and silent where `quiet`, or without a
    terminal unless it is wanted `always`."""

    def __init__(self, *, quiet: bool = False, always: bool = False) -> None:
        self._quiet, self._bar = quiet or not (always or sys.stderr.isatty()), None

    def _shown(self, initial: float = 0.0) -> Any:
        if self._bar is None:
            with warnings.catch_warnings():  # that a notebook without ipywidgets gets the bar of a terminal
                warnings.simplefilter("ignore")
                from tqdm.auto import tqdm

            self._bar = tqdm(total=1.0, initial=initial, desc="starting", bar_format=STARTING)
        return self._bar

    def phase(self, text: str) -> None:
        """Show what is being done, before there is a measure of progress."""
        if text and not self._quiet:
            self._shown().set_description_str(text)

    def show(self, done: float, total: float, text: str, shape: str = CASES) -> None:
        """Show that `done` of `total` are done, as one of the shapes above."""
        if self._quiet:
            return
        bar = self._shown(done)
        bar.bar_format, bar.total, bar.n = shape, total, done
        bar.set_description_str(text)

    def close(self) -> None:
        """Leave the bar as it stands."""
        if self._bar is not None:
            self._bar.close()


class RunProgress:
    """Shows an integration on a `Bar` over simulated time; its end is predicted from how fast the wall approaches the inlet
    temperature.

    `margin` (K) and `end_time` (s) are those of the scene.
    """

    def __init__(self, bar: Bar, margin: float, end_time: float) -> None:
        self._bar, self._margin, self._end_time = bar, margin, end_time
        self._last: tuple[float, float, float] | None = None

    def phase(self, text: str) -> None:
        """Show what is being done before the first step of time, and within a long one."""
        if self._last is None:
            self._bar.phase(text)

    def __call__(self, time: float, deficit: float, simulation: Any) -> None:
        """After a step to `time` (s), with the wall's worst point `deficit` (K) from the inlet's temperature."""
        predicted = 1.7 * simulation.problem.medium.estimates.heating_duration
        if self._last is not None and 0.0 < deficit < 0.5 * self._last[2] and deficit < self._last[1]:
            rate = math.log(self._last[1] / deficit) / (time - self._last[0])
            predicted = time + max(math.log(deficit / self._margin), 0.0) / rate
        first = self._last[2] if self._last is not None else deficit
        self._last = (time, deficit, first)
        total = min(max(predicted, time), self._end_time)
        self._bar.show(time, total, f"wall within {deficit:.1f} K", SECONDS)


def closures_text(closures: Mapping[str, Any]) -> str:
    """The set of closures, and what departs from it."""
    departing = ", ".join(f"{name} = {value}" for name, value in closures["departures"].items())
    return closures["set"] + (f", but {departing}" if departing else "")


def energy_text(energy: Mapping[str, Any]) -> str:
    """What heater and blower gave, at most at once, and where it went."""
    given, most = ENERGY_GIVEN, max(abs(energy[name]) for name in ENERGY_NAMES)
    gone = [name for name in ENERGY_NAMES if name not in ENERGY_GIVEN and abs(energy[name]) > LEAST_SHOWN * most]
    parts = ", ".join(f"{energy[name] / JOULES_A_KWH:.3g} kWh {ENERGY_NAMES[name]}" for name in given if energy[name])
    uses = ", ".join(f"{energy[name] / JOULES_A_KWH:.3g} {ENERGY_NAMES[name]}" for name in gone)
    cost = f", cost {energy['cost']:.2f} {energy.get('currency') or ''}".rstrip() if energy["cost"] is not None else ""
    return f"{parts}; at most {energy['peak_power'] / 1e3:.3g} kW{cost}; to {uses} kWh"


def kept_text(kept: Mapping[str, object] | None) -> str:
    """When a target was lost again, and from when it holds."""
    if kept is None or kept["lost"] is None:
        return ""
    since = "not held at the end" if kept["kept_from"] is None else f"kept from {kept['kept_from']:.1f} s"
    return f"; first met at {kept['met']:.1f} s, lost at {kept['lost']:.1f} s, {since}"


def cycle_text(cycle: Mapping[str, object], phases: Sequence[Mapping[str, Any]]) -> str:
    """What the last cycle gave and took, and when its phases ended."""
    shares = [
        f"{words} {cycle[name]:.1%}"
        for name, words in (
            *(("energy_efficiency", "energy efficiency"), ("exergy_efficiency", "exergy efficiency")),
            ("utilisation", "utilisation"),
        )
        if cycle[name] is not None
    ]
    ends = ", ".join(
        f"{phase['name']} {(phase['end'] - phase['begin']) / 3600.0:.3g} h ({phase['heat'] / JOULES_A_KWH:.4g} kWh)"
        for phase in phases
    )
    periodic = ", periodic" if cycle["is_periodic"] else ""
    return f"cycle {cycle['cycle']}{periodic}{': ' if shares else ''}{', '.join(shares)}\n  {ends}"


def is_cooling(scene: Scene) -> bool:
    """Whether the inlet ends up colder than the bed was at first."""
    return bool(scene.operation.inlet_temperature.values[-1] < scene.operation.initial_temperature)


def outer_wall_text(operation: Mapping[str, Any]) -> str:
    """What happens at the outer wall, by the keys of [operation]."""
    coefficient, emissivity = operation.get("outer_coefficient"), operation.get("outer_emissivity")
    ways = [] if coefficient is None else [f"{coefficient:g} W/m2/K"]
    ways += [] if emissivity is None else [f"radiation with an emissivity of {emissivity:g}"]
    parts = [f"{' and '.join(ways)} to the surroundings"] if ways else []
    parts += [] if operation.get("outer_heat_flux") is None else ["given heat flux"]
    return ", ".join(parts) or "adiabatic, no heat loss (see operation.outer_coefficient)"


def _until(summary: Summary, change: str) -> str:
    """Up to when energy is counted, where that is not the run's end."""
    answers, end = list(summary["targets"].values()) or [summary["heating_time"]], summary["end_time"]
    if summary["cycles"] or None in answers or end - max(answers) < LEAST_DIFFERENCE * end:
        return ""
    return " up to the last target" if summary["targets"] else f" up to the {change} time"


def summary_text(scene: Scene, summary: Summary, out: Path, pictures: Sequence[Path]) -> str:
    """The short readable end of a run."""
    margin, place = scene.operation.heating_margin, scene.operation.heated_place.replace("_", " ")
    modelled = modelled_part(dict(scene.geometry))
    change = "cooling" if is_cooling(scene) else "heating"

    def shown(seconds: float | None) -> str:
        return f"{seconds:.1f} s ({seconds / 60:.1f} min)" if seconds is not None else "not reached"

    energy = summary["energy"]
    if energy is None:
        spent = (
            f"energy{_until(summary, change)}: {summary['fluid_heat'] / 1e6:.4g} MJ to {change.removesuffix('ing')} the fluid to "
            f"the inlet temperature, {summary['pumping_work'] / 1e6:.4g} MJ of pumping work"
        )
    else:
        spent = f"energy of the whole tool up to {energy['until']:.0f} s: {energy_text(energy)}"
    seconds, low_high = summary["wall_seconds"], summary["temperature_bounds"]
    targets = [
        f"{name}: {shown(time)} ({summary['target_meanings'][name]}){kept_text(summary['targets_kept'].get(name))}"
        for name, time in summary["targets"].items()
    ]
    whole, bed_side = summary["heating_time"], summary["heating_time_bed_side"]
    lines = targets
    lines += [cycle_text(summary["last_cycle"], summary["cycles"][-1]["phases"])] if summary["cycles"] else []
    if whole is not None or (summary["has_heating_time"] and not targets):
        lines.append(f"{change} time ({place} within {margin:g} K of the inlet): {shown(whole)}")
    if bed_side is not None and (whole is None or abs(bed_side - whole) > LEAST_DIFFERENCE * whole):
        lines.append(f"  bed side of the wall: {shown(bed_side)}")
    lines += [
        f"{'mass flow, heat and energy' if energy is None else 'mass flow and heat'} below: of {modelled}",
        f"mass flow: {summary['mass_flow_initial']:.5g} kg/s at the start, {summary['mass_flow_final']:.5g} kg/s at the end; "
        f"pressure drop {summary['pressure_drop_initial']:.4g} and {summary['pressure_drop_final']:.4g} Pa",
        f"heat balance: {summary['heat_by_fluid'] / 1e6:.4g} MJ from the fluid, "
        f"relative imbalance {summary['energy_imbalance']:.1e}; "
        f"temperatures {low_high[0] - 273.15:.2f} to {low_high[1] - 273.15:.2f} °C",
        spent,
        f"{summary['unknowns']['flow']} + {summary['unknowns']['energy']} unknowns (flow + energy), "
        f"{summary['time_steps']} steps, {seconds['total']:.1f} s "
        f"(flow {seconds['flow']:.1f}, energy {seconds['energy']:.1f}, compiling {seconds['compile']:.1f})",
    ]
    if summary["heating_time_error"] is not None:
        lines.append(f"numerical error of the heating time: about {summary['heating_time_error']:.2%}")
    for kind, errors in (("target", summary["target_errors"]), ("peak of", summary["peak_errors"])):
        lines += [f"numerical error of {kind} {name}: about {error:.2%}" for name, error in errors.items()]
    if summary["end_errors"]:
        worst, error = max(summary["end_errors"].items(), key=lambda pair: pair[1])
        lines.append(f"numerical error at the end: about {error:.2%}, of {worst.replace('_', ' ')}")
    lines += [
        f"{name} at the end: {low - 273.15:.1f} to {high - 273.15:.1f} °C"
        for name, (low, high) in summary["layers_at_end"].items()
    ]
    if scene.model.wall in ("conjugate", "thin"):
        lines.append(f"outer wall: {outer_wall_text(dict(scene.operation))}")
    lines.append(f"closures: {closures_text(summary['closures'])}")
    lines += [f"warning: {text}" for text in summary["warnings"]]
    lines.append(f"written to {out}" + (f": {', '.join(path.name for path in pictures)}" if pictures else ""))
    return "\n".join(lines)
