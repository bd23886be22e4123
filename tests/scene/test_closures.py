"""Named sets of closures: what they give, what wins over them, and what departs."""

import pytest

from porousmold.errors import InputError
from porousmold.scene.chosen_laws import Laws, width_ratio
from porousmold.scene.closures import CLOSURES, departures
from porousmold.scene.scene import Scene

from ..support import ALUMINIUM, PIPE


@pytest.mark.parametrize("name", CLOSURES)
def test_a_set_gives_what_the_scene_leaves_open(name):
    scene = Scene.load(ALUMINIUM, {"model.closures": name})
    for full_name, value in CLOSURES[name].items():
        table, key = full_name.split(".")
        assert getattr(getattr(scene, table), key) == value
    assert departures(scene) == {}


def test_the_default_is_the_thesis():
    assert Scene.load(ALUMINIUM).as_tables() == Scene.load(ALUMINIUM, {"model.closures": "thesis"}).as_tables()


def test_a_key_that_is_set_wins_and_is_told():
    given = {"model.closures": "measured", "model.drag": "erdim", "bed.bulk_porosity": 0.42}
    scene = Scene.load(ALUMINIUM, given)
    assert departures(scene) == {"model.drag": "erdim", "bed.bulk_porosity": 0.42}
    assert Laws.of(scene).dispersion.source.startswith("Winterberg")
    again = Scene(scene.as_tables())
    assert again.as_tables() == scene.as_tables() and departures(again) == departures(scene)


def test_a_changed_set_changes_what_was_left_open():
    scene = Scene.load(ALUMINIUM, {"model.drag": "erdim"})
    changed = scene.changed({"model.closures": "measured"})
    assert changed.model.bead_conduction == "zehner-bauer-schluender" and changed.model.drag == "erdim"


def test_unknown_sets_are_refused():
    with pytest.raises(InputError, match=r"model\.closures"):
        Scene.load(ALUMINIUM, {"model.closures": "best"})
    with pytest.raises(InputError, match=r"model\.closures"):
        Scene.load(ALUMINIUM, {"model.closures": 3})


def test_flattening_is_the_materials_unless_given():
    assert Laws.of(Scene.load(ALUMINIUM, {"bed.bead_material": "steel"})).beads.contact_flattening == 0.0013
    given = Scene.load(ALUMINIUM, {"bed.bead_material": "steel", "bed.contact_flattening": 0.01})
    assert Laws.of(given).beads.contact_flattening == 0.01


def test_beads_are_counted_across_the_hydraulic_diameter():
    """D/d of a pipe, 2 H/d of a gap, 2 H W/[(H + W) d] between four walls."""
    assert width_ratio(Scene.load(PIPE)) == pytest.approx(0.1016 / 5e-3)
    assert width_ratio(Scene.load(ALUMINIUM)) == pytest.approx(20.0)
    four = Scene.load(ALUMINIUM, {"geometry.cavity_height": 0.1, "geometry.width": 0.2})
    assert width_ratio(four) == pytest.approx(2 * 0.1 * 0.2 / 0.3 / 5e-3)
