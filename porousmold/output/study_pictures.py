"""Pictures of a study: curves over one varied number, a heat map over two."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .figures import STYLE, plt, save


def draw_study(folder: Path, entries: Sequence[Mapping[str, Any]], head: Sequence[str]) -> Path | None:
    """curves.png of every record over the one number that varies, or map.png of the first record over two; None for other
    studies.

    `entries` are those of table.json, `head` the head of table.csv.
    """
    names = list(entries[0]) if entries else []
    if "status" not in names:
        return None
    varied, records = names[: names.index("status")], names[names.index("status") + 1 : names.index("reason")]
    labels = dict(zip(names, head, strict=False))
    known = [e for e in entries if all(_is_number(e[name]) for name in (*varied, *records[:1]))]
    if len(known) < 3 or len(varied) not in (1, 2) or not records:
        return None
    with plt.rc_context(STYLE):
        return (_curves if len(varied) == 1 else _map)(folder, known, varied, records, labels)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and bool(np.isfinite(value))


def _curves(
    folder: Path, known: list[Mapping[str, Any]], varied: list[str], records: list[str], labels: Mapping[str, str]
) -> Path:
    ordered = sorted(known, key=lambda entry: entry[varied[0]])
    shown = [name for name in records if all(_is_number(entry[name]) for entry in ordered)][:4]
    figure, all_axes = plt.subplots(1, len(shown), figsize=(1.0 + 4.4 * len(shown), 3.8), squeeze=False)
    figure.subplots_adjust(left=0.9 / (1.0 + 4.4 * len(shown)), right=0.98, bottom=0.16, top=0.96, wspace=0.3)
    for axes, name in zip(all_axes[0], shown, strict=True):
        axes.plot([entry[varied[0]] for entry in ordered], [entry[name] for entry in ordered], "o-")
        axes.set(xlabel=labels[varied[0]], ylabel=labels[name])
    return save(figure, folder / "curves.png")


def _map(
    folder: Path, known: list[Mapping[str, Any]], varied: list[str], records: list[str], labels: Mapping[str, str]
) -> Path | None:
    x, y = (sorted({entry[name] for entry in known}) for name in varied)
    if min(len(x), len(y)) < 2:
        return None
    values = np.full((len(y), len(x)), np.nan)
    for entry in known:
        values[y.index(entry[varied[1]]), x.index(entry[varied[0]])] = entry[records[0]]
    figure, axes = plt.subplots(figsize=(7.0, 4.6))
    figure.subplots_adjust(left=0.14, right=0.97, bottom=0.14, top=0.95)
    drawn = axes.imshow(values, origin="lower", aspect="auto", cmap="viridis")
    axes.set_xticks(range(len(x)), [f"{value:.4g}" for value in x])
    axes.set_yticks(range(len(y)), [f"{value:.4g}" for value in y])
    for (row, column), value in np.ndenumerate(values):
        if np.isfinite(value) and values.size <= 100:
            axes.text(column, row, f"{value:.4g}", ha="center", va="center", color="w", fontsize=8)
    axes.set(xlabel=labels[varied[0]], ylabel=labels[varied[1]])
    axes.grid(False)
    figure.colorbar(drawn, label=labels[records[0]])
    return save(figure, folder / "map.png")
