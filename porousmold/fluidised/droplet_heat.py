r"""Heat of a droplet in a bed: what its gas and grains store, conduct and give to it.

Q_f by nodes within its circle, which have its temperature, and lambda_0 of the bed at rest from there to the next ones outside,
    with which alone the grains at its edge exchange heat
Q_p = sum of M C (T - T_d)/tau over grains inside,    tau = rho_s C d^2/(12 lambda_w)    (Nu = 2)
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..arrays import Booleans, Floats
from ..laws.conductivity import LocalBed, stagnant_conductivity
from ..laws.evaporation import BOILING_TEMPERATURE
from .column_grid import ColumnGrid, Weights
from .droplet import HELD, Droplet
from .droplet_beads import DropletBeads
from .droplet_gas import DropletGas
from .droplet_input import DropletInput
from .parcel_heat import ParcelHeat

LARGEST_SHARE = 0.72
"""Of the grains in what the droplet leaves of a node's cell."""
EVENING = 4.0
"""Rate at which parcels of one cell even out, over lambda_0/(rho C h^2) of the bed. They would by their films, in 10 ms, but
cells of several parcels then conduct by it: 40 % more heat to a droplet in a bed at rest; with this rate 6 %."""
EMPTY = LocalBed(
    porosity=1.0, wall_distance=1.0, bead_diameter=1.0, density=1.0, viscosity=1.0, heat_capacity=1.0, speed=0.0,
    eddy_viscosity=0.0, fluid_conductivity=1.0, bead_conductivity=1.0, bulk_porosity=0.4, core_speed=0.0, temperature=300.0,
)  # fmt: skip
"""For `stagnant_conductivity`, which knows both conductivities and a porosity."""


class Placed(NamedTuple):
    """Where beads and droplet are: the beads' weights at the nodes and whether they are inside the droplet; at the nodes the
    share of the beads outside, their speed relative to the gas (m/s), their drag (kg/m3/s), and the share of the circle."""

    weights: Weights
    inside: Booleans
    share: Floats
    slip: Floats
    drag: Floats
    circle: Floats


@dataclass
class HeatBooks:
    """Heat (J) that was there at first, and since then given to the droplet, carried off through the top beyond what gas has of
    the initial temperature, brought by vapour beyond that, and given by the side walls."""

    at_first: float
    to_droplet: float = 0.0
    carried_off: float = 0.0
    by_vapour: float = 0.0
    by_walls: float = 0.0


class DropletHeat:
    """The heat of a `DropletInput`; `exchange` takes it over a step."""

    def __init__(
        self, given: DropletInput, grid: ColumnGrid, gas: DropletGas, beads: DropletBeads, droplet: Droplet
    ) -> None:
        self._given, self._grid, self._gas, self._beads, self._droplet = given, grid, gas, beads, droplet
        self._at_walls = np.zeros_like(gas.pressure)
        self._at_walls[:, [0, -1]] = HELD / grid.sizes[1] ** 2
        capacity = given.solid_fraction * given.bead_density * given.bead_heat_capacity
        conductivity = float(self.conductivity(np.array(given.solid_fraction)))
        self._evening_rate = EVENING * conductivity / capacity / math.prod(grid.sizes)
        self.books = HeatBooks(self._stored())

    @property
    def imbalance(self) -> float:
        """Heat that is missing, over what the droplet got."""
        books = self.books
        moved = books.by_vapour + books.by_walls - books.carried_off - books.to_droplet
        return (self._stored() - books.at_first - moved) / max(abs(books.to_droplet), 1e-30)

    def exchange(self, placed: Placed, vapour: Floats) -> tuple[float, float]:
        """Temperatures over a step, and the share of vapour; gives the heat to the droplet by the gas and by the grains
        inside, W."""
        weights, inside, share, slip = placed[:4]
        given, grid, gas, beads, droplet = self._given, self._grid, self._gas, self._beads, self._droplet
        step, start = given.time_step, given.initial_temperature
        porosity = np.clip(1.0 - share, 1.0 - LARGEST_SHARE, 1.0)
        film = given.film_coefficient(given.grain_diameter, gas.porosity * given.density * slip, porosity)
        free = droplet.is_free()
        parcels = ParcelHeat(grid, weights, free, beads.mass * given.bead_heat_capacity * ~inside)
        mean = parcels.mean(beads.temperature)
        # of the film of grains that fill a volume with their heat capacity
        rate = 6.0 * film / (given.grain_diameter * given.bead_density * given.bead_heat_capacity)
        exchange = -parcels.capacity / step * np.expm1(-rate * step) / grid.volumes
        heating = exchange * mean
        conductivity = self.conductivity(share)
        held = droplet.held(free, float(conductivity.max()))
        walls = self._at_walls * conductivity
        made = vapour / given.density
        pinned = droplet.held(free, given.vapour_diffusivity) + made
        leaving = gas.transport(
            made,
            droplet.between(conductivity, free),
            (
                exchange + held + walls,
                heating + (held + vapour * given.heat_capacity) * BOILING_TEMPERATURE + walls * start,
            ),
            droplet.between(given.vapour_diffusivity * gas.porosity, free),
            (pinned, pinned),
        )
        by_gas = float((held * (gas.temperature - BOILING_TEMPERATURE) * grid.volumes).sum())
        gained = exchange * (gas.temperature - mean) * grid.volumes * step / np.maximum(parcels.capacity, 1e-30)
        parcels.add(beads.temperature, mean, gained, (BOILING_TEMPERATURE, start))
        parcels.relax(beads.temperature, -math.expm1(-self._evening_rate * step))
        slow = given.bead_density * given.bead_heat_capacity * given.grain_diameter**2 / 12.0
        left = math.exp(-step * droplet.water.conductivity / slow)
        given_off = (1.0 - left) * (beads.temperature - BOILING_TEMPERATURE) * inside
        beads.temperature -= given_off
        by_beads = float(beads.mass * given.bead_heat_capacity * given_off.sum() / step)
        books, per_volume = self.books, given.density * given.heat_capacity
        made_rate = float((vapour * grid.volumes).sum())
        books.to_droplet += (by_gas + by_beads) * step
        books.carried_off += (leaving - per_volume * gas.volume_flow * start) * step
        books.by_vapour += made_rate * given.heat_capacity * (BOILING_TEMPERATURE - start) * step
        books.by_walls += float((walls * (start - gas.temperature) * grid.volumes).sum()) * step
        return by_gas, by_beads

    def conductivity(self, share: Floats) -> Floats:
        """lambda_0 (W/m/K) of the bed at rest where grains fill a share, or what its gas conducts alone."""
        given = self._given
        porosity = np.clip(1.0 - share, 1.0 - LARGEST_SHARE, 1.0)
        if given.conduction == "gas":
            return np.asarray(given.conductivity * porosity)
        bed = replace(EMPTY, fluid_conductivity=given.conductivity, bead_conductivity=given.bead_conductivity)
        return np.asarray(stagnant_conductivity(bed, porosity))

    def _stored(self) -> float:
        """Of gas and grains above the initial temperature, J."""
        given, gas, start = self._given, self._gas, self._given.initial_temperature
        in_gas = given.density * given.heat_capacity * (self._grid.volumes * gas.porosity * (gas.temperature - start))
        beads = self._beads.mass * given.bead_heat_capacity * (self._beads.temperature - start)
        return float(in_gas.sum() + beads.sum())
