"""The quasi-steady flow: Newton's method, and pseudo-transient continuation where that fails."""

import logging
from collections.abc import Sequence

import numpy as np
import ufl
from dolfinx import fem

from .. import fenicsx
from ..equations.flow import FlowState
from ..errors import SolveError
from ..geometry import BED, INTERFACE, SIDE, SYMMETRY, WALL
from .newton import NewtonSystem

LOG = logging.getLogger(__name__)

CONVERGED_UPDATE = 1e-8
"""Relative update of the scaled unknown at which the flow counts as converged."""
CONVERGED_PARTS = 1e-5
"""The same of velocity, k and epsilon, each on its own."""

STAGNATED_UPDATE = 1e-5
"""The same of two iterations in succession: where k is all but 0 in coarse cells, Newton's method goes to and fro between small
values of either sign. A thousandth of what a time step of the default tolerance accepts; of parts, the same as that."""
STAGNATED_PARTS = 0.05

FIRST_PSEUDO_STEP = 0.3
ENDLESS_PSEUDO_STEP = 1e7
LEAST_PSEUDO_STEP = 1e-9
"""Pseudo-time steps, in transit times of one bead at the reference speed: the first one, that beyond which the steady
equations themselves are solved, and that below which no solution is expected."""

STEP_FACTORS = ((1e-3, 1e4), (1e-2, 40.0), (0.1, 4.0), (0.3, 2.0), (0.7, 1.2), (1.5, 0.7))
"""Factors of the next pseudo-time step, each up to a relative update of the part that changes most."""
FAILED_STEP_FACTOR = 0.125
"""Factor of a pseudo-time step after which the state is not taken."""
MOST_NEWTON_ITERATIONS, HALF_OF_THEM = 16, 8
"""Iterations of Newton's method, and those after which its updates must be below 0.7."""
MOST_PSEUDO_STEPS = 150
"""Iterations from one initial guess after which another one is tried."""
WIDE_BLEND, NARROWING = 120.0, 0.85
"""Half-width (in Re_y) of the wall layer's blend that flows are found with, and its factor on the way to a narrower one."""
LEAST_REMAINDER = 0.1
"""Part of k and epsilon that a pseudo-time step leaves at least."""

KEPT_TOLERANCE = 0.005
"""Part of the tolerance to be met with kept factors, whose last update says less of the error."""
SLOWEST_CONTRACTION = 0.7
"""Ratio of successive updates beyond which kept factors are given up."""
LOOSER_PARTS = 5.0
"""Times the tolerance that the update of every part (k, epsilon, ...) may have on its own."""
FRESH_ITERATIONS = 8
"""Iterations with a new Jacobian each before the flow is solved from its start; where turbulence sets in or dies k may pass
through negative values on the way."""

TRACE_OF_TURBULENCE = 1e-3
"""k over the reference speed squared that counts as none: its eddies are no more viscous than the fluid."""

LARGEST_UNDERSHOOT = 0.2
"""Of the largest k: negative k in single cells, behind an inlet say, counts as none in all that follows from it."""

REST_OF_TURBULENCE = 1e-5
"""Part of k and epsilon from which a laminar flow is sought."""

LEAST_VALUE = 1e-6
"""Scaled velocity or pressure that counts as none."""


def silent(text: str) -> None:
    """Observe nothing."""


