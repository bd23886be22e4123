"""What a run answers, and why answers may be off."""

from collections.abc import Sequence

import numpy as np

from .accuracy import ALL_IN_DOUBT, AT_END, IN_DOUBT, PEAKS, Answer, Answers, Refinements
from .heat_capacity_peaks import melts
from .recorder import Recorder
from .regimes import turbulence_begins_at
from .targets import highest_until_met

HEATING_TIME = "heating_time"
"""Name of that answer."""
TARGETS = "targets."
"""Beginning of the names of the times at which targets were met."""
LEAST_SPAN, LEAST_HEAT = 0.01, 1e-3
"""Between all temperatures of a run (K), and of heat stored (J), below which nothing happens in it."""
SHARP_FRONT = 0.045
"""Part of all temperature differences within one cell of the bed, from which on what holds at the end is in doubt."""
BEYOND_THE_MARGIN = 1.5
"""Times operation.heating_margin by which a heated place may be beyond the inlet's temperature without a word."""
UNSTABLE_DISPLACEMENT = 5.0
"""Ratio of resistances of the fluid displaced and that which enters beyond which answers may depend on the cells."""
FINGERS = "a fluid that flows easily displaces one that does not"
"""The doubt that coarser cells do not settle: they may agree by accident."""
LONGEST_ENTRANCE = 0.05
"""Part of the bed's length behind the inlet in which turbulence may begin without a word."""
BEGINS_LATE = (
    "turbulence grows from the inlet's and begins within the bed: where it does depends on the cells along the flow"
)
"""Another one: k grows exponentially there, on cells that are too coarse sooner."""
MELTS = "beads melt at a sharp front, which the cells along the flow spread"
"""A third one: those are of first order at the front, and coarser ones hide it."""
AT_ONCE = {FINGERS: ALL_IN_DOUBT, BEGINS_LATE: Refinements(along=IN_DOUBT), MELTS: Refinements(along=IN_DOUBT)}
"""Doubts that are settled by finer cells alone, with their refinements."""
BEYOND_THE_INLET = "heat from elsewhere brings the heated place beyond the inlet's temperature"
"""One that is about the corner of the inlet and a wall that is heated."""
SLOW_TO_CONVERGE = {BEYOND_THE_INLET: 1.0 / 3.0, MELTS: 1.0 / 3.0}
"""Doubts in which errors fall slowly with the cells, and the part of the difference from a run on coarser cells that they allow:
0.6 % off where that differs by 0.26 %, and 0.3 % on twice the cells. With fewer steps, too, it may agree by accident."""
EARLY_PART, EARLY_STEPS = 0.25, 3
"""Part of the estimated heating duration in which a front that has just come in is as sharp as a few cells are long, and number
of the first steps of a run, within which an answer is in doubt: sensors there were passed up to 3 % too soon or too late, in the
first step at half the time."""
TOO_EARLY = "a time that is asked for is within the first steps"
"""The first of the doubts that come of that."""
JUST_COME_IN = "a front passes a sensor where it has just come in"
"""The second one."""
EXOTHERM = 0.02
"""Part of all temperature differences by which a layer that cures is hotter than all that is given, that counts."""


def answers_of(recorder: Recorder) -> dict[str, Answer]:
    """What the run answers: the heating time and the times (s) at which targets were met, as far as they were; the
    highest temperature (K) of each layer that cures; and where not all that it waits for is reached, the temperatures of all
    places (K) and the heat stored (J) at the end."""
    history, problem, course = recorder.history, recorder.problem, recorder.problem.specs.course
    times = {HEATING_TIME: recorder.heating_time}
    times |= {f"{TARGETS}{name}": time for name, time in recorder.targets.items()}
    found = {name: Answer.by_itself(time) for name, time in times.items() if time is not None}
    is_answered = recorder.reached or (course is not None and course.repeats)  # cycles answer by themselves
    lowest = min(history["lowest_temperature"])
    for name in problem.degrees_of_cure():
        place = name if f"highest_{name}" in history else "wall"
        peak = highest_until_met(history["time"], history[f"highest_{place}"], recorder.targets.values())
        found[f"{PEAKS}{name}"] = Answer(peak, max(peak - lowest, LEAST_SPAN))
    span = max(history["highest_temperature"]) - lowest
    if is_answered or span < LEAST_SPAN:
        return found
    for name in history:
        if name == "outlet_temperature" or name.startswith(("temperature_", "sensor_")):
            found[f"{AT_END}{name}"] = Answer(history[name][-1], span)
    stored = np.abs(history["heat_stored"])
    if stored.max() > LEAST_HEAT:
        found[f"{AT_END}heat_stored"] = Answer(history["heat_stored"][-1], float(stored.max()))
    return found


