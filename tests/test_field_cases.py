"""What users of other programs brought in public, with the right values (tests/field_cases/README.md)."""

import csv
import json
import subprocess
import sys

import numpy as np
import pytest
from mpi4py import MPI
from scipy.special import ive

from porousmold import InputError, Scene, run
from porousmold.cli import main
from porousmold.packing.container import Cylinder
from porousmold.packing.files import Placement, read_packing

from .support import FIELD_CASES, MESHES, STUDIES

PLACES = {"floor.dump": Placement(floor=-0.1), "yaxis.dump": Placement("y")}
PACKINGS = sorted(
    path
    for folder in ("02-triclinic-scaled-dump", "03-yade-id-format", "20-csv-packings")
    for path in (FIELD_CASES / folder).iterdir()
    if path.name != "README"
)


@pytest.mark.parametrize("path", PACKINGS, ids=lambda path: path.name)
def test_one_packing_in_many_writings(path):
    packing, left_out = read_packing(path, Cylinder(0.06), None, PLACES.get(path.name)).settled()
    assert left_out == 0 and len(packing.diameters) == 1798
    assert packing.void_fraction(0.055) == pytest.approx(0.4169, abs=2e-4)


def schumann(transfer_units, eta):
    """Temperature of the fluid at the outlet of a cold store, over the inlet's, at a time eta (Schumann 1929)."""
    root = np.linspace(0.0, np.sqrt(transfer_units), 20001)
    integrand = np.exp(-((root - np.sqrt(eta)) ** 2)) * ive(0, 2.0 * root * np.sqrt(eta)) * 2.0 * root
    return 1.0 - np.trapezoid(integrand, root) if hasattr(np, "trapezoid") else 1.0 - np.trapz(integrand, root)


def test_a_store_of_stones_is_charged_as_schumann_says():
    result = run(
        Scene.load(FIELD_CASES / "05-schumann-tes" / "tes.toml", {"output.pictures": False}), communicator=MPI.COMM_SELF
    )
    mass_flux, prandtl = 0.01 / (np.pi * 0.09 / 4.0), 3e-5 * 1005.0 / 0.04
    film = (2.0 + 1.1 * (mass_flux * 0.02 / 3e-5) ** 0.6 * prandtl ** (1 / 3)) * 0.04 / 0.02 * 6.0 * 0.6 / 0.02
    times, outlet = np.array(result["time"]), np.array(result["outlet_temperature"])
    exact = [
        298.15 + 475.0 * schumann(film / (mass_flux * 1005.0), film * (time - 0.4 / mass_flux) / (0.6 * 4e6))
        if time > 60.0
        else 298.15
        for time in times
    ]
    assert np.max(np.abs(outlet - exact)) < 2.5
    assert np.sqrt(np.mean((outlet - exact) ** 2)) < 1.0


LOGGER = FIELD_CASES / "08-logger-csv"
REFUSED = {
    *("desc.csv", "dup.csv", "epoch.csv", "epoch_h.csv", "meta.csv", "over.csv", "thirdcol.csv"),
    *("thousand.csv", "thousand2.csv", "thousandUS.csv", "err.csv", "nbsp.csv", "minutes.csv"),
}


@pytest.mark.parametrize("path", sorted(LOGGER.glob("*.csv")), ids=lambda path: path.name)
def test_a_loggers_file_is_the_good_one_or_is_refused(path):
    good = Scene.load(LOGGER / "base.toml", {"operation.inlet_temperature": str(LOGGER / "good.csv")})
    try:
        scene = Scene.load(LOGGER / "base.toml", {"operation.inlet_temperature": str(path)})
    except InputError as error:
        assert path.name in REFUSED and "\n" not in str(error)
        return
    assert path.name not in REFUSED
    times = np.array([0.0, 60.0, 180.0, 3600.0])
    series = [scene.operation.inlet_temperature, good.operation.inlet_temperature]
    found, expected = (np.array([one(time) for time in times]) for one in series)
    if path.name == "K.csv":  # kelvins by the head, which are far too cold
        expected = expected - 273.15
    if path.name == "ms_neg.csv":
        found[0] = expected[0]  # it began before the run
    assert found == pytest.approx(expected, abs=0.5)


