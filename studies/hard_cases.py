"""Every hard case of the design, run and told: writes docs/hard-cases.md. Run: make hard-cases (about 15 minutes)."""

import argparse
import tempfile
import time
from pathlib import Path

from mpi4py import MPI

from porousmold import InputError, Scene, run
from porousmold.errors import SolveError
from studies.page import Page, strategies

HERE = Path(__file__).parent
MOLD, FRP, PIPE = HERE / "mold" / "aluminium.toml", HERE / "mold" / "frp.toml", HERE / "pipe" / "baseline.toml"
LAMINAR = {"model.turbulence": "none"}
SHORT = {"operation.end_time": 2000.0}
SWEEP, CURVED, NARROW = HERE / "sweep" / "mold.toml", HERE / "mold" / "curved.toml", HERE / "mold" / "narrow.toml"
STEPPED = "time [s], T [degC]\n0, 90\n300, 90\n300.01, 40\n600, 40\n600.01, 90\n3000, 90\n"
NOISY = "time [s], T [degC]\n" + "".join(f"{20 * i}, {88 + (37 * i) % 5}\n" for i in range(160))
SWITCHED = "time [s], dp [kPa]\n0, 8\n200, 8\n200.5, 0\n400, 0\n400.5, 8\n4000, 8\n"
WATER = {"fluid.density": 997.0, "fluid.viscosity": 6e-4, "fluid.heat_capacity": 4180.0, "fluid.conductivity": 0.63}
OIL = {"fluid.density": 870.0, "fluid.viscosity": 0.03, "fluid.heat_capacity": 2000.0, "fluid.conductivity": 0.13}
DEEP = """
bed[] = Extrude {0, 0, 0.04} { Surface {1}; Layers {2}; };
wall[] = Extrude {0, 0, 0.04} { Surface {2}; Layers {2}; };
Physical Volume("bed") = {bed[1]};
Physical Volume("wall") = {wall[1]};
Physical Surface("symmetry") = {bed[2]};
Physical Surface("outlet") = {bed[3]};
Physical Surface("interface") = {bed[4]};
Physical Surface("inlet") = {bed[5]};
Physical Surface("outer") = {wall[4]};
Physical Surface("side") = {1, 2, bed[0], wall[0]};
"""
KINK = HERE / "profiles" / "cylinder_ratio_20.csv"


