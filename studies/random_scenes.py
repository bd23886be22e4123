"""Two hundred scenes drawn at random: is the flow found, how far is the answer from that of twice finer cells and steps, and
how far apart are full and developed flow? Writes docs/random-scenes.md. Run: make random-scenes (about 15 minutes, two cores).

Latin hypercube with a fixed seed over beads, bed, wall, drive, temperatures and every choice of model that the flow depends on.
"""

import argparse
import json
import multiprocessing
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from mpi4py import MPI

from porousmold import InputError, Scene, run
from porousmold.errors import SolveError
from porousmold.output.figures import STYLE, plt, save
from porousmold.simulation.estimates import estimate
from porousmold.simulation.running import RunInterrupted
from porousmold.simulation.specs import specs_of
from studies.hypercube import draws
from studies.page import strategies

HERE = Path(__file__).parent
DOCS = HERE.parent / "docs"
SEED, COUNT, SAMPLE = 13, 200, 40
PATIENCE = 120.0
"""CPU seconds after which a run at its own settings counts as without answer."""
DRIVES = ("pressure_drop", "mass_flow", "inlet_velocity")
CHOICES = {
    "kind": ("mold", "pipe"),
    "drive": DRIVES,
    "porosity_model": ("hunt-tien", "hunt-tien-spheres", "white-tien", "cheng-hsu", "vortmeyer-schuster", "constant"),
    "turbulence": ("none", "k-epsilon", "nakayama-kuwahara", "damped-nakayama-kuwahara"),
    "flow": ("full", "developed"),
    "wall": ("aluminium", "acrylic", "frp", "steel"),
}
RANGES = {  # (low, high, logarithmic)
    "bead_diameter": (1e-3, 12e-3, True),
    "beads_across": (10.0, 30.0, False),
    "length": (0.2, 3.0, True),
    "thickness": (0.3e-3, 20e-3, True),
    "bead_conductivity": (0.2, 200.0, True),
    "bulk_porosity": (0.34, 0.48, False),
    "pressure": (0.3e3, 60e3, True),
    "first_temperature": (303.15, 523.15, False),
    "second_temperature": (303.15, 523.15, False),
}
STEEL = {"density": 7850.0, "heat_capacity": 480.0, "conductivity": 45.0}
FINER = {"solver.mesh_refinement": 2.0, "solver.step_refinement": 2.0}


def scenes(count, seed):
    """The scenes, `count` of them."""
    for values in draws(RANGES, CHOICES, count, seed):
        yield _scene(**values)


def _scene(bead_diameter, beads_across, kind, drive, pressure, wall, thickness, **values):
    width = beads_across * bead_diameter
    first, second = values["first_temperature"], values["second_temperature"]
    if abs(first - second) < 20.0:
        second = first + (20.0 if first < 500.0 else -20.0)
    tables = {
        "geometry": {
            "kind": kind,
            "length": values["length"],
            "cavity_height" if kind == "mold" else "diameter": width,
        },
        "bed": {
            "bead_diameter": bead_diameter,
            "bead_conductivity": values["bead_conductivity"],
            "porosity_model": values["porosity_model"],
            "bulk_porosity": values["bulk_porosity"],
        },
        "wall": {"thickness": thickness, **(STEEL if wall == "steel" else {"material": wall})},
        "operation": {
            "initial_temperature": first,
            "inlet_temperature": second,
            "pressure_drop": pressure,
            "end_time": 1e8,
        },
        "model": {"turbulence": values["turbulence"], "flow": values["flow"]},
    }
    scene = Scene(tables)
    if drive != "pressure_drop":
        specs = specs_of(scene)
        expected = estimate(specs, specs.mesh.size)
        flow = {"mass_flow": expected.mass_flow, "inlet_velocity": expected.speed * values["bulk_porosity"]}[drive]
        scene = scene.changed({"operation.pressure_drop": None, **{f"operation.{drive}": flow}})
    return scene


