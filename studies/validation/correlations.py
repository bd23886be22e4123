r"""Correlations that were fitted to measurements in beds of spheres, as published: each with its range and scatter.

Re = rho U d/mu and Re_m = Re/(1 - phi) are on the superficial speed U, N = D/d is the tube's width in bead diameters (a gap H
counts as N = 2 H/d), Nu = h d/lambda_f. None was read in its first publication: the pressure drops in well-kept programs, the
others in secondary compilations.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq
from scipy.special import j0, j1

from porousmold.laws.conductivity import LocalBed, stagnant_conductivity

from .section import Section


class Fluid(NamedTuple):
    """Constant properties, SI."""

    density: float
    viscosity: float
    heat_capacity: float
    conductivity: float

    @property
    def prandtl_number(self) -> float:
        """mu C/lambda."""
        return self.viscosity * self.heat_capacity / self.conductivity


AIR = Fluid(1.1614, 1.846e-5, 1007.0, 0.0263)
"""At 300 K and 1 atm."""
CERAMIC = 2.09
"""Conductivity of the beads, W/m/K."""


class PressureDrop(NamedTuple):
    """F(Re, phi, N) of dp/L = F (1 - phi)/phi^3 rho U^2/d, with the range of Re_m or Re and what is said of its scatter."""

    factor: Callable[[float, float, float], float]
    valid: str
    scatter: str


def _eisfeld_schnitzlein(re: float, phi: float, n: float) -> float:
    a_w, b_w = 1.0 + 2.0 / (3.0 * n * (1.0 - phi)), (1.15 / n**2 + 0.87) ** 2
    return 154.0 * a_w**2 * (1.0 - phi) / re + a_w / b_w


def _harrison(re: float, phi: float, n: float) -> float:
    a = (1.0 + np.pi / (6.0 * (1.0 - phi) * n)) ** 2
    b = 1.0 - np.pi**2 / (24.0 * n) * (1.0 - 1.0 / (2.0 * n))
    modified = re / (1.0 - phi)
    return 119.8 * a / modified + 4.63 * b * modified ** (-1.0 / 6.0)


def _dixon(re: float, phi: float, n: float) -> float:
    modified = re / (1.0 - phi)
    walled = (1.0 + 2.0 * 0.564 / (3.0 * (1.0 - phi) * n)) ** 2
    inertial = 0.922 + 16.0 * (1.0 - np.exp(-0.22 * n)) * modified**-0.46
    return 160.0 * walled / modified + inertial * modified / (modified + 52.0)


PRESSURE_DROP: Mapping[str, PressureDrop] = {
    "KTA 1981": PressureDrop(
        lambda re, phi, n: 160.0 * (1 - phi) / re + 3.0 * ((1 - phi) / re) ** 0.1, "Re_m 1 to 1e5", "15 % (95 %)"
    ),
    "Carman 1937": PressureDrop(
        lambda re, phi, n: 180.0 * (1 - phi) / re + 2.871 * ((1 - phi) / re) ** 0.1, "Re_m 0.1 to 6e4", "not given"
    ),
    "Erdim 2015": PressureDrop(
        lambda re, phi, n: 160.0 * (1 - phi) / re + 2.81 * ((1 - phi) / re) ** 0.096,
        "Re_m 2 to 3582, N 4 to 34",
        "not given",
    ),
    "Eisfeld, Schnitzlein 2001": PressureDrop(
        _eisfeld_schnitzlein, "Re_m 0.01 to 1.8e4, N 1.6 to 250", "about 20 % (rms)"
    ),
    "Harrison, Brunner, Hecker 2013": PressureDrop(_harrison, "Re 0.7 to 7700, N 8.3 to 50", "not given"),
    "Dixon 2023": PressureDrop(_dixon, "Re_m 100 to 3e4, N 5 to 25", "not given"),
}


def stagnant(porosity: float, bead_diameter: float, fluid: Fluid = AIR) -> float:
    """lambda_0/lambda_f of ceramic beads."""
    bed = _bed_at_rest(bead_diameter, fluid)
    return float(stagnant_conductivity(bed, porosity) / fluid.conductivity)


def _bed_at_rest(bead_diameter: float, fluid: Fluid) -> LocalBed:
    return LocalBed(
        porosity=0.4,
        wall_distance=1.0,
        bead_diameter=bead_diameter,
        density=fluid.density,
        viscosity=fluid.viscosity,
        heat_capacity=fluid.heat_capacity,
        speed=0.0,
        eddy_viscosity=0.0,
        fluid_conductivity=fluid.conductivity,
        bead_conductivity=CERAMIC,
        bulk_porosity=0.4,
        core_speed=0.0,
        temperature=300.0,
        contact_flattening=0.0077,
    )


def overall(wall: float, radial: float, n: float) -> float:
    """Overall Nu of thermally developed plug flow in a tube from Nu_w and k_r/lambda_f: b J1(b) = Bi J0(b), Nu = k_r b^2/N."""
    biot = 0.5 * wall * n / radial
    root = brentq(lambda b: b * j1(b) - biot * j0(b), 1e-9, 2.404825557)
    return radial * root**2 / n


def wall_of(total: float, radial: float, n: float) -> float:
    """Nu_w that makes up an overall Nu with k_r/lambda_f: `overall` the other way round; infinite where there is none."""
    root = np.sqrt(total * n / radial)
    return float(2.0 * radial / n * root * j1(root) / j0(root)) if root < 2.404825557 else float("inf")


def radial_vdi(re: float, n: float, at_rest: float, pr: float) -> float:
    """k_r/lambda_f = lambda_0/lambda_f + Re Pr/(7 [2 - (1 - 2/N)^2]) (Schluender, VDI Heat Atlas M7)."""
    return at_rest + re * pr / (7.0 * (2.0 - (1.0 - 2.0 / n) ** 2))


def radial_specchia(re: float, n: float, at_rest: float, pr: float) -> float:
    """k_r/lambda_f = lambda_0/lambda_f + Re Pr/(8.65 [1 + 19.4/N^2]) (Specchia, Baldi, Sicardi 1980)."""
    return at_rest + re * pr / (8.65 * (1.0 + 19.4 / n**2))


WALL: Mapping[str, Callable[[float, float, float, float], float]] = {
    "Yagi, Wakao 1959": lambda re, n, at_rest, pr: 0.2 * re**0.8 if re >= 40.0 else 0.6 * re**0.5,
    "Li, Finlayson 1977 (wall)": lambda re, n, at_rest, pr: 0.17 * re**0.79,
    "Colledge, Paterson 1984": lambda re, n, at_rest, pr: 0.523 * (1.0 - 1.0 / n) * pr ** (1 / 3) * re**0.738,
    "Dixon, DiCostanzo, Soucy 1984": lambda re, n, at_rest, pr: (1.0 - 1.5 * n**-1.5) * pr ** (1 / 3) * re**0.59,
}
"""Nu_w(Re, N, lambda_0/lambda_f, Pr) to go with Specchia's k_r."""


