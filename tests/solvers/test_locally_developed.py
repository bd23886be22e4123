"""Developed flow over meshes of any shape: one scalar equation of the pressure."""

import numpy as np
import pytest
from mpi4py import MPI
from scipy.integrate import solve_ivp, trapezoid
from scipy.optimize import brentq

from porousmold import InputError, Scene, run
from porousmold.equations.exhaust import mass_leaving
from porousmold.mesh import fenicsx, ranks
from porousmold.mesh.domain import OUTER
from porousmold.simulation.assembly import locally_developed_flow
from porousmold.simulation.checking import check
from porousmold.solvers.developed import DevelopedFlow

from ..support import STUDIES, coarse_scene, simulation_of

CURVED = STUDIES / "mold" / "curved.toml"
LEAN = {"output.pictures": False, "output.fields": False}


def mass_flow(problem):
    """kg/s that leave."""
    form = fenicsx.compiled_form(mass_leaving(problem.energy_equations))
    return ranks.integral(problem.domain.communicator, form)


@pytest.mark.parametrize("settings", [{}, {"model.turbulence": "none"}, {"fluid.material": "water"}])
def test_a_straight_bed_has_its_own_developed_flow(settings):
    """Profiles of a table against those of every station: mass flow within 0.1 %."""
    problem = simulation_of(coarse_scene({"model.flow": "developed", **settings}), MPI.COMM_SELF).problem
    assert isinstance(problem.flow, DevelopedFlow)
    problem.flow.start()
    anywhere = locally_developed_flow(problem.specs, problem.medium)
    anywhere.start()
    (height,) = {float(problem.flow.columns.across[-1])}
    speeds = []
    for flow in (problem.flow, anywhere):
        fields = flow.fields()
        points = fields["pressure"].function_space.tabulate_dof_coordinates()
        middle = (np.abs(points[:, 0] - 0.5 * problem.domain.length) < 0.1) & (points[:, 1] < height)
        speeds.append(fields["velocity"].x.array[0::2][middle])
    assert speeds[1].max() > 0.0
    assert np.sqrt(np.mean((speeds[1] - speeds[0]) ** 2)) < 0.01 * speeds[0].max()


def test_nothing_crosses_a_straight_bed_at_its_ends():
    """Inlet and outlet take the same pressure from wall to wall, whatever the profile: a conductance that was a constant drove
    0.3 % of the flow across the last cells, 0.6 to 1 % of a wall's heating time."""
    problem = simulation_of(
        coarse_scene({"model.flow": "developed", "model.turbulence": "none"}), MPI.COMM_SELF
    ).problem
    flow = locally_developed_flow(problem.specs, problem.medium)
    flow.start()
    velocity = flow.fields()["velocity"].x.array
    assert np.abs(velocity[1::2]).max() < 1e-5 * velocity[0::2].max()


def test_a_viscosity_that_changes_across_the_layer_at_a_wall_is_told():
    liquid = {"fluid.material": "water", "operation.initial_temperature": "5 degC", "geometry.width": "0.3 m"}
    warm = {**liquid, "model.flow": "developed", "model.turbulence": "none", "operation.inlet_temperature": "95 degC"}

    def told(changes):
        found = check(coarse_scene(changes), MPI.COMM_SELF).warnings
        return any("across the layer at the wall" in text for text in found)

    assert told(warm)
    assert not told(warm | {"model.flow": "full"})
    assert not told(warm | {"geometry.width": None})
    warmer = {"operation.initial_temperature": "80 degC"}
    assert not told(warm | {"operation.inlet_temperature": "15 degC"})
    lost = {"operation.outer_coefficient": 8.0, "operation.ambient_temperature": "5 degC"}
    assert not told(warm | warmer | lost)  # the surroundings do not cool the water to theirs


@pytest.mark.parametrize(
    "drive",
    [{}, {"operation.pressure_drop": None, "operation.mass_flow": 0.03},
     {"operation.pressure_drop": None, "operation.inlet_velocity": 0.5}, {"operation.gravity": -9.81},
     {"model.closures": "measured"}],
    ids=["pressure drop", "mass flow", "inlet velocity", "gravity", "measured closures"],
)  # fmt: skip
def test_a_curved_mold_is_heated_as_by_the_full_flow(drive):
    """Heating time within 0.3 %, mass flow too; the heat that it carries is conserved."""
    full, developed = (
        run(Scene.load(CURVED, {"model.flow": flow, **LEAN, **drive}), communicator=MPI.COMM_SELF)
        for flow in ("full", "developed")
    )
    assert developed.heating_time == pytest.approx(full.heating_time, rel=3e-3)
    assert developed.summary["mass_flow_initial"] == pytest.approx(full.summary["mass_flow_initial"], rel=3e-3)
    assert abs(developed.summary["energy_imbalance"]) < 1e-5
    assert developed.summary["unknowns"]["flow"] < 0.3 * full.summary["unknowns"]["flow"]
    for result in (full, developed):  # within the temperatures given: flat cells are crossed to and fro by little
        assert result.history["lowest_temperature"].min() > 298.15 - 0.1
        assert result.history["highest_temperature"].max() < 363.15 + 0.1


