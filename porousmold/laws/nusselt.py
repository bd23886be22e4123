r"""Heat exchange between fluid and beads: a_v h_sf (T_f - T_s) per total volume.

a_v = 6 (1 - phi)/d (eq. 6.9), h_sf = Nu lambda_f/d (eq. 6.10), Re = rho phi |u| d/mu on the superficial velocity
(eq. 6.12), Pr = mu C_f/lambda_f (eq. 6.13). Wakao's correlation (eq. 6.11) is the default; the others are those of
the thesis's table 2.1, Whitaker's (2.8), and equation (13) of Henry et al.

Two entries of table 2.1 are defined only above a Reynolds number at which their denominator vanishes
(De Acetis-Thodos Re = 2.69, Gupta-Thodos Re = 0.285). As the local Reynolds number goes to zero at every
no-slip wall, the correlations take Re no smaller than the lower end of their range there (`floor`), which leaves
every value inside the range as published.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

from .functions import Value, exp, ln, maximum, sqrt
from .registry import Registry


def specific_surface(porosity: Value, bead_diameter: Value) -> Value:
    """Bead surface per total volume a_v = 6 (1 - phi)/d in 1/m (eq. 6.9)."""
    return 6.0 * (1.0 - porosity) / bead_diameter


def bead_reynolds_number(
    porosity: Value, density: Value, speed: Value, bead_diameter: Value, viscosity: Value
) -> Value:
    """Re = rho phi |u| d/mu with the intrinsic speed |u| (eq. 6.12, 7.14): local and superficial."""
    return density * porosity * speed * bead_diameter / viscosity


def prandtl_number(viscosity: Value, heat_capacity: Value, conductivity: Value) -> Value:
    """Pr = mu C/lambda (eq. 6.13)."""
    return viscosity * heat_capacity / conductivity


@dataclass(frozen=True)
class NusseltCorrelation:
    """A correlation Nu(Re, Pr, phi), its Reynolds range, its source, and the largest Prandtl number that it is for.

    Calling it gives Nu = h_sf d/lambda_f for floats, arrays or UFL. `floor` is the Reynolds number below which it is
    held constant (None: valid down to rest).
    """

    formula: Callable[..., Value]
    reynolds_range: tuple[float, float]
    source: str
    floor: float | None = None
    highest_prandtl_number: float = inf

    def __call__(self, reynolds_number: Value, prandtl_number: Value, porosity: Value) -> Value:
        if self.floor is not None:
            reynolds_number = maximum(reynolds_number, self.floor)
        return self.formula(reynolds_number, prandtl_number, porosity)


def _wakao(re: Value, pr: Value, phi: Value) -> Value:
    return 2.0 + 1.1 * re**0.6 * pr ** (1 / 3)


def _whitaker(re: Value, pr: Value, phi: Value) -> Value:
    solids = 1.0 - phi
    return (
        (0.5 * re**-0.1 * solids**0.5 / phi + 0.2 * re ** (1 / 15) * solids ** (1 / 3) / phi) * pr ** (1 / 3) * re**0.6
    )


def _achenbach(re: Value, pr: Value, phi: Value) -> Value:
    # The fluid heats only where there are beads: 1 - phi is kept off zero, where the second term is singular.
    solids = maximum(1.0 - phi, 1e-3)
    return ((1.18 * re**0.58) ** 4 + (0.23 * (re / solids) ** 0.75) ** 4) ** 0.25


def _gupta_thodos(re: Value, pr: Value, phi: Value) -> Value:
    return pr ** (1 / 3) / phi * re * (0.0108 + 0.929 / (re**0.58 - 0.483))


def _de_acetis_thodos(re: Value, pr: Value, phi: Value) -> Value:
    return 1.1 * pr ** (1 / 3) * re / (re**0.41 - 1.5)


def _resnick(re: Value, pr: Value, phi: Value) -> Value:
    return 0.922 * pr ** (1 / 3) * re**0.66


def _nsofor_adebiyi(re: Value, pr: Value, phi: Value) -> Value:
    return 8.74 + 9.34 * (6.0 * maximum(1.0 - phi, 1e-6)) ** 0.2 * pr ** (1 / 3) * re**0.2


def _nie(re: Value, pr: Value, phi: Value) -> Value:
    return 0.052 * maximum(1.0 - phi, 1e-6) ** 0.14 / phi * pr ** (1 / 3) * re**0.86


def _pen(re: Value, pr: Value, phi: Value) -> Value:
    return 0.048 * maximum(1.0 - phi, 1e-6) ** 0.3 / phi * pr ** (1 / 3) * re**0.7


def _henry(re: Value, pr: Value, phi: Value) -> Value:
    # eq. (11): voidage function of Di Felice on the superficial Reynolds number; logarithm to base 10 as Di Felice's
    re_interstitial = re / phi
    log10 = ln(re_interstitial) / ln(10.0)
    voidage = phi ** (-1.8 + exp(-0.5 * (1.5 - log10) ** 2))
    analogy = (re + 500.0) / (0.11 * re**1.4 + re + 500.0)
    return voidage * analogy * (0.18 * sqrt(re) + 1.39) ** 2 * pr**0.4


REST = 1e-3
"""Least Reynolds number of a power law below 1, whose slope at rest is infinite: keeps Newton's method finite and changes Nu by
less than 0.02."""

NUSSELT_CORRELATIONS: Registry[NusseltCorrelation] = Registry("nusselt")
for _name, _correlation in {
    "wakao": NusseltCorrelation(
        _wakao, (15.0, 8500.0), "Wakao, Kaguei, Funazkri, Chem. Eng. Sci. 34 (1979) 325-336", REST
    ),
    "whitaker": NusseltCorrelation(_whitaker, (50.0, 1e4), "Whitaker, AIChE J. 18 (1972) 361-371", REST),
    "achenbach": NusseltCorrelation(  # of air, and without Pr
        _achenbach, (1.0, 1e5), "Achenbach, Exp. Therm. Fluid Sci. 10 (1995) 17-27", REST, 1.0
    ),
    "gupta-thodos": NusseltCorrelation(_gupta_thodos, (20.0, 1e4), "Gupta, Thodos, AIChE J. 8 (1962)", 20.0),
    "de-acetis-thodos": NusseltCorrelation(
        _de_acetis_thodos, (13.0, 2136.0), "De Acetis, Thodos, Ind. Eng. Chem. 52 (1960) 1003-1006", 13.0
    ),
    "resnick": NusseltCorrelation(_resnick, (15.0, 161.0), "Resnick, PhD thesis, MIT (1952)", REST),
    "nsofor-adebiyi": NusseltCorrelation(
        _nsofor_adebiyi, (50.0, 120.0), "Nsofor, Adebiyi, Exp. Therm. Fluid Sci. 24 (2001) 1-9", REST
    ),
    "nie": NusseltCorrelation(_nie, (2.5, 175.6), "Nie, Evitts, Besant, Bolster, J. Heat Transfer 133 (2011)", REST),
    "pen": NusseltCorrelation(_pen, (20.0, 100.0), "Pen, Besant, Strathdee, Can. J. Chem. Eng. 78 (2000)", REST),
    "henry": NusseltCorrelation(
        _henry,
        (15.0, 8500.0),
        "Henry et al., droplet in a hot granular bed, eq. (13), compared there with Wakao's data",
        REST,
    ),
}.items():
    NUSSELT_CORRELATIONS.register(_name, _correlation)
