"""Pictures of a run, drawn from the files in its folder (one process, no MPI)."""

import json
import math
import multiprocessing
import re
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from scipy import sparse

from ..arrays import Floats, Integers
from ..errors import InputError
from ..files.xdmf import read_fields
from .figures import STYLE, plt, save
from .quantities import ENERGY_GIVEN, ENERGY_NAMES, JOULES_A_KWH, History, quantity
from .result_keys import Summary
from .slices import slice_of, triangles_of
from .stored import locked_folder, read_table, require_run
from .surface import draw_surface, in_three_dimensions

PLACES = {
    "centre": ("bed centre", "-"),
    "bed_side": ("wall, bed side", "--"),
    "outer": ("wall, outside", ":"),
    "opposite_bed_side": ("opposite bed side", "-."),
}
LEAST_DIFFERENCE = 0.3
"""Of temperatures (K), that can be seen."""
FRAMES_A_SECOND = 8
BUTTONS = {
    "fa-minus": "&minus;",
    "fa-fast-backward": "|&lt;",
    "fa-step-backward": "&lt;",
    "fa-play fa-flip-horizontal": "&#9664;",
    "fa-pause": "||",
    "fa-play": "&#9654;",
    "fa-step-forward": "&gt;",
    "fa-fast-forward": "&gt;|",
    "fa-plus": "+",
}
"""Of the fields with a slider, by matplotlib's names."""
MOST_TIMES = 6
"""Drawn below one another."""
INSIDE = 1e-6
"""Of the mesh's width: how far inside it lies the section that shows its plane of symmetry."""
# Margins are given, not found: letting matplotlib measure them doubles the time of every picture.


