"""What a run waits for: a heated place, or targets; and when it ends at the latest."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from ..keys import Key, Table
from ..series import TimeSeries
from .feature import Feature, key
from .sensors import sensor_names
from .wall import RESERVED_PLACES, WITHOUT_OUTSIDE, cures, name_of

if TYPE_CHECKING:
    from ..scene import Scene

Asked = Literal["within", "above", "below", "spread", "cured"]
ASKED: tuple[Asked, ...] = ("within", "above", "below", "spread", "cured")
"""What a target may ask for."""
TARGET: Mapping[str, Key] = {
    "name": Key("text", "name of the target in results"),
    "place": Key("text", "wall, bed_side, bed, or the name of a layer or a sensor", "wall"),
    "within": Key("delta_degC", "largest difference from the set-point farthest from the start", low=0.0, high=1000.0),
    "above": Key("K", "all of the place above this temperature", low=0.0, high=5000.0),
    "below": Key("K", "all of the place below this temperature", low=0.0, high=5000.0),
    "spread": Key(
        "delta_degC",
        "largest temperature difference within the place, from half-way to the set-point on; where that is the initial "
        "temperature, once the place has been farther from it than this",
        low=0.0,
        high=1000.0,
    ),
    "keep": Key(
        "flag",
        "it is met only as long as it holds: the run goes on until all such targets hold at once, until the last change of "
        "what is given has come through, and where the flow has phases or reverses, through a whole cycle",
        False,
    ),
    "hold": Key("s", "it is met once it has held for so long without a break; not of a cure", low=0.0, high=1e9),
    "cured": Key("", "least degree of cure of a layer", low=0.0, high=1.0),
}


@dataclass(frozen=True, kw_only=True)
class Heated(Feature):
    """The place whose heating time is sought: all of it within `margin` (K) of the inlet's temperature; `end_time` (s)."""

    place: str = key(
        "operation.heated_place",
        "text",
        "what the heating time is of: wall (all of it; of an insulated bed the fluid beside it), bed_side, bed (fluid and "
        "beads), or the name of a layer",
        "wall",
    )
    margin: float = key(
        "operation.heating_margin",
        "delta_degC",
        "that place is heated when all of it is within this of T_in",
        2.0,
        low=0.0,
        high=1000.0,
    )
    end_time: float = key(
        "operation.end_time",
        "s",
        "maximum simulated time, if the wall is not heated before; if not set, a steady state, too, ends the run",
        1e5,
        low=0.0,
        high=1e9,
    )

    def check(self, scene: "Scene") -> None:
        """There is such a place, no series begins when the run is over or ends before it, and there is something to heat or to
        cool."""
        known = [*RESERVED_PLACES, *map(name_of, scene.layers.values())]
        if self.place not in known:
            scene.refuse("operation.heated_place", f"must be one of {', '.join(known)}")
        for name, series in series_of(scene).items():
            begins = series.times[0]
            if len(series.times) > 1 and begins >= self.end_time:
                allowed = (
                    f"begins at {begins:.10g} s, after the run's end at {self.end_time:g} s: let its times count from the "
                    'run\'s start, or give { file = "...", time_offset = "first" }'
                )
                scene.refuse(name, allowed, value=series.source)
            if len(series.times) > 1 and series.times[-1] <= 0.0:
                allowed = (
                    f"ends at {series.times[-1]:.10g} s, and the run starts at 0 s: give a smaller time_offset, or "
                    '{ file = "...", time_offset = "first" }'
                )
                scene.refuse(name, allowed, value=series.source)
        self._check_differences(scene)

    def _check_differences(self, scene: "Scene") -> None:
        operation = scene.operation
        if _is_heated_otherwise(scene):
            return
        first = (operation.initial_temperature,) if scene.start is None else scene.start.range
        difference = max(abs(value - one) for value in operation.inlet_temperature.values for one in first)
        if difference == 0.0:
            allowed = "is operation.initial_temperature: there is nothing to heat or to cool"
            scene.refuse("operation.inlet_temperature", allowed, value=operation.initial_temperature)
        if self.margin >= difference:
            allowed = f"must be < {difference:g} K, the difference of inlet and initial temperature"
            scene.refuse("operation.heating_margin", allowed)


