"""Meshes of one's own: groups, the distance to the wall, cells put at the wall."""

import functools
import re

import numpy as np
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI

from porousmold.errors import InputError
from porousmold.mesh import domain as geometry
from porousmold.mesh.distances import distance_to_facets
from porousmold.mesh.domain import BED, INLET, INTERFACE, OUTLET, WALL, graded_coordinates
from porousmold.mesh.from_gmsh import Finer, from_file, require_connection, require_place
from porousmold.mesh.gmsh_model import Conventions, PlainMesh
from porousmold.simulation.checking import first_cell

from ..support import FIELD_CASES, MESHES, integral


def test_distance_to_segments():
    segments = np.array([[[0.0, 1.0], [1.0, 1.0]], [[1.0, 1.0], [2.0, 2.0]]])
    points = np.array([[0.5, 0.0], [-1.0, 1.0], [2.0, 1.0]])
    assert distance_to_facets(points, segments) == pytest.approx([1.0, 1.0, np.sqrt(0.5)])


@pytest.mark.parametrize("corners", [3, 4])
def test_distance_to_facets_in_space_is_the_least_over_their_points(corners):
    """Against the nearest of many points on a wavy surface of facets as different in size as 1 to 30."""
    lines = np.array([0.0, 0.03, 0.1, 0.3, 1.0])
    x, z = np.meshgrid(lines, lines, indexing="ij")
    nodes = np.stack([x, 0.2 * np.sin(3.0 * x) + 0.1 * z, z], axis=-1)
    quadrilaterals = np.stack([nodes[:-1, :-1], nodes[1:, :-1], nodes[1:, 1:], nodes[:-1, 1:]], axis=2).reshape(
        -1, 4, 3
    )
    triangles = np.concatenate([quadrilaterals[:, [0, 1, 2]], quadrilaterals[:, [0, 2, 3]]])
    rng = np.random.default_rng(1)
    points = rng.uniform(-0.5, 1.5, (300, 3))
    weights = rng.dirichlet([0.7] * 3, 4000)
    sampled = (weights @ triangles[:, None]).reshape(-1, 3)
    nearest = np.array([np.min(np.linalg.norm(sampled - point, axis=1)) for point in points])
    found = distance_to_facets(points, quadrilaterals if corners == 4 else triangles)
    assert np.all(found <= nearest + 1e-12) and np.max(nearest - found) < 0.02
    assert distance_to_facets(sampled[:500], triangles) == pytest.approx(0.0, abs=1e-12)


def test_gmsh_mold_has_the_exact_wall_distance():
    domain = from_file(MPI.COMM_SELF, MESHES / "mold.geo")
    function = domain.wall_distance
    y = function.function_space.tabulate_dof_coordinates()[:, 1]
    assert function.x.array == pytest.approx(np.abs(0.025 - y), abs=1e-12)
    assert domain.length == pytest.approx(1.0)
    assert domain.has_wall


@pytest.mark.parametrize("content", [b"", b"\x00\xff" * 50, b"Point(1) = {0, 0, 0};\n", b"no gmsh at all"])
def test_bad_meshes_are_refused_by_one_line(tmp_path, content):
    path = tmp_path / "mesh.geo"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"geometry\.mesh"):
        from_file(MPI.COMM_SELF, path)


def test_layers_of_a_mesh_are_its_groups(tmp_path):
    text = (MESHES / "mold.geo").read_text()
    path = tmp_path / "layers.geo"
    path.write_text(text.replace('Physical Surface("wall")', 'Physical Surface("skin")'))
    domain = from_file(MPI.COMM_SELF, path, ["skin"])
    assert integral(fem.Constant(domain.mesh, 1.0) * domain.wall_measure(2)) == pytest.approx(0.003)
    with pytest.raises(InputError, match="no physical surface named 'part'"):
        from_file(MPI.COMM_SELF, path, ["skin", "part"])


def test_a_mesh_of_the_other_dimension_is_refused():
    for path, dimension, told in (
        ("mold.geo", 3, "no physical volume"),
        ("shell_mold.geo", 2, "physical volumes: bed"),
    ):
        with pytest.raises(InputError, match=told):
            from_file(MPI.COMM_SELF, MESHES / path, dimension=dimension)


