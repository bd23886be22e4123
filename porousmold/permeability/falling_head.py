r"""The falling-head test: a liquid drains through the bed, and the fall of its level tells the permeability.

With z upwards, h the level above the top of the bed, v = dh/dt < 0 the superficial velocity and Q = -v S the flow rate,
Darcy's law with gravity (thesis eq. 4.9) and the pressures at the bed's top, rho g h, and bottom, P_D, give

    v = -(k/mu) [(rho g h - P_D)/L + rho g],        P_D = c0 Q + c1  (eq. 4.8),

all pressures against the atmosphere's. What the set-up takes below the bed, P_D, is known from a run without beads; c1 < 0
because the outlet lies below the bed and sucks. Solved for k at every moment that is the **instantaneous** method (eq. 4.11)

    k = -v mu L/[rho g (h + L) - c0 Q - c1].

For the **global** method, Q = -v S makes the first equation dh/dt = -rate (h + H) with

    H = L - c1/(rho g),        rate = rho g/(mu L/k + c0 S),

so that ln[(h + H)/(h_0 + H)] = -rate t, which is eq. 4.13 as printed: print and derivation agree. Without beads mu L/k = 0, and
the same exponential gives c0 from its rate and c1 from where it tends to: so the **baseline** is fitted.

| approach | c0, c1 | gravity in the bed | equations |
|---|---|---|---|
| complete | known | yes | 4.11, 4.13 |
| neither | 0 | no | 4.14, 4.15 |
| gravity | 0 | yes | 4.16, 4.17 |

Eq. 4.16 prints the set-up's pressure as neglected, so Q does not enter there either.
"""

import warnings
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import OptimizeWarning, curve_fit

from ..arrays import Floats

GRAVITY = 9.81
"""m/s2."""
DARCY_LIMIT = 1.0
"""Particle Reynolds number rho U d/mu up to which Darcy's law is taken to hold."""
FIRST_LEVEL = 3.0
"""Error of the first level over that of the others: a parabola through readings on one side only has sqrt(8) times the error."""
MOST_INTERVALS = 1_000_000
APPROACHES = ("complete", "neither", "gravity")


@dataclass(frozen=True)
class Setup:
    """A falling-head set-up and its liquid, SI: bed_length L (m), cross_section S (m2), initial_head h_0 (m), density (kg/m3),
    viscosity (Pa s), outlet_resistance c0 (Pa s/m3) and outlet_pressure c1 (Pa)."""

    bed_length: float
    cross_section: float
    initial_head: float
    density: float
    viscosity: float
    outlet_resistance: float = 0.0
    outlet_pressure: float = 0.0

    @property
    def specific_weight(self) -> float:
        """rho g, N/m3."""
        return self.density * GRAVITY

    def simplified(self, approach: str) -> tuple["Setup", float]:
        """(set-up without what the approach neglects, length whose weight drives the liquid through the bed)."""
        if approach == "complete":
            return self, self.bed_length
        bare = replace(self, outlet_resistance=0.0, outlet_pressure=0.0)
        return bare, self.bed_length if approach == "gravity" else 0.0

    def rate_and_offset(self, permeability: float, approach: str = "complete") -> tuple[float, float]:
        """(rate in 1/s, H in m) of the exponential fall (eq. 4.13, 4.15, 4.17) for a permeability in m2."""
        setup, weighing = self.simplified(approach)
        resistance = setup.viscosity * setup.bed_length / permeability + setup.outlet_resistance * setup.cross_section
        return setup.specific_weight / resistance, weighing - setup.outlet_pressure / setup.specific_weight

    def level(self, time: ArrayLike, permeability: float, approach: str = "complete") -> Floats:
        """h (m) at times (s)."""
        rate, offset = self.rate_and_offset(permeability, approach)
        return (self.initial_head + offset) * np.exp(-rate * np.asarray(time)) - offset

    def highest_reynolds_number(self, permeability: float, bead_diameter: float) -> float:
        """Particle Reynolds number rho U d/mu at the start of the fall, with beads of a diameter (m)."""
        rate, offset = self.rate_and_offset(permeability)
        return self.reynolds_number(rate * (self.initial_head + offset), bead_diameter)

    def reynolds_number(self, speed: float, bead_diameter: float) -> float:
        """Particle Reynolds number rho U d/mu at a superficial speed (m/s)."""
        return self.density * speed * bead_diameter / self.viscosity

    def duration(self, permeability: float) -> float:
        """Time (s) at which the level reaches the bed's top: the end of the test."""
        rate, offset = self.rate_and_offset(permeability)
        return float(np.log1p(self.initial_head / offset) / rate)

    def mass(self, time: ArrayLike, permeability: float) -> Floats:
        """Mass (kg) that has run out at times (s)."""
        return (self.initial_head - self.level(time, permeability)) * self.cross_section * self.density


