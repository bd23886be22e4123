"""Pictures of a study: curves over one key or two, heat maps over two numbers, parallel coordinates over more."""

import itertools
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from .figures import STYLE, plt, save

Entries = list[Mapping[str, Any]]
MOST_CURVES, MOST_PANELS, PANELS_A_ROW = 8, 6, 2
BEFORE_THE_UNIT = " ["
FEWEST_ANSWERS = 3
"""For a picture of a record."""
LIGHT = 0.6
"""Part of the colours' range from which on they are light."""


class _Study:
    """Cases with an answer, one record of theirs at least: what varies over them, what was recorded, and labels with units.

    `entries` are those of table.json, `head` the head of table.csv."""

    def __init__(self, entries: Sequence[Mapping[str, Any]], head: Sequence[str]) -> None:
        names = list(entries[0]) if entries else []
        end = names.index("status") if "status" in names else 0
        varied, records = names[:end], names[end + 1 : names.index("reason")] if end else []
        self.labels = dict(zip(names, head, strict=False))
        self.known = [entry for entry in entries if any(_is_number(entry[name]) for name in records)]
        self.varied = [name for name in varied if len({str(entry[name]) for entry in self.known}) > 1]
        self.numbers = [name for name in self.varied if all(_is_number(entry[name]) for entry in self.known)]
        self.records = [name for name in records if len(self.having(name)) >= FEWEST_ANSWERS]

    def having(self, *names: str) -> Entries:
        """The cases that have all of these records."""
        return _having(self.known, *names)

    def without(self, *names: str) -> str:
        """How many cases have not, as a title; none where all have."""
        count = len(self.known) - len(self.having(*names))
        return f"without {count} of {len(self.known)} cases, which have no {' or '.join(names)}" if count else ""


def draw_study(folder: Path, entries: Sequence[Mapping[str, Any]], head: Sequence[str]) -> list[Path]:
    """Pictures of a study in its folder; gives their paths.

    curves.png over one number, a curve for each value of a second key; map.png of the first record over two numbers;
    parallel.png over three keys or more. None for a study with fewer than three answers. A picture that lacks cases says so.
    """
    study = _Study(entries, head)
    if not study.records or not study.varied:
        return []
    with plt.rc_context(STYLE):
        drawn = []
        if len(study.varied) <= 2 and study.numbers:
            drawn.append(_curves(folder, study))
        if len(study.numbers) == 2 == len(study.varied):
            drawn += _map(folder, study)
        if len(study.varied) > 2:
            drawn.append(_parallel(folder, study))
    return drawn


def plot_in_terminal(entries: Sequence[Mapping[str, object]], head: Sequence[str]) -> str:
    """The first record over the first key as a picture of characters; a key that holds words is taken in the order of its cases.

    Empty for a study with fewer than two answers. Raises `InputError` without the package plotext.
    """
    study = _Study(entries, head)
    if not study.records or not study.varied:
        return ""
    try:
        import plotext
    except ImportError as error:
        raise InputError("--plot", True, "needs the Python package plotext") from error
    key, record = (study.numbers or study.varied)[0], study.records[0]
    plotext.clear_figure()
    plotext.theme("clear")
    plotext.plotsize(78, 20)
    for (label, members), marker in zip(_families(study, key).items(), itertools.cycle("•x+o*")):
        members = _having(members, record)
        x = [entry[key] for entry in members] if study.numbers else list(range(1, len(members) + 1))
        y = [entry[record] for entry in members]
        plotext.plot(x, y, marker=marker, label=label or None)
    plotext.xlabel(study.labels[key])
    plotext.title(study.labels[record])
    picture = str(plotext.build())
    return picture if sys.stdout.isatty() else str(plotext.uncolorize(picture))


def _having(entries: Entries, *names: str) -> Entries:
    """Those of some cases that have all of these records."""
    return [entry for entry in entries if all(_is_number(entry[name]) for name in names)]


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and bool(np.isfinite(value))


def _families(study: _Study, key: str) -> dict[str, Entries]:
    """The cases in the order of a key, by the values of the others, which are in the name."""
    others = [name for name in study.varied if name != key]
    ordered = sorted(study.known, key=lambda entry: entry[key]) if key in study.numbers else study.known
    named: dict[str, Entries] = {}
    for entry in ordered:
        named.setdefault(", ".join(_with_unit(study.labels[name], entry[name]) for name in others), []).append(entry)
    return named


def _with_unit(label: str, value: object) -> str:
    """A key's label with its value: `wall.thickness = 0.002 m`."""
    name, unit = label.partition(BEFORE_THE_UNIT)[::2]
    return f"{name} = {f'{value:.4g}' if _is_number(value) else value} {unit.rstrip(']')}".rstrip()


