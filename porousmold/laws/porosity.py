r"""Porosity against wall distance y for beads of diameter d and bulk porosity phi_b (thesis table 5.1).

| name                | phi(y)                                                        | at the wall |
|---------------------|---------------------------------------------------------------|-------------|
| hunt-tien           | phi_b [1 + (1/phi_b - 1) exp(-8 y/d)]  slightly irregular     | 1           |
| hunt-tien-spheres   | the same with 6: perfect spheres                              | 1           |
| white-tien          | [1 + (1/phi_b - 1) sqrt(1 - exp(-2 y/d))]^-1                  | 1           |
| cheng-hsu           | phi_b [1 + exp(-2 y/d)]                                       | 2 phi_b     |
| vortmeyer-schuster  | phi_b [1 + (1/phi_b - 1) exp(-2 y/d)]                         | 1           |
| giese               | phi_b [1 + 1.36 exp(-5 y/d)]                                  | 2.36 phi_b  |
| constant            | phi_b                                                         | phi_b       |

Sources: Hunt and Tien, Chem. Eng. Sci. 45 (1990) 55-63; White and Tien, Wärme- Stoffübertragung 21 (1987) 291-296;
Cheng and Hsu, Int. J. Heat Mass Transfer 29 (1986) 1843-1853; Vortmeyer and Schuster, Chem. Eng. Sci. 38 (1983)
1691-1699. Eq. 5.2 as printed has exp(1 - 2 y/d), which exceeds 1 at the wall (2.03 for phi_b = 0.4); the factor e
is left out here, which makes it 1.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .functions import Value, exp, sqrt
from .registry import Registry


@dataclass(frozen=True)
class PorosityModel:
    """A porosity law phi(y/d, phi_b); `largest_bulk_porosity` keeps it below 1 at the wall."""

    formula: Callable[[Value, Value], Value]
    source: str
    largest_bulk_porosity: float = 1.0

    def __call__(self, wall_distance: Value, bead_diameter: Value, bulk_porosity: Value) -> Value:
        """Porosity for floats, arrays or UFL: wall_distance >= 0 and bead_diameter in m, bulk_porosity in (0, 1)."""
        return self.formula(wall_distance / bead_diameter, bulk_porosity)


def _exponential(steepness: float) -> Callable[[Value, Value], Value]:
    return lambda s, bulk: bulk + (1.0 - bulk) * exp(-steepness * s)


def _white_tien(s: Value, bulk: Value) -> Value:
    # 1e-12 keeps the derivative of the square root finite at the wall itself
    return 1.0 / (1.0 + (1.0 / bulk - 1.0) * sqrt(1.0 - exp(-2.0 * s) + 1e-12))


POROSITY_MODELS: Registry[PorosityModel] = Registry("porosity")
for _name, _model in {
    "hunt-tien": PorosityModel(_exponential(8.0), "Hunt, Tien, Chem. Eng. Sci. 45 (1990) 55-63, b = 8"),
    "hunt-tien-spheres": PorosityModel(_exponential(6.0), "Hunt, Tien, Chem. Eng. Sci. 45 (1990) 55-63, b = 6"),
    "white-tien": PorosityModel(_white_tien, "White, Tien, Wärme- Stoffübertragung 21 (1987) 291-296"),
    "cheng-hsu": PorosityModel(
        lambda s, bulk: bulk * (1.0 + exp(-2.0 * s)), "Cheng, Hsu, Int. J. Heat Mass Transfer 29 (1986) 1843-1853", 0.5
    ),
    "vortmeyer-schuster": PorosityModel(
        _exponential(2.0), "Vortmeyer, Schuster, Chem. Eng. Sci. 38 (1983) 1691-1699, normalised at the wall"
    ),
    "giese": PorosityModel(
        lambda s, bulk: bulk * (1.0 + 1.36 * exp(-5.0 * s)),
        "Giese, Rottschaefer, Vortmeyer, AIChE J. 44 (1998) 484-490",
        0.42,
    ),
    "constant": PorosityModel(lambda s, bulk: bulk + 0.0 * s, "constant"),
}.items():
    POROSITY_MODELS.register(_name, _model)


class Porosity(Protocol):
    """The porosity of a bed, wherever it comes from: a law, or a tabulated profile."""

    @property
    def source(self) -> str:
        """Where it comes from."""

    @property
    def bulk_porosity(self) -> float:
        """Porosity far from the wall."""

    def volume(self, wall_distance: Value, bead_diameter: Value) -> Value:
        """phi_V at wall distances (m), arrays."""

    def area(self, wall_distance: Value, bead_diameter: Value) -> Value:
        """phi_A at wall distances (m), arrays."""

    def over(
        self,
        wall_distance: Value,
        bead_diameter: Value,
        constant: Callable[[float], Value],
        at_nodes: Callable[[Callable[[Value], Value]], Value],
    ) -> Value:
        """phi_V over a mesh in UFL: an expression of the two lengths with its numbers by `constant`, or what `at_nodes` makes of
        a function of wall distances (arrays)."""


def dixon_mean_porosity(width_ratio: Value) -> Value:
    """Mean porosity 0.4 + 0.05/N + 0.412/N^2 of poured spheres in a tube N bead diameters wide (Dixon, Can. J. Chem. Eng. 66
    (1988) 705-708); a gap of width H counts as N = 2 H/d."""
    return 0.4 + 0.05 / width_ratio + 0.412 / width_ratio**2


def benyahia_oneill_mean_porosity(width_ratio: Value) -> Value:
    """Mean porosity 0.390 + 1.740/(N + 1.140)^2 of the same, mean error 1.5 % (Benyahia, O'Neill, Part. Sci. Technol. 23 (2005)
    169-177)."""
    return 0.390 + 1.740 / (width_ratio + 1.140) ** 2


def mean_porosity(porosity: Porosity, bead_diameter: float, half_width: float, *, axisymmetric: bool) -> float:
    """Mean phi_V over the section of a gap or a tube of this half-width (m)."""
    from scipy.integrate import trapezoid  # a tenth of a second, which no formula here needs

    layer = np.linspace(0.0, 1.0, 4001) ** 2 * half_width
    weight = 2.0 * (half_width - layer) / half_width if axisymmetric else np.ones_like(layer)
    return float(trapezoid(porosity.volume(layer, bead_diameter) * weight, layer) / half_width)


@dataclass(frozen=True)
class LawPorosity:
    """A `PorosityModel` with its bulk porosity. It tells nothing of phi_A, which is taken as phi_V."""

    model: PorosityModel
    bulk_porosity: float

    @property
    def source(self) -> str:
        return self.model.source

    def volume(self, wall_distance: Value, bead_diameter: Value) -> Value:
        return self.model(wall_distance, bead_diameter, self.bulk_porosity) + 0.0 * wall_distance

    area = volume

    def over(
        self,
        wall_distance: Value,
        bead_diameter: Value,
        constant: Callable[[float], Value],
        at_nodes: Callable[[Callable[[Value], Value]], Value],
    ) -> Value:
        return self.model(wall_distance, bead_diameter, constant(self.bulk_porosity))
