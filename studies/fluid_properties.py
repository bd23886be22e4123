"""Fluids of the library, fitted to CoolProp: writes library/fluids.toml and library/real_gases.csv of porousmold/laws, and the
comparison with independent tables, docs/fluid-properties.md.

Needs CoolProp, chemicals and iapws (PyPI), which nothing else does: install them into an environment of its own. Every law is a
polynomial of the least degree that follows CoolProp within `WANTED` of its own value; the error that is left stands in its
source. Gases are ideal gases of their molar mass; what that leaves out at 1 bar is told, too. The independent tables are those
of the VDI Heat Atlas and of Perry's handbook (in `chemicals`), and IAPWS's own formulations of 1997, 2008 and 2011 (in
`iapws`).
"""

import csv
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from studies.page import Page

WANTED, HIGHEST_DEGREE, POINTS = 0.001, 8, 200
PRESSURE = 101325.0
LIQUID_PRESSURE = 1e6
"""Pa; at it water is liquid up to 450 K."""
GASES = {
    "air": ("Air", 200.0, 1300.0),
    "nitrogen": ("Nitrogen", 200.0, 1300.0),
    "helium": ("Helium", 200.0, 1300.0),
    "carbon_dioxide": ("CarbonDioxide", 250.0, 1300.0),
    "argon": ("Argon", 200.0, 1300.0),
    "steam": ("Water", 380.0, 1000.0),
}
LIQUIDS = {
    "water": ("Water", 274.0, 450.0),
    "water_glycol": ("INCOMP::MEG[0.5]", 243.15, 373.15),
    "thermal_oil": ("INCOMP::T66", 290.0, 600.0),
    "therminol_vp1": ("INCOMP::TVP1", 290.0, 660.0),
}
NAMES = {
    "water_glycol": "ethylene glycol, 50 % by mass, in water",
    "thermal_oil": "Therminol 66",
    "therminol_vp1": "Therminol VP-1, diphenyl oxide and biphenyl",
}
SOLAR_SALT = {
    "density": [2090.0, -0.636],
    "viscosity": [22.714e-3, -0.120e-3, 2.281e-7, -1.474e-10],
    "heat_capacity": [1443.0, 0.172],
    "conductivity": [0.443, 1.9e-4],
}
"""60 % sodium nitrate, 40 % potassium nitrate by mass: Zavoico, SAND2001-2100, polynomials in degC, 260 to 600 degC. CoolProp's
INCOMP::NaK has the same from 300 degC on."""
PROPERTIES = {"viscosity": "V", "heat_capacity": "C", "conductivity": "L"}
PRESSURES = (1.01325e5, 2e5, 3e5, 5e5, 7e5, 10e5, 15e5, 20e5, 30e5, 40e5, 50e5)
"""Of the table of real gases, Pa."""
STATES, ABOVE_SATURATION = 16, 1.0
"""States of a gas at a pressure, the lowest of them this much (K) above saturation."""
CAS = {
    "air": "132259-10-0",
    "nitrogen": "7727-37-9",
    "helium": "7440-59-7",
    "carbon_dioxide": "124-38-9",
    "argon": "7440-37-1",
}
LIBRARY = Path("porousmold/laws/library")
THESIS_AIR = """# Written by `python -m studies.fluid_properties`. In SI with T in K; gases are ideal.

[thesis_air]
molar_mass = 0.028964702298002958
source = "thesis section 6.5.2, 287.055 J/(kg K)"
range = [100.0, 2000.0]

[thesis_air.viscosity]
sutherland = [1.716e-5, 273.15, 110.4]
source = "Sutherland, Phil. Mag. 36 (1893) 507-531"
range = [100.0, 1900.0]

[thesis_air.heat_capacity]
polynomial = [1.0535e3, -3.8738e-1, 8.9321e-4, -4.2048e-7]
source = "Rasmussen (1997), properties of air for the calibration of microphones"
range = [200.0, 600.0]

[thesis_air.conductivity]
polynomial = [2.5143e-3, 7.7288e-5, 8.6248e-11]
source = "thesis, after Rasmussen (1997): -2.5 % at 300 K, +6.3 % at 600 K"
range = [200.0, 600.0]
"""


def fitted(temperatures, values, *, logarithmic):
    """Coefficients of the polynomial as they are written, and the largest error over the value itself."""
    for degree in range(HIGHEST_DEGREE + 1):
        target, weights = (np.log(values), None) if logarithmic else (values, 1.0 / values)
        fit = np.polynomial.Polynomial.fit(temperatures, target, degree, w=weights).convert().coef
        fit = np.array([float(f"{c:.12g}") for c in fit])
        found = np.polynomial.polynomial.polyval(temperatures, fit)
        error = float(np.max(np.abs((np.exp(found) if logarithmic else found) / values - 1.0)))
        if error < WANTED:
            break
    return fit, error


