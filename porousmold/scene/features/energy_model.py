"""The heat's equations: one or two temperatures, inside of beads, exchange, conduction and dispersion; the set of closures."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ...laws.conductivity import BEAD_CONDUCTION_LAWS, DISPERSION_LAWS
from ...laws.nusselt import NUSSELT_CORRELATIONS
from ..closures import CLOSURES, THESIS
from .feature import Feature, choice, key

if TYPE_CHECKING:
    from ..scene import Scene

_THESIS = CLOSURES[THESIS]


@dataclass(frozen=True, kw_only=True)
class EnergyModel(Feature):
    """Temperatures in the bed, and the laws that tell how heat is exchanged and conducted."""

    energy: str = choice(
        "model.energy",
        "separate temperatures of fluid and beads, or one temperature",
        ("two-temperature", "one-temperature"),
        "two-temperature",
    )
    bead_modes: int | None = key(
        "model.bead_modes",
        "integer",
        "transient modes of the temperature inside a bead, others quasi-steady; not set: beads are isothermal",
        low=0,
        high=16,
        closed=True,
    )
    closures: str = choice(
        "model.closures",
        "set of closures, the thesis's or those supported by measurements: default of bead_conduction, dispersion, drag, "
        "turbulence, bed.porosity_model and bed.bulk_porosity if these are not set",
        CLOSURES,
        THESIS,
    )
    nusselt: str = choice("model.nusselt", "Nusselt correlation between fluid and beads", NUSSELT_CORRELATIONS, "wakao")
    exchange_factor: float = key(
        "model.exchange_factor",
        "",
        "factor on the coefficient of heat exchange between fluid and beads; what model.bead_modes resists inside stays",
        1.0,
        low=0.0,
        high=1e6,
    )
    bead_conduction: str = choice(
        "model.bead_conduction",
        "bead conduction: parallel to the fluid, or from the stagnant conductivity of the bed",
        BEAD_CONDUCTION_LAWS,
        _THESIS["model.bead_conduction"],
    )
    conductivity_profile: Path | None = key(
        "bed.conductivity_profile",
        "file",
        "CSV profile (wall distance, stagnant conductivity of bed and fluid), as written by `porousmold conductivity`, in "
        "place of model.bead_conduction",
    )
    dispersion: str = choice(
        "model.dispersion",
        "thermal dispersion; with turbulence, the larger of dispersion and eddy conductivity",
        DISPERSION_LAWS,
        _THESIS["model.dispersion"],
    )
    conduction_factor: float = key(
        "model.conduction_factor",
        "",
        "factor on bead conduction and thermal dispersion, for their scatter",
        1.0,
        low=0.0,
        high=1e3,
    )

    @property
    def two_temperatures(self) -> bool:
        """Whether fluid and beads have a temperature each."""
        return self.energy == "two-temperature"

    def check(self, scene: "Scene") -> None:
        """Modes inside of beads have two temperatures; a profile of the conductivity stands in place of a law."""
        if self.bead_modes is not None:
            for name, value in (("energy", "one-temperature"), ("flow_update", "transient")):
                if getattr(scene.model, name) == value:
                    scene.refuse("model.bead_modes", f"cannot be combined with model.{name} {value!r}")
        if self.conductivity_profile is not None:
            for full_name in ("model.bead_conduction", "bed.emissivity", "bed.contact_flattening"):
                if scene.differs_from_default(full_name):
                    scene.refuse(full_name, "has no place beside bed.conductivity_profile, which is used instead")
