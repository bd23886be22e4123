"""Beads that a fluid lifts: against the weight of the bed, Stokes's law, and the limits of Martin's coefficient."""

import math

import pytest

from porousmold import InputError
from porousmold.laws.drag import DRAG_LAWS
from porousmold.laws.fluidisation import (
    CONTACT_CONSTANT,
    GRAVITY,
    BubblingBed,
    archimedes_number,
    expanded_porosity,
    minimum_fluidisation_reynolds_number,
    modified_mean_free_path,
    terminal_reynolds_number,
)

AIR = {"density": 1.2, "viscosity": 1.8e-5}
MARTIN = {
    "porosity": 0.5,
    "porosity_at_minimum": 0.4,
    "bead_heat_capacity": 2600.0 * 800.0,
    "bead_conductivity": 1.0,
    "conductivity": 0.026,
    "mean_free_path": 2e-7,
    "prandtl": 0.7,
    "archimedes": 0.0,
}


@pytest.mark.parametrize("diameter", [1e-4, 5e-4, 3e-3])
@pytest.mark.parametrize("porosity", [0.4, 0.48])
def test_erguns_drag_carries_the_weight_at_minimum_fluidisation(diameter, porosity):
    archimedes = archimedes_number(diameter, AIR["density"], 2600.0, AIR["viscosity"])
    reynolds = minimum_fluidisation_reynolds_number(archimedes, porosity)
    speed = reynolds * AIR["viscosity"] / (AIR["density"] * diameter) / porosity
    drag = DRAG_LAWS["ergun"].coefficient(porosity, diameter, AIR["density"], AIR["viscosity"], speed)
    gradient = drag * speed / porosity
    assert gradient == pytest.approx((1.0 - porosity) * (2600.0 - 1.2) * GRAVITY, rel=1e-9)


def test_a_small_sphere_falls_by_stokess_law_and_a_large_one_by_newtons():
    assert terminal_reynolds_number(0.01) == pytest.approx(0.01 / 18.0, rel=0.02)
    drag_coefficient = 4.0 / 3.0 * 1e8 / terminal_reynolds_number(1e8) ** 2
    assert 0.35 < drag_coefficient < 0.5


def test_expansion_goes_from_the_bed_at_rest_to_a_single_sphere():
    archimedes = archimedes_number(5e-4, 1.2, 2600.0, 1.8e-5)
    minimum, terminal = minimum_fluidisation_reynolds_number(archimedes, 0.42), terminal_reynolds_number(archimedes)
    assert expanded_porosity(minimum, minimum, terminal, 0.42) == pytest.approx(0.42)
    assert expanded_porosity(terminal, minimum, terminal, 0.42) == pytest.approx(1.0)
    assert 0.42 < expanded_porosity(2.0 * minimum, minimum, terminal, 0.42) < 0.6


def test_the_coefficient_at_the_wall_has_martins_limits():
    """Small beads: what they can carry, (1-phi) Z. Large ones: what one takes up at the wall, (1-phi) Nu_w/C_K."""
    small = BubblingBed(diameter=1e-6, **(MARTIN | {"mean_free_path": 1e-12})).wall_nusselt_number()
    free = 0.1 / (5.0 * 0.6 * 0.5)
    motion = MARTIN["bead_heat_capacity"] / (6.0 * 0.026) * math.sqrt(GRAVITY * 1e-18 * free)
    assert small == pytest.approx(0.5 * motion, rel=1e-2)
    large = BubblingBed(diameter=0.1, **(MARTIN | {"bead_conductivity": 1e9})).wall_nusselt_number()
    gap = 4e-6
    at_contact = 4.0 * ((1.0 + gap) * math.log1p(1.0 / gap) - 1.0)
    assert large == pytest.approx(0.5 * at_contact / CONTACT_CONSTANT, rel=1e-2)
    still = BubblingBed(diameter=1e-3, **(MARTIN | {"porosity": 0.4, "archimedes": 1e4})).wall_nusselt_number()
    assert still == pytest.approx(0.009 * 0.7 ** (1 / 3) * 100.0)


def test_sand_in_air_has_the_known_order_of_magnitude():
    path = modified_mean_free_path(300.0, 101325.0, 0.026, 1007.0, 287.0)
    assert 1e-7 < path < 4e-7
    nusselt = BubblingBed(diameter=5e-4, **(MARTIN | {"archimedes": 1e4, "mean_free_path": path})).wall_nusselt_number()
    assert 200.0 < nusselt * 0.026 / 5e-4 < 400.0


def test_beads_that_float_are_refused():
    with pytest.raises(InputError, match="float"):
        archimedes_number(1e-3, 1000.0, 900.0, 1e-3)
