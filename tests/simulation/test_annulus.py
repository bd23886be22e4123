"""An annulus around a core: against a wide one, which is a plane cavity, against exact conduction, and input that is refused."""

import math

import pytest
from mpi4py import MPI

from porousmold import InputError, Scene, run
from porousmold.scene.features.geometries import BedSize

RADIUS, GAP, LENGTH = 0.02, 0.05, 0.5
STEEL = {"density": 7850.0, "heat_capacity": 480.0, "conductivity": 45.0, "source": "of the tests"}
COARSE = {"solver.axial_cells": 10, "solver.cell_growth": 1.6}


def annulus(core=RADIUS, settings=(), opposite=(), **tables):
    """A short annulus with a gap of 10 beads between a tube and a core."""
    geometry = {"kind": "annulus", "length": LENGTH, "diameter": 2.0 * (core + GAP), "core_diameter": 2.0 * core}
    scene = {
        "geometry": geometry,
        "bed": {"bead_diameter": 0.005, "bead_material": "ceramic"},
        "wall": {
            "layer": [{"name": "tube", "material": "tool_steel", "thickness": 0.003}],
            "opposite_layer": list(opposite) or [{"name": "core", "material": "tool_steel", "thickness": 0.004}],
        },
        "materials": {"tool_steel": STEEL},
        "operation": {"initial_temperature": 293.15, "inlet_temperature": 353.15, "pressure_drop": 2000.0},
    }
    return Scene(scene | tables).changed(COARSE | dict(settings))


PLUG = {"model.flow": "plug", "model.turbulence": "none"}


def test_sizes_of_an_annulus():
    size = BedSize(length=1.0, half_height=0.025, axisymmetric=True, whole=True, core_radius=0.02)
    assert size.middle == pytest.approx(0.045)
    assert size.area == pytest.approx(math.pi * (0.07**2 - 0.02**2))
    assert size.walls == ((pytest.approx(2 * math.pi * 0.07), 1.0), (pytest.approx(2 * math.pi * 0.02), -1.0))
    assert size.area / size.walled_perimeter == pytest.approx(size.half_height)


@pytest.mark.parametrize("flow", ["plug", "developed", "full"])
def test_a_wide_annulus_is_a_plane_cavity(flow):
    settings = PLUG if flow == "plug" else {"model.flow": flow}
    radius = 50.0
    ring = run(annulus(radius, settings))
    planar = {"kind": "mold", "length": LENGTH, "cavity_height": GAP, "cavity": "whole"}
    plane = run(annulus(radius, settings, geometry=planar))
    around = 2.0 * math.pi * (radius + 0.5 * GAP)
    assert ring.heating_time == pytest.approx(plane.heating_time, rel=2e-4)
    for name in ("mass_flow_initial", "mass_flow_final", "heat_by_fluid", "heat_stored"):
        assert ring.summary[name] == pytest.approx(around * plane.summary[name], rel=1e-3)
    assert abs(ring.summary["energy_imbalance"]) < 1e-5


def test_conduction_from_the_core_is_a_logarithm():
    """At rest and steady: T falls by q' ln(r_2 / r_1) / (2 pi k) across the bed, q' (W/m) from the core that fills its middle."""
    rod = {"name": "rod", "material": "tool_steel", "thickness": RADIUS, "heat_source": 1e6}
    still = {"density": 1.0, "heat_capacity": 1000.0, "conductivity": 0.03, "viscosity": 2e-5}
    operation = {"initial_temperature": 293.15, "inlet_temperature": 293.15, "pressure_drop": 0.0, "end_time": "200 h"}
    operation |= {"outer_coefficient": 1e4, "ambient_temperature": 293.15}
    settings = {"bed.porosity_model": "constant", "bed.bulk_porosity": 0.4, "bed.bead_conductivity": 1.5}
    settings |= {"model.energy": "one-temperature", **PLUG}
    scene = annulus(
        settings=settings,
        opposite=[rod],
        fluid=still,
        operation=operation,
    )
    result = run(scene)
    conductivity, per_length = 0.4 * 0.03 + 0.6 * 1.5, 1e6 * math.pi * RADIUS**2
    expected = per_length * math.log((RADIUS + GAP) / RADIUS) / (2.0 * math.pi * conductivity)
    fall = result["temperature_opposite_bed_side_L/2"][-1] - result["temperature_bed_side_L/2"][-1]
    assert fall == pytest.approx(expected, rel=2e-3)
    inside = result["temperature_opposite_outer_L/2"][-1] - result["temperature_opposite_bed_side_L/2"][-1]
    assert inside == pytest.approx(1e6 * RADIUS**2 / (4.0 * 45.0), abs=0.1)


