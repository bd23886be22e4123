"""What a run writes."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from .feature import Feature, key

if TYPE_CHECKING:
    from ..scene import Scene

MOST_TIMES = 2000
"""Of output that may be asked for."""


@dataclass(frozen=True, kw_only=True)
class Output(Feature):
    """Fields at `field_times` times, or at given `times` (s) together with profiles along the bed; pictures; a checkpoint every
    `checkpoint_interval` s of the clock."""

    title: str | None = key(
        "output.title", "line", "title of the report, by default the geometry and the folder's name"
    )
    pictures: bool = key("output.pictures", "flag", "draw the PNG pictures", True)
    fields: bool = key("output.fields", "flag", "write fields.h5 and fields.xdmf", True)
    checkpoint_interval: float = key(
        "output.checkpoint_interval",
        "s",
        "minimum wall-clock time between checkpoints, for --resume",
        30.0,
        low=0.0,
        high=1e7,
        closed=True,
    )
    field_times: int = key(
        "output.field_times",
        "integer",
        "number of snapshots of the fields, evenly spread over the run as it turns out",
        4,
        low=1,
        high=1000,
        closed=True,
    )
    times: tuple[float, ...] | None = key(
        "output.times",
        "times",
        "times of the fields, in place of field_times, and of profiles along the bed (profiles.csv); steps end there",
    )
    every: float | None = key("output.every", "s", "the same every so often", low=0.0, high=1e9)

    def check(self, scene: "Scene") -> None:
        """Times are given in one way."""
        if self.every is not None and self.times is not None:
            scene.refuse("output.every", "cannot be combined with output.times")

    def with_times(self, scene: "Scene") -> "Output":
        """With the `times` that `every` makes up to the scene's end. Raises `InputError` where these are too many."""
        if self.every is None:
            return self
        count = int(scene.operation.end_time / self.every)
        if count > MOST_TIMES:
            end = scene.operation.end_time
            cure = "make it longer, or operation.end_time shorter"
            allowed = f"makes {count} times up to operation.end_time {end:g} s, may make {MOST_TIMES}; {cure}"
            scene.refuse("output.every", allowed)
        return replace(self, times=tuple(self.every * number for number in range(1, count + 1)))
