"""The quasi-steady flow over a bed: its solution, and its update as temperatures change."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from ..arrays import Floats, Integers
from ..equations.flow import BedMeasures, FlowEquations, FlowState
from ..equations.openings import Opening, entering
from ..errors import SolveError
from ..laws.functions import Value
from ..laws.turbulence_models import TurbulentUnknown
from ..mesh import fenicsx, ranks
from ..mesh.aliases import Space
from ..mesh.deferred_forms import DeferredForm
from ..mesh.domain import BED, INTERFACE, Domain
from .linear_solution import LinearSolution
from .newton import Beside, NewtonSystem
from .parts import Unknowns
from .protocols import FlowCounts, Observer
from .renewal import Renewal
from .state import ArrayOf, Arrays, Saved, SavedNumbers, State
from .steady import CAREFUL, FIRST_PSEUDO_STEP, SteadySolver

REST_OF_TURBULENCE = 1e-5
"""Part of k and epsilon from which a laminar flow is sought."""


class NonlinearFlow(ABC):
    """A flow whose steady equations are solved by a `SteadySolver`; `state` has the fields with units.

    A subclass builds its discrete system and hands it over as `solver`, with the `solution` that it is kept in.
    """

    streamfunction: fem.Function | None = None
    growth: fem.Function | None = None
    inlet: Opening | None = None
    kept_iterations = 5
    """Iterations with a reused Jacobian before the flow's Jacobian is renewed."""

    def __init__(self, equations: FlowEquations, solver: SteadySolver, state: FlowState) -> None:
        self.equations, self.solver, self.state = equations, solver, state
        self.solution = solver.solution
        self._renewal = Renewal(solver, self.kept_iterations)

    @abstractmethod
    def initial_guess(self) -> bool:
        """Give the flow something to start from; tells whether it is so near that Newton's method should be tried."""

    def initial_guesses(self) -> Iterator[bool]:
        """The initial guesses one after another, each in place when its turn comes: where no flow is found from one, the next."""
        yield self.initial_guess()

    @abstractmethod
    def fields(self) -> dict[str, fem.Function]:
        """Present velocity, pressure and turbulence (SI) as functions by name (collective)."""

    def observe_with(self, observe: Observer) -> None:
        """Have `observe(text)` called at every iteration; it may raise."""
        self.solver.observe = observe

    @property
    def unknowns(self) -> int:
        """Number of unknowns solved for."""
        return self.solver.system.active_unknowns

    @property
    def factored_at(self) -> Any:
        """What the present factors were made with."""
        return self.solver.system.factored_at

    @factored_at.setter
    def factored_at(self, made_with: Any) -> None:
        self.solver.system.factored_at = made_with

    @property
    def counts(self) -> FlowCounts:
        """What it has taken so far."""
        return self.solver.counts

    def start(self, time: float = 0.0, near: float = 0.0) -> None:
        """Find the steady flow from the initial guess, or come as `near` as `SteadySolver.find` says; raises `SolveError` (named
        with `time`).

        Where there are a laminar and a turbulent flow, the false transient, which starts from the beads' undamped
        turbulence, ends at the turbulent one.
        """
        self.counts.solves += 1
        if not self._find_from_guess(time, near) and not self._find_by_continuation(time):
            self._fail(time)
        self.found()

    def renew(self, time: float, tolerance: float) -> None:
        """Follow a changed temperature until the update is below `tolerance`; raises `SolveError` (named with `time`).

        Where Newton's method from the present flow leads away, by a careful false transient from there, from the initial guess
        for the present temperature, and in the end by a fast one from the present flow.
        """
        self.counts.solves += 1
        if not self._renewal.find(tolerance):
            present = self.solution.arrays()
            is_found = self.solver.find(FIRST_PSEUDO_STEP, time, pace=CAREFUL)
            if not is_found:
                self.solution.set(present)
            if not (is_found or self._find_from_guess(time)):
                self.solution.set(present)
                if not (self.solver.find(FIRST_PSEUDO_STEP, time) or self._find_by_continuation(time)):
                    self.solution.set(present)
                    self._fail(time)
        self.found()

    def found(self) -> None:  # noqa: B027 - most flows have nothing that follows
        """Called with every flow that is found: for what follows from it."""

    def is_turbulent(self) -> bool:
        """Whether k is more than negligible anywhere, or eddies follow from the flow itself (collective)."""
        if self.equations.model is not None and not self.equations.turbulent_unknowns:
            return True
        return self.solver.is_turbulent()

    def is_also_laminar(self, time: float = 0.0) -> bool:
        """Whether the steady equations have a laminar solution beside the present turbulent one, which stays (collective)."""
        if not self.equations.turbulent_unknowns or not self.is_turbulent():
            return False
        present = self.solution.arrays()
        self.solver.scale_turbulence(REST_OF_TURBULENCE)
        found = self.solver.find(FIRST_PSEUDO_STEP, time) and not self.is_turbulent()
        self.solution.set(present)
        return found

    def _find_from_guess(self, time: float, near: float = 0.0) -> bool:
        for starts_near in self.initial_guesses():
            guess = self.solution.arrays()
            if starts_near and self.solver.find(np.inf, time, near):
                return True
            self.solution.set(guess)
            if self.solver.find(FIRST_PSEUDO_STEP, time, near):
                return True
        return False

    def _find_by_continuation(self, time: float) -> bool:
        """Find the flow with an easy value of the turbulence model's parameter, and follow it to the wanted one."""
        model = self.equations.model
        if model is None or model.continuation is None:
            return False
        easy, factor = model.continuation.easy, model.continuation.factor
        parameter = getattr(model, model.continuation.parameter)
        wanted = float(parameter.value)
        if wanted >= easy:
            return False
        parameter.value = easy
        found = self._find_from_guess(time)
        while found and float(parameter.value) > wanted:
            parameter.value = max(wanted, factor * float(parameter.value))
            found = self.solver.find(np.inf, time) or self.solver.find(FIRST_PSEUDO_STEP, time)
        parameter.value = wanted
        return self.counts.note("continuation", found=found)

    def _fail(self, time: float) -> None:
        symbols = ", ".join(["u", "p", *(unknown.symbol for unknown in self.equations.turbulent_unknowns)])
        residual, update = self.solver.system.residual_norm, self.solver.update
        detail = f"the false transient does not converge, residual {residual:.3e}, last update {update:.3e}"
        if not np.isfinite(residual):
            detail = "its residual is not a number: a porosity, a material or a law has no value somewhere in the bed"
        cures = ["a finer mesh (porousmold check says what the wall needs)", "less flow"]
        cures += ["model.turbulence = 'none'"] if self.equations.model is not None else []
        cures += ["model.rev_terms = 'consistent' or 'off'"] if self.equations.published_pressure_term else []
        raise SolveError(f"flow ({symbols})", time, detail, " or ".join(cures[::-1]))

    def extrapolate(self, previous: Arrays, factor: float) -> None:
        """Extrapolate the solution `factor` times as far ahead as `previous` (its arrays) lies behind."""
        self.solver.extrapolate(previous, factor)

    def save(self) -> Saved:
        """What the reused Jacobian was made of, and the counts."""
        factors = self.factored_at
        numbers = {
            "counts": vars(self.counts),
            "constants_of_factors": factors[1] if factors else None,
        }
        return Saved(numbers, {f"factors/{i}": pair for i, pair in enumerate(factors[0])} if factors else {})

    def restore(self, numbers: SavedNumbers, array_of: ArrayOf) -> None:
        """Go on from what `save()` gave; the factors are made again, as iterations with others end elsewhere within their
        tolerance (collective)."""
        self.solver.counts = FlowCounts(**numbers["counts"])
        self.solver.system.factorise_again(
            lambda number, space: array_of(f"factors/{number}", space), numbers["constants_of_factors"]
        )

    def turbulent_factors(self) -> dict[str, float]:
        """Units (SI) of the scaled turbulence, by the names of its fields."""
        model, scales = self.equations.model, self.equations.scales
        if model is None:
            return {}
        sizes = model.magnitudes(float(scales.speed.value), float(scales.length.value))
        return {unknown.name: size for unknown, size in zip(model.unknowns, sizes, strict=True)}


