"""Conduction at rest and dispersion: limits, the printed formulas, measured numbers."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from porousmold.laws.conductivity import (
    BEAD_CONDUCTION_LAWS,
    DISPERSION_LAWS,
    Anisotropic,
    LocalBed,
    added,
    stagnant_conductivity,
    wall_coefficient,
)

CERAMIC_IN_AIR = LocalBed(
    porosity=0.4,
    wall_distance=1e-2,
    bead_diameter=5e-3,
    density=1.2,
    viscosity=1.8e-5,
    heat_capacity=1007.0,
    speed=1.0,
    eddy_viscosity=2e-3,
    fluid_conductivity=0.026,
    bead_conductivity=2.09,
    bulk_porosity=0.4,
    core_speed=0.4,
    temperature=330.0,
)
WHOLE = BEAD_CONDUCTION_LAWS["zehner-bauer-schluender"]
WINTERBERG_TSOTSAS = DISPERSION_LAWS["winterberg-tsotsas"].formula


def over_fluid(porosity, ratio, **changes):
    """lambda_0/lambda_f at a conductivity ratio."""
    bed = replace(CERAMIC_IN_AIR, bead_conductivity=ratio * 0.026, **changes)
    return stagnant_conductivity(bed, porosity) / 0.026


def printed(phi, kappa, radiation=0.0, flattening=0.0):
    """The formula as the VDI Heat Atlas prints it, which divides by N."""
    shape = 1.25 * ((1.0 - phi) / phi) ** (10.0 / 9.0)
    n = 1.0 + (radiation - shape) / kappa
    core = 2.0 / n * (shape * (kappa + radiation - 1.0) / (n**2 * kappa) * np.log((kappa + radiation) / shape)
                      + (shape + 1.0) / (2.0 * shape) * (radiation - shape) - (shape - 1.0) / n)  # fmt: skip
    section = np.sqrt(1.0 - phi)
    return (1.0 - section) * (1.0 + phi * radiation) + section * (flattening * kappa + (1.0 - flattening) * core)


def test_bulk_is_equation_7_11():
    """lambda_f + C mu_t/Pr_t in the fluid's part of the volume, lambda_s in the beads'."""
    law, eddies = BEAD_CONDUCTION_LAWS["bulk"], DISPERSION_LAWS["none"].formula(CERAMIC_IN_AIR)
    assert law.fluid(CERAMIC_IN_AIR) + eddies == pytest.approx(0.4 * (0.026 + 1007.0 * 2e-3 / 0.85))
    assert law.beads(CERAMIC_IN_AIR) == pytest.approx(0.6 * 2.09)


@given(st.floats(0.2, 0.95), st.floats(0.05, 5e3), st.floats(0.0, 0.9), st.floats(0.0, 0.03))
def test_the_bed_at_rest_is_the_printed_formula(phi, kappa, emissivity, flattening):
    radiation = 4.0 * 5.670374419e-8 * 330.0**3 * 5e-3 * emissivity / ((2.0 - emissivity) * 0.026)
    n = 1.0 + (radiation - 1.25 * ((1.0 - phi) / phi) ** (10.0 / 9.0)) / kappa
    if abs(n) < 0.02:  # the printed form loses its digits there
        return
    expected = printed(phi, kappa, radiation, flattening)
    found = over_fluid(phi, kappa, emissivity=emissivity, contact_flattening=flattening)
    assert found == pytest.approx(expected, rel=1e-5)


def test_numbers_of_ceramic_beads_in_air():
    """8.2 without contacts, 8.6 with, 10.0 with radiation at 330 K (correlations of this round), within their rounding."""
    kappa = 2.09 / 0.026
    assert over_fluid(0.4, kappa) == pytest.approx(8.2, abs=0.15)
    assert over_fluid(0.4, kappa, contact_flattening=0.0077) == pytest.approx(8.6, abs=0.15)
    assert over_fluid(0.4, kappa, contact_flattening=0.0077, emissivity=0.9) == pytest.approx(10.0, abs=0.15)


def test_limits_at_rest():
    assert over_fluid(0.37, 1.0) == pytest.approx(1.0, abs=1e-12)
    assert over_fluid(1.0, 80.0) == pytest.approx(1.0, abs=1e-6)
    touching = 1.25 * 1.5 ** (10.0 / 9.0)  # kappa at which N = 0
    around = [over_fluid(0.4, touching * (1.0 + shift)) for shift in (-1e-6, 0.0, 1e-6)]
    assert around[1] == pytest.approx(0.5 * (around[0] + around[2]), rel=1e-9)
    assert all(np.diff([over_fluid(0.4, kappa) for kappa in np.geomspace(0.1, 1e4, 200)]) > 0.0)


@given(st.floats(0.2, 1.0), st.floats(0.01, 1e4))
def test_both_phases_share_the_whole_bed(phi, kappa):
    """At every porosity, conductivity and speed the parts are positive and make up what the law gives."""
    bed = replace(CERAMIC_IN_AIR, porosity=phi, bead_conductivity=kappa * 0.026)
    fluid, beads = WHOLE.fluid(bed), WHOLE.beads(bed)
    assert fluid > 0.0 and beads >= 0.0
    assert fluid + beads == pytest.approx(WHOLE.formula(bed), rel=1e-12)


def test_the_wall_is_reached_at_rest_and_its_layer_resists_with_flow():
    """Pe = 0: as in the core up to the wall, and beads at its temperature. Pe = 200: lambda_f at the wall, beads insulated."""
    at_wall = replace(CERAMIC_IN_AIR, porosity=1.0)
    still, flowing = replace(at_wall, core_speed=0.0), replace(at_wall, core_speed=1.0)
    assert WHOLE.formula(still) == pytest.approx(WHOLE.formula(CERAMIC_IN_AIR))
    assert WHOLE.formula(flowing) == pytest.approx(0.026, rel=1e-5)
    assert wall_coefficient(still) > 1e3 * WHOLE.formula(still) / 5e-3
    assert wall_coefficient(flowing) < 1e-3 * WHOLE.formula(still) / 5e-3


def test_radiation_ends_with_the_beads():
    """None at phi -> 1 with flow, that of the core in the core, monotone between."""
    flowing = replace(CERAMIC_IN_AIR, core_speed=1.0, emissivity=0.9)
    dark = replace(flowing, emissivity=0.0)
    assert WHOLE.formula(replace(flowing, porosity=1.0)) == pytest.approx(0.026, rel=1e-5)
    assert WHOLE.formula(flowing) == pytest.approx(stagnant_conductivity(flowing, 0.4))
    more = [WHOLE.formula(replace(bed, porosity=phi)) for phi in (0.4, 0.6, 0.8, 0.99) for bed in (flowing, dark)]
    assert all(np.diff(np.subtract(more[::2], more[1::2])) < 0.0)


def test_dispersion_is_the_larger_of_pe_over_8_and_eddies():
    peclet = CERAMIC_IN_AIR.peclet_number
    assert peclet == pytest.approx(1.2 * 1007.0 * 0.4 * 1.0 * 5e-3 / 0.026)
    still = replace(CERAMIC_IN_AIR, eddy_viscosity=0.0)
    assert WINTERBERG_TSOTSAS(still) == Anisotropic(0.0, pytest.approx(peclet / 8.0 * 0.026))
    eddies = 0.4 * 1007.0 * 2e-3 / 0.85
    assert WINTERBERG_TSOTSAS(CERAMIC_IN_AIR) == Anisotropic(*[pytest.approx(eddies)] * 2)
    near = WINTERBERG_TSOTSAS(replace(still, wall_distance=1e-3)).across
    reach = 0.44 + 4.0 * np.exp(-1.2 * 0.4 * 5e-3 / 1.8e-5 / 70.0)
    assert near == pytest.approx(peclet / 8.0 * 0.026 * (0.2 / reach) ** 2)
    assert WINTERBERG_TSOTSAS(replace(still, wall_distance=0.0)).across == 0.0
    axial = DISPERSION_LAWS["winterberg-tsotsas-axial"].formula(still)
    assert axial.along == pytest.approx(peclet / 2.0 * 0.026) and axial.across == WINTERBERG_TSOTSAS(still).across


def test_sums_of_numbers_and_tensors():
    assert added(1.0, 2.0) == 3.0
    assert added(1.0, Anisotropic(1.0, 2.0)) == added(Anisotropic(1.0, 2.0), 1.0) == Anisotropic(2.0, 3.0)
    assert added(Anisotropic(1.0, 2.0), Anisotropic(3.0, 5.0)) == Anisotropic(4.0, 7.0)
