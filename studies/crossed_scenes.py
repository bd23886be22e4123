"""Three hundred scenes that cross every feature: is there an answer, how far is it from that of twice finer cells and steps,
which feature is the worst? Writes docs/crossed-scenes.md. Run: make crossed-scenes (about an hour, two cores).

A Latin hypercube with a fixed seed. What a scene answers are its heating time, when its targets are met, the highest temperature
of layers that cure, and without a heating time the temperatures and the heat stored at the end.
"""

import argparse
import json
import math
import multiprocessing
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from porousmold import InputError, Scene, run
from porousmold.errors import SolveError
from porousmold.simulation.estimates import estimate
from porousmold.simulation.result import Result
from porousmold.simulation.running import RunInterrupted
from porousmold.simulation.specs import specs_of
from porousmold.simulation.targets import highest_until_met
from studies.hypercube import draws
from studies.page import Page

HERE = Path(__file__).parent
DOCS = HERE.parent / "docs"
CURVED = HERE.parent / "meshes" / "curved_mold.geo"
SEED, COUNT, SAMPLE = 32, 300, 80
PATIENCE = 240.0
"""CPU seconds after which a run counts as without answer."""
NARROW_CELLS = 0.4
"""Refinement of the cells in three dimensions, where twice finer ones would take hours."""
FAR_OFF = 0.01
"""Error that a run should warn of."""
NOTHING = 0.01
"""K of difference between all temperatures of a run below which nothing happens in it, and it has no answer to compare."""
LEAST_HEAT = 1e-3
"""J stored, below which it is the rounding of heat that passes."""
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


def scene_of(number: int) -> Scene:
    """A scene by its number."""
    tables = list(scenes())[number][1]
    return Scene(_without_none(tables))


@dataclass
class Outcome:
    """What came of a run: its answers, (value, what a relative error is of), seconds of CPU and warnings, or why it has none."""

    answers: dict[str, tuple[float | None, float]] = field(default_factory=dict)
    seconds: float = 0.0
    steps: int = 0
    rejected: int = 0
    repeated: int = 0
    imbalance: float = 0.0
    beyond: float = 0.0
    reason: str = ""
    warnings: list[str] = field(default_factory=list)


def answers_of(scene: Scene, result: Result) -> dict[str, tuple[float | None, float]]:
    """Times over themselves, temperatures over the range of all temperatures, heat over the most that was stored.

    The extremes of a region are none of them: where gas meets a wall of another temperature at the inlet they are those of a
    corner, which is singular (scene 42: 674.4, 679.0 and 682.1 K with 1, 2 and 4 times the cells).
    """
    summary, history = result.summary, result.history
    found: dict[str, tuple[float | None, float]] = {}
    given = abs(scene.operation.initial_temperature - float(np.max(history["inlet_temperature"])))
    difference = max(given, float(np.max(history["highest_temperature"]) - np.min(history["lowest_temperature"])))
    if summary["heating_time"] is not None:
        found["heating time"] = summary["heating_time"], summary["heating_time"]
    for name, instant in summary["targets"].items():
        if instant is not None:
            found[f"target {name}"] = instant, instant
    for name in history:
        if name.startswith("cure_"):
            place = name.removeprefix("cure_")
            met = summary["targets"].values()
            peak = highest_until_met(list(history["time"]), list(history[f"highest_{place}"]), met)
            found[f"peak of {place}"] = peak, difference
    if summary["heating_time"] is None and summary["end_time"] >= scene.operation.end_time * (1.0 - 1e-9):
        for name in history:
            if name == "outlet_temperature" or name.startswith("temperature_"):
                found[name.replace("_", " ")] = float(history[name][-1]), difference
        found["heat stored"] = float(history["heat_stored"][-1]), float(np.max(np.abs(history["heat_stored"])))
    return found


