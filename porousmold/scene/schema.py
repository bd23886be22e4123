"""The schema of a scene: every key with its type, default, bounds and meaning (`docs/scene.md` lists it)."""

from collections.abc import Collection, Mapping
from dataclasses import replace

from ..errors import InputError
from ..laws import stirring
from ..laws.conductivity import BEAD_CONDUCTION_LAWS, DISPERSION_LAWS
from ..laws.drag import DRAG_LAWS
from ..laws.material_library import FLUIDS, SOLIDS
from ..laws.nusselt import NUSSELT_CORRELATIONS
from ..laws.porosity import POROSITY_MODELS
from ..laws.turbulence_models import TURBULENCE_MODELS
from .closures import CLOSURES, THESIS
from .keys import WITHOUT_UNIT, Key
from .tolerances import TOLERANCES

_THESIS = CLOSURES[THESIS]


def _length(meaning: str, default: float | None = None) -> Key:
    return Key("m", meaning, default, low=0.0, high=1e4)


def _choice(meaning: str, choices: Collection[str], default: str | None) -> Key:
    return Key("choice", meaning, default, choices=choices)


def _property(kind: str, meaning: str) -> Key:
    return Key(kind, meaning, low=0.0, high=1e7)


def _solid_properties(whose: str) -> dict[str, Key]:
    return {
        "density": _property("kg/m^3", f"density of {whose}; overrides the material's"),
        "heat_capacity": _property("J/(kg*K)", f"specific heat capacity of {whose}; overrides the material's"),
        "conductivity": _property("W/(m*K)", f"thermal conductivity of {whose}; overrides the material's"),
    }


_DRIVES = {
    "pressure_drop": Key("Pa", "static pressure, inlet minus outlet; negative in a series or phase: the flow reverses", low=-1e8,
                         high=1e8, closed=True, series=True),
    "inlet_velocity": Key("m/s", "superficial: volume flow over the empty cross-section; negative in a series or phase: the flow "
                          "reverses", low=-1e3, high=1e3, series=True),
    "mass_flow": Key("kg/s", "mass flow: whole pipe; half cavity (or whole, geometry.cavity) per metre of width; quarter of a "
                     "cavity with a width; negative in a series or phase: the flow reverses", low=-1e6, high=1e6, series=True),
}  # fmt: skip

_LAYER = {
    "name": Key("text", "name in results and targets, and of the physical group in a mesh; default: its material"),
    "material": _choice("material of the layer", SOLIDS, None),
    "thickness": _length("thickness of the layer"),
    "contact_resistance": Key(
        "m^2*K/W", "between this layer and the next one outwards", 0.0, low=0.0, high=100.0, closed=True
    ),
    "heat_source": Key("W/m^3", "volumetric heat source in the layer", low=-1e9, high=1e9, series=True),
    "cells": Key("integer", "cells through the layer; default from its Biot number", low=1, high=1000, closed=True),
}