@pytest.mark.parametrize(("drag", "flow"), [("ergun", 0.01073), ("kta", 0.01184), ("carman", 0.01206)])
def test_a_gas_that_expands_along_the_bed(drag, flow):
    scene = Scene.load(
        FIELD_CASES / "13-compressible-ergun" / "gas.toml", {"model.drag": drag, "output.pictures": False}
    )
    assert run(scene, communicator=MPI.COMM_SELF)["mass_flow"][0] == pytest.approx(flow, rel=2e-3)


def test_a_cold_gas_in_a_tube_with_a_hot_wall_becomes_as_warm_as_graetz_says():
    scene = Scene.load(
        FIELD_CASES / "10-hot-wall-tube" / "tube.toml",
        {"operation.inlet_velocity": 2.0, "model.energy": "one-temperature", "output.pictures": False},
    )
    result = run(scene, communicator=MPI.COMM_SELF)
    assert result["outlet_temperature"][-1] - 273.15 == pytest.approx(255.92, abs=0.5)
    assert result.summary["end_time"] < 1e4  # the steady state ends it


@pytest.mark.parametrize(
    ("name", "words"),
    [("mixed", "all be of one kind"), ("rz_y", "flow along x"), ("xz", "x-z plane"), ("dupnodes", "no common nodes")],
)
def test_meshes_that_do_not_fit_are_refused_in_one_line(name, words, capsys):
    scene = FIELD_CASES / "11-gmsh-users" / "scene.toml"
    assert main(["check", str(scene), "--set", f"geometry.mesh={name}.msh"]) == 2
    told = capsys.readouterr().err
    assert words in told and told.count("\n") == 1


@pytest.mark.parametrize("name", ["v41", "dupnodes"])
def test_a_mesh_of_two_parts_is_joined_to_the_answer_of_one(name):
    settings = {"geometry.mesh": f"{name}.msh", "operation.end_time": 600.0, "output.pictures": False}
    settings |= {"solver.refine_in_doubt": False}  # the value is that of the mesh as drawn
    settings |= {"geometry.join_nodes": True} if name == "dupnodes" else {}
    result = run(Scene.load(FIELD_CASES / "11-gmsh-users" / "scene.toml", settings), communicator=MPI.COMM_SELF)
    assert result["highest_wall"][-1] == pytest.approx(331.6, abs=0.1)


@pytest.mark.parametrize(("version", "binary"), [(2.2, 0), (2.2, 1), (4.0, 0), (4.1, 0), (4.1, 1)])
def test_a_mesh_in_every_format_of_gmsh_is_the_same_one(tmp_path, capsys, version, binary):
    source = FIELD_CASES / "11-gmsh-users"
    write = "import gmsh; gmsh.initialize(); gmsh.option.setNumber('General.Terminal', 0); "
    write += f"gmsh.open({str(source / 'v41.msh')!r}); gmsh.option.setNumber('Mesh.Binary', {binary}); "
    write += f"gmsh.option.setNumber('Mesh.MshFileVersion', {version}); gmsh.write({str(tmp_path / 'other.msh')!r})"
    subprocess.run([sys.executable, "-c", write], check=True)
    told = []
    for mesh in (source / "v41.msh", tmp_path / "other.msh"):
        assert main(["check", str(source / "scene.toml"), "--set", f"geometry.mesh={mesh}"]) == 0
        told.append([line for line in capsys.readouterr().out.splitlines() if line.startswith(("mesh:", "unknowns:"))])
    assert told[0] and told[0] == told[1]


def test_measured_channels_may_have_gaps_and_others_beside_them(tmp_path, capsys):
    settings = ["--set", "solver.mesh_refinement=0.5", "--set", "output.pictures=false", "--quiet"]
    assert (
        main(
            ["run", str(STUDIES / "pipe" / "experiment" / "experiment.toml"), "--out", str(tmp_path / "run"), *settings]
        )
        == 0
    )
    deviations = {}
    for name in ("extra", "gap", "nan", "semi", "offset"):
        measured = str(FIELD_CASES / "14-compare-logger" / f"{name}.csv")
        shift = ["--time-offset", "36000 s"] if name == "offset" else []
        assert main(["compare", str(tmp_path / "run"), measured, *shift]) == 0
        deviations[name] = json.loads((tmp_path / "run" / "comparison.json").read_text())["average_deviation"]
    assert list(deviations.values()) == pytest.approx([deviations["extra"]] * 5, abs=2e-3)


