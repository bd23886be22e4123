"""How the flow goes with the temperatures in a time step: kept, found anew for the temperatures extrapolated to the middle of the
step, or solved for together with them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..arrays import Floats
from ..mesh import ranks
from ..solvers.state import Arrays
from .answers import UNSTABLE_DISPLACEMENT
from .estimates import FluidProperties, flow_change, fluid_at, viscosity_ratio
from .problem import Problem

CORRECTED = 0.02
"""Of the mass flow, from which a step is taken again with what the fluid has displaced in it: fronts are within 0.1 %."""
LEAST_MISS = 1e-3
"""Of all temperature differences, by which an extrapolated temperature has to be missed to and fro to be relaxed."""
LEAST_VISCOSITY_RATIO = 3.0
"""Between all temperatures that are given, from which on the flow answers strongly to them: gases have 2.4 up to 850 °C."""
LEAST_FLOW = 1e-3
"""Of the expected mass flow: below, what is displaced does not count."""


@dataclass
class Past:
    """The problem's solution before the last step, none where the flow turned since, and the lengths (s) of the last two steps at
    most."""

    solution: Arrays = field(default_factory=dict)
    steps: list[float] = field(default_factory=list)

    def go_on(self, before: Arrays, step: float) -> None:
        """Take note of a step (s), and of the solution before it."""
        self.solution, self.steps = before, [*self.steps[-1:], step]


class Ahead(NamedTuple):
    """A step (s) from a time (s), what it goes on from, the `limits` (K) of temperatures that are extrapolated, whether the
    flow's course over the last steps `is_smooth`, and whether it `alternates` from step to step."""

    time: float
    step: float
    past: Past
    limits: tuple[float, float]
    is_smooth: bool
    alternates: bool


