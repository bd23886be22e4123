"""A mold whose two walls differ: against the half cavity, mirrored, against a cavity twice as high, and input that is refused."""

import json

import pytest

from porousmold import InputError, Scene, run
from porousmold.files.tables import read_toml

from ..support import ALUMINIUM, RESIN, under_mpirun

COARSE = {"solver.axial_cells": 10, "solver.cell_growth": 1.6, "solver.largest_step": 80.0}
SKIN = {"name": "skin", "material": "aluminium", "thickness": 0.003}


def whole(layers, opposite, settings=(), **materials):
    """The aluminium mold with these walls."""
    given = {name: dict(table) for name, table in read_toml("scene", ALUMINIUM).items() if name != "wall"}
    given["geometry"]["cavity"] = "whole"
    given |= {"wall": {"layer": layers, "opposite_layer": opposite}}
    given |= {"materials": materials} if materials else {}
    return Scene(given).changed(COARSE | dict(settings))


PLUG = {"model.flow": "plug", "model.turbulence": "none"}


@pytest.mark.parametrize("flow", ["plug", "developed", "full"])
def test_two_equal_walls_are_the_half_cavity_twice(flow):
    settings = {"model.flow": flow} | ({"model.turbulence": "none"} if flow == "plug" else {})
    half = run(Scene.load(ALUMINIUM, COARSE | settings))
    both = run(whole([SKIN], [SKIN | {"name": "other"}], settings))
    assert both.heating_time == pytest.approx(half.heating_time, rel=2e-5)
    for name in ("mass_flow_initial", "mass_flow_final", "heat_by_fluid", "heat_stored"):
        assert both.summary[name] == pytest.approx(2.0 * half.summary[name], rel=2e-5)
    assert abs(both.summary["energy_imbalance"]) < 1e-5
    for place in ("bed_side", "outer"):
        assert both[f"temperature_{place}_L/2"] == pytest.approx(both[f"temperature_opposite_{place}_L/2"], abs=1e-3)


PART = {"name": "part", "material": "gfrp", "thickness": 0.004, "contact_resistance": 0.0}
THICK = {"name": "back", "material": "steel_of_ours", "thickness": 0.012, "cells": 4}
STEEL = {"density": 7850.0, "heat_capacity": 480.0, "conductivity": 45.0, "source": "of the tests"}


@pytest.mark.parametrize("flow", ["plug", "developed"])
def test_walls_that_change_places_change_nothing(flow):
    settings = {"model.flow": flow, "operation.end_time": 20000.0, "operation.heating_margin": 5.0}
    settings |= {"model.turbulence": "none"} if flow == "plug" else {}
    one = [SKIN | {"contact_resistance": 5e-4}, PART]
    found = [run(whole(*walls, settings, steel_of_ours=STEEL)) for walls in ((one, [THICK]), ([THICK], one))]
    assert found[0].heating_time is not None
    assert found[0].heating_time == pytest.approx(found[1].heating_time, rel=1e-6)
    assert found[0]["temperature_bed_side_L"] == pytest.approx(found[1]["temperature_opposite_bed_side_L"], abs=1e-4)
    assert found[0]["highest_part"] == pytest.approx(found[1]["highest_part"], abs=1e-4)
    # the thick wall is the last to be heated: later than beside a wall like itself the thin one would be
    thin = run(Scene.load(ALUMINIUM, COARSE | settings))
    assert found[0].heating_time > thin.heating_time


def test_beside_a_wall_that_stores_nothing_the_cavity_is_half_of_one_twice_as_high():
    """Plug flow and a uniform porosity know no wall: an adiabatic one is a plane of symmetry."""
    nothing = {"name": "nothing", "material": "air_like", "thickness": 1e-4}
    air_like = {"density": 1e-3, "heat_capacity": 1.0, "conductivity": 1e-3, "source": "of the tests"}
    uniform = PLUG | {"bed.porosity_model": "constant"}
    settings = uniform | {"operation.heated_place": "skin"}
    one_sided = run(whole([SKIN], [nothing], settings, air_like=air_like))
    high = run(Scene.load(ALUMINIUM, COARSE | uniform | {"geometry.cavity_height": 0.1}))
    assert one_sided.heating_time == pytest.approx(high.heating_time, rel=1e-3)  # other cells across
    assert one_sided.summary["heat_stored"] == pytest.approx(high.summary["heat_stored"], rel=1e-3)


