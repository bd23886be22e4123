"""Interfaces of flow and heat solvers for the time integration."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np
from dolfinx import fem

from ..arrays import Floats
from ..equations.flow import FlowState
from ..equations.openings import Opening
from ..laws.materials import Fluid
from ..mesh.aliases import Space
from .curing import Curing
from .state import Arrays, SavedNumbers, State, Stateful
from .step_error import StepError

Observer = Callable[[str], None]
Bounds: TypeAlias = tuple[float, float, float, float] | tuple[float, float]
"""Lowest and highest temperature (K) that can be; four where those of the wall, the last two, are others than the bed's."""


def silent(text: str) -> None:
    """Observe nothing."""


def unbounded() -> Bounds:
    """Bounds of temperatures that may be any."""
    return -np.inf, np.inf


class Drive(NamedTuple):
    """What drives a flow at present: `kind` is pressure_drop (`value` in Pa), mass_flow (kg/s) or inlet_velocity (m/s,
    superficial) of fluid that comes at `temperature` (K)."""

    kind: str
    value: float
    temperature: float

    def mass_flow(self, pressure: float, area: float, fluid: Fluid) -> float | None:
        """Mass flow (kg/s) that it gives at an absolute pressure (Pa) at an inlet of an `area` (m2); None where it gives the
        pressure drop."""
        if self.kind == "mass_flow":
            return self.value
        if self.kind == "inlet_velocity":
            return float(self.value * area * fluid.density(pressure, self.temperature))
        return None


class Inflow(NamedTuple):
    """What drives a flow at any time: `drive()` gives the `Drive` of the present, `area` (m2) is that of the inlet, `fluid` the
    scene's `Fluid` in plain numbers."""

    drive: Callable[[], Drive]
    area: float
    fluid: Fluid

    def mass_flow(self, pressure: float) -> float | None:
        """Mass flow (kg/s) given at present at an absolute pressure (Pa) at the inlet; None where the pressure drop is."""
        return self.drive().mass_flow(pressure, self.area, self.fluid)


class StageUpdate(Protocol):
    """A quantity that is updated with the temperature in each stage of a time step, without being an unknown."""

    @property
    def depends_on_temperature(self) -> bool:
        """Whether it depends on the present temperatures, not on time alone."""

    def begin_step(self, step: float, gamma: float) -> None:
        """Start a step (s) whose stages all have theta = `gamma` times it."""

    def begin_stage(self, weights: Sequence[float]) -> None:
        """Start a stage: `weights` (s) are those of the earlier stages' rates."""

    def update(self) -> None:
        """Take the present temperature (collective)."""

    def end_stage(self) -> None:
        """Keep what the later stages need."""


@dataclass
class FlowCounts:
    """What a flow has taken so far: flows found, Newton iterations, steps of false transients, the largest part of the largest k
    by which k was below 0, the largest part of what a fluid contracts by that came in at the outlet, and how often each strategy
    of its solution ended with it, or was given up."""

    solves: int = 0
    newton_iterations: int = 0
    continuation_steps: int = 0
    largest_undershoot: float = 0.0
    largest_drawn_in: float = 0.0
    strategies: dict[str, int] = field(default_factory=dict)

    def note(self, strategy: str, *, found: bool) -> bool:
        """Count a strategy, which has `found` the flow or not; gives that."""
        name = strategy if found else f"{strategy}, given up"
        self.strategies[name] = self.strategies.get(name, 0) + 1
        return found


class Flow(Stateful, Protocol):
    """A steady flow for a given temperature field, and how it follows another one.

    `factored_at` tells what the present factors were made with, None where there are none; a checkpoint keeps it.
    """

    factored_at: Any

    @property
    def counts(self) -> FlowCounts:
        """What it has taken so far."""

    @property
    def state(self) -> FlowState:
        """The fields with units."""

    @property
    def streamfunction(self) -> fem.Function | None:
        """Carries the mass flow of a flow without openings."""

    @property
    def growth(self) -> fem.Function | None:
        """Of that mass flow along the bed, over that at the inlet, where the fluid's expansion counts."""

    @property
    def inlet(self) -> Opening | None:
        """The opening at which the fluid enters, of a flow that has openings."""

    def observe_with(self, observe: Observer) -> None:
        """Have `observe(text)` called at every iteration; it may raise."""

    @property
    def unknowns(self) -> int:
        """Number of unknowns solved for."""

    @property
    def solution(self) -> State:
        """What it is kept in."""

    def start(self, time: float = 0.0) -> None:
        """Find the flow from an initial guess; raises `SolveError`."""

    def renew(self, time: float, tolerance: float) -> None:
        """Follow a changed temperature to a relative `tolerance`; raises `SolveError`."""

    def extrapolate(self, previous: Arrays, factor: float) -> None:
        """Extrapolate the solution `factor` times as far ahead as `previous` (its arrays) lies behind."""

    def is_turbulent(self) -> bool:
        """Whether there is more than negligible turbulence (collective)."""

    def is_also_laminar(self) -> bool:
        """Whether there is a laminar flow beside the present turbulent one (collective)."""

    def fields(self) -> dict[str, fem.Function]:
        """Present velocity, pressure and turbulence (SI) by name (collective)."""


