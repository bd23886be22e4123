"""Targets of a run: a place within some kelvins of the inlet, above or below a temperature, uniform, or cured.

Every target is a quantity that falls below a margin; when it does so is interpolated as the heating time is. Hot and cold ends of
the run serve as the reference, from which the quantities fall off nearly exponentially where heat comes with the flow.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..scene.features.sensors import sensor_names
from ..scene.features.targets import Asked, asked_of, target_name
from ..scene.features.wall import RESERVED_PLACES, name_of
from ..scene.scene import Scene
from .heating_time import crossing_time, root_in_last_step, with_the_next

HALF_WAY = 0.5
"""Of the way from the initial to the inlet temperature, from which on a spread counts: at the start every place is even."""
LEAST_MARGIN = 1.0
"""Kelvin between a limit and the reference that it is seen from."""
SAME = 1e-9
"""Part of the margin that rounding may exceed it by."""


class Rows(Protocol):
    """Columns of the history by name."""

    def __getitem__(self, name: str) -> Sequence[float]:
        """A column."""


@dataclass(frozen=True, kw_only=True)
class Target:
    """`place` is to be, by `asks`, "within" `limit` (K) of the inlet's set-point, "above" or "below" it (K), in a "spread" of at
    most as much (K), or "cured" to that degree.

    `initial` (K) is the temperature that the run starts from, `final` (K) the set-point that is farthest from it: of a programme
    that cools down again the hottest; `hottest` and `coldest` (K) are its ends. What lies between the initial temperature and
    those counts as "below", or "above", only after it was passed. One to `keep` is met only as long as it holds, one with `hold`
    (s) once it has held for so long. Between steps the `heat` of a place that melts is interpolated, not its temperature, which
    halts: a thin wall of wax came to 63 °C 37 % too soon within a step that began below the 60 °C at which it melts.
    """

    name: str
    place: str
    asks: Asked
    limit: float
    initial: float
    final: float
    hottest: float = -math.inf
    coldest: float = math.inf
    is_sensor: bool = False
    keep: bool = False
    hold: float = 0.0
    heat: Callable[[float], float] | None = None

    @property
    def meaning(self) -> str:
        """What it asks for, in words."""
        place, limit = self.place.replace("_", " "), self.limit
        inlet = (
            "the inlet"
            if self.hottest == self.coldest
            else f"{self.final - 273.15:.4g} °C, the set-point farthest from the start"
        )
        words = {
            "within": f"{place} within {limit:g} K of {inlet}",
            "above": f"{place} above {limit - 273.15:g} °C",
            "below": f"{place} below {limit - 273.15:g} °C",
            "spread": f"{place} even to {limit:g} K",
            "cured": f"{place} cured to {limit:g}",
        }[self.asks]
        return f"{words} for {self.hold / 60.0:.4g} min" if self.hold else words

    @property
    def change_needed(self) -> float:
        """By how much (K) its place changes until it is met: from the start, of what is gone through twice from the far end;
        infinite where no temperature is asked for, or one that is there from the start."""
        way = 0.0
        if self.asks == "within":
            way = abs(self.final - self.initial) - self.limit
        elif self.asks == "below":
            way = (max(self.hottest, self.limit) if self.initial < self.limit else self.initial) - self.limit
        elif self.asks == "above":
            way = self.limit - (min(self.coldest, self.limit) if self.initial > self.limit else self.initial)
        return way if way > 0.0 else math.inf

    @property
    def _hot(self) -> float:
        return max(self.initial, self.final, self.limit + LEAST_MARGIN)

    @property
    def _cold(self) -> float:
        return min(self.initial, self.final, self.limit - LEAST_MARGIN)

    @property
    def margin(self) -> float:
        """What the quantity is to fall below."""
        margins = {"above": self._hot - self.limit, "below": self.limit - self._cold, "cured": 1.0 - self.limit}
        return margins.get(self.asks, self.limit)

    def quantity(self, history: Rows, row: int) -> float:
        """What is to fall below the margin, in a row of the history."""
        value = self.course(history, row)
        if self.asks != "spread" or self.is_under_way(history, row):
            return value
        return max(value, 2.0 * self.limit)

    def course(self, history: Rows, row: int) -> float:
        """The same without the jump of a spread that begins to count, to be interpolated."""
        if self.asks == "cured":
            return 1.0 - history[f"cure_{self.place}"][row]
        low, high = (history[column][row] for column in self._columns)
        if self.asks == "above":
            return self._hot - low
        if self.asks == "below":
            return high - self._cold
        if self.asks == "within":
            return max(self.final - low, high - self.final)
        return high - low

    def _curve(self, history: Rows, row: int) -> float:
        """What is interpolated of it."""
        return self._on_curve(self.course(history, row))

    def _on_curve(self, course: float) -> float:
        """The heat (J/kg) that a value of the course, or the margin, means where the place melts."""
        if self.heat is None or self.asks in ("spread", "cured"):
            return course
        rises = self.asks == "above" or (self.asks == "within" and self.final >= self.initial)
        reference = {"above": self._hot, "below": self._cold}.get(self.asks, self.final)
        sign = -1.0 if rises else 1.0
        return float(sign * (self.heat(reference + sign * course) - self.heat(reference)))

    def is_under_way(self, history: Rows, row: int) -> bool:
        """Whether the place has been half-way to the set-point by a row of the history; where that is the temperature at the
        start, whether it has been farther from it than the limit."""
        return any(self.way_gone(history, one) > 1.0 for one in range(row + 1))

    def way_gone(self, history: Rows, row: int) -> float:
        """What the place has come of that way in a row of the history."""
        low, high = (history[column][row] for column in self._columns)
        if self.final == self.initial:
            return max(abs(low - self.initial), abs(high - self.initial)) / self.limit
        return (0.5 * (low + high) - self.initial) / (self.final - self.initial) / HALF_WAY

    def time(self, history: Rows) -> float | None:
        """When it was first met (s) in the last step of the history, None where that was not then."""
        rows, times = len(history["time"]), history["time"][-3:]
        courses = [self._curve(history, row) for row in range(max(0, rows - 3), rows)]
        if not self.was_passed(history):
            return None
        if len(courses) == 1:
            return 0.0 if self.quantity(history, 0) < self.margin else None
        crossing = crossing_time(times, courses, self._on_curve(self.margin))
        if self.asks != "spread" or self.is_under_way(history, rows - 2):
            return crossing
        if not self.is_under_way(history, rows - 1):
            return None
        begins = root_in_last_step(times, [self.way_gone(history, row) - 1.0 for row in range(rows - len(times), rows)])
        if crossing is not None:
            return max(begins, crossing)
        return begins if courses[-1] < self.margin else None

    def time_with_next(self, history: Rows, met: float) -> float:
        """The same of one that was `met` (s) in the step before the last, with what has come since."""
        times, rows = history["time"][-4:], len(history["time"])
        if len(times) < 4 or not times[1] < met <= times[2]:
            return met
        if self.asks == "spread" and not self.is_under_way(history, rows - 3):
            return met
        curve = [self._curve(history, row) for row in range(rows - 4, rows)]
        better = with_the_next(times, curve, self._on_curve(self.margin))
        return met if better is None else better

    def holds(self, history: Rows, row: int) -> bool:
        """Whether it holds in a row of the history, after it was met."""
        return self.quantity(history, row) <= self.margin * (1.0 + SAME)

    def held_until(self, history: Rows) -> float:
        """Until when it held (s), after it did in the row before the last one."""
        last = len(history["time"]) - 1
        return history["time"][last] if self.holds(history, last) else self.crossing(history, last, falls=False)

    def crossing(self, history: Rows, row: int, *, falls: bool) -> float:
        """When the course passed the margin before a row (s), with the row that follows where there is one."""
        sign, first = 1.0 if falls else -1.0, max(0, row - 2)
        times, margin = history["time"][first : row + 2], sign * self._on_curve(self.margin)
        courses = [sign * self._curve(history, one) for one in range(first, first + len(times))]
        better = with_the_next(times, courses, margin) if len(times) == 4 else None
        if better is not None:
            return better
        last = row + 1 - first
        return root_in_last_step(times[:last], [one - margin for one in courses[:last]])

    def was_passed(self, history: Rows) -> bool:
        """Whether the place has been on the other side of a limit that the run goes through twice."""
        return any(self.is_beyond(history, row) for row in range(len(history["time"])))

    def is_beyond(self, history: Rows, row: int) -> bool:
        """Whether the place is on the other side of such a limit in a row, or there is none."""
        if self.asks == "below" and self.initial < self.limit < max(self.final, self.hottest):
            return history[self._columns[1]][row] > self.limit
        if self.asks == "above" and min(self.final, self.coldest) < self.limit < self.initial:
            return history[self._columns[0]][row] < self.limit
        return True

    @property
    def _columns(self) -> tuple[str, str]:
        """Columns of the place's lowest and highest temperature."""
        kinds = ("sensor", "sensor") if self.is_sensor else ("lowest", "highest")
        return f"{kinds[0]}_{self.place}", f"{kinds[1]}_{self.place}"


