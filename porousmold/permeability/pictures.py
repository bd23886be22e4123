"""Pictures of a falling-head test, like figures 4.7, 4.10 and 4.11 of the thesis."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..output.figures import STYLE, plt, save
from .falling_head import APPROACHES, instantaneous

if TYPE_CHECKING:
    from .falling_head import Levels
    from .measurement import Test

_LABELS = {
    "complete": "set-up and gravity (4.11, 4.13)",
    "neither": "neither (4.14, 4.15)",
    "gravity": "gravity (4.16, 4.17)",
}


def draw_test(path: Path, test: "Test", levels: "Levels", found: Any) -> Path:
    """Instantaneous permeabilities; levels with the fitted falls and, where it was measured, the baseline. Gives the path."""
    setup, middle = test.setup, 0.5 * (levels.time[1:] + levels.time[:-1])
    with plt.rc_context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(11.5, 4.6))
        figure.subplots_adjust(left=0.075, right=0.985, bottom=0.13, top=0.97, wspace=0.2)
        for number, approach in enumerate(APPROACHES):
            colour = f"C{number}"
            left.plot(middle, instantaneous(setup, levels, approach), ".", color=colour, label=_LABELS[approach])
            fitted = found["approaches"][approach]["global"]
            if fitted is not None:
                left.axhline(fitted.permeability, color=colour, linewidth=1.0)
                label = f"{_LABELS[approach]}, R² = {fitted.determination:.4f}"
                right.plot(
                    levels.time,
                    1e3 * setup.level(levels.time, fitted.permeability, approach),
                    color=colour,
                    label=label,
                )
        right.plot(levels.time, 1e3 * levels.level, "k.", markersize=4, label="measured")
        if test.baseline is not None:
            right.plot(test.baseline.time, 1e3 * test.baseline.level, "0.6", linestyle="--", label="without beads")
        left.set(xlabel="time, s", ylabel="permeability, m²")
        fits = [
            methods["global"].permeability for methods in found["approaches"].values() if methods["global"] is not None
        ]
        left.set_ylim(0.0, 2.0 * max(fits) if fits else None)  # without c1 the end of a test diverges
        right.set(xlabel="time, s", ylabel="level above the bed, mm")
        for axes in (left, right):
            axes.legend(fontsize=8)
        return save(figure, path)


def draw_accuracies(path: Path, found: Any, error: float) -> Path:
    """Error of the permeability at 95 % confidence against permeability, by liquid: {name: row of `Accuracy`}. Gives the path."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(7.5, 4.8))
        figure.subplots_adjust(left=0.1, right=0.98, bottom=0.12, top=0.97)
        for name, row in found.items():
            errors = np.array([a.error if np.isfinite(a.error) else np.nan for a in row])
            axes.loglog([a.permeability for a in row], errors, "o-", markersize=4, label=name)
        axes.axhline(error, color="0.5", linestyle="--", linewidth=1.0, label="asked for")
        axes.set(xlabel="permeability, m²", ylabel="relative error, 95 % of the tests")
        axes.legend()
        return save(figure, path)
