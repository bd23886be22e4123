r"""Beads that a rising fluid lifts: minimum fluidisation, expansion of the bed, heat transfer to its wall.

With the Archimedes number Ar = rho (rho_s - rho) g d^3/mu^2 and the superficial Reynolds number Re = rho w d/mu:

    minimum fluidisation (Ergun: pressure drop = weight, 150 and 1.75):
        Re_mf = 42.86 (1-phi_mf) [sqrt(1 + 3.11e-4 phi_mf^3 Ar/(1-phi_mf)^2) - 1]
    terminal velocity of a single sphere (VDI Heat Atlas):    Re_t = 18 [sqrt(1 + sqrt(Ar)/9) - 1]^2
    porosity of the expanded bed (Richardson, Zaki):          phi = (w/w_t)^(1/n),  n such that phi = phi_mf at w_mf

Coefficient between bed and wall of a bubbling bed (Martin, Chem. Eng. Process. 18 (1984) 157-169, 199-223; VDI Heat Atlas,
chapter M5), the sum of what beads carry, gas and radiation:

    Nu_p = (1-phi) Z (1 - exp(-N)),    N = Nu_w/(C_K Z),    C_K = 2.6
    Z = rho_s C_s/(6 lambda) sqrt(g d^3 (phi - phi_mf)/[5 (1-phi_mf)(1-phi)])
    1/Nu_w = 1/{4 [(1 + 2l/d) ln(1 + d/2l) - 1]} + (lambda/lambda_s)/{4 [1 + sqrt(3 C_K lambda Z/(2 pi lambda_s))]}
    l = 2 Lambda (2/gamma - 1),    Lambda = sqrt(2 pi R T) lambda/[p (2 C_p - R)]
    log10(1/gamma - 1) = 0.6 - (1000 K/T + 1)/C_A
    Nu_g = 0.009 Pr^(1/3) Ar^(1/2),    Nu_r = 4 emissivity sigma T^3 d/lambda

R is the gas's own constant (J/kg/K), l the modified mean free path, C_A = 2.8 that of air (other gases: `GAS_CONSTANTS`). Range:
dry spheres of 0.05 to 3 mm in gases, w from 1 to some 10 w_mf; measurements scatter by 30 %.
"""

import math
from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from .functions import Value

GRAVITY = 9.80665
ATMOSPHERE = 101325.0
"""Pressure (Pa) of the gas in a column."""
STEFAN_BOLTZMANN = 5.670374419e-8
GAS_CONSTANTS = {"air": 2.8, "thesis_air": 2.8, "nitrogen": 2.8, "carbon_dioxide": 2.4, "argon": 2.2, "helium": 50.0}
"""C_A by material (VDI Heat Atlas, chapter M5); 2.8 for others."""
CONTACT_CONSTANT = 2.6
SOURCE = "Martin, Chem. Eng. Process. 18 (1984) 157-169, 199-223; VDI Heat Atlas, chapter M5"
DIAMETER_RANGE = 0.05e-3, 3e-3
"""Bead diameters (m) for which the coefficient at the wall is known."""


def archimedes_number(diameter: float, density: float, bead_density: float, viscosity: float) -> float:
    """Ar = rho (rho_s - rho) g d^3/mu^2, of SI values. Raises `InputError` for beads that float."""
    if bead_density <= density:
        raise InputError(
            "bed.bead_density", bead_density, f"must be > {density:g} kg/m3, the fluid's: these beads float"
        )
    return density * (bead_density - density) * GRAVITY * diameter**3 / viscosity**2


def minimum_fluidisation_reynolds_number(archimedes: float, porosity: float) -> float:
    """Superficial Re at which Ergun's pressure drop carries the beads, at the porosity of the bed at rest."""
    solid = 1.0 - porosity
    return 150.0 * solid / 3.5 * (math.sqrt(1.0 + 7.0 * porosity**3 * archimedes / (150.0 * solid) ** 2) - 1.0)


def terminal_reynolds_number(archimedes: float) -> float:
    """Re of a single sphere that falls."""
    return 18.0 * (math.sqrt(1.0 + math.sqrt(archimedes) / 9.0) - 1.0) ** 2


def expanded_porosity(reynolds: float, minimum: float, terminal: float, porosity_at_minimum: float) -> float:
    """Porosity of a fluidised bed at a superficial Re between those of minimum fluidisation and of a single sphere."""
    exponent = math.log(minimum / terminal) / math.log(porosity_at_minimum)
    return float((reynolds / terminal) ** (1.0 / exponent))


def modified_mean_free_path(
    temperature: float,
    pressure: float,
    conductivity: float,
    heat_capacity: float,
    gas_constant: float,
    constant: float = 2.8,
) -> float:
    """l (m) of a gas at a wall: temperature (K), pressure (Pa), W/m/K, J/kg/K, R (J/kg/K), and C_A of the gas."""
    path = math.sqrt(2.0 * math.pi * gas_constant * temperature) * conductivity
    path /= pressure * (2.0 * heat_capacity - gas_constant)
    inverse = 1.0 + 10.0 ** (0.6 - (1000.0 / temperature + 1.0) / constant)
    return 2.0 * path * (2.0 * inverse - 1.0)


