"""Tabulated porosity profiles."""

import numpy as np
import pytest

from porousmold.errors import InputError
from porousmold.laws.porosity_profile import HEAD, PorosityProfile

GOOD = ",".join(HEAD) + "\n# from a packing\n0,1,1\n0.25,0.6,0.62\n0.5,0.38,0.45\n2.75,0.4,0.4\n"


def write(tmp_path, text):
    path = tmp_path / "profile.csv"
    path.write_text(text)
    return path


def test_passes_its_points_and_stays_between_them(tmp_path):
    profile = PorosityProfile.read("bed.porosity_profile", write(tmp_path, GOOD))
    places = np.array([0.0, 0.25, 0.5, 2.75, 9.0]) * 5e-3
    volume, area = profile.volume(places, 5e-3), profile.area(places, 5e-3)
    assert volume == pytest.approx([1.0, 0.6, 0.38, 0.4, 0.4])
    assert area == pytest.approx([1.0, 0.62, 0.45, 0.4, 0.4])
    dense = profile.volume(np.linspace(0.0, 0.5 * 5e-3, 500), 5e-3)
    assert np.all(np.diff(dense) <= 0.0)
    between = profile.volume(np.linspace(0.5, 2.75, 500) * 5e-3, 5e-3)
    assert between.min() >= 0.38 and between.max() <= 0.4
    assert profile.bulk_porosity == 0.4


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "head"),
        ("a,b,c\n0,1,1\n1,0.4,0.4\n", "head"),
        (",".join(HEAD) + "\n0,1,1\n", "two rows"),
        (",".join(HEAD) + "\n0,1,1\n1,x,0.4\n", "no number"),
        (",".join(HEAD) + "\n0,1,1\n1,0.4,0.4\n0.5,0.4,0.4\n", "increase"),
        (",".join(HEAD) + "\n0.1,1,1\n1,0.4,0.4\n", "from 0"),
        (",".join(HEAD) + "\n0,1,1\n1,1.4,0.4\n", "(0, 1]"),
        (",".join(HEAD) + "\n0,1,1\n1,nan,0.4\n", "(0, 1]"),
        (",".join(HEAD) + "\n0,1,1\n0.2,1,1\n1,0.4,0.4\n", "phi_v = 1 from 0 to 0.2 bead diameters"),
    ],
)
def test_broken_files_get_one_line(tmp_path, text, word):
    with pytest.raises(InputError) as caught:
        PorosityProfile.read("bed.porosity_profile", write(tmp_path, text))
    assert word in str(caught.value) and "\n" not in str(caught.value)


def test_binary_file_is_refused(tmp_path):
    path = tmp_path / "profile.csv"
    path.write_bytes(bytes(range(256)))
    with pytest.raises(InputError):
        PorosityProfile.read("bed.porosity_profile", path)
