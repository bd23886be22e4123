"""What is known of the walls before a scene is solved: capacities, cells through layers, and times, in the orders of magnitude of
`estimates`."""

import math
from collections.abc import Sequence
from itertools import accumulate
from typing import NamedTuple

from ..laws.materials import PiecewiseLinear, Solid
from ..scene.features.geometries import BedSize
from ..scene.features.wall import Layer
from .heat_capacity_peaks import changes_sharply
from .specs import HeatSpec, Specs

CELLS_A_DEPTH = 10.0
"""In a layer behind another one, for the depth sqrt(a t) that heat goes into it while the bed is heated."""
THICK = 10.0
"""Times in which a bed is heated, or that a run lasts, that heat needs at least to come through a layer that counts as thick."""
CELLS_OF_THICK = 32
"""Through such a layer, small at its surfaces."""
CELLS_OF_CURE = 6
"""Through a layer that cures, at least: it is hottest in its middle."""
MOST_CELLS, CELLS_OF_MELTING = 12, 3
"""Through a layer that is not thick; and times as many through one that melts, or whose conductivity jumps: temperatures halt as
each of its cells does."""
DRIVEN_FROM_OUTSIDE = 0.1
"""Of all temperature differences that are given, by which the surroundings differ from the start where they heat or cool the
wall, and not only take up what it loses: then its layers have the cells for that, too."""
SMALL_CHANGE, MOST_FOR_SMALL = 0.25, 3.0
"""Part of what heats the wall from outside, below which a place that is to change by that has more cells before it, as what comes
first is the foot of a steep profile: by the logarithm of that part over this one's, at most so many times (40 mm of a laminate
before a furnace of 900 °C, 30 °C at its inside: 1.0 % late on 12 cells)."""
CELLS_OF_TABLE = 4
"""Through a layer whose conductivity is a table, at least: a cell's quadrature points miss its kinks (a skin at 500 °C behind
20 mm of mineral wool: heat stored 0.7 % off on one cell, 0.04 % on four)."""
SOURCE_ERROR = 0.1
"""K that is cut off the parabola of temperature, q t^2/(4 k) high in a solid core, that a heat source q makes in a layer."""
ROUNDING = 1e-9
"""Of a wall's resistance."""
LEAST_END_LENGTH = 1e-3
"""Of the bed's length: shorter ends of the wall move the heating time by less than 0.05 %."""


class Store(NamedTuple):
    """Heat capacity (J/m2/K) and resistance to its own slowest mode (m2 K/W) of bed or layer, per area of the wall."""

    capacity: float
    resistance: float


def is_heated_from_outside(specs: Specs) -> bool:
    """Whether heat comes through the wall or is set free in it."""
    heat = specs.heat
    sources = any(layer.heat_source is not None or layer.solid.cure is not None for layer in heat.all_layers)
    outer = heat.outer_wall
    return sources or outer.exchanges or outer.heat_flux is not None or heat.is_wall_held


class Outside(NamedTuple):
    """What heats or cools the wall from outside: resistance of its film (m2 K/W), None of a given flux, and the temperature
    difference (K) that it makes."""

    resistance: float | None
    difference: float


def _outside(heat: HeatSpec, through: float) -> Outside | None:
    """Of a wall with the resistance `through` (m2 K/W); None where nothing heats or cools it."""
    outer, firsts = heat.outer_wall, heat.first_temperatures
    if outer.heat_flux is not None:
        return Outside(None, max(abs(flux) for flux in outer.heat_flux.range) * through)
    if not outer.exchanges or outer.ambient is None:
        return None
    low, high = heat.given_bounds
    apart = max(abs(value - first) for value in outer.ambient.range for first in firsts)
    film = outer.film(max(outer.ambient.range))
    return Outside(1.0 / film, apart) if film > 0.0 and apart > DRIVEN_FROM_OUTSIDE * (high - low) else None


def _times_for_small_change(change: float, difference: float) -> float:
    """Times the cells that layers have before a place that is to change by so much (K) of a difference outside (K)."""
    part = max(change, 1e-300) / difference if difference > 0.0 else 1.0
    return min(max(math.log(part) / math.log(SMALL_CHANGE), 1.0), MOST_FOR_SMALL)


