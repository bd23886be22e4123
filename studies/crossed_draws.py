"""Scenes that cross every feature, drawn from a Latin hypercube with a fixed seed (`studies.crossed_scenes` runs them)."""

import functools
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from porousmold import Scene
from porousmold.simulation.estimates import estimate
from porousmold.simulation.specs import specs_of
from studies.hypercube import draws

CURVED = Path(__file__).parent.parent / "meshes" / "curved_mold.geo"
SEED, COUNT = 33, 300
NARROW_CELLS = 0.4
"""Refinement of the cells in three dimensions, where twice finer ones would take hours."""
HARDLY_ANY = 0.1
"""Part of the scenes that differ by 0.2 K only."""
HOTTEST_CURE = 470.0
"""Temperature (K) up to which resins are cured."""
STEEL = {"density": 7850.0, "heat_capacity": 480.0, "conductivity": 45.0}
RESIN = {
    "density": 1850.0,
    "heat_capacity": 1100.0,
    "conductivity": 0.35,
    "source": "of the study",
    "cure": {
        **{"rate_1": 1e3, "activation_energy_1": 6e4, "rate_2": 1.5e5, "activation_energy_2": 6.65e4},
        **{"order_m": 0.81, "order_n": 2.0, "heat": 150e3, "initial": 0.01},
    },
}
FLUIDS = {  # lowest and highest temperature (K) that is drawn, and pressures (Pa) over a metre
    **dict.fromkeys(("air", "air ", "nitrogen", "argon", "carbon_dioxide"), (295.0, 595.0, 500.0, 4e4)),
    "helium": (300.0, 790.0, 5e2, 4e4),
    "steam": (420.0, 700.0, 5e2, 3e4),
    "water": (290.0, 365.0, 50.0, 5e3),
    "water_glycol": (280.0, 365.0, 100.0, 1e4),
    "thermal_oil": (300.0, 560.0, 500.0, 3e4),
}
CHOICES: dict[str, tuple[Any, ...]] = {
    "kind": (*("mold", "pipe") * 8, "mesh", "mesh", "mesh", "narrow"),
    "flow": ("full", "developed", "developed", "plug", "plug"),
    "turbulence": ("none", "k-epsilon", "nakayama-kuwahara", "damped-nakayama-kuwahara", "decaying-nakayama-kuwahara"),
    "closures": ("thesis", "measured", "each"),
    "drag": ("macdonald", "ergun", "carman", "kta", "erdim", "eisfeld-schnitzlein"),
    "nusselt": ("wakao", "whitaker", "achenbach", "gupta-thodos", "henry"),
    "bead_conduction": ("bulk", "zehner-bauer-schluender"),
    "dispersion": ("none", "winterberg-tsotsas", "winterberg-tsotsas-axial"),
    "porosity_model": ("hunt-tien", "white-tien", "cheng-hsu", "vortmeyer-schuster", "constant"),
    "energy": ("two-temperature", "two-temperature", "one-temperature"),
    "bead_modes": (None, None, None, 0, 2),
    "bead_material": ("ceramic", "glass", "steel", "acrylic", "aluminium"),
    "fluid": tuple(FLUIDS),
    "drive": ("pressure_drop", "pressure_drop", "mass_flow", "inlet_velocity", "blower", "blower", "none"),
    "heater": (False, True),
    "programme": ("constant", "constant", "ramp", "steps", "noise", "off and on"),
    "gravity": (0.0, 0.0, 9.81, -9.81),
    "wall": ("plain", "plain", "layers", "insulation", "contact", "source", "cure", "thin", "fixed", "none"),
    "material": ("aluminium", "acrylic", "frp", "steel"),
    "outer": ("adiabatic", "adiabatic", "losses", "oven", "flux"),
    "beads": ("rest", "rest", "rest", "rest", "with", "against"),
}
RANGES = {  # (low, high, logarithmic)
    "bead_diameter": (1e-3, 10e-3, True),
    "beads_across": (10.0, 30.0, False),
    "length": (0.2, 2.5, True),
    "thickness": (0.5e-3, 15e-3, True),
    "porosity": (0.35, 0.46, False),
    "pressure": (0.0, 1.0, False),
    "start": (0.0, 1.0, False),
    "end": (0.0, 1.0, False),
    "difference": (0.0, 1.0, False),
}


