"""Features of a scene: their keys, their values, and what a command that uses some of them refuses."""

import tomllib
from dataclasses import fields
from pathlib import Path

import pytest

import porousmold.scene.features as features
from porousmold.errors import InputError
from porousmold.scene.features import FEATURES, KEYS, Feature, require_used
from porousmold.scene.features.drive import Drive
from porousmold.scene.features.numerics import Accuracy
from porousmold.scene.features.outer_wall import OuterWall
from porousmold.scene.scene import Scene
from porousmold.scene.thinning import with_thinned_series

from ...support import ALUMINIUM

ROOMS = Path(features.__file__).parent


def test_every_feature_of_a_room_is_in_the_list_and_has_every_key_once():
    named = {cls for cls in Feature.__subclasses__() if cls.__module__.startswith(features.__name__)}
    assert named == set(FEATURES)
    assert sum(len(feature.keys()) for feature in FEATURES) == sum(len(keys) for keys in KEYS.values())


@pytest.mark.parametrize("feature", FEATURES, ids=lambda feature: feature.__name__)
def test_a_feature_has_the_scenes_values(feature):
    scene = Scene.load(ALUMINIUM)
    of_scene = feature.of(scene)
    for one in fields(feature):
        assert getattr(of_scene, one.name) == scene.value(one.metadata["full name"])


def test_fast_series_are_thinned_for_the_steps_in_time_alone():
    times = [0.5 * number for number in range(2000)]
    series = (times, [8000.0 + 10.0 * (number % 2) for number in range(2000)])
    scene = Scene.load(ALUMINIUM, {"operation.pressure_drop": series, "operation.gravity": 9.81})
    thinned = with_thinned_series(scene)
    assert len(Drive.of(scene).pressure_drop.times) == 2000 and len(Drive.of(thinned).pressure_drop.times) < 600
    assert Drive.of(thinned).gravity == 9.81 and Drive.of(thinned).mass_flow is None


def test_film_of_an_outer_wall_is_convection_and_radiation():
    """5 + 4 x 0.9 x 5.670374e-8 x 300^3 = 10.5 W/m2/K."""
    changes = {"operation.outer_coefficient": 5.0, "operation.outer_emissivity": 0.9}
    outer = OuterWall.of(Scene.load(ALUMINIUM, {**changes, "operation.ambient_temperature": "20 degC"}))
    assert outer.film(300.0) == pytest.approx(5.0 + 4 * 0.9 * 5.670374419e-8 * 300.0**3, rel=1e-9)
    assert outer.exchanges and not OuterWall.of(Scene.load(ALUMINIUM)).exchanges


def test_a_scene_as_a_run_writes_it_can_be_given_again_with_an_accuracy():
    """It lists every refinement with its default."""
    scene = Scene.load(ALUMINIUM, {"solver.accuracy": 0.01, "solver.mesh_refinement": 1.0})
    assert Accuracy.of(scene).wanted == 0.01
    with pytest.raises(InputError, match=r"chosen by solver\.accuracy"):
        scene.changed({"solver.mesh_refinement": 1.5})


def test_a_profile_of_the_porosity_goes_with_either_set_of_closures():
    """The bulk porosity of a set is no value that the scene gives."""
    profile = ALUMINIUM.parent.parent / "profiles" / "cylinder_ratio_20.csv"
    scene = Scene.load(ALUMINIUM, {"bed.porosity_profile": str(profile), "model.closures": "measured"})
    assert not scene.differs_from_default("bed.bulk_porosity")
    with pytest.raises(InputError, match=r"beside bed\.porosity_profile"):
        scene.changed({"bed.bulk_porosity": 0.37})


def test_keys_that_a_command_would_not_use_are_refused_those_of_lists_too():
    layer = {"material": "steel", "thickness": "2 mm", "heat_source": 5e6}
    scene = Scene(tomllib.loads(ALUMINIUM.read_text()) | {"wall": {"layer": [layer]}})
    used = {f"{table}.{name}" for table, keys in KEYS.items() for name in keys}
    used |= {"wall.layer.name", "wall.layer.material", "wall.layer.thickness"}
    with pytest.raises(InputError, match=r"wall\.layer\[1\]\.heat_source = .* has no effect on a stove"):
        require_used(scene, used, "a stove")
    require_used(scene, used | {"wall.layer.heat_source"}, "a stove")
    with pytest.raises(InputError, match=r"operation\.pressure_drop"):
        require_used(scene, used - {"operation.pressure_drop"} | {"wall.layer.heat_source"}, "a stove")
