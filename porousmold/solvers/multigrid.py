"""Iterative solution of the temperatures in large meshes: GMRES, preconditioned by one multigrid cycle for each of them.

Direct factors of a matrix in three dimensions grow as the 1.6th power of the unknowns, incomplete ones (ILU) take more iterations
the finer the mesh and the longer the step. Here a Schur split of fluid and beads has the matrix itself for its products, and
for its two blocks the matrix of `equations.energy_blocks`, one cycle of hypre's BoomerAMG each: 6 to 15 iterations reduce the
residual by 1e-3, whatever the mesh, the step and the number of ranks.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from petsc4py import PETSc

from ..arrays import Integers
from ..laws.functions import Value
from .petsc_options import set_defaults

LEAST_UNKNOWNS = {2: 400_000, 3: 20_000}
"""Unknowns, by dimensions of space, from which it is worth its while."""
REDUCTION = 1e-4
"""Of the linear residual: Newton's method on the Jacobian of the step's start gains little by more."""
NONE = 1e-12
"""Of the largest entry of a row, that counts as zero."""
MOST_ITERATIONS, RESTART = 150, 60
_CYCLE: Mapping[str, object] = {
    "ksp_type": "preonly",
    "pc_type": "hypre",
    "pc_hypre_type": "boomeramg",
    "pc_hypre_boomeramg_strong_threshold": 0.25,
    "pc_hypre_boomeramg_coarsen_type": "HMIS",
    "pc_hypre_boomeramg_interp_type": "ext+i",
    "pc_hypre_boomeramg_P_max": 2,
    "pc_hypre_boomeramg_relax_type_down": "SOR/Jacobi",
    "pc_hypre_boomeramg_relax_type_up": "backward-SOR/Jacobi",
}


@dataclass(frozen=True)
class Preconditioner:
    """A matrix near a system's own: its bilinear `form`, whose coefficients `renew()` evaluates, and the local numbers of the
    unknowns of its `fields`, in the order in which they are eliminated."""

    form: Value
    renew: Callable[[], None]
    fields: Mapping[str, Integers]


class Thinned:
    """A matrix without the entries that were zero in another one when it was made: products at the nodes leave 7 of 27 neighbours
    in a hexahedral mesh, whose cycles take a third of the time."""

    def __init__(self, full: Any) -> None:
        self._full = full
        first, columns, values = full.getValuesCSR()
        rows = np.repeat(np.arange(len(first) - 1), np.diff(first))
        largest = np.zeros(len(first) - 1)
        np.maximum.at(largest, rows, np.abs(values))
        own = columns == rows + full.getOwnershipRange()[0]
        self._kept = np.flatnonzero((np.abs(values) > NONE * largest[rows]) | own)
        first = np.searchsorted(self._kept, first).astype(first.dtype)
        self._pattern = first, columns[self._kept]
        self.matrix = PETSc.Mat().createAIJ(
            full.getSizes(), csr=(*self._pattern, values[self._kept]), comm=full.getComm()
        )

    def renew(self) -> None:
        """Take the present values (collective)."""
        self.matrix.setValuesCSR(*self._pattern, self._full.getValuesCSR()[2][self._kept])
        self.matrix.assemble()


def use_multigrid(ksp: Any, fields: Mapping[str, Integers]) -> None:
    """Have a linear solver iterate (collective).

    fields: of each the global numbers of the unknowns that this rank owns; one field alone is not split.
    """
    # by the number of fields, as one field's would be taken for all of another system
    prefix = f"{ksp.getOptionsPrefix()}multigrid{len(fields)}_"
    ksp.setOptionsPrefix(prefix)
    ksp.setType("gmres")
    ksp.setGMRESRestart(RESTART)
    ksp.setTolerances(rtol=REDUCTION, max_it=MOST_ITERATIONS)
    preconditioner = ksp.getPC()
    if len(fields) == 1:
        set_defaults(prefix, {name: value for name, value in _CYCLE.items() if name != "ksp_type"})
        preconditioner.setFromOptions()
        return
    preconditioner.setType("fieldsplit")
    preconditioner.setFieldSplitType(PETSc.PC.CompositeType.SCHUR)
    for name, numbers in fields.items():
        set_defaults(f"{prefix}fieldsplit_{name}_", _CYCLE)
        indices = PETSc.IS().createGeneral(np.sort(numbers).astype(PETSc.IntType), comm=ksp.getComm())
        preconditioner.setFieldSplitIS((name, indices))
    preconditioner.setFieldSplitSchurFactType(PETSc.PC.SchurFactType.UPPER)
    preconditioner.setFieldSplitSchurPreType(PETSc.PC.SchurPreType.A11)
    set_defaults(prefix, {"pc_fieldsplit_diag_use_amat": True, "pc_fieldsplit_off_diag_use_amat": True})
    preconditioner.setFromOptions()
