"""A scene: what the user writes in TOML, validated before anything is computed.

`KEYS` is the whole language (`docs/scene.md` lists it); `keys` checks a file by it.
"""

import copy
import hashlib
from pathlib import Path
from types import SimpleNamespace

from .closures.drag import DRAG_LAWS
from .closures.nusselt import NUSSELT_CORRELATIONS
from .errors import InputError
from .keys import Key, checked_names, checked_values, full_names, unknown
from .materials import FLUIDS, SOLIDS
from .porosity.models import POROSITY_MODELS
from .porosity.profile import PorosityProfile
from .series import TimeSeries
from .tables import read_toml


def _length(meaning, default=None):
    return Key("m", meaning, default, low=0.0, high=1e4)


def _choice(meaning, choices, default):
    return Key("choice", meaning, default, choices=tuple(choices))


def _property(kind, meaning):
    return Key(kind, meaning, low=0.0, high=1e7)


def _solid_properties(whose):
    return {
        "density": _property("kg/m^3", f"density of {whose}; overrides the material's"),
        "heat_capacity": _property("J/(kg*K)", f"specific heat capacity of {whose}; overrides the material's"),
        "conductivity": _property("W/(m*K)", f"thermal conductivity of {whose}; overrides the material's"),
    }


KEYS: dict[str, dict[str, Key]] = {
    "geometry": {
        "kind": _choice("what is heated", ("mold", "pipe", "mesh"), None),
        "length": _length("length of the bed along the flow"),
        "cavity_height": _length("full height of a mold's cavity; half of it is computed"),
        "width": _length("full width of a mold's cavity, which makes it three-dimensional; half of it is computed"),
        "sides": _choice("what is beside a cavity of given width: the wall, or more of the cavity", ("wall", "symmetry"),
                         "wall"),
        "diameter": _length("inner diameter of a pipe"),
        "sensors": Key("file", "CSV file `name, x [mm], y [mm]` of places whose temperature is recorded: x along the flow, y "
                               "from the middle"),
        "mesh": Key("file", "gmsh file (.geo, .msh) with named physical groups, for kind 'mesh'"),
        "symmetry": _choice("of a mesh: planar, or about the axis x[1] = 0", ("planar", "axisymmetric"), "planar"),
    },
    "bed": {
        "bead_diameter": _length("diameter of the beads"),
        "bead_material": _choice("material of the beads", SOLIDS, "ceramic"),
        **{f"bead_{name}": key for name, key in _solid_properties("the beads").items()},
        "porosity_model": _choice("porosity against wall distance", POROSITY_MODELS, "hunt-tien"),
        "bulk_porosity": Key("", "porosity far from the wall", 0.4, low=0.0, high=1.0),
        "porosity_profile": Key("file", "CSV profile (wall distance over bead diameter, phi_V, phi_A), in place of a model"),
        "averaging_diameter_ratio": Key("", "largest averaging sphere over bead diameter, D_max/d", 5.5, low=0.0, high=100),
        "allow_small_ratio": Key("flag", "accept a bed narrower than 10 beads, with a warning", False),
    },
    "wall": {
        "material": _choice("material of the wall", SOLIDS, "aluminium"),
        "thickness": _length("thickness of the wall"),
        **_solid_properties("the wall"),
    },
    "fluid": {
        "material": _choice("the fluid", FLUIDS, "air"),
        "density": _property("kg/m^3", "constant density: makes the fluid a liquid"),
        "viscosity": _property("Pa*s", "constant viscosity; overrides the material's"),
        "heat_capacity": _property("J/(kg*K)", "constant heat capacity; overrides the material's"),
        "conductivity": _property("W/(m*K)", "constant thermal conductivity; overrides the material's"),
    },
    "operation": {
        "initial_temperature": Key("K", "of fluid, beads and wall", low=0.0, high=5000.0),
        "inlet_temperature": Key("K", "of the incoming fluid", low=0.0, high=5000.0, series=True),
        "pressure_drop": Key("Pa", "static pressure, inlet minus outlet", low=0.0, high=1e8, closed=True, series=True),
        "inlet_velocity": Key("m/s", "superficial: volume flow over the empty cross-section", low=0.0, high=1e3, series=True),
        "mass_flow": Key("kg/s", "whole pipe; half cavity of a mold per metre width, or a quarter of one that has a width",
                         low=0.0, high=1e6, series=True),
        "outlet_pressure": Key("Pa", "absolute static pressure at the outlet", 101325.0, low=0.0, high=1e9),
        "gravity": Key("m/s^2", "acceleration along the flow (negative: against it)", 0.0, low=-1e3, high=1e3),
        "outer_heat_flux": Key("W/m^2", "heat into the outer wall (negative: loss); a file may have columns `0.1 m [W/m^2]`, ... "
                               "along the flow", low=-1e7, high=1e7, series=True, along=True),
        "outer_heat_flux_factor": Key("", "factor on outer_heat_flux, for the error of its sensors", 1.0, low=0.0, high=10.0),
        "outer_coefficient": Key("W/(m^2*K)", "heat transfer coefficient of the outer wall", low=0.0, high=1e6),
        "ambient_temperature": Key("K", "outside the outer wall", low=0.0, high=5000.0, series=True),
        "wall_temperature": Key("K", "of the bed's wall, for model.wall 'fixed-temperature'", low=0.0, high=5000.0,
                                series=True),
        "heating_margin": Key("delta_degC", "heated when T_in - min T_wall falls below it", 2.0, low=0.0, high=1000.0),
        "end_time": Key("s", "stop here if not heated before", 1e5, low=0.0, high=1e9),
    },
    "model": {
        "flow": _choice("two-dimensional flow, profiles developed at every station, or one uniform mass flux",
                        ("full", "developed", "plug"), "full"),
        "turbulence": _choice(
            "turbulence and bead sources",
            ("none", "k-epsilon", "nakayama-kuwahara", "damped-nakayama-kuwahara"),
            "damped-nakayama-kuwahara",
        ),
        "blend_half_width": Key("", "half-width, in Re_y, of the blend between the wall's layer and k-epsilon around Re_y = 200; "
                                    "published: 20", 120.0, low=1.0, high=200.0, closed=True),
        "longest_eddy": Key("", "largest length k^1.5/epsilon of the turbulence over the bead diameter; published: none, "
                                "which 1e6 is", 1.0, low=0.1, high=1e9, closed=True),
        "energy": _choice("temperatures of fluid and beads, or one for both", ("two-temperature", "one-temperature"),
                          "two-temperature"),
        "wall": _choice("wall: resolved, of one temperature through its thickness, held at operation.wall_temperature, or none",
                        ("conjugate", "thin", "fixed-temperature", "insulated"), "conjugate"),
        "exchange_factor": Key("", "factor on the heat exchange between fluid and beads", 1.0, low=0.0, high=1e6),
        "bead_modes": Key("integer", "modes kept of the temperature inside a bead, the others follow at once; without it beads "
                          "are isothermal", low=0, high=16, closed=True),
        "rev_terms": _choice("terms of the non-constant averaging volume", ("off", "consistent", "as-published"), "off"),
        "flow_update": _choice("how the flow follows the temperature", ("quasi-steady", "frozen", "transient"),
                               "quasi-steady"),
        "nusselt": _choice("heat exchange between fluid and beads", NUSSELT_CORRELATIONS, "wakao"),
        "drag": _choice("resistance of the beads", DRAG_LAWS, "macdonald"),
    },
    "solver": {
        "axial_cells": Key("integer", "cells along the flow; default from the expected width of the front, at least 18", low=2,
                           high=100000, closed=True),
        "first_cell": _length("height of the cell at the wall; default from the expected wall shear"),
        "cell_growth": Key("", "largest ratio of neighbouring cells across the bed; within a bead of the wall its root", 1.33,
                           low=1.001, high=3.0),
        "wall_cells": Key("integer", "cells through the wall; default from its Biot number", low=1, high=1000, closed=True),
        "mesh_refinement": Key("", "factor on the number of cells in each direction, given or by default", 1.0, low=0.1,
                               high=20.0, closed=True),
        "step_refinement": Key("", "factor on the number of time steps", 1.0, low=0.1, high=100.0, closed=True),
        "accuracy": Key("", "wanted relative error of the heating time: chooses both refinements, reports heating_time_error",
                        low=1e-4, high=0.2, closed=True),
        "first_step": Key("s", "first time step", 1.0, low=0.0, high=1e6),
        "step_growth": Key("", "ratio of successive steps", 1.5, low=1.0, high=10.0, closed=True),
        "largest_step": Key("s", "largest time step; default from how fast the front passes and the wall follows it",
                            low=0.0, high=1e7),
        "step_tolerance": Key("delta_degC", "estimated error of a step above which it is repeated smaller", 5.0,
                              low=0.0, high=1e3),
        "flow_tolerance": Key("", "relative change of the flow above which it is iterated within a step", 0.01,
                              low=0.0, high=1.0),
    },
    "output": {
        "pictures": Key("flag", "draw the PNG pictures", True),
        "fields": Key("flag", "write fields.h5 and fields.xdmf", True),
        "checkpoint_interval": Key("s", "wall-clock time after which the state is saved again, for --resume", 30.0, low=0.0,
                                   high=1e7, closed=True),
        "field_times": Key("integer", "number of times at which fields are kept, spread over the run", 4, low=1, high=1000,
                           closed=True),
    },
}  # fmt: skip


