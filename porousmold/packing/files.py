"""Files of packings: our own HDF5, and what other codes write.

| read                          | recognised by             | what is taken                                                    |
|-------------------------------|---------------------------|------------------------------------------------------------------|
| porousmold HDF5               | its signature             | everything, container included                                   |
| LIGGGHTS / LAMMPS text dump   | `ITEM: TIMESTEP`          | last frame, columns by name: id, x y z (or xu yu zu, or scaled   |
|                               |                           | xs ys zs, xsu ysu zsu, also of a tilted box), radius or          |
|                               |                           | diameter; atoms in any order; `ITEM: UNITS`                      |
| YADE text (x_y_z_r)           | `#format`, or lines of    | columns by the names of `#format`, else centre and radius;       |
|                               | four numbers              | further columns are left alone                                   |
| extended XYZ                  | a count, then Properties= | last frame; pos, and radius or diameter                          |
| XYZ                           | a count, rows of five     | name, x, y, z, radius                                            |
| CSV                           | suffix .csv               | columns x, y, z (ParaView: Points:0), and radius or diameter, by |
|                               |                           | name; m, or [mm] and the like; commas, semicolons or tabs        |
| any of these, by gzip         | its signature             | the same                                                         |
| NPY, NPZ                      | its signature             | arrays, by name (`numpy_files`)                                  |

All lengths are in m unless the file says otherwise. Where a file holds no radius, the caller gives the bead diameter;
all but our own need the container from the caller. Written: HDF5, extended XYZ, VTK. Files are written whole or not at
all. The readers are small on purpose: general ones know atoms, not radii.
"""

import csv
import gzip
import io
import json
import os
import re
import tempfile
import zlib
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np

from ..arrays import Floats
from ..errors import InputError
from ..files.atomic_files import output_file
from ..files.tables import LARGEST_TEXT, SEPARATORS, refuse_odd, text_of
from ..files.units import to_si
from .container import Container, container, description
from .numpy_files import KEY, read_npy, read_npz
from .packing import Packing


class Placement(NamedTuple):
    """Where a container stands in a file: its upright `axis`, the height of its `floor` along that (m), and its `centre` across
    (m), in the order of the two axes that follow it (of z: x, y; of y: z, x; of x: y, z)."""

    axis: str = "z"
    floor: float = 0.0
    centre: tuple[float, float] = (0.0, 0.0)

    def upright(self, positions: Floats) -> Floats:
        """Positions (n, 3) with the container's axis as z, its floor at 0 and its centre at the origin."""
        upright = "xyz".index(self.axis)
        turned = positions[:, [(upright + 1) % 3, (upright + 2) % 3, upright]]
        return np.asarray(turned - [*self.centre, self.floor])


def read_packing(
    path: str | Path,
    box: Container | None = None,
    bead_diameter: float | None = None,
    placement: Placement | None = None,
) -> Packing:
    """The `Packing` in a file; `box` (a container) and `bead_diameter` (m) for what the file does not hold, `placement` where the
    file has it elsewhere.

    Raises `InputError` with one line for a file that is missing, broken, of no known format, without beads, or that
    lacks a container or diameters which were not given.
    """
    path = Path(path)
    try:
        refuse_odd(KEY, path)
        with path.open("rb") as file:
            start = file.read(4096)
    except OSError as error:
        raise InputError(KEY, str(path), f"must be a readable file: {error.strerror}") from error
    if start.startswith(b"\x1f\x8b"):
        return _read_compressed(path, box, bead_diameter, placement)
    if not start.strip():
        raise InputError(KEY, str(path), "is empty")
    if start.startswith(b"\x89HDF"):
        if bead_diameter is not None or placement not in (None, Placement()):
            allowed = "is a packing of `porousmold pack`: bead diameter, axis, floor and centre are its own, none can be given"
            raise InputError(KEY, str(path), allowed)
        return _read_hdf5(path, box)
    if start.startswith(b"\x93NUMPY"):
        positions, diameters = read_npy(path)
    elif start.startswith(b"PK\x03\x04"):
        positions, diameters = read_npz(path)
    elif path.suffix.lower() == ".csv":
        positions, diameters = _read_csv(path)
    else:
        positions, diameters = _read_text(path)
    if diameters is not None and bead_diameter is not None:
        raise InputError(KEY, str(path), "holds the beads' sizes: a bead diameter has no effect")
    if diameters is None:
        if bead_diameter is None:
            raise InputError(KEY, str(path), "holds no radius or diameter: give the bead diameter")
        diameters = np.full(len(positions), bead_diameter)
    if box is None:
        raise InputError(KEY, str(path), "holds no container: give its kind and sizes")
    return _packing(path, (placement or Placement()).upright(positions), diameters, box, {"file": str(path)})


