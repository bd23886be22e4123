"""How fine a mesh is beside the cells that a straight bed of its size would have by default."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..mesh import domain as geometry
from ..mesh import fenicsx, ranks
from ..mesh.domain import Domain
from ..scene.features.geometries import BedSize
from .accuracy import IN_DOUBT, Refinements
from .estimates import Estimates, estimate
from .meshing import QUADRATURE_DEGREE, cells_through, integral_over
from .specs import Specs

FEW = 0.6
"""Part of the default number of cells below which a mesh has few."""
FEW_ALONG, FEW_THROUGH = 0.38, 0.2
"""The same of cells along a straight bed that the scene asks for: 0.48 of them are 0.3 % off, 0.38 of them 1 to 2 %, 0.2 to 0.1
of them 4 to 19 %, as temperatures are kept within their bounds; and through a layer of its wall: 2 of 12 are 0.8 to 2.5 % off, 1
of 12 3 to 10 %."""
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


class FewCells(NamedTuple):
    """Of a straight bed whose scene asks for few: what is said of those `along` the flow, and `through` the layers of the wall;
    '' where there are enough."""

    along: str
    through: str

    @property
    def text(self) -> str:
        """Both."""
        return ", ".join(one for one in self if one)


def few_straight_cells(specs: Specs, estimates: Estimates) -> FewCells:
    """What the cells of a straight bed are beside those by default."""
    cells, layers = specs.mesh.cells, specs.mesh.layers + specs.mesh.opposite_layers
    if specs.mesh.size is None:
        return FewCells("", "")
    usual = estimates.axial_cells
    along = (cells.along or usual) * cells.refinement * cells.refinement_along
    few = [
        f"{given} {_through(layer.name)} ({wanted})"
        for layer, wanted in zip(layers, estimates.wall_cells, strict=False)
        if layer.thickness is not None
        and (given := cells_through(layer, wanted, cells.refinement)) < FEW_THROUGH * wanted
    ]
    return FewCells(
        f"{along:.0f} along the flow ({usual})" if along < FEW_ALONG * usual * (1.0 - 1e-9) else "", ", ".join(few)
    )


def of_few_cells(specs: Specs, hidden: Refinements) -> Refinements:
    """What is `hidden` from coarser runs, and where a straight bed has few cells: those do without the bounds that spread its
    fronts, and cannot have fewer cells than one through a layer."""
    if specs.mesh.size is None:
        return hidden
    few = few_straight_cells(specs, estimate(specs, specs.mesh.size))
    along, across = (max(factor, IN_DOUBT if text else 1.0) for factor, text in zip(hidden, few, strict=False))
    return hidden._replace(along=along, across=across)


def _through(name: str) -> str:
    return f"through the {name}" if name == "wall" else f"through layer {name!r}"
