"""One simulation: assembly of a scene into equations and solvers, the march in time, the result."""
