"""A mesh of the user's own in place of a straight bed."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from .feature import Feature, choice, key

if TYPE_CHECKING:
    from ..scene import Scene


@dataclass(frozen=True, kw_only=True)
class OwnMesh(Feature):
    """The file of a mesh, and how it is read."""

    mesh: Path | None = key(
        "geometry.mesh",
        "file",
        "gmsh file (.geo, .msh) with named physical groups, for kind 'mesh'; a .geo that runs commands or opens other files "
        "than CAD drawings only with --allow-extensions",
    )
    symmetry: str = choice(
        "geometry.symmetry",
        "symmetry of a mesh: planar (2D), axisymmetric about x[1] = 0, or none (3D)",
        ("planar", "axisymmetric", "none"),
        "planar",
    )
    refine_wall: bool = key(
        "geometry.refine_wall", "flag", "insert graded cells at the wall of a mesh that is too coarse there", False
    )
    scale: float = key(
        "geometry.scale",
        "",
        "factor on the coordinates of a mesh, to m: 0.001 for one in mm",
        1.0,
        low=1e-9,
        high=1e9,
        closed=True,
    )
    groups: Mapping[str, str] | None = key(
        "geometry.groups",
        "names",
        'physical groups of a mesh that have other names, such as { wall = "skin", inlet = "7" }: a group without a name '
        "has its number, several count as one by ' + '",
    )
    join_nodes: bool = key(
        "geometry.join_nodes",
        "flag",
        "join the nodes of a mesh that lie at one place, where bed and wall were meshed apart",
        False,
    )
    parts: int | None = key(
        "geometry.parts",
        "integer",
        "number of such parts in the whole tool, for blower and heater; default 1, of a planar mesh with a group symmetry 2",
        low=1,
        high=1000,
        closed=True,
    )

    def check(self, scene: "Scene") -> None:
        """A mesh about an axis is the whole tool."""
        if self.parts not in (None, 1) and self.symmetry == "axisymmetric":
            scene.refuse("geometry.parts", "must be 1 about an axis")
