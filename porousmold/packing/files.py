"""Files of packings: our own HDF5, and what other codes write.

| read                          | recognised by             | what is taken                                                    |
|-------------------------------|---------------------------|------------------------------------------------------------------|
| porousmold HDF5               | its signature             | everything, container included                                   |
| LIGGGHTS / LAMMPS text dump   | `ITEM: TIMESTEP`          | last frame, columns by name: id, x y z (or xu yu zu, or scaled   |
|                               |                           | xs ys zs), radius or diameter; atoms in any order                |
| YADE text (x_y_z_r)           | lines of four numbers     | centre and radius; further columns are left alone                |
| extended XYZ                  | a count, then Properties= | last frame; pos, and radius or diameter                          |
| CSV                           | suffix .csv               | columns x, y, z, and radius or diameter, by name; m, or [mm] and |
|                               |                           | the like in the head                                             |
| NPY                           | its signature             | array (n, 4): x, y, z, radius; or (n, 3) with a given diameter   |

All lengths are in m unless the file says otherwise. Where a file holds no radius, the caller gives the bead diameter;
all but our own need the container from the caller. Written: HDF5, extended XYZ, VTK. Files are written whole or not at
all. The readers are small on purpose: general ones know atoms, not radii.
"""

import io
import json
import os
import re
import tokenize
from contextlib import suppress
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..files.atomic_files import output_file
from ..files.tables import read_rows
from ..files.units import to_si
from .container import container, description
from .packing import Packing

KEY = "packing"


def read_packing(path: str | Path, box: Any = None, bead_diameter: Any = None) -> Any:
    """The `Packing` in a file; `box` (a container) and `bead_diameter` (m) for what the file does not hold.

    Raises `InputError` with one line for a file that is missing, broken, of no known format, without beads, or that
    lacks a container or diameters which were not given.
    """
    path = Path(path)
    try:
        with path.open("rb") as file:
            start = file.read(4096)
    except OSError as error:
        raise InputError(KEY, str(path), f"must be a readable file: {error.strerror}") from error
    if not start.strip():
        raise InputError(KEY, str(path), "is empty")
    if start.startswith(b"\x89HDF"):
        return _read_hdf5(path, box)
    if start.startswith(b"\x93NUMPY"):
        positions, diameters = _read_npy(path)
    elif path.suffix.lower() == ".csv":
        positions, diameters = _read_csv(path)
    else:
        positions, diameters = _read_text(path)
    if diameters is None:
        if bead_diameter is None:
            raise InputError(KEY, str(path), "holds no radius or diameter: give the bead diameter")
        diameters = np.full(len(positions), bead_diameter)
    if box is None:
        raise InputError(KEY, str(path), "holds no container: give its kind and sizes")
    return _packing(path, positions, diameters, box, {"file": str(path)})


def _packing(path: str | Path, positions: Any, diameters: NDArray[Any], box: Any, made: Any) -> Any:
    try:
        return Packing(positions, diameters, box, made)
    except InputError as error:
        raise InputError(KEY, error.value, error.allowed, str(path)) from error


def _read_hdf5(path: str | Path, box: Any) -> Any:
    try:
        with h5py.File(path, "r") as file:
            positions, diameters = file["positions"][:].astype(float), file["diameters"][:].astype(float)
            own = container(str(file.attrs["container"]), dict(json.loads(file.attrs["container_sizes"])))
            made = dict(json.loads(file.attrs["made"]))
    except (OSError, KeyError, ValueError, TypeError, AttributeError, RuntimeError) as error:
        raise InputError(KEY, str(path), f"is not a packing written by porousmold, or is damaged: {error}") from error
    return _packing(path, positions, diameters, box or own, made)


def _read_npy(path: str | Path) -> tuple[Any, ...]:
    try:
        table = np.load(path, allow_pickle=False)
    except (OSError, ValueError, EOFError, SyntaxError, tokenize.TokenError) as error:
        raise InputError(KEY, str(path), f"is not a sound NPY file: {error}") from error
    if table.ndim != 2 or table.shape[1] not in (3, 4) or table.dtype.kind not in "fiu":
        raise InputError(
            KEY, str(path), f"must hold numbers of shape (n, 3) or (n, 4), not {table.dtype} {table.shape}"
        )
    return table[:, :3].astype(float), (2.0 * table[:, 3].astype(float) if table.shape[1] == 4 else None)


