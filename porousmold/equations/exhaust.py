"""What leaves through the outlet, which a circuit may return (`simulation.air_loop`)."""

from ..laws.functions import Value
from .energy import EnergyEquations


def enthalpy_leaving(equations: EnergyEquations, temperature: Value) -> Value:
    """Form (scalar, W) of the enthalpy that leaves through the outlet."""
    enthalpy = equations.flow.fluid.fluid.heat_capacity.integral
    return equations.coordinates.weight * equations.outward_mass_flux * enthalpy(temperature) * equations.outlet


def mass_leaving(equations: EnergyEquations) -> Value:
    """Form (scalar, kg/s) of the mass that leaves through the outlet."""
    return equations.coordinates.weight * equations.outward_mass_flux * equations.outlet
