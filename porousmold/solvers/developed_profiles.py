"""Developed profiles against the pressure gradient: what `equations.locally_developed` takes them from.

They are those of one plane bed whose stations have each their own dp/dx, all solved at once, in units of nu/d: functions of the
wall distance and of ln G, interpolated by monotone cubics in ln G after division by a power of G, and linearly across the bed.
More stations are inserted where these miss the profiles: where turbulence begins, they change at once.
"""

from typing import Any

import numpy as np

from ..arrays import Floats
from ..mesh import fenicsx
from .developed import DevelopedFlow
from .newton import Beside
from .parts import LEAST_VALUE

STATIONS = 29
"""Of the table, along ln G."""
REACH = 100.0
"""Factor of G above and below its middle that the table reaches; with 30, at the edges of ports, 0.4 % of the flow too much."""
HALF_MISSES = 0.01, 0.05
"""Part of a profile's largest value, the speed's and that of the turbulence's unknowns, that every other station may miss at the
one between, before more are inserted there: where turbulence begins, k grows by a factor of 30 within 0.2 of ln G."""
MOST_INSERTIONS = 2
"""Times that stations are inserted: where turbulence begins k then changes by less than 2 % of its largest value with where the
stations lie."""
POWERS = (0.6, 1.2, 1.8)
"""Of G, about which the scaled speed, k and epsilon go: profiles are divided by them before they are interpolated. The powers of
other unknowns are 1."""
STEEPEST = 4.0
"""Slope d ln f/d ln G at most, where a profile passes through zero; beyond the table it is that at its end, and not below 0."""


class ProfilesOfGradient(DevelopedFlow):
    """Developed profiles at stations of given dp/dx (Pa/m, `given`, positive where the pressure falls), each by itself."""

    given: Floats = np.ones(STATIONS)

    def initial_guess(self) -> bool:
        self._along.set_gradients(-self.given)
        self.pressure.x.array[:] = 0.0
        self._guess(-self._along.gradient.x.array)
        return self.equations.model is None or self.equations.model.starts_near()

    def _beside(self) -> Beside:
        return Beside()

    def found(self) -> None:
        """There is no one mass flow to be carried."""


