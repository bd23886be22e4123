"""The command `porousmold droplet`."""

import argparse
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from ..files.units import given_in_si, whole_number
from .cli import write_tables
from .column_run import add_run_options, ran

if TYPE_CHECKING:
    from .droplet_input import DropletInput

PAPER_BEADS = {"bead_density": 3200.0, "bead_heat_capacity": 290.0, "bead_conductivity": 234.0}
"""Henry et al., table 2, SI: as printed (for bronze, 8800 kg/m3, it would be a bulk density)."""
PAPER_GAS = {"density": 1.204, "viscosity": 2e-5, "heat_capacity": 1040.0, "conductivity": 0.026}
"""The same of the gas, and of the vapour."""
LENGTHS = {
    "droplet-diameter": ("2.5 mm", "of the droplet"),
    "release-height": ("1.5 mm", "of its centre above the bed, from which it falls"),
    "grain-diameter": ("55 um", "of the grains of the bed"),
    "parcel-diameter": ("0.25 mm", "of the parcels that stand for many grains each"),
    "width": ("8 mm", "of the column"),
    "bed-height": ("10 mm", "of the bed at rest"),
    "height": ("20 mm", "of the column"),
}
NUMBERS = {
    "solid-fraction": ("0.4", "share of the grains in the volume of the bed"),
    "bond": ("10", "of grains in contact where there is little vapour, in weights of a grain"),
    "friction": ("0.3", "coefficient between beads and at walls"),
    "cell-size": ("1.5", "of the gas's cells, in parcel diameters"),
    "relative-step": ("0.05", "time step in sqrt(parcel diameter/g)"),
}
CHOICES = {
    "conduction": ("bed", "heat reaches the droplet through the bed at rest (bed) or its gas alone (gas)"),
    "contact": ("mixture", "grains enter the droplet (mixture), or its vapour keeps hot ones out (film)"),
    "drag": ("gidaspow", "on the grains: gidaspow, or di-felice as in equation (12) of Henry et al."),
    "nusselt": ("henry", "film around the grains, as model.nusselt of a scene"),
}
UNITS = {"time": "s", "depth": "m", "speed": "m/s", "across": "m", "water": "1", "radius": "m"}
UNITS |= {"heat_by_gas": "W", "heat_by_beads": "W", "evaporation": "kg/s", "force_by_gas": "N", "force_by_beads": "N"}
UNITS |= {"weight": "N", "beads_inside": "1", "bead_temperature": "K", "highest_bead": "m", "force_on_floor": "N"}
UNITS |= {"force_on_beads": "N", "heat_imbalance": "1", "vapour_imbalance": "1"}


def add_commands(commands: Any) -> None:
    """Add the command to the program's subparsers."""
    command = commands.add_parser("droplet", help="a droplet of water on a hot bed of grains, which it may dig into")
    command.add_argument(
        "--bed-temperature", default="400 degC", metavar="VALUE", help="of bed and gas at first (default 400 degC)"
    )
    for option, (default, text) in (LENGTHS | NUMBERS | CHOICES).items():
        command.add_argument(f"--{option}", default=default, metavar="VALUE", help=f"{text} (default {default})")
    command.add_argument(
        "--beads", metavar="MATERIAL", help="solid of `porousmold materials` (default: table 2 of Henry et al.)"
    )
    command.add_argument(
        "--fluid", metavar="MATERIAL", help="gas of that library, at 20 degC (default: table 2 of Henry et al.)"
    )
    add_run_options(command, "droplet", "droplet.gif: grains and droplet")
    command.set_defaults(serial=_droplet)


def _droplet(options: argparse.Namespace) -> str:
    from .droplet_column import DropletColumn

    return ran(DropletColumn, _input(options), _write, options)