def _read_compressed(
    path: Path, box: Container | None, bead_diameter: float | None, placement: Placement | None
) -> Packing:
    """The packing in a file packed by gzip, `LARGEST_TEXT` long at most when it is unpacked."""
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / (path.name.removesuffix(".gz") or "packing")
        try:
            with gzip.open(path) as packed, plain.open("wb") as file:
                while part := packed.read(2**20):
                    file.write(part)
                    if file.tell() > LARGEST_TEXT:
                        raise OSError(f"it holds more than {LARGEST_TEXT // 2**20} MiB")
        except (OSError, EOFError, zlib.error) as error:
            raise InputError(KEY, str(path), f"is packed by gzip, but cannot be unpacked: {error}") from error
        try:
            return read_packing(plain, box, bead_diameter, placement)
        except InputError as error:
            raise InputError(error.key, str(path), error.allowed, error.where) from error


def _packing(path: str | Path, positions: Floats, diameters: Floats, box: Container, made: dict[str, Any]) -> Packing:
    try:
        packing = Packing(positions, diameters, box, made)
        packing.check_overlaps()
        return packing
    except InputError as error:
        raise InputError(KEY, error.value, error.allowed, str(path)) from error


def _same(one: Container, other: Container) -> bool:
    (kind, sizes), (other_kind, others) = description(one), description(other)
    return kind == other_kind and np.allclose(list(sizes.values()), list(others.values()), rtol=1e-9)


def _read_hdf5(path: str | Path, box: Container | None) -> Packing:
    try:
        with h5py.File(path, "r") as file:
            positions, diameters = file["positions"][:].astype(float), file["diameters"][:].astype(float)
            own = container(str(file.attrs["container"]), dict(json.loads(file.attrs["container_sizes"])))
            made = dict(json.loads(file.attrs["made"]))
    except (OSError, KeyError, ValueError, TypeError, AttributeError, RuntimeError) as error:
        raise InputError(KEY, str(path), f"is not a packing written by porousmold, or is damaged: {error}") from error
    if box is not None and not _same(box, own):
        raise InputError(KEY, str(path), f"holds beads in {own}, not in {box}")
    return _packing(path, positions, diameters, own, made)


NAMES = {
    **{name: name for name in ("x", "y", "z", "radius", "diameter")},
    **{"r": "radius", "d": "diameter", "points:0": "x", "points:1": "y", "points:2": "z"},
    **{"points_0": "x", "points_1": "y", "points_2": "z"},
}
"""Columns of tables, in small letters: plain ones, and ParaView's."""


def _read_csv(path: str | Path) -> Any:
    text = text_of(KEY, Path(path))
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    separator = max(SEPARATORS, key=lambda one: lines[0].count(one) if lines else 0)
    head, *rows = list(csv.reader(lines, delimiter=separator)) or [[]]
    if separator != ",":
        rows = [[cell.replace(",", ".") for cell in row] for row in rows]
    columns = {}
    for at, cell in enumerate(head):
        match = re.fullmatch(r"\s*([^\[(]*?)\s*(?:[\[(](.*)[\])])?\s*", cell)
        name = NAMES.get((match.group(1) if match else cell).lower())
        if name is not None:
            unit = match.group(2) if match else None
            scale = to_si(f"{KEY} column {name}", f"1 {unit}", "m", str(path)) if unit else 1.0
            if name in columns:
                raise InputError(KEY, str(path), f"has two columns {name}")
            columns[name] = scale * _numbers(path, [row[at : at + 1] for row in rows], 1)[:, 0]
    return _places(path, columns)