class Frozen:
    """The flow stays as it was at the start: `model.flow_update = "frozen"`, and what the others share."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem

    def flow_time(self, time: float, past: Past) -> float:
        """Time (s) that the flow was solved for, at the end (s) of a step."""
        return 0.0

    def prepare(self, ahead: Ahead, at_end: Floats | None = None) -> None:
        """Bring coefficients and flow to the step ahead, with temperatures extrapolated; the fluid expands by the temperatures
        `at_end` (K) of the step, by default those. Raises `SolveError` (collective)."""
        self._extrapolate_temperature(ahead)

    def better_end(self, step: float) -> Floats | None:
        """Temperatures (K) at the end of the step (s) just taken, where its flow was that of others, by so much that it is to be
        taken again; else None (collective)."""
        return None

    def flow_error(self) -> float:
        """Relative error of the mass flow in the step that was taken last (collective)."""
        return 0.0

    def _extrapolate_temperature(self, ahead: Ahead) -> None:
        """Take the heat's coefficients at the temperature extrapolated to the step's middle, where they belong (second order)."""
        problem, past = self.problem, ahead.past
        middle = problem.heat.unknown.copy()
        if past.solution:
            middle.x.array[:] += 0.5 * ahead.step / past.steps[-1] * (middle.x.array - past.solution["heat/unknown"])
            np.clip(middle.x.array, *ahead.limits, out=middle.x.array)
        problem.medium.property_temperature.x.array[:] = problem.part_of_heat(middle, 0).x.array


class QuasiSteady(Frozen):
    """The flow is the steady one at the temperatures of the step's middle."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem)
        has_fingers = (
            problem.medium.estimates.resistance_ratio > UNSTABLE_DISPLACEMENT
        )  # which go to and fro by themselves
        answers_strongly = viscosity_ratio(problem.specs) > LEAST_VISCOSITY_RATIO
        # a flow that follows the temperatures would lag behind them: its steps are as short as its error asks for
        self._may_be_relaxed = not self._follows_temperature and not has_fingers and answers_strongly

    def flow_time(self, time: float, past: Past) -> float:
        return time - (0.5 * past.steps[-1] if past.steps else 0.0)

    def prepare(self, ahead: Ahead, at_end: Floats | None = None) -> None:
        problem, medium = self.problem, self.problem.medium
        step, past, middle_time = ahead.step, ahead.past, ahead.time + 0.5 * ahead.step
        if self._follows_temperature:
            self._temperature_before, self._limits = problem.temperature.x.array.copy(), ahead.limits
        self._extrapolate_temperature(ahead)
        self._assume_flow_temperature(ahead)
        medium.boundary.set(middle_time)
        if medium.displacement is not None:
            present, middle = problem.temperature.x.array, medium.property_temperature.x.array
            end = np.clip(2.0 * middle - present, *ahead.limits) if at_end is None else at_end
            last_step = past.steps[-1] if past.steps else 0.0
            medium.displacement.follow(present, end, step, last_step, flows=self._is_driven)
        if ahead.is_smooth and len(past.steps) == 2:  # from its course over these, at whose middles it was solved
            before = {name: past.solution[f"flow/{name}"] for name in problem.flow.solution.functions}
            problem.flow.extrapolate(before, (step + past.steps[1]) / sum(past.steps))
        tolerance = problem.specs.flow.tolerance
        problem.find_flow(lambda: problem.flow.renew(ahead.time, tolerance), middle_time)

    def _assume_flow_temperature(self, ahead: Ahead) -> None:
        """Solve the flow for the temperature extrapolated to the step's middle, relaxed where that goes to and fro."""
        problem, medium = self.problem, self.problem.medium
        assumed, expected = medium.flow_temperature.x.array, medium.property_temperature.x.array
        may_be_relaxed = self._may_be_relaxed and ahead.is_smooth and bool(ahead.past.solution)
        if not (may_be_relaxed and (ahead.alternates or self._relaxes)):
            medium.relaxation.begin()
            assumed[:] = expected
            return
        became = problem.heat.unknown.copy()
        became.x.array[:] = 0.5 * (became.x.array + ahead.past.solution["heat/unknown"])
        low, high = ahead.limits
        finer = max(problem.specs.time.steps.refinement, 1.0)
        became_fluid, least = problem.part_of_heat(became, 0).x.array, LEAST_MISS / finer**3 * (high - low)
        assumed[:] = medium.relaxation.relaxed(assumed, became_fluid, expected, least)

    @property
    def _relaxes(self) -> bool:
        """Whether anything is relaxed by now (collective)."""
        return ranks.anywhere(self.problem.communicator, bool(self.problem.medium.relaxation.missed.x.array.any()))

    def better_end(self, step: float) -> Floats | None:
        problem, displacement = self.problem, self.problem.medium.displacement
        if displacement is None or not self._is_driven:
            return None
        end = problem.temperature.x.array
        missed = problem.specs.porosity.bulk_porosity * problem.bed.integral(np.abs(displacement.missed(end))) / step
        flow = max(problem.balances.mass_flow, LEAST_FLOW * problem.medium.estimates.mass_flow)
        return end if missed > CORRECTED * flow else None

    @property
    def _is_driven(self) -> bool:
        """Whether anything drives the flow at present; fluid that expands at rest may leave at either end."""
        return self.problem.medium.boundary.present_drive().value != 0.0 or self.problem.specs.flow.gravity != 0.0

    @property
    def _follows_temperature(self) -> bool:
        """Whether the mass flow is one that changes with the temperatures."""
        return self.problem.specs.flow.drive == "pressure_drop"

    def flow_error(self) -> float:
        if not self._follows_temperature:
            return 0.0
        problem, end = self.problem, self.problem.temperature.x.array
        middle = 0.5 * (self._temperature_before + end)
        pairs = (problem.medium.flow_temperature.x.array, middle), (end, self._with_error(end))
        return sum(
            flow_change(problem.specs, problem.medium.size, *(self._fluid_at(values) for values in pair))
            for pair in pairs
        )

    def _with_error(self, end: Floats) -> Floats:
        """The fluid's temperatures (K) at the end of a step with their estimated errors, within the limits of extrapolated ones
        (collective): where a liquid is a hundred times as viscous by them, small ones move the flow."""
        beside, error = self.problem.heat.unknown.copy(), self.problem.heat.estimated_error
        beside.x.array[: len(error)] += error
        beside.x.scatter_forward()
        return np.clip(self.problem.part_of_heat(beside, 0).x.array, *self._limits)

    def _fluid_at(self, temperature: Floats) -> FluidProperties:
        """What resists the flow along a bed as the fluid at the nodes' temperatures (K) does: of one flux all along, drag is that
        of the mean specific volume, and friction that of the mean kinematic viscosity (collective)."""
        problem = self.problem
        fluid, volume = fluid_at(problem.specs, temperature), problem.bed.size
        specific_volume = 1.0 / np.broadcast_to(fluid.density, temperature.shape)
        density = volume / problem.bed.integral(specific_volume)
        viscosity = density * problem.bed.integral(fluid.viscosity * specific_volume) / volume
        return fluid._replace(density=density, viscosity=viscosity)


class Coupled(Frozen):
    """Flow and temperatures are one system (`solvers.coupled`), whose step brings both to its end."""

    def flow_time(self, time: float, past: Past) -> float:
        return time


STEPPERS: Mapping[str, type[Frozen]] = {"frozen": Frozen, "quasi-steady": QuasiSteady, "transient": Coupled}
"""By `model.flow_update`."""