RADIAL = """
Point(1) = {0, 0, 0}; Point(2) = {0.05, 0, 0}; Point(3) = {0.2, 0, 0}; Point(4) = {0, 0.2, 0}; Point(5) = {0, 0.05, 0};
Line(1) = {2, 3}; Circle(2) = {3, 1, 4}; Line(3) = {4, 5}; Circle(4) = {5, 1, 2};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Transfinite Curve {1, 3} = 25; Transfinite Curve {2, 4} = 9; Transfinite Surface {1}; Recombine Surface {1};
bed[] = Extrude {0, 0, 0.0125} { Surface{1}; Layers{ {4, 4, 4, 4}, {0.6, 0.85, 0.96, 1} }; Recombine; };
wall[] = Extrude {0, 0, 0.002} { Surface{bed[0]}; Layers{1}; Recombine; };
Physical Volume("bed") = {bed[1]}; Physical Volume("wall") = {wall[1]};
Physical Surface("symmetry") = {1, bed[2], bed[4]}; Physical Surface("outlet") = {bed[3]};
Physical Surface("inlet") = {bed[5]}; Physical Surface("interface") = {bed[0]}; Physical Surface("outer") = {wall[0]};
Physical Surface("side") = {wall[2], wall[3], wall[4], wall[5]};
"""
"""A quarter of the space between two disks, from its middle plane (z = 0) to the wall, in hexahedra."""


def between_disks(folder, **model):
    """A scene on that mesh."""
    (folder / "radial.geo").write_text(RADIAL)
    tables = {
        "geometry": {"kind": "mesh", "mesh": str(folder / "radial.geo"), "symmetry": "none"},
        "bed": {"bead_diameter": 2.5e-3, "bead_material": "ceramic"},
        "operation": {"initial_temperature": 300.0, "inlet_temperature": 310.0, "pressure_drop": 100.0},
        "model": model,
        "wall": {"material": "aluminium"},
    }
    return Scene(tables)


def test_radial_flow_between_plates(tmp_path):
    """Outwards from 50 to 200 mm: the mass flow of an ordinary differential equation with the same profiles, within 1 %."""
    inner, outer, gap = 0.05, 0.2, 0.0125
    problem = simulation_of(between_disks(tmp_path, flow="developed"), MPI.COMM_SELF).problem
    flow = problem.flow
    flow.start()
    fluid, pressure = problem.specs.laws.fluid, problem.specs.flow.outlet_pressure
    density, viscosity = fluid.density(pressure, 300.0), fluid.viscosity(300.0)
    diameter, distance = 2.5e-3, np.linspace(0.0, gap, 4001)
    porosity = problem.specs.porosity.volume(distance, diameter)

    def through(gradient):
        """Mass flow per width (kg/s/m) of half the gap."""
        logarithm = np.full_like(distance, np.log(density * gradient * diameter**3 / viscosity**2))
        speed = flow._profiles.table.at(distance, logarithm)[0][0] * viscosity / density / diameter
        return trapezoid(porosity * density * speed, distance)

    gradients = np.geomspace(1.0, 1e5, 200)
    flows = np.array([through(gradient) for gradient in gradients])

    def lost(total):
        """Pressure (Pa) that a mass flow of the quarter takes."""

        def gradient(radius, _):
            return [np.exp(np.interp(np.log(total / (0.5 * np.pi * radius)), np.log(flows), np.log(gradients)))]

        return solve_ivp(gradient, (inner, outer), [0.0], rtol=1e-8).y[0, -1]

    expected = brentq(lambda total: lost(total) - 100.0, 1e-7, 0.1, xtol=1e-12)
    assert mass_flow(problem) == pytest.approx(expected, rel=0.01)


def test_planes_of_symmetry_of_a_full_flow_lie_in_any_direction(tmp_path):
    """Laminar flow outwards between disks, full beside locally developed: mass flow within 2 %, alike in all directions.

    Planes across x[0] and x[1] and the middle plane, all named symmetry: each holds the velocity across itself.
    """
    full, developed = (
        simulation_of(between_disks(tmp_path, flow=flow, turbulence="none"), MPI.COMM_SELF).problem
        for flow in ("full", "developed")
    )
    for problem in (full, developed):
        problem.flow.start()
    assert mass_flow(full) == pytest.approx(mass_flow(developed), rel=0.02)
    velocity = full.flow.fields()["velocity"]
    places = velocity.function_space.tabulate_dof_coordinates()
    speeds = velocity.x.array.reshape(-1, 3)
    radius = np.hypot(places[:, 0], places[:, 1])
    outwards = (speeds[:, :2] * places[:, :2]).sum(axis=1) / radius
    angle = np.arctan2(places[:, 1], places[:, 0])
    middle = (np.abs(radius - 0.12) < 0.02) & (places[:, 2] < 1e-9)
    edges, inside = (outwards[middle & part].mean() for part in (np.minimum(angle, 0.5 * np.pi - angle) < 0.02,
                                                                 np.abs(angle - 0.25 * np.pi) < 0.4))  # fmt: skip
    assert inside > 0.0 and edges == pytest.approx(inside, rel=0.02)


