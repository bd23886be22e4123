"""What changes in time in the coupled equations of flow and heat, which store mass too (`solvers.coupled`).

    mass:  d(phi rho)/dt        heat:  phi rho C_f dT/dt + (1 - phi) rho_s C_s dT_s/dt

The heat is in the form of rates of the temperatures: mass that is stored takes its enthalpy with it.
"""

from collections.abc import Sequence
from typing import NamedTuple

import ufl

from ..laws.functions import Value
from .energy import EnergyEquations
from .flow import FlowEquations, FlowState


class FluidHeld(NamedTuple):
    """Forms (scalar) of the fluid in the bed at the flow's temperature: its `mass` (kg), its `heat` (J) beyond the initial
    temperature, that at the inlet's (`at_inlet`), and what `EnergyEquations.stored_heat` counts it with, phi rho h(T)."""

    mass: Value
    heat: Value
    at_inlet: Value
    counted: Value


def fluid_held(equations: EnergyEquations) -> FluidHeld:
    """Of given flow fields."""
    fluid, temperature = equations.flow.fluid.fluid, equations.flow_temperature
    enthalpy, weight, dx = fluid.heat_capacity.integral, equations.coordinates.weight, equations.dx_bed
    mass, first = weight * equations.bed.porosity * equations.transfer.density, enthalpy(equations.initial_temperature)
    return FluidHeld(
        mass * dx,
        mass * (enthalpy(temperature) - first) * dx,
        mass * (enthalpy(equations.inlet_temperature) - first) * dx,
        weight * equations.fluid_enthalpy(temperature) * dx,
    )


def mass_storage(
    equations: FlowEquations,
    state: FlowState,
    old: FlowState,
    temperatures: Sequence[Value],
    test: Value,
    inverse_step: Value,
    dx: ufl.Measure,
) -> Value:
    """Form of d(phi rho)/dt against the mass balance's test, for pressures and `temperatures` (K) now and before."""
    pressure, warm = ufl.variable(state.pressure), ufl.variable(temperatures[0])
    density = equations.fluid.density(pressure, warm)
    rate = ufl.diff(density, pressure) * (state.pressure - old.pressure)
    rate += ufl.diff(density, warm) * (temperatures[0] - temperatures[1])
    return (
        equations.coordinates.weight * equations.bed.porosity * inverse_step * rate * test / equations.scales.speed * dx
    )


def heating_rate(
    equations: EnergyEquations,
    temperature: Value,
    bead_temperature: Value,
    rates: Sequence[Value],
    test: Value,
    bead_test: Value,
) -> Value:
    """Form of what `EnergyEquations.stored_heat` gains for dT/dt and dT_s/dt (K/s), `rates`."""
    weight, beads, dx = equations.coordinates.weight, equations.bed.beads, equations.dx_bed
    form = weight * equations.fluid_storage * rates[0] * test * dx
    capacity = beads.density(bead_temperature) * beads.heat_capacity(bead_temperature)
    form += weight * (1.0 - equations.bed.porosity) * capacity * rates[1] * bead_test * dx
    return form + equations.wall.heating_rate(temperature, rates[0], test)