def draw(folder: Path, processes: int = 1, kind: str = "png") -> list[Path]:
    """Draw every picture that the folder's files allow, so many at a time, as files of a `kind` (png, pdf, svg); gives the paths.

    Raises `InputError` if it holds no run, or another process is at work there.
    """
    folder = Path(folder)
    if not (folder / "result.json").is_file() or not (folder / "history.csv").is_file():
        raise InputError("RUN", str(folder), "is not the folder of a run (no result.json and history.csv)")
    require_run(folder)
    try:
        summary = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        marks, targets, energy = marks_of(summary), summary["targets"], summary["energy"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError("RUN", str(folder), f"has a damaged result.json: {error}") from error
    with locked_folder(folder, "drawn"), plt.rc_context(STYLE | {"savefig.format": kind}):
        history = read_table(folder / "history.csv")
        pictures = [partial(_temperatures, folder, history, marks)]
        if targets or _layers_of(history):
            pictures.append(partial(_skin, folder, history, marks))
        if energy is not None:
            pictures.append(partial(_supply, folder, history, energy))
        if (folder / "profiles.csv").is_file():
            pictures.append(partial(_profiles, folder, summary["cycles"]))
        if (folder / "near_wall.csv").is_file():
            pictures.append(partial(_near_wall, folder))
        if (folder / "fields.xdmf").is_file():
            pictures.append(partial(_fields, folder))
            if in_three_dimensions(folder):
                pictures.append(partial(draw_surface, folder, *time_unit(summary["end_time"])))
        if processes == 1:
            return [picture() for picture in pictures]
        with ProcessPoolExecutor(processes, multiprocessing.get_context("fork")) as pool:
            drawing = [pool.submit(picture) for picture in reversed(pictures)]  # the longest first
            return [one.result() for one in reversed(drawing)]


def time_unit(end: float) -> tuple[str, float]:
    """Sign and size (s) of the unit of all times in the pictures of a run that ends at a time (s)."""
    return next(
        (sign, size)
        for sign, size, most in (("s", 1.0, 600.0), ("min", 60.0, 36e3), ("h", 3600.0, math.inf))
        if end <= most
    )


def marks_of(summary: Summary) -> dict[str, float]:
    """Times (s) to be marked in pictures, of the content of result.json, by what they are called there."""
    sign, size = time_unit(summary["end_time"])
    times = {"heated": summary["heating_time"], **summary["targets"]}
    return {f"{name}, {time / size:.4g} {sign}": time for name, time in times.items() if time is not None}


def _temperatures(folder: Path, history: History, marks: Mapping[str, float]) -> Path:
    figure, axes = plt.subplots(figsize=(9.5, 5.0))
    figure.subplots_adjust(left=0.08, right=0.8, bottom=0.11, top=0.97)
    draw_temperatures(axes, history, marks)
    return save(figure, folder / "temperatures.png")


def _time_axis(history: History) -> tuple[Floats, str, float]:
    """Times as they are drawn, their unit, and the factor on seconds."""
    sign, size = time_unit(history["time"][-1])
    return np.array(history["time"]) / size, sign, 1.0 / size


def draw_temperatures(axes: Axes, history: History, marks: Mapping[str, float]) -> None:
    """Draw temperatures against time: `history` has columns by name, `marks` times (s) by what they are called."""
    times, unit, scale = _time_axis(history)
    labels = list(dict.fromkeys(name.rsplit("_", 1)[1] for name in history if name.startswith("temperature_")))
    colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.85, len(labels)))
    shown = [p for p in PLACES if any(name.startswith(f"temperature_{p}") for name in history) and _is_seen(p, history)]
    for label, colour in zip(labels, colours, strict=True):
        for place in shown:
            name, dashes = f"temperature_{place}_{label}", PLACES[place][1]
            if name in history:
                axes.plot(times, np.array(history[name]) - 273.15, dashes, color=colour, linewidth=1.6)
    axes.plot(times, np.array(history["inlet_temperature"]) - 273.15, color="0.4", linewidth=1.0)
    entries = [
        plt.Line2D([], [], color=colour, label=f"z = {label}") for label, colour in zip(labels, colours, strict=True)
    ]
    entries += [plt.Line2D([], [], color="k", linestyle=PLACES[p][1], label=PLACES[p][0]) for p in shown]
    entries.append(plt.Line2D([], [], color="0.4", linewidth=1.0, label="inlet"))
    if not np.array_equal(history["set_point"], history["inlet_temperature"]):
        axes.plot(times, np.array(history["set_point"]) - 273.15, "--", color="0.6", linewidth=1.0)
        entries.append(plt.Line2D([], [], color="0.6", linestyle="--", linewidth=1.0, label="set-point"))
    entries += _mark(axes, marks, scale)
    axes.set(xlabel=f"time in {unit}", ylabel="temperature in °C", xlim=(0, times[-1] or 1))
    axes.legend(handles=entries, fontsize=9, loc="center left", bbox_to_anchor=(1.01, 0.5))


def _is_seen(place: str, history: History) -> bool:
    """Whether a place has curves of its own: the wall's outside has none where it is as warm as the bed side."""
    if place != "outer":
        return True
    pairs = [(name, name.replace("_outer_", "_bed_side_")) for name in history if name.startswith("temperature_outer_")]
    return any(
        other not in history or np.max(np.abs(np.array(history[name]) - np.array(history[other]))) > LEAST_DIFFERENCE
        for name, other in pairs
    )


def _mark(axes: Axes, marks: Mapping[str, float], scale: float) -> list[Any]:
    """Vertical lines at times (s), drawn times the scale, and their entries of the legend."""
    colours = ["tab:red", "tab:green", "tab:purple", "tab:orange", "tab:brown"]
    entries = []
    for number, (label, time) in enumerate(marks.items()):
        colour = colours[number % len(colours)]
        axes.axvline(scale * time, color=colour, linewidth=1.2)
        entries.append(plt.Line2D([], [], color=colour, label=label))
    return entries


