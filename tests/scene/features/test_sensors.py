"""Files of sensors: points, and rows that stand for several on a line."""

import numpy as np
import pytest

from porousmold.errors import InputError
from porousmold.scene.features.sensors import read_sensors, sensor_names
from tests.support import coarse_scene


def written(tmp_path, *rows, head="name, x [mm], y [mm]"):
    path = tmp_path / "sensors.csv"
    path.write_text("\n".join([head, *rows]) + "\n")
    return path


def test_a_row_stands_for_sensors_on_a_line(tmp_path):
    path = written(tmp_path, "inlet, 0, 5", "bed, 0:300:4, 20", "across, 150, 0:30:3", "slope, 0:300:2, 10:0:2")
    names, places = read_sensors(path, 2)
    assert names == [
        "inlet",
        *(f"bed {n}" for n in range(1, 5)),
        *(f"across {n}" for n in range(1, 4)),
        "slope 1",
        "slope 2",
    ]
    assert names == sensor_names(path)
    assert places[1:5] == pytest.approx(np.array([[0.0, 0.02], [0.1, 0.02], [0.2, 0.02], [0.3, 0.02]]))
    assert places[-2:] == pytest.approx(np.array([[0.0, 0.01], [0.3, 0.0]]))


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("bed, 0:300, 20", "whole number from 2"),
        ("bed, 0:300:1, 20", "whole number from 2"),
        ("bed, 0:300:2.5, 20", "whole number from 2"),
        ("bed, 0:300:4, 0:20:5", "the same whole number"),
        ("bed, 0:100:300:4, 20", "whole number from 2"),
        ("bed, 0:many:4, 20", "many"),
        ("bed, 0:300:4", "2 numbers"),
        ("bed 2, 0, 0\nbed, 0:300:4, 20", "row 3 must have a name of its own"),
        ("bed[1], 0, 0", "without brackets"),
    ],
)
def test_rows_that_cannot_be_are_refused(tmp_path, row, message):
    with pytest.raises(InputError, match=message):
        read_sensors(written(tmp_path, row), 2)


def test_a_spread_of_one_sensor_is_refused(tmp_path):
    """It was met where the place is half-way, as one point has no spread."""
    (tmp_path / "sensors.csv").write_text("name, x [mm], y [mm]\ndeep, 200, 10\n")
    changes = {"geometry.sensors": str(tmp_path / "sensors.csv"), "target": [{"place": "deep", "spread": 5.0}]}
    with pytest.raises(InputError, match="a sensor has no spread"):
        coarse_scene(changes)
