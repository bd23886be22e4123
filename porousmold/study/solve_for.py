"""Inverse problem: the value of a key with which a scene reaches a target, one key at a time.

For each key the root of ln(record/target) over ln(value) is enclosed from the scene's own value on, step by step up to a factor
`FARTHEST` or to where no scene can have the value, and found by Brent's method. What is reported is always a run. Temperatures of
the inlet count from the initial temperature, which drives everything.
"""

import json
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from scipy.optimize import brentq

from ..errors import InputError
from ..files.atomic_files import output_file
from ..files.units import preferred_unit, to_si
from ..scene.chosen_laws import Laws
from ..scene.features import KEYS
from ..scene.features.geometries import modelled_part
from ..scene.keys import WITHOUT_UNIT, key_of, kind_of, names_beside, unknown
from ..scene.scene import Scene
from .definition import Study, kind_of_record, unit_of_record
from .parameters import case_around, value_of
from .quantity import check_record
from .running import run_study

TOLERANCE = 0.003
"""Part of the target that a run may be off."""
FIRST_FACTOR, FARTHEST = 1.3, 10.0
FARTHEST_TEMPERATURE = 3.0
"""The same of a temperature beyond the initial one."""
WITHIN_BOUND = 1e-3
"""Part by which a value stays within a bound that it may not have itself."""
MOST_HALVINGS = 5
"""Of the way to a value that no scene can have."""
MOST_AWAY = 2
"""Runs in succession that lead away from the target, after which the search turns round."""
MOST_RUNS = 14
BESIDE = ("mean_power", "energy_spent")
"""Recorded of every run beside the target."""
TARGET = re.compile(r"\s*([\w .-]+?)\s*=\s*(.+?)\s*")


@dataclass(frozen=True)
class Aim:
    """The `record` that is to have a `value` (SI)."""

    record: str
    value: float


@dataclass(frozen=True)
class Change:
    """What a single key does: its `value` (SI) as the scene has it, the one `tried` that comes nearest to the target, the same as
    `needed` where it is met (None: `reason`), and what is `reached` with it, of which the run may have a `warning`."""

    key: str
    unit: str
    value: float
    tried: float
    needed: float | None
    reached: float | None
    beside: dict[str, float | None]
    reason: str = ""
    warning: str = ""


BESIDE_THE_INLET = tuple(f"operation.{name}_temperature" for name in ("ambient", "fresh", "return", "bead_inlet"))
"""Temperatures that may lie on either side of those of inlet and start."""


class _StoppedError(Exception):
    """The user stopped the search."""


def aim_of(text: str) -> Aim:
    """The aim of 'heating_time = 15 min' or 'targets.cured = 2 h'. Raises `InputError`."""
    match = TARGET.fullmatch(text)
    if match is None:
        raise InputError("--target", text, "must be RECORD = VALUE, such as 'heating_time = 15 min'")
    if unit_of_record(match.group(1)) is None:
        hint = "; of a target of the scene it is targets.NAME, such as 'targets.cured = 2 h'"
        raise InputError("--target", match.group(1), f"is nothing that a run records{hint}")
    value = to_si("--target", match.group(2), kind_of_record(match.group(1)))
    if not value > 0.0:
        raise InputError("--target", match.group(2), "must be > 0")
    return Aim(match.group(1), value)


def solve_for(
    scene: Scene,
    keys: Sequence[str],
    aim: Aim,
    out: Path,
    *,
    progress: Callable[[str, int], Any] = lambda key, runs: None,
    stop: Callable[[], bool] = lambda: False,
) -> list[Change] | None:
    """The `Change` of every key, those that reach the aim first (collective); None where it was stopped.

    Runs are kept in `out`, so that the same search goes on. Raises `InputError` for a key that is no positive number of the
    scene.
    """
    laws = Laws.of(scene)
    check_record(scene, aim.record, "--target")
    if unit_of_record(aim.record) == "s" and aim.value >= scene.operation.end_time:
        allowed = f"must be below operation.end_time {scene.operation.end_time:g} s, at which runs end"
        raise InputError("--target", aim.value, allowed, scene.source)
    searches = [_Search(scene, laws, key, aim, out, progress, stop) for key in keys]
    try:
        found = [search.found() for search in searches]
    except _StoppedError:
        return None
    return sorted(found, key=lambda change: change.needed is None)


class _NoAnswerError(Exception):
    """A run between two that have an answer has none."""


