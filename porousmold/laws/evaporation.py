r"""Water that evaporates beside something hot, in closed forms.

A droplet of water on a surface that is much hotter than its boiling point rides on its own vapour (Leidenfrost). Heat conducted
through the vapour, k dT per thickness, evaporates m'' = k dT/(e L) at a film of thickness e; the vapour flows out along it as
between parallel plates, dp/dx = -12 mu u/e^2, and its pressure carries the weight:

    cylinder of half width b, weight W per length:   e^4 = 8 mu k dT b^3/(L rho_v W)
    disc of radius r, weight W:                      e^4 = 3 pi mu k dT r^4/(2 L rho_v W)

A sphere in still vapour far hotter loses its surface evenly (the d^2 law; Spalding 1953):

    D^2 = D_0^2 - 8 k/(rho C) ln(1 + C dT/L) t.
"""

import math

BOILING_TEMPERATURE = 373.124
"""Of water at 101 325 Pa, K (IAPWS-95)."""
LATENT_HEAT = 2.2565e6
"""Of water that boils at 101 325 Pa, J/kg (IAPWS-95)."""


def film_below_cylinder(
    half_width: float, weight: float, excess: float, conductivity: float, viscosity: float, vapour_density: float
) -> float:
    """Thickness (m) of the vapour below a flat strip of `half_width` (m) that presses with a `weight` (N/m), on a plate hotter by
    `excess` (K); vapour in SI."""
    made = viscosity * conductivity * excess / (LATENT_HEAT * vapour_density)
    return float((8.0 * made * half_width**3 / weight) ** 0.25)


def film_below_disc(
    radius: float, weight: float, excess: float, conductivity: float, viscosity: float, vapour_density: float
) -> float:
    """Thickness (m) of the vapour below a flat disc of `radius` (m) that presses with a `weight` (N), on a plate hotter by
    `excess` (K); vapour in SI."""
    made = viscosity * conductivity * excess / (LATENT_HEAT * vapour_density)
    return float((1.5 * math.pi * made * radius**4 / weight) ** 0.25)


def sphere_lifetime(diameter: float, density: float, excess: float, conductivity: float, heat_capacity: float) -> float:
    """Time (s) in which a sphere of water of a `diameter` (m) and `density` (kg/m3) is gone, in still vapour (conductivity in
    W/m/K, heat capacity in J/kg/K) that is hotter by `excess` (K) far away."""
    number = heat_capacity * excess / LATENT_HEAT
    return density * diameter**2 * heat_capacity / (8.0 * conductivity * math.log1p(number))
