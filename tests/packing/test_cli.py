"""`porousmold pack` and `porousmold porosity` as a user meets them, and scenes on their profiles."""

import csv

import numpy as np
import pytest

from porousmold import run
from porousmold.cli import main
from porousmold.laws.porosity_profile import PorosityProfile
from porousmold.packing.files import read_packing

from ..support import STUDIES, coarse_scene, under_mpirun

PACK = ["pack", "--container", "slab", "--gap", "50 mm", "--width", "36 mm", "--bead-diameter", "5 mm"]


@pytest.fixture(scope="module")
def profile(tmp_path_factory):
    """A packing of a small slab and its profile, by the commands."""
    folder = tmp_path_factory.mktemp("packing")
    assert main([*PACK, "--bed-height", "60 mm", "--out", str(folder / "slab.h5"), "--quiet"]) == 0
    assert main(["porosity", str(folder / "slab.h5"), "--out", str(folder / "slab.csv"),
                 "--fitted", str(folder / "fitted.csv")]) == 0  # fmt: skip
    return folder / "slab.csv"


def test_profile_reads_as_a_scene_reads_it(profile):
    assert sorted(path.name for path in profile.parent.iterdir()) == ["fitted.csv", "slab.csv", "slab.h5", "slab.png"]
    raw, fitted = (
        PorosityProfile.read("bed.porosity_profile", path) for path in (profile, profile.with_name("fitted.csv"))
    )
    assert raw.volume_porosity[0] == fitted.volume_porosity[0] == 1.0
    assert 0.35 < raw.bulk_porosity < 0.45
    assert np.abs(raw.volume_porosity - fitted.volume_porosity).max() < 0.08
    rows = list(csv.reader(line for line in profile.open() if not line.startswith("#")))
    assert rows[0][3:] == ["phi_v_standard_error", "phi_a_standard_error", "samples"]


def test_scene_runs_on_the_profile(profile):
    """The profile moves the mass flow by 1.7 %; the heating time only by chance of the mesh: by 0.1 % on finer ones."""
    by_law = run(coarse_scene()).summary
    by_profile = run(coarse_scene({"bed.porosity_profile": str(profile)})).summary
    assert by_profile["heating_time"] == pytest.approx(by_law["heating_time"], rel=0.15)
    assert by_profile["mass_flow_initial"] != pytest.approx(by_law["mass_flow_initial"], rel=1e-2)
    assert abs(by_profile["energy_imbalance"]) < 1e-3


@pytest.mark.parametrize("name", ["slab_ratio_10", "cylinder_ratio_20"])
def test_shipped_profiles_read(name):
    for suffix in ("", "_fitted"):
        profile = PorosityProfile.read("bed.porosity_profile", STUDIES / "profiles" / f"{name}{suffix}.csv")
        assert 0.36 < profile.bulk_porosity < 0.42


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["--container", "cylinder", "--bead-diameter", "5 mm", "--beads", "9"], "diameter"),
        (
            ["--container", "cylinder", "--diameter", "4 mm", "--bead-diameter", "5 mm", "--beads", "9"],
            "width of the container",
        ),
        (["--container", "cylinder", "--diameter", "4 kg", "--bead-diameter", "5 mm", "--beads", "9"], "--diameter"),
        (["--container", "ball", "--diameter", "4 cm", "--bead-diameter", "5 mm", "--beads", "9"], "must be one of"),
        (["--diameter", "4 cm", "--bead-diameter", "5 mm", "--beads", "9"], "--container"),
        (["--bead-diameter", "5 mm", "--beads", "9"], "--container"),
        (["--container", "cylinder", "--diameter", "4 cm", "--beads", "9"], "--bead-diameter"),
        (["--container", "cylinder", "--diameter", "4 cm", "--bead-diameter", "5 mm", "--beads", "0"], "beads"),
        (["--container", "cylinder", "--diameter", "4 cm", "--bead-diameter", "5 mm", "--beads", "many"], "--beads"),
        (["--container", "cylinder", "--diameter", "4 cm", "--bead-diameter", "5 mm"], "beads"),
        (["--container", "cylinder", "--diameter", "4 cm", "--mixture", "5 mm", "--beads", "9"], "--mixture"),
        (
            ["--container", "cylinder", "--diameter", "4 cm", "--mixture", "5 mm:1", "6 mm:x", "--beads", "9"],
            "--mixture",
        ),
        (
            [
                "--container",
                "cylinder",
                "--diameter",
                "4 cm",
                "--bead-diameter",
                "5 mm",
                "--beads",
                "9",
                "--vtk",
                "/dev/null/a",
            ],
            "--out",
        ),
    ],
)
def test_bad_wishes_get_one_line_and_status_2(tmp_path, monkeypatch, capsys, arguments, word):
    monkeypatch.chdir(tmp_path)
    assert main(["pack", *arguments]) == 2
    error = capsys.readouterr().err
    assert word in error and error.count("\n") == 1 and "Traceback" not in error
    assert not list(tmp_path.iterdir())


def test_porosity_refuses_what_it_cannot_average(tmp_path, capsys):
    (tmp_path / "a.txt").write_text("0 0 0.1 0.001\n")
    for arguments, word in (
        (["no.h5"], "No such file"),
        ([str(tmp_path / "a.txt")], "holds no container"),
        ([str(tmp_path / "a.txt"), "--container", "cylinder", "--diameter", "5 cm", "--grid", "0"], "--grid"),
        ([str(tmp_path / "a.txt"), "--container", "cylinder", "--diameter", "5 cm"], "averaging spheres"),
        ([str(tmp_path / "a.txt"), "--bead-diameter", "0"], "--bead-diameter"),
    ):
        assert main(["porosity", *arguments, "--out", str(tmp_path / "p.csv")]) == 2
        error = capsys.readouterr().err
        assert word in error and error.count("\n") == 1


def test_mixture_by_the_command_line(tmp_path, capsys):
    out = tmp_path / "mixture.h5"
    assert main(["pack", "--container", "cylinder", "--diameter", "4 cm", "--mixture", "4 mm:0.5", "6 mm:0.5", "--fractions",
                 "number", "--beads", "60", "--out", str(out), "--vtk", str(tmp_path / "m.vtk")]) == 0  # fmt: skip
    packing = read_packing(out)
    assert sorted(np.unique(packing.diameters, return_counts=True)[1]) == [30, 30]
    assert "60 beads" in capsys.readouterr().out and (tmp_path / "m.vtk").is_file()


def test_serial_commands_end_alike_on_all_ranks(tmp_path):
    def on_two_ranks(*arguments):
        return under_mpirun(2, "-m", "porousmold", *PACK, *arguments)

    done = on_two_ranks("--beads", "40", "--out", str(tmp_path / "a.h5"))
    assert done.returncode == 0 and done.stdout.count("40 beads") == 1
    refused = on_two_ranks("--beads", "0")
    assert refused.returncode == 2 and refused.stderr.count("must be a whole number") == 1
