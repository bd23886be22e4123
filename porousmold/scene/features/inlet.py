"""Temperatures at the start and of the fluid that flows in: one, a series, or a programme of ramps and holds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...errors import InputError
from ..keys import Key, Table
from ..series import TimeSeries
from ..start import LastState
from .feature import Feature, key
from .wall import cures

if TYPE_CHECKING:
    from ..scene import Scene

SAME_LENGTH = 1e-6
"""Relative difference of two lengths that rounding explains."""
STAGE: Mapping[str, Key] = {
    "to": Key("K", "temperature at the end of the ramp", low=0.0, high=5000.0),
    "rate": Key("K/s", "heating or cooling rate of the ramp, positive", low=0.0, high=1e4),
    "over": Key("s", "time that it takes, in place of a rate", low=0.0, high=1e9),
    "hold": Key("s", "duration of the hold after the ramp", low=0.0, high=1e9),
}


@dataclass(frozen=True, kw_only=True)
class AtStart(Feature):
    """What fluid, beads and wall have at first."""

    temperature: float | None = key(
        "operation.initial_temperature",
        "K",
        "of fluid, beads and wall; or a CSV file `x [m], temperature [degC]` of a profile along the flow",
        low=0.0,
        high=5000.0,
        profile=True,
    )
    state: LastState | None = key(
        "operation.initial_state",
        "run",
        "folder of a run whose last temperatures are those at the start, in place of initial_temperature",
    )

    def check(self, scene: "Scene") -> None:
        """There is a temperature; a state is that of a bed as long, without a cure that it does not know."""
        scene.require("operation.initial_temperature")
        if self.state is None:
            return
        if any(cures(scene, layer.material) for layer in scene.layers.values()):
            allowed = "knows no degree of cure: it has no place with a layer that cures"
            scene.refuse("operation.initial_state", allowed, value=None)
        length = scene.geometry.length
        if length is not None and abs(self.state.length / length - 1.0) > SAME_LENGTH:
            allowed = f"is of a bed of {self.state.length:.6g} m: geometry.length is {length:g} m"
            scene.refuse("operation.initial_state", allowed, value=str(self.state.folder))


@dataclass(frozen=True, kw_only=True)
class Inflow(Feature):
    """Temperature (K) of the fluid that flows in, or its programme."""

    temperature: TimeSeries | None = key(
        "operation.inlet_temperature",
        "K",
        "inlet temperature of the fluid; with a heater, its set-point",
        low=0.0,
        high=5000.0,
        series=True,
    )
    programme: Sequence[Table] | None = key(
        "operation.programme",
        "list",
        "stages of the inlet temperature set-point, instead of inlet_temperature",
        entries=STAGE,
    )

    def check(self, scene: "Scene") -> None:
        """One of both, unless there are phases."""
        if scene.operation.phase is not None:
            return
        if self.programme is None:
            scene.require("operation.inlet_temperature")
        elif scene.is_given("operation.inlet_temperature"):
            allowed = "cannot be combined with [[operation.programme]]"
            scene.refuse("operation.inlet_temperature", allowed, value=None)


def temperature_of(programme: Sequence[Table], initial_temperature: float, where: str | None) -> TimeSeries:
    """Temperature (K) against time (s) of stages that each go `to` a temperature at a `rate` (K/s) or `over` a time (s), and then
    `hold` it (s); the first begins at the initial temperature.

    Raises `InputError` for a stage without a way, or with two.
    """
    times, values = [0.0], [initial_temperature]
    for number, stage in enumerate(programme, start=1):
        place = f"operation.programme[{number}]"
        if stage.to is None and (stage.rate is not None or stage.over is not None):
            raise InputError(f"{place}.to", None, "is missing", where)
        if stage.to is not None and (stage.rate is None) == (stage.over is None):
            raise InputError(place, None, "needs either a rate or a time over which it goes to its temperature", where)
        if stage.to is None and stage.hold is None:
            raise InputError(place, None, "must go to a temperature, or hold one", where)
        if stage.to is not None and (stage.to != values[-1] or stage.over is not None):
            duration = stage.over if stage.rate is None else abs(stage.to - values[-1]) / stage.rate
            times.append(times[-1] + duration)
            values.append(stage.to)
        if stage.hold is not None:
            times.append(times[-1] + stage.hold)
            values.append(values[-1])
    return TimeSeries(tuple(times), tuple(values))
