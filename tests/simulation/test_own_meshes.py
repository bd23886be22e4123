"""Whole runs on meshes of one's own: cells put at the wall, three dimensions, walls in layers."""

import re

import numpy as np
import pytest
from mpi4py import MPI

from porousmold import InputError, Scene, run
from porousmold.mesh.wall_stations import longest_chain
from porousmold.simulation.checking import check
from porousmold.simulation.specs import specs_of

from ..support import ALUMINIUM, MESHES, PIPE, STUDIES, coarse_scene, problem_of, simulation_of

CURVED = STUDIES / "mold" / "curved.toml"
SOON = {"operation.end_time": 60.0, "model.turbulence": "none", "output.pictures": False}


def mold_like(path, *replaced):
    """The shipped mesh of the plane mold, changed."""
    text = (MESHES / "mold.geo").read_text()
    for old, new in replaced:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)
    return path


EXTRUDED = """
Extrude {0, 0, 0.04} { Surface {1, 2}; Layers {2}; Recombine; }
Physical Volume("bed") = Volume In BoundingBox {-1, -1, -1, 2, 0.0251, 1};
Physical Volume("wall") = Volume In BoundingBox {-1, 0.0249, -1, 2, 1, 1};
Physical Surface("inlet") = Surface In BoundingBox {-1e-4, -1, -1, 1e-4, 0.0251, 1};
Physical Surface("outlet") = Surface In BoundingBox {0.999, -1, -1, 1.001, 0.0251, 1};
Physical Surface("interface") = Surface In BoundingBox {-1, 0.0249, -1, 2, 0.0251, 1};
Physical Surface("outer") = Surface In BoundingBox {-1, 0.0279, -1, 2, 0.0281, 1};
Physical Surface("symmetry") = Surface In BoundingBox {-1, -1e-4, -1, 2, 1e-4, 1};
Physical Surface("side") = {Surface In BoundingBox {-1, -1, -1e-4, 2, 1, 1e-4}, Surface In BoundingBox {-1, -1, 0.0399, 2, 1, 1}};
"""


def extruded(path, *replaced):
    """The plane mold's mesh, 40 mm wide in two cells."""
    mold_like(path, *replaced)
    kept = [line for line in path.read_text().splitlines() if not line.startswith("Physical")]
    path.write_text("\n".join(kept) + EXTRUDED)
    return path


COARSE = (("along = 24", "along = 8"), ("across = 22", "across = 10"))


def test_a_mesh_that_begins_elsewhere_has_profiles_where_they_are_given(tmp_path):
    """Distances of a profile, and of a heat flux along the wall, count from where the bed begins, not from x = 0."""
    (tmp_path / "start.csv").write_text("x [m], temperature [degC]\n0, 25\n0.3, 25\n0.6, 60\n1, 60\n")
    (tmp_path / "flux.csv").write_text("time [s], 0.2 m [W/m^2], 0.5 m [W/m^2]\n0, 0, 3000\n100, 0, 3000\n")
    moved = [(f"{{{x}, ", f"{{2.5 + {x}, ") for x in ("0", "length")]
    settings = {
        **SOON,
        "operation.initial_temperature": str(tmp_path / "start.csv"),
        "operation.outer_heat_flux": str(tmp_path / "flux.csv"),
        "model.flow": "developed",
    }
    here, there = (
        run(
            Scene.load(CURVED, settings | {"geometry.mesh": str(mold_like(tmp_path / name, *COARSE, *change))}),
            communicator=MPI.COMM_SELF,
        )
        for name, change in (("here.geo", []), ("there.geo", moved))
    )
    for name in ("heat_stored", "heat_by_fluid", "heat_through_outer_wall", "outlet_temperature"):
        assert there.history[name] == pytest.approx(here.history[name], rel=1e-6, abs=1e-3)
    assert here.history["lowest_temperature"][0] == pytest.approx(298.15, abs=0.1)
    assert there.history["coldest_place"] == pytest.approx(here.history["coldest_place"], abs=1e-6)


