"""The command `porousmold fluidised`."""

import argparse
import csv
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ..files.atomic_files import output_file, output_folder
from ..output.console import Commands, add_extension_option, add_settings_option, settings_of
from ..output.result_keys import Summary


def add_commands(commands: Commands) -> None:
    """Add the command to the program's subparsers."""
    command = commands.add_parser("fluidised", help="heating time of a wall in contact with a fluidised bed")
    command.add_argument("scene", metavar="SCENE.toml")
    add_settings_option(command)
    command.add_argument("--out", metavar="DIR", help="folder to write (default: runs/NAME OF SCENE-fluidised)")
    command.add_argument("--quiet", action="store_true", help="no summary, no picture")
    add_extension_option(command)
    command.set_defaults(serial=_fluidised)


def _fluidised(options: argparse.Namespace) -> str:
    from ..scene.scene import Scene
    from .model import FluidisedBed

    scene = Scene.load(options.scene, settings_of(options), allow_extensions=options.allow_extensions)
    out = Path(options.out) if options.out else Path("runs") / f"{Path(options.scene).stem}-fluidised"
    summary, history = FluidisedBed(scene).integrate()
    output_folder(out)
    units = {name: "s" if name == "time" else "K" for name in history}
    write_tables(out, summary, units, zip(*history.values(), strict=True))
    if options.quiet:
        return ""
    picture = _draw(out, summary, history)
    time, margin = summary["heating_time"], scene.operation.heating_margin
    reached = f"{time:.1f} s ({time / 60.0:.1f} min)" if time is not None else "not reached"
    lines = [
        f"heating time (wall within {margin:g} K of the inlet): {reached}",
        f"fluid: {summary['velocity']:.3g} m/s when hot; "
        f"minimum fluidisation {summary['minimum_fluidisation_velocity']:.3g} m/s, "
        f"terminal velocity {summary['terminal_velocity']:.3g} m/s",
        f"bed: porosity {summary['porosity']:.3f}, {summary['height']:.3g} m high, {summary['pressure_drop']:.4g} Pa",
        f"wall: {summary['wall_coefficient']:.4g} W/m2/K (30 %), Biot number {summary['wall_biot_number']:.2g}",
        f"heat balance: {summary['heat_by_fluid'] / 1e6:.4g} MJ from the fluid, imbalance {summary['energy_imbalance']:.1e}",
        *(f"warning: {text}" for text in summary["warnings"]),
        f"written to {out}: result.json, history.csv, {picture.name}",
    ]
    return "\n".join(lines)


def write_tables(out: Path, summary: Summary, units: Mapping[str, str], rows: Iterable[Iterable[object]]) -> None:
    """history.csv with a unit for each column, and result.json."""
    with output_file(out / "history.csv") as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([f"{name} [{unit}]" for name, unit in units.items()])
        writer.writerows(rows)
    with output_file(out / "result.json") as temporary:
        temporary.write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")


def _draw(out: Path, summary: Any, history: Any) -> Path:
    from ..output.figures import STYLE, plt, save

    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(8.0, 5.0), layout="constrained")
        for name, style in (
            ("inlet_temperature", "0.4"),
            ("bead_temperature", "tab:blue"),
            ("wall_temperature", "tab:green"),
        ):
            axes.plot(
                history["time"] / 60.0, history[name] - 273.15, color=style, label=name.removesuffix("_temperature")
            )
        if summary["heating_time"] is not None:
            label = f"heated, {summary['heating_time']:.0f} s"
            axes.axvline(summary["heating_time"] / 60.0, color="tab:red", linewidth=1.2, label=label)
        axes.set(xlabel="time in min", ylabel="temperature in °C", xlim=(0, None))
        axes.legend(fontsize=9)
        return save(figure, out / "temperatures.png")
