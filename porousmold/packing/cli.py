"""The commands `porousmold pack` and `porousmold porosity`."""

import argparse
import json
import math
import sys
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

from ..errors import InputError
from ..files.atomic_files import output_file
from ..files.units import given_in_si, to_si, whole_number
from ..output.console import PART, Bar, Commands
from .packing import Packing

if TYPE_CHECKING:
    from .averaging import MeasuredProfile
    from .container import Container
    from .files import Placement
    from .fitting import Fits
    from .generator import Mixture

LARGEST_CONTACT = 0.5
"""Contact radius over bead radius."""
SIZES = ("diameter", "width", "depth", "gap")


def add_commands(commands: Commands) -> None:
    """Add both to the subparsers of the command line; each handler takes the parsed options and gives its text."""
    pack = commands.add_parser("pack", help="generate a packing: beads poured into a container (DEM)")
    _add_container(pack)
    pack.add_argument("--bead-diameter", metavar="LENGTH", help="diameter of beads of one size")
    pack.add_argument(
        "--mixture", nargs="+", metavar="DIAMETER:SHARE", help="diameters and fractions, such as '3 mm:0.3' '6 mm:0.7'"
    )
    pack.add_argument(
        "--fractions", default="mass", metavar="BY", help="fractions of a mixture by mass (default) or number"
    )
    pack.add_argument("--beads", metavar="N", help="number of beads")
    pack.add_argument(
        "--bed-height", metavar="LENGTH", help="instead of --beads: fill slightly above it; void fractions refer to it"
    )
    pack.add_argument("--void-fraction", metavar="X", help="target void fraction, reached by adjusting the friction")
    pack.add_argument("--friction", metavar="MU", help="friction coefficient of beads and walls (default 0.1)")
    pack.add_argument("--seed", default="1", metavar="N", help="random seed (default 1)")
    pack.add_argument("--out", default="packing.h5", metavar="FILE.h5", help="HDF5 file to write (default packing.h5)")
    pack.add_argument("--extxyz", metavar="FILE", help="write extended XYZ too")
    pack.add_argument("--vtk", metavar="FILE", help="write VTK too")
    pack.add_argument("--quiet", action="store_true", help="no progress bar, no summary")
    pack.set_defaults(serial=_pack)

    conducting = commands.add_parser(
        "conductivity", help="effective conductivity of a packing between two walls, from its contacts and gaps"
    )
    conducting.add_argument(
        "packing", metavar="PACKING", help="packing in a slab: HDF5 of `pack`, or another code's file"
    )
    _add_container(conducting)
    conducting.add_argument("--bead-diameter", metavar="LENGTH", help="where the file holds none")
    conducting.add_argument(
        "--beads", required=True, metavar="MATERIAL", help="bead material of `porousmold materials`"
    )
    conducting.add_argument("--fluid", default="air", metavar="MATERIAL", help="fluid of that library (default air)")
    conducting.add_argument(
        "--temperature", default="300 K", metavar="TEMPERATURE", help="temperature of the properties (default 300 K)"
    )
    conducting.add_argument(
        "--contact-radius",
        metavar="SHARE",
        help="contact radius over bead radius (default 0: gaps only)",
    )
    conducting.add_argument("--pressure", metavar="PRESSURE", help="in the bed, in place of it: contacts of Hertz")
    conducting.add_argument("--youngs-modulus", metavar="PRESSURE", help="of the beads, beside --pressure")
    conducting.add_argument(
        "--bed-height", metavar="LENGTH", help="evaluated up to this height (default: levelled height)"
    )
    conducting.add_argument("--out", required=True, metavar="FILE.csv", help="conductivity against wall distance")
    conducting.set_defaults(serial=_conductivity)
    porosity = commands.add_parser("porosity", help="phi_V and phi_A against wall distance, from a packing")
    porosity.add_argument(
        "packing", metavar="PACKING", help="HDF5 of `pack`, LIGGGHTS dump, YADE text, extended XYZ, CSV, NPY, NPZ"
    )
    _add_container(porosity)
    porosity.add_argument("--bead-diameter", metavar="LENGTH", help="where the file holds none")
    porosity.add_argument(
        "--bed-height", metavar="LENGTH", help="height of the bed to average over (default: levelled height)"
    )
    porosity.add_argument(
        "--grid", metavar="LENGTH", help="sample on a grid of this spacing as in the thesis, not in strata"
    )
    porosity.add_argument(
        "--out", default="profile.csv", metavar="FILE.csv", help="profile for bed.porosity_profile of a scene"
    )
    porosity.add_argument("--fitted", metavar="FILE.csv", help="write the piecewise-linear fit as a profile too")
    porosity.add_argument("--quiet", action="store_true", help="no summary, no picture")
    porosity.set_defaults(serial=_porosity)