@dataclass
class Outcome:
    """What came of a run: heating time (s) or None, seconds of CPU, iterations and steps, or why it failed."""

    heating_time: float | None
    seconds: float
    newton: int = 0
    pseudo_steps: int = 0
    steps: int = 0
    rejected: int = 0
    imbalance: float = 0.0
    beyond: float = 0.0
    reason: str = ""
    warnings: str = ""
    strategies: dict[str, int] = field(default_factory=dict)


def outcome(task):
    """`Outcome` of a scene with changes, (number, changes)."""
    number, changes, patience = task
    start = time.process_time()
    scene = list(scenes(COUNT, SEED))[number].changed(changes)
    try:
        summary = run(scene, communicator=MPI.COMM_SELF, stop=lambda: time.process_time() - start > patience).summary
    except (InputError, SolveError, RunInterrupted) as failure:
        return Outcome(None, time.process_time() - start, reason=f"{type(failure).__name__}: {failure}")
    operation = scene.operation
    given = [operation.initial_temperature, *operation.inlet_temperature.range]
    low, high = summary["temperature_bounds"]
    return Outcome(
        summary["heating_time"],
        time.process_time() - start,
        summary["newton_iterations"]["flow"],
        summary["continuation_steps"],
        summary["time_steps"],
        summary["rejected_steps"],
        summary["energy_imbalance"],
        max(high - max(given), min(given) - low, 0.0),
        warnings="; ".join(summary["warnings"]),
        strategies=summary["flow_strategies"],
    )


def text_of(number, scene, result):
    """A row about a run."""
    geometry, bed, operation, model = scene.geometry, scene.bed, scene.operation, scene.model
    drive = next(name for name in DRIVES if getattr(operation, name) is not None)
    width = geometry.cavity_height or geometry.diameter
    return (
        f"| {number} | {geometry.kind} {geometry.length:.2f} m x {width * 1e3:.0f} mm, d {bed.bead_diameter * 1e3:.1f} mm, "
        f"{bed.porosity_model} {bed.bulk_porosity:.2f}, {model.flow}, {model.turbulence}, "
        f"{drive} {getattr(operation, drive).values[0]:.3g} | "
        f"{result.heating_time if result.heating_time is None else round(result.heating_time, 2)} | {result.newton} | "
        f"{result.pseudo_steps} | {result.steps} / {result.rejected} | {result.seconds:.1f} | {result.reason[:160]} |"
    )


def main():
    """Run all, draw, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=DOCS / "random-scenes.md")
    parser.add_argument("--only", type=int, nargs="*", help="numbers of scenes to run alone, without a page")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--raw", type=Path, help="file for all outcomes as JSON")
    options = parser.parse_args()
    drawn = list(scenes(COUNT, SEED))
    numbers = range(COUNT) if options.only is None else options.only
    sample = [number for number in numbers if number % (COUNT // SAMPLE) == 0] if options.only is None else []
    other = {n: {"model.flow": "full" if drawn[n].model.flow == "developed" else "developed"} for n in sample}
    tasks = {(n, "own"): (n, {}, PATIENCE) for n in numbers}
    tasks |= {(n, "finer"): (n, FINER, 20 * PATIENCE) for n in sample}
    tasks |= {(n, "other flow"): (n, other[n], PATIENCE) for n in sample}
    results = {}
    with ProcessPoolExecutor(options.processes, multiprocessing.get_context("spawn")) as pool:
        for (number, kind), result in zip(tasks, pool.map(outcome, tasks.values()), strict=True):
            results[number, kind] = result
            print(kind, text_of(number, drawn[number], result), flush=True)
    if options.raw:
        raw = [{"number": n, "kind": kind, **vars(result)} for (n, kind), result in results.items()]
        options.raw.write_text(json.dumps(raw, indent=1))
    if options.only is None:
        write_page(options.out, drawn, results, sample)


def differences(results, sample, kind):
    """Relative differences of the sample's heating times from those of another kind, where there are both."""
    pairs = [(results[n, "own"].heating_time, results[n, kind].heating_time) for n in sample]
    return np.array([own / other - 1.0 for own, other in pairs if own and other])


