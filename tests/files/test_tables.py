"""Tables that the user gives, and those that spreadsheets read."""

import os
from pathlib import Path

import pytest

from porousmold.errors import InputError
from porousmold.files.tables import LARGEST_TEXT, read_rows, read_toml, text_cells


@pytest.mark.parametrize(
    "text", ["a = " + "[" * 5000 + "]" * 5000, "a = " + "[" * 100 + "]" * 100, ".".join("a" * 20000) + " = 1"]
)
def test_nested_toml_is_refused_in_one_line(tmp_path, text):
    path = tmp_path / "deep.toml"
    path.write_text(text)
    with pytest.raises(InputError, match="nested") as refusal:
        read_toml("scene", path)
    assert "\n" not in str(refusal.value)


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