def _add_container(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--container", metavar="KIND", help="cylinder (--diameter), box (--width --depth) or "
                        "slab between two walls (--gap, --width of its periodic side); of a dump "
                        "a box or slab without sizes is that of ITEM: BOX BOUNDS")  # fmt: skip
    for name in SIZES:
        parser.add_argument(f"--{name}", metavar="LENGTH")
    parser.add_argument("--axis", choices=("x", "y", "z"), default="z", help="upright axis of the file's coordinates")
    parser.add_argument(
        "--floor", default="0", metavar="LENGTH", help="where the container's floor stands along that axis"
    )
    parser.add_argument("--centre", nargs=2, default=("0", "0"), metavar="LENGTH",
                        help="where its middle stands across: x, y (of axis y: z, x; of axis x: y, z)")  # fmt: skip


def _container(options: argparse.Namespace) -> "Container | None":
    from .container import container

    sizes = _sizes(options)
    if options.container is None:
        if sizes:
            raise InputError("--container", None, "is missing: cylinder, box or slab")
        return None
    return container(options.container, sizes)


def _sizes(options: argparse.Namespace) -> dict[str, float]:
    return {name: to_si(f"--{name}", text, "m") for name in SIZES if (text := getattr(options, name)) is not None}


def _placed(options: argparse.Namespace) -> "tuple[Container | None, Placement | None]":
    """Container and placement of the packing that a file has; a box or slab without sizes is that of the dump."""
    from .files import Placement, placed_bounds

    if options.container in ("box", "slab") and not _sizes(options):
        return placed_bounds(options.packing, options.container, options.axis)
    first, second = (to_si("--centre", text, "m") for text in options.centre)
    return _container(options), Placement(options.axis, to_si("--floor", options.floor, "m"), (first, second))


def _settled(options: argparse.Namespace, bead_diameter: float | None) -> Packing:
    """The packing of the options without beads in flight; what is left out, and beads that reach into walls, are said."""
    from .files import read_packing
    from .packing import REACH

    box, placement = _placed(options)
    packing, left_out = read_packing(options.packing, box, bead_diameter, placement).settled()
    if left_out:
        print(f"left out: {left_out} bead(s) above the bed that touch none of its beads", file=sys.stderr)
    if packing.reaching.any():
        count = f"{packing.reaching.sum()} of {packing.diameters.size} beads"
        print(f"{count} reach into a wall by more than {REACH:.0%} of their diameter", file=sys.stderr)
    return packing


def _optional(options: argparse.Namespace, name: str, unit: str) -> float | None:
    text = getattr(options, name.replace("-", "_"))
    value = None if text is None else to_si(f"--{name}", text, unit)
    if value is not None and value < 0.0:
        raise InputError(f"--{name}", text, "must not be negative")
    return value


def _whole(options: argparse.Namespace, name: str) -> int | None:
    text = getattr(options, name)
    return None if text is None else whole_number(f"--{name}", text)


def _mixture(options: argparse.Namespace) -> "Mixture":
    from .generator import Mixture

    if (options.bead_diameter is None) == (options.mixture is None):
        raise InputError("--bead-diameter", options.bead_diameter, "give either it or --mixture")
    if options.mixture is None:
        return Mixture((to_si("--bead-diameter", options.bead_diameter, "m"),))
    diameters, shares = [], []
    for text in options.mixture:
        diameter, colon, share = text.rpartition(":")
        if not colon:
            raise InputError("--mixture", text, "must be DIAMETER:SHARE, such as '3 mm:0.3'")
        diameters.append(to_si("--mixture", diameter, "m"))
        shares.append(to_si("--mixture", share, ""))
    return Mixture(tuple(diameters), tuple(shares), options.fractions)


def _pack(options: argparse.Namespace) -> str | None:
    box, mixture = _container(options), _mixture(options)
    if box is None:
        raise InputError("--container", None, "is missing: cylinder, box or slab")
    from .files import check_writable, write_packing
    from .generator import pack

    check_writable(options.out, options.extxyz, options.vtk)
    bed_height = _optional(options, "bed-height", "m")
    bar = Bar(quiet=options.quiet)
    try:
        packing = pack(
            box,
            mixture,
            beads=_whole(options, "beads"),
            bed_height=bed_height,
            void_fraction=_optional(options, "void-fraction", ""),
            friction=_optional(options, "friction", ""),
            seed=whole_number("--seed", options.seed),
            progress=_Progress(bar),
        )
    finally:
        bar.close()
    write_packing(packing, options.out, options.extxyz, options.vtk)
    return None if options.quiet else _packing_text(packing, bed_height, options.out)


