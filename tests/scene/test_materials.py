"""A scene's own materials, walls in layers, programmes and targets: read, refused, told in the result."""

import os

import pytest
from mpi4py import MPI

from porousmold import InputError, Scene, run
from porousmold.scene.chosen_laws import Laws
from porousmold.scene.identity import identity_of

from ..support import ALUMINIUM, STUDIES, coarse_scene

WORKSHOP = STUDIES / "mold" / "workshop.toml"
SHORT = {"operation.end_time": 5.0, "model.turbulence": "none", "model.flow": "plug"}


def with_file(tmp_path, text="[brass]\ndensity = 8530\nheat_capacity = 380\nconductivity = 110\nsource = 'sheet'\n"):
    """The aluminium mold whose wall is of a material in a file."""
    (tmp_path / "shop.toml").write_text(text)
    scene = tmp_path / "scene.toml"
    scene.write_text("[materials]\nfile = 'shop.toml'\n" + ALUMINIUM.read_text())
    return scene


def test_materials_of_a_file_are_used_and_named(tmp_path):
    scene = Scene.load(with_file(tmp_path), {"wall.material": "brass", **SHORT})
    assert Laws.of(scene).walls["wall"].conductivity(300.0) == 110.0
    told = run(scene, communicator=MPI.COMM_SELF).summary["materials"]["wall"]
    assert told["material"] == "brass" and told["properties"]["density"] == {
        "value": 8530.0,
        "unit": "kg/m^3",
        "source": "sheet",
    }


def test_another_content_is_another_identity(tmp_path):
    first = identity_of(Scene.load(with_file(tmp_path), {"wall.material": "brass"}))
    text = "[brass]\ndensity = 8531\nheat_capacity = 380\nconductivity = 110\nsource = 'sheet'\n"
    assert identity_of(Scene.load(with_file(tmp_path, text), {"wall.material": "brass"})) != first


def test_an_override_is_named_as_such():
    told = Laws.of(coarse_scene({"wall.density": 7800.0})).walls["wall"].name
    assert told == "aluminium, but density of the scene"
    whole = coarse_scene({"wall.density": 7800.0, "wall.heat_capacity": 460.0, "wall.conductivity": 40.0})
    assert Laws.of(whole).walls["wall"].name == "constants of the scene"


def test_a_layer_changes_by_its_number():
    scene = Scene.load(WORKSHOP)
    changed = scene.changed({"wall.layer[2].thickness": "6 mm", "target[1].cured": 0.5})
    assert changed.value("wall.layer[2].thickness") == pytest.approx(6e-3) and changed.value("target[1].cured") == 0.5
    assert scene.value("wall.layer[2].thickness") == pytest.approx(3e-3)
    with pytest.raises(InputError, match="from 1 to 3"):
        scene.changed({"wall.layer[4].thickness": "6 mm"})


def test_a_name_that_is_not_in_the_library_is_refused_with_the_way_to_ones_own():
    layer = {"name": "skin", "material": "rockwool", "thickness": 0.02}
    for changes in ({"wall.material": "rockwool"}, {"fluid.material": "nectar"}, {"wall.layer": [layer]}):
        with pytest.raises(InputError, match=r"or a material of your own, \[materials.NAME\]"):
            coarse_scene(changes)


def test_the_programme_is_the_set_point():
    series = Scene.load(WORKSHOP).operation.inlet_temperature
    assert series(0.0) == pytest.approx(293.15) and series(60.0) == pytest.approx(296.15)
    assert series.breakpoints[-1] == pytest.approx(160.0 / 3.0 * 60.0 + 5400.0) and series(1e5) == pytest.approx(453.15)


def test_a_stage_that_takes_its_time_without_a_change_is_a_hold(tmp_path):
    scene = tmp_path / "scene.toml"
    stages = ['to = "60 degC"\nrate = "1 K/s"', 'to = "60 degC"\nover = "1 h"', 'to = "40 degC"\nover = "10 s"']
    text = WORKSHOP.read_text().replace('blower = "blower.csv"', f'blower = "{WORKSHOP.parent / "blower.csv"}"')
    first, rest = text.split("[[operation.programme]]")[0], "[[target]]" + text.split("[[target]]", 1)[1]
    scene.write_text(first + "".join(f"[[operation.programme]]\n{stage}\n" for stage in stages) + rest)
    assert Scene.load(scene).operation.inlet_temperature.times == pytest.approx((0.0, 40.0, 3640.0, 3650.0))


def test_a_layer_of_an_extension_is_part_of_the_identity(tmp_path):
    """Another conductivity of a solid that a user's file registers is another run, within the same second too."""
    text = "import porousmold as pm\npm.register(pm.Solid('layer_of_mine', 8100, 515, {}, 'mine'))\n"
    found = []
    for value in (10, 11):
        path = tmp_path / "mine.py"
        path.write_text(text.format(value))
        os.utime(path, (1e9, 1e9))
        settings = {"extensions.python": str(path), "wall.layer[1].material": "layer_of_mine"}
        found.append(identity_of(Scene.load(WORKSHOP, settings, allow_extensions=True)))
    assert found[0] != found[1]


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"wall.layer[1].material": "wood"}, "wall.layer[1].material"),
        ({"wall.layer[2].thickness": None}, "wall.layer[2].thickness"),
        ({"wall.layer[2].name": "skin"}, "wall.layer[2].name"),
        ({"wall.layer[2].name": "fluid"}, "wall.layer[2].name"),
        ({"wall.layer[3].contact_resistance": 1e-3}, "wall.layer[3].contact_resistance"),
        ({"wall.thickness": "3 mm"}, "wall.thickness"),
        ({"model.wall": "thin"}, "model.wall"),
        ({"bed.bead_material": "prepreg"}, "bed.bead_material"),
        ({"operation.blower_efficiency": 0.0}, "operation.blower_efficiency"),
        ({"target[1].place": "insulation"}, "target[1].place"),
        ({"target[1].place": "roof"}, "target[1].place"),
        ({"target[1].above": "90 degC"}, "target[1]"),
        ({"target[2].name": "cured"}, "target[2].name"),
        ({"operation.programme[1].rate": None}, "operation.programme[1]"),
        ({"operation.inlet_temperature": "90 degC"}, "operation.inlet_temperature"),
    ],
)
def test_impossible_lists_are_refused_by_the_name_of_the_entry(changes, key):
    with pytest.raises(InputError) as refused:
        Scene.load(WORKSHOP, changes)
    assert refused.value.key == key


def test_a_setting_of_an_own_material_says_where_it_stands():
    with pytest.raises(InputError, match="stands in the scene's file"):
        Scene.load(ALUMINIUM, {"materials.tile.density": "1.2 g/cm^3"})


def test_targets_can_be_set_as_a_list_and_taken_away():
    scene = Scene.load(ALUMINIUM, {"target": [{"above": "70 degC"}]})
    assert [target.above for target in scene.target.list] == pytest.approx([343.15])
    assert scene.changed({"target": None}).target.list is None
