"""Results of a simulation: the content of result.json, and its warnings."""

import platform
from collections.abc import Mapping
from datetime import datetime
from typing import Any

import dolfinx
import numpy as np
from petsc4py import PETSc

from .. import __version__
from ..errors import SolveError
from ..laws.natural_convection import ONSET, carried_from_below, carried_from_the_side
from ..laws.phases import LARGEST_DEPARTURE, departure, other_phase
from ..laws.real_gas import RealGasDensity
from ..output.quantities import JOULES_A_KWH
from ..scene.closures import departures
from ..scene.features.targets import series_of
from ..scene.features.wall import RESERVED_PLACES
from ..scene.scene import Scene
from .accuracy import AT_END, PEAKS, refinements_of
from .cycles import SURROUNDINGS, cycles_of
from .end_warnings import of_heat_from_elsewhere, of_phases_over_at_once, of_the_corner, why_not_heated
from .energy_use import energy_use
from .estimates import rayleigh_darcy
from .march import Simulation
from .scene_warnings import first_cell, warnings_of_the_first_cell, warnings_of_the_scene
from .specs import Specs
from .step_rules import given_bounds, is_open
from .unmet_targets import kept_targets, why_not_met

HIGHEST_MACH_NUMBER = 0.3
LARGEST_PRESSURE_ERROR = 5e-3
"""Of a given pressure drop, up to which that of the flow may differ without a word."""
LARGEST_EXPANSION = 8.0
"""Density at the inlet over that at the outlet pressure, beyond which the pressure drop was off by half a per cent and more on
default cells (plug flow of air, against the exact isothermal one: 0.38 % at 8, 0.67 % at 12, 2.2 % at 23)."""
LARGEST_OVERSHOOT = 0.1
LARGEST_UNDERSHOOT = 0.05
LEAST_SURPLUS = 0.02
"""Of the heat that a cycle took, which it may give beyond that without a word."""
LARGEST_IMBALANCE = 1e-3
"""Of the heat put in, above which the balance is warned of."""
SPENT = ("fluid_heat", "pumping_work", "energy_spent", "mean_power")


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
    cycles = _cycles(simulation)
    return {
        "status": "failed" if failure else "interrupted" if interrupted else "done",
        "failure": str(failure) if failure else None,
        "heating_time": recorder.heating_time,
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
        "pressure_drop_initial": history["pressure_drop"][0] if recorded else None,
        "pressure_drop_final": history["pressure_drop"][-1] if recorded else None,
        "mass_imbalance": problem.balances.mass_imbalance if recorded else None,
        "energy_imbalance": _imbalance(simulation),
        "energy_rev_residual": balance.by_rev_terms / balance.by_fluid if balance.by_fluid else 0.0,
        "heat_by_fluid": balance.by_fluid,
        "heat_stored": balance.stored,
        **_spent(simulation),
        **cycles,
        "energy": _energy_of_the_tool(simulation) | {"currency": scene.operation.currency}
        if recorded and problem.air_loop is not None
        else None,
        "spread_at_end": _spread_at_end(simulation) if recorded else None,
        "layers_at_end": _layers_at_end(simulation) if recorded else {},
        "temperature_bounds": bounds,
        **_work_done(simulation),
        **_provenance(scene, simulation),
        "warnings": warnings_of(scene, simulation, bounds)
        + _gave_more_than_it_took(cycles["last_cycle"])
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
    warm = [float(value) for phase in course.phases for value in phase.temperature.values]
    ambient = specs.heat.outer_wall.ambient
    given = {
        "outlet_pressure": specs.flow.outlet_pressure,
        "surroundings": SURROUNDINGS if ambient is None else float(ambient(0.0)),
        "length": problem.domain.length,
        "storable": problem.storable(min(warm), max(warm)),
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


def _spent(simulation: Simulation) -> dict[str, float | None]:
    """Heat, work and mean power; None of a run that has not begun."""
    recorder, problem, specs = simulation.recorder, simulation.problem, simulation.specs
    spent: dict[str, float | None] = dict.fromkeys(SPENT)
    if not len(recorder.history):
        return spent
    spent |= energy_use(
        recorder.history,
        specs.laws.fluid,
        outlet_pressure=specs.flow.outlet_pressure,
        initial_temperature=specs.heat.initial_temperature,
        heating_time=recorder.heating_time,
    )
    if problem.air_loop is not None:
        spent |= _spent_by_the_supply(simulation, spent["pumping_work"])
    return spent


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
        "given": scene.given(),
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


def _imbalance(simulation: Simulation) -> float:
    """Of the heat, as a fraction of the largest that was moved, set free or stored (collective)."""
    problem, history = simulation.problem, simulation.recorder.history
    set_free = problem.heat_kept()["cure"] if problem.heat.curing else 0.0
    stored = float(np.max(np.abs(history["heat_stored"]))) if len(history) else 0.0
    return problem.heat.balance.imbalance_beside(max(abs(set_free), stored))


def _spent_by_the_supply(simulation: Simulation, ideal_work: float | None) -> dict[str, float]:
    """What heater and blower gave what is computed until the answer, or the end of the run; of a given pressure drop the ideal
    work."""
    air_loop, ended_at = simulation.problem.air_loop, simulation.recorder.ended_at
    assert air_loop is not None
    given = {name: value / air_loop.spec.share for name, value in _tool_energy(simulation).items()}
    work = given["blower"] if air_loop.spec.blower is not None else float(ideal_work or 0.0)
    spent = given["heater"] + work
    return {
        "fluid_heat": given["heater"],
        "pumping_work": work,
        "energy_spent": spent,
        "mean_power": spent / ended_at if ended_at > 0.0 else 0.0,
    }


def _tool_energy(simulation: Simulation) -> dict[str, float]:
    """Energies (J) of the whole tool by source and use up to the answer (collective)."""
    recorder = simulation.recorder
    assert recorder.tool_energy is not None
    if len(recorder.history) < 2:
        return recorder.tool_energy.until(1.0)
    begun, end = recorder.history["time"][-2:]
    return recorder.tool_energy.until((recorder.ended_at - begun) / (end - begun) if end > begun else 1.0)


def _energy_of_the_tool(simulation: Simulation) -> dict[str, Any]:
    """What heater and blower gave to the whole tool up to the answer and where it went (J), the largest power (W), and the
    cost (collective)."""
    problem, history = simulation.problem, simulation.recorder.history
    assert problem.air_loop is not None
    energy: dict[str, Any] = dict(_tool_energy(simulation))
    spec, spent = problem.air_loop.spec, energy["heater"] + energy["blower"]
    powers = np.array(history["heater_power"]) + np.array(history["blower_power"])
    energy |= {
        "peak_power": float(np.max(powers)),
        "until": simulation.recorder.ended_at if len(history) else 0.0,
        "share": spec.share,
        "loop_imbalance": problem.heat.balance.loop_imbalance,
        "spent": spent,
        "cost": None if spec.price is None else spec.price * spent / JOULES_A_KWH,
    }
    return energy


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
    """Warnings of a run: limits of the model that it exceeds (collective)."""
    specs, medium = simulation.specs, simulation.problem.medium
    found = (
        _of_the_outcome(simulation)
        + warnings_of_the_scene(scene, specs, medium.estimates, medium.size)
        + _of_late_series(scene, simulation.time)
    )
    found += warnings_of_the_first_cell(specs, medium.estimates, first_cell(medium.domain))
    if bounds is not None:
        return found + _of_what_was_reached(simulation, bounds)
    return found + outside_ranges(simulation.specs, simulation.problem.has_wall, {})


def _of_late_series(scene: Scene, end: float) -> list[str]:
    """Of series that had not begun when the run ended."""
    return [
        f"{name} begins at {series.times[0]:g} s, after the run's end: it was its first value all the time"
        for name, series in series_of(scene).items()
        if len(series.times) > 1 and series.times[0] >= end
    ]


def outside_ranges(specs: Specs, has_wall: bool, reached: Mapping[str, tuple[float, float]]) -> list[str]:
    """A sentence for every property that was used outside the temperatures (K) that it is given for: `reached` by each material,
    where nothing is known of it initial and inlet temperatures."""
    given = [*specs.heat.first_temperatures, *specs.heat.inlet_temperature.range]
    found = []
    for use, material in specs.laws.materials(has_wall).items():
        low, high = reached.get(use, (min(given), max(given)))
        for name, law in material.laws().items():
            first, last = law.temperature_range
            if low < first - LARGEST_OVERSHOOT or high > last + LARGEST_OVERSHOOT:
                known, used = (f"{a - 273.15:.1f} to {b - 273.15:.1f} °C" for a, b in ((first, last), (low, high)))
                found.append(f"{material.name} {name} is given for {known}, used for {used}")
    return found + _of_the_phase(specs, reached.get("fluid", (min(given), max(given))))


def _of_the_phase(specs: Specs, temperatures: tuple[float, float]) -> list[str]:
    """Of a fluid that is no ideal gas, or of another phase, at these temperatures (K)."""
    name, pressure = specs.laws.fluid.name, specs.flow.outlet_pressure
    highest = pressure + (specs.flow.driven_by.range[1] if specs.flow.drive == "pressure_drop" else 0.0)
    found = [text for one in temperatures if (text := other_phase(name, pressure, one)) is not None]
    largest, where = max(((departure(name, highest, one), one) for one in temperatures), key=lambda pair: abs(pair[0]))
    if not found and not isinstance(specs.laws.fluid.density, RealGasDensity) and abs(largest) > LARGEST_DEPARTURE:
        more = "more" if largest < 0.0 else "less"
        state = f"{highest / 1e5:.4g} bar and {where - 273.15:.1f} °C"
        found.append(
            f"{name} is no ideal gas at {state}: its density is about {abs(largest):.1%} {more} (Peng-Robinson); "
            "fluid.real_gas"
        )
    return found


def _reached_by_materials(simulation: Simulation) -> dict[str, tuple[float, float]]:
    """Lowest and highest temperature (K) of every material."""
    history = simulation.recorder.history

    def of(place: str) -> tuple[float, float]:
        return min(history[f"lowest_{place}"]), max(history[f"highest_{place}"])

    uses = simulation.specs.laws.materials(simulation.problem.has_wall)
    layers = {use: use if f"lowest_{use}" in history else "wall" for use in uses}
    return {use: of("bed" if use in ("fluid", "beads") else place) for use, place in layers.items()}


def _gave_more_than_it_took(cycle: Mapping[str, Any] | None) -> list[str]:
    """Of a last cycle that lives on what was stored before it."""
    efficiency = None if cycle is None else cycle["energy_efficiency"]
    if efficiency is None or efficiency <= 1.0 + LEAST_SURPLUS:
        return []
    return [
        f"the last cycle gave {efficiency:.0%} of the heat that it took: it empties what was stored before, and its efficiencies "
        "are not those of a store that repeats itself (operation.cycles, operation.cycle_tolerance)"
    ]


def _of_the_outcome(simulation: Simulation) -> list[str]:
    time, found = simulation.specs.time, []
    at_end, steady = simulation.time >= time.end_time * (1 - 1e-9), simulation.ending.is_steady(simulation.time)
    course = simulation.specs.course
    waiting = simulation.recorder.heating_time is None and simulation.specs.waits_for_heat
    if course is not None and course.repeats:
        if not course.is_over and course.has_waited(simulation.time):
            waited = simulation.time - course.begun
            found.append(f"phase {course.phase.name!r} waits for a temperature that had not come after {waited:.3g} s")
        elif not course.is_over and at_end:
            found.append(
                f"operation.end_time {time.end_time:g} s came in phase {course.phase.name!r}, which had not ended"
            )
        elif course.tolerance is not None and not course.is_periodic:
            found.append(f"the state is not periodic within operation.cycle_tolerance after {course.cycles} cycles")
    if waiting and (at_end or steady) and not time.targets:
        found.append(why_not_heated(simulation))
    if simulation.specs.heat.is_wall_held and time.heated.place != "bed" and not (time.targets or course):
        found.append(
            "there is no heating time: the wall is held at operation.wall_temperature; operation.heated_place = 'bed' or a "
            "[[target]] asks for one of the bed"
        )
    found += of_heat_from_elsewhere(simulation) + of_the_corner(simulation)
    kept = kept_targets(simulation)
    is_unmet = None in simulation.recorder.targets.values() and (at_end or steady)
    energy = _energy_of_the_tool(simulation) if is_unmet and simulation.problem.air_loop is not None else None
    for target in time.targets:
        if simulation.recorder.targets[target.name] is None and (at_end or steady):
            by = (
                f"by operation.end_time {time.end_time:g} s"
                if at_end
                else f"in the steady state at {simulation.time:.4g} s"
            )
            if course is not None and course.is_over:
                by = f"when the phases were through, at {simulation.time:.6g} s"
            why = why_not_met(simulation, target, energy)
            found.append(f"target {target.name!r} not met {by}{f': {why}' if why else ''}")
        elif target.name in kept and kept[target.name]["kept_from"] is None:
            met, lost = kept[target.name]["met"], kept[target.name]["lost"]
            off = target.quantity(simulation.recorder.history, len(simulation.recorder.history) - 1) - target.margin
            found.append(
                f"target {target.name!r} was met at {met:.0f} s and lost at {lost:.0f} s: at the end it is off by {off:.3g} "
                f"{'' if target.asks == 'cured' else 'K'} (target.keep = true waits until it holds)".replace("  ", " ")
            )
    imbalance = _imbalance(simulation)
    if abs(imbalance) > LARGEST_IMBALANCE:
        found.append(
            f"the heat balance is off by {imbalance:.1%}: heat and temperatures are less accurate (finer cells and steps)"
        )
    undershoot = simulation.problem.flow.counts.largest_undershoot
    if undershoot > LARGEST_UNDERSHOOT:
        found.append(f"k undershoots by {undershoot:.0%} of its largest value in single cells, where it counts as 0")
    if simulation.regimes.is_also_laminar:
        found.append(
            "with these settings a laminar flow is steady, too; the turbulent solution is used, as for a tripped flow"
        )
    return found


def _of_rest(simulation: Simulation, bounds: list[float]) -> list[str]:
    """What natural convection would carry where the bed rests: the equations have none."""
    specs, size, course = simulation.specs, simulation.specs.mesh.size, simulation.specs.course
    strength = specs.flow.driven_by.range[0] if course is None else min(abs(phase.sign) for phase in course.phases)
    if size is None or (simulation.problem.medium.estimates.flows and strength > 0.0 and not specs.flow.by_blower):
        return []
    if specs.flow.by_blower and course is None:
        return []
    low, high = bounds
    upright = rayleigh_darcy(specs, low, high, size.length)
    if upright <= ONSET:
        return []
    across = carried_from_the_side(upright, 0.5 * size.length / size.half_height)
    return [
        "natural convection in the bed at rest is left out: its Rayleigh-Darcy number is up to "
        f"{upright:.2g} over its length; upright and hot below it would carry about {carried_from_below(upright):.2g} times what "
        f"conducts along it (onset at {ONSET:.0f}), hot at a side {across:.2g} times what conducts across it"
    ]


def _of_the_beads_weight(simulation: Simulation) -> list[str]:
    """Whether a flow against gravity would lift the beads: its pressure drop beyond the fluid's own weight carries them."""
    specs, history = simulation.specs, simulation.recorder.history
    if specs.flow.gravity >= 0.0:
        return []
    temperature = specs.heat.inlet_temperature.values[-1]
    density = specs.laws.fluid.density(specs.flow.outlet_pressure, temperature)
    heavier = specs.laws.beads.density(temperature) - density
    weight = (1.0 - specs.porosity.bulk_porosity) * heavier * -specs.flow.gravity * simulation.problem.domain.length
    drop = max(history["pressure_drop"]) + density * specs.flow.gravity * simulation.problem.domain.length
    if drop <= weight:
        return []
    return [
        f"the upward flow fluidises the beads: its pressure drop of {drop:.4g} Pa exceeds their weight, {weight:.4g} Pa "
        "(see 'porousmold fluidised')"
    ]


def _beyond_what_can_be(simulation: Simulation) -> tuple[float, float]:
    """By how much (K) temperatures anywhere, and those of the bed, were beyond what can be: what is given, and beside a wall that
    gets hotter or colder by itself, which has no bound, what the wall had been until then."""
    history, heat = simulation.recorder.history, simulation.specs.heat
    lowest, highest = given_bounds(heat)
    warm = np.maximum(
        highest, np.maximum.accumulate(history["inlet_temperature"])
    )  # air may come back warmer than its set-point
    cold, (colder, hotter) = np.full_like(warm, lowest), is_open(heat)
    in_wall = []
    if hotter:
        warm = np.maximum(warm, np.maximum.accumulate(history["highest_wall"]))
    else:
        in_wall.append(np.max(np.array(history["highest_wall"]) - warm))
    if colder:
        cold = np.minimum(cold, np.minimum.accumulate(history["lowest_wall"]))
    else:
        in_wall.append(np.max(cold - np.array(history["lowest_wall"])))
    in_bed = max(np.max(np.array(history["highest_bed"]) - warm), np.max(cold - np.array(history["lowest_bed"])))
    return float(max([in_bed, *in_wall])), float(in_bed)


def _of_the_openings(simulation: Simulation) -> list[str]:
    """Of a mesh of one's own whose cells at the ends of an opening are too coarse for the pressure that is given there."""
    flow, history = simulation.specs.flow, simulation.recorder.history
    if simulation.specs.mesh.own.mesh is None or flow.drive != "pressure_drop" or flow.by_blower:
        return []
    given, found = abs(float(flow.driven_by(history["time"][-1]))), abs(history["pressure_drop"][-1])
    if not given or abs(found / given - 1.0) < LARGEST_PRESSURE_ERROR:
        return []
    return [
        f"the mean pressures at the openings differ by {found:.4g} Pa where {given:.4g} Pa are given: cells are too coarse "
        "there, and mass flow and times off by some part of that (solver.mesh_refinement, or a finer mesh)"
    ]


def _of_the_expansion(simulation: Simulation) -> list[str]:
    """Of a gas that expands so much along the bed that most of its pressure drop lies in the last cells."""
    outlet, history = simulation.specs.flow.outlet_pressure, simulation.recorder.history
    drop, warm = max(abs(one) for one in history["pressure_drop"]), history["inlet_temperature"][-1]
    thin, dense = (float(simulation.specs.laws.fluid.density(pressure, warm)) for pressure in (outlet, outlet + drop))
    if dense <= LARGEST_EXPANSION * thin:
        return []
    return [
        f"the gas expands {dense / thin:.3g}-fold, most of that within the last cells: pressure drop, mass flow and times may be "
        "off by a per cent and more (solver.axial_cells)"
    ]


def _of_what_was_reached(simulation: Simulation, bounds: list[float]) -> list[str]:
    problem, found = simulation.problem, _of_the_beads_weight(simulation) + _of_rest(simulation, bounds)
    mach = problem.highest_mach_number()
    if mach > HIGHEST_MACH_NUMBER:
        found.append(f"Mach number {mach:.2g} > {HIGHEST_MACH_NUMBER}: the energy balance is that of low Mach numbers")
    found += _of_the_expansion(simulation) + _of_the_openings(simulation)
    found += outside_ranges(simulation.specs, problem.has_wall, _reached_by_materials(simulation))
    beyond, in_bed = _beyond_what_can_be(simulation)
    if beyond > LARGEST_OVERSHOOT:
        if in_bed < LARGEST_OVERSHOOT:
            remedy = "in the wall, where heat has entered less than a cell: solver.mesh_refinement lessens"
        elif simulation.specs.mesh.own.mesh is None:
            remedy = "behind the sharp first front: more solver.axial_cells lessen"
        else:
            remedy = "behind the sharp first front: a finer mesh along the flow lessens"
        found.append(f"temperatures reached {beyond:.2g} K beyond those given, {remedy} it")
    return found
