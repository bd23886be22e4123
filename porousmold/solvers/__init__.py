"""PETSc and time stepping: how the forms are solved. No correlation and no scene here."""
