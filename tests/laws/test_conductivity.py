"""Effective conductivities of the two phases."""

import pytest

from porousmold.laws.conductivity import CONDUCTIVITY_LAWS, LocalBed

BED = LocalBed(0.4, 1e-2, 5e-3, 1.2, 1.8e-5, 1007.0, 1.0, 2e-3, 0.026, 2.09)


def test_parallel_is_equation_7_11():
    """lambda_f + C mu_t/Pr_t in the fluid's part of the volume, lambda_s in the beads'."""
    law = CONDUCTIVITY_LAWS["parallel"]
    assert law.fluid(BED) == pytest.approx(0.4 * (0.026 + 1007.0 * 2e-3 / 0.85))
    assert law.beads(BED) == pytest.approx(0.6 * 2.09)


def test_peclet_number_is_that_of_the_superficial_speed():
    assert BED.peclet_number == pytest.approx(1.2 * 1007.0 * 0.4 * 1.0 * 5e-3 / 0.026)
