"""Why a target was not met: what was at its limit, where the heat went, and the largest lever; which ones were nearly lost."""

import bisect
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..output.quantities import ENERGY_GIVEN, JOULES_A_KWH, Columns
from .target_history import Turn, longest_hold, lost_and_kept, narrowest, narrowest_turn
from .targets import Target
from .time_integration import Simulation

AT_LIMIT = 0.999
"""Part of a heater's limit, or of the blower's end, from which it counts as reached."""
OFTEN = 1.2
"""Times that a heater was at its limit in all, over that at the end without a break, from which on the first is told."""
LEVERS = {
    "exhaust": "operation.recirculation returns what leaves",
    "outer_wall": "insulation, or a smaller operation.outer_coefficient",
    "return_duct": "a smaller operation.duct_conductance",
}
"""What lessens each loss."""
LARGE_LOSS = 0.1
"""Part of the energy given above which a loss is named."""
NARROW = 2e-3
"""Part of all temperature differences that a run's steps and cells may be off by (docs/accuracy.md)."""
COOLED = 2.0
"""K below its highest temperature from which on a place has cooled."""
NO_CHANGE = 1e-3
"""Of what is short of a target, or of the heating time, over the last fifth of a run, that is none."""


def why_not_met(simulation: Simulation, target: Target, energy: Mapping[str, float | None] | None) -> str:
    """Reasons in one sentence part, for a scene with or without blower and heater (`energy` of the whole tool, J)."""
    history = simulation.recorder.history
    last = len(history) - 1
    short = target.quantity(history, last) - target.margin
    since = simulation.recorder.held_since[target.name]
    if since is not None:
        return f"it has held from {since:.4g} s on, not yet for {target.hold:g} s"
    longest = longest_hold(target, history)
    if target.hold and longest is not None:
        begin, end = longest
        held = f"it held for {end - begin:.4g} s at the longest, {begin:.4g} to {end:.4g} s"
        return f"{held}, and not for {target.hold:g} s"
    if longest is None and target.holds(history, 0) and target.asks in ("above", "below"):
        return "it held from the start, and counts only after the place has been on the other side of the limit"
    parts = [f"{short:.3g} short" if target.asks == "cured" else f"{short:.1f} K short"] if short > 0.0 else []
    if parts:
        parts[0] += _course_of(target, history, short)
    if target.asks == "spread" and not target.is_under_way(history, last):
        way = "farther than that from" if target.final == target.initial else "half-way to the set-point from"
        parts = [f"its place has not been {way} the temperature at the start"]
    parts += supply_at_its_limit(simulation)
    parts += _heat_of_a_cure(target, history) if target.asks == "cured" else _losses(energy)
    return "; ".join(parts)


def _heat_of_a_cure(target: Target, history: Columns) -> list[str]:
    """How hot its place is at the end, and was before: what a cure that is not reached wants."""
    column = f"highest_{target.place}" if f"highest_{target.place}" in history else "highest_wall"
    highest, times = history[column], history["time"]
    row = max(range(len(highest)), key=highest.__getitem__)
    now, then = highest[-1] - 273.15, highest[row] - 273.15
    if then - now < COOLED:
        return [f"its place is at most {now:.4g} °C hot: a hotter inlet, or longer"]
    at = f"{times[row] / 60.0:.4g} min"
    return [f"its place was hottest at {at}, {then:.4g} °C, and is {now:.4g} °C by now: a hotter or longer hold"]


def _course_of(target: Target, history: Columns, short: float) -> str:
    """Whether what is `short` of a target still gets less, over the last fifth of a run."""
    times, last = history["time"], len(history) - 1
    if last < 1:
        return ""
    before = row_of_the_last_fifth(times)
    gained = target.quantity(history, before) - target.quantity(history, last)
    if abs(gained) < NO_CHANGE * short:
        return " and stays there"
    if gained < 0.0:
        turn = narrowest(target, history)
        if turn is not None and 0.0 < -turn.left < short:
            return f"; nearest at {turn.time:.4g} s, {-turn.left:.2g} K short"
        return f", more than at {times[before]:.4g} s"
    rate, unit = 60.0 * gained / (times[-1] - times[before]), "" if target.asks == "cured" else " K"
    return f", which lessens by {rate:.2g}{unit}/min"


def row_of_the_last_fifth(times: Sequence[float]) -> int:
    """Where the last fifth of a run of two rows or more begins, before its last row."""
    return min(bisect.bisect_left(times, 0.8 * times[-1]), len(times) - 2)


def supply_at_its_limit(simulation: Simulation) -> list[str]:
    """What of heater and blower was at its limit, and since when."""
    loop, history = simulation.problem.air_loop, simulation.recorder.history
    if loop is None:
        return []
    found, times = [], np.array(history["time"])
    lacks = np.array(history["set_point"]) - np.array(history["inlet_temperature"])
    limit = loop.spec.supply.heater_power
    powers = np.array(history["heater_power"])
    if limit > 0.0 and np.isfinite(limit) and powers[-1] >= AT_LIMIT * limit:
        at_limit = powers >= AT_LIMIT * limit
        below = np.flatnonzero(~at_limit)
        since = times[below[-1] + 1] if len(below) else 0.0
        spent = np.diff(times, prepend=0.0)[at_limit].sum()
        when = f"from {since / 60.0:.0f} min on"
        if spent > OFTEN * (times[-1] - since):  # a flow that reverses, a programme
            when = f"for {spent / times[-1]:.0%} of the time"
        found.append(
            f"the heater is at its limit of {limit / 1e3:.3g} kW {when}, the inlet "
            f"{max(lacks[-1], 0.0):.1f} K below its set-point (a larger operation.heater_power)"
        )
    elif lacks[-1] > 1.0:
        found.append(f"the inlet is {lacks[-1]:.1f} K below its set-point")
    return found


