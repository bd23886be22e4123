"""Elasticities against what physics says they are."""

import pytest

from porousmold import Scene
from porousmold.cli import main
from porousmold.study import sensitivity
from porousmold.study.quantity import Quantity
from porousmold.study.running import Row
from porousmold.study.sensitivity import COARSER, cases_around, coarser, elasticities, not_varied, parameters_of, write

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


def test_properties_of_beads_that_melt_are_scaled_and_not_replaced(tmp_path, monkeypatch):
    """A table with a peak at the middle became that value throughout: 10 times the heat, and the target was out of reach."""
    table = tmp_path / "wax.csv"
    table.write_text("temperature [degC],heat_capacity [J/(kg*K)]\n0,2000\n45,2000\n50,40000\n55,2000\n200,2000\n")
    monkeypatch.setattr(sensitivity, "PARAMETERS", ("bed.bead_density", "bed.bead_heat_capacity"))
    monkeypatch.setattr(sensitivity, "_given_quantities", lambda scene: [])
    wax = {"density": 900.0, "conductivity": 0.3, "heat_capacity": {"table": str(table), "source": "drawn"}}
    scene = Scene(
        {
            "geometry": {"kind": "mold", "length": 0.2, "cavity_height": 0.05},
            "bed": {"bead_diameter": 5e-3, "bead_material": "wax"},
            "materials": {"wax": wax},
            "model": {"flow": "plug", "wall": "insulated"},
            "operation": {"initial_temperature": "20 degC", "inlet_temperature": "80 degC", "inlet_velocity": 0.5,
                          "end_time": "8 h"},
            "target": [{"name": "molten", "place": "bed", "above": "70 degC"}],
        }
    )  # fmt: skip
    quantity = Quantity("targets.molten", "s")
    density, heat_capacity = (entry.value for entry in elasticities(scene, tmp_path / "cases", quantity))
    assert density == pytest.approx(heat_capacity, abs=2e-3)
    assert density == pytest.approx(1.0, abs=0.02)
    settings = [case.settings["bed.bead_heat_capacity"] for case in cases_around(scene)[2:]]
    assert settings == ["105 %", "95.2380952381 %"]


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


def test_every_quantity_that_a_scene_gives_is_varied_or_named():
    """Temperatures count from the initial one: one that is the same, a series and thresholds of phases are named."""
    phases = [{"temperature": "100 degC", "pressure_drop": "500 Pa", "until_outlet_above": "60 degC", "duration": "2 h"},
              {"temperature": "15 degC", "pressure_drop": "300 Pa", "duration": "1 h"}]  # fmt: skip
    loss = {"model.wall": "conjugate", "operation.outer_coefficient": 8.0, "operation.ambient_temperature": "5 degC"}
    scene = Scene.load(ALUMINIUM, {"model.drag_factor": 1.1, "bed.bead_conductivity": "90 W/(m*K)", **loss})
    found = parameters_of(scene)
    assert {"model.drag_factor", "bed.bead_conductivity", "operation.ambient_temperature"} <= set(found)
    assert not not_varied(scene) and "operation.initial_temperature" not in found
    same = scene.changed({"operation.ambient_temperature": scene.operation.initial_temperature})
    assert not_varied(same) == ["operation.ambient_temperature"]
    drives = {"operation.phase": phases, "operation.pressure_drop": None, "operation.inlet_temperature": None}
    assert not_varied(scene.changed(drives)) == ["operation.phase[1].until_outlet_above"]
    times = {"operation.inlet_temperature": lambda time: 300.0 + 0.1 * min(time, 500.0)}
    assert not_varied(scene.changed(times)) == ["operation.inlet_temperature"]


def test_a_temperature_is_varied_as_its_difference_from_the_initial_one():
    scene = Scene.load(ALUMINIUM, {"operation.outer_coefficient": 8.0, "operation.ambient_temperature": 263.15})
    initial = scene.operation.initial_temperature
    cases = {case.name: case.settings for case in cases_around(scene, 0.05)}
    up = cases["operation.ambient_temperature,up"]["operation.ambient_temperature"]
    assert up - initial == pytest.approx(1.05 * (263.15 - initial))


def test_at_a_bound_the_other_side_gives_the_elasticity(tmp_path, monkeypatch):
    monkeypatch.setattr(sensitivity, "PARAMETERS", ())
    monkeypatch.setattr(sensitivity, "_given_quantities", lambda scene: ["bed.emissivity", "operation.pressure_drop"])
    scene = Scene.load(ALUMINIUM, CHEAP | {"bed.emissivity": 0.98, "model.bead_conduction": "zehner-bauer-schluender"})
    found = {entry.parameter: entry for entry in elasticities(scene, tmp_path)}
    assert not found["operation.pressure_drop"].reason and "of one side alone" in found["bed.emissivity"].reason
    assert found["bed.emissivity"].value is not None
    assert elasticities(scene, tmp_path / "stopped", stop=lambda: True) is None


def test_elasticities_of_an_answer_in_doubt_say_so(tmp_path, monkeypatch):
    """A target that was kept by a hundredth of a kelvin had elasticities of 2.5 for 0.4."""
    monkeypatch.setattr(sensitivity, "PARAMETERS", ())
    monkeypatch.setattr(sensitivity, "_given_quantities", lambda scene: ["operation.pressure_drop"])
    doubt = "target 'hot' was kept by only 0.005 K at 1893 s, ...: it may as well be lost there"
    monkeypatch.setattr(sensitivity, "run_study", lambda study, *_, **__: [
        Row(case, "done", doubt, {"heating_time": 100.0}) for case in study.cases
    ])  # fmt: skip
    (entry,) = elasticities(Scene.load(ALUMINIUM, CHEAP), tmp_path)
    assert entry.value == 0.0 and entry.reason == "in doubt (table.csv says why)"


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