@dataclass(frozen=True)
class Levels:
    """What a test gives, averaged: time (s) and level (m) at the ends of the intervals, flow_rate (m3/s) within them."""

    time: Floats
    level: Floats
    flow_rate: Floats


def levels_of(setup: Setup, time: Floats, mass: Floats, interval: float = 2.0) -> Levels:
    """`Levels` from time (s) and mass (kg) on the scale (eq. 4.4-4.6), over intervals of at least `interval` seconds.

    The mass at the end of an interval is that of the parabola through the readings within half an interval of it, which
    averages the scale's noise and leaves an exponential as it is. Readings below the bed's top do not count. Raises
    `ValueError` for fewer than three intervals.
    """
    time, mass = np.asarray(time, float), np.asarray(mass, float)
    interval = max(interval, float(np.median(np.diff(time))))
    if (time[-1] - time[0]) / interval > MOST_INTERVALS:
        raise ValueError(f"gives more than {MOST_INTERVALS} intervals of {interval:g} s")
    ends = np.arange(time[0], time[-1] + 1e-9 * interval, interval)
    smoothed = np.array([_mass_at(end, time, mass, 0.5 * interval) for end in ends])
    level = setup.initial_head - (smoothed - smoothed[0]) / (setup.density * setup.cross_section)
    above = int(np.argmax(level < 0.0)) if np.any(level < 0.0) else len(level)
    if above < 4:
        raise ValueError(
            f"gives {max(above - 1, 0)} intervals of {interval:g} s before the level reaches the bed's top, below 3"
        )
    ends, level = ends[:above], level[:above]
    return Levels(ends - ends[0], level, -np.diff(level) * setup.cross_section / np.diff(ends))


def _mass_at(moment: float, time: Floats, mass: Floats, reach: float) -> float:
    first, last = np.searchsorted(time, [moment - reach - 1e-9, moment + reach + 1e-9])
    if last - first < 4:
        return float(np.interp(moment, time, mass))
    return float(np.polyfit(time[first:last] - moment, mass[first:last], 2)[-1])


@dataclass(frozen=True)
class Estimate:
    """A permeability (m2) with its standard deviation and 95 % confidence interval; `determination` is R2 where fitted.

    The interval of a mean takes its values as independent; where the set-up takes most of the pressure and readings are noisy,
    the mean of the instantaneous values is biased beyond it.
    """

    permeability: float
    standard_deviation: float
    interval: tuple[float, float]
    determination: float | None = None


def instantaneous(setup: Setup, levels: Levels, approach: str = "complete") -> Floats:
    """k (m2) in every interval (eq. 4.11, 4.14, 4.16), at the mean level of an exponential fall within it."""
    simple, weighing = setup.simplified(approach)
    offset = setup.rate_and_offset(1.0, approach)[1]
    ends = np.maximum(levels.level + offset, 1e-12)
    ratio = np.log(ends[:-1] / ends[1:])
    steep = np.abs(ratio) > 1e-9
    level = np.where(steep, (ends[:-1] - ends[1:]) / np.where(steep, ratio, 1.0), ends[1:]) - offset
    driving = setup.specific_weight * (level + weighing)
    driving = driving - simple.outlet_resistance * levels.flow_rate - simple.outlet_pressure
    return levels.flow_rate / setup.cross_section * setup.viscosity * setup.bed_length / driving


