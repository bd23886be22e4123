"""The outer surface of a tool in three dimensions, coloured by its temperature at a few times."""

import itertools
from pathlib import Path

import numpy as np
from matplotlib import cm, colors
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from ..arrays import Booleans, Integers
from ..files.xdmf import read_fields
from .figures import plt, save

FACES = {
    4: ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)),
    8: ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
}
"""Corners of the faces of tetrahedra and hexahedra in drawing order, by the number of corners of a cell."""
MOST_TIMES = 4
FLATTEST = 0.3
"""Of the tool's length, that its height and width are drawn as at least."""


def in_three_dimensions(folder: Path) -> bool:
    """Whether the fields of a run's folder are, by the first lines of what describes them."""
    with (folder / "fields.xdmf").open(encoding="utf-8") as file:
        return any("Hexahedron" in line or "Tetrahedron" in line for line in itertools.islice(file, 10))


def outer_faces(cells: Integers, in_bed: Booleans) -> Integers:
    """Corners of the faces that belong to one cell alone and touch no bed, a row each; `in_bed` tells it of every node."""
    faces = np.concatenate([cells[:, list(corners)] for corners in FACES[cells.shape[1]]])
    _, first, counts = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    alone = faces[first[counts == 1]]
    return alone[~in_bed[alone].any(axis=1)]


def draw_surface(folder: Path, unit: str, size: float) -> Path:
    """Draw surface.png of a run's folder; `unit` and its `size` (s) are those of the times' titles."""
    nodes, cells, steps = read_fields(folder / "fields.xdmf")
    times = sorted(steps)
    chosen = [
        times[n] for n in np.unique(np.linspace(0, len(times) - 1, min(len(times), MOST_TIMES)).round().astype(int))
    ]
    faces = outer_faces(cells, steps[times[0]]["in_bed"] > 0.99)
    places = nodes[:, [0, 2, 1]] * 1e3
    warm = {time: steps[time]["temperature"][faces].mean(axis=1) - 273.15 for time in chosen}
    reached = np.concatenate(list(warm.values()))
    scale = colors.Normalize(float(reached.min()), float(reached.max()))
    figure = plt.figure(figsize=(11.0, 2.6 * ((len(chosen) + 1) // 2) + 0.4))
    extent = np.ptp(places, axis=0)
    for number, time in enumerate(chosen):
        axes = figure.add_subplot((len(chosen) + 1) // 2, 2, number + 1, projection="3d")
        shown = Poly3DCollection(places[faces], facecolors=cm.inferno(scale(warm[time])), edgecolors="none")
        axes.add_collection3d(shown)
        for name, low, high in zip("xyz", places.min(axis=0), places.max(axis=0), strict=True):
            getattr(axes, f"set_{name}lim")(low, high)
        axes.set_box_aspect(np.maximum(extent / extent[0], FLATTEST), zoom=1.35)
        axes.view_init(elev=42.0, azim=-62.0)
        axes.set_title(f"t = {time / size:.4g} {unit}", fontsize=10, y=0.96)
        axes.set_xlabel("along in mm", fontsize=8)
        axes.set_ylabel("beside", fontsize=8, labelpad=-4)
        axes.set_zticks([])
        axes.yaxis.set_major_locator(MaxNLocator(3))
        axes.tick_params(labelsize=7, pad=-1)
    figure.subplots_adjust(left=0.0, right=0.9, bottom=0.04, top=0.97, wspace=0.0, hspace=0.05)
    mapped = cm.ScalarMappable(scale, "inferno")
    figure.colorbar(
        mapped, cax=figure.add_axes((0.93, 0.12, 0.015, 0.76)), label="temperature of the outer surface in °C"
    )
    return save(figure, folder / "surface.png")
