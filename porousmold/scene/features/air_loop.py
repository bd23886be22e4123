"""Blower, heater and returned air of a scene: the curve's file, and how much of the tool is computed."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...errors import InputError
from ...files.tables import read_columns
from ..series import TimeSeries
from .feature import Feature, key, measure
from .geometries import geometry_of

if TYPE_CHECKING:
    from ..scene import Scene

KEY = "operation.blower"
LOOP_KEYS = ("blower", "blower_pressure", "heater_power", "recirculation", "duct_conductance")


@dataclass(frozen=True, kw_only=True)
class AirLoop(Feature):
    """Blower, ducts, heater and returned air of the whole tool, and what energy costs."""

    blower: Path | None = key(
        "operation.blower",
        "file",
        "CSV curve `volume_flow [m^3/h], pressure_rise [Pa]` of the whole tool's blower",
    )
    blower_pressure: float | None = key(
        "operation.blower_pressure",
        "Pa",
        "pressure rise at zero flow of a blower with a parabolic curve",
        low=0.0,
        high=1e7,
    )
    blower_flow: float | None = key(
        "operation.blower_flow",
        "m^3/s",
        "volume flow at zero pressure rise of that blower",
        low=0.0,
        high=1e4,
    )
    blower_density: float | None = key(
        "operation.blower_density",
        "kg/m^3",
        "density at which the blower's curve holds; default: the fluid at fresh_temperature",
        low=0.0,
        high=1e4,
    )
    blower_efficiency: float = key(
        "operation.blower_efficiency",
        "",
        "of motor and fan, over isentropic compression; all power dissipated in the air",
        0.6,
        low=0.01,
        high=1.0,
        closed=True,
    )
    duct_resistance: float = key(
        "operation.duct_resistance",
        "Pa*s^2/m^6",
        "pressure loss of ducts and filters over the volume flow squared, at blower_density",
        0.0,
        low=0.0,
        high=1e12,
        closed=True,
    )
    heater_power: float | None = key(
        "operation.heater_power", "W", "maximum power of the heater of the whole tool", low=0.0, high=1e9
    )
    recirculation: TimeSeries | None = key(
        "operation.recirculation",
        "",
        "fraction of the outlet flow that is recirculated to the blower",
        low=0.0,
        high=1.0,
        closed=True,
        series=True,
    )
    duct_conductance: float | None = key(
        "operation.duct_conductance",
        "W/K",
        "U A of the return duct: what returns keeps exp(-U A/(m c_p)) of its difference from fresh_temperature",
        low=0.0,
        high=1e6,
        closed=True,
    )
    fresh_temperature: float | None = key(
        "operation.fresh_temperature",
        "K",
        "temperature of fresh air and around the duct; default initial_temperature, where that is one number",
        low=0.0,
        high=5000.0,
    )
    mold_width: float | None = measure(
        "operation.mold_width",
        "mold width supplied by blower and heater, if geometry.width is not set; default 1 m",
    )
    energy_price: float | None = key(
        "operation.energy_price", "", "price of a kWh for heater and blower", low=0.0, high=1e6
    )
    currency: str | None = key("operation.currency", "line", "of the price, for summary and report")

    @property
    def has_blower(self) -> bool:
        """Whether a blower drives the flow."""
        return self.blower is not None or self.blower_pressure is not None

    def check(self, scene: "Scene") -> None:
        """A blower has one curve, and what belongs to the loop stands in a scene that has one."""
        if self.has_blower:
            self._check_blower(scene)
        if self.blower_flow is not None and self.blower_pressure is None:
            scene.require("operation.blower_pressure")
        for name in ("duct_resistance", "blower_efficiency", "blower_density"):
            if scene.differs_from_default(f"operation.{name}") and not self.has_blower:
                scene.refuse(f"operation.{name}", "has no meaning without a blower")
        if self.currency is not None and self.energy_price is None:
            scene.refuse("operation.currency", "has no meaning without operation.energy_price")
        if self.duct_conductance and not self.recirculation:
            scene.refuse("operation.duct_conductance", "has no meaning without operation.recirculation")
        geometry = dict(scene.geometry)
        if self.mold_width is not None and not geometry_of(geometry).is_per_width(geometry):
            allowed = f"has no place here: what is modelled is {geometry_of(geometry).modelled_part(geometry)}"
            scene.refuse("operation.mold_width", allowed)
        if not has_air_loop(scene):
            for name in ("fresh_temperature", "mold_width", "energy_price"):
                if getattr(self, name):
                    allowed = "has no meaning without a blower, a heater or recirculation"
                    cure = " (operation.recirculation = 0 is a heater without return)" if name == "energy_price" else ""
                    scene.refuse(f"operation.{name}", allowed + cure)
            return
        if scene.start is not None:
            scene.require("operation.fresh_temperature")
        if scene.model.flow_update == "transient":
            scene.refuse("model.flow_update", "must not be 'transient' with a heater or recirculation")

    def _check_blower(self, scene: "Scene") -> None:
        if self.blower is not None:
            for name in ("blower_pressure", "blower_flow"):
                if getattr(self, name) is not None:
                    scene.refuse(f"operation.{name}", "cannot be combined with operation.blower, a file")
            read_curve(self.blower)
        else:
            scene.require("operation.blower_flow")
        if scene.model.flow_update == "transient":
            scene.refuse("model.flow_update", "must be 'quasi-steady' or 'frozen' with a blower")


def read_curve(path: Path) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Volume flows (m3/s) and pressure rises (Pa) of a CSV file `volume_flow [m^3/h], pressure_rise [Pa]`.

    Raises `InputError` where the head is another, the flows do not rise from 0, or the pressure does not fall in the end.
    """
    columns = read_columns(KEY, path)
    if columns.names != ["volume_flow", "pressure_rise"]:
        allowed = "must have the head 'volume_flow [m^3/h], pressure_rise [Pa]'"
        raise InputError(KEY, ", ".join(columns.names), allowed, str(path))
    flows, rises = columns.in_si(0, "m^3/s"), columns.in_si(1, "Pa")
    if len(flows) < 2 or flows[0] != 0.0 or np.any(np.diff(flows) <= 0.0):
        allowed = "must have volume flows that increase from 0: the first row is the pressure rise of no flow"
        raise InputError(KEY, str(path), allowed)
    if np.any(rises[:-1] <= 0.0) or rises[-1] < 0.0 or rises[-1] >= rises[-2]:
        raise InputError(KEY, str(path), "must have pressure rises > 0 that fall in the end")
    return tuple(flows.tolist()), tuple(rises.tolist())


def has_air_loop(scene: "Scene") -> bool:
    """Whether the inlet's temperature follows from a heater and returned air."""
    return any(getattr(scene.operation, name) is not None for name in LOOP_KEYS)


def share_of(scene: "Scene") -> float:
    """How many times what is computed the whole tool is, with the width that it is said to have."""
    geometry = dict(scene.geometry)
    return geometry_of(geometry).parts(geometry) * float(scene.operation.mold_width or 1.0)
