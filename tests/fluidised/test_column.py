"""A column of beads in a gas, bead by bead: Ergun, weight, forces, heat, settling, and input that is refused."""

import json
import subprocess
import sys

import numpy as np
import pytest

from porousmold.cli import main
from porousmold.errors import InputError
from porousmold.files.atomic_files import locked
from porousmold.fluidised.column import Column
from porousmold.fluidised.column_beads import ColumnBeads
from porousmold.fluidised.column_input import ColumnInput
from porousmold.laws.drag import DRAG_LAWS
from porousmold.laws.fluidisation import (
    SUSPENSION_DRAGS,
    archimedes_number,
    suspension_drag,
    suspension_drag_of_henry,
    terminal_reynolds_number,
)
from porousmold.packing import dynamics

from ..support import under_mpirun

AIR = {"density": 1.2, "viscosity": 2e-5, "heat_capacity": 1010.0, "conductivity": 0.025}
GLASS = {"bead_density": 2500.0, "bead_heat_capacity": 840.0}
SIZES = {"width": 0.014, "depth": 0.007, "height": 0.049, "bed_height": 0.012, "bead_diameter": 1e-3}


def column(velocity, positions=None, **settings):
    return Column(ColumnInput(**{**SIZES, **AIR, **GLASS, "velocity": velocity, **settings}), positions)


