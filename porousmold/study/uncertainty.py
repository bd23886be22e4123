"""Uncertainty budget of a heating time, or of another quantity of a run: the contributions of inputs, closures and mesh.

Every input and closure of [tolerance] has a standard deviation sigma, half its tolerance. With t the quantity, each of them
contributes

    s_i = [ln t(p + sigma) - ln t(p - sigma)]/2

to the standard deviation of ln t, by central differences: of the order sigma^2. Two laws between which the experiments do not
decide (`ALTERNATIVES`) count as equally likely: half their difference in ln t is a standard deviation, and moves the middle.
The discretisation contributes the error that follows from what 1.5 times as many cells and steps change. All are independent:
s^2 = sum s_i^2, and 95 % of all cases lie within exp(+-1.96 s) around the middle.

`sampled` asks the model itself: a Latin hypercube of normally distributed inputs, the alternatives by the toss of a coin.
"""

import csv
import io
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import norm, qmc

from ..arrays import Floats
from ..files.atomic_files import output_file
from ..files.tables import text_cells
from ..laws.materials import Fluid, Solid
from ..laws.porosity import POROSITY_MODELS
from ..scene.chosen_laws import Laws
from ..scene.features.drive import DRIVES
from ..scene.features.geometries import dimension_of
from ..scene.features.tolerances import TOLERANCES, Tolerance, tolerance_of
from ..scene.keys import LISTED
from ..scene.scene import Scene
from ..scene.series import TimeSeries
from ..simulation.accuracy import ORDER
from .definition import Case, Study
from .parameters import case_around, phase_values, scaled, value_of
from .quantity import Quantity, quantity_of
from .running import IN_DOUBT, run_study

ALTERNATIVES: Mapping[str, Mapping[str, str]] = {
    "bed.porosity_model": {"hunt-tien": "hunt-tien-spheres", "hunt-tien-spheres": "hunt-tien"},
    "model.turbulence": {
        "nakayama-kuwahara": "damped-nakayama-kuwahara",
        "damped-nakayama-kuwahara": "nakayama-kuwahara",
        "decaying-nakayama-kuwahara": "nakayama-kuwahara",
    },
}
"""Laws with the other one between which and it the experiments do not decide."""
IN_TIME = "changes in time: not varied"
"""Reason of a contribution that there is none of."""
CELLS = "discretisation"
"""Name of the contribution of cells and steps."""
FINER, HALVED = 1.5, 2.0
"""Factor on cells and steps of the case that tells the discretisation's part; on a mesh of one's own."""
INSIDE_95 = 1.96
"""Standard deviations on each side that hold 95 % of a normal distribution."""
LARGEST_POROSITY = 0.95
OF_LAYERS = ("thickness", "heat_capacity", "conductivity")
"""Of every layer of the wall, with the tolerances of a plain one; its density acts as its heat capacity does."""


@dataclass(frozen=True)
class Contribution:
    """Of an input, a closure or the cells: `deviation` is its standard deviation of ln t, with its sign for an input that
    grows; None, with the `reason`, where there is none; a `reason` beside a number says what it lacks. `tolerance` is as the
    scene states it."""

    name: str
    tolerance: str
    deviation: float | None
    reason: str = ""


@dataclass(frozen=True)
class Budget:
    """The `value` of a quantity as the scene gives it, its `middle` and 95 % interval, the contributions, largest first, and what
    the scene gives but has no tolerance; of what is counted up to an answer that the scene does not reach what is `unmet`; how
    many cases are `in_doubt`, as coarser cells move their answers, or a target hangs on less than the error."""

    quantity: Quantity
    value: float
    middle: float
    low: float
    high: float
    deviation: float
    contributions: tuple[Contribution, ...]
    without_tolerance: tuple[str, ...] = ()
    unmet: str = ""
    in_doubt: int = 0

    @property
    def doubt(self) -> str:
        """What the interval lacks: inputs with an answer on one side alone, and contributions without one; '' where it is
        whole."""
        one_sided = [c for c in self.contributions if c.deviation is not None and c.reason]
        without = [c for c in self.contributions if c.deviation is None and c.reason != IN_TIME]
        found = [f"counted up to the end of the run: {self.unmet}"] if self.unmet else []
        if one_sided:
            found.append(
                f"{len(one_sided)} of {len(self.contributions)} have an answer on one side alone, which counts for both: the "
                "interval is no bound on the other"
            )
        if self.in_doubt:
            found.append(f"the answers of {self.in_doubt} cases are in doubt (table.csv says why)")
        if without:
            found.append(f"{len(without)} of {len(self.contributions)} have none and count as 0")
        return "; ".join(found)

    @property
    def of_inputs(self) -> float:
        """The standard deviation without the part of cells and steps, as a sample has it."""
        parts = [c.deviation for c in self.contributions if c.name != CELLS and c.deviation is not None]
        return math.sqrt(math.fsum(part**2 for part in parts))

    @property
    def shares(self) -> dict[str, float]:
        """Of the variance, by name."""
        variance = max(self.deviation**2, 1e-300)
        return {c.name: c.deviation**2 / variance for c in self.contributions if c.deviation is not None}