def test_a_falling_head_gives_the_permeability_it_was_made_with(tmp_path):
    folder = FIELD_CASES / "18-falling-head"
    words = [
        "permeability",
        str(folder / "level.csv"),
        "--setup",
        str(folder / "setup.toml"),
        "--out",
        str(tmp_path),
        "--quiet",
    ]
    assert main(words) == 0
    found = json.loads((tmp_path / "permeability.json").read_text())
    # made with water of 998 kg/m3 and 1 mPa s; the library's at 23 degC is 6.75 % thinner
    assert found["approaches"]["complete"]["global"]["permeability"] == pytest.approx(9.325e-12, rel=1e-3)


def test_a_store_is_charged_and_waits_and_is_discharged_in_one_run(tmp_path):
    """Of an insulated store nothing is lost while it waits, and a discharge gives back what the charge has brought."""
    store = FIELD_CASES / "17-tes-cycle" / "tes.toml"
    waiting = run(
        Scene.load(store, {"operation.mass_flow": "zero.csv", "output.pictures": False}), communicator=MPI.COMM_SELF
    )
    times, stored = np.array(waiting["time"]), np.array(waiting["heat_stored"])
    assert np.ptp(stored[times > 4.02 * 3600.0]) < 1e-6 * stored[-1]
    (tmp_path / "flow.csv").write_text("time [h],mass_flow [kg/s]\n0,0.01\n4,0.01\n4.01,0\n6,0\n6.01,-0.01\n40,-0.01\n")
    settings = {"operation.mass_flow": str(tmp_path / "flow.csv"), "operation.return_temperature": "25 degC"}
    settings |= {"operation.end_time": "40 h", "output.pictures": False}
    back = run(Scene.load(store, settings), communicator=MPI.COMM_SELF)
    assert abs(back["heat_stored"][-1]) < 2e-3 * max(back["heat_stored"])
    assert max(back["outlet_temperature"]) > 773.15 - 5.0  # the heat comes back as hot as it was brought


def test_a_strangers_mesh_runs_no_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["check", str(FIELD_CASES / "attacks" / "01-geo-systemcall" / "scene.toml")]) == 2
    assert "starts a process" in capsys.readouterr().err and not list(tmp_path.iterdir())


def test_an_unreachable_target_ends_at_the_steady_state():
    result = run(
        Scene.load(FIELD_CASES / "attacks" / "02-unreachable-target" / "scene.toml"), communicator=MPI.COMM_SELF
    )
    assert result.summary["end_time"] < 3e4 and list(result.summary["targets"].values()) == [None]
    assert any("steady" in text for text in result.summary["warnings"])


def test_a_mesh_of_ones_own_keeps_within_what_is_given():
    settings = {"geometry.mesh": str(MESHES / "curved_mold.geo"), "output.pictures": False}
    result = run(
        Scene.load(FIELD_CASES / "attacks" / "05-overshoot-mesh" / "scene.toml", settings), communicator=MPI.COMM_SELF
    )
    assert not [text for text in result.summary["warnings"] if "beyond those given" in text]


def test_names_are_drawn_as_text_and_are_no_formulas(tmp_path):
    scene = FIELD_CASES / "attacks" / "06-mathtext-name" / "scene.toml"
    assert main(["run", str(scene), "--out", str(tmp_path / "run"), "--quiet"]) == 0
    assert (tmp_path / "run" / "temperatures.png").is_file()
    with (tmp_path / "run" / "history.csv").open(newline="", encoding="utf-8") as file:
        assert not [cell for cell in next(csv.reader(file)) if cell.startswith(("=", "+", "-", "@"))]


@pytest.mark.parametrize(
    "name", ["08-unit-power-tower/pow", "10-toml-recursion/deep1", "10-toml-recursion/deep3", "10-toml-recursion/deep4"]
)
def test_units_and_tables_without_end_are_refused_at_once(name, capsys):
    assert main(["check", str(FIELD_CASES / "attacks" / f"{name}.toml")]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("name", ["04-pump-scaled-by-density/scene", "11-liquid-blower-cube/scene"])
def test_a_pump_never_gives_more_than_its_curve(name):
    scene = Scene.load(FIELD_CASES / "attacks" / f"{name}.toml", {"output.pictures": False})
    try:
        result = run(scene, communicator=MPI.COMM_SELF)
    except InputError:
        return
    assert max(result["pressure_drop"]) <= 1.001 * scene.operation.blower_pressure