def _curves(folder: Path, study: _Study) -> Path:
    key = max(study.numbers, key=lambda name: len({entry[name] for entry in study.known}))
    families, shown = _families(study, key), study.records[:MOST_PANELS]
    columns = min(len(shown), PANELS_A_ROW)
    rows = -(-len(shown) // columns)
    width, height = 1.0 + 4.4 * columns, 3.8 * rows
    figure, all_axes = plt.subplots(rows, columns, figsize=(width, height), squeeze=False)
    sides = {"left": 0.95 / width, "right": 1.0 - 0.1 / width, "bottom": 0.6 / height, "top": 1.0 - 0.3 / height}
    figure.subplots_adjust(**sides, wspace=0.3, hspace=0.25)
    for axes in all_axes.flat[len(shown) :]:
        axes.set_visible(False)
    for axes, name in zip(all_axes.flat, shown, strict=False):
        for label, members in list(families.items())[:MOST_CURVES]:
            shown_here = _having(members, name)
            axes.plot([e[key] for e in shown_here], [e[name] for e in shown_here], "o-", markersize=4, label=label)
        axes.set_title(study.without(name), fontsize=8)
        axes.set(xlabel=study.labels[key], ylabel=study.labels[name])
        _plain_numbers(axes.yaxis)
    if "" not in families:
        all_axes[0, 0].legend(fontsize=8)
    return save(figure, folder / "curves.png")


def _plain_numbers(axis: Any) -> None:
    """No offset added to the numbers of an axis; large ones by a power of ten in multiples of three."""
    from matplotlib.ticker import EngFormatter, ScalarFormatter

    low, high = axis.get_view_interval()
    large = max(abs(low), abs(high)) >= 1e5
    axis.set_major_formatter(EngFormatter(sep="") if large else ScalarFormatter(useOffset=False))


def _map(folder: Path, study: _Study) -> list[Path]:
    x, y = (sorted({entry[name] for entry in study.known}) for name in study.numbers)
    if min(len(x), len(y)) < 2:
        return []
    values = np.full((len(y), len(x)), np.nan)
    for entry in study.known:
        value = entry[study.records[0]]
        values[y.index(entry[study.numbers[1]]), x.index(entry[study.numbers[0]])] = (
            value if _is_number(value) else np.nan
        )
    figure, axes = plt.subplots(figsize=(7.0, 4.6))
    figure.subplots_adjust(left=0.14, right=0.97, bottom=0.14, top=0.95)
    drawn = axes.imshow(values, origin="lower", aspect="auto", cmap="viridis")
    axes.set_xticks(range(len(x)), [f"{value:g}" for value in x])
    axes.set_yticks(range(len(y)), [f"{value:g}" for value in y])
    for (row, column), value in np.ndenumerate(values):
        if np.isfinite(value) and values.size <= 100:
            colour = "k" if drawn.norm(value) > LIGHT else "w"
            axes.text(column, row, f"{value:.4g}", ha="center", va="center", color=colour, fontsize=9)
    axes.set(xlabel=study.labels[study.numbers[0]], ylabel=study.labels[study.numbers[1]])
    axes.grid(False)
    figure.colorbar(drawn, label=study.labels[study.records[0]])
    return [save(figure, folder / "map.png")]


def _parallel(folder: Path, study: _Study) -> Path:
    """A line for each case across one axis for each key and record, coloured by the first record."""
    shown = study.records[:2]
    names, known = [*study.varied, *shown], study.having(*shown)
    columns, ticks = [], []
    for name in names:
        values = [entry[name] for entry in known]
        if name in study.varied and name not in study.numbers:
            words = sorted({str(value) for value in values})
            heights = {word: number / max(len(words) - 1, 1) for number, word in enumerate(words)}
            columns.append(np.array([heights[str(value)] for value in values]))
            ticks.append([(heights[word], word) for word in words])
        else:
            low, high = min(values), max(values)
            columns.append((np.array(values) - low) / ((high - low) or 1.0))
            ticks.append([(part, f"{low + part * (high - low):.4g}") for part in (0.0, 0.5, 1.0)])
    record = np.array([entry[study.records[0]] for entry in known])
    figure, axes = plt.subplots(figsize=(2.0 + 1.7 * len(names), 4.6))
    figure.subplots_adjust(left=0.08, right=0.98, bottom=0.16, top=0.96)
    colours = plt.Normalize(record.min(), record.max() or 1.0)
    for row, value in zip(np.array(columns).T, record, strict=True):
        axes.plot(range(len(names)), row, color=plt.get_cmap("viridis")(colours(value)), linewidth=1.0, alpha=0.8)
    for number, marks in enumerate(ticks):
        axes.axvline(number, color="0.3", linewidth=0.8)
        for height, text in marks:
            axes.annotate(text, (number, height), xytext=(3, 1), textcoords="offset points", fontsize=8)
    labels = [study.labels[name].replace(BEFORE_THE_UNIT, "\n[") for name in names]
    axes.set_xticks(range(len(names)), [label.replace(".", ".\n", 1) for label in labels], fontsize=8)
    axes.set_yticks([])
    axes.set_xlim(-0.1, len(names) - 0.6)
    axes.grid(False)
    axes.set_title(study.without(*shown), fontsize=8)
    figure.colorbar(plt.cm.ScalarMappable(colours, "viridis"), ax=axes, label=study.labels[study.records[0]])
    return save(figure, folder / "parallel.png")
