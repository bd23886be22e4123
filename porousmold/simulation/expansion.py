"""Whether the mass counts that the fluid in the bed displaces as its density changes with the temperature.

Where the same mass flow passes all of the bed, the fluid in it stores phi int rho C_f dT; where the mass is conserved
phi rho (h - h_0), rho the density of what came. The difference, over the heat that fluid and beads store, is by how much fronts
pass places in the bed late. A gas at the pressure of the atmosphere stores next to nothing.
"""

import numpy as np

from .estimates import Estimates
from .specs import Specs

LEAST = 1e-3
"""Of the heat stored, from which it is counted: a time at which all is heated changes by a fifth of that."""


def heat_of_expansion(specs: Specs) -> float:
    """Heat that the bed would store too much between the lowest and highest temperature given, were it left out, over all that
    fluid and beads store; where the flow is frozen, so is the density."""
    fluid, beads, pressure = specs.laws.fluid, specs.laws.beads, specs.flow.outlet_pressure
    low, high = specs.heat.given_bounds
    between, phi = np.linspace(low, high, 41), specs.porosity.bulk_porosity
    density, capacity = fluid.density(pressure, between), fluid.heat_capacity(between)
    counted, stays = phi * np.mean(density * capacity), phi * np.mean(capacity) * fluid.density(pressure, high)
    if specs.flow.model.update == "frozen":
        first = specs.heat.initial_temperature
        counted = phi * fluid.density(pressure, first) * np.mean(capacity)
    of_beads = (1.0 - phi) * np.mean(beads.density(between) * beads.heat_capacity(between))
    return float((counted - stays) / (stays + of_beads))


def counts_expansion(specs: Specs, estimates: Estimates) -> bool:
    """Whether the flow counts it: one that follows the temperatures quasi-steadily, where it is more than `LEAST`, or where a
    liquid's temperatures are not known beforehand; not beside an air loop, whose balance is that of a gas."""
    if not estimates.flows or specs.flow.model.update != "quasi-steady" or specs.heat.air_loop is not None:
        return False
    density, pressure = specs.laws.fluid.density, specs.flow.outlet_pressure
    if not density.compressible and any(specs.heat.is_open):
        high = specs.heat.given_bounds[1]
        return bool(density(pressure, high) != density(pressure, high + 1.0))
    return abs(heat_of_expansion(specs)) > LEAST