class _Search:
    """The search over one key."""

    def __init__(
        self,
        scene: Scene,
        laws: Laws,
        key: str,
        aim: Aim,
        out: Path,
        progress: Callable[[str, int], Any],
        stop: Callable[[], bool],
    ) -> None:
        self._scene, self._key, self._aim, self._out = scene, key, aim, out
        self._progress, self._stop = progress, stop
        try:
            described = key_of(KEYS, key)
        except KeyError:
            raise InputError("--key", key, unknown(key, names_beside(KEYS, key))) from None
        value = value_of(scene, laws, key) if described.kind not in WITHOUT_UNIT else None
        self._datum = _datum(scene, key) if described.kind == "K" else 0.0
        if scene.value(key) is None and value is None:
            allowed = f"is not set in the scene: give it a value to begin from, --set {key}='VALUE'"
            raise InputError("--key", key, allowed)
        if value is None or (value - self._datum == 0.0 and key not in BESIDE_THE_INLET):
            allowed = "must be a number of the scene that does not change in time, and not 0, or where the other temperatures are"
            raise InputError("--key", key, allowed)
        self._unit, self._value, self._kind = described.unit, value, described
        self._farthest = FARTHEST_TEMPERATURE if described.kind == "K" else FARTHEST
        self._span: float | None = None
        if key in BESIDE_THE_INLET:
            warm = max(scene.operation.inlet_temperature.values, key=lambda one: abs(one - self._datum))
            self._span, self._farthest = abs(warm - self._datum) / math.log(FARTHEST), FARTHEST
        self._rows: dict[float, Any] = {}
        self._refusal = ""

    def found(self) -> Change:
        """The change that the key makes."""
        here = self._excess(0.0)
        if abs(here) < TOLERANCE:
            return self._change(0.0)
        jumped = ""
        for side in self._towards_less_excess(here):
            last, at_last, place, away = 0.0, here, 0.0, 0
            halvings, end, refused = 0, self._end(side), math.inf
            while abs(place) < end * (1.0 - 1e-9) and len(self._rows) < MOST_RUNS:
                ahead = abs(place) + math.log(FIRST_FACTOR) * (1.0 if place == 0.0 else 1.6)
                place = side * min(ahead, end)
                excess = self._excess(place)
                while math.isnan(excess) and halvings < MOST_HALVINGS:
                    halvings, refused = halvings + 1, abs(place)
                    end = 0.5 * (abs(last) + refused)
                    place = side * end
                    excess = self._excess(place)
                if math.isnan(excess):
                    break
                if abs(excess) < TOLERANCE:
                    return self._change(place)
                if excess * at_last < 0.0:
                    change = self._between(last, place)
                    if change.needed is not None:
                        return change
                    jumped = change.reason  # the other side may have one
                    break
                away = away + 1 if abs(excess) > abs(at_last) else 0
                last, at_last = place, excess
                if away >= MOST_AWAY:
                    break
                if abs(place) >= end * (1.0 - 1e-9) and refused < math.inf and halvings < MOST_HALVINGS:
                    halvings, end = halvings + 1, 0.5 * (abs(place) + refused)
        nearest = min(self._rows, key=lambda place: abs(self._excess(place)) if self._known(place) else math.inf)
        searched = [place for place, row in self._rows.items() if row.status == "done"]
        (low, high), unit = preferred_unit([self._setting(f(searched)) for f in (min, max)], kind_of(KEYS, self._key))
        beyond = f"; beyond: {self._refusal}" if self._refusal and self._refusal != jumped else ""
        also = f"; {jumped}" if jumped else ""
        return self._change(nearest, f"not reached from {low:.4g} to {high:.4g} {unit}".rstrip() + also + beyond)

    def _end(self, side: float) -> float:
        """How far the search goes to one side: by its largest factor, or to the key's own bound."""
        end, from_datum = math.log(self._farthest), self._value - self._datum
        if self._span is not None:
            return end
        for bound in (self._kind.low, self._kind.high):
            if not math.isfinite(bound) or (bound - self._datum) / from_datum <= 0.0:
                continue
            away = side * math.log((bound - self._datum) / from_datum)
            if away >= 0.0:
                end = min(end, max(0.0, away - (0.0 if self._kind.closed else WITHIN_BOUND)))
        return end

    def _towards_less_excess(self, here: float) -> tuple[float, float]:
        """Both directions, that which brings the record nearer first."""
        first = math.log(FIRST_FACTOR)
        up, down = (self._excess(side * min(first, self._end(side))) for side in (1.0, -1.0))
        better = [abs(value) if not math.isnan(value) else math.inf for value in (up, down)]
        crosses = [value * here < 0.0 for value in (up, down)]
        return (1.0, -1.0) if crosses[0] or (better[0] <= better[1] and not crosses[1]) else (-1.0, 1.0)

    def _between(self, low: float, high: float) -> Change:
        """The root between two places."""

        def excess(place: float) -> float:
            value = self._excess(place)
            if math.isnan(value):
                raise _NoAnswerError
            return 0.0 if abs(value) < TOLERANCE else value

        try:
            place = float(brentq(excess, low, high, xtol=1e-4, maxiter=MOST_RUNS, disp=False))
        except _NoAnswerError:
            return self._change(low, self._refusal or "a run on the way has no answer")
        met = abs(self._excess(place)) < TOLERANCE
        if met:
            return self._change(place)
        (value,), unit = preferred_unit([self._setting(place)], kind_of(KEYS, self._key))
        return self._change(place, f"the answer jumps past it at {value:.4g} {unit}".rstrip())

    def _known(self, place: float) -> bool:
        return self._rows[place].values.get(self._aim.record) is not None

    def _setting(self, place: float) -> float:
        if self._span is not None:
            return float(f"{self._value + self._span * place:.6g}")
        return float(f"{self._datum + (self._value - self._datum) * math.exp(place):.6g}")

    def _excess(self, place: float) -> float:
        """ln(record/target) with the key's value times exp(place); NaN where no scene can have it, or it has no such record."""
        if place not in self._rows:
            value = self._setting(place)
            settings: dict[str, Any] = {"bed.allow_small_ratio": self._scene.bed.allow_small_ratio}
            settings |= {} if place == 0.0 else {self._key: value}
            case = case_around(self._scene, "as given" if place == 0.0 else f"{self._key}={value:.6g}", settings)
            study = Study([case], [], [self._aim.record, *BESIDE])
            rows = run_study(study, self._out, progress=self._progress(self._key, len(self._rows)), stop=self._stop)
            if rows[0].status == "missing":
                raise _StoppedError
            self._rows[place] = rows[0]
            self._refusal = rows[0].reason if rows[0].status != "done" else self._refusal
        found = self._rows[place].values.get(self._aim.record)
        if found is None and self._rows[place].status == "done" and unit_of_record(self._aim.record) == "s":
            found = self._scene.operation.end_time * 2.0  # not reached: later than the end
        return math.log(found / self._aim.value) if found else math.nan

    def _change(self, place: float, reason: str = "") -> Change:
        row = self._rows[place]
        reached = row.values.get(self._aim.record)
        needed = self._setting(place) if not reason else None
        beside = {name: row.values.get(name) for name in BESIDE}
        warning = row.reason if row.status == "done" and reached is not None else ""
        return Change(
            self._key, self._unit, self._value, self._setting(place), needed, reached, beside, reason, warning
        )


