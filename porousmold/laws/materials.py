r"""Property laws of fluids, beads and walls, each with its unit, its source and the temperatures it holds for.

A law is a `Polynomial` in the temperature T (K), the exponential of one, straight lines between points, or Sutherland's
viscosity. Laws accept floats, numpy arrays and UFL. The materials themselves are in `material_library`.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import isfinite, log

from .cure import Cure
from .functions import Value, exp, maximum, minimum


@dataclass(frozen=True)
class Polynomial:
    """c0 + c1 T + c2 T^2 + ... of the temperature in K, with its unit, source and range of temperature in K.

    The coefficients may be numbers or UFL constants. Beyond its range the law goes on along its tangent: powers from the third on
    would give carbon dioxide of 1500 degC 1.3 times its heat capacity, and steam a negative one.
    """

    coefficients: tuple[Value, ...]
    unit: str
    source: str
    temperature_range: tuple[float, float] = (0.0, float("inf"))

    def __call__(self, temperature: Value) -> Value:
        """Value at the temperature (K)."""
        if self._is_straight:
            return _horner(self.coefficients, temperature)
        inside, beyond = self._split(temperature)
        return _horner(self.coefficients, inside) + sum(self._slope(end) * away for end, away in beyond)

    def integral(self, temperature: Value) -> Value:
        """Antiderivative c0 T + c1 T^2/2 + ..., zero at 0 K: the enthalpy, if the law is a heat capacity."""
        coefficients = (0.0, *(one / power for power, one in enumerate(self.coefficients, start=1)))
        if self._is_straight:
            return _horner(coefficients, temperature)
        inside, beyond = self._split(temperature)
        return _horner(coefficients, inside) + sum(
            (_horner(self.coefficients, end) + 0.5 * self._slope(end) * away) * away for end, away in beyond
        )

    def times(self, factor: float) -> "Polynomial":
        """The law times a factor."""
        return self.with_coefficients(factor * one for one in self.coefficients)

    @property
    def _is_straight(self) -> bool:
        return len(self.coefficients) < 3 or not isfinite(self.temperature_range[1])

    def _split(self, temperature: Value) -> tuple[Value, tuple[tuple[float, Value], ...]]:
        """The temperature within the range, and each end of that with how far it is beyond (K, signed)."""
        low, high = self.temperature_range
        below, above = minimum(temperature - low, 0.0), maximum(temperature - high, 0.0)
        return minimum(maximum(temperature, low), high), ((low, below), (high, above))

    def _slope(self, temperature: float) -> Value:
        return _horner(tuple(n * one for n, one in enumerate(self.coefficients) if n), temperature)

    def with_coefficients(self, coefficients: Iterable[Value]) -> "Polynomial":
        """The same law with other numbers, for example UFL constants in place of floats."""
        return replace(self, coefficients=tuple(coefficients))


def _horner(coefficients: tuple[Value, ...], temperature: Value) -> Value:
    """c0 + c1 T + c2 T^2 + ..."""
    value = coefficients[-1] + 0.0 * temperature
    for coefficient in reversed(coefficients[:-1]):
        value = value * temperature + coefficient
    return value


def constant(value: Value, unit: str, source: str) -> Polynomial:
    """A property that does not depend on temperature."""
    return Polynomial((value,), unit, source)


@dataclass(frozen=True)
class LogPolynomial:
    """exp(c0 + c1 T + c2 T^2 + ...) of the temperature in K: for what changes by orders of magnitude, as a liquid's viscosity.

    Beyond its range the exponent goes on along its tangent: the polynomial itself would make water at 650 K stiffer than rock.
    """

    coefficients: tuple[Value, ...]
    unit: str
    source: str
    temperature_range: tuple[float, float] = (0.0, float("inf"))

    def __call__(self, temperature: Value) -> Value:
        """Value at the temperature (K)."""
        return exp(Polynomial(self.coefficients, "", "", self.temperature_range)(temperature))

    def times(self, factor: float) -> "LogPolynomial":
        """The law times a factor."""
        return self.with_coefficients((self.coefficients[0] + log(factor), *self.coefficients[1:]))

    def with_coefficients(self, coefficients: Iterable[Value]) -> "LogPolynomial":
        """The same law with other numbers, for example UFL constants in place of floats."""
        return replace(self, coefficients=tuple(coefficients))


@dataclass(frozen=True)
class PiecewiseLinear:
    """Straight lines between points (T_i, v_i) of increasing temperature (K), constant beyond them.

    `coefficients` are T_1, v_1, T_2, v_2, ...
    """

    coefficients: tuple[Value, ...]
    unit: str
    source: str
    temperature_range: tuple[float, float] = (0.0, float("inf"))

    def _pieces(self, temperature: Value) -> Iterable[tuple[Value, Value, Value]]:
        """Of every interval: its slope, how far the temperature has gone into it, and how far beyond it (K)."""
        places, values = self.coefficients[::2], self.coefficients[1::2]
        for first, last, low, high in zip(places[:-1], places[1:], values[:-1], values[1:], strict=True):
            inside = minimum(maximum(temperature - first, 0.0), last - first)
            yield (high - low) / (last - first), inside, maximum(temperature - last, 0.0)

    def __call__(self, temperature: Value) -> Value:
        """Value at the temperature (K)."""
        rise = sum(slope * inside for slope, inside, _ in self._pieces(temperature))
        return self.coefficients[1] + 0.0 * temperature + rise

    def integral(self, temperature: Value) -> Value:
        """Antiderivative, that of the first value at 0 K: the enthalpy, if the law is a heat capacity."""
        rises = (slope * inside * (0.5 * inside + beyond) for slope, inside, beyond in self._pieces(temperature))
        return self.coefficients[1] * temperature + sum(rises)

    def times(self, factor: float) -> "PiecewiseLinear":
        """The law times a factor."""
        return self.with_coefficients(factor * one if n % 2 else one for n, one in enumerate(self.coefficients))

    def with_coefficients(self, coefficients: Iterable[Value]) -> "PiecewiseLinear":
        """The same law with other numbers, for example UFL constants in place of floats."""
        return replace(self, coefficients=tuple(coefficients))


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

    def times(self, factor: float) -> "SutherlandViscosity":
        """The law times a factor."""
        return replace(self, reference_viscosity=factor * self.reference_viscosity)


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

    @property
    def coefficients(self) -> tuple[Value, ...]:
        """The value."""
        return (self.value,)

    def with_coefficients(self, coefficients: Iterable[Value]) -> "ConstantDensity":
        """The same with another number, for example a UFL constant in place of a float."""
        (value,) = coefficients
        return replace(self, value=value)


@dataclass(frozen=True)
class LiquidDensity:
    """A liquid's density in kg/m3 as a law of the temperature, whatever the pressure."""

    law: Polynomial | PiecewiseLinear
    unit: str = "kg/m^3"

    def __call__(self, absolute_pressure: Value, temperature: Value) -> Value:
        return self.law(temperature)

    @property
    def compressible(self) -> bool:
        return False

    @property
    def source(self) -> str:
        return self.law.source

    @property
    def temperature_range(self) -> tuple[float, float]:
        return self.law.temperature_range

    @property
    def coefficients(self) -> tuple[Value, ...]:
        """Those of the law."""
        return self.law.coefficients

    def with_coefficients(self, coefficients: Iterable[Value]) -> "LiquidDensity":
        """The same with other numbers, for example UFL constants in place of floats."""
        return replace(self, law=self.law.with_coefficients(coefficients))


