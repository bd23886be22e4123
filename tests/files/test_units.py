"""Units at the program's border."""

import pint
import pytest

from porousmold.errors import InputError
from porousmold.files import units
from porousmold.files.units import given_in_si, preferred_unit, to_si


@pytest.mark.parametrize(
    ("values", "unit", "shown"),
    [
        ([0.003, 0.0013], "m", ([3.0, 1.3], "mm")),
        ([0.5, 1.2], "m", ([0.5, 1.2], "m")),
        ([363.15, None], "K", ([90.0, None], "°C")),
        ([2.0], "delta_degC", ([2.0], "K")),
        ([24.0], "s", ([24.0], "s")),
        ([24.0, 1200.0], "s", ([0.4, 20.0], "min")),
        ([8000.0], "Pa", ([8.0], "kPa")),
        ([7.2e6], "J", ([2.0], "kWh")),
        ([None], "s", ([None], "s")),
        ([0.4], "1", ([0.4], "")),
    ],
)
def test_values_that_are_shown_together_have_one_unit(values, unit, shown):
    found, sign = preferred_unit(values, unit)
    assert sign == shown[1] and found == pytest.approx(shown[0])


@pytest.mark.parametrize(("unit", "value"), [("m", 0.02), ("K", 300.0), ("s", 900.0), ("Pa", 2e4), ("kg/s", 0.04)])
def test_what_is_shown_is_read_back(unit, value):
    (shown,), sign = preferred_unit([value], unit)
    assert to_si("--set", f"{shown} {sign.replace('°C', 'degC')}", unit) == pytest.approx(value, rel=1e-12)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """The file of units that were read before, of a user who has read none."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    units._known_scales.cache_clear()
    yield tmp_path / "porousmold" / "units.json"
    units._known_scales.cache_clear()


GIVEN = [("5.3 mm", "m"), ("81.7 degC", "K"), ("-3.1 degF", "K"), ("7.9 kPa", "Pa"), ("13.1 ft^3/min", "m^3/s"), ("0.3 K", "K"),
         ("0.9 kJ/kg/K", "J/(kg*K)"), ("2.7 kWh", "J")]  # fmt: skip


@pytest.mark.parametrize(("text", "unit"), GIVEN)
def test_values_are_those_of_pint_to_the_last_digit(text, unit):
    number, given = text.split(" ")
    assert to_si("key", text, unit) == pint.UnitRegistry().Quantity(float(number), given).to(unit).magnitude


def test_units_that_were_read_before_need_no_pint(cache, monkeypatch):
    values = [to_si("key", text, unit) for text, unit in GIVEN]
    assert cache.is_file()
    monkeypatch.setattr(units, "_registry", lambda: pytest.fail("pint is asked"))
    units._known_scales.cache_clear()
    assert [to_si("key", text, unit) for text, unit in GIVEN] == values


@pytest.mark.parametrize("content", ["", "no JSON", "[1, 2]", '{"mm in m": 1}'])
def test_a_damaged_cache_is_done_without(cache, content):
    cache.parent.mkdir()
    cache.write_text(content)
    assert to_si("key", "5 mm", "m") == 0.005 and to_si("key", "6 mm", "m") == 0.006


@pytest.mark.parametrize(
    "text",
    [
        "5 mm*9**9**9**9",
        "5 mm**99999",
        "1 (m",
        "5 m" + " m" * 100,
        "5 mm + 3",
        "5 __import__('os')",
        "5 m^9^9",
        "5 m*(1/0)",
    ],
)
def test_no_arithmetic_is_evaluated(text):
    with pytest.raises(InputError, match="must be a number with a unit of length"):
        to_si("bed.bead_diameter", text, "m")


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("5 W/(m^2*K)", "W/(m^2*K)", 5.0),
        ("5 W/m**2/K", "W/(m^2*K)", 5.0),
        ("1 W m^-2 K^-1", "W/(m^2*K)", 1.0),
        ("2 °C", "K", 275.15),
        ("3 µm", "m", 3e-6),
        ("1.5e5 1/s", "1/s", 1.5e5),
        ("2e5 Pa*s^2/m^6", "Pa*s^2/m^6", 2e5),
        ("5 kg / m ^ 3", "kg/m^3", 5.0),
    ],
)
def test_products_of_units_are_read(text, unit, value):
    assert to_si("key", text, unit) == pytest.approx(value)


@pytest.mark.parametrize("given", ["80", "25.0", 80.0])
def test_a_temperature_without_a_unit_that_no_mold_has_is_refused(given):
    with pytest.raises(InputError, match="needs a unit"):
        given_in_si("--temperature", given, "K")
    assert given_in_si("--temperature", "80 degC", "K") == pytest.approx(353.15)
    assert given_in_si("--temperature", "300", "K") == 300.0 and given_in_si("--time", "80", "s") == 80.0


@pytest.mark.parametrize(
    ("text", "unit", "value"), [("3000 μm", "m", 3e-3), ("3000 µm", "m", 3e-3), ("−20 ℃", "K", 253.15)]
)
def test_characters_that_texts_come_with_are_read(text, unit, value):
    assert to_si("q", text, unit) == pytest.approx(value, rel=1e-12)
