"""What drives the flow where no blower does, and gravity."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..keys import Key
from ..series import TimeSeries
from .air_loop import AirLoop
from .feature import Feature, key

if TYPE_CHECKING:
    from ..scene import Scene

DRIVES = ("pressure_drop", "inlet_velocity", "mass_flow")
MOST_OF_OUTLET_PRESSURE = 10.0
"""Times the outlet's pressure that a pressure drop may be."""


@dataclass(frozen=True, kw_only=True)
class Drive(Feature):
    """One of pressure drop (Pa), superficial velocity at the inlet (m/s) and mass flow (kg/s); gravity (m/s2) along the flow."""

    pressure_drop: TimeSeries | None = key(
        "operation.pressure_drop",
        "Pa",
        "static pressure, inlet minus outlet; negative in a series or phase: the flow reverses",
        low=-1e8,
        high=1e8,
        closed=True,
        series=True,
    )
    inlet_velocity: TimeSeries | None = key(
        "operation.inlet_velocity",
        "m/s",
        "superficial: volume flow over the empty cross-section; negative in a series or phase: the flow reverses",
        low=-1e3,
        high=1e3,
        series=True,
    )
    mass_flow: TimeSeries | None = key(
        "operation.mass_flow",
        "kg/s",
        "mass flow: whole pipe; half cavity (or whole, geometry.cavity) per metre of width; quarter of a cavity with a width; "
        "negative in a series or phase: the flow reverses",
        low=-1e6,
        high=1e6,
        series=True,
    )
    gravity: float = key(
        "operation.gravity",
        "m/s^2",
        "acceleration along the flow (negative: against it); a blower has the column of what it draws beside the bed",
        0.0,
        low=-1e3,
        high=1e3,
    )

    @property
    def chosen(self) -> list[str]:
        """Names of the drives that have a value."""
        return [name for name in DRIVES if getattr(self, name) is not None]

    def check(self, scene: "Scene") -> None:
        """One drive, unless a blower or phases drive the flow; its direction and size can be."""
        operation, chosen = scene.operation, self.chosen
        if operation.phase is not None:
            return
        if AirLoop.of(scene).has_blower:
            for name in chosen:
                scene.refuse(f"operation.{name}", "cannot be combined with a blower", value=None)
            return
        if len(chosen) != 1:
            given = " and ".join(f"operation.{name}" for name in chosen) or "operation.pressure_drop"
            names = ", ".join(f"operation.{name}" for name in DRIVES)
            scene.refuse(given, f"exactly one of {names} must be given", value=None)
        name, is_pressure = chosen[0], chosen[0] == "pressure_drop"
        drive: TimeSeries = getattr(self, name)
        if len(drive.values) == 1 and (drive.values[0] < 0.0 or (drive.values[0] == 0.0 and not is_pressure)):
            allowed = f"must be {'>=' if is_pressure else '>'} 0, but in a time series or a phase"
            if is_pressure and operation.gravity > 0.0:
                allowed = (
                    "must be >= 0: of a flow that its weight drives against a rising pressure give operation.mass_flow"
                )
            scene.refuse(f"operation.{name}", allowed, value=drive.values[0])
        if not any(drive.values) and len(drive.values) > 1 and not is_pressure:
            scene.refuse(f"operation.{name}", "must not be 0 all the time", value=drive.source)
        if scene.model.flow_update == "frozen" and drive.breakpoints:
            scene.refuse("model.flow_update", f"must be 'quasi-steady' with a time series as operation.{name}")
        limit = MOST_OF_OUTLET_PRESSURE * operation.outlet_pressure
        if is_pressure and max(abs(value) for value in drive.range) > limit:
            allowed = f"must be <= {MOST_OF_OUTLET_PRESSURE:g} x operation.outlet_pressure ({limit:g} Pa)"
            scene.refuse("operation.pressure_drop", allowed, value=drive.range[1])


def drive_keys() -> dict[str, Key]:
    """The keys of the drives by their names."""
    keys = Drive.keys()
    return {name: keys[f"operation.{name}"] for name in DRIVES}
