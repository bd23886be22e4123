"""matplotlib for pictures in files: no display, one look. In a notebook its own backend stays."""

import os
import sys
from pathlib import Path

import matplotlib

if "matplotlib.pyplot" not in sys.modules and not os.environ.get("MPLBACKEND", "").startswith("module://"):
    matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.figure import Figure
from matplotlib.text import Text

from ..errors import OutputError
from ..files.atomic_files import whole_file

# a title's height is given, not found: finding it measures every label a second time
STYLE = {"font.size": 11, "axes.grid": True, "grid.alpha": 0.3, "figure.dpi": 130, "axes.titley": 1.0}


def save(figure: Figure, path: Path) -> Path:
    """Write the picture in matplotlib's present savefig.format, close it, and give its path, with that ending. Names of the
    user's that look like formulas but are none stand as text. Raises `OutputError` where there is no room."""
    path = path.with_suffix(f".{plt.rcParams['savefig.format']}")
    try:
        with whole_file(path) as temporary:
            _save(figure, temporary, path.suffix.removeprefix("."))
    except OSError as error:
        raise OutputError(path, error, "with room there, 'porousmold show' draws the pictures of a run") from error
    finally:
        plt.close(figure)
    return path


def _save(figure: Figure, path: Path, kind: str) -> None:
    try:
        figure.savefig(path, format=kind)
    except ValueError:  # what mathtext raises
        for text in figure.findobj(Text):
            text.set_parse_math(False)
        figure.savefig(path, format=kind)