@pytest.mark.parametrize(
    ("group", "members", "told"),
    [
        ("inlet", "4, 2", "groups 'inlet' and 'outlet' share"),
        ("inlet", "4, 1", "groups 'inlet' and 'symmetry' share"),
        ("outer", "6, 3", "groups 'interface' and 'outer' share"),
    ],
)
def test_groups_that_share_a_curve_are_refused(group, members, told, tmp_path):
    """Each of them would count twice: a mass flow 5 times as large, or a crash."""
    text = (MESHES / "curved_mold.geo").read_text()
    path = tmp_path / "shared.geo"
    path.write_text(re.sub(rf'Curve\("{group}"\) = {{[0-9]}}', f'Curve("{group}") = {{{members}}}', text))
    with pytest.raises(InputError, match=told):
        from_file(MPI.COMM_SELF, path)


def test_a_mold_from_a_step_file_has_the_shape_that_was_drawn():
    """Volumes are those that OpenCASCADE gives for the solids of the file."""
    domain = from_file(MPI.COMM_SELF, MESHES / "shell_mold.geo", dimension=3)
    one, dx, ds = fem.Constant(domain.mesh, 1.0), domain.cell_measure(2), domain.facet_measure(2)
    assert integral(one * dx(geometry.BED)) == pytest.approx(2.52019e-3, rel=2e-3)
    assert integral(one * dx(geometry.WALL)) == pytest.approx(0.6 * 0.15 * 0.003, rel=1e-6)
    assert integral(one * ds(geometry.INLET)) == pytest.approx(0.15 * 0.025, rel=1e-6)
    assert integral(one * ds(geometry.SYMMETRY)) == pytest.approx(0.6 * 0.15, rel=1e-6)
    assert domain.length == pytest.approx(0.6)
    assert domain.stations(0.5)["bed_side"] == pytest.approx((0.3, 0.0367, 0.0), abs=1e-4)


def wall_of(kind, tmp_path):
    """A mesh with a curved wall and even cells, its dimension, and the perimeter or surface of its bed and wall."""
    if kind == "tetrahedra":
        text = (MESHES / "shell_mold.geo").read_text()
        lines = [line for line in text.splitlines() if not line.startswith(("Recombine", "Transfinite Volume"))]
        text = "\n".join(lines)
    elif kind == "hexahedra":
        text = (MESHES / "shell_mold.geo").read_text()
    else:
        text = (
            (MESHES / "curved_mold.geo").read_text().replace(" Using Progression 1 / 1.3", "").replace("= 22;", "= 6;")
        )
        text = text.replace("Recombine", "//") if kind == "triangles" else text
    path = tmp_path / "mold.geo"
    path.write_text(text.replace('"shell_mold.step"', f'"{MESHES / "shell_mold.step"}"'))
    return path, 3 if kind.endswith("hedra") else 2


@pytest.mark.parametrize("kind", ["quadrilaterals", "triangles", "hexahedra", "tetrahedra"])
def test_cells_at_the_wall_fill_the_gap(kind, tmp_path):
    """Same volumes, so that no cell is turned over; same boundary, no facet left open; the first cell as low as was asked for."""
    path, dimension = wall_of(kind, tmp_path)
    wanted = 2e-4
    drawn = from_file(MPI.COMM_SELF, path, dimension=dimension)
    refined = from_file(
        MPI.COMM_SELF, path, dimension=dimension, finer=Finer(lambda gap: graded_coordinates(gap, wanted, 1.3))
    )
    sizes = []
    for domain in (drawn, refined):
        one, ds, dx = fem.Constant(domain.mesh, 1.0), domain.facet_measure(2), domain.cell_measure(2)
        tags = [geometry.INLET, geometry.OUTLET, geometry.OUTER, geometry.SYMMETRY]
        parts = [one * ds(tag) for tag in ([*tags, geometry.SIDE] if dimension == 3 else tags)]
        parts += [
            one * dx(geometry.BED),
            one * dx(geometry.WALL),
            one * domain.interface_measure(2),
            one * ufl.ds(domain=domain.mesh),
        ]
        sizes.append([integral(part) for part in parts])
    assert sizes[1] == pytest.approx(sizes[0], rel=1e-9)
    counts = [domain.mesh.topology.index_map(dimension).size_local for domain in (drawn, refined)]
    assert counts[1] > 1.5 * counts[0]
    assert first_cell(refined) == pytest.approx(wanted, rel=0.3) and first_cell(drawn) > 5.0 * wanted


