"""The same answers on any number of ranks. Run under mpirun -n 1, 2, 3 with -m mpi."""

import json

import numpy as np
import pytest
import ufl
from mpi4py import MPI

from porousmold import Scene, run
from porousmold.cli import main
from porousmold.mesh.probe import PointProbe

from .support import ALUMINIUM, COARSE, PIPE, STUDIES, box, coarse_scene, nodal, simulation_of

pytestmark = pytest.mark.mpi


@pytest.fixture
def shared_folder(tmp_path):
    """Rank 0's temporary folder, on every rank."""
    return MPI.COMM_WORLD.bcast(tmp_path)


@pytest.mark.parametrize("path", [ALUMINIUM, PIPE], ids=["mold", "pipe"])
def test_heating_time_does_not_depend_on_the_number_of_ranks(path):
    alone = simulation_of(coarse_scene(path), MPI.COMM_SELF).integrate()
    together = simulation_of(coarse_scene(path), MPI.COMM_WORLD).integrate()
    assert together.recorder.heating_time == pytest.approx(alone.recorder.heating_time, rel=1e-6)
    assert together.recorder.history["mass_flow"] == pytest.approx(alone.recorder.history["mass_flow"], rel=1e-6)
    for name in alone.recorder.history.columns:
        if name.startswith("temperature_"):
            assert together.recorder.history[name] == pytest.approx(alone.recorder.history[name], abs=1e-4)
    # updates count each unknown once, whatever the ranks: all thresholds are passed alike
    assert together.problem.flow.counts.newton_iterations == alone.problem.flow.counts.newton_iterations
    assert abs(together.problem.heat.balance.imbalance) < 1e-4


def test_a_rank_may_have_no_part_of_the_bed():
    """Bed cells on one rank only, as few as there are: the others take part in every collective call all the same."""
    changes = {
        "solver.axial_cells": 2,
        "solver.first_cell": "12 mm",
        "solver.wall_cells": 8,
        "model.flow": "developed",
    }
    scene = coarse_scene({"operation.end_time": 5.0, "model.turbulence": "none", **changes})
    alone, together = (
        simulation_of(scene, communicator).integrate() for communicator in (MPI.COMM_SELF, MPI.COMM_WORLD)
    )
    assert together.recorder.history["heat_stored"][-1] == pytest.approx(
        alone.recorder.history["heat_stored"][-1], rel=1e-6
    )


def test_a_gas_that_expands_along_the_bed_on_any_number_of_ranks():
    """The developed flow's elimination follows the pressure, from sums over all ranks."""
    beads = {"bed.bead_diameter": 1e-3, "geometry.cavity_height": 0.02, "model.flow": "developed"}
    changes = {"operation.pressure_drop": None, "operation.inlet_velocity": 1.6, "operation.end_time": 20.0}
    scene = coarse_scene({"model.turbulence": "none", **beads, **changes})
    alone, together = (
        simulation_of(scene, communicator).integrate() for communicator in (MPI.COMM_SELF, MPI.COMM_WORLD)
    )
    assert max(alone.recorder.history["pressure_drop"]) > 1e5
    assert together.recorder.history["mass_flow"] == pytest.approx(alone.recorder.history["mass_flow"], rel=1e-9)
    assert together.problem.flow.counts.newton_iterations == alone.problem.flow.counts.newton_iterations


def test_the_walls_contact_on_any_number_of_ranks():
    """Beads at rest against a wall with cells of its own: the facets between two ranks count once."""
    changes = {
        "operation.pressure_drop": 0.0,
        "operation.outer_coefficient": 50.0,
        "operation.ambient_temperature": 363.15,
    }
    scene = coarse_scene(
        {"model.closures": "measured", "operation.end_time": 300.0, "model.turbulence": "none", **changes}
    )
    alone, together = (
        simulation_of(scene, communicator).integrate() for communicator in (MPI.COMM_SELF, MPI.COMM_WORLD)
    )
    assert together.recorder.history["heat_stored"][-1] == pytest.approx(
        alone.recorder.history["heat_stored"][-1], rel=1e-6
    )


@pytest.mark.parametrize("closures", ["thesis", "measured"])
def test_gmsh_mesh_on_any_number_of_ranks(closures):
    changes = {"operation.end_time": 60.0, "model.turbulence": "none", "model.closures": closures}
    scene = Scene.load(STUDIES / "mold" / "curved.toml", changes)
    alone, together = (
        simulation_of(scene, communicator).integrate() for communicator in (MPI.COMM_SELF, MPI.COMM_WORLD)
    )
    assert together.recorder.history["heat_stored"][-1] == pytest.approx(
        alone.recorder.history["heat_stored"][-1], rel=1e-6
    )


def test_points_on_different_ranks_have_the_values_of_one():
    points = [(0.5, 1.0), (0.1, 0.1), (0.9, 0.9), (0.3, 1.1), (0.6, 0.4)]
    found = []
    for communicator in (MPI.COMM_SELF, MPI.COMM_WORLD):
        domain = box((6, 5), wall=0.25, communicator=communicator)
        x, y = ufl.SpatialCoordinate(domain.mesh)
        function = nodal(domain, ufl.conditional(ufl.lt(y, 1.0 + 1e-9), 3.0 * x + y, 3.0 * x + 70.0 * y - 69.0))
        probe, nowhere = PointProbe(domain, points), PointProbe(domain, np.empty((0, 2)))
        assert nowhere(function).size == nowhere.steepness(function).size == 0
        found.append((probe(function), probe.steepness(function)))
    alone, together = found
    assert together[0] == pytest.approx(alone[0], abs=1e-12)
    assert together[1] == pytest.approx(alone[1], rel=1e-9)


def test_run_writes_one_folder_and_fields_of_the_whole_mesh(shared_folder):
    out = shared_folder / "run"
    result = run(coarse_scene({"operation.end_time": 100.0}), out, MPI.COMM_WORLD)
    MPI.COMM_WORLD.barrier()
    summary = json.loads((out / "result.json").read_text())
    assert summary["end_time"] == result.summary["end_time"]
    if MPI.COMM_WORLD.rank == 0:
        from porousmold.files.xdmf import read_fields
        from porousmold.output.pictures import draw

        nodes, _, steps = read_fields(out / "fields.xdmf")
        assert all(np.all(np.isfinite(fields["temperature"])) for fields in steps.values())
        assert nodes[:, 0].max() == pytest.approx(1.0) and nodes[:, 1].max() == pytest.approx(0.028)
        assert len(draw(out)) == 3


def test_bad_input_ends_every_rank_alike(shared_folder):
    words = [word for name, value in COARSE.items() for word in ("--set", f"{name}={value}")]
    out = shared_folder / "absent"
    assert main(["run", str(ALUMINIUM), *words, "--set", "wall.thickness=-1", "--out", str(out)]) == 2
    assert main(["run", str(ALUMINIUM), *words, "--set", "model.rev_terms=consistent", "--out", str(out)]) == 2
    assert not out.exists()