@dataclass(frozen=True)
class Sample:
    """A Latin hypercube: how many cases gave an answer, the standard deviation of its logarithm and three quantiles."""

    cases: int
    answered: int
    deviation: float
    low: float
    median: float
    high: float


def inputs_of(scene: Scene) -> dict[str, tuple[float, float]]:
    """{name: (value, standard deviation)} in SI of what the scene has of [tolerance]; of properties of materials, whose laws are
    scaled, the value in the middle.

    Raises `InputError` for a tolerance that is given of what has no single value, such as a time series or phases, or is no
    input of the scene, and for one that is not below half of the value.
    """
    laws, found = Laws.of(scene), {}
    in_time = unvaried(scene)
    for name in TOLERANCES:
        of_phases = [abs(value) for value in phase_values(scene, name).values()]
        value = max(of_phases) if of_phases else value_of(scene, laws, name)
        if not _counts(scene, name) or value is None:
            is_of_layers = name.removeprefix("wall.") in OF_LAYERS and scene.layers
            if scene.is_given(f"tolerance.{name}") and _tolerance(scene, name).size > 0.0 and not is_of_layers:
                why = "has no single value in" if name in in_time else "is no input of"
                scene.refuse(f"tolerance.{name}", f"has no effect: {name} {why} this scene")
            continue
        if (size := _size(scene, name, value)) > 0.0:
            found[name] = (value, 0.5 * size)
    for name in (f"{place}.{key}" for place in scene.layers for key in OF_LAYERS):
        value = value_of(scene, laws, name)
        if value is not None and (size := _size(scene, name, value)) > 0.0:
            found[name] = (value, 0.5 * size)
    return found


def _size(scene: Scene, name: str, value: float) -> float:
    """The tolerance of an input of a value, in SI."""
    size, key = _tolerance(scene, name).of(value), _tolerance_key(name)
    if size >= 0.5 * abs(value):
        scene.refuse(
            f"tolerance.{key}", f"must be below half of {name} = {value:g} {TOLERANCES[key].tolerated}".rstrip()
        )
    return size


def _tolerance(scene: Scene, name: str) -> Tolerance:
    key = _tolerance_key(name)
    return tolerance_of(key, getattr(scene.tolerance, key), scene.source)


def _tolerance_key(name: str) -> str:
    """The key of [tolerance] that an input has: of a layer that of the wall."""
    listed = LISTED.fullmatch(name)
    return f"wall.{listed['key']}" if listed else name


def without_tolerance(scene: Scene) -> list[str]:
    """What the scene gives of materials of its own and of its operation, and the budget does not vary."""
    varied = {
        *inputs_of(scene),
        *unvaried(scene),
        "operation.end_time",
        "operation.heating_margin",
        "operation.energy_price",
    }
    tables = ("bed", "wall", "operation", "model")
    numbers = [
        f"{table}.{name}"
        for table in tables
        for name, value in getattr(scene, table)
        if isinstance(value, float | TimeSeries)
    ]
    given = [name for name in numbers if scene.is_given(name) and name not in varied]
    given += [
        f"{place}.{name}"
        for place, layer in scene.layers.items()
        for name, value in (("contact_resistance", layer.contact_resistance), ("heat_source", layer.heat_source))
        if value is not None and value != 0.0
    ]
    given += ["density of layers"] if scene.layers else []
    given += ["operation.blower"] if scene.operation.blower is not None else []
    for name, material in scene.materials.items():
        given += [f"materials.{name}"] if isinstance(material, Fluid) else []
        given += [f"cure of materials.{name}"] if isinstance(material, Solid) and material.cure is not None else []
    return given


def _counts(scene: Scene, name: str) -> bool:
    """Whether the input is one of this scene."""
    model = scene.model
    if name.startswith("wall."):
        return model.wall in ("conjugate", "thin") and not (name == "wall.thickness" and scene.geometry.kind == "mesh")
    if name == "bed.bulk_porosity":
        return scene.bed.porosity_profile is None
    if name == "model.exchange_factor":
        return model.energy == "two-temperature"
    return True


