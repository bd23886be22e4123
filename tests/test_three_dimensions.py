"""A cavity of finite width: the same equations on a three-dimensional mesh."""

import numpy as np
import pytest
from mpi4py import MPI

from porousmold import run
from porousmold.simulation import Simulation

from .support import coarse_scene

SMALL = {"solver__mesh_refinement": 0.5, "solver__largest_step": 150.0}
LAMINAR = SMALL | {"model__turbulence": "none"}


@pytest.mark.parametrize("turbulence", ["none", "nakayama-kuwahara"])
def test_a_cavity_without_sides_heats_as_in_two_dimensions(turbulence):
    """Nothing changes across the width, so every temperature is that of the plane and the mass flow is its multiple."""
    choices = SMALL | {"model__turbulence": turbulence, "operation__end_time": 60.0, "solver__flow_tolerance": 1e-6}
    plane = Simulation(coarse_scene(**choices), MPI.COMM_SELF).march()
    wide = coarse_scene(geometry__width=0.2, geometry__sides="symmetry", **choices)
    space = Simulation(wide, MPI.COMM_SELF).march()
    assert space.history["mass_flow"] == pytest.approx(0.1 * np.array(plane.history["mass_flow"]), rel=1e-5)
    for name in (name for name in plane.history.columns if name.startswith("temperature_")):
        assert space.history[name] == pytest.approx(plane.history[name], abs=0.01)
    assert abs(space.problem.heat.balance.imbalance) < 1e-4


def test_height_and_width_may_change_places():
    lying, standing = (
        Simulation(
            coarse_scene(geometry__cavity_height=height, geometry__width=width, operation__end_time=60.0, **LAMINAR),
            MPI.COMM_SELF,
        ).march()
        for height, width in ((0.05, 0.06), (0.06, 0.05))
    )
    assert standing.history["mass_flow"] == pytest.approx(lying.history["mass_flow"], rel=1e-3)
    assert standing.history["deficit_wall"] == pytest.approx(lying.history["deficit_wall"], abs=0.05)


def test_corners_heat_last_and_pictures_are_drawn(tmp_path):
    pytest.importorskip("matplotlib")
    from porousmold.plots import draw

    plane = run(coarse_scene(**LAMINAR), communicator=MPI.COMM_SELF)
    box = run(coarse_scene(geometry__width=0.1, **LAMINAR), tmp_path / "box", MPI.COMM_SELF)
    assert box.heating_time > plane.heating_time
    assert np.all(box.history["temperature_corner_L"] <= box.history["temperature_bed_side_L"] + 0.05)
    assert len(draw(tmp_path / "box")) == 3


@pytest.mark.mpi
def test_three_dimensions_on_any_number_of_ranks():
    scene = coarse_scene(geometry__width=0.06, operation__end_time=60.0, **LAMINAR)
    alone, together = (Simulation(scene, communicator).march() for communicator in (MPI.COMM_SELF, MPI.COMM_WORLD))
    assert together.history["mass_flow"] == pytest.approx(alone.history["mass_flow"], rel=1e-6)
    assert together.history["heat_stored"] == pytest.approx(alone.history["heat_stored"], rel=1e-6, abs=1e-6)
