"""One self-contained HTML page about a run or a study, for mailing: everything in it, nothing from a network."""

import base64
import html
import json
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import ParseError

from .. import __version__
from ..errors import InputError
from ..files.atomic_files import output_file
from ..files.units import preferred_unit
from ..scene.geometries import modelled_part
from ..scene.keys import flat, kind_of, unit_and_meaning
from ..scene.schema import KEYS
from .console import closures_text, kept_text, model_text, outer_wall_text
from .pictures import draw, fields_with_slider
from .quantities import ENERGY_GIVEN, ENERGY_NAMES, JOULES_A_KWH
from .stored import read_study
from .study_pictures import draw_study

_STYLE = """
body { font: 15px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; color: #222; }
table { border-collapse: collapse; margin: 1em 0; }
th, td { padding: .2em .8em; text-align: left; border-bottom: 1px solid #ddd; }
td.number { text-align: right; font-variant-numeric: tabular-nums; } img { max-width: 100%; }
td { overflow-wrap: anywhere; } td:first-child { white-space: nowrap; }
@media print { body { font-size: 10px; margin: 0; max-width: none; } th, td { padding: .1em .4em; }
  img { page-break-inside: avoid; max-height: 16cm; } h2 { page-break-after: avoid; } tr { page-break-inside: avoid; } }
.warning { background: #fff3d6; padding: .5em 1em; margin: .5em 0; } .large { font-size: 1.6em; }
"""