def unvaried(scene: Scene) -> list[str]:
    """Inputs that change in time or from phase to phase, whose tolerances are not part of the budget."""
    names = ("operation.inlet_temperature", *(f"operation.{name}" for name in DRIVES))
    laws = Laws.of(scene)
    return [
        name
        for name in names
        if scene.value(name) is not None and value_of(scene, laws, name) is None and not phase_values(scene, name)
    ]


def moved(scene: Scene, name: str, value: float, deviation: float, steps: float) -> dict[str, float | str]:
    """Settings of an input moved by so many standard deviations; of phases all of them, each by its own, drives in magnitude."""
    phases = phase_values(scene, name)
    if not phases:
        return {name: scaled(scene, name, value, 1.0 + steps * deviation / value)}
    tolerance = _tolerance(scene, name)
    return {key: one + steps * math.copysign(0.5 * tolerance.of(abs(one)), one) for key, one in phases.items()}


def alternatives_of(scene: Scene) -> dict[str, str]:
    """{key: the other law} where the scene has one of `ALTERNATIVES`."""
    others = {}
    for name, other in ALTERNATIVES.items():
        table, key = name.split(".")
        chosen = getattr(getattr(scene, table), key)
        if chosen not in other or (name == "bed.porosity_model" and scene.bed.porosity_profile is not None):
            continue
        if name == "model.turbulence" and scene.model.flow == "plug":
            continue
        others[name] = other[chosen]
    return others


def _finer(scene: Scene) -> float:
    """Factor on cells and steps of the case "finer"."""
    return HALVED if scene.geometry.kind == "mesh" else FINER


def cases_of(scene: Scene) -> list[Case]:
    """The scene itself, both sides of every input, the other laws, and a finer mesh with smaller steps."""
    cases = [case_around(scene, "as given", {})]
    for name, (value, deviation) in inputs_of(scene).items():
        cases += [
            case_around(scene, f"{name},{side}", moved(scene, name, value, deviation, sign))
            for side, sign in (("up", 1), ("down", -1))
        ]
    cases += [case_around(scene, f"{name},{law}", {name: law}) for name, law in alternatives_of(scene).items()]
    if scene.solver.accuracy is None:
        factor = _finer(scene)
        finer = {"solver.step_refinement": factor * scene.solver.step_refinement}
        if not (scene.geometry.kind == "mesh" and dimension_of(scene.geometry) == 3):
            finer["solver.mesh_refinement"] = factor * scene.solver.mesh_refinement
        cases.append(case_around(scene, "finer", finer))
    return cases


def budget(
    scene: Scene,
    out: Path,
    quantity: Quantity | None = None,
    *,
    progress: Any = None,
    stop: Callable[[], bool] = lambda: False,
) -> Budget | None:
    """Run what is missing in `out` and give the budget of a quantity (default: `quantity_of`; collective); None where it was
    stopped.

    Raises `InputError` for a scene that has no such quantity by its end, or none that is positive.
    """
    quantity = quantity or quantity_of(scene, None)
    cases, record = cases_of(scene), [quantity.record, *_error_record(quantity)]
    rows = run_study(Study(cases[:1], [], record), out, progress=progress, stop=stop)
    given = rows[0]
    here = quantity.in_row(given, given)
    if here is None and given.status != "missing":
        raise quantity.no_answer(scene, quantity.reason(given, given))
    rows = run_study(Study(cases, [], record), out, progress=progress, stop=stop)
    if any(row.status == "missing" for row in rows):
        return None
    assert here is not None, "an answer that is missing has ended the study"
    times = {row.case.name: quantity.in_row(row, given) for row in rows}
    reasons = {row.case.name: quantity.reason(row, given) for row in rows}
    found, shift = [], 0.0
    for name in inputs_of(scene):
        up, down = times[f"{name},up"], times[f"{name},down"]
        text = str(getattr(scene.tolerance, _tolerance_key(name)))
        if up is not None and down is not None:
            found.append(Contribution(name, text, 0.5 * math.log(up / down)))
        elif up is None and down is None:
            found.append(Contribution(name, text, None, reasons[f"{name},up"]))
        else:
            side, one = ("up", math.log(up / here)) if up is not None else ("down", math.log(here / (down or here)))
            found.append(Contribution(name, text, one, f"of {name},{side} alone"))
    found += [Contribution(name, "", None, IN_TIME) for name in unvaried(scene)]
    for name, law in alternatives_of(scene).items():
        time = times[f"{name},{law}"]
        half = None if time is None else 0.5 * math.log(time / here)
        shift += half or 0.0
        found.append(Contribution(name, f"or {law}", half, "" if half is not None else reasons[f"{name},{law}"]))
    if "finer" in times:
        finer = times["finer"]
        cells = None if finer is None else abs(math.log(finer / here)) / (1.0 - _finer(scene) ** -ORDER)
        found.append(
            Contribution(CELLS, "finer cells, smaller steps", cells, "" if cells is not None else reasons["finer"])
        )
    else:
        error = next((rows[0].values[name] for name in _error_record(quantity)), None)
        found.append(
            Contribution(
                CELLS,
                f"solver.accuracy {scene.solver.accuracy:g}",
                error,
                "" if error is not None else f"solver.accuracy estimates none of {quantity.words}",
            )
        )
    deviation = math.sqrt(sum(c.deviation**2 for c in found if c.deviation is not None))
    middle, reach = here * math.exp(shift), math.exp(INSIDE_95 * deviation)
    ordered = tuple(sorted(found, key=lambda c: -abs(c.deviation or 0.0)))
    unmet = "" if given.is_reached or quantity.is_answer else given.reason
    return Budget(
        *(quantity, here, middle, middle / reach, middle * reach, deviation, ordered),
        *(tuple(without_tolerance(scene)), unmet, sum(IN_DOUBT.search(row.reason) is not None for row in rows)),
    )


