"""The beads and their porosity, a bed that is stirred, and the averaging volume (REV)."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ...laws import stirring
from ...laws.porosity import POROSITY_MODELS
from ..closures import CLOSURES, THESIS
from ..keys import Part
from .feature import Feature, choice, key, measure, own_property, solid
from .geometries import GEOMETRIES

if TYPE_CHECKING:
    from ..scene import Scene

SMALLEST_RATIO = 10.0
"""Bead diameters that a bed is wide at least."""
_THESIS = CLOSURES[THESIS]


@dataclass(frozen=True, kw_only=True)
class Beads(Feature):
    """Size and material of the beads."""

    diameter: float | None = measure("bed.bead_diameter", "diameter of the beads")
    material: str = solid("bed.bead_material", "material of the beads", "ceramic")
    density: float | Part | None = own_property(
        "bed.bead_density", "kg/m^3", "density of the beads; overrides the material's"
    )
    heat_capacity: float | Part | None = own_property(
        "bed.bead_heat_capacity", "J/(kg*K)", "specific heat capacity of the beads; overrides the material's"
    )
    conductivity: float | Part | None = own_property(
        "bed.bead_conductivity", "W/(m*K)", "thermal conductivity of the beads; overrides the material's"
    )
    contact_flattening: float | None = key(
        "bed.contact_flattening",
        "",
        "flattened fraction of a bead's cross-section, for model.bead_conduction 'zehner-bauer-schluender'; overrides the "
        "material's",
        low=0.0,
        high=0.5,
        closed=True,
    )
    emissivity: float = key(
        "bed.emissivity",
        "",
        "emissivity of the beads, for radiation between them in the same law; 0: none",
        0.0,
        low=0.0,
        high=1.0,
        closed=True,
    )
    allow_small_ratio: bool = key(
        "bed.allow_small_ratio", "flag", "accept a bed narrower than 10 beads, with a warning", False
    )

    def check(self, scene: "Scene") -> None:
        """The bed is wide enough for averages over beads."""
        scene.require("bed.bead_diameter")
        assert self.diameter is not None
        geometry, least = scene.geometry, SMALLEST_RATIO * self.diameter
        for name, width in GEOMETRIES[geometry.kind].widths(geometry).items():
            if width < least * (1 - 1e-9) and not self.allow_small_ratio:
                limit = f"at least {SMALLEST_RATIO:g} bead diameters ({least:g} m)"
                allowed = f"makes the bed {width:.4g} m wide, and must make it {limit}"
                scene.refuse(f"geometry.{name}", f"{allowed}, or set bed.allow_small_ratio = true")
            if self.diameter >= width:
                scene.refuse("bed.bead_diameter", f"must be smaller than the bed, {width:g} m (geometry.{name})")
            if scene.solver.first_cell is not None and scene.solver.first_cell >= width / 2:
                scene.refuse("solver.first_cell", f"must be < {width / 2:g} m, half the bed")


@dataclass(frozen=True, kw_only=True)
class BedPorosity(Feature):
    """Porosity against wall distance: a law, or a profile."""

    model: str = choice(
        "bed.porosity_model", "porosity against wall distance", POROSITY_MODELS, _THESIS["bed.porosity_model"]
    )
    bulk: float = key(
        "bed.bulk_porosity", "", "porosity far from the wall", _THESIS["bed.bulk_porosity"], low=0.0, high=1.0
    )
    profile: Path | None = key(
        "bed.porosity_profile",
        "file",
        "CSV profile (wall distance over bead diameter, phi_V, phi_A), in place of a model",
    )

    def check(self, scene: "Scene") -> None:
        """A profile stands in place of a law, whose bulk porosity has a limit."""
        if self.profile is None:
            limit = POROSITY_MODELS[self.model].largest_bulk_porosity
            if self.bulk > limit:
                scene.refuse("bed.bulk_porosity", f"must be <= {limit:g} with porosity_model {self.model!r}")
            return
        for name in ("bed.bulk_porosity", "bed.porosity_model"):
            if scene.differs_from_default(name):
                scene.refuse(name, "has no place beside bed.porosity_profile, which is used instead")


@dataclass(frozen=True, kw_only=True)
class Stirring(Feature):
    """A bed that is stirred or sheared conducts more across the flow."""

    shear_rate: float = key(
        "bed.shear_rate",
        "1/s",
        "shear rate of a stirred bed; adds conduction across the flow",
        0.0,
        low=0.0,
        closed=True,
    )
    coefficient: float = key(
        "bed.stirring_coefficient",
        "",
        "c of the stirring conductivity c (1 - phi) rho_s C_s d^2 x shear rate",
        stirring.COEFFICIENT,
        low=0.0,
        high=1.0,
    )

    def check(self, scene: "Scene") -> None:
        """The coefficient has a shear rate to go with."""
        if scene.differs_from_default("bed.stirring_coefficient") and not self.shear_rate:
            scene.refuse("bed.stirring_coefficient", "has no meaning without bed.shear_rate")


@dataclass(frozen=True, kw_only=True)
class AveragingVolume(Feature):
    """Terms of the averaging volume (REV) that is not constant."""

    diameter_ratio: float = key(
        "bed.averaging_diameter_ratio",
        "",
        "largest averaging sphere over bead diameter, D_max/d",
        5.5,
        low=0.0,
        high=100,
    )
    terms: str = choice(
        "model.rev_terms",
        "terms of the non-constant averaging volume",
        ("off", "consistent", "as-published"),
        "off",
    )

    def check(self, scene: "Scene") -> None:
        """They need phi_A, which no law has, and a bed at rest."""
        if self.terms == "off":
            return
        if scene.bed.porosity_profile is None:
            scene.refuse("model.rev_terms", "needs bed.porosity_profile: the porosity models give no phi_A")
        if scene.is_locally_developed:
            allowed = "must be 'off' with model.flow 'developed' in three dimensions or a mesh of your own"
            scene.refuse("model.rev_terms", allowed)
        if scene.operation.bead_velocity:
            scene.refuse("model.rev_terms", "must be 'off' with operation.bead_velocity")
