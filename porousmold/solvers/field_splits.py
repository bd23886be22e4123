"""Iterative solution of systems too large to be factorised as a whole: GMRES, preconditioned by their fields in turn.

Velocity and pressure are one field, each unknown of the turbulence is another. The turbulence is local enough for incomplete
factors: GMRES takes no more iterations than with those of MUMPS. Velocity and pressure are factorised, in three dimensions one
after the other: incompletely the velocity's own matrix A, and by MUMPS the Schur complement D - C diag(A)^-1 B of the pressure,
where B and C couple the two. In a bed the drag makes A all but diagonal. That takes two fifths of the time at 180 000 unknowns
(docs/growth.md). In two dimensions, where cells at the wall are a hundred times as long as high, GMRES does not converge on it.
Multigrid (hypre's, PETSc's) does not converge on that complement either: stabilised, it is no M-matrix.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from petsc4py import PETSc

from ..arrays import Integers
from ..mesh.aliases import Communicator
from .petsc_options import set_defaults

RESTART, MOST_ITERATIONS = 100, 300
"""Of GMRES."""
REDUCTION = 1e-2
"""Of the linear residual: Newton's method with a reused Jacobian gains no more by an exact solution, and takes half the
iterations of GMRES that 1e-4 takes."""

_INCOMPLETE: dict[str, Any] = {"ksp_type": "preonly", "pc_type": "asm", "sub_pc_type": "ilu"}
_FACTORISED: dict[str, Any] = {
    "ksp_type": "preonly",
    "pc_type": "lu",
    "pc_factor_mat_solver_type": "mumps",
    "mat_mumps_icntl_14": 80,
}


def split_fields(ksp: Any, fields: Sequence[Sequence[Integers]], *, by_schur_complement: bool) -> None:
    """Have a linear solver, whose operators are set, iterate (collective).

    fields: of each the global numbers of the unknowns that this rank owns, of the first one those of velocity and pressure apart.
    """
    prefix, communicator = f"{ksp.getOptionsPrefix()}{'schur' if by_schur_complement else 'split'}_", ksp.getComm()
    ksp.setOptionsPrefix(prefix)
    set_defaults(
        f"{prefix}fieldsplit_0_", {"ksp_type": "preonly", "pc_type": "none"} if by_schur_complement else _FACTORISED
    )
    for number in range(1, len(fields)):
        set_defaults(f"{prefix}fieldsplit_{number}_", _INCOMPLETE)
    ksp.setType("fgmres")
    ksp.setGMRESRestart(RESTART)
    ksp.setTolerances(rtol=REDUCTION, max_it=MOST_ITERATIONS)
    preconditioner = ksp.getPC()
    preconditioner.setType("fieldsplit")
    preconditioner.setFieldSplitType(PETSc.PC.CompositeType.MULTIPLICATIVE)
    unknowns = [np.sort(np.concatenate(parts)) for parts in fields]
    for number, numbers in enumerate(unknowns):
        preconditioner.setFieldSplitIS((str(number), _indices(numbers, communicator)))
    if not by_schur_complement:
        return
    ksp.setUp()  # there are no solvers of the fields before
    motion = preconditioner.getFieldSplitSubKSP()[0].getPC()
    motion.setType("fieldsplit")
    motion.setFieldSplitType(PETSc.PC.CompositeType.SCHUR)
    motion.setFieldSplitSchurFactType(PETSc.PC.SchurFactType.FULL)
    motion.setFieldSplitSchurPreType(PETSc.PC.SchurPreType.SELFP)
    first = communicator.tompi4py().exscan(len(unknowns[0])) or 0
    for name, solver, part in zip(("velocity", "pressure"), (_INCOMPLETE, _FACTORISED), fields[0], strict=True):
        set_defaults(f"{prefix}fieldsplit_0_fieldsplit_{name}_", solver)
        numbers = first + np.searchsorted(unknowns[0], np.sort(part))
        motion.setFieldSplitIS((name, _indices(numbers, communicator)))


def _indices(numbers: Integers, communicator: Communicator) -> Any:
    return PETSc.IS().createGeneral(numbers.astype(PETSc.IntType), comm=communicator)