def doubt_of(recorder: Recorder, answers: Answers) -> str:
    """Why answers may be off by more than the default cells and steps are made for, '' where they should not (collective): beads
    that melt in a flow, a front that stands in the bed at the end, a displacement that forms fingers, turbulence that begins
    late, a time within the first steps or of a front that has just come in, heat from elsewhere that brings the heated place
    beyond the inlet, so that what comes last comes slowly, or heat of cure that makes a layer hotter than all that is given."""
    history, problem = recorder.history, recorder.problem
    span = max(history["highest_temperature"]) - min(history["lowest_temperature"])
    if span < LEAST_SPAN:
        return ""
    specs = problem.specs
    if answers and any(specs.flow.driven_by.range) and melts(specs.laws.beads.heat_capacity, specs.heat):
        return MELTS
    if any(name.startswith(AT_END) for name in answers):
        part = problem.largest_difference_in_a_cell() / span
        if part > SHARP_FRONT:
            return f"the temperature changes within one cell of the bed by {part:.0%} of all differences"
    if problem.medium.estimates.resistance_ratio > UNSTABLE_DISPLACEMENT:
        return FINGERS
    if answers and turbulence_begins_at(problem) > LONGEST_ENTRANCE:
        return BEGINS_LATE
    times = [answer.value for name, answer in answers.items() if name == HEATING_TIME or name.startswith(TARGETS)]
    if early := _early_answer(recorder, [time for time in times if time > 0.0]):
        return early
    if times and beyond_the_inlet(recorder, min(times)):
        return BEYOND_THE_INLET
    elsewhere = [series.range[1] for series in problem.specs.heat.given_elsewhere]
    given = max(history["highest_temperature"][0], *history["inlet_temperature"], *elsewhere)
    peaks = [answer.value for name, answer in answers.items() if name.startswith(PEAKS)]
    is_exotherm = bool(peaks) and max(peaks) > given + EXOTHERM * span
    return "a layer's cure makes it hotter than all that is given" if is_exotherm else ""


def _early_answer(recorder: Recorder, times: Sequence[float]) -> str:
    """That one of the `times` (s) that a run answers is within its first steps, or that a front passes a sensor where it has just
    come in; '' where neither is so."""
    if not times:
        return ""
    ends = recorder.history["time"]
    if min(times) <= ends[min(EARLY_STEPS, len(ends) - 1)]:
        return TOO_EARLY
    specs, estimates = recorder.problem.specs, recorder.problem.medium.estimates
    passed = (recorder.targets[target.name] for target in specs.time.targets if target.is_sensor)
    just_come_in = any(time is not None and 0.0 < time < EARLY_PART * estimates.heating_duration for time in passed)
    return JUST_COME_IN if estimates.flows and just_come_in else ""


def hidden_directions(doubt: str) -> Refinements:
    """Factors above 1 in the directions in which coarser cells do not show the error of answers in doubt, but finer ones do."""
    return AT_ONCE[doubt] if doubt in (BEGINS_LATE, MELTS) else Refinements()


def beyond_the_inlet(recorder: Recorder, time: float) -> tuple[float, str] | None:
    """By how much (K) the heated place is beyond the inlet's temperature at a time (s) or later, by heat from elsewhere, and what
    it is then, "hotter" or "colder"; None where it is not, or by no more than `BEYOND_THE_MARGIN`."""
    heated, history = recorder.problem.specs.time.heated, recorder.history
    after, inlet = int(np.searchsorted(history["time"], time)), history["inlet_temperature"]
    rows = slice(min(after, len(history) - 1), len(history))
    # what has not come to the inlet's temperature from where it started is not beyond it
    hottest, coldest = max(*inlet, history["highest_temperature"][0]), min(*inlet, history["lowest_temperature"][0])
    above = max(history[f"highest_{heated.place}"][rows]) - hottest
    below = coldest - min(history[f"lowest_{heated.place}"][rows])
    beyond, side = (above, "hotter") if above >= below else (below, "colder")
    return (beyond, side) if beyond > BEYOND_THE_MARGIN * heated.margin else None