def _datum(scene: Scene, key: str) -> float:
    """Temperature (K) from which another one is varied: the initial one, itself from the inlet's."""
    operation = scene.operation
    is_initial = key == "operation.initial_temperature" and operation.inlet_temperature is not None
    return float(operation.inlet_temperature.values[-1] if is_initial else operation.initial_temperature)


def summary_text(found: Sequence[Change], aim: Aim, scene: Scene) -> str:
    """Which single change reaches the aim, as a table."""
    reached = [change.reached for change in found]
    (aimed, *reached), unit = preferred_unit([aim.value, *reached], kind_of_record(aim.record))
    lines = [f"{aim.record} = {aimed:.6g} {unit}".rstrip() + " by a single change of"]
    for change, value in zip(found, reached, strict=True):
        if change.needed is None:
            (tried,), sign = preferred_unit([change.tried], kind_of(KEYS, change.key))
            nearest = f"; nearest {value:.5g} {unit} with {tried:.4g} {sign}".rstrip() if value is not None else ""
            lines.append(f"  {change.key:32s} none found: {change.reason}{nearest}")
            continue
        power = change.beside["mean_power"]
        cost = f", mean power {power / 1e3:.3g} kW" if power is not None else ""
        (now, needed), sign = preferred_unit([change.value, change.needed], kind_of(KEYS, change.key))
        lines.append(f"  {change.key:32s} {now:.6g} -> {needed:.6g} {sign}".rstrip() + f": {value:.5g} {unit}{cost}")
        lines += [f"    {change.warning}"] if change.warning else []
    if any(change.needed is not None for change in found):
        lines.append(f"power of {modelled_part(dict(scene.geometry))}")
    return "\n".join(lines)


def write(found: Sequence[Change], aim: Aim, out: Path) -> Path:
    """solve_for.json; gives its path."""
    target = asdict(aim) | {"unit": unit_of_record(aim.record) or ""}
    content = {"target": target, "changes": [asdict(change) for change in found]}
    with output_file(out / "solve_for.json") as temporary:
        temporary.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    return out / "solve_for.json"
