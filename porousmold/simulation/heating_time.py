"""When a quantity comes within a margin: the heating time, and the times of targets."""

import math
from collections.abc import Sequence

from scipy.optimize import brentq

SMOOTH = 0.9
"""Relative change of the slope from step to step up to which a course has no corner."""


def crossing_time(times: Sequence[float], deficits: Sequence[float], margin: float) -> float | None:
    """Time (s) at which a deficit, as |T_in - T_wall| (K), falls below `margin`, inside the last step; None if it did not.

    `times` and `deficits` are the run's so far, the last step's end included. Interpolated by the parabola through the last three
    points of ln(deficit), which is nearly straight while a body approaches its bath, or of the deficit itself where that is
    straighter, as it is where a given heat flux warms a body, or not positive; linearly where there are two points.
    """
    if len(times) < 2 or not deficits[-1] < margin <= deficits[-2]:
        return None
    curves = _curves(deficits[-3:], margin)
    return root_in_last_step(times[-3:], min(curves, key=lambda curve: _bend(times[-3:], curve)))


def with_the_next(times: Sequence[float], deficits: Sequence[float], margin: float) -> float | None:
    """Time (s) at which a deficit falls below `margin` between the second and the third of four times, by the cubic through all
    of them, of the deficit or its logarithm as in `crossing_time`; None where it does not, or where the course has a corner."""
    from scipy.interpolate import KroghInterpolator  # takes a while to import

    if not deficits[2] < margin <= deficits[1]:
        return None
    curve = min(_curves(deficits, margin), key=lambda values: _sharpest(times, values))
    if _sharpest(times, curve) > SMOOTH:
        return None
    return float(brentq(KroghInterpolator(times, curve), *times[1:3], xtol=1e-10))


def root_in_last_step(times: Sequence[float], values: Sequence[float]) -> float:
    """Where values at two or three times (s) pass through 0 between the last two: by the line or parabola through them. Where
    they do not, but for rounding, the time of the one that is nearer to 0."""
    start, end = times[-2:]
    before, after = values[-2:]
    if before * after >= 0.0:
        return start if abs(before) <= abs(after) else end
    slope = (after - before) / (end - start)
    curvature = (slope - _slope(times, values)) / (end - times[0]) if len(times) > 2 else 0.0

    def interpolated(time: float) -> float:
        return before + (slope + curvature * (time - end)) * (time - start)

    return float(brentq(interpolated, start, end, xtol=1e-10))


def _curves(deficits: Sequence[float], margin: float) -> list[list[float]]:
    """What passes through 0 where the deficits pass the margin: the difference, and of positive ones that of their logarithms."""
    curves = [[value - margin for value in deficits]]
    if min(deficits) > 0.0:
        curves.append([math.log(value / margin) for value in deficits])
    return curves


def _sharpest(times: Sequence[float], values: Sequence[float]) -> float:
    """The larger bend of four values."""
    return max(_bend(times[n : n + 3], values[n : n + 3]) for n in (0, 1))


def _slope(times: Sequence[float], values: Sequence[float]) -> float:
    """Of the first two of some values (1/s)."""
    return (values[1] - values[0]) / (times[1] - times[0])


def _bend(times: Sequence[float], values: Sequence[float]) -> float:
    """Relative change of the slope of three values, 0 of fewer."""
    if len(values) < 3:
        return 0.0
    slopes = _slope(times, values), _slope(times[1:], values[1:])
    return abs(slopes[1] - slopes[0]) / max(abs(slopes[0]), abs(slopes[1]), 1e-300)
