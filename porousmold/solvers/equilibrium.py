"""The initial guess of a flow: what drag and beads alone would make of it at every place."""

from typing import Any

import numpy as np

from .. import fenicsx
from ..closures import turbulence as closure
from ..equations.flow import FlowEquations
from ..materials import Fluid


def local_equilibrium(
    equations: FlowEquations,
    fluid: Fluid,
    space: Any,
    gradient: float,
    temperature: np.ndarray,
    gauge_pressure: np.ndarray,
) -> list[np.ndarray]:
    """Nodal arrays [speed (m/s), k (m2/s2), epsilon (m2/s3)] over a scalar space, the last two where `equations` are turbulent.

    The speed at which the local drag balances the pressure gradient (Pa/m), fading in a layer at the wall, and the beads'
    undamped turbulence at that speed, with the wall layer's epsilon near the wall. `equations` are `FlowEquations`, `fluid` is
    the scene's `Fluid`, temperature (K) and gauge pressure (Pa) are nodal arrays.
    """
    bed, scale = equations.bed, float(equations.scales.speed.value)
    diameter = float(bed.bead_diameter.value)
    porosity, distance = (fenicsx.nodal_values(expression, space) for expression in (bed.porosity, bed.wall_distance))
    porosity, distance = np.clip(porosity, 0.0, 0.95), np.maximum(distance, 0.0)
    viscosity = fluid.viscosity(temperature)
    density = fluid.density(gauge_pressure + float(equations.fluid.reference_pressure.value), temperature)
    speed = bed.drag.speed(porosity * gradient, porosity, diameter, density, viscosity)
    speed *= -np.expm1(-distance / np.sqrt(2.0 * viscosity * scale / gradient))
    if equations.model is None:
        return [speed]
    energy = closure.bead_kinetic_energy(porosity, speed) + 0.01 * speed**2
    between_beads = closure.bead_dissipation_rate(porosity, speed, diameter) + 0.01 * speed**3 / diameter
    off_wall = np.maximum(distance, 1e-6 * diameter)
    reynolds = closure.wall_reynolds_number(density, off_wall, energy, viscosity)
    outer = closure.outer_fraction(reynolds, float(equations.model.blend_half_width.value))
    at_wall = closure.inner_dissipation_rate(energy, reynolds, off_wall, viscosity / density)
    return [speed, energy, outer * between_beads + (1.0 - outer) * at_wall]
