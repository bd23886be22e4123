"""The discrete problem of a scene, and the questions that one can ask of its present state."""

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from ..arrays import Floats
from ..equations.energy import EnergyEquations
from ..equations.flow import FlowEquations
from ..equations.heat_budget import HeatBudget
from ..errors import InputError
from ..laws.functions import Value
from ..mesh import domain as geometry
from ..mesh import fenicsx, ranks
from ..mesh.aliases import Communicator, Form, Space
from ..mesh.domain import Domain
from ..mesh.mirror import Mirror
from ..mesh.nodes import spans_along_flow
from ..mesh.probe import PointProbe
from ..scene.features.geometries import BedSize
from ..scene.features.sensors import read_sensors
from ..scene.start import Start
from ..solvers.displacement import Displacement
from ..solvers.protocols import Flow, Heat
from ..solvers.relaxation import Relaxation
from ..solvers.state import ArrayOf, Numbers, Saved, SavedNumbers, State
from .air_loop import AirLoop
from .bed_volume import BedVolume
from .boundary_values import BoundaryValues
from .estimates import Estimates
from .places import Places
from .specs import Specs
from .stopwatch import Stopwatch

PLACES_ALONG = 101
"""Of the profile along the bed."""
STORES = ("beads", "wall")
LITTLE = 0.05
"""Of what the fluid displaces in the bed: what leaves beside it has no temperature of its own."""
STATION_FRACTIONS = {"L/8": 0.125, "L/4": 0.25, "L/2": 0.5, "L": 1.0}


@dataclass(frozen=True)
class Medium:
    """What fills a mesh: the flow's equations over the bed, the boundary's values, the inlet's area (m2), and the temperatures
    (K, functions) that the flow is solved for, with their `relaxation`, and that the heat's properties are taken at;
    `displacement` is what the fluid displaces as it expands, where that counts."""

    domain: Domain
    size: BedSize
    estimates: Estimates
    equations: FlowEquations
    boundary: BoundaryValues
    inlet_area: float
    flow_temperature: fem.Function
    property_temperature: fem.Function
    relaxation: Relaxation
    displacement: Displacement | None = None


@dataclass(frozen=True, kw_only=True)
class _Forms:
    mass_in: Form
    mass_out: Form
    mass_displaced: Form
    is_mass_kept: bool
    inlet_pressure: Form
    outlet_heat: Form
    outlet_area: Form
    outlet_mean: Form
    bead_outlet: tuple[Any, Any] | None


class Balances:
    """Compiled forms of what flows through inlet and outlet, and their present values.

    Below the mass flux `no_flow` (kg/m2/s) nothing flows but what rounding leaves.
    """

    def __init__(self, communicator: Communicator, no_flow: float, **forms: Any) -> None:
        self._communicator, self._no_flow, self._forms = communicator, no_flow, _Forms(**forms)

    def _value(self, form: Form) -> float:
        """Value of a compiled scalar form, the sum over all ranks."""
        return ranks.integral(self._communicator, form.form)

    @property
    def mass_flow(self) -> float:
        """Mass flow out of the outlet, without what the fluid in the bed displaces as it expands, kg/s, of what is computed (per
        metre width where that has no width); that into the inlet where REV terms do not keep the mass."""
        displaced = self._forms.mass_displaced
        if not self._forms.is_mass_kept:
            return self._value(self._forms.mass_in)
        return self._mass_out - (0.0 if displaced is None else self._value(displaced))

    @property
    def _mass_out(self) -> float:
        return self._value(self._forms.mass_out)

    @property
    def drawn_in(self) -> float:
        """Part of what the fluid in the bed contracts by that comes in at the outlet, where that is faster than the flow."""
        displaced = self._forms.mass_displaced
        if displaced is None or (out := self._mass_out) >= -self._no_flow * self._outlet_area:
            return 0.0
        return out / min(self._value(displaced), out)

    @property
    def mass_imbalance(self) -> float:
        """(in + displaced - out)/out of the mass flow."""
        displaced = self._forms.mass_displaced
        out = self._mass_out - (0.0 if displaced is None else self._value(displaced))
        return (self._value(self._forms.mass_in) - out) / out if out else 0.0

    @property
    def pressure_drop(self) -> float:
        """Mean pressure over the inlet above that at the outlet, Pa."""
        return self._value(self._forms.inlet_pressure)

    @functools.cached_property
    def _outlet_area(self) -> float:
        return self._value(self._forms.outlet_area)

    @property
    def outlet_temperature(self) -> float:
        """Mean temperature of what flows out, K; that of the outlet's area where next to nothing does."""
        leaving, displaced = self._mass_out, self._forms.mass_displaced
        least = self._no_flow * self._outlet_area
        if displaced is not None:
            least = max(least, LITTLE * abs(self._value(displaced)))
        if abs(leaving) <= least:
            return self._value(self._forms.outlet_mean) / self._outlet_area
        return self._value(self._forms.outlet_heat) / leaving

    @property
    def bead_outlet_temperature(self) -> float | None:
        """Mean temperature of the beads that leave, K; None where they rest."""
        if self._forms.bead_outlet is None:
            return None
        temperature, area = self._forms.bead_outlet
        return self._value(temperature) / self._value(area)


