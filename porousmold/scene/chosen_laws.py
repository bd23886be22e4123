"""The property laws and correlations that a scene chose, and where they come from."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from ..errors import InputError
from ..laws import bead_interior, stirring
from ..laws.conductivity import BEAD_CONDUCTION_LAWS, DISPERSION_LAWS, BeadConduction, Dispersion
from ..laws.drag import DRAG_LAWS, DragLaw
from ..laws.material_library import FLUIDS, SOLIDS
from ..laws.materials import CHANGED, UNITS, ConstantDensity, Fluid, Solid, constant, without_value
from ..laws.nusselt import NUSSELT_CORRELATIONS, NusseltCorrelation
from ..laws.phases import other_phase
from ..laws.porosity import POROSITY_MODELS, Porosity
from ..laws.real_gas import real_gas
from ..laws.registry import Registry
from ..laws.turbulence_models import TURBULENCE_MODELS, TurbulenceModel
from .features.geometries import GEOMETRIES
from .features.wall import name_of
from .keys import Part, Table
from .scene import Scene
from .series import TimeSeries

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
Material = TypeVar("Material", Fluid, Solid)


@dataclass(frozen=True)
class Laws:
    """Of one scene: materials, correlations and the porosity; `turbulence` is None where there is none, `walls` the
    materials of the wall's layers by their names, those of the opposite wall after them, of a plain one as "wall", whether the
    scene has a wall or not."""

    fluid: Fluid
    beads: Solid
    walls: Mapping[str, Solid]
    drag: DragLaw
    nusselt: NusseltCorrelation
    bead_conduction: BeadConduction
    dispersion: Dispersion
    turbulence: TurbulenceModel | None
    porosity: Porosity

    @classmethod
    def of(cls, scene: Scene) -> "Laws":
        """Those of a scene: the library's, with constant properties in place of those given."""
        bed, model = scene.bed, scene.model
        return cls(
            _fluid(scene),
            _with_given(
                scene,
                "bed.bead_",
                _solid(scene, bed.bead_material),
                density=bed.bead_density,
                heat_capacity=bed.bead_heat_capacity,
                conductivity=bed.bead_conductivity,
                contact_flattening=bed.contact_flattening,
            ),
            _walls(scene),
            replace(DRAG_LAWS[model.drag].for_width(width_ratio(scene)), factor=model.drag_factor),
            NUSSELT_CORRELATIONS[model.nusselt],
            _bead_conduction(scene),
            replace(DISPERSION_LAWS[model.dispersion], factor=model.conduction_factor),
            _turbulence(model),
            scene.porosity,
        )

    @property
    def bulk_porosity(self) -> float:
        """Porosity far from the wall."""
        return self.porosity.bulk_porosity

    def materials(self, has_wall: bool) -> dict[str, Fluid | Solid]:
        """The materials in use, by what they are the material of."""
        return {"fluid": self.fluid, "beads": self.beads, **(self.walls if has_wall else {})}

    def sources(self, bead_modes: bool) -> dict[str, str]:
        """Where the laws in use come from, by what they are used for."""
        sources = {"drag": self.drag.source, "nusselt": self.nusselt.source, "porosity": self.porosity.source}
        sources |= {"bead conduction": self.bead_conduction.source, "dispersion": self.dispersion.source}
        if self.bead_conduction.mixing_rate:
            sources["stirring"] = stirring.SOURCE
        if self.turbulence is not None:
            sources["turbulence"] = self.turbulence.source
        if bead_modes:
            sources["bead interior"] = bead_interior.SOURCE
        return sources


def width_ratio(scene: Scene) -> float:
    """Hydraulic diameter over that of the beads: D/d of a pipe, 2 H/d of a cavity; infinite where only the mesh knows."""
    size = GEOMETRIES[scene.geometry.kind].size(scene.geometry)
    return float("inf") if size is None else 4.0 * size.area / size.walled_perimeter / float(scene.bed.bead_diameter)


def _bead_conduction(scene: Scene) -> BeadConduction:
    """The law of the scene or its table, with what stirring adds."""
    bed, law = scene.bed, BEAD_CONDUCTION_LAWS[scene.model.bead_conduction]
    if scene.conductivity_profile is not None:
        law = BeadConduction(scene.conductivity_profile, str(bed.conductivity_profile), whole_bed=True)
    mixing_rate = float(bed.stirring_coefficient * bed.shear_rate)
    return replace(law, factor=scene.model.conduction_factor, mixing_rate=mixing_rate)


