"""Blower, heater and returned air of a scene: the curve's file, and how much of the tool is computed."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..files.tables import read_columns

if TYPE_CHECKING:
    from .scene import Scene

KEY = "operation.blower"
LOOP_KEYS = ("blower", "blower_pressure", "heater_power", "recirculation", "duct_conductance", "energy_price")


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
        raise InputError(KEY, str(path), "must have volume flows that increase from 0")
    if np.any(rises[:-1] <= 0.0) or rises[-1] < 0.0 or rises[-1] >= rises[-2]:
        raise InputError(KEY, str(path), "must have pressure rises > 0 that fall in the end")
    return tuple(flows.tolist()), tuple(rises.tolist())


def has_air_loop(scene: "Scene") -> bool:
    """Whether the inlet's temperature follows from a heater and returned air."""
    return any(getattr(scene.operation, name) is not None for name in LOOP_KEYS)


def is_round(scene: "Scene") -> bool:
    """Whether the whole tool is computed: about an axis."""
    return bool(scene.geometry.kind == "pipe" or scene.geometry.symmetry == "axisymmetric")


def share_of(scene: "Scene") -> float:
    """How many times what is computed the whole tool is: half a cavity (or the whole) per metre of width, a quarter of one that
    has a width, as many as the scene says of a mesh in three dimensions."""
    if is_round(scene):
        return 1.0
    if scene.geometry.symmetry == "none":
        return float(scene.geometry.parts)
    if scene.geometry.width is not None:
        return 4.0
    return (1.0 if scene.geometry.cavity == "whole" else 2.0) * float(scene.operation.mold_width or 1.0)
