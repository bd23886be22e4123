"""Numbers with units at the program's border: everything inside is SI."""

import contextlib
import functools
import json
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import InputError
from .atomic_files import whole_file
from .cache_folder import cache_home

_NUMBER_AND_UNIT = re.compile(r"^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*$")

_FACTOR = r"(?:1|(?:[^\W\d]|[°%])[\w°%]*)(?: ?(?:\*\*|\^) ?[-+]?\d{1,2}(?:\.\d{1,2})?)?"
_PRODUCT = rf"{_FACTOR}(?:(?: ?[*/·⋅] ?| ){_FACTOR})*"
_GROUP = rf"(?:{_FACTOR}|\({_PRODUCT}\))"
_UNIT = re.compile(rf"{_GROUP}(?:(?: ?[*/·⋅] ?| ){_GROUP})*")
"""A product of units with short exponents, and no arithmetic that pint would evaluate."""
FARTHEST = 1e6
"""m: beyond it no bed lies, and squares lose their digits."""
LONGEST_UNIT = 60
"""Characters of a unit."""

_AS_WRITTEN = str.maketrans({"\N{GREEK SMALL LETTER MU}": "\N{MICRO SIGN}", "\N{MINUS SIGN}": "-", "℃": "degC"})
"""Characters that texts come with, by those that stand for them here."""
_LARGE = 2.0**100
"""A number that leaves the zero of a unit behind, and only shifts the exponent of its size."""
COLDEST_WITHOUT_UNIT = 150.0
"""Temperature (K) below which a number needs a unit."""


@functools.cache
def _registry() -> Any:
    import pint  # half a second, which a scene of units that were read before does not pay

    return pint.UnitRegistry()


class _Scale(NamedTuple):
    """A unit in another one: the values are `size` times the number, plus `zero`."""

    size: float
    zero: float


def _scale_of(given: str, unit: str) -> _Scale:
    """Scale of a unit in another one, from the user's cache or by pint. Raises what pint raises."""
    known = _known_scales()
    name = f"{given} in {unit}"
    if name not in known:
        registry = _registry()
        zero, large = (registry.Quantity(number, given).to(unit).magnitude for number in (0.0, _LARGE))
        known[name] = _Scale(large / _LARGE, zero)
        _remember(known)
    return known[name]


def _cache() -> Path:
    """File of the units that were read before."""
    return cache_home() / "porousmold" / "units.json"


@functools.cache
def _known_scales() -> dict[str, _Scale]:
    """Units that were read before; none where the cache cannot be read."""
    try:
        stored = json.loads(_cache().read_text(encoding="utf-8"))
        return {str(name): _Scale(float(size), float(zero)) for name, (size, zero) in stored.items()}
    except (OSError, ValueError, TypeError, AttributeError):
        return {}


def _remember(known: dict[str, _Scale]) -> None:
    """Write the cache, if the user's folder lets it be written."""
    with contextlib.suppress(OSError):
        _cache().parent.mkdir(parents=True, exist_ok=True)
        with whole_file(_cache()) as temporary:
            temporary.write_text(json.dumps(known), encoding="utf-8")


def to_si(key: str, value: object, unit: str, where: str | None = None) -> float:
    """The value in `unit` (a pint unit name, '' for pure numbers), from a number in SI or a text like '5 mm'.

    Temperatures may be in degC; temperature differences (unit 'delta_degC' or 'kelvin' margins) are in K. Raises
    `InputError` naming the key for a value that is no number, not finite, or of another dimension.
    """
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise InputError(key, value, f"must be a number in {unit or 'no unit'} or a text with a unit", where)
    if isinstance(value, str):
        value = _converted(key, value, unit, where)
    try:
        finite = math.isfinite(value)
    except OverflowError:  # an integer of hundreds of digits
        finite = False
    if not finite:
        raise InputError(key, value, "must be a finite number", where)
    return float(value)


def given_in_si(key: str, value: Any, unit: str, where: str | None = None) -> float:
    """`to_si` of what a user gives: a temperature without a unit that no mold has is refused, as it is likely to be meant in
    degrees Celsius."""
    number = to_si(key, value, unit, where)
    try:
        is_bare = unit == "K" and 0.0 < float(value) < COLDEST_WITHOUT_UNIT
    except ValueError:
        is_bare = False
    if is_bare:
        raise InputError(key, value, f"needs a unit: '{number:g} degC' or '{number:g} K'", where)
    return number


def whole_number(key: str, text: str, least: int = 0, most: int = 10**15) -> int:
    """The number of a text. Raises `InputError` naming the key where it is no whole number from `least` to `most`."""
    text = text.strip()
    if not (text.isdecimal() and len(text) <= 16 and least <= int(text) <= most):
        raise InputError(key, text, f"must be a whole number from {least} to {most}")
    return int(text)