def _packing_text(packing: Packing, bed_height: float | None, out: Path) -> str:
    made, height = packing.made, "the levelled height" if bed_height is None else f"{bed_height * 1e3:g} mm"
    if bed_height is not None and bed_height > packing.top:
        print(f"warning: the bed ends at {packing.top * 1e3:.4g} mm, below {height}: its void fraction counts the space above it",
              file=sys.stderr)  # fmt: skip
    lines = [
        f"{packing.diameters.size} beads, levelled height {packing.levelled_height * 1e3:.1f} mm",
        f"void fraction from the floor to {height}: {packing.void_fraction(bed_height):.4f} (friction {made['friction']:.4g})",
        f"contacts per bead: {packing.coordination_number:.2f} ({packing.bead_coordination_number:.2f} with other beads); "
        f"mean overlap {packing.mean_overlap:.2%} of d",
        f"at rest: kinetic energy {made['kinetic_energy']:.1e} m g d, residual force {made['residual_force']:.1e} m g per bead",
        f"written to {out}",
    ]
    return "\n".join(lines)


class _Progress:
    """Shows progress towards rest: the logarithm of the kinetic energy that is still to go, after the fall."""

    def __init__(self, bar: Bar) -> None:
        self._bar, self._largest, self._shown, self._time = bar, 0.0, -math.inf, 0.0

    def __call__(self, time: float, energy: float, residual: float) -> None:
        from .generator import LARGEST_KINETIC_ENERGY

        if time < self._time:  # a new packing of a search
            self._largest = 0.0
        self._time = time
        self._largest = max(self._largest, energy, 1e-3)
        if monotonic() - self._shown < 0.2 and energy > LARGEST_KINETIC_ENERGY:
            return
        self._shown = monotonic()
        done = math.log(self._largest / max(energy, LARGEST_KINETIC_ENERGY)) / math.log(
            self._largest / LARGEST_KINETIC_ENERGY
        )
        text = f"kinetic energy {energy:.1e} m g d, residual force {residual:.1e} m g"
        self._bar.show(round(max(done, 0.0), 3), 1.0, text, PART)


def _porosity(options: argparse.Namespace) -> str | None:
    from ..laws.porosity_profile import write_profile
    from .averaging import grid_profile, stratified_profile, thin_shell_porosity
    from .files import check_writable
    from .fitting import profile_fits

    picture = None if options.quiet else Path(options.out).with_suffix(".png")
    check_writable(options.out, options.fitted, picture, sources=[options.packing])
    bed_height, spacing = _optional(options, "bed-height", "m"), _optional(options, "grid", "m")
    bead_diameter = _optional(options, "bead-diameter", "m")
    if bead_diameter == 0.0:
        raise InputError("--bead-diameter", bead_diameter, "must be > 0")
    packing = _settled(options, bead_diameter)
    if spacing is None:
        profile = stratified_profile(packing, bed_height)
    elif 0.0 < spacing < packing.container.smallest_width:
        profile = grid_profile(packing, spacing, bed_height)
    else:
        raise InputError("--grid", options.grid, f"must be > 0 and < {packing.container.smallest_width:g} m")
    source = [
        f"from {options.packing}: {packing.diameters.size} beads, Sauter mean diameter {packing.bead_diameter:.6g} m"
    ]
    write_profile(options.out, profile, source)
    fits = profile_fits(profile)
    if options.fitted:
        write_profile(options.fitted, profile, [*source, "piecewise-linear fits"], *fits)
    if picture is None:
        return None
    from .pictures import draw_profile

    draw_profile(picture, profile, fits, thin_shell_porosity(packing, bed_height))
    written = [options.out, str(picture)] + ([options.fitted] if options.fitted else [])
    return _porosity_text(packing, profile, fits, bed_height) + f"\nwritten to {', '.join(written)}"