@dataclass(frozen=True)
class Manufactured:
    """Of a manufactured solution: the `sources` of the equations that it has, and the local unknowns that are `fixed`."""

    sources: Sequence[Value] | None = None
    fixed: Sequence[Floats] = ()


class FullFlow(NonlinearFlow):
    """The flow over the bed of a domain for a given temperature field.

    `equations` are `FlowEquations`; `openings` the inlet and outlet; `temperature` the function (K) that density and
    viscosity are taken at. The scaled unknown is `unknown`. `guesses(flow)` gives better initial guesses than the uniform flow,
    and tells of each whether it is near; `simpler` is a cheaper flow over the same bed, in which a laminar flow is sought.
    """

    def __init__(
        self,
        domain: Domain,
        equations: FlowEquations,
        openings: Sequence[Opening],
        temperature: fem.Function,
        dx: ufl.Measure,
        manufactured: Manufactured | None = None,
        guesses: "Callable[[FullFlow], Iterator[bool]] | None" = None,
        simpler: NonlinearFlow | None = None,
    ) -> None:
        self.domain, self.openings, self.dx = domain, openings, dx
        self._better_guesses, self._simpler = guesses, simpler
        self.inlet = openings[0] if openings else None
        turbulence = equations.turbulent_unknowns
        elements = [fenicsx.lagrange_element(domain.mesh, 1, domain.mesh.geometry.dim)]
        elements += [fenicsx.lagrange_element(domain.mesh, 1)] * (1 + len(turbulence))
        self.space = fenicsx.mixed_space(domain.mesh, elements)
        self.unknown, previous = fem.Function(self.space), fem.Function(self.space)
        inverse_step = fem.Constant(domain.mesh, 0.0)
        measures, made = BedMeasures(dx(BED), domain.nodal_measure()(BED)), manufactured or Manufactured()
        given = temperature, openings, measures, made.sources
        residual = equations.residual(self.unknown, previous, inverse_step, *given)
        # the matrix needs entries for the unknowns that are held at 0 inside the wall
        nothing = fem.Constant(domain.mesh, 0.0)
        residual += nothing * ufl.inner(self.unknown, ufl.TestFunction(self.space)) * domain.wall_measure(1)
        constrained = np.unique(np.concatenate([constrained_unknowns(domain, self.space, turbulence), *made.fixed]))
        parts = [fenicsx.collapse(self.space, part)[1] for part in range(len(elements))]
        blocks = (parts[:2], *([part] for part in parts[2:])) if turbulence else ()
        beside, linear = Beside(renew=self.renew_inlet), LinearSolution(blocks=blocks)
        system = NewtonSystem(
            "flow", residual, self.unknown, constrained, keep_jacobian=True, linear=linear, beside=beside
        )
        state = equations.state_of(ufl.split(self.unknown))
        self._entering = [
            (opening.mean_square, *map(DeferredForm, entering(equations, opening, state, temperature)))
            for opening in openings
            if opening.mean_square is not None
        ]
        unknowns = Unknowns(parts[:2], parts[2:])
        transit = equations.scales.transit_time
        solver = SteadySolver(system, unknowns, State({"unknown": self.unknown}), previous, inverse_step, transit)
        super().__init__(equations, solver, state)

    def renew_inlet(self) -> None:
        """Take the mean square of the present entering velocity for the inlet's total pressure (collective)."""
        for mean_square, *forms in self._entering:
            flow, moment = (ranks.integral(self.domain.communicator, later.form) for later in forms)
            mean_square.value = moment / flow if flow > 0.0 else 0.0

    def initial_guess(self) -> bool:
        return next(self.initial_guesses())

    def initial_guesses(self) -> Iterator[bool]:
        self.guess_uniform()
        if self._better_guesses is None:
            yield self.equations.model is None
        else:
            yield from self._better_guesses(self)

    def is_also_laminar(self, time: float = 0.0) -> bool:
        simpler = self._simpler
        return super().is_also_laminar(time) if simpler is None else simpler.is_also_laminar(time)

    def guess_uniform(self, velocity: float = 1.0, turbulence_intensity: float = 0.05) -> None:
        """Start from one (scaled) velocity along x[0] everywhere off the wall, and a uniform turbulence."""
        _, numbers = fenicsx.collapse(self.space, 0)
        values = self.unknown.x.array
        values[:] = 0.0
        values[numbers[:: self.domain.mesh.geometry.dim]] = velocity
        values[self.solver.unknowns.of_turbulence] = turbulence_intensity**2
        self._clear_constrained()

    def guess(self, fields: Mapping[str, fem.Function]) -> None:
        """Start from fields as `fields()` gives them, of any flow over the same domain."""
        for index, (name, factor) in enumerate(self._factors().items()):
            space, numbers = fenicsx.collapse(self.space, index)
            values = fem.Function(space)
            values.interpolate(fields[name])
            self.unknown.x.array[numbers] = values.x.array / factor
        self._clear_constrained()

    def _clear_constrained(self) -> None:
        self.unknown.x.array[self.solver.system.constrained] = 0.0
        self.unknown.x.scatter_forward()

    def fields(self) -> dict[str, fem.Function]:
        fields = {}
        for index, (name, factor) in enumerate(self._factors().items()):
            space, numbers = fenicsx.collapse(self.space, index)
            fields[name] = fem.Function(space, name=name)
            fields[name].x.array[:] = factor * self.unknown.x.array[numbers]
        return fields

    def _factors(self) -> dict[str, float]:
        """Units of the parts of the scaled unknown, by the names of the fields."""
        scales = self.equations.scales
        return {
            "velocity": float(scales.speed.value),
            "pressure": float(scales.pressure.value),
        } | self.turbulent_factors()