def _layers_of(history: History) -> list[str]:
    """Names of the wall's layers that have columns of their own."""
    plain = ("temperature", "wall", "bed", "bed_side")
    return [name.removeprefix("lowest_") for name in history if name.startswith("lowest_") and name[7:] not in plain]


def _skin(folder: Path, history: History, marks: Mapping[str, float]) -> Path:
    """How hot the wall's layers are, how even they and the wall's bed side are, where that is coldest and hottest, and how far
    layers have cured."""
    times, unit, scale = _time_axis(history)
    layers, cured = _layers_of(history), [name for name in history if name.startswith("cure_")]
    rows = bool(layers) + 2 + bool(cured)
    ratios = [1.0 + 0.2 * max(len(layers) - 1, 0)] * bool(layers) + [1.0] * (rows - bool(layers))
    size = 9.5, 2.2 * sum(ratios) + 0.6
    figure, all_axes = plt.subplots(rows, 1, figsize=size, sharex=True, height_ratios=ratios)
    height = figure.get_size_inches()[1]
    beside = {"fontsize": 8, "loc": "center left", "bbox_to_anchor": (1.01, 0.5)}
    figure.subplots_adjust(left=0.09, right=0.79, bottom=0.55 / height, top=1.0 - 0.15 / height, hspace=0.12)
    axes = list(all_axes)
    if layers:
        panel = axes.pop(0)
        for number, name in enumerate(layers):
            low, high = (np.array(history[f"{end}_{name}"]) - 273.15 for end in ("lowest", "highest"))
            panel.fill_between(times, low, high, color=f"C{number}", alpha=0.12, linewidth=0.0)
            panel.plot(times, high, color=f"C{number}", linewidth=1.4, label=f"{name}, hottest")
            panel.plot(times, low, "--", color=f"C{number}", linewidth=1.4, label=f"{name}, coldest")
        panel.plot(times, np.array(history["inlet_temperature"]) - 273.15, color="0.4", linewidth=1.0, label="inlet")
        panel.set_ylabel("temperature\nin °C", fontsize=9)
        panel.legend(**beside)
    for number, name in enumerate((*layers, "bed_side")):
        low, high = (np.array(history[f"{end}_{name}"]) for end in ("lowest", "highest"))
        colour = f"C{number}" if number < len(layers) else "black"
        axes[0].plot(times, high - low, color=colour, label=name.replace("_", " "))
    axes[0].set_ylabel("hottest minus\ncoldest in K", fontsize=9)
    axes[0].set_ylim(0, 1.2 * float(np.max(high - low)) or None)  # insulation leaves the picture
    shown = axes[0].get_legend_handles_labels()[0] if layers else []
    if shown or marks:
        axes[0].legend(handles=[*shown, *_mark(axes[0], marks, scale)], **beside)
    for end, colour in (("coldest", "tab:blue"), ("hottest", "tab:red")):
        axes[1].plot(times, history[f"{end}_place"], color=colour, label=end)
    axes[1].set_ylabel("along the flow\nin m", fontsize=9)
    axes[1].legend(**beside)
    for name in cured:
        axes[2].plot(times, history[name], label=name.removeprefix("cure_"))
        axes[2].set_ylabel("least degree\nof cure", fontsize=9)
        axes[2].set_ylim(0, 1)
        axes[2].legend(**beside)
    axes[-1].set(xlabel=f"time in {unit}", xlim=(0, times[-1] or 1))
    return save(figure, folder / "skin.png")