def mean(run, name):
    half = run.rows[len(run.rows) // 2 :]
    return np.mean([row[name] for row in half])


@pytest.fixture(scope="module")
def fluidised():
    run = column(0.9)
    run.integrate(0.2)
    return run


def test_the_pressure_drop_is_the_weight_of_beads_that_float(fluidised):
    assert mean(fluidised, "pressure_drop") == pytest.approx(fluidised.weight, rel=0.05)
    assert mean(fluidised, "force_on_beads") == pytest.approx(mean(fluidised, "pressure_drop"), rel=0.04)
    assert mean(fluidised, "bed_height") > 1.1 * fluidised.rows[0]["bed_height"]


def test_heat_is_conserved_and_temperatures_stay_within_bounds(fluidised):
    assert abs(fluidised.rows[-1]["heat_imbalance"]) < 1e-10
    gas, beads = fluidised.gas.temperature, fluidised.beads.temperature
    for values in (gas, beads):
        assert values.min() > 293.15 - 1e-6 and values.max() < 353.15
    assert beads.mean() > 293.3
    # nearly all of the gas's heat stays in the beads: they take it up within the first cells
    taken_up = 0.9 * 1.2 * 1010.0 * 60.0 * 0.014 * 0.007 * fluidised.time
    stored = len(beads) * fluidised.given.bead_mass * 840.0 * (beads.mean() - 293.15)
    assert stored == pytest.approx(taken_up, rel=0.02)


def test_gas_of_the_beads_temperature_changes_nothing():
    run = column(0.7, inlet_temperature=293.15)
    run.integrate(0.02)
    assert np.ptp(run.gas.temperature) < 1e-8 and np.ptp(run.beads.temperature) < 1e-9


def test_no_gas_enters_where_the_floor_is_blocked():
    run = column(0.4, blocked_width=4e-3)
    run.integrate(0.01)
    up = run.gas.velocity[0][0] * run.gas.porosity[0]
    middle = run.grid.cells[1] // 2
    assert up[middle] < 0.5 * up[[0, -1]].min()
    assert abs(run.rows[-1]["heat_imbalance"]) < 1e-10


@pytest.mark.parametrize("blocked", [0.0, 1e-4, 4e-3, 6.9e-3, 7.1e-3])
def test_what_is_blocked_takes_its_share_of_the_gas(blocked):
    """It was rounded to whole nodes: 0.1 and 6.9 mm let the same gas in."""
    run = column(0.4, blocked_width=blocked)
    assert run.gas.volume_flow == pytest.approx(0.4 * SIZES["depth"] * (SIZES["width"] - blocked), rel=1e-9)


def lattice(spacing_of_cells=4):
    """Beads that leave the same porosity at every node, those at the walls included."""
    cell = SIZES["width"] / 4
    spacing = cell / spacing_of_cells
    across = (np.arange(4 * spacing_of_cells) + 0.5) * spacing - 0.5 * SIZES["width"]
    up = (np.arange(round(SIZES["height"] / spacing)) + 0.5) * spacing
    deep = np.linspace(-0.5, 0.5, 7)[:-1] * SIZES["depth"]
    return np.stack(np.meshgrid(across, deep, up, indexing="ij"), axis=-1).reshape(-1, 3)


def test_beads_that_are_held_resist_by_ergun(monkeypatch):
    """Whatever the step: what holds them does to them the opposite of what the gas does."""

    def hold(beads, gas, push, rate):
        for axis in (0, 1):
            beads._pushed[beads._name, axis] = -(push[axis] + rate * gas[axis])

    monkeypatch.setattr(ColumnBeads, "move", hold)
    for step in (0.01, 0.05, 0.2):
        run = column(0.3, lattice(), relative_step=step)
        run.integrate(0.004 + 20.0 * run.given.time_step)
        porosity = run.gas.porosity.ravel()
        assert np.ptp(porosity) < 1e-12
        coefficient = DRAG_LAWS["ergun"].coefficient(porosity[0], 1e-3, 1.2, 2e-5, 0.3 / porosity[0])
        by_ergun = coefficient * 0.3 / porosity[0] ** 2 * SIZES["height"]
        assert run.rows[-1]["pressure_drop"] == pytest.approx(by_ergun, rel=2e-3)


def test_fine_beads_at_rest_resist_by_ergun():
    """A step in which a bead would fall by a third of the gas's velocity: what holds the bed is part of the prediction."""
    d, velocity = 55e-6, 1e-3
    sizes = {"width": 20 * d, "depth": 7 * d, "height": 40 * d, "bed_height": 25 * d, "bead_diameter": d}
    run = column(velocity, **sizes, bead_density=3200.0, bead_heat_capacity=290.0, relative_step=0.1)
    assert 9.81 * run.given.time_step > 0.3 * velocity / 0.4
    run.integrate(8e-3)
    across = run.grid.parts[1] / run.grid.parts[1].sum()
    porosity = run.gas.porosity[1:6]  # nodes within the bed: neither on the floor nor at the free surface
    resistance = DRAG_LAWS["ergun"].coefficient(porosity, d, 1.2, 2e-5, velocity / porosity)
    gradient = velocity / (porosity**2 / resistance @ across)
    pressure = run.gas.pressure @ across
    by_ergun = run.grid.lengths[0] / run.grid.cells[0] * (gradient.sum() - 0.5 * (gradient[0] + gradient[-1]))
    assert pressure[1] - pressure[5] == pytest.approx(by_ergun, rel=0.02)
    assert mean(run, "force_on_beads") == pytest.approx(mean(run, "pressure_drop"), rel=0.02)
    assert abs(run.beads.velocity[0].mean()) < 0.02 * velocity


def test_a_dilute_suspension_settles_as_richardson_and_zaki_say():
    """Glass in water, 2.5 % of the volume: the velocity of a single bead times porosity^n."""
    water = {"density": 1000.0, "viscosity": 1e-3, "heat_capacity": 4180.0, "conductivity": 0.6}
    d = 5e-4
    sizes = {"width": 7e-3, "depth": 4e-3, "height": 2.8e-2, "bed_height": 1e-2, "bead_diameter": d}
    volume = 7e-3 * 4e-3 * 2.8e-2
    count = round(0.025 * volume / (np.pi / 6.0 * d**3))
    places, low, high = np.empty((count, 3)), np.array([-3.5e-3, -2e-3, 6e-3]), np.array([3.5e-3, 2e-3, 2.6e-2])
    rng, period = np.random.default_rng(2), np.array([0.0, 4e-3])
    assert dynamics.place(rng, places, np.full(count, 0.5 * d), low, high, 0.0, period, 10_000) == count
    run = column(0.0, places, **sizes, **water)
    run.integrate(0.1)
    before = run.beads.places[:, 1].mean()
    run.integrate(0.15)
    speed = (before - run.beads.places[:, 1].mean()) / 0.05
    archimedes = archimedes_number(d, 1000.0, 2500.0, 1e-3)
    single = terminal_reynolds_number(archimedes) * 1e-3 / (1000.0 * d)
    share = 0.025 * 2.8 / 2.0
    assert speed == pytest.approx(single * (1.0 - share) ** 3.5, rel=0.2)


def test_drag_of_dense_and_dilute_beds():
    """Ergun's below a porosity of 0.7, a single bead's above 0.99."""
    porosity, speed = 0.45, 0.8
    assert suspension_drag(porosity, 1e-3, 1.2, 2e-5, speed) == pytest.approx(
        DRAG_LAWS["ergun"].coefficient(porosity, 1e-3, 1.2, 2e-5, speed), rel=0.01
    )
    reynolds = 1.2 * speed * 1e-3 / 2e-5
    drag = 24.0 / reynolds * (1.0 + 0.15 * reynolds**0.687) * 0.5 * 1.2 * speed * np.pi / 4.0 * 1e-6
    solids = 1e-6
    found = suspension_drag(1.0 - solids, 1e-3, 1.2, 2e-5, speed) / solids * np.pi / 6.0 * 1e-9
    assert found == pytest.approx(drag, rel=0.01)


def test_drag_of_henry_is_dallavalles_of_a_sphere_and_at_rest_its_limit():
    for reynolds in (0.1, 10.0, 1e3):
        speed, solids = reynolds * 2e-5 / (1.2 * 1e-3), 1e-6
        drag = (0.63 + 4.8 / np.sqrt(reynolds)) ** 2 * 0.5 * 1.2 * speed * np.pi / 4.0 * 1e-6
        found = suspension_drag_of_henry(1.0 - solids, 1e-3, 1.2, 2e-5, speed) / solids * np.pi / 6.0 * 1e-9
        assert found == pytest.approx(drag, rel=1e-5)
    creeping = 0.75 * 0.6 * 0.4**-1.8 * 4.8**2 * 2e-5 / (0.4 * 1e-6)  # 3/4 C_d (1-phi) rho |u-v|/d, Re to 0
    assert suspension_drag_of_henry(0.4, 1e-3, 1.2, 2e-5, 0.0) == pytest.approx(creeping, rel=1e-12)
    assert suspension_drag_of_henry(0.4, 1e-3, 1.2, 2e-5, 1e-9) == pytest.approx(creeping, rel=1e-3)


def test_a_bed_at_rest_takes_the_drag_and_the_film_that_are_chosen(monkeypatch):
    """Of a lattice that is held: the pressure drop over Gidaspow's, and how fast the beads warm up."""
    monkeypatch.setattr(ColumnBeads, "move", lambda *ignored: None)
    runs = [column(0.05, lattice(), **laws) for laws in ({}, {"drag": "di-felice", "nusselt": "henry"})]
    for run in runs:
        run.integrate(2e-3)
    porosity, slip = runs[0].gas.porosity[0, 0], runs[0].gas.velocity[0].mean()
    laws = [SUSPENSION_DRAGS[run.given.drag](porosity, 1e-3, 1.2, 2e-5, slip) for run in runs]
    drops = [run.rows[-1]["pressure_drop"] for run in runs]
    assert drops[1] / drops[0] == pytest.approx(laws[1] / laws[0], rel=0.02)
    gained = [run.beads.temperature[run.beads.places[:, 1] < 4e-3].mean() - 293.15 for run in runs]
    assert abs(gained[1] / gained[0] - 1.0) > 0.01


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"drag": "syamlal"}, "--drag = 'syamlal': must be one of gidaspow, di-felice"),
        ({"nusselt": "gunn"}, "--nusselt = 'gunn': must be one of wakao"),
        ({"width": 5e-3}, "--width = 0.005: must be >= 0.008 m"),
        ({"height": 0.01}, "--height = 0.01: must be >="),
        ({"cell_size": 1.0}, "--cell-size = 1.0: must be >= 2"),
        ({"blocked_width": 0.02}, "--blocked-width = 0.02: must be >= 0"),
        ({"friction": -1.0}, "--friction = -1.0: must be >= 0"),
        ({"velocity": -1.0}, "--velocity = -1.0: must be >= 0"),
        ({"depth_coefficient": -1.0}, "--depth-coefficient = -1.0: must be >= 0"),
        ({"smallest_diameter": 2e-3}, "--smallest-diameter = 0.002: must be >= 0.0004 and <= 0.001"),
        ({"depth": 5e-4}, "--depth = 0.0005: must be >= 0.001"),
        ({"depth": 1.1e-3}, r"--depth = 0.0011: must be <= 0.001 m \(one layer of beads\) or >= 0.007 m"),
        ({"bead_density": 1.0}, "float"),
    ],
)
def test_bad_input_is_refused(settings, message):
    with pytest.raises(InputError, match=message):
        ColumnInput(**{**SIZES, **AIR, **GLASS, "velocity": 0.5, **settings})


