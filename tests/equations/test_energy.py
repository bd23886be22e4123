"""Orders and exact solutions of the two-temperature energy equations with a conjugate wall."""

from dataclasses import replace

import numpy as np
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI

from porousmold.equations.bead_interior import BeadInterior
from porousmold.equations.energy import EnergyEquations, Interface
from porousmold.equations.flow import FlowState
from porousmold.equations.stabilisation import flux_density
from porousmold.equations.wall import OuterWall, Wall, WallLayer
from porousmold.laws.bead_interior import eigenvalues
from porousmold.laws.conductivity import (
    BEAD_CONDUCTION_LAWS,
    Anisotropic,
    BeadConduction,
    Dispersion,
)
from porousmold.laws.functions import exp
from porousmold.mesh import domain as geometry
from porousmold.mesh import fenicsx
from porousmold.solvers.flow import unknowns_outside
from porousmold.solvers.heating import FrozenTransport, TransientHeat
from porousmold.solvers.newton import NewtonSystem
from porousmold.solvers.newton_iterations import Iterations
from studies.exact_solutions import schumann

from ..support import (
    GivenFlow,
    box,
    divergence_of_vector,
    error_norm,
    fill_part,
    flow_equations,
    liquid,
    observed_orders,
    solid,
)

DEGREE = 4


def energy_equations(domain, flow, state, *, wall=None, inlet_temperature=1.0, outer=None):
    """Energy equations over a domain for given flow fields."""
    dx, ds = domain.cell_measure(DEGREE), domain.facet_measure(DEGREE)
    layers = [] if wall is None else [WallLayer(wall, dx(geometry.WALL), domain.nodal_measure()(geometry.WALL))]
    return EnergyEquations(
        flow,
        state,
        fem.Constant(domain.mesh, 300.0),
        domain.entrance(),
        Wall(flow.coordinates, flow.bed.wall_distance, layers, outer),
        fem.Constant(domain.mesh, float(inlet_temperature)),
        ds(geometry.INLET),
        ds(geometry.OUTLET),
        dx(geometry.BED),
        domain.nodal_measure()(geometry.BED),
        interface=Interface(domain.interface_measure(DEGREE), domain.in_bed()),
    )


def steady(domain, equations, *, sources=(0.0, 0.0), exact=(None, None), held_boundaries=()):
    """Steady T and T_s with T and T_s held at `exact` on parts of the boundary."""
    element = fenicsx.lagrange_element(domain.mesh, 1)
    space = fenicsx.mixed_space(domain.mesh, [element, element])
    unknown = fem.Function(space)
    constrained = [unknowns_outside(domain, space, (1,), geometry.BED)]
    for part, field in enumerate(exact):
        if field is None:
            continue
        if isinstance(field, float):
            unknown.x.array[fenicsx.collapse(space, part)[1]] = field
        else:
            fill_part(unknown, part, field)
        facets, across = domain.mesh.topology.dim - 1, space.sub(part)
        constrained += [fem.locate_dofs_topological(across, facets, domain.facets(tag)) for tag in held_boundaries]
    parts, tests = ufl.split(unknown), ufl.TestFunctions(space)
    dx = domain.cell_measure(DEGREE)
    frozen = FrozenTransport(domain, equations, equations.flow_temperature, DEGREE)
    frozen.renew()
    residual = equations.outflow_of_heat(*parts, *tests, frozen.frozen)
    residual += fem.Constant(domain.mesh, 0.0) * parts[1] * tests[1] * dx(geometry.WALL)
    for source, test in zip(sources, tests, strict=True):
        residual -= equations.coordinates.weight * source * test * dx(geometry.BED)
    system = NewtonSystem("test", residual, unknown, np.unique(np.concatenate(constrained)))
    assert system.solve(Iterations(20, lambda update: update < 1e-11))
    return unknown, parts


