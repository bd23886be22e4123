r"""Transient two-temperature heating: L-stable SDIRK steps of the energy equations.

Three stages, third order, L-stable and stiffly accurate (Alexander, SIAM J. Numer. Anal. 14 (1977) 1006-1021). With
S(T) the heat stored and A(T) the heat leaving (vectors against the tests), stage i solves

    [S(T_i) - S(T_n)]/(gamma dt) + A(T_i) + sum_{j<i} a_ij/gamma A(T_j) = 0,   T_{n+1} = T_3.

All stages have the same matrix; it is factorised once a step, and Newton's method iterates the residual, with its
temperature-dependent properties, to convergence on these factors. Because S is the enthalpy itself, the discrete
heat balance closes to the tolerance of that iteration. The flow is held during a step, at the temperature foreseen
for its middle, which makes the coupled method second order.
"""

from dataclasses import dataclass

import numpy as np
import ufl
from dolfinx import fem

from .. import fenicsx
from ..equations.energy import Transport
from ..equations.stabilisation import Streamline
from ..errors import SolveError
from ..geometry import BED
from .bead_modes import BeadModes
from .flow import silent, unknowns_outside
from .newton import NewtonSystem

GAMMA = 0.43586652150845899942
"""Root of gamma^3 - 3 gamma^2 + 3/2 gamma - 1/6 = 0 between 0 and 1/2."""
LAST_ROW = (-(6 * GAMMA**2 - 16 * GAMMA + 1) / 4, (6 * GAMMA**2 - 20 * GAMMA + 5) / 4, GAMMA)
STAGES: tuple[tuple[float, ...], ...] = ((GAMMA,), ((1 - GAMMA) / 2, GAMMA), LAST_ROW)
BACKWARD_EULER: tuple[tuple[float, ...], ...] = ((1.0,),)
OVERSHOOT = 0.07
"""Kelvin out of bounds at which a cell becomes monotone."""
DAMPING_PART = 0.05
"""Part of a repeated step that the backward Euler method takes first where marking cells alone did not help."""
BACKWARD_EULER_ERROR = 10.0
"""Weight of the estimated error where the backward Euler method takes the whole of a step."""
MONOTONE_STEPS = 2
"""Steps after which a cell is second order again; if it is out of bounds once more it is marked once more."""
STAGE_UPDATE = 1e-9
"""Relative update at which a stage counts as solved: 3e-7 K."""
MOST_REPETITIONS = 12


@dataclass
class HeatBalance:
    """Heat since the start (J): brought in by the fluid, through the outer wall, stored, created by REV terms."""

    by_fluid: float = 0.0
    through_outer_wall: float = 0.0
    stored: float = 0.0
    by_rev_terms: float = 0.0

    @property
    def imbalance(self):
        """What is missing, as a fraction of the heat put in (the larger of stored and brought in, at least 1e-6 J)."""
        scale = max(abs(self.by_fluid + self.through_outer_wall), abs(self.stored), 1e-6)
        return (self.by_fluid + self.through_outer_wall + self.by_rev_terms - self.stored) / scale


def either(a, b):
    """Reduction of tuples of flags for `allreduce`."""
    return tuple(x or y for x, y in zip(a, b, strict=True))


