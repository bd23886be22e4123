"""A mesh between gmsh and arrays: files opened and meshed, physical groups by their names, cells and facets as plain arrays."""

import os
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Floats, Integers
from ..files.gmsh_files import is_mesh, without_companions
from ..mpi import LAUNCHERS
from .aliases import GmshModel

KINDS = {1: "physical curve", 2: "physical surface", 3: "physical volume"}
"""Of gmsh's groups, by their dimension."""
ELEMENTS = {(1, 2): 1, (2, 3): 2, (2, 4): 3, (3, 4): 4, (3, 8): 5}
"""gmsh's number of a first-order element, by its dimension and the number of its nodes."""
SIDES = {
    (2, 3): ((0, 1), (1, 2), (2, 0)),
    (2, 4): ((0, 1), (1, 2), (2, 3), (3, 0)),
    (3, 4): ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)),
    (3, 8): ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
}
"""Corners of the sides of a cell, in gmsh's order, by dimension and number of its corners."""
LONGEST_READING = 120
"""Seconds that gmsh may take for a mesh."""


@dataclass(frozen=True)
class Conventions:
    """How a file differs from the one expected: the factor `scale` to m on its coordinates, the names of its physical `groups`
    by ours (several joined by " + "), and whether nodes at one place are to be joined (`join_nodes`)."""

    scale: float = 1.0
    groups: Mapping[str, str] = field(default_factory=dict)
    join_nodes: bool = False

    def named(self, tags: Mapping[str, int]) -> dict[str, int]:
        """The tags by the names that the file has."""
        return {one: tag for name, tag in tags.items() for one in self.in_file(name)}

    def named_twice(self, *kinds: Iterable[str]) -> tuple[str, str, str] | None:
        """A group of the file that two of our names of a kind stand for, and these; None without one."""
        for names in kinds:
            owners: dict[str, str] = {}
            for name in names:
                for one in set(self.in_file(name)):
                    if owners.setdefault(one, name) != name:
                        return one, owners[one], name
        return None

    def in_file(self, name: str) -> list[str]:
        """Names of the file's groups that are ours of a name."""
        return [one.strip() for one in self.groups.get(name, name).split(" + ")]


@dataclass
class PlainMesh:
    """Points (n, 3) in m; the nodes of the cells of every region and of the facets of every boundary, a row each, by tag."""

    points: Floats
    cells: dict[int, Integers]
    facets: dict[int, Integers]


def sides_of(cells: Integers, dimension: int) -> Integers:
    """Corners of all sides of cells, one row each."""
    sides = np.array(SIDES[dimension, cells.shape[1]])
    return cells[:, sides].reshape(-1, sides.shape[1])


def lone(sides: Integers) -> Integers:
    """Numbers of the sides that one cell has alone."""
    corners = np.sort(sides, axis=1)
    same = corners[:, 0]  # column by column: twice as fast as unique rows
    for column in corners.T[1:]:
        same = np.unique(same * (column.max(initial=0) + 1) + column, return_inverse=True)[1]
    _, first, counts = np.unique(same, return_index=True, return_counts=True)
    return np.sort(first[counts == 1])


