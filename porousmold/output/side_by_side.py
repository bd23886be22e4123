"""Two runs side by side: what differs between their scenes, their results, and their curves over each other."""

import json
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..files.atomic_files import output_file, output_folder
from ..files.units import preferred_unit
from ..scene.features import KEYS
from ..scene.keys import flat, kind_of
from .figures import STYLE, plt, save
from .quantities import Columns
from .stored import read_table

RESULTS = {
    "heating_time": "s",
    "heating_time_bed_side": "s",
    "end_time": "s",
    "mass_flow_initial": "kg/s",
    "mass_flow_final": "kg/s",
    "heat_by_fluid": "J",
    "energy_spent": "J",
    "mean_power": "W",
    "energy.spent": "J",
    "energy.peak_power": "W",
    "bead_reynolds_number": "1",
}
CURVES = {
    "inlet_temperature": ("inlet temperature in °C", 273.15),
    "outlet_temperature": ("mean outlet temperature in °C", 273.15),
    "lowest_bed_side": ("coldest point of the wall's bed side in °C", 273.15),
    "highest_bed_side": ("hottest point of the wall's bed side in °C", 273.15),
    "mass_flow": ("mass flow of the modelled part in kg/s", 0.0),
    "heater_power": ("heater of the whole tool in W", 0.0),
}
"""Columns of the history that are drawn over each other: their titles, and what is taken off."""
STYLES = (("-", "tab:blue"), ("--", "tab:orange"))


def beside(first: Path, second: Path, out: Path) -> str:
    """Write beside.json and beside.png into `out`; gives the table as text.

    Raises `InputError` where a folder holds no finished run, or the files cannot be written.
    """
    runs = [_read(Path(folder)) for folder in (first, second)]
    scenes = [flat(run[1]) for run in runs]
    differing = {
        name: [scene.get(name) for scene in scenes]
        for name in dict.fromkeys([*scenes[0], *scenes[1]])
        if scenes[0].get(name) != scenes[1].get(name)
    }
    summaries = [run[0] for run in runs]
    results = {name: [_entry(summary, name) for summary in summaries] for name in RESULTS}
    targets = dict.fromkeys(name for summary in summaries for name in summary["targets"])
    results |= {f"targets.{name}": [summary["targets"].get(name) for summary in summaries] for name in targets}
    results = {name: values for name, values in results.items() if any(value is not None for value in values)}
    output_folder(out)
    content = {"runs": [str(first), str(second)], "scenes": differing, "results": results}
    with output_file(out / "beside.json") as temporary:
        temporary.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    picture = _draw([run[2] for run in runs], [Path(first).name, Path(second).name], out)
    return _text(content, out, picture)


def _read(folder: Path) -> tuple[dict[str, Any], dict[str, Any], Columns]:
    try:
        summary = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        scene = tomllib.loads((folder / "scene.toml").read_text(encoding="utf-8"))
        return summary, scene, read_table(folder / "history.csv")
    except (OSError, ValueError, LookupError) as error:
        reason = f"no {Path(error.filename).name}" if isinstance(error, FileNotFoundError) else str(error)
        raise InputError("RUN", str(folder), f"is not the folder of a whole run: {reason}") from error


def _entry(summary: object, name: str) -> Any:
    for part in name.split("."):
        summary = summary.get(part) if isinstance(summary, dict) else None
    return summary


def _draw(histories: list[Columns], names: list[str], out: Path) -> Path:
    shown = [name for name in CURVES if any(name in history for history in histories)]
    with plt.rc_context(STYLE):
        rows = (len(shown) + 1) // 2
        figure, axes = plt.subplots(rows, 2, figsize=(11.0, 2.6 * rows + 0.6), sharex=True, squeeze=False)
        height = 2.6 * rows + 0.6
        figure.subplots_adjust(
            left=0.07, right=0.98, bottom=0.55 / height, top=1.0 - 0.6 / height, hspace=0.25, wspace=0.2
        )
        for name, panel in zip(shown, axes.flat, strict=False):
            title, datum = CURVES[name]
            for history, (style, colour), run in zip(histories, STYLES, names, strict=True):
                if name in history:
                    values = np.array(history[name]) - datum
                    panel.plot(np.array(history["time"]) / 60.0, values, style, color=colour, label=run)
            panel.set_title(title, fontsize=9)
        for panel in axes.flat[len(shown) :]:
            panel.set_visible(False)
        for panel in axes.flat[: len(shown)][-2:]:
            panel.set_xlabel("time in min")
            panel.tick_params(labelbottom=True)
        figure.legend(*axes.flat[0].get_legend_handles_labels(), loc="upper center", ncols=2, fontsize=9)
        return save(figure, out / "beside.png")


def _row(name: str, values: list[Any], unit: str) -> str:
    """A line of the table; numbers in one unit that suits both."""
    if all(value is None or _is_number(value) for value in values):
        values, unit = preferred_unit(values, unit)
    texts = [_short(value) for value in values]
    return f"  {f'{name} {unit}'.strip():38s} {texts[0]:>18s} {texts[1]:>18s}"


def _short(value: object) -> str:
    """A value in few characters."""
    if value is None:
        return "-"
    return f"{value:.6g}" if _is_number(value) else str(value)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _text(content: Mapping[str, Any], out: Path, picture: Path) -> str:
    lines = ["the scenes differ in" if content["scenes"] else "the scenes are the same"]
    lines += [_row(name, values, kind_of(KEYS, name)) for name, values in content["scenes"].items()]
    lines.append("results")
    for name, (a, b) in content["results"].items():
        ratio = f"   x {b / a:.4f}" if a and b is not None else ""
        lines.append(_row(name, [a, b], RESULTS.get(name, "s")) + ratio)
    return "\n".join([*lines, f"written to {out}: beside.json, {picture.name}"])
