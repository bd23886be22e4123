"""What a study file says: a base scene, what changes for all cases, what varies, and what is recorded."""

import difflib
import hashlib
import itertools
import json
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..files.tables import read_toml
from ..files.units import COLDEST_WITHOUT_UNIT, given_in_si
from ..scene.features import KEYS
from ..scene.features.targets import target_name
from ..scene.keys import LISTED, Settings, Tables, key_of, names_beside, unknown
from ..scene.scene import Scene
from ..scene.tables import LISTS

DESIGNS = ("grid", "one-at-a-time", "cases")
RECORDS = {
    "heating_time": "s", "heating_time_bed_side": "s", "heating_time_error": "1", "end_time": "s",
    "mass_flow_initial": "kg/s", "mass_flow_final": "kg/s",
    "pressure_drop_initial": "Pa", "pressure_drop_final": "Pa", "mass_imbalance": "1", "energy_imbalance": "1",
    "heat_by_fluid": "J", "heat_stored": "J",
    "fluid_heat": "J", "pumping_work": "J", "energy_spent": "J", "mean_power": "W",
    "energy.spent": "J", "energy.heater": "J", "energy.blower": "J", "energy.peak_power": "W", "energy.cost": "1",
    "spread_at_end": "K",
    "last_cycle.heat_in": "J", "last_cycle.heat_out": "J", "last_cycle.heat_lost": "J", "last_cycle.pumping_work": "J",
    "last_cycle.energy_efficiency": "1", "last_cycle.exergy_efficiency": "1", "last_cycle.utilisation": "1",
    "time_steps": "1", "rejected_steps": "1", "bead_biot_number": "1", "bead_reynolds_number": "1",
    "unknowns.flow": "1", "unknowns.energy": "1", "wall_seconds.total": "s", "wall_seconds.flow": "s", "wall_seconds.energy": "s",
}  # fmt: skip
"""What can be recorded of a run (entries of result.json) and in which unit."""
LONGEST_NAME = 120


def unit_of_record(name: str) -> str | None:
    """Unit of what can be recorded of a run, also of "targets.NAME", the time of a target; None for what is not."""
    for prefix, unit in (("targets.", "s"), ("target_errors.", "1")):
        if name.startswith(prefix) and len(name) > len(prefix):
            return unit
    return RECORDS.get(name)


def kind_of_record(name: str) -> str:
    """The same as `files.units` reads and shows it: temperatures that are recorded are differences, and 1 has no unit."""
    unit = unit_of_record(name) or ""
    return {"K": "delta_degC", "1": ""}.get(unit, unit)


OF_EVERY_CASE = {"output.pictures": False, "output.fields": False, "solver.refine_in_doubt": False}
"""Settings: nothing that no one looks at, and the same cells and steps for all, as small differences count."""


@dataclass(frozen=True)
class Case:
    """One run of a study: `settings` {'table.key': value} on top of those for all cases; `name` is its folder's."""

    name: str
    settings: Settings
    scene: Scene | None
    reason: str | None = None
    """Why there is no scene, in one line."""