def _read_text(path: str | Path) -> Any:
    lines = text_of(KEY, Path(path)).splitlines()
    if "\0" in lines[0]:
        raise InputError(KEY, str(path), "must be a text file, HDF5, NPY or NPZ")
    if lines[0].startswith("ITEM:"):
        return _read_dump(path, lines)
    if lines[0].strip().isdecimal() and len(lines) > 1 and "Properties=" in lines[1]:
        return _read_extxyz(path, lines)
    if lines[0].strip().isdecimal() and len(lines) > 2 and len(lines[2].split()) == 5:  # plain XYZ with a radius
        count = _whole(path, lines[0])
        rows = [line.split()[1:] for line in lines[2 : 2 + count]]
        if len(rows) < count:
            raise InputError(KEY, str(path), f"ends early: {len(rows)} of {count} rows")
        table = _numbers(path, rows, 4)
        return table[:, :3], 2.0 * table[:, 3]
    rows = [line.split() for line in lines if line.strip() and not line.lstrip().startswith("#")]
    if lines[0].startswith("#format ") and rows:
        names = [NAMES.get(name.lower()) for name in lines[0].removeprefix("#format ").strip().split("_")]
        at = {name: number for number, name in enumerate(names) if name is not None}
        return _places(
            path,
            {name: _numbers(path, [row[place : place + 1] for row in rows], 1)[:, 0] for name, place in at.items()},
        )
    if not rows or len(rows[0]) < 4:
        raise InputError(
            KEY, str(path), "is of no known format: dump, extended XYZ, CSV, NPY, NPZ, HDF5, or lines x y z r"
        )
    table = _numbers(path, [row[:4] for row in rows], 4)
    return table[:, :3], 2.0 * table[:, 3]


def _read_dump(path: str | Path, lines: list[str]) -> Any:
    """The last frame: ITEM: NUMBER OF ATOMS, ITEM: BOX BOUNDS, ITEM: ATOMS with its column names."""
    heads = [number for number, line in enumerate(lines) if line.startswith("ITEM: ATOMS")]
    counts = [number for number, line in enumerate(lines) if line.startswith("ITEM: NUMBER OF ATOMS")]
    if not heads or not counts or counts[-1] > heads[-1] or counts[-1] + 1 >= len(lines):
        raise InputError(KEY, str(path), "is a dump without ITEM: NUMBER OF ATOMS and ITEM: ATOMS in its last frame")
    names = [name.lower() for name in lines[heads[-1]].split()[2:]]
    count = _whole(path, lines[counts[-1] + 1])
    rows = [line.split() for line in lines[heads[-1] + 1 :] if line.strip()]
    if len(rows) != count:
        raise InputError(
            KEY, str(path), f"is cut short: {len(rows)} rows in its last frame, where {count} atoms are due"
        )
    # columns of words, such as the element's name, are left alone
    placed = {axis + kind for axis in "xyz" for kind in ("", "u", "s", "su")}
    wanted = [name for name in names if name in {"id", "radius", "diameter", *placed}]
    at = [names.index(name) for name in wanted]
    if any(len(row) != len(names) for row in rows):
        raise InputError(KEY, str(path), f"has rows that are not of {len(names)} columns, as its ITEM: ATOMS says")
    table = _numbers(path, [[row[i] for i in at] for row in rows], len(at))
    if "id" in wanted:
        table = table[np.argsort(table[:, wanted.index("id")], kind="stable")]
    columns = {name: table[:, i] for i, name in enumerate(wanted)}
    for kind in ("u", "s", "su"):
        if not set("xyz") <= columns.keys() and {name + kind for name in "xyz"} <= columns.keys():
            places = [columns[name + kind] for name in "xyz"]
            columns |= dict(
                zip("xyz", places if kind == "u" else _unscaled(path, lines, heads[-1], places), strict=True)
            )
    scale = _unit_of_length(path, lines)
    lengths = {name: scale * values for name, values in columns.items() if name in ("radius", "diameter", *"xyz")}
    return _places(path, lengths)


def _unit_of_length(path: str | Path, lines: list[str]) -> float:
    """Metres of the unit that `ITEM: UNITS` names; 1 where there is none, or numbers without a unit (lj)."""
    at = next((number for number, line in enumerate(lines) if line.startswith("ITEM: UNITS")), None)
    name = "si" if at is None or at + 1 >= len(lines) else lines[at + 1].strip()
    units = {"si": 1.0, "lj": 1.0, "cgs": 1e-2, "micro": 1e-6, "nano": 1e-9, "real": 1e-10, "metal": 1e-10}
    if name not in units:
        raise InputError(KEY, str(path), f"has ITEM: UNITS {name!r}, which is none of {', '.join(units)}")
    return units[name]


