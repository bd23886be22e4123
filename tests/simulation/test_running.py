"""Runs as a user sees them: folder, summary, command line, physics of whole scenes."""

import csv
import json
import subprocess
import sys

import meshio
import numpy as np
import pytest
from mpi4py import MPI

from porousmold import InputError, Scene, run
from porousmold.cli import main
from porousmold.files.atomic_files import locked
from porousmold.files.xdmf import read_fields
from porousmold.laws.porosity_profile import HEAD
from porousmold.output.pictures import draw
from porousmold.output.stored import LOCK
from porousmold.simulation.observation import field_snapshots
from porousmold.simulation.snapshots import Snapshot

from ..support import ALUMINIUM, COARSE, FRP, PIPE, STUDIES, coarse_scene, problem_of, under_mpirun

SETTINGS = [word for name, value in COARSE.items() for word in ("--set", f"{name}={value}")]
KEYS = [
    *("heating_time", "heating_time_bed_side", "end_time", "mass_flow_initial", "mass_flow_final", "energy_imbalance"),
    *("energy_rev_residual", "temperature_bounds", "time_steps", "rejected_steps", "flow_solves", "newton_iterations"),
    *("unknowns", "wall_seconds", "bead_biot_number", "model", "versions", "warnings"),
]


def heated(scene):
    """Summary of a run of the scene without a folder."""
    return run(scene, communicator=MPI.COMM_SELF).summary


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A coarse run of the mold through the command line."""
    out = tmp_path_factory.mktemp("run") / "mold"
    assert main(["run", str(ALUMINIUM), *SETTINGS, "--out", str(out), "--quiet"]) == 0
    return out


def test_folder_holds_what_is_promised(folder):
    names = {path.name for path in folder.iterdir() if not path.name.startswith(".")}
    assert names == {"result.json", "history.csv", "near_wall.csv", "fields.h5", "fields.xdmf", "scene.toml",
                     "temperatures.png", "near_wall.png", "fields.png"}  # fmt: skip
    summary = json.loads((folder / "result.json").read_text())
    assert not [key for key in KEYS if key not in summary]
    assert set(summary["wall_seconds"]) == {"total", "compile", "mesh", "flow", "energy", "output"}
    assert summary["status"] == "done"
    # a coarse mesh overshoots at the first front, and says so
    assert not [text for text in summary["warnings"] if "beyond those given" not in text]
    with (folder / "history.csv").open() as file:
        head, *rows = csv.reader(file)
    assert head[0] == "time [s]" and all(cell.endswith("]") for cell in head)
    assert len(rows) == summary["time_steps"] + 1


def test_without_bounds_temperatures_pass_them_and_a_warning_says_so():
    summary = heated(coarse_scene(ALUMINIUM, {"solver.axial_cells": 9, "solver.keep_bounds": False}))
    low, high = summary["temperature_bounds"]
    assert low < 298.05 or high > 363.25
    assert [text for text in summary["warnings"] if "beyond those given" in text]


def test_scene_as_run_gives_the_same_answer_again(folder):
    again = heated(Scene.load(folder / "scene.toml"))
    assert again["heating_time"] == pytest.approx(
        json.loads((folder / "result.json").read_text())["heating_time"], rel=1e-12
    )


def test_fields_are_within_the_bounds_at_four_times(folder):
    nodes, cells, steps = read_fields(folder / "fields.xdmf")
    assert len(steps) == 4 and cells.shape[1] == 4
    summary = json.loads((folder / "result.json").read_text())
    low, high = summary["temperature_bounds"]
    for fields in steps.values():
        assert {"temperature", "bead_temperature", "velocity", "pressure", "in_bed"} <= set(fields)
        assert fields["temperature"].min() >= low - 1e-9 and fields["temperature"].max() <= high + 1e-9
        assert len(fields["temperature"]) == len(nodes)


def test_other_programs_read_all_fields_of_a_time_as_one_grid(folder):
    """meshio, which ParaView's users convert with, takes the first collection over time for all there is."""
    with meshio.xdmf.TimeSeriesReader(folder / "fields.xdmf") as reader:
        points, (cells,) = reader.read_points_cells()
        assert reader.num_steps == 4
        for step in range(4):
            _, at_points, in_cells = reader.read_data(step)
            names = {"temperature", "bead_temperature", "velocity", "pressure", "porosity", "eddy_viscosity_ratio"}
            assert names <= set(at_points) and all(len(values) == len(points) for values in at_points.values())
    (region,) = in_cells["region"]
    y = points[cells.data][:, :, 1].mean(axis=1)
    assert np.array_equal(region.ravel() == 1, y > 0.025) and set(region.ravel()) == {0.0, 1.0}
    at_wall, inside = np.isclose(points[:, 1], 0.025), points[:, 1] < 0.02
    porosity = at_points["porosity"].ravel()
    assert porosity[at_wall] == pytest.approx(1.0) and porosity[inside] == pytest.approx(0.4, rel=1e-3)
    assert (
        at_points["eddy_viscosity_ratio"].max() > 1.0 and abs(at_points["eddy_viscosity_ratio"][at_wall]).max() < 1e-9
    )


