"""What the outer wall exchanges with its surroundings."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...laws.conductivity import STEFAN_BOLTZMANN
from ..series import TimeSeries
from .feature import Feature, key
from .wall import WITHOUT_OUTSIDE

if TYPE_CHECKING:
    from ..scene import Scene


@dataclass(frozen=True, kw_only=True)
class OuterWall(Feature):
    """`heat_flux` in (W/m2) times a factor, `coefficient` (W/m2/K) and radiation by an `emissivity` to `ambient` (K)."""

    heat_flux: TimeSeries | None = key(
        "operation.outer_heat_flux",
        "W/m^2",
        "heat flux into the outer wall (negative: loss; not set: adiabatic); a file may have columns `0.1 m [W/m^2]`, ... "
        "from the inlet along the flow",
        low=-1e7,
        high=1e7,
        series=True,
        along=True,
    )
    heat_flux_factor: float = key(
        "operation.outer_heat_flux_factor",
        "",
        "factor on outer_heat_flux, for the error of its sensors",
        1.0,
        low=0.0,
        high=10.0,
    )
    coefficient: float | None = key(
        "operation.outer_coefficient",
        "W/(m^2*K)",
        "heat transfer coefficient of the outer wall (not set: adiabatic)",
        low=0.0,
        high=1e6,
    )
    emissivity: float | None = key(
        "operation.outer_emissivity",
        "",
        "emissivity of the outer wall, which radiates to ambient_temperature",
        low=0.0,
        high=1.0,
        closed=True,
    )
    ambient: TimeSeries | None = key(
        "operation.ambient_temperature", "K", "outside the outer wall", low=0.0, high=5000.0, series=True
    )

    def film(self, temperature: float) -> float:
        """Coefficient (W/m2/K) about a temperature (K) of the outer wall, radiation included; 0 without either."""
        return (self.coefficient or 0.0) + 4.0 * (self.emissivity or 0.0) * STEFAN_BOLTZMANN * temperature**3

    @property
    def exchanges(self) -> bool:
        """Whether heat passes to the surroundings."""
        return self.coefficient is not None or self.emissivity is not None

    def check(self, scene: "Scene") -> None:
        """There is an outer wall, and what is outside has a temperature."""
        if scene.model.wall in WITHOUT_OUTSIDE and (self.exchanges or self.heat_flux is not None):
            scene.refuse("model.wall", "excludes operation.outer_heat_flux, outer_coefficient and outer_emissivity")
        if self.heat_flux is None and self.heat_flux_factor != 1.0:
            scene.refuse("operation.outer_heat_flux_factor", "has no meaning without operation.outer_heat_flux")
        together = "and operation.ambient_temperature must be given together"
        if self.emissivity is not None and self.ambient is None:
            scene.refuse("operation.outer_emissivity", together)
        if self.exchanges != (self.ambient is not None):
            scene.refuse("operation.outer_coefficient", together)