def tensors(along, across):
    """Laws by which both phases conduct otherwise along the flow than across it: the fluid's dispersion and the beads, W/m/K."""
    return {
        "dispersion": Dispersion(lambda bed: Anisotropic(along * bed.porosity, across * bed.porosity), "test"),
        "bead_conduction": BeadConduction(
            lambda bed: Anisotropic(0.3 * along * (1.0 - bed.porosity), 2.0 * across * (1.0 - bed.porosity)), "test"
        ),
    }


def manufactured_errors(cells, axisymmetric, jump, laws=None, dimension=2):
    """L2 errors of T and T_s."""
    if dimension == 2:
        domain = box((cells, cells), axisymmetric=axisymmetric)
        (z, r), sideways = ufl.SpatialCoordinate(domain.mesh), 0.0
    else:
        sides = geometry.Across.to_wall(np.linspace(0.0, 1.0, cells + 1), [])
        nodes = np.linspace(0.0, 1.0, cells + 1)
        domain = geometry.straight_bed(MPI.COMM_SELF, nodes, [sides, sides], axisymmetric=False)
        z, r, third = ufl.SpatialCoordinate(domain.mesh)
        sideways = 0.2 * third * (1.0 - third)
    if jump:  # two layers; both fields are flat in r at the jump, so that the fluxes are continuous
        phi = ufl.conditional(ufl.lt(r, 0.5), 0.4, 0.8)
        across = ufl.cos(2.0 * np.pi * r)
    else:
        phi = 0.4 + 0.5 * exp(-3.0 * (1.0 - r))
        across = ufl.cos(np.pi * r) * (1.0 if dimension == 2 else ufl.cos(np.pi * third))
    fluid, beads = liquid(heat_capacity=1.0, conductivity=0.5), solid(conductivity=0.8)
    flow = flow_equations(domain, phi, fluid=fluid, beads=beads, equations=GivenFlow)
    velocity = ufl.as_vector([1.0 - 0.5 * r**2, 0.0 * r if laws is None else 0.4 * r, sideways][:dimension])
    state = FlowState(velocity, 0.0 * z)
    of_fluid, of_beads = 0.5 * phi, 0.8 * (1.0 - phi)
    if laws is not None:
        flow = replace(flow, bed=replace(flow.bed, **laws))
    equations = energy_equations(domain, flow, state)
    if laws is not None:
        of_fluid, of_beads = equations.transfer.fluid_conduction(300.0), equations.transfer.bead_conduction(300.0)
    fluid_temperature = 2.0 + ufl.sin(np.pi * z) * across
    bead_temperature = 2.0 + ufl.cos(np.pi * z) * across
    coordinates = equations.coordinates
    transfer = equations.transfer.exchange_coefficient(fluid_temperature) * (fluid_temperature - bead_temperature)
    sources = (
        ufl.dot(flow.mass_flux(state, 300.0), ufl.grad(fluid_temperature))
        - divergence_of_vector(flux_density(of_fluid, ufl.grad(fluid_temperature)), coordinates)
        + transfer,
        -divergence_of_vector(flux_density(of_beads, ufl.grad(bead_temperature)), coordinates) - transfer,
    )
    _, parts = steady(
        domain,
        equations,
        sources=sources,
        exact=(fluid_temperature, bead_temperature),
        held_boundaries=(geometry.INLET, geometry.OUTLET, geometry.INTERFACE),
    )
    return [
        error_norm(domain, part - field, coordinates)
        for part, field in zip(parts, (fluid_temperature, bead_temperature), strict=True)
    ]


@pytest.mark.parametrize("axisymmetric", [False, True])
@pytest.mark.parametrize("jump", [False, True], ids=["smooth", "jump"])
def test_second_order_in_space(axisymmetric, jump):
    errors = np.array([manufactured_errors(cells, axisymmetric, jump) for cells in (8, 16, 32)])
    for field in range(2):
        assert observed_orders(errors[:, field])[-1] > 1.85


@pytest.mark.parametrize("axisymmetric", [False, True])
def test_second_order_with_tensors(axisymmetric):
    """Conduction along a slanted flow five times that across it in the fluid, and less than that in the beads."""
    errors = np.array([manufactured_errors(cells, axisymmetric, False, tensors(1.5, 0.3)) for cells in (8, 16, 32)])
    for field in range(2):
        assert observed_orders(errors[:, field])[-1] > 1.85