@pytest.mark.parametrize(
    ("settings", "key"),
    [
        ({"model.flow": "plug"}, "model.flow"),
        ({"operation.bead_velocity": 1e-3, "operation.bead_inlet_temperature": 300.0, "geometry.width": 0.2,
          "model.flow": "developed"}, "operation.bead_velocity"),
    ],
)  # fmt: skip
def test_what_it_leaves_out_is_refused(settings, key):
    scene = coarse_scene if "geometry.width" in settings else lambda given: Scene.load(CURVED, given)
    with pytest.raises(InputError, match=key):
        scene(settings)


@pytest.mark.mpi
def test_a_narrow_mold_on_any_number_of_ranks():
    scene = coarse_scene(
        {"geometry.width": 0.15, "model.flow": "developed", "solver.mesh_refinement": 0.4, "operation.end_time": 120.0}
    )
    alone, together = (
        simulation_of(scene, communicator).integrate() for communicator in (MPI.COMM_SELF, MPI.COMM_WORLD)
    )
    assert together.recorder.history["mass_flow"] == pytest.approx(alone.recorder.history["mass_flow"], rel=1e-6)
    assert together.recorder.history["deficit_wall"] == pytest.approx(alone.recorder.history["deficit_wall"], abs=0.01)


@pytest.mark.parametrize("cells", [0.3, 0.45])
def test_the_pressure_is_iterated_in_large_meshes(cells, monkeypatch):
    """As many iterations whatever the mesh, and the flow of the factors."""
    settings = {"model.flow": "developed", "model.turbulence": "none", "solver.mesh_refinement": cells}
    scene, flows = Scene.load(STUDIES / "mold" / "narrow.toml", settings), []
    for least in ({3: 0}, {3: 10**9}):
        monkeypatch.setattr("porousmold.solvers.locally_developed.LEAST_UNKNOWNS", least)
        problem = simulation_of(scene, MPI.COMM_SELF).problem
        problem.flow.start()
        flows.append(problem.balances.mass_flow)
        assert problem.flow.system.is_iterated == (least[3] == 0)
        assert problem.flow.system.linear_iterations < 30
    assert flows[0] == pytest.approx(flows[1], rel=1e-6)


def test_cells_too_high_at_the_wall_are_warned_of(tmp_path):
    """Triangles without graded cells: the profile at the wall is missed, and the run says so."""
    mesh = (STUDIES.parent / "meshes" / "curved_mold.geo").read_text().replace("Using Progression 1 / 1.3", "")
    (tmp_path / "coarse.geo").write_text(mesh.replace("across = 22", "across = 3"))
    settings = {"geometry.mesh": str(tmp_path / "coarse.geo"), "model.flow": "developed", "operation.end_time": 60.0}
    result = run(Scene.load(CURVED, {**settings, **LEAN}), communicator=MPI.COMM_SELF)
    assert any("first cell at the wall" in text for text in result.summary["warnings"])


@pytest.mark.parametrize("groups", [{"outlet": "inlet + outlet"}, {"wall": "bed + wall"}, {"outlet": "outlet + outer"}])
def test_a_group_of_a_mesh_has_one_meaning(groups):
    scene = Scene.load(CURVED, {"geometry.groups": groups, **LEAN})
    with pytest.raises(InputError, match="must name a group once"):
        simulation_of(scene, MPI.COMM_SELF)


def test_several_groups_are_one(tmp_path):
    """The interface in two pieces is that of one."""
    mesh = (STUDIES.parent / "meshes" / "curved_mold.geo").read_text()
    mesh = mesh.replace(
        'Physical Curve("outer") = {6};', 'Physical Curve("outside") = {6}; Physical Curve("ends") = {5, 7};'
    )
    (tmp_path / "apart.geo").write_text(mesh)
    settings = {"geometry.mesh": str(tmp_path / "apart.geo"), "geometry.groups": {"outer": "outside + ends"}}
    joined = simulation_of(Scene.load(CURVED, settings | LEAN), MPI.COMM_SELF).problem.domain
    alone = simulation_of(Scene.load(CURVED, LEAN), MPI.COMM_SELF).problem.domain
    assert len(joined.facets(OUTER)) == len(alone.facets(OUTER)) + 2
