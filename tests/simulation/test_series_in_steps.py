"""Series as time steps follow them: loggers, noise, pulses, clock times, and changes that come late."""

import numpy as np
import pytest

from porousmold import InputError, Scene, run
from porousmold.scene.series import MOST_ROWS, TimeSeries

from ..support import coarse_scene
from .test_error_control import COLD, HOT, bed_at_rest


def test_a_fast_logger_takes_no_step_a_row():
    """Ten thousand rows 1 ms apart: their integral stays, and the steps are those of a few hundred rows."""
    times = np.arange(10001) * 1e-3
    values = 298.15 + 65.0 * np.minimum(times / 5.0, 1.0) + 0.1 * np.sin(40.0 * times)
    series = TimeSeries(tuple(times), tuple(values))
    thinned = series.thinned(1e5, 65.0)
    assert len(thinned.times) <= MOST_ROWS + 2
    assert np.sum(np.diff(thinned.times) * (np.array(thinned.values)[1:] + thinned.values[:-1]) / 2.0) == pytest.approx(
        np.sum(np.diff(times) * (values[1:] + values[:-1]) / 2.0), rel=1e-12
    )
    few = TimeSeries((0.0, 1.0, 1.001, 50.0), (1.0, 1.0, 2.0, 2.0))
    assert few.thinned(1e5, 2.0) is few
    straight = TimeSeries(tuple(times), tuple(300.0 + 7.0 * np.minimum(times, 5.0))).thinned(1e5, 35.0)
    assert straight.times == (0.0, 5.0, 10.0) and straight.values == pytest.approx((300.0, 335.0, 335.0))


def test_the_noise_of_a_thermocouple_takes_no_step_a_row():
    """Two hours of a reading each second that scatters by 1 K of 65 K, alone in its scene: the wall follows the mean."""
    times = np.arange(0.0, 7200.0)
    noisy = (times, 363.15 + np.random.default_rng(3).normal(0.0, 1.0, len(times)))
    scene = coarse_scene({"model.flow": "plug", "model.turbulence": "none"})
    result = run(scene.changed({"operation.inlet_temperature": noisy}))
    steady = run(scene.changed({"solver.step_refinement": 4.0}))  # rows close together
    assert result.summary["time_steps"] < 900
    expected = np.interp(result["time"], steady["time"], steady["lowest_wall"])
    assert np.max(np.abs(np.array(result["lowest_wall"]) - expected)[result["time"] < steady["time"][-1]]) < 0.3


def test_pulses_and_reversals_are_no_noise():
    """A row each second for two days: what jumps stays as it is, up to the end that a run has; noise beside it is averaged."""
    times = np.arange(0.0, 172800.0)
    values = np.where(times % 1200.0 < 60.0, 5e6, -5e6) + 4e4 * np.sin(times)
    thinned = TimeSeries(tuple(times), tuple(values)).thinned(5e4, 5e6)
    asked = times[times <= 5e4]
    assert len(thinned.times) < 800 and 5e4 <= thinned.times[-1] < 5e4 + 500.0
    found = np.interp(asked, thinned.times, thinned.values)
    assert np.max(np.abs(found - values[: len(asked)])) < 0.02 * 5e6
    short = TimeSeries(tuple(times[:50002]), tuple(values[:50002])).thinned(5e4, 5e6)
    assert short.times == thinned.times and short.values == thinned.values


def test_a_run_does_not_know_what_its_series_say_after_its_end():
    """Flow and inlet in pulses at the same times, of a file of four days and of its first rows: the same heat."""
    end = 1200.0
    times = np.arange(0.0, 4 * 86400.0, 20.0)
    on = np.where(times % 400.0 < 60.0, 1.0, 0.0)
    found = []
    for count in (len(times), int(end / 20.0) + 2):
        series = {
            "operation.mass_flow": (times[:count], 0.01 + 0.04 * on[:count]),
            "operation.inlet_temperature": (times[:count], 303.15 + 60.0 * on[:count]),
        }
        settings = {"operation.pressure_drop": None, "operation.end_time": end, "model.flow": "plug"}
        result = run(coarse_scene(settings | {"model.turbulence": "none", **series}))
        found.append((result.summary["heat_by_fluid"], result["temperature_centre_L/2"][-1]))
    assert found[0] == pytest.approx(found[1], rel=1e-9)


def test_a_set_point_that_passes_the_temperature_of_the_wall_does_not_count_as_heated():
    """From 380 K down to 310 K and up to 360 K again, each within a second: the wall, between them, is passed twice."""
    times, values = [0.0, 1200.0, 1201.0, 1500.0, 1501.0], [380.0, 380.0, 310.0, 310.0, 360.0]
    given = {"initial_temperature": 300.0, "inlet_temperature": [times, values], "heating_margin": 1.0}
    scene = coarse_scene().changed({f"operation.{name}": value for name, value in given.items()})
    for refinement in (1.0, 8.0):  # the more so the shorter the steps
        result = run(scene.changed({"solver.step_refinement": refinement}))
        low = np.interp([1200.0, 1501.0], result["time"], result["lowest_wall"])
        assert np.all(low > 312.0) and np.all(low < [378.0, 358.0])
        assert result.heating_time > 1600.0