def test_a_step_at_the_inlet_is_told_wherever_that_is(tmp_path):
    settings = {"model.energy": "one-temperature", "model.flow": "developed", **SOON}
    for begin in ("0", "2.5", "-0.5"):
        moved = [(f"{{{x}, ", f"{{{begin} + {x}, ") for x in ("0", "length")]
        mesh = mold_like(tmp_path / f"{begin}.geo", *COARSE, *moved)
        problem = simulation_of(Scene.load(CURVED, settings | {"geometry.mesh": str(mesh)}), MPI.COMM_SELF).problem
        problem.heat.unknown.interpolate(lambda x, begin=float(begin): 300.0 + 5.0 * (x[0] < begin + 1e-6) + x[0])
        assert problem.places.step_at_the_inlet("bed") == pytest.approx(4.0), begin  # 5 K, less 1 K at 1 m


@pytest.mark.parametrize("refine", [False, True])
def test_an_extruded_mold_is_heated_as_the_plane_one(tmp_path, refine):
    changes = SOON | {"geometry.refine_wall": refine, "solver.flow_tolerance": 1e-4, "solver.refine_in_doubt": False}
    plane = mold_like(tmp_path / "plane.geo", *COARSE)
    spatial = extruded(tmp_path / "spatial.geo", *COARSE)
    flat, solid = (
        run(Scene.load(CURVED, {**changes, "geometry.mesh": str(mesh), **more}), communicator=MPI.COMM_SELF)
        for mesh, more in ((plane, {}), (spatial, {"geometry.symmetry": "none"}))
    )
    assert solid.summary["unknowns"]["energy"] == 3 * flat.summary["unknowns"]["energy"]
    for name in ("mass_flow", "heat_stored"):
        assert solid.history[name][-1] == pytest.approx(0.04 * flat.history[name][-1], rel=1e-6)
    assert solid.history["outlet_temperature"][-1] == pytest.approx(flat.history["outlet_temperature"][-1], rel=1e-8)


@pytest.mark.mpi
def test_an_extruded_mold_is_the_same_on_any_number_of_ranks(tmp_path):
    folder = MPI.COMM_WORLD.bcast(tmp_path)
    if MPI.COMM_WORLD.rank == 0:
        extruded(folder / "spatial.geo", *COARSE)
    MPI.COMM_WORLD.barrier()
    mesh = {"geometry.mesh": str(folder / "spatial.geo"), "geometry.symmetry": "none", "geometry.refine_wall": True}
    scene = Scene.load(CURVED, SOON | mesh)
    alone, together = (
        simulation_of(scene, communicator).integrate() for communicator in (MPI.COMM_SELF, MPI.COMM_WORLD)
    )
    assert together.recorder.history["heat_stored"][-1] == pytest.approx(
        alone.recorder.history["heat_stored"][-1], rel=1e-6
    )


@pytest.mark.parametrize("kind", ["quadrilaterals", "triangles"])
def test_a_mesh_too_coarse_at_the_wall_is_refined_to_the_answer(tmp_path, kind):
    """Even cells across the bed, the first one 100 times too high: no flow is found. With cells at the wall the heating time is
    that of the program's own mesh."""
    changes = [(" Using Progression 1 / 1.3", ""), ("across = 22", "across = 8")]
    mesh = mold_like(tmp_path / "coarse.geo", *changes, *([("Recombine", "//")] if kind == "triangles" else []))
    settings = {"geometry.mesh": str(mesh), "geometry.refine_wall": True, "output.pictures": False}
    ours = run(Scene.load(ALUMINIUM, {"output.pictures": False}), communicator=MPI.COMM_SELF)
    refined = run(Scene.load(CURVED, settings), communicator=MPI.COMM_SELF)
    assert refined.heating_time == pytest.approx(ours.heating_time, rel=5e-3)
    assert abs(refined.summary["energy_imbalance"]) < 1e-4


