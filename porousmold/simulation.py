"""The march in time: flow and heat in turn, what is recorded, and when the wall is heated."""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from .discretisation import Discretisation
from .errors import SolveError
from .geometry import max_of
from .heating_time import crossing_time
from .solvers.flow import silent
from .solvers.time_control import TimeControl

MOST_SNAPSHOTS = 32


@dataclass
class History:
    """What is recorded at every step: columns by name, each a list; `units` by the same names."""

    columns: dict[str, list[float]] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)

    def add(self, **values_and_units):
        """Append one row: name=(value, unit)."""
        for name, (value, unit) in values_and_units.items():
            self.columns.setdefault(name, []).append(float(value))
            self.units[name] = unit

    def __getitem__(self, name):
        return self.columns[name]


class Simulation:
    """A scene on a communicator, marched in time by `march()`; `history`, `heating_time` and the rest tell how.

    `problem` is the `Discretisation`, `observe(text)` is told what is being done. Raises `InputError` like it.
    """

    def __init__(self, scene, communicator, observe=silent):
        self.scene, self._observe = scene, observe
        self.problem = Discretisation(scene, communicator, observe)
        self.control = self._time_control()
        self.heating_time = self.heating_time_bed_side = None
        self.time = 0.0
        self.history = History()
        self.snapshots: list[tuple[float, list[np.ndarray]]] = []
        self._snapshot_spacing = 0.0
        self._previous: list[np.ndarray] = []
        self._steps: list[float] = []
        self.regimes: list[str] = []
        self._last_flow: tuple[float, float, float] | None = None
        self._bounds = temperature_bounds(scene.operation)
        if (
            scene.model.rev_terms == "as-published"
        ):  # its pressure term drives flow across the openings: nothing is bounded
            self._bounds = -math.inf, math.inf

    def _time_control(self):
        solver, operation = self.scene.solver, self.scene.operation
        series = [s for s in vars(operation).values() if hasattr(s, "kinks")]
        return TimeControl(
            solver.first_step / solver.step_refinement,
            solver.step_growth ** (1.0 / solver.step_refinement),
            (solver.largest_step or min(self.problem.estimates.largest_step, operation.end_time))
            / solver.step_refinement,
            solver.step_tolerance,
            operation.end_time,
            tuple(sorted({kink for s in series for kink in s.kinks if kink > 0.0})),
        )

    def march(self, progress=lambda time, deficit: None, stop=lambda: False):
        """Heat until the whole wall is within the margin or the end time is reached.

        `progress(time, deficit)` is called after every step, `stop()` at every iteration of the flow: where it is true on any
        rank, all raise `KeyboardInterrupt` together. Raises `SolveError` when a solve fails for good. In both cases history,
        snapshots and balance stand at the last good step.
        """
        scene, operation, control = self.scene, self.scene.operation, self.control
        problem, flow, heat = self.problem, self.problem.flow, self.problem.heat

        def observe(text):
            self._observe(text)
            if problem.communicator.allreduce(bool(stop()), op=max_of):
                raise KeyboardInterrupt

        problem.observe_solvers(observe)
        observe("flow: initial guess")
        if not self.history.columns:  # else it goes on from a checkpoint
            with problem.stopwatch("flow"):
                flow.start()
                self.regimes = ["turbulent" if flow.is_turbulent() else "laminar"]
                if problem.is_also_laminar():
                    self.regimes.append("laminar")
            self._check_direction()
            self._record(0.0)
            self._keep_snapshot()
        while self.time < operation.end_time * (1 - 1e-12) and not self._heated_for_good():
            observe("")
            step = control.propose(self.time)
            old_balance = replace(heat.balance)
            before = [function.x.array.copy() for function in problem.memory]
            try:
                with problem.stopwatch("flow"):
                    self._foresee(step)
                    if scene.model.flow_update == "quasi-steady":
                        self._foresee_flow(step)
                        problem.flow.renew(self.time, scene.solver.flow_tolerance)
                with problem.stopwatch("energy"):
                    error = heat.step(self.time, step, after_jump=control.after_jump(self.time), bounds=self._bounds)
                self._check_direction()
            except KeyboardInterrupt:
                self._restore(before, old_balance)
                raise
            except SolveError as failure:
                self._restore(before, old_balance)
                control.reject_failed(step, failure)
                continue
            if not control.accept(self.time + step, step, error):
                self._restore(before, old_balance)
                continue
            self._previous, self._steps = before[: len(problem.functions)], [*self._steps[-1:], step]
            self.time += step
            self._record(step)
            self._keep_snapshot()
            progress(self.time, self.history["deficit_wall"][-1])
        return self

    def _heated_for_good(self):
        """Whether the wall is heated and the inlet's temperature has no change ahead."""
        last_change = max(self.scene.operation.inlet_temperature.kinks, default=0.0)
        return self.heating_time is not None and self.time >= last_change * (1 - 1e-12)

    def _restore(self, before, balance):
        for function, array in zip(self.problem.memory, before, strict=True):
            function.x.array[:] = array
        self.problem.heat.balance = balance
        self._set_boundary()

    def _set_boundary(self):
        """Give the boundary of the flow the values that the present flow was solved for, that of the heat those of now."""
        self.problem.boundary.set(self._flow_time())
        self.problem.boundary.set_heat(self.time)

    def _flow_time(self):
        """Time (s) that the present flow was solved for."""
        return {
            "frozen": 0.0,
            "quasi-steady": self.time - 0.5 * self._steps[-1] if self._steps else 0.0,
            "transient": self.time,
        }[self.scene.model.flow_update]

    def _foresee(self, step):
        """Take the step's coefficients at the temperature extrapolated to its middle, where they belong (second order)."""
        problem, operation = self.problem, self.scene.operation
        ahead = problem.heat.unknown.copy()
        if self._previous:
            ahead.x.array[:] += 0.5 * step / self._steps[-1] * (ahead.x.array - self._previous[0])
            low, high = operation.inlet_temperature.range
            low = min(low, self.history["lowest_temperature"][-1])
            high = max(high, self.history["highest_temperature"][-1])
            np.clip(ahead.x.array, low, high, out=ahead.x.array)
        problem.property_temperature.x.array[:] = problem.part_of_heat(ahead, 0).x.array
        if self.scene.model.flow_update == "quasi-steady":
            problem.flow_temperature.x.array[:] = problem.property_temperature.x.array
            problem.boundary.set(self.time + 0.5 * step)

    def _foresee_flow(self, step):
        """Start the flow's iterations from its course over the last two steps, at whose middles it was solved."""
        if len(self._steps) < 2 or self.control.after_jump(self.time - sum(self._steps)):
            return
        before = self._previous[len(self.problem.heat.functions) :]
        self.problem.flow.extrapolate(before, (step + self._steps[1]) / sum(self._steps))

    def _deficit(self, place):
        """Largest distance (K) of the place's temperatures from the inlet's, on the side they started from."""
        low, high = self.problem.extremes(place)
        inlet = self.scene.operation.inlet_temperature
        target = inlet(self.time)
        return target - low if inlet.values[-1] >= self.scene.operation.initial_temperature else high - target

    def _check_direction(self):
        mass_flow = self.problem.mass_flow
        if mass_flow < -1e-3 * self.problem.estimates.mass_flow:
            raise SolveError(
                "flow",
                self.time,
                f"it runs backwards, {mass_flow:.3g} kg/s",
                "a larger operation.pressure_drop, which must overcome operation.gravity",
            )

    def _at_end_of_step(self, mass_flow, pressure_drop):
        """Mass flow and pressure drop at the end of the last step: a flow solved for its middle goes on as it did between the
        last two middles, unless what drives it has a kink on the way."""
        now = (self._flow_time(), mass_flow, pressure_drop)
        before, self._last_flow = self._last_flow, now
        if now[0] == self.time or before is None or not 0.0 <= before[0] < now[0]:
            return mass_flow, pressure_drop
        if any(before[0] < kink < self.time for kink in self.control.kinks):
            return mass_flow, pressure_drop
        ahead = (self.time - now[0]) / (now[0] - before[0])
        return tuple(value + ahead * (value - old) for value, old in zip(now[1:], before[1:], strict=True))

    def _record(self, step):
        operation, balance = self.scene.operation, self.problem.heat.balance
        solved = self.problem.mass_flow
        outlet = self.problem.value(self.problem.outlet_heat) / solved if solved else float("nan")
        mass_flow, pressure_drop = self._at_end_of_step(solved, self.problem.pressure_drop)
        rows = {
            "time": (self.time, "s"),
            "step": (step, "s"),
            "inlet_temperature": (operation.inlet_temperature(self.time), "K"),
            "outlet_temperature": (outlet, "K"),
            "deficit_wall": (self._deficit("wall"), "K"),
            "deficit_bed_side": (self._deficit("bed_side"), "K"),
            "mass_flow": (mass_flow, "kg/s"),
            "pressure_drop": (pressure_drop, "Pa"),
            "heat_by_fluid": (balance.by_fluid, "J"),
            "heat_through_outer_wall": (balance.through_outer_wall, "J"),
            "heat_stored": (balance.stored, "J"),
            "heat_by_rev_terms": (balance.by_rev_terms, "J"),
        }
        bed, wall = self.problem.extremes("bed"), self.problem.extremes("wall")
        rows |= {"lowest_temperature": (min(bed[0], wall[0]), "K"), "highest_temperature": (max(bed[1], wall[1]), "K")}
        if self.problem.heat.bead_modes:
            rows["largest_bead_difference"] = (self.problem.heat.bead_modes.largest_difference(), "K")
        temperature = self.problem.temperature
        for kind, probe, names in (
            ("temperature", self.problem.stations, self.problem.station_names),
            ("sensor", self.problem.sensors, self.problem.sensor_names),
        ):
            rows |= {f"{kind}_{name}": (v, "K") for name, v in zip(names, probe(temperature)[:, 0], strict=True)}
        steepness = self.problem.sensors.steepness(temperature)
        rows |= {f"gradient_{name}": (v, "K/m") for name, v in zip(self.problem.sensor_names, steepness, strict=True)}
        self.history.add(**rows)
        if self.scene.model.wall == "fixed-temperature":
            return  # the wall's temperature is given: nothing to wait for
        margin, times = operation.heating_margin, self.history["time"]
        if self.heating_time is None:
            self.heating_time = crossing_time(times, self.history["deficit_wall"], margin)
        if self.heating_time_bed_side is None:
            self.heating_time_bed_side = crossing_time(times, self.history["deficit_bed_side"], margin)

    def memory(self):
        """Everything the march goes on from: numbers (ready for JSON), and arrays by name with their function space."""
        problem, flow, heat = self.problem, self.problem.flow, self.problem.heat
        factors = flow.factors()
        numbers = {
            "time": self.time,
            "steps": self._steps,
            "next_step": self.control.step,
            "rejected": self.control.rejected,
            "heating_time": self.heating_time,
            "heating_time_bed_side": self.heating_time_bed_side,
            "balance": vars(heat.balance),
            "regimes": self.regimes,
            "last_flow": self._last_flow,
            "columns": self.history.columns,
            "units": self.history.units,
            "snapshot_times": [time for time, _ in self.snapshots],
            "snapshot_spacing": self._snapshot_spacing,
            "counters": [[getattr(owner, name) for name in names] for owner, names in self._counters()],
            "constants_of_factors": factors[1] if factors else None,
        }
        fields = {f"memory/{i}": (f.function_space, f.x.array) for i, f in enumerate(problem.memory)}
        spaces = [function.function_space for function in problem.functions]
        for i, array in enumerate(self._previous):
            fields[f"previous/{i}"] = spaces[i], array
        for number, (_, state) in enumerate(self.snapshots):
            fields |= {f"snapshot/{number}/{i}": pair for i, pair in enumerate(zip(spaces, state, strict=True))}
        if factors:
            fields |= {f"factors/{i}": pair for i, pair in enumerate(factors[0])}
        return numbers, fields

    def recall(self, numbers, array_of):
        """Go on from what `memory()` gave; `array_of(name, space)` gives the local array of a name (collective)."""
        problem, flow = self.problem, self.problem.flow
        self.time, self._steps = numbers["time"], numbers["steps"]
        self.control.go_on_with(numbers["next_step"])
        self.control.rejected = numbers["rejected"]
        self.heating_time, self.heating_time_bed_side = numbers["heating_time"], numbers["heating_time_bed_side"]
        problem.heat.balance = type(problem.heat.balance)(**numbers["balance"])
        self.history = History(numbers["columns"], numbers["units"])
        self.regimes, self._last_flow = numbers["regimes"], numbers["last_flow"]
        self._snapshot_spacing = numbers["snapshot_spacing"]
        for (owner, names), values in zip(self._counters(), numbers["counters"], strict=True):
            for name, value in zip(names, values, strict=True):
                setattr(owner, name, value)
        spaces = [function.function_space for function in problem.functions]
        if self._steps:
            self._previous = [array_of(f"previous/{i}", space) for i, space in enumerate(spaces)]
        self.snapshots = [
            (time, [array_of(f"snapshot/{number}/{i}", space) for i, space in enumerate(spaces)])
            for number, time in enumerate(numbers["snapshot_times"])
        ]
        constants = numbers["constants_of_factors"]
        flow.recall_factors(lambda number, space: array_of(f"factors/{number}", space), constants)
        for number, function in enumerate(problem.memory):
            function.x.array[:] = array_of(f"memory/{number}", function.function_space)
        self._set_boundary()

    def _counters(self):
        heat = self.problem.heat
        return (
            (self.problem.flow, ("newton_iterations", "solves", "continuation_steps", "largest_undershoot")),
            (heat, ("newton_iterations", *(["repetitions"] if "repetitions" in vars(heat) else []))),
        )

    def _keep_snapshot(self):
        """Keep the fields of this time; beyond `MOST_SNAPSHOTS` every second goes and the spacing doubles."""
        finished = self._heated_for_good() or self.time >= self.scene.operation.end_time
        if self.snapshots and not finished and self.time < self.snapshots[-1][0] + self._snapshot_spacing:
            return
        self.snapshots.append((self.time, self.problem.state()))
        if len(self.snapshots) > MOST_SNAPSHOTS and not finished:
            self.snapshots = self.snapshots[::2]
            self._snapshot_spacing = max(2.0 * self._snapshot_spacing, self.time / MOST_SNAPSHOTS)


def temperature_bounds(operation):
    """Lowest and highest temperature (K) that a scene can reach: what is given, infinite where a heat flux is."""
    given = [operation.initial_temperature, *operation.inlet_temperature.range]
    if operation.ambient_temperature is not None:
        given += operation.ambient_temperature.range
    if operation.wall_temperature is not None:
        given += operation.wall_temperature.range
    low, high = min(given), max(given)
    if operation.outer_heat_flux is not None:
        least, most = operation.outer_heat_flux.range
        low, high = (-math.inf if least < 0.0 else low), (math.inf if most > 0.0 else high)
    return low, high
