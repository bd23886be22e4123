r"""Property laws of fluids, beads and walls, each with its unit, its source and the temperatures it holds for.

A law is a `Polynomial` in the temperature T (K) or Sutherland's viscosity. Laws accept floats, numpy arrays and UFL.
Sources are those of the thesis's tables 6.1, 7.1 and 8.1; the viscosity of table 6.1 is printed without the factor
383.55 that tables 7.1 and 8.1 (and Sutherland's law) have.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from .functions import Value
from .registry import Registry

GAS_CONSTANT_AIR = 287.055
"""Specific gas constant of air in J/(kg K) (thesis section 6.5.2)."""


@dataclass(frozen=True)
class Polynomial:
    """c0 + c1 T + c2 T^2 + ... of the temperature in K, with its unit, source and range of temperature in K.

    The coefficients may be numbers or UFL constants.
    """

    coefficients: tuple[Value, ...]
    unit: str
    source: str
    temperature_range: tuple[float, float] = (0.0, float("inf"))

    def __call__(self, temperature: Value) -> Value:
        """Value at the temperature (K)."""
        value = self.coefficients[-1] + 0.0 * temperature
        for coefficient in reversed(self.coefficients[:-1]):
            value = value * temperature + coefficient
        return value

    def integral(self, temperature: Value) -> Value:
        """Antiderivative c0 T + c1 T^2/2 + ..., zero at 0 K: the enthalpy, if the law is a heat capacity."""
        value = 0.0 * temperature
        for power in range(len(self.coefficients), 0, -1):
            value = (value + self.coefficients[power - 1] / power) * temperature
        return value

    def with_coefficients(self, coefficients: Iterable[Value]) -> "Polynomial":
        """The same law with other numbers, for example UFL constants in place of floats."""
        return replace(self, coefficients=tuple(coefficients))


def constant(value: Value, unit: str, source: str) -> Polynomial:
    """A property that does not depend on temperature."""
    return Polynomial((value,), unit, source)


@dataclass(frozen=True)
class SutherlandViscosity:
    """mu = mu_0 (T/T_0)^1.5 (T_0 + S)/(T + S) in Pa s."""

    reference_viscosity: float
    reference_temperature: float
    sutherland_temperature: float
    source: str
    unit: str = "Pa s"
    temperature_range: tuple[float, float] = (100.0, 1900.0)

    def __call__(self, temperature: Value) -> Value:
        t0, s = self.reference_temperature, self.sutherland_temperature
        return self.reference_viscosity * (temperature / t0) ** 1.5 * (t0 + s) / (temperature + s)


@dataclass(frozen=True)
class IdealGasDensity:
    """rho = p/(R T) in kg/m3, pressure absolute in Pa."""

    gas_constant: float
    source: str
    unit: str = "kg/m^3"
    temperature_range: tuple[float, float] = (100.0, 2000.0)

    def __call__(self, absolute_pressure: Value, temperature: Value) -> Value:
        return absolute_pressure / (self.gas_constant * temperature)

    @property
    def compressible(self) -> bool:
        return True


@dataclass(frozen=True)
class ConstantDensity:
    """A liquid's density in kg/m3, whatever pressure and temperature (no buoyancy, no expansion)."""

    value: Value
    source: str
    unit: str = "kg/m^3"
    temperature_range: tuple[float, float] = (0.0, float("inf"))

    def __call__(self, absolute_pressure: Value, temperature: Value) -> Value:
        return self.value

    @property
    def compressible(self) -> bool:
        return False


UNITS = {"density": "kg/m^3", "heat_capacity": "J/(kg K)", "conductivity": "W/(m K)", "viscosity": "Pa s"}


def _law_of(value: Value, name: str, source: str) -> Value:
    """A property law of a number; a law as it is."""
    return value if callable(value) else constant(float(value), UNITS[name], source)


