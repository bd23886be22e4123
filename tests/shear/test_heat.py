"""Heat between sheared beads: exact solutions, and the balance of fluxes, walls and storage."""

import math

import numpy as np
import pytest

from porousmold.shear.cell import ShearCell
from porousmold.shear.heat import AREA_ROOT, Heat, cases_of, exchange
from porousmold.shear.motion import Shearing


def exchanged(height, heights, pairs, with_walls, cases, temperature, span, times=1, mass=None, moved=0.0):
    """`exchange` of beads in the order of their names: pairs {(i, j): contact radius}."""
    count = len(heights)
    start, partner, radii = np.zeros(count + 1, np.int64), [], []
    for i in range(count):
        for (a, b), radius in pairs.items():
            if a == i:
                partner.append(b)
                radii.append(radius)
        start[i + 1] = len(partner)
    size = np.column_stack((np.full(count, 0.5), np.ones(count) if mass is None else mass))
    fluxes, into_beads = np.zeros((5, len(cases), 2)), np.zeros((len(cases), 3))
    z = np.array(heights, float)
    for _ in range(times):
        heat = Heat(np.arange(count), temperature, cases, height, fluxes, into_beads)
        of_pairs = (start, np.array(partner, np.int64)), np.array(radii, float)
        exchange(heat, z, z + moved, size, *of_pairs, np.array(with_walls, float), span)
        z = z + moved
    return fluxes, into_beads


def test_two_beads_approach_each_other_exponentially():
    cases, radius = cases_of((1.0,), (0.0,)), 0.1
    rate = 2.0 * 2.0 * AREA_ROOT * radius / cases[0, 0]
    errors = []
    for steps in (40, 80):
        temperature = np.array([[0.5], [-0.5]])
        exchanged(5.0, [2.0, 3.0], {(0, 1): radius}, np.zeros((2, 2)), cases, temperature, 1.0 / rate / steps, steps)
        assert temperature.sum() == pytest.approx(0.0, abs=1e-14)
        errors.append(abs(temperature[0, 0] - temperature[1, 0] - math.exp(-1.0)))
    assert errors[1] < 5e-3
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.05)  # Euler's steps: of first order


@pytest.mark.parametrize("biot", [0.1, 50.0])
def test_a_bead_in_a_fluid_follows_its_film_and_its_inside(biot):
    """Decay rate 6 alpha'/(rho C d): the film in series with R/(5 lambda)."""
    cases, temperature = cases_of((2.0,), (biot,)), np.array([[0.4]])
    exchanged(5.0, [2.0], {}, np.zeros((1, 2)), cases, temperature, 0.37)
    rate = 6.0 * biot / (1.0 + biot / 10.0) / (4.0 * 2.0)
    assert temperature[0, 0] == pytest.approx(0.4 * math.exp(-rate * 0.37), rel=1e-12)


def test_a_row_of_beads_conducts_like_resistances_in_series():
    """A simple cubic lattice between walls: n - 1 contacts between beads and two with the walls."""
    count, radius, of_walls = 6, 0.05, 0.08
    height, cases = float(count), cases_of((0.1,), (0.0,))
    temperature = np.zeros((count, 1))
    with_walls = np.zeros((count, 2))
    with_walls[0, 0] = with_walls[-1, 1] = of_walls
    pairs = {(i, i + 1): radius for i in range(count - 1)}
    heights = np.arange(count) + 0.5
    exchanged(height, heights, pairs, with_walls, cases, temperature, 1.0, 300)
    fluxes, into_beads = exchanged(height, heights, pairs, with_walls, cases, temperature, 1.0)
    conductance = 2.0 * AREA_ROOT
    heat = 1.0 / ((count - 1) / (conductance * radius) + 2.0 / (conductance * of_walls))
    assert into_beads[0] == pytest.approx([-heat, heat, 0.0], rel=1e-9, abs=1e-14)
    assert fluxes.sum() == pytest.approx(-heat * height, rel=1e-9)  # down the gradient, through a volume of that height


def test_beads_that_move_carry_their_heat():
    cases = cases_of((3.0,), (0.0,))
    temperature = np.array([[0.25]])
    fluxes, _ = exchanged(5.0, [1.0], {}, np.zeros((1, 2)), cases, temperature, 0.1, moved=0.2)
    assert fluxes.sum(axis=0) == pytest.approx(np.array([[0.0, cases[0, 0] * 0.25 * 0.2]]))


@pytest.mark.parametrize("walls", ["rough", "flat"])
def test_fluxes_are_those_through_the_walls_less_what_is_stored(walls):
    """To rounding errors, in any motion: the mean flux over the volume, with the moment of the stored heat."""
    cell = ShearCell(0.55, 0.05, peclet=(0.1, 10.0), biot=(0.0,), strains=2.0, distance=6.0, width=5.0, walls=walls)
    shearing = Shearing(cell)
    shearing.integrate()
    for block in shearing._blocks:
        through = block["fluxes"].sum(axis=(0, 2))
        at_walls = 0.5 * cell.distance * (block["into_beads"][:, 1] - block["into_beads"][:, 0])
        assert through + at_walls == pytest.approx(block["moment"], abs=1e-10)
        assert np.abs(at_walls).max() > 0.01
