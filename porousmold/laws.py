"""The property laws and correlations that a scene chose, and where they come from."""

from dataclasses import dataclass, replace

from .closures import bead_interior
from .closures.drag import DRAG_LAWS, DragLaw
from .closures.nusselt import NUSSELT_CORRELATIONS, NusseltCorrelation
from .equations.turbulence import TurbulenceModel
from .materials import FLUIDS, SOLIDS, ConstantDensity, Fluid, Solid, constant
from .porosity.models import POROSITY_MODELS

TURBULENCE_MODELS = {
    "none": None,
    "k-epsilon": TurbulenceModel(),
    "nakayama-kuwahara": TurbulenceModel(bead_sources=True),
    "damped-nakayama-kuwahara": TurbulenceModel(bead_sources=True, damped=True),
}


@dataclass(frozen=True)
class Laws:
    """Of one scene: materials, correlations and the bulk porosity; `turbulence` is None where there is none, `wall` the
    wall's material whether the scene has a wall or not."""

    fluid: Fluid
    beads: Solid
    wall: Solid
    drag: DragLaw
    nusselt: NusseltCorrelation
    turbulence: TurbulenceModel | None
    bulk_porosity: float

    @classmethod
    def of(cls, scene):
        """Those of a scene: the library's, with constant properties in place of those given."""
        bed, wall, model = scene.bed, scene.wall, scene.model
        return cls(
            _fluid(scene.fluid),
            _solid(bed.bead_material, bed.bead_density, bed.bead_heat_capacity, bed.bead_conductivity),
            _solid(wall.material, wall.density, wall.heat_capacity, wall.conductivity),
            DRAG_LAWS[model.drag],
            NUSSELT_CORRELATIONS[model.nusselt],
            _turbulence(model),
            bed.bulk_porosity if scene.profile is None else scene.profile.bulk_porosity,
        )

    def properties(self, has_wall):
        """All property laws in use: (owner, name of the property, law)."""
        owners: list[Fluid | Solid] = [self.fluid, self.beads, *([self.wall] if has_wall else [])]
        return [(owner.name, name, law) for owner in owners for name, law in owner.laws().items()]

    def sources(self, scene, has_wall):
        """Where the closures and properties of the scene come from, by what they are used for."""
        bed = scene.bed
        porosity = POROSITY_MODELS[bed.porosity_model].source if scene.profile is None else str(bed.porosity_profile)
        sources = {"drag": self.drag.source, "nusselt": self.nusselt.source, "porosity": porosity}
        if self.turbulence is not None:
            sources["turbulence"] = "Launder, Spalding 1974; Chen, Patel 1988; Nakayama, Kuwahara 1999; thesis eq. 7.33"
        if scene.model.bead_modes is not None:
            sources["bead interior"] = bead_interior.SOURCE
        return sources | {f"{owner} {name}": law.source for owner, name, law in self.properties(has_wall)}


def _turbulence(model):
    chosen = TURBULENCE_MODELS[model.turbulence]
    if chosen is None or model.flow == "plug":
        return None
    return replace(chosen, blend_half_width=model.blend_half_width, longest_eddy=model.longest_eddy)


def _fluid(given):
    changes = {
        name: constant(value, "", "scene")
        for name in ("viscosity", "heat_capacity", "conductivity")
        if (value := getattr(given, name)) is not None
    }
    if given.density is not None:
        changes |= {"density": ConstantDensity(given.density, "scene"), "name": "liquid"}
    return replace(FLUIDS[given.material], **changes)


def _solid(material, density, heat_capacity, conductivity):
    given = {"density": density, "heat_capacity": heat_capacity, "conductivity": conductivity}
    changes = {name: constant(value, "", "scene") for name, value in given.items() if value is not None}
    return replace(SOLIDS[material], **changes)