UNITS = {
    "density": "kg/m^3",
    "heat_capacity": "J/(kg K)",
    "conductivity": "W/(m K)",
    "conductivity_in_plane": "W/(m K)",
    "viscosity": "Pa s",
}


SMALL_EXCESS = 0.1
"""K beyond a law's range that are not told."""
CHANGED = ", but "
"""What follows a material's name where a scene changes properties of it."""


def _law_of(value: Value, name: str, source: str) -> Value:
    """A property law of a number; a law as it is."""
    return value if callable(value) else constant(float(value), UNITS[name], source)


@dataclass(frozen=True)
class Fluid:
    """Laws of a fluid: `density` of absolute pressure and temperature (`IdealGasDensity`, `ConstantDensity`, `LiquidDensity`),
    `viscosity`, `heat_capacity` and `conductivity` of the temperature. SI units; a number in place of a law is a constant
    property, whose source is `source`. The heat capacity has an `integral`, the enthalpy (`Polynomial`, `PiecewiseLinear`)."""

    name: str
    density: IdealGasDensity | ConstantDensity | LiquidDensity
    viscosity: Value
    heat_capacity: Value
    conductivity: Value
    source: str = ""

    def __post_init__(self) -> None:
        if not callable(self.density):
            object.__setattr__(self, "density", ConstantDensity(float(self.density), self.source))
        for name in ("viscosity", "heat_capacity", "conductivity"):
            object.__setattr__(self, name, _law_of(getattr(self, name), name, self.source))

    @property
    def substance(self) -> str:
        """Its name in the library, whatever properties of it a scene changes."""
        return self.name.partition(CHANGED)[0]

    def laws(self) -> dict[str, Value]:
        """The four laws by name."""
        return {name: getattr(self, name) for name in ("density", "viscosity", "heat_capacity", "conductivity")}


