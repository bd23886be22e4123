"""Runs beside measurements: numbers by hand, and the shipped synthetic experiment."""

import json
import shutil

import numpy as np
import pytest
from mpi4py import MPI

from porousmold import InputError, Scene, run
from porousmold.cli import main
from porousmold.experiment.comparison import average_deviation, between_steps, compare

from ..support import STUDIES

EXPERIMENT = STUDIES / "pipe" / "experiment"
NOISE = 0.3
"""K, of the synthetic measurement (synthetic.py)."""


@pytest.fixture
def folder(tmp_path):
    return written_run(tmp_path)


def written_run(folder, warmer=0.0):
    """A folder that holds a history of sensors a, which rises by 10 K, and b, where the temperature falls by 2 K/mm."""
    folder.mkdir(exist_ok=True)
    (folder / "history.csv").write_text("time [s],sensor_a [K],sensor_b [K],gradient_a [K/m],gradient_b [K/m]\n"
                                        f"0.0,{300 + warmer},{310 + warmer},0.0,2000.0\n"
                                        f"10.0,{310 + warmer},{310 + warmer},0.0,2000.0\n")  # fmt: skip
    return folder


def test_deviations_are_those_of_eq_7_30(folder):
    """Sensor a is 1 K above and 1 K below, b always 2 K above: S_ave 1.5 K; what lies outside the run does not count."""
    measured = folder / "measured.csv"
    measured.write_text("time [s], b [degC], a [degC]\n2.5, 34.85, 30.35\n7.5, 34.85, 33.35\n99, 0, 0\n")
    a, b = compare(folder, measured).deviations
    assert (a.average, a.bias, a.largest) == pytest.approx((1.0, 0.0, 1.0))
    assert (b.average, b.bias, b.largest) == pytest.approx((2.0, 2.0, 2.0))
    assert average_deviation([a, b]) == pytest.approx(1.5)
    assert main(["compare", str(folder), str(measured)]) == 0
    assert json.loads((folder / "comparison.json").read_text())["sensors"]["b"]["bias"] == pytest.approx(2.0)
    assert (folder / "comparison.png").is_file()


def test_what_a_logger_writes_for_none_is_no_temperature(folder, capsys):
    measured = folder / "measured.csv"
    measured.write_text("time [s], a [degC]\n2.5, 30.35\n7.5, -9999\n")
    assert main(["compare", str(folder), str(measured)]) == 2
    assert "at 7.5 s: no temperature" in capsys.readouterr().err


def test_measurements_may_come_in_several_files(folder, capsys):
    for name, value in (("a", 31.85), ("b", 34.85)):
        (folder / f"{name}.csv").write_text(f"time [s], {name} [degC]\n5.0, {value}\n")
    files = [str(folder / f"{name}.csv") for name in ("a", "b")]
    assert main(["compare", str(folder), *files]) == 0
    assert set(json.loads((folder / "comparison.json").read_text())["sensors"]) == {"a", "b"}
    assert main(["compare", str(folder), *files, files[0]]) == 2
    assert "a second time" in capsys.readouterr().err


