r"""Transient two-temperature heating: SDIRK steps of the energy equations (`solvers.sdirk`).

Because what they store is the enthalpy itself, the discrete heat balance closes to the tolerance of Newton's method. The flow is
held during a step, at the temperature predicted for its middle, which makes the coupled method second order.
"""

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from ..arrays import Floats
from ..equations.energy import EnergyEquations, Transport
from ..laws.functions import Value
from ..mesh import fenicsx
from ..mesh.deferred_forms import DeferredForm
from ..mesh.domain import BED, Domain
from .bead_modes import BeadModes
from .bounded_steps import BoundedSteps, Parts
from .curing import Curing
from .heat_error import HeatError
from .heat_flows import HeatFlows
from .heat_preconditioner import heat_preconditioner
from .heat_unknowns import HeatUnknowns
from .linear_solution import LinearSolution
from .newton import Beside, NewtonSystem
from .protocols import (
    Bounds,
    HeatBalance,
    Observer,
    StageUpdate,
    silent,
    unbounded,
)
from .sdirk import Sdirk, Stages
from .stages import ITERATED_STAGE_ERROR, STAGE_ERROR, StageSolver
from .state import ArrayOf, Saved, SavedNumbers, State
from .step_error import StepError
from .transport import FrozenTransport, MonotoneCells


@dataclass(frozen=True)
class ErrorControl:
    """A stage is solved to the relative `stage_error`; `stores` tells of each layer of the wall whether its temperature counts in
    a step's error, `melting` between which temperatures (K) something melts, if it does."""

    stage_error: float = STAGE_ERROR
    stores: Sequence[bool] = ()
    melting: tuple[float, float] | None = None


ORDINARY = ErrorControl()


