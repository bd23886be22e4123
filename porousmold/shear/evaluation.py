"""What the blocks of a sheared cell say: profiles, fluxes with their standard errors, stirring (theory: `shear.cell`)."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Booleans, Floats
from .cell import ShearCell

SKIPPED_BLOCKS = 2
SMALLEST_GRADIENT = 0.2
"""Of the mean one: with less in the middle, nothing is measured there."""
LARGEST_ERROR = 0.3
"""Of a flux, its standard error up to which it says something."""
LARGEST_DRIFT = 0.05
"""Of a flux that counts as steady, over the flux."""


@dataclass(frozen=True)
class Sheared:
    """What was measured, in units of `ShearCell`.

    `pressure` (of contacts) over k/d, `friction_coefficient` of the bed (shear stress over normal stress), `coordination_number`,
    `core_shear_rate` over the nominal one, `core_solid_fraction`, `self_diffusion` over gamma d^2 of the core (with its standard
    error), and the `height` of the bins of the profiles `solid_fraction`, `velocity` (over gamma d) and `temperature` (bins, m).
    `conduction`, `convection` (m, 2): mean and standard error, over lambda (T_top - T_bottom)/H, positive from the hot to the
    cold wall; `wall_flux` (m): through the walls; `steady` (m); `stirring` (m): c, nan where the core has no gradient.
    `pictured` (times, n, 3): x, z and temperature of the first case during the last block.
    """

    cell: ShearCell
    beads: int
    steps: int
    pressure: float
    friction_coefficient: float
    coordination_number: float
    core_shear_rate: float
    core_solid_fraction: float
    self_diffusion: tuple[float, float]
    height: Floats
    solid_fraction: Floats
    velocity: Floats
    temperature: Floats
    conduction: Floats
    convection: Floats
    wall_flux: Floats
    steady: Booleans
    stirring: Floats
    pictured: Floats


def evaluate(
    cell: ShearCell, blocks: Sequence[Mapping[str, Floats]], beads: int, steps: int, pictured: Floats
) -> Sheared:
    """What the sums of `blocks`, per strain, say of a cell of so many free beads after so many time steps."""
    used, bins = blocks[SKIPPED_BLOCKS:], len(blocks[0]["profile"])
    mean = {key: np.mean([block[key] for block in used], axis=0) for key in used[0]}
    volume = cell.volume
    reference = 1.0 / cell.distance  # lambda (T_top - T_bottom)/H
    fluxes = -np.array([block["fluxes"].sum(axis=0) for block in used]) / volume / reference  # (blocks, m, 2)
    error, whole = fluxes.std(axis=0, ddof=1) / math.sqrt(len(used)), fluxes.sum(axis=2)
    profile = mean["profile"]
    number = np.maximum(profile[:, 0], 1e-12)
    slices = volume / bins
    share = profile[:, 0] / profile[:, 0].sum() * beads
    height, velocity, temperature = profile[:, 2] / number, profile[:, 1] / number, profile[:, 3:] / number[:, None]
    solid = share * math.pi / 6.0 / slices
    core = np.abs((np.arange(bins) + 0.5) / bins - 0.5) < 0.25
    rate = float(np.polyfit(height[core], velocity[core], 1)[0])
    gradient = np.polyfit(height[core], temperature[core], 1)[0]
    diffusion = np.array([block["diffusion"] for block in used])
    in_core = -mean["fluxes"][core, :, 1].sum(axis=0) / (core.sum() * slices)
    fraction = float(solid[core].mean())
    peclet, biot = np.array(cell.pairs).T
    with np.errstate(divide="ignore", invalid="ignore"):
        stirring = in_core / (4.0 * peclet * fraction * rate * gradient)
    enough = (np.abs(gradient) > SMALLEST_GRADIENT * reference) & (abs(rate) > SMALLEST_GRADIENT)
    stress = mean["stress"] / volume
    area = cell.width**2
    wall_flux = 0.5 * (mean["into_beads"][:, 1] - mean["into_beads"][:, 0]) / area / reference
    return Sheared(
        cell=cell,
        beads=beads,
        steps=steps,
        pressure=float(stress[0] / 3.0 / cell.stiffness),
        friction_coefficient=float(-stress[2] / stress[1]) if stress[1] else math.nan,
        coordination_number=float(2.0 * mean["stress"][3] / beads),
        core_shear_rate=rate,
        core_solid_fraction=fraction,
        self_diffusion=(
            float(diffusion.mean() / abs(rate)),
            float(diffusion.std(ddof=1) / math.sqrt(len(used)) / abs(rate)),
        ),
        height=height,
        solid_fraction=solid,
        velocity=velocity,
        temperature=temperature,
        conduction=np.column_stack((fluxes[:, :, 0].mean(axis=0), error[:, 0])),
        convection=np.column_stack((fluxes[:, :, 1].mean(axis=0), error[:, 1])),
        wall_flux=wall_flux,
        steady=_steady(whole, np.array([block["moment"] for block in used]) / volume / reference)
        & (_passes_the_walls(whole, wall_flux) | (biot > 0.0)),
        stirring=np.where(enough, stirring, math.nan),
        pictured=pictured,
    )


def _passes_the_walls(fluxes: Floats, wall_flux: Floats) -> Booleans:
    """Whether the fluxes of all blocks (blocks, m) are, in the mean, what passes the walls, as in a steady state without fluid:
    within three standard errors, which are no more than `LARGEST_ERROR` of the larger of both."""
    mean, error = fluxes.mean(axis=0), fluxes.std(axis=0, ddof=1) / math.sqrt(len(fluxes))
    larger = np.maximum(np.abs(mean), np.abs(wall_flux))
    agrees = np.abs(mean - wall_flux) <= np.maximum(3.0 * error, LARGEST_DRIFT * larger)
    return np.asarray(agrees & (error <= LARGEST_ERROR * larger))


def _steady(fluxes: Floats, stored: Floats) -> Booleans:
    """Whether the fluxes of both halves of the blocks (blocks, m) agree, and what is stored is small, for each case."""
    half = len(fluxes) // 2
    early, late = fluxes[:half], fluxes[half:]
    error = np.hypot(early.std(axis=0, ddof=1), late.std(axis=0, ddof=1)) / math.sqrt(half)
    allowed = LARGEST_DRIFT * np.abs(fluxes.mean(axis=0))
    storing = stored.std(axis=0, ddof=1) / math.sqrt(len(stored))
    agree = np.abs(late.mean(axis=0) - early.mean(axis=0)) <= np.maximum(3.0 * error, allowed)
    return np.asarray(agree & (np.abs(stored.mean(axis=0)) <= np.maximum(3.0 * storing, allowed)))
