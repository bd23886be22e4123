r"""A cell of beads sheared between two walls that move against each other (Forgber, Radl 2016; `docs/moving-beads.md`).

The walls lie at z = 0 and z = H and move along x with -gamma H/2 and gamma H/2; x and y are periodic, without gravity. Lengths
are in bead diameters, masses in masses of a bead, time in 1/gamma. The stiffness of the springs follows from the dimensionless
shear rate gamma* = gamma d^(3/2)/sqrt(k/rho) (eq. 14): k = (6/pi)/gamma*^2 in these units. Tangential springs are as stiff as
normal ones (section 2.1 of the paper).

`rough` walls are beads fixed on the planes z = 0 and z = H, as many as find place there at random; half of each counts as part of
the bed. `flat` walls with friction slip: dense beads then move as a block, and the core is not sheared.

Beads are placed at random with smaller radii, grow while they are sheared, and are sheared on until the motion is steady. Then
their temperatures begin on the straight line between the walls, and blocks of strain are measured; the first ones are left out of
the means. Standard errors are those of the mean of the other blocks. A flux counts as steady where both halves of these blocks
agree, and the beads store little heat (its moment about the middle is what tells the mean flux from that through the walls), both
within three standard errors or 5 %. Large Peclet numbers without a film take thousands of strains.

Stirring. Where beads wander across the gradient like molecules, the convective flux is that of a conductivity
c (1 - phi) rho C gamma d^2; c is measured in the middle half of the cell, with the shear rate, the solid fraction and the
temperature gradient there. The self-diffusion coefficient over gamma d^2 is c again, found without any temperature.
"""

import hashlib
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, SolveError
from ..files.atomic_files import whole_file
from ..packing import dynamics
from .heat import cases_of, shear

START_SOLID_FRACTION = 0.30
GROWTH_STRAINS, WARM_UP_STRAINS = 3.0, 10.0
BLOCKS, SKIPPED_BLOCKS = 10, 2
HEAT_INTERVAL = 8
"""Steps of the motion between two exchanges of heat: half of a collision."""
LARGEST_GROWTH = 0.02
"""Of a radius between two Verlet lists, over the overlap at which a spring holds the kinetic energy of a sheared bead."""
SMALLEST_GRADIENT = 0.2
"""Of the mean one: with less in the middle, nothing is measured there."""
LARGEST_DRIFT = 0.05
"""Of a flux that counts as steady, over the flux."""
ROUGH, FLAT = "rough", "flat"
LIMITS: dict[str, tuple[float, float]] = {
    "solid_fraction": (0.3, 0.68),
    "shear_rate": (1e-5, 0.3),
    "friction": (0.0, 2.0),
    "restitution": (0.05, 1.0),
    "distance": (6.0, 100.0),
    "width": (5.0, 100.0),
    "strains": (1.0, 1e5),
    "steps_per_contact": (8, 200),
    "peclet": (1e-3, 1e6),
    "biot": (0.0, 1e4),
}
LARGEST_NUMBER = 1_000_000
STATE = ("body", "size", "name", "wall_spring", "temperature", "pictured")
VERLET = ("start", "partner", "dashpot", "spring")
"""What a checkpoint holds besides the blocks."""