class SteadyFlow:
    """The flow over the bed of a domain for a given temperature field.

    `equations` are `FlowEquations`; `openings` the inlet and outlet; `temperature` the function (K) that density and
    viscosity are taken at. The scaled unknown is `unknown`; `state` has the fields with units.

    `initial_guess()` may be replaced by a better one; `observe(text)` is called after every iteration, and may raise.
    """

    _entering: Sequence = ()
    kept_iterations = 5
    """Iterations with kept factors before the flow's Jacobian is renewed."""

    def __init__(self, domain, equations, openings, temperature, dx, sources=None, fixed=()):
        self.domain, self.equations, self.temperature = domain, equations, temperature
        turbulent = equations.model is not None
        elements = [fenicsx.lagrange_element(domain.mesh, 1, domain.mesh.geometry.dim)]
        elements += [fenicsx.lagrange_element(domain.mesh, 1)] * (3 if turbulent else 1)
        self.space = fenicsx.mixed_space(domain.mesh, elements)
        self.unknown = fem.Function(self.space)
        self._previous = fem.Function(self.space)
        self._inverse_step = fem.Constant(domain.mesh, 0.0)
        self.openings, self.dx = openings, dx
        measures = dx(BED), domain.nodal_measure()(BED)
        residual = equations.residual(
            self.unknown, self._previous, self._inverse_step, temperature, openings, *measures, sources
        )
        # the matrix needs entries for the unknowns that are held at 0 inside the wall
        nothing = fem.Constant(domain.mesh, 0.0)
        residual += nothing * ufl.inner(self.unknown, ufl.TestFunction(self.space)) * dx(WALL)
        held = np.concatenate([held_unknowns(domain, self.space, turbulent), *fixed])
        self._system = NewtonSystem(residual, self.unknown, np.unique(held), keep_jacobian=True, blocks=self._blocks())
        self.state = FlowState.of(ufl.split(self.unknown), equations.scales)
        parts = [fenicsx.collapse(self.space, part)[1] for part in range(len(elements))]
        self._take_parts(parts[:2], parts[2:])
        self._entering = [
            (opening.mean_square, *map(fenicsx.compiled_form, equations.entering(opening, self.state, temperature)))
            for opening in openings
            if opening.mean_square is not None
        ]
        self._reset_counters()

    def _take_parts(self, motion, turbulence):
        """Note the local unknowns of velocity and pressure, of k and epsilon, and the size below which each counts as 0.

        All but the pressure evolve in a false transient: it belongs to its velocity, however short the step.
        """
        self._turbulence_unknowns = np.concatenate([np.empty(0, int), *turbulence])
        self._sizes = [(part, LEAST_VALUE) for part in motion] + [(part, TRACE_OF_TURBULENCE) for part in turbulence]
        self._evolving = self._sizes[:1] + self._sizes[len(motion) :]

    def _reset_counters(self):
        self.newton_iterations = self.solves = self.continuation_steps = 0
        self.largest_undershoot = 0.0
        self._update = np.inf
        self.observe = silent

    @property
    def unknowns(self):
        """Number of unknowns solved for."""
        return self._system.active_unknowns

    @property
    def linear_iterations(self):
        """Iterations of the last linear solve: 1 where it was factorised."""
        return self._system.linear_iterations

    def initial_guess(self) -> bool:
        """Give the flow something to start from; tells whether it is so near that Newton's method should be tried."""
        self.guess_uniform()
        return self.equations.model is None

    def guess_uniform(self, velocity=1.0, turbulence_intensity=0.05):
        """Start from one (scaled) velocity along x[0] everywhere off the wall, and a uniform turbulence."""
        _, numbers = fenicsx.collapse(self.space, 0)
        values = self.unknown.x.array
        values[:] = 0.0
        values[numbers[:: self.domain.mesh.geometry.dim]] = velocity
        if self._turbulence_unknowns.size:
            for part, value in ((2, turbulence_intensity**2), (3, turbulence_intensity**2)):
                values[fenicsx.collapse(self.space, part)[1]] = value
        self._clear_held()

    def guess(self, fields):
        """Start from fields as `fields()` gives them, of any flow over the same domain."""
        for index, (name, factor) in enumerate(self._factors().items()):
            space, numbers = fenicsx.collapse(self.space, index)
            values = fem.Function(space)
            values.interpolate(fields[name])
            self.unknown.x.array[numbers] = values.x.array / factor
        self._clear_held()

    def _clear_held(self):
        self.unknown.x.array[self._system.held] = 0.0
        self.unknown.x.scatter_forward()

    def start(self, time: float = 0.0) -> None:
        """Find the steady flow from the initial guess; raises `SolveError` like `solve`.

        Where there are a laminar and a turbulent flow, the false transient, which starts from the beads' undamped
        turbulence, ends at the turbulent one.
        """
        self.solves += 1
        if not self._find_from_guess(time) and not self._find_by_narrowing(time):
            self._fail(time)

    def solve(self, time=0.0):
        """Converge the steady flow; raises `SolveError` (named with `time`) if it is not found.

        By Newton's method from the present flow; where that leads away, by a false transient from the initial guess for
        the present temperature and, in the end, by one from the present flow.
        """
        self.solves += 1
        present = self._state()
        if self._find(np.inf, time):
            return
        if self._find_from_guess(time):
            return
        self._restore(present)
        if self._find(FIRST_PSEUDO_STEP, time) or self._find_by_narrowing(time):
            return
        self._restore(present)
        self._fail(time)

    def is_turbulent(self) -> bool:
        """Whether k is more than a trace anywhere (collective)."""
        values = self.unknown.x.array[self._kinetic_energy_unknowns()]
        highest = self.domain.communicator.allreduce(float(np.max(values, initial=0.0)), op=max)
        return highest > TRACE_OF_TURBULENCE

    def is_also_laminar(self, time: float = 0.0) -> bool:
        """Whether the steady equations have a laminar solution beside the present turbulent one, which stays (collective)."""
        if not self.is_turbulent():
            return False
        present = self._state()
        self.unknown.x.array[self._turbulence_unknowns] *= REST_OF_TURBULENCE
        found = self._find(FIRST_PSEUDO_STEP, time) and not self.is_turbulent()
        self._restore(present)
        return found

    def _find_from_guess(self, time: float) -> bool:
        near = self.initial_guess()
        guess = self._state()
        if near and self._find(np.inf, time):
            return True
        self._restore(guess)
        return self._find(FIRST_PSEUDO_STEP, time)

    def _find_by_narrowing(self, time: float) -> bool:
        """Find the flow with a wide blend of the wall's layer, and follow it to the narrow one that the model asks for."""
        if self.equations.model is None:
            return False
        width = self.equations.model.blend_half_width
        wanted = float(width.value)
        if wanted >= WIDE_BLEND:
            return False
        width.value = WIDE_BLEND
        found = self._find_from_guess(time)
        while found and float(width.value) > wanted:
            width.value = max(wanted, NARROWING * float(width.value))
            found = self._find(np.inf, time) or self._find(FIRST_PSEUDO_STEP, time)
        width.value = wanted
        return found

    def _find(self, step: float, time: float) -> bool:
        """Iterate from the present flow until the steady equations are solved; tells whether they are.

        One Newton iteration for each implicit step of a false transient; the first one is `step` bead transits long, later
        ones grow as the updates fall, until they are endless. `step` = inf is Newton's method alone.
        """
        scales = self.equations.scales
        transit = float(scales.length.value / scales.speed.value)
        newton = np.isinf(step)
        for iteration in range(1, (MOST_NEWTON_ITERATIONS if newton else MOST_PSEUDO_STEPS) + 1):
            before, last = self._state(), self._update
            endless = step > ENDLESS_PSEUDO_STEP
            update = self._pseudo_step(np.inf if endless else step * transit)
            LOG.debug(
                "t = %g s: step of %.1e bead transits, update %.1e, of a part %.1e", time, step, self._update, update
            )
            self.observe(f"flow: iteration {iteration}, update {self._update:.0e}")
            if endless and self._converged(update, last):
                return True
            factor = next((factor for limit, factor in STEP_FACTORS if update < limit), FAILED_STEP_FACTOR)
            if newton:
                if not np.isfinite(update) or (iteration >= HALF_OF_THEM and factor < 1.0):
                    break
                continue
            if step < LEAST_PSEUDO_STEP:
                break
            if factor == FAILED_STEP_FACTOR:
                self._restore(before)
            if factor < 1.0 or not endless:
                step = min(step, ENDLESS_PSEUDO_STEP) * factor
        return False

    def _pseudo_step(self, step: float) -> float:
        """One Newton iteration of an implicit step (s) of a false transient, or of the steady equations where it is endless.

        Gives the relative update of the part that changes most, infinite where the iteration fails.
        """
        before = self._previous.x.array
        before[:] = self.unknown.x.array
        self._inverse_step.value = 1.0 / step
        self._system.renew_jacobian()
        self._update = self._iterate()
        self.newton_iterations += 1
        if np.isfinite(step):
            self.continuation_steps += 1
        if not np.isfinite(self._update):
            return np.inf
        if np.isfinite(step):
            numbers = self._turbulence_unknowns
            old, now = before[numbers], self.unknown.x.array[numbers]
            self.unknown.x.array[numbers] = np.where(old > 0.0, np.maximum(now, LEAST_REMAINDER * old), now)
        return self._updates(before, self._evolving)[1]

    def _converged(self, update: float, last: float) -> bool:
        """Whether the steady equations are solved; `last` is the update before the present one."""
        small = self._update < CONVERGED_UPDATE and update < CONVERGED_PARTS
        stagnated = max(self._update, last) < STAGNATED_UPDATE and update < STAGNATED_PARTS
        return (small or stagnated) and self._physical()

    def _blocks(self):
        """Unknowns of u and p, of k, and of epsilon."""
        if self.equations.model is None:
            return ()
        parts = [fenicsx.collapse(self.space, part)[1] for part in range(4)]
        return np.concatenate(parts[:2]), parts[2], parts[3]

    def renew_inlet(self) -> None:
        """Take the mean square of the present entering velocity for the inlet's total pressure (collective)."""
        for mean_square, *forms in self._entering:
            flow, moment = (self.domain.communicator.allreduce(float(fem.assemble_scalar(form))) for form in forms)
            mean_square.value = moment / flow if flow > 0.0 else 0.0

    def _iterate(self):
        """One iteration with the present factors; gives its relative update, infinite where it fails."""
        self.renew_inlet()
        converged, iterations = self._system.solve(max_iterations=1, relative_update=1e-14)
        if not iterations:  # there is nothing left to solve, as in a fluid at rest
            return 0.0 if converged else np.inf
        return self._system.relative_update

    def _updates(self, before, parts=None):
        """Update since the array `before`, relative to the geometric mean of then and now, so that growth shows like decay.

        Of all unknowns of the parts (default: all), and the largest of a part, as k and epsilon hardly count in that of all.
        """
        parts = parts or self._sizes
        squares = [
            [change @ change, now @ now, old @ old, len(now)]
            for numbers, _ in parts
            for now, old in [(self.unknown.x.array[numbers], before[numbers])]
            for change in [now - old]
        ]
        changes, values, old_values, counts = self.domain.communicator.allreduce(np.array(squares)).T
        least = np.array([trace for _, trace in parts]) ** 2 * np.maximum(counts, 1)
        of_all = np.sqrt(max(values.sum(), least.sum()) * max(old_values.sum(), least.sum()))
        of_parts = np.sqrt(np.maximum(values, least) * np.maximum(old_values, least))
        return float(np.sqrt(changes.sum() / of_all)), float(np.sqrt(np.max(changes / of_parts)))

    def extrapolate(self, previous, factor):
        """Foresee the state `factor` times as far ahead as `previous` (arrays of `functions`) lies behind."""
        turbulence = self.unknown.x.array[self._turbulence_unknowns].copy()
        for function, array in zip(self.functions, previous, strict=True):
            function.x.array[:] += factor * (function.x.array - array)
        foreseen = self.unknown.x.array[self._turbulence_unknowns]
        self.unknown.x.array[self._turbulence_unknowns] = np.maximum(foreseen, 0.3 * turbulence)

    def renew(self, time, tolerance):
        """Follow a changed temperature by Newton iterations until the update is below `tolerance`.

        The Jacobian's factors serve from step to step while updates with them fall fast; then the Jacobian is renewed.
        """
        start, last = self._state(), np.inf
        self.solves += 1
        for _ in range(self.kept_iterations):
            self._update = self._iterate()
            self.newton_iterations += 1
            self.observe("")
            if self._update < KEPT_TOLERANCE * tolerance and self._physical():
                return
            if not self._update < SLOWEST_CONTRACTION * last:
                self._restore(start)
                break
            last = self._update
        for _ in range(FRESH_ITERATIONS):
            before = self.unknown.x.array.copy()
            self._system.renew_jacobian()
            self._update = self._iterate()
            self.newton_iterations += 1
            self.observe("")
            if not np.isfinite(self._update):
                break
            if max(self._update, self._updates(before)[1] / LOOSER_PARTS) < tolerance and self._physical():
                return
        self._restore(start)
        self.solve(time)

    def _state(self):
        return [function.x.array.copy() for function in self.functions]

    def _restore(self, arrays):
        for function, array in zip(self.functions, arrays, strict=True):
            function.x.array[:] = array

    @property
    def functions(self):
        """What the state of the flow is kept in: finite-element functions to save and restore."""
        return [self.unknown]

    def factors(self):
        """What the Jacobian's kept factors were made of, as `NewtonSystem.factored_at`."""
        return self._system.factored_at

    def recall_factors(self, array_of, constants):
        """Make the factors again that `factors()` told of; `array_of(number, space)` gives the arrays (collective)."""
        self._system.factorise_again(array_of, constants)

    def fields(self):
        """Present velocity, pressure and turbulence (SI) as functions by name (collective)."""
        fields = {}
        for index, (name, factor) in enumerate(self._factors().items()):
            space, numbers = fenicsx.collapse(self.space, index)
            fields[name] = fem.Function(space, name=name)
            fields[name].x.array[:] = factor * self.unknown.x.array[numbers]
        return fields

    def _factors(self):
        """Units of the parts of the scaled unknown, by the names of the fields."""
        scales = self.equations.scales
        speed, pressure, length = (float(scale.value) for scale in (scales.speed, scales.pressure, scales.length))
        factors = {"velocity": speed, "pressure": pressure}
        if self.equations.model is not None:
            factors |= {"turbulent_kinetic_energy": speed**2, "dissipation_rate": speed**3 / length}
        return factors

    def _physical(self):
        """No NaN, and k no further below zero than a part of its largest value, or a trace of the speed squared where there is
        no turbulence. `largest_undershoot` notes the largest part that has passed."""
        if not self._turbulence_unknowns.size:
            return True
        values = self.unknown.x.array[self._kinetic_energy_unknowns()]
        low, high = (
            self.domain.communicator.allreduce(float(value), op=op)
            for value, op in ((np.min(values, initial=0.0), min), (np.max(values, initial=0.0), max))
        )
        if low < -max(LARGEST_UNDERSHOOT * high, TRACE_OF_TURBULENCE):
            return False
        if high > TRACE_OF_TURBULENCE:
            self.largest_undershoot = max(self.largest_undershoot, -low / high)
        return bool(np.isfinite(low))

    def _kinetic_energy_unknowns(self):
        return self._turbulence_unknowns[: self._turbulence_unknowns.size // 2]

    def _fail(self, time):
        self._inverse_step.value = 0.0
        raise SolveError(
            "flow (u, p, k, epsilon)",
            time,
            f"no false transient ends, residual {self._system.residual_norm:.3e}, last update {self._update:.3e}",
            "a finer mesh (solver.axial_cells, solver.first_cell), model.turbulence = 'none', or a smaller pressure drop",
        )


def held_unknowns(domain, space, turbulent):
    """Unknowns that are held at 0: velocity and k at the wall, the velocity across planes of symmetry, all in the wall."""
    held = [unknowns_outside(domain, space, range(4 if turbulent else 2), BED)]
    facet_dimension = domain.mesh.topology.dim - 1
    parts = [(space.sub(0), INTERFACE), (space.sub(0).sub(1), SYMMETRY)]
    if domain.mesh.geometry.dim == 3:
        parts.append((space.sub(0).sub(2), SIDE))
    if turbulent:
        parts.append((space.sub(2), INTERFACE))
    for part, tag in parts:
        held.append(fem.locate_dofs_topological(part, facet_dimension, domain.facets(tag)))
    return np.concatenate(held)


def unknowns_outside(domain, space, parts, tag):
    """Local unknowns of the mixed space's parts that no cell with the tag touches: where the field does not live."""
    dimension = domain.mesh.topology.dim
    outside = []
    for part in parts:
        everywhere = fenicsx.collapse(space, part)[1]
        inside = fem.locate_dofs_topological(space.sub(part), dimension, domain.cells(tag))
        outside.append(np.setdiff1d(everywhere, inside))
    return np.concatenate(outside).astype(np.int64)
