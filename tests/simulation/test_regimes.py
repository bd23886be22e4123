"""Where a flow becomes turbulent."""

import pytest
from mpi4py import MPI

from porousmold import Scene
from porousmold.simulation.regimes import turbulence_begins_at
from porousmold.simulation.specs import specs_of
from porousmold.simulation.time_integration import Simulation

from ..support import ALUMINIUM
from .test_answers_in_doubt import TRANSITION


def begins_at(scene):
    simulation = Simulation(specs_of(scene), MPI.COMM_WORLD)
    simulation.integrate()
    found = turbulence_begins_at(simulation.problem)
    simulation.free()
    return found


@pytest.mark.mpi
def test_turbulence_grows_from_the_inlet_where_no_bead_source_acts():
    """With sources, or where it has developed, it is there from the inlet on; a laminar flow has none."""
    short, coarse = {"operation.end_time": 0.5}, {"solver.mesh_refinement": 0.5}
    assert begins_at(Scene(TRANSITION).changed(short)) == pytest.approx(0.25, abs=0.06)
    for turbulence, flow in (("nakayama-kuwahara", "full"), ("k-epsilon", "developed"), ("none", "full")):
        settings = short | coarse | {"model.turbulence": turbulence, "model.flow": flow}
        assert begins_at(Scene.load(ALUMINIUM, settings)) < 0.01
