"""The property laws and correlations that a scene chose, and where they come from."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ..laws import bead_interior
from ..laws.conductivity import BEAD_CONDUCTION_LAWS, DISPERSION_LAWS, BeadConduction, Dispersion
from ..laws.drag import DRAG_LAWS, DragLaw
from ..laws.materials import FLUIDS, SOLIDS, ConstantDensity, Fluid, Solid, constant
from ..laws.nusselt import NUSSELT_CORRELATIONS, NusseltCorrelation
from ..laws.porosity import POROSITY_MODELS, Porosity
from ..laws.registry import Registry
from ..laws.turbulence_models import TURBULENCE_MODELS, TurbulenceModel
from .geometries import GEOMETRIES
from .scene import Scene, Table

CHOICES: Mapping[str, Registry[Any]] = {
    "model.drag": DRAG_LAWS,
    "model.bead_conduction": BEAD_CONDUCTION_LAWS,
    "model.dispersion": DISPERSION_LAWS,
    "model.nusselt": NUSSELT_CORRELATIONS,
    "model.turbulence": TURBULENCE_MODELS,
    "bed.porosity_model": POROSITY_MODELS,
    "bed.bead_material": SOLIDS,
    "wall.material": SOLIDS,
    "fluid.material": FLUIDS,
}
"""The keys of a scene that name a law, with the registry that holds it."""


@dataclass(frozen=True)
class Laws:
    """Of one scene: materials, correlations and the porosity; `turbulence` is None where there is none, `wall` the wall's
    material whether the scene has a wall or not."""

    fluid: Fluid
    beads: Solid
    wall: Solid
    drag: DragLaw
    nusselt: NusseltCorrelation
    bead_conduction: BeadConduction
    dispersion: Dispersion
    turbulence: TurbulenceModel | None
    porosity: Porosity

    @classmethod
    def of(cls, scene: Scene) -> "Laws":
        """Those of a scene: the library's, with constant properties in place of those given."""
        bed, wall, model = scene.bed, scene.wall, scene.model
        return cls(
            _fluid(scene.fluid),
            _solid(
                bed.bead_material,
                bed.bead_density,
                bed.bead_heat_capacity,
                bed.bead_conductivity,
                bed.contact_flattening,
            ),
            _solid(wall.material, wall.density, wall.heat_capacity, wall.conductivity),
            replace(DRAG_LAWS[model.drag].for_width(width_ratio(scene)), factor=model.drag_factor),
            NUSSELT_CORRELATIONS[model.nusselt],
            replace(BEAD_CONDUCTION_LAWS[model.bead_conduction], factor=model.conduction_factor),
            replace(DISPERSION_LAWS[model.dispersion], factor=model.conduction_factor),
            _turbulence(model),
            scene.porosity,
        )

    @property
    def bulk_porosity(self) -> float:
        """Porosity far from the wall."""
        return self.porosity.bulk_porosity

    def properties(self, has_wall: bool) -> list[tuple[str, str, Any]]:
        """All property laws in use: (owner, name of the property, law)."""
        owners: list[Fluid | Solid] = [self.fluid, self.beads, *([self.wall] if has_wall else [])]
        return [(owner.name, name, law) for owner in owners for name, law in owner.laws().items()]

    def sources(self, has_wall: bool, bead_modes: bool) -> dict[str, str]:
        """Where the laws and properties in use come from, by what they are used for."""
        sources = {"drag": self.drag.source, "nusselt": self.nusselt.source, "porosity": self.porosity.source}
        sources |= {"bead conduction": self.bead_conduction.source, "dispersion": self.dispersion.source}
        if self.turbulence is not None:
            sources["turbulence"] = self.turbulence.source
        if bead_modes:
            sources["bead interior"] = bead_interior.SOURCE
        return sources | {f"{owner} {name}": law.source for owner, name, law in self.properties(has_wall)}


def width_ratio(scene: Scene) -> float:
    """Hydraulic diameter over that of the beads: D/d of a pipe, 2 H/d of a cavity; infinite where only the mesh knows."""
    size = GEOMETRIES[scene.geometry.kind].size(scene.geometry)
    return float("inf") if size is None else 4.0 * size.area / size.walled_perimeter / float(scene.bed.bead_diameter)


def _turbulence(model: Table) -> TurbulenceModel | None:
    chosen = TURBULENCE_MODELS[model.turbulence]
    if chosen is None or model.flow == "plug":
        return None
    values = dict(model)
    given: dict[str, Any] = {name: values[name] for name in chosen.parameters if name in values}
    return replace(chosen, **given)


def _fluid(given: Table) -> Fluid:
    changes: dict[str, Any] = {
        name: constant(value, "", "scene")
        for name in ("viscosity", "heat_capacity", "conductivity")
        if (value := getattr(given, name)) is not None
    }
    if given.density is not None:
        changes |= {"density": ConstantDensity(given.density, "scene"), "name": "liquid"}
    return replace(FLUIDS[given.material], **changes)


def _solid(
    material: str,
    density: float | None,
    heat_capacity: float | None,
    conductivity: float | None,
    contact_flattening: float | None = None,
) -> Solid:
    given = {"density": density, "heat_capacity": heat_capacity, "conductivity": conductivity}
    changes: dict[str, Any] = {name: constant(value, "", "scene") for name, value in given.items() if value is not None}
    if contact_flattening is not None:
        changes["contact_flattening"] = contact_flattening
    return replace(SOLIDS[material], **changes)