def _error_record(quantity: Quantity) -> list[str]:
    """What a run with solver.accuracy records of the error of a quantity."""
    if quantity.record.startswith("targets."):
        return [f"target_errors.{quantity.record.removeprefix('targets.')}"]
    return [f"{quantity.record}_error"] if quantity.record == "heating_time" else []


def sample_cases(scene: Scene, count: int, seed: int) -> list[Case]:
    """A Latin hypercube of so many cases."""
    inputs, others = inputs_of(scene), alternatives_of(scene)
    points = qmc.LatinHypercube(len(inputs) + len(others), seed=seed).random(count)
    cases = []
    for number, point in enumerate(points):
        settings: dict[str, Any] = {}
        for (name, (value, deviation)), place in zip(inputs.items(), point, strict=False):
            settings |= {
                key: _kept(scene, key, one)
                for key, one in moved(scene, name, value, deviation, float(norm.ppf(place))).items()
            }
        tosses = point[len(inputs) :]
        settings |= {name: law for (name, law), toss in zip(others.items(), tosses, strict=True) if toss < 0.5}
        cases.append(case_around(scene, f"sample-{number:04d}", settings))
    return cases


def _kept(scene: Scene, name: str, value: float | str) -> float | str:
    """The value, or the largest that the porosity's laws take."""
    if name != "bed.bulk_porosity" or isinstance(value, str):
        return value
    laws = {scene.bed.porosity_model, alternatives_of(scene).get("bed.porosity_model", scene.bed.porosity_model)}
    return min(value, LARGEST_POROSITY, *(POROSITY_MODELS[law].largest_bulk_porosity for law in laws))


def sampled(
    scene: Scene,
    out: Path,
    count: int,
    seed: int,
    quantity: Quantity | None = None,
    *,
    progress: Any = None,
    stop: Callable[[], bool] = lambda: False,
) -> Sample | None:
    """Run what is missing of a Latin hypercube in `out` and give its statistics (collective); None where it was stopped."""
    quantity = quantity or quantity_of(scene, None)
    cases = [case_around(scene, "as given", {}), *sample_cases(scene, count, seed)]
    given, *rows = run_study(Study(cases, [], [quantity.record]), out, progress=progress, stop=stop)
    if any(row.status == "missing" for row in (given, *rows)):
        return None
    times: Floats = np.array([t for row in rows if (t := quantity.in_row(row, given)) is not None], float)
    if len(times) < 2:
        raise quantity.no_answer(scene, f"in {len(times)} of the sampled cases alone")
    slow = sum(quantity.is_beyond(row, given) for row in rows)
    low, median, high = np.quantile(
        [*times, *[np.inf] * slow], (0.025, 0.5, 0.975), method="lower" if slow else "linear"
    )
    return Sample(count, len(times), float(np.std(np.log(times), ddof=1)), float(low), float(median), float(high))


