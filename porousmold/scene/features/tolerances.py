"""Uncertainties of the inputs and closures of a scene: the keys of [tolerance], with defaults.

A tolerance is half the width of the interval that holds 95 % of all cases, two standard deviations: relative ("2 %"), or absolute
in the unit of its key ("0.1 mm"). The keys are the names of the inputs themselves. Defaults of inputs are those of a careful
workshop; those of closures follow from the scatter of the experiments behind them (docs/validation.md).
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...errors import InputError
from ...files.units import to_si
from ..keys import Key
from .feature import Feature

if TYPE_CHECKING:
    from ..scene import Scene

_DEFAULTS: dict[str, tuple[str, str, str]] = {
    "geometry.length": ("m", "0.5 %", "length of the bed"),
    "geometry.cavity_height": ("m", "1 %", "height of the cavity"),
    "geometry.diameter": ("m", "1 %", "diameter of the pipe"),
    "bed.bead_diameter": ("m", "2 %", "bead diameter, of a sieve fraction"),
    "bed.bulk_porosity": ("", "0.01", "bulk porosity, from one filling to the next"),
    "bed.bead_density": ("kg/m^3", "1 %", "density of the beads"),
    "bed.bead_heat_capacity": ("J/(kg*K)", "3 %", "heat capacity of the beads"),
    "bed.bead_conductivity": ("W/(m*K)", "10 %", "conductivity of the beads"),
    "wall.thickness": ("m", "5 %", "thickness of the wall"),
    "wall.density": ("kg/m^3", "1 %", "density of the wall"),
    "wall.heat_capacity": ("J/(kg*K)", "3 %", "heat capacity of the wall"),
    "wall.conductivity": ("W/(m*K)", "5 %", "conductivity of the wall"),
    "operation.pressure_drop": ("Pa", "2 %", "pressure drop"),
    "operation.inlet_velocity": ("m/s", "3 %", "inlet velocity"),
    "operation.mass_flow": ("kg/s", "2 %", "mass flow"),
    "operation.inlet_temperature": ("delta_degC", "1 K", "inlet temperature"),
    "operation.initial_temperature": ("delta_degC", "1 K", "initial temperature"),
    "model.drag_factor": ("", "15 %", "drag: KTA 3102.3 states 15 % at 95 % confidence"),
    "model.exchange_factor": ("", "25 %", "exchange between fluid and beads"),
    "model.conduction_factor": ("", "24 %", "heat across the flow: eight correlation sets scatter by 12 % (one sigma)"),
}
TOLERANCES = {
    name: Key("tolerance", f"of the {meaning}", default, tolerated=unit)
    for name, (unit, default, meaning) in _DEFAULTS.items()
}


@dataclass(frozen=True)
class Tolerances(Feature):
    """The keys of [tolerance], which stay as they are written."""

    @classmethod
    def keys(cls) -> dict[str, Key]:
        """Each has the name of an input."""
        return {f"tolerance.{name}": key for name, key in TOLERANCES.items()}

    def check(self, scene: "Scene") -> None:
        """Those that are given can be read."""
        for name, value in scene.tolerance:
            if scene.is_given(f"tolerance.{name}"):
                tolerance_of(name, value, scene.source)


@dataclass(frozen=True)
class Tolerance:
    """Half the width of a 95 % interval: `size` in SI, or `relative` to the value."""

    size: float
    relative: bool

    def of(self, value: float) -> float:
        """In the unit of the value."""
        return self.size * abs(value) if self.relative else self.size


def tolerance_of(name: str, given: object, where: str | None = None) -> Tolerance:
    """The tolerance of an input from "2 %" or a quantity of its unit. Raises `InputError` naming the key."""
    key, text = f"tolerance.{name}", given if isinstance(given, str) else str(given)
    relative = text.strip().endswith("%")
    size = to_si(key, text.strip().removesuffix("%"), "", where) / 100.0 if relative else 0.0
    if not relative:
        size = to_si(key, given, TOLERANCES[name].tolerated, where)
    if relative and TOLERANCES[name].tolerated == "delta_degC":
        raise InputError(key, given, "must be in K: a part of a temperature would count from 0 K", where)
    if not 0.0 <= size < (0.5 if relative else float("inf")):
        raise InputError(key, given, "must be >= 0, and < 50 % where it is relative", where)
    return Tolerance(size, relative)
