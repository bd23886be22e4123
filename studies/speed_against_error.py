"""Model ladder x meshes x steps against the transient reference: writes docs/speed-against-error.md and .png.

Run: make speed-against-error (about 25 minutes on one core).
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mpi4py import MPI

from porousmold import Scene
from porousmold.errors import SolveError
from porousmold.output.figures import STYLE, plt, save
from porousmold.simulation.accuracy import Answer, run_to_accuracy
from porousmold.simulation.specs import specs_of
from porousmold.simulation.time_integration import Simulation
from studies.page import yardstick

HERE = Path(__file__).parent
SCENES = {
    "aluminium mold": HERE / "mold" / "aluminium.toml",
    "FRP mold": HERE / "mold" / "frp.toml",
    "pipe": HERE / "pipe" / "baseline.toml",
}
LADDER = {
    "full": {},
    "full, frozen flow": {"model.flow_update": "frozen"},
    "full, no damping": {"model.turbulence": "nakayama-kuwahara"},
    "full, k-epsilon without beads": {"model.turbulence": "k-epsilon"},
    "full, laminar": {"model.turbulence": "none"},
    "full, thin wall": {"model.wall": "thin"},
    "full, one temperature": {"model.energy": "one-temperature"},
    "developed": {"model.flow": "developed"},
    "developed, no damping": {"model.flow": "developed", "model.turbulence": "nakayama-kuwahara"},
    "developed, thin wall": {"model.flow": "developed", "model.wall": "thin"},
    "developed, laminar": {"model.flow": "developed", "model.turbulence": "none"},
    "plug": {"model.flow": "plug", "model.turbulence": "none"},
}
CHEAP = {"solver.mesh_refinement": 0.5, "solver.step_refinement": 0.35}
UNBOUNDED = {"solver.keep_bounds": "false"}
CHEAPEST = {"solver.mesh_refinement": 0.4, "solver.step_refinement": 0.35} | UNBOUNDED
COARSE = "mesh x 0.5, steps x 0.35"
REPEATED = {
    "aluminium mold": {
        "full": {},
        "full, steps x 0.7": {"solver.step_refinement": 0.7},
        f"full, {COARSE}": CHEAP,
        "developed": LADDER["developed"],
        f"developed, {COARSE}": LADDER["developed"] | CHEAP,
        "developed, mesh x 0.4, steps x 0.35, without bounds": LADDER["developed"] | CHEAPEST,
    },
    "FRP mold": {
        "full, mesh x 0.42, steps x 0.35": CHEAP | {"solver.mesh_refinement": 0.42},
        "developed, mesh x 0.4, steps x 0.35": LADDER["developed"] | CHEAP | {"solver.mesh_refinement": 0.4},
    },
    "pipe": {f"full, {COARSE}": CHEAP, f"developed, {COARSE}": LADDER["developed"] | CHEAP},
}
LAST_SECTION = "## Five times the same, whole process"
MESHES, STEPS = (0.4, 0.5, 0.7, 1.0, 1.5), (0.35, 0.7, 1.0)
MESHES_WITHOUT_BOUNDS = (0.4, 0.5, 0.7)
LINES = {(1.0, True): "-", (0.7, True): "--", (0.35, True): ":", (0.35, False): "-."}
"""Dashes of a line of meshes, by its steps and whether temperatures keep their bounds."""
REPETITIONS = 5
ACCURACIES = (0.01, 0.003, 0.001, 0.0003)
LEAST_SHOWN = 1e-5
PEERS = {"aluminium mold": [(0.0069, 32.6), (0.0057, 9.1), (0.0007, 5.0)]}
"""Errors and Y of docs/openfoam.md, spin-up included."""


@dataclass
class Point:
    """A run in the picture: error of its heating time and solver time in Y; of the grids with its refinements, and whether
    temperatures keep their bounds."""

    scene: str
    choice: str
    error: float
    time: float
    mesh: float = 0.0
    steps: float = 0.0
    bounded: bool = True
    estimate: float = 0.0

    def __post_init__(self):
        self.error = max(self.error, LEAST_SHOWN)


def integrated(scene: Scene) -> tuple[float, float, int, float] | None:
    """(heating time, solver seconds, unknowns, energy imbalance) of a `Scene`; None where it failed."""
    try:
        simulation = Simulation(specs_of(scene), MPI.COMM_SELF).integrate()
    except SolveError:
        return None
    problem = simulation.problem
    seconds = problem.stopwatch.seconds["flow"] + problem.stopwatch.seconds["energy"]
    unknowns = problem.flow.unknowns + problem.heat.unknowns
    return simulation.recorder.heating_time, seconds, unknowns, abs(problem.heat.balance.imbalance)


def row(name, result, reference, unit):
    """A line of a table."""
    if result is None:
        return f"| {name} | no steady flow | | | | |"
    heating, seconds, unknowns, imbalance = result
    return f"| {name} | {heating:.1f} | {heating / reference - 1:+.3%} | {seconds / unit:.2f} | {unknowns} | {imbalance:.0e} |"


HEAD = ["| choice | heating time, s | error | solver, Y | unknowns | imbalance |", "|---|---|---|---|---|---|"]


def scene_tables(name, path, points):
    """Tables of one scene; appends a `Point` of every run to `points`."""
    reference_settings = {"solver.mesh_refinement": 2.0, "solver.step_refinement": 2.0}
    base = integrated(Scene.load(path, reference_settings))[0]
    transient = integrated(Scene.load(path, {"model.flow_update": "transient"}))
    steady = integrated(Scene.load(path))
    lines = ["", f"## {name}", ""]
    lines += [
        f"Reference: {base:.2f} s, full flow with twice the cells in each direction and twice the steps.",
        "The coupled transient fails at the default mesh."
        if transient is None
        else f"Coupled transient at the default mesh: {transient[0]:.2f} s in {transient[1]:.1f} s of solver time, quasi-steady "
        f"{steady[0]:.2f} s: the quasi-steady assumption costs {steady[0] / transient[0] - 1:+.4%}.",
        "",
        "### Ladder, default mesh and steps",
        "",
        *HEAD,
    ]
    for choice, settings in LADDER.items():
        unit = yardstick()
        result = integrated(Scene.load(path, settings))
        lines.append(row(choice, result, base, unit))
        print(lines[-1], flush=True)
        if result:
            points.append(Point(name, choice, abs(result[0] / base - 1), result[1] / unit))
    lines += ["", "### Meshes and steps", "", *HEAD]
    for choice in ("full", "developed"):
        grid = [(mesh, steps, {}) for mesh in MESHES for steps in STEPS]
        grid += [(mesh, STEPS[0], UNBOUNDED) for mesh in MESHES_WITHOUT_BOUNDS]
        for mesh, steps, bounds in grid:
            unit = yardstick()
            settings = {"solver.mesh_refinement": mesh, "solver.step_refinement": steps} | bounds | LADDER[choice]
            result = integrated(Scene.load(path, settings))
            without = ", without bounds" if bounds else ""
            lines.append(row(f"{choice}, mesh x {mesh:g}, steps x {steps:g}{without}", result, base, unit))
            print(lines[-1], flush=True)
            if result:
                error = abs(result[0] / base - 1)
                points.append(Point(name, choice, error, result[1] / unit, mesh, steps, not bounds))
    lines += ["", "### Accuracy on request", ""]
    lines += ["| solver.accuracy | heating time, s | error | its estimate | all runs, Y |", "|---|---|---|---|---|"]
    for accuracy in ACCURACIES:
        unit, results = yardstick(), []

        def integrate(scene, results=results):
            results.append(integrated(scene))
            if results[-1] is None:
                raise SolveError("flow", 0.0, "no steady flow", "a finer mesh")
            return {"heating_time": Answer.by_itself(results[-1][0])}

        estimate = run_to_accuracy(Scene.load(path, {"solver.accuracy": accuracy}), integrate)["heating_time"]
        heating, total = results[-1][0], sum(result[1] for result in results if result) / unit
        lines.append(f"| {accuracy:g} | {heating:.1f} | {heating / base - 1:+.3%} | {estimate:.3%} | {total:.2f} |")
        print(lines[-1], flush=True)
        points.append(Point(name, "accuracy", abs(heating / base - 1), total, estimate=estimate))
    return lines


def repeated(references: dict[str, float]) -> list[str]:
    """Five runs of the whole process, pictures included, each with its own solver time: lines with medians and spread, errors
    against the scenes' `references` (s)."""
    folder, lines = Path("runs/speed-against-error"), ["", LAST_SECTION, ""]
    lines += ["| scene | choice | error | solver, Y | whole process, Y |", "|---|---|---|---|---|"]
    for scene, choices in REPEATED.items():
        for choice, settings in choices.items():
            solver, whole = [], []
            for _ in range(REPETITIONS):
                unit = yardstick()
                start = time.perf_counter()
                command = [sys.executable, "-m", "porousmold", "run", str(SCENES[scene]), "--quiet"]
                command += ["--out", str(folder), "--force"]
                for name, value in settings.items():
                    command += ["--set", f"{name}={value}"]
                # as in studies.page: without MPI's variables
                subprocess.run(command, check=True, capture_output=True, env=dict(os.environ))
                whole.append((time.perf_counter() - start) / unit)
                result = json.loads((folder / "result.json").read_text(encoding="utf-8"))
                seconds = result["wall_seconds"]
                solver.append((seconds["flow"] + seconds["energy"]) / unit)
            text = [f"{statistics.median(v):.2f} ({min(v):.2f}-{max(v):.2f})" for v in (solver, whole)]
            error = result["heating_time"] / references[scene] - 1
            lines.append(f"| {scene} | {choice} | {error:+.3%} | {text[0]} | {text[1]} |")
            print(lines[-1], flush=True)
    return lines


