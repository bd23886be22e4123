"""The series of a scene as steps in time follow them: without the noise of fast loggers."""

import math
from collections.abc import Mapping

from .features import KEYS
from .features.targets import series_of
from .features.wall import LAYER
from .keys import Key, Table
from .scene import Scene
from .series import LITTLE, LITTLE_ALONE, TimeSeries


def with_thinned_series(scene: Scene) -> Scene:
    """A copy whose series are thinned up to the end of the run (`TimeSeries.thinned`), in proportion to `scale_of` each, by more
    where it is the only one that varies."""
    operation, wall = scene.operation, scene.wall
    varying = sum(len(series.times) > 1 for series in series_of(scene).values())
    little = LITTLE_ALONE if varying == 1 and not operation.phase else LITTLE
    end = math.inf if operation.phase else operation.end_time  # phases may last longer
    walls = {name: getattr(wall, name) for name in ("layer", "opposite_layer")}
    layers = {
        name: entries and [_thinned(one, LAYER, scene, end, little) for one in entries]
        for name, entries in walls.items()
    }
    return scene.with_tables(
        {"operation": _thinned(operation, KEYS["operation"], scene, end, little), "wall": wall.with_values(layers)}
    )


def _thinned(table: Table, keys: Mapping[str, Key], scene: Scene, end: float, little: float) -> Table:
    found = {}
    for name, series in table:
        if isinstance(series, TimeSeries):
            found[name] = series.thinned(end, scale_of(series, keys[name], scene), little)
    return table.with_values(found)


def scale_of(series: TimeSeries, key: Key, scene: Scene) -> float:
    """What changes of a series are small or large beside: of a temperature its largest distance from the initial one, else the
    largest magnitude (SI)."""
    reference = scene.operation.initial_temperature if key.kind == "K" else 0.0
    return max(abs(value - reference) for value in series.range)