@dataclass(frozen=True, kw_only=True)
class Targets(Feature):
    """What is asked of places."""

    targets: Sequence[Table] | None = key(
        "target.list",
        "list",
        "targets of the run, [[target]]; it continues until all are met, or to operation.end_time",
        entries=TARGET,
    )

    def check(self, scene: "Scene") -> None:
        """Each asks one thing of a place that there is, by a name of its own."""
        layers = {name_of(layer): layer for layer in scene.layers.values()}
        places, sensors = [*RESERVED_PLACES, *layers], sensor_names(scene.geometry.sensors)
        known = [*places, *sensors]
        names: list[str] = []
        for number, target in enumerate(self.targets or (), start=1):
            name = f"target[{number}]"
            asked = [one for one in ASKED if getattr(target, one) is not None]
            if len(asked) != 1:
                scene.refuse(name, f"needs exactly one of {', '.join(ASKED)}", value=None)
            if target.place not in known:
                scene.refuse(f"{name}.place", f"must be one of {', '.join(known)}")
            if scene.model.wall in WITHOUT_OUTSIDE and target.place == "wall":
                scene.refuse(f"{name}.place", f"has no place with model.wall {scene.model.wall!r}")
            if asked == ["spread"] and target.place in sensors and target.place not in places:
                scene.refuse(f"{name}.spread", "needs a place of more than one point: a sensor has no spread")
            if asked == ["cured"]:
                is_plain = target.place == "wall" and not scene.wall.layer
                material = scene.wall.material if is_plain else getattr(layers.get(target.place), "material", None)
                if not cures(scene, material):
                    scene.refuse(f"{name}.place", "must be the name of a layer whose material cures")
            if target.hold is not None and asked == ["cured"]:
                scene.refuse(f"{name}.hold", "has no meaning with cured: a degree of cure is never lost")
            if target.hold is not None and target.hold >= scene.operation.end_time:
                scene.refuse(f"{name}.hold", f"must be below operation.end_time {scene.operation.end_time:g} s")
            if target_name(target) in names:
                scene.refuse(f"{name}.name", "must be a name of its own", value=target_name(target))
            names.append(target_name(target))


def asked_of(target: Table) -> Asked:
    """What a target asks for."""
    return next(name for name in ASKED if getattr(target, name) is not None)


def target_name(target: Table) -> str:
    """The name of a target, by default of its place and what it asks for."""
    return target.name or f"{target.place} {asked_of(target)}"


def series_of(scene: "Scene") -> dict[str, TimeSeries]:
    """Every `TimeSeries` of a scene's operation and of its layers' heat sources, by the name of its key."""
    found = {f"operation.{name}": value for name, value in scene.operation if isinstance(value, TimeSeries)}
    sources = {f"{place}.heat_source": layer.heat_source for place, layer in scene.layers.items()}
    return found | {name: source for name, source in sources.items() if isinstance(source, TimeSeries)}


def _is_heated_otherwise(scene: "Scene") -> bool:
    """Whether heat comes from elsewhere than with the fluid: beads, wall, surroundings or sources."""
    operation, layers = scene.operation, scene.layers.values()
    others = (
        *(operation.ambient_temperature, operation.wall_temperature, operation.bead_inlet_temperature),
        operation.return_temperature,
    )
    values = [value for series in others if series is not None for value in series.values]
    return (
        any(value != operation.initial_temperature for value in values)
        or operation.outer_heat_flux is not None
        or any(layer.heat_source is not None or cures(scene, layer.material) for layer in layers)
        or (not scene.wall.layer and cures(scene, scene.wall.material))
    )