def test_second_order_with_tensors_in_three_dimensions():
    errors = np.array([manufactured_errors(cells, False, False, tensors(1.5, 0.3), 3) for cells in (6, 12)])
    for field in range(2):
        assert observed_orders(errors[:, field])[-1] > 1.8


def test_a_tensor_of_equal_parts_is_the_number():
    """Whatever the flow's direction: the same errors as with the law that gives numbers."""

    def laws(shape):
        return {
            "dispersion": Dispersion(lambda bed: shape(0.5 * bed.porosity), "test"),
            "bead_conduction": BeadConduction(lambda bed: shape(0.8 * (1.0 - bed.porosity)), "test"),
        }

    tensor, plain = (manufactured_errors(8, False, False, laws(s)) for s in (lambda k: Anisotropic(k, k), lambda k: k))
    assert tensor == pytest.approx(plain, rel=1e-9)


def at_rest(domain):
    """State of a fluid that does not move."""
    zero = 0.0 * ufl.SpatialCoordinate(domain.mesh)[0]
    return FlowState(ufl.as_vector([zero, zero]), zero)


@pytest.mark.parametrize("axisymmetric", [False, True])
def test_composite_wall(axisymmetric):
    """Steady conduction through still fluid and wall: the interface temperature follows from the two resistances.

    Beads that hardly conduct take the fluid's temperature and carry nothing. In a pipe the heat enters at the outside
    and the whole cross-section is then at one temperature, but for the wall's logarithmic drop.
    """
    domain = box((2, 16), axisymmetric=axisymmetric, wall=0.25, wall_cells=16)
    phi = fem.Constant(domain.mesh, 0.4)
    flow = flow_equations(
        domain, phi, fluid=liquid(conductivity=0.5), beads=solid(conductivity=1e-9), equations=GivenFlow
    )
    ds = domain.facet_measure(DEGREE)
    number = [fem.Constant(domain.mesh, value) for value in (3.0, 400.0)]
    outer = OuterWall(ds(geometry.OUTER), coefficient=number[0], ambient=number[1])
    equations = energy_equations(domain, flow, at_rest(domain), wall=solid(conductivity=2.0), outer=outer)
    if axisymmetric:
        unknown, _ = steady(domain, equations, exact=(300.0, 300.0),
                            held_boundaries=(geometry.INTERFACE,))  # fmt: skip
        flux_per_length = 2 * np.pi * 100.0 / (1.0 / (3.0 * 1.25) + np.log(1.25) / 2.0)
        expected = 400.0 - flux_per_length / (2 * np.pi * 1.25 * 3.0)
        place = (0.5, 1.25)
    else:
        unknown, _ = steady(domain, equations, exact=(300.0, 300.0), held_boundaries=(geometry.SYMMETRY,))
        flux = 100.0 / (1.0 / (0.4 * 0.5) + 0.25 / 2.0 + 1.0 / 3.0)
        expected = 300.0 + flux / (0.4 * 0.5)
        place = (0.5, 1.0)
    subspace, numbers = fenicsx.collapse(unknown.function_space, 0)
    nodes = subspace.tabulate_dof_coordinates()
    node = np.argmin(np.hypot(nodes[:, 0] - place[0], nodes[:, 1] - place[1]))
    assert unknown.x.array[numbers][node] == pytest.approx(expected, abs=0.02 if axisymmetric else 1e-6)


def bed_at_rest(domain, law, wall=None, outer=None):
    """Energy equations of a fluid at rest between beads of 50 times its conductivity, at one porosity."""
    fluid, beads = liquid(conductivity=0.5, viscosity=1.0), solid(conductivity=25.0)
    flow = flow_equations(domain, fem.Constant(domain.mesh, 0.4), fluid=fluid, beads=beads, equations=GivenFlow)
    flow = replace(flow, bed=replace(flow.bed, bead_conduction=BEAD_CONDUCTION_LAWS[law]))
    return energy_equations(domain, flow, at_rest(domain), wall=wall, outer=outer)


