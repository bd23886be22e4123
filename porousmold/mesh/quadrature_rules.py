"""Quadrature rules of our own on reference cells: at vertices, and at the ends of an axis along the flow."""

from typing import Any

import basix
import numpy as np

from . import fenicsx
from .aliases import Mesh


def vertex_rule(cell_type: str) -> dict[str, Any]:
    """Quadrature at a reference cell's vertices with equal weights, as metadata of a measure: (points, weights).

    `cell_type` is a name such as "quadrilateral". FFCx's own scheme "vertex" knows no quadrilaterals before 0.7.
    """
    cell = getattr(basix.CellType, cell_type)
    points = basix.geometry(cell)
    volume = float(np.sum(basix.make_quadrature(cell, 1)[1]))
    return {
        "quadrature_rule": "custom",
        "quadrature_degree": 1,
        "quadrature_points": tuple(map(tuple, points.tolist())),
        "quadrature_weights": (volume / len(points),) * len(points),
    }


def column_rule(flow_axis: int, degree: int) -> dict[str, Any]:
    """Quadrature on quadrilaterals at the ends of reference axis `flow_axis` and at Gauss points along the other."""
    gauss, weights = basix.make_quadrature(basix.CellType.interval, degree)
    points = []
    for end in (0.0, 1.0):
        for along in gauss[:, 0]:
            points.append((end, float(along)) if flow_axis == 0 else (float(along), end))
    return {
        "quadrature_rule": "custom",
        "quadrature_degree": degree,
        "quadrature_points": tuple(points),
        "quadrature_weights": tuple(float(0.5 * weight) for weight in weights) * 2,
    }


def flow_axis(domain: Mesh) -> int:
    """Reference axis (0 or 1) of a rectangle mesh's cells along x[0] (a collective call)."""
    nodes = fenicsx.cell_vertices(domain)
    mine = None
    if len(nodes):
        first, second = domain.geometry.x[nodes[0, :2], 0]
        mine = 0 if abs(second - first) > 0.0 else 1
    return next(axis for axis in domain.comm.allgather(mine) if axis is not None)
