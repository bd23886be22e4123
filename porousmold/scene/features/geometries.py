"""Kinds of geometry: which keys of a scene belong to each, and how large the computed part of its bed is."""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from ..keys import Table

if TYPE_CHECKING:
    from ..scene import Scene

Values: TypeAlias = Mapping[str, Any]
"""Of the keys of a scene's [geometry]; keys that are not set may be missing."""
OF_A_MESH = tuple(
    f"geometry.{name}" for name in ("mesh", "symmetry", "refine_wall", "scale", "groups", "join_nodes", "parts")
)
"""Keys that only a mesh of one's own has."""
OF_A_MOLD = ("geometry.cavity_height", "geometry.cavity", "geometry.width", "geometry.sides")
"""Keys that only a mold has."""


@dataclass(frozen=True, kw_only=True)
class BedSize:
    """The computed part of a straight bed (m): `half_height` is a pipe's radius, `half_width` that of a cavity of given width,
    `walled_sides` whether a wall stands beside that. Of a `whole` cavity both halves are computed, with a wall at either side;
    about an axis it is an annulus, around a core of the `core_radius`."""

    length: float
    half_height: float
    half_width: float | None = None
    walled_sides: bool = False
    axisymmetric: bool = False
    whole: bool = False
    core_radius: float = 0.0

    @property
    def is_disk(self) -> bool:
        """Whether the cross-section is one: less of it lies at the same distance from the wall the farther in."""
        return self.axisymmetric and not self.whole

    @property
    def middle(self) -> float:
        """Place x[1] of the middle between the two walls of a `whole` bed."""
        return self.core_radius + self.half_height if self.axisymmetric else 0.0

    @property
    def area(self) -> float:
        """Cross-section, m2; that of a bed without a width counts as a metre wide."""
        if self.is_disk:
            return math.pi * self.half_height**2
        if self.axisymmetric:
            return 4.0 * math.pi * self.middle * self.half_height
        height = 2.0 * self.half_height if self.whole else self.half_height
        return height * (1.0 if self.half_width is None else self.half_width)

    @property
    def walls(self) -> tuple[tuple[float, float], ...]:
        """The wall, or both of a whole bed: its length around the cross-section (m), that at the sides included, and how it is
        curved: 1 for a wall around the bed, -1 for that of a core, 0 for a plane one."""
        if self.is_disk:
            return ((2.0 * math.pi * self.half_height, 1.0),)
        if self.axisymmetric:
            outer = self.core_radius + 2.0 * self.half_height
            return (2.0 * math.pi * outer, 1.0), (2.0 * math.pi * self.core_radius, -1.0)
        width = 1.0 if self.half_width is None else self.half_width
        if self.whole:
            return (width, 0.0), (width, 0.0)
        return ((width + (self.half_height if self.walled_sides else 0.0), 0.0),)

    @property
    def walled_perimeter(self) -> float:
        """Length of the wall around the cross-section, m."""
        return sum(length for length, _ in self.walls)


class Geometry(ABC):
    """A kind of geometry. `needed` are keys of [geometry] that it needs, `foreign` full names of keys that it has no place
    for."""

    article = "a"
    needed: tuple[str, ...] = ()
    foreign: tuple[str, ...] = ()

    @abstractmethod
    def size(self, table: Table) -> BedSize | None:
        """`BedSize` of the values of [geometry]; None where only the mesh knows."""

    def widths(self, table: Table) -> dict[str, float]:
        """How wide the bed is between its walls (m), by the key that says it."""
        return {}

    @abstractmethod
    def modelled_part(self, geometry: Values) -> str:
        """Which part of a tool is computed, in words: what mass flows and heats belong to."""

    @abstractmethod
    def parts(self, geometry: Values) -> float:
        """How many such parts the whole tool has; of a part per metre of width, a tool a metre wide."""

    def is_per_width(self, geometry: Values) -> bool:
        """Whether the part is a plane one, a metre wide."""
        return False

    def has_two_walls(self, geometry: Values) -> bool:
        """Whether the bed lies between two walls, each with layers of its own."""
        return False

    def check(self, scene: "Scene") -> None:
        """Raise `InputError` for measures that it needs, has no place for, or that do not go together."""
        for name in self.needed:
            scene.require(f"geometry.{name}")
        for full_name in self.foreign:
            if scene.is_given(full_name):
                scene.refuse(full_name, f"has no place in {self.article} {scene.geometry.kind}")


