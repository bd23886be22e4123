"""Time series from numbers and CSV files."""

import pytest

from porousmold.errors import InputError
from porousmold.scene.series import TimeSeries, read_channel, read_series

KEY = "operation.inlet_temperature"


def write(tmp_path, text):
    path = tmp_path / "series.csv"
    path.write_text(text)
    return path


def test_interpolates_holds_its_ends_and_converts_units(tmp_path):
    series = read_series(KEY, write(tmp_path, "time [min], T [degC]\n# comment\n0, 20\n1, 80\n"), "K")
    assert series(30.0) == pytest.approx(273.15 + 50.0)
    assert series(-5.0) == pytest.approx(293.15) and series(1e9) == pytest.approx(353.15)
    assert series.breakpoints == (0.0, 60.0)
    assert series.range == pytest.approx((293.15, 353.15))


@pytest.mark.parametrize("text", ["time [s]; T [K]\n0; 300,5\n1; 301\n", "time [s]\tT [K]\n0\t300.5\n1\t301\n"])
def test_semicolons_with_decimal_commas_and_tabs_are_read(tmp_path, text):
    assert read_series(KEY, write(tmp_path, text), "K").values == (300.5, 301.0)


def test_constant_has_no_kinks():
    series = TimeSeries.constant(5.0)
    assert series(123.0) == 5.0 and series.breakpoints == ()


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "head"),
        ("time [s], T [K]\n", "head"),
        ("time, T\n0, 300\n", "units"),
        ("time [s], T [K]\n0, 300\n0, 310\n", "row 3"),
        ("time [s], T [K]\n0, 300\n10, 310\n5, 320\n", "row 4"),
        ("time [s], T [K]\n0, abc\n", "row 2"),
        ("time [s];T [K]\n0;300,5\n1.000;310\n", "which is the decimal sign"),
        ("time;T [K]\n05.03.2024 10:00;300\n05.03.2024 11:00;310\n", "write dates like"),
        ("time,T [K]\n3/5/2024 10:00,300\n3/5/2024 11:00,310\n", "write dates like"),
        ("time [min],T [K]\n00:00,300\n00:30,310\n", "h:mm, or min:s"),
        ("time [s], T [m]\n0, 300\n", "temperature"),
        ("time [s], T [K], x [m]\n0, 300, 1\n", "two columns"),
        ("time [s], T [K]\n0; 300\n", "row 2"),
        ("time [s], T [K]\n# a comment\n\n0, 300\n0, 310\n", "row 5"),
        ("time [s]; T [K]\n0; 300\n1, 300\n", "row 3"),
        ("time [s], T [K]\n0, nan\n", "row 2"),
    ],
)
def test_broken_files_get_one_line(tmp_path, text, word):
    with pytest.raises(InputError) as caught:
        read_series(KEY, write(tmp_path, text), "K")
    assert word in str(caught.value) and "\n" not in str(caught.value)


def test_columns_along_the_flow_are_interpolated_in_time_and_give_their_places(tmp_path):
    series = read_series(
        "q", write(tmp_path, "time [s], 100 mm [W/m^2], 0.3 m [W/m^2]\n0, -1, -3\n10, -2, -9\n"), "W/m^2", along=True
    )
    assert series.positions == pytest.approx((0.1, 0.3))
    assert series(5.0) == pytest.approx([-1.5, -6.0]) and series(99.0) == pytest.approx([-2.0, -9.0])
    assert series.range == (-9.0, -1.0) and series.breakpoints == (0.0, 10.0)


@pytest.mark.parametrize(
    "head", ["0.3 m [W/m^2], 0.1 m [W/m^2]", "here [W/m^2], there [W/m^2]", "1 kg [W/m^2], 2 kg [W/m^2]"]
)
def test_columns_at_no_places_are_refused(tmp_path, head):
    with pytest.raises(InputError, match=r"positions|head|length"):
        read_series("q", write(tmp_path, f"time [s], {head}\n0, -1, -3\n10, -2, -9\n"), "W/m^2", along=True)


LOGGER = """nr;Zeit;Zulufttemperatur;Status;Abluft [degC]
1;2024-03-05 10:00:00;25,0;ok;20
2;2024-03-05 10:01:00;55,5;OVERRANGE;21
"""


def test_one_channel_of_a_logger_is_named_by_a_table(tmp_path):
    write(tmp_path, LOGGER.replace("nr;", "").replace("1;2024", "2024").replace("2;2024", "2024"))
    table = {"file": "series.csv", "column": "Zulufttemperatur", "unit": "degC"}
    series = read_channel(KEY, table, tmp_path, "K", along=False, where=None)
    assert series.times == (0.0, 60.0) and series.values == pytest.approx((298.15, 328.65))
    assert series.as_value() == {**table, "file": str(tmp_path / "series.csv")}
    other = read_channel(KEY, {"file": "series.csv", "column": "Abluft [degC]"}, tmp_path, "K", along=False, where=None)
    assert other.values == pytest.approx((293.15, 294.15))
    for change, words in (
        ({"column": "Zuluft"}, "has no such column"),
        ({"unit": "m"}, "temperature"),
        ({"channel": "1"}, "must be a text, and one of"),
        ({"time_offset": "3 m"}, "time"),
        ({"file": "no.csv"}, "must name an existing file"),
        ({"column": "Abluft", "unit": "degF"}, "is not that of the head, degC"),
    ):
        with pytest.raises(InputError, match=words):
            read_channel(KEY, table | change, tmp_path, "K", along=False, where=None)
    del table["unit"]
    with pytest.raises(InputError, match="needs a head with units"):
        read_channel(KEY, table, tmp_path, "K", along=False, where=None)


@pytest.mark.parametrize("offset", ["first", "36000 s", "10 h", "10:00"])
def test_a_clock_may_begin_at_its_first_row(tmp_path, offset):
    write(tmp_path, "time [h], T [K]\n10.0, 300\n10.5, 330\n")
    table = {"file": "series.csv", "time_offset": offset}
    series = read_channel(KEY, table, tmp_path, "K", along=False, where=None)
    assert series.times == pytest.approx((0.0, 1800.0))
