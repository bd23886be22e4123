"""Flow, turbulence and temperatures as one transient system: the reference that the quasi-steady flow is measured against.

Every unknown keeps its time derivative, the density its changes with pressure and temperature. The stages are those of
`solvers.sdirk`; stage i is solved for the unknowns U with the rates (U - R_i)/(gamma dt), R_i = U_n + dt sum a_ij K_j
of the earlier stages' rates K_j, by Newton's method with a new Jacobian as often as it needs one.
"""

import functools
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import ufl
from dolfinx import fem

from ..arrays import Floats
from ..equations.coupled_storage import FluidHeld, fluid_held, heating_rate, mass_storage
from ..equations.energy import EnergyEquations
from ..equations.flow import BedMeasures, FlowState
from ..errors import SolveError
from ..laws.functions import Value
from ..mesh import ranks
from ..mesh.aliases import Space
from ..mesh.deferred_forms import DeferredForm
from ..mesh.domain import BED, Domain
from .bounded_steps import MOST_REPETITIONS
from .coupled_unknowns import CoupledUnknowns
from .flow import FullFlow, constrained_unknowns, unknowns_outside
from .heating import TransientHeat
from .newton import NewtonSystem
from .newton_iterations import Iterations
from .protocols import Bounds, HeatBalance, Observer, silent, unbounded
from .sdirk import GAMMA, STAGES
from .state import ArrayOf, Saved, SavedNumbers, State
from .step_error import StepError

CONVERGED_UPDATE, MOST_ITERATIONS = 1e-8, 25
"""Relative update at which a stage counts as solved, and its iterations at most."""


