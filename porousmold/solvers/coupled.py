"""Flow, turbulence and temperatures as one transient system: the reference that the quasi-steady flow is measured against.

Every unknown keeps its time derivative, the density its changes with pressure and temperature. The stages are those of
`solvers.heating`; stage i is solved for the unknowns U with the rates (U - R_i)/(gamma dt), R_i = U_n + dt sum a_ij K_j
of the earlier stages' rates K_j, by Newton's method with a new Jacobian as often as it needs one.
"""

import numpy as np
import ufl
from dolfinx import fem

from .. import fenicsx
from ..equations.energy import Transport
from ..equations.flow import FlowState
from ..errors import SolveError
from ..geometry import BED, WALL
from .flow import held_unknowns, silent, unknowns_outside
from .heating import BACKWARD_EULER, STAGES
from .newton import NewtonSystem


class CoupledTransient:
    """Takes the place of `heat` (`TransientHeat`) in the march; `flow` is the `SteadyFlow` it starts from.

    After every stage both hold the coupled solution, so that what is recorded and balanced is theirs. `energy(state,
    temperature)` gives the `EnergyEquations` of a flow state and its temperature; `flow_temperature` follows T;
    `heat_scale` (W/m3 m) brings the energy equations to the size of the flow's.
    """

    def __init__(self, domain, flow, heat, energy, flow_temperature, set_time, heat_scale):
        self.domain, self.flow, self.heat = domain, flow, heat
        self._flow_temperature, self._set_time = flow_temperature, set_time
        equations = flow.equations
        turbulent, two = equations.model is not None, heat.equations.two_temperatures
        self._flow_parts = 4 if turbulent else 2
        scalars = self._flow_parts - 1 + (2 if two else 1)
        elements = [fenicsx.lagrange_element(domain.mesh, 1, domain.mesh.geometry.dim)]
        elements += [fenicsx.lagrange_element(domain.mesh, 1)] * scalars
        self._space = fenicsx.mixed_space(domain.mesh, elements)
        self._coupled, self._reference = fem.Function(self._space), fem.Function(self._space)
        self._inverse_step = fem.Constant(domain.mesh, 1.0)
        now, before = ufl.split(self._coupled), ufl.split(self._reference)
        tests = ufl.TestFunctions(self._space)
        count = self._flow_parts
        state, old = (FlowState.of(parts[:count], equations.scales) for parts in (now, before))
        temperature, beads, test, bead_test = now[count], now[-1], tests[count], tests[-1]
        dx = flow.dx
        measures = dx(BED), domain.nodal_measure()(BED)
        residual = equations.residual_of(state, old, tests, self._inverse_step, temperature, flow.openings, *measures)
        residual += equations.mass_storage(
            state, old, temperature, before[count], tests[1], self._inverse_step, dx(BED)
        )
        live = energy(state, temperature)
        carried = live.transport(temperature, heat.frozen.streamline.monotone)
        transport = Transport(carried.advection, carried.conduction, carried.exchange, heat.frozen.streamline)
        rates = [self._inverse_step * (now[part] - before[part]) for part in (count, -1)]
        warming = live.outflow_of_heat(temperature, beads, test, bead_test, transport)
        warming += live.heating_rate(temperature, beads, rates, test, bead_test)
        residual += fem.Constant(domain.mesh, 1.0 / float(heat_scale)) * warming
        nothing = fem.Constant(domain.mesh, 0.0)
        residual += nothing * sum(ufl.inner(a, b) for a, b in zip(now, tests, strict=True)) * dx(WALL)
        held = [held_unknowns(domain, self._space, turbulent)]
        if two:
            held.append(unknowns_outside(domain, self._space, (count + 1,), BED))
        self._system = NewtonSystem(residual, self._coupled, np.unique(np.concatenate(held)), keep_jacobian=True)
        self._parts = [fenicsx.collapse(self._space, part) for part in range(len(elements))]
        self.newton_iterations = 0
        self.observe = silent

    @property
    def balance(self):
        """The heat balance, kept by `heat`."""
        return self.heat.balance

    @balance.setter
    def balance(self, balance):
        self.heat.balance = balance

    bead_modes = None

    @property
    def unknown(self):
        return self.heat.unknown

    @property
    def functions(self):
        return self.heat.functions

    @property
    def monotone_steps(self):
        return self.heat.monotone_steps

    @property
    def space(self):
        return self.heat.space

    @property
    def repetitions(self):
        return 0

    @property
    def unknowns(self):
        """Number of unknowns solved for, those of the flow included."""
        return self._system.active_unknowns

    def _gather(self):
        """Take the unknowns of flow and heat."""
        sources = [self.flow.unknown.sub(part) for part in range(self._flow_parts)]
        heat = self.heat.unknown
        sources += [heat.sub(0), heat.sub(1)] if self.heat.equations.two_temperatures else [heat]
        for (space, numbers), source in zip(self._parts, sources, strict=True):
            values = fem.Function(space)
            values.interpolate(source)
            self._coupled.x.array[numbers] = values.x.array
        self._coupled.x.scatter_forward()

    def _scatter(self):
        """Give flow and heat the coupled unknowns."""
        targets: list = [(self.flow.unknown, self.flow.space, part) for part in range(self._flow_parts)]
        two = self.heat.equations.two_temperatures
        targets += [(self.heat.unknown, self.heat.space, part if two else None) for part in range(2 if two else 1)]
        for index, (function, space, part) in enumerate(targets):
            if part is None:
                function.interpolate(self._coupled.sub(index))
                continue
            subspace, numbers = fenicsx.collapse(space, part)
            values = fem.Function(subspace)
            values.interpolate(self._coupled.sub(index))
            function.x.array[numbers] = values.x.array
        self._flow_temperature.interpolate(self._coupled.sub(self._flow_parts))
        for function in (self.flow.unknown, self.heat.unknown, self._flow_temperature):
            function.x.scatter_forward()

    def step(self, time, step, *, after_jump=False, bounds=None):
        """One step of `step` seconds from `time`; gives the estimated error (K) like `TransientHeat.step`."""
        stages = BACKWARD_EULER if after_jump else STAGES
        gamma = stages[0][0]
        self._gather()
        self.flow.renew_inlet()
        self.heat.begin(step)
        start = self._coupled.x.array.copy()
        self._inverse_step.value = 1.0 / (gamma * step)
        rates: list[np.ndarray] = []
        flows = dict.fromkeys(self.heat.scalars, 0.0)
        for stage, row in enumerate(stages):
            self._set_time(time + sum(row) * step)
            reference = start + step * sum(weight * rate for weight, rate in zip(row, rates, strict=False))
            self._reference.x.array[:] = reference
            self._solve(time, step)
            rates.append((self._coupled.x.array - reference) / (gamma * step))
            self._scatter()
            if stage == 0:
                self.heat.note_first_stage()
            for name, form in self.heat.scalars.items():
                value = self.domain.communicator.allreduce(float(fem.assemble_scalar(form)))
                flows[name] += step * stages[-1][stage] * value
        self.heat.finish(flows)
        return 0.0 if after_jump else self.heat.estimated_error()

    def _solve(self, time, step):
        last = np.inf
        for _ in range(25):
            self.observe("")
            if not last < 1e-2:
                self._system.renew_jacobian()
            _, iterations = self._system.solve(max_iterations=1, relative_update=1e-14)
            self.newton_iterations += iterations
            update = self._system.relative_update if iterations else np.inf
            if not np.isfinite(update):
                break
            if update < 1e-8:
                return
            if update > 0.3 * last:
                self._system.renew_jacobian()
            last = update
        raise SolveError(
            "coupled transient (u, p, k, epsilon, T_f, T_s)",
            time,
            f"step of {step:.3g} s, residual {self._system.residual_norm:.3e}",
            "a smaller solver.largest_step or solver.first_step",
        )
