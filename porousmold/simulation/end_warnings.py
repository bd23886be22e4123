"""What is to be said at the end of a run of the place that was to be heated, of how even places are, and of phases."""

from collections import Counter
from itertools import pairwise

import numpy as np

from ..output.quantities import quantity
from .answers import BEYOND_THE_MARGIN, beyond_the_inlet
from .specs import Specs
from .time_integration import Simulation
from .to_and_fro import free_column, part_to_and_fro
from .unmet_targets import NO_CHANGE, row_of_the_last_fifth, supply_at_its_limit

EDGE_OF_ALL = 5e-3
"""Of all temperature differences, that the extremes of the bed's side may be off at the inlet without a word."""
EDGE_STEP = 0.01
"""Part of a spread asked for that the first nodes at the inlet may differ by."""
TO_AND_FRO, LAST_ROWS = 0.01, 20
"""Part of itself by which a flow may go to and fro in the last rows without a word."""
STEADY = 0.02
"""Relative change of the wall's distance from the inlet temperature over the last fifth of a run that is hardly one."""


def why_not_heated(simulation: Simulation) -> str:
    """How far the wall is from the inlet's temperature at the end, whether it still approaches it, and what of the supply was at
    its limit."""
    return "; ".join([_distance_left(simulation), *supply_at_its_limit(simulation)])


def of_no_heating_time(specs: Specs) -> list[str]:
    """Of a scene that has none, and asks for no target and no phases in its place."""
    if specs.waits_for_heat or specs.time.targets or specs.course:
        return []
    if specs.heat.is_wall_held:
        return [
            "there is no heating time: the wall is held at operation.wall_temperature; operation.heated_place = 'bed' or a "
            "[[target]] asks for one of the bed"
        ]
    return [
        f"there is no heating time: what flows in is within {specs.time.heated.margin:g} K of the temperature at the start; a "
        "[[target]] asks for the time that something else takes"
    ]


def _distance_left(simulation: Simulation) -> str:
    time, history, heat = simulation.specs.time, simulation.recorder.history, simulation.specs.heat
    end = (
        f"at {simulation.time:.4g} s"
        if simulation.ending.is_steady(simulation.time)
        else f"by operation.end_time {time.end_time:g} s"
    )
    place, column = time.heated.place, f"deficit_{time.heated.place}"
    wall = "the wall" if simulation.problem.has_wall else "the side of the bed"
    named = {"wall": wall, "bed_side": "the wall's bed side", "bed": "the bed"}.get(place, f"layer {place!r}")
    cools = heat.inlet_temperature.values[-1] < heat.initial_temperature
    changed, farthest = ("cooled", "hottest") if cools else ("heated", "coldest")
    begins = f"not {changed} to within {time.heated.margin:g} K {end}"
    if history[column][-1] <= time.heated.margin:  # it never lagged behind
        low, high, inlet = (history[name][-1] for name in (f"lowest_{place}", f"highest_{place}", "set_point"))
        return f"{begins}: heat from elsewhere has {named} ahead of the inlet, {_kelvin(max(inlet - low, high - inlet))} from it"
    text = f"{begins}: {named} is {_kelvin(history[column][-1])} away"
    times, deficits = (np.array(history[name]) for name in ("time", column))
    if len(times) < 3:
        return text
    before = row_of_the_last_fifth(times.tolist())
    approached = deficits[before] - deficits[-1]
    may_last = (
        simulation.ending.is_steady(simulation.time) or times[-1] > simulation.problem.medium.estimates.heating_duration
    )
    if abs(approached) < NO_CHANGE * deficits[-1] and may_last:
        return text + " and stays there" + _what_balances(simulation, before)
    if deficits[-1] > (1.0 - STEADY) * deficits.max():
        beyond = deficits[-1] > (1.0 + STEADY) * deficits[0]
        outside = heat.outer_wall.exchanges or heat.outer_wall.heat_flux is not None
        ahead = abs(history["set_point"][-1] - history["inlet_temperature"][-1]) > time.heated.margin
        why = (
            "the inlet is not at its set-point"
            if ahead
            else "the surroundings reach it before the flow does"
            if outside
            else "the inlet's temperature runs ahead"
        )
        more = f", farther than at the start: {why}" if beyond else ""
        return f"{text}, its {farthest} point hardly {changed} yet{more}"
    if approached <= 0.0:  # a flow that turns, a programme
        return f"{text}, farther than at {times[before]:.4g} s"
    return text + f" and approaches it by {60.0 * approached / (times[-1] - times[before]):.2g} K/min"


def _kelvin(difference: float) -> str:
    return f"{difference:.1f} K" if difference >= 0.95 else f"{difference:.2g} K"