class Scene:
    """A validated scene. `scene.wall.thickness` and the like are SI values; series keys hold `TimeSeries`.

    `source` is the file it came from, `profile` the `PorosityProfile` that the bed names; either may be None.
    `file_digests` tell the contents of the files that it names, as they were when it was made.
    """

    profile: PorosityProfile | None
    geometry: SimpleNamespace
    bed: SimpleNamespace
    wall: SimpleNamespace
    fluid: SimpleNamespace
    operation: SimpleNamespace
    model: SimpleNamespace
    solver: SimpleNamespace
    output: SimpleNamespace

    def __init__(self, tables, source=None):
        self.source = str(source) if source else None
        base = Path(source).parent if source else Path()
        if not tables:
            raise InputError(
                "scene", None, "is empty: it needs at least [geometry], [bed] and [operation]", self.source
            )
        self._given = checked_names(tables, KEYS, self.source)
        values = checked_values(tables, KEYS, base, self.source)
        for table, content in values.items():
            setattr(self, table, SimpleNamespace(**content))
        self.file_digests = {
            f"{table}.{name}": hashlib.sha256(value.read_bytes()).hexdigest()
            for table, content in values.items()
            for name, value in content.items()
            if isinstance(value, Path)
        }
        _check_together(self)

    @classmethod
    def load(cls, path, **overrides):
        """Read a TOML file; overrides are written table__key=value, for example wall__thickness='2 mm'."""
        return cls.from_file(path, {name.replace("__", ".", 1): value for name, value in overrides.items()})

    @classmethod
    def from_file(cls, path, settings=None):
        """Read a TOML file and apply settings {'table.key': value} on top."""
        path = Path(path)
        tables = read_toml("scene", path)
        for name, value in (settings or {}).items():
            table, dot, key = name.partition(".")
            if not dot or table not in KEYS:
                raise InputError(name, value, unknown(name, full_names(KEYS)), "--set")
            if not isinstance(tables.setdefault(table, {}), dict):
                raise InputError(table, tables[table], "must be a table", str(path))
            tables[table][key] = value
        return cls(tables, path)

    def with_changes(self, **overrides):
        """A copy with other values, written table__key=value; None takes a value away."""
        tables = copy.deepcopy(self._given)
        for name, value in overrides.items():
            table, _, key = name.partition("__")
            tables.setdefault(table, {})[key] = value
            if value is None:
                del tables[table][key]
        return Scene(tables, self.source)

    def as_tables(self):
        """Every key with its value, defaults included, ready for TOML; keys without a value are left out."""
        tables = {}
        for table, keys in KEYS.items():
            content = {}
            for name in keys:
                if f"{table}.{name}" in _FOREIGN[self.geometry.kind]:
                    continue
                value = getattr(getattr(self, table), name)
                if isinstance(value, TimeSeries):
                    value = value.source or value.values[0]
                if value is not None:
                    content[name] = str(value) if isinstance(value, Path) else value
            tables[table] = content
        return tables


