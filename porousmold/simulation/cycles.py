"""What the phases of a run gave and took: heat, exergy, work, and how sharp the front in the bed is.

The exergy that a flow leaves behind is m [h(T_in) - h(T_out) - T_0 (s(T_in) - s(T_out))], T_0 of the surroundings; that of its
pressure is left to the pumping work. The thermocline is the part of the bed between 10 and 90 % of the temperature difference of
the phases, or where all have one temperature of that and the bed's at the start (its thickness); its place is where half of that
is passed.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Floats
from ..laws.materials import Fluid
from ..output.quantities import Columns
from .course import Course
from .energy_use import pumping_power

SURROUNDINGS = 298.15
"""Temperature (K) of the surroundings of a scene that gives none."""
FRONT = (0.1, 0.9)
"""Parts of the temperature difference between which the thermocline lies."""
LEAST_DIFFERENCE = 0.01
"""K between the phases' temperatures, below which they are one."""
NOTHING = 1e-9
"""Of the heat of a cycle, below which none was put in."""
AT_REST = 1e-9
"""Of the largest mass flow, below which one is a rounding error."""
FULL = 1.02
"""Utilisation up to which the density of a fluid that expands explains what is beyond 1."""
OUTSIDE = 0.01
"""Of the temperature difference of the phases, by which a store may begin beyond their temperatures."""
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(8)  # type: ignore[no-untyped-call]


@dataclass(frozen=True)
class Profile:
    """Temperatures (K) of fluid and beads along the middle of the bed at a time (s); `number` is that of the phase which then
    ended, if one did."""

    label: str
    time: float
    fluid: Floats
    beads: Floats
    number: int | None = None


def cycles_of(
    history: Columns, course: Course, profiles: Sequence[Profile], fluid: Fluid, given: Mapping[str, float]
) -> list[dict[str, Any]]:
    """The cycles that are through, each with its `phases`.

    `given`: "outlet_pressure" (Pa), "surroundings" (K), "length" (m), and "storable" (J) between
    the `extremes`.
    """
    columns = {name: np.array(values) for name, values in history.columns.items()}
    at_rest = np.abs(columns["mass_flow"]) < AT_REST * np.max(np.abs(columns["mass_flow"]), initial=0.0)
    columns["mass_flow"] = np.where(at_rest, 0.0, columns["mass_flow"])
    known = {profile.number: profile for profile in profiles}
    low, high = extremes(course, history)
    phases = []
    for number, (end, heat) in enumerate(zip(course.ends, course.heats, strict=True)):
        begun, before = (course.ends[number - 1], course.heats[number - 1]) if number else (0.0, 0.0)
        rows = (columns["time"] > begun) & (columns["time"] <= end * (1.0 + 1e-12))
        part = {name: values[rows] for name, values in columns.items()}
        content = {"name": course.phase_of(number).name, "begin": begun, "end": end, "heat": heat - before}
        content |= _flow(part, begun, fluid, given)
        content["heat_stored"] = float(part["heat_stored"][-1])
        if number in known:
            content |= _front(known[number], low, high, given["length"])
        phases.append(content)
    count = len(course.phases)
    whole = [phases[first : first + count] for first in range(0, len(phases) - count + 1, count)]
    cycles = [_cycle(number, part, columns, given["storable"]) for number, part in enumerate(whole, start=1)]
    apart = max(low - columns["lowest_temperature"][0], columns["highest_temperature"][0] - high)
    if cycles and apart > OUTSIDE * (high - low):  # it stores what lies beyond the phases' temperatures, too
        cycles[0]["utilisation"] = None
    return cycles


def extremes(course: Course, history: Columns) -> tuple[float, float]:
    """Lowest and highest temperature (K) that the phases give; of a store that is charged alone with what it was at first."""
    given = [float(value) for phase in course.phases for value in phase.temperature.values]
    if max(given) - min(given) < LEAST_DIFFERENCE:
        given += [history["lowest_temperature"][0], history["highest_temperature"][0]]
    return min(given), max(given)


