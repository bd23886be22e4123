r"""The best parameters within bounds, under a limit on energy or power, and the trade-off between the two.

A study's grid is run first. Through the logarithms of its results goes a radial basis function (thin-plate spline with a
linear part) of the parameters, each logarithmic where all its values are positive; on that scipy's SLSQP finds the minimum
under the limits. The minimum is then run, and joins the grid for the next search, until what is predicted and what is run
agree to `AGREEMENT`. Runs that do not reach what they wait for are none of the surface, and the search keeps away from them by
halves. What is reported is always a run, never the interpolation. The trade-off curve is the same search under a
row of limits, from the least that can be had to what the free minimum takes.
"""

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.optimize import minimize

from ..arrays import Floats
from ..errors import InputError
from ..files.atomic_files import output_file
from ..files.tables import read_toml
from ..files.units import preferred_unit, to_si
from ..mpi import MPI
from ..scene.features import KEYS
from ..scene.keys import key_of, kind_of
from .definition import Case, Study, check_names, kind_of_record, table_of, unit_of_record, with_units
from .quantity import check_record
from .running import Row, run_study, setting

AGREEMENT = 0.003
MOST_ROUNDS = 6
TRADE_OFF_POINTS = 7
TRADE_OFF_ROUNDS = 2
DIGITS = 4
"""Digits of the values that are tried."""


@dataclass(frozen=True)
class Aim:
    """What a study's table [optimum] asks for: the record to minimise, limits (SI) by record, the other one of the trade-off."""

    minimise: str
    below: dict[str, float]
    trade_off: str | None


@dataclass(frozen=True)
class Optimum:
    """The best run: its row, the best row for every limit of the trade-off, and whether the search came to agreement."""

    row: Row | None
    trade_off: list[Row]
    agreed: bool


def load(path: str | Path, *, allow_extensions: bool = False) -> tuple[Study, Aim]:
    """The `Study` and `Aim` of a file. Raises `InputError` naming the key for anything impossible."""
    path = Path(path)
    study, where = Study.load(path, allow_extensions=allow_extensions), str(path)
    head = table_of(read_toml("study", path), "optimum", where)
    check_names(head, ("minimise", "below", "trade_off"), "optimum.", where)
    default = "heating_time" if "heating_time" in study.record else study.record[0]
    minimise, below, trade_off = head.get("minimise", default), head.get("below", {}), head.get("trade_off")
    if not isinstance(below, dict):
        raise InputError(
            "optimum.below", str(below), "must be a table of limits, such as { fluid_heat = '3 MJ' }", where
        )
    for name, given in below.items():
        if isinstance(given, dict):
            quoted = f'"{name}.{next(iter(given), "")}"'
            raise InputError(
                f"optimum.below.{name}", str(given), f"a name with a point stands in quotes: {quoted} = ...", where
            )
    scene = next((case.scene for case in study.cases if case.scene is not None), None)
    for key, name in [("minimise", minimise), ("trade_off", trade_off), *(("below", name) for name in below)]:
        if name not in study.record and not (key == "trade_off" and name is None):
            raise InputError(f"optimum.{key}", str(name), f"must be one of study.record {study.record}", where)
        if scene is not None and name is not None:
            check_record(scene, name, f"optimum.{key}")
    limits = {name: to_si(f"optimum.below.{name}", given, kind_of_record(name), where) for name, given in below.items()}
    for name, limit in limits.items():
        if not limit > 0.0:
            raise InputError(f"optimum.below.{name}", limit, "must be > 0", where)
    if trade_off == minimise:
        raise InputError("optimum.trade_off", trade_off, "must be another record than optimum.minimise", where)
    for name in study.varied:
        values = {setting(case, name) for case in study.cases if case.scene is not None}
        if (
            key_of(KEYS, name).kind in ("integer", "flag", "choice", "file")
            or len(values) < 3
            or not all(isinstance(value, int | float) for value in values)
        ):
            raise InputError(f"vary.{name}", None, "must have three numbers at least to search between them", where)
    return study, Aim(minimise, limits, trade_off)