@pytest.mark.parametrize("more", [{}, {"depth": 0.9e-3, "smallest_diameter": 0.8e-3}], ids=["deep", "one layer, mixed"])
def test_it_goes_on_from_a_checkpoint_to_the_same_numbers(tmp_path, more):
    once, first = column(0.9, **more), column(0.9, **more)
    once.integrate(0.02)
    first.integrate(0.01)
    first.save(tmp_path / "checkpoint.npz", {})
    with np.load(tmp_path / "checkpoint.npz") as saved:
        second = Column.restored(first.given, saved)
    second.integrate(0.02)
    assert second.rows == once.rows and (second.beads.places == once.beads.places).all()


def command(out, seconds):
    sizes = {"width": 10, "depth": 7, "height": 30, "bed-height": 8, "bead-diameter": 1}
    words = ["fluidise", *(word for name, value in sizes.items() for word in (f"--{name}", f"{value} mm"))]
    return [*words, "--beads", "glass", "--velocity", "0.8 m/s", "--time", f"{seconds} s", "--out", str(out)]


def test_the_command_writes_history_summary_and_pictures(tmp_path, capsys):
    out = tmp_path / "column"
    assert main([*command(out, 0.01), "--animate"]) == 0
    assert "of the weight of the beads" in capsys.readouterr().out
    assert sorted(path.name for path in out.iterdir()) == ["column.gif", "column.png", "history.csv", "result.json"]
    assert json.loads((out / "result.json").read_text())["steps"] > 10
    layer = ["--depth", "0.9 mm", "--smallest-diameter", "0.8 mm", "--wall-coefficient", "350 W/m^2/K",
             "--depth-coefficient", "40 kW/m^3/K", "--depth-drag", "1.07 kg/m^3/s"]  # fmt: skip
    assert main([*command(tmp_path / "layer", 0.01), *layer, "--quiet"]) == 0
    assert json.loads((tmp_path / "layer" / "result.json").read_text())["heat_imbalance"] < 1e-10
    assert main(command(out, 0)) == 2
    assert "--time" in capsys.readouterr().err
    assert main([*command(out, 0.01), "--fluid", "honey"]) == 2
    assert "--fluid = 'honey'" in capsys.readouterr().err


