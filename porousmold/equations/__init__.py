"""UFL residuals: the physics in weak form. No PETSc, no solver, no scene."""