KEYS: dict[str, dict[str, Key]] = {
    "geometry": {
        "kind": _choice("what is heated", ("mold", "pipe", "mesh"), None),
        "length": _length("length of the bed along the flow"),
        "cavity_height": _length("full height of a mold's cavity; half of it is modelled"),
        "cavity": _choice("how much of a mold's cavity is modelled: half, between equal walls, or the whole, whose other wall "
                          "has [[wall.opposite_layer]]", ("half", "whole"), "half"),
        "width": _length("full width of a mold's cavity, for a three-dimensional model; half of it is modelled"),
        "sides": _choice("lateral boundary of a cavity with a width: wall, or plane of symmetry", ("wall", "symmetry"),
                         "wall"),
        "diameter": _length("inner diameter of a pipe"),
        "sensors": Key("file", "CSV file `name, x [mm], y [mm]` of points where the temperature is recorded: x along the flow, y "
                               "from the middle; `0:300:11` for a coordinate gives 11 sensors on a line"),
        "mesh": Key("file", "gmsh file (.geo, .msh) with named physical groups, for kind 'mesh'; a .geo that runs commands "
                           "or opens other files than CAD drawings only with --allow-extensions"),
        "symmetry": _choice("symmetry of a mesh: planar (2D), axisymmetric about x[1] = 0, or none (3D)",
                            ("planar", "axisymmetric", "none"), "planar"),
        "refine_wall": Key("flag", "insert graded cells at the wall of a mesh that is too coarse there", False),
        "scale": Key("", "factor on the coordinates of a mesh, to m: 0.001 for one in mm", 1.0, low=1e-9, high=1e9, closed=True),
        "groups": Key("names", "physical groups of a mesh that have other names, such as { wall = \"skin\", inlet = \"7\" }: a "
                               "group without a name has its number, several count as one by ' + '"),
        "join_nodes": Key("flag", "join the nodes of a mesh that lie at one place, where bed and wall were meshed apart", False),
        "parts": Key("integer", "number of such parts in the whole tool (symmetry 'none'), for blower and heater", 1, low=1,
                     high=1000, closed=True),
    },
    "bed": {
        "bead_diameter": _length("diameter of the beads"),
        "bead_material": _choice("material of the beads", SOLIDS, "ceramic"),
        **{f"bead_{name}": key for name, key in _solid_properties("the beads").items()},
        "contact_flattening": Key("", "flattened fraction of a bead's cross-section, for model.bead_conduction "
                                      "'zehner-bauer-schluender'; overrides the material's", low=0.0, high=0.5, closed=True),
        "emissivity": Key("", "emissivity of the beads, for radiation between them in the same law; 0: none", 0.0, low=0.0,
                          high=1.0, closed=True),
        "porosity_model": _choice("porosity against wall distance", POROSITY_MODELS, _THESIS["bed.porosity_model"]),
        "bulk_porosity": Key("", "porosity far from the wall", _THESIS["bed.bulk_porosity"], low=0.0, high=1.0),
        "porosity_profile": Key("file", "CSV profile (wall distance over bead diameter, phi_V, phi_A), in place of a model"),
        "conductivity_profile": Key("file", "CSV profile (wall distance, stagnant conductivity of bed and fluid), as written by "
                                            "`porousmold conductivity`, in place of model.bead_conduction"),
        "shear_rate": Key("1/s", "shear rate of a stirred bed; adds conduction across the flow", 0.0, low=0.0, closed=True),
        "stirring_coefficient": Key("", "c of the stirring conductivity c (1 - phi) rho_s C_s d^2 x shear rate",
                                    stirring.COEFFICIENT, low=0.0, high=1.0),
        "averaging_diameter_ratio": Key("", "largest averaging sphere over bead diameter, D_max/d", 5.5, low=0.0, high=100),
        "allow_small_ratio": Key("flag", "accept a bed narrower than 10 beads, with a warning", False),
    },
    "wall": {
        "material": _choice("material of the wall", SOLIDS, "aluminium"),
        "thickness": _length("thickness of the wall"),
        **_solid_properties("the wall"),
        "layer": Key("list", "layers of the wall from the bed outwards, in place of its material and thickness", entries=_LAYER),
        "opposite_layer": Key("list", "layers of the wall opposite, from the bed outwards, with geometry.cavity 'whole'",
                              entries=_LAYER),
    },
    "fluid": {
        "material": _choice("material of the fluid", FLUIDS, _THESIS["fluid.material"]),
        "real_gas": Key("flag", "properties of the real gas about operation.outlet_pressure, 1 to 50 bar, in place of the ideal "
                                "gas and properties at 1 bar", False),
        "density": _property("kg/m^3", "constant density: makes the fluid a liquid"),
        "viscosity": _property("Pa*s", "constant viscosity; overrides the material's"),
        "heat_capacity": _property("J/(kg*K)", "constant heat capacity; overrides the material's"),
        "conductivity": _property("W/(m*K)", "constant thermal conductivity; overrides the material's"),
    },
    "operation": {
        "initial_temperature": Key("K", "of fluid, beads and wall; or a CSV file `x [m], temperature [degC]` of a profile along "
                                   "the flow", low=0.0, high=5000.0, profile=True),
        "initial_state": Key("run", "folder of a run whose last temperatures are those at the start, in place of "
                             "initial_temperature"),
        "inlet_temperature": Key("K", "inlet temperature of the fluid; with a heater, its set-point", low=0.0, high=5000.0,
                                 series=True),
        "programme": Key("list", "stages of the inlet temperature set-point, instead of inlet_temperature", entries={
            "to": Key("K", "temperature at the end of the ramp", low=0.0, high=5000.0),
            "rate": Key("K/s", "heating or cooling rate of the ramp, positive", low=0.0, high=1e4),
            "over": Key("s", "time that it takes, in place of a rate", low=0.0, high=1e9),
            "hold": Key("s", "duration of the hold after the ramp", low=0.0, high=1e9),
        }),
        **_DRIVES,
        "return_temperature": Key("K", "of the fluid that enters at the outlet, where the drive of the flow gets negative",
                                  low=0.0, high=5000.0, series=True),
        "reversal_period": Key("s", "the flow comes from both ends in turn, so long from each, with the same drive and "
                               "temperature", low=0.0, high=1e9),
        "phase": Key("list", "phases of a run (charge, rest, discharge), one after the other, instead of a drive and "
                     "inlet_temperature", entries={
            "name": Key("text", "name of the phase in results"),
            **{name: replace(key, series=False) for name, key in _DRIVES.items()},
            "temperature": Key("K", "of the fluid that enters, from whichever end", low=0.0, high=5000.0),
            "duration": Key("s", "after which the phase ends", low=0.0, high=1e9),
            "until_outlet_above": Key("K", "the phase ends when the fluid that leaves is as warm", low=0.0, high=5000.0),
            "until_outlet_below": Key("K", "the phase ends when the fluid that leaves is as cold", low=0.0, high=5000.0),
        }),
        "cycles": Key("integer", "times that the phases are gone through, at most", 1, low=1, high=10000, closed=True),
        "cycle_tolerance": Key("", "relative change of the heat of every phase from one cycle to the next below which the state "
                               "is periodic and the run ends", low=0.0, high=1.0),
        "blower": Key("file", "CSV curve `volume_flow [m^3/h], pressure_rise [Pa]` of the whole tool's blower"),
        "blower_pressure": Key("Pa", "pressure rise at zero flow of a blower with a parabolic curve", low=0.0,
                               high=1e7),
        "blower_flow": Key("m^3/s", "volume flow at zero pressure rise of that blower", low=0.0, high=1e4),
        "blower_density": Key("kg/m^3", "density at which the blower's curve holds; default: the fluid at fresh_temperature",
                              low=0.0, high=1e4),
        "blower_efficiency": Key("", "of motor and fan; all power dissipated in the air", 0.6, low=0.01, high=1.0, closed=True),
        "duct_resistance": Key("Pa*s^2/m^6", "pressure loss of ducts and filters over the volume flow squared, at blower_density",
                               0.0, low=0.0, high=1e12, closed=True),
        "heater_power": Key("W", "maximum power of the heater of the whole tool", low=0.0, high=1e9),
        "recirculation": Key("", "fraction of the outlet flow that is recirculated to the blower", low=0.0, high=1.0, closed=True,
                             series=True),
        "duct_conductance": Key("W/K", "heat lost by the return duct per kelvin above fresh_temperature", low=0.0, high=1e6,
                                closed=True),
        "fresh_temperature": Key("K", "temperature of fresh air and around the duct; default initial_temperature", low=0.0,
                                 high=5000.0),
        "mold_width": _length("mold width supplied by blower and heater, if geometry.width is not set; default 1 m"),
        "energy_price": Key("", "price of a kWh for heater and blower", low=0.0, high=1e6),
        "currency": Key("line", "of the price, for summary and report"),
        "bead_velocity": Key("m/s", "of beads that move as a plug: positive along the flow, negative against it", 0.0, low=-10.0,
                             high=10.0),
        "bead_inlet_temperature": Key("K", "of the entering beads, for bead_velocity", low=0.0, high=5e3, series=True),
        "outlet_pressure": Key("Pa", "absolute static pressure at the outlet", 101325.0, low=0.0, high=1e9),
        "gravity": Key("m/s^2", "acceleration along the flow (negative: against it)", 0.0, low=-1e3, high=1e3),
        "outer_heat_flux": Key("W/m^2", "heat flux into the outer wall (negative: loss; not set: adiabatic); a file may have "
                               "columns `0.1 m [W/m^2]`, ... from the inlet along the flow",
                               low=-1e7, high=1e7, series=True, along=True),
        "outer_heat_flux_factor": Key("", "factor on outer_heat_flux, for the error of its sensors", 1.0, low=0.0, high=10.0),
        "outer_coefficient": Key("W/(m^2*K)", "heat transfer coefficient of the outer wall (not set: adiabatic)",
                                 low=0.0, high=1e6),
        "outer_emissivity": Key("", "emissivity of the outer wall, which radiates to ambient_temperature", low=0.0, high=1.0,
                                closed=True),
        "ambient_temperature": Key("K", "outside the outer wall", low=0.0, high=5000.0, series=True),
        "wall_temperature": Key("K", "of the bed's wall, for model.wall 'fixed-temperature'", low=0.0, high=5000.0,
                                series=True),
        "heated_place": Key("text", "what the heating time is of: wall (all of it), bed_side, bed, or the name of a layer",
                            "wall"),
        "heating_margin": Key("delta_degC", "that place is heated when all of it is within this of T_in", 2.0, low=0.0,
                              high=1000.0),
        "end_time": Key("s", "maximum simulated time, if the wall is not heated before; if not set, a steady state, too, ends "
                        "the run", 1e5, low=0.0, high=1e9),
    },
    "model": {
        "flow": _choice("flow model: full (2D or 3D), locally developed profiles, or plug flow",
                        ("full", "developed", "plug"), "full"),
        "turbulence": _choice("turbulence model, bead sources included", TURBULENCE_MODELS, _THESIS["model.turbulence"]),
        "blend_half_width": Key("", "half-width, in Re_y, of the blending of the near-wall layer and k-epsilon at Re_y = 200; "
                                    "published: 20", 120.0, low=1.0, high=200.0, closed=True),
        "longest_eddy": Key("", "upper limit of the turbulence length k^1.5/epsilon over the bead diameter; published: none "
                                "(same as 1e6)", 1.0, low=0.1, high=1e9, closed=True),
        "energy": _choice("separate temperatures of fluid and beads, or one temperature", ("two-temperature", "one-temperature"),
                          "two-temperature"),
        "wall": _choice("wall model: resolved conduction, lumped in thickness, fixed at operation.wall_temperature, or adiabatic",
                        ("conjugate", "thin", "fixed-temperature", "insulated"), "conjugate"),
        "exchange_factor": Key("", "factor on the heat exchange between fluid and beads", 1.0, low=0.0, high=1e6),
        "drag_factor": Key("", "factor on the drag of the beads, for its experimental scatter", 1.0, low=0.0,
                           high=1e3),
        "conduction_factor": Key("", "factor on bead conduction and thermal dispersion, for their scatter", 1.0,
                                 low=0.0, high=1e3),
        "bead_modes": Key("integer", "transient modes of the temperature inside a bead, others quasi-steady; not set: beads "
                          "are isothermal", low=0, high=16, closed=True),
        "rev_terms": _choice("terms of the non-constant averaging volume", ("off", "consistent", "as-published"), "off"),
        "flow_update": _choice("update of the flow as temperatures change", ("quasi-steady", "frozen", "transient"),
                               "quasi-steady"),
        "nusselt": _choice("Nusselt correlation between fluid and beads", NUSSELT_CORRELATIONS, "wakao"),
        "closures": _choice("set of closures, the thesis's or those supported by measurements: default of bead_conduction, "
                            "dispersion, drag, turbulence, bed.porosity_model and bed.bulk_porosity if these are not "
                            "set", CLOSURES,
                            THESIS),
        "bead_conduction": _choice("bead conduction: parallel to the fluid, or from the stagnant conductivity of the bed",
                                   BEAD_CONDUCTION_LAWS, _THESIS["model.bead_conduction"]),
        "dispersion": _choice("thermal dispersion; with turbulence, the larger of dispersion and eddy conductivity",
                              DISPERSION_LAWS, _THESIS["model.dispersion"]),
        "drag": _choice("drag law of the bed", DRAG_LAWS, _THESIS["model.drag"]),
    },
    "solver": {
        "axial_cells": Key("integer", "cells along the flow; default from the expected width of the front, at least 18", low=2,
                           high=100000, closed=True),
        "first_cell": _length("height of the cell at the wall; default from the expected wall shear"),
        "cell_growth": Key("", "largest growth ratio of cells across the bed; its root within a bead diameter of the wall", 1.33,
                           low=1.001, high=3.0),
        "wall_cells": Key("integer", "cells through the wall; default from its Biot number", low=1, high=1000, closed=True),
        "mesh_refinement": Key("", "factor on the number of cells in each direction, given or by default", 1.0, low=0.1,
                               high=20.0, closed=True),
        "axial_refinement": Key("", "another factor on the number of cells along the flow alone", 1.0, low=0.01, high=20.0,
                                closed=True),
        "step_refinement": Key("", "factor on the number of time steps", 1.0, low=0.1, high=100.0, closed=True),
        "accuracy": Key("", "wanted relative error of heating time, targets and peaks of cure, without a time of temperatures at "
                        "the end: chooses all refinements, reports heating_time_error, target_errors, peak_errors, end_errors",
                        low=1e-4, high=0.2, closed=True),
        "first_step": Key("s", "first time step; default, and at most, a twentieth of the largest", low=0.0, high=1e6),
        "step_growth": Key("", "ratio of successive steps", 1.5, low=1.0, high=10.0, closed=True),
        "largest_step": Key("s", "largest time step; default from the front's passage time and the wall's time constant",
                            low=0.0, high=1e7),
        "step_tolerance": Key("delta_degC", "largest estimated error of a time step (root mean square over bed or layer), "
                              "besides 0.8 % of the temperature differences there are", low=0.0, high=1e3),
        "keep_bounds": Key("flag", "keep temperatures within those given: first order in the cells of a sharp front; else they "
                           "may pass them by a few kelvin there", True),
        "flow_tolerance": Key("", "convergence tolerance of the flow in a time step (relative update); over step_refinement, "
                              "to 0.05 at most where that is below 1", 0.01, low=0.0, high=1.0),
    },
    "target": {
        "list": Key("list", "targets of the run, [[target]]; it continues until all are met, or to operation.end_time", entries={
            "name": Key("text", "name of the target in results"),
            "place": Key("text", "wall, bed_side, bed, or the name of a layer or a sensor", "wall"),
            "within": Key("delta_degC", "largest difference from the set-point farthest from the start",
                          low=0.0, high=1000.0),
            "above": Key("K", "all of the place above this temperature", low=0.0, high=5000.0),
            "below": Key("K", "all of the place below this temperature", low=0.0, high=5000.0),
            "spread": Key("delta_degC", "largest temperature difference within the place, from half-way on",
                          low=0.0, high=1000.0),
            "keep": Key("flag", "it is met only as long as it holds: the run goes on until all such targets hold at once", False),
            "cured": Key("", "least degree of cure of a layer", low=0.0, high=1.0),
        }),
    },
    "tolerance": TOLERANCES,
    "extensions": {
        "python": Key("file", "Python file that registers user-defined laws; run only with --allow-extensions"),
    },
    "output": {
        "title": Key("line", "title of the report, by default the geometry and the folder's name"),
        "pictures": Key("flag", "draw the PNG pictures", True),
        "fields": Key("flag", "write fields.h5 and fields.xdmf", True),
        "checkpoint_interval": Key("s", "minimum wall-clock time between checkpoints, for --resume", 30.0, low=0.0,
                                   high=1e7, closed=True),
        "field_times": Key("integer", "number of snapshots of the fields, evenly spread over the run as it turns out", 4, low=1,
                           high=1000, closed=True),
        "times": Key("times", "times of the fields, in place of field_times, and of profiles along the bed (profiles.csv); steps "
                     "end there"),
        "every": Key("s", "the same every so often", low=0.0, high=1e9),
    },
}  # fmt: skip


