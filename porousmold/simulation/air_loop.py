"""The supply of a tool as part of a simulation: the blower's operating point, and the inlet temperature that heater and returned
air give.

Beside a bed that stands upright (gravity g along the flow) there is a column of what the blower draws, in the room or in the
return duct: where the blower raises the pressure by Delta p, p_inlet - p_outlet = Delta p - rho_drawn g L. A cold bed then flows
as it does lying; a hot one that is blown upwards draws like a chimney.

The inlet temperature follows the outlet's at every iteration of a stage, so that what the heater gives, the bed takes and the
exhaust loses balance to the tolerance of the stages. The operating point is found by a secant, one flow after the other.
"""

import math
from collections.abc import Callable, Sequence

from dolfinx import fem

from ..equations.energy import EnergyEquations
from ..equations.exhaust import enthalpy_leaving, mass_leaving
from ..errors import SolveError
from ..laws.air_supply import Supplied
from ..laws.materials import Fluid
from ..mesh import ranks
from ..mesh.aliases import Communicator
from ..mesh.deferred_forms import DeferredForm
from ..solvers.state import SavedNumbers
from .air_loop_spec import AirLoopSpec
from .boundary_values import BoundaryValues

POINT_TOLERANCE = 0.3
"""Of the flow's tolerance: the part of the pressure drop by which it may be off the operating point."""
LARGEST_CORRECTION = 10.0
"""Of what is allowed, that blower and bed may differ by: a secant of two nearly equal flows takes any difference for little."""
FARTHEST_AHEAD = 2.0
"""Steps that the operating point is predicted for, at most."""
MOST_POINTS = 12
FLOW_EXPONENT = 0.6
"""Of a bed's mass flow against its pressure drop, for the first secant."""


