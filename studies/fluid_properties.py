"""Fluids of the library, fitted to CoolProp: writes porousmold/laws/library/fluids.toml but for air, which is the thesis's.

Needs CoolProp (PyPI), which nothing else does: install it into an environment of its own. Every law is a polynomial of the least
degree that follows CoolProp within `WANTED` of the largest value, six at most; the error that is left stands in its source. Gases
are ideal gases of their molar mass; what that leaves out at 1 bar is told, too.
"""

import sys
from pathlib import Path

import numpy as np

WANTED, HIGHEST_DEGREE, POINTS = 0.002, 6, 200
PRESSURE = 101325.0
LIQUID_PRESSURE = 1e6
"""Pa; at it water is liquid up to 450 K."""
GASES = {
    "nitrogen": ("Nitrogen", 250.0, 800.0),
    "helium": ("Helium", 250.0, 800.0),
    "carbon_dioxide": ("CarbonDioxide", 250.0, 800.0),
    "argon": ("Argon", 250.0, 800.0),
    "steam": ("Water", 380.0, 800.0),
}
LIQUIDS = {
    "water": ("Water", 275.0, 450.0),
    "water_glycol": ("INCOMP::MEG[0.5]", 243.15, 373.15),
    "thermal_oil": ("INCOMP::T66", 290.0, 600.0),
}
NAMES = {"water_glycol": "ethylene glycol, 50 % by mass, in water", "thermal_oil": "Therminol 66"}
PROPERTIES = {"viscosity": "V", "heat_capacity": "C", "conductivity": "L"}
AIR = """# Written by `python -m studies.fluid_properties` but for air. In SI with T in K; gases are ideal.

[air]
molar_mass = 0.028964702298002958
source = "thesis section 6.5.2, 287.055 J/(kg K)"
range = [100.0, 2000.0]

[air.viscosity]
sutherland = [1.716e-5, 273.15, 110.4]
source = "Sutherland, Phil. Mag. 36 (1893) 507-531"
range = [100.0, 1900.0]

[air.heat_capacity]
polynomial = [1.0535e3, -3.8738e-1, 8.9321e-4, -4.2048e-7]
source = "Rasmussen (1997), properties of air for the calibration of microphones"
range = [200.0, 600.0]

[air.conductivity]
polynomial = [2.5143e-3, 7.7288e-5, 8.6248e-11]
source = "Rasmussen (1997), properties of air for the calibration of microphones"
range = [200.0, 600.0]
"""


def fitted(temperatures, values, *, logarithmic):
    """Coefficients of the polynomial, and the largest error over the largest value (of itself, where it is logarithmic)."""
    for degree in range(HIGHEST_DEGREE + 1):
        target = np.log(values) if logarithmic else values
        fit = np.polynomial.Polynomial.fit(temperatures, target, degree).convert().coef
        found = np.polynomial.polynomial.polyval(temperatures, fit)
        missed = np.exp(found) / values - 1.0 if logarithmic else (found - values) / np.max(values)
        error = float(np.max(np.abs(missed)))
        if error < WANTED:
            break
    return fit, error


def law(table, name, fluid, symbol, low, high, pressure):
    """Text of one property's table."""
    from CoolProp.CoolProp import PropsSI

    temperatures = np.linspace(low, high, POINTS)
    values = np.array([PropsSI(symbol, "T", float(T), "P", pressure, fluid) for T in temperatures])
    logarithmic = name == "viscosity" and np.max(values) > 3.0 * np.min(values)
    fit, error = fitted(temperatures, values, logarithmic=logarithmic)
    form = "log_polynomial" if logarithmic else "polynomial"
    numbers = ", ".join(f"{c:.8g}" for c in fit)
    return f'[{table}.{name}]\n{form} = [{numbers}]\nsource = "{source(fluid)}, fitted within {error:.2%}"\n'


def source(fluid):
    import CoolProp

    return f"CoolProp {CoolProp.__version__} ({fluid})"


def main():
    from CoolProp.CoolProp import PropsSI

    parts = [AIR]
    for name, (fluid, low, high) in GASES.items():
        molar_mass = PropsSI("M", fluid)
        temperatures = np.linspace(low, high, POINTS)
        real = np.array([PropsSI("D", "T", float(T), "P", PRESSURE, fluid) for T in temperatures])
        off = float(np.max(np.abs(PRESSURE * molar_mass / (8.31446261815324 * temperatures) / real - 1.0)))
        text = f"{source(fluid)}; at 1 bar within {off:.1%}"
        parts.append(f'[{name}]\nmolar_mass = {molar_mass:.9g}\nsource = "{text}"\nrange = [{low}, {high}]\n')
        parts += [law(name, entry, fluid, symbol, low, high, PRESSURE) for entry, symbol in PROPERTIES.items()]
    for name, (fluid, low, high) in LIQUIDS.items():
        told = f"{NAMES[name]}: {source(fluid)}" if name in NAMES else source(fluid)
        parts.append(f'[{name}]\nsource = "{told}"\nrange = [{low}, {high}]\n')
        entries = {"density": "D", **PROPERTIES}.items()
        parts += [law(name, entry, fluid, symbol, low, high, LIQUID_PRESSURE) for entry, symbol in entries]
    path = Path(sys.argv[1] if len(sys.argv) > 1 else "porousmold/laws/library/fluids.toml")
    path.write_text("\n".join(parts), encoding="utf-8")
    print(path.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
