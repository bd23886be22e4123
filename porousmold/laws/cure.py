r"""Cure of a thermosetting resin, an exothermic reaction of its degree of cure alpha from 0 to 1.

    d alpha/dt = (k_1 + k_2 alpha^m)(1 - alpha)^n,   k_i = A_i exp(-E_i/(R T)),   heat released: rho H d alpha/dt

(Kamal, Sourour, Polym. Eng. Sci. 13 (1973) 59-64). H is per mass of the laminate, not of its resin alone.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import Floats

GAS_CONSTANT = 8.31446261815324
"""J/(mol K)."""
MOST_ITERATIONS, CLOSENESS, LEAST = 60, 1e-12, 1e-12


@dataclass(frozen=True)
class Cure:
    """Rate constants A (1/s) and activation energies E (J/mol), orders m and n, `heat` H (J/kg), `initial` degree of cure.

    With A_1 = 0 nothing begins at alpha = 0: `initial` must be positive then.
    """

    rate_1: float
    activation_energy_1: float
    rate_2: float
    activation_energy_2: float
    order_m: float
    order_n: float
    heat: float
    initial: float

    def constants(self, temperature: Floats) -> tuple[Floats, Floats]:
        """k_1 and k_2 (1/s) at temperatures (K)."""
        kelvins = GAS_CONSTANT * temperature
        return (
            self.rate_1 * np.exp(-self.activation_energy_1 / kelvins),
            self.rate_2 * np.exp(-self.activation_energy_2 / kelvins),
        )

    def rate(self, degree: Floats, temperature: Floats) -> Floats:
        """d alpha/dt (1/s) at degrees of cure and temperatures (K)."""
        first, second = self.constants(temperature)
        return (first + second * degree**self.order_m) * (1.0 - degree) ** self.order_n

    def growth(self, degree: Floats, temperature: Floats) -> Floats:
        """How fast a difference of two degrees of cure grows (1/s): the derivative of the rate with respect to alpha."""
        return self._rate_and_growth(np.clip(degree, LEAST, 1.0 - LEAST), *self.constants(temperature))[1]

    def _rate_and_growth(self, degree: Floats, first: Floats, second: Floats) -> tuple[Floats, Floats]:
        """d alpha/dt and its derivative at degrees between 0 and 1, with the rate constants (1/s)."""
        power, rest = degree**self.order_m, (1.0 - degree) ** self.order_n
        rate = (first + second * power) * rest
        return rate, second * self.order_m * power / degree * rest - self.order_n * rate / (1.0 - degree)

    def after(self, known: Floats, theta: float, temperature: Floats, guess: Floats | None = None) -> Floats:
        """The alpha from `known` to 1 of (alpha - known)/theta = rate(alpha, T): a stage of a time scheme, theta in s.

        By Newton's method from a guess, with bisection where that leaves what encloses the root. What a stage's weights bring
        beyond 0 or 1 is brought back.
        """
        constants = self.constants(temperature)
        known = np.clip(known, 0.0, 1.0)
        low, high = known.copy(), np.ones_like(known)
        degree = 0.5 * (low + high) if guess is None else np.clip(guess, low, high)
        for _ in range(MOST_ITERATIONS):
            inside = np.clip(degree, LEAST, 1.0 - LEAST)
            rate, slope = self._rate_and_growth(inside, *constants)
            excess = degree - known - theta * rate
            low, high = np.where(excess < 0.0, degree, low), np.where(excess < 0.0, high, degree)
            with np.errstate(divide="ignore", invalid="ignore"):
                found = degree - excess / (1.0 - theta * slope)
            found = np.where((low <= found) & (found <= high), found, 0.5 * (low + high))
            update, degree = np.max(np.abs(found - degree), initial=0.0), found
            if update < CLOSENESS:
                break
        return degree