def test_fields_of_plug_flow_are_those_of_their_time(tmp_path):
    """The mass flow from velocity and density at the inlet's centre is that of the history in the middle of the last step."""
    scene = coarse_scene({"model.flow": "plug", "model.turbulence": "none", "bed.porosity_model": "constant"})
    history = run(scene, tmp_path, MPI.COMM_SELF).history
    nodes, _, steps = read_fields(tmp_path / "fields.xdmf")
    place = int(np.argmin(np.hypot(nodes[:, 0] - 0.5, nodes[:, 1])))
    assert len(steps) == 4 and np.ptp(history["mass_flow"]) > 0.02 * history["mass_flow"][0]
    for time, fields in steps.items():
        density = (101325.0 + fields["pressure"][place]) / (287.055 * fields["temperature"][place])
        flow = 0.025 * 0.4 * density * fields["velocity"][place, 0]
        step = history["step"][np.argmin(np.abs(history["time"] - time))]
        assert flow == pytest.approx(np.interp(time - step / 2, history["time"], history["mass_flow"]), rel=1e-3)


def test_pictures_can_be_drawn_again_and_only_from_a_run(folder, tmp_path):
    assert [path.name for path in draw(folder)] == ["temperatures.png", "near_wall.png", "fields.png"]
    assert main(["show", str(folder)]) == 0
    with pytest.raises(InputError, match="not the folder of a run"):
        draw(tmp_path)


@pytest.mark.parametrize(
    "arguments",
    [
        ["--set", "wall.thickness=-1"],
        ["--set", "wall.thickness"],
        ["--set", "bed.porosity_profile=nowhere.csv"],
        ["--set", "model.rev_terms=consistent"],
    ],
)
def test_bad_input_ends_with_status_2_one_line_and_no_folder(arguments, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["run", str(ALUMINIUM), *arguments, "--out", str(out)]) == 2
    printed = capsys.readouterr()
    assert printed.err.startswith("porousmold: ") and printed.err.count("\n") == 1 and printed.out == ""
    assert not out.exists()


def test_folder_that_cannot_be_made_is_found_before_the_run(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["run", str(ALUMINIUM), *SETTINGS, "--out", str(tmp_path / "file" / "out")]) == 2
    assert "cannot be written" in capsys.readouterr().err


def test_failing_solve_ends_with_status_3_and_keeps_what_was_computed(tmp_path, monkeypatch, capsys):
    from porousmold.errors import SolveError
    from porousmold.solvers.heating import TransientHeat

    step = TransientHeat.step

    def failing(self, time, length, bounds):
        if time > 100.0:
            raise SolveError("energy", time, "made to fail", "nothing")
        return step(self, time, length, bounds)

    monkeypatch.setattr(TransientHeat, "step", failing)
    out = tmp_path / "out"
    assert main(["run", str(ALUMINIUM), *SETTINGS, "--out", str(out), "--quiet"]) == 3
    assert "made to fail" in capsys.readouterr().err
    summary = json.loads((out / "result.json").read_text())
    assert summary["status"] == "failed" and "made to fail" in summary["failure"]
    assert summary["end_time"] > 100.0 and (out / "history.csv").is_file() and (out / "fields.xdmf").is_file()