def mean_of(values: Floats) -> Estimate:
    """`Estimate` of the mean of independent values, its interval by the normal distribution."""
    mean, deviation = float(np.mean(values)), float(np.std(values, ddof=1))
    half = 1.96 * deviation / np.sqrt(len(values))
    return Estimate(mean, deviation, (mean - half, mean + half))


def globally(setup: Setup, levels: Levels, approach: str = "complete") -> Estimate:
    """`Estimate` by the fit of the whole fall (eq. 4.13, 4.15, 4.17) to the levels: least squares in h, ln k unknown.

    Its deviation is that of the fit and that of the first level, from which all others are counted: `FIRST_LEVEL` times the
    residuals'. Raises `RuntimeError` where no permeability fits.
    """

    guess = float(np.median(instantaneous(setup, levels, approach)))
    start = np.log(guess) if guess > 0.0 else np.log(1e-9)

    def fitted(level: object) -> tuple[Any, ...]:
        """(ln k, its variance)"""
        with warnings.catch_warnings():
            warnings.simplefilter(
                "error", OptimizeWarning
            )  # no covariance: the level does not determine the permeability
            try:
                found, covariance = curve_fit(
                    lambda time, logarithm: setup.level(time, np.exp(logarithm), approach),
                    levels.time, level, p0=[start], xtol=1e-12, ftol=1e-12,
                )  # fmt: skip
            except OptimizeWarning as error:
                raise RuntimeError("no permeability fits the fall of the level") from error
        return float(found[0]), float(covariance[0, 0])

    logarithm, variance = fitted(levels.level)
    best = float(np.exp(logarithm))
    residual = levels.level - setup.level(levels.time, best, approach)
    shifted, _ = fitted(levels.level + FIRST_LEVEL * np.std(residual))
    error = float(np.hypot(np.sqrt(variance), shifted - logarithm))
    if error > np.log(1e3):
        raise RuntimeError("the fall of the level does not determine the permeability")
    spread = levels.level - levels.level.mean()
    return Estimate(
        best,
        best * error,
        (best * float(np.exp(-1.96 * error)), best * float(np.exp(1.96 * error))),
        1.0 - float(residual @ residual) / float(spread @ spread),
    )


def fit_baseline(setup: Setup, levels: Levels) -> tuple[float, float]:
    """(c0 in Pa s/m3, c1 in Pa) from a run without beads: rho g (h + L) = c0 Q + c1 all along its exponential fall.

    Raises `RuntimeError` where there is no such fall.
    """

    def fall(time: Floats, rate: float, offset: float) -> Floats:
        return (setup.initial_head + offset) * np.exp(-rate * time) - offset

    first, last = levels.level[0], levels.level[-1]
    guess = max((first - last) / levels.time[-1] / (first + setup.bed_length), 1e-9)
    with warnings.catch_warnings():
        warnings.simplefilter("error", OptimizeWarning)
        try:
            (rate, offset), _ = curve_fit(
                fall, levels.time, levels.level, p0=[guess, setup.bed_length], xtol=1e-12, ftol=1e-12
            )
        except OptimizeWarning as error:
            raise RuntimeError("the fall does not determine c0 and c1") from error
    if not (rate > 0.0 and offset > -levels.level[-1]):
        raise RuntimeError("the level does not fall towards an end below it")
    return setup.specific_weight / (rate * setup.cross_section), (setup.bed_length - offset) * setup.specific_weight


def reynolds_number(setup: Setup, levels: Levels, bead_diameter: float) -> float:
    """Largest particle Reynolds number rho U d/mu of the test with beads of `bead_diameter` (m)."""
    fastest = float(np.max(levels.flow_rate)) / setup.cross_section
    return setup.reynolds_number(fastest, bead_diameter)