@dataclass(frozen=True)
class Study:
    """A study as it is run: its cases in order, and what to record of each."""

    cases: list[Case]
    varied: list[str]
    record: list[str] = field(default_factory=lambda: ["heating_time"])
    base: Path = Path()
    common: Settings = field(default_factory=dict)
    allow_extensions: bool = False
    """The base scene's file, the settings for all cases and whether its extensions may run, of which `case` makes more."""

    def case(self, settings: Settings) -> Case:
        """A case of this study with other settings {'table.key': value}."""
        return _case(settings, self.base, self.common, self.allow_extensions)

    def with_cases(self, cases: Sequence[Case]) -> "Study":
        """This study with other cases."""
        return replace(self, cases=cases)

    @classmethod
    def load(cls, path: str | Path, *, allow_extensions: bool = False) -> "Study":
        """Read a study file. Raises `InputError` naming the key for anything that is unknown or impossible; a combination
        of values that no scene can have is no such error, but a case with a reason."""
        path = Path(path)
        tables = read_toml("study", path)
        where = str(path)
        check_names(tables, ("study", "set", "vary", "case", "optimum"), "", where)
        head = table_of(tables, "study", where)
        check_names(head, ("scene", "design", "record"), "study.", where)
        scene_path = head.get("scene")
        if not isinstance(scene_path, str):
            raise InputError("study.scene", scene_path, "must name the base scene's file", where)
        design = head.get("design", "grid")
        if design not in DESIGNS:
            raise InputError("study.design", design, f"must be one of {', '.join(map(repr, DESIGNS))}", where)
        record = head.get("record")
        if record is not None and (not isinstance(record, list) or not record):
            raise InputError("study.record", record, "must be a list of names", where)
        for name in record or []:
            if not isinstance(name, str) or unit_of_record(name) is None:
                allowed = f"must be of {', '.join(RECORDS)}, or targets.NAME"
                raise InputError("study.record", str(name), allowed, where)
        base = path.parent / scene_path
        common = OF_EVERY_CASE | _settings(table_of(tables, "set", where), "set", where)
        targets = target_names(Scene.load(base, common, allow_extensions=allow_extensions))
        record = record or [f"targets.{name}" for name in targets] or ["heating_time"]
        combinations = _combinations(design, tables, where)
        cases = [_case(settings, base, common, allow_extensions) for settings in combinations]
        _make_unique(cases, where)
        _check_targets(cases, record, where)
        varied = list(dict.fromkeys(name for settings in combinations for name in settings))
        return cls(cases, varied, list(dict.fromkeys(record)), base, common, allow_extensions)


def table_of(tables: Tables, name: str, where: str) -> dict[str, Any]:
    """The table of a name, empty where there is none."""
    content = tables.get(name, {})
    if not isinstance(content, dict):
        raise InputError(name, str(content), "must be a table", where)
    return content


def check_names(table: Iterable[str], known: Collection[str], prefix: str, where: str) -> None:
    """Refuse (`InputError`) a name that is not known."""
    for name in table:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"; did you mean {near[0]!r}?" if near else f" (known: {', '.join(known)})"
            raise InputError(f"{prefix}{name}", None, f"is not a known key{hint}", where)


def _settings(table: Tables, place: str, where: str) -> Settings:
    """{'table.key': value} from the nested tables that TOML makes of dotted keys, and from keys that are quoted."""
    settings: Settings = {}
    for group, content in table.items():
        quoted, _, name = group.partition(".")
        if name in KEYS.get(quoted, ()):
            settings[group] = content
            continue
        if LISTED.fullmatch(group):
            try:
                key_of(KEYS, group)
            except KeyError:
                raise InputError(f"{place}.{group}", None, unknown(group, names_beside(KEYS, group)), where) from None
            settings[group] = content
            continue
        if group in LISTS and isinstance(content, list):
            settings[group] = content
            continue
        entries = content if isinstance(content, dict) else {}
        if group not in KEYS or not isinstance(content, dict):
            known = [f"{g}.{key}" for g, keys in KEYS.items() for key in keys]
            near = difflib.get_close_matches(group, known, n=1)
            raise InputError(f"{place}.{group}", None if isinstance(content, dict) else str(content),
                             "is not a key of a scene" + (f"; did you mean {near[0]!r}?" if near else ""), where)  # fmt: skip
        check_names(entries, tuple(KEYS[group]), f"{place}.{group}.", where)
        settings |= {f"{group}.{name}": value for name, value in entries.items()}
    return settings


