"""Packings in files of numpy: one array, or several by name (NPZ).

| array                                                       | what it is                                                   |
|-------------------------------------------------------------|--------------------------------------------------------------|
| (n, 4); (n, 3)                                              | x, y, z, radius; without radius                              |
| positions, points, centres, centers, coordinates, xyz (n, 3)| places; or the arrays x, y, z (n,)                           |
| radius, radii, r; diameter, diameters, d                    | (n,), or one number for all                                  |
"""

import tokenize
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Floats
from ..errors import InputError
from ..files.tables import LARGEST_TEXT

KEY = "packing"
PLACES = ("positions", "points", "centres", "centers", "coordinates", "xyz")
SIZES = {**dict.fromkeys(("radius", "radii", "r"), 2.0), **dict.fromkeys(("diameter", "diameters", "d"), 1.0)}
"""Names of arrays of sizes, and the factor that makes diameters of them."""

Beads = tuple[Floats, Floats | None]
"""Positions (n, 3) and diameters (n,) in m, None where the file has none."""


def read_npy(path: Path) -> Beads:
    """The beads of one array. Raises `InputError`."""
    return _of_one(path, _loaded(path))


def read_npz(path: Path) -> Beads:
    """The beads of an archive of arrays. Raises `InputError`, also where it is longer than `LARGEST_TEXT` when it is unpacked."""
    try:
        with zipfile.ZipFile(path) as archive:
            if sum(entry.file_size for entry in archive.infolist()) > LARGEST_TEXT:
                raise InputError(KEY, str(path), f"holds more than {LARGEST_TEXT // 2**20} MiB")
    except (OSError, zipfile.BadZipFile) as error:
        raise InputError(KEY, str(path), f"is not a sound NPZ file: {error}") from error
    arrays = {name.lower(): array for name, array in _loaded(path).items()}
    places = next((arrays[name] for name in PLACES if name in arrays), None)
    if places is None and {"x", "y", "z"} <= arrays.keys():
        parts = [_numbers(path, name, arrays[name]).ravel() for name in "xyz"]
        if len({part.size for part in parts}) > 1:
            raise InputError(KEY, str(path), "has arrays x, y and z of different lengths")
        places = np.column_stack(parts)
    if places is None and len(arrays) == 1:
        places = next(iter(arrays.values()))
    if places is None:
        raise InputError(KEY, str(path), f"has no array named {', '.join(PLACES)}, nor x, y and z: {', '.join(arrays)}")
    positions, diameters = _of_one(path, places)
    given = next(((name, factor) for name, factor in SIZES.items() if name in arrays), None)
    if given is not None:
        name, factor = given
        sizes = factor * _numbers(path, name, arrays[name]).ravel()
        if sizes.size not in (1, len(positions)):
            raise InputError(KEY, str(path), f"has {sizes.size} numbers in {name} of {len(positions)} beads")
        diameters = np.broadcast_to(sizes, len(positions)).copy()
    return positions, diameters


def _loaded(path: Path) -> Any:
    try:
        loaded = np.load(path, allow_pickle=False)
        if not isinstance(loaded, Mapping):
            return loaded
        return {name: array for name, array in loaded.items() if isinstance(array, np.ndarray)}  # others are bytes
    except (OSError, ValueError, EOFError, SyntaxError, KeyError, tokenize.TokenError) as error:
        raise InputError(KEY, str(path), f"is not a sound NPY or NPZ file: {error}") from error
    except (
        zipfile.BadZipFile,
        zlib.error,
        NotImplementedError,
        RuntimeError,
    ) as error:  # a damaged, or a locked archive
        raise InputError(KEY, str(path), f"is not a sound NPZ file: {error}") from error


def _numbers(path: Path, name: str, array: NDArray[np.generic]) -> Floats:
    if array.dtype.kind not in "fiu":
        raise InputError(KEY, str(path), f"must hold numbers in {name}, not {array.dtype}")
    return array.astype(float)


def _of_one(path: Path, table: NDArray[np.generic]) -> Beads:
    if table.ndim != 2 or table.shape[1] not in (3, 4):
        raise InputError(KEY, str(path), f"must hold an array of shape (n, 3) or (n, 4), not {table.shape}")
    numbers = _numbers(path, "its array", table)
    return numbers[:, :3], 2.0 * numbers[:, 3] if table.shape[1] == 4 else None
