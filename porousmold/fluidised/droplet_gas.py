r"""The gas around a droplet in a bed: pressure, velocity, temperature and share of vapour, by finite volumes around the nodes of
a `ColumnGrid`, with velocities at the faces between them.

Grains of 55 um in a gas that moves at centimetres a second: Re_d is below 1, and the convection of momentum is left out. With the
share a of beads that move freely, the share a_d of the droplet, phi = 1 - a - a_d, and the beads' velocity v* and the droplet's
U* as the pressure p will change them within the step (Henry et al., eq. A.20),

    phi rho du/dt = -phi grad p - beta (u - v*) - B (u - U)
    div(phi u + a v* + a_d U*) = s/rho
    v* = (1 - theta) v + theta u - (a/r) grad p,    r = a rho_s/dt + beta,    theta = beta/r
    U* = U - (dt/rho_w) grad p

v and U are what weight and contacts alone would make of both, B holds the gas within the circle at the droplet's velocity. Heat
and vapour are carried by the flux phi u, upwind and implicit; a Laplace equation first corrects it to what the porosity's change
leaves, so that mass and heat are conserved to rounding.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import solve_banded, solveh_banded

from ..arrays import Floats
from .column_grid import ColumnGrid, both_sides
from .droplet_input import DropletInput

STATE = ("pressure", "temperature", "vapour", "porosity", "up", "across")
"""Names of the arrays that the gas goes on from."""


@dataclass
class Surroundings:
    """What the gas flows around, at the nodes: shares of the volume of beads and droplet, velocity (m/s) of beads that weight and
    contacts alone would give, upwards and across, their drag beta (kg/m3/s), theta, and r (kg/m3/s), and of the droplet its
    velocity (m/s), a_d dt/rho_w (m3 s/kg) and the resistance B (kg/m3/s)."""

    beads: Floats
    droplet: Floats
    bead_velocity: list[Floats]
    drag: Floats
    theta: Floats
    resistance: Floats
    droplet_velocity: list[float]
    droplet_yielding: Floats
    droplet_resistance: Floats


class DropletGas:
    """The gas of a `DropletInput`; fields at the nodes are (up, across), `up` and `across` the velocities at the faces."""

    def __init__(self, given: DropletInput, grid: ColumnGrid) -> None:
        self.given, self._grid = given, grid
        rows, columns = (n + 1 for n in grid.cells)
        self._areas = [
            np.broadcast_to(grid.parts[1] * given.depth, (rows - 1, columns)),
            np.broadcast_to(grid.parts[0][:, None] * given.depth, (rows, columns - 1)),
        ]
        self._over_length = [area / size for area, size in zip(self._areas, grid.sizes, strict=True)]
        self.pressure, self.vapour, self.porosity = np.zeros((3, rows, columns))
        self.temperature = np.full((rows, columns), given.initial_temperature)
        self.up, self.across = np.zeros((rows - 1, columns)), np.zeros((rows, columns - 1))
        self._laplace = self._symmetric(self._over_length)
        self.volume_flow = 0.0

    @property
    def velocity(self) -> list[Floats]:
        """Upwards and across at the nodes, m/s."""
        up, across = np.zeros_like(self.pressure), np.zeros_like(self.pressure)
        up[1:-1], up[0], up[-1] = 0.5 * (self.up[1:] + self.up[:-1]), 0.5 * self.up[0], self.up[-1]
        across[:, 1:-1] = 0.5 * (self.across[:, 1:] + self.across[:, :-1])
        return [up, across]

    def keep(self) -> None:
        """The present state is that of the step before."""
        self._old = self.porosity.copy(), self.temperature.copy(), self.vapour.copy()

    def surround(self, around: Surroundings) -> None:
        """Take what the gas flows around."""
        self.porosity, self._around = 1.0 - around.beads - around.droplet, around

    def flow(self, made: Floats) -> None:
        """Pressure and velocities where a volume `made` (1/s) comes from each volume; the pressure is 0 at the top."""
        around, given = self._around, self.given
        step, share = given.time_step, around.beads
        free = 1.0 - around.theta
        yielding = np.where(share > 0.0, share**2 / around.resistance, 0.0) + around.droplet_yielding
        balance = made * self._grid.volumes
        coefficients, parts = [], []
        for axis, old in enumerate((self.up, self.across)):

            def face(values: Floats, axis: int = axis) -> Floats:
                return _mean(values, axis)

            velocity, droplet = around.bead_velocity[axis], around.droplet_velocity[axis]
            inertia = face(self.porosity) * given.density / step
            held = face(around.droplet_resistance)
            resistance = inertia + face(around.drag * free) + held
            without = (inertia * old + face(around.drag * free * velocity) + held * droplet) / resistance
            carried = face(self.porosity + around.theta * share)
            per_slope = carried / resistance
            flux = carried * without + face(share * free * velocity) + face(around.droplet) * droplet
            balance -= _net(flux * self._areas[axis], axis)
            coefficients.append((carried * per_slope + face(yielding)) * self._over_length[axis])
            parts.append((without, per_slope))
        balance[-1] = 0.0
        self.pressure = self._solved(self._symmetric(coefficients), balance)
        self.up, self.across = (
            without - per_slope * np.diff(self.pressure, axis=axis) / self._grid.sizes[axis]
            for axis, (without, per_slope) in enumerate(parts)
        )

    def transport(
        self,
        made: Floats,
        conductivity: list[Floats],
        heat: tuple[Floats, Floats],
        diffusivity: list[Floats],
        vapour: tuple[Floats, Floats],
    ) -> float:
        """Temperature and share of vapour over a step; gives the heat (W, above 0 K) that leaves at the top.

        made: volume of vapour from each volume (1/s); conductivity and diffusivity: at the faces across each axis (W/m/K, m2/s);
        heat: conductance (W/m3/K) to what is in each volume, and what that gives at 0 K (W/m3); vapour: the same of the share,
        1/s.
        """
        given, volumes, (old_porosity, old_temperature, old_vapour) = self.given, self._grid.volumes, self._old
        step = given.time_step
        fluxes = [
            _mean(self.porosity, axis) * velocity * area
            for axis, (velocity, area) in enumerate(zip((self.up, self.across), self._areas, strict=True))
        ]
        left = made * volumes - (self.porosity - old_porosity) / step * volumes
        missing = left - sum(_net(flux, axis) for axis, flux in enumerate(fluxes))
        missing[-1] = 0.0
        potential = self._solved(self._laplace, missing)
        fluxes = [flux - np.diff(potential, axis=axis) * self._over_length[axis] for axis, flux in enumerate(fluxes)]
        out = np.zeros_like(made)
        out[-1] = (left - sum(_net(flux, axis) for axis, flux in enumerate(fluxes)))[-1]
        self.volume_flow = float(out.sum())
        capacity = given.density * given.heat_capacity
        conducting, spreading = (
            [of_face * per_length for of_face, per_length in zip(faces, self._over_length, strict=True)]
            for faces in (conductivity, diffusivity)
        )
        stored = self.porosity * volumes / step
        was = old_porosity * volumes / step
        self.temperature = self._carried(
            capacity * stored + heat[0] * volumes,
            capacity * was * old_temperature + heat[1] * volumes,
            [capacity * flux for flux in fluxes],
            capacity * out,
            conducting,
        )
        self.vapour = self._carried(
            stored + vapour[0] * volumes, was * old_vapour + vapour[1] * volumes, fluxes, out, spreading
        )
        return capacity * float((out * self.temperature).sum())

    def _symmetric(self, coefficients: list[Floats]) -> Floats:
        """Lower bands of the sum over the faces of c (p_a - p_b), with p = 0 in the top row."""
        up, across = coefficients
        rows, columns = across.shape[0], up.shape[1]
        diagonal, above, beside = np.zeros((3, rows, columns))
        diagonal[:-1] += up
        diagonal[1:] += up
        diagonal[:, :-1] += across
        diagonal[:, 1:] += across
        above[:-1], beside[:, :-1] = -up, -across
        above[-2], beside[-1], diagonal[-1] = 0.0, 0.0, diagonal[:-1].mean()
        bands = np.zeros((columns + 1, rows * columns))
        bands[0], bands[1], bands[columns] = diagonal.ravel(), beside.ravel(), above.ravel()
        return bands

    def _solved(self, bands: Floats, right: Floats) -> Floats:
        return np.asarray(solveh_banded(bands, right.ravel(), lower=True, check_finite=False)).reshape(right.shape)

    def _carried(
        self, diagonal: Floats, right: Floats, fluxes: list[Floats], out: Floats, conducting: list[Floats]
    ) -> Floats:
        """What fluxes carry upwind and conductances spread; what flows in at the top is like what is there."""
        columns = diagonal.shape[1]
        diagonal = diagonal + out
        bands = np.zeros((2 * columns + 1, diagonal.size))
        for axis, (flux, conductance) in enumerate(zip(fluxes, conducting, strict=True)):
            ahead, back = np.maximum(flux, 0.0) + conductance, -np.minimum(flux, 0.0) + conductance
            upper, lower = np.zeros_like(diagonal), np.zeros_like(diagonal)
            nothing = np.zeros_like(ahead)
            for values, first, second in ((diagonal, ahead, back), (lower, -ahead, nothing), (upper, nothing, -back)):
                one, other = both_sides(values, axis)
                one += first
                other += second
            apart = columns if axis == 0 else 1
            bands[columns - apart] = upper.ravel()
            bands[columns + apart] = lower.ravel()
        bands[columns] = diagonal.ravel()
        solved = solve_banded((columns, columns), bands, right.ravel(), check_finite=False)
        return np.asarray(solved).reshape(right.shape)

    def save(self) -> dict[str, Floats]:
        """Everything that the gas goes on from."""
        return {f"gas_{name}": getattr(self, name) for name in STATE}

    def restore(self, saved: Any) -> None:
        """Go on from what `save` gave."""
        for name in STATE:
            setattr(self, name, saved[f"gas_{name}"])


def _mean(values: Floats, axis: int) -> Floats:
    """At the faces across an axis."""
    one, other = both_sides(values, axis)
    return np.asarray(0.5 * (one + other))


def _net(flux: Floats, axis: int) -> Floats:
    """What leaves each node through its faces across an axis."""
    before, behind = ([(1, 0), (0, 0)], [(0, 1), (0, 0)]) if axis == 0 else ([(0, 0), (1, 0)], [(0, 0), (0, 1)])
    return np.pad(flux, behind) - np.pad(flux, before)