def law(table, name, fluid, symbol, low, high, pressure):
    """Text of one property's table."""
    from CoolProp.CoolProp import PropsSI

    angles = np.pi * (np.arange(POINTS) + 0.5) / POINTS
    between = 0.5 * (low + high) - 0.5 * (high - low) * np.cos(angles)  # dense at the ends, where polynomials go astray
    temperatures = np.concatenate([[low], between, [high]])
    values = np.array([PropsSI(symbol, "T", float(T), "P", pressure, fluid) for T in temperatures])
    logarithmic = name == "viscosity" and np.max(values) > 3.0 * np.min(values) and table in LIQUIDS
    fit, error = fitted(temperatures, values, logarithmic=logarithmic)
    form = "log_polynomial" if logarithmic else "polynomial"
    numbers = ", ".join(f"{c:.12g}" for c in fit)
    return f'[{table}.{name}]\n{form} = [{numbers}]\nsource = "{source(fluid)}, fitted within {error:.2%}"\n'


def solar_salt() -> str:
    """Text of its table: Zavoico's polynomials, in K."""
    told = 'source = "60 % NaNO3, 40 % KNO3 by mass: Zavoico, SAND2001-2100 (2001)"\nrange = [533.15, 873.15]\n'
    parts = ["[solar_salt]\n" + told]
    for name, celsius in SOLAR_SALT.items():
        kelvin = np.polynomial.Polynomial(celsius)(np.polynomial.Polynomial([-273.15, 1.0])).coef
        numbers = ", ".join(f"{c:.12g}" for c in kelvin)
        parts.append(f"[solar_salt.{name}]\npolynomial = [{numbers}]\n")
    return "\n".join(parts)


def source(fluid):
    import CoolProp

    return f"CoolProp {CoolProp.__version__} ({fluid})"


def write_fluids(path: Path) -> None:
    """The library's fluids."""
    from CoolProp.CoolProp import PropsSI

    parts = [THESIS_AIR]
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
    parts.append(solar_salt())
    path.write_text("\n".join(parts), encoding="utf-8")


def lowest_temperature(name: str, pressure: float) -> float:
    """K, of a gas in the table: that of its laws, or just above saturation."""
    from CoolProp.CoolProp import PropsSI

    fluid, low, _ = GASES[name]
    if fluid not in ("CarbonDioxide", "Water") or pressure > PropsSI("Pcrit", fluid):
        return low
    return max(low, PropsSI("T", "P", pressure, "Q", 1, fluid) + ABOVE_SATURATION)


def write_real_gases(path: Path) -> None:
    """Compressibility factors and the other properties by pressure and temperature, states crowding towards the lowest."""
    from CoolProp.CoolProp import PropsSI

    with path.open("w", newline="", encoding="utf-8") as file:
        file.write(f"# written by `python -m studies.fluid_properties`: {source('all')}\n")
        writer = csv.writer(file, lineterminator="\n")
        units = {"heat_capacity": "J/(kg*K)", "viscosity": "Pa*s", "conductivity": "W/(m*K)"}
        heads = [f"{entry} [{unit}]" for entry, unit in units.items()]
        writer.writerow(["gas", "pressure [Pa]", "temperature [K]", "compressibility_factor", *heads])
        for name, (fluid, _, high) in GASES.items():
            for pressure in PRESSURES:
                low = lowest_temperature(name, pressure)
                for part in np.linspace(0.0, 1.0, STATES):
                    state = "T", float(low + (high - low) * part**3), "P", pressure, fluid
                    values = [state[1], PropsSI("Z", *state), *(PropsSI(PROPERTIES[entry], *state) for entry in units)]
                    writer.writerow([name, f"{pressure:g}", *(f"{value:.6g}" for value in values)])


Reference = Callable[[float], float]


