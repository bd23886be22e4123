"""The mass flow to be expected through a bed, before anything is solved in two dimensions.

The flow past the beads is developed across the bed within some bead diameters: at the pressure gradient G of the estimates the
speed follows from the porosity at each distance from the wall, as in `equations.developed` but laminar and of one temperature,

    -d/dy(mu phi du/dy) + f(phi, |u|) u = phi G,    u = 0 at the wall,    du/dy = 0 in the middle.

Drag rules all but the layer at the wall, so that turbulence counts for little: over random scenes of every drag law, porosity
and turbulence model the mass flow of the run was met within 5 % (`tests/simulation/test_expected_flow.py`). The middle of the bed
alone, which `estimates` go by, is up to 35 % too low.
"""

import numpy as np
from scipy.linalg import solve_banded

from ..arrays import Floats
from ..scene.features.geometries import BedSize
from .estimates import Estimates, fluid_at
from .specs import Specs

NODES = 300
"""From the wall to the middle, in geometric progression from a ten thousandth of a bead."""
MOST_ITERATIONS, CONVERGED = 60, 1e-6
LARGEST_POROSITY = 1.0 - 1e-6


def expected_mass_flow(specs: Specs, size: BedSize, estimates: Estimates) -> float:
    """Mass flow (kg/s) of the modelled part, warm, at the strongest drive; what is given of it as it is given."""
    if specs.flow.drive != "pressure_drop" or specs.flow.model.kind == "plug" or not estimates.flows:
        return estimates.driven_part * estimates.mass_flow if estimates.flows else 0.0
    depths = np.concatenate([[0.0], np.geomspace(1e-4 * specs.mesh.bead_diameter, size.half_height, NODES)])
    porosity = np.minimum(specs.porosity.volume(depths, specs.mesh.bead_diameter), LARGEST_POROSITY)
    speed = _profile(specs, depths, porosity, estimates.driven_gradient)
    around = size.half_height - depths if size.is_disk else np.ones_like(depths)
    mean = _integral(porosity * speed * around, depths) / _integral(around, depths)
    return float(estimates.mass_flow * mean / (specs.porosity.bulk_porosity * estimates.speed))


def _profile(specs: Specs, depths: Floats, porosity: Floats, gradient: float) -> Floats:
    """Speed (m/s) between the beads at depths (m) from the wall, by repeated linear solves that are half taken over."""
    fluid, drag, diameter = (
        fluid_at(specs, specs.heat.inlet_temperature.values[-1]),
        specs.laws.drag,
        specs.mesh.bead_diameter,
    )
    steps, between = np.diff(depths), 0.5 * (porosity[1:] + porosity[:-1])
    conductance = fluid.viscosity * between / steps
    volumes = 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))
    force = porosity * gradient
    speed = np.asarray(drag.speed(force, porosity, diameter, fluid.density, fluid.viscosity), float)
    bands = np.zeros((3, len(depths)))
    for _ in range(MOST_ITERATIONS):
        resistance = drag.coefficient(porosity, diameter, fluid.density, fluid.viscosity, np.abs(speed))
        bands[1] = volumes * resistance + np.append(conductance, 0.0) + np.append(0.0, conductance)
        bands[0, 1:], bands[2, :-1] = -conductance, -conductance
        bands[1, 0], bands[0, 1] = 1.0, 0.0
        right = volumes * force
        right[0] = 0.0
        found = 0.5 * (speed + solve_banded((1, 1), bands, right))
        change, speed = np.max(np.abs(found - speed)), found
        if change < CONVERGED * np.max(np.abs(speed)):
            break
    return speed


def _integral(values: Floats, places: Floats) -> float:
    return float(np.sum(0.5 * (values[1:] + values[:-1]) * np.diff(places)))