def test_end_time_stops_a_run_and_says_so():
    summary = heated(coarse_scene({"operation.end_time": 200.0}))
    assert summary["heating_time"] is None and summary["end_time"] == pytest.approx(200.0)
    assert any("not heated" in text for text in summary["warnings"])


def test_module_is_a_command():
    done = subprocess.run(
        [sys.executable, "-m", "porousmold", "--help"], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0 and "run a scene" in done.stdout


def test_cooling_mirrors_heating():
    """With constant properties cooling by the same difference takes the same time."""
    constant = {
        "fluid.density": 1.0,
        "fluid.viscosity": 2e-5,
        "fluid.heat_capacity": 1000.0,
        "fluid.conductivity": 0.03,
    }
    up = heated(coarse_scene(constant))
    down = heated(
        coarse_scene({**constant, "operation.initial_temperature": 363.15, "operation.inlet_temperature": 298.15})
    )
    assert down["heating_time"] == pytest.approx(up["heating_time"], rel=1e-6)


@pytest.mark.parametrize("turbulence", ["none", "k-epsilon", "nakayama-kuwahara", "damped-nakayama-kuwahara"])
@pytest.mark.parametrize("path", [ALUMINIUM, PIPE], ids=["mold", "pipe"])
def test_every_turbulence_model_conserves_heat_and_mass(path, turbulence):
    """Heat closes whatever the flow's tolerance; mass closes to it."""
    summary = heated(coarse_scene(path, {"model.turbulence": turbulence, "solver.flow_tolerance": 1e-6}))
    assert abs(summary["energy_imbalance"]) < 1e-4 and abs(summary["mass_imbalance"]) < 1e-8
    assert summary["heating_time"] is not None


def test_turbulence_shortens_the_heating():
    """More mixing near the wall: laminar slowest, undamped bead sources fastest."""
    times = [
        heated(coarse_scene(FRP, {"model.turbulence": model}))["heating_time"]
        for model in ("none", "k-epsilon", "damped-nakayama-kuwahara", "nakayama-kuwahara")
    ]
    assert times == sorted(times, reverse=True)


@pytest.mark.parametrize("drive", ["inlet_velocity", "mass_flow"])
def test_velocity_and_mass_flow_inlets_meet_their_value(drive):
    """Superficial velocity: rho u_in over the whole cross-section, rho at the inlet's temperature and pressure."""
    tables = coarse_scene().as_tables()
    del tables["operation"]["pressure_drop"]
    tables["solver"]["flow_tolerance"] = 1e-6
    tables["operation"][drive] = {"inlet_velocity": 1.5, "mass_flow": 0.04}[drive]
    summary = heated(Scene(tables))
    if drive == "mass_flow":
        assert summary["mass_flow_final"] == pytest.approx(0.04, rel=1e-8)
    else:  # at the inlet's pressure, some 4 to 9 kPa above the outlet's
        density = summary["mass_flow_final"] / (1.5 * 0.025)
        assert 101325.0 + 4e3 < density * 287.055 * 363.15 < 101325.0 + 12e3


@pytest.mark.parametrize("drive", ["mass_flow", "inlet_velocity"])
def test_what_a_given_flow_brings_is_what_the_bed_receives(drive, tmp_path):
    """The inlet's velocity follows a given mass flow only in the mean: the heat must go with what is given, T_in(t) too."""
    inlet = tmp_path / "inlet.csv"
    inlet.write_text("time [s], temperature [degC]\n0, 25\n200, 90\n2000, 90\n")
    scene = coarse_scene(
        {
            "model.turbulence": "none",
            "operation.pressure_drop": None,
            "operation.inlet_temperature": str(inlet),
            "operation.end_time": 600.0,
            **{f"operation.{drive}": 0.04 if drive == "mass_flow" else 1.5},
        }
    )
    result = run(scene, communicator=MPI.COMM_SELF)
    assert abs(result.summary["energy_imbalance"]) < 1e-4
    assert abs(result.summary["mass_imbalance"]) < 1e-5


def test_heat_lost_along_the_pipe_is_the_integral_of_what_the_sensors_tell(tmp_path):
    """q(t, z) linear between sensors and constant beyond: two pi R int int q dz dt over the acrylic's outer surface."""
    sensors = tmp_path / "loss.csv"
    sensors.write_text("time [s], 0.1 m [W/m^2], 0.5 m [W/m^2]\n0, 0, 0\n100, -20, -60\n200, -20, -60\n")
    scene = coarse_scene(
        PIPE,
        {
            "model.turbulence": "none",
            "model.flow": "plug",
            "operation.outer_heat_flux": str(sensors),
            "operation.end_time": 200.0,
            "solver.largest_step": 25.0,
            "geometry.length": 0.6,
            "solver.axial_cells": 18,
        },
    )
    result = run(scene, communicator=MPI.COMM_SELF)
    along = 0.1 * 20.0 + 0.4 * 40.0 + 0.1 * 60.0  # int q dz at the end, W/m
    lost = 2.0 * np.pi * (0.0508 + 0.00635) * along * (0.5 * 100.0 + 100.0)
    assert result.history["heat_through_outer_wall"][-1] == pytest.approx(-lost, rel=0.01)
    assert abs(result.summary["energy_imbalance"]) < 1e-4


def test_outer_flux_and_ambient_enter_the_balance():
    """Heat loss lengthens the heating; a given flux brings its own heat, and the balance closes with both."""
    insulated = heated(coarse_scene())
    lossy = heated(
        coarse_scene(
            {
                "operation.outer_coefficient": 0.5,
                "operation.ambient_temperature": 298.15,
                "operation.heating_margin": "4 K",
            }
        )
    )
    four = heated(coarse_scene({"operation.heating_margin": "4 K"}))
    heated_outside = run(coarse_scene({"operation.outer_heat_flux": 500.0}), communicator=MPI.COMM_SELF)
    assert lossy["heating_time"] > four["heating_time"]
    assert heated_outside.heating_time < insulated["heating_time"]
    brought = heated_outside.history["heat_through_outer_wall"][-1]
    assert brought == pytest.approx(500.0 * 1.0 * heated_outside.history["time"][-1], rel=1e-9)
    assert abs(heated_outside.summary["energy_imbalance"]) < 1e-4 and abs(lossy["energy_imbalance"]) < 1e-4
    end = {"operation.end_time": 100.0}
    doubled = run(coarse_scene({"operation.outer_heat_flux": 250.0, "operation.outer_heat_flux_factor": 2.0, **end}),
                  communicator=MPI.COMM_SELF).history["heat_through_outer_wall"][-1]  # fmt: skip
    assert doubled == pytest.approx(500.0 * 1.0 * 100.0, rel=1e-9)
    with pytest.raises(InputError, match="outer_heat_flux_factor"):
        coarse_scene({"operation.outer_heat_flux_factor": 2.0})


def profile_file(tmp_path):
    """A made-up profile with phi_A above phi_V as in a packing, but by a tenth of the packing's difference.

    With the whole difference the published pressure term drives cross flows without a steady state.
    """
    s = np.linspace(0.0, 3.0, 31)
    volume = 0.4 + 0.6 * np.exp(-7.0 * s)
    area = np.minimum(volume + 0.02 * s * np.exp(-2.5 * s), 1.0)
    path = tmp_path / "profile.csv"
    rows = "\n".join(f"{a:.6f},{b:.6f},{c:.6f}" for a, b, c in zip(s, volume, area, strict=True))
    path.write_text(",".join(HEAD) + "\n" + rows + "\n")
    return str(path)


def test_rev_terms_and_their_heat_stand_in_the_balance(tmp_path):
    profile = profile_file(tmp_path)
    off, consistent, published = (
        heated(coarse_scene({"bed.porosity_profile": profile, "model.rev_terms": terms, "model.turbulence": "none"}))
        for terms in ("off", "consistent", "as-published")
    )
    assert off["energy_rev_residual"] == 0.0
    for summary in (consistent, published):
        assert summary["energy_rev_residual"] != 0.0
        assert abs(summary["energy_imbalance"]) < 1e-4
    assert len({round(s["heating_time"], 3) for s in (off, consistent, published)}) == 3


def test_a_given_mass_flow_is_what_enters_though_rev_terms_make_some(tmp_path):
    """The results had that of the outlet, up to 4 % more, and the heat given to it."""
    profile = tmp_path / "porosity.csv"
    profile.write_text(
        "wall_distance_over_bead_diameter,phi_v,phi_a\n0,.95,.95\n.3,.5,.45\n.6,.3,.28\n1,.45,.46\n1.5,.36,.35\n2,.41,.41\n"
    )
    given = {"operation.pressure_drop": None, "operation.mass_flow": 0.04, "model.turbulence": "none"}
    terms = {"bed.porosity_profile": str(profile), "model.rev_terms": "consistent"}
    summary = heated(coarse_scene(given | terms))
    assert summary["mass_flow_initial"] == pytest.approx(0.04, rel=1e-6)
    assert summary["mass_imbalance"] < -0.01
    assert any("the REV terms, which are no divergences, make" in text for text in summary["warnings"])


@pytest.mark.parametrize("flow", ["full", "developed", "plug"])
@pytest.mark.parametrize("turbulence", ["none", "damped-nakayama-kuwahara"])
def test_a_fluid_at_rest_stays_there(flow, turbulence):
    """No pressure drop: nothing moves, and no solve fails for lack of anything to solve."""
    result = run(
        coarse_scene(
            {
                "operation.pressure_drop": 0.0,
                "operation.end_time": 300.0,
                "model.flow": flow,
                "model.turbulence": turbulence,
            }
        ),
        communicator=MPI.COMM_SELF,
    )
    assert np.max(np.abs(result.history["mass_flow"])) < 1e-10
    assert abs(result.summary["heat_stored"]) < 1e-6 and abs(result.summary["heat_by_fluid"]) < 1e-6


@pytest.mark.parametrize("flow", ["full", "developed"])
def test_a_flow_that_is_switched_off_comes_back(flow, tmp_path):
    (tmp_path / "dp.csv").write_text("time [s], dp [kPa]\n0, 8\n100, 8\n110, 0\n200, 0\n210, 8\n")
    changes = {"operation.pressure_drop": str(tmp_path / "dp.csv"), "operation.end_time": 300.0}
    history = run(
        coarse_scene({"model.flow": flow, "model.turbulence": "none", **changes}), communicator=MPI.COMM_SELF
    ).history
    during = (history["time"] > 112.0) & (history["time"] < 198.0)
    assert during.any() and np.max(np.abs(history["mass_flow"][during])) < 1e-6
    assert history["mass_flow"][-1] == pytest.approx(history["mass_flow"][history["time"] < 99.0][-1], rel=0.02)


def test_liquid_and_time_dependent_inlet(tmp_path):
    series = tmp_path / "inlet.csv"
    series.write_text("time [s], T [K]\n0, 298.15\n40, 340\n60, 330\n200, 350\n")
    tables = coarse_scene(
        {
            "fluid.density": "998 kg/m^3",
            "fluid.viscosity": "1 mPa*s",
            "fluid.heat_capacity": "4182 J/kg/K",
            "fluid.conductivity": "0.6 W/m/K",
            "operation.inlet_temperature": str(series),
            "model.turbulence": "none",
            "operation.pressure_drop": "5 kPa",
        }
    )
    result = run(tables, communicator=MPI.COMM_SELF)
    times = result.history["time"]
    assert times[-1] >= 200.0 and result.heating_time > 0.0
    assert all(np.min(np.abs(times - instant)) < 1e-6 for instant in (40.0, 60.0) if instant < times[-1])
    assert abs(result.summary["energy_imbalance"]) < 1e-4
    assert result.history["mass_flow"][-1] == pytest.approx(result.history["mass_flow"][0], rel=1e-3)


def test_gmsh_mold_agrees_with_the_built_in_mesh():
    curved = STUDIES / "mold" / "curved.toml"
    ours = heated(Scene.load(ALUMINIUM))["heating_time"]
    gmsh = heated(Scene.load(curved, {"geometry.mesh": "../../meshes/mold.geo"}))["heating_time"]
    assert gmsh == pytest.approx(ours, rel=3e-3)


def test_a_folder_at_work_is_not_drawn(folder):
    with locked(folder / LOCK), pytest.raises(InputError, match="another process"):
        draw(folder)


def test_damaged_result_is_refused_by_show(folder, tmp_path, capsys):
    for text in ("{", "[]", "{}"):
        for name in ("result.json", "history.csv"):
            (tmp_path / name).write_text(text if name == "result.json" else (folder / name).read_text())
        assert main(["show", str(tmp_path)]) == 2
        error = capsys.readouterr().err
        assert "damaged" in error and error.count("\n") == 1


def test_narrow_bed_is_warned_of_and_a_wide_one_is_not():
    for bead_diameter, warned in (("6.25 mm", True), ("5 mm", False)):
        scene = coarse_scene(
            {
                "bed.bead_diameter": bead_diameter,
                "bed.allow_small_ratio": True,
                "model.turbulence": "none",
                "operation.end_time": 20.0,
            }
        )
        assert any("8.0 beads wide" in text for text in heated(scene)["warnings"]) == warned


@pytest.mark.parametrize(("bulk", "warned"), [(0.4, False), (0.45, True), (0.34, True)])
def test_a_porosity_that_spheres_do_not_pour_to_is_told(bulk, warned):
    """The mean over the section is more than 0.02 from both correlations of the mean void at this width."""
    scene = coarse_scene({"bed.bulk_porosity": bulk, "model.flow": "plug", "model.turbulence": "none"})
    assert any("poured spheres" in text for text in heated(scene)["warnings"]) == warned


def test_warnings_name_the_limits_that_a_run_touches():
    summary = heated(
        coarse_scene({"bed.bead_conductivity": 0.2, "operation.pressure_drop": "60 kPa", "model.nusselt": "pen"})
    )
    text = " ".join(summary["warnings"])
    assert "Biot" in text and "Reynolds" in text and "'pen'" in text


@pytest.mark.parametrize("flow", ["full", "developed"])
def test_reversed_flow_is_a_failure_not_an_answer(flow):
    from porousmold import SolveError

    against = {"operation.pressure_drop": 1.0, "operation.gravity": -9.81, "model.turbulence": "none"}
    with pytest.raises(SolveError, match="backwards"):
        heated(coarse_scene(against | {"model.flow": flow}))


def test_a_fault_on_one_rank_ends_them_all(tmp_path):
    """No rank waits for ever for one that has fallen out; a fault is the program's own and keeps its traceback."""
    code = (
        "import sys\nfrom mpi4py import MPI\nfrom porousmold.cli import main\n"
        "from porousmold.simulation.time_integration import Simulation\n"
        "def faulty(self, *_):\n    1 / (1 - MPI.COMM_WORLD.rank)\n    MPI.COMM_WORLD.barrier()\n"
        "Simulation.integrate = faulty\n"
        "sys.exit(main(sys.argv[1:]))\n"
    )
    ended = under_mpirun(2, "-c", code, "run", str(ALUMINIUM), *SETTINGS, "--out", str(tmp_path / "run"), timeout=60)
    assert ended.returncode not in (0, 2, 3, 130) and "ZeroDivisionError" in ended.stderr


def test_fields_of_a_run_that_stops_at_its_start_are_of_one_time():
    """Two of the same time would have one name in the file of the fields."""
    problem = problem_of(coarse_scene({"model.flow": "plug", "model.turbulence": "none"}))
    assert [time for time, _ in field_snapshots(problem, [], 0.0)] == [0.0]
    late = problem.solution.arrays()
    late = {name: array + 1.0 for name, array in late.items()}
    two = [Snapshot(0.0, 0, problem.solution.arrays()), Snapshot(600.0, 1, late)]
    many = [time for time, _ in field_snapshots(problem, two, 600.0)]
    assert len(many) == problem.specs.output.field_times and many[-1] == 600.0
    assert [time for time, _ in field_snapshots(problem, [two[0], two[1]._replace(step=9)], 600.0)] == [0.0, 600.0]