def _supply(folder: Path, history: History, energy: Mapping[str, float]) -> Path:
    """Powers of heater and blower against time, and where their energy went."""
    times, unit, _ = _time_axis(history)
    figure, (powers, uses) = plt.subplots(1, 2, figsize=(11.0, 3.8), width_ratios=(1.3, 1.0))
    figure.subplots_adjust(left=0.07, right=0.98, bottom=0.15, top=0.9, wspace=0.32)
    for name, colour in (("heater_power", "tab:red"), ("blower_power", "tab:blue")):
        powers.plot(times, np.array(history[name]) / 1e3, color=colour, label=name.removesuffix("_power"))
    powers.set(xlabel=f"time in {unit}", ylabel="power in kW", xlim=(0, times[-1] or 1), ylim=(0, None))
    powers.set_title("whole tool", fontsize=10)
    powers.legend(fontsize=9)
    shown = {name: energy[name] for name in ENERGY_NAMES if abs(energy[name]) > 0.0}
    colours = ["tab:red" if name in ENERGY_GIVEN else "tab:gray" for name in shown]
    uses.barh([ENERGY_NAMES[name] for name in shown], [value / JOULES_A_KWH for value in shown.values()], color=colours)
    uses.invert_yaxis()
    uses.set_xlabel("energy in kWh")
    uses.set_title("given (red) and where it went (grey)", fontsize=10)
    uses.grid(axis="y", visible=False)
    return save(figure, folder / "supply.png")


def _profiles(folder: Path, cycles: Sequence[Mapping[str, object]]) -> Path:
    """Temperatures along the bed at the times asked for, and at the ends of the phases of the first and the last cycle; and what
    each cycle gave back."""
    table = read_table(folder / "profiles.csv")
    several, along = len(cycles) > 1, table["distance_from_inlet"]
    width = 8.0 + 4.0 * several
    shares = (2.0, 1.0) if several else (1.0,)
    figure, panels = plt.subplots(1, len(shares), figsize=(width, 4.2), squeeze=False, width_ratios=shares)
    figure.subplots_adjust(left=0.75 / width, right=1.0 - 0.2 / width, bottom=0.14, top=0.96, wspace=0.22)
    profiles = panels[0, 0]
    for label, colour, dashes in _profiles_shown(
        [name for name in table if name.startswith("fluid_")], several=several
    ):
        profiles.plot(
            along, np.array(table[f"fluid_{label}"]) - 273.15, dashes, color=colour, label=_profile_label(label)
        )
    profiles.set(xlabel="distance from the inlet in m", ylabel="fluid in °C", xlim=(0, along[-1]))
    profiles.legend(fontsize=9)
    if several:
        _draw_cycles(panels[0, 1], cycles)
    return save(figure, folder / "profiles.png")


def _profiles_shown(names: Sequence[str], *, several: bool) -> list[tuple[str, Any, str]]:
    """(label, colour, dashes) of the profiles in a picture: of times all, of phases those of the first and of the last cycle."""
    labels = [name.removeprefix("fluid_") for name in names]
    of_times = [label for label in labels if re.fullmatch(r"[\d.e+]+ s", label)]
    of_phases = [label.split(" ", 1) for label in labels if label not in of_times]
    colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.9, max(len(of_times), 1)))
    shown: list[tuple[str, Any, str]] = [(label, colour, "-") for label, colour in zip(of_times, colours, strict=False)]
    phases = list(dict.fromkeys(phase for _, phase in of_phases))
    last = max((int(cycle) for cycle, _ in of_phases), default=1)
    for cycle, phase in of_phases:
        if int(cycle) in (1, last):
            dashes = "--" if several and int(cycle) == 1 else "-"
            shown.append((f"{cycle} {phase}", f"C{phases.index(phase)}", dashes))
    return shown


def _profile_label(label: str) -> str:
    first, rest = label.split(" ", 1)
    return label if rest == "s" else f"end of {rest}, cycle {first}"


def _draw_cycles(axes: Axes, cycles: Sequence[Mapping[str, Any]]) -> None:
    for name, words in (
        ("energy_efficiency", "energy"),
        ("exergy_efficiency", "exergy"),
        ("utilisation", "utilisation"),
    ):
        values = [math.nan if cycle[name] is None else 100.0 * cycle[name] for cycle in cycles]
        axes.plot([cycle["cycle"] for cycle in cycles], values, ".-", label=words)
    axes.set(xlabel="cycle", ylabel="given back in %", ylim=(0, None))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(fontsize=9)


