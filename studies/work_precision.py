"""Work against precision over forty scenes that cross the features, not over one: writes docs/work-precision.md and .png.

Every scene is run with fewer cells, fewer steps, fewer of both, and to an accuracy on request; its error is that of its worst
answer (`studies.crossed_scenes`) against twice the cells in each direction and twice the steps of the run on default cells (of
its repeat where its answers are in doubt). Run: make work-precision (about 50 minutes of one core).
"""

import argparse
import json
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from porousmold.output.figures import STYLE, plt, save
from studies.crossed_draws import SEED, scene_of, scenes
from studies.crossed_scenes import errors, finer, outcome
from studies.page import Page, yardstick

DOCS = Path(__file__).parent.parent / "docs"
SCENES = 40
KINDS = ("mold", "pipe")
"""Straight beds, whose cells are the program's own."""
PATIENCE = 90.0
"""CPU seconds after which a run counts as without answer; ten times that for the reference."""
CELLS, STEPS = "solver.mesh_refinement", "solver.step_refinement"
PATHS: dict[str, list[dict[str, float]]] = {
    "cells and steps": [{CELLS: one, STEPS: one} for one in (0.35, 0.5, 0.71, 1.0)],
    "cells alone": [{CELLS: one} for one in (0.35, 0.5, 0.71, 1.0)],
    "steps alone": [{STEPS: one} for one in (0.25, 0.35, 0.5, 1.0)],
    "solver.accuracy": [{"solver.accuracy": one} for one in (0.03, 0.01, 0.003)],
}
"""Settings along each path; factors are on the scene's own."""
LEAST_SHOWN = 1e-6


@dataclass
class Point:
    """A run: number of its scene, its path and place there, error of its worst answer, and CPU time in Y."""

    scene: int
    path: str
    place: int
    error: float
    time: float


def settings_of(number: int, given: dict[str, float]) -> dict[str, float]:
    """Settings of a scene, factors taken times its own."""
    own = scene_of(number).solver
    bases = {CELLS: own.mesh_refinement, STEPS: own.step_refinement}
    return {name: value * bases.get(name, 1.0) for name, value in given.items()}


def points_of(number: int) -> list[Point]:
    """All runs of a scene; none where it has no answer, or nothing happens in it."""
    default = outcome((number, {}, PATIENCE))
    if default.reason:
        return []
    reference = outcome((number, finer(number, default), 10.0 * PATIENCE))
    if reference.reason:
        return []
    unit, found = yardstick(of_cpu=True), []
    known: dict[str, tuple[float, float]] = {}
    for path, places in PATHS.items():
        for place, given in enumerate(places):
            settings = settings_of(number, given)
            key = json.dumps({CELLS: 1.0, STEPS: 1.0} | given, sort_keys=True)
            if key not in known:
                own = outcome((number, settings, PATIENCE))
                if own.reason or not (off := errors(own, reference)) or not np.isfinite(max(off.values())):
                    return []
                known[key] = max(off.values()), own.seconds / unit
            found.append(Point(number, path, place, *known[key]))
    return found


def write_page(path: Path, points: list[Point], tried: int) -> None:
    """Table and picture: of every place of every path the median and 95 % of the errors, and the median time."""
    count = len({point.scene for point in points})
    page = Page(
        "# Work against precision",
        "",
        f"Written by `make work-precision`; do not edit. {count} scenes (of {tried} drawn; the others have no answer within",
        f"{PATIENCE:g} s of CPU along every path, or none to compare) that cross the program's features: straight beds of",
        f"[crossed-scenes.md](crossed-scenes.md), of seed {SEED}. The error of a run is that of its worst answer (heating time,",
        "targets, peaks of cure; without those every temperature and the heat stored at the end), against twice the cells in",
        "each direction and twice the steps of the run on default cells, of its repeat where its answers are in doubt. Time is",
        "the CPU time of the whole run in a process that has compiled its forms, in Y: CPU time of a",
        "sparse LU factorisation (5-point Laplacian, 300 x 300 nodes) in the same minute.",
        "",
        "![error against time](work-precision.png)",
    )
    page.head("path", "settings", "median error", "95 %", "median time, Y")
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(8.0, 5.2))
    figure.subplots_adjust(left=0.11, right=0.97, bottom=0.12, top=0.97)
    for colour, (name, places) in zip(("tab:blue", "tab:orange", "tab:green", "tab:red"), PATHS.items(), strict=True):
        times, medians, nearly_all = [], [], []
        for place, given in enumerate(places):
            here = [point for point in points if (point.path, point.place) == (name, place)]
            off = np.maximum([point.error for point in here], LEAST_SHOWN)
            times.append(float(np.median([point.time for point in here])))
            medians.append(float(np.median(off)))
            nearly_all.append(float(np.quantile(off, 0.95)))
            shown = ", ".join(f"{key.removeprefix('solver.')} {value:g}" for key, value in given.items())
            page.row(name, shown, f"{medians[-1]:.3%}", f"{nearly_all[-1]:.3%}", f"{times[-1]:.2f}")
        axes.loglog(medians, times, "o-", color=colour, label=f"{name}: median")
        axes.loglog(nearly_all, times, "s--", color=colour, mfc="none", label=f"{name}: 95 %")
    axes.axvline(0.003, color="0.7", linewidth=1.0, linestyle=":")
    axes.set(xlabel="relative error of the worst answer", ylabel="median CPU time of a run in Y")
    axes.legend(fontsize=8)
    save(figure, path.with_suffix(".png"))
    page.add("", "Other programs are not in the picture: docs/openfoam.md has one, on the aluminium mold.", "")
    page.write(path)


def main() -> None:
    """Run all and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=DOCS / "work-precision.md")
    parser.add_argument("--scenes", type=int, default=SCENES, help="how many scenes")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--raw", type=Path, help="file for all points as JSON; scenes that it has are not run again")
    options = parser.parse_args()
    numbers = [number for number, (drawn, _) in enumerate(scenes()) if drawn["kind"] in KINDS]
    numbers = numbers[:: max(1, len(numbers) // options.scenes)][: options.scenes]
    done: dict[str, list[dict[str, Any]]] = {}
    if options.raw and options.raw.is_file():
        done = json.loads(options.raw.read_text())
    missing = [number for number in numbers if str(number) not in done]
    with ProcessPoolExecutor(options.processes, multiprocessing.get_context("spawn")) as pool:
        for number, found in zip(missing, pool.map(points_of, missing), strict=True):
            done[str(number)] = [asdict(point) for point in found]
            print(number, " ".join(f"{p.error:.1e}/{p.time:.2f}" for p in found) or "no answer", flush=True)
            if options.raw:
                options.raw.write_text(json.dumps(done, indent=1))
    points = [Point(**one) for number in numbers for one in done[str(number)]]
    write_page(options.out, points, len(numbers))


if __name__ == "__main__":
    main()
