"""Meshes: grading, tags, wall distance."""

import itertools

import numpy as np
import pytest
import ufl
from dolfinx import fem
from hypothesis import given
from hypothesis import strategies as st
from mpi4py import MPI

from porousmold.equations.coordinates import Coordinates
from porousmold.mesh import domain as geometry
from porousmold.mesh import fenicsx
from porousmold.mesh.domain import graded_coordinates

from ..support import box, integral


@given(width=st.floats(1e-3, 0.2), fraction=st.floats(1e-4, 0.4), growth=st.floats(1.02, 2.0))
def test_graded_coordinates(width, fraction, growth):
    nodes = graded_coordinates(width, fraction * width, growth)
    sizes = np.diff(nodes)
    assert nodes[0] == 0.0 and nodes[-1] == pytest.approx(width)
    assert np.all(sizes > 0.0)
    ratios = sizes[1:] / sizes[:-1]
    assert np.all(ratios <= growth * (1 + 1e-5)) and np.all(ratios >= 1 - 1e-9)
    assert sizes[0] <= fraction * width * (1 + 1e-6)


def test_coordinates_are_finer_within_the_layer_and_no_cell_too_wide():
    nodes = graded_coordinates(0.025, 3e-5, 1.4, layer=0.005, widest=0.004)
    sizes, depths = np.diff(nodes), nodes[1:-1]
    ratios = sizes[1:] / sizes[:-1]
    assert sizes[0] == pytest.approx(3e-5, rel=1e-6)
    assert np.all(ratios[depths < 0.0049] <= 1.4**0.5 * (1 + 1e-6)) and np.any(ratios[depths > 0.0051] > 1.4**0.5)
    assert np.max(sizes) <= 0.004 * (1 + 1e-6)


@pytest.mark.parametrize("axisymmetric", [False, True])
def test_volumes_and_areas(axisymmetric):
    domain = box((4, 3), axisymmetric=axisymmetric, length=2.0, width=0.5, wall=0.1)
    weight = Coordinates(domain.mesh, axisymmetric).weight
    dx, ds = domain.cell_measure(4), domain.facet_measure(4)
    circle = np.pi if axisymmetric else 1.0
    one = fem.Constant(domain.mesh, 1.0)
    bed = 2.0 * (circle * 0.25 if axisymmetric else 0.5)
    wall = 2.0 * (circle * (0.36 - 0.25) if axisymmetric else 0.1)
    assert integral(weight * one * dx(geometry.BED)) == pytest.approx(bed)
    assert integral(weight * one * dx(geometry.WALL)) == pytest.approx(wall)
    assert integral(weight * one * ds(geometry.INLET)) == pytest.approx(bed / 2.0)
    assert integral(weight * one * ds(geometry.OUTLET)) == pytest.approx(bed / 2.0)
    assert integral(weight * one * ds(geometry.OUTER)) == pytest.approx(
        2.0 * (2 * np.pi * 0.6 if axisymmetric else 1.0)
    )


@pytest.mark.parametrize("walled", [True, False])
def test_volumes_and_areas_in_three_dimensions(walled):
    across = [
        geometry.Across.to_wall(np.array([0.0, 0.2, 0.5]), [np.array([0.0, 0.1])]),
        geometry.Across.to_wall(np.array([0.0, 0.3, 1.0]), [np.array([0.0, 0.1])])
        if walled
        else geometry.Across(np.array([0.0, 0.4, 1.0]), 2, walled=False),
    ]
    domain = geometry.straight_bed(MPI.COMM_SELF, np.array([0.0, 0.5, 2.0]), across)
    dx, ds = domain.cell_measure(2), domain.facet_measure(2)
    inner = ufl.Measure("dS", domain=domain.mesh, subdomain_data=domain.facet_tags)
    one = fem.Constant(domain.mesh, 1.0)
    beside = 1.1 if walled else 1.0
    assert integral(one * dx(geometry.BED)) == pytest.approx(2.0 * 0.5 * 1.0)
    assert integral(one * dx(geometry.WALL)) == pytest.approx(2.0 * (0.6 * beside - 0.5))
    assert integral(one * ds(geometry.INLET)) == pytest.approx(0.5)
    assert integral(one * ds(geometry.OUTLET)) == pytest.approx(0.5)
    assert integral(one * ds(geometry.OUTER)) == pytest.approx(2.0 * (beside + (0.6 if walled else 0.0)))
    assert integral(one * inner(geometry.INTERFACE)) == pytest.approx(2.0 * (1.0 + (0.5 if walled else 0.0)))
    assert integral(one * ds(geometry.SIDE)) == pytest.approx(2.0 * 0.6 * (1 if walled else 2))
    middle = fem.assemble_scalar(fenicsx.compiled_form(domain.wall_distance * ds(geometry.SIDE)))
    assert middle == pytest.approx(2.0 * (0.5 * 0.25 - 0.1 * 0.05) * (1 if walled else 2))


@pytest.mark.parametrize("axisymmetric", [False, True])
def test_layers_of_a_wall_have_tags_of_their_own(axisymmetric):
    depths = [np.array([0.0, 0.02, 0.05]), np.array([0.0, 0.1])]
    across = geometry.Across.to_wall(np.array([0.0, 0.2, 0.5]), depths)
    domain = geometry.straight_bed(MPI.COMM_SELF, np.array([0.0, 1.0, 2.0]), [across], axisymmetric=axisymmetric)
    weight, dx = Coordinates(domain.mesh, axisymmetric).weight, domain.cell_measure(4)
    one = fem.Constant(domain.mesh, 1.0)
    ends = [0.5, 0.55, 0.65]
    areas = [np.pi * (b * b - a * a) if axisymmetric else b - a for a, b in itertools.pairwise(ends)]
    found = [integral(weight * one * dx(tag)) for tag in domain.wall_tags]
    assert found == pytest.approx([2.0 * area for area in areas])
    assert integral(weight * one * domain.wall_measure(4)) == pytest.approx(2.0 * sum(areas))


def test_layers_go_around_a_bed_in_three_dimensions():
    depths = [np.array([0.0, 0.05]), np.array([0.0, 0.05, 0.1])]
    across = [geometry.Across.to_wall(np.array([0.0, 0.2, width]), depths) for width in (0.5, 1.0)]
    domain = geometry.straight_bed(MPI.COMM_SELF, np.array([0.0, 2.0]), across)
    one, dx = fem.Constant(domain.mesh, 1.0), domain.cell_measure(2)
    found = [integral(one * dx(tag)) for tag in domain.wall_tags]
    assert found == pytest.approx([2.0 * (0.55 * 1.05 - 0.5), 2.0 * (0.65 * 1.15 - 0.55 * 1.05)])
