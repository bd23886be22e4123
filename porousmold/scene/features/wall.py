"""The wall: its model, its layers outwards from the bed, and those of the wall opposite."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from ...laws.material_library import SOLIDS
from ...laws.materials import Solid
from ..keys import Key, Part, Table
from ..series import TimeSeries
from .feature import OWN_MATERIAL, Feature, choice, key, measure, own_property, solid
from .geometries import geometry_of

if TYPE_CHECKING:
    from ..scene import Scene

RESERVED_PLACES = ("wall", "bed_side", "bed")
"""Places that every scene has."""
RESERVED_NAMES = (*RESERVED_PLACES, "fluid", "beads", "temperature")
"""Names that no layer can have."""
CONTACT_THICKNESS = 1e-6
"""Of the layer (m) that stands for a contact resistance."""
WITHOUT_OUTSIDE = ("insulated", "fixed-temperature")
"""Models of the wall that have nothing behind the bed's surface."""
WallKind = Literal["conjugate", "thin", "fixed-temperature", "insulated"]
LAYER: Mapping[str, Key] = {
    "name": Key("text", "name in results and targets, and of the physical group in a mesh; default: its material"),
    "material": Key("choice", "material of the layer", choices=SOLIDS, else_allowed=OWN_MATERIAL),
    "thickness": Key("m", "thickness of the layer", low=0.0, high=1e4),
    "density": Key("kg/m^3", "density of the layer; overrides the material's", low=0.0, high=1e7, of_law=True),
    "heat_capacity": Key(
        "J/(kg*K)", "specific heat capacity of the layer; overrides the material's", low=0.0, high=1e7, of_law=True
    ),
    "conductivity": Key(
        "W/(m*K)", "thermal conductivity of the layer; overrides the material's", low=0.0, high=1e7, of_law=True
    ),
    "contact_resistance": Key(
        "m^2*K/W", "between this layer and the next one outwards", 0.0, low=0.0, high=100.0, closed=True
    ),
    "heat_source": Key("W/m^3", "volumetric heat source in the layer", low=-1e9, high=1e9, series=True),
    "cells": Key("integer", "cells through the layer; default from its Biot number", low=1, high=1000, closed=True),
}


@dataclass(frozen=True, kw_only=True)
class Layer:
    """A layer of the wall: its `thickness` (None where only the mesh knows), its `solid`, what heats it (W/m3), and its cells."""

    name: str
    solid: Solid
    thickness: float | None
    heat_source: TimeSeries | None = None
    cells: int | None = None
    is_contact: bool = False