def _losses(energy: Mapping[str, float | None] | None) -> list[str]:
    """The largest loss of the whole tool, and what lessens it."""
    if energy is None:
        return []
    given = sum(max(float(energy[name] or 0.0), 0.0) for name in ENERGY_GIVEN)
    losses = {name: float(energy[name] or 0.0) for name in LEVERS}
    name = max(losses, key=lambda one: losses[one])
    if given <= 0.0 or losses[name] < LARGE_LOSS * given:
        return []
    where = {
        "exhaust": "left with the exhaust",
        "outer_wall": "left through the outer wall",
        "return_duct": "left the return duct",
    }
    return [f"{losses[name] / given:.0%} of the {given / JOULES_A_KWH:.3g} kWh given {where[name]} ({LEVERS[name]})"]


def kept_targets(simulation: Simulation) -> dict[str, dict[str, Any]]:
    """Of every target that was met: "met" (s), "lost" (s, the first time after it, None where it never was) and "kept_from" (s,
    None where it does not hold at the end)."""
    history, found = simulation.recorder.history, {}
    for target in simulation.specs.time.targets:
        met = simulation.recorder.first_met[target.name]
        if met is not None:
            lost, kept = lost_and_kept(target, history, met)
            found[target.name] = {"met": met, "lost": lost, "kept_from": kept}
    return found


def of_narrow_margins(simulation: Simulation) -> list[str]:
    """Of targets, and of the heated place's margin, that were kept, lost or missed by less than steps and cells may be off by."""
    history, found = simulation.recorder.history, []
    if not len(history):  # stopped before its first row
        return []
    allowed = NARROW * (max(history["highest_temperature"]) - min(history["lowest_temperature"]))
    turns = [(f"target {one.name!r}", one.hold, narrowest(one, history)) for one in simulation.specs.time.targets]
    if simulation.specs.waits_for_heat:
        turns.append(("the heated place's margin", 0.0, _narrowest_of_the_heated_place(simulation, allowed)))
    for name, hold, turn in turns:
        if turn is not None and abs(turn.left) < allowed:
            outcomes = ("kept", "lost") if turn.held_before else ("met", "missed")
            outcome, other = outcomes if turn.left >= 0.0 else reversed(outcomes)
            begins = ", and the time that it has to hold begin again" if hold else ""
            found.append(
                f"{name} was {outcome} by only {abs(turn.left):.2g} K at {turn.time:.4g} s, less than steps and "
                f"cells may be off by ({NARROW:.1%} of all differences, {allowed:.2g} K): it may as well be {other} there"
                f"{begins if turn.held_before else ''}"
            )
    return found


def _narrowest_of_the_heated_place(simulation: Simulation, allowed: float) -> Turn | None:
    """Where the distance of the heated place from the inlet's temperature turned back nearest to its margin, from when on it was
    more than that by what is `allowed` (K) up to the breakpoint of the inlet's temperature at which the heating time is final."""
    recorder, heated = simulation.recorder, simulation.specs.time.heated
    times, deficits = recorder.history["time"], recorder.history[f"deficit_{heated.place}"]
    first = next((row for row, deficit in enumerate(deficits) if deficit > heated.margin + allowed), len(times))
    final = math.inf
    if recorder.heating_time is not None:
        ahead = (one for one in simulation.specs.heat.inlet_temperature.breakpoints if one >= recorder.heating_time)
        final = min(ahead, default=recorder.heating_time)
    rows = [row for row in range(first, len(times)) if times[row] <= final * (1.0 + 1e-12)]
    if len(rows) < 2:
        return None
    instants, left = [times[row] for row in rows], [heated.margin - deficits[row] for row in rows]
    return narrowest_turn([*instants, math.inf], [*left, left[-1] + _gain_to_come(simulation, rows[-1])])


def _gain_to_come(simulation: Simulation, row: int) -> float:
    """By how much (K) the distance of the heated place from the inlet's temperature would lessen in a step like that to a row of
    the history, if the place went on as it did and the inlet's temperature as it is given."""
    history, inlet, place = (
        simulation.recorder.history,
        simulation.specs.heat.inlet_temperature,
        simulation.specs.time.heated.place,
    )
    end, step = history["time"][row], history["time"][row] - history["time"][row - 1]
    now = float(inlet(end))
    bend = float(inlet(end + 1e-3 * step) - now) / 1e-3 - (now - float(inlet(end - 1e-3 * step))) / 1e-3
    is_below = now - history[f"lowest_{place}"][row] >= history[f"highest_{place}"][row] - now
    deficits = history[f"deficit_{place}"]
    return deficits[row - 1] - deficits[row] - (bend if is_below else -bend)
