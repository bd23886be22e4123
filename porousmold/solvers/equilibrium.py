"""Initial guess of a flow: local equilibrium of pressure gradient, drag and bead turbulence."""

from dataclasses import replace

import numpy as np
import ufl

from ..arrays import Floats
from ..equations.flow import FlowEquations
from ..laws.functions import number_of
from ..laws.materials import Fluid
from ..laws.turbulence_models import LocalFlow
from ..mesh.aliases import Space
from ..mesh.point_values import nodal_values

SMALLEST_DRIVE = 1e-6
"""Of the largest drive in the bed: a guess does not flow backwards."""


def local_equilibrium(
    equations: FlowEquations,
    fluid: Fluid,
    space: Space,
    gradient: float | Floats,
    temperature: Floats,
    gauge_pressure: Floats,
) -> list[Floats]:
    """Nodal arrays [speed (m/s), the turbulence's unknowns (SI) ...] over a scalar space.

    The speed at which the local drag balances gravity and the pressure gradient (Pa/m, positive where the pressure falls, a
    number or one for each node), fading in a layer at the wall, and the turbulence model's own guess at that speed. `fluid` is
    the scene's `Fluid`, temperature (K) and gauge pressure (Pa) are nodal arrays.
    """
    bed, scale = equations.bed, float(equations.scales.speed.value)
    diameter = float(bed.bead_diameter.value)
    porosity, distance = nodal_values(ufl.as_vector([bed.porosity, bed.wall_distance]), space)
    porosity, distance = np.clip(porosity, 0.0, 0.95), np.maximum(distance, 0.0)
    viscosity = fluid.viscosity(temperature)
    density = fluid.density(gauge_pressure + float(equations.fluid.reference_pressure.value), temperature)
    drag = replace(bed.drag, factor=number_of(bed.drag.factor))
    driving = gradient + np.zeros(len(temperature))
    if equations.gravity is not None:
        driving += density * nodal_values(equations.gravity[0], space)
    driving = np.maximum(driving, SMALLEST_DRIVE * np.max(np.abs(driving)))
    speed = drag.speed(porosity * driving, porosity, diameter, density, viscosity)
    speed *= -np.expm1(-distance / np.sqrt(2.0 * viscosity * scale / driving))
    if equations.model is None:
        return [speed]
    off_wall = np.maximum(distance, 1e-6 * diameter)
    return [speed, *equations.model.guess(LocalFlow(porosity, diameter, off_wall, density, viscosity, speed, scale))]