def constrained_unknowns(domain: Domain, space: Space, turbulent_unknowns: Sequence[TurbulentUnknown]) -> Integers:
    """Unknowns that are held at 0: the velocity and what else is 0 at the wall, the velocity across planes of symmetry, all in
    the wall."""
    constrained = [unknowns_outside(domain, space, range(2 + len(turbulent_unknowns)), BED)]
    facet_dimension = domain.mesh.topology.dim - 1
    interface = domain.facets(INTERFACE)
    parts = [(space.sub(0), interface)]
    parts += [(space.sub(0).sub(axis), facets) for axis, facets in enumerate(domain.planes_of_symmetry())]
    parts += [(space.sub(2 + number), interface) for number, u in enumerate(turbulent_unknowns) if u.zero_at_wall]
    for part, facets in parts:
        constrained.append(fem.locate_dofs_topological(part, facet_dimension, facets))
    return np.concatenate(constrained)


def unknowns_outside(domain: Domain, space: Space, parts: Iterable[int], tag: int) -> Integers:
    """Local unknowns of the mixed space's parts that no cell with the tag touches: where the field does not live."""
    dimension = domain.mesh.topology.dim
    outside = []
    for part in parts:
        everywhere = fenicsx.collapse(space, part)[1]
        inside = fem.locate_dofs_topological(space.sub(part), dimension, domain.cells(tag))
        outside.append(np.setdiff1d(everywhere, inside))
    return np.concatenate(outside).astype(np.int64)
