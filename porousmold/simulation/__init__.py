"""One simulation: assembly of a scene into equations and solvers, the integration in time, the result."""

from ..mesh import form_language as form_language
