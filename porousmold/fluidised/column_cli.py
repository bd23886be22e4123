"""The command `porousmold fluidise`."""

import argparse
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from ..files.units import given_in_si, to_si, whole_number
from .cli import write_tables
from .column_run import add_run_options, ran

if TYPE_CHECKING:
    from .column_input import ColumnInput

LENGTHS = ("width", "depth", "height", "bed-height", "bead-diameter")
TEMPERATURES = ("initial-temperature", "inlet-temperature", "wall-temperature")
UNITS = {"time": "s", "pressure_drop": "Pa", "force_on_beads": "Pa", "bed_height": "m", "highest_bead": "m"}
UNITS |= {
    "fastest_bead": "m/s",
    "bead_temperature": "K",
    "outlet_temperature": "K",
    "heat_to_walls": "J",
    "heat_imbalance": "1",
}

SPREAD_OF_THE_SURFACE, LEAST_SPREAD = 0.6, 0.03
"""Relative error of a resting bed's pressure drop times its height in cells of the gas, whose porosity falls off over one at the
surface (measured: 8, 18 and 35 % of Ergun's at 7.6, 4.3 and 2.2 cells), and what is told of it."""
AT_REST = 0.9
"""Pressure drop over the weight of the beads, below which the bed is at rest."""


def add_commands(commands: Any) -> None:
    """Add the command to the program's subparsers."""
    command = commands.add_parser(
        "fluidise", help="a small column of beads that a gas flows through and lifts, bead by bead"
    )
    for option, default, text in (
        ("--width", None, "between the walls"),
        ("--depth", None, "of the slab, periodic; not above a bead diameter: one layer of beads"),
        ("--height", None, "of the column"),
        ("--bed-height", None, "of the bed at rest"),
        ("--bead-diameter", None, "of the beads"),
        ("--velocity", None, "superficial, of the gas at the inlet temperature"),
    ):
        command.add_argument(option, required=default is None, metavar="VALUE", help=text)
    command.add_argument("--beads", required=True, metavar="MATERIAL", help="solid of `porousmold materials`")
    command.add_argument("--fluid", default="air", metavar="MATERIAL", help="fluid of that library (default air)")
    for option, default, text in (
        ("--initial-temperature", "20 degC", "of beads and gas (default 20 degC)"),
        ("--inlet-temperature", "80 degC", "of the gas (default 80 degC)"),
        ("--blocked-width", "0 mm", "in the middle of the floor, through which no gas enters (default 0)"),
        ("--smallest-diameter", None, "beads are spread evenly from it to --bead-diameter (default: all have that)"),
        ("--wall-temperature", "20 degC", "of the walls (default 20 degC)"),
        ("--wall-coefficient", "0 W/m^2/K", "from the gas to the walls at the sides (default 0)"),
        ("--depth-coefficient", "0 W/m^3/K", "from the gas to front and rear, per volume (default 0)"),
        ("--depth-drag", "0 kg/m^3/s", "of front and rear on the gas, 12 viscosity/depth^2 of a gap (default 0)"),
        ("--friction", "0.3", "coefficient between beads and at walls (default 0.3)"),
        ("--drag", "gidaspow", "on the beads: gidaspow (default), or di-felice as in equation (12) of Henry et al."),
        ("--nusselt", "wakao", "correlation of the film around the beads, as model.nusselt of a scene (default wakao)"),
        ("--cell-size", "3.5", "of the gas's cells, in bead diameters (default 3.5)"),
    ):
        command.add_argument(option, default=default, metavar="VALUE", help=text)
    add_run_options(command, "fluidise", "column.gif: the beads, coloured by temperature")
    command.set_defaults(serial=_fluidise)


def _fluidise(options: argparse.Namespace) -> str:
    from .column import Column

    return ran(Column, _input(options), _write, options)