@pytest.mark.parametrize("kind", ["quadrilaterals", "triangles"])
def test_the_first_front_stays_between_the_temperatures_given(tmp_path, kind):
    """On a curved mesh as well, and in triangles that have no side along the flow (once 27 K above the inlet's)."""
    text = (MESHES / "curved_mold.geo").read_text()
    mesh = tmp_path / "curved.geo"
    mesh.write_text(text.replace("Recombine", "//") if kind == "triangles" else text)
    settings = {"geometry.mesh": str(mesh), "operation.end_time": 120.0, "output.pictures": False}
    found = run(Scene.load(CURVED, settings), communicator=MPI.COMM_SELF)
    assert not [warning for warning in found.summary["warnings"] if "beyond" in warning]
    assert abs(found.summary["energy_imbalance"]) < 1e-4


def test_keys_of_a_mesh_in_three_dimensions():
    with pytest.raises(InputError, match=re.escape("geometry.parts")):
        Scene.load(CURVED, {"geometry.parts": 4, "geometry.symmetry": "axisymmetric"})
    with pytest.raises(InputError, match=re.escape("geometry.refine_wall")):
        Scene.load(ALUMINIUM, {"geometry.refine_wall": True})
    shell = Scene.load(STUDIES / "mold" / "shell.toml")
    assert specs_of(shell).mesh.dimension == 3 and Scene(shell.as_tables()).as_tables() == shell.as_tables()
    with pytest.raises(InputError, match=re.escape("geometry.mesh")):
        problem_of(Scene.load(STUDIES / "mold" / "shell.toml", {"geometry.symmetry": "planar"}))


HALVES = """Point(7) = {0, width + thickness / 2, 0};
Point(8) = {length, width + thickness / 2, 0};
Line(8) = {7, 8};
Line(9) = {7, 5};
Line(10) = {8, 6};
"""
SPLIT_WALL = (
    ("Line(1) = {1, 2};", HALVES + "Line(1) = {1, 2};"),
    ("Line(5) = {3, 5};", "Line(5) = {3, 7};"),
    ("Line(7) = {4, 6};", "Line(7) = {4, 8};"),
    ("{3, 7, -6, -5};", "{3, 7, -8, -5};\nCurve Loop(3) = {8, 10, -6, -9};\nPlane Surface(3) = {3};"),
    ("Transfinite Curve {1, 3, 6}", "Transfinite Curve {1, 3, 6, 8}"),
    ("Transfinite Curve {5, 7}", "Transfinite Curve {5, 7, 9, 10}"),
    ("Surface {1, 2};", "Surface {1, 2, 3};"),
)


@pytest.mark.parametrize("kind", ["pipe", "three dimensions", "mesh"])
def test_two_layers_of_one_material_are_one_wall(tmp_path, kind):
    """In a pipe, around a mold of given width, and by the groups of a mesh: the same heat as with one wall. In the program's own
    meshes the wall's ends differ by a cell along the flow."""
    if kind == "mesh":
        mesh = mold_like(tmp_path / "split.geo", *COARSE, *SPLIT_WALL)
        one_mesh = mesh.with_name("one.geo")
        one_mesh.write_text(mesh.read_text().replace('Surface("wall") = {2}', 'Surface("wall") = {2, 3}'))
        mesh.write_text(
            mesh.read_text().replace('"wall") = {2}', '"inside") = {2};\nPhysical Surface("outside") = {3}')
        )
        one = Scene.load(CURVED, SOON | {"geometry.mesh": str(one_mesh)})
    else:
        path, coarse = {
            "pipe": (PIPE, {}), "three dimensions": (STUDIES / "mold" / "narrow.toml", {"solver.mesh_refinement": 0.25}),
        }[kind]  # fmt: skip
        one = Scene.load(path, SOON | coarse | {"solver.axial_cells": 8, "solver.wall_cells": 4})
    tables = one.as_tables()
    layers = [{"name": name, "material": one.wall.material} for name in ("inside", "outside")]
    if kind == "mesh":
        tables["geometry"]["mesh"] = str(mesh)
    else:
        tables["solver"].pop("wall_cells")
        layers = [layer | {"thickness": one.wall.thickness / 2, "cells": 2} for layer in layers]
    tables["wall"] = {"layer": layers}
    plain, layered = (run(scene, communicator=MPI.COMM_SELF) for scene in (one, Scene(tables)))
    for name in ("heat_stored", "outlet_temperature"):
        close = 1e-9 if kind == "mesh" else 1e-3
        assert layered.history[name][-1] == pytest.approx(plain.history[name][-1], rel=close)