class CoupledTransient:
    """Takes the place of `heat` (`TransientHeat`) in the integration; `flow` is the `FullFlow` it starts from.

    After every stage both hold the coupled solution, so that what is recorded and balanced is theirs. `energy(state,
    temperature)` gives the `EnergyEquations` of a flow state and its temperature; `flow_temperature` follows T;
    `heat_scale` (W/m3 m) brings the energy equations to the size of the flow's.
    """

    def __init__(
        self,
        domain: Domain,
        flow: FullFlow,
        heat: TransientHeat,
        energy: Callable[[FlowState, Value], EnergyEquations],
        flow_temperature: fem.Function,
        set_time: Callable[[float], None],
        heat_scale: float,
    ) -> None:
        self.domain, self.flow, self.heat = domain, flow, heat
        self.curing = heat.curing
        self._flow_temperature, self._set_time = flow_temperature, set_time
        equations = flow.equations
        self._unknowns = CoupledUnknowns(domain, flow, heat, flow_temperature)
        self._coupled, space = self._unknowns.coupled, self._unknowns.space
        self._reference = fem.Function(space)
        self._inverse_step = fem.Constant(domain.mesh, 1.0)
        now, before = ufl.split(self._coupled), ufl.split(self._reference)
        tests = ufl.TestFunctions(space)
        count = self._unknowns.flow_parts
        state, old = (equations.state_of(parts[:count]) for parts in (now, before))
        temperature, beads, test, bead_test = now[count], now[-1], tests[count], tests[-1]
        dx = flow.dx
        measures = BedMeasures(dx(BED), domain.nodal_measure()(BED))
        residual = equations.residual_of(
            state, old, tests[:count], self._inverse_step, temperature, flow.openings, measures
        )
        warm = temperature, before[count]
        residual += mass_storage(equations, state, old, warm, tests[1], self._inverse_step, dx(BED))
        live = energy(state, temperature)
        carried = live.transport(temperature, heat.frozen.streamline.monotone)
        transport = replace(carried, touching=heat.frozen.touching, streamline=heat.frozen.streamline)
        rates = [self._inverse_step * (now[part] - before[part]) for part in (count, -1)]
        warming = live.outflow_of_heat(temperature, beads, test, bead_test, transport)
        warming += heating_rate(live, temperature, beads, rates, test, bead_test)
        residual += fem.Constant(domain.mesh, 1.0 / float(heat_scale)) * warming
        nothing = fem.Constant(domain.mesh, 0.0)
        residual += nothing * sum(ufl.inner(a, b) for a, b in zip(now, tests, strict=True)) * domain.wall_measure(1)
        constrained = [constrained_unknowns(domain, space, equations.turbulent_unknowns)]
        if heat.equations.two_temperatures:
            constrained.append(unknowns_outside(domain, space, (count + 1,), BED))
        held = np.unique(np.concatenate(constrained))
        self._system = NewtonSystem("coupled", residual, self._coupled, held, keep_jacobian=True)
        self._held_forms = [DeferredForm(form) for form in fluid_held(heat.equations)]
        self.newton_iterations = 0
        self.observe: Observer = silent

    @property
    def balance(self) -> HeatBalance:
        """The heat balance, kept by `heat`."""
        return self.heat.balance

    @property
    def unknown(self) -> fem.Function:
        return self.heat.unknown

    @property
    def solution(self) -> State:
        return self.heat.solution

    @property
    def space(self) -> Space:
        return self.heat.space

    @property
    def repetitions(self) -> int:
        """Steps that were repeated to keep temperatures within bounds."""
        return self.heat.repetitions

    def observe_with(self, observe: Observer) -> None:
        """Have `observe(text)` called at every iteration; it may raise."""
        self.observe = observe

    @property
    def unknowns(self) -> int:
        """Number of unknowns solved for, those of the flow included."""
        return self._system.active_unknowns

    @property
    def estimated_error(self) -> Floats:
        """Of the owned temperatures (K), in the part of a step that the heat took last by itself."""
        return self.heat.estimated_error

    def step(self, time: float, step: float, bounds: Callable[[], Bounds] = unbounded) -> StepError:
        """One step of `step` seconds from `time`; gives its estimated error, keeps `bounds` like `TransientHeat.step`."""
        bounded = self.heat.bounded_steps
        bounded.release()
        start = self._solved.copy()
        for left in reversed(range(MOST_REPETITIONS)):
            rates = self._take(time, step)
            excess, new = bounded.mark(bounds())
            if not (excess and new and left):
                break
            bounded.repetitions += 1
            self._solved.put_back(start)
        difference = step * GAMMA * (rates[0] - 2.0 * rates[1] + rates[2])
        return StepError(self.heat.error.norm(self._unknowns.of_heat(difference)), 0.0, 3)

    @functools.cached_property
    def _solved(self) -> State:
        """What a step changes."""
        functions = {
            "heat": self.heat.unknown,
            "flow": self.flow.unknown,
            "flow_temperature": self._flow_temperature,
        }
        return State(functions, {"balance": self.balance})

    def _take(self, time: float, step: float) -> list[Floats]:
        """All stages of a step; gives their rates. The balance is brought forward."""
        self._unknowns.gather()
        self.flow.renew_inlet()
        self.heat.begin()
        before = self._held()
        start = self._coupled.x.array.copy()
        self._inverse_step.value = 1.0 / (GAMMA * step)
        rates: list[Floats] = []
        crossed = np.zeros(1)
        for stage, row in enumerate(STAGES):
            self._set_time(time + sum(row) * step)
            reference = start + step * sum(weight * rate for weight, rate in zip(row, rates, strict=False))
            self._reference.x.array[:] = reference
            self._solve(time, step)
            rates.append((self._coupled.x.array - reference) / (GAMMA * step))
            self._unknowns.scatter()
            crossed = crossed + step * STAGES[-1][stage] * self.heat.flows.here()
        after = self._held()
        # heat counts from the initial temperature; the flows count that of what leaves from the inlet's
        beyond = after.at_inlet / after.mass * (after.mass - before.mass)
        self.heat.finish(crossed, beyond, after.heat - before.heat - (after.counted - before.counted))
        return rates

    def _held(self) -> FluidHeld:
        """Values (collective)."""
        return FluidHeld(*(ranks.integral(self.domain.communicator, form.form) for form in self._held_forms))

    def _solve(self, time: float, step: float) -> None:
        def converged(update: float) -> bool:
            self.newton_iterations += 1
            self.observe("")
            return update < CONVERGED_UPDATE

        if not self._system.solve(Iterations(MOST_ITERATIONS, converged, prepare=self._renew_where_slow)):
            raise SolveError(
                "coupled transient (u, p, k, epsilon, T_f, T_s)",
                time,
                f"step of {step:.3g} s, residual {self._system.residual_norm:.3e}",
                "a smaller solver.largest_step, or where turbulence dies out model.turbulence = 'decaying-nakayama-kuwahara'",
            )

    def _renew_where_slow(self, update: float, last: float) -> None:
        if not update < 1e-2 or update > 0.3 * last:
            self._system.renew_jacobian()

    @property
    def memory(self) -> State:
        """What the next step depends on besides the `solution`."""
        return self.heat.memory

    def largest_bead_difference(self) -> float | None:
        """Beads are isothermal here."""
        return None

    def save(self) -> Saved:
        """What the heat saves, and the own iterations."""
        return Saved(self.heat.save().numbers | {"coupled_iterations": self.newton_iterations})

    def restore(self, numbers: SavedNumbers, array_of: ArrayOf) -> None:
        """Go on from what `save()` gave."""
        self.heat.restore(numbers, array_of)
        self.newton_iterations = numbers["coupled_iterations"]