def _near_wall(folder: Path) -> Path:
    profile = read_table(folder / "near_wall.csv")
    distance = np.array(profile["wall_distance"]) * 1e3
    names = ("porosity", "speed", "eddy_viscosity_ratio", "turbulent_kinetic_energy")
    panels = [(name, quantity(name).axis_label) for name in names if name in profile]
    figure, all_axes = plt.subplots(1, len(panels), figsize=(3.4 * len(panels), 3.4))
    for axes, (name, label) in zip(np.atleast_1d(all_axes), panels, strict=True):
        axes.semilogx(distance[1:], profile[name][1:], color="tab:blue")
        axes.minorticks_off()
        axes.set(xlabel="wall distance in mm", xlim=(distance[1], distance[-1]), ylim=(0, None))
        axes.set_title(label, fontsize=9)
    figure.suptitle("at half length, end of the run", fontsize=10, y=0.99)
    width = figure.get_figwidth()
    figure.subplots_adjust(left=0.6 / width, right=1.0 - 0.15 / width, bottom=0.16, top=0.84, wspace=0.28)
    return save(figure, folder / "near_wall.png")


class _Section(NamedTuple):
    """What one column of the fields' picture shows: a field on triangles of places, of which `weights` give the values."""

    title: str
    field: str
    along: str
    x: Floats
    y: Floats
    triangles: Floats
    weights: Any

    def draw(self, axes: Axes, fields: Mapping[str, Floats], levels: Floats) -> Any:
        """Draw the field of a time as filled contours, with the interface of bed and wall."""
        bed, values = self.weights @ fields["in_bed"] > 0.99, self.weights @ fields[self.field] - 273.15
        in_bed = np.all(bed[self.triangles], axis=1)
        shapes = self.triangles[in_bed] if self.field == "bead_temperature" else self.triangles
        drawn = axes.tricontourf(self.x, self.y, shapes, values, levels=levels, cmap="inferno")
        axes.set_ylim(self.y.min(), self.y.max())
        if np.any(~bed):
            axes.tricontour(self.x, self.y, self.triangles, bed, levels=[0.99], colors="w", linewidths=0.7)
        axes.grid(False)
        return drawn


def _sections(nodes: Floats, cells: Integers) -> list[_Section]:
    """Of a flat mesh fluid and beads; of another one the plane of symmetry and a section across the flow."""
    if nodes.shape[1] == 2:
        everything = nodes[:, 0], 1e3 * nodes[:, 1], triangles_of(cells), sparse.identity(len(nodes), format="csr")
        named = (("fluid and wall", "temperature"), ("beads", "bead_temperature"))
        return [_Section(title, name, "along the flow in m", *everything) for title, name in named]
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    middle = 0.5 * (low[0] + high[0])
    cuts = (
        ("fluid and wall, plane of symmetry", "along the flow in m", 1.0, 2, low[2] + INSIDE * (high[2] - low[2])),
        (f"fluid and wall, {middle - low[0]:.2g} m from the inlet", "beside the middle in mm", 1e3, 0, middle),
    )
    sections = []
    for title, along, unit, axis, value in cuts:
        places, triangles, weights = slice_of(nodes, cells, axis, value)
        x, y = unit * places[:, 0], 1e3 * places[:, 1]
        sections.append(_Section(title, "temperature", along, x, y, triangles, weights))
    return sections


def _levels(steps: Mapping[float, Mapping[str, Floats]]) -> tuple[Floats, list[float]]:
    """Contours (°C) over all times, and ticks among them."""
    shown = ("temperature", "bead_temperature")
    reached = np.concatenate([fields[name] for fields in steps.values() for name in shown if name in fields]) - 273.15
    reached = reached[np.isfinite(reached)]
    levels = np.linspace(reached.min(), reached.max() + 1e-9, 25)
    ticks = MaxNLocator(6).tick_values(reached.min(), reached.max())
    return levels, [tick for tick in ticks if levels[0] <= tick <= levels[-1]]


