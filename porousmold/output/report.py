"""One self-contained HTML page about a run or a study, for mailing: everything in it, nothing from a network."""

import base64
import csv
import html
import json
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import ParseError

from .. import __version__
from ..errors import InputError
from ..files.whole_files import output_file
from ..scene.language import KEYS
from .console import closures_text
from .pictures import draw

_STYLE = """
body { font: 15px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; color: #222; }
table { border-collapse: collapse; margin: 1em 0; }
th, td { padding: .2em .8em; text-align: left; border-bottom: 1px solid #ddd; }
td.number { text-align: right; font-variant-numeric: tabular-nums; } img { max-width: 100%; }
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
    time = summary["heating_time"]
    kind = scene["geometry"]["kind"]
    parts = []
    if summary["status"] != "done":
        parts.append(
            f'<p class="warning">This run is {_text(summary["status"])}: {_text(summary["failure"] or "")}</p>'
        )
    reached = f"{time:.0f} s ({time / 60:.1f} min)" if time is not None else "not reached"
    estimated = summary["heating_time_error"]
    known = f", numerical error about {estimated:.1%}" if estimated is not None else ""
    parts.append(f'<p class="large">Heating time: {reached}{known}</p>')
    parts += [f'<p class="warning">{_text(text)}</p>' for text in summary["warnings"]]
    bounds = summary["temperature_bounds"] or [float("nan")] * 2
    parts.append("<h2>Result</h2>")
    parts.append(_table(["quantity", "value", "unit"], [
        ["heating time of the wall's bed side", *_or_dash(summary["heating_time_bed_side"], "s")],
        ["mass flow at the start", *_or_dash(summary["mass_flow_initial"], "kg/s")],
        ["mass flow at the end", *_or_dash(summary["mass_flow_final"], "kg/s")],
        ["heat from the fluid", *_or_dash(summary["heat_by_fluid"], "J")],
        ["heat given to the fluid before it enters", *_or_dash(summary["fluid_heat"], "J")],
        ["work of driving it through the bed", *_or_dash(summary["pumping_work"], "J")],
        ["of the heat unaccounted for", *_or_dash(summary["energy_imbalance"], "1")],
        ["lowest and highest temperature", f"{bounds[0] - 273.15:.2f} to {bounds[1] - 273.15:.2f}", "°C"],
        ["time steps", str(summary["time_steps"]), ""],
        ["unknowns (flow, energy)", f"{summary['unknowns']['flow']}, {summary['unknowns']['energy']}", ""],
    ]))  # fmt: skip
    pictures = draw(folder) if (folder / "history.csv").is_file() else []  # it failed at the start
    parts.append("<h2>Pictures</h2>" + "".join(map(_picture, pictures)))
    if (folder / "comparison.json").is_file():
        parts += _compared(folder)
    parts.append("<h2>Scene</h2>")
    rows = [
        [f"{table}.{name}", float(value) if isinstance(value, int | float) and not isinstance(value, bool) else value,
         _unit(table, name), KEYS[table][name].meaning if name in KEYS.get(table, {}) else ""]
        for table, content in scene.items() for name, value in content.items()
    ]  # fmt: skip
    parts.append(_table(["key", "value (SI)", "unit", "meaning"], rows))
    parts.append("<h2>Sources of the closures and properties</h2>")
    parts.append(f"<p>Set of closures: {_text(closures_text(summary['closures']))}</p>")
    parts.append(_table(["of", "source"], [[name, source] for name, source in summary["sources"].items()]))
    parts.append("<h2>Versions</h2>" + _table(["of", "version"], list(summary["versions"].items())))
    return f"Heating of a {kind}: {folder.name}", "".join(parts)


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


def _or_dash(value: Any, unit: str) -> Any:
    return (float(value), unit) if value is not None else ("-", unit)


def _unit(table: Any, name: str) -> Any:
    return KEYS[table][name].unit if name in KEYS.get(table, {}) else ""


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
        told = f"Heating time {found['heating_time']:.0f} s, 95 % within {found['low']:.0f} to {found['high']:.0f} s"
        sample = found["sample"]
        if sample is not None:
            told += f"; {sample['answered']} sampled cases: {sample['low']:.0f} to {sample['high']:.0f} s"
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise InputError("RUN", str(folder), f"has a damaged uncertainty.json: {error}") from error
    head = ["of", "tolerance", "standard deviation of the heating time", "share of the variance"]
    return f'<p class="large">{_text(told)}</p>' + _table(head, rows)


def _of_study(folder: Path) -> tuple[Any, ...]:
    try:
        entries = json.loads((folder / "table.json").read_text(encoding="utf-8"))
        with (folder / "table.csv").open(newline="", encoding="utf-8") as file:
            head = next(csv.reader(file))
        rows = [
            [float(v) if isinstance(v, int | float) else ("-" if v is None else v) for v in e.values()] for e in entries
        ]
        statuses = [entry["status"] for entry in entries]
    except (OSError, ValueError, KeyError, TypeError, AttributeError, StopIteration) as error:
        raise InputError("RUN", str(folder), f"has a damaged table: {error}") from error
    counts = ", ".join(f"{statuses.count(status)} {status}" for status in dict.fromkeys(statuses))
    body = _uncertainty(folder) if (folder / "uncertainty.json").is_file() else ""
    body += f"<p>{len(entries)} cases: {_text(counts)}.</p>" + _table(head, rows)
    body += "".join(_picture(path) for path in sorted(folder.glob("*.png")))
    return f"Study: {folder.name}", body
