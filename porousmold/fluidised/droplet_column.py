r"""A droplet of water on, and in, a hot bed of grains (Henry et al., section 4): its vapour may lift them and dig it in.

Grains are drawn together into parcels (`droplet_beads`) on the grid of `column_grid`; the gas is `droplet_gas`, the droplet
`droplet`. A step: porosity, drag and the droplet's circle at the nodes; the vapour that the heat of the step before makes, evenly
around the circle; pressure and velocity of the gas; temperatures of gas and grains, share of vapour, and the heat to the droplet
(`droplet_heat`); then beads and droplet together, in `column_beads.CHUNKS` parts. Grains feel the gas as in `column`, by their
own diameter; inside the circle they feel the water instead. A contact where there is little vapour (a share below `FLUIDISED`)
holds with `bond` grain weights over the grain's area (paper: 7.5e-4 N/m, 10 weights of a disc of 55 um).

Side walls have the bed's initial temperature, no heat passes front and rear, the top is open, gas that comes in there is like
that which is there. What the model leaves out: the droplet's shape, capillarity, radiation, wetting and boiling on the grains.
"""

from collections.abc import Callable, Mapping
from dataclasses import astuple
from pathlib import Path

import numpy as np

from ..arrays import Floats
from ..errors import SolveError
from ..files.atomic_files import output_file
from ..laws.evaporation import LATENT_HEAT
from ..laws.fluidisation import GRAVITY, SUSPENSION_DRAGS
from .column_grid import ColumnGrid
from .droplet import Droplet
from .droplet_beads import DropletBeads
from .droplet_gas import DropletGas, Surroundings
from .droplet_heat import LARGEST_SHARE, DropletHeat, HeatBooks, Placed
from .droplet_input import DropletInput

OF_THE_CIRCLE = 0.9
"""Part of the circle that is closed to the gas in the balance of volume: some porosity is left at each node."""
BLOCKING, FULL = 1e8, 0.95
"""Resistance (kg/m3/s) of nodes that the circle fills so far: the gas there moves with the droplet. With nodes that are filled
less, the thrust of its vapour is 5 to 10 % too large on these cells."""
FLUIDISED = 0.9
"""Share of vapour from which grains do not stick together (the paper's psi_0)."""
HOTTEST_WET = 473.15
"""Temperature (K) from which, with `contact` 'film', vapour keeps grains out: the Leidenfrost point of water lies about there."""
NUMBERS = ("surface", "evaporation", "_water_at_first", "_gas_at_first", "_made", "_left")
"""Of a column, that a checkpoint keeps besides its time."""
GONE = 0.03
"""Part of the water, below which the droplet is taken as evaporated."""


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
        self._place()
        self.gas.keep()
        self.heat = DropletHeat(given, self.grid, self.gas, self.beads, self.droplet)
        self._gas_at_first, self._made, self._left = self._gas_volume(), 0.0, 0.0

    @classmethod
    def restored(cls, given: DropletInput, saved: Mapping[str, Floats]) -> "DropletColumn":
        """The column that `save` wrote a checkpoint of."""
        beads = DropletBeads(given, given.bead_diameter * saved["body"][:, :3], float(saved["fill"]))
        column = cls(given, beads)
        beads.restore(saved)
        column.gas.restore(saved)
        column.time = float(saved["time"])
        for name, number in zip(NUMBERS, map(float, saved["numbers"]), strict=True):
            setattr(column, name, number)
        droplet = column.droplet
        droplet.place, droplet.velocity = saved["droplet"][:2].copy(), saved["droplet"][2:4].copy()
        droplet.mass, droplet.radius = map(float, saved["droplet"][4:])
        column.heat.books = HeatBooks(*map(float, saved["books"]))
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

    def integrate(self, end_time: float, progress: Callable[[float, float, str], None] | None = None) -> None:
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
        by_gas, by_beads = self.heat.exchange(placed, vapour)
        force, on_beads = self._move(placed)
        droplet.mass -= self.evaporation * given.time_step
        self._made += self.evaporation * given.time_step
        self._left += given.density * gas.volume_flow * given.time_step
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
        is_bonded = grid.at(weights, gas.vapour) < FLUIDISED
        beads.bonds = beads.by_name(given.bond * given.grain_diameter / given.bead_diameter * is_bonded)
        beads.repelled = beads.by_name((beads.temperature > HOTTEST_WET) & ~inside & (given.contact == "film"))
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
        given, droplet, beads = self.given, self.droplet, self.beads
        vapour = given.density * (self._gas_volume() - self._gas_at_first) + self._left - self._made
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
            "heat_imbalance": self.heat.imbalance,
            "vapour_imbalance": vapour / max(self._made, 1e-30),
        })  # fmt: skip

    def _gas_volume(self) -> float:
        return float((self.grid.volumes * self.gas.porosity).sum())

    def save(self, path: Path, more: Mapping[str, Floats]) -> None:
        """Write a checkpoint, with `more` arrays, from which a column of the same input goes on to the same numbers."""
        droplet = self.droplet
        state = {
            "time": np.array(self.time),
            "numbers": np.array([getattr(self, name) for name in NUMBERS]),
            "droplet": np.array([*droplet.place, *droplet.velocity, droplet.mass, droplet.radius]),
            "books": np.array(astuple(self.heat.books)),
            "fill": np.array(self.beads.fill),
            "rows": np.array([list(row.values()) for row in self.rows]),
            "row_names": np.array(list(self.rows[0])),
        }
        with output_file(path) as temporary, temporary.open("wb") as file:
            np.savez(file, **state, **self.beads.save(), **self.gas.save(), **more)
