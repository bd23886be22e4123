"""The motion of a sheared cell: beads placed, grown, sheared until their motion is steady, and measured block by block."""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Booleans, Floats, Integers
from ..errors import InputError, SolveError
from ..files.atomic_files import output_file
from ..packing import dynamics
from .cell import ROUGH, ShearCell
from .evaluation import Sheared, evaluate
from .heat import Heat, cases_of, shear

START_SOLID_FRACTION = 0.30
GROWTH_STRAINS, WARM_UP_STRAINS = 3.0, 10.0
BLOCKS = 10
HEAT_INTERVAL = 8
"""Steps of the motion between two exchanges of heat: half of a collision."""
LARGEST_GROWTH = 0.02
"""Of a radius between two Verlet lists, over the overlap at which a spring holds the kinetic energy of a sheared bead."""
STATE = ("body", "size", "name", "wall_spring", "temperature", "pictured")
VERLET = ("start", "partner", "dashpot", "spring")
"""What a checkpoint holds besides the blocks."""


class Shearing:
    """The motion of a `ShearCell` from its random start to the end of its blocks; goes on from `checkpoint` if there is one.

    A checkpoint is written after the warm-up and after every block, and leads to the same numbers as a run in one go.
    """

    def __init__(self, cell: ShearCell, checkpoint: Path | None = None, *, pictures: int = 0) -> None:
        self.cell, self._checkpoint, self._pictures = cell, checkpoint, pictures
        self._material = dynamics.material_of(cell.stiffness, cell.restitution, cell.friction, ratio=1.0)
        self.dt = dynamics.contact_time(cell.stiffness, cell.restitution) / cell.steps_per_contact
        self._cases = cases_of(cell.peclet, cell.biot)
        self._bins = round(cell.distance)
        planes, speed = _planes(cell), 0.5 * cell.distance
        velocity = np.array([[-speed, 0.0, 0.0], [speed, 0.0, 0.0], [0.0, 0.0, 0.0]])
        self._walls = (planes, 0.0, np.array([cell.width, cell.width]), velocity)
        self._blocks: list[dict[str, Any]] = []
        self._warm = False
        self._verlet: tuple[Integers, Integers, Floats, Floats]
        self._pictured = np.zeros((0, 0, 3))
        if checkpoint is not None and checkpoint.is_file():
            self._read(checkpoint)
        else:
            self._start()

    def integrate(self, progress: Callable[[float, float, str], None] | None = None) -> Sheared:
        """Shear to the end; progress(strains done, strains in all, what). Raises `SolveError` if beads fly apart."""
        report = progress or (lambda done, total, text: None)
        warm, span = GROWTH_STRAINS + WARM_UP_STRAINS, self.cell.strains / BLOCKS
        total = warm + self.cell.strains
        if not self._warm:
            self._grow(partial(_report, report, 0.0, total, "beads grow"))
            self._advance(WARM_UP_STRAINS, None, partial(_report, report, GROWTH_STRAINS, total, "warm-up"))
            self._temperature = self._first_temperatures()
            self._warm = True
            self._write()
        while len(self._blocks) < BLOCKS:
            number = len(self._blocks)
            before, text = warm + number * span, f"block {number + 1} of {BLOCKS}"
            self._blocks.append(self._block(span, partial(_report, report, before, total, text)))
            self._write()
        beads = int((self._size[:, 1] < dynamics.FIXED).sum())
        return evaluate(self.cell, self._blocks, beads, round(total / self.dt), self._pictured)

    def _start(self) -> None:
        """Beads of the walls, and the others placed at random."""
        cell, rng = self.cell, np.random.default_rng(self.cell.seed)
        fixed, free, self._small = _placed(cell, rng, self._walls[2])
        number = len(free)
        self._body = np.zeros((len(fixed) + number, 9))
        self._body[:, :3] = np.concatenate([fixed, free])
        self._body[:, 3] = self._body[:, 2] - 0.5 * cell.distance
        self._body[len(fixed) :, 3:6] += 0.1 * rng.standard_normal((number, 3))
        self._size = np.column_stack((np.full(len(self._body), self._small), np.ones(len(self._body))))
        self._size[: len(fixed)] = 0.5, dynamics.FIXED
        count = len(self._body)
        self._name = np.arange(count)
        self._wall_spring = np.zeros((count, 3, 3))
        self._verlet = dynamics.no_pairs(count)
        self._temperature = np.zeros((count, 0))

    def _grow(self, report: Callable[[float], None]) -> None:
        free = self._size[:, 1] < dynamics.FIXED
        rate, done = (0.5 - self._small) / GROWTH_STRAINS, 0.0
        # an overlap of gamma* d has the elastic energy of a bead that moves with gamma d
        longest = LARGEST_GROWTH * self.cell.shear_rate / max(rate, 1e-12)
        while done < GROWTH_STRAINS:
            span = min(longest, GROWTH_STRAINS - done)
            self._advance(span, None)
            done += span
            free = self._size[:, 1] < dynamics.FIXED
            self._size[free, 0] = self._small + rate * done
            report(done)
        self._size[free, 0] = 0.5

    def _first_temperatures(self) -> Floats:
        """The straight line between the walls, by bead; walls have their own."""
        straight = np.empty(len(self._name))
        straight[self._name] = np.clip(self._body[:, 2] / self.cell.distance - 0.5, -0.5, 0.5)
        return np.repeat(straight[:, None], len(self._cases), axis=1)

    def _advance(self, span: float, sums: dict[str, Any] | None, report: Callable[[float], None] | None = None) -> None:
        """Shear over `span`, with heat and sums where these are given."""
        done, cell, count = 0, self.cell, len(self._name)
        steps = max(1, round(span / self.dt))
        load = np.zeros((count, 6))
        while done < steps:
            fastest = math.sqrt((self._body[:, 3:6] ** 2).sum(axis=1).max())
            if not fastest < 1e3 * cell.distance:
                raise SolveError("shear", 0.0, f"a bead moves at {fastest:.1e} gamma d", "more --steps-per-contact")
            skin = min(max(0.05, 60.0 * self.dt * fastest), 0.3)
            self._verlet = dynamics.renew_pairs(
                self._body,
                self._size,
                self._name,
                self._wall_spring,
                self._verlet,
                skin,
                self._walls[2],
                self._material[1],
            )
            beads = dynamics.Beads(self._body, load, self._size, self._wall_spring)
            forces, ahead = (
                (self._verlet, self._walls, self._material),
                dynamics.Span(self.dt, steps - done, 0.5 * skin),
            )
            if sums is None:
                some, _ = dynamics.advance(beads, *forces, np.zeros(3), ahead)
            else:
                of_cell = self._name, self._temperature, self._cases, cell.distance
                heat = Heat(*of_cell, sums["fluxes"], sums["into_beads"])
                some = shear(beads, *forces, ahead, HEAT_INTERVAL, sums["stress"], heat)
                self._sample(sums["profile"], some)
                if "pictured" in sums and len(sums["pictured"]) <= self._pictures * done / steps:
                    sums["pictured"].append(self._picture())
            done += some
            if report is not None:
                report(done * self.dt)

    def _block(self, span: float, report: Callable[[float], None]) -> dict[str, Any]:
        """Sums over one block, per strain."""
        cases = len(self._cases)
        sums: dict[str, Any] = {
            "stress": np.zeros(dynamics.STRESSES),
            "fluxes": np.zeros((self._bins, cases, 2)),
            "into_beads": np.zeros((cases, 3)),
            "profile": np.zeros((self._bins, 3 + cases)),
        }
        if self._pictures and len(self._blocks) == BLOCKS - 1:
            sums["pictured"] = []
        start, stored = self._heights(), self._moment()
        self._advance(span, sums, report)
        span = max(1, round(span / self.dt)) * self.dt
        end = self._heights()
        core = self._free_by_name() & (np.abs(start - 0.5 * self.cell.distance) < 0.25 * self.cell.distance)
        if "pictured" in sums:
            self._pictured = np.array(sums.pop("pictured"))
        return {
            "stress": sums["stress"] * self.dt / span,
            "fluxes": sums["fluxes"] / span,
            "into_beads": sums["into_beads"] / span,
            "profile": sums["profile"],
            "diffusion": np.array(((end - start)[core] ** 2).mean() / (2.0 * span)),
            "moment": (self._moment() - stored) / span,
        }

    def _sample(self, profile: Floats, weight: int) -> None:
        free = self._size[:, 1] < dynamics.FIXED
        z = self._body[:, 2]
        place = np.clip((z / self.cell.distance * self._bins).astype(int), 0, self._bins - 1)[free]
        profile[:, 0] += weight * np.bincount(place, minlength=self._bins)
        columns = [self._body[free, 3], z[free], *self._temperature[self._name[free]].T]
        for column, values in enumerate(columns, start=1):
            profile[:, column] += weight * np.bincount(place, values, minlength=self._bins)

    def _heights(self) -> Floats:
        """z by bead."""
        heights = np.empty(len(self._name))
        heights[self._name] = self._body[:, 2]
        return heights

    def _free_by_name(self) -> Booleans:
        free = np.empty(len(self._name), bool)
        free[self._name] = self._size[:, 1] < dynamics.FIXED
        return free

    def _moment(self) -> Floats:
        """Stored heat times its distance from the middle, of every case."""
        free = self._free_by_name()
        lever = self._heights()[free] - 0.5 * self.cell.distance
        return np.asarray(self._cases[:, 0] * (lever @ self._temperature[free]))

    def _picture(self) -> NDArray[np.float32]:
        """x, z and the first temperature of the beads in front."""
        rows = np.zeros((len(self._name), 3), np.float32)
        front = self._body[:, 1] < -0.5 * self.cell.width + 1.0
        values = np.column_stack((self._body[:, 0], self._body[:, 2], self._temperature[self._name, 0]))
        rows[:] = np.where(front[:, None], values, np.nan)
        return rows

    def _write(self) -> None:
        if self._checkpoint is None:
            return
        state = {name: getattr(self, f"_{name}") for name in STATE}
        state |= dict(zip(VERLET, self._verlet, strict=True))
        state["blocks"] = np.array(len(self._blocks))
        for number, block in enumerate(self._blocks):
            state |= {f"{number}_{key}": value for key, value in block.items()}
        with output_file(self._checkpoint) as temporary, temporary.open("wb") as file:
            np.savez(file, **state)

    def _read(self, path: Path) -> None:
        with np.load(path) as state:
            for name in STATE:
                setattr(self, f"_{name}", state[name])
            start, partner, dashpot, spring = (state[name] for name in VERLET)
            self._verlet, self._warm = (start, partner, dashpot, spring), True
            keys = ("stress", "fluxes", "into_beads", "profile", "diffusion", "moment")
            self._blocks = [{key: state[f"{number}_{key}"] for key in keys} for number in range(int(state["blocks"]))]


