"""The commands `porousmold rotameter` and `porousmold compare`."""

import argparse
import json
import sys
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..files.atomic_files import output_file, output_folder
from ..files.tables import time_offset
from ..files.units import given_in_si, to_si
from ..output.console import Commands

REFERENCE = (200.0, 500.0)
"""Temperatures (K) between which the scale of a rotameter may be given."""


def add_commands(commands: Commands) -> None:
    """Add both to the subparsers of the command line."""
    rotameter = commands.add_parser(
        "rotameter", help="inlet velocity and temperature of a scene from a logger's readings"
    )
    rotameter.add_argument(
        "log", metavar="LOG.csv", help="time, flow, rotameter_ and inlet_ pressure and temperature, with units"
    )
    rotameter.add_argument("--diameter", required=True, metavar="LENGTH", help="inner diameter of the bed's pipe")
    rotameter.add_argument(
        "--reference-temperature",
        required=True,
        metavar="T",
        help="reference temperature of the rotameter, such as '21 degC'",
    )
    rotameter.add_argument(
        "--interval", default="10 s", metavar="TIME", help="averaging interval of the readings (default 10 s)"
    )
    rotameter.add_argument("--out", metavar="DIR",
                           help="for inlet_velocity.csv and inlet_temperature.csv (default: runs/NAME OF LOG)")  # fmt: skip
    rotameter.set_defaults(serial=_rotameter)
    compare = commands.add_parser("compare", help="compare a run with a measurement, or with another run")
    compare.add_argument("run", metavar="RUN", help="folder of a run of a scene with geometry.sensors")
    compare.add_argument("measured", nargs="+", metavar="MEASURED.csv|RUN",
                         help="'time [s], NAME [degC], ...' with the sensors' names, in one file or more; or a run")  # fmt: skip
    compare.add_argument("--bounds", nargs="+", default=[], metavar="RUN", help="runs with an input at the bounds of its "
                         "error, such as operation.outer_heat_flux_factor 0.95 and 1.05")  # fmt: skip
    compare.add_argument(
        "--column", action="append", default=[], metavar="SENSOR=COLUMN", help="the column of a sensor"
    )
    compare.add_argument(
        "--time-offset", metavar="TIME", help="taken from the measured times; 'first': the first row's"
    )
    compare.add_argument("--out", metavar="DIR", help="of two runs: folder to write (default: runs/RUN-beside-RUN)")
    compare.set_defaults(serial=_compare)


def _rotameter(options: argparse.Namespace) -> str:
    from .rotameter import averaged, inlet_velocity, read_log

    diameter = to_si("--diameter", options.diameter, "m")
    reference = given_in_si("--reference-temperature", options.reference_temperature, "K")
    interval = to_si("--interval", options.interval, "s")
    for name, value in (("diameter", diameter), ("reference-temperature", reference), ("interval", interval)):
        if value <= 0.0:
            raise InputError(f"--{name}", getattr(options, name.replace("-", "_")), "must be > 0")
    if not REFERENCE[0] <= reference <= REFERENCE[1]:
        allowed = f"must be >= {REFERENCE[0]:g} and <= {REFERENCE[1]:g} K, of a rotameter's scale"
        raise InputError("--reference-temperature", options.reference_temperature, allowed)
    time, log, gaps = read_log(Path(options.log))
    if interval > time[-1] - time[0]:
        print(
            f"warning: --interval is longer than {options.log}: readings between its ends are one mean", file=sys.stderr
        )
    if gaps:
        print(f"warning: {gaps} missing value(s) of {options.log}, interpolated", file=sys.stderr)
    velocity = inlet_velocity(**log, area=0.25 * np.pi * diameter**2, reference_temperature=reference)
    if not np.all(np.isfinite(velocity)):
        raise InputError("--diameter", options.diameter, "gives no finite velocity")
    folder = Path(options.out) if options.out else Path("runs") / Path(options.log).stem
    output_folder(folder)
    for name, unit, values in (("velocity", "m/s", velocity), ("temperature", "K", log["inlet_temperature"])):
        rows = "".join(f"{t:.15g}, {v:.8g}\n" for t, v in zip(*averaged(time, values, interval), strict=True))
        with output_file(folder / f"inlet_{name}.csv") as temporary:
            temporary.write_text(f"time [s], {name} [{unit}]\n{rows}", encoding="utf-8")
    return (
        f"superficial velocity {velocity.min():.4g} to {velocity.max():.4g} m/s\n"
        f"written to {folder}: inlet_velocity.csv, inlet_temperature.csv"
    )