def scenes(count: int = COUNT, seed: int = SEED) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
    """What was drawn, and the tables of the scene, of `count` scenes."""
    for number, drawn in enumerate(draws(RANGES, CHOICES, count, seed)):
        yield (compatible := _compatible(drawn)), _tables(number, **compatible)


def _compatible(drawn: Mapping[str, Any]) -> dict[str, Any]:
    """What was drawn, with choices that exclude each other settled."""
    d = dict(drawn)
    if d["kind"] in ("mesh", "narrow"):
        d |= {"flow": "full", "beads": "rest"}
    if d["kind"] == "mesh" and d["wall"] not in ("plain", "cure"):
        d["wall"] = "plain"
    if d["beads"] != "rest":
        d |= {"energy": "two-temperature", "bead_modes": None}
    if d["energy"] == "one-temperature":
        d["bead_modes"] = None
    if d["wall"] in ("fixed", "none"):
        d["outer"] = "adiabatic"
    if d["drive"] == "none" and d["outer"] == "adiabatic" and d["wall"] not in ("fixed", "source", "cure"):
        d["drive"] = "pressure_drop"
    if d["drive"] == "none":
        d |= {"gravity": 0.0, "heater": False, "programme": "constant", "turbulence": "none"}
        d["flow"] = "full" if d["kind"] in ("mesh", "narrow") else "developed"
    if d["fluid"] in ("water", "water_glycol", "thermal_oil"):
        d |= {"turbulence": "none", "heater": False, "gravity": 0.0}
        d["drive"] = "pressure_drop" if d["drive"] == "blower" else d["drive"]
    if d["programme"] == "off and on" and d["drive"] != "pressure_drop":
        d["programme"] = "constant"
    if d["flow"] == "plug":
        d["turbulence"] = "none"
    if d["wall"] == "cure" and d["difference"] < HARDLY_ANY:  # what cures is far hotter than what flows in
        d["difference"] = HARDLY_ANY
    return d


def _tables(number: int, **d: Any) -> dict[str, Any]:
    low, high, least, most = FLUIDS[d["fluid"]]
    first = low + d["start"] * (high - low)
    second = low + d["end"] * (high - low)
    if d["wall"] == "cure":
        high = min(high, HOTTEST_CURE)
        low = min(low, high - 30.0)
        first, second = (low + d[end] * (high - low) for end in ("start", "end"))
    if d["difference"] < HARDLY_ANY:
        second = first + (0.2 if first < 0.5 * (low + high) else -0.2)
    elif abs(first - second) < 5.0:
        second = first + (5.0 if first < 0.5 * (low + high) else -5.0)
    change = second - first
    width = d["beads_across"] * d["bead_diameter"]
    length = 1.0 if d["kind"] == "mesh" else d["length"]
    if d["kind"] == "mesh":
        d["bead_diameter"] = min(d["bead_diameter"], 5e-3)
    tables: dict[str, dict[str, Any]] = {
        "geometry": _geometry(d["kind"], length, width),
        "bed": {
            "bead_diameter": d["bead_diameter"],
            "bead_material": d["bead_material"],
            "porosity_model": d["porosity_model"],
            "bulk_porosity": d["porosity"],
        },
        "fluid": {"material": d["fluid"].strip()},
        "operation": {
            "initial_temperature": first,
            "inlet_temperature": second,
            "heating_margin": 0.04 * abs(change),
            "gravity": d["gravity"],
        },
        "model": _model(d),
        "solver": {"mesh_refinement": NARROW_CELLS} if d["kind"] == "narrow" else {},
        "output": {"pictures": False, "fields": False},
    }
    if d["bead_material"] == "steel":
        tables["bed"] |= {"bead_material": "ceramic", **{f"bead_{name}": value for name, value in STEEL.items()}}
    tables |= _wall(tables, d)
    _outer(tables["operation"], d, first, second, change)
    _drive(tables, d, length, least * (most / least) ** d["pressure"])
    _programme(tables, d, number, first, second, change)
    return tables


