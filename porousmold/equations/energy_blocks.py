r"""A matrix near that of an implicit stage of the energy equations, each temperature by itself, for algebraic multigrid.

Beads that are eliminated node by node leave for the fluid, with c = (1-phi) rho_s C_s/(gamma dt) and E = a_v h_sf,

    beads: c + E - div K_s grad,    T: phi rho C_f/(gamma dt) + E c/(E + c) + C_f q.grad - div K_f grad,

and in the wall its own equation. Products are taken at the nodes and coefficients in the cells' middles: of flat hexahedra
that makes an M-matrix, which multigrid needs (at quadrature points those have positive entries off the diagonal). The flow is
upwinded for the same reason, whatever the equations do.
"""

from collections.abc import Callable
from typing import NamedTuple

import ufl

from ..laws.functions import Value
from .energy import EnergyEquations
from .stabilisation import flux_density


class Temperatures(NamedTuple):
    """The `unknown` function with its part T (fluid and wall), and trial and test functions of T and T_s, the same twice with
    one temperature."""

    unknown: Value
    fluid: Value
    trial: Value
    trials: tuple[Value, Value]
    tests: tuple[Value, Value]


def energy_blocks(
    equations: EnergyEquations,
    temperatures: Temperatures,
    temperature: Value,
    monotone: Value,
    inverse_time: Value,
    of_cell: Callable[[Value], Value],
) -> Value:
    """Bilinear form of both blocks, and of the wall.

    `temperature` (K) is that of the properties, `monotone` marks cells (`Streamline`), `inverse_time` is 1/(gamma dt) in 1/s,
    `of_cell` gives a function with the values of an expression in the cells' middles.
    """
    (trial, bead_trial), (test, bead_test) = temperatures.trials, temperatures.tests
    bed, transport = equations.bed, equations.transport(temperature, monotone)
    capacity = equations.flow.fluid.fluid.heat_capacity(temperature)
    beads = (1.0 - bed.porosity) * bed.beads.density(temperature) * bed.beads.heat_capacity(temperature)
    stored, carried = inverse_time * of_cell(beads), of_cell(capacity * transport.mass_flux)
    conduction, along_beads = of_cell(transport.conduction), of_cell(transport.bead_conduction)
    reach = of_cell(transport.streamline.upwinded.reach)
    own = inverse_time * of_cell(equations.fluid_storage)
    form = ufl.dot(carried, ufl.grad(trial)) * (test + ufl.dot(reach, ufl.grad(test)))
    form += ufl.dot(flux_density(conduction, ufl.grad(trial)), ufl.grad(test))
    of_beads = ufl.dot(flux_density(along_beads, ufl.grad(bead_trial)), ufl.grad(bead_test))
    if equations.two_temperatures:
        exchange = of_cell(transport.exchange)
        own += exchange * stored / (exchange + stored)
        of_beads += (stored + exchange) * bead_trial * bead_test
    else:
        own += stored
    form += own * trial * test + of_beads
    if equations.moving_beads is not None:
        form += equations.moving_beads.carried_at_the_nodes(temperature, bead_trial, bead_test)
    form = equations.coordinates.nodal_weight * form * equations.nodes_bed
    if transport.touching is not None and equations.interface is not None:
        form += equations.interface.integral(of_cell(transport.touching), trial * test + bead_trial * bead_test)
    form += equations.coordinates.weight * capacity * equations.entering_mass_flux * trial * test * equations.inlet
    wall, held = equations.wall.at_nodes(), temperatures.fluid
    of_wall = inverse_time * wall.stored_heat(held, test, 1.0) + wall.outflow_of_heat(held, test, 1.0)
    return form + ufl.derivative(of_wall, temperatures.unknown, temperatures.trial) if wall.has_heat else form
