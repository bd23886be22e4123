"""matplotlib for pictures in files: no display, one look. In a notebook its own backend stays."""

import os
import sys
from pathlib import Path
from typing import Any

import matplotlib

if "matplotlib.pyplot" not in sys.modules and not os.environ.get("MPLBACKEND", "").startswith("module://"):
    matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.text import Text

# a title's height is given, not found: finding it measures every label a second time
STYLE = {"font.size": 11, "axes.grid": True, "grid.alpha": 0.3, "figure.dpi": 130, "axes.titley": 1.0}


def save(figure: Any, path: Path) -> Any:
    """Write the picture, close it, and give its path. Names of the user's that look like formulas but are none stand as text."""
    try:
        figure.savefig(path)
    except ValueError:  # what mathtext raises
        for text in figure.findobj(Text):
            text.set_parse_math(False)
        figure.savefig(path)
    plt.close(figure)
    return path
