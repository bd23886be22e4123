"""What is recorded: a quantity is an entry of one table."""

import pytest
from mpi4py import MPI

from porousmold.output import quantities
from porousmold.output.quantities import Quantity

from ..support import coarse_scene, simulation_of

PLUG = {"model.flow": "plug", "model.turbulence": "none"}


def test_a_quantity_is_added_by_one_entry(monkeypatch):
    """The largest difference between fluid and beads: within the range of temperatures, and gone when all is warm."""

    def lag(now):
        fluid, beads = now.problem.temperature, now.problem.bead_temperature
        return now.problem.bed.mean(fluid) - now.problem.bed.mean(beads)

    entry = Quantity(r"\Delta T", "mean temperature of the fluid above that of the beads", "K", value=lag)
    monkeypatch.setattr(quantities, "QUANTITIES", {**quantities.QUANTITIES, "lag_of_beads": entry})
    history = simulation_of(coarse_scene(PLUG), MPI.COMM_SELF).integrate().recorder.history
    assert history.units["lag_of_beads"] == "K" and 0.05 < max(history["lag_of_beads"]) < 65.0
    assert abs(history["lag_of_beads"][-1]) < 0.1 * max(history["lag_of_beads"])


def test_signs_and_places_count_from_the_inlet_where_the_flow_reverses():
    changes = {**PLUG, "operation.pressure_drop": ([0.0, 60.0, 60.001, 200.0], [8000.0, 8000.0, -8000.0, -8000.0])}
    scene = coarse_scene({**changes, "operation.return_temperature": "90 degC", "operation.end_time": "150 s"})
    history = simulation_of(scene, MPI.COMM_SELF).integrate().recorder.history
    assert history["mass_flow"][1] > 0.0 > history["mass_flow"][-1]
    assert history["pressure_drop"][-1] == pytest.approx(-8000.0, rel=0.02)
    assert history["hottest_place"][-1] == pytest.approx(1.0, abs=0.1)  # where it enters now
    assert {name.split("_")[0] for name in history} >= {"temperature", "lowest", "highest", "deficit"}
