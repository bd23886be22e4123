"""The fluid and its pressure."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...laws.material_library import FLUIDS
from ..closures import CLOSURES, THESIS
from ..keys import Part
from .feature import OWN_MATERIAL, Feature, choice, key, own_property

if TYPE_CHECKING:
    from ..scene import Scene


@dataclass(frozen=True, kw_only=True)
class BedFluid(Feature):
    """What flows through the bed; properties that are given stand in place of the material's."""

    material: str = choice(
        "fluid.material",
        "material of the fluid",
        FLUIDS,
        CLOSURES[THESIS]["fluid.material"],
        else_allowed=OWN_MATERIAL,
    )
    real_gas: bool = key(
        "fluid.real_gas",
        "flag",
        "properties of the real gas about operation.outlet_pressure, 1 to 50 bar, in place of the ideal gas and properties at "
        "1 bar",
        False,
    )
    density: float | None = key(
        "fluid.density", "kg/m^3", "constant density: makes the fluid a liquid", low=0.0, high=1e7
    )
    viscosity: float | Part | None = own_property(
        "fluid.viscosity", "Pa*s", "constant viscosity; overrides the material's"
    )
    heat_capacity: float | Part | None = own_property(
        "fluid.heat_capacity", "J/(kg*K)", "constant heat capacity; overrides the material's"
    )
    conductivity: float | Part | None = own_property(
        "fluid.conductivity", "W/(m*K)", "constant thermal conductivity; overrides the material's"
    )
    outlet_pressure: float = key(
        "operation.outlet_pressure", "Pa", "absolute static pressure at the outlet", 101325.0, low=0.0, high=1e9
    )

    def check(self, scene: "Scene") -> None:
        """A liquid has all its properties."""
        if not scene.is_given("fluid.density"):
            return
        for name in ("viscosity", "heat_capacity", "conductivity"):
            if not scene.is_given(f"fluid.{name}"):
                scene.refuse(f"fluid.{name}", "is missing: a liquid needs all four properties", value=None)
            if isinstance(scene.value(f"fluid.{name}"), Part):
                scene.refuse(f"fluid.{name}", "must be a value: a liquid with fluid.density has no material")
