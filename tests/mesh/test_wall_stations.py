"""Stations of meshes of one's own: where they are asked for, however the mesh is cut and turned."""

import numpy as np
import pytest
from mpi4py import MPI

from porousmold import InputError
from porousmold.mesh.domain import INLET, INTERFACE, OUTER, OUTLET, SIDE, SYMMETRY
from porousmold.mesh.from_gmsh import from_file, surface_of
from porousmold.mesh.gmsh_model import PlainMesh, lone, sides_of
from porousmold.mesh.wall_stations import stations_along_curve, stations_along_surface

from ..support import MESHES

LENGTH, HEIGHT, WIDTH = 0.5, 0.03, 0.1
AWAY = 2e-6 * LENGTH
"""m, by which stations are beside the place that is asked for, where a corner might be."""


def box(turned=None, uneven=0.0):
    """Facets by tag and surface of a bed of 4 x 3 x 2 cells below its wall, with points and normals multiplied by `turned`."""
    shape = 5, 4, 3
    number = np.arange(np.prod(shape)).reshape(shape)
    places = [np.linspace(0.0, size, count) for size, count in zip((LENGTH, HEIGHT, WIDTH), shape, strict=True)]
    points = np.stack(np.meshgrid(*places, indexing="ij"), axis=-1).reshape(-1, 3)
    points[:, 1] *= 1.0 + uneven * np.sin(np.pi * points[:, 0] / LENGTH)
    corners = [(i, j, k) for k in (0, 1) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]  # as gmsh orders them
    cells = np.stack([number[i : i + 4, j : j + 3, k : k + 2].ravel() for i, j, k in corners], axis=1)
    sides = sides_of(cells, 3)
    outside = sides[lone(sides)]

    def at(axis, value):
        return outside[(np.abs(points[outside][:, :, axis] - value) < 1e-12).all(axis=1)]

    planes = {INLET: at(0, 0.0), OUTLET: at(0, LENGTH), SYMMETRY: at(1, 0.0), SIDE: at(2, 0.0)}
    top = number[:, -1].ravel()
    planes[INTERFACE] = outside[np.isin(outside, top).all(axis=1)]
    points = points if turned is None else points @ np.asarray(turned).T
    mesh = PlainMesh(points, {1: cells}, planes)
    return {tag: points[nodes] for tag, nodes in planes.items()}, surface_of(mesh)


def about_x(angle):
    return [[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]]


@pytest.mark.parametrize("turned", [None, about_x(0.5), about_x(np.pi / 2), about_x(np.pi), np.diag([1, -1, 1])])
@pytest.mark.parametrize("fraction", [0.0, 0.1, 0.25, 0.6, 1.0])
def test_a_station_is_between_nodes_where_it_is_asked_for(turned, fraction):
    """Not at the nearest node, and the centre is opposite, not where a plane of symmetry meets the wall; also of a wall below."""
    facets, surface = box(turned)
    length, stations = stations_along_surface(facets, surface)
    found = stations(fraction)
    axes = np.eye(3) if turned is None else np.asarray(turned)
    wall, centre = (np.array(found[name]) @ axes for name in ("bed_side", "centre"))
    assert length == pytest.approx(LENGTH)
    assert wall[:2] == pytest.approx([fraction * LENGTH, HEIGHT], abs=AWAY)
    assert centre == pytest.approx([wall[0], 0.0, wall[2]], abs=AWAY)


def test_the_centre_beside_a_curved_wall_is_along_its_normal():
    facets, surface = box(uneven=0.5)
    found = stations_along_surface(facets, surface)[1](0.2)
    wall, centre = np.array(found["bed_side"]), np.array(found["centre"])
    slope = 0.5 * HEIGHT * np.sin(np.pi / 4) / (LENGTH / 4)
    assert wall[1] == pytest.approx(HEIGHT * (1.0 + 0.5 * np.sin(np.pi / 4) * 0.8), abs=AWAY)
    assert centre == pytest.approx([wall[0] + slope * wall[1], 0.0, 0.0], abs=AWAY)


def test_the_centre_of_a_pipe_is_on_its_axis():
    """Of half of one, whose plane of symmetry meets the wall: it was at the wall, which is up to 32 K off in a heating."""
    domain = from_file(MPI.COMM_SELF, MESHES / "bent_pipe.geo", dimension=3)
    bend, radius = 0.12, 0.02
    for fraction in (0.1, 0.25, 0.5):
        found = domain.stations(fraction)
        x, y, z = found["centre"]
        assert np.hypot(np.hypot(x, bend - y) - bend, z) < 0.08 * radius
        x, y, z = found["bed_side"]
        assert np.hypot(np.hypot(x, bend - y) - bend, z) == pytest.approx(radius, rel=0.02)


def test_places_beside_the_wall_of_a_plane_mesh_lie_between_nodes():
    places = np.linspace(0.0, 0.4, 5)

    def line(height):
        return np.stack(
            [np.column_stack([part, np.full(2, height)]) for part in np.stack([places[:-1], places[1:]], 1)]
        )

    facets = {
        INTERFACE: line(0.03),
        OUTER: line(0.033),
        SYMMETRY: line(0.0),
        INLET: np.array([[[0.0, 0.0], [0.0, 0.03]]]),
    }
    found = stations_along_curve(facets)[1](0.125)
    assert found["bed_side"] == pytest.approx((0.05, 0.03))
    assert found["outer"] == pytest.approx((0.05, 0.033))
    assert found["centre"] == pytest.approx((0.05, 0.0))


def test_stations_count_from_the_inlet():
    """Also of a bed that runs against x, and at the side that is a plane of symmetry, be it the lower or the upper one."""
    for turned in (np.diag([-1.0, 1, 1]), np.diag([1.0, 1, -1])):
        facets, surface = box(turned)
        found = {name: np.array(place) for name, place in stations_along_surface(facets, surface)[1](0.25).items()}
        assert found["bed_side"] @ turned == pytest.approx([0.25 * LENGTH, HEIGHT, 0.0], abs=AWAY)
        assert found["centre"] @ turned == pytest.approx([0.25 * LENGTH, 0.0, 0.0], abs=AWAY)


def test_a_wall_with_a_gap_has_its_stations_beside_that():
    facets, surface = box()
    kept = np.abs(facets[INTERFACE][:, :, 0].mean(axis=1) - 0.375 * LENGTH) > 0.1 * LENGTH
    gap = facets | {INTERFACE: facets[INTERFACE][kept]}
    found = stations_along_surface(gap, surface)[1](0.4)
    assert found["bed_side"][0] in (pytest.approx(0.25 * LENGTH, abs=AWAY), pytest.approx(0.5 * LENGTH, abs=AWAY))


def test_an_interface_beside_no_bed_is_refused(tmp_path):
    mesh = (MESHES / "bent_pipe.geo").read_text()
    mesh = mesh.replace('Physical Surface("interface") = {5, 6};', 'Physical Surface("interface") = {10, 11};')
    (tmp_path / "wrong.geo").write_text(mesh.replace('Physical Surface("outer") = {10, 11};', ""))
    with pytest.raises(InputError, match="interface must lie beside the bed"):
        from_file(MPI.COMM_SELF, tmp_path / "wrong.geo", dimension=3)
