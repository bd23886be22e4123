"""A mesh between gmsh and arrays: files opened and meshed, physical groups by their names, cells and facets as plain arrays."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

KINDS = {1: "physical curve", 2: "physical surface", 3: "physical volume"}
"""Of gmsh's groups, by their dimension."""
ELEMENTS = {(1, 2): 1, (2, 3): 2, (2, 4): 3, (3, 4): 4, (3, 8): 5}
"""gmsh's number of a first-order element, by its dimension and the number of its nodes."""


@dataclass
class PlainMesh:
    """Points (n, 3) in m; the nodes of the cells of every region and of the facets of every boundary, a row each, by tag."""

    points: NDArray[Any]
    cells: dict[int, NDArray[Any]]
    facets: dict[int, NDArray[Any]]


def open_model(path: Path, dimension: int, regions: Sequence[str], boundaries: Sequence[str]) -> Any:
    """gmsh's model of a file, meshed if it was not, with physical groups of these names.

    `dimension` is that of the `regions`. Raises `ValueError` that names a missing group, and gmsh's plain `Exception`.
    """
    import gmsh

    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(path))
        if len(gmsh.model.mesh.getNodes()[0]) == 0:
            gmsh.model.mesh.generate(dimension)
        _require_groups(gmsh.model, {dimension: regions, dimension - 1: boundaries})
    except Exception:
        gmsh.finalize()
        raise
    return gmsh.model


def close_model() -> None:
    """End gmsh, whose model is no longer needed."""
    import gmsh

    gmsh.finalize()


def _require_groups(model: Any, required: Mapping[int, Sequence[str]]) -> None:
    """Raises `ValueError` that names what is missing and what there is."""
    names: dict[int, list[str]] = {dimension: [] for dimension in required}
    for dimension, tag in model.getPhysicalGroups():
        names.setdefault(dimension, []).append(model.getPhysicalName(dimension, tag) or f"number {tag}, without a name")
    missing = [(KINDS[d], name) for d, wanted in required.items() for name in wanted if name not in names[d]]
    if missing:
        told = " and ".join(f"no {kind} named {name!r}" for kind, name in missing)
        there = "; ".join(f"{KINDS[d]}s: {', '.join(names[d]) or 'none'}" for d in sorted(names, reverse=True) if d)
        raise ValueError(f"it has {told} ({there})")


def renumber_groups(model: Any, dimension: int, regions: Mapping[str, int], boundaries: Mapping[str, int]) -> None:
    """Give the groups of these names these numbers, and remove all others."""
    numbers = {dimension: regions, dimension - 1: boundaries}
    groups = [
        (group, numbers[group][name], model.getEntitiesForPhysicalGroup(group, tag))
        for group, tag in model.getPhysicalGroups()
        if group in numbers and (name := model.getPhysicalName(group, tag)) in numbers[group]
    ]
    model.removePhysicalGroups()
    for group, number, entities in groups:
        model.addPhysicalGroup(group, entities, number)


def read_model(model: Any, dimension: int) -> PlainMesh:
    """The cells and facets of the model's physical groups. Raises `ValueError` for other than first-order elements."""
    tags, coordinates, _ = model.mesh.getNodes()
    number_of = np.zeros(int(tags.max()) + 1, dtype=np.int64)
    number_of[tags] = np.arange(len(tags))

    def elements(group: int, tag: int) -> NDArray[Any]:
        parts = []
        for entity in model.getEntitiesForPhysicalGroup(group, tag):
            for kind, _, nodes in zip(*model.mesh.getElements(group, entity), strict=True):
                if kind not in ELEMENTS.values():
                    raise ValueError("its cells must be of first order, without pyramids and prisms")
                parts.append(number_of[nodes].reshape(len(nodes) // _corners(kind), -1))
        return np.concatenate(parts)

    found: dict[int, dict[int, NDArray[Any]]] = {dimension: {}, dimension - 1: {}}
    for group, tag in model.getPhysicalGroups():
        found[group][tag] = elements(group, tag)
    return PlainMesh(coordinates.reshape(-1, 3), found[dimension], found[dimension - 1])


def _corners(kind: int) -> int:
    return next(corners for (_, corners), number in ELEMENTS.items() if number == kind)


def replace_model(model: Any, dimension: int, mesh: PlainMesh) -> None:
    """Put the mesh in the place of all that the model has."""
    model.add("with cells at the wall")
    numbers = np.arange(1, len(mesh.points) + 1)
    carrier = model.addDiscreteEntity(dimension)
    model.mesh.addNodes(dimension, carrier, numbers, mesh.points.ravel())
    for group, parts in ((dimension, mesh.cells), (dimension - 1, mesh.facets)):
        for tag, nodes in parts.items():
            entity = model.addDiscreteEntity(group)
            kind = ELEMENTS[group, nodes.shape[1]]
            model.mesh.addElementsByType(entity, kind, [], numbers[nodes].ravel())
            model.addPhysicalGroup(group, [entity], tag)
