"""The inlet's set-point as a programme of ramps and holds, [[operation.programme]]."""

from collections.abc import Sequence

from ..errors import InputError
from .keys import Table
from .series import TimeSeries


def series_of(programme: Sequence[Table], initial_temperature: float, where: str | None) -> TimeSeries:
    """Temperature (K) against time (s) of stages that each go `to` a temperature at a `rate` (K/s) or `over` a time (s), and then
    `hold` it (s); the first begins at the initial temperature.

    Raises `InputError` for a stage without a way, or with two.
    """
    times, values = [0.0], [initial_temperature]
    for number, stage in enumerate(programme, start=1):
        place = f"operation.programme[{number}]"
        if stage.to is None and (stage.rate is not None or stage.over is not None):
            raise InputError(f"{place}.to", None, "is missing", where)
        if stage.to is not None and (stage.rate is None) == (stage.over is None):
            raise InputError(place, None, "needs either a rate or a time over which it goes to its temperature", where)
        if stage.to is None and stage.hold is None:
            raise InputError(place, None, "must go to a temperature, or hold one", where)
        if stage.to is not None and (stage.to != values[-1] or stage.over is not None):
            duration = stage.over if stage.rate is None else abs(stage.to - values[-1]) / stage.rate
            times.append(times[-1] + duration)
            values.append(stage.to)
        if stage.hold is not None:
            times.append(times[-1] + stage.hold)
            values.append(values[-1])
    return TimeSeries(tuple(times), tuple(values))