def cases(folder):
    """(row of the design's list, what is hard, scene file, settings); time series are written into the folder."""
    for name, text in (("stepped", STEPPED), ("noisy", NOISY), ("switched", SWITCHED)):
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")
    curved = (HERE.parent / "meshes" / "curved_mold.geo").read_text(encoding="utf-8").replace("Recombine", "//")
    plain = "\n".join(line for line in curved.splitlines() if not line.startswith("Physical"))
    for name, text in (("triangles", curved), ("tetrahedra", plain + DEEP)):
        (folder / f"{name}.geo").write_text(text, encoding="utf-8")
    for first in (0.01, 0.1, 1.0, 10.0, 100.0):
        yield 1, f"first step {first:g} s", MOLD, LAMINAR | {"solver.first_step": first}
    yield 1, "first step 0.01 s, FRP", FRP, LAMINAR | {"solver.first_step": 0.01}
    for diameter in (0.5, 1.0, 2.0):
        yield 2, f"beads of {diameter:g} mm", MOLD, LAMINAR | SHORT | {"bed.bead_diameter": diameter * 1e-3}
    yield 2, "beads of 10 mm in a cavity of 100 mm", MOLD, {"bed.bead_diameter": 0.01, "geometry.cavity_height": 0.1}
    for pressure in (0.0, 10.0, 500.0, 2e3, 12e3, 30e3, 80e3):
        yield 2, f"pressure drop {pressure:g} Pa", MOLD, SHORT | {"operation.pressure_drop": pressure}
    for conductivity in (0.05, 400.0):
        yield 3, f"wall of {conductivity:g} W/m/K", MOLD, LAMINAR | {"wall.conductivity": conductivity}
    for thickness in (0.1, 50.0):
        yield 3, f"wall of {thickness:g} mm", MOLD, LAMINAR | SHORT | {"wall.thickness": thickness * 1e-3}
    for factor in (0.01, 0.1, 10.0, 1000.0):
        yield 4, f"exchange x {factor:g}", MOLD, LAMINAR | {"model.exchange_factor": factor}
    yield 4, "one temperature (the limit of x 1000)", MOLD, LAMINAR | {"model.energy": "one-temperature"}
    for porosity in (0.26, 0.6, 0.9):
        yield 5, f"bulk porosity {porosity:g}", MOLD, LAMINAR | SHORT | {"bed.bulk_porosity": porosity}
    yield 5, "constant porosity 0.4", MOLD, LAMINAR | {"bed.porosity_model": "constant"}
    yield 5, "profile with its breakpoint, REV terms consistent", MOLD, LAMINAR | {
        "bed.porosity_profile": str(KINK), "model.rev_terms": "consistent"}  # fmt: skip
    yield 6, "12 axial cells, first cell 5 um (aspect 1e4)", MOLD, LAMINAR | {
        "solver.axial_cells": 12, "solver.first_cell": 5e-6}  # fmt: skip
    yield 6, "6 axial cells (cell Peclet number 2e4)", MOLD, LAMINAR | {"solver.axial_cells": 6}
    yield 7, "cooling", MOLD, {"operation.initial_temperature": 363.15, "operation.inlet_temperature": 298.15}
    yield 7, "inlet temperature stepped down and up", MOLD, LAMINAR | {
        "operation.inlet_temperature": str(folder / "stepped.csv")}  # fmt: skip
    yield 7, "noisy inlet temperature (4 K every 20 s)", MOLD, LAMINAR | SHORT | {
        "operation.inlet_temperature": str(folder / "noisy.csv")}  # fmt: skip
    yield 7, "flow switched off and on", MOLD, LAMINAR | {"operation.pressure_drop": str(folder / "switched.csv")}
    yield 7, "the same, damped turbulence", MOLD, {"operation.pressure_drop": str(folder / "switched.csv")}
    yield 7, "the same, developed", MOLD, {
        "operation.pressure_drop": str(folder / "switched.csv"), "model.flow": "developed"}  # fmt: skip
    yield 8, "turbulence dying in the bulk, developed", MOLD, {
        "geometry.cavity_height": 0.07, "bed.bead_diameter": 0.007, "model.flow": "developed"}  # fmt: skip
    for pressure in (3e3, 5e3):
        yield 8, f"damping's switch in the bulk, {pressure:g} Pa", MOLD, SHORT | {"operation.pressure_drop": pressure}
    for model in ("k-epsilon", "nakayama-kuwahara"):
        yield 8, f"cold start of {model}", MOLD, {"model.turbulence": model}
    yield 9, "outlet pressure 10 bar", MOLD, LAMINAR | {"operation.outlet_pressure": 1e6}
    yield 10, "water", MOLD, LAMINAR | WATER | {"operation.pressure_drop": 500.0}
    yield 10, "oil", MOLD, LAMINAR | OIL | {"operation.pressure_drop": 2000.0, "operation.end_time": 2e4}
    yield 11, "8 beads across", MOLD, LAMINAR | {"geometry.cavity_height": 0.04}
    yield 11, "8 beads across, asked for", MOLD, LAMINAR | {
        "geometry.cavity_height": 0.04, "bed.allow_small_ratio": True}  # fmt: skip
    yield 12, "beads of a poor conductor (Bi > 0.1)", MOLD, LAMINAR | {"bed.bead_conductivity": 0.1}
    yield 12, "the same with 2 modes inside", MOLD, LAMINAR | {"bed.bead_conductivity": 0.1, "model.bead_modes": 2}
    yield 12, "developed flow, pipe", PIPE, {"model.flow": "developed"}
    yield from flow_cases(folder)


def flow_cases(folder):
    """Flows that are hard to find: where bead sources fade out in the bulk, driven in every way, on every mesh."""
    developed = {"model.flow": "developed"}
    for pressure in (20e3, 25e3, 40e3):
        yield 13, f"{pressure / 1e3:g} kPa", MOLD, {"operation.pressure_drop": pressure}
    yield 13, "30 kPa, developed", MOLD, developed | {"operation.pressure_drop": 30e3}
    for kind in ({}, developed):
        name = ", developed" if kind else ""
        yield 13, "pipe with 10 mm beads" + name, PIPE, kind | {"bed.bead_diameter": 0.01}
        yield 13, "cavity of 80 mm with 8 mm beads" + name, MOLD, kind | {
            "geometry.cavity_height": 0.08, "bed.bead_diameter": 0.008}  # fmt: skip
        for diameter, pressure in ((0.006, 14.6e3), (0.00525, 19.7e3), (0.006, 19.7e3)):
            yield 13, f"mold of the sweep, {diameter * 1e3:g} mm, {pressure / 1e3:g} kPa" + name, SWEEP, {
                "bed.bead_diameter": diameter, "operation.pressure_drop": pressure, "model.flow": "full"} | kind  # fmt: skip
    for law in ("cheng-hsu", "vortmeyer-schuster"):
        yield 13, f"porosity of {law}", MOLD, {"bed.porosity_model": law}
    for size in (0.4, 0.5, 2.0):
        yield 13, f"mesh x {size:g}", MOLD, {"solver.mesh_refinement": size}
    yield 13, "mesh and steps x 0.4", MOLD, {"solver.mesh_refinement": 0.4, "solver.step_refinement": 0.4}
    yield 13, "short bed (0.1 m), 20 kPa", MOLD, {"geometry.length": 0.1, "operation.pressure_drop": 20e3}
    yield 13, "the same, mesh and steps x 2", MOLD, {
        "geometry.length": 0.1, "operation.pressure_drop": 20e3, "solver.mesh_refinement": 2.0,
        "solver.step_refinement": 2.0}  # fmt: skip
    yield 13, "curved mold", CURVED, {}
    yield 13, "curved mold of triangles", CURVED, {"geometry.mesh": str(folder / "triangles.geo")}
    yield 13, "curved mold of tetrahedra, 200 s", CURVED, {
        "geometry.mesh": str(folder / "tetrahedra.geo"), "geometry.symmetry": "none", "operation.end_time": 200.0}  # fmt: skip
    yield 13, "narrow mold in three dimensions, 200 s", NARROW, {"operation.end_time": 200.0}
    for model in ("k-epsilon", "nakayama-kuwahara", "damped-nakayama-kuwahara"):
        for flow in (0.03, 0.0395, 0.0436):
            yield 14, f"mass flow {flow:g} kg/s/m, {model}", MOLD, {
                "operation.mass_flow": flow, "operation.pressure_drop": None, "model.turbulence": model}  # fmt: skip
        yield 14, f"inlet velocity 1.5 m/s, {model}", MOLD, {
            "operation.inlet_velocity": 1.5, "operation.pressure_drop": None, "model.turbulence": model}  # fmt: skip
        yield 14, f"pipe, 8.5 g/s, {model}", PIPE, {
            "operation.mass_flow": 0.0085, "operation.pressure_drop": None, "model.turbulence": model}  # fmt: skip
        yield 14, f"pipe, inlet velocity 2 m/s, {model}", PIPE, {
            "operation.inlet_velocity": 2.0, "operation.pressure_drop": None, "model.turbulence": model}  # fmt: skip
    yield 15, "published blend and no longest eddy", MOLD, {
        "model.blend_half_width": 20.0, "model.longest_eddy": 1e6}  # fmt: skip
    for kind in ("full", "developed"):
        yield 15, f"two steady flows: k-epsilon at 3 kPa, {kind}", MOLD, {
            "model.turbulence": "k-epsilon", "operation.pressure_drop": 3e3, "model.flow": kind}  # fmt: skip