def _geometry(kind: str, length: float, width: float) -> dict[str, Any]:
    if kind == "mesh":
        return {"kind": "mesh", "mesh": str(CURVED)}
    if kind == "narrow":
        return {"kind": "mold", "length": length, "cavity_height": width, "width": 3.0 * width}
    return {"kind": kind, "length": length, "cavity_height" if kind == "mold" else "diameter": width}


def _model(d: Mapping[str, Any]) -> dict[str, Any]:
    model = {"flow": d["flow"], "energy": d["energy"], "nusselt": d["nusselt"]}
    if d["closures"] == "each":
        model |= {name: d[name] for name in ("drag", "bead_conduction", "dispersion")}
    else:
        model["closures"] = d["closures"]
    if d["closures"] != "measured" or d["flow"] == "plug" or d["turbulence"] == "none":
        model["turbulence"] = d["turbulence"]
    if d["bead_modes"] is not None:
        model["bead_modes"] = d["bead_modes"]
    return model


def _wall(tables: dict[str, Any], d: Mapping[str, Any]) -> dict[str, Any]:
    material = dict(STEEL) if d["material"] == "steel" else {"material": d["material"]}
    thickness, kind = d["thickness"], d["wall"]
    own = {} if tables["geometry"]["kind"] == "mesh" else {"thickness": thickness}
    if kind in ("plain", "thin"):
        tables["model"]["wall"] = "thin" if kind == "thin" else "conjugate"
        return {"wall": material | own}
    if kind in ("fixed", "none"):
        tables["model"]["wall"] = "fixed-temperature" if kind == "fixed" else "insulated"
        return {}
    if kind == "cure" and tables["geometry"]["kind"] == "mesh":
        return {"wall": {"material": "resin"}, "materials": {"resin": RESIN}}
    skin = {
        "name": "skin",
        "material": "carbon_steel" if d["material"] == "steel" else d["material"],
        "thickness": thickness,
    }
    behind: dict[str, Any] = {"name": "behind", "material": "mineral_wool", "thickness": "20 mm"}
    if kind == "layers":
        behind |= {"material": "gfrp", "thickness": "4 mm"}
    if kind == "contact":
        skin["contact_resistance"], behind["material"], behind["thickness"] = 1e-3, "gfrp", "4 mm"
    if kind == "source":
        skin["heat_source"] = 2e3 / thickness
    if kind == "cure":
        behind |= {"material": "resin", "thickness": "4 mm"}
    return {"wall": {"layer": [skin, behind]}} | ({"materials": {"resin": RESIN}} if kind == "cure" else {})


def _outer(operation: dict[str, Any], d: Mapping[str, Any], first: float, second: float, change: float) -> None:
    if d["outer"] == "losses":
        operation |= {"outer_coefficient": 8.0, "ambient_temperature": first}
    elif d["outer"] == "oven":
        operation |= {"outer_coefficient": 30.0, "ambient_temperature": second}
    elif d["outer"] == "flux":
        operation["outer_heat_flux"] = math.copysign(300.0, change)
    if d["wall"] == "fixed":
        operation["wall_temperature"] = second