class TransientHeat:
    """The temperatures over a domain. `equations` are its `EnergyEquations`.

    `unknown` holds T (fluid and wall) and T_s (beads, held where there are none), or with one temperature T alone;
    `memory` tells for how many more steps a cell is monotone; `set_time(t)` is called before each stage to update the boundary
    values; `flows` are what brings heat.
    """

    def __init__(
        self,
        domain: Domain,
        equations: EnergyEquations,
        initial_temperature: float,
        set_time: Callable[[float], None],
        property_temperature: fem.Function,
        quadrature_degree: int,
        control: ErrorControl = ORDINARY,
    ) -> None:
        self.domain, self.equations = domain, equations
        is_thin, melting = equations.wall.thin is not None, control.melting
        of_run = equations.two_temperatures, initial_temperature, control.stores
        temperatures = HeatUnknowns(domain, *of_run, is_thin=is_thin)
        self.unknown, self.space = temperatures.function, temperatures.space
        parts = temperatures.parts
        of_modes = domain, equations, parts, property_temperature
        self.bead_modes = None if equations.interior is None else BeadModes(*of_modes)
        self.curing = [
            Curing(domain, tag, layer.solid.cure, layer.degree, parts[0])
            for tag, layer in zip(domain.wall_tags, equations.wall.layers, strict=False)
            if layer.solid.cure is not None and layer.degree is not None
        ]
        self._inverse_stage = fem.Constant(domain.mesh, 1.0)
        self._transport = FrozenTransport(domain, equations, property_temperature, quadrature_degree)
        stored, residuals = _forms(
            equations, temperatures, self._transport.frozen, self._inverse_stage, domain.wall_measure(quadrature_degree)
        )
        coefficients = property_temperature, self._transport.monotone, self._inverse_stage
        preconditioner = heat_preconditioner(equations, temperatures, *coefficients)
        self._system = NewtonSystem(
            "energy",
            residuals[1],
            self.unknown,
            temperatures.constrained,
            keep_jacobian=True,
            linear=LinearSolution(False, preconditioner=preconditioner),
            simpler=residuals[0],
            beside=Beside(renew=lambda: self._stages.renew_beside(), complete=lambda update: self._stages.damp(update)),
        )
        self._stored_forms = [DeferredForm(form) for form in stored]
        self.flows = HeatFlows(domain.communicator, equations, *parts)
        self.observe: Observer = silent
        error = control.stage_error * (ITERATED_STAGE_ERROR / STAGE_ERROR if self._system.is_iterated else 1.0)
        self._stages = StageSolver(self._system, lambda: self._stage_updates, error)

        def set_stage_time(time: float) -> None:
            set_time(time)
            self.observe("")

        self._steps = Sdirk(
            self._system,
            self._store,
            self._inverse_stage,
            self._stages,
            set_stage_time,
            self._renew_coefficients,
            lambda: self._stage_updates,
        )
        weighted = equations.coordinates.weight * sum(dict.fromkeys(temperatures.tests))
        volumes = DeferredForm(weighted * domain.cell_measure(quadrature_degree))
        of_error = self._system, self._steps, self._store, self.curing, volumes, temperatures.regions
        self.error = HeatError(*of_error, domain.communicator, melting)
        cells = MonotoneCells(self._transport.monotone, temperatures.of_cells, domain.cells(BED))
        self.bounded_steps = BoundedSteps(cells, temperatures, melting if equations.melts else None)

    def _store(self, vector: PETSc.Vec) -> None:
        """Assemble what is stored, as the residual has it at present."""
        fenicsx.assemble_vector(vector, self._stored_forms[0 if self._system.uses_simpler else 1].form)

    def observe_with(self, observe: Observer) -> None:
        """Have `observe(text)` called at every stage; it may raise."""
        self.observe = observe

    @property
    def unknowns(self) -> int:
        """Number of unknowns solved for."""
        return self._system.active_unknowns

    @property
    def newton_iterations(self) -> int:
        """Newton iterations so far."""
        return self._stages.iterations

    @property
    def repetitions(self) -> int:
        """Steps that were repeated to keep temperatures within bounds."""
        return self.bounded_steps.repetitions

    @functools.cached_property
    def solution(self) -> State:
        """What the temperatures are kept in, those inside the beads and the degrees of cure included."""
        modes = self.bead_modes.functions if self.bead_modes else []
        functions = {"unknown": self.unknown} | {f"bead_mode_{number}": mode for number, mode in enumerate(modes)}
        return State(functions | {f"cure_{number}": part.degree for number, part in enumerate(self.curing)})

    def step(self, time: float, step: float, bounds: Callable[[], Bounds] = unbounded) -> StepError:
        """One step of `step` seconds from `time`; gives its estimated error. The heat balance is brought forward.

        Where a temperature leaves `bounds()` (K), the cells around it become monotone and the step is repeated, in the end by
        the backward Euler method.
        Raises `SolveError` if a stage does not converge: `solution` and `memory` are then the caller's to put back.
        """

        def restored() -> None:
            if self.flows.supply:
                self.flows.supply.update()

        take_all = functools.partial(self._take_all, time)
        flows, stored, error = self.bounded_steps.take(step, take_all, bounds, self.solution, restored)
        self.balance.add(flows, stored)
        return error

    @property
    def balance(self) -> HeatBalance:
        """Of all steps so far."""
        return self.flows.balance

    @functools.cached_property
    def memory(self) -> State:
        """What the next step depends on besides the `solution`."""
        cells = self.bounded_steps.cells
        return State({"monotone_for": cells.steps, "held_for": cells.held})

    def largest_bead_difference(self) -> float | None:
        """Largest distance (K) of a bead's surface from its mean; None where beads are isothermal (collective)."""
        return self.bead_modes.largest_difference() if self.bead_modes else None

    def save(self) -> Saved:
        """Counters, and how Newton's method has contracted."""
        counts = {"newton_iterations": self.newton_iterations, "repetitions": self.repetitions}
        return Saved(counts | {"contraction": self._stages.contraction.ratio})

    def restore(self, numbers: SavedNumbers, array_of: ArrayOf) -> None:
        """Go on from what `save()` gave."""
        self._stages.iterations, self.bounded_steps.repetitions = numbers["newton_iterations"], numbers["repetitions"]
        self._stages.contraction.ratio = numbers["contraction"]

    @property
    def frozen(self) -> Transport:
        """The `Transport` of the present step."""
        return self._transport.frozen

    @property
    def estimated_error(self) -> Floats:
        """Of the owned temperatures (K), in the part of a step that was taken last."""
        return self.error.of_temperatures

    def begin(self) -> None:
        """Note the start of a step that another solver takes."""
        self._renew_coefficients()
        self._steps.note_start()

    def finish(self, crossed: Floats, by_fluid: float, stored: float) -> None:
        """Bring the balance forward by the heat (J) that `crossed` during such a step, the sum of `flows.here()` times their
        weights, and by what the fluid brings and stores beside that as its mass changes."""
        flows = self.flows.of_all_ranks(crossed)
        self.balance.add(flows | {"by_fluid": flows["by_fluid"] + by_fluid}, self._steps.gained() + stored)

    def _renew_coefficients(self) -> None:
        """Take those of the present flow and temperature, with the cells that are monotone at present."""
        self._transport.renew()
        self._system.uses_simpler = not self.bounded_steps.cells.are_there

    def _take_all(self, time: float, parts: Parts) -> tuple[dict[str, float], float, StepError]:
        """Successive (step, stages) from `time`; gives the heat (J) of each flow, the heat stored, and the estimated error."""
        flows, stored, errors = self.flows.none, 0.0, []
        for step, stages in parts:
            more, gained = self._take(time, step, stages)
            flows = {name: heat + more[name] for name, heat in flows.items()}
            stored, time = stored + gained, time + step
            errors.append(self.error.of_step(stages, self._inverse_stage.value))
        return flows, stored, functools.reduce(StepError.plus, errors)

    def _take(self, time: float, step: float, stages: Stages) -> tuple[dict[str, float], float]:
        """All stages of a step; gives the heat (J) of each flow and the heat stored."""
        flows, crossed = self.flows.none, np.zeros(1)

        def passed(weight: float) -> None:
            nonlocal crossed
            crossed = crossed + weight * self.flows.here()
            for name, rate in self.flows.of_supply.items():
                flows[name] += weight * rate

        gained = self._steps.take(time, step, stages, passed)
        return flows | self.flows.of_all_ranks(crossed), gained

    @property
    def _stage_updates(self) -> list[StageUpdate]:
        return [part for part in (self.bead_modes, *self.curing, self.flows.supply) if part is not None]


def _forms(
    equations: EnergyEquations, unknowns: HeatUnknowns, frozen: Transport, inverse_stage: Value, dx_wall: ufl.Measure
) -> tuple[list[Value], list[Value]]:
    """What is stored and the residual of a stage, each without monotone cells and with them."""
    parts, tests, nothing = unknowns.parts, unknowns.tests, fem.Constant(unknowns.space.mesh, 0.0)
    stored, residuals = [], []
    for transport in (replace(frozen, streamline=frozen.streamline.without_monotone_cells()), frozen):
        stored.append(equations.stored_heat(*parts, *tests, transport))
        residual = inverse_stage * stored[-1] + equations.outflow_of_heat(*parts, *tests, transport)
        # the matrix needs entries for the bead temperatures that are fixed inside the wall
        residuals.append(residual + nothing * parts[1] * tests[1] * dx_wall)
    return stored, residuals