def _input(options: argparse.Namespace) -> "ColumnInput":
    from ..laws.fluidisation import ATMOSPHERE
    from ..laws.material_library import FLUIDS, SOLIDS, named
    from ..laws.materials import beyond_ranges
    from ..laws.phases import other_phase
    from .column_input import ColumnInput

    beads, fluid = named("--beads", options.beads, SOLIDS), named("--fluid", options.fluid, FLUIDS)
    start, inlet, wall = (
        given_in_si(f"--{name}", getattr(options, name.replace("-", "_")), "K") for name in TEMPERATURES
    )
    for name, value in zip(TEMPERATURES, (start, inlet, wall), strict=True):
        if not 150.0 < value < 5000.0:
            raise InputError(f"--{name}", value, "must be > 150 and < 5000 K")
        if (text := other_phase(fluid.name, ATMOSPHERE, value)) is not None:
            raise InputError(f"--{name}", value, f"does not fit --fluid: {text}")
    ends = min(start, inlet), max(start, inlet)
    beyond = beyond_ranges(beads, *ends, ("density", "heat_capacity"))
    for text in beyond + beyond_ranges(fluid, *ends, ("viscosity", "heat_capacity", "conductivity")):
        print(f"warning: {text}", file=sys.stderr)
    lengths = {
        name.replace("-", "_"): to_si(f"--{name}", getattr(options, name.replace("-", "_")), "m") for name in LENGTHS
    }
    for name, value in lengths.items():
        if not value > 0.0:
            raise InputError(f"--{name.replace('_', '-')}", value, "must be > 0 m")
    smallest = options.smallest_diameter
    return ColumnInput(
        **lengths,
        velocity=to_si("--velocity", options.velocity, "m/s"),
        density=float(fluid.density(ATMOSPHERE, inlet)),
        viscosity=float(fluid.viscosity(inlet)),
        heat_capacity=float(fluid.heat_capacity(inlet)),
        conductivity=float(fluid.conductivity(inlet)),
        bead_density=float(beads.density(start)),
        bead_heat_capacity=float(beads.heat_capacity(start)),
        blocked_width=to_si("--blocked-width", options.blocked_width, "m"),
        initial_temperature=start,
        inlet_temperature=inlet,
        smallest_diameter=None if smallest is None else to_si("--smallest-diameter", smallest, "m"),
        wall_temperature=wall,
        wall_coefficient=to_si("--wall-coefficient", options.wall_coefficient, "W/(m^2*K)"),
        depth_coefficient=to_si("--depth-coefficient", options.depth_coefficient, "W/(m^3*K)"),
        depth_drag=to_si("--depth-drag", options.depth_drag, "kg/(m^3*s)"),
        friction=to_si("--friction", options.friction, ""),
        cell_size=to_si("--cell-size", options.cell_size, ""),
        seed=whole_number("--seed", options.seed),
        drag=options.drag,
        nusselt=options.nusselt,
    )


def _of_the_surface(column: Any, drop: float, bed_height: float) -> list[str]:
    """Of the pressure drop of a bed at rest, whose surface the cells of the gas spread."""
    cells = bed_height / (column.given.cell_size * column.given.bead_diameter)
    low = SPREAD_OF_THE_SURFACE / cells
    if drop > AT_REST * column.weight or low < LEAST_SPREAD:
        return []
    return [
        f"warning: the bed is {cells:.2g} cells high: at rest its pressure drop is some {low:.0%} low (a smaller --cell-size)"
    ]


def _write(column: Any, out: Path, pictures: list[Any]) -> str:
    """History, summary and pictures; gives the text of the summary."""
    from .column_pictures import draw_column, draw_motion

    rows, half = column.rows, column.rows[len(column.rows) // 2 :]

    def mean(name: str) -> float:
        return float(sum(row[name] for row in half) / len(half))

    summary = {
        "beads": len(column.beads),
        "weight": column.weight,
        "pressure_drop": mean("pressure_drop"),
        "force_on_beads": mean("force_on_beads"),
        "bed_height": mean("bed_height"),
        "bed_height_at_first": rows[0]["bed_height"],
        "bead_temperature": rows[-1]["bead_temperature"],
        "outlet_temperature": rows[-1]["outlet_temperature"],
        "heat_imbalance": rows[-1]["heat_imbalance"],
        "time": rows[-1]["time"],
        "steps": len(rows),
        "input": asdict(column.given),
    }
    write_tables(out, summary, UNITS, ([f"{row[name]:.9g}" for name in UNITS] for row in rows))
    files = [
        draw_column(out / "column.png", column),
        *([draw_motion(out / "column.gif", column, pictures)] if pictures else []),
    ]
    drop, force = summary["pressure_drop"], summary["force_on_beads"]
    height, first = 1e3 * summary["bed_height"], 1e3 * summary["bed_height_at_first"]
    beads, gas = summary["bead_temperature"] - 273.15, summary["outlet_temperature"] - 273.15
    lines = [
        f"{summary['beads']} beads, {summary['steps']} steps of {column.given.time_step:.2g} s; means over the second half:",
        f"pressure drop {drop:.4g} Pa, {drop / column.weight:.3f} of the weight of the beads; force on the beads {force:.4g} Pa",
        *_of_the_surface(column, drop, summary["bed_height"]),
        f"bed height {height:.3g} mm, at first {first:.3g} mm",
        f"beads {beads:.2f} °C, gas at the outlet {gas:.2f} °C; relative heat imbalance {summary['heat_imbalance']:.1e}",
        f"written to {out}: result.json, history.csv, {', '.join(path.name for path in files)}",
    ]
    column.free()
    return "\n".join(lines)
