"""The JSON Schema of scenes accepts every scene that the program accepts, and refuses what no scene has."""

import tomllib

import jsonschema
import pytest

from porousmold import Scene
from porousmold.scene.json_schema import scene_schema

from ..support import ALUMINIUM, STUDIES

SCENES = sorted(path for path in STUDIES.rglob("*.toml") if "[geometry]" in path.read_text(encoding="utf-8"))


def test_the_schema_is_one():
    jsonschema.Draft202012Validator.check_schema(scene_schema())


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_shipped_scenes_and_their_defaults_fit(path):
    given = tomllib.loads(path.read_text(encoding="utf-8"))
    jsonschema.validate(given, scene_schema())
    if "extensions" not in given:
        jsonschema.validate(Scene.load(path).as_tables(), scene_schema())


@pytest.mark.parametrize(
    "wrong", [{"model": {"flow": "fast"}}, {"wall": {"thicknes": 1.0}}, {"bed": {"bead_diameter": -1.0}}]
)
def test_wrong_scenes_do_not(wrong):
    tables = Scene.load(ALUMINIUM).as_tables()
    for table, content in wrong.items():
        tables[table] |= content
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(tables, scene_schema())