def of_the_corner(simulation: Simulation) -> list[str]:
    """Of targets that ask how even a place is, and of the spread at the end, where the extreme is the inlet's edge: gas and wall
    of two temperatures meet there, and a finer mesh comes nearer to the one or the other (collective)."""
    problem, history = simulation.problem, simulation.recorder.history
    if not len(history):  # stopped before its first row
        return []
    asked = [one for one in simulation.specs.time.targets if one.asks == "spread" and one.place in problem.places.names]
    range_of_all = max(history["highest_temperature"]) - min(history["lowest_temperature"])
    found = []
    for place in dict.fromkeys((*(one.place for one in asked), "bed_side")):
        step = problem.places.step_at_the_inlet(place)
        of_place = [one for one in asked if one.place == place]
        at_edge = (
            f"the extreme of {place.replace('_', ' ')} is at the edge of the inlet, {step:.1f} K from the next node: finer cells "
            f"move it by as much or more ({step / max(range_of_all, 1e-12):.1%} of all differences)"
        )
        if of_place and step > EDGE_STEP * min(one.limit for one in of_place):
            names = ", ".join(repr(one.name) for one in of_place)
            found.append(
                f"target {names}: {at_edge}, and with it the target's time; a target 'within' at each of some sensors is free of "
                "that"
            )
        elif step > EDGE_OF_ALL * range_of_all:
            found.append(f"{at_edge}, and with it spread_at_end; sensors are free of that")
    return found


def of_a_flow_to_and_fro(simulation: Simulation) -> list[str]:
    """Of a steady drive whose flow, or pressure drop, still goes to and fro from one of the last steps to the next."""
    flow, history = simulation.specs.flow, simulation.recorder.history
    low, high = flow.driven_by.range
    if low != high or simulation.specs.course is not None:
        return []
    name = free_column(flow.drive)
    part = part_to_and_fro(history, name, LAST_ROWS)
    if part <= TO_AND_FRO:
        return []
    around = f"{np.mean(history[name][-LAST_ROWS:]):.4g} {quantity(name).unit}"
    return [
        f"the {name.replace('_', ' ')} goes to and fro by {part:.1%} from step to step, around {around}: the flow answers "
        "strongly to the temperature (a smaller solver.largest_step)"
    ]


def _what_balances(simulation: Simulation, before: int) -> str:
    """What the outer wall and beads that move have exchanged since a row of the history, beside the bed; '' where the wall is as
    warm as what enters, which only the supply keeps from its set-point."""
    outer, heated, rows = simulation.specs.heat.outer_wall, simulation.specs.time.heated, simulation.recorder.history
    lacks = abs(rows["set_point"][-1] - rows["inlet_temperature"][-1])
    if lacks > 0.0 and rows[f"deficit_{heated.place}"][-1] - lacks <= heated.margin:  # by the supply
        return ""

    def gained(column: str) -> float:
        return rows[column][-1] - rows[column][before] if column in rows else 0.0

    through_wall, by_beads = gained("heat_through_outer_wall"), gained("heat_by_beads")
    if abs(by_beads) > abs(through_wall):
        return ": beads that enter cold carry off the heat" if by_beads < 0.0 else ": beads that enter hot bring heat"
    if not outer.exchanges and outer.heat_flux is None:
        return ""
    if through_wall > 0.0:
        return ": heat that comes in through the outer wall balances what the flow carries away"
    sources = any(layer.heat_source is not None for layer in simulation.specs.heat.all_layers)
    return f": heat losses of the outer wall balance the heat from {'the sources and ' if sources else ''}the bed"


def of_heat_from_elsewhere(simulation: Simulation) -> list[str]:
    """Of a place that counts as heated though heat from elsewhere has brought it beyond the inlet's temperature."""
    recorder, specs = simulation.recorder, simulation.specs
    if recorder.heating_time is None or not specs.waits_for_heat:
        return []
    found, place = beyond_the_inlet(recorder, recorder.heating_time), specs.time.heated.place
    if found is None:
        return []
    beyond, side = found
    return [
        f"the time of {place.replace('_', ' ')} is that of its side that comes last: by then or later it is up to {beyond:.1f} K "
        f"{side} than the inlet, by heat from elsewhere"
    ]


def of_an_earlier_set_point(simulation: Simulation) -> list[str]:
    """Of a place that was heated once, and is not as warm as an inlet that was changed since."""
    time, recorder, heat = simulation.specs.time, simulation.recorder, simulation.specs.heat
    if recorder.heating_time is None or time.targets or not simulation.specs.waits_for_heat:
        return []
    away = recorder.history[f"deficit_{time.heated.place}"][-1]
    last = max(heat.inlet_temperature.breakpoints, default=0.0)
    if last < recorder.heating_time or away <= BEYOND_THE_MARGIN * time.heated.margin:
        return []
    place = time.heated.place.replace("_", " ")
    return [
        f"the heating time is that of an earlier set-point: at the end, {simulation.time:.4g} s, {place} is {_kelvin(away)} from "
        "the present one (a [[target]] asks for another)"
    ]


def of_phases_over_at_once(simulation: Simulation) -> list[str]:
    """Of phases whose limit what leaves was beyond before they began, or nearly: they last a step, with its heat."""
    course, history = simulation.specs.course, simulation.recorder.history
    if course is None or not len(history):
        return []
    times = np.array(history["time"])
    spans = enumerate(pairwise([0.0, *course.ends]))
    short = [number for number, (begun, end) in spans if np.count_nonzero((times > begun) & (times <= end)) <= 1]
    counts = Counter(number % len(course.phases) for number in short if course.phase_of(number).side is not None)
    return [
        f"phase {course.phases[number].name!r} ended with its first step, {count} times: what left was "
        f"{course.phases[number].side} {course.phases[number].limit - 273.15:.4g} °C from its begin, or nearly; its time and "
        "heat are those of that step"
        for number, count in sorted(counts.items())
    ]
