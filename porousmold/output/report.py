"""One self-contained HTML page about a run or a study, for mailing: everything in it, nothing from a network."""

import json
import tomllib
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import ParseError

from ..errors import InputError
from ..files.atomic_files import output_file
from ..files.units import preferred_unit
from ..scene.features import KEYS
from ..scene.features.geometries import modelled_part
from ..scene.keys import Tables, flat, kind_of, unit_and_meaning
from .console import closures_text, kept_text, outer_wall_text
from .pictures import draw, fields_with_slider
from .quantities import ENERGY_GIVEN, ENERGY_NAMES, JOULES_A_KWH
from .report_page import Block, Markup, Picture, Section, Sentence, Table, rendered
from .result_keys import Summary
from .stored import read_study, require_run
from .study_pictures import draw_study


def write_report(folder: Path) -> Path:
    """Write report.html into the folder of a run or a study; gives its path. `InputError` if the folder holds neither."""
    folder = Path(folder)
    if (folder / "result.json").is_file():
        require_run(folder)
        try:
            title, sections = _of_run(folder)
        except (OSError, ValueError, LookupError, TypeError, AttributeError, ParseError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError("RUN", str(folder), f"has damaged files: {error}") from error
    elif (folder / "table.json").is_file():
        title, sections = _of_study(folder)
    else:
        raise InputError("RUN", str(folder), "is not the folder of a run or a study (no result.json, no table.json)")
    with output_file(folder / "report.html") as temporary:
        temporary.write_text(rendered(title, sections), encoding="utf-8")
    return folder / "report.html"


def _of_run(folder: Path) -> tuple[str, list[Section]]:
    summary = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    scene = tomllib.loads((folder / "scene.toml").read_text(encoding="utf-8"))
    pictures = draw(folder) if (folder / "history.csv").is_file() else []  # it failed at the start
    sections = [
        Section("", _headline(summary, scene) + [Sentence(text, "warning") for text in summary["warnings"]]),
        Section("Targets", _targets(summary)),
        Section("Uncertainty", _uncertainty_of(folder)),
        Section("Result", _results(summary, scene)),
        Section("Energy", _energy(summary)),
        Section("Pictures", [Picture(path) for path in pictures]),
        Section("Fields over time", [Markup(fields_with_slider(folder))] if (folder / "fields.xdmf").is_file() else []),
        Section("Beside the measurement", _compared(folder) if (folder / "comparison.json").is_file() else []),
        Section("Scene", _keys(summary, scene)),
        Section("Materials", _materials(summary)),
        Section("Sources of the closures", _sources(summary)),
        Section(
            "Date and versions",
            [Table(["of", "version"], list({"computed": summary["date"], **summary["versions"]}.items()))],
        ),
    ]
    title = scene.get("output", {}).get("title")
    return title or f"Heating of a {scene['geometry']['kind']}: {folder.name}", sections


def _headline(summary: Summary, scene: Tables) -> list[Block]:
    """How it ended, targets and heating time."""
    parts: list[Block] = []
    time = summary["heating_time"]
    if summary["status"] != "done":
        parts.append(Sentence(f"This run is {summary['status']}: {summary['failure'] or ''}", "warning"))
    reached = f"{time:.0f} s ({time / 60:.1f} min)" if time is not None else "not reached"
    estimated = summary["heating_time_error"]
    known = f", numerical error about {estimated:.1%}" if estimated is not None else ""
    met = summary["targets"].values()
    if met:
        last = f"all met at {max(met) / 60.0:.1f} min" if None not in met else "not all met"
        lost = [name for name, kept in summary["targets_kept"].items() if kept["kept_from"] is None]
        but = f", but not kept to the end: {', '.join(lost)}" if lost else ""
        parts.append(Sentence(f"Targets: {last}{but}", "large"))
    if time is not None or (summary["has_heating_time"] and not met):
        operation = scene["operation"]
        margin, place = operation["heating_margin"], operation["heated_place"].replace("_", " ")
        parts.append(Sentence(f"Heating time: {reached}{known} ({place} within {margin:g} K of the inlet)", "large"))
    return parts


def _results(summary: Summary, scene: Tables) -> list[Block]:
    bounds = summary["temperature_bounds"] or [float("nan")] * 2
    layers = [
        [f"{name} at the end", f"{low - 273.15:.1f} to {high - 273.15:.1f}", "°C"]
        for name, (low, high) in summary["layers_at_end"].items()
    ]
    return [
        Sentence(f"Mass flow and heat are those of the modelled part: {modelled_part(scene['geometry'])}."),
        Table(["quantity", "value", "unit"], [row for row in [
            ["heating time of the wall's bed side", *_or_dash(summary["heating_time_bed_side"], "s")],
            ["mass flow at the start", *_or_dash(summary["mass_flow_initial"], "kg/s")],
            ["mass flow at the end", *_or_dash(summary["mass_flow_final"], "kg/s")],
            ["heat from the fluid", *_or_dash(summary["heat_by_fluid"], "J")],
            ["heat to bring the fluid to the inlet temperature", *_or_dash(summary["fluid_heat"], "J")],
            ["pumping work", *_or_dash(summary["pumping_work"], "J")],
            ["relative imbalance of the heat balance", *_or_dash(summary["energy_imbalance"], "1")],
            ["lowest and highest temperature", f"{bounds[0] - 273.15:.2f} to {bounds[1] - 273.15:.2f}", "°C"],
            *layers,
            ["time steps", str(summary["time_steps"]), ""],
            ["outer wall", outer_wall_text(scene["operation"]), ""],
            ["unknowns (flow, energy)", f"{summary['unknowns']['flow']}, {summary['unknowns']['energy']}", ""],
        ] if row[1] != "-"]),
    ]  # fmt: skip


def _keys(summary: Summary, scene: Tables) -> list[Block]:
    """The scene as it was run."""
    given = summary["given"]
    rows = [
        [name, given.get(name, "-"), _value(value), *unit_and_meaning(KEYS, name)]
        for name, value in flat(scene).items()
        if not name.startswith("materials.") and (name in given or not name.startswith("tolerance."))
    ]
    return [
        Sentence("Keys as set in the scene, and all values in SI, defaults included."),
        Table(["key", "as given", "value (SI)", "unit", "meaning"], rows),
    ]


def _compared(folder: Path) -> list[Block]:
    """What `porousmold compare` left in the folder."""
    try:
        return _comparison(folder, json.loads((folder / "comparison.json").read_text(encoding="utf-8")))
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        return [Sentence("The comparison in the folder is damaged: make it again by porousmold compare.", "warning")]


def _comparison(folder: Path, found: Any) -> list[Block]:
    head = ["sensor", "on average apart, K", "bias, K", "at most, K", "run uncertain by at most, K", "within errors"]
    rows = [
        [
            name,
            *(float(of[key]) for key in ("average", "bias", "largest", "largest_uncertainty")),
            f"{of['within_errors']:.0%}",
        ]
        for name, of in found["sensors"].items()
    ]
    return [
        Sentence(f"S_ave = {found['average_deviation']:.3f} K"),
        Table(head, rows),
        Picture(folder / "comparison.png"),
    ]


def _or_dash(value: float | None, unit: str) -> tuple[str, str]:
    """A value (SI) in the unit that readers prefer, and that unit."""
    (shown,), sign = preferred_unit([value], unit)
    return ("-" if shown is None else f"{shown:.4g}"), sign


def _value(value: object) -> Any:
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else value


def _targets(summary: Summary) -> list[Block]:
    rows = [
        [
            name,
            summary["target_meanings"][name] + kept_text(summary["targets_kept"].get(name)),
            *((time / 60.0, "min") if time is not None else ("not met", "")),
        ]
        for name, time in summary["targets"].items()
    ]
    return [Table(["name", "asks for", "met at", ""], rows)] if rows else []


def _energy(summary: Summary) -> list[Block]:
    energy = summary["energy"]
    if energy is None:
        return []
    rows = [
        [words, energy[name] / JOULES_A_KWH, "kWh", "given" if name in ENERGY_GIVEN else "taken"]
        for name, words in ENERGY_NAMES.items()
        if energy[name]
    ]
    rows += [["largest power of heater and blower", energy["peak_power"] / 1e3, "kW", ""]]
    if energy["cost"] is not None:
        rows += [["cost of heater and blower", float(energy["cost"]), energy.get("currency") or "", ""]]
    sentence = f"Of the whole tool, {energy['share']:g} times the modelled part, up to {energy['until']:.0f} s."
    return [Sentence(sentence), Table(["of", "energy", "unit", ""], rows)]


def _sources(summary: Summary) -> list[Block]:
    rows = [[name, source] for name, source in summary["sources"].items()]
    return [Sentence(f"Set of closures: {closures_text(summary['closures'])}"), Table(["of", "source"], rows)]


def _materials(summary: Summary) -> list[Block]:
    rows = [
        [owner, entry["material"], name.replace("_", " "), float(law["value"]), law["unit"], law["source"]]
        for owner, entry in summary["materials"].items()
        for name, law in entry["properties"].items()
    ]
    mean = next(iter(summary["materials"].values()))["temperature"] - 273.15
    head = ["of", "material", "property", f"value at {mean:.0f} °C", "unit", "source"]
    return [Table(head, rows)]


def _uncertainty_of(folder: Path) -> list[Block]:
    """That of the run's scene, where it was computed beside it."""
    beside = folder.with_name(f"{folder.name}-uncertainty")
    return _uncertainty(beside) if (beside / "uncertainty.json").is_file() else []


def _uncertainty(folder: Path) -> list[Block]:
    """What `porousmold uncertainty` left in the folder."""
    try:
        found = json.loads((folder / "uncertainty.json").read_text(encoding="utf-8"))
        rows = [
            [entry["name"], entry["tolerance"]]
            + (["-", "-"] if entry["deviation"] is None
               else [f"{entry['deviation']:+.2%}", f"{found['shares'][entry['name']]:.0%}"])
            + [entry["reason"]]
            for entry in found["contributions"]
        ]  # fmt: skip
        sentence, words = str(found["sentence"]), str(found["of"])
        without = ", ".join(found["without_tolerance"])
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise InputError("RUN", str(folder), f"has a damaged uncertainty.json: {error}") from error
    head = ["of", "tolerance", f"standard deviation of the {words}", "share of the variance", "remark"]
    not_varied = [Sentence(f"Not varied, as they have no tolerance here: {without}.")] if without else []
    return [Sentence(sentence, "large"), Table(head, rows), *not_varied]


def _optimum(folder: Path) -> list[Block]:
    """What `porousmold optimum` left in the folder: the answer."""
    try:
        found = json.loads((folder / "optimum.json").read_text(encoding="utf-8"))
        best, units = found["optimum"], found["units"]
        limits = ", ".join(f"{name} below {_shown(limit, units[name])}" for name, limit in found["below"].items())
        shown = {} if best is None else {name: _shown(value, units[name]) for name, value in best.items()}
    except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
        raise InputError("RUN", str(folder), f"has a damaged optimum.json: {error}") from error
    under = f" with {limits}" if limits else ""
    sentence = f"Least {found['minimise']}{under}: {shown.get(found['minimise'], 'no case keeps the limits')}"
    return [Sentence(sentence, "large"), *([Table(["of", "value"], list(shown.items()))] if shown else [])]


def _search(folder: Path) -> list[Block]:
    """What `porousmold solve-for` left in the folder: which single change reaches the target."""
    try:
        found = json.loads((folder / "solve_for.json").read_text(encoding="utf-8"))
        record, target, unit = (found["target"][name] for name in ("record", "value", "unit"))
        rows = []
        for one in found["changes"]:
            given, tried = (_shown(one[name], kind_of(KEYS, one["key"])) for name in ("value", "tried"))
            needed, remark = tried, ""
            if one["needed"] is None:
                needed, remark = "none found", f"nearest with {tried}: {one['reason']}"
            power = _shown(one["beside"]["mean_power"], "W")
            rows.append([one["key"], given, needed, _shown(one["reached"], unit), power, remark])
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise InputError("RUN", str(folder), f"has a damaged solve_for.json: {error}") from error
    head = ["key", "as given", "needed", record, "mean power", "remark"]
    sentence = f"Target: {record} = {_shown(target, unit)}, by a single change"
    return [Sentence(sentence, "large"), Table(head, rows)]


def _shown(value: float | None, unit: str) -> str:
    """A value (SI) with the unit that readers prefer."""
    return " ".join(_or_dash(value, unit)).strip()


def _cell(value: object) -> Any:
    return float(value) if isinstance(value, int | float) else "-" if value is None else value


def _of_study(folder: Path) -> tuple[str, list[Section]]:
    entries, head = read_study(folder)
    statuses = [entry["status"] for entry in entries]
    is_around = (folder / "uncertainty.json").is_file()  # cases that their names alone tell apart
    told = {*([] if is_around else ["folder"]), *(["status"] if set(statuses) == {"done"} else [])}
    names = [name for name in (entries[0] if entries else ()) if name not in told]
    names = [name for name in names if any(entry[name] is not None for entry in entries)]
    labels = dict(zip(entries[0] if entries else (), head, strict=False))
    rows = [[_cell(entry[name]) for name in names] for entry in entries]
    counts = ", ".join(f"{statuses.count(status)} {status}" for status in dict.fromkeys(statuses))
    answers = [
        Section("", part(folder))
        for name, part in (("optimum", _optimum), ("uncertainty", _uncertainty))
        if (folder / f"{name}.json").is_file()
    ]
    if (folder / "solve_for.json").is_file():  # its table is that of the last run tried
        return f"What must change: {folder.name}", [*answers, Section("", _search(folder))]
    draw_study(folder, entries, head)
    sentence = f"{len(entries)} case{'s' if len(entries) != 1 else ''}: {counts}."
    pictures = [Picture(path) for path in sorted(folder.glob("*.png"))]
    return f"Study: {folder.name}", [
        *answers,
        Section("", [Sentence(sentence), *pictures, Table([labels[name] for name in names], rows)]),
    ]
