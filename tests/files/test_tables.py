"""Tables that the user gives, and those that spreadsheets read."""

import os
from pathlib import Path

import pytest

from porousmold.errors import InputError
from porousmold.files.tables import LARGEST_TEXT, read_columns, read_rows, read_toml, text_cells


@pytest.mark.parametrize(
    "text", ["a = " + "[" * 5000 + "]" * 5000, "a = " + "[" * 100 + "]" * 100, ".".join("a" * 20000) + " = 1"]
)
def test_nested_toml_is_refused_in_one_line(tmp_path, text):
    path = tmp_path / "deep.toml"
    path.write_text(text)
    with pytest.raises(InputError, match="nested") as refusal:
        read_toml("scene", path)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("[wall.layer]\na = 1\n[wall.layer]\na = 2\n", r"two brackets: \[\[wall.layer\]\]"),
        ("a = 4 mm\n", "need quotes"),
    ],
)
def test_toml_that_cannot_be_read_is_refused_with_what_to_look_at(tmp_path, text, hint):
    path = tmp_path / "scene.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=hint):
        read_toml("scene", path)


def test_a_pipe_and_a_file_of_any_size_are_not_read(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with (tmp_path / "sparse").open("wb") as file:
        file.truncate(LARGEST_TEXT + 1)
    for name, reason in (("pipe", "regular file"), ("sparse", "smaller")):
        for read in (read_toml, read_rows):
            with pytest.raises(InputError, match=reason):
                read("key", tmp_path / name)
    with pytest.raises(InputError, match="regular file"):
        read_toml("key", Path("/dev/zero"))


@pytest.mark.parametrize("cell", ["=cmd|' /C calc'!A0", "@SUM(1)", "+1+cmd|' /C calc'!A0", "-2+3", " =1"])
def test_what_a_spreadsheet_would_take_for_a_formula_is_text(cell):
    assert text_cells([cell]) == [f"'{cell}"]


def test_numbers_with_units_and_names_stay_as_they_are():
    cells = ["-9.81 m/s^2", "-5", "+2.5e-3", "aluminium", -3.0, None, "5 mm", "a=b"]
    assert text_cells(cells) == cells


GOOD = "time [s],inlet [degC]\n0,25.0\n60,55.5\n120,80.25\n180,90.0\n"
SAME = {
    "semicolons and decimal commas": GOOD.replace(",", ";").replace(".", ","),
    "tabs and decimal commas": GOOD.replace(",", "\t").replace(".", ","),
    "separators at the ends": GOOD.replace(",", ";").replace("\n", ";\n"),
    "an index": '"",'
    + GOOD.replace("\n0,", "\n0,0,").replace("\n60,", "\n1,60,").replace("\n120", "\n2,120").replace("\n18", "\n3,18"),
    "units in parentheses": GOOD.replace("[", "(").replace("]", ")"),
    "times of day": GOOD.replace("\n0,", "\n0:00:00,")
    .replace("\n60,", "\n0:01:00,")
    .replace("\n120,", "\n0:02:00,")
    .replace("\n180,", "\n0:03,"),
    "dates": GOOD.replace("\n0,", "\n2024-03-05 10:00:00,")
    .replace("\n60,", "\n2024-03-05T10:01:00,")
    .replace("\n120,", "\n2024-03-05 10:02:00.0,")
    .replace("\n180,", "\n2024-03-05 10:03:00,"),
    "a separator in a name": GOOD.replace("inlet [degC]", '"inlet; top [degC]"'),
}


@pytest.mark.parametrize("writing", SAME)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_the_same_table_in_the_writings_of_loggers(tmp_path, writing, encoding):
    path = tmp_path / "log.csv"
    text = SAME[writing]
    if writing == "times of day":
        text = text.replace("0:03,", "0:03:00,")
    path.write_text(text.replace("degC", "°C"), encoding=encoding)
    columns = read_columns("key", path)
    assert columns.times().tolist() == [0.0, 60.0, 120.0, 180.0]
    assert columns.in_si(1, "K") == pytest.approx([298.15, 328.65, 353.4, 363.15])
    assert columns.gaps == 0


def test_times_of_day_before_a_name_with_a_unit(tmp_path):
    """A time without a unit and one name with one: the separator is what makes two columns of them."""
    path = tmp_path / "log.csv"
    path.write_text("time, temperature [degC]\n10:00:00, 20\n10:01:00, 21.5\n")
    columns = read_columns("key", path)
    assert columns.times().tolist() == [36000.0, 36060.0] or columns.times().tolist() == [0.0, 60.0]
    assert columns.in_si(1, "K") == pytest.approx([293.15, 294.65])


@pytest.mark.parametrize("gap", ["", "NaN", "n/a", "--"])
def test_short_gaps_are_interpolated_and_counted(tmp_path, gap):
    path = tmp_path / "log.csv"
    path.write_text(GOOD.replace("80.25", gap))
    columns = read_columns("key", path)
    assert columns.gaps == 1
    assert columns.values[2, 1] == pytest.approx(0.5 * (55.5 + 90.0))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (GOOD.replace("25.0", ""), "row 2 has no number"),
        (GOOD.replace("90.0", "nan"), "row 5 has no number"),
        ("t [s],a [K]\n0,1\n" + "".join(f"{i},\n" for i in range(1, 7)) + "7,1\n", "row 3 has no number"),
        (GOOD.replace("\n60,", "\n,"), "row 3 has no number"),
        (GOOD.replace("80.25", "OVERRANGE"), "'OVERRANGE', which is no number"),
        (GOOD.replace("80.25", "inf"), "'inf', which is no number"),
        ("Logger ABC;serial 1\n" + GOOD, "needs a head with units"),
        (GOOD.replace("\n60,", "\n0:01:00,"), "'0:01:00', which is no number"),
        (GOOD.replace("\n0,", "\n2024-03-05,"), "'60', which is no date"),
        (GOOD.replace("\n0,", "\n0:00,"), "'60', which is no time"),
        (GOOD.replace("\n60,55.5", "\n60;55.5"), "are separators mixed"),
    ],
)
def test_what_a_table_may_not_hold(tmp_path, text, reason):
    path = tmp_path / "log.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=reason):
        read_columns("key", path)