def references_in(page: str) -> dict[str, float]:
    """Reference heating times (s) of the scenes of a page."""
    sections = {name: page.split(f"\n## {name}\n")[1] for name in SCENES}
    return {name: float(text.split("Reference: ")[1].split(" s")[0]) for name, text in sections.items()}


def front(points):
    """Those that no other one beats in both error and time, by falling error."""
    best, chosen = np.inf, []
    for point in sorted(points, key=lambda point: (point.error, point.time)):
        if point.time < best:
            best = point.time
            chosen.append(point)
    return chosen


def picture(points, path):
    """Work against precision, a panel a scene: the grids of both flows, their front, runs to an accuracy, and OpenFOAM."""
    with plt.rc_context(STYLE):
        figure, all_axes = plt.subplots(1, len(SCENES), figsize=(13.5, 5.4), sharey=True, sharex=True)
    figure.subplots_adjust(left=0.05, right=0.99, top=0.94, bottom=0.27, wspace=0.06)
    for axes, name in zip(all_axes, SCENES, strict=True):
        own = [point for point in points if point.scene == name and point.mesh]
        for choice, colour in (("full", "tab:blue"), ("developed", "tab:orange")):
            for (steps, bounded), dash in LINES.items():
                line = [p for p in own if (p.choice, p.steps, p.bounded) == (choice, steps, bounded)]
                line.sort(key=lambda point: point.mesh)
                label = f"{choice} flow, steps x {steps:g}" + ("" if bounded else ", without bounds")
                axes.loglog([p.error for p in line], [p.time for p in line], dash, marker="o", ms=3.5, lw=1.1, color=colour,
                            label=label)  # fmt: skip
        best = front(own)
        axes.loglog([p.error for p in best], [p.time for p in best], "-", color="0.5", lw=7, alpha=0.3, zorder=0,
                    label="front of the best choices")  # fmt: skip
        for number, point in enumerate(p for p in points if p.scene == name and p.estimate):
            axes.plot([point.error, point.estimate], 2 * [point.time], "-", color="tab:green", lw=1.0)
            axes.plot(point.error, point.time, "*", ms=11, color="tab:green",
                      label="solver.accuracy; bar to its own estimate" if not number else None)  # fmt: skip
        if name in PEERS:
            errors, times = zip(*PEERS[name], strict=True)
            axes.plot(
                errors, times, "s", ms=6, mfc="none", color="k", label="OpenFOAM, turbulence given (docs/openfoam.md)"
            )
        axes.axvline(0.003, color="0.7", linewidth=1.0, linestyle="--")
        axes.set(title=name, xlabel="relative error of the heating time", xlim=(LEAST_SHOWN, 0.02))
    all_axes[0].set_ylabel("solver time in Y")
    figure.legend(*all_axes[0].get_legend_handles_labels(), loc="lower center", ncols=3, fontsize=9)
    save(figure, path)


