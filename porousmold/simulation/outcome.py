"""What came of a simulation: the content of result.json, and everything that its reader should know."""

import platform
from typing import Any

import dolfinx
import numpy as np
from petsc4py import PETSc

from .. import __version__
from ..errors import SolveError
from ..laws.porosity import LawPorosity, benyahia_oneill_mean_porosity, dixon_mean_porosity, mean_porosity
from ..scene.checks import SMALLEST_RATIO
from ..scene.chosen_laws import width_ratio
from ..scene.closures import departures
from ..scene.scene import Scene
from .energy_use import energy_use
from .march import Simulation, temperature_bounds

HIGHEST_MACH_NUMBER = 0.3
HIGHEST_BIOT_NUMBER = 0.1
LARGEST_OVERSHOOT = 0.1
LARGEST_POROSITY_ERROR = 0.02
HIGHEST_BEAD_CONDUCTION = 2.0
"""Of the beads, over what measurements give for the whole bed across the flow. Up to twice that, bulk conduction stands for the
dispersion that the thesis leaves out (ceramic beads in air: 1 to 1.5); beyond, nothing makes up for it."""
LARGEST_UNDERSHOOT = 0.05
SPENT = ("fluid_heat", "pumping_work", "energy_spent", "mean_power")


def summarise(
    scene: Scene,
    simulation: Simulation,
    heating_time_error: float | None = None,
    failure: SolveError | None = None,
    *,
    interrupted: bool = False,
) -> dict[str, Any]:
    """The content of result.json (a collective call), all but the seconds."""
    problem, recorder, specs = simulation.problem, simulation.recorder, simulation.specs
    history, flow, heat, estimates = recorder.history, problem.flow, problem.heat, problem.medium.estimates
    balance, recorded = heat.balance, len(history) > 0
    bounds = [min(history["lowest_temperature"]), max(history["highest_temperature"])] if recorded else None
    spent: dict[str, float | None] = dict.fromkeys(SPENT)
    if recorded:
        spent |= energy_use(
            history,
            specs.laws.fluid,
            outlet_pressure=specs.flow.outlet_pressure,
            initial_temperature=specs.heat.initial_temperature,
            heating_time=recorder.heating_time,
        )
    return {
        "status": "failed" if failure else "interrupted" if interrupted else "done",
        "failure": str(failure) if failure else None,
        "heating_time": recorder.heating_time,
        "heating_time_error": heating_time_error,
        "heating_time_bed_side": recorder.heating_time_bed_side,
        "end_time": simulation.time,
        "mass_flow_initial": history["mass_flow"][0] if recorded else None,
        "mass_flow_final": history["mass_flow"][-1] if recorded else None,
        "mass_imbalance": problem.balances.mass_imbalance if recorded else None,
        "energy_imbalance": balance.imbalance,
        "energy_rev_residual": balance.by_rev_terms / balance.by_fluid if balance.by_fluid else 0.0,
        "heat_by_fluid": balance.by_fluid,
        "heat_stored": balance.stored,
        **spent,
        "temperature_bounds": bounds,
        "time_steps": len(history) - 1 if recorded else 0,
        "rejected_steps": simulation.control.rejected,
        "repeated_steps": heat.repetitions,
        "flow_regimes": simulation.regimes,
        "flow_solves": flow.solves,
        "continuation_steps": flow.continuation_steps,
        "newton_iterations": {"flow": flow.newton_iterations, "energy": heat.newton_iterations},
        "unknowns": problem.unknowns,
        "bead_biot_number": estimates.bead_biot_number,
        "bead_reynolds_number": estimates.reynolds_number,
        "model": scene.as_tables()["model"],
        "closures": {"set": scene.model.closures, "departures": departures(scene)},
        "sources": specs.laws.sources(problem.has_wall, specs.heat.bead_modes is not None),
        "versions": versions(problem.communicator.size),
        "warnings": warnings_of(scene, simulation, bounds),
    }


def versions(ranks: int) -> dict[str, Any]:
    """Of everything that computes."""
    return {
        "porousmold": __version__,
        "dolfinx": dolfinx.__version__,
        "petsc": ".".join(map(str, PETSc.Sys.getVersion())),
        "numpy": np.__version__,
        "python": platform.python_version(),
        "ranks": ranks,
    }


def warnings_of(scene: Scene, simulation: Simulation, bounds: list[float] | None) -> list[str]:
    """Limits of the model that this run touched (collective)."""
    found = _of_the_outcome(simulation) + _of_the_scene(scene, simulation)
    return found + (_of_what_was_reached(simulation, bounds) if bounds is not None else [])


