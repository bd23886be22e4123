"""One nonlinear system F(x) = 0 of UFL forms, driven by PETSc SNES.

SNES runs Newton's method (`newtonls`) with a reused Jacobian and a convergence test of our own: an update, and what its
contraction tells of those to come, says when a system is solved, as residuals of momentum, mass, turbulence and heat have no
common measure. Where the update says so the residual after it is not assembled: that is the larger part of an iteration with a
reused Jacobian. The full step is taken. A user's own options (`solvers.petsc_options`) replace all of that.
"""

import functools
import logging
import weakref
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from dolfinx import fem
from petsc4py import PETSc

from ..arrays import Floats, Integers
from ..laws.functions import Value
from ..mesh.aliases import Constant, Mesh, Space
from .assembled_system import AssembledSystem
from .linear_solution import FACTORISED, MUMPS_OPTIONS, LinearSolution
from .newton_iterations import Iterations
from .petsc_options import given, set_defaults

LOG = logging.getLogger(__name__)

PREFIX = "porousmold_"
"""Of all options; the name of the system follows."""

SNES_OPTIONS = {"snes_linesearch_type": "basic"}
"""The full step."""
SOLVED, GIVEN_UP = PETSc.SNES.ConvergedReason.CONVERGED_SNORM_RELATIVE, PETSc.SNES.ConvergedReason.DIVERGED_DTOL

LEAST_SIZE = 1e-6
"""That counts of every unknown, so that the solution zero of scaled unknowns is recognised."""


@dataclass(frozen=True)
class Beside:
    """What is solved for together with a system's unknown without being one of its forms' unknowns.

    `renew()` is called before every residual; `complete(update)` may change a Newton update (PETSc vector, to be subtracted from
    the unknown) before it is taken; `size_of(update)` gives the relative update that counts, from that of the unknown.
    """

    renew: Callable[[], None] = lambda: None
    complete: Callable[[Any], None] | None = None
    size_of: Callable[[float], float] = lambda update: update


_SYSTEMS: list["weakref.ref[NewtonSystem]"] = []
"""All that are alive, in the order in which they were made, which is the same on all ranks."""


def free_systems(domain: Mesh) -> None:
    """Free what PETSc holds for the systems over a mesh, which are of no more use then (collective).

    Python frees nothing of PETSc's by itself: factors would stay for as long as the process lives, 25 MB of an ordinary run.
    """
    for reference in list(_SYSTEMS):
        system = reference()
        if system is None:
            _SYSTEMS.remove(reference)
        elif system.space.mesh is domain:
            _SYSTEMS.remove(reference)
            system.free()