def open_model(
    path: Path, dimension: int, regions: Sequence[str], boundaries: Sequence[str], *, trusted: bool = False
) -> Any:
    """gmsh's model of a file, meshed if it was not, with physical groups of these names; until `close_model`.

    `dimension` is that of the `regions`. A file that is not `trusted` may hold no command that starts a process or opens a file
    (`files.gmsh_files`). Raises `ValueError` that names a missing group or such a command, or for a damaged mesh that makes gmsh
    crash, and gmsh's plain `Exception`.
    """
    import gmsh

    if is_mesh(path):
        _read_apart(path)
    gmsh.initialize(readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        with nullcontext(path) if trusted else without_companions(path) as file:
            gmsh.open(str(file))
            if len(gmsh.model.mesh.getNodes()[0]) == 0:
                gmsh.model.mesh.generate(dimension)
        _require_groups(gmsh.model, {dimension: regions, dimension - 1: boundaries})
    except BaseException:
        gmsh.finalize()
        raise
    return gmsh.model


READING = """
import gmsh, sys
gmsh.initialize(readConfigFiles=False)
gmsh.option.setNumber("General.Terminal", 0)
try:
    gmsh.open(sys.argv[1])
    gmsh.model.mesh.getNodes()
    gmsh.model.mesh.getElements()
except Exception:  # which comes again, where it is told
    pass
"""


def _read_apart(path: Path) -> None:
    """Read a mesh in a process of its own first: gmsh follows a damaged reference to a node to wherever it leads. Raises
    `ValueError` where that process is killed, or has not ended after `LONGEST_READING`."""
    alone = {name: value for name, value in os.environ.items() if not name.startswith(LAUNCHERS)}
    with without_companions(path) as file:
        try:
            command = [sys.executable, "-c", READING, str(file)]
            ended = subprocess.run(command, env=alone, capture_output=True, timeout=LONGEST_READING, check=False)
        except subprocess.TimeoutExpired:
            raise ValueError("it is not read to its end: the file is damaged") from None
    if ended.returncode < 0:
        raise ValueError("it makes gmsh crash: the file is damaged")


def close_model() -> None:
    """End gmsh, whose model is no longer needed."""
    import gmsh

    gmsh.finalize()


def _require_groups(model: GmshModel, required: Mapping[int, Sequence[str]]) -> None:
    """Raises `ValueError` that names what is missing and what there is."""
    names: dict[int, list[str]] = {dimension: [] for dimension in required}
    for dimension, tag in model.getPhysicalGroups():
        names.setdefault(dimension, []).append(_group_name(model, dimension, tag))
    missing = [(KINDS[d], name) for d, wanted in required.items() for name in wanted if name not in names[d]]
    if missing:
        lacks = " and ".join(f"no {kind} named {name!r}" for kind, name in missing)
        there = "; ".join(f"{KINDS[d]}s: {', '.join(names[d]) or 'none'}" for d in sorted(names, reverse=True) if d)
        raise ValueError(f"it has {lacks} ({there})")


def _group_name(model: GmshModel, dimension: int, tag: int) -> str:
    """Of a physical group; its number where it has none."""
    return model.getPhysicalName(dimension, tag) or str(tag)


def read_model(
    model: GmshModel, dimension: int, regions: Mapping[str, int], boundaries: Mapping[str, int]
) -> PlainMesh:
    """The cells and facets of the model's physical groups of these names, by the tags given to them. Points that belong to none
    (those that a spline was drawn through) are left out. Raises `ValueError` for other than first-order elements."""
    tags, coordinates, _ = model.mesh.getNodes()
    numbers = {dimension: regions, dimension - 1: boundaries}
    found: dict[int, dict[int, Floats]] = {dimension: {}, dimension - 1: {}}
    for group, tag in model.getPhysicalGroups():
        name = _group_name(model, group, tag)
        if name in numbers.get(group, {}):
            number, elements = numbers[group][name], _elements(model, group, tag)
            parts = [part for part in (found[group].get(number), elements) if part is not None]
            found[group][number] = np.concatenate(parts)
    shapes = {part.shape[1] for part in found[dimension].values()}
    if len(shapes) > 1:
        raise ValueError("its cells must all be of one kind, in bed and wall alike")
    used = np.unique(np.concatenate([part.ravel() for part in found[dimension].values()]))
    if not all(np.isin(part, used).all() for part in found[dimension - 1].values()):
        raise ValueError("it has facets that belong to no cell")
    order = np.argsort(tags)
    points = coordinates.reshape(-1, 3)[order[np.searchsorted(tags, used, sorter=order)]]
    cells, facets = (
        {tag: np.searchsorted(used, part) for tag, part in found[group].items()} for group in (dimension, dimension - 1)
    )
    return PlainMesh(points, cells, facets)


def _elements(model: GmshModel, dimension: int, tag: int) -> Integers:
    """gmsh's numbers of the nodes of a physical group's elements, a row each."""
    parts = []
    for entity in model.getEntitiesForPhysicalGroup(dimension, tag):
        for kind, _, nodes in zip(*model.mesh.getElements(dimension, entity), strict=True):
            if kind not in ELEMENTS.values():
                raise ValueError("its cells must be of first order, without pyramids and prisms")
            parts.append(nodes.reshape(-1, _corners(kind)))
    if len({part.shape[1] for part in parts}) > 1:
        raise ValueError("its cells must all be of one kind")
    return np.concatenate(parts).astype(np.int64)


def _corners(kind: int) -> int:
    return next(corners for (_, corners), number in ELEMENTS.items() if number == kind)


def replace_model(model: GmshModel, dimension: int, mesh: PlainMesh) -> None:
    """Put the mesh in the place of all that the model has."""
    model.add("named groups")
    numbers = np.arange(1, len(mesh.points) + 1)
    carrier = model.addDiscreteEntity(dimension)
    model.mesh.addNodes(dimension, carrier, numbers, mesh.points.ravel())
    for group, parts in ((dimension, mesh.cells), (dimension - 1, mesh.facets)):
        for tag, nodes in parts.items():
            entity = model.addDiscreteEntity(group)
            kind = ELEMENTS[group, nodes.shape[1]]
            model.mesh.addElementsByType(entity, kind, [], numbers[nodes].ravel())
            model.addPhysicalGroup(group, [entity], tag)