def nodal_parts(unknown):
    """(height, T, T_s) at the nodes."""
    height = unknown.function_space.sub(0).collapse()[0].tabulate_dof_coordinates()[:, 1]
    return height, *(unknown.x.array[fenicsx.collapse(unknown.function_space, part)[1]] for part in (0, 1))


def test_the_bed_at_rest_takes_the_walls_temperature():
    """Heat crosses a bed at rest as one slab of lambda_0 where its conduction ends at the wall; as published the beads stay
    behind, as all heat has to come to them through the film."""
    domain = box((2, 16))
    lag = {}
    for law in ("zehner-bauer-schluender", "bulk"):
        equations = bed_at_rest(domain, law)
        ds = domain.facet_measure(DEGREE)
        number = [fem.Constant(domain.mesh, value) for value in (1e6, 400.0)]
        outer = OuterWall(ds(geometry.INTERFACE), coefficient=number[0], ambient=number[1])
        equations = replace(equations, wall=replace(equations.wall, outer=outer))
        unknown, _ = steady(domain, equations, exact=(300.0, 300.0), held_boundaries=(geometry.SYMMETRY,))
        height, *temperatures = nodal_parts(unknown)
        linear = 300.0 + 100.0 * height
        lag[law] = [float(np.max(np.abs(found - linear))) for found in temperatures]
    assert max(lag["zehner-bauer-schluender"]) < 0.1
    assert lag["bulk"][1] > 1.0


@pytest.mark.parametrize("axisymmetric", [False, True])
def test_a_resolved_wall_passes_its_heat_to_the_whole_bed(axisymmetric):
    """The interface's temperature follows from the resistances of wall and bed, lambda_0."""
    domain = box((2, 32), axisymmetric=axisymmetric, wall=0.25, wall_cells=8)
    ds, number = domain.facet_measure(DEGREE), [fem.Constant(domain.mesh, value) for value in (3.0, 400.0)]
    outer = OuterWall(ds(geometry.OUTER), coefficient=number[0], ambient=number[1])
    equations = bed_at_rest(domain, "zehner-bauer-schluender", wall=solid(conductivity=2.0), outer=outer)
    held = (geometry.INLET, geometry.OUTLET) if axisymmetric else (geometry.SYMMETRY,)
    unknown, _ = steady(domain, equations, exact=(300.0, 300.0), held_boundaries=held)
    height, temperature, beads = nodal_parts(unknown)
    here = np.isclose(height, 1.0)
    assert beads[here] == pytest.approx(temperature[here], abs=0.1)
    if not axisymmetric:
        fluid, bead_part = equations.transfer.fluid_conduction(300.0), equations.transfer.bead_conduction(300.0)
        total = fem.assemble_scalar(fenicsx.compiled_form((fluid + bead_part) * domain.cell_measure(2)(geometry.BED)))
        flux = 100.0 / (1.0 / total + 0.25 / 2.0 + 1.0 / 3.0)
        assert temperature[here] == pytest.approx(300.0 + flux / total, abs=0.01)


def rosen(ratio, stored, film, interior, times):
    """Fluid temperature of the front through beads with an inside (Rosen, J. Chem. Phys. 20 (1952) 387-394) at its end.

    exp(-ratio film/(1/film + surface per flux))/p by Laplace's inversion along Talbot's contour (Weideman, Trefethen 2007);
    `ratio` a_v h L/G, `stored` rho C R (J/m2/K), `film` h, `interior` lambda/R (W/m2/K), `times` (s) since the fluid's transit.
    """
    theta = np.pi * (2.0 * np.arange(32) + 1.0) / 32 - np.pi
    result = []
    for time in times:
        z = 32 * (0.5017 * theta / np.tan(0.6407 * theta) - 0.6122 + 0.2645j * theta) / time
        slope = 32 / time * (0.5017 / np.tan(0.6407 * theta)
                             - 0.5017 * 0.6407 * theta / np.sin(0.6407 * theta) ** 2 + 0.2645j)  # fmt: skip
        root = np.sqrt(z * stored / interior)
        surface = np.tanh(root) / (root - np.tanh(root)) / interior
        values = np.exp(z * time - ratio / (1.0 + film * surface)) / z
        result.append(float(np.mean(values * slope / 1j).real))
    return np.array(result)