_NEEDED = {"mold": ("length", "cavity_height"), "pipe": ("length", "diameter"), "mesh": ("mesh",)}
_FOREIGN = {
    "mold": ("geometry.diameter", "geometry.mesh", "geometry.symmetry"),
    "pipe": ("geometry.cavity_height", "geometry.width", "geometry.sides", "geometry.mesh", "geometry.symmetry"),
    "mesh": ("geometry.length", "geometry.cavity_height", "geometry.width", "geometry.sides", "geometry.diameter",
             "solver.axial_cells", "solver.first_cell", "solver.cell_growth", "solver.wall_cells",
             "solver.mesh_refinement", "solver.accuracy"),
}  # fmt: skip
_DRIVES = ("pressure_drop", "inlet_velocity", "mass_flow")
SMALLEST_RATIO = 10.0


def _check_together(scene):
    geometry, bed, operation, where = scene.geometry, scene.bed, scene.operation, scene.source

    def need(table, name):
        if getattr(getattr(scene, table), name) is None:
            raise InputError(f"{table}.{name}", None, f"is missing; {KEYS[table][name].meaning}", where)

    need("geometry", "kind")
    for name in _NEEDED[geometry.kind]:
        need("geometry", name)
    for full_name in _FOREIGN[geometry.kind]:
        table, name = full_name.split(".")
        if name in scene._given.get(table, {}):
            raise InputError(
                full_name, getattr(getattr(scene, table), name), f"has no place in a {geometry.kind}", where
            )
    need("bed", "bead_diameter")
    if geometry.width is None and geometry.sides != "wall":
        raise InputError("geometry.sides", geometry.sides, "has no meaning without geometry.width", where)
    if geometry.width is not None and scene.model.flow != "full":
        raise InputError("model.flow", scene.model.flow, "must be 'full' with geometry.width", where)
    if geometry.kind == "mesh" and scene.model.flow != "full":
        raise InputError("model.flow", scene.model.flow, "must be 'full' for a mesh: its stations are not known", where)
    if geometry.kind == "mesh" and scene.model.wall != "conjugate":
        raise InputError(
            "model.wall", scene.model.wall, "must be 'conjugate' for a mesh, which has its own wall", where
        )
    if geometry.kind != "mesh":
        if scene.model.wall in ("conjugate", "thin"):
            need("wall", "thickness")
    elif scene.wall.thickness is not None:
        raise InputError(
            "wall.thickness", scene.wall.thickness, "has no place in a mesh, which has its own wall", where
        )
    need("operation", "initial_temperature")
    need("operation", "inlet_temperature")
    drives = [name for name in _DRIVES if getattr(operation, name) is not None]
    if len(drives) != 1:
        names = ", ".join(f"operation.{name}" for name in _DRIVES)
        raise InputError(" and ".join(f"operation.{n}" for n in drives) or "operation.pressure_drop", None,
                         f"exactly one of {names} must be given", where)  # fmt: skip
    if scene.model.flow_update == "frozen" and getattr(operation, drives[0]).kinks:
        raise InputError(
            "model.flow_update", "frozen", f"must be 'quasi-steady' with a time series as operation.{drives[0]}", where
        )
    if scene.model.flow_update == "transient" and scene.model.flow != "full":
        raise InputError("model.flow_update", "transient", "must go with model.flow 'full'", where)
    if scene.model.bead_modes is not None:
        for name, value in (("energy", "one-temperature"), ("flow_update", "transient")):
            if getattr(scene.model, name) == value:
                raise InputError(
                    "model.bead_modes", scene.model.bead_modes, f"has no place beside model.{name} {value!r}", where
                )
    if scene.solver.accuracy is not None:
        for name in ("mesh_refinement", "step_refinement"):
            if scene._given.get("solver", {}).get(name) is not None:
                raise InputError(f"solver.{name}", getattr(scene.solver, name), "is chosen by solver.accuracy", where)
    limit = POROSITY_MODELS[bed.porosity_model].largest_bulk_porosity
    if bed.porosity_profile is None and bed.bulk_porosity > limit:
        raise InputError("bed.bulk_porosity", bed.bulk_porosity,
                         f"must be <= {limit:g} with porosity_model {bed.porosity_model!r}", where)  # fmt: skip
    for name in ("cavity_height", "width", "diameter"):
        width = getattr(geometry, name)
        if width is None or (name == "width" and geometry.sides == "symmetry"):
            continue
        if width < SMALLEST_RATIO * bed.bead_diameter * (1 - 1e-9) and not bed.allow_small_ratio:
            raise InputError(f"geometry.{name}", width,
                             f"must be at least {SMALLEST_RATIO:g} bead diameters ({SMALLEST_RATIO * bed.bead_diameter:g} m)"
                             ", or set bed.allow_small_ratio = true", where)  # fmt: skip
        if bed.bead_diameter >= width:
            raise InputError("bed.bead_diameter", bed.bead_diameter, f"must be smaller than geometry.{name}", where)
        if scene.solver.first_cell is not None and scene.solver.first_cell >= width / 2:
            raise InputError(
                "solver.first_cell", scene.solver.first_cell, f"must be < {width / 2:g} m, half the bed", where
            )
    scene.profile = None
    if bed.porosity_profile is not None:
        scene.profile = PorosityProfile.read("bed.porosity_profile", bed.porosity_profile)
    elif scene.model.rev_terms != "off":
        raise InputError("model.rev_terms", scene.model.rev_terms,
                         "needs bed.porosity_profile: the porosity models give no phi_A", where)  # fmt: skip
    difference = max(abs(value - operation.initial_temperature) for value in operation.inlet_temperature.values)
    if operation.heating_margin >= difference:
        raise InputError("operation.heating_margin", operation.heating_margin,
                         f"must be < {difference:g} K, the difference of inlet and initial temperature", where)  # fmt: skip
    if (scene.model.wall == "fixed-temperature") != (operation.wall_temperature is not None):
        raise InputError("operation.wall_temperature", None,
                         "must be given with model.wall 'fixed-temperature', and only then", where)  # fmt: skip
    if (
        scene.model.wall in ("insulated", "fixed-temperature")
        and (operation.outer_heat_flux or operation.outer_coefficient) is not None
    ):
        raise InputError(
            "model.wall", scene.model.wall, "has no place beside operation.outer_heat_flux or outer_coefficient", where
        )
    if operation.outer_heat_flux is None and operation.outer_heat_flux_factor != 1.0:
        raise InputError("operation.outer_heat_flux_factor", operation.outer_heat_flux_factor,
                         "has no meaning without operation.outer_heat_flux", where)  # fmt: skip
    if (operation.outer_coefficient is None) != (operation.ambient_temperature is None):
        raise InputError("operation.outer_coefficient", operation.outer_coefficient,
                         "and operation.ambient_temperature must be given together", where)  # fmt: skip
    if operation.pressure_drop is not None and operation.pressure_drop.range[1] > 10.0 * operation.outlet_pressure:
        raise InputError("operation.pressure_drop", operation.pressure_drop.range[1],
                         f"must be <= 10 x operation.outlet_pressure ({10 * operation.outlet_pressure:g} Pa)", where)  # fmt: skip
    given_fluid = scene._given.get("fluid", {})
    if "density" in given_fluid:
        for name in ("viscosity", "heat_capacity", "conductivity"):
            if name not in given_fluid:
                raise InputError(f"fluid.{name}", None, "is missing: a liquid needs all four properties", where)


def reference():
    """Markdown page of every key: unit or kind, default, bounds or choices, meaning."""
    lines = [
        "# Keys of a scene",
        "",
        'Written by `porousmold keys`. Numbers are SI, or texts with a unit (`"5 mm"`, `"90 degC"`, `"8 kPa"`). Keys marked',
        "with * also take a CSV file `time [s], name [unit]`. Paths are relative to the scene's file.",
    ]
    for table, keys in KEYS.items():
        lines += ["", f"## [{table}]", "", "| key | kind | default | allowed | meaning |", "|---|---|---|---|---|"]
        for name, key in keys.items():
            kind = {"delta_degC": "K", "": "number"}.get(key.kind, key.kind)
            allowed = ", ".join(f"`{choice}`" for choice in key.choices)
            if not allowed and key.kind not in ("flag", "file", "choice"):
                allowed = key.allowed().removeprefix("must be ").removesuffix(f" {kind}")
            default = (
                "" if key.default is None else f"`{str(key.default).lower() if key.kind == 'flag' else key.default}`"
            )
            lines.append(f"| {name}{'*' if key.series else ''} | {kind} | {default} | {allowed} | {key.meaning} |")
    return "\n".join(lines) + "\n"
