"""Warnings about a run that has ended: what it left out, what it was not made for, and what may be off."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..laws.materials import beyond_ranges
from ..laws.natural_convection import ONSET, carried_from_below, carried_from_the_side
from ..laws.phases import LARGEST_DEPARTURE, departure, other_phase
from ..laws.real_gas import RealGasDensity, density_error
from ..scene.features.targets import series_of
from ..scene.scene import Scene
from .end_warnings import (
    of_a_flow_to_and_fro,
    of_an_earlier_set_point,
    of_heat_from_elsewhere,
    of_no_heating_time,
    of_the_corner,
    why_not_heated,
)
from .energy_of_run import energy_of_the_tool, imbalance_of
from .estimates import rayleigh_darcy
from .scene_warnings import (
    first_cell,
    of_a_narrow_bed,
    of_a_thin_core,
    warnings_of_the_first_cell,
    warnings_of_the_scene,
)
from .snapshots import SAME_TIME
from .specs import Specs
from .time_integration import Simulation
from .unmet_targets import kept_targets, of_narrow_margins, why_not_met

HIGHEST_MACH_NUMBER = 0.3
CHOKED = 0.85
"""Mach number at which a flow with friction and the temperature of its bed chokes: 1/sqrt(gamma), of air (Shapiro, ch. 6)."""
LARGEST_PRESSURE_ERROR = 5e-3
"""Of a given pressure drop, up to which that of the flow may differ without a word."""
LARGEST_EXPANSION = 5.0
"""Density at the inlet over that at the outlet pressure, beyond which full flow and that of local profiles were off by a third of
a per cent and more on default cells (isothermal air: 0.05 % at 4, 0.34 % at 5, 0.5 % at 7.5). Flows found station by station are
within 0.01 % at 10."""
LARGEST_OVERSHOOT = 0.1
LARGEST_UNDERSHOOT = 0.05
LARGEST_DRAWN_IN = 0.01
"""Of what a fluid contracts by, which may come in at the outlet without a word."""
LEAST_SURPLUS = 0.02
"""Of the heat that a cycle took, which it may give beyond that without a word."""
LARGEST_BY_REV_TERMS = 0.01
"""Of mass flow and heat, which REV terms may make or take away without a word."""
SHORT_WHILE = 0.1
"""Part of a run in which air may be warmer than its set-point without a word: a programme begins where the blower warms it."""
LARGEST_IMBALANCE = 1e-3
"""Of the heat put in, above which the balance is warned of."""


def warnings_of(scene: Scene, simulation: Simulation, bounds: list[float] | None) -> list[str]:
    """Warnings of a run: limits of the model that it exceeds (collective)."""
    specs, medium = simulation.specs, simulation.problem.medium
    found = (
        _of_the_outcome(simulation)
        + warnings_of_the_scene(scene, specs, medium.estimates, medium.size)
        + _of_late_series(scene, simulation.time)
        + _of_late_outputs(scene, simulation.time)
    )
    found += warnings_of_the_first_cell(specs, medium.estimates, first_cell(medium.domain))
    found += of_a_thin_core(scene, medium.domain) + of_a_narrow_bed(scene, medium.domain)
    if bounds is not None:
        return found + _of_the_expansion(scene, simulation) + _of_what_was_reached(simulation, bounds)
    return found + outside_ranges(simulation.specs, simulation.problem.has_wall, {})


def _of_late_series(scene: Scene, end: float) -> list[str]:
    """Of series that had not begun when the run ended."""
    return [
        f"{name} begins at {series.times[0]:g} s, after the run's end: it was its first value all the time"
        for name, series in series_of(scene).items()
        if series.times[0] > 0.0 and series.times[0] >= end
    ]


def _of_late_outputs(scene: Scene, end: float) -> list[str]:
    """Of times of output that the run has not come to."""
    late = [time for time in scene.output.times or () if time > end * (1.0 + SAME_TIME)]
    if scene.output.every is not None and scene.output.every > end * (1.0 + SAME_TIME):
        return [f"output.every {scene.output.every:g} s is longer than the run, {end:g} s: nothing is kept"]
    if not late:
        return []
    return [f"output.times from {late[0]:g} s on are after the run's end at {end:g} s: nothing is kept of them"]


def outside_ranges(
    specs: Specs, has_wall: bool, reached: Mapping[str, tuple[float, float]], drop: float | None = None
) -> list[str]:
    """A sentence for every property that was used outside the temperatures (K) that it is given for: `reached` by each material,
    where nothing is known of it initial and inlet temperatures; and of the phase, with the largest pressure `drop` (Pa)."""
    given = [*specs.heat.first_temperatures, *specs.heat.inlet_temperature.range]
    found = []
    for use, material in specs.laws.materials(has_wall).items():
        found += beyond_ranges(material, *reached.get(use, (min(given), max(given))))
    return found + _of_the_phase(specs, reached.get("fluid", (min(given), max(given))), drop)


def _of_the_phase(specs: Specs, temperatures: tuple[float, float], drop: float | None) -> list[str]:
    """Of a fluid that is no ideal gas, or of another phase, at these temperatures (K): a liquid boils at the outlet first, a
    vapour condenses at the inlet, where it has the largest pressure `drop` (Pa) more; None where only what is given is known."""
    name, pressure = specs.laws.fluid.substance, specs.flow.outlet_pressure
    given = specs.flow.driven_by.range[1] if specs.flow.drive == "pressure_drop" else 0.0
    highest = pressure + (given if drop is None else drop)
    pressures = dict.fromkeys((pressure, highest))
    phases = (other_phase(name, at, one) for one in dict.fromkeys(temperatures) for at in pressures)
    found = [text for text in phases if text is not None][:1]
    if isinstance(specs.laws.fluid.density, RealGasDensity):
        away = max(density_error(specs.laws.fluid, highest, one) for one in temperatures)
        if away > LARGEST_DEPARTURE:
            found.append(
                f"fluid.real_gas holds the laws of {pressure / 1e5:.4g} bar, and its density is off by {away:.1%} at the inlet's "
                f"{highest / 1e5:.4g} bar: mass flow and times up to half as far"
            )
        return found
    largest, where = max(((departure(name, highest, one), one) for one in temperatures), key=lambda pair: abs(pair[0]))
    if not found and abs(largest) > LARGEST_DEPARTURE:
        more = "more" if largest < 0.0 else "less"
        state = f"{highest / 1e5:.4g} bar and {where - 273.15:.1f} °C"
        found.append(
            f"{name} is no ideal gas at {state}: its density is about {abs(largest):.1%} {more} (Peng-Robinson), heat "
            "capacity, and with it times, three to five times as far off; fluid.real_gas"
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


def of_a_store_that_empties(cycle: Mapping[str, Any] | None) -> list[str]:
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
        elif course.is_over and course.tolerance is not None and not course.is_periodic:
            found.append(f"the state is not periodic within operation.cycle_tolerance after {course.cycles} cycles")
    if waiting and (at_end or steady) and not time.targets:
        found.append(why_not_heated(simulation))
    found += of_no_heating_time(simulation.specs)
    found += of_heat_from_elsewhere(simulation) + of_the_corner(simulation)
    found += of_an_earlier_set_point(simulation) + of_a_flow_to_and_fro(simulation)
    found += of_narrow_margins(simulation)
    kept = kept_targets(simulation)
    is_through = course is not None and course.repeats and (course.is_over or course.has_waited(simulation.time))
    has_ended = at_end or steady or is_through
    is_unmet = None in simulation.recorder.targets.values() and has_ended
    energy = energy_of_the_tool(simulation) if is_unmet and simulation.problem.air_loop is not None else None
    for target in time.targets:
        if simulation.recorder.targets[target.name] is None and has_ended:
            by = (
                f"by operation.end_time {time.end_time:g} s"
                if at_end
                else f"in the steady state at {simulation.time:.4g} s"
            )
            if is_through:
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
    found += _of_rev_terms(simulation) + _of_air_too_warm(simulation)
    imbalance = imbalance_of(simulation)
    if abs(imbalance) > LARGEST_IMBALANCE:
        found.append(
            f"the heat balance is off by {imbalance:.1%}: heat and temperatures are less accurate (finer cells and steps)"
        )
    counts = simulation.problem.flow.counts
    if counts.largest_drawn_in > LARGEST_DRAWN_IN:
        found.append(
            f"the fluid contracts faster than it flows in: for a while {counts.largest_drawn_in:.0%} of that came in at the "
            "outlet, with the temperature that it found there (more flow, or slower cooling)"
        )
    undershoot = counts.largest_undershoot
    if undershoot > LARGEST_UNDERSHOOT:
        found.append(f"k undershoots by {undershoot:.0%} of its largest value in single cells, where it counts as 0")
    if simulation.regimes.is_also_laminar:
        found.append(
            "with these settings a laminar flow is steady, too; the turbulent solution is used, as for a tripped flow"
        )
    return found


def _of_rev_terms(simulation: Simulation) -> list[str]:
    """Of mass and heat that REV terms, which are no divergences, take away or make."""
    problem = simulation.problem
    balance = problem.heat.balance
    if simulation.specs.flow.averaging.terms == "off":
        return []
    parts = {
        "mass flow": -problem.balances.mass_imbalance,
        "heat": balance.by_rev_terms / max(abs(balance.by_fluid), abs(balance.stored), 1e-3),
    }
    said = [
        f"{'make' if part > 0.0 else 'take away'} {abs(part):.1%} of the {name}"
        for name, part in parts.items()
        if abs(part) > LARGEST_BY_REV_TERMS
    ]
    return [f"the REV terms, which are no divergences, {' and '.join(said)} (see docs/theory.md)"] if said else []


def _of_air_too_warm(simulation: Simulation) -> list[str]:
    """Of air that comes back warmer than its set-point for more than `SHORT_WHILE` of a run, as a heater cannot cool."""
    history, margin = simulation.recorder.history, simulation.specs.time.heated.margin
    if simulation.problem.air_loop is None or not len(history):
        return []
    beyond = np.array(history["inlet_temperature"]) - np.array(history["set_point"])
    hottest = int(np.argmax(beyond))
    steps = np.diff(history["time"], prepend=0.0)
    if steps[beyond > margin].sum() <= SHORT_WHILE * history["time"][-1]:
        return []
    return [
        f"the air entered up to {beyond[hottest]:.3g} K above its set-point, at {history['time'][hottest]:.4g} s: what returns "
        "and the blower's heat are that warm, and a heater cannot cool (less operation.recirculation)"
    ]


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
    lift = -specs.flow.gravity * float(simulation.problem.domain.from_inlet_to_outlet[0])
    weight = (1.0 - specs.porosity.bulk_porosity) * heavier * lift
    drop = max(history["pressure_drop"]) - density * lift
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
    lowest, highest = heat.given_bounds
    warm = np.maximum(
        highest, np.maximum.accumulate(history["inlet_temperature"])
    )  # air may come back warmer than its set-point
    cold, (colder, hotter) = np.full_like(warm, lowest), heat.is_open
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
        "there, and mass flow and times off with it (solver.mesh_refinement, or a finer mesh)"
    ]


def _of_the_expansion(scene: Scene, simulation: Simulation) -> list[str]:
    """Of a gas that expands so much along the bed that most of its pressure drop lies in the last cells."""
    outlet, history = simulation.specs.flow.outlet_pressure, simulation.recorder.history
    if not (scene.model.flow == "full" or scene.is_locally_developed):
        return []
    drop, warm = max(abs(one) for one in history["pressure_drop"]), history["inlet_temperature"][-1]
    thin, dense = (float(simulation.specs.laws.fluid.density(pressure, warm)) for pressure in (outlet, outlet + drop))
    if dense <= LARGEST_EXPANSION * thin:
        return []
    return [
        f"the gas expands {dense / thin:.3g}-fold, most of that within the last cells: pressure drop, mass flow and times may be "
        "off by half a per cent and more (solver.axial_cells, or a finer mesh)"
    ]


def _of_what_was_reached(simulation: Simulation, bounds: list[float]) -> list[str]:
    problem, found = simulation.problem, _of_the_beads_weight(simulation) + _of_rest(simulation, bounds)
    mach = problem.highest_mach_number()
    if mach > CHOKED:
        found.append(
            f"Mach number {mach:.2g} between the beads: a real flow is choked at about {CHOKED}, with less mass flow and a "
            "higher pressure at the outlet: mass flow and times may be off"
        )
    elif mach > HIGHEST_MACH_NUMBER:
        found.append(f"Mach number {mach:.2g} > {HIGHEST_MACH_NUMBER}: the energy balance is that of low Mach numbers")
    found += _of_the_openings(simulation)
    drop = max(abs(one) for one in simulation.recorder.history["pressure_drop"])
    found += outside_ranges(simulation.specs, problem.has_wall, _reached_by_materials(simulation), drop)
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
