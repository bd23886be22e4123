"""The closures against experiments: bands at few points of what `make validation` shows whole.

"measured" has to stay within what the correlations' scatter allows; of "thesis" today's ratios are pinned, so that nobody changes
them unknowingly.
"""

import tomllib
from pathlib import Path

import numpy as np
import pytest

import porousmold
from porousmold import Scene
from porousmold.experiment.comparison import compare
from porousmold.laws.drag import DRAG_LAWS
from studies.validation import at_rest
from studies.validation.beds import Bed, run_along
from studies.validation.correlations import (
    AIR,
    PRESSURE_DROP,
    li_finlayson,
    overall,
    overall_sets,
    wall_of,
    winterberg_tsotsas,
)

from .support import ALUMINIUM, STUDIES

MEASURED = {"model.closures": "measured"}
STEEL = STUDIES / "beds" / "steel_heated_from_above.toml"
MEASUREMENTS = sorted((STUDIES / "beds" / "steel_heated_from_above").glob("measured_*.csv"))
LEVER = {"model.flow": "developed", "output.pictures": False, "output.fields": False}


def median(re, n):
    return float(np.median(list(overall_sets(re, n).values())))


@pytest.mark.parametrize(("n", "re"), [(10, 100), (10, 420), (15, 1500), (20, 200), (30, 1000), (30, 3000)])
def test_heat_transfer_of_the_measured_closures(n, re):
    """Overall, from a wall of fixed temperature: 0.88 to 1.09 of the median of eight correlation sets at all 32 points of the
    page (1.083 at N = 30, Re = 3000, 1.08 and less elsewhere), of Li and Finlayson's alone 0.80 to 1.35 in their range."""
    found = Bed.of(re, n, MEASURED).overall_nusselt_number()
    assert 0.88 < found / median(re, n) < 1.09
    if n <= 20:
        assert 0.80 < found / li_finlayson(re, n) < 1.35


@pytest.mark.parametrize(
    ("settings", "ratios"),
    [
        ({"model.turbulence": "none"}, (0.624, 0.181)),
        ({"model.turbulence": "nakayama-kuwahara"}, (1.068, 0.509)),
        ({}, (1.092, 0.509)),
    ],
    ids=["laminar", "nakayama-kuwahara", "damped"],
)
def test_heat_transfer_of_the_thesis(settings, ratios):
    """Over the median at N = 20, Re = 420 and 3000: it falls with the Reynolds number, as nothing but eddies mixes."""
    found = [Bed.of(re, 20, settings).overall_nusselt_number() / median(re, 20) for re in (420, 3000)]
    assert found == pytest.approx(ratios, rel=0.02)


@pytest.mark.parametrize(("n", "re"), [(20, 50), (20, 420), (30, 1000)])
@pytest.mark.parametrize("slab", [False, True], ids=["tube", "slab"])
def test_pressure_drop_of_the_measured_closures(n, re, slab):
    """0.9 to 1.15 of each correlation at the bed's own mean void."""
    bed = Bed.of(re, n, MEASURED, slab=slab)
    for name, law in PRESSURE_DROP.items():
        if not (name.startswith("Dixon") and re < 100):
            assert 0.9 < bed.drag_factor / law.factor(re, bed.mean_porosity, n) < 1.15, name


def test_pressure_drop_of_the_thesis():
    """Macdonald's inertial constant does not fall with the Reynolds number."""
    ratios = []
    for re in (50, 420, 2000):
        bed = Bed.of(re, 20, {"model.turbulence": "none"})
        ratios.append(bed.drag_factor / PRESSURE_DROP["KTA 1981"].factor(re, bed.mean_porosity, 20))
    assert ratios == pytest.approx((1.05, 1.13, 1.28), rel=0.02)


def test_the_programs_energy_equation_gives_the_same_heat_transfer():
    """The page's is that of a section; beds of two lengths give it within 1.5 % (they conduct along the flow, too)."""
    for settings in ({}, MEASURED):
        section = Bed.of(420, 10, settings).overall_nusselt_number()
        assert run_along(420, 10, settings, (0.6, 1.2)) == pytest.approx(section, rel=0.015)


def test_permeabilities_that_the_thesis_measured():
    """Macdonald's viscous constant within 8 %; Ergun's is too permeable by 10 % and more."""
    beds = tomllib.loads((Path(__file__).parent / "published.toml").read_text())["permeability"]["bed"]
    ratios = {
        name: np.array([law.permeability(bed["porosity"], bed["diameter"]) / bed["k_global"] for bed in beds])
        for name, law in DRAG_LAWS.items()
        if name in ("macdonald", "ergun")
    }
    assert np.all(np.abs(ratios["macdonald"] - 1.0) < 0.08)
    assert np.all(ratios["ergun"] > 1.1)