def _combinations(design: str, tables: Tables, where: str) -> list[Settings]:
    if design == "cases":
        if "vary" in tables:
            raise InputError("vary", None, "has no place with design 'cases'", where)
        listed = tables.get("case", [])
        if not isinstance(listed, list) or not listed or not all(isinstance(entry, dict) for entry in listed):
            raise InputError("case", None, "must be given as [[case]] tables with design 'cases'", where)
        return [_settings(entry, "case", where) for entry in listed]
    if "case" in tables:
        raise InputError("case", None, f"has no place with design {design!r}", where)
    varied = {
        name: _values(f"vary.{name}", name, given, where)
        for name, given in _settings(table_of(tables, "vary", where), "vary", where).items()
    }
    if not varied:
        raise InputError("vary", None, "must name at least one key of the scene with its values", where)
    if design == "grid":
        return [dict(zip(varied, values, strict=True)) for values in itertools.product(*varied.values())]
    return [{name: value} for name, values in varied.items() for value in values]


def _values(place: str, name: str, given: object, where: str) -> list[Any]:
    """A list of values, or a range {from, to, count, spacing} of them in SI."""
    if isinstance(given, dict):
        check_names(given, ("from", "to", "count", "spacing"), f"{place}.", where)
        kind = key_of(KEYS, name).kind
        if kind in ("choice", "integer", "flag", "file"):
            raise InputError(place, None, "must be a list: it has no range", where)
        ends = [given_in_si(f"{place}.{end}", given.get(end), kind, where) for end in ("from", "to")]
        count, spacing = given.get("count"), given.get("spacing", "linear")
        if isinstance(count, bool) or not isinstance(count, int) or not 2 <= count <= 10_000:
            raise InputError(f"{place}.count", count, "must be a whole number from 2 to 10000", where)
        if spacing not in ("linear", "geometric"):
            raise InputError(f"{place}.spacing", str(spacing), "must be 'linear' or 'geometric'", where)
        if spacing == "geometric" and min(ends) <= 0.0:
            raise InputError(f"{place}.spacing", spacing, "needs positive ends", where)
        first, last = ends
        points = np.linspace(first, last, count) if spacing == "linear" else np.geomspace(first, last, count)
        return [with_units({name: float(f"{point:.12g}")})[name] for point in points]
    if not isinstance(given, list) or not given:
        raise InputError(place, str(given), "must be a list of values, or a range {from, to, count, spacing}", where)
    return given


def _case(settings: Settings, base: Path, common: Settings, allow_extensions: bool) -> Case:
    parts = [f"{name}={value}" for name, value in settings.items()]
    text = ",".join(parts).replace(" ", "_") or "base"
    name = re.sub(r"[^A-Za-z0-9_.,=+-]+", "_", text)
    if name != text or len(name) > LONGEST_NAME:  # "500 µm" and "500 m" are to be two
        digest = hashlib.sha256(",".join(parts).encode()).hexdigest()[:12]
        name = f"{name[: LONGEST_NAME - 13]}-{digest}"
    try:
        return Case(name, settings, Scene.load(base, common | settings, allow_extensions=allow_extensions))
    except InputError as error:
        return Case(name, settings, None, str(error))


def with_units(settings: Mapping[str, object]) -> Settings:
    """Settings that the program has made: temperatures that need a unit, as they are cold, with it."""
    return {
        name: f"{float(value)!r} K"
        if isinstance(value, float) and value < COLDEST_WITHOUT_UNIT and key_of(KEYS, name).kind == "K"
        else value
        for name, value in settings.items()
    }


def target_names(scene: Scene) -> list[str]:
    """Names of the targets of a scene."""
    return [target_name(target) for target in scene.target.list or ()]


def _check_targets(cases: Sequence[Case], record: Iterable[str], where: str) -> None:
    """Refuse a target that no case has."""
    known = {name for case in cases if case.scene is not None for name in target_names(case.scene)}
    for name in record:
        if name.startswith("targets.") and name.removeprefix("targets.") not in known:
            allowed = f"is no target of any case: they have {', '.join(sorted(known)) or 'no [[target]]'}"
            raise InputError("study.record", name, allowed, where)


def _make_unique(cases: list[Case], where: str) -> None:
    seen: dict[str, Case] = {}
    for case in cases:
        if case.name in seen:
            raise InputError("study", json.dumps(case.settings, default=str), "is there twice", where)
        seen[case.name] = case
