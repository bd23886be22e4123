r"""All sensitivities of a heating time by one adjoint sweep, beside central differences. Writes docs/adjoint.md.

Run: make adjoint (3 minutes, one core). With the heat stored S(T; p), the heat leaving A(T, U; p) and the flow's residual
F(U, T; p), where T are the temperatures, U the flow and p a parameter,

    dS/dt + A = 0,     F = 0,

the adjoint lambda of the temperature T_i of the node that is heated last follows backwards from the heating time t* by

    -M^T dlambda/dt + G^T lambda = 0,   M^T lambda(t*) = e_i,     M = S_T,   G = A_T - A_U F_U^{-1} F_T,

and with mu = F_U^{-T} A_U^T lambda, for every parameter alike,

    dT_i/dp = - integral [lambda.dS_p/dt + lambda.A_p - mu.F_p] dt,     dt*/dp = (dT_goal/dp - dT_i/dp) / (dT_i/dt).

T_goal is the inlet's temperature less or plus the margin, and moves with these two parameters only. UFL derives the matrices.
The sweep takes the steps of the run, each with an L-stable method of two stages and second order (gamma = 1 - 1/sqrt 2), and the
flow's part by iteration within a stage. A parameter's S_p, A_p and F_p are differences of the residuals of a problem that is
assembled with another value of it, at the states of the run.

For full flow, two temperatures, isothermal beads and values that do not change in time. Left out: what depends on U in S
(upwinding) and on T_f in its density, the inlet's mean square velocity, cells made monotone.
"""

import argparse
import math
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sparse
import ufl
from dolfinx import fem
from mpi4py import MPI
from numpy.typing import NDArray
from petsc4py import PETSc

from porousmold import Scene
from porousmold.equations.flow import BedMeasures
from porousmold.mesh import fenicsx
from porousmold.mesh.domain import BED
from porousmold.scene.chosen_laws import Laws
from porousmold.simulation.assembly import QUADRATURE_DEGREE, assemble
from porousmold.simulation.problem import Problem
from porousmold.simulation.specs import specs_of
from porousmold.simulation.time_integration import Simulation
from porousmold.solvers.flow import unknowns_outside
from porousmold.solvers.newton import free_systems
from porousmold.study.parameters import case_around
from porousmold.study.sensitivity import parameters_of
from studies.page import Page

HERE = Path(__file__).parent
SCENES = {"aluminium mold": "mold/aluminium.toml", "FRP mold": "mold/frp.toml", "pipe": "pipe/baseline.toml"}
GAMMA = 1.0 - math.sqrt(0.5)
COUPLING_ITERATIONS = 4
"""Of the flow's part of G within a stage; each falls by the share of the flow in the heat's change, a few per cent."""
RESIDUAL_STEP, RUN_STEP = 1e-4, 0.02
"""Relative changes of a parameter in differences of residuals, and of heating times."""

Array: TypeAlias = NDArray[Any]
Residuals: TypeAlias = tuple[list[Array], list[list[Array]]]