def _read_csv(path: str | Path) -> Any:
    head, *rows = read_rows(KEY, Path(path)) or [[]]
    names, units = [], []
    for cell in head:
        match = re.fullmatch(r"\s*([^\[(]*?)\s*(?:[\[(](.*)[\])])?\s*", cell)
        names.append(match.group(1).lower() if match else cell)
        units.append(match.group(2) if match else None)
    columns = {}
    for name in ("x", "y", "z", "radius", "diameter"):
        if name in names:
            at = names.index(name)
            scale = to_si(f"{KEY} column {name}", f"1 {units[at]}", "m", str(path)) if units[at] else 1.0
            columns[name] = scale * _numbers(path, [row[at : at + 1] for row in rows], 1)[:, 0]
    return _places(path, columns)


def _read_text(path: str | Path) -> Any:
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(KEY, str(path), "must be a text file, HDF5 or NPY") from error
    if lines[0].startswith("ITEM:"):
        return _read_dump(path, lines)
    if lines[0].strip().isdecimal() and len(lines) > 1 and "Properties=" in lines[1]:
        return _read_extxyz(path, lines)
    rows = [line.split() for line in lines if line.strip() and not line.lstrip().startswith("#")]
    if not rows or len(rows[0]) < 4:
        raise InputError(KEY, str(path), "is of no known format: dump, extended XYZ, CSV, NPY, HDF5, or lines x y z r")
    table = _numbers(path, [row[:4] for row in rows], 4)
    return table[:, :3], 2.0 * table[:, 3]


def _read_dump(path: str | Path, lines: Any) -> Any:
    """The last frame: ITEM: NUMBER OF ATOMS, ITEM: BOX BOUNDS, ITEM: ATOMS with its column names."""
    heads = [number for number, line in enumerate(lines) if line.startswith("ITEM: ATOMS")]
    counts = [number for number, line in enumerate(lines) if line.startswith("ITEM: NUMBER OF ATOMS")]
    if not heads or not counts or counts[-1] > heads[-1] or counts[-1] + 1 >= len(lines):
        raise InputError(KEY, str(path), "is a dump without ITEM: NUMBER OF ATOMS and ITEM: ATOMS in its last frame")
    names = lines[heads[-1]].split()[2:]
    count = _whole(path, lines[counts[-1] + 1])
    rows = [line.split() for line in lines[heads[-1] + 1 :] if line.strip()]
    if len(rows) != count:
        raise InputError(
            KEY, str(path), f"is cut short: {len(rows)} rows in its last frame, where {count} atoms are due"
        )
    # columns of words, such as the element's name, are left alone
    wanted = [
        name for name in names if name in {"id", "radius", "diameter", *"xyz", "xu", "yu", "zu", "xs", "ys", "zs"}
    ]
    at = [names.index(name) for name in wanted]
    if any(len(row) != len(names) for row in rows):
        raise InputError(KEY, str(path), f"has rows that are not of {len(names)} columns, as its ITEM: ATOMS says")
    table = _numbers(path, [[row[i] for i in at] for row in rows], len(at))
    if "id" in wanted:
        table = table[np.argsort(table[:, wanted.index("id")], kind="stable")]
    columns = {name: table[:, i] for i, name in enumerate(wanted)}
    for axis, name in enumerate("xyz"):
        if name not in columns and name + "u" in columns:
            columns[name] = columns[name + "u"]
        elif name not in columns and name + "s" in columns:
            low, high = _bounds(path, lines, heads[-1], axis)
            columns[name] = low + (high - low) * columns[name + "s"]
    return _places(path, columns)


def _bounds(path: str | Path, lines: Any, end: Any, axis: int) -> Any:
    heads = [number for number, line in enumerate(lines[:end]) if line.startswith("ITEM: BOX BOUNDS")]
    if not heads or heads[-1] + 3 >= end:
        raise InputError(KEY, str(path), "has scaled coordinates without ITEM: BOX BOUNDS")
    return _numbers(path, [lines[heads[-1] + 1 + axis].split()[:2]], 2)[0]


def _read_extxyz(path: str | Path, lines: Any) -> Any:
    """The last frame: count, comment with Properties=name:type:columns:..., rows."""
    at = 0
    while True:
        count = _whole(path, lines[at])
        comment = lines[at + 1] if at + 1 < len(lines) else ""
        rows = lines[at + 2 : at + 2 + count]
        if len(rows) < count:
            raise InputError(KEY, str(path), f"ends early: {len(rows)} of {count} rows in its last frame")
        after = at + 2 + count
        if after >= len(lines) or not lines[after].strip():
            break
        at = after
    match = re.search(r'Properties="?([^\s"]+)', comment)
    parts = match.group(1).split(":") if match else []
    if len(parts) % 3 or not parts:
        raise InputError(KEY, str(path), "has no Properties=name:type:columns:... in the comment of its last frame")
    offset, spans = 0, {}
    for name, width in zip(parts[::3], parts[2::3], strict=True):
        spans[name] = (offset, _whole(path, width))
        if not spans[name][1]:
            raise InputError(KEY, str(path), f"has no column for {name} in its Properties")
        offset += spans[name][1]
    cells = [row.split() for row in rows]
    columns: dict[str, NDArray[Any]] = {}
    for name in ("pos", "radius", "diameter"):
        if name in spans:
            first, width = spans[name]
            table = _numbers(path, [row[first : first + width] for row in cells], width)
            columns |= dict(zip("xyz", table.T, strict=False)) if name == "pos" else {name: table[:, 0]}
    return _places(path, columns)


