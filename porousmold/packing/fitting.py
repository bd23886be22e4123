"""How well porosity laws meet a measured profile: R², fitted bulk porosity, and the piecewise-linear fit.

R² = 1 - sum (phi - law)² / sum (phi - mean phi)² over the points, each counted once (thesis, section 5.7).
"""

from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from scipy.optimize import least_squares, minimize_scalar

from ..arrays import Floats
from ..laws.porosity import POROSITY_MODELS, PorosityModel

if TYPE_CHECKING:
    from .averaging import MeasuredProfile


def r_squared(values: Floats, predicted: Floats) -> float:
    """Coefficient of determination of predictions for values (arrays of one shape)."""
    values = np.asarray(values, float)
    return float(1.0 - ((values - predicted) ** 2).sum() / ((values - values.mean()) ** 2).sum())


@dataclass(frozen=True)
class Score:
    """R² of a porosity law with a given bulk porosity, and the bulk porosity that fits best with its R²."""

    given: float
    fitted_bulk_porosity: float
    fitted: float


def model_scores(position: Floats, porosity: Floats, bulk_porosity: float = 0.4) -> dict[str, Score]:
    """`Score` of every exponential law for porosities at wall distances `position` (in bead diameters)."""
    position = np.asarray(position, float)
    scores = {}
    for name, law in POROSITY_MODELS.items():
        if name == "constant":
            continue

        def error(bulk: float, law: PorosityModel = law) -> float:
            return float(((law(position, 1.0, bulk) - porosity) ** 2).sum())

        best = float(minimize_scalar(error, bounds=(0.2, min(0.6, law.largest_bulk_porosity)), method="bounded").x)
        scores[name] = Score(r_squared(porosity, law(position, 1.0, bulk_porosity)), best,
                             r_squared(porosity, law(position, 1.0, best)))  # fmt: skip
    return scores


@dataclass(frozen=True)
class PiecewiseLinear:
    """Straight lines between knots (wall distance in bead diameters, porosity); constant beyond the last."""

    knots: Floats
    values: Floats

    def __call__(self, position: Floats) -> Floats:
        """Porosity at wall distances in bead diameters."""
        return np.interp(position, self.knots, self.values)


Fits: TypeAlias = tuple[PiecewiseLinear, PiecewiseLinear]


def profile_fits(profile: "MeasuredProfile") -> Fits:
    """The piecewise-linear fits of phi_V and phi_A of a `MeasuredProfile`."""
    return piecewise_linear(profile.position, profile.phi_v), piecewise_linear(profile.position, profile.phi_a)


def piecewise_linear(position: Floats, porosity: Floats, segments: int = 4) -> PiecewiseLinear:
    """The continuous piecewise-linear least-squares fit with free knots that is 1 at the wall (thesis, figure 5.4).

    `segments` lines and a constant beyond the last knot. The values at given knots follow from linear least squares;
    the knots are the best choice out of 16 places, spread evenly over the square root of y/d up to 4, and are moved from
    there to the nearest minimum.
    """
    position, porosity = np.asarray(position, float), np.asarray(porosity, float)

    def fitted(knots: Floats) -> PiecewiseLinear:
        knots = np.append(0.0, knots)
        hats = np.column_stack([np.interp(position, knots, row) for row in np.eye(knots.size)])
        values = np.linalg.lstsq(hats[:, 1:], porosity - hats[:, 0], rcond=None)[0]
        return PiecewiseLinear(knots, np.concatenate(([1.0], values)))

    def residuals(knots: Floats) -> Floats:
        return fitted(knots)(position) - porosity

    places = np.linspace(0.35, np.sqrt(min(4.0, position.max())), 16) ** 2
    start = min(
        (np.array(knots) for knots in combinations(places, segments)), key=lambda knots: (residuals(knots) ** 2).sum()
    )
    # each knot stays on its side of the middles between those of the start, so that their order holds
    middles = 0.5 * (start[1:] + start[:-1])
    bounds = np.concatenate(([0.5 * start[0]], middles)), np.concatenate((middles, [start[-1] + 1.0]))
    return fitted(least_squares(residuals, start, bounds=bounds, x_scale=0.1).x)