def sensors_of(specs: Specs, domain: Domain) -> tuple[list[str], PointProbe]:
    """Names of the sensors, and what gives their values (collective). Raises `InputError` for one outside the mesh."""
    names, places = read_sensors(specs.mesh.sensors.file, domain.mesh.geometry.dim)
    try:
        return names, PointProbe(domain, places)
    except ValueError as error:
        raise InputError("geometry.sensors", str(specs.mesh.sensors.file), str(error)) from error


def starting_temperatures(start: Start, space: Space, domain: Domain, *, of_beads: bool) -> Floats:
    """Those (K) that a run starts from, at the nodes of a scalar space (collective); ghosts may lack cells of theirs."""
    spans = spans_along_flow(space) - domain.begin
    return start.at(space.tabulate_dof_coordinates(), spans, of_beads=of_beads)


class Problem:
    """A scene on a mesh: `specs`, `medium`, `flow`, `heat`, `balances`, the heat's equations, and where values are recorded.

    Raises `InputError` for a sensor outside the mesh.
    """

    def __init__(
        self,
        specs: Specs,
        medium: Medium,
        flow: Flow,
        heat: Heat,
        balances: Balances,
        energy_equations: EnergyEquations,
        stopwatch: Stopwatch,
        air_loop: AirLoop | None = None,
    ) -> None:
        self.air_loop = air_loop
        self.specs, self.medium, self.flow, self.heat, self.balances = specs, medium, flow, heat, balances
        self.energy_equations, self.stopwatch = energy_equations, stopwatch
        self.domain: Domain = medium.domain
        self.communicator = self.domain.communicator
        named = {
            f"{place}_{label}": point
            for label, fraction in STATION_FRACTIONS.items()
            for place, point in self.domain.stations(fraction).items()
        }
        self.station_names, self.stations = list(named), PointProbe(self.domain, np.array(list(named.values())))
        self.sensor_names, self.sensors = sensors_of(specs, self.domain)
        self.places = Places(self.domain, heat, specs.heat)

    @functools.cached_property
    def along_the_bed(self) -> PointProbe:
        """Values at `PLACES_ALONG` places, evenly spaced from inlet to outlet, in the middle of the bed."""
        stations = [self.domain.stations(float(part)) for part in np.linspace(0.0, 1.0, PLACES_ALONG)]
        return PointProbe(self.domain, np.array([station.get("centre", station["bed_side"]) for station in stations]))

    def storable(self, low: float, high: float) -> float:
        """Heat (J) that fluid, beads and wall store between two temperatures (K), the fluid with its present capacity
        (collective)."""
        warm, cold = self.domain.constant(high), self.domain.constant(low)
        budget = HeatBudget(self.energy_equations)
        forms = budget.kept(warm, warm, cold, cold)
        parts = [forms[name] for name in STORES if name in forms]
        parts.append((high - low) * budget.fluid_heat_capacity())
        return sum(ranks.integral(self.communicator, fenicsx.compiled_form(part)) for part in parts)

    @property
    def inlet_temperature(self) -> float:
        """Present temperature (K) of the fluid that flows in."""
        return float(self.medium.boundary.inlet_temperature.value)

    def heat_kept(self) -> dict[str, float]:
        """Heat (J) gained by beads and wall since the start, and set free by cure (collective)."""
        return {name: ranks.integral(self.communicator, form) for name, form in self._heat_kept_forms.items()}

    @functools.cached_property
    def _heat_kept_forms(self) -> dict[str, Form]:
        two = self.specs.heat.model.two_temperatures
        parts = ufl.split(self.heat.unknown) if two else (self.heat.unknown,) * 2
        forms = HeatBudget(self.energy_equations).kept(parts[0], parts[1], *self._at_first)
        return {name: fenicsx.compiled_form(form) for name, form in forms.items()}

    @functools.cached_property
    def _at_first(self) -> tuple[Value, Value]:
        """Temperatures of the wall and of the beads at the start."""
        heat, space = self.specs.heat, self.medium.flow_temperature.function_space
        if heat.start is None:
            return (self.domain.constant(heat.initial_temperature),) * 2
        functions = fem.Function(space), fem.Function(space)
        for function, of_beads in zip(functions, (False, heat.model.two_temperatures), strict=True):
            function.x.array[:] = starting_temperatures(heat.start, space, self.domain, of_beads=of_beads)
            function.x.scatter_forward()
        return functions

    def degrees_of_cure(self) -> dict[str, tuple[float, float]]:
        """Least and largest degree of cure of the layers that cure (collective)."""
        curing = [layer.name for layer in self.specs.heat.all_layers if layer.solid.cure is not None]
        return {name: part.extremes() for name, part in zip(curing, self.heat.curing, strict=True)}

    @property
    def beads_move(self) -> bool:
        """Whether beads bring and carry away heat."""
        return self.energy_equations.moving_beads is not None

    @property
    def has_wall(self) -> bool:
        """Whether there is a wall that stores heat, resolved or thin."""
        return self.domain.has_wall or self.specs.heat.wall.kind == "thin"

    @property
    def temperature(self) -> fem.Function:
        """Fluid and wall temperature (K) as a function on the mesh, a copy."""
        return self.part_of_heat(self.heat.unknown, 0)

    @property
    def bead_temperature(self) -> fem.Function:
        """Bead temperature (K) as a function on the mesh, a copy; meaningless in the wall."""
        return self.part_of_heat(self.heat.unknown, 1)

    @functools.cached_property
    def bed(self) -> BedVolume:
        """The volume of the bed, for means and integrals over it."""
        return BedVolume(self.domain, self.medium.flow_temperature.function_space, self.medium.equations.coordinates)

    def part_of_heat(self, unknown: fem.Function, part: int) -> fem.Function:
        """T (part 0) or T_s (part 1) of a function of the energy's space, as a function on the mesh.

        By interpolation: across ranks the spaces number their nodes differently.
        """
        function = fem.Function(self.medium.flow_temperature.function_space)
        function.interpolate(unknown.sub(part) if self.specs.heat.model.two_temperatures else unknown)
        function.x.scatter_forward()
        return function

    @property
    def unknowns(self) -> dict[str, int]:
        """Numbers of unknowns solved for."""
        return {"flow": self.flow.unknowns, "energy": self.heat.unknowns}

    @functools.cached_property
    def solution(self) -> State:
        """Temperatures and flow."""
        return State.joined({"heat": self.heat.solution, "flow": self.flow.solution})

    @functools.cached_property
    def heated(self) -> State:
        """All of the state but the flow."""
        medium = self.medium
        coefficients = {
            "flow": medium.flow_temperature,
            "properties": medium.property_temperature,
            "missed": medium.relaxation.missed,
            "turns": medium.relaxation.turns,
        }
        if (displacement := medium.displacement) is not None:
            coefficients |= {"displaced": displacement.counted, "displacement": displacement.rate}
        parts = {"heat": self.heat.solution, "memory": self.heat.memory, "coefficients": State(coefficients)}
        return State.joined(parts)

    @functools.cached_property
    def state(self) -> State:
        """All that the next step depends on."""
        numbers: dict[str, Numbers] = {"balance": self.heat.balance}
        if self.air_loop is not None:
            numbers["air_loop"] = self.air_loop
        return State(self.heated.functions | self.solution.functions, numbers)

    @functools.cached_property
    def mirror(self) -> Mirror:
        """What mirrors functions along the flow, where that reverses."""
        return Mirror(self.domain)

    def find_flow(self, solve: Callable[[], None], time: float) -> None:
        """Find the flow by `solve()`, at a blower's operating point where one drives it; raises `SolveError`."""
        if self.air_loop is None:
            solve()
            return
        began, tolerance = not self.flow.counts.solves, self.specs.flow.tolerance
        ways = iter([solve])

        def solve_again() -> None:
            next(ways, lambda: self.flow.renew(time, tolerance))()

        self.air_loop.find_point(solve_again, lambda: self.balances.mass_flow, time, tolerance)
        if began:  # what enters at the start
            self.air_loop.set_time(0.0)
            self.air_loop.update()

    def save(self) -> Saved:
        """The state, and what flow and heat keep beside it."""
        own, flow, heat = self.state.save(), self.flow.save(), self.heat.save()
        return Saved({"state": own.numbers, "flow": flow.numbers, "heat": heat.numbers}, own.arrays | flow.arrays)

    def restore(self, numbers: SavedNumbers, array_of: ArrayOf) -> None:
        """Go on from what `save()` gave."""
        self.flow.restore(numbers["flow"], array_of)
        self.heat.restore(numbers["heat"], array_of)
        self.state.restore(numbers["state"], array_of)

    def largest_difference_in_a_cell(self) -> float:
        """Of the fluid's temperature, K, among the bed's cells (collective)."""
        temperature = self.temperature
        cells = fenicsx.dof_table(temperature.function_space)[self.domain.cells(geometry.BED)]
        return ranks.largest_magnitude(self.communicator, np.ptp(temperature.x.array[cells], axis=1))

    def highest_mach_number(self) -> float:
        """Largest nodal |u|/c with the speed of sound of an ideal gas; 0 for a liquid (collective)."""
        fluid = self.specs.laws.fluid
        density = fluid.density
        if not density.compressible:
            return 0.0
        velocity = self.flow.fields()["velocity"].x.array.reshape(-1, self.domain.mesh.geometry.dim)
        fastest = ranks.largest_magnitude(self.communicator, np.linalg.norm(velocity, axis=1))
        temperature = float(self.medium.boundary.inlet_temperature.value)
        heat_capacity = fluid.heat_capacity(temperature)
        gas_constant = density.gas_constant  # type: ignore[union-attr]
        ratio = heat_capacity / (heat_capacity - gas_constant)
        return float(fastest / np.sqrt(ratio * gas_constant * temperature))