def _places(path: str | Path, columns: Any) -> tuple[Any, ...]:
    if not all(name in columns for name in "xyz"):
        raise InputError(KEY, str(path), f"must have columns x, y and z; it has {', '.join(columns) or 'none of them'}")
    positions = np.column_stack([columns[name] for name in "xyz"])
    if "radius" in columns:
        return positions, 2.0 * columns["radius"]
    return positions, columns.get("diameter")


def _numbers(path: str | Path, rows: Any, width: float) -> NDArray[Any]:
    if not rows:
        raise InputError(KEY, str(path), "holds no beads")
    if any(len(row) != width for row in rows):
        short = next(number for number, row in enumerate(rows, 1) if len(row) != width)
        raise InputError(KEY, str(path), f"has too few columns in row {short} of its beads")
    try:
        return np.array(rows, float)
    except ValueError as error:
        raise InputError(KEY, str(path), f"holds a cell that is no number: {error}") from error


def _whole(path: str | Path, text: str) -> int:
    if not text.strip().isdecimal() or len(text.strip()) > 15:
        raise InputError(KEY, str(path), f"has {text.strip()!r} where a whole number is due")
    return int(text)


def write_packing(packing: Packing, path: str | Path, extxyz: Any = None, vtk: Any = None) -> None:
    """HDF5 at `path`, and on request extended XYZ and VTK (vertices with radius). `InputError` if one cannot be written."""
    for target, write in ((path, _write_hdf5), (extxyz, _write_extxyz), (vtk, _write_vtk)):
        if target is not None:
            with output_file(target) as temporary:
                write(packing, temporary)


def check_writable(*paths: Any, sources: Any = ()) -> None:
    """Refuse paths that cannot be written, are one another or a source, before long work begins (`InputError`); folders that are
    missing are made."""
    taken = {Path(path).resolve() for path in sources}
    for path in paths:
        if path is None:
            continue
        try:
            full = Path(path).resolve()
            with suppress(FileNotFoundError, NotADirectoryError):
                full.stat()  # an OSError of a name that is too long, which is_dir() of Python 3.14 keeps to itself
            existing = next(folder for folder in full.parents if folder.exists())
            writable = not full.is_dir() and existing.is_dir() and os.access(existing, os.W_OK)
        except OSError:
            writable = False
        if not writable:
            raise InputError("--out", str(path), "must be a file in a folder that can be written")
        if full in taken:
            raise InputError("--out", str(path), "is needed for another file")
        taken.add(full)
    for path in paths:
        if path is not None:
            Path(path).resolve().parent.mkdir(parents=True, exist_ok=True)


def _write_hdf5(packing: Packing, path: str | Path) -> None:
    with h5py.File(path, "w") as file:
        for name, values in (("positions", packing.positions), ("diameters", packing.diameters)):
            file.create_dataset(name, data=values).attrs["unit"] = "m"
        kind, sizes = description(packing.container)
        file.attrs["container"], file.attrs["container_sizes"] = kind, json.dumps(sizes)
        file.attrs["made"] = json.dumps(packing.made)


def _write_extxyz(packing: Packing, path: str | Path) -> None:
    text = io.StringIO()
    kind, sizes = description(packing.container)
    text.write(f"{packing.diameters.size}\nProperties=species:S:1:pos:R:3:radius:R:1 container={kind} ")
    text.write(" ".join(f"{name}={value:g}" for name, value in sizes.items()) + "\n")
    table = np.column_stack((packing.positions, 0.5 * packing.diameters))
    np.savetxt(text, table, fmt="X %.12g %.12g %.12g %.12g")
    Path(path).write_text(text.getvalue(), encoding="utf-8")


def _write_vtk(packing: Packing, path: str | Path) -> None:
    import meshio  # a tenth of a second, paid by those who want the file

    vertices = [("vertex", np.arange(packing.diameters.size)[:, None])]
    meshio.write_points_cells(path, packing.positions, vertices, {"radius": 0.5 * packing.diameters}, file_format="vtk")
