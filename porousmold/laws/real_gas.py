r"""Gases under pressure: the properties of real gases, tabulated by CoolProp once (`studies.fluid_properties`).

    rho = p/(R T + b p),    b(T) = (Z(T, p_0) - 1) R T/p_0

with the compressibility factor Z at the pressure p_0 for which the laws are made: exact there, and a virial equation about it.
Heat capacity, viscosity and conductivity are those at p_0. All are straight lines between the table's 16 temperatures, which
crowd towards saturation. Range: 1 to 50 bar; deviations stand in docs/fluid-properties.md.
"""

import csv
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from ..arrays import Floats
from ..errors import InputError
from .functions import Value
from .materials import UNITS, Fluid, IdealGasDensity, PiecewiseLinear

TABLE = Path(__file__).parent / "library" / "real_gases.csv"
SOURCE = "CoolProp 8.0.0, tabulated (library/real_gases.csv)"


@dataclass(frozen=True)
class RealGasDensity(IdealGasDensity):
    """rho = p/(R T + b(T) p) in kg/m3, pressure absolute in Pa, b (m3/kg) a law of the temperature."""

    covolume: PiecewiseLinear | None = None

    def __call__(self, absolute_pressure: Value, temperature: Value) -> Value:
        assert self.covolume is not None
        return absolute_pressure / (self.gas_constant * temperature + self.covolume(temperature) * absolute_pressure)

    @property
    def coefficients(self) -> tuple[Value, ...]:
        """Those of b."""
        assert self.covolume is not None
        return self.covolume.coefficients

    def with_coefficients(self, coefficients: Iterable[Value]) -> "RealGasDensity":
        """The same with other numbers, for example UFL constants in place of floats."""
        assert self.covolume is not None
        return replace(self, covolume=self.covolume.with_coefficients(coefficients))


@cache
def _states() -> dict[str, tuple[Floats, Floats]]:
    """By gas: pressures (n), and temperature, factor, heat capacity, viscosity and conductivity (n, 5, states) of the table."""
    with TABLE.open(newline="", encoding="utf-8") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))[1:]
    found = {}
    for gas in dict.fromkeys(row[0] for row in rows):
        table = np.array([row[1:] for row in rows if row[0] == gas], float)
        pressures = np.unique(table[:, 0])
        found[gas] = pressures, np.array([table[table[:, 0] == p, 1:].T for p in pressures])
    return found


def real_gas(fluid: Fluid, pressure: float, where: str | None = None) -> Fluid:
    """The gas of the library with the properties of the real one about a pressure (Pa). Raises `InputError`, with `where`, for
    another fluid, and outside the table's pressures."""
    states = _states()
    if fluid.name not in states or not isinstance(fluid.density, IdealGasDensity):
        raise InputError("fluid.real_gas", fluid.name, f"is tabulated for {', '.join(states)}", where)
    pressures, table = states[fluid.name]
    if not 0.95 * pressures[0] <= pressure <= pressures[-1]:
        allowed = f"must be {pressures[0] / 1e5:.3g} to {pressures[-1] / 1e5:g} bar with fluid.real_gas"
        raise InputError("operation.outlet_pressure", f"{pressure:g} Pa", allowed, where)
    place = np.log(max(pressure, pressures[0]))
    temperatures, factors, *others = (
        np.array([np.interp(place, np.log(pressures), values) for values in quantity.T])
        for quantity in table.transpose(1, 0, 2)
    )
    constant = fluid.density.gas_constant
    span = float(temperatures[0]), float(temperatures[-1])

    def law(values: Floats, unit: str) -> PiecewiseLinear:
        return PiecewiseLinear(tuple(np.column_stack([temperatures, values]).ravel().tolist()), unit, SOURCE, span)

    covolume = law((factors - 1.0) * constant * temperatures / pressure, "m^3/kg")
    density = RealGasDensity(constant, SOURCE, temperature_range=span, covolume=covolume)
    names = ("heat_capacity", "viscosity", "conductivity")
    laws = {name: law(values, UNITS[name]) for name, values in zip(names, others, strict=True)}
    return replace(fluid, density=density, **laws)


def density_error(gas: Fluid, pressure: float, temperature: float) -> float:
    """Relative error of a `real_gas`'s density at another pressure (Pa) than that it is made for, against the table there, within
    its range."""
    pressures = _states()[gas.substance][0]
    there = real_gas(replace(gas, name=gas.substance), min(max(pressure, pressures[0]), pressures[-1]))
    return abs(float(gas.density(pressure, temperature) / there.density(pressure, temperature)) - 1.0)