@dataclass(frozen=True)
class ShearCell:
    """What is sheared, without units; `distance` of the walls and `width` of the periodic sides in bead diameters, `strains` that
    are measured, `shear_rate` gamma*. Raises `InputError` for values out of the ranges of `LIMITS`."""

    solid_fraction: float
    shear_rate: float
    friction: float = 0.5
    peclet: tuple[float, ...] = (1.0,)
    biot: tuple[float, ...] = (0.0,)
    walls: str = ROUGH
    restitution: float = 0.9
    distance: float = 15.0
    width: float = 8.0
    strains: float = 100.0
    steps_per_contact: int = 16
    seed: int = 1

    def __post_init__(self) -> None:
        for key, (low, high) in LIMITS.items():
            values = getattr(self, key)
            for value in values if isinstance(values, tuple) else (values,):
                if not low <= value <= high:
                    raise InputError(f"--{key.replace('_', '-')}", value, f"must be >= {low:g} and <= {high:g}")
        if self.walls not in (ROUGH, FLAT):
            raise InputError("--walls", self.walls, f"must be {ROUGH} or {FLAT}")
        if not self.peclet or not self.biot:
            raise InputError("--peclet", str(self.peclet), "give at least one Peclet and one Biot number")
        if self.seed < 0:
            raise InputError("--seed", self.seed, "must be >= 0")
        if self.volume * self.solid_fraction > LARGEST_NUMBER * math.pi / 6.0:
            raise InputError("--width", self.width, f"needs more than {LARGEST_NUMBER} beads")

    @property
    def volume(self) -> float:
        """In bead diameters cubed."""
        return self.width**2 * self.distance

    @property
    def stiffness(self) -> float:
        """Of the springs, in units of the mass of a bead and the shear rate."""
        return 6.0 / math.pi / self.shear_rate**2

    @property
    def pairs(self) -> list[tuple[float, float]]:
        """(Pe, Bi) of every case."""
        return [(peclet, biot) for peclet in self.peclet for biot in self.biot]

    @property
    def identity(self) -> str:
        """A short name of these values."""
        return hashlib.sha256(repr(sorted(asdict(self).items())).encode()).hexdigest()[:16]


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
    height: NDArray[Any]
    solid_fraction: NDArray[Any]
    velocity: NDArray[Any]
    temperature: NDArray[Any]
    conduction: NDArray[Any]
    convection: NDArray[Any]
    wall_flux: NDArray[Any]
    steady: NDArray[Any]
    stirring: NDArray[Any]
    pictured: NDArray[Any]


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
        planes, speed = self._planes(), 0.5 * cell.distance
        velocity = np.array([[-speed, 0.0, 0.0], [speed, 0.0, 0.0], [0.0, 0.0, 0.0]])
        self._walls = (planes, 0.0, np.array([cell.width, cell.width]), velocity)
        self._blocks: list[dict[str, Any]] = []
        self._warm = False
        self._verlet: tuple[NDArray[Any], ...]
        self._pictured = np.zeros((0, 0, 3))
        if checkpoint is not None and checkpoint.is_file():
            self._read(checkpoint)
        else:
            self._start()

    def march(self, progress: Callable[[float, float, str], None] | None = None) -> Sheared:
        """Shear to the end; progress(strains done, strains in all, what). Raises `SolveError` if beads fly apart."""
        report = progress or (lambda done, total, text: None)
        warm, span = GROWTH_STRAINS + WARM_UP_STRAINS, self.cell.strains / BLOCKS
        total = warm + self.cell.strains
        if not self._warm:
            self._grow(partial(self._report, report, 0.0, total, "beads grow"))
            self._advance(WARM_UP_STRAINS, None, partial(self._report, report, GROWTH_STRAINS, total, "warm-up"))
            self._temperature = self._first_temperatures()
            self._warm = True
            self._write()
        while len(self._blocks) < BLOCKS:
            number = len(self._blocks)
            before, text = warm + number * span, f"block {number + 1} of {BLOCKS}"
            self._blocks.append(self._block(span, partial(self._report, report, before, total, text)))
            self._write()
        return self._result()

    @staticmethod
    def _report(
        report: Callable[[float, float, str], None], before: float, total: float, text: str, done: float
    ) -> None:
        report(before + done, total, text)

    def _planes(self) -> NDArray[Any]:
        """Of the walls; behind rough ones they only keep beads from coming through."""
        behind = 0.5 if self.cell.walls == ROUGH else 0.0
        return np.array([[0.0, 0.0, 1.0, behind], [0.0, 0.0, -1.0, self.cell.distance + behind]])

    def _start(self) -> None:
        """Beads of the walls, and the others placed at random."""
        cell, rng = self.cell, np.random.default_rng(self.cell.seed)
        half, period = 0.5 * cell.width, self._walls[2]
        fixed = np.zeros((0, 3))
        if cell.walls == ROUGH:
            for z in (0.0, cell.distance):
                layer = np.empty((int(2.0 * cell.width**2), 3))
                low, high = np.array([-half, -half, z - 0.5]), np.array([half, half, z + 0.5])
                placed = dynamics.place(rng, layer, np.full(len(layer), 0.5), low, high, 0.0, period, 100_000)
                fixed = np.concatenate([fixed, layer[:placed]])
        number = round(cell.solid_fraction * cell.volume / (math.pi / 6.0) - 0.5 * len(fixed))
        self._small = 0.5 * (START_SOLID_FRACTION / max(cell.solid_fraction, START_SOLID_FRACTION)) ** (1.0 / 3.0)
        free, margin = np.empty((number, 3)), 0.5 if cell.walls == ROUGH else 0.0
        low, high = np.array([-half, -half, margin]), np.array([half, half, cell.distance - margin])
        if dynamics.place(rng, free, np.full(number, self._small), low, high, 0.0, period, 200_000) < number:
            raise InputError("--solid-fraction", cell.solid_fraction, "leaves the beads no place to start from")
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

    def _first_temperatures(self) -> NDArray[Any]:
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
            common = (self._body, load, self._size)
            forces = (self._verlet, self._walls, self._wall_spring, self._material)
            if sums is None:
                some, _ = dynamics.advance(*common, *forces, np.zeros(3), self.dt, steps - done, 0.5 * skin)
            else:
                some = shear(*common, self._name, *forces, self.dt, steps - done, 0.5 * skin, HEAT_INTERVAL, sums["stress"],
                             self._temperature, self._cases, cell.distance, sums["fluxes"], sums["into_beads"])  # fmt: skip
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

    def _sample(self, profile: NDArray[Any], weight: int) -> None:
        free = self._size[:, 1] < dynamics.FIXED
        z = self._body[:, 2]
        place = np.clip((z / self.cell.distance * self._bins).astype(int), 0, self._bins - 1)[free]
        profile[:, 0] += weight * np.bincount(place, minlength=self._bins)
        columns = [self._body[free, 3], z[free], *self._temperature[self._name[free]].T]
        for column, values in enumerate(columns, start=1):
            profile[:, column] += weight * np.bincount(place, values, minlength=self._bins)

    def _heights(self) -> NDArray[Any]:
        """z by bead."""
        heights = np.empty(len(self._name))
        heights[self._name] = self._body[:, 2]
        return heights

    def _free_by_name(self) -> NDArray[Any]:
        free = np.empty(len(self._name), bool)
        free[self._name] = self._size[:, 1] < dynamics.FIXED
        return free

    def _moment(self) -> NDArray[Any]:
        """Stored heat times its distance from the middle, of every case."""
        free = self._free_by_name()
        lever = self._heights()[free] - 0.5 * self.cell.distance
        return np.asarray(self._cases[:, 0] * (lever @ self._temperature[free]))

    def _picture(self) -> NDArray[Any]:
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
        with whole_file(self._checkpoint) as temporary, temporary.open("wb") as file:
            np.savez(file, **state)

    def _read(self, path: Path) -> None:
        with np.load(path) as state:
            for name in STATE:
                setattr(self, f"_{name}", state[name])
            self._verlet, self._warm = tuple(state[name] for name in VERLET), True
            keys = ("stress", "fluxes", "into_beads", "profile", "diffusion", "moment")
            self._blocks = [{key: state[f"{number}_{key}"] for key in keys} for number in range(int(state["blocks"]))]

    def _result(self) -> Sheared:
        cell, used = self.cell, self._blocks[SKIPPED_BLOCKS:]
        mean = {key: np.mean([block[key] for block in used], axis=0) for key in used[0]}
        volume, beads = cell.volume, int((self._size[:, 1] < dynamics.FIXED).sum())
        reference = 1.0 / cell.distance  # lambda (T_top - T_bottom)/H
        fluxes = -np.array([block["fluxes"].sum(axis=0) for block in used]) / volume / reference  # (blocks, m, 2)
        error = fluxes.std(axis=0, ddof=1) / math.sqrt(len(used))
        profile = mean["profile"]
        number = np.maximum(profile[:, 0], 1e-12)
        slices = volume / self._bins
        share = profile[:, 0] / profile[:, 0].sum() * beads
        height, velocity, temperature = profile[:, 2] / number, profile[:, 1] / number, profile[:, 3:] / number[:, None]
        solid = share * math.pi / 6.0 / slices
        core = np.abs((np.arange(self._bins) + 0.5) / self._bins - 0.5) < 0.25
        rate = float(np.polyfit(height[core], velocity[core], 1)[0])
        gradient = np.polyfit(height[core], temperature[core], 1)[0]
        diffusion = np.array([block["diffusion"] for block in used])
        in_core = -mean["fluxes"][core, :, 1].sum(axis=0) / (core.sum() * slices)
        fraction = float(solid[core].mean())
        peclet = np.array([pair[0] for pair in cell.pairs])
        with np.errstate(divide="ignore", invalid="ignore"):
            stirring = in_core / (4.0 * peclet * fraction * rate * gradient)
        enough = (np.abs(gradient) > SMALLEST_GRADIENT * reference) & (abs(rate) > SMALLEST_GRADIENT)
        stress = mean["stress"] / volume
        area = cell.width**2
        return Sheared(
            cell=cell,
            beads=beads,
            steps=round((GROWTH_STRAINS + WARM_UP_STRAINS + cell.strains) / self.dt),
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
            wall_flux=0.5 * (mean["into_beads"][:, 1] - mean["into_beads"][:, 0]) / area / reference,
            steady=_steady(fluxes.sum(axis=2), np.array([block["moment"] for block in used]) / volume / reference),
            stirring=np.where(enough, stirring, math.nan),
            pictured=self._pictured,
        )


def _steady(fluxes: NDArray[Any], stored: NDArray[Any]) -> NDArray[Any]:
    """Whether the fluxes of both halves of the blocks (blocks, m) agree, and what is stored is small, for each case."""
    half = len(fluxes) // 2
    early, late = fluxes[:half], fluxes[half:]
    error = np.hypot(early.std(axis=0, ddof=1), late.std(axis=0, ddof=1)) / math.sqrt(half)
    allowed = LARGEST_DRIFT * np.abs(fluxes.mean(axis=0))
    storing = stored.std(axis=0, ddof=1) / math.sqrt(len(stored))
    agree = np.abs(late.mean(axis=0) - early.mean(axis=0)) <= np.maximum(3.0 * error, allowed)
    return np.asarray(agree & (np.abs(stored.mean(axis=0)) <= np.maximum(3.0 * storing, allowed)))