@dataclass(frozen=True, kw_only=True)
class BedWall(Feature):
    """The wall's model and what it is made of: one material, or layers."""

    kind: WallKind = choice(
        "model.wall",
        "wall model: resolved conduction, lumped in thickness, fixed at operation.wall_temperature, or adiabatic",
        ("conjugate", "thin", "fixed-temperature", "insulated"),
        "conjugate",
    )
    material: str = solid("wall.material", "material of the wall", "aluminium")
    thickness: float | None = measure("wall.thickness", "thickness of the wall")
    density: float | Part | None = own_property(
        "wall.density", "kg/m^3", "density of the wall; overrides the material's"
    )
    heat_capacity: float | Part | None = own_property(
        "wall.heat_capacity", "J/(kg*K)", "specific heat capacity of the wall; overrides the material's"
    )
    conductivity: float | Part | None = own_property(
        "wall.conductivity", "W/(m*K)", "thermal conductivity of the wall; overrides the material's"
    )
    layer: Sequence[Table] | None = key(
        "wall.layer",
        "list",
        "layers of the wall from the bed outwards, in place of its material and thickness",
        entries=LAYER,
    )
    opposite_layer: Sequence[Table] | None = key(
        "wall.opposite_layer",
        "list",
        "layers of the wall opposite, from the bed outwards, with geometry.cavity 'whole'; of an annulus's core, from the bed "
        "inwards",
        entries=LAYER,
    )
    cells: int | None = key(
        "solver.wall_cells",
        "integer",
        "cells through the wall; default from its Biot number",
        low=1,
        high=1000,
        closed=True,
    )
    temperature: TimeSeries | None = key(
        "operation.wall_temperature",
        "K",
        "of the bed's wall, for model.wall 'fixed-temperature'",
        low=0.0,
        high=5000.0,
        series=True,
    )

    @property
    def listed(self) -> dict[str, Table]:
        """The layers of the wall and of the wall opposite, each from the bed outwards, by their keys; a plain wall has none."""
        walls = {"layer": self.layer, "opposite_layer": self.opposite_layer}
        return {
            f"wall.{name}[{number}]": layer
            for name, layers in walls.items()
            for number, layer in enumerate(layers or (), start=1)
        }

    def layers(self, solids: Mapping[str, Solid]) -> tuple[Layer, ...]:
        """Of the wall, of `solids` by name: a plain wall is one; there are none without a wall."""
        if self.layer is not None:
            return tuple(_layers(self.layer, solids))
        if self.kind in WITHOUT_OUTSIDE:
            return ()
        return (Layer(name="wall", solid=solids["wall"], thickness=self.thickness, cells=self.cells),)

    def opposite_layers(self, solids: Mapping[str, Solid]) -> tuple[Layer, ...]:
        """Of the wall opposite, which has a place of its own only where the whole cavity is modelled."""
        return tuple(_layers(self.opposite_layer or (), solids))

    def check(self, scene: "Scene") -> None:
        """Layers, thickness and temperature are those that the wall's model needs."""
        if scene.geometry.kind == "mesh":
            if self.kind != "conjugate":
                scene.refuse("model.wall", "must be 'conjugate' for a mesh, which has its own wall")
            if self.thickness is not None:
                scene.refuse("wall.thickness", "has no place in a mesh, which has its own wall")
        elif self.kind not in WITHOUT_OUTSIDE and self.layer is None:
            scene.require("wall.thickness")
        if (self.kind == "fixed-temperature") != (self.temperature is not None):
            allowed = "must be given with model.wall 'fixed-temperature', and only then"
            scene.refuse("operation.wall_temperature", allowed, value=None)
        self._check_opposite(scene)
        if self.listed:
            self._check_layers(scene)
        self._check_cure(scene)

    def _check_opposite(self, scene: "Scene") -> None:
        geometry = dict(scene.geometry)
        is_whole = scene.geometry.cavity == "whole"
        has_two = geometry_of(geometry).has_two_walls(geometry)
        if has_two and not self.opposite_layer:
            key = "geometry.cavity" if is_whole else "geometry.kind"
            scene.refuse(key, "needs the other wall's layers, [[wall.opposite_layer]]")
        if self.opposite_layer and not has_two and scene.geometry.kind == "mesh":
            scene.refuse(
                "wall.opposite_layer",
                "has no place in a mesh: list the layers of all walls under wall.layer",
                value=None,
            )
        if self.opposite_layer and not has_two:
            allowed = "must be 'whole' with [[wall.opposite_layer]]: half a cavity has equal walls"
            scene.refuse("geometry.cavity", allowed)
        if is_whole and scene.geometry.width is not None:
            scene.refuse("geometry.width", "has no place with geometry.cavity 'whole', which is a plane model")

    def _check_layers(self, scene: "Scene") -> None:
        is_mesh = scene.geometry.kind == "mesh"
        if self.kind != "conjugate":
            scene.refuse("model.wall", "must be 'conjugate' with layers of the wall")
        for name in ("material", "thickness", "density", "heat_capacity", "conductivity"):
            if self.layer is not None and scene.is_given(f"wall.{name}"):
                scene.refuse(f"wall.{name}", "cannot be combined with [[wall.layer]]")
        if self.layer is not None and self.cells is not None:
            scene.refuse("solver.wall_cells", "cannot be combined with [[wall.layer]]: set its cells")
        names: dict[str, str] = {}
        outermost = [f"wall.{name}[{len(getattr(self, name) or ())}]" for name in ("layer", "opposite_layer")]
        for place, layer in self.listed.items():
            for name in ("material",) if is_mesh else ("material", "thickness"):
                if getattr(layer, name) is None:
                    of_layer = f" (of {layer.name or layer.material})" if layer.name or layer.material else ""
                    scene.refuse(f"{place}.{name}", f"is missing{of_layer}")
            for name in ("thickness", "cells"):
                if is_mesh and getattr(layer, name) is not None:
                    scene.refuse(f"{place}.{name}", "is the mesh's")
            if layer.contact_resistance and (is_mesh or place in outermost):
                allowed = "needs a layer behind it" if not is_mesh else "has no place in a mesh: draw a thin layer"
                scene.refuse(f"{place}.contact_resistance", allowed)
            name = name_of(layer)
            if name in (*names, *RESERVED_NAMES):
                holder = f": {names[name]} has it" if name in names else ": it is the program's"
                scene.refuse(f"{place}.name", f"must be a name of its own{holder}", value=name)
            names[name] = place

    def _check_cure(self, scene: "Scene") -> None:
        if cures(scene, scene.bed.bead_material):
            scene.refuse("bed.bead_material", "must not cure: only the wall and its layers do")
        plain = not self.layer and cures(scene, self.material)
        if plain and self.kind != "conjugate":
            scene.refuse("model.wall", "must be 'conjugate' with a material that cures")
        any_cures = plain or any(cures(scene, layer.material) for layer in self.listed.values())
        if any_cures and scene.model.flow_update == "transient":
            scene.refuse("model.flow_update", "must not be 'transient' with a material that cures")


def cures(scene: "Scene", material: str | None) -> bool:
    """Whether a material of that name cures."""
    return getattr(scene.materials.get(material or "", SOLIDS.get(material or "")), "cure", None) is not None


def name_of(layer: Table) -> str:
    """The name of a layer, by default its material."""
    return str(layer.name or layer.material)


def contact(name: str, resistance: float) -> Layer:
    """A contact resistance (m2 K/W) as a layer of one cell that conducts as much through it, nothing along it, and stores
    nothing: within `CONTACT_THICKNESS` over the wall's own exact."""
    nothing, source = 1e-9, "contact resistance of the scene"
    material = Solid(name, nothing, 1.0, CONTACT_THICKNESS / resistance, source, conductivity_in_plane=nothing)
    return Layer(name=name, solid=material, thickness=CONTACT_THICKNESS, cells=1, is_contact=True)


def _layers(entries: Sequence[Table], solids: Mapping[str, Solid]) -> Iterator[Layer]:
    """The layers of one wall from its entries in the scene, with its contacts."""
    for entry in entries:
        name = name_of(entry)
        yield Layer(
            name=name,
            solid=solids[name],
            thickness=entry.thickness,
            heat_source=entry.heat_source,
            cells=entry.cells,
        )
        if entry.contact_resistance > 0.0:
            yield contact(f"{name} contact", entry.contact_resistance)
