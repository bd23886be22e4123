r"""A column of beads that a gas flows through and may lift: beads one by one (DEM), the gas averaged over the space between them.

The column is a slab: between two walls across x[1], periodic in depth, with the gas from below along x[0]. The gas is
two-dimensional, on quadrilaterals of some bead diameters; the beads are spheres in three dimensions. Every bead gives its volume,
velocity and heat to the four nodes around it by their hat functions, and takes the values of the gas by the same.

A step: porosity and drag (one of `laws.fluidisation.SUSPENSION_DRAGS`) at the nodes; velocity and pressure of the gas by Newton's
method, implicit in the drag of both sides (`equations.suspended_beads`); its temperature; then the beads, in
`column_beads.CHUNKS` parts,

    dv/dt = beta/(a rho_s) (u - v) - grad p/rho_s + g (1 - rho/rho_s),    implicit in v,

each followed by steps of their contacts (`packing.dynamics`). A bead takes up K (T - T_i) over the step with
K = M C (1 - exp(-h A dt/(M C)))/dt, so that it never overshoots, h by one of `laws.nusselt.NUSSELT_CORRELATIONS`.
Of beads of several sizes drag and h are those of their Sauter diameter. Walls take h_w (T - T_w) per area at the sides, and
lambda (T - T_w) per volume in front and rear, from the gas, whose properties are constant.
The gas predicts the beads' motion with what weight and contacts did to them in the step before (Henry et al., eq. A.20), and so
knows what holds a bed at rest.
"""

import math
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from ..arrays import Floats
from ..errors import SolveError
from ..files.atomic_files import output_file
from ..laws.fluidisation import SUSPENSION_DRAGS
from .column_beads import ColumnBeads, bed_at_rest
from .column_gas import ColumnGas
from .column_grid import ColumnGrid, Weights
from .column_input import ColumnInput

SMALLEST_CHANGE = 1e-3
"""K of all beads, whose heat is the least that an imbalance is a part of."""
LARGEST_SHARE = 0.72
"""Of the beads at a node: denser than that no packing is."""