def test_a_series_of_clock_times_is_refused_and_one_that_never_began_is_told(tmp_path):
    """Seconds of a calendar, or a logger's time of day, would be the first value for ever."""
    given = {"operation.end_time": 7200.0, "operation.inlet_temperature": [[1.7096e9, 1.7097e9], [298.15, 363.15]]}
    with pytest.raises(InputError, match="begins at 1709600000 s, after the run's end at 7200 s"):
        coarse_scene(given)
    late = {
        "operation.end_time": "20 h",
        "operation.heating_margin": 20.0,
        "operation.outer_coefficient": 5.0,
        "operation.ambient_temperature": [[36000.0, 36060.0], [293.0, 300.0]],
    }
    warnings = run(coarse_scene(late)).summary["warnings"]
    assert any("ambient_temperature begins at 36000 s, after the run's end" in warning for warning in warnings)


def test_missing_values_of_a_file_are_told(tmp_path):
    path = tmp_path / "inlet.csv"
    path.write_text("time [s],inlet [degC]\n0,25\n60,55.5\n120,\n180,90\n")
    warnings = run(coarse_scene({"operation.inlet_temperature": str(path)})).summary["warnings"]
    assert any("operation.inlet_temperature: 1 missing value" in warning for warning in warnings)


def test_steps_grow_when_nothing_changes_any_more():
    """A bed at rest that its wall has heated keeps its temperatures for days: steps that cross them, and see the next change."""
    day = 86400.0
    given = {"model.wall": "fixed-temperature", "operation.end_time": 40.0 * day}
    late = {"operation.wall_temperature": ([0.0, 20.0 * day, 20.0 * day + 600.0], [HOT, HOT, COLD + 30.0])}
    result = run(bed_at_rest(given | late))
    assert result.summary["time_steps"] < 400
    assert max(np.diff(result["time"])) > 2.0 * day
    assert result["lowest_bed"][-1] == pytest.approx(COLD + 30.0, abs=0.01)
    assert result["highest_bed"][-1] == pytest.approx(COLD + 30.0, abs=0.01)
    fixed = run(bed_at_rest(given | {"operation.wall_temperature": HOT, "solver.largest_step": day}))
    assert max(np.diff(fixed["time"])) <= day * (1.0 + 1e-9)


@pytest.mark.parametrize("course", ["wave", "noise"])
def test_rows_that_bend_a_course_by_little_do_not_restart_the_steps(course):
    """Every half hour a row of a slow wave of the wall's temperature, or of noise that is little beside the 60 K of heating:
    steps end there, and go on as they are, but for halves and quarters of the rows (a restart takes a 20th of them)."""
    times = np.linspace(0.0, 86400.0, 49)
    wave = 5.0 * np.sin(2.0 * np.pi * times / 86400.0)
    wave = HOT + (wave if course == "wave" else 0.5 * np.random.default_rng(1).random(len(times)))
    given = {"model.wall": "fixed-temperature", "operation.end_time": times[-1]}
    result = run(bed_at_rest(given | {"operation.wall_temperature": (times, wave)}))
    steps = np.diff(result["time"])[result["time"][:-1] > 7200.0]
    assert steps.min() > 0.24 * 1800.0 and len(steps) < 4 * 44
    assert max(abs(result["highest_bed"] - np.interp(result["time"], times, wave))[result["time"] > 7200.0]) < 1.0


def test_a_pause_of_the_pump_does_not_spread_a_front():
    """Water that stops and flows again within a first step: the front goes on as it was (backward Euler steps after each change,
    as there were, spread it by 2 %, and were more)."""
    pause = ([0.0, 5.2, 5.33, 7.8, 7.93], [640.0, 640.0, 0.0, 0.0, 640.0])
    scene = Scene(
        {
            "geometry": {"kind": "mold", "length": 0.236, "cavity_height": 0.0423},
            "bed": {"bead_diameter": 0.00187, "bead_material": "aluminium", "porosity_model": "constant"},
            "fluid": {"material": "water"},
            "operation": {"initial_temperature": 341.4, "inlet_temperature": 336.4, "pressure_drop": pause},
            "model": {"flow": "developed", "turbulence": "none"},
            "wall": {"material": "frp", "thickness": 0.0067},
        }
    ).changed({"bed.bulk_porosity": 0.4476, "operation.end_time": 13.0})
    result, finer = (run(scene.changed({"solver.step_refinement": steps})) for steps in (1.0, 4.0))
    for place in ("centre_L", "bed_side_L"):
        assert result[f"temperature_{place}"][-1] == pytest.approx(finer[f"temperature_{place}"][-1], abs=3e-3 * 5.0)
    assert result.summary["time_steps"] < 40