def front_through_beads(modes=None, biot=None, *, cells=80, bead_diameter=0.02, step=0.4, end=60.0):
    """A front of 1 K through beads that only exchange heat with the fluid, with `modes` inside them at Bi = h R/lambda.

    Gives times since the fluid's transit and the outlet's warming, a_v h (W/m3/K) of film alone, the fluid's G (W/m2/K), and
    `TransientHeat`.
    """
    length, phi, speed, density = 1.0, 0.4, 2.5, 50.0
    beads = solid(density=density, conductivity=1e-9)
    domain = box((cells, 1), length=length)
    fluid = liquid(conductivity=1e-3, viscosity=1e-3)
    flow = flow_equations(
        domain,
        fem.Constant(domain.mesh, phi),
        fluid=fluid,
        beads=beads,
        bead_diameter=bead_diameter,
        equations=GivenFlow,
    )
    zero = 0.0 * domain.wall_distance
    state = FlowState(ufl.as_vector([speed + zero, zero]), zero)
    equations = energy_equations(domain, flow, state, inlet_temperature=301.0)
    exchange = fem.assemble_scalar(
        fenicsx.compiled_form(equations.transfer.exchange_coefficient(300.0) * domain.cell_measure(2)(geometry.BED))
    )
    if modes is not None:
        film = exchange * bead_diameter / (6.0 * (1.0 - phi))
        inside = solid(density=density, conductivity=film * bead_diameter / (2.0 * biot))
        lag = fem.Function(fenicsx.lagrange_space(domain.mesh))
        interior = BeadInterior(tuple(eigenvalues(modes)), inside, bead_diameter, lag, fem.Constant(domain.mesh, 1.0))
        equations = replace(equations, interior=interior)
    heat = TransientHeat(
        domain,
        equations,
        300.0,
        lambda time: None,
        equations.flow_temperature,
        DEGREE,
    )
    times, outlet, time = [], [], 0.0
    subspace, numbers = fenicsx.collapse(heat.space, 0)
    last = numbers[np.argmax(subspace.tabulate_dof_coordinates()[:, 0])]
    while time < end:
        heat.step(time, step)
        time += step
        times.append(time - length / speed)
        outlet.append(heat.unknown.x.array[last] - 300.0)
    return np.array(times), np.array(outlet), exchange, phi * speed, heat


def test_schumann_front():
    """A front through isothermal beads, against the exact solution at the outlet."""
    times, outlet, exchange, flux, heat = front_through_beads()
    exact = [schumann(exchange / flux, exchange * t / (0.6 * 50.0)) if t > 0.0 else 0.0 for t in times]
    assert max(exact) > 0.99
    assert np.max(np.abs(outlet - exact)) < 0.01
    assert abs(heat.balance.imbalance) < 1e-8


def test_rosen_front():
    """The same through large beads that conduct badly, Bi = 40: eight modes meet the exact solution, the resistance alone
    (no mode) is far from it."""
    errors = {}
    for modes in (0, 8):
        times, outlet, exchange, flux, heat = front_through_beads(
            modes, 40.0, cells=40, bead_diameter=0.06, step=0.1, end=20.0
        )
        after = times > 2.0
        film = exchange * 0.06 / (6.0 * 0.6)
        exact = rosen(exchange / flux, 50.0 * 0.03, film, film / 40.0, times[after])
        errors[modes] = np.max(np.abs(outlet[after] - exact))
        assert abs(heat.balance.imbalance) < 1e-8
    assert np.ptp(exact) > 0.3
    assert errors[8] < 0.004
    assert errors[0] > 0.1
