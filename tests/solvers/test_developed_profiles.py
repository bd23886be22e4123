"""Tables of developed profiles against the pressure gradient."""

import numpy as np
import pytest
from mpi4py import MPI

from porousmold import Scene
from porousmold.simulation.assembly import profile_table

from ..support import ALUMINIUM, PIPE, coarse_scene, problem_of, simulation_of


@pytest.mark.parametrize(
    ("gradient", "bead_diameter", "half_height", "refinement", "model"),
    [
        (2.04e6, 8.0, 40.9, 2.0, "damped-nakayama-kuwahara"),
        (2.99e6, 9.4, 31.4, 2.0, "damped-nakayama-kuwahara"),
        (2.32e6, 8.0, 27.2, 1.0, "nakayama-kuwahara"),
        (2.31e6, 9.9, 45.0, 1.0, "damped-nakayama-kuwahara"),
        (2.6e5, 5.0, 25.0, 1.0, "damped-nakayama-kuwahara"),
    ],
)
def test_profiles_from_laminar_to_turbulent_are_found_at_once(gradient, bead_diameter, half_height, refinement, model):
    """Stations whose turbulence dies out beside turbulent ones, where Newton's method leads astray: all are found.

    A larger gradient drives a faster flow, by G (Darcy) to the square root of it (Forchheimer, turbulence).
    """
    settings = {
        "bed.bead_diameter": 1e-3 * bead_diameter,
        "geometry.cavity_height": 2e-3 * half_height,
        "bed.allow_small_ratio": True,
        "solver.mesh_refinement": refinement,
        "model.turbulence": model,
    }
    problem = simulation_of(coarse_scene(ALUMINIUM, settings), MPI.COMM_SELF).problem
    table = profile_table(problem.specs, problem.medium.estimates, 1e-3 * half_height)
    logarithms = np.log(gradient) + np.linspace(-3.0, 3.0, 25)
    table.cover(np.log(gradient))
    speeds, slopes = table.at(np.full(25, 1e-3 * half_height), logarithms)[0]
    assert np.all(np.diff(speeds) > 0.0)
    assert np.all((slopes > 0.4) & (slopes < 1.02))
    for end in table.reach:  # slopes that change at once let iterations go to and fro between them
        beside = end + np.array([-1e-6, 1e-6])
        values, slopes = table.at(np.full(2, 1e-3 * half_height), beside)[0]
        assert slopes[0] == pytest.approx(slopes[1], abs=1e-4)
        assert np.diff(np.log(values)) == pytest.approx(slopes[:1] * 2e-6, rel=1e-3)


def test_beyond_the_table_a_profile_goes_on_as_a_wider_one_has_it():
    """At the edges of ports the pressure gradient is a hundred times its mean; a power law of its own drove too much there."""
    settings = {"model.turbulence": "damped-nakayama-kuwahara", "bed.bead_diameter": "5 mm"}
    problem = simulation_of(coarse_scene(ALUMINIUM, settings), MPI.COMM_SELF).problem
    table = profile_table(problem.specs, problem.medium.estimates, 0.025)
    distances, middle = np.array([0.001, 0.005, 0.025]), np.log(2e6)
    table.cover(middle)
    beyond = np.full(3, table.reach[1] + np.log(5.0))
    extrapolated = table.at(distances, beyond)[0][0]
    table.cover(middle + 3.0)
    assert table.reach[1] > beyond[0]
    assert extrapolated == pytest.approx(table.at(distances, beyond)[0][0], rel=0.03)


def test_where_turbulence_begins_profiles_do_not_depend_on_where_the_stations_lie():
    """k grows thirtyfold within 0.2 of ln G: splines through even stations had twice of it between two, a wall was heated 1.4 %
    too early."""
    settings = {
        "fluid.material": "water",
        "fluid.viscosity": "0.5 mPa*s",
        "model.turbulence": "damped-nakayama-kuwahara",
    }
    problem = simulation_of(coarse_scene(ALUMINIUM, settings), MPI.COMM_SELF).problem
    distances, middle = np.array([1e-4, 2e-4, 5e-4, 1e-3, 3e-3, 0.01]), np.log(9.6e5)
    tables = []
    for away in (0.0, 0.16, 0.5):  # of 0.33 between two
        table = profile_table(problem.specs, problem.medium.estimates, 0.025)
        table.cover(middle + away)
        tables.append(table)
    for logarithm in middle + np.array([-0.4, -0.1, 0.0, 0.05, 0.4]):
        found = [table.at(distances, np.full(6, logarithm)) for table in tables]
        for other in found[1:]:
            assert other[0][0] == pytest.approx(found[0][0][0], rel=1e-3)
            assert other[1][0] == pytest.approx(found[0][1][0], rel=0.03, abs=0.02 * found[0][1][0].max())


def test_a_table_keeps_the_flow_of_its_whole_reach():
    """Whether it has a laminar solution, too, was asked of the stations put in last, where k-epsilon has died out."""
    problem = simulation_of(coarse_scene(ALUMINIUM, {"model.turbulence": "k-epsilon"}), MPI.COMM_SELF).problem
    table = profile_table(problem.specs, problem.medium.estimates, 0.025)
    table.cover(np.log(9.6e5))
    assert table.reach[1] - table.reach[0] == pytest.approx(2.0 * np.log(100.0))
    assert table._flow.is_turbulent()


def test_a_bed_of_a_millimetre_has_the_flow_of_a_larger_one():
    """The same Reynolds number in a pipe of a tenth the size: ten times the velocity, a thousand times the pressure gradient.

    PETSc took its pivots, which go with the size of the cells, for zero.
    """
    drops = []
    for size in (1e-3, 1e-2):
        sizes = {"geometry.diameter": size, "geometry.length": size, "bed.bead_diameter": 0.05 * size}
        flow = {"model.flow": "developed", "model.turbulence": "none", "operation.pressure_drop": None}
        flow |= {"operation.inlet_velocity": 2e-4 / size, "wall.thickness": 0.1 * size}
        problem = problem_of(Scene.load(PIPE, {**sizes, **flow}))
        problem.flow.start()
        drops.append(problem.balances.pressure_drop)
    assert drops[0] == pytest.approx(100.0 * drops[1], rel=1e-2)