def _drive(tables: dict[str, Any], d: Mapping[str, Any], length: float, pressure: float) -> None:
    operation, pressure = tables["operation"], pressure * length
    if d["gravity"] < 0.0:
        pressure += 30.0 * length
    operation["pressure_drop"] = 0.0 if d["drive"] == "none" else pressure
    if d["beads"] != "rest":
        operation |= {"bead_velocity": 1e-9, "bead_inlet_temperature": operation["initial_temperature"]}
    if d["kind"] == "mesh" and d["drive"] in ("mass_flow", "inlet_velocity"):
        operation |= {
            "pressure_drop": None,
            "inlet_velocity": 0.5 if d["fluid"] not in ("water", "thermal_oil") else 0.01,
        }
    elif d["drive"] in ("mass_flow", "inlet_velocity") or d["beads"] != "rest":
        specs = specs_of(Scene(_without_none(tables)))
        assert specs.mesh.size is not None
        expected = estimate(specs, specs.mesh.size)
        if d["drive"] == "mass_flow":
            operation |= {"pressure_drop": None, "mass_flow": expected.mass_flow}
        elif d["drive"] == "inlet_velocity":
            operation |= {"pressure_drop": None, "inlet_velocity": expected.speed * d["porosity"]}
        if d["beads"] != "rest":  # as much heat capacity as the gas, about
            operation["bead_velocity"] = math.copysign(
                length / expected.flow_duration, 1.0 if d["beads"] == "with" else -1.0
            )
    if d["drive"] == "blower":
        operation |= {"pressure_drop": None, "blower_pressure": 2.0 * pressure, "blower_flow": 0.5}
    if d["heater"]:
        operation |= {"recirculation": 0.7}
        if operation["initial_temperature"] < operation["inlet_temperature"]:
            operation |= {"heater_power": 2e4}


def _programme(
    tables: dict[str, Any], d: Mapping[str, Any], number: int, first: float, second: float, change: float
) -> None:
    """The course of inlet temperature or pressure drop; a time at which runs end that wait for nothing, and targets."""
    operation = tables["operation"]
    scene = Scene(_without_none(tables | {"operation": operation}))
    specs = specs_of(scene)
    duration = 500.0
    if specs.mesh.size is not None:
        duration = min(estimate(specs, specs.mesh.size).heating_duration, 1e5)
    random = np.random.default_rng(number)
    if d["programme"] == "ramp":
        operation["inlet_temperature"] = [[0.0, duration], [first, second]]
    elif d["programme"] == "steps":
        times = [0.0, 0.3 * duration, 0.3 * duration + 0.1, 0.8 * duration, 0.8 * duration + 0.1]
        operation["inlet_temperature"] = [times, [first + part * change for part in (0.5, 0.5, 0.2, 0.2, 1.0)]]
    elif d["programme"] == "noise":
        times = np.linspace(0.0, 2.0 * duration, 60)
        values = second - 0.02 * abs(change) * random.random(60)
        operation["inlet_temperature"] = [times.tolist(), values.tolist()]
    elif d["programme"] == "off and on":
        pressure = operation["pressure_drop"]
        times = [0.0, 0.4 * duration, 0.41 * duration, 0.6 * duration, 0.61 * duration]
        operation["pressure_drop"] = [times, [pressure, pressure, 0.0, 0.0, pressure]]
    operation["end_time"] = 20.0 * duration
    if d["wall"] in ("fixed", "source") or d["outer"] != "adiabatic" or d["drive"] == "none" or d["beads"] != "rest":
        operation["end_time"] = 1.0 * duration
    if d["wall"] == "cure":
        operation["end_time"] = max(3.0 * duration, 600.0)
        place = "wall" if tables["geometry"]["kind"] == "mesh" else "behind"
        tables["target"] = {"list": [{"name": "cured", "place": place, "cured": 0.5}]}


def _without_none(tables: Mapping[str, Any]) -> dict[str, Any]:
    return {
        name: {key: value for key, value in table.items() if value is not None} if name != "materials" else table
        for name, table in tables.items()
    }


def scene_of(number: int, seed: int = SEED) -> Scene:
    """A scene by its number."""
    return Scene(_without_none(_all_tables(seed)[number]))


@functools.cache
def _all_tables(seed: int) -> list[dict[str, Any]]:
    return [tables for _, tables in scenes(seed=seed)]