def _of_the_outcome(simulation: Simulation) -> list[str]:
    time, found = simulation.specs.time, []
    waiting = simulation.recorder.heating_time is None and simulation.specs.heat.wall != "fixed-temperature"
    if waiting and simulation.time >= time.end_time * (1 - 1e-9):
        found.append(f"not heated to within {time.margin:g} K by operation.end_time {time.end_time:g} s")
    undershoot = simulation.problem.flow.largest_undershoot
    if undershoot > LARGEST_UNDERSHOOT:
        found.append(f"k undershoots by {undershoot:.0%} of its largest value in single cells, where it counts as 0")
    if len(simulation.regimes) > 1:
        found.append(
            "with these settings a laminar flow is steady, too; this is the turbulent one (flow_regimes), as if tripped"
        )
    return found


def _of_the_scene(scene: Scene, simulation: Simulation) -> list[str]:
    specs, estimates, found = simulation.specs, simulation.problem.medium.estimates, []
    if estimates.bead_biot_number > HIGHEST_BIOT_NUMBER and specs.heat.bead_modes is None:
        found.append(
            f"bead Biot number {estimates.bead_biot_number:.2g} > {HIGHEST_BIOT_NUMBER}: "
            "beads are taken as isothermal, which they are not (see model.bead_modes)"
        )
    low, high = specs.laws.nusselt.reynolds_range
    if not low <= estimates.reynolds_number <= high:
        found.append(
            f"bead Reynolds number {estimates.reynolds_number:.3g} is outside {low:g} to {high:g}, "
            f"the range of model.nusselt {scene.model.nusselt!r}"
        )
    if specs.flow.kind == "plug" and scene.model.turbulence != "none":
        found.append("plug flow carries no turbulence: model.turbulence has no effect")
    if estimates.conduction_ratio > HIGHEST_BEAD_CONDUCTION:
        found.append(
            f"the beads conduct {estimates.conduction_ratio:.2g} times as much as measurements give for the whole bed: "
            "heat spreads too far (see model.closures 'measured', or model.bead_conduction)"
        )
    for name in ("emissivity", "contact_flattening"):
        if not specs.laws.bead_conduction.whole_bed and getattr(scene.bed, name):
            law = scene.model.bead_conduction
            found.append(f"bed.{name} has no effect beside model.bead_conduction {law!r}")
    found += _of_the_porosity(scene, simulation)
    if specs.mesh.is_too_narrow:
        found.append(
            f"the bed is {specs.mesh.beads_across:.1f} beads wide, below {SMALLEST_RATIO:g}: "
            "averages over a packing lose their meaning there"
        )
    return found


def _of_the_porosity(scene: Scene, simulation: Simulation) -> list[str]:
    """Whether spheres pour like that, of a law in a tube or a gap; a profile from a file is the user's own."""
    specs = simulation.specs
    size, diameter = simulation.problem.medium.size, specs.mesh.bead_diameter
    if not isinstance(specs.porosity, LawPorosity) or specs.mesh.size is None or size.half_width is not None:
        return []
    mean = mean_porosity(specs.porosity, diameter, size.half_height, axisymmetric=size.axisymmetric)
    measured = [correlation(width_ratio(scene)) for correlation in (dixon_mean_porosity, benyahia_oneill_mean_porosity)]
    if min(abs(mean - other) for other in measured) <= LARGEST_POROSITY_ERROR:
        return []
    return [
        f"the mean porosity {mean:.3f} is not that of poured spheres, {min(measured):.3f} to {max(measured):.3f} at this width "
        "(Dixon; Benyahia, O'Neill): see bed.bulk_porosity"
    ]


def _of_what_was_reached(simulation: Simulation, bounds: list[float]) -> list[str]:
    problem, found = simulation.problem, []
    mach = problem.highest_mach_number()
    if mach > HIGHEST_MACH_NUMBER:
        found.append(f"Mach number {mach:.2g} > {HIGHEST_MACH_NUMBER}: the energy balance is that of low Mach numbers")
    for owner, law_name, law in simulation.specs.laws.properties(problem.has_wall):
        first, last = law.temperature_range
        if bounds[0] < first or bounds[1] > last:
            found.append(
                f"{owner} {law_name} is given for {first:g} to {last:g} K, used for {bounds[0]:.4g} to {bounds[1]:.4g} K"
            )
    lowest, highest = temperature_bounds(simulation.specs.heat)
    beyond = max(lowest - bounds[0], bounds[1] - highest)
    if beyond > LARGEST_OVERSHOOT:
        found.append(
            f"temperatures reached {beyond:.2g} K beyond those given, behind the sharp first front: "
            "more solver.axial_cells lessen it"
        )
    return found
