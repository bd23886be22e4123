"""The falling-head test on data of known permeability."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from porousmold.files.tables import read_toml
from porousmold.laws.drag import DRAG_LAWS
from porousmold.permeability.falling_head import (  # fmt: skip
    GRAVITY,
    Setup,
    fit_baseline,
    globally,
    instantaneous,
    levels_of,
    mean_of,
    reynolds_number,
)

from ..support import STUDIES

PUBLISHED = read_toml("published", STUDIES.parent / "tests" / "published.toml")["permeability"]
PRINTED = PUBLISHED["setup"]
SILICONE = Setup(
    PRINTED["bed_length_virtual"],
    np.pi / 4 * PRINTED["pipe_diameter"] ** 2,
    PRINTED["h0_virtual"],
    PRINTED["silicone_density"],
    PRINTED["silicone_viscosity"],
    PRINTED["c0"],
    PRINTED["c1"],
)
WATER = replace(SILICONE, density=998.0, viscosity=9.3e-4)


def readings(setup, permeability, every=0.5):
    """(time, mass) as a scale would tell them, without noise; a short test is read more often."""
    end = setup.duration(permeability)
    time = np.linspace(0.0, end, max(int(end / every), 200) + 1)
    return time, setup.mass(time, permeability)


def test_the_fall_solves_darcys_law_with_gravity_and_outlet():
    """Eq. 4.9 with 4.8 and 4.10 integrated numerically is eq. 4.13."""
    s, k = SILICONE, 1e-8

    def velocity(_, h):
        # v = -(k/mu)[(rho g h - c0 Q - c1)/L + rho g] with Q = -v S, solved for v
        driving = s.density * GRAVITY * (h + s.bed_length) - s.outlet_pressure
        return -driving / (s.viscosity * s.bed_length / k + s.outlet_resistance * s.cross_section)

    time = np.linspace(0.0, s.duration(k), 20)
    solved = solve_ivp(velocity, (0.0, time[-1]), [s.initial_head], t_eval=time, rtol=1e-10, atol=1e-12)
    assert s.level(time, k) == pytest.approx(solved.y[0], abs=1e-8)
    assert s.level(time[-1], k) == pytest.approx(0.0, abs=1e-9)


@settings(max_examples=40)
@given(logarithm=st.floats(-11.0, -6.0), liquid=st.sampled_from([SILICONE, WATER]))
def test_noise_free_data_give_the_permeability_back(logarithm, liquid):
    """Within 0.2 % by the global method for any; by the instantaneous one where the bed is not lost beside the outlet."""
    k = 10.0**logarithm
    time, mass = readings(liquid, k)
    levels = levels_of(liquid, time, mass, interval=4.0 * (time[1] - time[0]))
    assert globally(liquid, levels).permeability == pytest.approx(k, rel=2e-3)
    assert mean_of(instantaneous(liquid, levels)).permeability == pytest.approx(k, rel=2e-3)


@settings(max_examples=40)
@given(logarithm=st.floats(-11.0, -7.5), seed=st.integers(0, 10**6))
def test_noisy_data_give_it_back_within_the_stated_interval(logarithm, seed):
    """Scale noise of 1 g. Three times the half width of the 95 % interval: exceeded once in 10^8. The interval itself is within
    5 %, but for the most permeable beds, whose runs are so short that it scatters up to 5.3 %."""
    k, random = 10.0**logarithm, np.random.default_rng(seed)
    time = np.linspace(0.0, SILICONE.duration(k), 2000)
    mass = SILICONE.mass(time, k) + random.normal(0.0, 1e-3, len(time))
    levels = levels_of(SILICONE, time, mass, interval=20.0 * time[1])
    found = globally(SILICONE, levels)
    half = 0.5 * (found.interval[1] - found.interval[0])
    assert abs(found.permeability - k) < 3.0 * half
    assert half < 0.05 * k or logarithm > -7.75


def test_simplified_approaches_drift_as_section_4_7_1_says():
    """On complete data: the second approach starts too low and rises; the third is lower still, and rises; R2 falls."""
    k = PUBLISHED["bed"][0]["k_global"]
    levels = levels_of(SILICONE, *readings(SILICONE, k))
    complete, neither, gravity = (instantaneous(SILICONE, levels, a) for a in ("complete", "neither", "gravity"))
    assert np.ptp(complete) < 2e-3 * k
    assert np.all(np.diff(neither) > 0.0) and np.all(np.diff(gravity) > 0.0)
    assert neither[-1] > 1.5 * neither[0] and gravity[-1] > gravity[0]
    assert np.all(gravity < neither)
    fits = [globally(SILICONE, levels, a).determination for a in ("complete", "neither", "gravity")]
    assert fits[0] == pytest.approx(1.0, abs=1e-9) and fits[1] < 0.999 and fits[2] < 0.999


def test_baseline_comes_from_a_run_without_beads():
    empty = replace(SILICONE)
    time, mass = readings(empty, 1.0)  # a permeability of 1 m2 is no bed at all
    c0, c1 = fit_baseline(replace(SILICONE, outlet_resistance=0.0, outlet_pressure=0.0), levels_of(empty, time, mass))
    assert c0 == pytest.approx(SILICONE.outlet_resistance, rel=1e-3)
    assert c1 == pytest.approx(SILICONE.outlet_pressure, rel=1e-2)


@pytest.mark.parametrize("bed", PUBLISHED["bed"], ids=lambda bed: f"bed {bed['id']}")
@pytest.mark.parametrize("name", ["ergun", "macdonald"])
def test_predictions_of_table_4_4(bed, name):
    """Within what the printed digits allow (+-0.005 in porosity, mm/200 in diameter); beds 1, 4 and 5 agree to 1 %."""
    law = DRAG_LAWS[name]
    least, most = (law.permeability(bed["porosity"] + e * 5e-3, bed["diameter"] + e * 5e-6) for e in (-1, 1))
    assert least - 5e-11 < bed[name] < most + 5e-11
    if bed["id"] in (1, 4, 5):
        assert law.permeability(bed["porosity"], bed["diameter"]) == pytest.approx(bed[name], rel=0.01)


def test_water_is_too_fast_for_darcy_and_silicone_oil_is_not():
    """Section 4.7: Reynolds numbers of 10 to 20 with water, below 0.1 with silicone oil, in beads of 3.26 mm."""
    k = PUBLISHED["bed"][0]["k_global"]
    free = replace(WATER, outlet_resistance=1e7, outlet_pressure=-2742.0)
    for setup, low, high in ((free, 1.0, 1e3), (SILICONE, 0.0, 0.1)):
        number = reynolds_number(setup, levels_of(setup, *readings(setup, k)), 3.26e-3)
        assert low < number < high


def test_too_short_a_test_is_refused():
    with pytest.raises(ValueError, match="intervals"):
        levels_of(SILICONE, [0.0, 1.0, 2.0], [0.0, 1e-3, 2e-3])