class Mold(Geometry):
    """A planar cavity, of which half is computed, or the whole where its two walls differ; of one that has a width a quarter, in
    three dimensions."""

    needed = ("length", "cavity_height")
    foreign = ("geometry.diameter", "geometry.core_diameter", *OF_A_MESH)

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

    def widths(self, table: Table) -> dict[str, float]:
        walled = {} if table.width is None or table.sides == "symmetry" else {"width": table.width}
        return {"cavity_height": table.cavity_height} | walled

    def modelled_part(self, geometry: Values) -> str:
        if geometry.get("cavity") == "whole":
            return "the whole cavity, per metre of width"
        return "half of the cavity, per metre of width" if geometry.get("width") is None else "a quarter of the cavity"

    def parts(self, geometry: Values) -> float:
        if geometry.get("width") is not None:
            return 4.0
        return 1.0 if geometry.get("cavity") == "whole" else 2.0

    def is_per_width(self, geometry: Values) -> bool:
        return geometry.get("width") is None

    def has_two_walls(self, geometry: Values) -> bool:
        return bool(geometry.get("cavity") == "whole")


class Pipe(Geometry):
    """A round pipe, axisymmetric."""

    needed = ("length", "diameter")
    foreign = (*OF_A_MOLD, "geometry.core_diameter", *OF_A_MESH)

    def size(self, table: Table) -> BedSize:
        return BedSize(length=table.length, half_height=table.diameter / 2, axisymmetric=True)

    def widths(self, table: Table) -> dict[str, float]:
        return {"diameter": table.diameter}

    def modelled_part(self, geometry: Values) -> str:
        return "the whole pipe"

    def parts(self, geometry: Values) -> float:
        return 1.0


class Annulus(Geometry):
    """The space between a pipe and a core inside it, axisymmetric; the core's layers are those of the wall opposite."""

    article = "an"
    needed = ("length", "diameter", "core_diameter")
    foreign = (*OF_A_MOLD, *OF_A_MESH)

    def size(self, table: Table) -> BedSize:
        core = table.core_diameter / 2
        return BedSize(
            length=table.length,
            half_height=(table.diameter / 2 - core) / 2,
            axisymmetric=True,
            whole=True,
            core_radius=core,
        )

    def widths(self, table: Table) -> dict[str, float]:
        return {"core_diameter": (table.diameter - table.core_diameter) / 2}

    def modelled_part(self, geometry: Values) -> str:
        return "the whole annulus"

    def parts(self, geometry: Values) -> float:
        return 1.0

    def has_two_walls(self, geometry: Values) -> bool:
        return True

    def check(self, scene: "Scene") -> None:
        super().check(scene)
        outer, core = scene.geometry.diameter, scene.geometry.core_diameter
        if core >= outer:
            scene.refuse("geometry.core_diameter", f"must be less than geometry.diameter, {outer:g} m")
        thickness = sum(layer.thickness or 0.0 for layer in scene.wall.opposite_layer or ())
        if thickness > core / 2 * (1.0 + 1e-9):
            allowed = f"must have layers of {core / 2:g} m at most together: half of geometry.core_diameter"
            scene.refuse("wall.opposite_layer", allowed, value=f"{thickness:g} m")


class Mesh(Geometry):
    """A mesh of the user's own."""

    needed = ("mesh",)
    foreign = (
        "geometry.length",
        *OF_A_MOLD,
        "geometry.diameter",
        "geometry.core_diameter",
        *("solver.axial_cells", "solver.first_cell", "solver.cell_growth", "solver.wall_cells"),
        *("solver.axial_refinement", "solver.accuracy"),
    )

    def size(self, table: Table) -> None:
        return None

    def check(self, scene: "Scene") -> None:
        super().check(scene)
        factor = scene.solver.mesh_refinement
        if factor != 1.0 and dimension_of(scene.geometry) == 3:
            scene.refuse("solver.mesh_refinement", "has no place in a mesh in three dimensions")
        if factor not in HALVINGS:
            allowed = "must be 1, 2, 4 or 8 for a mesh of your own, whose cells are halved in both directions"
            scene.refuse("solver.mesh_refinement", allowed)

    def modelled_part(self, geometry: Values) -> str:
        return "the part in the mesh" + (", per metre of width" if self.is_per_width(geometry) else "")

    def parts(self, geometry: Values) -> float:
        return float(geometry.get("parts") or (2 if self.is_per_width(geometry) else 1))

    def is_per_width(self, geometry: Values) -> bool:
        return geometry.get("symmetry") in (None, "planar")


HALVINGS = {1.0: 0, 2.0: 1, 4.0: 2, 8.0: 3}
"""Of the cells of a mesh of one's own, by the factor on their number in each direction."""


def dimension_of(table: Table) -> int:
    """Dimensions of space of the values of [geometry]."""
    return 3 if table.width is not None or table.symmetry == "none" else 2


GEOMETRIES: Mapping[str, Geometry] = {"mold": Mold(), "pipe": Pipe(), "annulus": Annulus(), "mesh": Mesh()}


def geometry_of(geometry: Values) -> Geometry:
    """The kind of the values of [geometry]."""
    return GEOMETRIES[geometry["kind"]]


def modelled_part(geometry: Values) -> str:
    """Which part of a tool is computed, in words, of the values of [geometry]."""
    return geometry_of(geometry).modelled_part(geometry)
