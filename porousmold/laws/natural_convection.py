"""Natural convection in a bed that rests, which the equations leave out: how much it would be.

A bed heated from below turns over where its Rayleigh-Darcy number, Ra* = rho^2 C_f g beta dT K H/(mu lambda), exceeds 4 pi^2
(Horton, Rogers 1945; Lapwood 1948); then it carries about Ra*/40 times what conduction does (Elder, J. Fluid Mech. 27 (1967) 29,
for Ra* up to some 400). Heated at a side it turns at any Ra*; the boundary layers of a tall bed carry 0.577 sqrt(Ra*) L/H times
what conduction across its width L does, with Ra* on its height H (Weber, Int. J. Heat Mass Transfer 18 (1975) 569).
"""

import math

ONSET = 4.0 * math.pi**2
"""Rayleigh-Darcy number above which a bed that is heated from below turns over."""
GRAVITY = 9.81


def rayleigh_darcy_number(
    *,
    density: float,
    heat_capacity: float,
    viscosity: float,
    expansion: float,
    permeability: float,
    conductivity: float,
    difference: float,
    height: float,
) -> float:
    """Ra* of a fluid (SI, `expansion` in 1/K) in a bed of a `permeability` (m2) and `conductivity` at rest (W/m/K), with a
    temperature `difference` (K) over a `height` (m)."""
    driving = density**2 * heat_capacity * GRAVITY * expansion * difference * permeability * height
    return driving / (viscosity * conductivity)


def carried_from_below(rayleigh_darcy: float) -> float:
    """Nusselt number of a bed heated from below, over conduction; 1 below the onset."""
    return max(1.0, rayleigh_darcy / 40.0)


def carried_from_the_side(rayleigh_darcy: float, slenderness: float) -> float:
    """Nusselt number, over conduction across the width, of a bed heated at a side, `slenderness` its height over its width; 1 at
    least."""
    return max(1.0, 0.577 * math.sqrt(rayleigh_darcy) / slenderness)