def test_a_mesh_fine_enough_at_the_wall_stays_as_it_is():
    drawn, asked = (
        from_file(MPI.COMM_SELF, MESHES / "mold.geo", finer=Finer(cells))
        for cells in (None, lambda gap: graded_coordinates(gap, 2e-5, 1.3))
    )
    assert asked.mesh.topology.index_map(2).size_local == drawn.mesh.topology.index_map(2).size_local


CORNER = """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 0.025, 0.05};
Box(2) = {0, 0.025, 0, 1, 0.003, 0.05};
Box(3) = {0, 0, 0.05, 1, 0.025, 0.003};
Box(4) = {0, 0.025, 0.05, 1, 0.003, 0.003};
Coherence;
Transfinite Curve {:} = 6;
Transfinite Surface {:};
Recombine Surface {:};
Transfinite Volume {:};
Physical Volume("bed") = {1};
Physical Volume("wall") = {2, 3, 4};
Physical Surface("inlet") = Surface In BoundingBox {-1e-6, -1, -1, 1e-6, 0.026, 0.051};
Physical Surface("outlet") = Surface In BoundingBox {0.999, -1, -1, 1.001, 0.026, 0.051};
interface() = Surface In BoundingBox {-1, 0.0249, -1, 2, 0.0251, 0.051};
interface() += Surface In BoundingBox {-1, -1, 0.0499, 2, 0.026, 0.0501};
Physical Surface("interface") = {interface()};
"""


def test_a_bed_between_two_walls_gets_cells_along_their_edge(tmp_path):
    path = tmp_path / "corner.geo"
    path.write_text(CORNER)
    domain = from_file(MPI.COMM_SELF, path, dimension=3, finer=Finer(lambda gap: graded_coordinates(gap, 2e-4, 1.3)))
    one, dx, ds = fem.Constant(domain.mesh, 1.0), domain.cell_measure(2), domain.facet_measure(2)
    assert integral(one * dx(geometry.BED)) == pytest.approx(1.0 * 0.025 * 0.05)
    assert integral(one * ds(geometry.INLET)) == pytest.approx(0.025 * 0.05)
    assert integral(one * ufl.ds(domain=domain.mesh)) == pytest.approx(2.0 * (0.028 * 0.053 + 0.028 + 0.053))
    assert integral(domain.wall_distance * ds(geometry.INLET)) == pytest.approx(
        0.5 * 0.025**2 * 0.05 - 0.025**3 / 6.0, rel=0.02
    )


def two_squares(cells_of_wall, *, shared):
    """Plain mesh of a bed and a wall over it: its nodes on the interface are the bed's or its own, of as many cells as given."""
    bed = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
    x = np.linspace(0.0, 1.0, cells_of_wall + 1)
    rows = [[[place, height, 0.0] for place in x] for height in (1.0, 2.0)]
    points, number = np.array(bed + rows[0] + rows[1]), len(x)
    cells = np.array([[4 + i, 5 + i, 5 + number + i, 4 + number + i] for i in range(cells_of_wall)])
    if shared:
        cells[cells == 4], cells[cells == 4 + cells_of_wall] = 3, 2
    facets = {INLET: np.array([[3, 0]]), OUTLET: np.array([[1, 2]]), INTERFACE: np.array([[3, 2]])}
    return PlainMesh(points, {BED: np.array([[0, 1, 2, 3]]), WALL: cells}, facets)


