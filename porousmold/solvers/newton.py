"""One nonlinear system F(x) = 0 of UFL forms, driven by PETSc SNES with a direct solver."""

import functools
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
from .field_splits import split_fields
from .multigrid import Preconditioner, Thinned, use_multigrid

_PREFIX = "porousmold_"
"""One prefix for all systems: PETSc holds 512 options at most."""

LARGEST_FACTORISED = {2: 400_000, 3: 10_000}
"""Unknowns, by dimensions of space, beyond which a system with blocks is not factorised as a whole: there the blocks need
less time and memory."""

LARGEST_FACTORISED_BY_PETSC = 20_000
"""Unknowns beyond which MUMPS is the faster one even of thin matrices (twice at 185 000)."""

# MUMPS: 14 is the head-room (in percent) for pivoting, which saddle points with pinned unknowns need; 8 scales rows and columns
# by their largest entries, which is as good here as the iterative default and saves a sixth of the factorisation
_OPTIONS = {
    # one iteration at a time: Newton's own SNES would assemble the residual at its end, and again at the next one's start
    "snes_type": "ksponly",
    "ksp_type": "preonly",
    "pc_type": "lu",
    "mat_mumps_icntl_14": 80,
    "mat_mumps_icntl_8": 4,
}


LEAST_RATIO = 1e-5
GROWN = 1.4
"""Factor on the iterations of linear systems at which their preconditioner is assembled anew."""


@dataclass
class LinearIterations:
    """Iterations that linear systems take to reduce their residual tenfold: at `first` with their preconditioner, and whether
    they have grown since."""

    first: float = 0.0
    has_grown: bool = False

    def count(self, iterations: int, reduction: float) -> None:
        """Note a system's iterations for a reduction of its residual."""
        tenfold = iterations / -np.log10(reduction)
        self.first = self.first or tenfold
        self.has_grown = self.has_grown or tenfold > GROWN * self.first + 1.0


@dataclass
class Contraction:
    """Ratio of two successive updates of Newton's method with a reused Jacobian, from the last system solved that had two; 1
    where there was none. Hairer, Wanner, Solving Ordinary Differential Equations II, section IV.8."""

    ratio: float = 1.0

    def error_after(self, update: float) -> float:
        """Error that an update leaves where it and those to come contract like that, at least by a half (equation IV.8.10)."""
        ratio = min(self.ratio, 0.5)
        return update * ratio / (1.0 - ratio)

    def age(self) -> None:
        """Trust the ratio less in another system, with the same factors or others, than in that it was measured in: as ratio^0.8
        (below equation IV.8.10), at least that of `LEAST_RATIO`: a linear system's is rounding alone."""
        self.ratio = min(max(self.ratio, LEAST_RATIO), 1.0) ** 0.8