def _sources(layers: Sequence[Layer], resistances: Sequence[float]) -> list[tuple[float, float]]:
    """Where layers with a heat source begin and end, by the resistance (m2 K/W) between them and the bed."""
    ends = list(accumulate(resistances))
    places = zip(layers, resistances, ends, strict=True)
    return [(end - own, end) for layer, own, end in places if layer.heat_source is not None]


def _waited_for(specs: Specs, layers: Sequence[Layer]) -> int:
    """Number of the layer of a wall, from the bed on, that is the last one waited for; a sensor may be in any."""
    time = specs.time
    places = {target.place for target in time.targets} or {time.heated.place}
    names = [layer.name for layer in layers]
    if not places <= {"bed", "bed_side", *(layer.name for layer in specs.heat.all_layers)}:
        return len(names)
    return max((number for number, name in enumerate(names, start=1) if name in places), default=0)


def conduction_time(specs: Specs, bed: Store) -> float:
    """Time constant (s) of wall and bed in series behind the film outside: every store through what lies before it; of the faster
    one of two walls."""
    temperature, outer = specs.heat.inlet_temperature.values[-1], specs.heat.outer_wall
    film = outer.film(temperature)
    times = []
    for layers in _walls(specs):
        behind, time = 1.0 / film if film else 0.0, 0.0
        for layer, thickness in reversed(layers):
            resistance = thickness / layer.solid.conductivity(temperature)
            time += volumetric_capacity(layer.solid, temperature) * thickness * (behind + 0.5 * resistance)
            behind += resistance
        times.append(time + bed.capacity * (behind + bed.resistance))
    return min(times)


def _walls(specs: Specs) -> list[list[tuple[Layer, float]]]:
    """The layers of each wall that have a thickness, with it."""
    heat = specs.heat
    walls = [heat.layers, heat.opposite_layers] if heat.opposite_layers else [heat.layers]
    return [[(layer, layer.thickness) for layer in layers if layer.thickness is not None] for layers in walls]


class WallEstimate(NamedTuple):
    """Heat capacity (J/K), cells through each layer, which layers are thick, and `end_length`, `time`, `wall_biot_number` of
    `Estimates`."""

    heat_capacity: float
    cells: tuple[int, ...]
    thick: tuple[bool, ...]
    end_length: float
    time: float
    biot_number: float


def wall_estimate(
    specs: Specs, size: BedSize, bed: Store, film: float, wall_coefficient: float, duration: float
) -> WallEstimate:
    """Of one wall, or of both: their capacities together, the slower of their times."""
    walls = _walls(specs)
    found = [
        _of_one_wall(specs, size.length, wall, layers, bed, film, wall_coefficient, duration)
        for wall, layers in zip(size.walls, walls, strict=True)
    ]
    return WallEstimate(
        sum(wall.heat_capacity for wall in found),
        tuple(cells for wall in found for cells in wall.cells),
        tuple(thick for wall in found for thick in wall.thick),
        min(wall.end_length for wall in found),
        max(wall.time for wall in found),
        max(wall.biot_number for wall in found),
    )