def test_a_part_on_one_side_cures_and_is_a_target():
    part = {"name": "part", "material": "resin", "thickness": 0.004}
    scene = whole([SKIN, part], [SKIN | {"name": "back"}], PLUG | {"operation.inlet_temperature": 430.0}, resin=RESIN)
    targets = {
        "target": [
            {"name": "cured", "place": "part", "cured": 0.5},
            {"name": "back warm", "place": "back", "above": 380.0},
        ]
    }
    tables = {name: dict(table) for name, table in scene.as_tables().items()} | targets
    result = run(Scene(tables))
    assert set(result.summary["targets"]) == {"cured", "back warm"} and None not in result.summary["targets"].values()
    assert 0.0 <= result["cure_part"][0] < 0.05 and result["cure_part"][-1] >= 0.5
    assert "highest_back" in result.history and abs(result.summary["energy_imbalance"]) < 1e-5


def test_losses_leave_through_both_outer_walls():
    """At a steady state what the fluid gives leaves, and a better insulated back is hotter outside than the front is."""
    losses = {
        "operation.outer_coefficient": 15.0,
        "operation.ambient_temperature": 298.15,
        "operation.end_time": 20000.0,
    }
    insulated = [SKIN | {"name": "back"}, {"name": "wool", "material": "mineral_wool", "thickness": 0.02}]
    result = run(whole([SKIN], insulated, PLUG | losses))
    assert result["temperature_outer_L/2"][-1] > result["temperature_opposite_outer_L/2"][-1] + 10.0
    assert result["temperature_opposite_bed_side_L/2"][-1] > result["temperature_bed_side_L/2"][-1]
    assert abs(result.summary["energy_imbalance"]) < 1e-5


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"geometry.cavity": "half"}, "geometry.cavity = 'half': must be 'whole' with \\[\\[wall.opposite_layer\\]\\]"),
        ({"geometry.width": 0.5}, "geometry.width = 0.5: has no place with geometry.cavity 'whole'"),
        ({"model.wall": "thin"}, "model.wall = 'thin': must be 'conjugate' with layers"),
        (
            {"wall.opposite_layer[1].name": "skin"},
            "wall.opposite_layer\\[1\\].name = 'skin': must be a name of its own: wall.layer\\[1\\] has it",
        ),
        ({"wall.opposite_layer[1].contact_resistance": 1e-3}, "needs a layer behind it"),
    ],
)
def test_what_does_not_fit_is_refused(settings, message):
    with pytest.raises(InputError, match=message):
        whole([SKIN], [SKIN | {"name": "other"}]).changed(settings)


def test_a_whole_cavity_needs_its_other_wall():
    with pytest.raises(
        InputError, match=r"geometry.cavity = 'whole': needs the other wall's layers, \[\[wall.opposite_layer"
    ):
        Scene.load(ALUMINIUM, {"geometry.cavity": "whole"})


def test_the_scene_as_run_gives_the_same_again(tmp_path):
    scene = whole([SKIN], [SKIN | {"name": "other"}], PLUG)
    first = run(scene, tmp_path / "run")
    again = run(Scene.load(tmp_path / "run" / "scene.toml"))
    assert again.heating_time == first.heating_time


@pytest.mark.slow
def test_two_ranks_give_the_same(tmp_path):
    scene = whole([SKIN], [SKIN | {"name": "other", "thickness": 0.006}], {"model.flow": "developed"})
    here = run(scene, tmp_path / "one")
    words = ["-m", "porousmold", "run", str(tmp_path / "one" / "scene.toml"), "--out", str(tmp_path / "two"), "--quiet"]
    done = under_mpirun(2, *words)
    assert done.returncode == 0, done.stderr
    there = json.loads((tmp_path / "two" / "result.json").read_text())
    assert there["heating_time"] == pytest.approx(here.heating_time, rel=1e-8)
