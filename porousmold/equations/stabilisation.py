r"""Intrinsic time scales of the residual-based stabilisation (SUPG, PSPG) on anisotropic cells.

With the metric G = 4 K^T K of the map from the reference cell (K its inverse Jacobian; G -> 4/h^2 on a rectangle's
axes), tau = [ (a.G a) + (12/4)^2 m^2 G:G + s^2 ]^-1/2 for advection a, diffusion m and reaction s: the smallest of
h/2|a|, h^2/12m and 1/s, direction by direction (Shakib, Hughes, Johan, CMAME 89 (1991) 141-219).
"""

import ufl

from ..laws.functions import Value
from ..mesh.aliases import Mesh


def metric(mesh: Mesh) -> Value:
    """G = 4 K^T K of the mesh's cells."""
    inverse = ufl.JacobianInverse(mesh)
    return 4.0 * inverse.T * inverse


def time_scale(metric_tensor: Value, advection: Value, diffusion: Value, reaction: Value) -> Value:
    """tau for a vector `advection` and scalars `diffusion` and `reaction`, in the inverse unit of `reaction`."""
    return 1.0 / ufl.sqrt(
        ufl.dot(advection, ufl.dot(metric_tensor, advection))
        + 9.0 * diffusion**2 * ufl.inner(metric_tensor, metric_tensor)
        + reaction**2
    )


def streamline_time_scale(metric_tensor: Value, advection: Value, diffusion: Value) -> Value:
    """tau = [a.G a + 9 m^2 (a.G a/|a|^2)^2]^-1/2: the cell's size along the flow only, whatever its height."""
    along = ufl.dot(advection, ufl.dot(metric_tensor, advection)) + 1e-30
    spread = diffusion * along / (ufl.dot(advection, advection) + 1e-30)
    return 1.0 / ufl.sqrt(along + 9.0 * spread**2)


def is_tensor(conductivity: Value) -> bool:
    return bool(getattr(conductivity, "ufl_shape", ()))


def flux_density(conductivity: Value, gradient: Value) -> Value:
    """K grad f of a number or a tensor K."""
    return ufl.dot(conductivity, gradient) if is_tensor(conductivity) else conductivity * gradient