def martin_nilles(re: float, n: float, at_rest: float, pr: float) -> float:
    """Nu_w = (1.3 + 5/N) lambda_0/lambda_f + 0.19 Pr^(1/3) Re^0.75 (Martin, Nilles 1993, VDI Heat Atlas M7)."""
    return (1.3 + 5.0 / n) * at_rest + 0.19 * pr ** (1 / 3) * re**0.75


def li_finlayson(re: float, n: float) -> float:
    """Overall Nu = 2.03 Re^0.8 exp(-6/N)/N of spheres in air (Li, Finlayson, Chem. Eng. Sci. 32 (1977) 1055-1066): Re 20 to
    7600, N 3.3 to 20, of data free of entrance effects."""
    return float(2.03 * re**0.8 * np.exp(-6.0 / n) / n)


def overall_sets(re: float, n: float, bead_diameter: float = 5e-3, fluid: Fluid = AIR) -> dict[str, float]:
    """Overall Nu from a wall of fixed temperature to the mixed mean, thermally developed, by each of the eight sets."""
    pr, at_rest = fluid.prandtl_number, stagnant(0.4 + 0.05 / n + 0.412 / n**2, bead_diameter, fluid)
    values = (re, n, at_rest, pr)
    return {
        "Leva 1947": float(0.813 * re**0.9 * np.exp(-6.0 / n) / n),
        "Li, Finlayson 1977": li_finlayson(re, n),
        "VDI, Martin, Nilles 1993": overall(martin_nilles(*values), radial_vdi(*values), n),
        **{f"Specchia + {name}": overall(nu(*values), radial_specchia(*values), n) for name, nu in WALL.items()},
        "Winterberg, Tsotsas 2000": winterberg_tsotsas(re, n, bead_diameter, fluid),
    }


def winterberg_tsotsas(re: float, n: float, bead_diameter: float, fluid: Fluid) -> float:
    """Overall Nu of their own model with one temperature: flow of Brinkman and Ergun with the effective viscosity of Giese,
    Rottschaefer and Vortmeyer (1998), porosity 0.37 (1 + 1.36 exp(-5 y/d)), K_1 = 1/8, K_2 = 0.44 + 4 exp(-Re/70)."""
    half = 0.5 * n * bead_diameter
    section = Section(half * (1.0 - np.linspace(1.0, 0.0, 401) ** 2), axisymmetric=True)
    y = half - section.nodes
    phi = 0.37 * (1.0 + 1.36 * np.exp(-5.0 * y / bead_diameter))
    mean = re * fluid.viscosity / (fluid.density * bead_diameter)
    viscous = 150.0 * (1.0 - phi) ** 2 / phi**3 * fluid.viscosity / bead_diameter**2
    inertial = 1.75 * (1.0 - phi) / phi**3 * fluid.density / bead_diameter
    shear = section.stiffness(np.full(len(y), 2.0 * fluid.viscosity * np.exp(2e-3 * re)))
    speed = np.full(len(y), mean)
    for _ in range(100):
        matrix = shear + np.diag(section.weights * (viscous + inertial * speed))
        found = np.append(np.linalg.solve(matrix[:-1, :-1], section.weights[:-1]), 0.0)
        found *= mean / section.mean(found)
        if np.max(np.abs(found - speed)) < 1e-9 * mean:
            break
        speed = 0.5 * (speed + found)
    peclet = speed[0] * bead_diameter * fluid.density * fluid.heat_capacity / fluid.conductivity
    reach = (0.44 + 4.0 * np.exp(-re / 70.0)) * bead_diameter
    conductivity = stagnant_conductivity(_bed_at_rest(bead_diameter, fluid), phi)
    conductivity = conductivity + peclet / 8.0 * np.minimum(y / reach, 1.0) ** 2 * fluid.conductivity
    carried = section.weights * fluid.density * fluid.heat_capacity * np.maximum(speed, 1e-9 * mean)
    rate = eigh(section.stiffness(conductivity)[:-1, :-1], np.diag(carried[:-1]), eigvals_only=True)[0]
    return float(rate * carried.sum() / section.perimeter * bead_diameter / fluid.conductivity)