def targets_of(scene: Scene, heats: Mapping[str, Callable[[float], float]]) -> tuple[Target, ...]:
    """Those of a scene, with the `heats` (J/kg, of a temperature) of places that melt."""
    initial, sensors = scene.operation.initial_temperature, sensor_names(scene.geometry.sensors)
    final = max(scene.operation.inlet_temperature.values, key=lambda value: abs(value - initial))
    others = (*RESERVED_PLACES, *map(name_of, scene.layers.values()))
    return tuple(
        Target(
            name=target_name(target),
            place=target.place,
            asks=asked_of(target),
            limit=getattr(target, asked_of(target)),
            is_sensor=target.place in sensors and target.place not in others,
            initial=initial,
            final=final,
            hottest=max(scene.operation.inlet_temperature.values),
            coldest=min(scene.operation.inlet_temperature.values),
            keep=target.keep,
            hold=target.hold or 0.0,
            heat=heats.get(target.place),
        )
        for target in scene.target.list or ()
    )


def highest_until_met(times: Sequence[float], highest: Sequence[float], met: Iterable[float | None]) -> float:
    """Largest of the values `highest` of a run; where all its targets are `met` (s; None where not), up to the last one and not
    to the end of the last step."""
    instants = list(met)
    until = times[-1] if None in instants else max((time for time in instants if time is not None), default=times[-1])
    values = (value for time, value in zip(times, highest, strict=True) if time <= until)
    return max(float(np.interp(until, times, highest)), *values)
