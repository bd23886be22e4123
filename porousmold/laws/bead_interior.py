r"""Temperature inside a bead: how far its surface is from its mean.

A bead of radius R takes up the flux q(t) through its surface and conducts it inwards (Forgber, Radl, table 1),

    rho C dT/dt = 1/r^2 d/dr (r^2 lambda dT/dr),   lambda dT/dr = q at r = R.

By Laplace's transform (Carslaw, Jaeger, Conduction of Heat in Solids, 2nd ed. 1959, section 9.8) the surface is above the mean by

    T_surface - T_mean = R/lambda sum_n [2/(R^2 p/alpha + mu_n^2)] q,   tan mu_n = mu_n > 0,   alpha = lambda/(rho C):

every mode w_n lags behind the flux on its own, (R^2/alpha) dw_n/dt + mu_n^2 w_n = 2 (R/lambda) q. The first N modes are kept;
the others, faster than R^2/(alpha mu_N+1^2), follow the flux at once and are a resistance. As sum_n 2/mu_n^2 = 1/5, N = 0
leaves the resistance R/(5 lambda): the linear driving force of Glueckauf, Trans. Faraday Soc. 51 (1955) 1540-1551.
The mean takes up all of the heat whatever N: no mode stores any.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.optimize import brentq

from .functions import Value

SOURCE = "Carslaw, Jaeger 1959, section 9.8; Glueckauf 1955; equation: Forgber, Radl, table 1"
ALL_MODES = 0.2
"""sum over all n of 2/mu_n^2."""


def eigenvalues(count: int) -> list[Any]:
    """The first `count` mu_n > 0 with tan mu = mu, as a list of floats."""
    return [
        brentq(lambda mu: np.sin(mu) - mu * np.cos(mu), n * np.pi, (n + 0.5) * np.pi, xtol=1e-14)
        for n in range(1, count + 1)
    ]


def remaining_resistance(eigenvalues_kept: Sequence[float]) -> Value:
    """Resistance of the modes that are not kept, in units of R/lambda (0.2 if none is)."""
    return ALL_MODES - sum(2.0 / mu**2 for mu in eigenvalues_kept)


def overall_coefficient(coefficient: Value, resistance: Value) -> Value:
    """Heat transfer coefficient (W/m2/K) of a film in series with a resistance (m2 K/W) behind it; 0 for a film of 0."""
    return coefficient / (1.0 + coefficient * resistance)