def main():
    """Compute and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=HERE.parent / "docs" / "speed-against-error.md")
    parser.add_argument("--repeated", action="store_true", help="renew the last section only")
    options = parser.parse_args()
    out, start = options.out, time.perf_counter()
    points: list = []
    if options.repeated:
        kept = out.read_text(encoding="utf-8").split(f"\n{LAST_SECTION}")[0]
        out.write_text("\n".join([kept.rstrip("\n"), *repeated(references_in(kept)), ""]), encoding="utf-8")
        return
    lines = [
        "# Speed against error",
        "",
        "Written by `make speed-against-error`; do not edit. Errors are those of the heating time against the reference of each",
        "scene; the error of a simplified model therefore includes its discretisation error. Y is the median time of one sparse",
        "LU factorisation (5-point Laplacian, 300 x 300 nodes) on the same core in the same minute, in a process of its own.",
        "Solver time is that of flow and energy; the last table's runs are processes of their own, those of the others follow",
        "each other in one. To reproduce a row, pass its options with `--set`: `model.flow`, `model.turbulence`, `model.wall`,",
        "`model.energy`, `model.flow_update`, `solver.mesh_refinement`, `solver.step_refinement`, `solver.keep_bounds`.",
        "Errors by cells along the flow, by cells across it and by steps have signs: a point far left of its neighbours owes",
        "that to errors that cancel.",
        "",
        "![solver time against error](speed-against-error.png)",
    ]
    for name, path in SCENES.items():
        lines += scene_tables(name, path, points)
        out.write_text("\n".join(lines) + "\n", encoding="utf-8")
    lines += repeated(references_in("\n".join(lines)))
    print(f"{time.perf_counter() - start:.0f} s")
    lines.append("")
    out.write_text("\n".join(lines), encoding="utf-8")
    picture(points, out.with_suffix(".png"))


if __name__ == "__main__":
    main()
