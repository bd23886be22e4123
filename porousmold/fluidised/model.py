r"""A fluidised bed that heats its wall: beads mixed to one temperature, the wall of one temperature, in seconds.

    bed:   (M_s C_s + V rho C_p) dT_s/dt = m C_p (T_in - T_s) (1 - exp(-NTU)) - h A (T_s - T_w)
    wall:  M_w C_w dT_w/dt = h A (T_s - T_w) + outer heat

V is the volume of the voids of the expanded bed: what their fluid stores is little of a gas and most of a liquid. m is the mass
flow, NTU = a_v h_sf H/(rho w C_p) its exchange with the beads over the height H of the expanded bed, h the coefficient at the
wall (`laws.fluidisation`), A the wall's area over that height. The gas rises; the bed at rest is as high as geometry.length,
with the scene's bulk porosity. Properties are those at the present temperatures. The wall's layers are added up, which holds
for h t/lambda well below 1; the summary has that Biot number.

The pressure drop is the weight of the beads less their buoyancy, (1-phi)(rho_s - rho) g H: what a manometer shows beyond the
column of fluid at rest. The coefficient at the wall is that of gases: of a liquid the summary says so.

The heat balance m int C_p (T_in - T_out) dt + outer heat = gained by bed and wall closes to the tolerance of the integration.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import quad, solve_ivp

from ..arrays import Floats
from ..errors import InputError
from ..laws import fluidisation
from ..laws.materials import IdealGasDensity, beyond_ranges
from ..scene.chosen_laws import Laws, require_phase
from ..scene.features import require_used
from ..scene.features.bed import Beads
from ..scene.features.extensions import Extensions
from ..scene.features.fluid import BedFluid
from ..scene.features.geometries import GEOMETRIES, BedSize
from ..scene.features.inlet import STAGE, Inflow
from ..scene.features.output import Output
from ..scene.features.straight_bed import StraightBed
from ..scene.features.wall import BedWall, name_of
from ..scene.scene import Scene
from .expanded_bed import State, state_of

TOLERANCE = 1e-8
USED = {
    *StraightBed.keys().keys() - {"geometry.cavity"},
    *Beads.keys().keys() - {"bed.contact_flattening"},
    *("bed.bulk_porosity", "bed.porosity_profile", "model.closures", "model.nusselt", "model.exchange_factor"),
    *("operation.initial_temperature", "operation.inlet_velocity", "operation.mass_flow"),
    *Inflow.keys(),
    *(f"operation.programme.{name}" for name in STAGE),
    *BedWall.keys().keys() - {"wall.opposite_layer", "solver.wall_cells", "operation.wall_temperature"},
    *(f"wall.layer.{name}" for name in ("name", "material", "thickness")),
    *("operation.outer_coefficient", "operation.ambient_temperature", "operation.heating_margin", "operation.end_time"),
    *BedFluid.keys(),
    *Extensions.keys(),
    *Output.keys().keys() - {"output.times", "output.every"},
}
"""Keys of a scene that a fluidised bed is computed from; the others are refused."""
LARGEST_RATIO = 10.0
"""Of the velocity to that of minimum fluidisation, up to which the coefficient at the wall is known."""


class FluidisedBed:
    """The bed and wall of a scene. Raises `InputError` for a scene without a straight bed, a given flow and a wall."""

    def __init__(self, scene: Scene) -> None:
        self.scene, operation = scene, scene.operation
        size = GEOMETRIES[scene.geometry.kind].size(scene.geometry)
        if size is None or size.core_radius:
            raise InputError(
                "geometry.kind", scene.geometry.kind, "must be 'mold' or 'pipe' for a fluidised bed", scene.source
            )
        self._size: BedSize = size
        if operation.inlet_velocity is None and operation.mass_flow is None:
            allowed = "must be given, or operation.mass_flow: the pressure drop of a fluidised bed is its weight"
            raise InputError("operation.inlet_velocity", None, allowed, scene.source)
        drive = "mass_flow" if operation.inlet_velocity is None else "inlet_velocity"
        if len(set(getattr(operation, drive).values)) > 1:
            allowed = "must be the same all the time: the height of the bed, and of the wall that it heats, follows it"
            scene.refuse(f"operation.{drive}", allowed, value=getattr(operation, drive).source)
        if scene.model.wall not in ("conjugate", "thin"):
            raise InputError(
                "model.wall", scene.model.wall, "must be 'conjugate' or 'thin' for a fluidised bed", scene.source
            )
        require_used(scene, USED, "a fluidised bed")
        if scene.start is not None:
            allowed = "must be one temperature: a fluidised bed is mixed"
            raise InputError("operation.initial_temperature", None, allowed, scene.source)
        self._laws = Laws.of(scene)
        require_phase(scene, self._laws)
        if any(one.cure is not None for one in self._laws.walls.values()):
            allowed = "must not cure: the heat of cure has no effect on a fluidised bed"
            raise InputError("wall.material", ", ".join(self._laws.walls), allowed, scene.source)
        self.porosity_at_rest = self._laws.bulk_porosity
        layers = scene.wall.layer
        self._layers = (
            [(scene.wall.thickness, self._laws.walls["wall"])]
            if layers is None
            else [(layer.thickness, self._laws.walls[name_of(layer)]) for layer in layers]
        )

    def state(self, time: float, temperature: float) -> State:
        """The bed at a time (s), all of it at a temperature (K). Raises `InputError` where the gas does not lift the beads, or
        carries them away."""
        return state_of(self.scene, self._laws, self._size, time, temperature)

    @property
    def _is_liquid(self) -> bool:
        return not isinstance(self._laws.fluid.density, IdealGasDensity)

    @property
    def _bead_volume(self) -> float:
        return self._size.area * self._size.length * (1.0 - self.porosity_at_rest)

    def _void_volume(self, height: float) -> float:
        return self._size.area * height - self._bead_volume

    def _heat_of_fluid(self, height: float, start: float, end: float) -> float:
        """Heat (J) that the fluid in a bed of that height takes up; what expands leaves it."""
        fluid, pressure = self._laws.fluid, self.scene.operation.outlet_pressure
        heat = quad(lambda value: fluid.density(pressure, value) * fluid.heat_capacity(value), start, end)[0]
        return float(self._void_volume(height) * heat)

    def wall_biot_number(self, state: State) -> float:
        """h times the resistance of the wall's layers."""
        temperature = self._warmest_inlet
        return state.wall_coefficient * sum(t / solid.conductivity(temperature) for t, solid in self._layers)

    def _wall_volumes(self, height: float) -> list[tuple[float, Any]]:
        """Volume (m3) of each layer over a height, and its material."""
        volumes, inner = [], self._size.half_height
        for thickness, solid in self._layers:
            across = math.pi * (2.0 * inner + thickness) if self._size.axisymmetric else self._size.walled_perimeter
            volumes.append((across * thickness * height, solid))
            inner += thickness
        return volumes

    def _rates(self, time: float, temperatures: Floats, height: float) -> tuple[Floats, float, float]:
        """dT/dt of beads and wall (K/s), heat from the gas and from outside (W); the wall is that of `height`."""
        bead, wall = temperatures
        operation, laws, state = self.scene.operation, self._laws, self.state(time, bead)
        inlet = operation.inlet_temperature(time)
        enthalpy = laws.fluid.heat_capacity.integral
        from_gas = state.mass_flow * (enthalpy(inlet) - enthalpy(bead)) * -math.expm1(-state.transfer_units)
        to_wall = state.wall_coefficient * self._size.walled_perimeter * height * (bead - wall)
        outside = 0.0
        if operation.outer_coefficient is not None:
            outer = self._size.walled_perimeter
            outer += 2.0 * math.pi * sum(t for t, _ in self._layers) if self._size.axisymmetric else 0.0
            outside = operation.outer_coefficient * outer * height * (operation.ambient_temperature(time) - wall)
        of_bed = self._bead_volume * laws.beads.density(bead) * laws.beads.heat_capacity(bead)
        of_bed += self._void_volume(height) * state.fluid_density * laws.fluid.heat_capacity(bead)
        of_wall = sum(v * solid.density(wall) * solid.heat_capacity(wall) for v, solid in self._wall_volumes(height))
        rates = np.array([(from_gas - to_wall) / of_bed, (to_wall + outside) / of_wall])
        return rates, from_gas, outside

    @property
    def _warmest_time(self) -> float:
        """When (s) the inlet's temperature is farthest from the start, first."""
        inlet, start = self.scene.operation.inlet_temperature, self.scene.operation.initial_temperature
        number = max(range(len(inlet.values)), key=lambda one: abs(inlet.values[one] - start))
        return float(max(inlet.times[number], 0.0))

    @property
    def _warmest_inlet(self) -> float:
        """The inlet's temperature (K) then."""
        return float(self.scene.operation.inlet_temperature(self._warmest_time))

    def integrate(self) -> tuple[dict[str, Any], Mapping[str, Floats]]:
        """Summary, and history (SI arrays by name) until the wall is within operation.heating_margin of the inlet's
        temperature, whose last change is behind, or operation.end_time.

        An inlet temperature that only passes the wall's heats nothing: the wall has to stay within the margin up to the next
        breakpoint of the inlet's temperature.
        """
        operation, end = self.scene.operation, self.scene.operation.end_time
        inlet, start = operation.inlet_temperature, operation.initial_temperature
        warm = self.state(self._warmest_time, self._warmest_inlet)
        wall_volumes, bead_volumes = self._wall_volumes(warm.height), [(self._bead_volume, self._laws.beads)]
        scale = _heat_taken(wall_volumes + bead_volumes, start, start + 1.0)

        def rates(time: float, unknowns: Floats) -> list[float]:
            change, from_gas, outside = self._rates(time, unknowns[:2], warm.height)
            return [*change, from_gas / scale, outside / scale]

        def deficit(time: float, unknowns: Floats) -> float:
            return float(abs(inlet(time) - unknowns[1]) - operation.heating_margin)

        series = [one for one in (inlet, operation.ambient_temperature) if one is not None]
        corners = {float(instant) for one in series for instant in one.breakpoints if 0.0 < instant < end}
        last_change = max((instant for instant in inlet.breakpoints if instant < end), default=0.0)
        times, unknowns = np.zeros(1), np.array([[start], [start], [0.0], [0.0]])
        crossings: list[float] = []
        for begun, ended in pairwise([0.0, *sorted(corners), end]):  # no step passes a corner unseen
            deficit.terminal = begun >= last_change  # type: ignore[attr-defined]
            if deficit.terminal and crossings and deficit(begun, unknowns[:, -1]) <= 0.0:  # type: ignore[attr-defined]
                break
            found = solve_ivp(
                rates, (begun, ended), unknowns[:, -1], "LSODA", events=deficit, rtol=TOLERANCE, atol=1e-8
            )
            times, unknowns = np.append(times, found.t[1:]), np.hstack([unknowns, found.y[:, 1:]])
            crossings += found.t_events[0].tolist()
            if found.status == 1:
                break
        bead, wall, *given = unknowns
        stored = _heat_taken(bead_volumes, start, bead[-1]) + _heat_taken(wall_volumes, start, wall[-1])
        stored += self._heat_of_fluid(warm.height, start, bead[-1])
        temperatures = np.array([inlet(time) for time in times])
        history = {"time": times, "inlet_temperature": temperatures, "bead_temperature": bead, "wall_temperature": wall}
        outside = deficit(0.0, unknowns[:, 0]) > 0.0
        heated = _heating_time(crossings, inlet.breakpoints, begins_outside=outside)
        return self._summary(
            warm, heated, float(times[-1]), (scale * given[0][-1], scale * given[1][-1]), stored
        ), history

    def _beyond_ranges(self) -> list[str]:
        """Of laws that do not hold at the temperatures given."""
        operation = self.scene.operation
        given = operation.initial_temperature, *operation.inlet_temperature.range
        materials = self._laws.materials(True).values()
        return [text for material in materials for text in beyond_ranges(material, min(given), max(given))]

    def _summary(
        self, warm: State, heated: float | None, end: float, given: tuple[float, float], stored: float
    ) -> dict[str, Any]:
        """Of the bed when it is warm, heating and end time (s), heat given by the gas and from outside, and heat stored (J)."""
        density = self._laws.beads.density(self.scene.operation.initial_temperature) - warm.fluid_density
        biot = self.wall_biot_number(warm)
        return {
            "heating_time": heated,
            "end_time": end,
            "minimum_fluidisation_velocity": warm.minimum_velocity,
            "terminal_velocity": warm.terminal_velocity,
            "velocity": warm.velocity,
            "porosity": warm.porosity,
            "height": warm.height,
            "pressure_drop": self._bead_volume / self._size.area * density * fluidisation.GRAVITY,
            "wall_coefficient": warm.wall_coefficient,
            "wall_biot_number": biot,
            "transfer_units": warm.transfer_units,
            "mass_flow": warm.mass_flow,
            "heat_by_fluid": given[0],
            "heat_stored": stored,
            "energy_imbalance": (sum(given) - stored) / max(abs(sum(given)), abs(stored), 1e-6),
            "source": fluidisation.SOURCE,
            "warnings": _warnings(self.scene, self._is_liquid, warm, biot, heated) + self._beyond_ranges(),
        }