@dataclass(frozen=True)
class Fluid:
    """Laws of a fluid: `density` of absolute pressure and temperature (`IdealGasDensity`, `ConstantDensity`), `viscosity`,
    `heat_capacity` and `conductivity` of the temperature. SI units; a number in place of a law is a constant property, whose
    source is `source`. The heat capacity is a `Polynomial`, as its integral is the enthalpy."""

    name: str
    density: IdealGasDensity | ConstantDensity
    viscosity: Value
    heat_capacity: Value
    conductivity: Value
    source: str = ""

    def __post_init__(self) -> None:
        if not callable(self.density):
            object.__setattr__(self, "density", ConstantDensity(float(self.density), self.source))
        for name in ("viscosity", "heat_capacity", "conductivity"):
            object.__setattr__(self, name, _law_of(getattr(self, name), name, self.source))

    def laws(self) -> dict[str, Value]:
        """The four laws by name."""
        return {name: getattr(self, name) for name in ("density", "viscosity", "heat_capacity", "conductivity")}


@dataclass(frozen=True)
class Solid:
    """Laws of a solid: constant `density` (kg/m3), `heat_capacity` (J/(kg K)) and `conductivity` (W/(m K)) of T, as
    `Polynomial`s. A number in place of a law is a constant property, whose source is `source`.

    `contact_flattening` is the share of a bead's section that is flattened where beads of it touch (`laws.conductivity`): of
    ceramic where nothing else is known."""

    name: str
    density: Value
    heat_capacity: Value
    conductivity: Value
    source: str = ""
    contact_flattening: Value = 0.0077

    def __post_init__(self) -> None:
        for name in ("density", "heat_capacity", "conductivity"):
            object.__setattr__(self, name, _law_of(getattr(self, name), name, self.source))

    def laws(self) -> dict[str, Value]:
        """The three laws by name."""
        return {name: getattr(self, name) for name in ("density", "heat_capacity", "conductivity")}


FLUIDS: Registry[Fluid] = Registry("fluid")
SOLIDS: Registry[Solid] = Registry("solid")

_RASMUSSEN = "Rasmussen (1997), properties of air for the calibration of microphones"
AIR = Fluid(
    "air",
    IdealGasDensity(GAS_CONSTANT_AIR, "ideal gas, thesis section 6.5.2"),
    SutherlandViscosity(1.716e-5, 273.15, 110.4, "Sutherland, Phil. Mag. 36 (1893) 507-531"),
    Polynomial((1.0535e3, -3.8738e-1, 8.9321e-4, -4.2048e-7), "J/(kg K)", _RASMUSSEN, (200.0, 600.0)),
    Polynomial((2.5143e-3, 7.7288e-5, 8.6248e-11), "W/(m K)", _RASMUSSEN, (200.0, 600.0)),
)
FLUIDS.register(AIR.name, AIR)

CERAMIC = Solid("ceramic", 2580.0, 846.7, 2.09, "thesis table 6.1: measured (ASTM D792, DSC), Kingery")
# flattening: VDI Heat Atlas D6.3 for ceramic 0.0077, steel 0.0013, copper 0.0253, which stands for aluminium as well
ALUMINIUM = Solid("aluminium", 2702.0, 903.0, 237.0, "thesis table 8.1 [178]", 0.0253)
STEEL = Solid("steel", 7747.0, 464.0, 42.0, "beads of Beaulieu (PhD thesis, Polytechnique Montreal, 2020)", 0.0013)
FRP = Solid("frp", 1600.0, 1075.0, 0.64, "thesis table 8.1 [179], isotropic, through-thickness value")
ACRYLIC = Solid(
    "acrylic",
    constant(1170.0, "kg/m^3", "thesis table 6.1: measured (ASTM D792)"),
    Polynomial((166.95, 4.0289), "J/(kg K)", "Gaur et al., thesis table 6.1 [150]", (230.0, 375.0)),
    Polynomial((1.7149e-1, 8.3338e-5), "W/(m K)", "Eiermann, Hellwege, J. Polym. Sci. 57 (1962) 99-106", (93.0, 363.0)),
)
for _solid in (CERAMIC, ALUMINIUM, STEEL, FRP, ACRYLIC):
    SOLIDS.register(_solid.name, _solid)
