"""What is recorded of an integration: the history's rows, the heating times, and snapshots of the fields."""

from ..output.quantities import Columns, Moment, row_of
from ..solvers.state import ArrayOf, Saved, SavedNumbers
from .heated_place import HeatedPlace
from .problem import Problem
from .snapshots import Snapshots
from .tool_energy import ToolEnergy


class Recorder:
    """Of a `problem`: its `history` with a row for every step; the times at which the wall was heated and the `targets` were met,
    None until then, of those to keep also where they were lost since (`first_met` keeps the first, `held_since` when those that
    hold began to); `snapshots`; and of an air supply the `tool_energy`."""

    def __init__(self, problem: Problem) -> None:
        self.problem, self._time, self._heat = problem, problem.specs.time, problem.specs.heat
        self._course, self._place = problem.specs.course, problem.specs.time.heated.place
        self.history = Columns()
        self.heating_time: float | None = None
        self.heating_time_bed_side: float | None = None
        self.targets: dict[str, float | None] = {target.name: None for target in self._time.targets}
        self.first_met, self.held_since = dict(self.targets), dict(self.targets)
        self.snapshots = Snapshots(problem)
        self.tool_energy = None if problem.air_loop is None else ToolEnergy(problem)
        layers = self._heat.all_layers
        self._has_sources = any(layer.heat_source is not None or layer.solid.cure is not None for layer in layers)
        self._last_flow: list[float] | None = None

    def record(self, time: float, step: float, flow_time: float) -> None:
        """Append the row of a time (s), at the end of a step (s); the flow is that of `flow_time` (collective)."""
        problem, sign = self.problem, self._direction(time)
        mass_flow, pressure_drop = self._at_end_of_step(time, flow_time)
        ends = problem.places.extreme_places("bed_side")
        of_nodes = {place: problem.places.extremes(place) for place in problem.places.names}
        extremes = of_nodes | {"bed": self._extremes_of_bed(of_nodes["bed"], time)}
        lows, highs = zip(*(of_nodes[place] for place in ("bed", "wall")), strict=True)
        waited_for, given = dict.fromkeys(("wall", "bed_side", self._place)), self._given_until(time)
        now = Moment(
            time=time,
            step=step,
            problem=problem,
            set_point=self._heat.inlet_temperature(time),
            mass_flow=sign * mass_flow,
            pressure_drop=sign * pressure_drop,
            extremes=extremes,
            nodal_range=(min(lows), max(highs)),
            deficits={place: self._deficit(*extremes[place], time, given) for place in waited_for},
            ends=ends if sign > 0 else (problem.domain.length - ends[0], problem.domain.length - ends[1]),
            at_places=self._at_places(time),
        )
        self.history.append(row_of(now))
        if self.tool_energy is not None:
            self.tool_energy.record()
        self._look_at_targets()
        if not self.problem.specs.waits_for_heat:
            return  # the wall's temperature is given, or its heat comes from elsewhere: nothing to wait for
        margin = self._time.heated.margin
        of_place, of_bed_side = (HeatedPlace(name, self._heat, margin) for name in (self._place, "bed_side"))
        self.heating_time = of_place.time(self.history, self.heating_time)
        self.heating_time_bed_side = of_bed_side.time(self.history, self.heating_time_bed_side)

    def _extremes_of_bed(self, of_nodes: tuple[float, float], time: float) -> tuple[float, float]:
        """Lowest and highest temperature (K) of the bed at a time (s); where beads move what enters is part of it, as cells that
        are longer than the exchange have no node of that temperature."""
        beads = self._heat.bead_motion.inlet_temperature
        entering = () if beads is None else (beads(time), self._heat.inlet_temperature(time))
        found = *of_nodes, *entering
        return min(found), max(found)

    def _look_at_targets(self) -> None:
        for target in self._time.targets:
            name, before = target.name, self.targets[target.name]
            since, time = self.held_since[name], self.history["time"][-1]
            began = since is None
            since = target.time(self.history) if since is None else target.time_with_next(self.history, since)
            if since is None:
                continue
            until = time if began else target.held_until(self.history)
            met = since + target.hold if before is not None or until >= since + target.hold else None
            if self.first_met[name] == before:
                self.first_met[name] = met
            if until < time and (target.keep or met is None):  # lost
                since = met = None
            self.targets[name], self.held_since[name] = met, since

    @property
    def reached(self) -> bool:
        """Whether all targets are met, or without targets the wall is heated."""
        return None not in self.targets.values() if self.targets else self.heating_time is not None

    @property
    def ended_at(self) -> float:
        """Time (s) of the answer that ended the run, which its last step has passed; else of the last row."""
        last, answered_at = self.history["time"][-2:], self.answered_at
        return answered_at if last[0] < answered_at else last[-1]

    @property
    def answered_at(self) -> float:
        """Time (s) of the answer: the last of the targets, or the heating time; without one, or in cycles, that of the end."""
        answers = list(self.targets.values()) or [self.heating_time]
        known = [one for one in answers if one is not None]
        is_answer = self.reached and not (self._course is not None and self._course.repeats)
        return max(known) if is_answer else self.history["time"][-1]

    def _direction(self, time: float) -> int:
        """1 where the fluid comes in at the inlet at a time (s), -1 where at the outlet."""
        return 1 if self._course is None else self._course.direction(time)

    def end_phase(self, number: int, time: float) -> None:
        """Keep the temperatures along the bed at the end (s) of a phase; the flow is another one from now on, so that nothing is
        extrapolated from before (collective)."""
        self._last_flow = None
        self.snapshots.end_phase(number, time)

    def _at_places(self, time: float) -> dict[str, dict[str, float]]:
        """Temperatures at the stations and at the sensors, and how steep they are there."""
        problem, temperature = self.problem, self.problem.temperature
        if self._direction(time) < 0:
            problem.mirror(temperature)
        return {
            "temperature": dict(zip(problem.station_names, problem.stations(temperature)[:, 0], strict=True)),
            "sensor": dict(zip(problem.sensor_names, problem.sensors(temperature)[:, 0], strict=True)),
            "gradient": dict(zip(problem.sensor_names, problem.sensors.steepness(temperature), strict=True)),
        }

    def _deficit(self, low: float, high: float, time: float, given: tuple[float, float] | None) -> float:
        """Largest distance (K) of a place's lowest and highest temperature (K) from the inlet's, on either side. Where heat from
        elsewhere may carry it beyond the inlet's, it is enough that all of it is as far from the start as what was `given`."""
        heat, target = self._heat, float(self._heat.inlet_temperature(time))
        distance = max(target - low, high - target)
        if given is None:
            return distance
        start, inlet = heat.initial_temperature, heat.inlet_temperature.values
        is_heated = max(inlet, key=lambda value: abs(value - start)) >= start
        return min(distance, given[1] - low if is_heated else high - given[0])

    def _given_until(self, time: float) -> tuple[float, float] | None:
        """Lowest and highest temperature (K) at the start and of the inlet up to a time (s); None where no heat comes from
        elsewhere."""
        heat = self._heat
        if heat.outer_wall.heat_flux is None and not self._has_sources:
            return None
        before = self.history["set_point"] if len(self.history) else ()
        given = (float(heat.inlet_temperature(time)), *heat.first_temperatures, *before)
        return min(given), max(given)

    def _at_end_of_step(self, time: float, flow_time: float) -> tuple[float, float]:
        """Mass flow and pressure drop at the end of the last step: a flow solved for its middle goes on as it did between the
        last two middles, unless what drives it has a breakpoint on the way."""
        now = [flow_time, self.problem.balances.mass_flow, self.problem.balances.pressure_drop]
        before, self._last_flow = self._last_flow, now
        if flow_time == time or before is None or not 0.0 <= before[0] < flow_time:
            return now[1], now[2]
        if any(before[0] < instant < time for instant in self._time.breakpoints):
            return now[1], now[2]
        ahead = (time - flow_time) / (flow_time - before[0])
        mass_flow, pressure_drop = (
            value + ahead * (value - old) for value, old in zip(now[1:], before[1:], strict=True)
        )
        return mass_flow, pressure_drop

    def save(self) -> Saved:
        """Everything recorded."""
        snapshots = self.snapshots.save()
        numbers = {
            "columns": self.history.columns,
            "heating_time": self.heating_time,
            "heating_time_bed_side": self.heating_time_bed_side,
            "targets": self.targets,
            "first_met": self.first_met,
            "held_since": self.held_since,
            "last_flow": self._last_flow,
            "snapshots": snapshots.numbers,
            "tool_energy": None if self.tool_energy is None else self.tool_energy.save(),
        }
        return Saved(numbers, snapshots.arrays)

    def restore(self, numbers: SavedNumbers, array_of: ArrayOf) -> None:
        """Go on from what `save()` gave."""
        self.history = Columns(numbers["columns"])
        self.heating_time, self.heating_time_bed_side = numbers["heating_time"], numbers["heating_time_bed_side"]
        self.targets |= numbers["targets"]
        self.first_met |= numbers["first_met"]
        self.held_since |= numbers["held_since"]
        self._last_flow = numbers["last_flow"]
        self.snapshots.restore(numbers["snapshots"], array_of)
        if self.tool_energy is not None:
            self.tool_energy.restore(numbers["tool_energy"])
