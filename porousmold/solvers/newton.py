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
import ufl
from dolfinx import fem
from petsc4py import PETSc

from ..arrays import Floats, Integers
from ..laws.functions import Value
from ..mesh import fenicsx, ranks
from ..mesh.aliases import Space
from .jacobian import Jacobian
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


def free_systems(domain: Any) -> None:
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


class NewtonSystem:
    """Residual form F(x; v), its derivative, and homogeneous Dirichlet conditions, solved by SNES under the options of `name`.

    `simpler` is a residual that is the same at present where `uses_simpler` is set, and takes less to assemble.
    The unknowns `constrained` (local numbers in the function's own space, ghosts included) stay as they are in `unknown`.
    `addend` is a PETSc vector added to the assembled residual. Linear systems are iterated, where `linear` says so, as long as
    that converges; else they are factorised. The Jacobian is renewed at every iteration, or with `keep_jacobian` only when
    `renew_jacobian()` was called: then the factors serve until the next call.
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
        self._prefix, self._beside = f"{PREFIX}{name}_", beside or Beside()
        self.unknown, self.space = unknown, unknown.function_space
        self.constrained = np.asarray(constrained)
        self._owned_constrained = self.constrained[self.constrained < self.owned_size]
        self.active_unknowns = int(ranks.total(self.space.mesh.comm, self.owned_size - len(self._owned_constrained)))
        residuals = [residual] if simpler is None else [simpler, residual]
        self._residuals = [fenicsx.DeferredForm(form) for form in residuals]
        trial, zero = ufl.TrialFunction(self.space), fem.Function(self.space)
        self._jacobian = Jacobian(
            residuals,
            [ufl.derivative(form, unknown, trial) for form in residuals],
            [fem.dirichletbc(zero, self.constrained.astype(np.int32))],
            linear.preconditioner,
            is_kept=keep_jacobian,
        )
        self.uses_simpler = simpler is not None
        self.addend: Any = None
        self._linear = linear
        self.relative_update = float("inf")
        self._iterations = Iterations(0, converged=lambda error: False)
        self._is_judged = True
        self._raised: BaseException | None = None
        self._vectors: list[Any] = []
        _SYSTEMS.append(weakref.ref(self))

    @property
    def owned_size(self) -> int:
        """Number of unknowns that this rank owns, the first of its local ones."""
        dofmap = self.space.dofmap
        return dofmap.index_map.size_local * dofmap.index_map_bs

    def free(self) -> None:
        """Free matrix, factors and vectors (collective)."""
        for name in ("_snes", "_iterate", "_assembled", "vector"):
            if name in self.__dict__:
                self.__dict__.pop(name).destroy()
        for vector in self._vectors:
            vector.destroy()
        self._jacobian.free()

    def new_vector(self) -> PETSc.Vec:
        """A vector of the unknowns (PETSc), freed with the system: one that is dropped is never freed."""
        self._vectors.append(self._view().duplicate())
        return self._vectors[-1]

    @functools.cached_property
    def vector(self) -> PETSc.Vec:
        """The residual at the start of the last iteration."""
        return self._jacobian.matrix.createVecLeft()

    @functools.cached_property
    def _assembled(self) -> PETSc.Vec:
        return self._view().duplicate()

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

    @property
    def factored_at(self) -> tuple[list[Any], list[Any]] | None:
        """What the present factors were made with (`Jacobian.made_with`), None where there are none."""
        return self._jacobian.made_with

    @factored_at.setter
    def factored_at(self, made_with: tuple[list[Any], list[Any]] | None) -> None:
        self._jacobian.made_with = made_with

    def renew_jacobian(self) -> None:
        """Have the next iteration assemble and factorise the Jacobian anew."""
        self._jacobian.is_due = True

    def factorise_again(self, array_of: Callable[[int, Space], Floats], constants: Sequence[Any] | None) -> None:
        """Make the Jacobian that `factored_at` (its arrays by `array_of(number, space)`) told of, whatever the present."""
        if constants is not None:
            self._jacobian.renew_as_before(array_of, constants, self._present, self._linear_solver)

    @property
    def _linear_solver(self) -> Any:
        """The KSP, once there is one."""
        return self._snes.getKSP() if "_snes" in self.__dict__ else None

    @property
    def _present(self) -> int:
        """Number of the residual that counts."""
        return 0 if self.uses_simpler else len(self._residuals) - 1

    def _store(self, x: PETSc.Vec) -> None:
        x.copy(self._view())
        self.unknown.x.scatter_forward()

    def _view(self) -> PETSc.Vec:
        return fenicsx.petsc_vector(self.unknown)

    def assemble_residual_into(self, residual: Value) -> None:
        """Residual of the present unknown, 0 at the held unknowns."""
        fenicsx.assemble_vector(self._assembled, self._residuals[self._present].form)
        self._assembled.copy(residual)
        if self.addend is not None:
            residual.axpy(1.0, self.addend)
        residual.array[self._owned_constrained] = 0.0

    def _assemble_residual(self, snes: Any, x: PETSc.Vec, residual: Value) -> None:
        if not self._is_judged and not self._has_own_options:
            self._judge(x)
            if self._is_over:
                return
        else:
            self._store(x)
        self._guarded(self._beside.renew)
        if self._raised is None:
            self.assemble_residual_into(residual)

    def _assemble_jacobian(self, snes: Any, x: PETSc.Vec, matrix: PETSc.Mat, preconditioner: PETSc.Mat) -> None:
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

    @property
    def is_iterated(self) -> bool:
        """Whether linear systems are solved by iteration."""
        return self._jacobian.preconditioner is not None

    def solve_to(self, reduction: float) -> None:
        """Have iterated linear systems reduce their residual by that much."""
        if self.is_iterated:
            self._snes.getKSP().setTolerances(rtol=reduction)

    @property
    def linear_iterations(self) -> int:
        """Iterations of the last linear solve: 1 where the matrix was factorised."""
        return self._snes.getKSP().getIterationNumber()

    @property
    def residual_norm(self) -> float:
        """Residual norm at the start of the last iteration."""
        return float(self.vector.norm())
