"""The command `porousmold shear`."""

import argparse
import csv
import math
import shutil
import sys
from itertools import product
from pathlib import Path
from typing import Any

from ..errors import InputError, SolveError
from ..files.atomic_files import output_file, output_folder
from ..files.stop_signals import StopSignals, acknowledge
from ..files.units import to_si, whole_number
from ..output.console import PART, Bar, Commands

FRAMES = 60
COLUMNS = (
    *("solid_fraction", "shear_rate", "friction", "peclet", "biot"),
    *(
        "conduction",
        "conduction_error",
        "convection",
        "convection_error",
        "wall_flux",
        "steady",
        "stirring_coefficient",
    ),
    *("self_diffusion", "self_diffusion_error", "pressure", "bed_friction", "coordination_number"),
    *("core_shear_rate", "core_solid_fraction", "beads", "strains"),
)
"""Of the table, all without units."""


def add_commands(commands: Commands) -> None:
    """Add the command to the program's subparsers."""
    shear = commands.add_parser("shear", help="heat conducted and carried by beads that two walls shear")
    for option, default, text in (
        ("--solid-fraction", None, "of the bed, 0.3 to 0.68"),
        ("--shear-rate", None, "dimensionless: gamma d^(3/2)/sqrt(k/rho), 1e-5 to 0.3; small for hard beads"),
        ("--friction", "0.5", "coefficient between beads and at walls (default 0.5)"),
        ("--peclet", "1", "(d/2)^2 gamma rho C/lambda of the beads (default 1)"),
        ("--biot", "0", "alpha d/lambda of the film around the beads (default 0: no fluid)"),
    ):
        shear.add_argument(option, nargs="+", default=None if default is None else [default], required=default is None,
                           metavar="X", help=f"{text}; several values: all combinations")  # fmt: skip
    for option, default, text in (
        ("--restitution", "0.9", "coefficient of restitution (default 0.9)"),
        ("--distance", "15", "of the walls, in bead diameters (default 15)"),
        ("--width", "8", "of the periodic sides, in bead diameters (default 8)"),
        ("--strains", "100", "shear strain that is measured (default 100)"),
        ("--steps-per-contact", "16", "time steps of a collision (default 16)"),
        ("--seed", "1", "same seed, same motion, but for a run that compiles, the first one (docs/sheared-bed.md)"),
    ):
        shear.add_argument(option, default=default, metavar="X", help=text)
    shear.add_argument("--walls", default="rough", metavar="KIND", help="rough (default) or flat")
    shear.add_argument("--out", default="shear.csv", metavar="FILE.csv", help="table to write (default shear.csv)")
    shear.add_argument("--animate", action="store_true", help="also FILE.gif: the first combination in motion")
    shear.add_argument("--quiet", action="store_true", help="no progress bar, no summary")
    shear.set_defaults(command=_shear)


def _shear(options: argparse.Namespace) -> int:
    out = Path(options.out)
    if out.suffix != ".csv":
        raise InputError("--out", options.out, "must end with .csv")
    from ..mpi import MPI
    from .motion import Shearing

    cells, world = _cells(options), MPI.COMM_WORLD
    parts = out.with_suffix(".parts")
    output_folder(parts)
    StopSignals()
    bar = Bar(quiet=options.quiet or bool(world.rank))
    mine, problem = range(world.rank, len(cells), world.size), None

    def shearing(number: int) -> Any:
        cell = cells[number]
        pictures = FRAMES if options.animate and number == 0 else 0
        return Shearing(cell, parts / f"{cell.identity}{'-pictured' if pictures else ''}.npz", pictures=pictures)

    try:
        for done, number in enumerate(mine):
            shearing(number).integrate(_Progress(bar, [cells[own] for own in mine], done))
    except (InputError, SolveError) as error:
        problem = error
    except KeyboardInterrupt:
        acknowledge()
        if world.rank == 0:
            print(f"porousmold: interrupted; finished blocks are in {parts}, the same command goes on", file=sys.stderr)
        if world.size > 1:
            world.Abort(130)
        return 130
    finally:
        bar.close()
    for failure in world.allgather(problem):
        if failure is not None:
            raise failure
    if world.rank == 0:
        results = [shearing(number).integrate() for number in range(len(cells))]
        text = _write(results, out, animate=options.animate)
        shutil.rmtree(parts, ignore_errors=True)
        if not options.quiet:
            print(text)
    world.Barrier()
    return 0