class _Surface:
    """Interpolates the records of rows that reach what they wait for over the unit cube of the varied parameters."""

    def __init__(self, study: Study, rows: Sequence[Row], records: Iterable[str]) -> None:
        self._names = study.varied
        answered = reached(rows)
        known = [row for row in answered if all(_positive(row.values[name]) for name in records)]
        places = self._places(known)
        if len(known):  # a place may have been run under two names, such as '20 kPa' and 20000.0
            places, first = np.unique(places, axis=0, return_index=True)
            known = [known[number] for number in first]
        if len(known) < len(self._names) + 2 or np.any(np.ptp(places, axis=0) == 0.0):
            what = (
                f"{len(known)} of {len(rows)} cases have {' and '.join(records)} > 0, {len(answered)} reached their end"
            )
            raise InputError("study", what, "is too few to search between")
        names = {row.case.name for row in answered}
        short = [row for row in rows if row.status == "done" and row.case.name not in names]
        tried = np.concatenate([places, self._places(short)])
        self._ends = tried.min(axis=0), tried.max(axis=0)
        self._logarithmic = np.all(tried > 0.0, axis=0)
        self._low, self._high = map(self._scaled, self._ends)
        within = (self._scaled(tried) - self._low) / (self._high - self._low)
        self.places, self._short = within[: len(places)], within[len(places) :]
        self._values = {name: np.log([row.values[name] for row in known]) for name in records}
        self._fits = {name: RBFInterpolator(self.places, values) for name, values in self._values.items()}

    def _places(self, rows: Sequence[Row]) -> Floats:
        values = [[float(setting(row.case, name)) for name in self._names] for row in rows]
        return np.array(values).reshape(-1, len(self._names))

    def _scaled(self, values: Floats) -> Floats:
        return np.where(self._logarithmic, np.log(np.where(self._logarithmic, values, 1.0)), values)

    def __call__(self, name: str, place: Floats) -> float:
        """Logarithm of a record at a place of the unit cube."""
        return float(self._fits[name](np.clip(place, 0.0, 1.0)[None, :])[0])

    def settings(self, place: Floats) -> dict[str, float]:
        """Values of the parameters at a place, rounded."""
        values = self._low + place * (self._high - self._low)
        values = np.where(self._logarithmic, np.exp(values), values)
        rounded = (float(f"{value:.{DIGITS}g}") for value in values)
        return {  # not beyond the bounds by rounding
            name: float(min(max(value, low), high))
            for name, value, low, high in zip(self._names, rounded, *self._ends, strict=True)
        }

    def minimum(self, name: str, limits: Mapping[str, float]) -> Floats:
        """Place of the least value of a record under limits {record: SI}; the least excess where they cannot be met."""
        constraints = [
            {"type": "ineq", "fun": lambda x, n=n, limit=limit: math.log(limit) - self(n, x)}
            for n, limit in limits.items()
        ]

        def excess(x: Floats) -> float:
            return math.fsum(max(0.0, self(n, x) - math.log(limit)) for n, limit in limits.items())

        starts = sorted(self.places, key=lambda x: (round(excess(x), 3), self(name, x)))[:5]
        ends = [
            np.clip(minimize(lambda x: self(name, x), x, method="SLSQP", bounds=[(0.0, 1.0)] * len(x),
                             constraints=constraints).x, 0.0, 1.0) for x in starts
        ]  # fmt: skip
        return min([*starts, *map(self._nearer, ends)], key=lambda x: (round(excess(x), 4), self(name, x)))

    def _nearer(self, place: Floats) -> Floats:
        """The place, as often half-way to the nearest run that reaches what it waits for as one that does not is nearer."""
        while True:
            distances = np.linalg.norm(self.places - place, axis=1)
            if np.linalg.norm(self._short - place, axis=1).min(initial=math.inf) >= distances.min():
                return place
            place = 0.5 * (place + self.places[distances.argmin()])


def _positive(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value) and value > 0.0


