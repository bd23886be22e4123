r"""A droplet of water on, and in, a hot bed of grains (Henry et al., section 4): its vapour may lift them and dig it in.

Grains are drawn together into parcels (`droplet_beads`) on the grid of `column_grid`; the gas is `droplet_gas`, the droplet
`droplet`. A step: porosity, drag and the droplet's circle at the nodes; the vapour that the heat of the step before makes, evenly
around the circle; pressure and velocity of the gas; temperatures of gas and grains, share of vapour, and the heat to the droplet,

    Q_f by nodes within its circle, which have its temperature, and lambda_0 of the bed at rest from there to the next ones
        outside, with which alone the grains at its edge exchange heat
    Q_p = sum of M C (T - T_d)/tau over grains inside,    tau = rho_s C d^2/(12 lambda_w)    (Nu = 2)

then beads and droplet together, in `column_beads.CHUNKS` parts. Grains feel the gas as in `column`, by their own diameter; inside
the circle they feel the water instead. Where gas is wet (vapour below `DRY`), a contact holds with `bond` grain weights over the
grain's area (paper: 7.5e-4 N/m, 10 weights of a disc of 55 um).

Side walls have the bed's initial temperature, no heat passes front and rear, the top is open, gas that comes in there is like
that which is there. What the model leaves out: the droplet's shape, capillarity, radiation, wetting and boiling on the grains.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..arrays import Booleans, Floats
from ..errors import SolveError
from ..files.atomic_files import output_file
from ..laws.conductivity import LocalBed, stagnant_conductivity
from ..laws.evaporation import BOILING_TEMPERATURE, LATENT_HEAT
from ..laws.fluidisation import GRAVITY, SUSPENSION_DRAGS
from ..laws.nusselt import NUSSELT_CORRELATIONS, prandtl_number
from .column_grid import ColumnGrid, Weights
from .droplet import Droplet
from .droplet_beads import DropletBeads
from .droplet_gas import DropletGas, Surroundings
from .droplet_input import DropletInput
from .parcel_heat import ParcelHeat

LARGEST_SHARE = 0.72
"""Of the grains in what the droplet leaves of a node's cell."""
OF_THE_CIRCLE = 0.9
"""Part of the circle that is closed to the gas in the balance of volume: some porosity is left at each node."""
BLOCKING, FULL = 1e8, 0.95
"""Resistance (kg/m3/s) of nodes that the circle fills so far: the gas there moves with the droplet. With nodes that are filled
less, the thrust of its vapour is 5 to 10 % too large on these cells."""
DRY = 0.9
"""Share of vapour from which grains do not stick together (the paper's psi_0)."""
HOTTEST_WET = 473.15
"""Temperature (K) from which, with `contact` 'film', vapour keeps grains out: the Leidenfrost point of water lies about there."""
EVENING = 4.0
"""Rate at which parcels of one cell even out, over lambda_0/(rho C h^2) of the bed. They would by their films, in 10 ms, but
cells of several parcels then conduct by it: 40 % more heat to a droplet in a bed at rest; with this rate 6 %."""
GONE = 0.03
"""Part of the water, below which the droplet is taken as evaporated."""


class Placed(NamedTuple):
    """Where beads and droplet are: the beads' weights at the nodes and whether they are inside the droplet; at the nodes the
    share of the beads outside, their speed relative to the gas (m/s), their drag (kg/m3/s), and the share of the circle."""

    weights: Weights
    inside: Booleans
    share: Floats
    slip: Floats
    drag: Floats
    circle: Floats


