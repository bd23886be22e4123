"""What a time step may do: its error, its length, and the bounds of its temperatures."""

import math
from collections.abc import Callable

from ..errors import SolveError
from ..mesh import ranks
from ..solvers.protocols import Bounds
from ..solvers.state import Arrays
from ..solvers.step_error import StepError
from .problem import Problem
from .recorder import Recorder
from .to_and_fro import free_column, part_to_and_fro

STEP_ERROR = {2: 4e-3, 3: 2e-3}
"""Estimated error of a step that is allowed, of temperatures, over the differences there are, by the order of the estimate: 3 of
three stages, 2 of a step that the backward Euler method damps, which is of little length where it is of much error."""
CURE_ERROR = {2: 3e-5, 3: 1.5e-4}
"""The same of a degree of cure."""
COARSEST_ERRORS = 0.6
"""Refinement of the steps below which their errors may grow no more: a front that comes in is lost in one step else."""
FLOW_ERROR = 1e-3
"""Relative error of the mass flow in a step that is allowed."""
LARGEST_SCALE = 8.0
"""Times the change of a place that is waited for, that the differences count at most: behind a wall that a furnace
of 900 °C heats, 60 °C came 0.6 % late with an error that is a part of 900 K."""
LEAST_DIFFERENCE = 0.02
"""Temperature difference (K) below which none counts."""
LEAST_SCALE = 0.04
"""Of the differences, that counts at least, however small that change is."""
STEPS_OF_CHANGE = 4.0
"""Steps like the last one whose change counts as a difference: of what is heated evenly."""
QUIET_CHANGE = 5e-4
"""Change of every temperature in a step, over the differences there are, and of every degree of cure, below which the step is
a quiet one: what is given is steady, and no front is on its way through the bed."""
CURE_BEGINS, LARGEST_GROWTH = 1e-3, 0.35
"""Degree of cure below which its error says nothing, as it grows by itself from next to nothing; and the part of that growth's
time constant that a step may take: from 1e-9 on a resin of order 1 cures within 0.15 % of its time (by its error alone never)."""
ALTERNATING_ROWS, ALTERNATING_PART = 13, 2.5e-4
"""The last rows in which a flow has to go to and fro, by more than this part of itself, to be relaxed."""
LARGEST_PART = 0.5
"""Of the time in which differences that decay would be gone, that one step may take."""
INLET_CHANGE = 0.1
"""K by which air that comes back may get warmer within a step, beside twice what it last did, before cells become monotone."""


