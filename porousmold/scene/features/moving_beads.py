"""Beads that move along the bed as a plug."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..series import TimeSeries
from .feature import Feature, key

if TYPE_CHECKING:
    from ..scene import Scene


@dataclass(frozen=True, kw_only=True)
class BeadMotion(Feature):
    """`velocity` (m/s), positive along the flow, and the temperature (K) with which the beads enter."""

    velocity: float = key(
        "operation.bead_velocity",
        "m/s",
        "of beads that move as a plug: positive along the flow, negative against it",
        0.0,
        low=-10.0,
        high=10.0,
    )
    inlet_temperature: TimeSeries | None = key(
        "operation.bead_inlet_temperature",
        "K",
        "of the entering beads, for bead_velocity",
        low=0.0,
        high=5e3,
        series=True,
    )

    def check(self, scene: "Scene") -> None:
        """Moving beads have a temperature, a straight bed, and equations that carry them."""
        moves, model = self.velocity != 0.0, scene.model
        if moves != (self.inlet_temperature is not None):
            allowed = "must be given with operation.bead_velocity, and only then"
            scene.refuse("operation.bead_inlet_temperature", allowed, value=None)
        if not moves:
            return
        if scene.geometry.kind == "mesh":
            allowed = "has no place in a mesh of your own: beads move along straight beds"
            scene.refuse("operation.bead_velocity", allowed)
        if scene.is_locally_developed:
            allowed = "must be 0 with model.flow 'developed' in three dimensions or a mesh of your own"
            scene.refuse("operation.bead_velocity", allowed)
        if model.bead_modes is not None:
            allowed = "cannot be combined with operation.bead_velocity: moving beads are isothermal"
            scene.refuse("model.bead_modes", allowed)
        for name, excluded, needed in (
            ("energy", "one-temperature", "two-temperature"),
            ("flow_update", "transient", "quasi-steady or frozen"),
        ):
            if getattr(model, name) == excluded:
                scene.refuse(f"model.{name}", f"must be {needed!r} with operation.bead_velocity")
