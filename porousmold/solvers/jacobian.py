"""The matrix of a nonlinear system: assembled when it is due, with what stands in for it in a preconditioner."""

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from petsc4py import PETSc

from ..arrays import Floats
from ..laws.functions import Value
from ..mesh import fenicsx
from ..mesh.aliases import Constant, Space
from ..mesh.deferred_forms import DeferredForm
from .multigrid import Preconditioner, Thinned

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


class Jacobian:
    """Derivatives of the forms `residuals`, of which `renew(number)` assembles one, with homogeneous `conditions`.

    Where it `is_kept` it serves until `is_due`, and `made_with` tells what it was made with: (space, array) of every coefficient
    of `residuals`, and the constants' values. The linear systems are factorised or, with a `preconditioner`, iterated.
    """

    def __init__(
        self,
        residuals: Sequence[Value],
        derivatives: Sequence[Value],
        conditions: Sequence[object],
        preconditioner: Preconditioner | None,
        *,
        is_kept: bool,
    ) -> None:
        self._forms = [DeferredForm(form) for form in derivatives]
        self._coefficients, self._constants = residuals[-1].coefficients(), residuals[-1].constants()
        self._conditions = conditions
        self.is_kept, self.is_due = is_kept, True
        self.made_with: tuple[list[Any], list[Any]] | None = None
        self.preconditioner = preconditioner
        self._iterations = LinearIterations(has_grown=True)
        self._nearby_form = None if preconditioner is None else DeferredForm(preconditioner.form)

    @functools.cached_property
    def matrix(self) -> PETSc.Mat:
        """The matrix itself."""
        return fenicsx.create_matrix(self._forms[0].form)

    @functools.cached_property
    def _nearby(self) -> PETSc.Mat:
        assert self._nearby_form is not None
        return fenicsx.create_matrix(self._nearby_form.form)

    @functools.cached_property
    def _thinned(self) -> Thinned:
        """The preconditioner's matrix without its zeros, once that is assembled."""
        return Thinned(self._nearby)

    @property
    def preconditioning_matrix(self) -> PETSc.Mat:
        """The matrix that is factorised, or whose fields are."""
        return self.matrix if self.preconditioner is None else self._thinned.matrix

    def free(self) -> None:
        """Free the matrices (collective)."""
        for name in ("matrix", "_nearby"):
            if name in self.__dict__:
                self.__dict__.pop(name).destroy()
        if "_thinned" in self.__dict__:
            self.__dict__.pop("_thinned").matrix.destroy()

    def renew(self, number: int, linear_solver: PETSc.KSP | None = None) -> None:
        """Assemble that of residual `number` at the present unknown, for a `linear_solver` (KSP) where there is one."""
        fenicsx.assemble_matrix(self.matrix, self._forms[number].form, self._conditions)
        self._renew_preconditioner(linear_solver)
        self.is_due = False
        if self.is_kept:
            arrays = [(function.function_space, function.x.array.copy()) for function in self._coefficients]
            self.made_with = arrays, [np.asarray(constant.value).tolist() for constant in self._constants]

    def _renew_preconditioner(self, linear_solver: PETSc.KSP | None) -> None:
        """Assemble the preconditioner anew where the last systems took noticeably more iterations than those it was made for."""
        if self.preconditioner is None or self._nearby_form is None:
            return
        due = self._iterations.has_grown
        if due:
            self.preconditioner.renew()
            fenicsx.assemble_matrix(self._nearby, self._nearby_form.form, self._conditions)
            self._iterations = LinearIterations()
            if "_thinned" in self.__dict__:
                self._thinned.renew()
        if linear_solver is not None:
            linear_solver.getPC().setReusePreconditioner(not due)

    def count(self, linear_solver: PETSc.KSP) -> None:
        """Note the iterations of the last linear solve."""
        if self.preconditioner is not None:
            self._iterations.count(linear_solver.getIterationNumber(), linear_solver.getTolerances()[0])

    def renew_as_before(
        self,
        array_of: Callable[[int, Space], Floats],
        constants: Sequence[Constant],
        number: int,
        linear_solver: PETSc.KSP | None,
    ) -> None:
        """Make that which `made_with` (its arrays by `array_of(number, space)`) told of, whatever the present."""
        now = [function.x.array.copy() for function in self._coefficients]
        values_now = [np.array(constant.value) for constant in self._constants]
        for index, function in enumerate(self._coefficients):
            function.x.array[:] = array_of(index, function.function_space)
        self._set_constants(constants)
        self.renew(number, linear_solver)
        for function, array in zip(self._coefficients, now, strict=True):
            function.x.array[:] = array
        self._set_constants(values_now)

    def _set_constants(self, values: Sequence[object]) -> None:
        for constant, value in zip(self._constants, values, strict=True):
            constant.value = np.asarray(value)