def outcome(task: tuple[int, dict[str, Any], float]) -> Outcome:
    """`Outcome` of a scene with changes, (number, changes, CPU seconds)."""
    number, changes, patience = task
    start = time.process_time()
    try:
        scene = scene_of(number).changed(changes)
        result = run(scene, communicator=MPI.COMM_SELF, stop=lambda: time.process_time() - start > patience)
    except (InputError, SolveError, RunInterrupted) as failure:
        return Outcome(seconds=time.process_time() - start, reason=f"{type(failure).__name__}: {failure}")
    summary = result.summary
    beyond = next((w for w in summary["warnings"] if "beyond those given" in w), "")
    return Outcome(
        answers_of(scene, result),
        time.process_time() - start,
        summary["time_steps"],
        summary["rejected_steps"],
        summary["repeated_steps"],
        summary["energy_imbalance"],
        float(beyond.split(" K")[0].split()[-1]) if beyond else 0.0,
        warnings=summary["warnings"],
    )


def finer(number: int) -> dict[str, Any]:
    """Settings for twice the cells in each direction, of a mesh that is given none, and twice the steps."""
    scene = scene_of(number)
    cells = 2.0 * scene.solver.mesh_refinement
    return {"solver.step_refinement": 2.0} | (
        {} if scene.geometry.kind == "mesh" else {"solver.mesh_refinement": cells}
    )


def errors(own: Outcome, finer: Outcome) -> dict[str, float]:
    """Relative error of every answer that both runs have; infinite where only one has it; none where nothing happens."""
    found: dict[str, float] = {}
    differences = [scale for name, (_, scale) in own.answers.items() if name.startswith(("temperature", "outlet"))]
    if differences and max(differences) < NOTHING:
        return found
    for name in sorted({*own.answers, *finer.answers}):
        if name == "heat stored" and own.answers.get(name, (0.0, 1.0))[1] < LEAST_HEAT:
            continue
        if name not in own.answers or name not in finer.answers:
            found[name] = math.inf
            continue
        (value, scale), (other, _) = own.answers[name], finer.answers[name]
        assert value is not None and other is not None
        found[name] = abs(value - other) / max(scale, 1e-12)
    return found