def _placed(cell: ShearCell, rng: np.random.Generator, period: Floats) -> tuple[Floats, Floats, float]:
    """Middles of the beads of the walls and of the others, which do not touch, and the radius of these, which are to grow."""
    half = 0.5 * cell.width
    fixed = np.zeros((0, 3))
    if cell.walls == ROUGH:
        for z in (0.0, cell.distance):
            layer = np.empty((int(2.0 * cell.width**2), 3))
            low, high = np.array([-half, -half, z - 0.5]), np.array([half, half, z + 0.5])
            placed = dynamics.place(rng, layer, np.full(len(layer), 0.5), low, high, 0.0, period, 100_000)
            fixed = np.concatenate([fixed, layer[:placed]])
    number = round(cell.solid_fraction * cell.volume / (math.pi / 6.0) - 0.5 * len(fixed))
    small = 0.5 * (START_SOLID_FRACTION / max(cell.solid_fraction, START_SOLID_FRACTION)) ** (1.0 / 3.0)
    free, margin = np.empty((number, 3)), 0.5 if cell.walls == ROUGH else 0.0
    low, high = np.array([-half, -half, margin]), np.array([half, half, cell.distance - margin])
    if dynamics.place(rng, free, np.full(number, small), low, high, 0.0, period, 200_000) < number:
        raise InputError("--solid-fraction", cell.solid_fraction, "leaves the beads no place to start from")
    return fixed, free, small


def _report(report: Callable[[float, float, str], None], before: float, total: float, text: str, done: float) -> None:
    report(before + done, total, text)


def _planes(cell: ShearCell) -> Floats:
    """Of the walls; behind rough ones they only keep beads from coming through."""
    behind = 0.5 if cell.walls == ROUGH else 0.0
    return np.array([[0.0, 0.0, 1.0, behind], [0.0, 0.0, -1.0, cell.distance + behind]])
