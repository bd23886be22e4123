"""Tabulated conductivities of a bed."""

from dataclasses import replace

import numpy as np
import pytest

from porousmold.errors import InputError
from porousmold.laws.conductivity_profile import ConductivityProfile

from .test_stirring import BED


def written(tmp_path, text):
    path = tmp_path / "conductivity.csv"
    path.write_text(text)
    return path


def test_straight_lines_between_points_constant_outside(tmp_path):
    text = "wall_distance [mm],conductivity [W/(m*K)]\n1,0.2\n3,0.6\n10,0.5\n"
    profile = ConductivityProfile.read("bed.conductivity_profile", written(tmp_path, text))
    places = np.array([0.0, 1.0, 2.0, 3.0, 6.5, 10.0, 30.0]) * 1e-3
    found = profile(replace(BED, wall_distance=places))
    assert found == pytest.approx(np.interp(places, profile.distances, profile.conductivities))
    assert profile(replace(BED, wall_distance=2e-3)) == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("distance [m],conductivity [W/(m*K)]\n0,1\n", "must begin with the head"),
        ("wall_distance [m],conductivity [W/(m*K)]\n1,1\n0,1\n", "that increase"),
        ("wall_distance [m],conductivity [W/(m*K)]\n0,0\n", "conductivities > 0"),
        ("wall_distance [m],conductivity [W]\n0,1\n", "conductivity"),
    ],
)
def test_what_is_no_profile_is_refused(tmp_path, text, message):
    with pytest.raises(InputError, match=message):
        ConductivityProfile.read("bed.conductivity_profile", written(tmp_path, text))
