"""Materials from TOML tables, those of the library and a user's own.

    [NAME]
    density = "7.85 g/cm^3"                                   # a number (SI), or a text with a unit
    heat_capacity = { polynomial = [446.0, 0.12] }            # c0 + c1 T + ... in SI, T in K
    conductivity = { table = "k.csv", source = "supplier" }   # CSV file: temperature [degC], conductivity [W/(m*K)]
    source = "EN 10088-1"
    range = ["20 degC", "400 degC"]

A material with a `viscosity` is a fluid: a gas with a `molar_mass`, a liquid with a `density`. Every property may have a source
and a range of its own; liquids' viscosity is best `{ log_polynomial = [...] }`, exp(c0 + c1 T + ...). A resin has a table `cure`
of `laws.cure.Cure`.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Floats, Integers
from ..errors import InputError
from ..files.tables import existing_file, read_columns
from ..files.units import to_si
from .cure import GAS_CONSTANT, Cure
from .functions import Value
from .materials import (
    UNITS,
    ConstantDensity,
    Fluid,
    IdealGasDensity,
    LiquidDensity,
    LogPolynomial,
    PiecewiseLinear,
    Polynomial,
    Solid,
    SutherlandViscosity,
)

MOST_POINTS, CLOSENESS = 16, 1e-3
"""Points kept of a property's table, and the part of its largest value that lines between them may miss."""
SAMPLES = 50
_FORMS = ("polynomial", "log_polynomial", "sutherland", "table")
_COMMON = ("source", "range")
_SOLID = ("density", "heat_capacity", "conductivity")
_FLUID = ("viscosity", "heat_capacity", "conductivity")
_SOLID_OPTIONS = ("conductivity_in_plane", "contact_flattening", "cure")
_CURE = {
    "rate_1": "1/s",
    "activation_energy_1": "J/mol",
    "rate_2": "1/s",
    "activation_energy_2": "J/mol",
    "order_m": "",
    "order_n": "",
    "heat": "J/kg",
    "initial": "",
}
_DENSITIES = ("density", "molar_mass")


def read_materials(tables: Mapping[str, object], base: Path, where: str | None) -> dict[str, Solid | Fluid]:
    """Materials by name, of tables whose CSV files are relative to the folder `base`; raises `InputError` naming key and file."""
    return {name: _material(name, table, base, where) for name, table in tables.items()}


def _material(name: str, table: object, base: Path, where: str | None) -> Solid | Fluid:
    key = f"materials.{name}"
    if not isinstance(table, dict):
        raise InputError(key, str(table), "must be a table of properties", where)
    is_fluid = "viscosity" in table
    known = (*_FLUID, *_DENSITIES, *_COMMON) if is_fluid else (*_SOLID, *_SOLID_OPTIONS, *_COMMON)
    for entry in table:
        if entry not in known:
            kind = "fluid" if is_fluid else "solid"
            raise InputError(f"{key}.{entry}", str(table[entry]), f"is none of a {kind}'s: {', '.join(known)}", where)
    for entry in _FLUID if is_fluid else _SOLID:
        if entry not in table:
            raise InputError(f"{key}.{entry}", None, "is missing", where)
    reader = _Reader(key, table, base, where)
    if is_fluid:
        return Fluid(name, reader.fluid_density(), *(reader.law(entry) for entry in _FLUID))
    if not len(getattr(density := reader.law("density"), "coefficients", ())) == 1:
        raise InputError(f"{key}.density", None, "must be one number: a solid's mass does not change", where)
    options: dict[str, Any] = {}
    if "conductivity_in_plane" in table:
        options["conductivity_in_plane"] = reader.law("conductivity_in_plane")
    if "contact_flattening" in table:
        options["contact_flattening"] = reader.number("contact_flattening", "", 0.5)
    if "cure" in table:
        options["cure"] = reader.cure()
    return Solid(name, density, reader.law("heat_capacity"), reader.law("conductivity"), reader.source, **options)


