"""Orders and exact solutions of the volume-averaged Navier-Stokes equations."""

import numpy as np
import pytest
import ufl
from dolfinx import fem
from scipy.integrate import solve_bvp

from porousmold.equations.coordinates import Coordinates
from porousmold.equations.flow import FlowState
from porousmold.laws.functions import exp
from porousmold.mesh import domain as geometry
from porousmold.mesh import fenicsx
from porousmold.solvers.flow import FullFlow, Manufactured

from ..support import (
    box,
    divergence_of_tensor,
    divergence_of_vector,
    error_norm,
    fill_part,
    flow_equations,
    nodal,
    observed_orders,
    opening,
)

DEGREE = 4


def held_velocity(domain, space, tags):
    """Unknowns of the velocity on the boundary's parts, and one of the pressure, which is else known but for a constant."""
    constrained = [fem.locate_dofs_topological(space.sub(0), 1, domain.facets(tag)) for tag in tags]
    return [*constrained, fenicsx.collapse(space, 1)[1][:1]] if constrained else constrained


def solve(domain, equations, openings, *, sources=None, exact=None, fixed_tags=()):
    """Steady flow with the velocity held at that of `exact` (`FlowState`) on parts of the boundary; gives its `FlowState`."""
    temperature = nodal(domain, 300.0 + ufl.SpatialCoordinate(domain.mesh)[0] * 0.0 + 1e-30 * domain.wall_distance)
    elements = [fenicsx.lagrange_element(domain.mesh, 1, 2), fenicsx.lagrange_element(domain.mesh, 1)]
    fixed = held_velocity(domain, fenicsx.mixed_space(domain.mesh, elements), fixed_tags)
    flow = FullFlow(domain, equations, openings, temperature, domain.cell_measure(DEGREE), Manufactured(sources, fixed))
    flow.guess_uniform(0.0)
    if exact is not None:
        for part, field in enumerate((exact.velocity, exact.pressure)):
            fill_part(flow.unknown, part, field)
    assert flow.solver.find(np.inf, 0.0)
    return flow.state, temperature


def manufactured_errors(cells, axisymmetric):
    """L2 errors of velocity and pressure for a smooth solution with smoothly varying porosity."""
    domain = box((cells, cells), axisymmetric=axisymmetric)
    z, r = ufl.SpatialCoordinate(domain.mesh)
    phi = 0.4 + 0.5 * exp(-3.0 * domain.wall_distance)
    equations = flow_equations(domain, phi)
    u = ufl.as_vector([(1.0 - r**2) * (1.0 + 0.3 * ufl.sin(np.pi * z)), 0.2 * r * (1.0 - r) * ufl.cos(np.pi * z)])
    p = ufl.cos(np.pi * z) * (1.0 + r**2)
    exact = FlowState(u, p)
    coordinates = equations.coordinates
    temperature = 300.0 + 0.0 * z
    m = equations.momentum(exact, temperature)
    sources = (
        m.force - divergence_of_tensor(phi * m.stress, coordinates),
        divergence_of_vector(phi * m.density * u, coordinates),
    )
    openings = [
        opening(domain, geometry.INLET, DEGREE, pressure=p),
        opening(domain, geometry.OUTLET, DEGREE, pressure=p),
    ]
    state, _ = solve(
        domain, equations, openings, sources=sources, exact=exact, fixed_tags=(geometry.INLET, geometry.OUTLET)
    )
    return (
        error_norm(domain, state.velocity - u, coordinates),
        error_norm(domain, state.pressure - p, coordinates),
    )


@pytest.mark.parametrize("axisymmetric", [False, True])
def test_second_order_with_smooth_porosity(axisymmetric):
    """Theory for equal-order linear elements with SUPG/PSPG: 2 for the velocity, at least 1 for the pressure (1.5 seen)."""
    errors = np.array([manufactured_errors(cells, axisymmetric) for cells in (8, 16, 32)])
    velocity, pressure = observed_orders(errors[:, 0]), observed_orders(errors[:, 1])
    assert velocity[-1] > 1.85
    assert pressure[-1] > 1.3


