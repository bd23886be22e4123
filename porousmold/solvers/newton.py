"""One nonlinear system F(x) = 0 of UFL forms, driven by PETSc SNES with a direct solver."""

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from .. import fenicsx

_PREFIX = "porousmold_"
"""One prefix for all systems: PETSc holds 512 options at most."""

LARGEST_FACTORISED = {2: 400_000, 3: 40_000}
"""Unknowns, by dimensions of space, beyond which a system with blocks is not factorised as a whole: there the blocks need
less time and memory."""

# MUMPS: 14 is the head-room (in percent) for pivoting, which saddle points with pinned unknowns need.
_OPTIONS = {
    "snes_type": "newtonls",
    "snes_linesearch_type": "basic",
    # else a warm start, whose first residual is tiny, counts as diverged where it only has to move
    "snes_divergence_tolerance": -1,
    "ksp_type": "preonly",
    "pc_type": "lu",
    "mat_mumps_icntl_14": 80,
}


class NewtonSystem:
    """Residual form F(x; v), its derivative, and homogeneous Dirichlet conditions, solved by SNES.

    The unknowns `held` (local numbers in the function's own space, ghosts included) stay as they are in `unknown`.
    `pivoting` is needed where the diagonal may vanish, as that of the pressure does. `addend` is a PETSc vector added to
    the assembled residual. `blocks` are the unknowns of parts that may be factorised one after the other. The Jacobian is
    renewed at every iteration, or with `keep_jacobian` only when `renew_jacobian()` was called: then the factors serve
    until the next call, and `factored_at` tells what they were made with: (space, array) of every coefficient, and the
    constants' values.
    """

    def __init__(self, residual, unknown, held, *, keep_jacobian=False, pivoting=True, blocks=()):
        self.unknown = unknown
        self.space = unknown.function_space
        zero = fem.Function(self.space)
        self._conditions = [fem.dirichletbc(zero, np.asarray(held, dtype=np.int32))]
        self.held = np.asarray(held)
        self._held_owned = np.asarray(held)[np.asarray(held) < self._owned_size()]
        self.active_unknowns = self.space.mesh.comm.allreduce(self._owned_size() - len(self._held_owned))
        trial = ufl.TrialFunction(self.space)
        self.residual_form = fenicsx.compiled_form(residual)
        self.jacobian_form = fenicsx.compiled_form(ufl.derivative(residual, unknown, trial))
        self._coefficients, self._constants = residual.coefficients(), residual.constants()
        self.factored_at = None
        self.matrix = fenicsx.create_matrix(self.jacobian_form)
        self.vector = self.matrix.createVecLeft()
        self._assembled = self._view().duplicate()
        self.addend = None
        self._keep_jacobian, self._jacobian_due = keep_jacobian, True
        self._snes = PETSc.SNES().create(self.space.mesh.comm)
        options = PETSc.Options()
        # PETSc's own factorisation is the faster one of thin matrices, but serial and without pivoting
        dimension = self.space.mesh.geometry.dim
        solver = "mumps" if pivoting or dimension == 3 or self.space.mesh.comm.size > 1 else "petsc"
        for name, value in (_OPTIONS | {"pc_factor_mat_solver_type": solver}).items():
            options[_PREFIX + name] = value
        self._snes.setOptionsPrefix(_PREFIX)
        self._snes.setFunction(self._assemble_residual, self.vector)
        self._snes.setJacobian(self._assemble_jacobian, self.matrix)
        self._snes.setFromOptions()
        if blocks and self.active_unknowns > LARGEST_FACTORISED[dimension]:
            self._split_fields(blocks)
        self._iterate = self.matrix.createVecRight()

    def _split_fields(self, blocks):
        """Solve by GMRES, preconditioned with the factors of each block of unknowns in turn: less to factorise."""
        offset = self.space.dofmap.index_map.local_range[0] * self.space.dofmap.index_map_bs
        options = PETSc.Options()
        for number in range(len(blocks)):
            prefix = f"{_PREFIX}fieldsplit_{number}_"
            options[prefix + "ksp_type"], options[prefix + "pc_type"] = "preonly", "lu"
            options[prefix + "pc_factor_mat_solver_type"], options[prefix + "mat_mumps_icntl_14"] = "mumps", 80
        ksp = self._snes.getKSP()
        ksp.setType("fgmres")
        ksp.setGMRESRestart(60)
        ksp.setTolerances(rtol=1e-4, max_it=200)  # Newton's method gains no more by an exact one
        preconditioner = ksp.getPC()
        preconditioner.setType("fieldsplit")
        preconditioner.setFieldSplitType(PETSc.PC.CompositeType.MULTIPLICATIVE)
        for number, block in enumerate(blocks):
            owned = np.sort(block[block < self._owned_size()])
            indices = PETSc.IS().createGeneral((offset + owned).astype(PETSc.IntType), comm=self.space.mesh.comm)
            preconditioner.setFieldSplitIS((str(number), indices))

    def _owned_size(self):
        dofmap = self.space.dofmap
        return dofmap.index_map.size_local * dofmap.index_map_bs

    def renew_jacobian(self):
        """Have the next solve assemble and factorise the Jacobian anew."""
        self._jacobian_due = True

    def _store(self, x):
        x.copy(self._view())
        self.unknown.x.scatter_forward()

    def _view(self):
        return fenicsx.petsc_vector(self.unknown)

    def _assemble_residual(self, snes, x, residual):
        self._store(x)
        self.assemble_residual_into(residual)

    def assemble_residual_into(self, residual):
        """Residual of the present unknown, 0 at the held unknowns."""
        fenicsx.assemble_vector(self._assembled, self.residual_form)
        self._assembled.copy(residual)
        if self.addend is not None:
            residual.axpy(1.0, self.addend)
        residual.array[self._held_owned] = 0.0

    def _assemble_jacobian(self, snes, x, matrix, preconditioner):
        if self._keep_jacobian and not self._jacobian_due:
            return
        fenicsx.assemble_matrix(self.matrix, self.jacobian_form, self._conditions)
        self._jacobian_due = False
        if self._keep_jacobian:
            arrays = [(function.function_space, function.x.array.copy()) for function in self._coefficients]
            self.factored_at = arrays, [np.asarray(constant.value).tolist() for constant in self._constants]

    def factorise_again(self, array_of, constants):
        """Make the Jacobian that `factored_at` (its arrays by `array_of(number, space)`) tells of, whatever the present."""
        if constants is None:
            return
        now = [function.x.array.copy() for function in self._coefficients]
        values_now = [np.array(constant.value) for constant in self._constants]
        for number, function in enumerate(self._coefficients):
            function.x.array[:] = array_of(number, function.function_space)
        self._set_constants(constants)
        self._jacobian_due = True
        self._assemble_jacobian(None, None, None, None)
        for function, array in zip(self._coefficients, now, strict=True):
            function.x.array[:] = array
        self._set_constants(values_now)

    def _set_constants(self, values):
        for constant, value in zip(self._constants, values, strict=True):
            constant.value = np.asarray(value)

    def solve(self, *, max_iterations, relative_update):
        """Iterate until |dx| < relative_update |x|; give (converged, iterations).

        A factorisation that fails, a NaN or the iteration limit count as not converged; the unknown then holds the
        last iterate.
        """
        self._snes.setTolerances(rtol=1e-50, atol=1e-50, stol=relative_update, max_it=max_iterations)
        self._view().copy(self._iterate)
        try:
            self._snes.solve(None, self._iterate)
            reason = self._snes.getConvergedReason()
        except PETSc.Error:  # MUMPS reports a singular matrix (error 76) as an exception
            reason = PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE
        if reason == PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE:
            self._jacobian_due = True
            self._snes.getKSP().reset()  # else the factorisation's failure sticks to later solves
        self._store(self._iterate)
        finite = np.isfinite(self._iterate.norm())
        return bool(reason > 0 and finite), self._snes.getIterationNumber()

    def apply_inverse(self, vector):
        """Solution of the linear system with the present Jacobian and its factors, of one right-hand side (PETSc)."""
        if self._jacobian_due:  # there was nothing to solve, as in a fluid at rest
            self._assemble_jacobian(None, None, None, None)
            self._snes.getKSP().setOperators(self.matrix, self.matrix)
        vector.array[self._held_owned] = 0.0
        result = vector.duplicate()
        self._snes.getKSP().solve(vector, result)
        return result

    @property
    def linear_iterations(self):
        """Iterations of the last linear solve: 1 where the matrix was factorised."""
        return self._snes.getKSP().getIterationNumber()

    @property
    def residual_norm(self):
        """Residual norm of the last solve."""
        return self._snes.getFunctionNorm()

    @property
    def relative_update(self):
        """|dx|/|x| of the last iteration of the last solve; |x| counts as a millionth per unknown at least, so that the
        solution zero of scaled unknowns can be told."""
        least = 1e-6 * self._iterate.getSize() ** 0.5
        return self._snes.getSolutionUpdate().norm() / max(self._iterate.norm(), least)
