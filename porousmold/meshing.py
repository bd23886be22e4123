"""The mesh of a scene."""

import numpy as np

from . import geometry
from .estimates import AXIAL_GRADING, bed_size


def axial_nodes(length, cells, last_cell):
    """Nodes (m) along the flow from 0 to `length`: graded from the inlet, the last of the `cells` halved until it is at most
    `last_cell` (m) long, where the wall's end lets no heat out."""
    nodes = length * np.linspace(0.0, 1.0, cells + 1) ** AXIAL_GRADING
    while nodes[-1] - nodes[-2] > last_cell:
        nodes = np.insert(nodes, -1, 0.5 * (nodes[-2] + nodes[-1]))
    return nodes


def straight_domain(scene, estimates, communicator):
    """Domain of a pipe or mold; what the scene leaves open is as its `estimates` say."""
    solver = scene.solver
    length, half_height, area = bed_size(scene)
    finer = solver.mesh_refinement
    first_cell = (solver.first_cell or estimates.first_cell) / finer
    axial_cells = max(2, round((solver.axial_cells or estimates.axial_cells) * finer))
    wall_cells = max(1, round((solver.wall_cells or estimates.wall_cells) * finer))
    resolved = scene.model.wall == "conjugate"
    wall_nodes = np.linspace(0.0, scene.wall.thickness, wall_cells + 1) if resolved else []

    def to_wall(width):
        nodes = geometry.graded_coordinates(width, first_cell, solver.cell_growth ** (1.0 / finer))
        return geometry.Across.to_wall(nodes, wall_nodes)

    across = [to_wall(half_height)]
    if scene.geometry.width is not None:
        half_width = area / half_height
        if scene.geometry.sides == "wall":
            across.append(to_wall(half_width))
        else:  # nothing changes across the width: cells as wide as the bed is high
            cells = max(2, round(finer * half_width / half_height))
            across.append(geometry.Across(np.linspace(0.0, half_width, cells + 1), cells, walled=False))
    along = axial_nodes(length, axial_cells, estimates.end_length / finer)
    axisymmetric = scene.geometry.kind == "pipe"
    return geometry.straight_bed(communicator, along, across, axisymmetric=axisymmetric)