class Column:
    """The state of a `ColumnInput`; `step()` advances it by its `time_step` (s), `rows` has what is recorded of every step."""

    def __init__(self, given: ColumnInput, positions: Floats | None = None, diameters: Floats | None = None) -> None:
        self.given, self.time = given, 0.0
        self.rows: list[dict[str, float]] = []
        self.beads = bed_at_rest(given) if positions is None else ColumnBeads(given, positions, diameters)
        self.grid = ColumnGrid(given)
        self.gas = ColumnGas(given, self.grid, self.weight)
        self.heat_given = self.heat_carried_off = self.heat_to_walls = 0.0
        self._to_walls = np.full(self.grid.volumes.shape, given.depth_coefficient)
        self._to_walls[:, [0, -1]] += 2.0 * given.wall_coefficient / self.grid.sizes[1]
        self._deposit()
        self._heat_at_first = self._stored_heat()

    @classmethod
    def restored(cls, given: ColumnInput, saved: Mapping[str, Floats]) -> "Column":
        """The column that `save` wrote a checkpoint of."""
        column = cls(given, given.bead_diameter * saved["body"][:, :3], 2.0 * saved["size"][:, 0])
        column.time = float(saved["time"])
        column._heat_at_first, column.heat_given, column.heat_carried_off, column.heat_to_walls = map(
            float, saved["heats"]
        )
        names = [str(name) for name in saved["row_names"]]
        column.rows = [dict(zip(names, map(float, row), strict=True)) for row in saved["rows"]]
        column.beads.restore(saved)
        column.gas.restore(saved)
        return column

    @property
    def weight(self) -> float:
        """Of the beads less buoyancy, over the cross-section, Pa."""
        given, mass = self.given, math.fsum(self.beads.masses)  # the same in whatever order they are
        return -mass * self.beads.gravity / (given.width * given.depth)

    def integrate(self, end_time: float, progress: Callable[[float, float, str], None] | None = None) -> None:
        """Step until `end_time` (s); progress(time, end time, text)."""
        while self.time < end_time - 0.5 * self.given.time_step:
            self.step()
            if progress is not None:
                progress(self.time, end_time, f"beads {self.rows[-1]['bead_temperature'] - 273.15:.1f} °C")

    def step(self) -> None:
        """One step. Raises `SolveError` where the gas finds no solution, or a bead leaves the column."""
        given, grid = self.given, self.grid
        self.gas.keep()
        weights, share, slip, drag = self._deposit()
        self.gas.flow(self.time)
        self._heat_up(weights, slip)
        gas = [grid.at(weights, values) for values in self.gas.velocity]
        pressure = self.gas.pressure
        push = [-slope / given.bead_density for slope in grid.gradient(weights, pressure)]
        rate = grid.at(weights, drag / np.maximum(share, 1e-9) / given.bead_density)
        force = (self.beads.masses * (push[0] + rate * (gas[0] - self.beads.velocity[0]))).sum() / (
            given.width * given.depth
        )
        self.beads.move(gas, push, rate)
        self.time += given.time_step
        gained = self._stored_heat() - self._heat_at_first
        moved = self.heat_given - self.heat_carried_off - self.heat_to_walls
        least = SMALLEST_CHANGE * given.bead_heat_capacity * float(self.beads.masses.sum())
        exchanged = max(abs(self.heat_given), abs(self.heat_to_walls), least)
        up = self.beads.places[:, 1]
        self.rows.append({
            "time": self.time,
            "pressure_drop": float(pressure[0].mean() - pressure[-1].mean()),
            "force_on_beads": float(force),
            "bed_height": float(2.0 * up.mean()),
            "highest_bead": float(up.max()),
            "fastest_bead": self.beads.fastest,
            "bead_temperature": float(self.beads.temperature.mean()),
            "outlet_temperature": float(self.gas.temperature[-1].mean()),
            "heat_to_walls": self.heat_to_walls,
            "heat_imbalance": float((gained - moved) / exchanged),
        })  # fmt: skip
        if self.rows[-1]["highest_bead"] > given.height:
            raise SolveError("fluidise", self.time, "a bead leaves the column", "a higher one (--height), or less gas")

    def _deposit(self) -> tuple[Weights, Floats, Floats, Floats]:
        """Put the beads into the gas; gives their weights, and share, relative speed and drag at the nodes."""
        given, d, grid = self.given, self.beads.sauter_diameter, self.grid
        weights, volume = grid.weights(self.beads.places), self.beads.volumes
        share = np.minimum(grid.spread(weights, volume) / grid.volumes, LARGEST_SHARE)
        safe = np.maximum(share, 1e-9)
        beads, pushed = (
            [grid.spread(weights, volume * values) / grid.volumes / safe for values in of_beads]
            for of_beads in (self.beads.velocity, self.beads.acceleration)
        )
        gas = self.gas.velocity
        slip = np.hypot(gas[0] - beads[0], gas[1] - beads[1])
        drag = SUSPENSION_DRAGS[given.drag](1.0 - share, d, given.density, given.viscosity, slip)
        resistance = np.maximum(share * given.bead_density / given.time_step + drag, 1e-30)
        beads = [velocity + given.time_step * more for velocity, more in zip(beads, pushed, strict=True)]
        self.gas.surround(share, beads, drag, drag / resistance, np.where(share > 0.0, share**2 / resistance, 0.0))
        return weights, share, slip, drag

    def _heat_up(self, weights: Weights, slip: Floats) -> None:
        """Temperatures of gas and beads over a step."""
        given, grid, beads = self.given, self.grid, self.beads
        porosity, step = self.gas.porosity, self.given.time_step
        film = given.film_coefficient(beads.sauter_diameter, porosity * given.density * slip, porosity)
        capacity = given.bead_heat_capacity * beads.masses
        conductance = -capacity / step * np.expm1(-grid.at(weights, film) * beads.surfaces * step / capacity)
        exchange = grid.spread(weights, conductance) / grid.volumes
        heating = grid.spread(weights, conductance * self.beads.temperature) / grid.volumes
        leaving = self.gas.heat_up(exchange + self._to_walls, heating + self._to_walls * given.wall_temperature)
        warmer = self.gas.temperature - given.wall_temperature
        self.heat_to_walls += float((grid.volumes * self._to_walls * warmer).sum()) * step
        warm = grid.at(weights, self.gas.temperature)
        self.beads.temperature += conductance * (warm - self.beads.temperature) * step / capacity
        flow = given.density * given.heat_capacity * self.gas.volume_flow
        self.heat_given += flow * (given.inlet_temperature - given.initial_temperature) * step
        self.heat_carried_off += (leaving - flow * given.initial_temperature) * step

    def _stored_heat(self) -> float:
        """Of beads and gas, above the initial temperature, J."""
        given, start = self.given, self.given.initial_temperature
        gas = self.gas.porosity * (self.gas.temperature - start)
        in_gas = given.density * given.heat_capacity * (self.grid.volumes * gas).sum()
        in_beads = given.bead_heat_capacity * (self.beads.masses * (self.beads.temperature - start)).sum()
        return float(in_gas + in_beads)

    def save(self, path: Path, more: Mapping[str, Floats]) -> None:
        """Write a checkpoint, with `more` arrays, from which a column of the same input goes on to the same numbers."""
        heats = [self._heat_at_first, self.heat_given, self.heat_carried_off, self.heat_to_walls]
        rows = np.array([list(row.values()) for row in self.rows])
        names = np.array(list(self.rows[0]))
        state = {"time": np.array(self.time), "heats": np.array(heats), "rows": rows, "row_names": names}
        with output_file(path) as temporary, temporary.open("wb") as file:
            np.savez(file, **state, **self.beads.save(), **self.gas.save(), **more)

    def free(self) -> None:
        """Free what PETSc holds."""
        self.gas.free()