def search(
    study: Study, aim: Aim, out: Path, *, progress: Any = lambda cases: None, stop: Callable[[], bool] = lambda: False
) -> Optimum | None:
    """Run what is missing in `out`, search, and give the `Optimum` (collective); None if it was stopped.

    progress: called as progress(number of cases) before each batch of runs; gives what `run_study` takes as progress, or
    None. Raises `InputError` if too few cases reach their end.
    """
    rows = run_study(study, out, progress=progress(len(study.cases)), stop=stop)
    records = list(dict.fromkeys([aim.minimise, *aim.below, *([aim.trade_off] if aim.trade_off else [])]))

    def where(case: Case) -> tuple[float, ...]:
        return tuple(float(f"{setting(case, name):.{DIGITS}g}") for name in study.varied)

    def run_at(wanted: Any) -> float:
        """Run the minima under the given limits; the largest difference of what was predicted from what was found."""
        nonlocal study, rows
        surface = _Surface(study, rows, records)
        places = MPI.COMM_WORLD.bcast([surface.minimum(name, limits) for name, limits in wanted])
        known = {where(case): case for case in study.cases if case.scene is not None}
        cases = [study.case(with_units(surface.settings(place))) for place in places]
        cases = [known.get(where(case), case) for case in cases]
        there = {case.name for case in study.cases}  # those that no scene can have, too
        more = {case.name: case for case in cases if where(case) not in known and case.name not in there}
        study = study.with_cases([*study.cases, *more.values()])
        rows = run_study(study, out, progress=progress(len(study.cases)), stop=stop)
        found = {row.case.name: row for row in rows}
        answered = {row.case.name for row in reached(rows)}
        differences = [0.0]
        for case, place in zip(cases, places, strict=True):
            for name in records:
                value = found[case.name].values[name]
                is_found = _positive(value) and case.name in answered
                differences.append(abs(math.log(value) - surface(name, place)) if is_found else math.inf)
        return max(differences)

    agreed = False
    inside = {
        name: limit * (1.0 - AGREEMENT) for name, limit in aim.below.items()
    }  # what is found keeps the limits themselves
    for _ in range(MOST_ROUNDS):
        if any(row.status == "missing" for row in rows):
            return None
        agreed = run_at([(aim.minimise, inside)]) < AGREEMENT
        if agreed:
            break
    curve = []
    if aim.trade_off:
        for _ in range(TRADE_OFF_ROUNDS):
            if any(row.status == "missing" for row in rows):
                return None
            run_at([(aim.minimise, {}), (aim.trade_off, {})])
            both = {aim.minimise: math.inf, aim.trade_off: math.inf}  # the cheapest run may never reach a target
            ends = [best(reached(rows), name, both) for name in (aim.trade_off, aim.minimise)]
            values = [row.values[aim.trade_off] for row in ends if row is not None]
            if len(values) < len(ends):
                break
            limits = np.geomspace(values[0], values[1], TRADE_OFF_POINTS)
            run_at([(aim.minimise, {aim.trade_off: limit}) for limit in limits])
        curve = front(reached(rows), aim)
    if any(row.status == "missing" for row in rows):
        return None
    found = best(reached(rows), aim.minimise, aim.below)
    return Optimum(found, curve, agreed and found is not None)


def reached(rows: Sequence[Row]) -> list[Row]:
    """Those that reach what they wait for: a tool that never gets warm is cheap. All, where none does."""
    return [row for row in rows if row.is_reached] or list(rows)


def best(rows: Sequence[Row], name: str, limits: Mapping[str, float]) -> Row | None:
    """The row with the least of a record among those within the limits; None if there is none."""
    within = [
        row for row in rows
        if _positive(row.values[name])
        and all(_positive(row.values[n]) and row.values[n] <= limit for n, limit in limits.items())
    ]  # fmt: skip
    return min(within, key=lambda row: float(row.values[name])) if within else None


def front(rows: Sequence[Row], aim: Aim) -> list[Row]:
    """Rows that no other row beats in both records of the trade-off, in the order of the second."""
    other = aim.trade_off or aim.minimise
    known = [row for row in rows if _positive(row.values[aim.minimise]) and _positive(row.values[other])]
    known.sort(key=lambda row: (row.values[other], row.values[aim.minimise]))
    least, kept = math.inf, []
    for row in known:
        if row.values[aim.minimise] < least:
            least = row.values[aim.minimise]
            kept.append(row)
    return kept