def modified_newton(
    iterate: Callable[[], float],
    *,
    most: int,
    converged: Callable[[float], bool],
    prepare: Callable[[float, float], None] = lambda update, last: None,
    gives_up: Callable[[float, float], bool] = lambda update, last: False,
    contraction: Contraction | None = None,
) -> bool:
    """Newton's method on factors that may be kept: iterate until `converged(error)`; tells whether it is.

    `iterate()` takes one iteration with the present factors and gives its relative update, infinite where it fails; the error is
    what `contraction`, which is kept from system to system, says that it leaves, and without that the update. Before an iteration
    `prepare(update, last)` is called with the two updates before (inf where there was none), and may renew the Jacobian;
    `gives_up(update, last)` ends it, as do `most` iterations and a failed one.
    """
    update = last = float("inf")
    if contraction is not None:
        contraction.age()
    for _ in range(most):
        prepare(update, last)
        last, update = update, iterate()
        if contraction is not None and 0.0 < last < float("inf"):
            contraction.ratio = update / last
        if converged(update if contraction is None else contraction.error_after(update)):
            return True
        if gives_up(update, last) or not np.isfinite(update):
            return False
    return False


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
    """Residual form F(x; v), its derivative, and homogeneous Dirichlet conditions, solved by SNES.

    `simpler` is a residual that is the same at present where `uses_simpler` is set, and takes less to assemble.
    The unknowns `constrained` (local numbers in the function's own space, ghosts included) stay as they are in `unknown`.
    `pivoting` is needed where the diagonal may vanish, as that of the pressure does. `addend` is a PETSc vector added to
    the assembled residual. `blocks` are the unknowns of fields that may be solved for one after the other, those of the
    first one in two parts (`split_fields`); with a `preconditioner` the linear systems are iterated, as long as that converges
    (`solvers.multigrid`). The Jacobian is renewed at every iteration, or with `keep_jacobian` only when
    `renew_jacobian()` was called: then the factors serve until the next call, and `factored_at` tells what they were made
    with: (space, array) of every coefficient, and the constants' values.
    """

    def __init__(
        self,
        residual: Value,
        unknown: fem.Function,
        constrained: Integers,
        *,
        keep_jacobian: bool = False,
        pivoting: bool = True,
        blocks: Sequence[Sequence[Integers]] = (),
        preconditioner: Preconditioner | None = None,
        simpler: Value = None,
    ) -> None:
        self.unknown = unknown
        self.space = unknown.function_space
        zero = fem.Function(self.space)
        self._conditions = [fem.dirichletbc(zero, np.asarray(constrained, dtype=np.int32))]
        self.constrained = np.asarray(constrained)
        self._owned_constrained = np.asarray(constrained)[np.asarray(constrained) < self.owned_size]
        self.active_unknowns = int(ranks.total(self.space.mesh.comm, self.owned_size - len(self._owned_constrained)))
        trial = ufl.TrialFunction(self.space)
        residuals = [residual] if simpler is None else [simpler, residual]
        self._residuals = [fenicsx.DeferredForm(form) for form in residuals]
        self._jacobians = [fenicsx.DeferredForm(ufl.derivative(form, unknown, trial)) for form in residuals]
        self.uses_simpler = simpler is not None
        self._coefficients, self._constants = residual.coefficients(), residual.constants()
        self.factored_at: tuple[list[Any], list[Any]] | None = None
        self.addend: Any = None
        self._keep_jacobian, self._jacobian_due = keep_jacobian, True
        self._pivoting, self._blocks = pivoting, blocks
        self._preconditioner = preconditioner
        self._iterations = LinearIterations(has_grown=True)
        self._preconditioner_form = None if preconditioner is None else fenicsx.DeferredForm(preconditioner.form)
        self.relative_update = float("inf")
        self._vectors: list[Any] = []
        _SYSTEMS.append(weakref.ref(self))

    @property
    def _present(self) -> int:
        """Number of the residual that counts."""
        return 0 if self.uses_simpler else len(self._residuals) - 1

    def free(self) -> None:
        """Free matrix, factors and vectors (collective)."""
        for name in ("_snes", "_iterate", "_assembled", "vector", "matrix", "_nearby"):
            if name in self.__dict__:
                self.__dict__.pop(name).destroy()
        for vector in self._vectors:
            vector.destroy()
        if "_thinned" in self.__dict__:
            self.__dict__.pop("_thinned").matrix.destroy()

    def new_vector(self) -> Any:
        """A vector of the unknowns (PETSc), freed with the system: one that is dropped is never freed."""
        self._vectors.append(self._view().duplicate())
        return self._vectors[-1]

    @functools.cached_property
    def matrix(self) -> PETSc.Mat:
        """The Jacobian."""
        return fenicsx.create_matrix(self._jacobians[0].form)

    @functools.cached_property
    def _nearby(self) -> PETSc.Mat:
        """The preconditioner's matrix."""
        assert self._preconditioner_form is not None
        return fenicsx.create_matrix(self._preconditioner_form.form)

    @functools.cached_property
    def _thinned(self) -> Thinned:
        """The preconditioner's matrix without its zeros, once that is assembled."""
        return Thinned(self._nearby)

    @functools.cached_property
    def vector(self) -> PETSc.Vec:
        """The residual."""
        return self.matrix.createVecLeft()

    @functools.cached_property
    def _assembled(self) -> PETSc.Vec:
        return self._view().duplicate()

    @functools.cached_property
    def _iterate(self) -> PETSc.Vec:
        return self.matrix.createVecRight()

    @functools.cached_property
    def _snes(self) -> Any:
        snes = PETSc.SNES().create(self.space.mesh.comm)
        options = PETSc.Options()
        # PETSc's own factorisation is the faster one of small and thin matrices, but serial and without pivoting
        dimension = self.space.mesh.geometry.dim
        is_large = dimension == 3 or self.active_unknowns > LARGEST_FACTORISED_BY_PETSC
        solver = "mumps" if self._pivoting or is_large or self.space.mesh.comm.size > 1 else "petsc"
        for name, value in (_OPTIONS | {"pc_factor_mat_solver_type": solver}).items():
            options[_PREFIX + name] = value
        snes.setOptionsPrefix(_PREFIX)
        snes.setFunction(self._assemble_residual, self.vector)
        if self._preconditioner is not None:
            self._renew_matrix()
        snes.setJacobian(self._assemble_jacobian, self.matrix, self._preconditioning_matrix)
        snes.setFromOptions()
        if self._preconditioner is not None:
            fields = {name: self._owned_numbers(part) for name, part in self._preconditioner.fields.items()}
            use_multigrid(snes.getKSP(), fields)
        if self._blocks and self.active_unknowns > LARGEST_FACTORISED[dimension]:
            self._split_fields(snes.getKSP())
        return snes

    def _split_fields(self, ksp: Any) -> None:
        """Have the blocks solved for one after the other."""
        self._renew_matrix()
        ksp.setOperators(self.matrix, self.matrix)
        fields = [[self._owned_numbers(part) for part in parts] for parts in self._blocks]
        split_fields(ksp, fields, by_schur_complement=self.space.mesh.geometry.dim == 3)

    @property
    def _preconditioning_matrix(self) -> PETSc.Mat:
        return self.matrix if self._preconditioner is None else self._thinned.matrix

    def _owned_numbers(self, local: Integers) -> Integers:
        """Global numbers of those of some local unknowns that this rank owns."""
        offset = self.space.dofmap.index_map.local_range[0] * self.space.dofmap.index_map_bs
        return np.asarray(offset + local[local < self.owned_size])

    @property
    def owned_size(self) -> int:
        """Number of unknowns that this rank owns, the first of its local ones."""
        dofmap = self.space.dofmap
        return dofmap.index_map.size_local * dofmap.index_map_bs

    def renew_jacobian(self) -> None:
        """Have the next solve assemble and factorise the Jacobian anew."""
        self._jacobian_due = True

    def _store(self, x: PETSc.Vec) -> None:
        x.copy(self._view())
        self.unknown.x.scatter_forward()

    def _view(self) -> Any:
        return fenicsx.petsc_vector(self.unknown)

    def _assemble_residual(self, snes: Any, x: PETSc.Vec, residual: Value) -> None:
        self._store(x)
        self.assemble_residual_into(residual)

    def assemble_residual_into(self, residual: Value) -> None:
        """Residual of the present unknown, 0 at the held unknowns."""
        fenicsx.assemble_vector(self._assembled, self._residuals[self._present].form)
        self._assembled.copy(residual)
        if self.addend is not None:
            residual.axpy(1.0, self.addend)
        residual.array[self._owned_constrained] = 0.0

    def _assemble_jacobian(self, snes: Any, x: PETSc.Vec, matrix: PETSc.Mat, preconditioner: PETSc.Mat) -> None:
        if not self._keep_jacobian or self._jacobian_due:
            self._renew_matrix()

    def _renew_matrix(self) -> None:
        """Assemble the Jacobian at the present unknown."""
        fenicsx.assemble_matrix(self.matrix, self._jacobians[self._present].form, self._conditions)
        self._renew_preconditioner()
        self._jacobian_due = False
        if self._keep_jacobian:
            arrays = [(function.function_space, function.x.array.copy()) for function in self._coefficients]
            self.factored_at = arrays, [np.asarray(constant.value).tolist() for constant in self._constants]

    def _renew_preconditioner(self) -> None:
        """Assemble the preconditioner anew where the last systems took noticeably more iterations than those it was made for."""
        if self._preconditioner is None or self._preconditioner_form is None:
            return
        due = self._iterations.has_grown
        if due:
            self._preconditioner.renew()
            fenicsx.assemble_matrix(self._nearby, self._preconditioner_form.form, self._conditions)
            self._iterations = LinearIterations()
            if "_thinned" in self.__dict__:
                self._thinned.renew()
        if "_snes" in self.__dict__:
            self._snes.getKSP().getPC().setReusePreconditioner(not due)

    def factorise_again(self, array_of: Callable[[int, Any], Floats], constants: Sequence[Any] | None) -> None:
        """Make the Jacobian that `factored_at` (its arrays by `array_of(number, space)`) tells of, whatever the present."""
        if constants is None:
            return
        now = [function.x.array.copy() for function in self._coefficients]
        values_now = [np.array(constant.value) for constant in self._constants]
        for number, function in enumerate(self._coefficients):
            function.x.array[:] = array_of(number, function.function_space)
        self._set_constants(constants)
        self._renew_matrix()
        for function, array in zip(self._coefficients, now, strict=True):
            function.x.array[:] = array
        self._set_constants(values_now)

    def _set_constants(self, values: Sequence[Any]) -> None:
        for constant, value in zip(self._constants, values, strict=True):
            constant.value = np.asarray(value)

    def iterate(self) -> float:
        """One iteration of Newton's method, with the reused Jacobian if there is one (collective).

        Gives its relative update |dx|/|x|, infinite where the factorisation fails or the iterate is not finite; |x| counts as a
        millionth per unknown at least, so that the solution zero of scaled unknowns is recognised.
        """
        failed = self._solve_linear()
        if failed and self._preconditioner is not None:
            self._preconditioner = None  # from now on by factors
            failed = self._solve_linear()
        self._store(self._iterate)
        size = self._iterate.norm()
        if failed or not np.isfinite(size):
            self.relative_update = float("inf")
        else:
            least = 1e-6 * self._iterate.getSize() ** 0.5
            self.relative_update = float(self._snes.getSolutionUpdate().norm() / max(size, least))
        return self.relative_update

    def _solve_linear(self) -> bool:
        """Take the update from the present unknown; tells whether that failed."""
        self._view().copy(self._iterate)
        try:
            self._snes.solve(None, self._iterate)
            failed = self._snes.getConvergedReason() < 0
            if self._preconditioner is not None:
                self._iterations.count(self.linear_iterations, self._snes.getKSP().getTolerances()[0])
        except PETSc.Error:  # MUMPS reports a singular matrix (error 76) as an exception
            failed = True
        if failed:
            self._jacobian_due = True
            if "_snes" in self.__dict__:  # else the factorisation's failure sticks to later solves
                self.__dict__.pop("_snes").destroy()
        return failed

    def apply_inverse(self, vector: PETSc.Vec, result: PETSc.Vec) -> None:
        """Solve the linear system with the present Jacobian and its factors, of one right-hand side, for `result`."""
        if self._jacobian_due:  # there was nothing to solve, as in a fluid at rest
            self._renew_matrix()
            self._snes.getKSP().setOperators(self.matrix, self._preconditioning_matrix)
        vector.array[self._owned_constrained] = 0.0
        self._snes.getKSP().solve(vector, result)

    @property
    def is_iterated(self) -> bool:
        """Whether linear systems are solved by iteration."""
        return self._preconditioner is not None

    def solve_to(self, reduction: float) -> None:
        """Have iterated linear systems reduce their residual by that much."""
        if self._preconditioner is not None:
            self._snes.getKSP().setTolerances(rtol=reduction)

    @property
    def linear_iterations(self) -> Any:
        """Iterations of the last linear solve: 1 where the matrix was factorised."""
        return self._snes.getKSP().getIterationNumber()

    @property
    def residual_norm(self) -> float:
        """Residual norm at the start of the last iteration."""
        return float(self.vector.norm())