class FrozenTransport:
    """A `Transport` at the quadrature points, renewed once a step; in monotone cells the `Streamline` is that of the middle.

    That leaves the enthalpies as the only nonlinearity within a step; taken at the temperature foreseen for its middle,
    the method stays second order. `monotone` marks the cells that are to be so.
    """

    def __init__(self, domain, equations, temperature, quadrature_degree):
        cells = fenicsx.cell_constant_space(domain.mesh)
        self.monotone = fem.Function(cells)
        transport = equations.transport(temperature, self.monotone)
        along = transport.streamline
        self._cells = [
            (fem.Function(cells), fenicsx.compiled_expression(expression, cells))
            for expression in (along.fitting, along.exchange)
        ]
        given = [along.reach, along.upwind, transport.advection, transport.conduction]
        given += [transport.exchange] if transport.exchange is not None else []
        self._points = [fenicsx.PointValues(domain.mesh, expression, quadrature_degree) for expression in given]
        reach, upwind, *points = (point.value for point in self._points)
        fitting, exchange = (function for function, _ in self._cells)
        streamline = Streamline(
            reach,
            upwind,
            fitting,
            exchange,
            self.monotone,
            equations.coordinates.from_middle,
            along.across,
        )
        advection, conduction, *exchanged = points
        self.frozen = Transport(advection, conduction, exchanged[0] if exchanged else None, streamline)

    def renew(self):
        """Take the values of the present flow and temperature."""
        for function, expression in self._cells:
            function.interpolate(expression)
        for point in self._points:
            point.renew()


