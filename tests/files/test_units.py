"""Units at the program's border."""

import pytest

from porousmold.files.units import preferred_unit, to_si


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
