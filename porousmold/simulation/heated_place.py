"""When a place has come within the margin of the inlet's temperature."""

import math
from dataclasses import dataclass

from ..output.quantities import Columns
from .heating_time import crossing_time
from .specs import HeatSpec


@dataclass(frozen=True)
class HeatedPlace:
    """A place of a history, by its `name`, that is heated within a `margin` (K)."""

    name: str
    heat: HeatSpec
    margin: float

    def time(self, history: Columns, before: float | None) -> float | None:
        """Time (s) at which it came within the margin, `before` as far as it is known.

        An inlet temperature that only passes the wall's on its way, as from one set point to the next, heats nothing: the place
        has to stay within the margin up to the next breakpoint of the inlet's temperature. Nor does noise about the temperature
        at the start. A place that follows a ramp within the margin comes within that of its last set point.
        """
        times, deficits, margin = history["time"], history[f"deficit_{self.name}"], self.margin
        if before is None:
            crossed = crossing_time(times, deficits, margin)
            if crossed is not None:
                return crossed if self._has_left_the_start(history) else None
            return self._followed(history) if deficits[-1] <= margin else None
        ahead = [one for one in self.heat.inlet_temperature.breakpoints if one >= before]
        is_lost = deficits[-1] > margin and times[-1] <= min(ahead, default=-math.inf) * (1.0 + 1e-12)
        return None if is_lost else before

    def _has_left_the_start(self, history: Columns) -> bool:
        """Whether the inlet is farther than the margin from the temperature at the start, or the place has been."""
        low, high = self.heat.first_temperatures
        present = self.heat.inlet_temperature(history["time"][-1])
        coldest, hottest = min(history[f"lowest_{self.name}"]), max(history[f"highest_{self.name}"])
        return (
            max(abs(present - low), abs(present - high)) > self.margin
            or coldest < low - self.margin
            or hottest > high + self.margin
        )

    def _followed(self, history: Columns) -> float | None:
        """When (s) the place, now within the margin of the last set point, came there; None before that is set."""
        times, inlet, margin = history["time"], self.heat.inlet_temperature, self.margin
        last = max(inlet.breakpoints, default=math.inf)
        if times[-1] < last:
            return None
        final = inlet(times[-1])
        lows, highs = (history[f"{end}_{self.name}"] for end in ("lowest", "highest"))
        deficits = [max(final - low, high - final) for low, high in zip(lows, highs, strict=True)]
        rows = (row for row in range(len(times), 1, -1) if deficits[row - 2] > margin >= deficits[row - 1])
        row = next(rows, None)
        return None if row is None else crossing_time(times[:row], deficits[:row], margin)
