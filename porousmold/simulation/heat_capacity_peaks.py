"""Peaks of heat capacities, as of what melts."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..laws.functions import Value
from ..laws.materials import Solid
from ..solvers.stages import STAGE_ERROR

if TYPE_CHECKING:
    from .specs import HeatSpec, Specs

NARROW = 0.05
"""Part of all temperature differences within which a heat capacity that changes much has a peak."""
SMOOTH_CHANGE = 1.5
"""Factor on it within that part, below which it has none."""
PART_AT_PEAK = 0.3
"""Of a stage's error over the factor on a heat capacity with a peak: of 20 to 90, heat balances close within 3e-4, with all of it
7e-4."""
POINTS = 4001
"""At which it is looked at."""


def sharpest_change(law: Value, low: float, high: float) -> float:
    """Largest factor by which a property changes within `NARROW` of the range from `low` to `high` (K)."""
    temperatures = np.linspace(low, high, POINTS)
    values = np.asarray(law(temperatures)) + 0.0 * temperatures
    largest = 1.0
    for beside in np.unique(np.geomspace(1, NARROW * (POINTS - 1), 8).astype(int)):
        ratios = values[beside:] / values[:-beside]
        largest = max(largest, float(np.max(ratios)), float(1.0 / np.min(ratios)))
    return largest


def changes_sharply(law: Value, heat: "HeatSpec") -> bool:
    """Whether a property does within a small part of the temperatures that may be reached."""
    return sharpest_change(law, *heat.reached) > SMOOTH_CHANGE


def melts(heat_capacity: Value, heat: "HeatSpec") -> bool:
    """Whether a heat capacity has a peak between the temperatures that may be reached."""
    return changes_sharply(heat_capacity, heat)


def stage_error(sharpest: float) -> float:
    """Relative error at which a stage counts as solved, by the sharpest change of a heat capacity: a kelvin within a peak is more
    heat than elsewhere, and errors of the stages add up, the more so the more steps there are."""
    return PART_AT_PEAK * STAGE_ERROR / sharpest if sharpest > SMOOTH_CHANGE else STAGE_ERROR


def heats_where_it_melts(heat: "HeatSpec", beads: Solid) -> dict[str, Callable[[float], float]]:
    """Enthalpy (J/kg) against temperature (K) of every place that melts as a whole: bed, layers, a wall of one layer, and of a
    thin one the bed's side, which is the wall."""
    layers = {layer.name: layer.solid for layer in heat.all_layers if not layer.is_contact}
    solids = layers | {"bed": beads}
    if len(layers) == 1:
        solids["wall"] = next(iter(layers.values()))
        if heat.wall.kind == "thin":
            solids["bed_side"] = solids["wall"]
    return {name: solid.heat_capacity.integral for name, solid in solids.items() if melts(solid.heat_capacity, heat)}


def sharpest_change_of_stores(specs: "Specs") -> float:
    """The same of fluid, beads and every layer of the wall, over all temperatures that they may have."""
    of_walls = [layer.solid.heat_capacity for layer in specs.heat.all_layers]
    capacities = [specs.laws.fluid.heat_capacity, specs.laws.beads.heat_capacity, *of_walls]
    return max(sharpest_change(one, *specs.heat.reached) for one in capacities)
