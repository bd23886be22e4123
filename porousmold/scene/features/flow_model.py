"""The flow's equations: which model, its turbulence and drag, and how it follows the temperatures."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from ...laws.drag import DRAG_LAWS
from ...laws.turbulence_models import TURBULENCE_MODELS
from ..closures import CLOSURES, THESIS
from .feature import Feature, choice, key

if TYPE_CHECKING:
    from ..scene import Scene

FlowKind = Literal["full", "developed", "plug"]
FlowUpdate = Literal["quasi-steady", "frozen", "transient"]
_THESIS = CLOSURES[THESIS]
LARGEST_TOLERANCE = 0.05
"""To which fewer steps raise the flow's tolerance at most."""


@dataclass(frozen=True, kw_only=True)
class FlowModel(Feature):
    """Full, locally developed or plug flow; `update` tells how it follows the temperatures, to which `tolerance`."""

    kind: FlowKind = choice(
        "model.flow",
        "flow model: full (2D or 3D), locally developed profiles, or plug flow",
        ("full", "developed", "plug"),
        "full",
    )
    update: FlowUpdate = choice(
        "model.flow_update",
        "update of the flow as temperatures change",
        ("quasi-steady", "frozen", "transient"),
        "quasi-steady",
    )
    tolerance: float = key(
        "solver.flow_tolerance",
        "",
        "convergence tolerance of the flow in a time step (relative update); over step_refinement, to 0.05 at most where that "
        "is below 1",
        0.01,
        low=0.0,
        high=1.0,
    )
    turbulence: str = choice(
        "model.turbulence", "turbulence model, bead sources included", TURBULENCE_MODELS, _THESIS["model.turbulence"]
    )
    blend_half_width: float = key(
        "model.blend_half_width",
        "",
        "half-width, in Re_y, of the blending of the near-wall layer and k-epsilon at Re_y = 200; published: 20",
        120.0,
        low=1.0,
        high=200.0,
        closed=True,
    )
    longest_eddy: float = key(
        "model.longest_eddy",
        "",
        "upper limit of the turbulence length k^1.5/epsilon over the bead diameter; published: none (same as 1e6)",
        1.0,
        low=0.1,
        high=1e9,
        closed=True,
    )
    drag: str = choice("model.drag", "drag law of the bed", DRAG_LAWS, _THESIS["model.drag"])
    drag_factor: float = key(
        "model.drag_factor",
        "",
        "factor on the drag of the beads, for its experimental scatter",
        1.0,
        low=0.0,
        high=1e3,
    )

    def tolerance_with(self, step_refinement: float) -> float:
        """That of a run's own steps, refined by a factor."""
        return min(self.tolerance / step_refinement, max(self.tolerance, LARGEST_TOLERANCE))

    def check(self, scene: "Scene") -> None:
        """The flow can be had in the geometry, and solved for as it is asked."""
        geometry = scene.geometry
        if self.kind == "plug" and scene.has_no_stations:
            what = "with geometry.width" if geometry.kind != "mesh" else "for a mesh, which has no axial stations"
            scene.refuse("model.flow", f"must be 'full' or 'developed' {what}")
        if self.update == "transient" and self.kind != "full":
            scene.refuse("model.flow_update", "must go with model.flow 'full'")
