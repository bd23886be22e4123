"""How the linear systems of Newton's method are solved: factorised, by fields in turn, or iterated with multigrid."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Integers
from ..mesh.aliases import Space
from .field_splits import split_fields
from .jacobian import Jacobian
from .multigrid import Preconditioner, use_multigrid

LARGEST_FACTORISED = {2: 400_000, 3: 10_000}
"""Unknowns, by dimensions of space, beyond which a system with blocks is not factorised as a whole: there the blocks need
less time and memory."""

LARGEST_FACTORISED_BY_PETSC = 20_000
"""Unknowns beyond which MUMPS is the faster one even of thin matrices (twice at 185 000)."""

# 14 is the head-room (in percent) for pivoting, which saddle points with pinned unknowns need; 8 scales rows and columns by
# their largest entries, which is as good here as the iterative default and saves a sixth of the factorisation
MUMPS_OPTIONS = {"mat_mumps_icntl_14": 80, "mat_mumps_icntl_8": 4}


SMALLEST_PIVOT = 1e-60
"""Below it a pivot counts as zero. PETSc's own, 2e-14, is that of rows of order 1: a flow in cells of a bed of 1 mm has
smaller ones."""


@dataclass(frozen=True)
class LinearSolution:
    """`pivoting` is needed where the diagonal may vanish, as that of the pressure does. `blocks` are the local unknowns of fields
    that may be solved for one after the other, those of the first one in two parts (`split_fields`); with a `preconditioner` the
    systems are iterated (`solvers.multigrid`)."""

    pivoting: bool = True
    blocks: Sequence[Sequence[Integers]] = ()
    preconditioner: Preconditioner | None = None

    def factorise(self, linear_solver: Any, space: Space, unknowns: int) -> None:
        """Have a linear solver (KSP) factorise matrices of so many unknowns, unless the user's options say otherwise."""
        linear_solver.setType("preonly")
        linear_solver.getPC().setType("lu")
        # PETSc's own factorisation is the faster one of small and thin matrices, but serial and without pivoting
        is_large = space.mesh.geometry.dim == 3 or unknowns > LARGEST_FACTORISED_BY_PETSC
        by_mumps = self.pivoting or is_large or space.mesh.comm.size > 1
        linear_solver.getPC().setFactorSolverType("mumps" if by_mumps else "petsc")
        linear_solver.getPC().setFactorPivot(zeropivot=SMALLEST_PIVOT)

    def iterate_large(self, linear_solver: Any, space: Space, unknowns: int, jacobian: Jacobian, present: int) -> None:
        """Have large systems iterated, with the Jacobian of residual number `present` (collective)."""
        dimension = space.mesh.geometry.dim
        if jacobian.preconditioner is not None:
            use_multigrid(linear_solver, {n: _owned(space, part) for n, part in jacobian.preconditioner.fields.items()})
        if self.blocks and unknowns > LARGEST_FACTORISED[dimension]:
            jacobian.renew(present)
            linear_solver.setOperators(jacobian.matrix, jacobian.matrix)
            fields = [[_owned(space, part) for part in parts] for parts in self.blocks]
            split_fields(linear_solver, fields, by_schur_complement=dimension == 3)


FACTORISED = LinearSolution()


def _owned(space: Space, local: Integers) -> Integers:
    """Global numbers of those of some local unknowns that this rank owns."""
    dofmap = space.dofmap
    size = dofmap.index_map_bs
    return np.asarray(dofmap.index_map.local_range[0] * size + local[local < dofmap.index_map.size_local * size])