class _Reader:
    """Reads the properties of one material, whose errors name `key` and `where`."""

    def __init__(self, key: str, table: Mapping[str, object], base: Path, where: str | None) -> None:
        self._key, self._table, self._base, self._where = key, table, base, where
        self.source = str(table.get("source", f"given in {Path(where).name}" if where else "given"))
        self._range = self._span(key, table["range"]) if "range" in table else (0.0, float("inf"))

    def number(self, name: str, unit: str, most: float = 1e9) -> float:
        """A positive number in `unit`."""
        value = to_si(f"{self._key}.{name}", self._table[name], unit, self._where)
        if not 0.0 < value <= most:
            raise InputError(f"{self._key}.{name}", value, f"must be > 0 and <= {most:g} {unit}".strip(), self._where)
        return value

    def cure(self) -> Cure:
        """The cure of a resin. Raises `InputError` where a parameter is missing, or where it could not begin."""
        key, given = f"{self._key}.cure", self._table["cure"]
        if not isinstance(given, dict) or given.keys() != _CURE.keys():
            raise InputError(key, str(given), f"must be a table of {', '.join(_CURE)}", self._where)
        values = {name: to_si(f"{key}.{name}", given[name], unit, self._where) for name, unit in _CURE.items()}
        for name, value in values.items():
            if value < 0.0 or (name == "initial" and value >= 1.0) or (name == "order_n" and value == 0.0):
                raise InputError(f"{key}.{name}", value, "must not be negative; initial < 1, order_n > 0", self._where)
        cure = Cure(**values)
        if not cure.rate(np.array([cure.initial]), np.array([500.0]))[0] > 0.0:
            raise InputError(
                f"{key}.initial", cure.initial, "must be > 0 where rate_1 is 0: it never begins", self._where
            )
        return cure

    def fluid_density(self) -> IdealGasDensity | ConstantDensity | LiquidDensity:
        """An ideal gas of a molar mass, or a liquid."""
        given = [name for name in _DENSITIES if name in self._table]
        if len(given) != 1:
            allowed = "needs either a molar_mass (a gas) or a density (a liquid)"
            raise InputError(self._key, None, allowed, self._where)
        if given == ["molar_mass"]:
            constant = GAS_CONSTANT / self.number("molar_mass", "kg/mol", 1.0)
            return IdealGasDensity(constant, f"ideal gas; {self.source}", temperature_range=self._range)
        law = self.law("density")
        return ConstantDensity(law.coefficients[0], law.source) if len(law.coefficients) == 1 else LiquidDensity(law)

    def law(self, name: str) -> Value:
        """The law of a property. Raises `InputError` where it is none, or not positive over its range."""
        key, given, unit = f"{self._key}.{name}", self._table[name], UNITS[name]
        if not isinstance(given, dict):
            return Polynomial((self.number(name, _pint(unit)),), unit, self.source, self._range)
        forms = [form for form in _FORMS if form in given]
        unknown = [entry for entry in given if entry not in (*_FORMS, *_COMMON)]
        if len(forms) != 1 or unknown:
            allowed = f"must have one of {', '.join(_FORMS)}, beside source and range"
            raise InputError(key, str(given), allowed, self._where)
        span = self._span(key, given["range"]) if "range" in given else self._range
        source = str(given.get("source", self.source))
        law = self._of_form(key, name, forms[0], given[forms[0]], source, span)
        self._check(key, law)
        return law

    def _of_form(self, key: str, name: str, form: str, given: object, source: str, span: tuple[float, float]) -> Value:
        unit = UNITS[name]
        if form == "table":
            return self._of_table(key, name, given, source)
        if not isinstance(given, list) or not given or not all(isinstance(c, int | float) for c in given):
            raise InputError(f"{key}.{form}", str(given), "must be a list of numbers (SI, T in K)", self._where)
        coefficients = tuple(float(c) for c in given)
        if form == "sutherland":
            if name != "viscosity" or len(coefficients) != 3:
                allowed = "must be [viscosity, temperature, constant] of a viscosity"
                raise InputError(f"{key}.{form}", str(given), allowed, self._where)
            viscosity, temperature, constant = coefficients
            return SutherlandViscosity(viscosity, temperature, constant, source, temperature_range=span)
        if form == "log_polynomial":
            if name in ("heat_capacity", "density"):
                raise InputError(f"{key}.{form}", str(given), "must be a polynomial or a table here", self._where)
            return LogPolynomial(coefficients, unit, source, span)
        return Polynomial(coefficients, unit, source, span)

    def _of_table(self, key: str, name: str, given: object, source: str) -> PiecewiseLinear:
        path = existing_file(f"{key}.table", given, self._base, self._where)
        columns = read_columns(f"{key}.table", path)
        if columns.names != ["temperature", name]:
            allowed = f"must have the head 'temperature [degC], {name} [{_pint(UNITS[name])}]'"
            raise InputError(f"{key}.table", ", ".join(columns.names), allowed, str(path))
        temperatures, values = columns.in_si(0, "K"), columns.in_si(1, _pint(UNITS[name]))
        if len(values) < 2 or np.any(np.diff(temperatures) <= 0.0):
            raise InputError(f"{key}.table", str(path), "must have rows of increasing temperature", self._where)
        kept, missed = thinned(temperatures, values)
        source = f"{source} ({path.name}"
        source += f": {len(kept)} of {len(values)} rows, within {missed:.1%})" if len(kept) < len(values) else ")"
        points = tuple(float(x) for pair in zip(temperatures[kept], values[kept], strict=True) for x in pair)
        return PiecewiseLinear(points, UNITS[name], source, (float(temperatures[0]), float(temperatures[-1])))

    def _span(self, key: str, given: object) -> tuple[float, float]:
        if not isinstance(given, list) or len(given) != 2:
            raise InputError(f"{key}.range", str(given), "must be two temperatures, like [300, 500]", self._where)
        low, high = (to_si(f"{key}.range", value, "K", self._where) for value in given)
        if not 0.0 <= low < high:
            raise InputError(f"{key}.range", str(given), "must be two increasing temperatures", self._where)
        return low, high

    def _check(self, key: str, law: Value) -> None:
        low, high = law.temperature_range
        with np.errstate(all="ignore"):
            values = law(np.linspace(max(low, 200.0), min(high, 600.0), SAMPLES))
        if not np.all(np.isfinite(values)) or np.min(values) <= 0.0:
            place = f"from {max(low, 200.0):g} to {min(high, 600.0):g} K"
            raise InputError(key, float(np.min(values)), f"must be positive {place}", self._where)


def _pint(unit: str) -> str:
    """The unit as `files.units` writes it."""
    return unit.replace(" ", "*")


def thinned(places: Floats, values: Floats) -> tuple[Integers, float]:
    """Numbers of the points that straight lines need to follow (places, values) to `CLOSENESS`, at most `MOST_POINTS` of them,
    each the worst missed so far; and the part of the largest value that is missed."""
    kept = [0, len(values) - 1]
    scale = float(np.max(np.abs(values)))
    while True:
        kept.sort()
        missed = np.abs(np.interp(places, places[kept], values[kept]) - values)
        worst = int(np.argmax(missed))
        if missed[worst] <= CLOSENESS * scale or len(kept) == MOST_POINTS:
            return np.array(kept), float(missed[worst] / scale)
        kept.append(worst)
