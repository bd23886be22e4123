"""Developed profiles against the pressure gradient: what `equations.locally_developed` takes them from.

They are those of one plane bed whose stations have each their own dp/dx, all solved at once, in units of nu/d: functions of the
wall distance and of ln G, interpolated by cubic splines in ln G after division by a power of G, and linearly across the bed.
"""

import numpy as np

from ..arrays import Floats
from ..mesh import fenicsx
from .developed import DevelopedFlow
from .newton import Beside

STATIONS = 29
"""Of the table, along ln G."""
REACH = 100.0
"""Factor of G above and below its middle that the table reaches; with 30, at the edges of ports, 0.4 % of the flow too much."""
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
        from scipy.interpolate import RectBivariateSpline  # takes a while to import, and most runs have no table

        if abs(logarithm - self.middle) < 0.5 * np.log(REACH):
            return
        logarithms = logarithm + np.log(REACH) * np.linspace(-1.0, 1.0, STATIONS)
        # the flow's own stations are along dp/dx
        self._flow.given = np.exp(logarithms) * self._viscosity**2 / (self._density * self._diameter**3)
        self._flow.start()
        self.middle = logarithm
        distances, tables = self._tables()
        self._splines = []
        for number, table in enumerate(tables):
            scaled = table / np.exp(self._power(number) * (logarithms - logarithm))[:, None]
            self._splines.append(RectBivariateSpline(logarithms, distances, scaled, kx=3, ky=1))
        self._ends = logarithms[0], logarithms[-1], distances[-1]

    def at(self, distance: Floats, logarithm: Floats) -> list[tuple[Floats, Floats]]:
        """Values f and slopes d ln f/d ln G of every field at wall distances (m) and values of ln G: the scaled speed u d/nu,
        and the turbulence's unknowns in their units."""
        low, high, farthest = self._ends
        place, inside = np.minimum(distance, farthest), np.clip(logarithm, low, high)
        found = []
        for number, spline in enumerate(self._splines):
            power = self._power(number)
            scaled, change = spline.ev(inside, place), spline.ev(inside, place, dx=1)
            slope = power + change / np.where(np.abs(scaled) > 0.0, scaled, 1.0)
            slope = np.clip(slope, np.where(inside == logarithm, -STEEPEST, 0.0), STEEPEST)
            value = scaled * np.exp(power * (inside - self.middle) + slope * (logarithm - inside))
            found.append((value, slope))
        return found

    @staticmethod
    def _power(number: int) -> float:
        return POWERS[number] if number < len(POWERS) else 1.0

    def _tables(self) -> tuple[Floats, list[Floats]]:
        """Wall distances (m), and of every field a row for each station."""
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
        return self._half_height - across[::-1], tables

    def largest_undershoot(self) -> float:
        """Largest part of the largest k by which k is below 0 in the table."""
        return self._flow.counts.largest_undershoot

    def is_also_laminar(self) -> bool:
        """Whether its profiles have a laminar solution beside the turbulent one."""
        return self._flow.is_also_laminar()
