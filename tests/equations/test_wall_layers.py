"""Walls in layers: steady and transient conduction with a contact resistance, along and through a layer, and cure."""

from dataclasses import replace

import numpy as np
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

from porousmold.equations.energy import EnergyEquations, Interface
from porousmold.equations.flow import FlowState
from porousmold.equations.wall import OuterWall, Wall, WallLayer
from porousmold.laws.cure import Cure
from porousmold.mesh import domain as geometry
from porousmold.mesh import fenicsx
from porousmold.scene.features.wall import contact
from porousmold.solvers.heating import ErrorControl, TransientHeat

from ..support import GivenFlow, flow_equations, liquid, solid

DEGREE = 2
RESIN = Cure(40.0, 2.5e4, 4e5, 6e4, 0.8, 1.6, 200.0, 0.0)


def wall_alone(layers, *, coefficient=None, ambient=400.0, axisymmetric=False, length=1.0, along=1):
    """Heat of a wall of (solid, thickness, cells, source) outside a bed that neither conducts nor stores; (heat, depths)."""
    across = geometry.Across.to_wall(
        np.array([0.0, 1.0]), [np.linspace(0.0, thickness, cells + 1) for _, thickness, cells, _ in layers]
    )
    nodes = np.linspace(0.0, length, along + 1)
    domain = geometry.straight_bed(MPI.COMM_SELF, nodes, [across], axisymmetric=axisymmetric)
    fluid, beads = liquid(heat_capacity=1e-9, conductivity=1e-12), solid(density=1e-9, conductivity=1e-12)
    flow = flow_equations(domain, fem.Constant(domain.mesh, 0.4), fluid=fluid, beads=beads, equations=GivenFlow)
    zero = 0.0 * ufl.SpatialCoordinate(domain.mesh)[0]
    dx, ds, at_nodes = domain.cell_measure(DEGREE), domain.facet_measure(DEGREE), domain.nodal_measure()
    space = fenicsx.lagrange_space(domain.mesh)
    outer = None
    if coefficient is not None:
        film = fem.Constant(domain.mesh, float(coefficient))
        outer = OuterWall(ds(geometry.OUTER), coefficient=film, ambient=fem.Constant(domain.mesh, float(ambient)))
    equations = EnergyEquations(
        flow,
        FlowState(ufl.as_vector([zero, zero]), zero),
        fem.Constant(domain.mesh, 300.0),
        domain.entrance(),
        Wall(
            flow.coordinates,
            flow.bed.wall_distance,
            [
                WallLayer(
                    material,
                    dx(tag),
                    at_nodes(tag),
                    None if source is None else fem.Constant(domain.mesh, source),
                    None if material.cure is None else fem.Function(space),
                )
                for tag, (material, _, _, source) in zip(domain.wall_tags, layers, strict=True)
            ],
            outer,
        ),
        fem.Constant(domain.mesh, 300.0),
        ds(geometry.INLET),
        ds(geometry.OUTLET),
        dx(geometry.BED),
        at_nodes(geometry.BED),
        interface=Interface(domain.interface_measure(DEGREE), domain.in_bed()),
    )
    return TransientHeat(
        domain, equations, 300.0, lambda time: None, equations.flow_temperature, DEGREE, ErrorControl(1e-9)
    ), across


def through_wall(heat, across):
    """Temperatures at the nodes from the bed side outwards, at the inlet's end."""
    space, numbers = fenicsx.collapse(heat.space, 0)
    nodes = space.tabulate_dof_coordinates()
    values = heat.unknown.x.array[numbers]
    places = [np.argmin(np.hypot(nodes[:, 0], nodes[:, 1] - y)) for y in across.nodes[across.bed_cells :]]
    return values[places]


def integrate(heat, end, steps):
    for number in range(steps):
        heat.step(number * end / steps, end / steps)


@pytest.mark.parametrize("axisymmetric", [False, True])
def test_steady_wall_of_layers_with_a_contact_resistance(axisymmetric):
    """A source inside, two layers and their contact: every temperature follows from the resistances in series."""
    inner, outside, resistance, film, source = solid(conductivity=2.0), solid(conductivity=0.5), 0.3, 4.0, 50.0
    gap = contact("gap", resistance)
    layers = [(inner, 0.2, 40, source), (gap.solid, gap.thickness, 1, None), (outside, 0.3, 60, None)]
    heat, across = wall_alone(layers, coefficient=film, axisymmetric=axisymmetric)
    integrate(heat, 1e6, 10)
    temperatures = through_wall(heat, across)
    if axisymmetric:
        flow = source * 0.5 * (1.2**2 - 1.0)  # W per radian and metre
        outer = 400.0 + flow / (film * 1.5)
        beyond = outer + flow * np.log(1.5 / 1.2) / 0.5
        before = beyond + flow * resistance / 1.2
        inside = before + source / (4.0 * 2.0) * (1.2**2 - 1.0) - source / (2.0 * 2.0) * np.log(1.2)
    else:
        flow = source * 0.2
        outer = 400.0 + flow / film
        beyond = outer + flow * 0.3 / 0.5
        before = beyond + flow * resistance
        inside = before + source * 0.2**2 / (2.0 * 2.0)
    found = temperatures[[0, 40, 41, -1]]
    assert found == pytest.approx([inside, before, beyond, outer], abs=2e-4 if axisymmetric else 1e-5)
    assert abs(heat.balance.imbalance) < 1e-8


