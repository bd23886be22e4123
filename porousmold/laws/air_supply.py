r"""Air supply of a tool: a blower with its curve, ducts, a heater, and recirculation of a part of the outlet air.

    blower at the suction's density:  Delta p_bed = (rho/rho_0)[p_0(V) - c V^2],   V = m/rho
    mixing before the heater:         m h_mix = r [m h_out - Q_duct] + (1 - r) m h_fresh + P_blower
    heater:                           m h(T_in) = m h_mix + P_heater,   0 <= P_heater <= P_max,   at most to the set-point
    blower's power:                   m w(p_1, T_1, p_b)/eta

p_0(V) is the pressure rise at the density rho_0 of the curve (fan laws: it scales with the density at the same volume flow), c
the resistance of ducts and filters, r the part returned. A gas is compressed by p_b from the suction's p_1 and T_1 with the
isentropic work w of `compression` (V p_b where p_b << p_1) and the efficiency eta. All of the blower's power ends as heat in the
air. The return duct loses Q_duct = r m [h(T_out) - h(T_a + (T_out - T_a) exp(-U A/(r m C)))] to the surroundings at T_a, which is
the fresh air's temperature.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from .compression import isentropic_work
from .materials import Fluid


@dataclass(frozen=True)
class Blower:
    """A curve of volume flows (m3/s, from 0) and pressure rises (Pa), straight lines between, at a `density` (kg/m3), and a
    `duct_resistance` (Pa s2/m6) of ducts and filters at that density; `efficiency` of motor and fan."""

    volume_flows: tuple[float, ...]
    pressure_rises: tuple[float, ...]
    density: float
    duct_resistance: float
    efficiency: float

    def pressure_rise(self, volume_flow: float, density: float) -> float:
        """What the blower gives (Pa); beyond the curve's end its last line goes on."""
        flows, rises = self.volume_flows, self.pressure_rises
        if volume_flow <= flows[-1]:
            rise = float(np.interp(volume_flow, flows, rises))
        else:
            rise = rises[-1] + (rises[-1] - rises[-2]) / (flows[-1] - flows[-2]) * (volume_flow - flows[-1])
        return rise * density / self.density

    def left_for_bed(self, volume_flow: float, density: float) -> float:
        """What the ducts leave of it (Pa)."""
        lost = self.duct_resistance * volume_flow * abs(volume_flow) * density / self.density
        return self.pressure_rise(volume_flow, density) - lost

    def power(self, fluid: Fluid, volume_flow: float, pressure: float, temperature: float) -> float:
        """Electrical power (W) for a fluid that is drawn at an absolute pressure (Pa) and a temperature (K)."""
        density = float(fluid.density(pressure, temperature))
        rise = max(self.pressure_rise(volume_flow, density), 0.0)
        return float(isentropic_work(fluid, pressure, temperature, rise) * density * volume_flow / self.efficiency)


@dataclass(frozen=True)
class Supplied:
    """What the supply does at a moment: `temperature` (K) of the air that enters the bed, and powers (W)."""

    temperature: float
    heater: float
    exhaust: float
    duct_loss: float


@dataclass(frozen=True)
class AirSupply:
    """Heater and return of a tool: the heater's limit `heater_power` (W), `fresh_temperature` (K), and the duct's U A
    `duct_conductance` (W/K)."""

    heater_power: float
    fresh_temperature: float
    duct_conductance: float

    def supplied(
        self,
        fluid: Fluid,
        mass_flow: float,
        outlet_enthalpy: float,
        set_point: float,
        returned: float,
        blower_power: float,
    ) -> Supplied:
        """For a mass flow (kg/s) that leaves with an enthalpy flow (W), of which a part is `returned`, and a set-point (K)."""
        if mass_flow <= 0.0:
            return Supplied(set_point, 0.0, 0.0, 0.0)
        drawn, lost, fresh = self._drawn(fluid, mass_flow, outlet_enthalpy, returned)
        mixed, wanted = drawn + blower_power, mass_flow * fluid.heat_capacity.integral(set_point)
        heater = min(max(wanted - mixed, 0.0), self.heater_power)
        reached = 0.0 <= wanted - mixed <= self.heater_power
        temperature = set_point if reached else temperature_of(fluid, (mixed + heater) / mass_flow, set_point)
        return Supplied(float(temperature), heater, (1.0 - returned) * (outlet_enthalpy - fresh), lost)

    def suction_temperature(self, fluid: Fluid, mass_flow: float, outlet_enthalpy: float, returned: float) -> float:
        """Of the air that the blower draws (K), mixed of what returns and fresh air."""
        if mass_flow <= 0.0:
            return self.fresh_temperature
        drawn, _, _ = self._drawn(fluid, mass_flow, outlet_enthalpy, returned)
        return temperature_of(fluid, drawn / mass_flow, self.fresh_temperature)

    def _drawn(self, fluid: Fluid, mass_flow: float, outlet_enthalpy: float, returned: float) -> tuple[float, ...]:
        """Enthalpy flow of what the blower draws, loss of the duct, and enthalpy flow if all were fresh air (W)."""
        fresh = mass_flow * fluid.heat_capacity.integral(self.fresh_temperature)
        lost = self._duct_loss(fluid, returned * mass_flow, outlet_enthalpy / mass_flow)
        return returned * outlet_enthalpy - lost + (1.0 - returned) * fresh, lost, fresh

    def _duct_loss(self, fluid: Fluid, returned_flow: float, outlet_enthalpy: float) -> float:
        if returned_flow <= 0.0 or self.duct_conductance == 0.0:
            return 0.0
        outlet = temperature_of(fluid, outlet_enthalpy, self.fresh_temperature)
        kept = math.exp(-self.duct_conductance / (returned_flow * fluid.heat_capacity(outlet)))
        after = self.fresh_temperature + (outlet - self.fresh_temperature) * kept
        return float(returned_flow * (outlet_enthalpy - fluid.heat_capacity.integral(after)))


def temperature_of(fluid: Fluid, enthalpy: float, guess: float) -> float:
    """Temperature (K) of an enthalpy per mass (J/kg), by Newton's method."""
    temperature: Any = guess
    for _ in range(50):
        update = (enthalpy - fluid.heat_capacity.integral(temperature)) / fluid.heat_capacity(temperature)
        temperature += update
        if abs(update) < 1e-11 * abs(temperature):
            break
    return float(temperature)