def write_report(folder: Path) -> Any:
    """Write report.html into the folder of a run or a study; gives its path. `InputError` if the folder holds neither."""
    folder = Path(folder)
    if (folder / "result.json").is_file():
        try:
            title, body = _of_run(folder)
        except (OSError, ValueError, LookupError, TypeError, AttributeError, ParseError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError("RUN", str(folder), f"has damaged files: {error}") from error
    elif (folder / "table.json").is_file():
        title, body = _of_study(folder)
    else:
        raise InputError("RUN", str(folder), "is not the folder of a run or a study (no result.json, no table.json)")
    page = (
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{_text(title)}</title>'
        f"<style>{_STYLE}</style></head><body><h1>{_text(title)}</h1>{body}"
        f"<p>porousmold {_text(__version__)}</p></body></html>\n"
    )
    with output_file(folder / "report.html") as temporary:
        temporary.write_text(page, encoding="utf-8")
    return folder / "report.html"


def _text(value: Any) -> Any:
    return html.escape(str(value))


def _table(head: Sequence[str], rows: Any) -> str:
    """Rows of cells as a table; numbers stand right."""
    lines = "".join(f"<th>{_text(cell)}</th>" for cell in head)
    for row in rows:
        cells = (
            f'<td class="number">{cell:.6g}</td>' if isinstance(cell, float) else f"<td>{_text(cell)}</td>"
            for cell in row
        )
        lines += f"</tr><tr>{''.join(cells)}"
    return f"<table><tr>{lines}</tr></table>"


def _picture(path: Path) -> str:
    data = base64.b64encode(path.read_bytes()).decode()
    return f'<p><img alt="{_text(path.stem)}" src="data:image/png;base64,{data}"></p>'


def _of_run(folder: Path) -> tuple[Any, ...]:
    summary = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    scene = tomllib.loads((folder / "scene.toml").read_text(encoding="utf-8"))
    parts = _headline(summary, scene)
    parts += [f'<p class="warning">{_text(text)}</p>' for text in summary["warnings"]]
    parts += _targets(summary) + _model(summary) + _uncertainty_of(folder)
    parts += _results(summary, scene) + _energy(summary)
    pictures = draw(folder) if (folder / "history.csv").is_file() else []  # it failed at the start
    parts.append("<h2>Pictures</h2>" + "".join(map(_picture, pictures)))
    if (folder / "fields.xdmf").is_file():
        parts.append(f"<h2>Fields over time</h2>{fields_with_slider(folder)}")
    if (folder / "comparison.json").is_file():
        parts += _compared(folder)
    parts += _keys(summary, scene)
    parts.append("<h2>Materials</h2>" + _materials(summary))
    parts.append("<h2>Sources of the closures</h2>")
    parts.append(f"<p>Set of closures: {_text(closures_text(summary['closures']))}</p>")
    parts.append(_table(["of", "source"], [[name, source] for name, source in summary["sources"].items()]))
    versions = {"computed": summary["date"], **summary["versions"]}
    parts.append("<h2>Date and versions</h2>" + _table(["of", "version"], list(versions.items())))
    return f"Heating of a {scene['geometry']['kind']}: {folder.name}", "".join(parts)


def _headline(summary: dict[str, Any], scene: dict[str, Any]) -> list[str]:
    """How it ended, targets and heating time."""
    parts, time = [], summary["heating_time"]
    if summary["status"] != "done":
        parts.append(
            f'<p class="warning">This run is {_text(summary["status"])}: {_text(summary["failure"] or "")}</p>'
        )
    reached = f"{time:.0f} s ({time / 60:.1f} min)" if time is not None else "not reached"
    estimated = summary["heating_time_error"]
    known = f", numerical error about {estimated:.1%}" if estimated is not None else ""
    met = summary["targets"].values()
    if met:
        last = f"all met at {max(met) / 60.0:.1f} min" if None not in met else "not all met"
        parts.append(f'<p class="large">Targets: {last}</p>')
    if time is not None or not met:
        margin = scene["operation"]["heating_margin"]
        parts.append(f'<p class="large">Heating time: {reached}{known} (wall within {margin:g} K of the inlet)</p>')
    return parts


def _results(summary: dict[str, Any], scene: dict[str, Any]) -> list[str]:
    bounds = summary["temperature_bounds"] or [float("nan")] * 2
    modelled = _text(modelled_part(scene["geometry"]))
    return [
        f"<h2>Result</h2><p>Mass flow and heat are those of the modelled part: {modelled}.</p>",
        _table(["quantity", "value", "unit"], [
            ["heating time of the wall's bed side", *_or_dash(summary["heating_time_bed_side"], "s")],
            ["mass flow at the start", *_or_dash(summary["mass_flow_initial"], "kg/s")],
            ["mass flow at the end", *_or_dash(summary["mass_flow_final"], "kg/s")],
            ["heat from the fluid", *_or_dash(summary["heat_by_fluid"], "J")],
            ["heat to bring the fluid to the inlet temperature", *_or_dash(summary["fluid_heat"], "J")],
            ["pumping work", *_or_dash(summary["pumping_work"], "J")],
            ["relative imbalance of the heat balance", *_or_dash(summary["energy_imbalance"], "1")],
            ["lowest and highest temperature", f"{bounds[0] - 273.15:.2f} to {bounds[1] - 273.15:.2f}", "°C"],
            ["time steps", str(summary["time_steps"]), ""],
            ["outer wall", outer_wall_text(scene["operation"]), ""],
            ["unknowns (flow, energy)", f"{summary['unknowns']['flow']}, {summary['unknowns']['energy']}", ""],
        ]),
    ]  # fmt: skip


def _keys(summary: dict[str, Any], scene: dict[str, Any]) -> list[str]:
    """The scene as it was run."""
    given = summary["given"]
    rows = [
        [name, given.get(name, "-"), _value(value), *unit_and_meaning(KEYS, name)]
        for name, value in flat(scene).items()
        if not name.startswith("materials.") and (name in given or not name.startswith("tolerance."))
    ]
    return [
        "<h2>Scene</h2>",
        "<p>Keys as set in the scene, and all values in SI, defaults included.</p>",
        _table(["key", "as given", "value (SI)", "unit", "meaning"], rows),
    ]


def _compared(folder: Path) -> Any:
    """What `porousmold compare` left in the folder."""
    try:
        return _comparison(folder, json.loads((folder / "comparison.json").read_text(encoding="utf-8")))
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        return ['<p class="warning">The comparison in the folder is damaged: make it again by porousmold compare.</p>']


def _comparison(folder: Path, found: Any) -> list[Any]:
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
        f"<h2>Beside the measurement</h2><p>S_ave = {found['average_deviation']:.3f} K</p>",
        _table(head, rows),
        _picture(folder / "comparison.png"),
    ]


def _or_dash(value: float | None, unit: str) -> tuple[str, str]:
    """A value (SI) in the unit that readers prefer, and that unit."""
    (shown,), sign = preferred_unit([value], unit)
    return ("-" if shown is None else f"{shown:.4g}"), sign


def _value(value: Any) -> Any:
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else value


def _model(summary: Any) -> list[str]:
    """What the chosen model leaves out."""
    found = summary.get("model_choice")
    if found is None:
        return []
    rows = [
        [
            one["leaves_out"],
            f"{one['key']} = {one['value']}" if one["value"] is not None else f"no {one['key']}",
            "left out" if one["chosen"] else "kept",
            f"{one['worth']:+.3%}" if one["worth"] is not None else "-",
            one["reason"],
        ]
        for one in found["choices"]
    ]
    head = ["what", "by", "", "changes the heating time by", "why it is kept"]
    return [
        "<h2>Model</h2>",
        f"<p>{_text(model_text(found))}. Differences of runs on coarse cells.</p>",
        _table(head, rows),
    ]


def _targets(summary: Any) -> list[str]:
    rows = [
        [
            name,
            summary["target_meanings"][name] + kept_text(summary["targets_kept"].get(name)),
            *((time / 60.0, "min") if time is not None else ("not met", "")),
        ]
        for name, time in summary["targets"].items()
    ]
    return ["<h2>Targets</h2>", _table(["name", "asks for", "met at", ""], rows)] if rows else []