class TransientHeat:
    """The temperatures over a domain. `equations` are its `EnergyEquations`.

    `unknown` holds T (fluid and wall) and T_s (beads, held where there are none), or with one temperature T alone;
    `monotone_steps` counts for how many more steps a cell is monotone;
    `set_time(t)` is called before each stage to update the boundary values.
    """

    def __init__(self, domain, equations, initial_temperature, set_time, dx, property_temperature, quadrature_degree):
        self.domain, self.equations, self._set_time = domain, equations, set_time
        two = equations.two_temperatures
        element = fenicsx.lagrange_element(domain.mesh, 1)
        self.space = (
            fenicsx.mixed_space(domain.mesh, [element, element]) if two else fenicsx.lagrange_space(domain.mesh)
        )
        self.unknown = fem.Function(self.space)
        self.unknown.x.array[:] = initial_temperature
        self._start, self._first = fem.Function(self.space), fem.Function(self.space)
        if two:
            parts, tests = ufl.split(self.unknown), ufl.TestFunctions(self.space)
        else:
            parts, tests = (self.unknown,) * 2, (ufl.TestFunction(self.space),) * 2
        self.bead_modes = None
        if equations.interior is not None:
            self.bead_modes = BeadModes(domain, equations, parts, property_temperature)
        self._inverse_stage = fem.Constant(domain.mesh, 1.0)
        self._transport = FrozenTransport(domain, equations, property_temperature, quadrature_degree)
        stored = equations.stored_heat(*parts, *tests, self._transport.frozen)
        nothing = fem.Constant(domain.mesh, 0.0)
        # the matrix needs entries for the bead temperatures that are held inside the wall
        residual = self._inverse_stage * stored + equations.outflow_of_heat(*parts, *tests, self._transport.frozen)
        residual += nothing * parts[1] * tests[1] * dx
        if two:
            held = unknowns_outside(domain, self.space, (1,), BED)
            beads = np.setdiff1d(fenicsx.collapse(self.space, 1)[1], held)
            self._storing = np.concatenate([beads, unknowns_outside(domain, self.space, (0,), BED)])
        else:
            held, self._storing = np.empty(0, np.int64), np.arange(len(self.unknown.x.array))
        self._system = NewtonSystem(residual, self.unknown, held, keep_jacobian=True, pivoting=False)
        self._stored_form = fenicsx.compiled_form(stored)
        self._stored_start, self._stored_now = (fenicsx.petsc_vector(self.unknown).duplicate() for _ in range(2))
        self.scalars = {
            "by_fluid": equations.heat_input(parts[0]),
            "through_outer_wall": equations.heat_through_outer_wall(parts[0]),
            "by_rev_terms": equations.rev_heat(*parts),
        }
        self.scalars = {name: fenicsx.compiled_form(form) for name, form in self.scalars.items() if form is not None}
        self.balance = HeatBalance()
        self.observe = silent
        self.newton_iterations = 0
        self.repetitions = 0
        tables = (
            [fenicsx.dof_table(self.space.sub(part)) for part in (0, 1)] if two else [fenicsx.dof_table(self.space)]
        )
        self._cell_unknowns = np.hstack(tables)
        self.monotone_steps = fem.Function(self._transport.monotone.function_space)
        self._cell_marks = fenicsx.dof_table(self.monotone_steps.function_space)[:, 0]

    @property
    def unknowns(self):
        """Number of unknowns solved for."""
        return self._system.active_unknowns

    @property
    def functions(self):
        """What the temperatures are kept in, those inside the beads included."""
        return [self.unknown, *(self.bead_modes.functions if self.bead_modes else [])]

    def step(self, time, step, *, after_jump=False, bounds=(-np.inf, np.inf)):
        """One step of `step` seconds from `time`; gives the estimated error (K). The heat balance is brought forward.

        `after_jump` takes the backward Euler method, which damps what a jump of the inlet excites and other methods let
        swing. Where a temperature leaves `bounds` (K), the cells around it become monotone and the step is repeated, in the
        end by the backward Euler method.
        Raises `SolveError` if a stage does not converge: the balance is then as before, `functions` and `monotone_steps` are
        the caller's to put back.
        """
        self._release_cells()
        first = BACKWARD_EULER if after_jump else STAGES
        # where marking cells does not help: the fluid jumps where its equation has changed, which the backward Euler
        # method damps; and no method of higher order keeps bounds at any step
        damped, rest = (DAMPING_PART * step, BACKWARD_EULER), (1.0 - DAMPING_PART) * step
        ways = [[(step, first)], [damped, (rest, first)], [damped, (rest, BACKWARD_EULER)]]
        error, weight = 0.0, 1.0
        way, starts = 0, [function.x.array.copy() for function in self.functions]
        for left in reversed(range(MOST_REPETITIONS)):
            flows, stored = self._take_all(time, ways[way])
            _, stages = ways[way][-1]
            if stages is STAGES:
                error, weight = self.estimated_error(), 1.0
            else:  # that is an error of this method itself, far above those of the other
                weight = BACKWARD_EULER_ERROR
            out, new = self._limit_cells(bounds)
            way += not new
            if not out or way == len(ways) or not left:
                break
            self.repetitions += 1
            for function, start in zip(self.functions, starts, strict=True):
                function.x.array[:] = start
        for name, heat in flows.items():
            setattr(self.balance, name, getattr(self.balance, name) + heat)
        self.balance.stored += stored
        return weight * error

    @property
    def frozen(self):
        """The `Transport` of the present step."""
        return self._transport.frozen

    def begin(self, step):
        """Note the start of a step that another solver takes."""
        self._start.x.array[:] = self.unknown.x.array
        self._transport.renew()
        fenicsx.assemble_vector(self._stored_start, self._stored_form)

    def note_first_stage(self):
        """Note the present unknown as the first stage of such a step."""
        self._first.x.array[:] = self.unknown.x.array

    def finish(self, flows):
        """Bring the balance forward by the heat (J) that flowed during such a step."""
        fenicsx.assemble_vector(self._stored_now, self._stored_form)
        for name, heat in flows.items():
            setattr(self.balance, name, getattr(self.balance, name) + heat)
        self.balance.stored += self._stored_now.sum() - self._stored_start.sum()

    def _take_all(self, time, parts):
        """Successive (step, stages) from `time`; gives the heat (J) of each flow and the heat stored."""
        flows, stored = dict.fromkeys(self.scalars, 0.0), 0.0
        for step, stages in parts:
            more, gained = self._take(time, step, stages)
            flows = {name: heat + more[name] for name, heat in flows.items()}
            stored, time = stored + gained, time + step
        return flows, stored

    def _take(self, time, step, stages):
        """All stages of a step; gives the heat (J) of each flow and the heat stored."""
        values = self.unknown.x.array
        self._start.x.array[:] = values
        gamma = stages[0][0]
        self._inverse_stage.value = 1.0 / (gamma * step)
        if self.bead_modes:
            self.bead_modes.begin_step(self._inverse_stage.value)
        self._transport.renew()
        self._system.renew_jacobian()
        flows = dict.fromkeys(self.scalars, 0.0)
        fenicsx.assemble_vector(self._stored_start, self._stored_form)
        outflows: list = []
        for stage, row in enumerate(stages):
            self._set_time(time + sum(row) * step)
            self.observe("")
            if self.bead_modes:
                self.bead_modes.begin_stage([weight * step for weight in row[:-1]])
            addend = self._stored_start.copy()
            addend.scale(-self._inverse_stage.value)
            for weight, outflow in zip(row, outflows, strict=False):
                addend.axpy(weight / gamma, outflow)
            if stage > 0:  # first guess: the last stage's slope from the start goes on
                values[:] = self._start.x.array + (values - self._start.x.array) * sum(row) / sum(stages[stage - 1])
            self._solve_stage(time, step, addend)
            if self.bead_modes:
                self.bead_modes.end_stage()
            if stage == 0:
                self._first.x.array[:] = values
            fenicsx.assemble_vector(self._stored_now, self._stored_form)
            # A(T_i) from the stage's own equation
            outflow = self._stored_now.copy()
            outflow.scale(-self._inverse_stage.value)
            outflow.axpy(-1.0, addend)
            outflows.append(outflow)
            for name, form in self.scalars.items():
                flows[name] += step * stages[-1][stage] * self._sum(fem.assemble_scalar(form))
        return flows, self._stored_now.sum() - self._stored_start.sum()

    def _temperatures_of_cells(self):
        """Temperatures at the nodes of every local cell, held ones left out as NaN: (cells, nodes)."""
        values = self.unknown.x.array.copy()
        values[self._system.held] = np.nan
        return values[self._cell_unknowns]

    def _limit_cells(self, bounds):
        """Make the cells monotone that have a temperature out of bounds: whether there are any, and new ones, on any rank."""
        values, marks = self._temperatures_of_cells(), self._transport.monotone.x.array
        out = (values < bounds[0] - OVERSHOOT) | (values > bounds[1] + OVERSHOOT)
        out = out.any(axis=1)
        new = out & (marks[self._cell_marks] == 0.0)
        marks[self._cell_marks[new]] = 1.0
        self.monotone_steps.x.array[self._cell_marks[out]] = MONOTONE_STEPS
        return self.domain.communicator.allreduce((bool(out.any()), bool(new.any())), op=either)

    def _release_cells(self):
        """Give the cells second order again that have been monotone for a while: by then the front has spread."""
        left = self.monotone_steps.x.array
        left[:] = np.maximum(left - 1.0, 0.0)
        self._transport.monotone.x.array[:] = left > 0.0

    def _sum(self, value):
        return self.domain.communicator.allreduce(float(value))

    def _solve_stage(self, time, step, addend):
        self._system.addend = addend
        guess = self.unknown.x.array.copy()
        converged, iterations = self._system.solve(max_iterations=20, relative_update=STAGE_UPDATE)
        self.newton_iterations += iterations
        if not converged:
            self.unknown.x.array[:] = guess
            self._system.renew_jacobian()
            converged, iterations = self._system.solve(max_iterations=20, relative_update=STAGE_UPDATE)
            self.newton_iterations += iterations
        if not converged:
            raise SolveError(
                "energy (T_f, T_s, T_w)",
                time,
                f"step of {step:.3g} s, residual {self._system.residual_norm:.3e}, "
                f"last update {self._system.relative_update:.3e}",
                "a smaller solver.largest_step or solver.first_step",
            )

    def estimated_error(self):
        """Largest difference (K) between the step's end and the continuation of its first stage's slope, over all ranks.

        That is the local error of the backward Euler method, of the order dt^2 d2T/dt2. Taken over beads and wall,
        which store the heat; the fluid follows them and the inlet at once, jumps included, whatever the step.
        """
        start, first = (function.x.array[self._storing] for function in (self._start, self._first))
        straight = start + (first - start) / GAMMA
        return self.domain.communicator.allreduce(
            float(np.max(np.abs(self.unknown.x.array[self._storing] - straight), initial=0.0)), op=max
        )