def _converted(key: str, text: str, unit: str, where: str | None) -> float:
    text = text.translate(_AS_WRITTEN)
    match = _NUMBER_AND_UNIT.match(text)
    if re.match(r"\s*[-+]?\d+,\d", text):
        raise InputError(key, text, "must have a decimal point, not a comma", where)
    allowed = f"must be a number with a unit of {_dimension(unit)}, like {_example(unit)!r}"
    if match is None:
        raise InputError(key, text, allowed, where)
    number, given = float(match.group(1)), match.group(2)
    if not given:
        return number
    if given.strip() == "%" and unit == "":
        return number / 100.0
    given = re.sub(r"\bm([23])\b", r"m^\1", " ".join(given.split()))  # W/m2/K, as it is printed
    if len(given) > LONGEST_UNIT or not _UNIT.fullmatch(given):
        raise InputError(key, text, allowed, where)
    try:
        scale = _scale_of(given, {"delta_degC": "kelvin", "": "dimensionless"}.get(unit, unit))
    except Exception as error:  # pint raises many kinds, AssertionError among them, for units that are no units
        raise InputError(key, text, allowed, where) from error
    if unit == "K" and given.startswith("delta_"):
        raise InputError(key, text, "is a temperature difference, not a temperature", where)
    if unit == "delta_degC" and scale.zero != 0.0:
        raise InputError(key, text, "is a temperature difference: give it in K", where)
    return number * scale.size + scale.zero


_EXAMPLES = {
    "m": ("length", "5 mm"),
    "K": ("temperature", "90 degC"),
    "delta_degC": ("temperature difference", "2 K"),
    "Pa": ("pressure", "8 kPa"),
    "s": ("time", "30 min"),
    "kg/m^3": ("density", "2580 kg/m^3"),
    "J/(kg*K)": ("specific heat capacity", "0.9 kJ/kg/K"),
    "W/(m*K)": ("thermal conductivity", "0.2 W/m/K"),
    "m/s": ("velocity", "1.5 m/s"),
    "kg/s": ("mass flow", "40 g/s"),
    "Pa*s": ("viscosity", "1 mPa*s"),
    "W/(m^2*K)": ("heat transfer coefficient", "5 W/m^2/K"),
    "W/(m^3*K)": ("heat transfer coefficient per volume", "40 kW/m^3/K"),
    "kg/(m^3*s)": ("drag per volume and velocity", "1.1 kg/m^3/s"),
    "W/m^2": ("heat flux", "50 W/m^2"),
    "m^3/s": ("volume flow", "9 ft^3/min"),
    "m^2": ("area", "81 cm^2"),
    "kg": ("mass", "150 g"),
    "W/K": ("conductance", "15 W/K"),
    "Pa*s^2/m^6": ("resistance of a duct", "2e5 Pa*s^2/m^6"),
    "J/kg": ("heat per mass", "180 kJ/kg"),
    "J/mol": ("activation energy", "66 kJ/mol"),
    "1/s": ("rate", "1.5e5 1/s"),
    "W/m^3": ("heat source per volume", "20 kW/m^3"),
    "m^2*K/W": ("thermal contact resistance", "2e-4 m^2*K/W"),
    "K/s": ("heating rate", "2 K/min"),
    "kg/mol": ("molar mass", "28.96 g/mol"),
    "Pa*s/m^3": ("hydraulic resistance", "5.9e8 Pa*s/m^3"),
    "J": ("energy", "4 MJ"),
    "W": ("power", "2 kW"),
    "m/s^2": ("acceleration", "9.81 m/s^2"),
    "": ("a pure number", "0.4"),
}


def _dimension(unit: str) -> Any:
    return _EXAMPLES[unit][0]


def _example(unit: str) -> str:
    return _EXAMPLES[unit][1]


class _Preferred(NamedTuple):
    """A unit that readers prefer to that of the SI, for values (SI) from `low` up to `high`: its `size` and `zero` in SI."""

    sign: str
    size: float
    low: float = 0.0
    high: float = math.inf
    zero: float = 0.0


_PREFERRED = {
    "m": _Preferred("mm", 1e-3, high=1.0),
    "K": _Preferred("°C", 1.0, zero=273.15),
    "s": _Preferred("min", 60.0, low=180.0),
    "Pa": _Preferred("kPa", 1e3, low=1e3),
    "W": _Preferred("kW", 1e3, low=1e3),
    "J": _Preferred("kWh", 3.6e6, low=3.6e5),
    "kg/s": _Preferred("g/s", 1e-3, high=1.0),
}


def preferred_unit(values: Sequence[float | None], unit: str) -> tuple[list[float | None], str]:
    """SI values in the one unit in which readers like them, and its sign: mm, °C, min, kPa, kW, kWh or g/s where they suit the
    largest value, else the `unit` itself."""
    largest = max((abs(value) for value in values if value is not None), default=math.nan)
    preferred = _PREFERRED.get(unit)
    if preferred is None or not preferred.low <= largest < preferred.high:
        return list(values), {"delta_degC": "K", "1": ""}.get(unit, unit)
    return [None if value is None else (value - preferred.zero) / preferred.size for value in values], preferred.sign
