"""Flow that reverses and rests, and phases that repeat: [[operation.phase]], a drive that changes its sign in time, or one that
comes from both ends in turn (`operation.reversal_period`).

A positive drive pushes the fluid from the inlet to the outlet, a negative one back; at zero the bed rests. What enters through
the outlet has a temperature of its own: that of the phase, or `operation.return_temperature`.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

from ...errors import InputError
from ..keys import Key, Table
from ..series import ProfileSeries, TimeSeries
from .drive import DRIVES, drive_keys
from .feature import Feature, key

if TYPE_CHECKING:
    from ..scene import Scene

Side = Literal["above", "below"]
ENDS: tuple[Side, ...] = ("above", "below")
MOST_REVERSALS = 10_000
"""Up to the end of a run, each of which takes several steps."""

PHASE: Mapping[str, Key] = {
    "name": Key("text", "name of the phase in results"),
    **{name: replace(one, series=False) for name, one in drive_keys().items()},
    "temperature": Key("K", "of the fluid that enters, from whichever end", low=0.0, high=5000.0),
    "duration": Key("s", "after which the phase ends", low=0.0, high=1e9),
    "until_outlet_above": Key("K", "the phase ends when the fluid that leaves is as warm", low=0.0, high=5000.0),
    "until_outlet_below": Key("K", "the phase ends when the fluid that leaves is as cold", low=0.0, high=5000.0),
}


@dataclass(frozen=True, kw_only=True)
class Reversal(Feature):
    """Flow from both ends in turn, and phases."""

    return_temperature: TimeSeries | None = key(
        "operation.return_temperature",
        "K",
        "of the fluid that enters at the outlet, where the drive of the flow gets negative",
        low=0.0,
        high=5000.0,
        series=True,
    )
    period: float | None = key(
        "operation.reversal_period",
        "s",
        "the flow comes from both ends in turn, so long from each, with the same drive and temperature",
        low=0.0,
        high=1e9,
    )
    phases: Sequence[Table] | None = key(
        "operation.phase",
        "list",
        "phases of a run (charge, rest, discharge), one after the other, instead of a drive and inlet_temperature",
        entries=PHASE,
    )
    cycles: int = key(
        "operation.cycles",
        "integer",
        "times that the phases are gone through, at most",
        1,
        low=1,
        high=10000,
        closed=True,
    )
    cycle_tolerance: float | None = key(
        "operation.cycle_tolerance",
        "",
        "relative change of the heat of every phase from one cycle to the next below which the state is periodic and the run "
        "ends",
        low=0.0,
        high=1.0,
    )

    def check(self, scene: "Scene") -> None:
        """Refuse phases without a drive, an end or a temperature, and reversal where it is not to be had."""
        check_phases(scene)


@dataclass(frozen=True)
class Phase:
    """A part of a run with one direction of flow: `sign` 1, -1, or 0 where it rests. `drive` is the magnitude of what drives the
    flow, `temperature` (K) that of the entering fluid, both against the time of the run. The phase ends after `duration` (s), or
    before that where the fluid that leaves gets beyond `limit` (K), "above" or "below"."""

    name: str
    sign: int
    drive: TimeSeries
    temperature: TimeSeries
    duration: float = math.inf
    side: Side | None = None
    limit: float = 0.0


def has_phases(scene: "Scene") -> bool:
    """Whether the run consists of [[operation.phase]]."""
    return scene.operation.phase is not None


def reverses(scene: "Scene") -> bool:
    """Whether the flow comes from the outlet at some time."""
    return any(phase.sign < 0 for phase in phases_of(scene))


def phases_of(scene: "Scene") -> tuple[Phase, ...]:
    """The phases of a scene, once through; none where the flow keeps its direction all the time."""
    operation = scene.operation
    if operation.phase is not None:
        return tuple(_of_table(number, phase, scene) for number, phase in enumerate(operation.phase, start=1))
    drive = drive_of(scene)
    back = operation.return_temperature or operation.inlet_temperature
    if operation.reversal_period is not None:
        given = (TimeSeries.constant(0.0) if drive is None else drive), operation.inlet_temperature
        return tuple(
            Phase(name, sign, *given, operation.reversal_period) for name, sign in (("forward", 1), ("back", -1))
        )
    if drive is None or min(drive.values) >= 0.0:
        return ()
    return tuple(_pieces(drive, operation.inlet_temperature, back))


def drive_of(scene: "Scene") -> TimeSeries | None:
    """The series of what drives the flow, None with a blower or phases."""
    return next((value for name in DRIVES if (value := getattr(scene.operation, name)) is not None), None)


def drive_name(phases: Sequence[Table]) -> str | None:
    """The key of the drive of all phases; None where there is none."""
    return next((name for phase in phases for name in DRIVES if getattr(phase, name) is not None), None)


def representative(phases: Sequence[Table], initial: float) -> dict[str, TimeSeries]:
    """What stands for `operation.inlet_temperature` and the drive where only their values count: those farthest from the start
    come last."""
    warm = sorted({p.temperature for p in phases if p.temperature is not None}, key=lambda value: abs(value - initial))
    name = drive_name(phases)
    strong = sorted({abs(getattr(p, name) or 0.0) for p in phases}) if name else []
    found = {"inlet_temperature": _values(warm or [initial])}
    return found | ({name: _values(strong)} if name else {})


def _values(values: Sequence[float]) -> TimeSeries:
    return TimeSeries(tuple(float(number) for number in range(len(values))), tuple(values), corners=())


def _of_table(number: int, phase: Table, scene: "Scene") -> Phase:
    name = drive_name(scene.operation.phase)
    strength = (getattr(phase, name) if name else None) or 0.0
    side = next((side for side in ENDS if getattr(phase, f"until_outlet_{side}") is not None), None)
    temperature = phase.temperature
    if temperature is None:  # nothing enters
        temperature = scene.operation.inlet_temperature.values[-1]
    return Phase(
        phase.name or f"phase {number}",
        _sign(strength),
        TimeSeries.constant(abs(strength)),
        TimeSeries.constant(temperature),
        math.inf if phase.duration is None else phase.duration,
        side,
        0.0 if side is None else getattr(phase, f"until_outlet_{side}"),
    )


def _pieces(drive: TimeSeries, forward: TimeSeries, back: TimeSeries) -> list[Phase]:
    """The phases of a drive that changes its sign, from one zero crossing to the next; the last one goes on."""
    times, values = list(drive.times), list(drive.values)
    points = [(times[0], values[0])]
    for (t0, v0), (t1, v1) in pairwise(zip(times, values, strict=True)):
        if v0 * v1 < 0.0:
            points.append((t0 + (t1 - t0) * v0 / (v0 - v1), 0.0))
        points.append((t1, v1))
    signs = [_sign(a[1] + b[1]) for a, b in pairwise(points)]
    pieces: list[list[tuple[float, float]]] = []
    kinds: list[int] = []
    for sign, (first, following) in zip(signs, pairwise(points), strict=True):
        if not kinds or sign != kinds[-1]:
            pieces.append([first])
            kinds.append(sign)
        pieces[-1].append(following)
    begun, phases = 0.0, []
    for number, (sign, piece) in enumerate(zip(kinds, pieces, strict=True), start=1):
        end = math.inf if number == len(pieces) else piece[-1][0]
        name = {1: "forward", 0: "rest", -1: "back"}[sign]
        course = TimeSeries(tuple(t for t, _ in piece), tuple(abs(v) for _, v in piece))
        phases.append(Phase(name, sign, course, back if sign < 0 else forward, end - begun))
        begun = end
    return phases


def _sign(value: float) -> int:
    return (value > 0.0) - (value < 0.0)


def check_phases(scene: "Scene") -> None:
    """Refuse (`InputError`) phases without a drive, an end or a temperature, and reversal where it is not to be had."""
    operation = scene.operation
    if operation.phase is not None:
        _check_table(scene)
    elif operation.cycles != 1 or operation.cycle_tolerance is not None:
        name = "cycles" if operation.cycles != 1 else "cycle_tolerance"
        raise InputError(f"operation.{name}", getattr(operation, name), "needs [[operation.phase]]", scene.source)
    if operation.reversal_period is not None:
        _check_period(scene)
    drive = drive_of(scene)
    if drive is not None and len(drive.values) == 1 and drive.values[0] < 0.0:
        return  # refused as such
    if not phases_of(scene):
        if operation.return_temperature is not None:
            allowed = "has no meaning: the flow never comes from the outlet"
            raise InputError("operation.return_temperature", None, allowed, scene.source)
        return
    _check_models(scene)
    if not reverses(scene):
        return
    if operation.phase is None and operation.return_temperature is None and operation.reversal_period is None:
        allowed = "is missing: the flow reverses, and what then enters at the outlet has a temperature"
        raise InputError("operation.return_temperature", None, allowed, scene.source)
    if scene.geometry.kind == "mesh":
        allowed = "must be a straight bed (mold, pipe) where the flow reverses"
        raise InputError("geometry.kind", scene.geometry.kind, allowed, scene.source)
    if operation.gravity:
        allowed = "must be 0 where the flow reverses: buoyancy would turn with it"
        raise InputError("operation.gravity", operation.gravity, allowed, scene.source)


def _check_models(scene: "Scene") -> None:
    operation = scene.operation
    if scene.model.flow_update != "quasi-steady":
        allowed = "must be 'quasi-steady' where the flow reverses or has phases"
        raise InputError("model.flow_update", scene.model.flow_update, allowed, scene.source)
    if operation.bead_velocity:
        allowed = "must be 0 where the flow reverses or has phases"
        raise InputError("operation.bead_velocity", operation.bead_velocity, allowed, scene.source)
    for name in ("heater_power", "recirculation"):
        if getattr(operation, name) is not None and operation.reversal_period is None:
            allowed = "has no place where the flow reverses or has phases"
            raise InputError(f"operation.{name}", None, allowed, scene.source)
    flux = operation.outer_heat_flux
    if isinstance(flux, ProfileSeries) and reverses(scene):
        allowed = "must not change along the flow where that reverses"
        raise InputError("operation.outer_heat_flux", flux.source, allowed, scene.source)


def _check_period(scene: "Scene") -> None:
    operation = scene.operation
    if operation.phase is not None:
        allowed = "cannot be combined with [[operation.phase]]"
        raise InputError("operation.reversal_period", operation.reversal_period, allowed, scene.source)
    if operation.return_temperature is not None:
        allowed = "has no place beside operation.reversal_period: the same fluid comes from both ends"
        raise InputError("operation.return_temperature", None, allowed, scene.source)
    drive, period = drive_of(scene), operation.reversal_period
    if drive is not None and min(drive.values) < 0.0:
        allowed = "cannot be combined with a drive that changes its sign"
        raise InputError("operation.reversal_period", period, allowed, scene.source)
    if operation.end_time > MOST_REVERSALS * period:
        allowed = f"makes more than {MOST_REVERSALS} reversals up to operation.end_time {operation.end_time:g} s"
        raise InputError("operation.reversal_period", period, allowed, scene.source)


def _check_table(scene: "Scene") -> None:
    operation, where = scene.operation, scene.source
    for other in ("inlet_temperature", "programme", "return_temperature", "blower", "blower_pressure", *DRIVES):
        if scene.is_given(f"operation.{other}"):
            raise InputError(f"operation.{other}", None, "cannot be combined with [[operation.phase]]", where)
    name = drive_name(operation.phase)
    if name is None:
        allowed = f"one of {', '.join(DRIVES)} must be given for a phase at least"
        raise InputError("operation.phase", None, allowed, where)
    for number, phase in enumerate(operation.phase, start=1):
        place = f"operation.phase[{number}]"
        for other in DRIVES:
            if other != name and getattr(phase, other) is not None:
                raise InputError(f"{place}.{other}", None, f"must be {name}, as of the other phases", where)
        if getattr(phase, name) and phase.temperature is None:
            raise InputError(f"{place}.temperature", None, "is missing: the temperature of what enters", where)
        ends = [side for side in ENDS if getattr(phase, f"until_outlet_{side}") is not None]
        if len(ends) == 2:
            raise InputError(f"{place}.until_outlet_below", None, "cannot be combined with until_outlet_above", where)
        if ends and not getattr(phase, name):
            allowed = "needs a flow: without one nothing leaves"
            raise InputError(f"{place}.until_outlet_{ends[0]}", None, allowed, where)
        if ends:
            _check_limit(scene, place, ends[0], getattr(phase, f"until_outlet_{ends[0]}"))
        if not ends and phase.duration is None:
            raise InputError(f"{place}.duration", None, "is missing, and so is until_outlet_above or _below", where)


def _check_limit(scene: "Scene", place: str, side: Side, limit: float) -> None:
    """Refuse an outlet temperature that nothing given in the scene can bring about."""
    operation = scene.operation
    sources = (
        any(layer.heat_source is not None for layer in scene.layers.values()) or operation.outer_heat_flux is not None
    )
    given = [phase.temperature for phase in operation.phase if phase.temperature is not None]
    given += scene.start.range if scene.start is not None else [operation.initial_temperature]
    given += [] if operation.ambient_temperature is None else operation.ambient_temperature.values
    is_far = limit >= max(given) if side == "above" else limit <= min(given)
    if is_far and not sources:
        extreme = (
            f"{'hotter' if side == 'above' else 'colder'} than {max(given) if side == 'above' else min(given):.6g} K"
        )
        raise InputError(f"{place}.until_outlet_{side}", limit, f"is never reached: nothing is {extreme}", scene.source)