def summary_text(found: Budget, sample: Sample | None) -> str:
    """The answer in a sentence, the budget as lines, and the sample beside it."""
    shares = found.shares
    leading = ", ".join(f"{name} {share:.0%}" for name, share in list(shares.items())[:4])
    text = found.quantity.text
    named = "" if found.quantity.record == "heating_time" else f"{found.quantity.words}: "
    lines = [
        f"{named}{text(found.value)}, 95 % within {_range(found, found.low, found.high)}; {leading} of the variance",
        f"standard deviation {found.deviation:.1%}, middle {text(found.middle)}",
    ]
    for entry in found.contributions:
        part = (
            f"{entry.deviation:+.2%}  {shares[entry.name]:4.0%}{f'  ({entry.reason})' if entry.reason else ''}"
            if entry.deviation is not None
            else f"none: {entry.reason}"
        )
        lines.append(f"  {entry.name:28s} {entry.tolerance:28s} {part}")
    if found.doubt:
        lines.append(f"warning: {found.doubt}")
    if found.without_tolerance:
        lines.append(f"not varied, as they have no tolerance here: {', '.join(found.without_tolerance)}")
    if sample is not None:
        lines += [
            f"{sample.answered} of {sample.cases} sampled cases: 95 % within {_range(found, sample.low, sample.high)}, median "
            f"{_told(found, sample.median)}",
            f"  standard deviation {sample.deviation:.1%} against {found.of_inputs:.1%} of the budget without {CELLS} "
            f"({sample.deviation / max(found.of_inputs, 1e-300) - 1.0:+.0%}): all cases have the same cells and steps",
        ]
    return "\n".join(lines)


def _answer(found: Budget, sample: Sample | None, separator: str) -> str:
    """The value and its interval, and that of the sample."""
    parts = [f"{found.quantity.text(found.value)}, 95 % within {_range(found, found.low, found.high)}"]
    if found.doubt:
        parts.append(found.doubt)
    if sample is not None:
        parts.append(f"{sample.answered} sampled cases: {_range(found, sample.low, sample.high)}")
    return separator.join(parts)


def _range(found: Budget, low: float, high: float) -> str:
    first, last = _told(found, low), _told(found, high)
    unit = "" if found.quantity.unit == "1" else f" {found.quantity.unit}"
    return f"{first.removesuffix(unit)} to {last}"


def write(found: Budget, sample: Sample | None, out: Path) -> list[Path]:
    """uncertainty.json, budget.csv and the picture budget.png; gives their paths."""
    content = asdict(found) | {"shares": found.shares, "sample": None if sample is None else _finite(asdict(sample))}
    content |= {
        "of": found.quantity.words,
        "sentence": f"{found.quantity.words}: {_answer(found, sample, '; ')}".capitalize(),
    }
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["of", "tolerance", "standard deviation of ln t [1]", "share of the variance [1]", "reason"])
    for entry in found.contributions:
        cells = entry.name, entry.tolerance, entry.deviation, found.shares.get(entry.name), entry.reason
        writer.writerow(text_cells(cells))
    paths = [out / "uncertainty.json", out / "budget.csv"]
    for path, written in zip(paths, (json.dumps(content, indent=2) + "\n", text.getvalue()), strict=True):
        with output_file(path) as temporary:
            temporary.write_text(written, encoding="utf-8")
    return [*paths, _draw(found, sample, out / "budget.png")]


def _told(found: Budget, value: float) -> str:
    return found.quantity.text(value) if math.isfinite(value) else "beyond the end of the run"


def _finite(numbers: Mapping[str, float]) -> dict[str, float | None]:
    """Numbers for JSON, which knows no infinite ones: None where a case that is not heated by the end stands."""
    return {name: value if math.isfinite(value) else None for name, value in numbers.items()}


def _draw(found: Budget, sample: Sample | None, path: Path) -> Path:
    from ..output.figures import STYLE, plt, save

    shown: Sequence[Contribution] = [
        c for c in found.contributions if c.deviation is not None and abs(c.deviation) > 5e-4
    ][::-1]
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(9.0, 1.5 + 0.3 * len(shown)), layout="constrained")
        sizes = [1e2 * (c.deviation or 0.0) for c in shown]
        axes.barh([f"{c.name} ({c.tolerance})" for c in shown], sizes,
                  color=["tab:red" if size > 0.0 else "tab:green" for size in sizes])  # fmt: skip
        axes.axvline(0.0, color="k", linewidth=0.8)
        larger = "longer" if found.quantity.is_time else "larger"
        axes.set_xlabel(f"standard deviation of the {found.quantity.words} in % (red: {larger})")
        axes.set_title(_answer(found, sample, "\n"))
        axes.grid(axis="y", visible=False)
        return Path(save(figure, path))
