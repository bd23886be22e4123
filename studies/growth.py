"""Seconds and memory against unknowns, from 4k to 1M, on 1 and 2 ranks: writes docs/growth.md. Run: make growth (40 minutes).

Every size is a process of its own (`--size`, under mpirun): the aluminium mold, or the one of 150 mm width in three dimensions
(`mold/narrow.toml`), with every cell cut, undamped bead sources, started from developed profiles. The second Newton iteration
of flow and k-epsilon and the second time step of the energy (of one stage) are timed; the first ones analyse the matrices, once
in a run and on one rank alone. Of `developed` flow it is the start, with the table of its profiles, and a renewal; the heat is
iterated (GMRES, multigrid) in three dimensions from 20 000 unknowns. Memory is in pages of 2 MiB
(`GLIBC_TUNABLES=glibc.malloc.hugetlb=1` in the environment), which large factors are written into a tenth to a fifth faster.
The last table is of whole runs of that mold.
"""

import argparse
import json
import math
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest.mock import patch

from mpi4py import MPI

from porousmold import Scene
from porousmold.simulation.specs import specs_of
from porousmold.simulation.time_integration import Simulation
from porousmold.solvers.sdirk import BACKWARD_EULER
from studies.page import Page

HEAD = (
    *("flow unknowns", "flow iteration, s", "the first one, s", "Krylov iterations"),
    *("energy unknowns", "energy step, s", "memory, GiB"),
)
HEAD_OF_DEVELOPED = (
    *("flow unknowns", "flow renewed, s", "the first one, s", "Krylov iterations of a heat stage"),
    *("energy unknowns", "energy step, s", "memory, GiB"),
)
TO_THE_HEATING_TIME = "3 dimensions, heating time"
"""Title of the whole runs' table."""
WHOLE_RUNS = (
    *((2, "full", 0.4), (2, "full", 0.6), (2, "full", 1.0)),
    *((1, "developed", 0.6), (1, "developed", 1.0), (2, "developed", 1.0)),
)
"""Their ranks, flow, and factors on the number of cells in each direction."""
HERE = Path(__file__).parent
SCENES = {2: "aluminium.toml", 3: "narrow.toml"}
TABLES = (
    (2, 1, "factorised", (1.4, 2, 4, 8, 11, 16.5)),
    (2, 1, "split", (4, 8, 11, 16.5)),
    (2, 2, "factorised", (2, 4, 8)),
    (2, 2, "split", (4, 8, 11, 16.5)),
    (3, 1, "factorised", (0.4, 0.6, 0.85, 1.0)),
    (3, 1, "split", (0.6, 0.85, 1.0)),
    (3, 2, "split", (0.6, 0.85, 1.0)),
    (3, 1, "developed", (0.6, 1.0, 1.6, 2.0, 2.5)),
    (3, 2, "developed", (0.6, 1.0, 1.6, 2.0, 2.5)),
)
"""Dimensions, ranks, how the flow is solved, and factors on the number of cells in each direction."""
STRATEGIES = {"factorised": 10**9, "split": 0, "developed": 0}
LARGE_PAGES = {"GLIBC_TUNABLES": "glibc.malloc.hugetlb=1"}
LONGEST = 1500
"""Seconds for one size."""
LARGEST_REFINEMENT = 20.0
"""Of a scene; beyond it there are more cells along the flow."""


def measure(dimensions, size, strategy):
    """Figures of one size on this communicator."""
    from porousmold.solvers import linear_solution

    linear_solution.LARGEST_FACTORISED = dict.fromkeys((2, 3), STRATEGIES[strategy])
    settings = {"model.turbulence": "nakayama-kuwahara", "solver.mesh_refinement": min(size, LARGEST_REFINEMENT)}
    if size > LARGEST_REFINEMENT:
        settings["solver.axial_cells"] = round(18 * size / LARGEST_REFINEMENT)
    scene = Scene.load(HERE / "mold" / SCENES[dimensions], settings)
    if strategy == "developed":
        scene = scene.changed({"model.flow": "developed"})
    problem = Simulation(specs_of(scene), MPI.COMM_WORLD).problem
    system, seconds = problem.heat._system, {}
    if strategy == "developed":
        seconds["first_flow"] = seconds_of(problem.flow.start)
        seconds["flow"] = seconds_of(lambda: problem.flow.renew(0.0, math.inf))
    else:
        system = problem.flow.solver.system
        problem.flow.initial_guess()
        for name in ("first_flow", "flow"):
            system.renew_jacobian()
            seconds[name] = seconds_of(lambda: problem.flow.renew(0.0, math.inf))
    with patch("porousmold.solvers.bounded_steps.STAGES", BACKWARD_EULER):  # one stage, of three that a step has
        for _ in range(2):
            seconds["energy"] = seconds_of(lambda: problem.heat.step(0.0, 1.0))
    memory = MPI.COMM_WORLD.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) / 2**20
    return {
        "size": size,
        "flow_unknowns": problem.flow.unknowns,
        "energy_unknowns": problem.heat.unknowns,
        "krylov_iterations": system.linear_iterations,
        "memory": memory,
        **seconds,
    }


def seconds_of(call: Callable[[], object]) -> float:
    """Wall seconds of a collective call."""
    MPI.COMM_WORLD.barrier()
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def child(dimensions: int, size: float, ranks: int, strategy: str) -> dict[str, float] | str:
    """Figures of one size, measured by another process, or why there are none."""
    options = ["--size", str(size), "--strategy", strategy, "--dimensions", str(dimensions)]
    done = launched(ranks, "studies.growth", *options)
    if isinstance(done, str):
        return done
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    return json.loads(lines[-1]) if lines else next(reversed(done.stderr.split("\n")[:-1]), "nothing")