def _heating_time(crossings: Sequence[float], breakpoints: Sequence[float], *, begins_outside: bool) -> float | None:
    """The first time (s) at which the wall comes within the margin and stays there up to the next breakpoint, of the times at
    which it crosses it, in and out by turns."""
    inwards = crossings[not begins_outside :: 2]
    outwards = crossings[begins_outside::2]
    for instant in inwards:
        ahead = min((one for one in breakpoints if one >= instant), default=-math.inf)
        if not any(instant < one <= ahead for one in outwards):
            return float(instant)
    return None


def _warnings(scene: Scene, liquid: bool, state: State, wall_biot_number: float, heated: float | None) -> list[str]:
    found: list[str] = []
    if liquid:
        found.append(
            "the fluid is a liquid: the coefficient at the wall (Martin 1984) is that of bubbling beds in gases, and the heating "
            "time follows from it; velocities, height and pressure drop hold"
        )
    low, high = fluidisation.DIAMETER_RANGE
    if not low <= scene.bed.bead_diameter <= high:
        found.append(
            f"beads of {scene.bed.bead_diameter * 1e3:.3g} mm are outside {low * 1e3:g} to {high * 1e3:g} mm, the range of "
            "the coefficient at the wall"
        )
    if state.velocity > LARGEST_RATIO * state.minimum_velocity:
        ratio = state.velocity / state.minimum_velocity
        found.append(
            f"the fluid has {ratio:.2g} times the minimum fluidisation velocity; valid up to {LARGEST_RATIO:g}"
        )
    if wall_biot_number > 0.3:
        found.append(f"wall Biot number {wall_biot_number:.2g}: a lumped wall is heated too fast")
    if heated is None:
        margin = scene.operation.heating_margin
        found.append(f"not heated to within {margin:g} K by operation.end_time {scene.operation.end_time:g} s")
    return found


def _heat_taken(volumes: list[tuple[float, Any]], start: float, end: float) -> float:
    """Heat (J) that volumes (m3) of solids take from one temperature (K) to another."""
    gained = (
        volume * solid.density(end) * (solid.heat_capacity.integral(end) - solid.heat_capacity.integral(start))
        for volume, solid in volumes
    )
    return float(sum(gained))