class StepRules:
    """Those of a problem, from its present state and what has been recorded of it."""

    def __init__(self, problem: Problem, recorder: Recorder) -> None:
        self._problem, self._recorder, self._specs = problem, recorder, problem.specs
        # the published pressure term drives flow across the openings
        free = not self._specs.time.steps.keep_bounds or self._specs.flow.averaging.terms == "as-published"
        self._given = (-math.inf, math.inf) if free else self._specs.heat.given_bounds
        self._is_open = self._specs.heat.is_open
        self._rows_seen, self._left = 0, (-math.inf, math.inf)

    def range_now(self) -> tuple[float, float]:
        """Lowest and highest present temperature (K)."""
        history = self._recorder.history
        return history["lowest_temperature"][-1], history["highest_temperature"][-1]

    def error_ratio(self, time: float, error: StepError, flow_error: Callable[[], float]) -> float:
        """Estimated error of a step to a time (s), and of its flow, over what is allowed (collective). Raises `SolveError`
        where more heat is taken out than there is."""
        problem, specs, history = self._problem, self._specs.time, self._recorder.history
        lows, highs = zip(*(problem.places.extremes(place) for place in ("bed", "wall")), strict=True)
        low, high = min(lows), max(highs)
        if not low > 0.0:
            raise SolveError(
                "heat",
                time,
                "a temperature falls to 0 K",
                "less heat taken out: operation.outer_heat_flux, heat_source of a layer; or laws of your own that are positive",
            )
        change = max(abs(low - history["lowest_temperature"][-1]), abs(high - history["highest_temperature"][-1]))
        differences = self.differences(time, low, high, problem.inlet_temperature)
        met = [name for name, since in self._recorder.targets.items() if since is not None]
        largest = max(LARGEST_SCALE * self._specs.least_change_needed(met), LEAST_SCALE * differences)
        scale = min(max(differences, STEPS_OF_CHANGE * change), largest)
        allowed = STEP_ERROR[error.order] * max(scale, LEAST_DIFFERENCE)
        if specs.steps.tolerance is not None:
            allowed = min(allowed, specs.steps.tolerance)
        finer = max(specs.steps.refinement, COARSEST_ERRORS)
        ratio = max(error.temperature / allowed, error.cure / CURE_ERROR[error.order]) * finer**error.order
        return float(max(ratio, self._weight_of_flow(time) * flow_error() / FLOW_ERROR * finer**2))

    def _weight_of_flow(self, time: float) -> float:
        """Of an error of the flow that lasts up to a time (s): its part of all that is to flow through the bed, or of the time
        that takes; the root, as a flow that a front makes ever slower is off at every scale of time."""
        estimates, flow = self._problem.medium.estimates, abs(self._problem.balances.mass_flow)
        times = max(1.0, flow / estimates.mass_flow) if estimates.mass_flow > 0.0 else 1.0
        return math.sqrt(min(1.0, times * time / estimates.heating_duration))

    def flow_alternates(self) -> bool:
        """Whether the flow, or its pressure drop where it is given, has gone to and fro in the last steps."""
        part = part_to_and_fro(self._recorder.history, free_column(self._specs.flow.drive), ALTERNATING_ROWS)
        return part > ALTERNATING_PART / max(self._specs.time.steps.refinement, 1.0)

    def is_quiet(self, before: Arrays) -> bool:
        """Whether the step that was just taken from a state (arrays of `Problem.state`) has changed no temperature and no degree
        of cure anywhere (collective)."""
        problem, (low, high) = self._problem, self.range_now()
        differences = max(high - low, LEAST_DIFFERENCE)
        for name, function in problem.heat.solution.functions.items():
            change = ranks.largest_magnitude(problem.communicator, function.x.array - before[f"heat/{name}"])
            if change > QUIET_CHANGE * (1.0 if name.startswith("cure") else differences):
                return False
        return True

    def differences(self, time: float, low: float, high: float, inlet: float) -> float:
        """Largest temperature difference (K) at a time (s) between places and what is given there: by the inlet where it flows,
        else by the start."""
        given = [low, high, *(float(one(time)) for one in self._specs.heat.given_elsewhere)]
        given += [inlet] if self._problem.medium.estimates.flows else self._specs.heat.first_temperatures
        return max(given) - min(given)

    def longest_of_cure(self) -> float:
        """A part of the time in which a cure that has hardly begun grows by itself (s; collective)."""
        growth = max((part.fastest_growth(CURE_BEGINS) for part in self._problem.heat.curing), default=0.0)
        return LARGEST_GROWTH / growth / self._specs.time.steps.refinement if growth > 0.0 else math.inf

    def longest_step(self) -> float:
        """A part of the time in which temperature differences that decay would be gone (s)."""
        history = self._recorder.history
        if len(history) < 2:
            return math.inf
        columns = ("time", "lowest_temperature", "highest_temperature", "inlet_temperature")
        before, now = (self.differences(*(history[name][row] for name in columns)) for row in (-2, -1))
        if not now < before:
            return math.inf
        gone_after = now * (history["time"][-1] - history["time"][-2]) / (before - now)
        return LARGEST_PART * gone_after / self._specs.time.steps.refinement

    def bounds(self) -> Bounds:
        """Bounds of the temperatures (K) of the present step: a heater cannot cool air that comes back too warm, which then
        enters as warm as it did, but for what changes within a step. Where the wall has sources, cures or takes up a given flux
        it has no bound on that side, and the bed is bounded by the wall as it is and by what that has left in it (collective)."""
        low, high = self._given
        air_loop = self._problem.air_loop
        if air_loop is not None and air_loop.is_too_warm:
            entered = self._recorder.history["inlet_temperature"]
            rise = entered[-1] - entered[-2] if len(entered) > 1 else 0.0
            high = max(high, max(entered) + INLET_CHANGE + 2.0 * max(rise, 0.0))
        colder, hotter = self._is_open
        if not (colder or hotter):
            return low, high
        of_wall = (-math.inf if colder else low), (math.inf if hotter else high)
        coldest, hottest = self._problem.places.extremes("wall")
        least, most = self._left_by_wall()
        if colder:
            low = min(low, coldest, least)
        if hotter:
            high = max(high, hottest, most)
        return low, high, *of_wall

    def _left_by_wall(self) -> tuple[float, float]:
        """Lowest and highest temperature (K) that the bed may have from its wall as it was: a wall that has heated it may be
        colder than the bed by now, which stays as hot as it has been at most."""
        history = self._recorder.history
        names = (f"{end}_{place}" for end in ("lowest", "highest") for place in ("wall", "bed"))
        low, high = self._left
        for coldest, least, hottest, most in zip(*(history[name][self._rows_seen :] for name in names), strict=True):
            low, high = min(coldest, max(low, least)), max(hottest, min(high, most))
        self._rows_seen, self._left = len(history), (low, high)
        return low, high

    def limits(self) -> tuple[float, float]:
        """Within which temperatures (K) are extrapolated: those of now, and those that enter."""
        low, high = self.range_now()
        coldest, hottest = self._specs.heat.inlet_temperature.range
        return min(low, coldest), max(high, hottest)