@dataclass(frozen=True)
class Solid:
    """Laws of a solid: constant `density` (kg/m3), `heat_capacity` (J/(kg K), with an `integral`) and `conductivity` (W/(m K))
    of T. A number in place of a law is a constant property, whose source is `source`.

    `conductivity_in_plane` is that along a layer of it, where it is not that through it, `cure` how it cures.
    `contact_flattening` is the share of a bead's section that is flattened where beads of it touch (`laws.conductivity`): of
    ceramic where nothing else is known."""

    name: str
    density: Value
    heat_capacity: Value
    conductivity: Value
    source: str = ""
    contact_flattening: Value = 0.0077
    conductivity_in_plane: Value = None
    cure: Cure | None = None

    def __post_init__(self) -> None:
        for name in self._given():
            object.__setattr__(self, name, _law_of(getattr(self, name), name, self.source))

    def _given(self) -> list[str]:
        names = ["density", "heat_capacity", "conductivity"]
        return names if self.conductivity_in_plane is None else [*names, "conductivity_in_plane"]

    def laws(self) -> dict[str, Value]:
        """The laws by name."""
        return {name: getattr(self, name) for name in self._given()}


def beyond_ranges(material: Fluid | Solid, low: float, high: float, laws: Iterable[str] = ()) -> list[str]:
    """A sentence on those of some `laws` of a material (default: all) that do not hold from one temperature (K) to another, if
    any, and on what each is given for."""
    beyond: dict[str, list[str]] = {}
    for name, law in material.laws().items():
        first, last = law.temperature_range
        if (name in laws or not laws) and (low < first - SMALL_EXCESS or high > last + SMALL_EXCESS):
            beyond.setdefault(f"{first - 273.15:.1f} to {last - 273.15:.1f} °C", []).append(name)
    if not beyond:
        return []
    given = ", ".join(f"{known} ({', '.join(names)})" for known, names in beyond.items())
    substance = material.name.partition(CHANGED)[0]
    return [f"{substance} is used for {low - 273.15:.1f} to {high - 273.15:.1f} °C, given for {given}"]


def without_value(material: Fluid | Solid, pressure: float, temperature: float) -> str:
    """A sentence for a property that is no positive number at a pressure (Pa) and temperature (K), such as a polynomial far
    outside its range; '' where there is none."""
    for name, law in material.laws().items():
        arguments = (pressure,) if isinstance(material, Fluid) and name == "density" else ()
        value = float(law(*arguments, temperature))
        if not (value > 0.0 and isfinite(value)):
            low, high = (f"{limit - 273.15:.1f}" for limit in law.temperature_range)
            return f"{material.name} {name}, which is given for {low} to {high} °C, has no value there"
    return ""