def test_uncertainties_are_those_of_place_and_bounds(folder):
    """b: 0.5 mm x 2 K/mm and 1.5 K between the runs, with 1.1 K of the sensor within hypot(1.1, 1.0, 1.5) = 2.11 K."""
    measured = folder / "measured.csv"
    measured.write_text("time [s], b [degC], a [degC]\n2.5, 38.94, 30.35\n7.5, 38.98, 33.35\n")
    bounds = [written_run(folder / str(warmer), warmer) for warmer in (1.5, -0.5)]
    a, b = compare(folder, measured, bounds).deviations
    assert a.uncertainty == pytest.approx([1.5, 1.5])
    assert b.uncertainty == pytest.approx([np.hypot(1.0, 1.5)] * 2)
    assert list(b.within) == [True, False]
    assert main(["compare", str(folder), str(measured), "--bounds", *map(str, bounds)]) == 0
    assert json.loads((folder / "comparison.json").read_text())["sensors"]["b"]["within_errors"] == 0.5
    ends_early = folder / "1.5" / "history.csv"  # a bound that ends before the run takes no point from the comparison
    ends_early.write_text(ends_early.read_text().replace("10.0,", "5.0,"))
    shorter = compare(folder, measured, bounds).deviations[0]
    assert shorter.uncertainty == pytest.approx([4.0, 0.5])  # it rises twice as fast
    ends_early.write_text("time [s],sensor_a [K],gradient_a [K/m]\n0.0,300.0,0.0\n")
    with pytest.raises(InputError, match="--bounds"):
        compare(folder, measured, bounds)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("time [s], c [degC]\n0, 1\n1, 1\n", "'c'"),
        ("time [s], a [degC]\n50, 1\n60, 1\n", "no time"),
        ("time [s], a [m]\n0, 1\n1, 1\n", "temperature"),
        ("time [s], a [K], a [K]\n0, 1, 1\n1, 1, 1\n", "different sensors"),
        ("time [s]\n0\n1\n", "nothing but the time"),
    ],
)
def test_measurements_that_do_not_fit_the_run_are_refused(folder, text, word):
    (folder / "measured.csv").write_text(text)
    with pytest.raises(InputError, match=word):
        compare(folder, folder / "measured.csv")


def test_a_gap_or_another_channel_costs_that_value_and_no_more(folder, capsys):
    measured = folder / "measured.csv"
    rows = "2.5, 30.35, ok, NaN\n5.0, , ok, 34.85\n7.5, 33.35, ERR, 34.85\n"
    measured.write_text(f"time [s], Kanal 1 [degC], room, b [degC]\n{rows}")
    columns = ["--column", "a=Kanal 1"]
    assert main(["compare", str(folder), str(measured), *columns]) == 0
    told = capsys.readouterr().out
    assert "no sensors of the run: room" in told and "2 missing value(s)" in told
    a, b = compare(folder, measured, columns={"a": "Kanal 1 [degC]"}).deviations
    assert (list(a.time), list(b.time)) == ([2.5, 7.5], [5.0, 7.5])
    assert (a.bias, b.bias) == pytest.approx((0.0, 2.0))
    assert main(["compare", str(folder), str(measured), "--column", "c=Kanal 1"]) == 2
    assert main(["compare", str(folder), str(measured), "--column", "a=Kanal 2"]) == 2
    assert main(["compare", str(folder), str(measured), *columns, "--column", "a=Kanal 2"]) == 2  # the last one counted
    told = capsys.readouterr().err
    assert "--column = 'c'" in told and "'Kanal 1'" in told and "every sensor once" in told


@pytest.mark.parametrize("offset", ["first", "36000 s"])
def test_a_clock_may_begin_with_the_run(folder, offset, capsys):
    measured = folder / "measured.csv"
    measured.write_text("time [s], a [degC]\n36000, 26.85\n36010, 36.85\n")
    assert main(["compare", str(folder), str(measured)]) == 2
    assert "36000 to 36010 s beside 0 to 10 s; --time-offset" in capsys.readouterr().err
    assert main(["compare", str(folder), str(measured), "--time-offset", offset]) == 0
    assert json.loads((folder / "comparison.json").read_text())["average_deviation"] == pytest.approx(0.0, abs=1e-9)


def test_a_run_without_sensors_is_refused(tmp_path):
    with pytest.raises(InputError, match="no history"):
        compare(tmp_path, tmp_path)
    (tmp_path / "history.csv").write_text("time [s]\n0.0\n")
    with pytest.raises(InputError, match=r"geometry\.sensors"):
        compare(tmp_path, tmp_path)