def slab(layers, film, ambient, times, cells=400):
    """Temperatures on both sides of (conductivity, storage, thickness, resistance behind) layers by finite volumes and their
    eigenvectors: insulated inside, a film outside, from 300 K."""
    sizes = np.concatenate([np.full(cells, t / cells) for _, _, t, _ in layers])
    conductivity = np.concatenate([np.full(cells, k) for k, _, _, _ in layers])
    store = np.concatenate([np.full(cells, s * t / cells) for _, s, t, _ in layers])
    half = 0.5 * sizes / conductivity
    behind = np.zeros(len(sizes) - 1)
    for number, layer in enumerate(layers[:-1], start=1):
        behind[number * cells - 1] = layer[3]
    links = 1.0 / (half[:-1] + behind + half[1:])
    loss = 1.0 / (half[-1] + 1.0 / film)
    matrix = np.diag(np.concatenate([links, [loss]]) + np.concatenate([[0.0], links]))
    matrix -= np.diag(links, 1) + np.diag(links, -1)
    scale = 1.0 / np.sqrt(store)
    rates, vectors = eigh(scale[:, None] * matrix * scale)
    start = vectors.T @ ((300.0 - ambient) / scale)
    excess = (scale[:, None] * vectors) @ (start[:, None] * np.exp(-np.outer(rates, times)))
    outside = ambient + excess[-1] * (1.0 / film) / (half[-1] + 1.0 / film)
    return ambient + excess[0], outside


def test_transient_wall_of_layers_against_finite_volumes():
    """Heating from outside through a poor layer and a contact resistance into a good one."""
    inner, outside = solid(density=3.0, conductivity=5.0), solid(density=1.0, conductivity=0.2)
    gap = contact("gap", 0.4)
    layers = [(inner, 0.2, 16, None), (gap.solid, gap.thickness, 1, None), (outside, 0.1, 16, None)]
    heat, across = wall_alone(layers, coefficient=2.0)
    integrate(heat, 0.6, 60)
    store = [float(layer.density(300.0) * layer.heat_capacity(300.0)) for layer in (inner, outside)]
    exact = slab([(5.0, store[0], 0.2, 0.4), (0.2, store[1], 0.1, 0.0)], 2.0, 400.0, np.array([0.6]))
    found = through_wall(heat, across)
    assert found[[0, -1]] == pytest.approx([exact[0][0], exact[1][0]], abs=0.05)
    assert 305.0 < found[0] < 390.0
    assert abs(heat.balance.imbalance) < 1e-8


def test_a_layer_conducts_along_itself_otherwise_than_through_it():
    """Heated at its outside to a profile along it, a sheet of high conductivity in its plane evens it out: Fourier's solution."""
    through, along, thickness = 0.5, 50.0, 0.1
    sheet = replace(solid(conductivity=through), conductivity_in_plane=along)
    length, film = 2.0, 3.0
    heat, across = wall_alone([(sheet, thickness, 20, None)], coefficient=film, length=length, along=40)
    ambient = heat.equations.wall.outer.ambient
    place = ufl.SpatialCoordinate(heat.domain.mesh)[0]
    wave = np.pi / length
    outer = replace(heat.equations.wall.outer, ambient=ambient + 100.0 * ufl.cos(wave * place))
    equations = replace(heat.equations, wall=replace(heat.equations.wall, outer=outer))
    heat = TransientHeat(heat.domain, equations, 400.0, lambda time: None, equations.flow_temperature, DEGREE)
    integrate(heat, 1e5, 10)
    decay = wave * np.sqrt(along / through)
    amplitude = 100.0 / (np.cosh(decay * thickness) + through * decay / film * np.sinh(decay * thickness))
    assert through_wall(heat, across)[0] - 400.0 == pytest.approx(amplitude, rel=2e-3)


def cured_alone(steps, end=40.0):
    """Degree of cure, temperature and heat of a slab of resin that no heat leaves."""
    resin = replace(solid(density=2.0), cure=RESIN)
    heat, across = wall_alone([(resin, 0.1, 2, None)])
    heat.unknown.x.array[:] = 350.0
    integrate(heat, end, steps)
    return heat.curing[0].extremes()[0], through_wall(heat, across)[1], heat


def test_adiabatic_cure_of_third_order():
    """What reacts heats: T = T_0 + H (alpha - alpha_0)/C, and alpha as the kinetics alone give it."""
    capacity = float(solid(density=2.0).heat_capacity(300.0))

    def rate(time, degree):
        return RESIN.rate(degree, 350.0 + RESIN.heat * degree / capacity)

    exact = solve_ivp(rate, (0.0, 40.0), [0.0], rtol=1e-11, atol=1e-12, method="LSODA").y[0, -1]
    assert 0.3 < exact < 0.95
    errors = []
    for steps in (20, 40, 80):
        degree, temperature, heat = cured_alone(steps)
        assert temperature == pytest.approx(350.0 + RESIN.heat * degree / capacity, abs=1e-5)
        assert abs(heat.balance.stored) < 1e-6 * RESIN.heat
        errors.append(abs(degree - exact))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 1e-4 and orders[-1] > 2.5, (errors, orders)


def test_cure_in_a_step_of_any_length_stays_between_its_start_and_1():
    known, temperature = np.linspace(0.0, 0.99, 12), np.full(12, 450.0)
    for theta in (1e-3, 1.0, 1e3, 1e9):
        degree = RESIN.after(known, theta, temperature)
        assert np.all((known <= degree) & (degree <= 1.0))
        missed = degree - known - theta * RESIN.rate(degree, temperature)
        scale = 1.0 + theta * np.max(RESIN.rate(known, temperature))
        assert np.max(np.abs(missed)) < 1e-6 * scale
