"""The virtual experiment: what reading and handling errors do to a measured permeability (thesis section 4.7.2).

A test of known permeability is computed (eq. 4.13), read with errors, and evaluated by the global method. c0 and c1 of
the set-up are held whatever the liquid, as in the thesis: a set-up of fixed resistance. Errors are drawn
independently: the level h0 read at the start, the scale's resolution and noise, the temperature (through the viscosity that is
believed), and the time stamps. What comes out is the error of the permeability at 95 % confidence, and from it the range of
permeability that a set-up measures within a given error.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .falling_head import Setup, globally, levels_of

MOST_READINGS = 400
"""Of a virtual test: more bring nothing new."""


@dataclass(frozen=True)
class ReadingErrors:
    """Half widths or standard deviations: initial_head (m, uniform), scale_resolution (kg, rounding), scale_noise (kg, normal),
    viscosity (relative, normal: temperature error times the liquid's slope, some 2 % per kelvin for water and silicone oils),
    time_stamp (s, normal)."""

    initial_head: float = 0.5e-3
    scale_resolution: float = 1e-3
    scale_noise: float = 0.0
    viscosity: float = 0.0
    time_stamp: float = 0.0


@dataclass(frozen=True)
class Accuracy:
    """Of a permeability (m2): `bias` and the 95 % quantile of |error|, both relative; `failed`, the share of tests that gave
    nothing; `duration` of the test (s)."""

    permeability: float
    bias: float
    error: float
    failed: float
    duration: float


def virtual_test(
    setup: Setup,
    permeability: float,
    errors: ReadingErrors,
    random: np.random.Generator,
    *,
    reading_interval: float = 2.0,
    believed_head: float | None = None,
) -> float:
    """Relative error of the permeability that one virtual test gives; NaN where it gives none.

    setup: `Setup`; random: numpy generator; reading_interval: s between readings, changed for 20 to `MOST_READINGS` of them;
    believed_head: in place of a drawn reading of h0 (m).
    """
    end = setup.duration(permeability)
    time = np.linspace(0.0, end, int(np.clip(end / reading_interval, 20, MOST_READINGS)) + 1)
    mass = setup.mass(time, permeability) + random.normal(0.0, errors.scale_noise, len(time))
    if errors.scale_resolution > 0.0:
        mass = np.round(mass / errors.scale_resolution) * errors.scale_resolution
    stamps = np.sort(time + random.normal(0.0, errors.time_stamp, len(time)))
    if believed_head is None:
        believed_head = setup.initial_head + random.uniform(-1.0, 1.0) * errors.initial_head
    viscosity = setup.viscosity * float(np.exp(random.normal(0.0, errors.viscosity)))
    believed = replace(setup, initial_head=believed_head, viscosity=viscosity)
    try:
        found = globally(believed, levels_of(believed, stamps, mass, time[1])).permeability
    except (ValueError, RuntimeError):
        return float("nan")
    return found / permeability - 1.0 if 1e-3 < found / permeability < 1e3 else float("nan")


def accuracy(
    setup: Setup, permeability: float, errors: ReadingErrors, *, samples: int = 100, seed: int = 1
) -> Accuracy:
    """`Accuracy` by Monte Carlo."""
    random = np.random.default_rng(seed)
    found = np.array([virtual_test(setup, permeability, errors, random) for _ in range(samples)])
    good = found[np.isfinite(found)]
    duration = setup.duration(permeability)
    if len(good) < 0.5 * samples:
        return Accuracy(permeability, float("nan"), float("inf"), 1.0 - len(good) / samples, duration)
    # a test that gives nothing is wrong by all there is
    errors_found = np.sort(np.concatenate([np.abs(good), np.full(samples - len(good), np.inf)]))
    error = errors_found[int(np.ceil(0.95 * samples)) - 1]
    return Accuracy(permeability, float(np.mean(good)), float(error), 1.0 - len(good) / samples, duration)


def measurable_range(found: Any, error: float, longest: float) -> Any:
    """(least, greatest) permeability (m2) of a row of `Accuracy` within the `error` and a duration of `longest` s; None if
    there is none."""
    within = [a.permeability for a in found if a.error <= error and a.duration <= longest]
    return (min(within), max(within)) if within else None