def test_the_comparison_tells_the_right_model_from_the_wrong_one(tmp_path):
    """Beside noise of 0.3 K, whose mean magnitude is 0.24 K: the model that the synthetic data come from stays below the noise
    level, a laminar one is clearly above."""
    deviations = {}
    for turbulence in ("nakayama-kuwahara", "none"):
        settings = {
            "model.turbulence": turbulence,
            "solver.mesh_refinement": 0.7,
            "output.pictures": False,
            "output.fields": False,
        }
        run(Scene.load(EXPERIMENT / "experiment.toml", settings), tmp_path / turbulence, MPI.COMM_SELF)
        deviations[turbulence] = average_deviation(
            compare(tmp_path / turbulence, EXPERIMENT / "measured_synthetic.csv").deviations
        )
    assert deviations["nakayama-kuwahara"] < NOISE
    assert deviations["none"] > 2.0 * NOISE


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("name, x [mm], y [mm]\n", "row for every"),
        ("name, x, y\na, 1, 2\n", "head"),
        ("name, x [mm], y [mm]\na, 100, 0\na, 200, 0\n", "row 3"),
        ("name, x [mm], y [mm]\na, 100, 900\n", "outside"),
        ("name, x [mm], y [mm]\na, ten, 0\n", "row 2"),
        ("name, x [mm], y [mm]\nT [1], 100, 0\n", "brackets"),
    ],
)
def test_sensors_that_are_nowhere_are_refused(tmp_path, text, word):
    for path in EXPERIMENT.iterdir():
        shutil.copy(path, tmp_path)
    (tmp_path / "sensors.csv").write_text(text)
    with pytest.raises(InputError, match=word):
        run(Scene.load(tmp_path / "experiment.toml", {"model.turbulence": "none"}), communicator=MPI.COMM_SELF)


def test_sensors_record_what_stations_do(tmp_path):
    """A sensor in the middle of the bed at half length is the station there."""
    sensors = tmp_path / "sensors.csv"
    sensors.write_text("name, x [m], y [m]\nhere, 0.3125, 0\n")
    settings = {"model.turbulence": "none", "model.flow": "plug", "operation.end_time": 1500.0}
    scene = Scene.load(EXPERIMENT.parent / "baseline.toml", settings | {"geometry.sensors": str(sensors)})
    history = run(scene, communicator=MPI.COMM_SELF).history
    assert history["sensor_here"] == pytest.approx(history["temperature_centre_L/2"], abs=1e-9)
    assert np.ptp(history["sensor_here"]) > 1.0


def test_values_at_times_that_the_run_does_not_have_are_counted(folder, capsys):
    """The run ends at 10 s."""
    measured = folder / "long.csv"
    measured.write_text("time [s], a [degC], b [degC]\n-1, 30, 30\n2.5, 30.35, 31\n5, 31, 31\n50, 60,\n")
    assert main(["compare", str(folder), str(measured)]) == 0
    assert "3 value(s) of the measurement left out, before or after the run" in capsys.readouterr().out


def test_between_long_steps_a_run_is_curved_and_has_no_extremes_of_its_own():
    """Steps of half a time constant: 1.5 K of 65 K off by straight lines, a fifth of that as it is; monotone beside a kink."""
    steps = np.linspace(0.0, 5.0, 11)
    times = np.linspace(0.0, 5.0, 401)
    exact = 65.0 * np.exp(-times)
    off = np.abs(between_steps(times, steps, 65.0 * np.exp(-steps)) - exact).max()
    assert off < 0.25 * np.abs(np.interp(times, steps, 65.0 * np.exp(-steps)) - exact).max()
    kinked = np.where(steps < 2.0, 300.0, 300.0 + 20.0 * (steps - 2.0))
    found = between_steps(times, steps, kinked)
    assert np.all(np.diff(found) >= -1e-12) and found.min() == 300.0
    assert np.array_equal(between_steps(np.array([-1.0, 9.0]), steps, kinked), kinked[[0, -1]])