@pytest.mark.parametrize(("velocity", "is_told"), [("0.2 m/s", True), ("0.9 m/s", False)])
def test_few_cells_of_a_bed_at_rest_are_told(tmp_path, capsys, velocity, is_told):
    """Its pressure drop was 18 % below Ergun's in 4 cells, in silence."""
    assert main([*command(tmp_path / "bed", 0.03), "--velocity", velocity]) == 0
    assert ("cells high" in capsys.readouterr().out) == is_told


def test_a_time_below_a_step_and_a_fluid_in_another_phase_are_refused(tmp_path, capsys):
    short = [*command(tmp_path / "short", 1e-6)]
    assert main(short) == 2 and "half a time step" in capsys.readouterr().err
    assert main([*command(tmp_path / "wet", 0.01), "--fluid", "steam"]) == 2
    assert "condenses" in capsys.readouterr().err


def test_a_folder_keeps_the_result_of_another_column(tmp_path, capsys):
    out = tmp_path / "column"
    assert main([*command(out, 0.005), "--quiet"]) == 0
    kept = json.loads((out / "result.json").read_text())
    assert kept["input"]["velocity"] == 0.8
    with locked(out / ".lock"):
        assert main([*command(out, 0.005), "--quiet"]) == 2
    assert "in use" in capsys.readouterr().err
    assert main([*command(out, 0.005), "--friction", "0.1", "--quiet"]) == 2
    assert (
        "result of another column" in capsys.readouterr().err and json.loads((out / "result.json").read_text()) == kept
    )
    assert main([*command(out, 0.005), "--friction", "0.1", "--quiet", "--force"]) == 0
    assert json.loads((out / "result.json").read_text())["input"]["friction"] == 0.1


def test_the_command_runs_on_two_ranks_as_on_one(tmp_path):
    """PETSc is initialised by all ranks: rank 0 alone got what the others waited for, and they died."""
    assert under_mpirun(2, "-m", "porousmold", *command(tmp_path / "two", 0.005), "--quiet").returncode == 0
    assert main([*command(tmp_path / "one", 0.005), "--quiet"]) == 0
    assert (tmp_path / "two" / "history.csv").read_text() == (tmp_path / "one" / "history.csv").read_text()