def reference(only: str | None = None) -> str:
    """Markdown page of every key, or of those of one table: unit or kind, default, bounds or choices, meaning.

    Raises `InputError` for a table that is none.
    """
    if only is not None and only not in KEYS:
        raise InputError("TABLE", only, f"must be one of {', '.join(KEYS)}")
    lines = [
        "# Keys of a scene",
        "",
        'Written by `porousmold keys`. Numbers are SI, or texts with a unit (`"5 mm"`, `"90 degC"`, `"8 kPa"`). Keys marked',
        "with * also take a CSV file `time [s], name [unit]`. Paths are relative to the scene's file. Materials of your own:",
        "[materials.md](materials.md).",
    ]
    for table, keys in KEYS.items():
        if only not in (None, table):
            continue
        lists = {name: key for name, key in keys.items() if key.kind == "list"}
        if len(lists) < len(keys):
            lines += _section(f"[{table}]", {name: key for name, key in keys.items() if name not in lists})
        for name, key in lists.items():
            full_name = f"{table}.{name}".removesuffix(".list")
            lines += _section(f"[[{full_name}]]", key.entries, key.meaning)
    return "\n".join(lines) + "\n"


def _section(title: str, keys: Mapping[str, Key], meaning: str = "") -> list[str]:
    lines = ["", f"## {title}", *(["", f"{meaning[0].upper()}{meaning[1:]}."] if meaning else [])]
    lines += ["", "| key | kind | default | allowed | meaning |", "|---|---|---|---|---|"]
    for name, key in keys.items():
        kind = {"delta_degC": "K", "": "number", "tolerance": f"% or {key.tolerated or 'number'}"}.get(
            key.kind, key.kind
        )
        allowed = ", ".join(f"`{choice}`" for choice in key.choices)
        if not allowed and (key.kind == "integer" or key.kind not in WITHOUT_UNIT):
            allowed = key.allowed().removeprefix("must be ").removesuffix(f" {kind}")
        shown = str(key.default).lower() if key.kind == "flag" else key.default
        default = "" if key.default is None else f"`{shown}`"
        lines.append(f"| {name}{'*' if key.series else ''} | {kind} | {default} | {allowed} | {key.meaning} |")
    return lines