class Forms:
    """S, A and F of a problem with full flow, and their derivatives, at any state (T, U)."""

    def __init__(self, problem: Problem) -> None:
        medium, heat, flow = problem.medium, problem.heat, problem.flow
        domain, equations = medium.domain, heat.equations
        self.heat, self.flow = heat.unknown, flow.unknown
        self.warm = [medium.flow_temperature, medium.property_temperature]
        _, self.of_fluid = fenicsx.collapse(heat.space, 0)
        self.held = unknowns_outside(domain, heat.space, (1,), BED), flow.solver.system.constrained
        monotone = fem.Function(fenicsx.cell_constant_space(domain.mesh))
        transport = equations.transport(medium.property_temperature, monotone)
        given = *ufl.split(heat.unknown), *ufl.TestFunctions(heat.space), transport
        self._stored, self._leaving = equations.stored_heat(*given), equations.outflow_of_heat(*given)
        previous, steady = fem.Function(flow.space), fem.Constant(domain.mesh, 0.0)
        measures = BedMeasures(domain.cell_measure(QUADRATURE_DEGREE)(BED), domain.nodal_measure()(BED))
        state = flow.unknown, previous, steady, medium.flow_temperature, flow.openings
        self._flow = flow.equations.residual(*state, measures)
        forms = (self._stored, self._leaving, self._flow)
        self._compiled = [fenicsx.compiled_form(form) for form in forms]
        self._matrices: dict[str, Any] = {}

    def set(self, temperatures: Array, flow: Array) -> None:
        """Take everything at a state."""
        self.heat.x.array[:], self.flow.x.array[:] = temperatures, flow
        for function in self.warm:
            function.x.array[:] = temperatures[self.of_fluid]

    def vectors(self) -> list[Array]:
        """S, A and F here, 0 at what is held."""
        found = []
        for form, held in zip(self._compiled, (self.held[0], self.held[0], self.held[1]), strict=True):
            values = fem.assemble_vector(form)
            values = np.array(getattr(values, "array", values))
            values[held] = 0.0
            found.append(values)
        return found

    def matrices(self) -> list[sparse.csr_matrix]:
        """S_T, A_T, A_U, F_U and F_T here."""
        if not self._matrices:
            for name, form, by in (
                ("S_T", self._stored, self.heat),
                ("A_T", self._leaving, self.heat),
                ("A_flow_temperature", self._leaving, self.warm[0]),
                ("A_property_temperature", self._leaving, self.warm[1]),
                ("A_U", self._leaving, self.flow),
                ("F_U", self._flow, self.flow),
                ("F_flow_temperature", self._flow, self.warm[0]),
            ):
                derivative = ufl.derivative(form, by, ufl.TrialFunction(by.function_space))
                self._matrices[name] = fenicsx.compiled_form(derivative)
        values = {name: assembled(form) for name, form in self._matrices.items()}
        count = len(self.of_fluid)
        fluid = sparse.csr_matrix((np.ones(count), (np.arange(count), self.of_fluid)), (count, len(self.heat.x.array)))
        by_fluid = (values["A_flow_temperature"] + values["A_property_temperature"]) @ fluid
        free_heat, free_flow = (
            sparse.diags(np.isin(np.arange(len(function.x.array)), held, invert=True).astype(float))
            for function, held in zip((self.heat, self.flow), self.held, strict=True)
        )
        return [
            free_heat @ values["S_T"] @ free_heat + sparse.identity(free_heat.shape[0]) - free_heat,
            free_heat @ (values["A_T"] + by_fluid) @ free_heat,
            free_heat @ values["A_U"] @ free_flow,
            free_flow @ values["F_U"] @ free_flow + sparse.identity(free_flow.shape[0]) - free_flow,
            free_flow @ values["F_flow_temperature"] @ fluid @ free_heat,
        ]


def assembled(form: Any) -> sparse.csr_matrix:
    """The matrix of a form."""
    matrix = fenicsx.create_matrix(form)
    fenicsx.assemble_matrix(matrix, form, [])
    rows, columns, values = matrix.getValuesCSR()
    found = sparse.csr_matrix((values, columns, rows), matrix.getSize())
    matrix.destroy()
    return found


class Transposed:
    """Factors of a matrix (MUMPS) that solve with its transpose."""

    def __init__(self, matrix: sparse.csr_matrix) -> None:
        matrix = matrix.tocsr()
        self._matrix = PETSc.Mat().createAIJ(matrix.shape, csr=(matrix.indptr, matrix.indices, matrix.data))
        self._solver = PETSc.KSP().create(PETSc.COMM_SELF)
        self._solver.setType("preonly")
        self._solver.getPC().setType("lu")
        self._solver.getPC().setFactorSolverType("mumps")
        self._solver.setOperators(self._matrix)
        self._given, self._found = self._matrix.createVecs()

    def solve(self, given: Array) -> Array:
        """x with A^T x = given."""
        self._given.array[:] = given
        self._solver.solveTranspose(self._given, self._found)
        return self._found.array.copy()

    def free(self) -> None:
        """Give PETSc's memory back."""
        for part in (self._solver, self._matrix, self._given, self._found):
            part.destroy()


class Course:
    """A run's states: times (s), temperatures and flow, cut off at the heating time; `node` is what is heated last."""

    def __init__(self, scene: Scene) -> None:
        specs = specs_of(scene)
        series = specs.heat.inlet_temperature, specs.flow.driven_by
        if specs.flow.model.kind != "full" or any(one.breakpoints for one in series):
            raise ValueError("the adjoint is that of full flow, with an inlet and a drive that do not change in time")
        self.simulation = Simulation(specs, MPI.COMM_SELF)
        self.problem = self.simulation.problem
        heat, flow = self.problem.heat.unknown, self.problem.flow.unknown
        self.times, self.temperatures, self.flows = [0.0], [heat.x.array.copy()], []

        def note(now: float, _: float) -> None:
            self.times.append(now)
            self.temperatures.append(heat.x.array.copy())
            self.flows.append(flow.x.array.copy())

        self.simulation.integrate(note)
        self.heating_time = self.simulation.recorder.heating_time
        part = (self.heating_time - self.times[-2]) / (self.times[-1] - self.times[-2])
        self.temperatures[-1] = (1.0 - part) * self.temperatures[-2] + part * self.temperatures[-1]
        self.times[-1] = self.heating_time
        self.forms = Forms(self.problem)
        space, domain = self.problem.medium.flow_temperature.function_space, self.problem.domain
        wall = self.forms.of_fluid[fem.locate_dofs_topological(space, 2, domain.wall_cells)]
        distances = np.abs(self.temperatures[-1] - self.simulation.specs.heat.inlet_temperature(self.heating_time))
        self.node = wall[np.argmax(distances[wall])]

    def steps(self) -> Iterator[tuple[float, Array, Array]]:
        """Length (s) of every step, temperatures in its middle, and its flow."""
        for number, flow in enumerate(self.flows):
            ends = self.temperatures[number : number + 2]
            yield self.times[number + 1] - self.times[number], 0.5 * (ends[0] + ends[1]), flow