@dataclass
class HeatBalance:
    """Heat since the start (J): brought in by the fluid, through the outer wall, by sources in the wall, stored (less what is
    left of a heat of cure), created by REV terms, brought by moving beads beyond what they take away; and, where air is
    supplied so, given by heater and blower, lost by the exhaust and the return duct."""

    by_fluid: float = 0.0
    through_outer_wall: float = 0.0
    by_sources: float = 0.0
    stored: float = 0.0
    by_rev_terms: float = 0.0
    by_beads: float = 0.0
    by_heater: float = 0.0
    by_blower: float = 0.0
    by_exhaust: float = 0.0
    by_duct: float = 0.0

    def add(self, flows: Mapping[str, float], stored: float) -> None:
        """Add the heat (J) of flows by their names here, and what is stored of it."""
        for name, heat in flows.items():
            setattr(self, name, getattr(self, name) + heat)
        self.stored += stored

    def save(self) -> SavedNumbers:
        """Its entries."""
        return dict(vars(self))

    def restore(self, numbers: SavedNumbers) -> None:
        """Take the entries that `save()` gave."""
        vars(self).update(numbers)

    @property
    def loop_imbalance(self) -> float:
        """What is missing between heater, blower, bed, exhaust and return duct, as a fraction of what the first two give."""
        given = self.by_heater + self.by_blower
        return (given - self.by_fluid - self.by_exhaust - self.by_duct) / max(abs(given), 1e-6)

    @property
    def imbalance(self) -> float:
        """`imbalance_beside` nothing."""
        return self.imbalance_beside(0.0)

    def imbalance_beside(self, other: float) -> float:
        """What is missing, as a fraction of the heat put in (the largest of stored, brought in, and `other` heat (J) that counts,
        such as what a cure has set free, or what was stored once; at least 1 mJ: more than what rounding leaves where nothing
        flows)."""
        given = self.by_fluid + self.through_outer_wall + self.by_sources + self.by_beads
        largest = max(abs(given), abs(self.stored), abs(self.by_beads), abs(other), 1e-3)
        return (given + self.by_rev_terms - self.stored) / largest


class Heat(Stateful, Protocol):
    """The temperatures over a domain, integrated in time."""

    curing: list[Curing]

    @property
    def balance(self) -> HeatBalance:
        """Heat since the start."""

    @property
    def unknown(self) -> fem.Function:
        """T, and T_s where the beads have one of their own."""

    @property
    def space(self) -> Space:
        """Function space of `unknown`."""

    @property
    def newton_iterations(self) -> int:
        """Newton iterations so far."""

    @property
    def repetitions(self) -> int:
        """Steps that were repeated to keep temperatures within bounds."""

    def observe_with(self, observe: Observer) -> None:
        """Have `observe(text)` called at every iteration; it may raise."""

    @property
    def unknowns(self) -> int:
        """Number of unknowns solved for."""

    @property
    def solution(self) -> State:
        """What the temperatures are kept in."""

    @property
    def memory(self) -> State:
        """What else the next step depends on."""

    def step(self, time: float, step: float, bounds: Callable[[], Bounds] = unbounded) -> StepError:
        """One step of `step` seconds from `time`; gives its estimated error. `bounds()` gives those of its temperatures, once
        they are found. Raises `SolveError`."""

    @property
    def estimated_error(self) -> Floats:
        """Of the owned temperatures (K), in the part of a step that was taken last."""

    def largest_bead_difference(self) -> float | None:
        """Largest distance (K) of a bead's surface from its mean; None where beads are isothermal (collective)."""