def main() -> None:
    """Run all and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=DOCS / "crossed-scenes.md")
    parser.add_argument("--only", type=int, nargs="*", help="numbers of scenes to run alone, without a page")
    parser.add_argument("--step", type=int, default=1, help="one scene in so many")
    parser.add_argument("--every", type=int, default=COUNT // SAMPLE, help="one scene in so many against a finer run")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--raw", type=Path, help="file for all outcomes as JSON")
    parser.add_argument("--note", default="", help="a sentence for the page")
    parser.add_argument("--page-of", type=Path, metavar="RAW", help="run nothing: the page of such a file")
    options = parser.parse_args()
    numbers = list(range(0, COUNT, options.step)) if options.only is None else options.only
    drawn = [choice for choice, _ in scenes()]
    sample = [
        number
        for number in numbers
        if options.only is not None or (number % options.every == 0 and drawn[number]["kind"] != "narrow")
    ]
    tasks = {(n, "own"): (n, {}, PATIENCE) for n in numbers} | {
        (n, "finer"): (n, finer(n), 10 * PATIENCE) for n in sample
    }
    results: dict[tuple[int, str], Outcome] = {}
    if options.page_of:
        for entry in json.loads(options.page_of.read_text()):
            number, kind, _ = entry.pop("number"), entry.pop("kind"), entry.pop("drawn")
            results[number, kind] = Outcome(**entry)
        write_page(options.out, drawn, results, sample, options.note)
        return
    with ProcessPoolExecutor(options.processes, multiprocessing.get_context("spawn")) as pool:
        for key, result in zip(tasks, pool.map(outcome, tasks.values()), strict=True):
            results[key] = result
            line = f"{key[1]} {key[0]}: {result.seconds:.1f} s, {result.steps} steps ({result.rejected}, {result.repeated})"
            print(
                line,
                result.reason[:200] or {name: round(value, 4) for name, (value, _) in result.answers.items() if value},
                flush=True,
            )
            if key[1] == "finer":
                print("   ", _text(errors(results[key[0], "own"], result)), drawn[key[0]], flush=True)
    if options.raw:
        raw = [{"number": n, "kind": kind, "drawn": drawn[n], **vars(result)} for (n, kind), result in results.items()]
        options.raw.write_text(json.dumps(raw, indent=1))
    if options.only is None:
        write_page(options.out, drawn, results, sample, options.note)


def _text(found: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {100 * value:.3f} %" for name, value in found.items())


def write_page(
    path: Path, drawn: list[dict[str, Any]], results: Mapping[tuple[int, str], Outcome], sample: list[int], note: str
) -> None:
    """The page: scenes without an answer, errors, and errors by feature."""
    own = {n: result for (n, kind), result in results.items() if kind == "own"}
    refused = [n for n, result in own.items() if result.reason.startswith("InputError")]
    failed = [n for n, result in own.items() if result.reason and n not in refused]
    both = [n for n in sample if not own[n].reason and not results[n, "finer"].reason]
    found = {n: errors(own[n], results[n, "finer"]) for n in both}
    worst = {n: max(found[n].values()) for n in both if found[n]}
    both = list(worst)
    seconds = np.array([result.seconds for result in own.values() if not result.reason])
    values = np.array(list(worst.values()))
    far_off = [n for n in both if worst[n] > FAR_OFF]
    silent = [n for n in far_off if not _is_told(own[n])]
    alarms = [n for n in both if _is_told(own[n]) and worst[n] <= 0.5 * FAR_OFF]
    times = [value for n in both for name, value in found[n].items() if name.startswith(("heating", "target"))]
    page = Page(
        "# Scenes that cross every feature",
        "",
        f"Written by `make crossed-scenes`; do not edit. A Latin hypercube of {len(own)} scenes (seed {SEED}) over every",
        "closure and feature: layers, contacts, sources, cure, bead modes, one temperature, blower, heater, returned air,",
        "programmes and series, all fluids, gravity, moving beads, every kind of wall, no flow, heat from outside, meshes of",
        "one's own, narrow molds in three dimensions, full, developed and plug flow, differences of 0.2 to 500 K.",
        "",
        f"**{len(own) - len(refused) - len(failed)} of {len(own)} have an answer**, {len(refused)} are refused, {len(failed)} "
        f"failed or took more than {PATIENCE:g} s. CPU seconds of a run: median {np.median(seconds):.1f}, 95 % "
        f"{np.quantile(seconds, 0.95):.1f}, longest {seconds.max():.1f}. Largest imbalance of heat "
        f"{max(abs(result.imbalance) for result in own.values()):.1e}, largest excess over the temperatures given "
        f"{max(result.beyond for result in own.values()):.2g} K.",
        "",
        f"The worst answer of each of {len(both)} scenes in which anything happens, against twice the cells in each direction "
        f"and twice the steps: median "
        f"{100 * np.median(values):.3f} %, 95 % {100 * np.quantile(values, 0.95):.3f} %, largest {100 * values.max():.3g} %.",
        f"Of {len(times)} heating times and times of targets: median {100 * np.median(times):.3f} %, "
        f"95 % {100 * np.quantile(times, 0.95):.3f} %, largest {100 * max(times):.3g} %.",
        "",
        f"Off by more than {FAR_OFF:.0%} are {len(far_off)} scenes, {len(silent)} of them without a warning that says so"
        f"{': ' + ', '.join(map(str, silent)) if silent else ''}; {len(alarms)} scenes are warned of that are off by less "
        "than half of that.",
        note,
        "",
        "## By feature",
    )
    rows = []
    for name, choices in CHOICES.items():
        for choice in dict.fromkeys(choices):
            some = [worst[n] for n in both if drawn[n][name] == choice]
            if some:
                rows.append((name, choice, len(some), f"{100 * np.median(some):.3f} %", f"{100 * max(some):.3f} %"))
    page.table(("feature", "choice", "scenes", "median", "largest"), rows)
    page.add("## The worst scenes")
    largest = sorted(worst, key=lambda n: -worst[n])[:12]
    page.table(
        ("scene", "errors", "warnings", "what"),
        (
            (n, _text(errors(own[n], results[n, "finer"])), "; ".join(w[:80] for w in own[n].warnings), _what(drawn[n]))
            for n in largest
        ),
    )
    page.add("## Scenes without an answer")
    page.table(("scene", "reason", "what"), ((n, own[n].reason[:200], _what(drawn[n])) for n in (*refused, *failed)))
    page.write(path)


def _is_told(outcome: Outcome) -> bool:
    """Whether the run warns that its answers may be off for the sake of its cells and steps."""
    return any("coarser cells and steps" in one or "within one cell of the bed" in one for one in outcome.warnings)


def _what(drawn: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} {drawn[name]}".strip() for name in CHOICES)


if __name__ == "__main__":
    main()
