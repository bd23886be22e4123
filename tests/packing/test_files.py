"""Packings of other codes, each from a small file written by hand to its documented format."""

import gzip

import h5py
import meshio
import numpy as np
import pytest

from porousmold.errors import InputError
from porousmold.packing.container import Box, Cylinder, Slab
from porousmold.packing.files import Placement, check_writable, placed_bounds, read_packing, write_packing
from porousmold.packing.packing import Packing

BOX = Cylinder(0.1)
POSITIONS = np.array([[0.01, 0.02, 0.003], [-0.01, 0.0, 0.004], [0.0, -0.02, 0.005]])
DIAMETERS = np.array([0.006, 0.004, 0.002])

DUMP = """ITEM: TIMESTEP
0
ITEM: NUMBER OF ATOMS
1
ITEM: BOX BOUNDS ff ff ff
-0.05 0.05
-0.05 0.05
0 0.1
ITEM: ATOMS id type x y z radius
1 1 0 0 0 0.001
ITEM: TIMESTEP
1000
ITEM: NUMBER OF ATOMS
3
ITEM: BOX BOUNDS ff ff ff
-0.05 0.05
-0.05 0.05
0 0.1
ITEM: ATOMS type id {x} {y} {z} vx element radius
1 3 {r3} 0 X 0.001
1 1 {r1} 0 X 0.003
1 2 {r2} 0 X 0.002
"""
PLAIN = DUMP.format(x="x", y="y", z="z", r1="0.01 0.02 0.003", r2="-0.01 0 0.004", r3="0 -0.02 0.005")
SCALED = DUMP.format(x="xs", y="ys", z="zs", r1="0.6 0.7 0.03", r2="0.4 0.5 0.04", r3="0.5 0.3 0.05")
UNWRAPPED = PLAIN.replace(" x y z ", " xu yu zu ").replace("id xu yu zu radius", "id x y z radius")
YADE = "#format x_y_z_r\n0.01\t0.02\t0.003\t0.003\n-0.01\t0\t0.004\t0.002\n0\t-0.02\t0.005\t0.001\n"
EXTXYZ = """3
Lattice="1 0 0 0 1 0 0 0 1" Properties=species:S:1:velo:R:3:pos:R:3:radius:R:1 Time=0.1
X 9 9 9 0.01 0.02 0.003 0.003
X 9 9 9 -0.01 0 0.004 0.002
X 9 9 9 0 -0.02 0.005 0.001
"""
CSV = "# by hand\nid,y [mm],x [mm],z [mm],diameter [mm]\n1,20,10,3,6\n2,0,-10,4,4\n3,-20,0,5,2\n"
CSV_METRES = "x,y,z,radius\n0.01,0.02,0.003,0.003\n-0.01,0,0.004,0.002\n0,-0.02,0.005,0.001\n"
FILES = {"dump": PLAIN, "scaled.dump": SCALED, "unwrapped.lammpstrj": UNWRAPPED, "yade.txt": YADE, "a.extxyz": EXTXYZ,
         "frames.xyz": EXTXYZ.replace("0.02", "0.04") + EXTXYZ, "mm.csv": CSV, "m.csv": CSV_METRES,
         "mark.csv": "\ufeff" + CSV_METRES}  # fmt: skip


TILTED = """ITEM: UNITS
cgs
ITEM: TIMESTEP
0
ITEM: NUMBER OF ATOMS
3
ITEM: BOX BOUNDS xy xz yz pp pp ff
-6 7 2
-4 5.5 -1
-1 9 1.5
ITEM: ATOMS id type {0} radius
"""


def tilted(kind):
    """A dump of a tilted box in cm: places as parts of its sides, after LAMMPS's manual on triclinic boxes."""
    low, sides = np.array([-5.0, -4.0, -1.0]), np.array([[10.0, 2.0, -1.0], [0.0, 8.0, 1.5], [0.0, 0.0, 10.0]])
    parts = np.linalg.solve(sides, (100.0 * POSITIONS - low).T).T
    rows = [
        f"{i} 1 {x:.12g} {y:.12g} {z:.12g} {50.0 * d}"
        for i, ((x, y, z), d) in enumerate(zip(parts, DIAMETERS, strict=True))
    ]
    return TILTED.format(f"x{kind} y{kind} z{kind}") + "\n".join(rows) + "\n"