def _compare(options: argparse.Namespace) -> str:
    from ..output.stored import locked_folder
    from .comparison import POSITION_ERROR, SENSOR_ERROR, average_deviation, compare
    from .pictures import draw_comparison

    folder = Path(options.run)
    if Path(options.measured[0]).is_dir():
        return _beside(options)
    bounds = [Path(other) for other in options.bounds]
    pairs = [text.partition("=")[::2] for text in options.column]
    columns = dict(pairs)
    if len(columns) < len(pairs):
        raise InputError("--column", ", ".join(options.column), "must name every sensor once")
    known = {None: 0.0, "first": None}
    given = options.time_offset
    offset = known[given] if given in known else time_offset("--time-offset", given)
    compared = [compare(folder, Path(path), bounds, columns, offset) for path in options.measured]
    found = [deviation for each in compared for deviation in each.deviations]
    if not found:
        raise InputError("MEASURED", str(options.measured[0]), "has no value at the times of the run")
    names = [deviation.name for deviation in found]
    if twice := [name for name in names if names.count(name) > 1]:
        raise InputError("MEASURED", str(options.measured[-1]), f"has {twice[0]!r} a second time")
    content = {
        "average_deviation": average_deviation(found),
        "sensors": {
            d.name: {
                "average": d.average,
                "bias": d.bias,
                "largest": d.largest,
                "largest_uncertainty": float(np.max(d.uncertainty)),
                "within_errors": float(np.mean(d.within)),
            }
            for d in found
        },
    }
    with locked_folder(folder, "written"):
        picture = draw_comparison(folder / "comparison.png", found)
        with output_file(folder / "comparison.json") as temporary:
            temporary.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    within = sum(int(np.sum(d.within)) for d in found)
    points = sum(len(d.time) for d in found)
    lines = [f"S_ave = {content['average_deviation']:.3f} K over {points} points of {len(found)} sensors; "
             f"{within / points:.0%} within the errors of sensors ({SENSOR_ERROR:g} K, {1e3 * POSITION_ERROR:g} mm)"
             + (" and bounds" if options.bounds else "")]  # fmt: skip
    lines += [
        f"{d.name}: on average {d.average:.3f} K apart, bias {d.bias:+.3f} K, at most {d.largest:.3f} K; "
        f"the run is uncertain by {np.max(d.uncertainty):.3f} K at most"
        for d in found
    ]
    if left_out := [name for each in compared for name in each.left_out]:
        lines.append(f"not compared, as they are no sensors of the run: {', '.join(left_out)}")
    if gaps := sum(each.gaps for each in compared):
        lines.append(f"{gaps} missing value(s) of the measurement left out")
    if beyond := sum(each.beyond for each in compared):
        lines.append(f"{beyond} value(s) of the measurement left out, before or after the run")
    return "\n".join([*lines, f"written to {folder}: comparison.json, {picture.name}"])


def _beside(options: argparse.Namespace) -> str:
    from ..output.side_by_side import beside

    if len(options.measured) > 1 or options.bounds:
        raise InputError("RUN", ", ".join(options.measured), "two runs are compared, without --bounds")
    first, second = Path(options.run), Path(options.measured[0])
    out = Path(options.out) if options.out else Path("runs") / f"{first.name}-beside-{second.name}"
    return beside(first, second, out)