def test_second_order_with_a_porosity_jump():
    """Parallel flow through two layers: u and phi mu du/dy are continuous, du/dy jumps with phi."""

    def error(cells):
        domain = box((2, cells))
        y = ufl.SpatialCoordinate(domain.mesh)[1]
        inner, outer = 0.4, 0.8
        phi = ufl.conditional(ufl.lt(y, 0.5), inner, outer)
        curve = ufl.cos(0.5 * np.pi * y)  # phi u' = d(curve)/dy in both layers
        at_half = float(np.cos(0.25 * np.pi))
        along = ufl.conditional(ufl.lt(y, 0.5), curve / inner + at_half * (1 / outer - 1 / inner), curve / outer)
        u = ufl.as_vector([along, 0.0 * y])
        equations = flow_equations(domain, phi)
        p = -ufl.SpatialCoordinate(domain.mesh)[0]
        exact = FlowState(u, p)
        m = equations.momentum(exact, 300.0 + 0.0 * y)
        viscous = 0.1 * (0.5 * np.pi) ** 2 * curve
        sources = (m.force + ufl.as_vector([viscous, 0.0 * y]), 0.0 * y)
        openings = [
            opening(domain, geometry.INLET, DEGREE, pressure=p),
            opening(domain, geometry.OUTLET, DEGREE, pressure=p),
        ]
        state, _ = solve(
            domain, equations, openings, sources=sources, exact=exact, fixed_tags=(geometry.INLET, geometry.OUTLET)
        )
        return error_norm(domain, state.velocity - u, Coordinates(domain.mesh, False))

    assert observed_orders([error(cells) for cells in (16, 32, 64)])[-1] > 1.85


@pytest.mark.parametrize("axisymmetric", [False, True])
def test_poiseuille(axisymmetric):
    """No beads: u = G (1 - y^2)/(2 mu), a quarter of G in a pipe; second order, so 1/16 of 2 % on 32 cells."""

    def error(cells):
        domain = box((2, cells), axisymmetric=axisymmetric, length=2.0)
        equations = flow_equations(domain, fem.Constant(domain.mesh, 1.0))
        gradient = 0.3
        number = [fem.Constant(domain.mesh, value) for value in (gradient * 2.0, 0.0)]
        openings = [
            opening(domain, geometry.INLET, DEGREE, pressure=number[0]),
            opening(domain, geometry.OUTLET, DEGREE, pressure=number[1]),
        ]
        state, _ = solve(domain, equations, openings)
        y = ufl.SpatialCoordinate(domain.mesh)[1]
        exact = gradient / ((4.0 if axisymmetric else 2.0) * 0.1) * (1.0 - y**2)
        return error_norm(domain, state.velocity[0] - exact, equations.coordinates) / error_norm(
            domain, exact, equations.coordinates
        )

    errors = [error(cells) for cells in (8, 16, 32)]
    assert errors[-1] < 2e-3
    assert observed_orders(errors)[-1] > 1.9


def test_brinkman_forchheimer_channel():
    """Developed flow through a bed of constant porosity against SciPy's boundary-value solver."""
    domain = box((2, 256), length=1.0)
    phi, gradient = 0.4, 50.0
    equations = flow_equations(domain, fem.Constant(domain.mesh, phi), bead_diameter=0.5, pressure=gradient)
    openings = [
        opening(domain, geometry.INLET, DEGREE, pressure=fem.Constant(domain.mesh, gradient)),
        opening(domain, geometry.OUTLET, DEGREE, pressure=fem.Constant(domain.mesh, 0.0)),
    ]
    state, _ = solve(domain, equations, openings)
    law = equations.bed.drag

    def slope(y, v):
        return np.vstack(
            [v[1], (law.coefficient(phi, 0.5, 1.0, 0.1, np.abs(v[0])) * v[0] - phi * gradient) / (phi * 0.1)]
        )

    grid = np.linspace(0.0, 1.0, 200)
    reference = solve_bvp(
        slope, lambda a, b: np.array([a[1], b[0]]), grid, np.ones((2, 200)), tol=1e-6, max_nodes=20000
    )
    assert reference.success
    velocity = fem.Function(fenicsx.lagrange_space(domain.mesh))
    velocity.interpolate(fenicsx.compiled_expression(state.velocity[0], velocity.function_space))
    y = velocity.function_space.tabulate_dof_coordinates()[:, 1]
    exact = reference.sol(y)[0]
    assert np.max(np.abs(velocity.x.array - exact)) < 2e-3 * exact.max()


def test_given_mass_flux_is_met_exactly():
    """The mass flux enters weakly, so that inflow and outflow equal it to the solver's tolerance."""
    from ..support import integral

    domain = box((6, 8))
    equations = flow_equations(domain, fem.Constant(domain.mesh, 0.4), pressure=100.0)
    openings = [
        opening(domain, geometry.INLET, DEGREE, mass_flux=fem.Constant(domain.mesh, 0.7)),
        opening(domain, geometry.OUTLET, DEGREE, pressure=fem.Constant(domain.mesh, 0.0)),
    ]
    state, temperature = solve(domain, equations, openings)
    normal = ufl.FacetNormal(domain.mesh)
    out = integral(
        ufl.dot(equations.mass_flux_through_boundary(state, temperature), normal)
        * domain.facet_measure(DEGREE)(geometry.OUTLET)
    )
    assert out == pytest.approx(0.7, rel=1e-8)
