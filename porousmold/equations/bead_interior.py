r"""Beads that are not isothermal, as the energy equations see them within an implicit step.

A stage of a time scheme solves every mode w_n of `laws.bead_interior` for (w_n - r_n)/theta = dw_n/dt with a known r_n and
a known time theta, thus with c = R^2/(alpha theta)

    w_n = [c r_n + 2 (R/lambda) q]/(c + mu_n^2).

So the surface is at T_s + W + Z q with

    lag W = sum c r_n/(c + mu_n^2),   resistance Z = R/lambda [sum 2/(c + mu_n^2) + rest]:

the flux is h/(1 + h Z) (T_f - T_s - W), and the modes are no unknowns of the equations to be solved.
"""

from dataclasses import dataclass

from ..laws.bead_interior import remaining_resistance
from ..laws.functions import Value
from ..laws.materials import Solid


@dataclass(frozen=True)
class BeadInterior:
    """Modes `eigenvalues` inside the `beads`; `lag` is W (K, a function), `inverse_time` 1/theta (1/s, a constant)."""

    eigenvalues: tuple[float, ...]
    beads: Solid
    bead_diameter: Value
    lag: Value
    inverse_time: Value

    def step_ratio(self, temperature: Value) -> Value:
        """c = R^2/(alpha theta) at the temperature (K) of the properties."""
        beads = self.beads
        diffusivity = beads.conductivity(temperature) / (beads.density(temperature) * beads.heat_capacity(temperature))
        return (0.5 * self.bead_diameter) ** 2 / diffusivity * self.inverse_time

    def unit_resistance(self, temperature: Value) -> Value:
        """R/lambda, m2 K/W."""
        return 0.5 * self.bead_diameter / self.beads.conductivity(temperature)

    def resistance(self, temperature: Value) -> Value:
        """Z, m2 K/W."""
        ratio = self.step_ratio(temperature)
        kept = sum(2.0 / (ratio + mu**2) for mu in self.eigenvalues)
        return self.unit_resistance(temperature) * (kept + remaining_resistance(self.eigenvalues))