def test_a_mold_from_a_step_file_is_heated():
    """The flow of k and epsilon below a doubly curved skin is found, mass and heat are kept."""
    # at the default tolerance one iteration a step leaves 1e-5 of the mass flow as long as it changes fast
    changes = {"operation.end_time": 30.0, "output.pictures": False, "solver.flow_tolerance": 1e-3}
    result = run(Scene.load(STUDIES / "mold" / "shell.toml", changes), communicator=MPI.COMM_SELF)
    assert result.summary["mass_imbalance"] == pytest.approx(0.0, abs=1e-6)
    assert result.summary["energy_imbalance"] == pytest.approx(0.0, abs=1e-4)
    assert 298.0 < result.history["outlet_temperature"][-1] < 299.0


UPRIGHT = """
Point(1) = {0, 0, 0}; Point(2) = {0.02, 0, 0}; Point(3) = {0.02, 0.3, 0}; Point(4) = {0, 0.3, 0};
Point(5) = {0.023, 0, 0}; Point(6) = {0.023, 0.3, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Line(5) = {2, 5}; Line(6) = {5, 6}; Line(7) = {6, 3};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Curve Loop(2) = {5, 6, 7, -2}; Plane Surface(2) = {2};
Transfinite Curve{2, 4, 6} = 16; Transfinite Curve{1, -3} = 13 Using Progression 0.75; Transfinite Curve{5, 7} = 2;
Transfinite Surface{1}; Transfinite Surface{2}; Recombine Surface{1, 2};
Physical Surface("bed") = {1}; Physical Surface("wall") = {2};
Physical Curve("inlet") = {1}; Physical Curve("outlet") = {3}; Physical Curve("interface") = {2};
Physical Curve("symmetry") = {4}; Physical Curve("outer") = {6};
"""
OF_A_MESH = {
    "geometry.kind": "mesh",
    **dict.fromkeys(("geometry.length", "geometry.cavity_height", "wall.thickness"), None),
    **dict.fromkeys(("solver.mesh_refinement", "solver.axial_cells", "solver.first_cell", "solver.cell_growth"), None),
    "bed.bead_diameter": "2 mm",
    "model.flow": "developed",
    "model.turbulence": "none",
}


def upright(tmp_path, changes):
    (tmp_path / "upright.geo").write_text(UPRIGHT)
    return coarse_scene({**OF_A_MESH, "geometry.mesh": str(tmp_path / "upright.geo"), **changes})


def test_what_counts_along_the_flow_is_refused_in_a_mesh_that_lies_otherwise(tmp_path):
    """Gravity and profiles count along x[0]: in a mesh along x[1] they would be nothing, or all of the first value."""
    (tmp_path / "profile.csv").write_text("x [m], temperature [degC]\n0, 90\n0.3, 25\n")
    (tmp_path / "flux.csv").write_text("time [s], 0.1 m [W/m^2], 0.2 m [W/m^2]\n0, 5000, 0\n100, 5000, 0\n")
    assert simulation_of(upright(tmp_path, {}), MPI.COMM_SELF).problem.domain.length == pytest.approx(0.3)
    for key, value in (
        ("operation.gravity", 9.81),
        ("operation.initial_temperature", str(tmp_path / "profile.csv")),
        ("operation.outer_heat_flux", str(tmp_path / "flux.csv")),
    ):
        with pytest.raises(InputError, match=rf"{key}.*counts along x\[0\]"):
            simulation_of(upright(tmp_path, {key: value}), MPI.COMM_SELF)