@pytest.mark.parametrize("cells", [1, 2, 5])
def test_a_wall_without_the_nodes_of_the_bed_is_refused(cells):
    """Its nodes lie where the bed's do, or between them: either way it would stay cold for ever."""
    with pytest.raises(ValueError, match="bed and wall have no common nodes"):
        require_connection(two_squares(cells, shared=False), {BED: "bed", WALL: "wall"})


FLAT = """
Point(1) = {0, 0, 0}; Point(2) = {0.05, 0, 0}; Point(3) = {0.05, 0.02, 0}; Point(4) = {0, 0.02, 0};
Point(5) = {0.05, 0.022, 0}; Point(6) = {0, 0.022, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {4, 3}; Line(4) = {1, 4}; Line(5) = {4, 6}; Line(6) = {6, 5}; Line(7) = {3, 5};
Curve Loop(1) = {1, 2, -3, -4}; Plane Surface(1) = {1};
Curve Loop(2) = {3, 7, -6, -5}; Plane Surface(2) = {2};
Transfinite Curve {1, 3, 6} = 2; Transfinite Curve {2, 4} = 21 Using Progression 1 / 1.6; Transfinite Curve {5, 7} = 2;
Transfinite Surface {1}; Transfinite Surface {2};
RECOMBINE
bed[] = Extrude {0, 0, 0.03} { Surface {1}; Layers {2}; }; wall[] = Extrude {0, 0, 0.03} { Surface {2}; Layers {2}; };
Physical Volume("bed") = {bed[1]}; Physical Volume("wall") = {wall[1]};
Physical Surface("symmetry") = {bed[2]}; Physical Surface("outlet") = {bed[3]};
Physical Surface("interface") = {bed[4]}; Physical Surface("inlet") = {bed[5]};
Physical Surface("outer") = {wall[4]}; Physical Surface("side") = {1, 2, bed[0], wall[0]};
"""


@pytest.mark.parametrize("shape", ["tetrahedra", "hexahedra"])
def test_flat_cells_beside_the_wall_are_connected_to_it(shape, tmp_path):
    """Their sides, 1e3 times as long as high, come nearer to the wall than a thousandth of their length (it was refused)."""
    text = FLAT.replace("RECOMBINE", "" if shape == "tetrahedra" else "Recombine Surface {1, 2};")
    (tmp_path / "flat.geo").write_text(
        text if shape == "tetrahedra" else text.replace("Layers {2};", "Layers {2}; Recombine;")
    )
    domain = from_file(MPI.COMM_SELF, tmp_path / "flat.geo", dimension=3)
    one = fem.Constant(domain.mesh, 1.0)
    assert integral(one * domain.cell_measure(1)(geometry.BED)) == pytest.approx(0.05 * 0.02 * 0.03)


def test_a_wall_with_the_nodes_of_the_bed_is_none_the_worse_for_its_corners():
    require_connection(two_squares(1, shared=True), {BED: "bed", WALL: "wall"})


GEO = """
SetFactory("OpenCASCADE");
Rectangle(1) = {{0, 0, 0, 0.2, 0.02}};
Rectangle(2) = {{0, 0.02, 0, 0.2, 0.002}};
{join}
Physical Surface("bed") = {{1}}; Physical Surface("wall") = {{2}};
Physical Curve("inlet") = {{Curve In BoundingBox {{-1e-4, -1e-4, -1, 1e-4, 0.0201, 1}}}};
Physical Curve("outlet") = {{Curve In BoundingBox {{0.1999, -1e-4, -1, 0.2001, 0.0201, 1}}}};
Physical Curve("interface") = {{Curve In BoundingBox {{-1e-4, 0.0199, -1, 0.2001, 0.0201, 1}}}};
MeshSize {{:}} = 0.005;
{turn}
"""


