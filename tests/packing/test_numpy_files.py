"""Packings in arrays of numpy, as scripts write them."""

import zipfile

import numpy as np
import pytest

from porousmold.errors import InputError
from porousmold.packing.container import Cylinder
from porousmold.packing.files import read_packing

BOX = Cylinder(0.1)
POSITIONS = np.array([[0.01, 0.02, 0.005], [-0.02, 0.0, 0.004], [0.0, 0.004, 0.003]])
DIAMETERS = np.array([0.004, 0.004, 0.005])


@pytest.mark.parametrize("arrays", [
    {"positions": POSITIONS, "radius": 0.5 * DIAMETERS},
    {"Points": POSITIONS.astype(np.float32), "diameters": DIAMETERS[:, None]},
    {"x": POSITIONS[:, 0], "y": POSITIONS[:, 1], "z": POSITIONS[:, 2], "r": 0.5 * DIAMETERS, "velocity": POSITIONS},
    {"arr_0": np.column_stack((POSITIONS, 0.5 * DIAMETERS))},
])  # fmt: skip
@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_reads_an_archive_of_arrays(tmp_path, arrays, save):
    save(tmp_path / "bed.npz", **arrays)
    packing = read_packing(tmp_path / "bed.npz", BOX)
    assert packing.positions == pytest.approx(POSITIONS) and packing.diameters == pytest.approx(DIAMETERS)


def test_one_diameter_holds_for_all_beads(tmp_path):
    np.savez(tmp_path / "bed.npz", centres=POSITIONS, diameter=0.004)
    assert read_packing(tmp_path / "bed.npz", BOX).diameters == pytest.approx([0.004] * 3)
    np.savez(tmp_path / "bed.npz", centres=POSITIONS)
    assert read_packing(tmp_path / "bed.npz", BOX, 0.004).diameters == pytest.approx([0.004] * 3)


@pytest.mark.parametrize(("arrays", "word"), [
    ({"a": POSITIONS, "b": DIAMETERS}, "no array named positions"),
    ({"positions": POSITIONS, "radius": DIAMETERS[:2]}, "2 numbers in radius of 3 beads"),
    ({"positions": POSITIONS[:, :2]}, r"\(3, 2\)"),
    ({"positions": np.array([["a", "b", "c"]])}, "numbers in its array"),
    ({"x": DIAMETERS, "y": DIAMETERS, "z": DIAMETERS[:2]}, "different lengths"),
    ({"positions": np.array([[None, 1, 2]], dtype=object), "radius": DIAMETERS}, "NPZ"),
])  # fmt: skip
def test_other_arrays_are_refused_in_one_line(tmp_path, arrays, word):
    np.savez(tmp_path / "bed.npz", **arrays)
    with pytest.raises(InputError, match=word) as caught:
        read_packing(tmp_path / "bed.npz", BOX, 0.004)
    assert "\n" not in str(caught.value) and "bed.npz" in str(caught.value)


def test_archives_that_are_damaged_or_no_arrays_are_refused(tmp_path):
    np.savez(tmp_path / "bed.npz", positions=POSITIONS, radius=DIAMETERS)
    content = (tmp_path / "bed.npz").read_bytes()
    for number in range(4, len(content), 7):
        (tmp_path / "cut.npz").write_bytes(content[:number])
        (tmp_path / "bent.npz").write_bytes(content[:number] + bytes([content[number] ^ 0x55]) + content[number + 1 :])
        with pytest.raises(InputError):
            read_packing(tmp_path / "cut.npz", BOX)
        try:  # a name may be bent to another one, and a digest does not guard everything
            read_packing(tmp_path / "bent.npz", BOX)
        except InputError as refusal:
            assert "\n" not in str(refusal)
    with zipfile.ZipFile(tmp_path / "words.npz", "w") as archive:
        archive.writestr("words.txt", "no array")
    with pytest.raises(InputError):
        read_packing(tmp_path / "words.npz", BOX, 0.004)


def test_an_archive_that_unpacks_to_gigabytes_is_refused(tmp_path):
    with (
        zipfile.ZipFile(tmp_path / "huge.npz", "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open("x.npy", "w") as file,
    ):
        for _ in range(260):
            file.write(bytes(2**20))
    with pytest.raises(InputError, match="MiB"):
        read_packing(tmp_path / "huge.npz", BOX)