class NewtonSystem(AssembledSystem):
    """A system solved by SNES under the options of `name`, from the `unknown`'s present value.

    Linear systems are iterated, where `linear` says so, as long as that converges; else they are factorised. The Jacobian is
    renewed at every iteration, or with `keep_jacobian` only when `renew_jacobian()` was called: then the factors serve until
    the next call.
    """

    def __init__(
        self,
        name: str,
        residual: Value,
        unknown: fem.Function,
        constrained: Integers,
        *,
        keep_jacobian: bool = False,
        linear: LinearSolution = FACTORISED,
        simpler: Value = None,
        beside: Beside | None = None,
    ) -> None:
        super().__init__(
            residual,
            unknown,
            constrained,
            keep_jacobian=keep_jacobian,
            preconditioner=linear.preconditioner,
            simpler=simpler,
        )
        self._prefix, self._beside = f"{PREFIX}{name}_", beside or Beside()
        self._linear = linear
        self.relative_update = float("inf")
        self._iterations = Iterations(0, converged=lambda error: False)
        self._is_judged = True
        self._raised: BaseException | None = None
        _SYSTEMS.append(weakref.ref(self))

    def free(self) -> None:
        """Free matrix, factors and vectors (collective)."""
        for name in ("_snes", "_iterate"):
            if name in self.__dict__:
                self.__dict__.pop(name).destroy()
        super().free()

    @functools.cached_property
    def _iterate(self) -> PETSc.Vec:
        return self._jacobian.matrix.createVecRight()

    @functools.cached_property
    def _snes(self) -> Any:
        snes = PETSc.SNES().create(self.space.mesh.comm)
        snes.setOptionsPrefix(self._prefix)
        snes.setType("newtonls")
        set_defaults(self._prefix, SNES_OPTIONS | MUMPS_OPTIONS)
        snes.setFunction(self._assemble_residual, self.vector)
        if self._jacobian.preconditioner is not None:
            self._jacobian.renew(self._present)
        snes.setJacobian(self._assemble_jacobian, self._jacobian.matrix, self._jacobian.preconditioning_matrix)
        snes.setUpdate(lambda snes, number: self._guarded(self._iterations.begin))
        snes.setConvergenceTest(self._test)
        if self._beside.complete is not None:
            snes.setLineSearchPreCheck(self._complete)
        self._linear.factorise(snes.getKSP(), self.space, self.active_unknowns)
        snes.setFromOptions()
        self._linear.iterate_large(snes.getKSP(), self.space, self.active_unknowns, self._jacobian, self._present)
        return snes

    @functools.cached_property
    def _has_own_options(self) -> bool:
        """Whether the user has given options for SNES: then every residual is assembled."""
        return given(
            f"{self._prefix}snes_", {name.removeprefix("snes_"): value for name, value in SNES_OPTIONS.items()}
        )

    def factorise_again(self, array_of: Callable[[int, Space], Floats], constants: Sequence[Constant] | None) -> None:
        """Make the Jacobian that `factored_at` (its arrays by `array_of(number, space)`) told of, whatever the present."""
        if constants is not None:
            self._jacobian.renew_as_before(array_of, constants, self._present, self._linear_solver)

    @property
    def _linear_solver(self) -> Any:
        """The KSP, once there is one."""
        return self._snes.getKSP() if "_snes" in self.__dict__ else None

    def _assemble_residual(self, snes: PETSc.SNES, x: PETSc.Vec, residual: Value) -> None:
        if not self._is_judged and not self._has_own_options:
            self._judge(x)
            if self._is_over:
                return
        else:
            self._store(x)
        self._guarded(self._beside.renew)
        if self._raised is None:
            self.assemble_residual_into(residual)

    def _assemble_jacobian(self, snes: PETSc.SNES, x: PETSc.Vec, matrix: PETSc.Mat, preconditioner: PETSc.Mat) -> None:
        if not self._jacobian.is_kept or self._jacobian.is_due:
            self._jacobian.renew(self._present, self._linear_solver)
        self._is_judged = False

    def _complete(self, x: PETSc.Vec, update: PETSc.Vec) -> bool:
        assert self._beside.complete is not None
        self._guarded(functools.partial(self._beside.complete, update))
        return True

    def _test(self, snes: Any, number: int, norms: Sequence[float]) -> int | None:
        """SNES's convergence test: the update's verdict."""
        if number > 0 and not self._is_judged:
            self._judge(snes.getSolution())
        if not self._is_over:
            return None
        return int(SOLVED if self._iterations.is_solved else GIVEN_UP)

    @property
    def _is_over(self) -> bool:
        """Whether there is no further iteration."""
        return self._iterations.are_over or self._raised is not None

    def _judge(self, x: PETSc.Vec) -> None:
        """Take an iterate, and have the iterations' rule say whether it is the last one."""
        self._is_judged = True
        self._jacobian.count(self._snes.getKSP())
        size, update = x.norm(), float("inf")
        if np.isfinite(size):
            self._store(x)
            least = LEAST_SIZE * x.getSize() ** 0.5
            update = float(self._snes.getSolutionUpdate().norm() / max(size, least))

        def note() -> None:
            self.relative_update = self._beside.size_of(update) if np.isfinite(update) else update
            self._iterations.note(self.relative_update)

        self._guarded(note)

    def _guarded(self, function: Callable[[], None]) -> None:
        """Call what may raise: SNES is left in order, and then it is raised."""
        try:
            function()
        except BaseException as raised:
            self._raised = raised

    def solve(self, iterations: Iterations) -> bool:
        """Newton's method from the present unknown, until `iterations` are over; tells whether it is solved (collective).

        The relative update is |dx|/|x|, infinite where a factorisation fails or the iterate is not finite: the last finite one
        stays then.
        """
        self._iterations = iterations
        while not iterations.are_over:
            if not self._run_snes():
                continue
            if self._jacobian.preconditioner is not None:
                LOG.info("%s: the iteration of its linear systems fails; they are factorised from now on", self._prefix)
                self._jacobian.preconditioner = None
                continue
            self.relative_update = float("inf")
            iterations.note(self.relative_update)
        return iterations.is_solved

    def _run_snes(self) -> bool:
        """Have SNES go on from the present unknown; tells whether it failed before the iterations were over."""
        self._view().copy(self._iterate)
        self._is_judged, self._raised = True, None
        failed = False
        try:
            self._snes.setTolerances(max_it=self._iterations.most)
            self._snes.solve(None, self._iterate)
        except PETSc.Error:  # MUMPS reports a singular matrix (error 76) as an exception
            failed = True
        if self._raised is not None:
            raise self._raised
        failed = failed or not self._iterations.are_over
        if failed:
            self._jacobian.is_due = True
            if "_snes" in self.__dict__:  # else the factorisation's failure sticks to later solves
                self.__dict__.pop("_snes").destroy()
        return failed

    def iterate(self) -> float:
        """One iteration of Newton's method, with the reused Jacobian if there is one; gives its relative update (collective)."""
        self.solve(Iterations(1, converged=lambda error: True))
        return self.relative_update

    def apply_inverse(self, vector: PETSc.Vec, result: PETSc.Vec) -> None:
        """Solve the linear system with the present Jacobian and its factors, of one right-hand side, for `result`."""
        linear_solver = self._snes.getKSP()
        if self._jacobian.is_due:  # there was nothing to solve, as in a fluid at rest
            self._jacobian.renew(self._present, linear_solver)
            linear_solver.setOperators(self._jacobian.matrix, self._jacobian.preconditioning_matrix)
        vector.array[self._owned_constrained] = 0.0
        linear_solver.solve(vector, result)

    def solve_to(self, reduction: float) -> None:
        """Have iterated linear systems reduce their residual by that much."""
        if self.is_iterated:
            self._snes.getKSP().setTolerances(rtol=reduction)

    @property
    def linear_iterations(self) -> int:
        """Iterations of the last linear solve: 1 where the matrix was factorised."""
        return self._snes.getKSP().getIterationNumber()
