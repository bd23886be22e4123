"""Heating time inside a step."""

import numpy as np
import pytest
from mpi4py import MPI

from porousmold import InputError, Scene, run
from porousmold.files.tables import read_toml
from porousmold.simulation.heating_time import crossing_time, root_in_last_step, with_the_next

from ..support import ALUMINIUM, COARSE, coarse_scene


def test_exact_for_an_exponential_approach():
    times = [0.0, 100.0, 220.0]
    deficits = [65.0 * np.exp(-time / 60.0) for time in times]
    assert crossing_time(times, deficits, 2.0) == pytest.approx(60.0 * np.log(32.5), rel=1e-12)


def test_third_order_for_a_bent_approach():
    def deficit(time):
        return 65.0 * np.exp(-time / 60.0 - (time / 200.0) ** 2) * (1.0 + 0.3 * np.sin(time / 50.0))

    from scipy.optimize import brentq

    exact = brentq(lambda time: deficit(time) - 2.0, 50.0, 300.0)
    errors = []
    for step in (40.0, 20.0, 10.0):
        times = [exact - 1.6 * step, exact - 0.6 * step, exact + 0.4 * step]
        errors.append(abs(crossing_time(times, [deficit(t) for t in times], 2.0) - exact))
    assert errors[0] / errors[1] > 6.0 and errors[1] / errors[2] > 6.0


def test_fourth_order_with_the_step_that_follows():
    """A target that does not end the run: a sensor that a front passes was told 0.3 % of the time late by long steps."""

    def deficit(time):
        return 60.0 - 55.0 * np.tanh(time / 80.0)

    exact = 80.0 * np.arctanh(40.0 / 55.0)
    errors = []
    for step in (40.0, 20.0, 10.0):
        times = exact + step * np.array([-1.4, -0.4, 0.6, 1.6])
        found = with_the_next(times, [deficit(t) for t in times], 20.0)
        errors.append(abs(found - exact))
        before = crossing_time(times[:3], [deficit(t) for t in times[:3]], 20.0)
        assert errors[-1] < 0.5 * abs(before - exact)
    assert errors[0] / errors[1] > 10.0 and errors[1] / errors[2] > 10.0


def test_no_cubic_across_a_corner():
    """Where a phase ends, what was heated cools down again."""
    assert with_the_next([0.0, 10.0, 20.0, 30.0], [40.0, 25.0, 10.0, 30.0], 20.0) is None
    assert with_the_next([0.0, 10.0, 20.0, 30.0], [40.0, 30.0, 20.5, 10.0], 20.0) is None


def test_none_before_and_none_while_there_is_nothing_to_heat_yet():
    """An inlet that starts at the initial temperature (thesis eq. 7.17) has a deficit of 0 at first."""
    assert crossing_time([0.0, 1.0], [65.0, 60.0], 2.0) is None
    assert crossing_time([0.0], [0.0], 2.0) is None
    assert crossing_time([0.0, 1.0], [0.0, 1.0], 2.0) is None


def test_exact_where_a_quantity_changes_evenly():
    """A body that a heat flux warms passes a limit as it passes any other temperature, whatever the reference beyond it."""
    times = [0.0, 30.0, 70.0]
    for reference in (0.05, 1.0, 10.0):
        deficits = [0.1 * (60.0 - time) + reference for time in times]
        assert crossing_time(times, deficits, reference) == pytest.approx(60.0, rel=1e-12)


def test_a_value_that_is_0_but_for_rounding_is_passed_there():
    assert root_in_last_step([0.0, 10.0], [1e-13, 2.0]) == 0.0
    assert root_in_last_step([0.0, 10.0, 30.0], [-2.0, -1.0, -1e-13]) == 30.0
    assert root_in_last_step([0.0, 10.0, 30.0], [2.0, 1.0, -1.0]) == pytest.approx(20.0)


def test_linear_with_two_points():
    assert crossing_time([0.0, 10.0], [4.0, 0.0], 2.0) == pytest.approx(5.0)


def test_the_heating_time_may_be_that_of_a_layer():
    """Insulation is warm inside only: the whole wall is never heated, its tank is."""
    layers = [
        {"name": "tank", "material": "aluminium", "thickness": 0.003},
        {"name": "insulation", "material": "mineral_wool", "thickness": 0.05},
    ]
    tables = {name: dict(table) for name, table in read_toml("scene", ALUMINIUM).items() if name != "wall"}
    given = Scene({**tables, "wall": {"layer": layers}}).changed(
        {**COARSE, "model.flow": "plug", "operation.outer_coefficient": 10.0, "operation.ambient_temperature": 298.15,
         "operation.heating_margin": "6 K",
         "operation.end_time": "2 h", "output.pictures": False, "output.fields": False}
    )  # fmt: skip
    whole, tank = (
        run(given.changed({"operation.heated_place": place}), communicator=MPI.COMM_SELF) for place in ("wall", "tank")
    )
    assert whole.heating_time is None and any("the wall is" in text for text in whole.summary["warnings"])
    assert tank.heating_time == pytest.approx(
        np.interp(0.0, 6.0 - np.array(tank["deficit_tank"]), tank["time"]), rel=0.01
    )
    with pytest.raises(InputError, match="must be one of wall, bed_side, bed, tank, insulation"):
        given.changed({"operation.heated_place": "lid"})


def test_a_bed_is_heated_when_its_beads_are():
    """Large beads lag behind the fluid at the outlet by most of a kelvin: the bed is later than the fluid there."""
    settings = {
        "geometry.cavity_height": 0.4,
        "bed.bead_diameter": 0.02,
        "bed.porosity_model": "constant",
        "model.flow": "plug",
        "model.turbulence": "none",
        "model.wall": "insulated",
        "wall.thickness": None,
        "operation.heated_place": "bed",
    }
    times = {}
    for place in ("bed", "bed_side"):
        settings["operation.heated_place"] = place
        times[place] = run(Scene.load(ALUMINIUM, settings), communicator=MPI.COMM_SELF)
    beds = times["bed"]
    assert beds["lowest_bed"][-2] < beds["lowest_bed_side"][-2]
    assert 1.003 * times["bed_side"].heating_time < beds.heating_time < 1.1 * times["bed_side"].heating_time


@pytest.mark.parametrize(("start", "inlet", "flux"), [(298.15, 363.15, 1.0), (363.15, 298.15, -1.0)])
def test_an_inlet_that_dips_heats_nothing_where_heat_comes_from_elsewhere(start, inlet, flux):
    """A heat flux far too small to count, and an inlet that falls below the cold wall for a minute, or rises above the hot one:
    that minute was the heating time, with the wall 65 K away."""
    dip = ([0.0, 300.0, 301.0, 360.0, 361.0, 1e4], [inlet, inlet, start, start, inlet, inlet])
    given = {"model.flow": "plug", "model.turbulence": "none", "operation.initial_temperature": start}
    given |= {"operation.inlet_temperature": dip}
    plain = run(coarse_scene(given), communicator=MPI.COMM_SELF)
    heated = run(coarse_scene(given | {"operation.outer_heat_flux": flux}), communicator=MPI.COMM_SELF)
    assert plain.heating_time > 1000.0
    assert heated.heating_time == pytest.approx(plain.heating_time, rel=0.01)
