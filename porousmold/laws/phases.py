r"""Where the fluids of the library are what their laws take them for: an ideal gas, or a liquid below its boiling point.

Departure of a gas from the ideal one by the equation of state of Peng and Robinson (Ind. Eng. Chem. Fundam. 15 (1976) 59-64),
with p_r, T_r over the critical point and w the acentric factor,

    Z^3 - (1 - B) Z^2 + (A - 2 B - 3 B^2) Z - (A B - B^2 - B^3) = 0,   A = 0.45724 a p_r/T_r^2,   B = 0.0778 p_r/T_r,
    a = [1 + k (1 - T_r^1/2)]^2,   k = 0.37464 + 1.54226 w - 0.26992 w^2,

an estimate: Z is within 0.016 of published values for air at 60 bar, argon at 100, helium at 90 and carbon dioxide at 10, and
0.02 too large for steam at 10 bar. Pressure of saturation of water by Wagner and Pruss (J. Phys. Chem. Ref. Data 22 (1993) 783,
equation 1), of others by Lee and Kesler (AIChE J. 21 (1975) 510).
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

LARGEST_DEPARTURE = 0.006
"""Of a density from the ideal gas's that is not worth a warning: heat capacity and conductivity depart three to five times as
much (air at 45 bar and 300 K: 1.8 %, heating times 2.6 to 7.2 %; argon at 10 bar: 0.8 and 2.3 %)."""
COLDEST_PART = 0.35
"""Of the critical temperature, below which no saturation is sought."""
WAGNER = (
    (1.0, -7.85951783),
    (1.5, 1.84408259),
    (3.0, -11.7866497),
    (3.5, 22.6807411),
    (4.0, -15.9618719),
    (7.5, 1.80122502),
)


@dataclass(frozen=True)
class Phase:
    """Of a fluid: critical `temperature` (K) and `pressure` (Pa), `acentric` factor (Poling, Prausnitz, O'Connell, The Properties
    of Gases and Liquids, appendix A), whether its laws are those of a `liquid`, and the `part` of water in a mixture's vapour
    pressure (Raoult; None where it is no water)."""

    temperature: float
    pressure: float
    acentric: float
    liquid: bool = False
    part: float | None = None

    def compressibility_factor(self, pressure: float, temperature: float) -> float:
        """Z = p/(rho R T) of the gas, by Peng and Robinson."""
        reduced, w = temperature / self.temperature, self.acentric
        slope = 0.37464 + 1.54226 * w - 0.26992 * w**2
        attraction = 0.45724 * (1.0 + slope * (1.0 - math.sqrt(reduced))) ** 2 * pressure / self.pressure / reduced**2
        volume = 0.0778 * pressure / self.pressure / reduced
        cubic = (
            *(1.0, volume - 1.0, attraction - 2.0 * volume - 3.0 * volume**2),
            -(attraction * volume - volume**2 - volume**3),
        )
        return float(max(root.real for root in np.roots(cubic) if abs(root.imag) < 1e-9))

    def saturation_pressure(self, temperature: float) -> float:
        """Pa; infinite above the critical temperature, where there is one phase."""
        reduced = temperature / self.temperature
        if reduced >= 1.0:
            return math.inf
        if self.part is not None:
            exponent = sum(factor * (1.0 - reduced) ** power for power, factor in WAGNER) / reduced
            return self.part * self.pressure * math.exp(exponent)
        logarithm, sixth = math.log(reduced), reduced**6
        simple = 5.92714 - 6.09648 / reduced - 1.28862 * logarithm + 0.169347 * sixth
        acentric = 15.2518 - 15.6875 / reduced - 13.4721 * logarithm + 0.43577 * sixth
        return self.pressure * math.exp(simple + self.acentric * acentric)

    def boiling_temperature(self, pressure: float) -> float | None:
        """K; None where the pressure is beyond the critical one, or below those of a liquid."""
        low, high = COLDEST_PART * self.temperature, self.temperature * (1.0 - 1e-9)
        if not self.saturation_pressure(low) < pressure < self.saturation_pressure(high):
            return None
        return float(brentq(lambda one: math.log(self.saturation_pressure(one) / pressure), low, high))


PHASES = {
    **dict.fromkeys(("air", "thesis_air"), Phase(132.5, 3.79e6, 0.035)),
    "nitrogen": Phase(126.2, 3.39e6, 0.037),
    "argon": Phase(150.9, 4.90e6, -0.002),
    "helium": Phase(10.47, 0.676e6, 0.0),  # effective constants of a quantum gas (Prausnitz)
    "carbon_dioxide": Phase(304.1, 7.37e6, 0.225),
    "steam": Phase(647.096, 22.064e6, 0.344, part=1.0),
    "water": Phase(647.096, 22.064e6, 0.344, liquid=True, part=1.0),
    "therminol_vp1": Phase(
        772.0, 3.31e6, 0.42, liquid=True
    ),  # critical point of the supplier; boils at 257 °C at 1 bar
    "water_glycol": Phase(647.096, 22.064e6, 0.344, liquid=True, part=0.775),
}
"""By the names of the library; the glycol's is a mixture of equal masses, of which 0.775 of the molecules are water."""

FREEZING = {"water": 273.15, "therminol_vp1": 285.15, "solar_salt": 493.15}
"""K: of Therminol VP-1 by its data sheet, of the salt by Zavoico (SAND2001-2100): its first crystals form at 238 °C."""


def other_phase(name: str, pressure: float, temperature: float) -> str | None:
    """Words that tell that the fluid of this name has another phase at a pressure (Pa) and temperature (K); None where not."""
    freezes = FREEZING.get(name, 0.0)
    if temperature < freezes:
        return f"{name} freezes at {freezes - 273.15:.0f} °C, and {temperature - 273.15:.1f} °C is below that"
    phase = PHASES.get(name)
    if phase is not None and phase.liquid and temperature > phase.temperature:
        return f"{name} is no liquid above {phase.temperature - 273.15:.1f} °C, and {temperature - 273.15:.1f} °C is"
    boils = None if phase is None else phase.boiling_temperature(pressure)
    if phase is None or boils is None or (temperature < boils) is phase.liquid:
        return None
    verb = "boils" if phase.liquid else "condenses"
    boiling, given = (value - 273.15 for value in (boils, temperature))
    return f"{name} {verb} at {boiling:.1f} °C and {pressure / 1e5:.4g} bar, and {given:.1f} °C is beyond that"


def departure(name: str, pressure: float, temperature: float) -> float:
    """Part by which the density of the ideal gas of this name is too large, negative where too small; 0 of liquids and unknown
    ones."""
    phase = PHASES.get(name)
    return 0.0 if phase is None or phase.liquid else phase.compressibility_factor(pressure, temperature) - 1.0
