"""Terms of the non-constant averaging volume: gauge invariance of the consistent form, its loss in the published one."""

import numpy as np
import pytest
import ufl
from dolfinx import fem

from porousmold.equations.medium import rev_vector
from porousmold.laws.functions import exp
from porousmold.mesh import domain as geometry
from porousmold.mesh import fenicsx
from porousmold.solvers.flow import FullFlow

from ..support import box, flow_equations, nodal, opening


def velocities(drop, gauge, *, published):
    """Nodal velocities of a flow with REV terms between the pressures gauge + drop and gauge."""
    domain = box((6, 16))
    y = domain.wall_distance
    phi = 0.4 + 0.6 * exp(-8.0 * y)
    difference = -0.3 * y * exp(-4.0 * y)  # phi_A the larger, as in a packing
    equations = flow_equations(
        domain,
        phi,
        pressure=10.0,
        rev=rev_vector(difference, y, fem.Constant(domain.mesh, 1.2)),
        published_pressure_term=published,
    )
    openings = [
        opening(domain, geometry.INLET, 4, pressure=fem.Constant(domain.mesh, gauge + drop)),
        opening(domain, geometry.OUTLET, 4, pressure=fem.Constant(domain.mesh, gauge)),
    ]
    temperature = nodal(domain, 300.0 + ufl.SpatialCoordinate(domain.mesh)[0])
    flow = FullFlow(domain, equations, openings, temperature, domain.cell_measure(4))
    flow.guess_uniform(0.0)
    assert flow.solver.find(np.inf, 0.0)
    return flow.unknown.x.array[fenicsx.collapse(flow.space, 0)[1]]


def test_consistent_form_does_not_know_the_gauge():
    low, high = velocities(10.0, 0.0, published=False), velocities(10.0, 1e3, published=False)
    assert np.max(np.abs(low)) > 0.01
    assert high == pytest.approx(low, abs=1e-9 * np.max(np.abs(low)))


def test_consistent_form_leaves_a_fluid_at_rest_under_uniform_pressure():
    assert np.max(np.abs(velocities(0.0, 1e3, published=False))) < 1e-10


def test_published_form_pushes_a_fluid_at_rest():
    """Thesis eq. 6.4 as printed: uniform pressure drives a flow, and the gauge changes it."""
    assert np.max(np.abs(velocities(0.0, 10.0, published=True))) > 1e-3
    low, high = velocities(10.0, 0.0, published=True), velocities(10.0, 10.0, published=True)
    assert np.max(np.abs(high - low)) > 0.01 * np.max(np.abs(low))
