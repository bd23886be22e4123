"""R², fitted bulk porosities and piecewise-linear fits recover what was put in."""

import numpy as np
import pytest

from porousmold.laws.oscillating_porosity import de_klerk
from porousmold.laws.porosity import POROSITY_MODELS
from porousmold.packing.fitting import PiecewiseLinear, model_scores, piecewise_linear, r_squared

POSITION = np.linspace(0.0, 6.0, 80)


def test_r_squared_of_truth_and_mean():
    values = np.array([1.0, 2.0, 4.0])
    assert r_squared(values, values) == 1.0
    assert r_squared(values, np.full(3, values.mean())) == pytest.approx(0.0)


@pytest.mark.parametrize("name", [name for name in POROSITY_MODELS if name != "constant"])
def test_law_finds_its_own_bulk_porosity(name):
    scores = model_scores(POSITION, POROSITY_MODELS[name](POSITION, 1.0, 0.37))
    assert scores[name].fitted_bulk_porosity == pytest.approx(0.37, abs=1e-4)
    assert scores[name].fitted == pytest.approx(1.0)
    assert scores[name].given < 1.0
    assert scores[name].fitted == max(score.fitted for score in scores.values())


def test_piecewise_linear_finds_its_knots():
    truth = PiecewiseLinear(np.array([0.0, 0.3, 0.55, 1.4, 3.0]), np.array([1.0, 0.5, 0.37, 0.42, 0.39]))
    fit = piecewise_linear(POSITION, truth(POSITION))
    assert fit(POSITION) == pytest.approx(truth(POSITION), abs=2e-3)
    assert fit(0.0) == 1.0 and fit(50.0) == pytest.approx(0.39, abs=2e-3)


def test_de_klerk_is_one_at_the_wall_and_the_bulk_far_away():
    assert de_klerk(0.0, 0.38) == 1.0
    assert de_klerk(np.array([12.0]), 0.38) == pytest.approx(0.38, abs=1e-3)
    # its branches meet for a bulk porosity of 0.36
    assert de_klerk(0.637, 0.36) == pytest.approx(de_klerk(0.637 + 1e-9, 0.36), abs=3e-3)