def deviations(settings, folder):
    """Differences (K) from the three measured curves of the bed of steel beads."""
    porousmold.run(Scene.load(STEEL, {**LEVER, **settings}), out=folder)
    found = [deviation for path in MEASUREMENTS for deviation in compare(folder, path).deviations]
    assert len(found) == 3
    return [deviation.simulated - deviation.measured for deviation in found]


def test_a_bed_of_steel_beads_heated_from_above(tmp_path):
    """Within 1 K (rms) and the experiment's 2 K at 95 % of all points; as published it hardly warms."""
    measured = np.concatenate(deviations({}, tmp_path / "measured"))
    assert np.sqrt(np.mean(measured**2)) < 1.0
    assert np.mean(np.abs(measured) < 2.0) > 0.95
    first, *_ = deviations({"model.closures": "thesis"}, tmp_path / "thesis")
    assert first[-1] < -10.0


def test_aluminium_beads():
    """In the mold below 1800 s, where beads that conduct as published make it 2200 s; that is told."""
    times = {}
    for closures in ("thesis", "measured"):
        result = porousmold.run(
            Scene.load(ALUMINIUM, {**LEVER, "bed.bead_material": "aluminium", "model.closures": closures})
        )
        times[closures] = result.heating_time
        told = any("model.closures" in text for text in result.summary["warnings"])
        assert told == (closures == "thesis")
    assert times["measured"] < 1800.0 < 2100.0 < times["thesis"]


def test_correlations_agree_with_each_other_where_they_should():
    """A wall coefficient and its overall one; Winterberg and Tsotsas among the others at Re = 420."""
    assert wall_of(overall(20.0, 40.0, 15.0), 40.0, 15.0) == pytest.approx(20.0, rel=1e-9)
    others = [value for name, value in overall_sets(420, 15).items() if not name.startswith("Winterberg")]
    assert min(others) < winterberg_tsotsas(420, 15, 5e-3, AIR) < max(others)


def test_conductivity_of_ceramic_beads_in_helium():
    """Within 15 % (median) for every bed that it can have been measured on: 0.90 to 1.13."""
    ceramic = at_rest.SETS[0]
    for words in ceramic.beds:
        assert abs(np.median(ceramic.ratios(words)) - 1.0) < 0.15, words


def test_conductivity_of_graphite_at_rest_is_off_for_the_reasons_given():
    """Rough grains of 1 mm conduct half of the law, pebbles with convection in their voids twice, most in cold nitrogen."""
    comet, in_helium, in_nitrogen = at_rest.SETS[1:]
    assert all(2.0 <= np.median(comet.ratios(words)) < 2.8 for words in comet.beds)
    for words in in_helium.beds:
        assert 0.5 < np.median(in_helium.ratios(words)) < 0.7
        assert np.median(in_nitrogen.ratios(words)) < np.median(in_helium.ratios(words))


def test_compilation_of_beds_in_gas():
    """A median deviation within the law's published 30 % at each void, and no bias beyond it; the scatter of the authors
    (3.4 at one ratio) is a factor of 1.6 (rms)."""
    for void in (0.36, 0.40, 0.42):
        _, measured, found = at_rest.compilation(void)
        off = np.log(found / measured)
        assert np.median(np.abs(found / measured - 1.0)) < (0.4 if void == 0.36 else 0.3)
        assert abs(off.mean()) < 0.15
        assert np.sqrt(np.mean(off**2)) < np.log(1.65)


def test_pebbles_in_vacuum():
    """Shape of the profile within 3.6 % of its range by radiation alone, better with contact; radiation alone is too steep."""
    alone, touching = (at_rest.vacuum(0.49, flattening) for flattening in (0.0, at_rest.CERAMIC))
    assert touching.rms < 0.03 * 458.0 < 1.2 * alone.rms
    middle = np.argmin(np.abs(alone.places - 0.215))
    assert alone.computed[middle] > alone.measured[middle]


def test_pressure_drop_of_helium_through_steel_beads():
    """`measured` (KTA) within 16 %, at either end of the pressures that the source gives; the thesis's law up to 24 % high."""
    kta, macdonald = (
        np.concatenate([at_rest.helium_pressure_drop(name, pressure) for pressure in (1e5, 2e5)])
        for name in ("kta", "macdonald")
    )
    assert np.all(np.abs(kta - 1.0) < 0.165)
    assert macdonald.min() > 1.0 and 1.2 < macdonald.max() < 1.25