def _conductivity(options: argparse.Namespace) -> str:
    from ..laws.material_library import FLUIDS, SOLIDS, named
    from ..laws.materials import beyond_ranges
    from .conduction import conduction, hertz_contact_radius, zehner_bauer_schluender
    from .files import check_writable
    from .pictures import draw_conduction

    temperature, height = given_in_si("--temperature", options.temperature, "K"), _optional(options, "bed-height", "m")
    share = _optional(options, "contact-radius", "") or 0.0
    pressure, modulus = _optional(options, "pressure", "Pa"), _optional(options, "youngs-modulus", "Pa")
    if (pressure is None) != (modulus is None) or (pressure is not None and options.contact_radius is not None):
        raise InputError("--pressure", options.pressure, "give it with --youngs-modulus, and without --contact-radius")
    if modulus is not None and modulus == 0.0:
        raise InputError("--youngs-modulus", options.youngs_modulus, "must be > 0 Pa")
    bead_material, gas = named("--beads", options.beads, SOLIDS), named("--fluid", options.fluid, FLUIDS)
    if not 0.0 <= share <= LARGEST_CONTACT:
        raise InputError("--contact-radius", share, f"must be >= 0 and <= {LARGEST_CONTACT:g} bead radii")
    if not 0.0 < temperature < 5000.0:
        raise InputError("--temperature", temperature, "must be > 0 and < 5000 K")
    table = Path(options.out)
    files = table, table.with_suffix(".json"), table.with_suffix(".png")
    check_writable(*files, sources=[options.packing])
    beads, fluid = bead_material.conductivity(temperature), gas.conductivity(temperature)
    at = temperature, temperature, ["conductivity"]
    for text in beyond_ranges(bead_material, *at) + beyond_ranges(gas, *at):
        print(f"warning: {text}", file=sys.stderr)
    if not (beads > 0.0 and fluid > 0.0):
        allowed = f"is beyond the laws' range: conductivities of {beads:.3g} (beads) and {fluid:.3g} W/m/K (fluid)"
        raise InputError("--temperature", temperature, allowed)
    packing = _settled(options, _optional(options, "bead-diameter", "m"))
    if pressure is not None and modulus is not None:
        solid, contacts = 1.0 - packing.void_fraction(height), packing.bead_coordination_number
        radius = hertz_contact_radius(pressure, modulus, packing.bead_diameter, solid, contacts)
        share = 2.0 * radius / packing.bead_diameter
        if share > LARGEST_CONTACT:
            allowed = f"makes contacts of {share:.3g} bead radii by the law of Hertz, which holds for small ones"
            raise InputError("--pressure", options.pressure, f"{allowed}: at most {LARGEST_CONTACT:g}")
    found = conduction(packing, beads, fluid, contact_radius=0.5 * share * packing.bead_diameter, height=height)
    reference = zehner_bauer_schluender(found.core_porosity, packing.bead_diameter, beads, fluid)
    contacts_text = f"{share:.4f} of the bead radius"
    if share > 0.0 and not packing.bead_coordination_number > 0.0:
        contacts_text = "none, as no beads touch: gaps alone conduct"
    lines = [f"{d:.6g},{k:.6g}" for d, k in zip(found.conductivity_places, found.conductivity, strict=True)]
    with output_file(table) as temporary:
        temporary.write_text("\n".join(["wall_distance [m],conductivity [W/(m*K)]", *lines, ""]), encoding="utf-8")
    summary = {
        "core_conductivity": found.core,
        "overall_conductivity": found.overall,
        "wall_coefficient": found.wall_coefficient,
        "core_porosity": found.core_porosity,
        "bead_conductivity": float(beads),
        "fluid_conductivity": float(fluid),
        "contact_radius": share,
        "zehner_bauer_schluender": float(reference),
    }
    with output_file(files[1]) as temporary:
        temporary.write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
    draw_conduction(files[2], found, float(reference), packing.bead_diameter)
    return (
        f"core: {found.core:.4g} W/m/K at porosity {found.core_porosity:.3f}, {found.core / reference:.2f} of {reference:.4g} "
        "(Zehner, Bauer, Schluender)\n"
        f"contacts: {contacts_text}\n"
        f"from wall to wall: {found.overall:.4g} W/m/K; at a wall {found.wall_coefficient:.4g} W/m2/K\n"
        f"written to {', '.join(map(str, files))}"
    )


def _porosity_text(packing: Packing, profile: "MeasuredProfile", fits: "Fits", bed_height: float | None) -> str:
    from .fitting import model_scores, r_squared

    difference, place = profile.largest_difference
    middle = f"bulk porosity {profile.bulk_porosity:.4f}"
    if not profile.has_bulk:
        middle = f"porosity in the middle {profile.phi_v[-1]:.4f} (narrower than 5.5 beads: there is no bulk)"
    lines = [
        f"{packing.diameters.size} beads, void fraction {packing.void_fraction(bed_height):.4f}, {middle}",
        f"phi_V - phi_A is largest at y/d = {place:.2f}: {difference:+.4f}",
        "R² of phi_V:            bulk 0.4      bulk fitted",
    ]
    for name, score in model_scores(profile.position, profile.phi_v).items():
        lines.append(f"  {name:20s} {score.given:8.3f}      {score.fitted:.3f} ({score.fitted_bulk_porosity:.3f})")
    lines.append(f"  {'piecewise linear':20s} {'':8s}      {r_squared(profile.phi_v, fits[0](profile.position)):.3f}")
    knots = ", ".join(f"({s:.3f}, {value:.4f})" for s, value in zip(fits[0].knots, fits[0].values, strict=True))
    lines.append(f"  its knots (y/d, phi_V): {knots}")
    if (packing.levelled_height if bed_height is None else bed_height) < 16.0 * packing.bead_diameter:
        lines.append("the bed is lower than 16 beads: the standard errors are too small")
    return "\n".join(lines)
