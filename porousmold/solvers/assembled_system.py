"""One nonlinear system F(x) = 0 of UFL forms, assembled: its unknown, residual and Jacobian (`solvers.newton` solves it)."""

import functools
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from ..arrays import Integers
from ..laws.functions import Value
from ..mesh import fenicsx, ranks
from ..mesh.deferred_forms import DeferredForm
from .jacobian import Jacobian
from .multigrid import Preconditioner


class AssembledSystem:
    """Residual form F(x; v), its derivative, and homogeneous Dirichlet conditions.

    `simpler` is a residual that is the same at present where `uses_simpler` is set, and takes less to assemble.
    The unknowns `constrained` (local numbers in the function's own space, ghosts included) stay as they are in `unknown`.
    `addend` is a PETSc vector added to the assembled residual. With `keep_jacobian` the Jacobian serves until
    `renew_jacobian()` is called. `preconditioner` is None where linear systems are factorised.
    """

    def __init__(
        self,
        residual: Value,
        unknown: fem.Function,
        constrained: Integers,
        *,
        keep_jacobian: bool,
        preconditioner: Preconditioner | None,
        simpler: Value,
    ) -> None:
        self.unknown, self.space = unknown, unknown.function_space
        self.constrained = np.asarray(constrained)
        self._owned_constrained = self.constrained[self.constrained < self.owned_size]
        self.active_unknowns = int(ranks.total(self.space.mesh.comm, self.owned_size - len(self._owned_constrained)))
        residuals = [residual] if simpler is None else [simpler, residual]
        self._residuals = [DeferredForm(form) for form in residuals]
        trial, zero = ufl.TrialFunction(self.space), fem.Function(self.space)
        self._jacobian = Jacobian(
            residuals,
            [ufl.derivative(form, unknown, trial) for form in residuals],
            [fem.dirichletbc(zero, self.constrained.astype(np.int32))],
            preconditioner,
            is_kept=keep_jacobian,
        )
        self.uses_simpler = simpler is not None
        self.addend: PETSc.Vec | None = None
        self._vectors: list[Any] = []

    @property
    def owned_size(self) -> int:
        """Number of unknowns that this rank owns, the first of its local ones."""
        dofmap = self.space.dofmap
        return dofmap.index_map.size_local * dofmap.index_map_bs

    def free(self) -> None:
        """Free matrix, factors and vectors (collective)."""
        for name in ("vector", "_assembled"):
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

    @property
    def residual_norm(self) -> float:
        """Residual norm at the start of the last iteration."""
        return float(self.vector.norm())

    @functools.cached_property
    def _assembled(self) -> PETSc.Vec:
        return self._view().duplicate()

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

    @property
    def is_iterated(self) -> bool:
        """Whether linear systems are solved by iteration."""
        return self._jacobian.preconditioner is not None

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