def _energy(summary: Any) -> list[str]:
    energy = summary["energy"]
    if energy is None:
        return []
    rows = [
        [words, energy[name] / JOULES_A_KWH, "kWh", "given" if name in ENERGY_GIVEN else "taken"]
        for name, words in ENERGY_NAMES.items()
        if energy[name]
    ]
    rows += [["largest power of heater and blower", energy["peak_power"] / 1e3, "kW", ""]]
    rows += [["cost of heater and blower", float(energy["cost"]), "", ""]] if energy["cost"] is not None else []
    sentence = f"<p>Of the whole tool, {energy['share']:g} times the modelled part, up to the end of the run.</p>"
    return ["<h2>Energy</h2>", sentence, _table(["of", "energy", "unit", ""], rows)]


def _materials(summary: Any) -> str:
    rows = [
        [owner, entry["material"], name.replace("_", " "), float(law["value"]), law["unit"], law["source"]]
        for owner, entry in summary["materials"].items()
        for name, law in entry["properties"].items()
    ]
    mean = next(iter(summary["materials"].values()))["temperature"] - 273.15
    head = ["of", "material", "property", f"value at {mean:.0f} °C", "unit", "source"]
    return _table(head, rows)


def _uncertainty_of(folder: Path) -> list[str]:
    """That of the run's scene, where it was computed beside it."""
    beside = folder.with_name(f"{folder.name}-uncertainty")
    return ["<h2>Uncertainty</h2>", _uncertainty(beside)] if (beside / "uncertainty.json").is_file() else []


def _uncertainty(folder: Path) -> str:
    """What `porousmold uncertainty` left in the folder."""
    try:
        found = json.loads((folder / "uncertainty.json").read_text(encoding="utf-8"))
        rows = [
            [entry["name"], entry["tolerance"], f"{entry['deviation']:+.2%}", f"{found['shares'][entry['name']]:.0%}"]
            if entry["deviation"] is not None
            else [entry["name"], entry["tolerance"], "-", entry["reason"]]
            for entry in found["contributions"]
        ]
        sentence, words = str(found["sentence"]), str(found["of"])
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise InputError("RUN", str(folder), f"has a damaged uncertainty.json: {error}") from error
    head = ["of", "tolerance", f"standard deviation of the {words}", "share of the variance"]
    return f'<p class="large">{_text(sentence)}</p>' + _table(head, rows)


def _optimum(folder: Path) -> str:
    """What `porousmold optimum` left in the folder: the answer."""
    try:
        found = json.loads((folder / "optimum.json").read_text(encoding="utf-8"))
        best, limits = (
            found["optimum"],
            ", ".join(f"{name} below {limit:.6g}" for name, limit in found["below"].items()),
        )
        rows = [] if best is None else [[name, _value(value)] for name, value in best.items()]
    except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
        raise InputError("RUN", str(folder), f"has a damaged optimum.json: {error}") from error
    under = f" with {limits}" if limits else ""
    answer = "" if best is None else f": {best[found['minimise']]:.6g}"
    sentence = f"Least {found['minimise']}{under}{answer or ': no case keeps the limits'}"
    return f'<p class="large">{_text(sentence)}</p>' + (_table(["of", "value (SI)"], rows) if rows else "")


def _search(folder: Path) -> str:
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
    return f'<p class="large">Target: {_text(record)} = {_shown(target, unit)}, by a single change</p>' + _table(
        head, rows
    )


def _shown(value: float | None, unit: str) -> str:
    """A value (SI) with the unit that readers prefer."""
    return " ".join(_or_dash(value, unit)).strip()


def _of_study(folder: Path) -> tuple[Any, ...]:
    entries, head = read_study(folder)
    rows = [
        [float(v) if isinstance(v, int | float) else ("-" if v is None else v) for v in e.values()] for e in entries
    ]
    statuses = [entry["status"] for entry in entries]
    counts = ", ".join(f"{statuses.count(status)} {status}" for status in dict.fromkeys(statuses))
    body = _optimum(folder) if (folder / "optimum.json").is_file() else ""
    body += _uncertainty(folder) if (folder / "uncertainty.json").is_file() else ""
    if (folder / "solve_for.json").is_file():  # its table is that of the last run tried
        return f"What must change: {folder.name}", body + _search(folder)
    draw_study(folder, entries, head)
    body += f"<p>{len(entries)} case{'s' if len(entries) != 1 else ''}: {_text(counts)}.</p>"
    body += "".join(_picture(path) for path in sorted(folder.glob("*.png"))) + _table(head, rows)
    return f"Study: {folder.name}", body
