"""How much natural convection there would be in a bed at rest."""

import numpy as np
import pytest

from porousmold.laws.natural_convection import ONSET, carried_from_below, carried_from_the_side, rayleigh_darcy_number

BED = {
    "density": 1.0, "heat_capacity": 1000.0, "viscosity": 2e-5, "expansion": 1e-3, "permeability": 1e-6,
    "conductivity": 1.0, "difference": 500.0, "height": 3.0,
}  # fmt: skip


def test_rayleigh_darcy_number_is_its_definition():
    assert rayleigh_darcy_number(**BED) == pytest.approx(1000.0 * 9.81 * 1e-3 * 500.0 * 1e-6 * 3.0 / 2e-5)
    assert rayleigh_darcy_number(**BED | {"height": 6.0}) == pytest.approx(2.0 * rayleigh_darcy_number(**BED))


def test_nothing_turns_over_below_the_onset():
    assert pytest.approx(39.478, abs=1e-3) == ONSET
    assert carried_from_below(30.0) == 1.0 and carried_from_below(400.0) == pytest.approx(10.0)
    assert carried_from_the_side(1e-3, 5.0) == 1.0
    assert carried_from_the_side(1000.0, 1.0) == pytest.approx(0.577 * np.sqrt(1000.0))