@dataclass(frozen=True, kw_only=True)
class BubblingBed:
    """What the heat transfer of a bubbling bed to its wall depends on: SI values; `bead_heat_capacity` is rho_s C_s (J/m3/K),
    `mean_free_path` l (m), `conductivity` that of the gas (W/m/K)."""

    diameter: float
    porosity: float
    porosity_at_minimum: float
    bead_heat_capacity: float
    bead_conductivity: float
    conductivity: float
    mean_free_path: float
    prandtl: float
    archimedes: float
    emissivity: float = 0.0
    temperature: float = 300.0

    def wall_nusselt_number(self) -> float:
        """Nu = h d/lambda between bed and wall (Martin)."""
        at_minimum, conductivity = self.porosity_at_minimum, self.conductivity
        free = (self.porosity - at_minimum) / (5.0 * (1.0 - at_minimum) * (1.0 - self.porosity))
        motion = self.bead_heat_capacity / (6.0 * conductivity) * math.sqrt(GRAVITY * self.diameter**3 * free)  # Z
        gap = 2.0 * self.mean_free_path / self.diameter
        resistance = 1.0 / (4.0 * ((1.0 + gap) * math.log1p(1.0 / gap) - 1.0))
        ratio = conductivity / self.bead_conductivity
        resistance += ratio / (4.0 * (1.0 + math.sqrt(1.5 * CONTACT_CONSTANT * ratio * motion / math.pi)))
        by_beads = 0.0
        if motion > 0.0:
            by_beads = (1.0 - self.porosity) * motion * -math.expm1(-1.0 / (resistance * CONTACT_CONSTANT * motion))
        by_gas = 0.009 * self.prandtl ** (1 / 3) * math.sqrt(self.archimedes)
        by_radiation = 4.0 * self.emissivity * STEFAN_BOLTZMANN * self.temperature**3 * self.diameter / conductivity
        return by_beads + by_gas + by_radiation


def suspension_drag(porosity: Value, diameter: float, density: float, viscosity: float, relative_speed: Value) -> Value:
    """Drag per total volume and relative velocity, kg/m3/s (Gidaspow 1994): Ergun below a porosity of 0.8,
    3/4 C_D phi (1-phi) rho |u-v| phi^-2.65/d of Wen and Yu above, Re = phi rho |u-v| d/mu, C_D = 24 (1 + 0.15 Re^0.687)/Re below
    Re = 1000, else 0.44; blended by arctan(262.5 (phi - 0.8)) (Huilin, Gidaspow 2003). Arrays or numbers."""
    solids = 1.0 - porosity
    ergun = (
        150.0 * solids**2 * viscosity / (porosity * diameter**2) + 1.75 * solids * density * relative_speed / diameter
    )
    reynolds = np.maximum(porosity * density * relative_speed * diameter / viscosity, 1e-9)
    per_speed = np.where(reynolds < 1000.0, 24.0 * (1.0 + 0.15 * reynolds**0.687), 0.44 * reynolds)
    wen_yu = 0.75 * per_speed * viscosity * solids * porosity**-2.65 / diameter**2  # C_D rho phi |u-v| = C_D Re mu/d
    dilute = 0.5 + np.arctan(262.5 * (porosity - 0.8)) / np.pi
    return (1.0 - dilute) * ergun + dilute * wen_yu


def suspension_drag_of_henry(
    porosity: Value, diameter: float, density: float, viscosity: float, relative_speed: Value
) -> Value:
    """Drag per total volume and relative velocity, kg/m3/s, 3/4 C_d (1-phi) rho |u-v|/d with Henry et al.'s equation (12),

        C_d = g (0.63 + 4.8/sqrt(phi Re))^2,    g = phi^(-1.8 + exp(-(1.5 - log10 Re)^2/2)),    Re = rho |u-v| d/mu,

    Dallavalle's sphere among others. g is as they print it, after Di Felice (Int. J. Multiphase Flow 20 (1994) 153-159). His own
    exponent is -1.7 + 0.65 exp(...): at a porosity of 0.45 8 % less drag far from Re = 32, 22 % more there. Arrays or numbers."""
    reynolds = np.maximum(density * relative_speed * diameter / viscosity, 1e-9)
    voidage = porosity ** (-1.8 + np.exp(-0.5 * (1.5 - np.log10(reynolds)) ** 2))
    at_rest = 4.8 * np.sqrt(viscosity / (np.maximum(porosity, 1e-9) * density * diameter))  # 4.8 sqrt(|u-v|/(phi Re))
    per_density = voidage * (0.63 * np.sqrt(relative_speed) + at_rest) ** 2
    return 0.75 * (1.0 - porosity) * density / diameter * per_density


SUSPENSION_DRAGS = {"gidaspow": suspension_drag, "di-felice": suspension_drag_of_henry}
"""Drag of beads that a fluid carries, by name."""