FILES |= {
    "tilted.dump": tilted("s"),
    "tilted_unwrapped.dump": tilted("su"),
    "capital.dump": PLAIN.replace("radius", "Radius"),
    "format.txt": "#format id_x_y_z_r_matId\n"
    + "".join(
        f"{i} {x} {y} {z} {0.5 * d} 0\n" for i, ((x, y, z), d) in enumerate(zip(POSITIONS, DIAMETERS, strict=True))
    ),
    "capital.extxyz": EXTXYZ.replace("pos:", "Pos:").replace("radius:", "Radius:"),
    "plain.xyz": "3\ncomment\n"
    + "".join(f"C {x} {y} {z} {0.5 * d}\n" for (x, y, z), d in zip(POSITIONS, DIAMETERS, strict=True)),
    "semicolons.csv": CSV_METRES.replace(",", ";").replace(".", ","),
    "tabs.csv": CSV_METRES.replace(",", "\t"),
    "paraview.csv": CSV_METRES.replace("x,y,z,radius", '"Points:0","Points:1","Points:2","Radius"'),
    "short_names.csv": CSV_METRES.replace("radius", "r"),
}


@pytest.mark.parametrize("name", FILES)
def test_reads_files_of_other_codes(tmp_path, name):
    path = tmp_path / name
    path.write_text(FILES[name])
    packing = read_packing(path, BOX)
    assert packing.positions == pytest.approx(POSITIONS)
    assert packing.diameters == pytest.approx(DIAMETERS)
    assert packing.container == BOX


def test_reads_what_gzip_packed(tmp_path):
    path = tmp_path / "bed.dump.gz"
    path.write_bytes(gzip.compress(PLAIN.encode()))
    assert read_packing(path, BOX).positions == pytest.approx(POSITIONS)
    path.write_bytes(gzip.compress(PLAIN.encode())[:-20])
    with pytest.raises(InputError, match="cannot be unpacked"):
        read_packing(path, BOX)


@pytest.mark.parametrize(("axis", "order"), [("x", (2, 0, 1)), ("y", (1, 2, 0)), ("z", (0, 1, 2))])
def test_a_container_may_stand_elsewhere(tmp_path, axis, order):
    moved = (POSITIONS + np.array([0.3, -0.2, 5.0]))[:, list(order)]
    np.save(tmp_path / "bed.npy", np.column_stack((moved, 0.5 * DIAMETERS)))
    placement = Placement(axis, 5.0, (0.3, -0.2))
    assert read_packing(tmp_path / "bed.npy", BOX, placement=placement).positions == pytest.approx(POSITIONS)
    with pytest.raises(InputError, match="have their centres outside"):
        read_packing(tmp_path / "bed.npy", BOX)


def test_reads_npy(tmp_path):
    np.save(tmp_path / "four.npy", np.column_stack((POSITIONS, 0.5 * DIAMETERS)))
    assert read_packing(tmp_path / "four.npy", BOX).diameters == pytest.approx(DIAMETERS)
    np.save(tmp_path / "three.npy", POSITIONS)
    assert read_packing(tmp_path / "three.npy", BOX, 0.004).diameters == pytest.approx([0.004] * 3)
    with pytest.raises(InputError, match="give the bead diameter"):
        read_packing(tmp_path / "three.npy", BOX)


def test_what_is_written_is_read_again(tmp_path):
    packing = Packing(POSITIONS, DIAMETERS, BOX, {"seed": 3})
    write_packing(packing, tmp_path / "a.h5", tmp_path / "a.extxyz", tmp_path / "a.vtk")
    again = read_packing(tmp_path / "a.h5")
    assert np.array_equal(again.positions, POSITIONS) and again.container == BOX and again.made == {"seed": 3}
    assert read_packing(tmp_path / "a.extxyz", BOX).positions == pytest.approx(POSITIONS)
    assert read_packing(tmp_path / "a.extxyz", BOX).diameters == pytest.approx(DIAMETERS)
    vertices = meshio.read(tmp_path / "a.vtk")
    assert vertices.points == pytest.approx(POSITIONS) and vertices.point_data["radius"] == pytest.approx(
        0.5 * DIAMETERS
    )
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.extxyz", "a.h5", "a.vtk"]


