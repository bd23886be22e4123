"""The commands `porousmold permeability` and `porousmold test-range`."""

import argparse
import csv
import io
import json
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from ..files.atomic_files import output_file, output_folder
from ..files.units import to_si, whole_number
from ..output.console import Bar, Commands

if TYPE_CHECKING:
    from .falling_head import Levels
    from .measurement import Test

LEAST, GREATEST, GRID = 1e-12, 1e-5, 22


def add_commands(commands: Commands) -> None:
    """Add both to the subparsers of the command line."""
    measured = commands.add_parser("permeability", help="permeability of a bed from a falling-head test")
    measured.add_argument(
        "data", metavar="DATA.csv", help="'time [s], mass [g]' of the scale, or 'time [s], level [mm]'"
    )
    measured.add_argument("--setup", required=True, metavar="SETUP.toml", help="set-up, liquid and bed")
    measured.add_argument("--out", metavar="DIR", help="folder to write (default: runs/NAME OF DATA)")
    measured.add_argument("--quiet", action="store_true", help="no summary, no picture")
    measured.set_defaults(serial=_permeability)
    span = commands.add_parser("test-range", help="range of permeabilities that a falling-head set-up can measure")
    span.add_argument("setup", metavar="SETUP.toml")
    span.add_argument("--error", default="0.05", help="largest relative error of 95 %% of the tests (default 0.05)")
    span.add_argument("--longest", default="1 day", help="longest test (default 1 day)")
    span.add_argument("--head-error", default="0.5 mm", help="error of the reading of h0, half width (default 0.5 mm)")
    span.add_argument("--scale-resolution", default="1 g", help="resolution of the scale (default 1 g)")
    span.add_argument(
        "--temperature-error", default="1 K", help="standard deviation; 2 %% of viscosity per K (default 1 K)"
    )
    span.add_argument("--time-error", default="0.1 s", help="of time stamps, standard deviation (default 0.1 s)")
    span.add_argument("--samples", default="100", metavar="N", help="virtual tests per permeability (default 100)")
    span.add_argument("--out", metavar="DIR", help="folder to write (default: runs/NAME OF SETUP-range)")
    span.add_argument("--quiet", action="store_true", help="no summary, no picture")
    span.set_defaults(serial=_test_range)


def _folder(out: Path, default: Any) -> Path:
    folder = Path(out) if out else Path("runs") / default
    output_folder(folder)
    return folder


def _permeability(options: argparse.Namespace) -> str:
    from .falling_head import instantaneous
    from .measurement import evaluate, read_levels, read_setup

    test = read_setup(options.setup)
    levels, warnings = read_levels(options.data, test.setup, test.averaging_time)
    found = evaluate(test, levels)
    found["warnings"] = [*warnings, *found["warnings"]]
    folder = _folder(options.out, Path(options.data).stem)
    content = {
        "setup": asdict(test.setup),
        "approaches": {
            name: {method: None if estimate is None else asdict(estimate) for method, estimate in methods.items()}
            for name, methods in found["approaches"].items()
        },
        **{name: found[name] for name in ("predictions", "reynolds_number", "warnings")},
    }
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time [s]", "level [m]", "flow_rate [m^3/s]", "permeability [m^2]"])
    middle = [0.5 * (values[1:] + values[:-1]) for values in (levels.time, levels.level)]
    writer.writerows(zip(*middle, levels.flow_rate, instantaneous(test.setup, levels), strict=True))
    summary = _summary(test, levels, found)
    for name, written in (
        ("permeability.json", json.dumps(content, indent=2) + "\n"),
        ("permeability.csv", text.getvalue()),
    ):
        with output_file(folder / name) as temporary:
            temporary.write_text(written, encoding="utf-8")
    if options.quiet:
        return ""
    from .pictures import draw_test

    picture = draw_test(folder / "permeability.png", test, levels, found)
    return f"{summary}\nwritten to {folder}: permeability.json, permeability.csv, {picture.name}"


def _finite(values: Any) -> dict[str, Any]:
    """With None for what is no number, which JSON does not know."""
    return {name: value if np.isfinite(value) else None for name, value in values.items()}


