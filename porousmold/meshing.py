"""The mesh of a scene."""

import math
import os
from collections.abc import Callable

import numpy as np

from . import geometry
from .errors import InputError
from .estimates import AXIAL_GRADING, bed_size
from .scene import Scene

WIDEST_CELL = 0.2
"""Of the width from the wall to the middle of the bed."""
BYTES_AN_UNKNOWN = {2: 10e3, 3: 40e3}
"""Memory that factors, matrices and the rest need for an unknown of the flow, by dimensions of space (docs/growth.md)."""


def _announce(scene: Scene, cells_along: int, across: list[geometry.Across], observe: Callable[[str], None]) -> None:
    cells = cells_along * math.prod(direction.cells for direction in across)
    in_bed = cells_along * math.prod(direction.bed_cells for direction in across)
    dimension = 1 + len(across)
    turbulent = scene.model.turbulence != "none"
    parts = {"full": dimension + 1, "developed": 1, "plug": 0}[scene.model.flow] + (2 if turbulent else 0)
    unknowns = in_bed * max(parts, 1)
    memory = BYTES_AN_UNKNOWN[dimension] * unknowns
    observe(f"mesh of {cells} cells, about {unknowns:.2g} unknowns of the flow and {memory / 2**30:.1g} GiB")
    machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if memory > machine:
        raise InputError(
            "solver.mesh_refinement",
            scene.solver.mesh_refinement,
            f"makes a mesh of {cells} cells, whose flow needs about {memory / 2**30:.0f} GiB of memory; this machine has "
            f"{machine / 2**30:.0f}",
            scene.source,
        )


def axial_nodes(length: float, cells: int, last_cell: float) -> np.ndarray:
    """Nodes (m) along the flow from 0 to `length`: graded from the inlet, the last of the `cells` halved until it is at most
    `last_cell` (m) long, where the wall's end lets no heat out."""
    nodes = length * np.linspace(0.0, 1.0, cells + 1) ** AXIAL_GRADING
    while nodes[-1] - nodes[-2] > last_cell:
        nodes = np.insert(nodes, -1, 0.5 * (nodes[-2] + nodes[-1]))
    return nodes


def refined(nodes: np.ndarray, factor: float) -> np.ndarray:
    """Nodes of `factor` times as many cells, two at least: where it is a whole number every cell is cut evenly."""
    cells = max(2, round((len(nodes) - 1) * factor))
    return np.interp(np.linspace(0, len(nodes) - 1, cells + 1), np.arange(len(nodes)), nodes)


def straight_domain(scene, estimates, communicator, observe):
    """Domain of a pipe or mold; what the scene leaves open is as its `estimates` say.

    `observe(text)` is told its size. Raises `InputError` where it would need more memory than the machine has.
    """
    solver = scene.solver
    length, half_height, area = bed_size(scene)
    finer = solver.mesh_refinement
    wall_cells = max(1, round((solver.wall_cells or estimates.wall_cells) * finer))
    resolved = scene.model.wall == "conjugate"
    wall_nodes = np.linspace(0.0, scene.wall.thickness, wall_cells + 1) if resolved else []

    def to_wall(width):
        first_cell = solver.first_cell or estimates.first_cell
        layer, widest = scene.bed.bead_diameter, WIDEST_CELL * width
        nodes = geometry.graded_coordinates(width, first_cell, solver.cell_growth, layer, widest)
        return geometry.Across.to_wall(refined(nodes, finer), wall_nodes)

    across = [to_wall(half_height)]
    if scene.geometry.width is not None:
        half_width = area / half_height
        if scene.geometry.sides == "wall":
            across.append(to_wall(half_width))
        else:  # nothing changes across the width: cells as wide as the bed is high
            cells = max(2, round(finer * half_width / half_height))
            across.append(geometry.Across(np.linspace(0.0, half_width, cells + 1), cells, walled=False))
    along = axial_nodes(length, solver.axial_cells or estimates.axial_cells, estimates.end_length)
    along = refined(along, finer)
    _announce(scene, len(along) - 1, across, observe)
    axisymmetric = scene.geometry.kind == "pipe"
    return geometry.straight_bed(communicator, along, across, axisymmetric=axisymmetric)
