"""Boundary conditions at inlet, outlet and outer wall: UFL constants, updated in time from the series of a scene."""

from collections.abc import Callable
from itertools import pairwise

import ufl
from dolfinx import fem

from ..equations.wall import OuterWall
from ..laws.functions import Value
from ..mesh.aliases import Constant
from ..mesh.domain import Domain
from ..scene.series import ProfileSeries, TimeSeries
from ..solvers.protocols import Drive
from .specs import FlowSpec, HeatSpec

PENALTY_COEFFICIENT = 1e6
"""Heat transfer coefficient (W/m2/K) that holds a wall at a fixed temperature: within 0.01 K at 10 kW/m2."""


class BoundaryValues:
    """Those of a scene over a domain whose inlet has an area of `inlet_area` (m2), with the values of a time.

    `inlet_temperature` (K) is that of the heat flowing in.
    """

    def __init__(self, flow: FlowSpec, heat: HeatSpec, domain: Domain, inlet_area: float) -> None:
        self._flow, self._heat, self._domain, self._inlet_area = flow, heat, domain, inlet_area
        at_start = heat.inlet_temperature(0.0)
        self.inlet_temperature, self._drive, self._drive_temperature = map(domain.constant, (at_start, 0.0, at_start))
        self._time_setters: list[Callable[[float], None]] = []
        self._outer: list[tuple[Constant, TimeSeries]] = []
        self._drive.value = flow.driven_by(0.0)
        self.set(0.0)

    def set(self, time: float) -> None:
        """Update the boundary values of flow and energy to a time (s)."""
        if self._heat.air_loop is None:
            self._drive_temperature.value = self._heat.inlet_temperature(time)
        else:
            self._drive_temperature.value = self.inlet_temperature.value
        if not self._flow.by_blower:
            self._drive.value = self._flow.driven_by(time)
        self.set_heat(time)

    @property
    def pressure_drop(self) -> float:
        """Of a flow that is driven by one, Pa; a blower's is set."""
        return float(self._drive.value)

    @pressure_drop.setter
    def pressure_drop(self, value: float) -> None:
        self._drive.value = value

    def set_point(self, time: float) -> float:
        """Inlet temperature (K) that is aimed at."""
        return float(self._heat.inlet_temperature(time))

    def set_heat(self, time: float) -> None:
        """Update the boundary values of the energy equations only: the flow is held during a step."""
        if self._heat.air_loop is None:
            self.inlet_temperature.value = self._heat.inlet_temperature(time)
        for constant, series in self._outer:
            constant.value = series(time)
        for set_time in self._time_setters:
            set_time(time)

    def call_with_time(self, set_time: Callable[[float], None]) -> None:
        """Have `set_time(time)` called with every time that the heat's values are set for."""
        self._time_setters.append(set_time)

    def drive(self) -> dict[str, Value]:
        """What drives the flow, as terms of the `Opening` at the inlet."""
        if self._flow.drive == "pressure_drop":
            return {"pressure": self._drive, "mean_square": self._domain.constant(0.0)}
        if self._flow.drive == "mass_flow":
            return {"mass_flux": self._drive / self._domain.constant(self._inlet_area)}
        return {"velocity": self._drive, "temperature": self._drive_temperature}

    def present_drive(self) -> Drive:
        """What drives the flow, and its present numbers."""
        return Drive(self._flow.drive, float(self._drive.value), float(self._drive_temperature.value))

    def outer_wall(self, ds: ufl.Measure) -> OuterWall | None:
        """The `OuterWall` on the facets of a measure, None where the scene gives it no heat."""
        if self._heat.is_wall_held:
            ambient = self.following(self._heat.wall.temperature)
            return OuterWall(ds, coefficient=self._domain.constant(PENALTY_COEFFICIENT), ambient=ambient)
        given = self._heat.outer_wall
        if given.heat_flux is None and not given.exchanges:
            return None
        terms = {}
        if given.heat_flux is not None:
            flux = self.following(given.heat_flux)
            if isinstance(given.heat_flux, ProfileSeries):
                sensors = fem.Constant(self._domain.mesh, given.heat_flux.positions)
                place = ufl.SpatialCoordinate(self._domain.mesh)[0] - self._domain.constant(self._domain.begin)
                flux = _between(sensors, flux, place)
            terms["heat_flux"] = flux * self._domain.constant(given.heat_flux_factor)
        if given.exchanges:
            terms["ambient"] = self.following(given.ambient)
        for name in ("coefficient", "emissivity"):
            if (value := getattr(given, name)) is not None:
                terms[name] = self._domain.constant(value)
        return OuterWall(ds, **terms)

    def following(self, series: TimeSeries | None) -> Constant:
        """Constant with the values that the series has at the time."""
        assert series is not None
        constant = fem.Constant(self._domain.mesh, series(0.0))
        self._outer.append((constant, series))
        return constant


def _between(positions: Value, values: Value, place: Value) -> Value:
    """UFL expression of `place` that is linear between values at positions and constant beyond them."""
    result = values[0]
    for number, (first, last) in enumerate(pairwise(positions)):
        part = ufl.min_value(ufl.max_value((place - first) / (last - first), 0.0), 1.0)
        result += part * (values[number + 1] - values[number])
    return result
