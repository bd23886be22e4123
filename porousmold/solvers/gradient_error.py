r"""How far a flow is off by cells that are too coarse for its pressure, told from the flow itself (Zienkiewicz, Zhu, Int. J.
Numer. Methods Eng. 24 (1987) 337-357).

A scalar equation of the pressure minimises dissipation, so that its mass flow at a given pressure drop is too large by the square
of the error of grad p over that of grad p, in the norm of the dissipation. The error is estimated by the difference from the
means G at the nodes,

    e = int w |grad p - G|^2 dx / int w |G|^2 dx,   w = |u|/|G|.
"""

import ufl
from dolfinx import fem

from ..equations.coordinates import Coordinates
from ..mesh import fenicsx, ranks
from ..mesh.domain import BED, Domain
from .nodal_means import NodalMeans

QUADRATURE_DEGREE = 4
NOTHING = 1e-15
"""Of a speed (m/s) and of a gradient (Pa/m), squared: keeps w finite where nothing flows."""


def gradient_error(domain: Domain, coordinates: Coordinates, pressure: fem.Function, velocity: fem.Function) -> float:
    """e of a flow's nodal pressure (Pa) and velocity (m/s) in the bed (collective)."""
    space = pressure.function_space
    means, gradient, components = NodalMeans(domain, space, coordinates.nodal_weight), ufl.grad(pressure), []
    for axis in range(domain.mesh.geometry.dim):
        components.append(fem.Function(space))
        means.take(fenicsx.compiled_form(means.form(gradient[axis])), components[-1])
    mean = ufl.as_vector(components)
    weight = ufl.sqrt((ufl.dot(velocity, velocity) + NOTHING) / (ufl.dot(mean, mean) + NOTHING))
    bed = domain.cell_measure(QUADRATURE_DEGREE)(BED)
    parts = ufl.dot(gradient - mean, gradient - mean), ufl.dot(mean, mean)
    error, whole = (
        ranks.integral(domain.communicator, fenicsx.compiled_form(coordinates.weight * weight * part * bed))
        for part in parts
    )
    return error / whole if whole > 0.0 else 0.0