def _turbulence(model: Table) -> TurbulenceModel | None:
    chosen = TURBULENCE_MODELS[model.turbulence]
    if chosen is None or model.flow == "plug":
        return None
    values = dict(model)
    given: dict[str, Any] = {name: values[name] for name in chosen.parameters if name in values}
    return replace(chosen, **given)


def _fluid(scene: Scene) -> Fluid:
    given = scene.fluid
    fluid = scene.materials.get(given.material, FLUIDS.get(given.material))
    assert isinstance(fluid, Fluid), "checked with the scene"
    if given.real_gas:
        fluid = real_gas(fluid, scene.operation.outlet_pressure, scene.source)
    changed = _with_given(
        scene,
        "fluid.",
        fluid,
        viscosity=given.viscosity,
        heat_capacity=given.heat_capacity,
        conductivity=given.conductivity,
    )
    if given.density is None:
        return changed
    return replace(changed, density=ConstantDensity(given.density, "scene"), name="liquid of the scene")


def _walls(scene: Scene) -> dict[str, Solid]:
    wall = scene.wall
    layers = {name_of(layer): _of_table(scene, place, layer) for place, layer in scene.layers.items()}
    return layers if wall.layer is not None else {"wall": _of_table(scene, "wall", wall)} | layers


def _of_table(scene: Scene, place: str, table: Table) -> Solid:
    """The solid of a wall's or a layer's table."""
    return _with_given(
        scene,
        f"{place}.",
        _solid(scene, table.material),
        density=table.density,
        heat_capacity=table.heat_capacity,
        conductivity=table.conductivity,
    )


def _solid(scene: Scene, name: str) -> Solid:
    solid = scene.materials.get(name, SOLIDS.get(name))
    assert isinstance(solid, Solid), "checked with the scene"
    return solid


def _with_given(scene: Scene, prefix: str, material: Material, **given: float | Part | None) -> Material:
    """The material with constant properties in place of those given, or with parts of its laws; its name tells which."""
    changes: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    if not changes:
        return material
    parts = {name: value for name, value in changes.items() if isinstance(value, Part)}
    laws: dict[str, Any] = {
        name: constant(value, UNITS[name], "scene")
        for name, value in changes.items()
        if name in UNITS and name not in parts
    }
    for name, part in parts.items():
        law = getattr(material, name)
        if not hasattr(law, "times"):
            allowed = f"must be a value: the {name} of {material.name} is a law of its own code"
            scene.refuse(f"{prefix}{name}", allowed)
        laws[name] = law.times(part.factor)
    whole = not parts and material.laws().keys() <= changes.keys()
    described = "constants of the scene" if whole else f"{material.name}{CHANGED}{' and '.join(changes)} of the scene"
    return replace(material, **(changes | laws | {"name": described}))


def require_phase(scene: Scene, laws: Laws) -> None:
    """Raise `InputError` where a temperature that is given for the fluid makes another phase of it, or nonsense of a material:
    a polynomial far outside its range."""
    pressure, drop = scene.operation.outlet_pressure, scene.operation.pressure_drop
    pressures = dict.fromkeys((pressure, pressure + (0.0 if drop is None else drop.range[1])))  # at outlet and inlet
    materials = laws.materials(scene.model.wall in ("conjugate", "thin"))
    for name, temperature in _given_to_the_fluid(scene):
        key = f"operation.{name}"
        for one in pressures:
            if (text := other_phase(laws.fluid.substance, one, temperature)) is not None:
                raise InputError(key, temperature, f"does not fit fluid.material: {text}", scene.source)
        for material in materials.values():
            if text := without_value(material, pressure, temperature):
                raise InputError(key, temperature, text, scene.source)


def _given_to_the_fluid(scene: Scene) -> Iterator[tuple[str, float]]:
    """(key, temperature in K) of what the fluid is given: the ends of every range."""
    operation = scene.operation
    yield from (
        ("initial_temperature", one) for one in (scene.start.range if scene.start else (operation.initial_temperature,))
    )
    for name in ("inlet_temperature", "return_temperature", "fresh_temperature"):
        value = getattr(operation, name)
        if value is not None:
            yield from ((name, one) for one in (value.range if isinstance(value, TimeSeries) else (value,)))