def _fields(folder: Path) -> Path:
    nodes, cells, steps = read_fields(folder / "fields.xdmf")
    sections, (levels, ticks), times = _sections(nodes, cells), _levels(steps), sorted(steps)
    times = [
        times[n] for n in np.unique(np.linspace(0, len(times) - 1, min(len(times), MOST_TIMES)).round().astype(int))
    ]
    figure, axes = plt.subplots(len(times), 2, figsize=(11.0, 1.5 * len(times) + 0.9), squeeze=False, sharex="col")
    figure.subplots_adjust(
        left=0.08, right=0.88, bottom=0.4 / (len(times) + 0.6), top=1 - 0.25 / (len(times) + 0.6), hspace=0.2
    )
    for column, section in enumerate(sections):
        axes[0, column].set_title(section.title)
        axes[-1, column].set_xlabel(section.along)
        for row, time in enumerate(times):
            drawn = section.draw(axes[row, column], steps[time], levels)
    sign, size = time_unit(times[-1])
    for row, time in enumerate(times):
        axes[row, 0].set_ylabel(f"t = {time / size:.4g} {sign}\nacross in mm", fontsize=9)
    _colour_bar(figure, drawn, ticks)
    return save(figure, folder / "fields.png")


def _colour_bar(figure: Figure, drawn: object, ticks: list[float]) -> None:
    figure.colorbar(drawn, cax=figure.add_axes((0.9, 0.12, 0.015, 0.8)), label="temperature in °C", ticks=ticks)


def animate(folder: Path) -> Path:
    """heating.gif of the fields of a run at all times that were kept (`output.field_times`); gives its path.

    Raises `InputError` if the folder holds no fields, or another process is at work there.
    """
    folder = Path(folder)
    if not (folder / "fields.xdmf").is_file():
        raise InputError("RUN", str(folder), "holds no fields (output.fields)")
    with locked_folder(folder, "drawn"), plt.rc_context(STYLE):
        path = folder / "heating.gif"
        movie = _movie(folder)
        movie.save(path, PillowWriter(fps=FRAMES_A_SECOND), dpi=100)
        plt.close(movie._fig)
    return path


def fields_with_slider(folder: Path) -> str:
    """The fields of a run as HTML with a slider over the times that were kept, everything in it."""
    with plt.rc_context(STYLE | {"figure.dpi": 80}):
        movie = _movie(folder)
        page = movie.to_jshtml(fps=FRAMES_A_SECOND, default_mode="once")
        plt.close(movie._fig)
    for name, sign in BUTTONS.items():  # matplotlib fetches a font for them
        page = page.replace(f'<i class="fa {name}"></i>', sign)
    return re.sub(r"<link[^>]*>", "", page)


def _movie(folder: Path) -> FuncAnimation:
    """An animation of matplotlib: both sections, a frame for each time."""
    nodes, cells, steps = read_fields(folder / "fields.xdmf")
    sections, (levels, ticks), times = _sections(nodes, cells), _levels(steps), sorted(steps)
    sign, size = time_unit(times[-1])
    figure, axes = plt.subplots(1, 2, figsize=(11.0, 2.6))
    figure.subplots_adjust(left=0.08, right=0.88, bottom=0.22, top=0.8)

    def show(time: float) -> None:
        for panel, section in zip(axes, sections, strict=True):
            panel.clear()
            drawn = section.draw(panel, steps[time], levels)
            panel.set(title=section.title, xlabel=section.along)
        axes[0].set_ylabel("across in mm")
        figure.suptitle(f"t = {time / size:.4g} {sign}", x=0.01, ha="left", fontsize=11)
        if len(figure.axes) == len(axes):
            _colour_bar(figure, drawn, ticks)

    return FuncAnimation(figure, show, frames=times, init_func=lambda: None)