class Sweep:
    """The adjoint of a course: `heat` lambda and `flow` mu of every step, `rate` dT_i/dt (K/s) at the end."""

    def __init__(self, course: Course) -> None:
        forms, steps = course.forms, list(course.steps())
        forms.set(course.temperatures[-1], course.flows[-1])
        factors = Transposed(forms.matrices()[0])
        present = factors.solve(np.eye(1, len(forms.heat.x.array), course.node)[0])
        factors.free()
        self.rate = -float(present @ forms.vectors()[1])
        self.heat: list[Array] = []
        self.flow: list[Array] = []
        for step, temperatures, flow in reversed(steps):
            forms.set(temperatures, flow)
            present = self._back(present, step, forms)
        self.heat.reverse()
        self.flow.reverse()

    def _back(self, present: Array, step: float, forms: Forms) -> Array:
        """lambda at a step's begin from that at its end."""
        stored, leaving, by_flow, of_flow, by_heat = forms.matrices()
        flow, stage = Transposed(of_flow), Transposed(stored + GAMMA * step * leaving)

        def through_flow(values: Array) -> Array:
            return by_heat.T @ flow.solve(by_flow.T @ values)

        def solve(right: Array) -> Array:
            found = stage.solve(right)
            for _ in range(COUPLING_ITERATIONS):
                found = stage.solve(right + GAMMA * step * through_flow(found))
            return found

        first = solve(stored.T @ present)
        last = solve(stored.T @ present - (1.0 - GAMMA) * step * (leaving.T @ first - through_flow(first)))
        self.heat.append((1.0 - GAMMA) * first + GAMMA * last)
        self.flow.append(flow.solve(by_flow.T @ self.heat[-1]))
        flow.free()
        stage.free()
        return last


def with_factor(scene: Scene, name: str, value: float, factor: float) -> Scene:
    """The scene with another value of a parameter: the inlet's temperature counts from the initial one."""
    initial = scene.operation.initial_temperature if name == "operation.inlet_temperature" else 0.0
    return case_around(scene, name, {name: float(initial + (value - initial) * factor)}).scene


def units_of(own: Problem, other: Problem) -> Array:
    """What a flow of one's own problem is to be multiplied by in another, which is given the same scales; its own unit of length
    is the bead diameter, which may differ."""
    for name in ("speed", "pressure"):
        getattr(other.medium.equations.scales, name).value = getattr(own.medium.equations.scales, name).value
    other.medium.boundary.set(0.0)
    for opening, mine in zip(other.flow.openings, own.flow.openings, strict=True):
        if mine.mean_square is not None:
            opening.mean_square.value = mine.mean_square.value
    factors = np.ones(len(own.flow.unknown.x.array))
    sizes = zip(own.flow.turbulent_factors().values(), other.flow.turbulent_factors().values(), strict=True)
    for part, (mine, its) in zip(own.flow.solver.unknowns.turbulence, sizes, strict=True):
        factors[part] = mine / its
    return factors


def residuals(course: Course, forms: Forms, units: Array | float = 1.0) -> Residuals:
    """S at all times, A and F of all steps; `units` multiply the flow."""
    stored = []
    for number, temperatures in enumerate(course.temperatures):
        forms.set(temperatures, units * course.flows[max(number - 1, 0)])
        stored.append(forms.vectors()[0])
    others = []
    for _, temperatures, flow in course.steps():
        forms.set(temperatures, units * flow)
        others.append(forms.vectors()[1:])
    return stored, others


def residuals_with(scene: Scene, course: Course, name: str, value: float, factor: float) -> Residuals | None:
    """The same of a problem with `factor` times a parameter's value; None where that has another mesh."""
    other = assemble(specs_of(with_factor(scene, name, value, factor)), MPI.COMM_SELF)
    try:
        if len(other.heat.unknown.x.array) != len(course.temperatures[0]):
            return None
        return residuals(course, Forms(other), units_of(course.problem, other))
    finally:
        free_systems(other.domain.mesh)