class _Progress:
    """Shows the strains done of all combinations of this rank."""

    def __init__(self, bar: Bar, cells: list[Any], number: int) -> None:
        self._bar, self._cell = bar, cells[number]
        self._before, self._total = sum(c.strains for c in cells[:number]), sum(c.strains for c in cells)

    def __call__(self, done: float, total: float, text: str) -> None:
        cell = self._cell
        which = f"solid fraction {cell.solid_fraction:g}, shear rate {cell.shear_rate:g}: {text}"
        self._bar.show(round(self._before + done / total * cell.strains, 3), self._total, which, PART)


def _cells(options: argparse.Namespace) -> list[Any]:
    from .cell import ShearCell

    def numbers(option: str) -> list[float]:
        return [to_si(f"--{option}", text, "") for text in getattr(options, option.replace("-", "_"))]

    def number(option: str) -> float:
        return float(to_si(f"--{option}", getattr(options, option.replace("-", "_")), ""))

    common = {
        "peclet": tuple(numbers("peclet")),
        "biot": tuple(numbers("biot")),
        "walls": options.walls,
        "restitution": number("restitution"),
        "distance": number("distance"),
        "width": number("width"),
        "strains": number("strains"),
        "steps_per_contact": whole_number("--steps-per-contact", options.steps_per_contact),
        "seed": whole_number("--seed", options.seed),
    }
    combinations = product(numbers("shear-rate"), numbers("friction"), numbers("solid-fraction"))
    return [ShearCell(fraction, rate, friction, **common) for rate, friction, fraction in combinations]


def _write(results: list[Any], out: Path, *, animate: bool) -> str:
    """The table, the pictures, and the text of the summary."""
    from .pictures import draw_motion, draw_shear

    files = [out, out.with_suffix(".png"), *([out.with_suffix(".gif")] if animate else [])]
    rows = [row for result in results for row in _rows(result)]
    with output_file(out) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        writer.writerows([["" if isinstance(v, float) and math.isnan(v) else _short(v) for v in row] for row in rows])
    draw_shear(files[1], results)
    if animate:
        draw_motion(files[2], results[0])
    lines = []
    for result in results:
        cell, diffusion = result.cell, result.self_diffusion
        lines += [
            f"solid fraction {cell.solid_fraction:g}, shear rate {cell.shear_rate:g}, friction {cell.friction:g}: "
            f"{result.beads} beads, {result.steps} steps",
            f"  pressure {result.pressure:.3g} k/d, bed friction {result.friction_coefficient:.3f}, "
            f"{result.coordination_number:.2f} contacts per bead, core sheared at {result.core_shear_rate:.2f} of the rate",
            f"  self-diffusion {diffusion[0]:.4f} +- {diffusion[1]:.4f} gamma d^2",
        ]
        if abs(result.core_shear_rate) < 0.5:
            lines.append("  warning: the walls slip, the core is hardly sheared; rough walls or a lower solid fraction")
        heading = f"  {'Pe':>8} {'Bi':>7} {'conduction':>22} {'convection':>22} {'at walls':>10} {'stirring c':>10}"
        lines.append(heading)
        for number, (peclet, biot) in enumerate(cell.pairs):
            fluxes = (result.conduction[number], result.convection[number])
            shown = " ".join(f"{f'{mean:.4g} +- {error:.1g}':>22}" for mean, error in fluxes)
            stirring = result.stirring[number]
            c = "-" if math.isnan(stirring) else f"{stirring:.4f}"
            not_steady = "" if result.steady[number] else "  not steady: more --strains"
            lines.append(f"  {peclet:8g} {biot:7g} {shown} {result.wall_flux[number]:10.4g} {c:>10}{not_steady}")
    lines.append("fluxes over lambda (T_top - T_bottom)/H of the beads' solid, +- one standard error")
    lines.append(f"written to {', '.join(map(str, files))}")
    return "\n".join(lines)


def _rows(result: Any) -> list[list[Any]]:
    cell = result.cell
    return [
        [
            *(cell.solid_fraction, cell.shear_rate, cell.friction, peclet, biot),
            *(
                *result.conduction[n],
                *result.convection[n],
                result.wall_flux[n],
                bool(result.steady[n]),
                result.stirring[n],
            ),
            *(*result.self_diffusion, result.pressure, result.friction_coefficient, result.coordination_number),
            *(result.core_shear_rate, result.core_solid_fraction, result.beads, cell.strains),
        ]
        for n, (peclet, biot) in enumerate(cell.pairs)
    ]


def _short(value: object) -> Any:
    return f"{value:.6g}" if isinstance(value, float) else value