@pytest.mark.parametrize(
    ("parts", "reason"),
    [
        ({"join": ""}, "bed and wall have no common nodes"),
        ({"turn": "Recombine Surface {1};"}, "must all be of one kind"),
        ({}, None),
    ],
)
def test_drawings_that_do_not_fit_are_refused_in_one_line(tmp_path, parts, reason):
    path = tmp_path / "mold.geo"
    path.write_text(GEO.format(**({"join": "Coherence;", "turn": ""} | parts)))
    read = functools.partial(from_file, MPI.COMM_SELF, path)
    if reason is None:
        assert read().length == pytest.approx(0.2)
        return
    with pytest.raises(InputError, match=reason) as refusal:
        read()
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("axes", "shift", "axisymmetric", "reason"),
    [
        ((0, 2, 1), 0.0, False, "x-z plane: turn it"),
        ((1, 0, 2), 0.0, True, "inlet does not lie across x"),
        ((0, 1, 2), -0.5, True, "below y = 0"),
        ((2, 0, 1), 0.0, False, "x-y plane"),
    ],
)
def test_a_mesh_that_lies_elsewhere_is_refused(axes, shift, axisymmetric, reason):
    mesh = two_squares(1, shared=True)
    require_place(mesh, 2, axisymmetric=axisymmetric)
    mesh.points = mesh.points[:, list(axes)] + [0.0, shift, 0.0]
    with pytest.raises(ValueError, match=reason):
        require_place(mesh, 2, axisymmetric=axisymmetric)


@pytest.mark.parametrize("place", [1e300, float("nan"), -float("inf"), 1e7])
def test_a_mesh_with_a_node_that_is_nowhere_is_refused(place):
    """As a file has it in which a digit or a blank is lost (found by the fuzz)."""
    mesh = two_squares(1, shared=True)
    mesh.points[1, 1] = place
    with pytest.raises(ValueError, match="a node that is not within"):
        require_place(mesh, 2, axisymmetric=False)


def test_a_mesh_may_be_in_millimetres_with_groups_of_other_names(tmp_path):
    text = (MESHES / "mold.geo").read_text()
    path = tmp_path / "mold.geo"
    path.write_text(text.replace('"wall"', '"Haut"').replace('"inlet"', "7").replace('"interface"', '"Grenze"'))
    groups = {"wall": "Haut", "inlet": "7", "interface": "Grenze"}
    domain = from_file(MPI.COMM_SELF, path, conventions=Conventions(1e-3, groups))
    assert domain.length == pytest.approx(1e-3) and domain.has_wall
    for changed, words in (
        ({}, "no physical curve named 'inlet' and"),
        (groups | {"wall": "skin"}, "no physical surface named 'skin'.*Haut"),
        (groups | {"outer": "aussen"}, "no physical curve named 'aussen'"),
        (groups | {"Haut": "wall"}, "must be one of bed, wall, inlet"),
    ):
        with pytest.raises(InputError, match=words):
            from_file(MPI.COMM_SELF, path, conventions=Conventions(1.0, changed))


def test_nodes_at_one_place_are_joined_on_request():
    path, shape = FIELD_CASES / "11-gmsh-users" / "dupnodes.msh", {"axisymmetric": True}
    with pytest.raises(InputError, match=r"no common nodes at 24 sides.*join_nodes"):
        from_file(MPI.COMM_SELF, path, **shape)
    joined = from_file(MPI.COMM_SELF, path, **shape, conventions=Conventions(join_nodes=True))
    whole = from_file(MPI.COMM_SELF, path.with_name("v41.msh"), **shape)
    assert joined.has_wall and joined.length == pytest.approx(whole.length)
    for tag in (BED, WALL):
        volumes = [
            integral(fem.Constant(one.mesh, 1.0) * ufl.Measure("dx", one.mesh, subdomain_data=one.cell_tags)(tag))
            for one in (joined, whole)
        ]
        assert volumes[0] == pytest.approx(volumes[1], rel=1e-3)


def test_a_mesh_that_makes_gmsh_crash_is_refused(tmp_path):
    """A cell with a node that is not there: gmsh follows it to nowhere (found by make fuzz-test)."""
    text = (FIELD_CASES / "11-gmsh-users" / "dupnodes.msh").read_text()
    path = tmp_path / "damaged.msh"
    path.write_text(text.replace("\n411 423 446 4", "\n411 423 446 -"))
    assert path.read_text() != text
    with pytest.raises(InputError, match="is no mesh that can be used"):
        from_file(MPI.COMM_SELF, path, axisymmetric=True)
