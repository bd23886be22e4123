"""The geometry: what is heated, and the measures of a straight bed."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from .feature import Feature, choice, measure
from .geometries import GEOMETRIES

if TYPE_CHECKING:
    from ..scene import Scene


@dataclass(frozen=True, kw_only=True)
class StraightBed(Feature):
    """Kind of the geometry and measures (m) of the bed."""

    kind: str | None = choice("geometry.kind", "what is heated", tuple(GEOMETRIES))
    length: float | None = measure("geometry.length", "length of the bed along the flow")
    cavity_height: float | None = measure(
        "geometry.cavity_height", "full height of a mold's cavity; half of it is modelled"
    )
    cavity: str = choice(
        "geometry.cavity",
        "how much of a mold's cavity is modelled: half, between equal walls, or the whole, whose other wall has "
        "[[wall.opposite_layer]]",
        ("half", "whole"),
        "half",
    )
    width: float | None = measure(
        "geometry.width", "full width of a mold's cavity, for a three-dimensional model; half of it is modelled"
    )
    sides: str = choice(
        "geometry.sides",
        "lateral boundary of a cavity with a width: wall, or plane of symmetry",
        ("wall", "symmetry"),
        "wall",
    )
    diameter: float | None = measure("geometry.diameter", "inner diameter of a pipe, or of the wall around an annulus")
    core_diameter: float | None = measure(
        "geometry.core_diameter", "diameter of an annulus's core, which has [[wall.opposite_layer]]"
    )

    def check(self, scene: "Scene") -> None:
        """The measures are those that the kind needs."""
        scene.require("geometry.kind")
        assert self.kind is not None
        GEOMETRIES[self.kind].check(scene)
        if self.width is None and self.sides != "wall":
            scene.refuse("geometry.sides", "has no meaning without geometry.width")