SLOTTED = """
Point(1) = {{0, 0, 0}}; Point(2) = {{0.3, 0, 0}}; Point(3) = {{0.3, 0.025, 0}}; Point(4) = {{0, 0.025, 0}};
Point(5) = {{{beside}, {height}, 0}}; Point(6) = {{{covered}, 0.025, 0}};
Line(1) = {{1, 2}}; Line(2) = {{2, {first}}}; Line(3) = {{{first}, 3}};
Line(4) = {{3, 6}}; Line(5) = {{6, 4}}; Line(6) = {{4, 1}};
Curve Loop(1) = {{1:6}}; Plane Surface(1) = {{1}};
Transfinite Curve {{1}} = 13; Transfinite Curve {{4}} = 5; Transfinite Curve {{5}} = 9;
Transfinite Curve {{2}} = 9; Transfinite Curve {{3}} = 3; Transfinite Curve {{6}} = 11;
Transfinite Surface {{1}} = {{1, 2, 3, 4}}; Recombine Surface {{1}};
Physical Surface("bed") = {{1}};
Physical Curve("{whole}") = {{6}}; Physical Curve("{slot}") = {{3}};
Physical Curve("symmetry") = {{1}}; Physical Curve("interface") = {{{interface}}};
"""
"""Half of a bed of 0.3 m x 50 mm with an opening of 5 mm at the wall at one end."""


def slotted(path, *, slot, interface="4, 5"):
    """That mesh with the `slot` as inlet or outlet, its interface of these curves: "5" ends at 0.2 m."""
    numbers = {"beside": 0.3, "height": 0.02, "covered": 0.2, "first": 5, "interface": interface}
    path.write_text(SLOTTED.format(slot=slot, whole="outlet" if slot == "inlet" else "inlet", **numbers))
    return {**OF_A_MESH, "geometry.mesh": str(path), "geometry.symmetry": "planar"}


def test_developed_flow_has_the_profiles_of_the_bed_beside_a_port_at_the_wall(tmp_path):
    """The same flow to and from it: of a port within a bead of the wall the whole bed had the profiles there, 27 % too fast."""
    changes = {"bed.bead_diameter": "8 mm", "bed.allow_small_ratio": True, "model.closures": "measured"}
    flows = []
    for slot in ("inlet", "outlet"):
        mesh = slotted(tmp_path / f"{slot}.geo", slot=slot)
        mesh |= {"model.flow": "developed", "model.turbulence": "none", "operation.pressure_drop": "1 kPa", **changes}
        problem = simulation_of(coarse_scene(mesh), MPI.COMM_SELF).problem
        problem.flow.start()
        flows.append(problem.balances.mass_flow)
    assert flows[0] == pytest.approx(flows[1], rel=0.01)


def test_the_column_beside_an_upright_bed_is_as_high_as_that(tmp_path):
    """Not only as its wall: cold air flows as in a lying one, where a wall is beside two thirds of the bed."""
    blower = {"operation.blower_pressure": "20 Pa", "operation.blower_flow": "0.02 m^3/s", "geometry.parts": 2}
    blower |= {"operation.heater_power": "2 kW", "operation.pressure_drop": None, "model.flow": "developed"}
    blower |= {"model.turbulence": "none", "operation.inlet_temperature": "90 degC"}
    mesh = slotted(tmp_path / "short.geo", slot="outlet", interface="5")
    flows = []
    for gravity in (0.0, -9.81):
        settings = {**mesh, **blower, "operation.gravity": gravity, "operation.end_time": 1e-3}
        flows.append(run(coarse_scene(settings), communicator=MPI.COMM_SELF).summary["mass_flow_initial"])
    assert flows[0] == pytest.approx(flows[1], rel=1e-3)


