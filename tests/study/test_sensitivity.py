"""Elasticities against what physics says they are."""

import pytest

from porousmold import Scene
from porousmold.cli import main
from porousmold.study import sensitivity
from porousmold.study.quantity import Quantity
from porousmold.study.sensitivity import COARSER, coarser, elasticities, parameters_of, write

from ..support import ALUMINIUM, PIPE, STUDIES

CHEAP = {"model.flow": "plug", "model.turbulence": "none", "solver.axial_cells": 6,
         "solver.mesh_refinement": 1.0 / COARSER["solver.mesh_refinement"],
         "solver.step_refinement": 1.0 / COARSER["solver.step_refinement"]}  # fmt: skip


def test_heat_stored_in_beads_and_wall_sets_the_time_scale(tmp_path):
    """Twice all solid heat capacity is twice the time (the fluid's own is a thousandth): the elasticities add up to 1, and
    density and heat capacity, which enter as a product, have the same one."""
    found = {e.parameter: e for e in elasticities(Scene.load(ALUMINIUM, CHEAP), tmp_path)}
    assert found["bed.bead_density"].value == pytest.approx(found["bed.bead_heat_capacity"].value, abs=1e-4)
    assert found["wall.density"].value == pytest.approx(found["wall.heat_capacity"].value, abs=1e-4)
    assert found["bed.bead_density"].value + found["wall.density"].value == pytest.approx(1.0, abs=0.01)
    assert found["operation.pressure_drop"].value < 0.0 < found["geometry.length"].value
    assert write(list(found.values()), tmp_path, Quantity("heating_time", "s")).is_file()
    assert (tmp_path / "elasticities.json").is_file()


def test_parameters_are_those_that_the_scene_has():
    mold, pipe = (parameters_of(Scene.load(path)) for path in (ALUMINIUM, PIPE))
    assert mold["wall.conductivity"] == 237.0 and "geometry.diameter" not in mold
    assert pipe["geometry.diameter"] == pytest.approx(0.1016) and "geometry.cavity_height" not in pipe
    assert pipe["wall.conductivity"] == pytest.approx(0.1977, abs=1e-3)  # acrylic in the middle of the temperatures
    assert not [
        name for name in parameters_of(Scene.load(STUDIES / "mold" / "curved.toml")) if name.startswith("wall.")
    ]
    insulated = Scene.load(ALUMINIUM, {"model.wall": "insulated"})
    assert not [name for name in parameters_of(insulated) if name.startswith("wall.")]


def test_elasticities_are_taken_on_coarser_cells():
    assert coarser(Scene.load(ALUMINIUM)).solver.mesh_refinement == 0.7
    assert coarser(Scene.load(ALUMINIUM, {"solver.accuracy": 0.01})).solver.accuracy == 0.01
    curved = coarser(Scene.load(STUDIES / "mold" / "curved.toml"))
    assert curved.solver.step_refinement == 0.5 and curved.solver.mesh_refinement == 1.0


def test_coarser_cells_give_the_elasticities_of_the_scene(tmp_path, monkeypatch):
    names = ("operation.pressure_drop", "wall.thickness")
    monkeypatch.setattr(sensitivity, "PARAMETERS", names)
    coarse = {e.parameter: e.value for e in elasticities(Scene.load(ALUMINIUM), tmp_path / "coarse")}
    monkeypatch.setattr(sensitivity, "COARSER", {})
    own = {e.parameter: e.value for e in elasticities(Scene.load(ALUMINIUM), tmp_path / "own")}
    for name in names:
        assert coarse[name] == pytest.approx(own[name], abs=0.01)


def test_impossible_steps_are_refused(capsys):
    assert main(["sensitivity", str(ALUMINIUM), "--step", "2"]) == 2
    assert main(["sensitivity", "absent.toml"]) == 2
    assert "--step" in capsys.readouterr().err
