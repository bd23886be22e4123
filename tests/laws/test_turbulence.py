"""Two-layer model and bead sources: limits and equilibrium."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from porousmold.laws import turbulence as t
from porousmold.laws.turbulence_models import NO_TURBULENCE, TwoLayerState


@given(porosity=st.floats(0.3, 0.95), speed=st.floats(0.01, 20.0), diameter=st.floats(5e-4, 1e-2))
def test_dissipation_squared_over_energy_is_what_its_name_says(porosity, speed, diameter):
    energy = t.bead_kinetic_energy(porosity, speed)
    rate = t.bead_dissipation_rate(porosity, speed, diameter)
    assert t.bead_dissipation_squared_over_energy(porosity, speed, diameter) == pytest.approx(
        rate**2 / energy, rel=1e-12
    )


@given(fraction=st.floats(0.01, 1.0), porosity=st.floats(0.3, 0.9), speed=st.floats(0.1, 20.0))
def test_uniform_bed_settles_at_damped_equilibrium(fraction, porosity, speed):
    """k = f k_inf, eps = f eps_inf makes both uniform equations vanish: S_k = eps, eps^2/k = S_eps."""
    diameter = 5e-3
    k = fraction * t.bead_kinetic_energy(porosity, speed)
    rate = fraction * t.bead_dissipation_rate(porosity, speed, diameter)
    assert fraction * t.bead_dissipation_rate(porosity, speed, diameter) == pytest.approx(rate)
    source = fraction * t.bead_dissipation_squared_over_energy(porosity, speed, diameter)
    assert source == pytest.approx(rate**2 / k, rel=1e-12)


def test_sources_vanish_without_beads_and_damping_has_its_ends():
    assert t.bead_kinetic_energy(1.0, 5.0) == 0.0
    assert t.bead_dissipation_rate(1.0, 5.0, 5e-3) == 0.0
    assert t.bead_dissipation_squared_over_energy(1.0, 5.0, 5e-3) == 0.0
    assert t.damping(800.0) == 0.0 and t.damping(900.0) == 1.0
    assert t.damping(850.0) == pytest.approx(0.5)


@given(k=st.floats(1e-8, 10.0), y=st.floats(1e-6, 1e-2))
def test_inner_dissipation_rate_is_k_to_three_halves_over_its_length(k, y):
    density, viscosity = 1.0, 2e-5
    reynolds = t.wall_reynolds_number(density, y, k, viscosity)
    length = y * t.C_LENGTH * (1.0 - np.exp(-reynolds / t.A_EPSILON))
    expected = k**1.5 / length
    tolerance = 1e-6 if reynolds / t.A_EPSILON > 1e-3 else 1e-3
    assert t.inner_dissipation_rate(k, reynolds, y, viscosity / density) == pytest.approx(expected, rel=tolerance)


def test_the_two_layers_meet_in_the_log_layer():
    """Where Re_y >> A_mu both give mu_t = rho C_mu k^2/eps: with eps = k^1.5/(C_l y) the lengths are equal."""
    k, y, density, viscosity = 4.0, 0.05, 1.0, 2e-5
    reynolds = t.wall_reynolds_number(density, y, k, viscosity)
    outer = t.outer_eddy_viscosity(density, k, k**1.5 / (t.C_LENGTH * y))
    assert t.inner_eddy_viscosity(density, k, reynolds, y) == pytest.approx(outer, rel=1e-12)


def test_log_layer_slope_is_kappa():
    """mu_t = rho kappa u_tau y for k = u_tau^2/sqrt(C_mu)."""
    friction, y = 0.5, 0.1
    k = friction**2 / t.C_MU**0.5
    reynolds = t.wall_reynolds_number(1.0, y, k, 1e-6)
    assert t.inner_eddy_viscosity(1.0, k, reynolds, y) == pytest.approx(t.KAPPA * friction * y, rel=1e-12)


def test_regularisation_is_inactive_where_turbulence_lives():
    """The state's eddy viscosity is the plain blend to 1e-3 for values as in the mold."""
    k, y, density, viscosity = np.array([9.0, 4.0, 1.0]), np.array([5e-4, 2e-3, 1e-2]), 1.0, 2e-5
    epsilon = k**1.5 / (t.C_LENGTH * y) * 0.8
    state = TwoLayerState(k, epsilon, density, viscosity, y, 12.0, 20.0, 1e3)
    reynolds = t.wall_reynolds_number(density, y, k, viscosity)
    weight = t.outer_fraction(reynolds, 20.0)
    plain = weight * t.outer_eddy_viscosity(density, k, epsilon) + (1 - weight) * t.inner_eddy_viscosity(
        density, k, reynolds, y
    )
    assert state.eddy_viscosity == pytest.approx(plain, rel=1e-3)


def test_outer_fraction_and_its_ufl_derivative_stay_finite_far_from_the_wall():
    """UFL's derivative of tanh gave NaN there, and with it singular Jacobians at high Reynolds numbers."""
    import ufl
    from ufl.algorithms import expand_derivatives

    assert t.outer_fraction(np.array([0.0, 200.0, 1e5]), 20.0) == pytest.approx([0.0, 0.5, 1.0], abs=1e-12)
    assert t.outer_fraction(np.array([80.0, 320.0]), 120.0) == pytest.approx([0.01, 0.99], abs=1e-12)
    for value in (0.0, 200.0, 5e3, 1e5):
        reynolds = ufl.variable(ufl.as_ufl(value))
        slope = expand_derivatives(ufl.diff(t.outer_fraction(reynolds, 20.0), reynolds))
        assert np.isfinite(float(slope(())))


def test_dissipation_turns_over_no_faster_where_there_is_no_turbulence():
    """epsilon/k of either sign of a vanishing k, as nodes of a laminar core have: alike, and that of the least k."""
    scale, epsilon = 12.0, 0.3
    rates = [
        TwoLayerState(k * scale, epsilon, 1.0, 2e-5, 0.02, scale, 20.0, 1e3).turnover_outer
        for k in (-1e-3, -1e-8, 0.0, 1e-8)
    ]
    assert max(rates) < 1.01 * epsilon / (NO_TURBULENCE * scale) and min(rates) > 0.65 * max(rates)
    turbulent = TwoLayerState(0.1 * scale, 50.0, 1.0, 2e-5, 0.02, scale, 20.0, 1e3)
    assert turbulent.turnover_outer == pytest.approx(50.0 / (0.1 * scale), rel=1e-4)