def test_of_two_walls_the_longer_one_tells_length_and_stations():
    """Not a way to and fro between them: 0.4 m for a bed between walls of 0.4 and 0.3 m."""
    lower = [[[0.1 * n, 0.0], [0.1 * (n + 1), 0.0]] for n in (2, 0, 3, 1)]
    upper = [[[0.1 * n, 0.06], [0.1 * (n + 1), 0.06]] for n in range(3)]
    chain = longest_chain(np.array(lower + upper), np.array([0.0, 0.03]))
    assert chain == pytest.approx(np.array([[0.1 * n, 0.0] for n in range(5)]))
    assert longest_chain(np.array(lower), np.array([0.4, 0.0]))[0] == pytest.approx([0.4, 0.0])


def test_a_rarefied_gas_is_warned_of():
    """Helium at 10 mbar about beads of 0.1 mm: a mean free path of 15 um or more."""
    thin = {"fluid.material": "helium", "operation.outlet_pressure": 1000.0, "operation.pressure_drop": 100.0}
    scene = coarse_scene({**thin, "bed.bead_diameter": "0.1 mm", "model.flow": "plug", "model.turbulence": "none"})
    assert any("mean free path" in text for text in check(scene, MPI.COMM_SELF).warnings)
    assert not any("mean free path" in text for text in check(coarse_scene(), MPI.COMM_SELF).warnings)


@pytest.mark.parametrize(("core", "is_told"), [(0.01, True), (0.03, False)])
def test_developed_flow_beside_a_thin_core_is_told(core, is_told, tmp_path):
    """Its profiles are those beside a plane wall: 1.1 % of a time at a radius of 2.5 bead diameters, in silence."""
    text = (MESHES / "pipe.geo").read_text().replace("across = 24;", f"across = 24; core = {core};")
    text = text.replace("Point(1) = {0, 0, 0}", "Point(1) = {0, core, 0}").replace(
        "{length, 0, 0}", "{length, core, 0}"
    )
    text = text.replace('"interface") = {3}', '"interface") = {1, 3}').replace('Physical Curve("symmetry") = {1};', "")
    (tmp_path / "annulus.geo").write_text(text)
    given = dict.fromkeys(("geometry.length", "geometry.diameter", "wall.thickness"))
    given |= {
        "geometry.kind": "mesh",
        "geometry.mesh": str(tmp_path / "annulus.geo"),
        "geometry.symmetry": "axisymmetric",
    }
    given |= {"model.flow": "developed", "model.turbulence": "none", "bed.bead_diameter": 0.004}
    warnings = check(Scene.load(PIPE, given), MPI.COMM_SELF).warnings
    assert any("profile beside a plane wall" in text for text in warnings) == is_told


def cavity(path, whole):
    """A plane mold of 0.6 m and 60 mm, the whole of it between two walls, or its upper half without a group `symmetry`."""
    sides = (-1, 1) if whole else (1,)
    text = ["l = 0.6; h = 0.03; a = 0.003;", "Point(1) = {0, 0, 0}; Point(2) = {l, 0, 0}; Line(1) = {1, 2};"]
    groups = {name: [] for name in ("bed", "wall", "inlet", "outlet", "interface", "outer")}
    for number, side in enumerate(sides):
        p, c, s = 10 + 10 * number, 10 + 10 * number, 1 + 2 * number
        text += [
            f"Point({p}) = {{0, {side} * h, 0}}; Point({p + 1}) = {{l, {side} * h, 0}};",
            f"Point({p + 2}) = {{0, {side} * (h + a), 0}}; Point({p + 3}) = {{l, {side} * (h + a), 0}};",
            f"Line({c}) = {{1, {p}}}; Line({c + 1}) = {{2, {p + 1}}}; Line({c + 2}) = {{{p}, {p + 1}}};",
            f"Line({c + 3}) = {{{p}, {p + 2}}}; Line({c + 4}) = {{{p + 1}, {p + 3}}}; Line({c + 5}) = {{{p + 2}, {p + 3}}};",
            f"Curve Loop({s}) = {{1, {c + 1}, {-c - 2}, {-c}}}; Plane Surface({s}) = {{{s}}};",
            f"Curve Loop({s + 1}) = {{{c + 2}, {c + 4}, {-c - 5}, {-c - 3}}}; Plane Surface({s + 1}) = {{{s + 1}}};",
            f"Transfinite Curve{{1, {c + 2}, {c + 5}}} = 13; Transfinite Curve{{{c}, {c + 1}}} = 12 Using Progression 0.7;",
            f"Transfinite Curve{{{c + 3}, {c + 4}}} = 2;",
            f"Transfinite Surface{{{s}, {s + 1}}}; Recombine Surface{{{s}, {s + 1}}};",
        ]
        for name, entity in zip(groups, (s, s + 1, c, c + 1, c + 2, c + 5), strict=True):
            groups[name].append(str(entity))
    kinds = {name: "Surface" if name in ("bed", "wall") else "Curve" for name in groups}
    text += [f'Physical {kinds[name]}("{name}") = {{{", ".join(of)}}};' for name, of in groups.items()]
    path.write_text("\n".join(text) + "\n")
    return path