def test_full_and_developed_flow_agree():
    found = [run(annulus(settings={"model.flow": flow, "geometry.length": 1.5})) for flow in ("full", "developed")]
    assert found[0].heating_time == pytest.approx(found[1].heating_time, rel=2e-3)
    assert found[0].summary["mass_flow_final"] == pytest.approx(found[1].summary["mass_flow_final"], rel=2e-3)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"geometry.core_diameter": 0.2}, "must be less than geometry.diameter, 0.14 m"),
        ({"geometry.core_diameter": 0.006, "geometry.diameter": 0.1}, "layers of 0.003 m at most"),
        ({"geometry.core_diameter": 0.06}, "at least 10 bead diameters"),
        ({"geometry.cavity_height": 0.05}, "has no place in an annulus"),
        ({"model.wall": "insulated"}, "must be 'conjugate'"),
    ],
)
def test_refused(changes, told):
    with pytest.raises(InputError, match=told):
        annulus(settings=changes)


def test_an_annulus_needs_its_core():
    with pytest.raises(InputError, match=r"needs the other wall's layers, \[\[wall.opposite_layer\]\]"):
        annulus(wall={"layer": [{"name": "tube", "material": "tool_steel", "thickness": 0.003}]})


@pytest.mark.mpi
def test_any_number_of_ranks_gives_the_same_answer():
    alone, together = (run(annulus(), communicator=world) for world in (MPI.COMM_SELF, MPI.COMM_WORLD))
    assert together.heating_time == pytest.approx(alone.heating_time, rel=1e-6)


@pytest.mark.parametrize(("diameter", "core"), [(0.110, 0.020), (0.181, 0.020), (0.146, 0.024)])
def test_rounding_leaves_no_node_beyond_a_wall(diameter, core):
    """Where one had a wall distance of -1e-18 m, its porosity was above 1 and the first residual no number."""
    scene = annulus(0.5 * core, {"model.flow": "developed", "operation.end_time": 5.0}, fluid={"material": "water"})
    result = run(
        scene.changed(
            {
                "geometry.diameter": diameter,
                "geometry.core_diameter": core,
                "bed.bead_diameter": 0.004,
                "operation.pressure_drop": None,
                "operation.mass_flow": 0.02,
                "solver.axial_cells": None,
                "solver.cell_growth": None,
            }
        )
    )
    assert result.history["mass_flow"][-1] == pytest.approx(0.02, rel=1e-6)


def test_the_state_of_a_pipe_says_nothing_of_a_core(tmp_path):
    """The core would start with the temperatures of the pipe's beads."""
    outer = 2.0 * (RADIUS + GAP)
    pipe = annulus(settings=PLUG | {"operation.end_time": 5.0, "output.pictures": False}).changed(
        {
            "geometry.kind": "pipe",
            "geometry.diameter": outer,
            "geometry.core_diameter": None,
            "wall.opposite_layer": None,
        }
    )
    run(pipe, out=tmp_path / "pipe")
    after = annulus(settings=PLUG).changed(
        {"operation.initial_temperature": None, "operation.initial_state": str(tmp_path / "pipe")}
    )
    with pytest.raises(InputError, match=r"has its bed between x\[1\] = 0 and 0.07 m, and this one lies between 0.02"):
        run(after)
