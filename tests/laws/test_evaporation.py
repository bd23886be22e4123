"""Closed forms of water that evaporates, against the equations that they solve."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from porousmold.laws.evaporation import (
    BOILING_TEMPERATURE,
    LATENT_HEAT,
    film_below_cylinder,
    film_below_disc,
    sphere_lifetime,
)

VAPOUR = {"conductivity": 0.026, "viscosity": 2e-5, "vapour_density": 1.204}
GRAVITY, WATER = 9.80665, 958.0


def pressure_carried(thickness, half_width, excess, *, round_film):
    """Weight that the vapour below a film carries: dp/dx = -12 mu u/e^2, with the mean velocity of what has evaporated so far."""
    made = VAPOUR["conductivity"] * excess / (thickness * LATENT_HEAT)
    run = 0.5 if round_film else 1.0  # area over perimeter, in x
    film = solve_ivp(
        lambda x, p: -12.0 * VAPOUR["viscosity"] * run * made * x / (VAPOUR["vapour_density"] * thickness**3),
        (half_width, 0.0), [0.0], dense_output=True, rtol=1e-9, atol=1e-9)  # fmt: skip
    if round_film:
        return quad(lambda x: 2.0 * np.pi * x * film.sol(x)[0], 0.0, half_width)[0]
    return 2.0 * quad(lambda x: film.sol(x)[0], 0.0, half_width)[0]


@pytest.mark.parametrize("excess", [100.0, 300.0, 500.0])
def test_the_film_carries_the_weight(excess):
    strip = film_below_cylinder(1.25e-3, 0.04, excess, **VAPOUR)
    assert pressure_carried(strip, 1.25e-3, excess, round_film=False) == pytest.approx(0.04, rel=1e-6)
    disc = film_below_disc(1e-3, 4e-5, excess, **VAPOUR)
    assert pressure_carried(disc, 1e-3, excess, round_film=True) == pytest.approx(4e-5, rel=1e-6)


def test_films_of_the_paper_s_droplet():
    """66 um and 117 kW/m2 below the cylinder of 2.5 mm at 400 °C with the paper's constants."""
    weight = WATER * np.pi * 1.25e-3**2 * GRAVITY
    film = film_below_cylinder(1.25e-3, weight, 673.15 - BOILING_TEMPERATURE, **VAPOUR)
    assert film == pytest.approx(66e-6, rel=0.02)
    assert 0.026 * 300.0 / film == pytest.approx(117e3, rel=0.02)


def test_a_film_grows_with_the_fourth_root_of_the_excess():
    thin, thick = (film_below_cylinder(1e-3, 0.04, excess, **VAPOUR) for excess in (100.0, 1600.0))
    assert thick / thin == pytest.approx(2.0)


def test_the_heat_that_reaches_a_sphere_evaporates_it():
    """d^2 law: integrated from the surface outwards, the temperature around ends at the excess that the closed form was given."""
    assert sphere_lifetime(2.5e-3, WATER, 300.0, 0.04, 2000.0) == pytest.approx(159.0, rel=0.01)
    conductivity, heat_capacity, excess, radius = 0.04, 2000.0, 300.0, 1e-3
    rate = WATER * (2.0 * radius) ** 2 / sphere_lifetime(2.0 * radius, WATER, excess, conductivity, heat_capacity)
    rate *= np.pi * radius / 2.0  # of mass: d(m)/dt = rho pi D/4 d(D^2)/dt
    around = solve_ivp(
        lambda _, excess: rate * (heat_capacity * excess + LATENT_HEAT) / (4.0 * np.pi * conductivity), (0.0, 1.0 / radius),
        [0.0], rtol=1e-10, atol=1e-12)  # fmt: skip
    assert around.y[0, -1] == pytest.approx(excess, rel=1e-6)
