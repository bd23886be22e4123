"""Numbers that a refactoring must leave alone: stored once, compared later.

Runs every shipped scene, and every choice of model and turbulence on coarse cells. Run (about 4 minutes):

    make regression-store      # before a change: runs/regression.json
    make regression            # after it: the largest relative difference of every number, status 1 beyond 1e-6
"""

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path

from tqdm import tqdm

from porousmold import Scene, run

HERE = Path(__file__).parent
MOLD, PIPE = HERE / "mold" / "aluminium.toml", HERE / "pipe" / "baseline.toml"
SHIPPED = (
    *(HERE / "mold" / f"{name}.toml" for name in ("aluminium", "frp", "curved")),
    PIPE,
    HERE / "pipe" / "experiment" / "experiment.toml",
)
COARSE = {"solver.mesh_refinement": 0.5, "solver.step_refinement": 0.5}
NUMBERS = (
    *("heating_time", "heating_time_bed_side", "mass_flow_initial", "mass_flow_final", "heat_by_fluid", "heat_stored"),
    *("fluid_heat", "pumping_work", "time_steps"),
)
ABSOLUTE = ("energy_imbalance", "mass_imbalance")
"""Compared by their difference, as they are next to nothing."""
TURBULENCE = ("none", "k-epsilon", "nakayama-kuwahara", "damped-nakayama-kuwahara")
PROFILE = str(HERE / "profiles" / "cylinder_ratio_20.csv")


def cases() -> Iterator[tuple[str, Path, dict[str, object]]]:
    """(name, scene file, settings) of every run."""
    for path in SHIPPED:
        yield path.stem, path, {}
    for turbulence in TURBULENCE:
        for kind, path in (("mold", MOLD), ("pipe", PIPE)):
            for flow in ("full", "developed"):
                settings = {"model.turbulence": turbulence, "model.flow": flow}
                yield f"{kind}, {turbulence}, {flow}", path, COARSE | settings
    fixed = {"model.wall": "fixed-temperature", "operation.wall_temperature": 340.0, "operation.end_time": 600.0}
    choices: dict[str, dict[str, object]] = {
        "plug": {"model.flow": "plug"},
        "one temperature": {"model.energy": "one-temperature"},
        "thin wall": {"model.wall": "thin"},
        "no wall": {"model.wall": "insulated"},
        "wall of fixed temperature": fixed,
        "frozen": {"model.flow_update": "frozen"},
        "transient": {"model.flow_update": "transient", "model.turbulence": "none"},
        "bead modes": {"model.bead_modes": 2},
        "ergun, henry": {"model.drag": "ergun", "model.nusselt": "henry"},
        "white-tien": {"bed.porosity_model": "white-tien"},
        "profile": {"bed.porosity_profile": PROFILE, "model.turbulence": "none"},
        "REV terms": {"bed.porosity_profile": PROFILE, "model.turbulence": "none", "model.rev_terms": "consistent"},
        "mass flow": {"operation.pressure_drop": None, "operation.mass_flow": 0.04},
        "velocity": {"operation.pressure_drop": None, "operation.inlet_velocity": 1.5},
        "gravity, outer wall": {
            **{"operation.gravity": 9.81, "operation.outer_coefficient": 10.0},
            "operation.ambient_temperature": 298.15,
        },
        "three dimensions": {"geometry.width": 0.1, "model.turbulence": "none", "solver.axial_cells": 8},
    }
    for name, settings in choices.items():
        for kind, path in (("mold", MOLD), ("pipe", PIPE)):
            if kind == "mold" or name not in ("three dimensions", "mass flow", "velocity"):
                yield f"{kind}, {name}", path, COARSE | {"solver.mesh_refinement": 0.4} | settings


def numbers_of(path: Path, settings: dict[str, object]) -> dict[str, float | None]:
    """The compared numbers of one run."""
    summary = run(Scene.load(path, settings)).summary
    return {name: summary[name] for name in (*NUMBERS, *ABSOLUTE)}


def difference(name: str, before: float | None, now: float | None) -> float:
    """Relative difference of a number, absolute for those of `ABSOLUTE`; infinite where only one of both is there."""
    if before is None or now is None:
        return 0.0 if before is now else float("inf")
    if name in ABSOLUTE:
        return abs(now - before)
    return abs(now - before) / max(abs(before), 1e-300) if now != before else 0.0


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("do", choices=("store", "compare"))
    parser.add_argument("file", type=Path)
    parser.add_argument("--only", default="", help="cases whose name contains this text")
    parser.add_argument("--tolerance", type=float, default=1e-6)
    options = parser.parse_args(arguments)
    chosen = [case for case in cases() if options.only in case[0]]
    found = {name: numbers_of(path, settings) for name, path, settings in tqdm(chosen, disable=not sys.stderr.isatty())}
    if options.do == "store":
        options.file.parent.mkdir(parents=True, exist_ok=True)
        options.file.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        return 0
    stored = json.loads(options.file.read_text(encoding="utf-8"))
    worst = 0.0
    for name, now in found.items():
        differences = {key: difference(key, stored[name][key], value) for key, value in now.items()}
        key = max(differences, key=lambda each: differences[each])
        worst = max(worst, differences[key])
        print(f"{name:45} {differences[key]:.1e}  {key}")
    print(f"largest difference {worst:.1e} in {len(found)} runs, allowed {options.tolerance:g}")
    return int(worst > options.tolerance)


if __name__ == "__main__":
    sys.exit(main())
