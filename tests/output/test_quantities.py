"""The table of recorded quantities."""

import numpy as np
import pytest

from porousmold.output.quantities import QUANTITIES, Columns, Recorded, quantity


def test_columns_take_their_units_from_the_table():
    columns = Columns()
    columns.append({"time": 0, "temperature_outer_L/2": 300.0, "gradient_lid": 5.0})
    columns.append({"time": 1, "temperature_outer_L/2": 301.0, "gradient_lid": 4.0})
    assert columns.units == {"time": "s", "temperature_outer_L/2": "K", "gradient_lid": "K/m"}
    assert len(columns) == 2 and columns["time"] == [0.0, 1.0]
    with pytest.raises(KeyError):
        quantity("nonsense")


def test_a_recorded_column_keeps_its_unit_when_cut_and_scaled():
    column = Recorded.of("pressure_drop", [1.0, 2.0, 3.0])
    assert column.unit == column[1:].unit == (2.0 * column).unit == "Pa"
    assert column.max() == 3.0 and np.asarray(column).tolist() == [1.0, 2.0, 3.0]


def test_labels_have_words_symbol_and_unit():
    assert QUANTITIES["speed"].axis_label == "speed $|u|$ in m/s"
    assert QUANTITIES["turbulent_kinetic_energy"].axis_label.endswith("in m²/s²")
    assert " in " not in QUANTITIES["porosity"].axis_label
