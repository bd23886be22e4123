"""Kinds of geometry: which keys of a scene belong to each, and how large the computed part of its bed is."""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..keys import Table

OF_A_MESH = tuple(
    f"geometry.{name}" for name in ("mesh", "symmetry", "refine_wall", "scale", "groups", "join_nodes", "parts")
)
"""Keys that only a mesh of one's own has."""


@dataclass(frozen=True, kw_only=True)
class BedSize:
    """The computed part of a straight bed (m): `half_height` is a pipe's radius, `half_width` that of a cavity of given width,
    `walled_sides` whether a wall stands beside that. Of a `whole` cavity both halves are computed, with a wall at either side."""

    length: float
    half_height: float
    half_width: float | None = None
    walled_sides: bool = False
    axisymmetric: bool = False
    whole: bool = False

    @property
    def area(self) -> float:
        """Cross-section, m2; that of a bed without a width counts as a metre wide."""
        if self.axisymmetric:
            return math.pi * self.half_height**2
        height = 2.0 * self.half_height if self.whole else self.half_height
        return height * (1.0 if self.half_width is None else self.half_width)

    @property
    def walled_perimeter(self) -> float:
        """Length of the wall around the cross-section (m), that at the sides included."""
        if self.axisymmetric:
            return 2.0 * math.pi * self.half_height
        width = 1.0 if self.half_width is None else self.half_width
        if self.whole:
            return 2.0 * width
        return width + (self.half_height if self.walled_sides else 0.0)


class Geometry(ABC):
    """A kind of geometry. `needed` are keys of [geometry] that it needs, `foreign` full names of keys that it has no place
    for, `widths` those of [geometry] that the beads are counted across."""

    needed: tuple[str, ...] = ()
    foreign: tuple[str, ...] = ()
    widths: tuple[str, ...] = ()

    @abstractmethod
    def size(self, table: Table) -> BedSize | None:
        """`BedSize` of the values of [geometry]; None where only the mesh knows."""


class Mold(Geometry):
    """A planar cavity, of which half is computed, or the whole where its two walls differ; of one that has a width a quarter, in
    three dimensions."""

    needed = ("length", "cavity_height")
    foreign = ("geometry.diameter", *OF_A_MESH)
    widths = ("cavity_height", "width")

    def size(self, table: Table) -> BedSize:
        half_width = None if table.width is None else table.width / 2
        walled = table.width is not None and table.sides == "wall"
        return BedSize(
            length=table.length,
            half_height=table.cavity_height / 2,
            half_width=half_width,
            walled_sides=walled,
            whole=table.cavity == "whole",
        )


class Pipe(Geometry):
    """A round pipe, axisymmetric."""

    needed = ("length", "diameter")
    foreign = ("geometry.cavity_height", "geometry.cavity", "geometry.width", "geometry.sides", *OF_A_MESH)
    widths = ("diameter",)

    def size(self, table: Table) -> BedSize:
        return BedSize(length=table.length, half_height=table.diameter / 2, axisymmetric=True)


class Mesh(Geometry):
    """A mesh of the user's own."""

    needed = ("mesh",)
    foreign = (
        *("geometry.length", "geometry.cavity_height", "geometry.cavity", "geometry.width", "geometry.sides"),
        "geometry.diameter",
        *("solver.axial_cells", "solver.first_cell", "solver.cell_growth", "solver.wall_cells"),
        *("solver.mesh_refinement", "solver.axial_refinement", "solver.accuracy"),
    )

    def size(self, table: Table) -> None:
        return None


def dimension_of(table: Table) -> int:
    """Dimensions of space of the values of [geometry]."""
    return 3 if table.width is not None or table.symmetry == "none" else 2


GEOMETRIES: Mapping[str, Geometry] = {"mold": Mold(), "pipe": Pipe(), "mesh": Mesh()}


def modelled_part(geometry: Mapping[str, Any]) -> str:
    """Which part of a tool is modelled, of the keys of a scene's [geometry]: what mass flows and heats belong to."""
    if geometry["kind"] == "pipe":
        return "the whole pipe"
    if geometry["kind"] == "mesh":
        planar = geometry.get("symmetry") in (None, "planar")
        return "the part in the mesh" + (", per metre of width" if planar else "")
    if geometry.get("cavity") == "whole":
        return "the whole cavity, per metre of width"
    return "a quarter of the cavity" if geometry.get("width") is not None else "half of the cavity, per metre of width"
