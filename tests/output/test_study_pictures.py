"""Studies draw themselves: a picture for one key, two, and more; the terminal's has the curve's ends."""

import pytest

from porousmold.output.study_pictures import _Study, draw_study, plot_in_terminal


def study(**values):
    """Entries and head of a study over all combinations of the values; its record is a function of them."""
    names, cases = list(values), [{}]
    for name, several in values.items():
        cases = [{**case, name: value} for case in cases for value in several]
    numbers = [[value if isinstance(value, float) else len(str(value)) for value in case.values()] for case in cases]
    records = [{"status": "done", "heating_time": 1000.0 + 100.0 * sum(found), "reason": None} for found in numbers]
    head = [f"{name} [m]" for name in names] + ["status", "heating_time [s]", "reason"]
    return [case | record for case, record in zip(cases, records, strict=True)], head


@pytest.mark.parametrize(
    ("values", "pictures"),
    [
        ({"a": [1.0, 2.0, 3.0]}, ["curves.png"]),
        ({"a": [1.0, 2.0, 3.0], "b": ["one", "other"]}, ["curves.png"]),
        ({"a": [1.0, 2.0, 3.0], "b": [0.1, 0.2]}, ["curves.png", "map.png"]),
        ({"a": [1.0, 2.0], "b": [0.1, 0.2], "c": ["one", "other"]}, ["parallel.png"]),
        ({"a": ["one", "other", "third"]}, []),
        ({"a": [1.0, 2.0]}, []),
    ],
)
def test_the_number_of_keys_decides_what_is_drawn(values, pictures, tmp_path):
    drawn = draw_study(tmp_path, *study(**values))
    assert [path.name for path in drawn] == pictures
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in drawn)


def test_failed_cases_and_constant_keys_are_left_out(tmp_path):
    entries, head = study(a=[1.0, 2.0, 3.0, 4.0], b=[0.5])
    entries[2] |= {"status": "failed", "heating_time": None, "reason": "no flow"}
    assert [path.name for path in draw_study(tmp_path, entries, head)] == ["curves.png"]


def test_a_case_without_the_first_record_is_in_the_pictures_of_the_others(tmp_path):
    """A study of which half does not meet a target was drawn as if it had no such cases, and a key less."""
    entries, head = study(a=[1.0, 2.0, 3.0], b=["one", "other"])
    for entry in entries:
        entry |= {"cost": 5.0, "reason": entry.pop("reason")}
        entry["heating_time"] = None if entry["b"] == "one" else entry["heating_time"]
    drawn = _Study(entries, [*head[:-1], "cost [1]", "reason"])
    assert drawn.varied == ["a", "b"] and drawn.records == ["heating_time", "cost"]
    assert len(drawn.having("heating_time")) == 3 and len(drawn.having("cost")) == 6
    assert "without 3 of 6 cases" in drawn.without("heating_time") and not drawn.without("cost")
    assert [path.name for path in draw_study(tmp_path, entries, head)] == ["curves.png"]


def test_the_terminals_picture_has_title_axis_and_range():
    text = plot_in_terminal(*study(a=[1.0, 2.0, 4.0]))
    assert "heating_time [s]" in text and "a [m]" in text
    assert "1100" in text and "1400" in text
    assert plot_in_terminal(*study(a=[1.0])) == ""