def _of_one_wall(
    specs: Specs,
    length: float,
    wall: tuple[float, float],
    layers: list[tuple[Layer, float]],
    bed: Store,
    film: float,
    wall_coefficient: float,
    duration: float,
) -> WallEstimate:
    """Of the layers of a wall (`BedSize.walls`) of a bed of a `length` (m): each follows the bed through what lies
    before it and half of itself; the wall's time ends with the layer by which half of its heat is stored, as insulation behind
    it follows later, or of a wall that stores less than the `bed` with the last one that is waited for. The bed is heated in
    `duration` (s)."""
    temperature = specs.heat.inlet_temperature.values[-1]
    given = [
        (thickness, layer.solid.conductivity(temperature), volumetric_capacity(layer.solid, temperature))
        for layer, thickness in layers
    ]
    if not given:
        return WallEstimate(0.0, (1,), (False,), length, 0.0, 0.0)
    stores = [storage * thickness for thickness, _, storage in given]
    capacity = time = passed = 0.0
    (around, curvature), resistance, cells = wall, 1.0 / wall_coefficient, []
    resistances = [thickness / conductivity for thickness, conductivity, _ in given]
    waited_for = _waited_for(specs, [layer for layer, _ in layers])
    through, sources = sum(resistances), _sources([layer for layer, _ in layers], resistances)
    outside = _outside(specs.heat, through)
    more = 1.0 if outside is None else _times_for_small_change(specs.least_change_needed(), outside.difference)
    for number, ((layer, _), (thickness, conductivity, storage), store) in enumerate(
        zip(layers, given, stores, strict=True), start=1
    ):
        behind, own = resistance - 1.0 / wall_coefficient, thickness / conductivity
        fewest = _cells_through(own / (1.0 / film + behind))
        if behind:  # what comes through another layer is no sharp front
            fewest = min(fewest, math.ceil(CELLS_A_DEPTH * thickness / math.sqrt(conductivity / storage * duration)))
        if outside is not None:  # of a flux, a layer's own resistance counts by what lies inside of it
            before = resistance if outside.resistance is None else outside.resistance
            fewest = max(fewest, _cells_through(own / (before + through - behind - own)))
        for begin, end in sources:
            apart = max(behind - end, begin - behind - own)
            if apart >= -ROUNDING * through:
                fewest = max(fewest, _cells_through(own / (max(apart, 0.0) + 0.5 * (end - begin))))
        fewest = max(fewest, 1 if layer.solid.cure is None else CELLS_OF_CURE)
        if isinstance(layer.solid.conductivity, PiecewiseLinear):
            fewest = max(fewest, CELLS_OF_TABLE)
        if layer.heat_source is not None:
            strongest = max(abs(value) for value in layer.heat_source.range)
            rise = strongest * thickness**2 / (4.0 * conductivity)
            fewest = max(fewest, math.ceil(math.sqrt(rise / SOURCE_ERROR)))
        laws = layer.solid.heat_capacity, layer.solid.conductivity
        times = CELLS_OF_MELTING if any(changes_sharply(law, specs.heat) for law in laws) else 1
        fewest = min(fewest, MOST_CELLS)
        cells.append(max(times * fewest, 1 + math.ceil(more * (fewest - 1))))
        if 2.0 * passed < sum(stores) and (number <= waited_for or sum(stores) > bed.capacity):
            time += store * (resistance + 0.5 * thickness / conductivity)
        resistance += thickness / conductivity
        passed += store
        perimeter = around + curvature * math.pi * thickness
        capacity += store * perimeter * length
    lasts = min(duration, specs.time.end_time)
    thick = tuple(thickness**2 * storage / conductivity > THICK * lasts for thickness, conductivity, storage in given)
    cells = [CELLS_OF_THICK if is_thick else number for number, is_thick in zip(cells, thick, strict=True)]
    thickness, conductivity, _ = max(given, key=lambda layer: layer[0] * layer[1])
    biot = film * thickness / conductivity
    end_length = max(thickness * max(1.0, 1.0 / math.sqrt(biot)), LEAST_END_LENGTH * length)
    largest = max(wall_coefficient * thickness / conductivity for thickness, conductivity, _ in given)
    return WallEstimate(capacity, tuple(cells), thick, end_length, time, largest)


def _cells_through(biot_number: float) -> int:
    """Cells through a layer by its resistance over that of all that lies before it: after a jump its temperature falls within
    them."""
    return math.ceil(8.0 * math.sqrt(biot_number))


def wall_nusselt_number(reynolds_number: float) -> float:
    """Nu of the bed's wall with the bead diameter, 2 + 0.17 Re^0.79: an order of magnitude (Li, Finlayson, Chem. Eng. Sci. 32
    (1977) 1055-1066, and a bed at rest)."""
    return 2.0 + 0.17 * reynolds_number**0.79


def volumetric_capacity(solid: Solid, temperature: float) -> float:
    """rho C of a solid, J/m3/K."""
    return float(solid.density(temperature) * solid.heat_capacity(temperature))
