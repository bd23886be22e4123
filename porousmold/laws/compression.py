r"""Ideal work of a flow through a pressure difference.

    of a gas      w = (p/(rho kappa)) [(1 + dp/p)^kappa - 1],   kappa = p/(rho T C)     (isentropic, C of the temperature T)
    of a liquid   w = dp/rho

p, T, rho are those before the pressure changes by dp (positive: compression, negative: expansion). Of an ideal gas kappa is
R/C = (gamma - 1)/gamma. Any textbook of thermodynamics.
"""

import numpy as np

from .functions import Value
from .materials import Fluid


def isentropic_work(fluid: Fluid, pressure: Value, temperature: Value, rise: Value) -> Value:
    """Work (J/kg) that brings a fluid of an absolute pressure (Pa) and a temperature (K) to one higher by `rise` (Pa; negative of
    an expansion, which gives work). Numbers or numpy arrays; `pressure + rise` is positive."""
    density = fluid.density(pressure, temperature)
    if not fluid.density.compressible:
        return rise / density
    exponent = pressure / (density * temperature * fluid.heat_capacity(temperature))
    return pressure / (density * exponent) * np.expm1(exponent * np.log1p(rise / pressure))