def write(found: Optimum, study: Study, aim: Aim, out: Path) -> list[Path]:
    """optimum.json, and with a trade-off its picture trade_off.png; gives the written paths."""

    def entry(row: Row | None) -> dict[str, Any] | None:
        return None if row is None else {n: setting(row.case, n) for n in study.varied} | row.values

    content = {
        "minimise": aim.minimise,
        "below": aim.below,
        "units": {
            **{name: kind_of(KEYS, name) for name in study.varied},
            **{name: kind_of_record(name) for name in study.record},
        },
        "agreed": found.agreed,
        "optimum": entry(found.row),
        "trade_off": [entry(row) for row in found.trade_off],
    }
    with output_file(out / "optimum.json") as temporary:
        temporary.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    if not found.trade_off or aim.trade_off is None:
        return [out / "optimum.json"]
    from ..output.figures import STYLE, plt, save

    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(11.0, 4.4))
        figure.subplots_adjust(left=0.075, right=0.985, bottom=0.13, top=0.95, wspace=0.18)
        along = np.array([row.values[aim.trade_off] for row in found.trade_off])
        axes[0].plot(along, [row.values[aim.minimise] for row in found.trade_off], "o-")
        if found.row is not None and aim.trade_off in aim.below:
            axes[0].axvline(aim.below[aim.trade_off], color="0.6", linestyle="--", label="limit asked for")
            axes[0].legend()
        axes[0].set_ylabel(_labelled(aim.minimise))
        for name in study.varied:
            values = np.array([float(setting(row.case, name)) for row in found.trade_off])
            axes[1].plot(along, values / values.max(), "o-", label=f"{name} / {values.max():.4g}")
        axes[1].set_ylabel("parameter / its largest on the curve")
        axes[1].set_ylim(bottom=0.0)
        axes[1].legend()
        for each in axes:
            each.set_xlabel(_labelled(aim.trade_off))
        return [out / "optimum.json", save(figure, out / "trade_off.png")]


def _labelled(name: str) -> str:
    return f"{name.replace('_', ' ')}, {unit_of_record(name)}".removesuffix(", 1")


def _text(value: float | None, kind: str) -> str:
    """A value (SI) in the unit that readers like."""
    (shown,), unit = preferred_unit([value], kind)
    return "none" if shown is None else f"{shown:.6g} {unit}".rstrip()


def summary_text(found: Optimum, study: Study, aim: Aim) -> str:
    """The short readable end of a search."""

    def record(name: str, value: float | None) -> str:
        text = _text(value, kind_of_record(name))
        return f"{text} {currency}".rstrip() if name == "energy.cost" else text

    scenes = [case.scene for case in study.cases if case.scene is not None]
    currency = next((scene.operation.currency for scene in scenes if scene.operation.currency), "")
    limits = ", ".join(f"{name} below {record(name, limit)}" for name, limit in aim.below.items())
    under = f" with {limits}" if limits else ""
    if found.row is None:
        return f"no run has {aim.minimise}{under}: widen the bounds or the limit"
    lines = [f"least {aim.minimise}{under}: {record(aim.minimise, found.row.values[aim.minimise])}"]
    lines += [f"  {name} {record(name, value)}" for name, value in found.row.values.items() if name != aim.minimise]
    for name in study.varied:
        tried = [setting(case, name) for case in study.cases if case.scene is not None]
        value = setting(found.row.case, name)
        edge = "" if min(tried) < value < max(tried) else ", at its bound"
        lines.append(f"  at {name} = {_text(value, kind_of(KEYS, name))}{edge}")
    if found.row.reason:
        lines.append(f"warning: {found.row.reason}")
    if not found.agreed:
        lines.append(
            "warning: the last search and its run still differ by more than 0.3 %; more points of the grid help"
        )
    return "\n".join(lines)
