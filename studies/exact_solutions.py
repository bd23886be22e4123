"""Exact solutions that studies and tests share."""

import numpy as np
from scipy.integrate import quad
from scipy.special import i0e


def schumann(ratio: float, time: float) -> float:
    """Fluid temperature of Schumann's (1929) front, 1 - e^-tau int_0^xi e^-s I0(2 sqrt(tau s)) ds, from 0 to 1: at a place xi and
    a time tau since the fluid has come there, both in transfer units (of the fluid's, and of the beads' heat capacity)."""

    def integrand(s: float) -> float:
        root = 2.0 * np.sqrt(time * s)
        return float(np.exp(root - s - time) * i0e(root))

    return float(1.0 - quad(integrand, 0.0, ratio, limit=200)[0])
