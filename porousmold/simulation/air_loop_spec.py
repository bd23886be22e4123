"""Blower, heater and returned air of a scene, ready for a simulation."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from ..errors import InputError
from ..laws.air_supply import AirSupply, Blower
from ..laws.materials import Fluid
from ..scene.chosen_laws import Laws
from ..scene.features.air_loop import has_air_loop, read_curve, share_of
from ..scene.features.geometries import BedSize
from ..scene.scene import Scene
from ..scene.series import TimeSeries

CURVE_POINTS = 41
"""Of a blower's quadratic curve."""
DENSER = 1.25
"""Than a blower's curve says a fluid may be: air of -20 degC is 1.16 times as dense as in catalogues."""


@dataclass(frozen=True, kw_only=True)
class AirLoopSpec:
    """What a scene says of it. `share` is how many times what is computed the whole tool is; `returned` the part of the outlet's
    air that comes back; `price` per kWh."""

    blower: Blower | None
    supply: AirSupply
    returned: TimeSeries
    share: float
    price: float | None


def _fresh_temperature(scene: Scene) -> float:
    operation = scene.operation
    return operation.initial_temperature if operation.fresh_temperature is None else operation.fresh_temperature


def _blower_density(scene: Scene, fluid: Fluid) -> float:
    """Density (kg/m3) at which the blower's curve holds: by default that of the fluid as it comes fresh.

    Raises `InputError` where the fluid is so much denser than what is given that the curve would be exceeded.
    """
    given, temperature = scene.operation.blower_density, _fresh_temperature(scene)
    fresh = float(fluid.density(scene.operation.outlet_pressure, temperature))
    if given is not None and fresh > DENSER * given:
        allowed = f"must be near the fluid's own, {fresh:.4g} kg/m3 at {temperature:.4g} K"
        reason = f"the blower or pump would give {fresh / given:.3g} times the pressure of its curve"
        raise InputError("operation.blower_density", given, f"{allowed}: {reason}")
    return fresh if given is None else float(given)


def blower_of(scene: Scene, fluid: Fluid) -> Blower | None:
    """The blower that drives the flow, if one does. Raises `InputError` for a curve at another fluid's density."""
    operation = scene.operation
    if operation.blower is not None:
        flows, rises = read_curve(operation.blower)
    elif operation.blower_pressure is not None:
        parts = np.linspace(0.0, 1.0, CURVE_POINTS)
        flows = tuple((parts * operation.blower_flow).tolist())
        rises = tuple(((1.0 - parts**2) * operation.blower_pressure).tolist())
    else:
        return None
    density = _blower_density(scene, fluid)
    return Blower(flows, rises, density, operation.duct_resistance, operation.blower_efficiency)


def air_loop_of(scene: Scene, fluid: Fluid) -> AirLoopSpec | None:
    """Heater, blower and returned air of a scene; None where the inlet's temperature is given. Raises as `blower_of`."""
    operation, blower = scene.operation, blower_of(scene, fluid)
    if not has_air_loop(scene):
        return None
    supply = AirSupply(
        math.inf if operation.heater_power is None else operation.heater_power,
        _fresh_temperature(scene),
        operation.duct_conductance or 0.0,
    )
    return AirLoopSpec(
        blower=blower,
        supply=supply,
        returned=operation.recirculation or TimeSeries.constant(0.0),
        share=share_of(scene),
        price=operation.energy_price,
    )


def first_point(
    size: BedSize | None,
    laws: Laws,
    blower: Blower,
    share: float,
    outlet_pressure: float,
    temperature: float,
    diameter: float,
) -> float:
    """Pressure drop (Pa) at which the blower and the middle of a bed of this size, a `share` of which the tool is, agree at a
    temperature (K); half of the blower's where the size is not known yet."""
    fluid, phi = laws.fluid, laws.bulk_porosity
    density = float(fluid.density(outlet_pressure, temperature))
    highest = max(blower.left_for_bed(flow, density) for flow in blower.volume_flows)
    if size is None:
        return 0.5 * highest
    viscosity, length, area = float(fluid.viscosity(temperature)), size.length, share * size.area

    def excess(pressure: float) -> float:
        speed = float(laws.drag.speed(phi * pressure / length, phi, diameter, density, viscosity))
        return blower.left_for_bed(area * phi * speed, density) - pressure

    return float(brentq(excess, 1e-6 * highest, highest))