def whole_run(size: float, ranks: int, flow: str) -> dict[str, Any] | str:
    """Result of the narrow mold with that many times the cells, heated in processes of their own, or why there is none."""
    out = Path("runs/growth")
    options = ["run", str(HERE / "mold" / SCENES[3]), "--quiet", "--force", "--out", str(out)]
    done = launched(
        ranks, "porousmold", *options, "--set", f"solver.mesh_refinement={size}", "--set", f"model.flow={flow}"
    )
    if isinstance(done, str):
        return done
    if done.returncode:
        return done.stderr.strip()
    return json.loads((out / "result.json").read_text(encoding="utf-8"))


def launched(ranks: int, module: str, *options: str) -> subprocess.CompletedProcess[str] | str:
    """A module's finished processes under mpirun, or that they took too long."""
    command = ["mpirun", "--oversubscribe", "-n", str(ranks)]
    command += ["--allow-run-as-root"] if os.geteuid() == 0 else []
    environment = {n: v for n, v in os.environ.items() if not n.startswith(("OMPI_", "PMIX_"))} | LARGE_PAGES
    command += [sys.executable, "-m", module, *options]
    try:
        return subprocess.run(command, capture_output=True, text=True, env=environment, timeout=LONGEST)
    except subprocess.TimeoutExpired:
        return f"not in {LONGEST} s"


def slope(rows, key, unknowns):
    """Exponent of growth between the two largest sizes."""
    a, b = rows[-2], rows[-1]
    return math.log(b[key] / a[key]) / math.log(b[unknowns] / a[unknowns])


def sections(page: Path) -> dict[str, list[str]]:
    """Lines of each section of the page, by its title."""
    titled = (part.split("\n", 1) for part in page.read_text(encoding="utf-8").split("\n## ")[1:])
    return {title: text.strip("\n").split("\n") for title, text in titled}


def main():
    """Measure one size (`--size`), or all, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", type=float)
    parser.add_argument("--dimensions", type=int, choices=SCENES, default=2)
    parser.add_argument("--strategy", choices=STRATEGIES, default="factorised")
    parser.add_argument("--renew", nargs=2, metavar=("DIMENSIONS", "STRATEGY"), help="only these tables (last: 3 time)")
    parser.add_argument("--out", type=Path, default=HERE.parent / "docs" / "growth.md")
    arguments = parser.parse_args()
    if arguments.size:
        result = measure(arguments.dimensions, arguments.size, arguments.strategy)
        if MPI.COMM_WORLD.rank == 0:
            print(json.dumps(result), flush=True)
        return
    from porousmold.solvers.linear_solution import LARGEST_FACTORISED

    page = Page(
        "# Growth",
        "",
        *__doc__.split("\n\n", 1)[1].strip().splitlines(),
        "",
        f"Up to {LARGEST_FACTORISED[2]} unknowns ({LARGEST_FACTORISED[3]} in three dimensions) the flow is factorised as a whole",
        "(MUMPS); beyond that GMRES is preconditioned by the factors of [u, p], in three dimensions by incomplete ones of u and",
        "those of the pressure's Schur complement, and by incomplete ones of k and epsilon (`split`). Memory is the peak of all",
        "ranks together.",
    )
    before = sections(arguments.out) if arguments.renew else {}

    def renewed(title: str) -> bool:
        return title.startswith(arguments.renew[0]) and title.endswith(arguments.renew[1])

    for dimensions, ranks, strategy, sizes in TABLES:
        title = f"{dimensions} dimensions, {ranks} rank{'s' * (ranks > 1)}, {strategy}"
        page.add("", f"## {title}")
        if arguments.renew and not renewed(title):
            page.add("", *before[title])
            continue
        page.head(*(HEAD_OF_DEVELOPED if strategy == "developed" else HEAD))
        rows = []
        for size in sizes:
            found = child(dimensions, size, ranks, strategy)
            if isinstance(found, str):
                page.row(f"mesh x {size:g}: {found}", *[""] * (len(HEAD) - 1))
                continue
            rows.append(found)
            flow, first, energy, memory = (f"{found[name]:.2f}" for name in ("flow", "first_flow", "energy", "memory"))
            iterations = found["krylov_iterations"]
            page.row(found["flow_unknowns"], flow, first, iterations, found["energy_unknowns"], energy, memory)
        if len(rows) > 1:
            page.add("", f"Exponent at the end: flow {slope(rows, 'flow', 'flow_unknowns'):.2f}, "
                      f"energy {slope(rows, 'energy', 'energy_unknowns'):.2f}, "
                      f"memory {slope(rows, 'memory', 'energy_unknowns'):.2f}.")  # fmt: skip
        page.write(arguments.out)
    page.add("", f"## {TO_THE_HEATING_TIME}")
    if arguments.renew and not renewed(TO_THE_HEATING_TIME):
        page.add("", *before[TO_THE_HEATING_TIME])
    else:
        page.head(
            *("flow", "ranks", "unknowns of the flow", "of the heat", "heating time, s", "steps"),
            *("flow, s", "energy, s", "whole run, s"),
        )
        for ranks, flow, size in WHOLE_RUNS:
            result = whole_run(size, ranks, flow)
            if isinstance(result, str):
                page.row(f"{flow}, mesh x {size:g}: {result}", *[""] * 8)
                continue
            seconds = [f"{result['wall_seconds'][name]:.0f}" for name in ("flow", "energy", "total")]
            unknowns, heating = result["unknowns"], f"{result['heating_time']:.1f}"
            page.row(flow, ranks, unknowns["flow"], unknowns["energy"], heating, result["time_steps"], *seconds)
    page.write(arguments.out)


if __name__ == "__main__":
    main()