def placed_bounds(path: str | Path, kind: str, axis: str) -> tuple[Any, Placement]:
    """The container of a `kind` ("box", or "slab" with a periodic side) that a dump's last ITEM: BOX BOUNDS give, and where it
    stands, its upright `axis` being that of the file.

    Raises `InputError` for a file that is no dump, a tilted box, and sides that are periodic where the container has walls.
    """
    text = text_of(KEY, Path(path))
    lines = text.splitlines()
    heads = [number for number, line in enumerate(lines) if line.startswith("ITEM: BOX BOUNDS")]
    if not heads or len(lines) < heads[-1] + 4:
        raise InputError(KEY, str(path), f"has no ITEM: BOX BOUNDS: give the sizes of the {kind}")
    kinds = lines[heads[-1]].split()[3:]
    if "xy" in kinds:
        raise InputError(KEY, str(path), f"has a tilted box: give the sizes of the {kind}")
    scale = _unit_of_length(path, lines)
    bounds = scale * _numbers(path, [line.split()[:2] for line in lines[heads[-1] + 1 : heads[-1] + 4]], 2)
    upright = "xyz".index(axis)
    across = [(upright + 1) % 3, (upright + 2) % 3]
    periodic = [kinds[side : side + 1] == ["pp"] for side in across]
    if periodic != [False, kind == "slab"]:
        sides = " and ".join("xyz"[side] for side, one in zip(across, periodic, strict=True) if one) or "neither side"
        have = "a box has four walls" if kind == "box" else f"a slab of this axis has walls in {'xyz'[across[0]]} alone"
        raise InputError(KEY, str(path), f"is periodic in {sides}, and {have}: give --container and its sizes")
    first, second = (bounds[across, 1] - bounds[across, 0]).tolist()
    sizes = {"width": first, "depth": second} if kind == "box" else {"gap": first, "width": second}
    middle = bounds[across].mean(axis=1).tolist()
    return container(kind, sizes), Placement(axis, float(bounds[upright, 0]), (middle[0], middle[1]))


def _unscaled(path: str | Path, lines: list[str], end: Any, scaled: Any) -> list[Floats]:
    """Places from those in parts of the box; of a tilted box the dump has the limits of what bounds it (LAMMPS's manual on
    triclinic boxes)."""
    heads = [number for number, line in enumerate(lines[:end]) if line.startswith("ITEM: BOX BOUNDS")]
    if not heads or heads[-1] + 3 >= end:
        raise InputError(KEY, str(path), "has scaled coordinates without ITEM: BOX BOUNDS")
    is_tilted = lines[heads[-1]].split()[3:6] == ["xy", "xz", "yz"]
    rows = _numbers(path, [lines[heads[-1] + 1 + axis].split()[: 2 + is_tilted] for axis in range(3)], 2 + is_tilted)
    xy, xz, yz = rows[:, 2].tolist() if is_tilted else [0.0, 0.0, 0.0]
    low = rows[:, 0] - [min(0.0, xy, xz, xy + xz), min(0.0, yz), 0.0]
    high = rows[:, 1] - [max(0.0, xy, xz, xy + xz), max(0.0, yz), 0.0]
    x, y, z = scaled
    sizes = high - low
    return [low[0] + sizes[0] * x + xy * y + xz * z, low[1] + sizes[1] * y + yz * z, low[2] + sizes[2] * z]


def _read_extxyz(path: str | Path, lines: list[str]) -> Any:
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
    for name, width in zip(map(str.lower, parts[::3]), parts[2::3], strict=True):
        spans[name] = (offset, _whole(path, width))
        if not spans[name][1]:
            raise InputError(KEY, str(path), f"has no column for {name} in its Properties")
        offset += spans[name][1]
    cells = [row.split() for row in rows]
    columns: dict[str, Floats] = {}
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


def _numbers(path: str | Path, rows: Any, width: float) -> Floats:
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


def write_packing(packing: Packing, path: str | Path, extxyz: object = None, vtk: Any = None) -> None:
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
