"""How fine a mesh of one's own is beside the cells that a straight bed of its size would have by default."""

from dataclasses import replace

import numpy as np

from ..mesh import domain as geometry
from ..mesh import fenicsx, ranks
from ..mesh.domain import Domain
from ..scene.features.geometries import BedSize
from .estimates import estimate
from .meshing import QUADRATURE_DEGREE, integral_over
from .specs import Specs

FEW = 0.6
"""Part of the default number of cells below which a mesh has few."""
SIMPLICES = {"triangle": (2.0, 1.0), "tetrahedron": (6.0, 2.0)}
"""How many of them fill a quadrilateral or hexahedron, and how many of their sides one of its sides."""


def few_cells(specs: Specs, domain: Domain, size: BedSize) -> str:
    """Along what a mesh of one's own has few cells, '' where nowhere or where the cells are the program's own (collective).

    Counted are the sides on the wall over the bed's length, and the cells of each layer over those sides; a layer is as thick as
    its volume over the area of the wall. In a mesh about an axis that is so for walls thin beside their radius.
    """
    if specs.mesh.own.mesh is None:
        return ""
    communicator, mesh = domain.communicator, domain.mesh
    dimension, one = mesh.topology.dim, domain.constant(1.0)
    owned = mesh.topology.index_map(dimension - 1).size_local
    sides = ranks.total(communicator, np.sum(domain.facets(geometry.INTERFACE) < owned))
    area = integral_over(domain, one * domain.interface_measure(QUADRATURE_DEGREE))
    if not sides or not area:
        return ""
    in_one, on_a_side = SIMPLICES.get(fenicsx.cell_name(mesh), (1.0, 1.0))
    squares = sides / on_a_side
    found = {"along the flow": domain.length / (area / squares) ** (1.0 / (dimension - 1))}
    layers, tags = list(specs.heat.layers), list(domain.wall_tags)
    for number, tag in enumerate(tags[: len(layers)]):
        count = ranks.total(communicator, np.sum(domain.cells(tag) < mesh.topology.index_map(dimension).size_local))
        volume = integral_over(domain, one * domain.cell_measure(QUADRATURE_DEGREE)(tag))
        if not count or layers[number].is_contact:
            continue
        layers[number] = replace(layers[number], thickness=volume / area)
        found[_through(layers[number].name)] = count / in_one / squares
    wanted_of = estimate(replace(specs, heat=replace(specs.heat, layers=tuple(layers))), size)
    wanted = {"along the flow": wanted_of.axial_cells}
    solid = [layer for layer in layers if layer.thickness is not None]
    wanted |= {_through(layer.name): cells for layer, cells in zip(solid, wanted_of.wall_cells, strict=False)}
    few = [
        f"{round(number)} {where} ({wanted[where]})"
        for where, number in found.items()
        if where in wanted and number < FEW * wanted[where]
    ]
    return f"the mesh has few cells (beside those of a straight bed by default): {', '.join(few)}" if few else ""


def _through(name: str) -> str:
    return f"through the {name}" if name == "wall" else f"through layer {name!r}"
