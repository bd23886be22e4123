"""Meshes of one's own beside the cells that a straight bed would have."""

import pytest
from mpi4py import MPI

from porousmold import Scene, run
from porousmold.simulation.checking import check
from porousmold.simulation.mesh_quality import few_cells
from porousmold.simulation.meshing import build_domain
from porousmold.simulation.specs import specs_of

from ..support import ALUMINIUM, STUDIES

CURVED = STUDIES / "mold" / "curved.toml"
WATER = {
    "fluid.material": "water",
    "model.turbulence": "none",
    "model.flow": "developed",
    "wall.material": "acrylic",
    "operation.pressure_drop": None,
    "operation.inlet_velocity": "0.01 m/s",
    "operation.initial_temperature": "47 degC",
    "operation.inlet_temperature": "52 degC",
    "operation.heating_margin": "0.5 K",
}


def told(scene):
    specs = specs_of(scene)
    domain, size, _ = build_domain(specs, MPI.COMM_SELF)
    return few_cells(specs, domain, size)


@pytest.mark.parametrize(
    ("path", "settings", "expected"),
    [
        (CURVED, {}, ""),
        (CURVED, {"wall.material": "frp"}, "1 through the wall ("),
        (CURVED, {"wall.material": "frp", "solver.mesh_refinement": 2.0}, "2 through the wall ("),
        (CURVED, {"wall.material": "frp", "solver.mesh_refinement": 8.0}, ""),
        (STUDIES / "mold" / "shell.toml", {}, ""),
        (ALUMINIUM, {"wall.material": "frp"}, ""),
    ],
)
def test_cells_are_counted_along_the_flow_and_through_the_wall(path, settings, expected):
    """One cell is right through a skin of aluminium, not of plastic; a bed's own mesh is as it should be."""
    found = told(Scene.load(path, settings))
    assert expected in found and bool(found) == bool(expected)


def test_a_heating_time_on_few_cells_is_that_of_halved_ones_and_says_so():
    """Water and a wall of plastic on a mesh made for air and aluminium: some per cent off, with no front left to tell."""
    scene = Scene.load(CURVED, WATER)
    result, plain = (
        run(scene.changed({"solver.refine_in_doubt": doubt}), communicator=MPI.COMM_SELF) for doubt in (True, False)
    )
    finer = run(scene.changed({"solver.mesh_refinement": 4.0}), communicator=MPI.COMM_SELF)
    error, of_plain = (abs(each.heating_time / finer.heating_time - 1.0) for each in (result, plain))
    assert error < 0.5 * of_plain and error < result.summary["heating_time_error"]
    assert any("few cells" in text and "moved the heating time" in text for text in result.summary["warnings"])
    assert any("few cells" in text for text in plain.summary["warnings"])
    assert any("few cells" in text for text in check(scene, MPI.COMM_SELF).warnings)


@pytest.mark.mpi
def test_cells_are_counted_alike_on_all_ranks():
    specs = specs_of(Scene.load(CURVED, WATER))
    domain, size, _ = build_domain(specs, MPI.COMM_WORLD)
    assert few_cells(specs, domain, size) == told(Scene.load(CURVED, WATER))
