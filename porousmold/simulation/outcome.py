"""Results of a simulation: the content of result.json."""

import platform
from collections.abc import Mapping
from datetime import datetime
from typing import Any

import dolfinx
import numpy as np
from petsc4py import PETSc

from .. import __version__
from ..errors import SolveError
from ..scene.closures import departures
from ..scene.features.wall import RESERVED_PLACES
from ..scene.scene import Scene
from .accuracy import AT_END, PEAKS, refinements_of
from .cycles import LEAST_DIFFERENCE, SURROUNDINGS, cycles_of, extremes
from .end_warnings import of_phases_over_at_once
from .energy_of_run import energy_of_the_tool, imbalance_of, spent_of
from .flow_error import mass_flow_error, of_coarse_cells
from .run_warnings import of_a_store_that_empties, warnings_of
from .specs import Specs
from .time_integration import Simulation
from .unmet_targets import kept_targets


def summarise(
    scene: Scene,
    simulation: Simulation,
    errors: Mapping[str, float] | None = None,
    failure: SolveError | None = None,
    *,
    interrupted: bool = False,
) -> dict[str, Any]:
    """The content of result.json (a collective call), all but the seconds."""
    problem, recorder, specs = simulation.problem, simulation.recorder, simulation.specs
    history, balance = recorder.history, problem.heat.balance
    recorded = len(history) > 0
    bounds = [min(history["lowest_temperature"]), max(history["highest_temperature"])] if recorded else None
    cycles, flow_error = _cycles(simulation), mass_flow_error(simulation) if recorded else None
    return {
        "status": "failed" if failure else "interrupted" if interrupted else "done",
        "failure": str(failure) if failure else None,
        "heating_time": recorder.heating_time,
        "has_heating_time": specs.waits_for_heat,
        "heating_time_error": None if errors is None else errors.get("heating_time"),
        "target_errors": _part(errors, "targets."),
        "peak_errors": _part(errors, PEAKS),
        "end_errors": _part(errors, AT_END),
        "heating_time_bed_side": recorder.heating_time_bed_side,
        "targets": recorder.targets,
        "targets_kept": kept_targets(simulation),
        "target_meanings": {target.name: target.meaning for target in specs.time.targets},
        "end_time": simulation.time,
        "mass_flow_initial": history["mass_flow"][0] if recorded else None,
        "mass_flow_final": history["mass_flow"][-1] if recorded else None,
        "mass_flow_error": flow_error,
        "pressure_drop_initial": history["pressure_drop"][0] if recorded else None,
        "pressure_drop_final": history["pressure_drop"][-1] if recorded else None,
        "mass_imbalance": problem.balances.mass_imbalance if recorded else None,
        "energy_imbalance": imbalance_of(simulation),
        "energy_rev_residual": balance.by_rev_terms / balance.by_fluid if balance.by_fluid else 0.0,
        "heat_by_fluid": balance.by_fluid,
        "heat_stored": balance.stored,
        **spent_of(simulation),
        **cycles,
        "energy": energy_of_the_tool(simulation) | {"currency": scene.operation.currency}
        if recorded and problem.air_loop is not None
        else None,
        "spread_at_end": _spread_at_end(simulation) if recorded else None,
        "layers_at_end": _layers_at_end(simulation) if recorded else {},
        "temperature_bounds": bounds,
        **_work_done(simulation),
        **_provenance(scene, simulation),
        "warnings": warnings_of(scene, simulation, bounds)
        + of_coarse_cells(simulation, flow_error)
        + of_a_store_that_empties(cycles["last_cycle"])
        + of_phases_over_at_once(simulation),
    }


def _spread_at_end(simulation: Simulation) -> float:
    """Spread (K) of the wall's bed side when the last of what was asked for was met, or at the end.

    Within the last step it falls as the heating time has it, exponentially.
    """
    recorder, history = simulation.recorder, simulation.recorder.history
    met = [time for time in (recorder.heating_time, *recorder.targets.values()) if time is not None]
    begun = history["time"][-2] if len(history) > 1 else 0.0
    end = max(met) if met and max(met) > begun else simulation.time
    spreads = np.subtract(history["highest_bed_side"][-2:], history["lowest_bed_side"][-2:])
    if spreads.min() <= 0.0:
        return float(np.interp(end, history["time"][-2:], spreads))
    return float(np.exp(np.interp(end, history["time"][-2:], np.log(spreads))))