BROKEN = {
    "empty.dump": ("", "is empty"),
    "short.dump": (PLAIN.rsplit("\n", 2)[0] + "\n", "cut short: 2 rows"),
    "next.dump": (PLAIN + "ITEM: TIMESTEP\n2000\n", "cut short: 5 rows"),
    "noatoms.dump": ("ITEM: TIMESTEP\n0\n", "ITEM: ATOMS"),
    "columns.dump": (PLAIN.replace(" vx element radius", " radius"), "columns"),
    "noplace.dump": (PLAIN.replace(" x y z ", " a b c "), "columns x, y and z"),
    "word.dump": (PLAIN.replace("-0.02", "oops"), "no number"),
    "count.dump": (PLAIN.replace("ATOMS\n3", "ATOMS\nthree"), "whole number"),
    "bounds.dump": (SCALED.replace("ITEM: BOX BOUNDS", "ITEM: BOX"), "BOX BOUNDS"),
    "short.extxyz": (EXTXYZ.rsplit("\n", 2)[0] + "\n", "ends early: 2 of 3"),
    "words.extxyz": (EXTXYZ.replace("0.003 0.003", "0.003"), "too few columns"),
    "width.extxyz": (EXTXYZ.replace("pos:R:3", "pos:R:x"), "whole number"),
    "three.txt": ("1 2 3\n4 5 6\n", "no known format"),
    "rows.txt": ("0 0 0.1 0.1\n1 2\n", "too few columns in row 2"),
    "words.txt": ("a b c d\n", "no number"),
    "head.csv": ("a,b\n1,2\n", "columns x, y and z"),
    "empty.csv": ("x,y,z,radius\n", "holds no beads"),
    "unit.csv": (CSV.replace("x [mm]", "x [kg]"), "length"),
    "negative.csv": (CSV_METRES.replace("0,0.004,0.002", "0,0.004,-0.002"), "diameters > 0"),
    "nan.csv": (CSV_METRES.replace("-0.01,0,", "nan,0,"), "bead 2"),
    "far.csv": (CSV_METRES.replace("-0.01,0,", "-1e300,0,"), "within 1e"),
    "floor.csv": (CSV_METRES.replace("0,0.004", "0,-0.004"), "floor"),
    "zero.extxyz": (EXTXYZ.replace("radius:R:1", "radius:R:0"), "no column for radius"),
    "huge.extxyz": ("9" * 5000 + "\n" + EXTXYZ.split("\n", 1)[1], "whole number"),
    "outside.csv": (CSV_METRES.replace("0.01,0.02", "0.1,0.02"), "have their centres outside"),
    "binary.txt": (b"\x00\xff\xfe\x01" * 20, "text file"),
    "broken.npy": (b"\x93NUMPY\x01\x00v\x00rubbish", "NPY"),
    "broken.h5": (b"\x89HDF\r\n\x1a\nrubbish", "damaged"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_get_one_line(tmp_path, name):
    content, word = BROKEN[name]
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError, match=word) as caught:
        read_packing(path, BOX)
    assert "\n" not in str(caught.value) and name in str(caught.value)


def test_what_a_packing_of_its_own_holds_cannot_be_given_again(tmp_path):
    """Another container replaced its own in silence, and an axis, a floor or a bead diameter had no effect."""
    slab = Slab(0.04, 0.028)
    beads = Packing(np.array([[0.0, 0.0, 0.002], [0.004, 0.0, 0.002]]), np.full(2, 0.004), slab)
    write_packing(beads, tmp_path / "a.h5")
    assert read_packing(tmp_path / "a.h5", Slab(0.04 * (1.0 + 1e-12), 0.028), None, Placement()).container == slab
    for given in ((Slab(0.05, 0.028),), (None, 0.002), (None, None, Placement("x"))):
        with pytest.raises(InputError, match=r"holds beads in|its own"):
            read_packing(tmp_path / "a.h5", *given)
    (tmp_path / "a.csv").write_text("x,y,z,radius\n0,0,0.002,0.002\n0.004,0,0.002,0.002\n")
    with pytest.raises(InputError, match="has no effect"):
        read_packing(tmp_path / "a.csv", slab, 0.002)


def test_foreign_hdf5_is_refused(tmp_path):
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["something"] = np.zeros(3)
    with pytest.raises(InputError, match="not a packing"):
        read_packing(tmp_path / "other.h5")


def test_damaged_attributes_are_refused(tmp_path):
    for name, value in (("container", [1, 2]), ("container_sizes", "[]"), ("container_sizes", '{"diameter": "x"}'),
                        ("made", "[1]"), ("made", 3)):  # fmt: skip
        path = tmp_path / "damaged.h5"
        write_packing(Packing(POSITIONS, DIAMETERS, BOX), path)
        with h5py.File(path, "a") as file:
            file.attrs[name] = value
        with pytest.raises(InputError, match="damaged"):
            read_packing(path)


def test_container_and_file_must_be_there(tmp_path):
    (tmp_path / "yade.txt").write_text(YADE)
    with pytest.raises(InputError, match="holds no container"):
        read_packing(tmp_path / "yade.txt")
    with pytest.raises(InputError, match="No such file"):
        read_packing(tmp_path / "none.txt", BOX)


def test_paths_that_cannot_be_written_are_found_first(tmp_path):
    check_writable(tmp_path / "a.h5", tmp_path / "new" / "folder" / "a.h5", None)
    assert (tmp_path / "new" / "folder").is_dir() and not list((tmp_path / "new" / "folder").iterdir())
    (tmp_path / "file").write_text("")
    for path in (tmp_path, tmp_path / "file" / "a.h5", tmp_path / ("a" * 300)):
        with pytest.raises(InputError, match="must be a file"):
            check_writable(path)
    for paths, sources in ((("a", "a"), ()), (("a",), ("a",))):
        with pytest.raises(InputError, match="needed for another"):
            check_writable(*(tmp_path / name for name in paths), sources=[tmp_path / name for name in sources])


def test_a_few_beads_may_reach_into_a_wall_and_are_counted():
    """As ten of 22 410 beads of a published packing do."""
    heights = np.arange(1, 201) * 0.01
    positions, diameters = np.column_stack([0.0 * heights, 0.0 * heights, heights]), np.full(200, 0.01)
    positions[:2, 0] = 0.0459  # nine tenths of a millimetre into the wall: 9 % of the diameter
    assert np.flatnonzero(Packing(positions, diameters, BOX).reaching).tolist() == [0, 1]
    positions[:3, 0] = 0.0459
    with pytest.raises(InputError, match=r"3 of 200 beads.*reach into the walls.*more than 5%.*bead 1 at"):
        Packing(positions, diameters, BOX)
    positions[:3, 0] = 0.0, 0.0480, 0.0
    with pytest.raises(InputError, match=r"1 of 200 beads.*more than 25%.*bead 2 at"):
        Packing(positions, diameters, BOX)
    positions[:3, 0] = 0.0, 0.0501, 0.0
    with pytest.raises(InputError, match=r"1 of 200 beads.*have their centres outside.*bead 2 at"):
        Packing(positions, diameters, BOX)


def test_a_box_without_sizes_is_that_of_the_dump(tmp_path):
    path = tmp_path / "dump"
    path.write_text(PLAIN.replace("-0.05 0.05\n0 0.1", "-0.03 0.05\n-0.01 0.1"))
    box, placement = placed_bounds(path, "box", "z")
    assert box == Box(pytest.approx(0.1), pytest.approx(0.08))
    assert placement == Placement("z", -0.01, (pytest.approx(0.0), pytest.approx(0.01)))
    assert read_packing(path, box, None, placement).positions[0] == pytest.approx([0.01, 0.01, 0.013])
    box, placement = placed_bounds(path, "box", "y")
    assert (box.width, box.depth, placement.floor) == pytest.approx((0.11, 0.1, -0.03))
    path.write_text(PLAIN.replace("ff ff ff", "ff pp ff"))
    assert placed_bounds(path, "slab", "z")[0] == Slab(0.1, 0.1)
    for kind, axis, words in (("box", "z", "periodic in y, and a box has four walls"), ("slab", "y", "neither side")):
        with pytest.raises(InputError, match=words):
            placed_bounds(path, kind, axis)
    path.write_text(CSV)
    with pytest.raises(InputError, match="no ITEM: BOX BOUNDS"):
        placed_bounds(path, "box", "z")
