"""matplotlib for pictures in files: no display, one look. In a notebook its own backend stays."""

import os
import sys
from pathlib import Path
from typing import Any

import matplotlib

if "matplotlib.pyplot" not in sys.modules and not os.environ.get("MPLBACKEND", "").startswith("module://"):
    matplotlib.use("Agg")
import matplotlib.pyplot as plt

# a title's height is given, not found: finding it measures every label a second time
STYLE = {"font.size": 11, "axes.grid": True, "grid.alpha": 0.3, "figure.dpi": 130, "axes.titley": 1.0}


def save(figure: Any, path: Path) -> Any:
    """Write the picture, close it, and give its path."""
    figure.savefig(path)
    plt.close(figure)
    return path
