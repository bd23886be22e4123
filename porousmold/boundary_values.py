"""What a scene gives at its openings and outer wall, as constants of the equations that follow it in time."""

from itertools import pairwise

import ufl
from dolfinx import fem

from .equations.energy import OuterWall
from .errors import InputError
from .series import ProfileSeries

HOLDING_COEFFICIENT = 1e6
"""Heat transfer coefficient (W/m2/K) that holds a wall at a fixed temperature: within 0.01 K at 10 kW/m2."""


class BoundaryValues:
    """Those of a scene over a domain whose inlet has an area of `inlet_area` (m2), with the values of a time.

    `inlet_temperature` (K) is that of the heat flowing in.
    """

    def __init__(self, scene, domain, inlet_area):
        self._scene, self._domain, self._inlet_area = scene, domain, inlet_area
        at_start = scene.operation.inlet_temperature(0.0)
        self.inlet_temperature, self._drive, self._drive_temperature = map(
            self._domain.constant, (at_start, 0.0, at_start)
        )
        self._outer: list = []
        self.set(0.0)

    def set(self, time):
        """Give flow and heat their values at a time (s)."""
        operation = self._scene.operation
        self._drive_temperature.value = operation.inlet_temperature(time)
        drive = operation.pressure_drop or operation.inlet_velocity or operation.mass_flow
        self._drive.value = drive(time)
        self.set_heat(time)

    def set_heat(self, time):
        """Give the heat alone its values: what flows in during a step is what the flow was solved for."""
        self.inlet_temperature.value = self._scene.operation.inlet_temperature(time)
        for constant, series in self._outer:
            constant.value = series(time)

    def drive(self):
        """What drives the flow, as terms of the `Opening` at the inlet."""
        operation = self._scene.operation
        if operation.pressure_drop is not None:
            return {"pressure": self._drive, "mean_square": self._domain.constant(0.0)}
        if operation.mass_flow is not None:
            return {"mass_flux": self._drive / self._domain.constant(self._inlet_area)}
        return {"velocity": self._drive, "temperature": self._drive_temperature}

    def drive_of_stations(self):
        """The same as `solvers.developed` takes it: its kind and its present numbers (SI)."""
        operation, value = self._scene.operation, float(self._drive.value)
        if operation.pressure_drop is not None:
            return "pressure_drop", value
        if operation.mass_flow is not None:
            return "mass_flow", value
        return "velocity", value, float(self._drive_temperature.value)

    def make_outer_wall(self, ds):
        """The `OuterWall` on the facets of a measure, None where the scene gives it no heat.

        Raises `InputError` where the mesh has no outer wall.
        """
        operation = self._scene.operation
        flux, coefficient = operation.outer_heat_flux, operation.outer_coefficient
        if self._scene.model.wall == "fixed-temperature":
            held = self._following(operation.wall_temperature)
            return OuterWall(ds, coefficient=self._domain.constant(HOLDING_COEFFICIENT), ambient=held)
        if flux is None and coefficient is None:
            return None
        if not self._domain.has_outer_wall and self._scene.model.wall != "thin":
            raise InputError(
                "geometry.mesh",
                str(self._scene.geometry.mesh),
                "needs a physical curve 'outer' for the outer wall's heat",
            )
        terms = {}
        if flux is not None:
            given = self._following(flux)
            if isinstance(flux, ProfileSeries):
                sensors = fem.Constant(self._domain.mesh, flux.positions)
                given = _between(sensors, given, ufl.SpatialCoordinate(self._domain.mesh)[0])
            terms["heat_flux"] = given * self._domain.constant(operation.outer_heat_flux_factor)
        if coefficient is not None:
            ambient = self._following(operation.ambient_temperature)
            terms |= {"coefficient": self._domain.constant(coefficient), "ambient": ambient}
        return OuterWall(ds, **terms)

    def _following(self, series):
        """Constant with the values that the series has at the time."""
        constant = fem.Constant(self._domain.mesh, series(0.0))
        self._outer.append((constant, series))
        return constant


def _between(positions, values, place):
    """UFL expression of `place` that is linear between values at positions and constant beyond them."""
    result = values[0]
    for number, (first, last) in enumerate(pairwise(positions)):
        part = ufl.min_value(ufl.max_value((place - first) / (last - first), 0.0), 1.0)
        result += part * (values[number + 1] - values[number])
    return result