BLOWN = {
    "operation.pressure_drop": None,
    "operation.blower_pressure": "4 kPa",
    "operation.blower_flow": "300 m^3/h",
    "operation.heater_power": "6 kW",
    "operation.end_time": 20.0,
    "model.turbulence": "none",
    "model.flow": "developed",
    "output.pictures": False,
}


def test_a_whole_cavity_takes_the_blowers_air_once(tmp_path):
    """It counted as half of the tool: twice the air, twice the power, in silence."""
    files = {whole: str(cavity(tmp_path / f"{whole}.geo", whole)) for whole in (False, True)}
    with pytest.raises(InputError, match=r"geometry\.parts: is missing: the mesh has no group 'symmetry'"):
        run(Scene.load(CURVED, BLOWN | {"geometry.mesh": files[True]}), communicator=MPI.COMM_SELF)
    half, whole = (
        run(Scene.load(CURVED, BLOWN | {"geometry.mesh": files[is_whole], "geometry.parts": parts})).summary
        for is_whole, parts in ((False, 2), (True, 1))
    )
    assert whole["mass_flow_initial"] == pytest.approx(2.0 * half["mass_flow_initial"], rel=1e-3)
    assert whole["energy"]["heater"] == pytest.approx(half["energy"]["heater"], rel=1e-3)
    assert Scene.load(CURVED, {"geometry.mesh": files[True]})  # without a supply it makes no difference


def test_the_estimates_of_a_blown_mesh_are_those_of_the_built_in_mold(tmp_path):
    """Its pressure drop was half of the blower's: a bead Reynolds number 24 times too high, and nine times the steps."""
    weak = BLOWN | {
        "operation.blower_pressure": "20 kPa",
        "operation.blower_flow": "60 m^3/h",
        "bed.bead_diameter": "5 mm",
    }
    mesh = {"geometry.mesh": str(cavity(tmp_path / "half.geo", False)), "geometry.parts": 2}
    built_in = {"geometry.length": 0.6, "geometry.cavity_height": 0.06}
    own = problem_of(Scene.load(CURVED, weak | mesh)).medium.estimates
    mold = problem_of(Scene.load(ALUMINIUM, weak | built_in)).medium.estimates
    assert own.reynolds_number == pytest.approx(mold.reynolds_number, rel=0.01)


def test_a_narrow_bed_of_ones_own_is_told(tmp_path):
    wide = {"geometry.mesh": str(cavity(tmp_path / "half.geo", False))}
    for diameter, is_told in ((5e-3, False), (8e-3, True)):
        told = check(Scene.load(CURVED, wide | {"bed.bead_diameter": diameter}), MPI.COMM_SELF).warnings
        assert any("7.5 beads wide, below 10" in text for text in told) == is_told
