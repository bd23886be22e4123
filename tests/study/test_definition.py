"""Study files: what they vary, and what is refused."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from porousmold import InputError
from porousmold.study.definition import Study
from porousmold.study.parameters import case_around

from ..support import ALUMINIUM, STUDIES

HEAD = f'[study]\nscene = "{ALUMINIUM}"\n'


def load(tmp_path, text):
    path = tmp_path / "study.toml"
    path.write_text(text)
    return Study.load(path)


def test_a_grid_has_every_combination_and_one_at_a_time_each_value_alone(tmp_path):
    vary = '[vary]\nwall.thickness = ["1 mm", "2 mm"]\noperation.pressure_drop = { from = "2 kPa", to = 8000, count = 3 }\n'
    grid = load(tmp_path, HEAD + vary)
    found = [(case.scene.wall.thickness, case.scene.operation.pressure_drop(0.0)) for case in grid.cases]
    assert found == [(t, p) for t in (0.001, 0.002) for p in (2000.0, 5000.0, 8000.0)]
    single = load(tmp_path, HEAD + 'design = "one-at-a-time"\n' + vary)
    found = [(case.scene.wall.thickness, case.scene.operation.pressure_drop(0.0)) for case in single.cases]
    assert found == [(0.001, 8000.0), (0.002, 8000.0), (0.003, 2000.0), (0.003, 5000.0), (0.003, 8000.0)]


def test_a_key_may_be_quoted_as_those_of_lists_must_be(tmp_path):
    for key in ("bed.bead_diameter", '"bed.bead_diameter"'):
        study = load(tmp_path, f'{HEAD}[vary]\n{key} = ["4 mm", "5 mm"]\n')
        assert study.varied == ["bed.bead_diameter"] and len(study.cases) == 2


def test_geometric_ranges_and_listed_cases(tmp_path):
    vary = '[vary]\nwall.conductivity = { from = 0.1, to = 1000, count = 5, spacing = "geometric" }\n'
    study = load(tmp_path, HEAD + vary)
    assert [case.scene.wall.conductivity for case in study.cases] == pytest.approx([0.1, 1.0, 10.0, 100.0, 1000.0])
    cases = (
        '[[case]]\ngeometry.cavity_height = "40 mm"\nbed.bead_diameter = "4 mm"\n[[case]]\nwall.thickness = "1 mm"\n'
    )
    study = load(tmp_path, HEAD + 'design = "cases"\n[set]\nmodel.turbulence = "none"\n' + cases)
    assert [case.scene.bed.bead_diameter for case in study.cases] == [0.004, 0.005]
    assert study.varied == ["geometry.cavity_height", "bed.bead_diameter", "wall.thickness"]
    assert all(case.scene.model.turbulence == "none" for case in study.cases)


def test_cold_temperatures_of_a_range_have_their_unit(tmp_path):
    """Without one they are refused, as a user may mean degrees Celsius."""
    cold = '[vary]\noperation.inlet_temperature = { from = "80 K", to = "100 K", count = 3 }\n'
    study = load(tmp_path, HEAD + '[set]\nfluid.material = "helium"\n' + cold)
    assert [case.scene.operation.inlet_temperature(0.0) for case in study.cases] == [80.0, 90.0, 100.0]
    with pytest.raises(InputError, match="needs a unit"):
        load(tmp_path, HEAD + cold.replace('"80 K"', "80"))
    around = case_around(study.cases[0].scene, "colder", {"operation.inlet_temperature": 78.0})
    assert around.scene.operation.inlet_temperature(0.0) == 78.0


def test_a_combination_that_no_scene_can_have_is_a_case_with_a_reason(tmp_path):
    study = load(tmp_path, HEAD + '[vary]\nbed.bead_diameter = ["4 mm", "8 mm"]\n')
    assert study.cases[0].scene is not None and study.cases[1].scene is None
    assert "at least 10 bead diameters" in study.cases[1].reason


@pytest.mark.parametrize(("text", "named"), [
    ("", "study.scene"), ("[study]\nscene = 3\n", "study.scene"), ('[study]\nscene = "absent.toml"\n', "no such file"),
    (HEAD + "[vary]\n", "vary"), (HEAD + "[vary]\nwall.thicknes = [1]\n", "thickness"),
    (HEAD + "[vary]\nwal.thickness = [1]\n", "wal"), (HEAD + "[vary]\nwall.thickness = 3\n", "vary.wall.thickness"),
    (HEAD + "[vary]\nwall.thickness = []\n", "vary.wall.thickness"),
    (HEAD + "[vary]\nwall.thickness = { from = 1, to = 2 }\n", "count"),
    (HEAD + '[vary]\nwall.thickness = { from = "1 kg", to = 2, count = 2 }\n', "length"),
    (HEAD + '[vary]\nwall.thickness = { from = 0, to = 2, count = 2, spacing = "geometric" }\n', "positive"),
    (HEAD + "[vary]\nmodel.flow = { from = 0, to = 2, count = 2 }\n", "must be a list"),
    (HEAD + '[vary]\nwall.thickness = ["1 mm", "1 mm"]\n', "there twice"),
    (HEAD + 'record = ["heating_tim"]\n[vary]\nwall.thickness = [0.001]\n', "heating_tim"),
    (HEAD + 'record = ["targets.hot"]\n[vary]\nwall.thickness = [0.001]\n', "no target of any case"),
    (HEAD + 'record = [["x"]]\n[vary]\nwall.thickness = [0.001]\n', "study.record"),
    (HEAD + 'design = "random"\n[vary]\nwall.thickness = [0.001]\n', "study.design"),
    (HEAD + 'design = "cases"\n', "case"), (HEAD + "[sett]\n", "set"), ("study = [", "not valid TOML"),
    (HEAD + "[set]\nwall.thickness = -1\n[vary]\nbed.bead_diameter = [0.004]\n", "wall.thickness"),
])  # fmt: skip
def test_what_cannot_be_is_refused_by_one_line_that_names_it(tmp_path, text, named):
    with pytest.raises(InputError) as refusal:
        load(tmp_path, text)
    assert named in str(refusal.value) and "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    "path", sorted(STUDIES.glob("*/curves/*.toml")), ids=lambda path: f"{path.parts[-3]}-{path.stem}"
)
def test_shipped_studies_have_a_scene_for_every_case(path):
    study = Study.load(path)
    assert len(study.cases) >= 5 and all(case.scene is not None for case in study.cases)


VALUES = st.one_of(st.integers(-5, 10**6), st.floats(), st.text(max_size=8), st.booleans(), st.none(),
                   st.lists(st.one_of(st.integers(), st.text(max_size=5), st.floats()), max_size=3),
                   st.dictionaries(st.sampled_from(["from", "to", "count", "spacing", "x"]), st.integers(-2, 5)))  # fmt: skip
PLACES = ["study.scene", "study.design", "study.record", "vary.wall.thickness", "vary.model.flow", "set.wall.thickness",
          "vary.bed", "set.x.y", "case", "vary.geometry.kind", "study.x"]  # fmt: skip


@settings(max_examples=500)
@given(changes=st.dictionaries(st.sampled_from(PLACES), VALUES, min_size=1, max_size=3))
def test_any_study_file_is_accepted_or_refused_by_one_line(tmp_path_factory, changes):
    import tomli_w

    tables = {"study": {"scene": str(ALUMINIUM)}, "vary": {"wall": {"thickness": ["1 mm", "2 mm"]}}}
    for place, value in changes.items():
        *path, last = place.split(".")
        here = tables
        for name in path:
            here = here.setdefault(name, {})
            if not isinstance(here, dict):
                return
        if value is None:
            here.pop(last, None)
        else:
            here[last] = value
    folder = tmp_path_factory.mktemp("fuzz", numbered=True)
    try:
        study = load(folder, tomli_w.dumps(tables))
    except InputError as error:
        assert "\n" not in str(error)
        return
    assert study.cases and len({case.name for case in study.cases}) == len(study.cases)