def _scene(path, settings, left_out):
    """Scene of a file with settings; what is left out gives way to another drive."""
    if not left_out:
        return Scene.load(path, settings)
    return Scene.load(path).changed(settings | dict.fromkeys(left_out))


def told(path, settings):
    """What happened, as the cells of a row; whether that is good; and how the flows were found."""
    start = time.process_time()
    try:
        given = {name: value for name, value in settings.items() if value is not None}
        left_out = [name for name, value in settings.items() if value is None]
        scene = _scene(path, given, left_out)
        summary = run(scene, communicator=MPI.COMM_SELF).summary
    except InputError as refusal:
        return ["refused", *[""] * 7, f"{time.process_time() - start:.0f}", str(refusal)[:140]], True, {}
    except SolveError as failure:
        return ["**status 3**", *[""] * 7, f"{time.process_time() - start:.0f}", str(failure)[:140]], False, {}
    operation = scene.operation
    given = [operation.initial_temperature, *operation.inlet_temperature.range]
    low, high = summary["temperature_bounds"]
    over, under = max(0.0, high - max(given)), max(0.0, min(given) - low)
    heating = summary["heating_time"]
    good = over < 0.1 and under < 0.1 and abs(summary["energy_imbalance"]) < 1e-3
    return (
        [
            "done" if good else "**out of bounds**",
            f"{heating:.0f}" if heating else "not reached",
            f"{summary['time_steps']} / {summary['rejected_steps']} / {summary['repeated_steps']}",
            str(summary["newton_iterations"]["flow"]),
            str(summary["continuation_steps"]),
            f"{over:.3f}",
            f"{under:.3f}",
            f"{summary['energy_imbalance']:.0e}",
            f"{time.process_time() - start:.0f}",
            "; ".join(warning[:90] for warning in summary["warnings"]),
        ],
        good,
        summary["flow_strategies"],
    )


def main():
    """Run all and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=HERE.parent / "docs" / "hard-cases.md")
    out = parser.parse_args().out
    page = Page(
        "# Hard cases",
        "",
        "Written by `make hard-cases`; do not edit. Rows are numbered as in the list of the design. Settings are those of",
        "`studies/mold/aluminium.toml` with what the row names, mostly laminar. Over and under are kelvin beyond the",
        "temperatures given (aim: < 0.1 K); steps are taken / rejected / repeated with monotone cells; iterations are the",
        "flow's of Newton's method, of which continuation counts those of false transients; s is CPU time, compilation included.",
    )
    page.head(
        *("row", "case", "ended", "heating time, s", "steps", "iterations", "continuation", "over", "under"),
        *("imbalance", "s", "warnings or reason"),
    )
    bad = count = 0
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for row, name, path, settings in cases(Path(folder)):
            cells, good, counts = told(path, settings)
            found.append(counts)
            bad, count = bad + (not good), count + 1
            page.row(row, name, *cells)
    page.add("", f"{count} cases, {bad} failed or beyond 0.1 K or 1e-3 of the heat.")
    page.add("", *strategies(found))
    page.write(out)


if __name__ == "__main__":
    main()