def _flow(
    part: Mapping[str, Floats], begun: float, fluid: Fluid, given: Mapping[str, float]
) -> dict[str, float | None]:
    """Exergy, work and outlet temperatures of a phase, from its rows of the history."""
    time = np.append(begun, part["time"])
    mass_flow = np.abs(part["mass_flow"])
    entering, leaving = part["inlet_temperature"], part["outlet_temperature"]

    def over_time(rate: Floats) -> float:
        from scipy.integrate import trapezoid  # takes a while to import, and most runs have no cycles

        return float(trapezoid(np.append(rate[:1], rate), time))

    mass = over_time(mass_flow)
    return {
        "exergy": over_time(mass_flow * _exergy(fluid, leaving, entering, given["surroundings"])),
        "pumping_work": over_time(
            pumping_power(fluid, given["outlet_pressure"], part["mass_flow"], part["pressure_drop"], entering)
        ),
        "mean_outlet_temperature": over_time(mass_flow * leaving) / mass if mass > 0.0 else None,
        "outlet_temperature": float(leaving[-1]),
    }


def _exergy(fluid: Fluid, low: Floats, high: Floats, surroundings: float) -> Floats:
    """Exergy (J/kg) between two temperatures (K), by Gauss's rule over C_f (1 - T_0/T)."""
    middle, half = 0.5 * (high + low), 0.5 * (high - low)
    at = middle + np.multiply.outer(POINTS, half)
    return np.asarray(half * np.tensordot(WEIGHTS, fluid.heat_capacity(at) * (1.0 - surroundings / at), axes=1))


def _front(profile: Profile, low: float, high: float, length: float) -> dict[str, float | None]:
    """Thickness and place (m) of the thermocline; no place where the bed has none, and neither without a difference (K)."""
    if high - low < LEAST_DIFFERENCE:
        return {"thermocline": None, "thermocline_place": None}
    warm = (profile.fluid - low) / (high - low)
    along = np.linspace(0.0, length, len(warm))
    finer = np.linspace(0.0, length, 20 * (len(warm) - 1) + 1)
    between = np.interp(finer, along, warm)
    thickness = length * float(np.mean((between > FRONT[0]) & (between < FRONT[1])))
    crossings = np.flatnonzero(np.diff(np.sign(between - 0.5)))
    return {"thermocline": thickness, "thermocline_place": float(finer[crossings[0]]) if len(crossings) else None}


def _cycle(number: int, phases: list[dict[str, Any]], columns: Mapping[str, Floats], storable: float) -> dict[str, Any]:
    """Sums over the phases of a cycle. Heat in is that of phases that give, heat out that of phases that take.

    A store is charged by the phases that leave exergy behind. Where they take heat it is a cold store, and its energy efficiency
    that of the cold: heat in over heat out.
    """

    def total(name: str, sign: int) -> float:
        return float(sum(max(sign * phase[name], 0.0) for phase in phases))

    begun, end = phases[0]["begin"], phases[-1]["end"]
    stored, lost = (np.interp([begun, end], columns["time"], columns[name]) for name in
                    ("heat_stored", "heat_through_outer_wall"))  # fmt: skip
    heat_in, heat_out, work = total("heat", 1), total("heat", -1), total("pumping_work", 1)
    exergy_in, exergy_out = total("exergy", 1), total("exergy", -1)
    is_cold = sum(phase["heat"] for phase in phases if phase["exergy"] > 0.0) < 0.0
    charged, discharged = (heat_out, heat_in) if is_cold else (heat_in, heat_out)
    levels = [float(stored[0]), *(phase["heat_stored"] for phase in phases)]
    utilisation = (max(levels) - min(levels)) / storable if storable else math.inf
    is_charged = charged > NOTHING * max(discharged, storable, *(abs(level) for level in levels))
    return {
        "cycle": number,
        "begin": begun,
        "end": end,
        "heat_in": heat_in,
        "heat_out": heat_out,
        "heat_stored": float(stored[1] - stored[0]),
        "heat_lost": float(lost[0] - lost[1]),
        "pumping_work": work,
        "energy_efficiency": discharged / charged if is_charged else None,
        "exergy_efficiency": exergy_out / (exergy_in + work) if is_charged and exergy_in > 0.0 else None,
        "utilisation": utilisation if utilisation <= FULL else None,
        "phases": phases,
    }