def independent_tables() -> Iterator[tuple[str, str, str, Reference]]:
    """(fluid, property, source, value at a temperature in K at 1 bar, of liquids at 10 bar)."""
    import chemicals
    from chemicals import heat_capacity, thermal_conductivity, viscosity
    from iapws import IAPWS97

    vdi_viscosity, vdi_conductivity = viscosity.mu_data_VDI_PPDS_8, thermal_conductivity.k_data_VDI_PPDS_10
    perry = thermal_conductivity.k_data_Perrys_8E_2_314, viscosity.mu_data_Perrys_8E_2_312
    for name, number in CAS.items():
        if number in vdi_viscosity.index:
            row = vdi_viscosity.loc[number]
            yield name, "viscosity", "VDI Heat Atlas", lambda t, r=row: sum(r[c] * t**k for k, c in enumerate("ABCDE"))
        if number in vdi_conductivity.index:
            row = vdi_conductivity.loc[number]
            yield (
                name,
                "conductivity",
                "VDI Heat Atlas",
                lambda t, r=row: sum(r[c] * t**k for k, c in enumerate("ABCDE")),
            )
        for what, table in zip(("conductivity", "viscosity"), perry, strict=True):
            if number in table.index:
                row = table.loc[number]
                yield name, what, "Perry, 8th ed.", lambda t, r=row: chemicals.EQ102(t, r.C1, r.C2, r.C3, r.C4)
        if number in heat_capacity.TRC_gas_data.index:
            row, mass = heat_capacity.TRC_gas_data.loc[number], chemicals.MW(number) * 1e-3
            yield (
                name,
                "heat_capacity",
                "TRC, ideal gas",
                lambda t, r=row, m=mass: chemicals.TRCCp(t, *(r[f"a{k}"] for k in range(8))) / m,
            )
    for name, pressure in (("steam", 0.101325), ("water", 1.0)):
        for what, attribute, scale in (
            ("density", "rho", 1.0),
            ("viscosity", "mu", 1.0),
            ("heat_capacity", "cp", 1e3),
            ("conductivity", "k", 1.0),
        ):
            yield (
                name,
                what,
                "IAPWS-IF97, 2008, 2011",
                lambda t, p=pressure, a=attribute, s=scale: s * getattr(IAPWS97(T=t, P=p), a),
            )


def write_page(path: Path) -> None:
    """The library beside independent tables, and real gases beside CoolProp between the states of the table."""
    from CoolProp.CoolProp import PropsSI

    from porousmold.laws.material_library import FLUIDS
    from porousmold.laws.real_gas import real_gas

    page = Page(
        "# Fluids of the library beside independent tables",
        "",
        "Written by `make fluid-properties`; do not edit. The library is fitted to CoolProp. Here it stands beside tables of",
        "other origin at 1 bar (water at 10 bar): largest deviation over the temperatures that both hold for.",
        "",
    )
    rows = []
    for name, what, where, reference in independent_tables():
        fluid = FLUIDS[name]
        law = getattr(fluid, what)
        low, high = law.temperature_range if what != "density" else fluid.viscosity.temperature_range
        temperatures = np.linspace(max(low, 250.0) + 1.0, min(high, 1000.0) - 1.0, 40)
        pressure = LIQUID_PRESSURE if name in LIQUIDS else PRESSURE
        deviations = []
        for temperature in temperatures:
            own = law(pressure, temperature) if what == "density" else law(temperature)
            deviations.append(float(own / reference(float(temperature)) - 1.0))
        worst = int(np.argmax(np.abs(deviations)))
        span = f"{temperatures[0]:.0f} to {temperatures[-1]:.0f} K"
        rows.append(
            (
                name,
                what,
                where,
                span,
                f"{np.median(np.abs(deviations)):.2%}",
                f"{deviations[worst]:+.2%}",
                f"{temperatures[worst]:.0f} K",
            )
        )
    page.table(("fluid", "property", "table", "temperatures", "median", "largest", "at"), rows)
    page.add(
        "Not compared, for want of another table: glycol and water, thermal oils, solar salt.",
        "",
        "## Under pressure",
        "",
        "Against CoolProp, largest deviation over 200 temperatures from 5 K above saturation (or the lowest of the law): the",
        "laws of 1 bar and the ideal gas, and with `fluid.real_gas = true`.",
        "",
    )
    rows = []
    entries = ("density", "heat_capacity", "viscosity", "conductivity")
    for name, (fluid, _, high) in GASES.items():
        ideal = FLUIDS[name]
        for pressure in (1.5e5, 4e5, 9e5, 17e5, 45e5):
            low = lowest_temperature(name, pressure) + 4.0
            real = real_gas(ideal, pressure)
            worst = np.zeros(8)
            for temperature in low + (high - 1.0 - low) * np.linspace(0.0, 1.0, POINTS) ** 2:
                state = "T", float(temperature), "P", pressure, fluid
                values = [PropsSI(symbol, *state) for symbol in "DCVL"]
                own = [
                    gas.density(pressure, temperature) if entry == "density" else getattr(gas, entry)(temperature)
                    for gas in (ideal, real)
                    for entry in entries
                ]
                worst = np.maximum(worst, np.abs(np.array(own) / [*values, *values] - 1.0))
            rows.append((name, f"{pressure / 1e5:g}", *(f"{one:.2%}" for one in worst)))
    names = [entry.replace("_", " ") for entry in entries]
    page.table(("gas", "bar", f"1 bar: {names[0]}", *names[1:], f"real gas: {names[0]}", *names[1:]), rows)
    page.write(path)


def main():
    write_fluids(LIBRARY / "fluids.toml")
    write_real_gases(LIBRARY / "real_gases.csv")
    write_page(Path("docs/fluid-properties.md"))


if __name__ == "__main__":
    main()
