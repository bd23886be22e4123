"""The heating time: when the wall's worst point comes within a margin of the inlet temperature."""

import math
from collections.abc import Sequence

from scipy.optimize import brentq


def crossing_time(times: Sequence[float], deficits: Sequence[float], margin: float) -> float | None:
    """Time (s) at which the deficit |T_in - T_wall| (K) falls below `margin`, inside the last step; None if it did not.

    `times` and `deficits` are the run's so far, the last step's end included. Interpolated by the parabola through
    the last three points of ln(deficit), which is nearly straight while a body approaches its bath; linearly where
    there are no three positive points.
    """
    if len(times) < 2 or not deficits[-1] < margin <= deficits[-2]:
        return None
    if len(times) < 3 or min(deficits[-3:]) <= 0.0:
        fraction = (deficits[-2] - margin) / (deficits[-2] - deficits[-1])
        return times[-2] + fraction * (times[-1] - times[-2])
    logarithms = [math.log(value / margin) for value in deficits[-3:]]

    def parabola(time: float) -> float:
        t0, t1, t2 = times[-3:]
        return (
            logarithms[0] * (time - t1) * (time - t2) / ((t0 - t1) * (t0 - t2))
            + logarithms[1] * (time - t0) * (time - t2) / ((t1 - t0) * (t1 - t2))
            + logarithms[2] * (time - t0) * (time - t1) / ((t2 - t0) * (t2 - t1))
        )

    return times[-2] if logarithms[1] == 0.0 else float(brentq(parabola, times[-2], times[-1], xtol=1e-10))