def _summary(test: "Test", levels: "Levels", found: Any) -> str:
    setup = test.setup
    lines = [
        f"{len(levels.flow_rate)} intervals over {levels.time[-1]:.6g} s; set-up c0 = {setup.outlet_resistance:.4g} Pa s/m3, "
        f"c1 = {setup.outlet_pressure:.5g} Pa"
    ]
    for name, methods in found["approaches"].items():
        for method, estimate in methods.items():
            if estimate is not None:
                fit = f", R2 = {estimate.determination:.5f}" if estimate.determination is not None else ""
                lines.append(
                    f"{name:9s} {method:14s} k = {estimate.permeability:.4g} m2, standard deviation "
                    f"{estimate.standard_deviation / estimate.permeability:.2%}, 95 % within "
                    f"{estimate.interval[0]:.4g} to {estimate.interval[1]:.4g}{fit}"
                )
    best = found["approaches"]["complete"]["global"]
    for name, value in found["predictions"].items():
        beside = f", {value / best.permeability - 1.0:+.1%}" if best is not None else ""
        lines.append(f"{name} predicts {value:.4g} m2{beside}")
    if found["reynolds_number"] is not None:
        lines.append(f"particle Reynolds number up to {found['reynolds_number']:.3g}")
    return "\n".join([*lines, *(f"warning: {text}" for text in found["warnings"])])


def _test_range(options: argparse.Namespace) -> str:
    from .falling_head import DARCY_LIMIT
    from .measurement import LIQUIDS, read_setup
    from .virtual import ReadingErrors, accuracy, measurable_range

    test = read_setup(options.setup)
    error, longest = to_si("--error", options.error, ""), to_si("--longest", options.longest, "s")
    samples = whole_number("--samples", options.samples, 20, 100_000)
    reading = ReadingErrors(
        to_si("--head-error", options.head_error, "m"),
        to_si("--scale-resolution", options.scale_resolution, "kg"),
        0.0,
        0.02 * to_si("--temperature-error", options.temperature_error, "delta_degC"),
        to_si("--time-error", options.time_error, "s"),
    )
    if not error > 0.0 or not longest > 0.0 or min(vars(reading).values()) < 0.0:
        raise InputError("--error", options.error, "and --longest must be > 0, the errors >= 0")
    folder = _folder(options.out, f"{Path(options.setup).stem}-range")
    liquids = {name: replace(test.setup, density=rho, viscosity=mu) for name, (rho, mu, _) in LIQUIDS.items()}
    if test.setup not in liquids.values():
        liquids["this liquid"] = test.setup
    # what stays inside cannot be measured
    liquids = {name: setup for name, setup in liquids.items() if setup.rate_and_offset(1.0)[1] > 0.0}
    if test.setup not in liquids.values():
        raise InputError("setup.outlet_pressure", test.setup.outlet_pressure,
                         "must be below the pressure of the liquid column, or nothing drains", options.setup)  # fmt: skip
    permeabilities = np.geomspace(LEAST, GREATEST, GRID)
    bar = Bar(quiet=options.quiet)
    found: dict[str, list[Any]] = {name: [] for name in liquids}
    try:
        for number, (name, setup) in enumerate(liquids.items()):
            for index, permeability in enumerate(permeabilities):
                found[name].append(accuracy(setup, permeability, reading, samples=samples))
                bar.show(number * GRID + index + 1, len(liquids) * GRID, "permeabilities")
    finally:
        bar.close()
    ranges = {name: measurable_range(row, error, longest) for name, row in found.items()}
    with output_file(folder / "test-range.json") as temporary:
        content = {
            name: {"range": ranges[name], "accuracies": [_finite(asdict(a)) for a in row]}
            for name, row in found.items()
        }
        temporary.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    if options.quiet:
        return ""
    from .pictures import draw_accuracies

    lines = [f"relative error below {error:.3g} in 95 % of the tests, tests not longer than {longest / 3600.0:.4g} h:"]
    for name, span in ranges.items():
        lines.append(f"{name:14s} {f'{span[0]:.2g} to {span[1]:.2g} m2' if span else 'none'}")
        if span and test.bead_diameter is not None:
            numbers = [liquids[name].highest_reynolds_number(k, test.bead_diameter) for k in permeabilities]
            beyond = [k for k, number in zip(permeabilities, numbers, strict=True) if number > DARCY_LIMIT]
            if beyond and beyond[0] <= span[1]:
                lines.append(
                    f"  warning: from {beyond[0]:.2g} m2 on the particle Reynolds number exceeds {DARCY_LIMIT:g} with these "
                    "beads: Darcy's law does not hold, and permeabilities come out too low"
                )
    lines.append("(c0 and c1 of the set-up are the same for all liquids)")
    picture = draw_accuracies(folder / "test-range.png", found, error)
    return "\n".join([*lines, f"written to {folder}: test-range.json, {picture.name}"])