def follows_temperature(scene: Scene, name: str) -> bool:
    """Whether a parameter is a property of beads or wall that the scene's material has as a law of the temperature."""
    table, _, property_name = name.partition(".")
    laws = Laws.of(scene)
    solid = {"wall": laws.walls.get("wall"), "bed": laws.beads}.get(table)
    law = getattr(solid, property_name.removeprefix("bead_"), None)
    return callable(law) and law(300.0) != law(350.0)


def elasticity(scene: Scene, course: Course, sweep: Sweep, own: Residuals, name: str, value: float) -> float | None:
    """d ln t*/d ln p by the adjoint; None where another value of the parameter makes another mesh."""
    changed = residuals_with(scene, course, name, value, 1.0 + RESIDUAL_STEP)
    if changed is None:
        return None
    if follows_temperature(scene, name):  # a value is a constant in its place
        own = residuals_with(scene, course, name, value, 1.0) or own
    stored, others = changed
    change = 0.0
    for number, (step, *_) in enumerate(course.steps()):
        (leaving, flow), (own_leaving, own_flow) = others[number], own[1][number]
        gained = [stored[number + end] - own[0][number + end] for end in (0, 1)]
        change -= sweep.heat[number] @ (gained[1] - gained[0] + step * (leaving - own_leaving))
        change += step * sweep.flow[number] @ (flow - own_flow)
    operation = scene.operation
    rise = operation.inlet_temperature(0.0) - operation.initial_temperature
    goals = {"operation.inlet_temperature": rise, "operation.heating_margin": -math.copysign(value, rise)}
    goal = goals.get(name, 0.0)
    return -(change / RESIDUAL_STEP - goal) / sweep.rate / course.heating_time


def difference(scene: Scene, name: str, value: float) -> float:
    """The same by two runs."""
    times = []
    for factor in (1.0 + RUN_STEP, 1.0 / (1.0 + RUN_STEP)):
        simulation = Simulation(specs_of(with_factor(scene, name, value, factor)), MPI.COMM_SELF).integrate()
        times.append(simulation.recorder.heating_time)
        simulation.free()
    return math.log(times[0] / times[1]) / (2.0 * math.log(1.0 + RUN_STEP))


def scene_table(page: Page, title: str, scene: Scene) -> None:
    """Both kinds of elasticities of a scene, and what they take."""
    first = Course(scene)
    first.forms.matrices()  # compiled before anything is timed
    free_systems(first.problem.domain.mesh)
    start = time.perf_counter()
    course = Course(scene)
    ran = time.perf_counter()
    sweep = Sweep(course)
    swept = time.perf_counter()
    own = residuals(course, course.forms)
    parameters = parameters_of(scene)
    found = {name: elasticity(scene, course, sweep, own, name, value) for name, value in parameters.items()}
    ended = time.perf_counter()
    page.add("", f"## {title}", "", f"Heating time {course.heating_time:.1f} s.")
    page.head("parameter", "by the adjoint", "by two runs")
    compared = {name: difference(scene, name, parameters[name]) for name, value in found.items() if value is not None}
    differed = time.perf_counter()
    for name, value in found.items():
        page.row(name, *(("another mesh", "") if value is None else (f"{value:.4f}", f"{compared[name]:.4f}")))
    errors = [abs(found[name] - other) for name, other in compared.items()]
    page.add(
        "",
        f"Largest difference {max(errors):.3f}. Run {ran - start:.1f} s, adjoint {swept - ran:.1f} s, {len(found)} parameters "
        f"{ended - swept:.1f} s; {2 * len(compared)} runs {differed - ended:.1f} s.",
    )
    free_systems(course.problem.domain.mesh)


def main() -> None:
    """Compare on all scenes and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=HERE.parent / "docs" / "adjoint.md")
    options = parser.parse_args()
    page = Page(
        "# Sensitivities by an adjoint",
        "",
        "Written by `make adjoint`; do not edit. Elasticities d ln t/d ln p of the heating time: all of them by one sweep",
        "backwards through the stored run, whose equations UFL derives (`studies/adjoint.py`), and by two runs each, of 1.02",
        "times the parameter and its 1.02th part. Default mesh and steps, one core, forms compiled before. A parameter's time",
        "is the assembly of the problem that its residuals are taken from, and these residuals. `porousmold sensitivity`",
        "takes two coarser runs for each parameter, on all cores.",
    )
    for title, path in SCENES.items():
        scene_table(page, title, Scene.load(HERE / path))
        page.write(options.out)


if __name__ == "__main__":
    main()