class DropletColumn:
    """The state of a `DropletInput`; `step()` advances it by its `time_step` (s), `rows` has what is recorded of every step."""

    def __init__(self, given: DropletInput, beads: DropletBeads | None = None) -> None:
        self.given, self.time = given, 0.0
        self.rows: list[dict[str, float]] = []
        self.beads, self.grid = beads or DropletBeads.at_rest(given), ColumnGrid(given)
        self.surface = self.beads.surface
        self.gas = DropletGas(given, self.grid)
        self.droplet = Droplet(given, self.grid, self.surface)
        self.evaporation = 0.0
        self._water_at_first = self.droplet.mass
        self._at_walls = np.zeros_like(self.gas.pressure)
        self._at_walls[:, [0, -1]] = 50.0 / (self.grid.lengths[1] / self.grid.cells[1]) ** 2
        capacity = given.solid_fraction * given.bead_density * given.bead_heat_capacity
        area = math.prod(length / n for length, n in zip(self.grid.lengths, self.grid.cells, strict=True))
        self._evening_rate = EVENING * float(self.conductivity(np.array(given.solid_fraction))) / capacity / area
        self._place()
        self.gas.keep()
        self._books = {"heat_at_first": self._heat(), "gas_at_first": self._gas_volume()}
        self._books |= dict.fromkeys(("to_droplet", "carried_off", "by_vapour", "by_walls", "made", "left"), 0.0)

    @classmethod
    def restored(cls, given: DropletInput, saved: Mapping[str, Floats]) -> "DropletColumn":
        """The column that `save` wrote a checkpoint of."""
        beads = DropletBeads(given, given.bead_diameter * saved["body"][:, :3], float(saved["fill"]))
        column = cls(given, beads)
        beads.restore(saved)
        column.gas.restore(saved)
        column.time, column.surface, column.evaporation, column._water_at_first = map(float, saved["numbers"])
        droplet = column.droplet
        droplet.place, droplet.velocity = saved["droplet"][:2].copy(), saved["droplet"][2:4].copy()
        droplet.mass, droplet.radius = map(float, saved["droplet"][4:])
        column._books = dict(zip(column._books, map(float, saved["books"]), strict=True))
        names = [str(name) for name in saved["row_names"]]
        column.rows = [dict(zip(names, map(float, row), strict=True)) for row in saved["rows"]]
        return column

    @property
    def depth(self) -> float:
        """Of the droplet's centre below the surface that the bed had, m."""
        return self.surface - float(self.droplet.place[1])

    @property
    def is_evaporated(self) -> bool:
        """Whether hardly any water is left."""
        return self.droplet.mass < GONE * self._water_at_first

    def march(self, end_time: float, progress: Callable[[float, float, str], None] | None = None) -> None:
        """Step until `end_time` (s), or until the water is gone; progress(time, end time, text)."""
        while self.time < end_time - 0.5 * self.given.time_step and not self.is_evaporated:
            self.step()
            if progress is not None:
                progress(self.time, end_time, f"droplet {1e3 * self.depth:+.2f} mm deep")

    def step(self) -> None:
        """One step. Raises `SolveError` where a bead leaves the column."""
        given, gas, droplet = self.given, self.gas, self.droplet
        gas.keep()
        placed = self._place()
        inside = int(placed.inside.sum())
        vapour = droplet.source(self.evaporation, placed.circle)
        gas.flow(vapour / given.density * (1.0 - OF_THE_CIRCLE * given.density / droplet.water.density))
        by_gas, by_beads = self._exchange_heat(placed, vapour)
        force, on_beads = self._move(placed)
        droplet.mass -= self.evaporation * given.time_step
        self._books["made"] += self.evaporation * given.time_step
        self.evaporation = max(by_gas + by_beads, 0.0) / LATENT_HEAT
        droplet.swell(self.beads.volume * inside)
        self.time += given.time_step
        self._record(by_gas, by_beads, force, on_beads, inside)
        if self.rows[-1]["highest_bead"] > given.height:
            raise SolveError("droplet", self.time, "a bead leaves the column", "a higher one (--height)")

    def _place(self) -> Placed:
        """Put beads and droplet into the gas."""
        given, grid, beads, droplet = self.given, self.grid, self.beads, self.droplet
        places = beads.places
        weights, inside, circle = grid.weights(places), droplet.is_inside(places), droplet.share()
        volume = beads.volume * ~inside
        spread = grid.spread(weights, volume) / grid.volumes
        share = np.minimum(spread, LARGEST_SHARE * (1.0 - circle))
        velocity, pushed = (
            [grid.spread(weights, volume * values) / grid.volumes / np.maximum(spread, 1e-9) for values in of_beads]
            for of_beads in (beads.velocity, beads.acceleration)
        )
        slip = np.hypot(*(gas - of_beads for gas, of_beads in zip(self.gas.velocity, velocity, strict=True)))
        beside = np.minimum(share / np.maximum(1.0 - circle, 1.0 - LARGEST_SHARE), LARGEST_SHARE)
        law = SUSPENSION_DRAGS[given.drag]
        drag = law(1.0 - beside, given.grain_diameter, given.density, given.viscosity, slip) * (share > 0.0)
        resistance = np.maximum(share * given.bead_density / given.time_step + drag, 1e-30)
        closed = OF_THE_CIRCLE * circle
        across, up = droplet.velocity
        self.gas.surround(Surroundings(
            beads=share,
            droplet=closed,
            bead_velocity=[now + given.time_step * more for now, more in zip(velocity, pushed, strict=True)],
            drag=drag,
            theta=drag / resistance,
            resistance=resistance,
            droplet_velocity=[float(up) - GRAVITY * given.time_step, float(across)],
            droplet_yielding=closed * given.time_step / droplet.water.density,
            droplet_resistance=BLOCKING * (circle > FULL),
        ))  # fmt: skip
        return Placed(weights, inside, share, slip, drag, circle)

    def _exchange_heat(self, placed: Placed, vapour: Floats) -> tuple[float, float]:
        """Temperatures over a step, and the share of vapour; gives the heat to the droplet by the gas and by the grains
        inside, W."""
        weights, inside, share, slip = placed[:4]
        given, grid, gas, beads, droplet = self.given, self.grid, self.gas, self.beads, self.droplet
        step, start = given.time_step, given.initial_temperature
        reynolds = gas.porosity * given.density * slip * given.grain_diameter / given.viscosity
        prandtl = prandtl_number(given.viscosity, given.heat_capacity, given.conductivity)
        porosity = np.clip(1.0 - share, 1.0 - LARGEST_SHARE, 1.0)
        nusselt = np.asarray(NUSSELT_CORRELATIONS[given.nusselt](np.maximum(reynolds, 1e-3), prandtl, porosity))
        film = nusselt * given.conductivity / given.grain_diameter
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
        wet = droplet.held(free, given.vapour_diffusivity) + made
        leaving = gas.transport(
            made,
            droplet.between(conductivity, free),
            (
                exchange + held + walls,
                heating + (held + vapour * given.heat_capacity) * BOILING_TEMPERATURE + walls * start,
            ),
            droplet.between(given.vapour_diffusivity * gas.porosity, free),
            (wet, wet),
        )
        by_gas = float((held * (gas.temperature - BOILING_TEMPERATURE) * grid.volumes).sum())
        given_up = exchange * (gas.temperature - mean) * grid.volumes * step / np.maximum(parcels.capacity, 1e-30)
        parcels.add(beads.temperature, mean, given_up, (BOILING_TEMPERATURE, start))
        parcels.relax(beads.temperature, -math.expm1(-self._evening_rate * step))
        slow = given.bead_density * given.bead_heat_capacity * given.grain_diameter**2 / 12.0
        left = math.exp(-step * droplet.water.conductivity / slow)
        given_off = (1.0 - left) * (beads.temperature - BOILING_TEMPERATURE) * inside
        beads.temperature -= given_off
        by_beads = float(beads.mass * given.bead_heat_capacity * given_off.sum() / step)
        per_volume, books = given.density * given.heat_capacity, self._books
        books["to_droplet"] += (by_gas + by_beads) * step
        books["carried_off"] += (leaving - per_volume * gas.volume_flow * start) * step
        books["by_vapour"] += self.evaporation * given.heat_capacity * (BOILING_TEMPERATURE - start) * step
        books["by_walls"] += float((walls * (start - gas.temperature) * grid.volumes).sum()) * step
        books["left"] += given.density * gas.volume_flow * step
        return by_gas, by_beads

    def conductivity(self, share: Floats) -> Floats:
        """lambda_0 (W/m/K) of the bed at rest where grains fill a share, or what its gas conducts alone."""
        given = self.given
        porosity = np.clip(1.0 - share, 1.0 - LARGEST_SHARE, 1.0)
        if given.conduction == "gas":
            return np.asarray(given.conductivity * porosity)
        bed = replace(EMPTY, fluid_conductivity=given.conductivity, bead_conductivity=given.bead_conductivity)
        return np.asarray(stagnant_conductivity(bed, porosity))

    def _move(self, placed: Placed) -> tuple[Floats, float]:
        """Beads and droplet over a step; gives F_f (N; across, up) and the gas's force on the beads (N, up)."""
        weights, inside, share, _, drag, _ = placed
        given, grid, beads, droplet, gas = self.given, self.grid, self.beads, self.droplet, self.gas
        force = droplet.pressure_force(gas.pressure)
        velocity = [grid.at(weights, values) for values in gas.velocity]
        push = [-slope / given.bead_density * ~inside for slope in grid.gradient(weights, gas.pressure)]
        per_mass = np.where(share > 1e-6, drag / np.maximum(share, 1e-9) / given.bead_density, 0.0)
        rate = grid.at(weights, per_mass) * ~inside
        on_beads = beads.mass * float((push[0] + rate * (velocity[0] - beads.velocity[0])).sum())
        wet = grid.at(weights, gas.vapour) < DRY
        beads.bonds = beads.by_name(given.bond * given.grain_diameter / given.bead_diameter * wet)
        beads.repelled = beads.by_name(
            (beads.temperature > HOTTEST_WET) & ~inside if given.contact == "film" else np.zeros(len(beads), bool)
        )
        beads.in_water = beads.by_name(self._rate_in_water(placed))
        beads.pressure_force = force
        beads.move_with(droplet, velocity, push, rate)
        return force, on_beads

    def _rate_in_water(self, placed: Placed) -> Floats:
        """Rate (1/s) of the water's drag on beads inside, by the share of grains around each; 0 for the others."""
        given, grid, droplet, beads = self.given, self.grid, self.droplet, self.beads
        weights, inside = placed[:2]
        everywhere = grid.spread(weights, np.full(len(beads), beads.volume)) / grid.volumes
        share = np.clip(grid.at(weights, everywhere), 1e-6, LARGEST_SHARE)
        relative = (
            values - of_droplet for values, of_droplet in zip(beads.velocity, droplet.velocity[::-1], strict=True)
        )
        law, properties = SUSPENSION_DRAGS[given.drag], (droplet.water.density, droplet.water.viscosity)
        drag = law(1.0 - share, given.grain_diameter, *properties, np.hypot(*relative))
        return np.asarray(inside * drag / share / given.bead_density)

    def _record(self, by_gas: float, by_beads: float, force: Floats, on_beads: float, inside: int) -> None:
        given, droplet, beads, books = self.given, self.droplet, self.beads, self._books
        gained = self._heat() - books["heat_at_first"]
        moved = books["by_vapour"] + books["by_walls"] - books["carried_off"] - books["to_droplet"]
        vapour = given.density * (self._gas_volume() - books["gas_at_first"]) + books["left"] - books["made"]
        floor = (self.gas.pressure[0] * self.grid.parts[1]).sum() * given.depth
        self.rows.append({
            "time": self.time,
            "depth": self.depth,
            "speed": -float(droplet.velocity[1]),
            "across": float(droplet.place[0]),
            "water": droplet.mass / self._water_at_first,
            "radius": droplet.radius,
            "heat_by_gas": by_gas,
            "heat_by_beads": by_beads,
            "evaporation": self.evaporation,
            "force_by_gas": float(force[1]),
            "force_by_beads": float(beads.on_water[1]),
            "weight": droplet.mass * GRAVITY,
            "beads_inside": float(inside),
            "bead_temperature": float(beads.temperature.mean()),
            "highest_bead": float(beads.places[:, 1].max()),
            "force_on_floor": float(floor),
            "force_on_beads": on_beads,
            "heat_imbalance": (gained - moved) / max(abs(books["to_droplet"]), 1e-30),
            "vapour_imbalance": vapour / max(books["made"], 1e-30),
        })  # fmt: skip

    def _heat(self) -> float:
        """Of gas and grains above the initial temperature, J."""
        given, gas, start = self.given, self.gas, self.given.initial_temperature
        in_gas = given.density * given.heat_capacity * (self.grid.volumes * gas.porosity * (gas.temperature - start))
        beads = self.beads.mass * given.bead_heat_capacity * (self.beads.temperature - start)
        return float(in_gas.sum() + beads.sum())

    def _gas_volume(self) -> float:
        return float((self.grid.volumes * self.gas.porosity).sum())

    def save(self, path: Path, more: Mapping[str, Floats]) -> None:
        """Write a checkpoint, with `more` arrays, from which a column of the same input goes on to the same numbers."""
        droplet = self.droplet
        state = {
            "time": np.array(self.time),
            "numbers": np.array([self.time, self.surface, self.evaporation, self._water_at_first]),
            "droplet": np.array([*droplet.place, *droplet.velocity, droplet.mass, droplet.radius]),
            "books": np.array(list(self._books.values())),
            "fill": np.array(self.beads.fill),
            "rows": np.array([list(row.values()) for row in self.rows]),
            "row_names": np.array(list(self.rows[0])),
        }
        with output_file(path) as temporary, temporary.open("wb") as file:
            np.savez(file, **state, **self.beads.save(), **self.gas.save(), **more)

    def free(self) -> None:
        """Nothing of PETSc's is held."""


EMPTY = LocalBed(
    porosity=1.0, wall_distance=1.0, bead_diameter=1.0, density=1.0, viscosity=1.0, heat_capacity=1.0, speed=0.0,
    eddy_viscosity=0.0, fluid_conductivity=1.0, bead_conductivity=1.0, bulk_porosity=0.4, core_speed=0.0, temperature=300.0,
)  # fmt: skip
"""For `stagnant_conductivity`, which knows both conductivities and a porosity."""