def write_page(path, drawn, results, sample):
    """The page and its picture."""
    own = {n: result for (n, kind), result in results.items() if kind == "own"}
    answered = [n for n, result in own.items() if result.heating_time is not None]
    finer, other = (np.abs(differences(results, sample, kind)) for kind in ("finer", "other flow"))
    seconds = np.array([own[n].seconds for n in answered])
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 3, figsize=(11, 3.4), sharey=True, layout="constrained")
    for axis, values, label in (
        (axes[0], 100 * finer, "difference from twice finer, %"),
        (axes[1], 100 * other, "full against developed flow, %"),
        (axes[2], seconds, "CPU seconds of a run"),
    ):
        values = np.sort(np.maximum(values, 1e-4))
        axis.semilogx(values, np.arange(1, len(values) + 1) / len(values), drawstyle="steps-post")
        axis.set_xlabel(label)
    axes[0].set_ylabel("part of the scenes")
    picture = path.with_suffix(".png")
    save(figure, picture)
    unbalanced = max(abs(own[n].imbalance) for n in answered)
    beyond = max(own[n].beyond for n in answered)

    def quantiles(values):
        return f"{100 * np.median(values):.3f} % | {100 * np.quantile(values, 0.95):.3f} % | {100 * values.max():.3f} %"

    lines = [
        "# Random scenes",
        "",
        "Written by `make random-scenes`; do not edit. A Latin hypercube of "
        f"{COUNT} scenes (seed {SEED}): molds and pipes, beads 1 to 12 mm,",
        "10 to 30 of them across, 0.2 to 3 m long, walls 0.3 to 20 mm of aluminium, steel, FRP or acrylic, beads of 0.2 to 200",
        "W/m/K, bulk porosity 0.34 to 0.48, 0.3 to 60 kPa or the mass flow or velocity that belongs to it, 30 to 250 degC,",
        "heating and cooling, every porosity law and turbulence model, full and developed flow. Default settings.",
        "",
        f"**{len(answered)} of {COUNT} have an answer.** Largest imbalance of heat {unbalanced:.1e}, largest excess over the "
        f"temperatures given {beyond:.3f} K. CPU seconds of a run, compiled: median {np.median(seconds):.1f}, 95 % "
        f"{np.quantile(seconds, 0.95):.1f}, longest {seconds.max():.1f}.",
        "",
        "| heating time, relative difference | scenes | median | 95 % | largest |",
        "|---|---|---|---|---|",
        f"| default settings against twice finer mesh and steps | {len(finer)} | {quantiles(finer)} |",
        f"| full against developed flow (entrance effects) | {len(other)} | {quantiles(other)} |",
        "",
        f"![Distributions]({picture.name})",
        "",
        "## How the flows were found",
        "",
        "In a step with the Jacobian of an earlier one, or a renewed one; from a guess by Newton's method or a false transient.",
        "",
        *strategies(own[n].strategies for n in answered),
        "",
        "## Scenes without an answer",
        "",
        "| scene | what | heating time, s | Newton iterations | pseudo-steps | steps / rejected | CPU s | reason |",
        "|---|---|---|---|---|---|---|---|",
        *[text_of(n, drawn[n], result) for n, result in own.items() if result.heating_time is None],
        "",
        "## The sample",
        "",
        "| scene | what | own, s | finer | other flow |",
        "|---|---|---|---|---|",
    ]
    for n in sample:
        what = text_of(n, drawn[n], own[n]).split("|")[2]
        values = [results[n, kind].heating_time for kind in ("own", "finer", "other flow")]
        cells = [f"{v:.2f}" if v else "none" for v in values]
        lines.append(f"| {n} |{what}| " + " | ".join(cells) + " |")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