class AirLoop:
    """The supply over a fluid whose flow has these boundary values; powers are those of the computed part, W.

    `gravity_times_length` (m2/s2) is that along the bed.
    """

    def __init__(
        self,
        spec: AirLoopSpec,
        fluid: Fluid,
        outlet_pressure: float,
        boundary: BoundaryValues,
        equations: EnergyEquations,
        temperature: fem.Function,
        communicator: Communicator,
        gravity_times_length: float,
    ) -> None:
        self.spec, self._fluid, self._outlet_pressure, self._boundary = spec, fluid, outlet_pressure, boundary
        self._communicator = communicator
        self._leaving = DeferredForm(enthalpy_leaving(equations, temperature))
        self._leaving_with_the_flow = DeferredForm(enthalpy_leaving(equations, equations.flow_temperature))
        self._mass = DeferredForm(mass_leaving(equations))
        self._set_point = self._returned = 0.0
        self._slope: float | None = None
        self._points: list[tuple[float, float]] = []
        self._flow = self.blower_power = 0.0
        self._gravity_times_length, self._rise = gravity_times_length, boundary.pressure_drop
        self._drawn_density = float(fluid.density(outlet_pressure, spec.supply.fresh_temperature))
        self.now = Supplied(0.0, 0.0, 0.0, 0.0)

    def set_time(self, time: float) -> None:
        """Take set-point and returned part of a time (s)."""
        self._set_point = self._boundary.set_point(time)
        self._returned = self.spec.returned(time)

    @property
    def depends_on_temperature(self) -> bool:
        """Whether the inlet's temperature depends on the outlet's, or on what the heater can give."""
        return math.isfinite(self.spec.supply.heater_power) or self.spec.returned.range[1] > 0.0

    def begin_step(self, step: float, gamma: float) -> None:
        """Take the mass flow of the step."""
        self._flow = ranks.integral(self._communicator, self._mass.form)

    def begin_stage(self, weights: Sequence[float]) -> None:
        """Nothing is kept from stage to stage."""

    def update(self) -> None:
        """Give the inlet the temperature that belongs to the present outlet's (collective)."""
        leaving = ranks.integral(self._communicator, self._leaving.form) if self._flow > 0.0 else 0.0
        share, supply = self.spec.share, self.spec.supply
        whole = supply.supplied(
            self._fluid, share * self._flow, share * leaving, self._set_point, self._returned, share * self.blower_power
        )
        self.now = Supplied(whole.temperature, whole.heater / share, whole.exhaust / share, whole.duct_loss / share)
        self._boundary.inlet_temperature.value = self.now.temperature

    def end_stage(self) -> None:
        """Nothing is kept from stage to stage."""

    @property
    def is_too_warm(self) -> bool:
        """Whether the air enters above the set-point, though the heater gives nothing."""
        return self.now.temperature > self._set_point + 1e-6

    @property
    def powers(self) -> dict[str, float]:
        """Of the whole tool, W."""
        share = self.spec.share
        return {"heater_power": share * self.now.heater, "blower_power": share * self.blower_power}

    @property
    def rates(self) -> dict[str, float]:
        """What heat balances gain a second (W)."""
        return {
            "by_heater": self.now.heater,
            "by_blower": self.blower_power,
            "by_exhaust": self.now.exhaust,
            "by_duct": self.now.duct_loss,
        }

    def save(self) -> SavedNumbers:
        """Everything that it goes on from."""
        boundary = self._boundary
        return {
            "now": dict(vars(self.now)),
            "flow": self._flow,
            "blower_power": self.blower_power,
            "slope": self._slope,
            "points": self._points,
            "rise": self._rise,
            "drawn_density": self._drawn_density,
            "pressure_drop": boundary.pressure_drop,
            "inlet_temperature": float(boundary.inlet_temperature.value),
        }

    def restore(self, numbers: SavedNumbers) -> None:
        """Go on from what `save()` gave."""
        self.now, self._flow = Supplied(**numbers["now"]), numbers["flow"]
        self.blower_power, self._slope = numbers["blower_power"], numbers["slope"]
        self._points = [(time, rise) for time, rise in numbers["points"]]
        self._rise, self._drawn_density = numbers["rise"], numbers["drawn_density"]
        if self.spec.blower is not None:
            self._boundary.pressure_drop = numbers["pressure_drop"]
        self._boundary.inlet_temperature.value = numbers["inlet_temperature"]

    def _suction_temperature(self, flow: float, time: float) -> float:
        """Of the air that the blower draws (K) beside a mass flow and the temperatures that it was solved with."""
        share, leaving = self.spec.share, ranks.integral(self._communicator, self._leaving_with_the_flow.form)
        whole = share * flow, share * leaving, self.spec.returned(time)
        return self.spec.supply.suction_temperature(self._fluid, *whole)

    def find_point(
        self, solve: Callable[[], None], mass_flow: Callable[[], float], time: float, tolerance: float
    ) -> None:
        """Have the flow of a `time` (s) solved until blower and bed agree to a part of
        the flow's `tolerance` (collective). Raises `SolveError` where they do not come to."""
        blower, share = self.spec.blower, self.spec.share
        if blower is None:
            solve()
            self._flow = mass_flow()
            return
        before, self._rise = None, self._foreseen_point(time)
        for _ in range(MOST_POINTS):
            self._boundary.pressure_drop = self._rise - self._drawn_density * self._gravity_times_length
            solve()
            flow = mass_flow()
            drawn = self._outlet_pressure, self._suction_temperature(flow, time)
            density = self._drawn_density = float(self._fluid.density(*drawn))
            rise = self._boundary.pressure_drop + density * self._gravity_times_length
            if before is not None and flow != before[1]:
                slope = (flow - before[1]) / (rise - before[0])
                self._slope = slope if slope > 0.0 else self._slope
            volume, step = share * flow / density, 1e-4 * share * max(flow, 1e-9) / density
            wanted = blower.left_for_bed(volume, density)
            self._flow, self.blower_power = flow, blower.power(self._fluid, volume, *drawn) / share
            falls = (blower.left_for_bed(volume + step, density) - wanted) / step * share / density
            rises = self._slope or FLOW_EXPONENT * max(flow, 1e-9) / max(rise, 1e-3)
            before = rise, flow
            self._rise = max(rise + (wanted - rise) / (1.0 - min(falls, 0.0) * rises), 0.05 * rise)
            allowed = POINT_TOLERANCE * tolerance * max(abs(rise), 1.0)
            if abs(self._rise - rise) < allowed and abs(wanted - rise) < LARGEST_CORRECTION * allowed:
                self._points = [*[point for point in self._points if point[0] < time][-1:], (time, self._rise)]
                return
        detail = f"the blower delivers {wanted:.4g} Pa, the bed takes {rise:.4g} Pa"
        raise SolveError("operating point of the blower", time, detail, "a curve that falls with the volume flow")

    def _foreseen_point(self, time: float) -> float:
        """What the blower gives (Pa) by the line through the last two operating points."""
        if len(self._points) < 2:
            return self._points[0][1] if self._points else self._rise
        (first, low), (last, high) = self._points
        ahead = min((time - last) / (last - first), FARTHEST_AHEAD)
        return max(high + ahead * (high - low), 0.5 * high)