def _input(options: argparse.Namespace) -> "DropletInput":
    from ..laws.fluidisation import ATMOSPHERE
    from ..laws.material_library import FLUIDS, SOLIDS, named
    from .droplet_input import DropletInput

    def value(option: str, unit: str) -> float:
        return given_in_si(f"--{option}", getattr(options, option.replace("-", "_")), unit)

    temperature = value("bed-temperature", "K")
    if not temperature < 2000.0:
        raise InputError("--bed-temperature", options.bed_temperature, "must be < 2000 K")
    lengths = {name: value(name, "m") for name in LENGTHS}
    for name, length in lengths.items():
        if not length > 0.0:
            raise InputError(f"--{name}", length, "must be > 0 m")
    lengths["bead-diameter"] = lengths.pop("parcel-diameter")
    numbers = {name: value(name, "") for name in NUMBERS}
    for name, number in numbers.items():
        if not (number > 0.0 or (name in ("bond", "friction") and number == 0.0)):
            raise InputError(f"--{name}", number, "must be > 0")
    beads: Mapping[str, Any] = PAPER_BEADS
    if options.beads is not None:
        solid = named("--beads", options.beads, SOLIDS)
        beads = {
            "bead_density": float(solid.density(temperature)),
            "bead_heat_capacity": float(solid.heat_capacity(temperature)),
            "bead_conductivity": float(solid.conductivity(temperature)),
        }
    gas: Mapping[str, Any] = PAPER_GAS
    if options.fluid is not None:
        fluid, at = named("--fluid", options.fluid, FLUIDS), 293.15
        gas = {
            "density": float(fluid.density(ATMOSPHERE, at)),
            "viscosity": float(fluid.viscosity(at)),
            "heat_capacity": float(fluid.heat_capacity(at)),
            "conductivity": float(fluid.conductivity(at)),
        }
    named_values: dict[str, Any] = {name.replace("-", "_"): number for name, number in (lengths | numbers).items()}
    return DropletInput(
        **named_values,
        **beads,
        **gas,
        **{name: getattr(options, name) for name in CHOICES},
        depth=lengths["bead-diameter"],
        initial_temperature=temperature,
        seed=whole_number("--seed", options.seed),
    )


def _write(column: Any, out: Path, pictures: list[Any]) -> str:
    """History, summary and pictures; gives the text of the summary."""
    from .droplet_pictures import draw_droplet, draw_moving_droplet

    rows, given = column.rows, column.given
    late = [row for row in rows if row["time"] > rows[-1]["time"] - 0.5]

    def mean(name: str) -> float:
        return float(sum(row[name] for row in late) / len(late))

    weight, evaporation = mean("weight"), mean("evaporation")
    summary = {
        "beads": len(column.beads),
        "grains_a_bead": column.beads.fill * (given.bead_diameter / given.grain_diameter) ** 3,
        "time": rows[-1]["time"],
        "steps": len(rows),
        "input": asdict(column.given),
        "depth": mean("depth"),
        "depth_in_diameters": mean("depth") / given.droplet_diameter,
        "deepest": max(row["depth"] for row in rows),
        "water": rows[-1]["water"],
        "lifetime_at_this_rate": column.droplet.mass / evaporation if evaporation > 0.0 else None,
        "heat_by_beads_of_all": mean("heat_by_beads") / max(mean("heat_by_beads") + mean("heat_by_gas"), 1e-30),
        "force_by_gas_in_weights": mean("force_by_gas") / weight,
        "force_by_beads_in_weights": mean("force_by_beads") / weight,
        "bead_temperature": rows[-1]["bead_temperature"],
        "highest_bead_above_surface": max(row["highest_bead"] for row in rows) - column.surface,
        "heat_imbalance": rows[-1]["heat_imbalance"],
        "vapour_imbalance": rows[-1]["vapour_imbalance"],
    }
    write_tables(out, summary, UNITS, ([f"{row[name]:.9g}" for name in UNITS] for row in rows))
    files = [
        draw_droplet(out / "droplet.png", column),
        *([draw_moving_droplet(out / "droplet.gif", column, pictures)] if pictures else []),
    ]
    lifetime = summary["lifetime_at_this_rate"]
    gone = f"{lifetime:.3g} s" if lifetime is not None else "no finite time"
    share = 100.0 * summary["heat_by_beads_of_all"]
    lines = [
        f"{summary['beads']} parcels of {summary['grains_a_bead']:.0f} grains, {summary['steps']} steps of "
        f"{given.time_step:.2g} s; means over the last {min(0.5, summary['time']):.2g} s:",
        f"depth of the droplet's centre: {1e3 * summary['depth']:.2f} mm, {summary['depth_in_diameters']:.2f} of its diameter "
        f"(deepest {1e3 * summary['deepest']:.2f} mm)",
        f"water left: {100.0 * summary['water']:.1f} %; at this rate gone in {gone}; {share:.0f} % of its heat by grains inside",
        f"forces in weights of the water: gas {summary['force_by_gas_in_weights']:+.2f}, grains inside "
        f"{summary['force_by_beads_in_weights']:+.2f}",
        f"relative imbalance of heat {summary['heat_imbalance']:.1e}, of vapour {summary['vapour_imbalance']:.1e}",
        "a research model in two dimensions, by parcels of grains: depths are not converged (docs/droplet.md)",
        f"written to {out}: result.json, history.csv, {', '.join(path.name for path in files)}",
    ]
    return "\n".join(lines)