def _cycles(simulation: Simulation) -> dict[str, Any]:
    """What phases gave and took, the last whole cycle once more without them, and whether it repeats itself (collective)."""
    course, recorder, problem, specs = (
        simulation.specs.course,
        simulation.recorder,
        simulation.problem,
        simulation.specs,
    )
    if course is None or not course.repeats or not len(recorder.history):
        return {"cycles": [], "last_cycle": None}
    low, high = extremes(course, recorder.history)
    ambient = specs.heat.outer_wall.ambient
    given = {
        "outlet_pressure": specs.flow.outlet_pressure,
        "surroundings": SURROUNDINGS if ambient is None else float(ambient(0.0)),
        "length": problem.domain.length,
        "storable": problem.storable(low, high) if high - low > LEAST_DIFFERENCE else 0.0,
    }
    cycles = cycles_of(recorder.history, course, recorder.snapshots.profiles, specs.laws.fluid, given)
    last = {name: value for name, value in cycles[-1].items() if name != "phases"} if cycles else None
    periodic = None if course.tolerance is None else course.is_periodic
    return {"cycles": cycles, "last_cycle": last and last | {"is_periodic": periodic}}


def _layers_at_end(simulation: Simulation) -> dict[str, list[float]]:
    """Lowest and highest temperature (K) of every layer that has a name of its own."""
    history = simulation.recorder.history
    names = [name for name in simulation.problem.places.names if name not in RESERVED_PLACES]
    return {name: [history[f"lowest_{name}"][-1], history[f"highest_{name}"][-1]] for name in names}


def _part(errors: Mapping[str, float] | None, prefix: str) -> dict[str, float]:
    """The errors of the answers whose names begin with `prefix`, without that."""
    return {name.removeprefix(prefix): error for name, error in (errors or {}).items() if name.startswith(prefix)}


def _work_done(simulation: Simulation) -> dict[str, Any]:
    """Steps, iterations and unknowns."""
    problem, flow, heat = simulation.problem, simulation.problem.flow, simulation.problem.heat
    return {
        "time_steps": max(len(simulation.recorder.history) - 1, 0),
        "rejected_steps": simulation.control.rejected,
        "repeated_steps": heat.repetitions,
        "flow_regimes": simulation.regimes.seen,
        "flow_solves": flow.counts.solves,
        "flow_strategies": flow.counts.strategies,
        "continuation_steps": flow.counts.continuation_steps,
        "newton_iterations": {"flow": flow.counts.newton_iterations, "energy": heat.newton_iterations},
        "unknowns": problem.unknowns,
    }


def _provenance(scene: Scene, simulation: Simulation) -> dict[str, Any]:
    """What the scene gave, models, sources and versions."""
    problem, specs, estimates = simulation.problem, simulation.specs, simulation.problem.medium.estimates
    return {
        "bead_biot_number": estimates.bead_biot_number,
        "bead_reynolds_number": estimates.reynolds_number,
        "refinements": refinements_of(scene)._asdict(),
        "date": datetime.now().astimezone().isoformat(timespec="seconds"),
        "model": scene.as_tables()["model"],
        "closures": {"set": scene.model.closures, "departures": departures(scene)},
        "sources": specs.laws.sources(specs.heat.model.bead_modes is not None),
        "materials": materials_used(specs, has_wall=problem.has_wall),
        "versions": versions(problem.communicator.size),
    }


def materials_used(specs: Specs, *, has_wall: bool) -> dict[str, Any]:
    """By what it is the material of: its name, and each property's value at the mean of initial and inlet temperature, unit and
    source."""
    temperature = 0.5 * (specs.heat.initial_temperature + specs.heat.inlet_temperature.values[-1])
    found = {}
    for owner, material in specs.laws.materials(has_wall).items():
        properties = {}
        for name, law in material.laws().items():
            arguments = (specs.flow.outlet_pressure,) if owner == "fluid" and name == "density" else ()
            value = float(law(*arguments, temperature))
            properties[name] = {"value": value, "unit": law.unit, "source": law.source}
        found[owner] = {"material": material.name, "temperature": temperature, "properties": properties}
    return found


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