class ProfileTable:
    """The profiles, solved anew about another ln G when `cover` is asked for one.

    `flow` is over a plane bed of `half_height` (m) with `STATIONS` stations, at a uniform temperature (K) of its fluid, whose
    `density` (kg/m3) and `viscosity` (Pa s) these are; `bead_diameter` in m.
    """

    def __init__(
        self, flow: ProfilesOfGradient, half_height: float, bead_diameter: float, density: float, viscosity: float
    ) -> None:
        self._flow, self._half_height = flow, half_height
        self._diameter, self._density, self._viscosity = bead_diameter, density, viscosity
        self.middle = np.nan
        """ln G in the middle of the table."""

    def cover(self, logarithm: float) -> None:
        """Have the middle of the table near a value of ln G. Raises `SolveError` where the profiles are not found."""
        if abs(logarithm - self.middle) < 0.5 * np.log(REACH):
            return
        logarithms = logarithm + np.log(REACH) * np.linspace(-1.0, 1.0, STATIONS)
        rows = self._rows_at(logarithms)
        self.middle, of_reach = logarithm, self._flow.solution.arrays()
        for _ in range(MOST_INSERTIONS):
            scaled = [self._scaled(number, logarithms, field) for number, field in enumerate(rows)]
            more = between_stations(logarithms, missed_by_half(logarithms, scaled))
            if not len(more):
                break
            rows = [np.concatenate(pair) for pair in zip(rows, self._rows_at(more), strict=True)]
            order = np.argsort(logarithms := np.concatenate([logarithms, more]))
            logarithms, rows = logarithms[order], [field[order] for field in rows]
        self._flow.solution.set(of_reach)  # from which `is_also_laminar` begins
        self._curves = [
            _monotone(logarithms, self._scaled(number, logarithms, field)) for number, field in enumerate(rows)
        ]

    @property
    def reach(self) -> tuple[float, float]:
        """Lowest and highest ln G of its stations."""
        return self._curves[0].x[0], self._curves[0].x[-1]

    def at(self, distance: Floats, logarithm: Floats) -> list[tuple[Floats, Floats]]:
        """Values f and slopes d ln f/d ln G of every field at wall distances (m) and values of ln G: the scaled speed u d/nu,
        and the turbulence's unknowns in their units."""
        stations = self._curves[0].x
        inside = np.clip(logarithm, *self.reach)
        interval = np.clip(np.searchsorted(stations, inside, side="right") - 1, 0, len(stations) - 2)
        along = inside - stations[interval]
        level = np.clip(np.searchsorted(self._distances, distance, side="right") - 1, 0, len(self._distances) - 2)
        near, far = self._distances[level], self._distances[level + 1]
        part = np.minimum((distance - near) / (far - near), 1.0)
        found = []
        for number, curve in enumerate(self._curves):
            power = self._power(number)
            a, b, c, f = (1.0 - part) * curve.c[:, interval, level] + part * curve.c[:, interval, level + 1]
            scaled, change = ((a * along + b) * along + c) * along + f, (3.0 * a * along + 2.0 * b) * along + c
            slope = power + change / np.where(np.abs(scaled) > 0.0, scaled, 1.0)
            slope = np.clip(slope, np.where(inside == logarithm, -STEEPEST, 0.0), STEEPEST)
            value = scaled * np.exp(power * (inside - self.middle) + slope * (logarithm - inside))
            found.append((value, slope))
        return found

    def _scaled(self, number: int, logarithms: Floats, rows: Floats) -> Floats:
        return rows / np.exp(self._power(number) * (logarithms - self.middle))[:, None]

    @staticmethod
    def _power(number: int) -> float:
        return POWERS[number] if number < len(POWERS) else 1.0

    def _rows_at(self, logarithms: Floats) -> list[Floats]:
        """Of every field a row for each of `STATIONS` values of ln G, at the wall distances `_distances` (m)."""
        # the flow's own stations are along dp/dx
        self._flow.given = np.exp(logarithms) * self._viscosity**2 / (self._density * self._diameter**3)
        self._flow.start()
        flow, nu = self._flow, self._viscosity / self._density
        model = flow.equations.model
        sizes = [nu / self._diameter]
        if model is not None:
            sizes += [float(size) for size in model.magnitudes(nu / self._diameter, self._diameter)]
        points = flow.pressure.function_space.tabulate_dof_coordinates()
        across = np.unique(np.round(points[:, 1], 12))
        across = across[across <= self._half_height * (1.0 + 1e-9)]
        fields = flow.fields()
        velocity = fields.pop("velocity")
        fields.pop("pressure")
        tables = []
        for values, space, size in zip(
            [velocity.x.array[0::2], *(function.x.array for function in fields.values())],
            [fenicsx.lagrange_space(flow.domain.mesh), *(function.function_space for function in fields.values())],
            sizes,
            strict=True,
        ):
            points = space.tabulate_dof_coordinates()
            station = np.rint(points[:, 0] * (STATIONS - 1)).astype(int)
            level = np.abs(points[:, 1][:, None] - across[None, :]).argmin(axis=1)
            table = np.zeros((STATIONS, len(across)))
            table[station, level] = values / size
            tables.append(table[:, ::-1])
        self._distances = self._half_height - across[::-1]
        return tables

    def largest_undershoot(self) -> float:
        """Largest part of the largest k by which k is below 0 in the table."""
        return self._flow.counts.largest_undershoot

    def is_also_laminar(self) -> bool:
        """Whether its profiles have a laminar solution beside the turbulent one."""
        return self._flow.is_also_laminar()


def _monotone(stations: Floats, rows: Floats) -> Any:
    from scipy.interpolate import PchipInterpolator  # takes a while to import, and most runs have no table

    return PchipInterpolator(stations, rows)


def missed_by_half(stations: Floats, fields: list[Floats]) -> Floats:
    """By how much, over what `HALF_MISSES` allows, a row of any field at a station is missed by monotone cubics through every
    other station; 0 at the ends."""
    missed = np.zeros(len(stations))
    for first in (0, 1):
        kept, between = slice(first, None, 2), np.arange(first + 1, len(stations) - 1, 2)
        for number, rows in enumerate(fields):
            guessed = _monotone(stations[kept], rows[kept])(stations[between])
            largest = np.maximum(np.abs(rows[between]).max(axis=1), np.abs(rows).max() * LEAST_VALUE)
            part = np.abs(guessed - rows[between]).max(axis=1) / largest
            missed[between] = np.maximum(missed[between], part / HALF_MISSES[min(number, 1)])
    return missed


def between_stations(stations: Floats, missed: Floats) -> Floats:
    """`STATIONS` more, spread over the intervals beside stations of which more is missed than allowed; none if there are no such
    stations."""
    of_intervals = np.maximum(missed[1:], missed[:-1])
    worst = np.argsort(-of_intervals, kind="stable")[:STATIONS]
    worst = worst[of_intervals[worst] > 1.0]
    if not len(worst):
        return np.zeros(0)
    counts = STATIONS // len(worst) + (np.arange(len(worst)) < STATIONS % len(worst))
    parts = [np.linspace(stations[i], stations[i + 1], n + 2)[1:-1] for i, n in zip(worst, counts, strict=True)]
    return np.concatenate(parts)