STOPPED = """
import os, signal, sys
from porousmold.cli import main
from porousmold.fluidised.column import Column

step = Column.step

def stopped_after_ten(self):
    step(self)
    if len(self.rows) == 10:
        os.kill(os.getpid(), signal.SIGTERM)

Column.step = stopped_after_ten
sys.exit(main(sys.argv[1:]))
"""


def test_a_stopped_command_goes_on(tmp_path, capsys):
    """The same command after SIGTERM ends with what one in one go gives; another one is refused."""
    out, whole = tmp_path / "stopped", tmp_path / "whole"
    words = [sys.executable, "-c", STOPPED, *command(out, 0.02), "--animate"]
    ended = subprocess.run(words, capture_output=True, text=True, timeout=200)
    assert ended.returncode == 130 and "the same command goes on from there" in ended.stderr
    assert [path.name for path in out.iterdir()] == ["checkpoint.npz"]
    assert main([*command(out, 0.02), "--seed", "2"]) == 2
    assert "checkpoint.npz': is a checkpoint of another column" in capsys.readouterr().err
    assert main(command(out, 1e-3)) == 2
    assert "--time = 0.001: must be >= 0.0" in capsys.readouterr().err
    (tmp_path / "damaged").mkdir()
    (tmp_path / "damaged" / "checkpoint.npz").write_text("nothing")
    assert main(command(tmp_path / "damaged", 0.02)) == 2
    assert "is damaged; delete it" in capsys.readouterr().err
    assert (
        main([*command(out, 0.02), "--animate", "--quiet"])
        == main([*command(whole, 0.02), "--animate", "--quiet"])
        == 0
    )
    for name in ("history.csv", "column.gif", "result.json"):
        assert (out / name).read_bytes() == (whole / name).read_bytes()
    assert not (out / "checkpoint.npz").exists()


def test_one_layer_of_a_mixture_floats_and_its_walls_take_its_heat():
    """Beads of 0.8 to 1 mm, one layer: weight, plane motion, sizes kept, heat closed with what walls take; goes on alike."""
    warm = {"initial_temperature": 363.15, "inlet_temperature": 363.15, "wall_temperature": 290.0}
    lost = {"wall_coefficient": 350.0, "depth_coefficient": 4e4, "depth_drag": 1.067}
    run = column(0.9, depth=0.9e-3, bed_height=0.02, width=0.03, smallest_diameter=0.8e-3, **warm, **lost)
    diameters = np.sqrt(run.beads.surfaces / np.pi)
    assert diameters.min() == pytest.approx(0.8e-3) and diameters.max() == pytest.approx(1e-3)
    assert run.beads.sauter_diameter == pytest.approx((diameters**3).sum() / (diameters**2).sum())
    run.integrate(0.35)
    late = [row["pressure_drop"] for row in run.rows if row["time"] > 0.2]  # the start lifts the whole bed
    assert np.mean(late) == pytest.approx(run.weight, rel=0.05)
    assert np.sort(np.sqrt(run.beads.surfaces / np.pi)) == pytest.approx(np.sort(diameters))
    last = run.rows[-1]
    assert abs(last["heat_imbalance"]) < 1e-10
    # nearly uniform: what walls take is that of a bed at its temperature, up to its height, and of the gas above it
    in_bed = 0.35 * 73.0 * (4e4 * 0.03 + 2.0 * 350.0) * 0.9e-3 * run.rows[0]["bed_height"]
    assert 0.9 * in_bed < last["heat_to_walls"] < 3.0 * in_bed
    assert last["bead_temperature"] < 362.5 and last["outlet_temperature"] < last["bead_temperature"]


def test_beads_of_several_sizes_are_packed_in_a_deep_slab():
    """As many of each size; the bed holds about 0.6 of solid."""
    run = column(0.1, smallest_diameter=0.7e-3)
    diameters = np.sqrt(run.beads.surfaces / np.pi)
    assert np.mean(diameters) == pytest.approx(0.85e-3, rel=0.02)
    solid = run.beads.volumes.sum() / (0.014 * 0.007 * 0.012)
    assert 0.5 < solid < 0.66
