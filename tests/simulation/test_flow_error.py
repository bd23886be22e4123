"""What is told of a flow whose cells are too coarse, beside the same flow on finer ones."""

import pytest
from mpi4py import MPI

from porousmold import Scene, run

from ..support import STUDIES

CURVED = STUDIES / "mold" / "curved.toml"
BED = """length = 0.2; height = 0.05; port = {port}; n = {cells};
Point(1) = {{0, 0, 0}}; Point(2) = {{length, 0, 0}}; Point(3) = {{0, port, 0}}; Point(4) = {{length, port, 0}};
Point(5) = {{0, height, 0}}; Point(6) = {{length, height, 0}};
Line(1) = {{1, 2}}; Line(2) = {{2, 4}}; Line(3) = {{3, 4}}; Line(4) = {{1, 3}};
Line(5) = {{3, 5}}; Line(6) = {{5, 6}};
Line(7) = {{4, 6}};
Curve Loop(1) = {{1, 2, -3, -4}}; Plane Surface(1) = {{1}};
Curve Loop(2) = {{3, 7, -6, -5}}; Plane Surface(2) = {{2}};
Point(7) = {{0, height + 0.003, 0}}; Point(8) = {{length, height + 0.003, 0}};
Line(8) = {{5, 7}}; Line(9) = {{7, 8}}; Line(10) = {{6, 8}}; Curve Loop(3) = {{6, 10, -9, -8}}; Plane Surface(3) = {{3}};
Transfinite Curve {{1, 3, 6, 9}} = 8 * n + 1; Transfinite Curve {{8, 10}} = 2;
Transfinite Curve {{2, 4}} = n + 1; Transfinite Curve {{5, 7}} = 2 * n + 1;
Transfinite Surface {{1, 2, 3}}; Recombine Surface {{1, 2, 3}};
Physical Surface("wall") = {{3}}; Physical Curve("outer") = {{9}};
Physical Surface("bed") = {{1, 2}}; Physical Curve("inlet") = {{{inlet}}}; Physical Curve("outlet") = {{2, 7}};
Physical Curve("interface") = {{6}}; Physical Curve("symmetry") = {{1}};
"""


def flow_through(path, cells, *, is_port, flow):
    """Summary of a bed that is fed through a third of its end, or through all of it."""
    inlet, port = ("4", 'Physical Curve("side") = {5};') if is_port else ("4, 5", "")
    path.write_text(BED.format(port=0.0167, cells=cells, inlet=inlet) + port)
    changes = {
        "geometry.mesh": str(path),
        "bed.porosity_model": "constant",
        "bed.bulk_porosity": 0.4,
        "model.flow": flow,
        "model.turbulence": "none",
        "operation.end_time": 1.0,
        "operation.pressure_drop": 200.0,
        "output.pictures": False,
        "solver.refine_in_doubt": False,
    }
    return run(Scene.load(CURVED, changes), communicator=MPI.COMM_SELF).summary


@pytest.mark.parametrize("flow", ["developed", "full"])
def test_cells_too_coarse_for_a_port_are_told(tmp_path, flow):
    coarse, fine = (flow_through(tmp_path / f"{cells}.geo", cells, is_port=True, flow=flow) for cells in (2, 16))
    error = abs(coarse["mass_flow_initial"] / fine["mass_flow_initial"] - 1.0)
    assert error < coarse["mass_flow_error"] < 0.08 and fine["mass_flow_error"] < 0.4 * coarse["mass_flow_error"]
    assert any("cells are too coarse where the flow gathers" in text for text in coarse["warnings"])
    assert not any("where the flow gathers" in text for text in fine["warnings"])


def test_a_straight_flow_is_not_called_coarse(tmp_path):
    straight = flow_through(tmp_path / "straight.geo", 2, is_port=False, flow="developed")
    assert straight["mass_flow_error"] < 1e-3
    assert not any("where the flow gathers" in text for text in straight["warnings"])
