"""A cavity of finite width: the same equations on a three-dimensional mesh."""

import numpy as np
import pytest
from mpi4py import MPI

from porousmold import run

from .support import coarse_scene, simulation_of

SMALL = {"solver.mesh_refinement": 0.5, "solver.largest_step": 150.0}
LAMINAR = SMALL | {"model.turbulence": "none"}


@pytest.mark.parametrize("turbulence", ["none", "nakayama-kuwahara"])
def test_a_cavity_without_sides_heats_as_in_two_dimensions(turbulence):
    """Nothing changes across the width, so every temperature is that of the plane and the mass flow is its multiple."""
    choices = SMALL | {"model.turbulence": turbulence, "operation.end_time": 60.0, "solver.flow_tolerance": 1e-6}
    plane = simulation_of(coarse_scene(choices), MPI.COMM_SELF).integrate()
    wide = coarse_scene({"geometry.width": 0.2, "geometry.sides": "symmetry", **choices})
    space = simulation_of(wide, MPI.COMM_SELF).integrate()
    assert space.recorder.history["mass_flow"] == pytest.approx(
        0.1 * np.array(plane.recorder.history["mass_flow"]), rel=1e-5
    )
    for name in (name for name in plane.recorder.history.columns if name.startswith("temperature_")):
        assert space.recorder.history[name] == pytest.approx(plane.recorder.history[name], abs=0.01)
    assert abs(space.problem.heat.balance.imbalance) < 1e-4


def test_height_and_width_may_change_places():
    lying, standing = (
        simulation_of(
            coarse_scene(
                {"geometry.cavity_height": height, "geometry.width": width, "operation.end_time": 60.0, **LAMINAR}
            ),
            MPI.COMM_SELF,
        ).integrate()
        for height, width in ((0.05, 0.06), (0.06, 0.05))
    )
    assert standing.recorder.history["mass_flow"] == pytest.approx(lying.recorder.history["mass_flow"], rel=1e-3)
    assert standing.recorder.history["deficit_wall"] == pytest.approx(lying.recorder.history["deficit_wall"], abs=0.05)


def test_corners_heat_last_and_pictures_are_drawn(tmp_path):
    pytest.importorskip("matplotlib")
    from porousmold.output.pictures import draw

    plane = run(coarse_scene(LAMINAR), communicator=MPI.COMM_SELF)
    box = run(coarse_scene({"geometry.width": 0.1, **LAMINAR}), tmp_path / "box", MPI.COMM_SELF)
    assert box.heating_time > plane.heating_time
    assert np.all(box.history["temperature_corner_L"] <= box.history["temperature_bed_side_L"] + 0.05)
    assert [path.name for path in draw(tmp_path / "box")][-2:] == ["fields.png", "surface.png"]


@pytest.mark.mpi
def test_three_dimensions_on_any_number_of_ranks():
    scene = coarse_scene({"geometry.width": 0.06, "operation.end_time": 60.0, **LAMINAR})
    alone, together = (
        simulation_of(scene, communicator).integrate() for communicator in (MPI.COMM_SELF, MPI.COMM_WORLD)
    )
    assert together.recorder.history["mass_flow"] == pytest.approx(alone.recorder.history["mass_flow"], rel=1e-6)
    assert together.recorder.history["heat_stored"] == pytest.approx(
        alone.recorder.history["heat_stored"], rel=1e-6, abs=1e-6
    )
