"""What a run starts from: one temperature, a profile along the flow, or the last state of another run."""

import hashlib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import ClassVar

import numpy as np

from ..arrays import Floats, Integers
from ..errors import InputError
from ..files.tables import read_columns, read_toml

PROFILE, STATE = "operation.initial_temperature", "operation.initial_state"
FIELDS = "fields.xdmf"
SAME_PLACE = 1e-9
"""Distance over the extent of a mesh within which a node is the same one."""
INWARDS = 1e-9, 1e-6, 1e-3, 0.01, 0.1, 1.0
"""Parts of the way to the middle of the nearest cell, at which a place is tried that lies beyond all cells."""
SAME_EXTENT = 0.01
"""Part of a mesh's extent by which another one of the same bed may differ."""


@dataclass(frozen=True)
class Profile:
    """Temperatures (K) at distances (m) from the inlet, linear between them and constant beyond; `source` is their file."""

    positions: tuple[float, ...]
    values: tuple[float, ...]
    source: str
    key: ClassVar[str] = PROFILE

    @classmethod
    def read(cls, path: Path) -> "Profile":
        """Of a CSV file `x [m], temperature [degC]`. Raises `InputError`."""
        columns = read_columns(PROFILE, path)
        if len(columns.names) != 2:
            raise InputError(PROFILE, str(path), "must have two columns, such as x [m], temperature [degC]")
        positions, values = columns.in_si(0, "m"), columns.in_si(1, "K")
        if np.any(np.diff(positions) <= 0.0):
            raise InputError(PROFILE, str(path), "must have distances from the inlet that increase")
        if not (inside := (values > 0.0) & (values < 5000.0)).all():
            row = int(np.argmin(inside))
            raise InputError(
                PROFILE, f"{values[row]:g} K", "must be > 0 and < 5000 K", f"{path}, at {positions[row]:g} m"
            )
        return cls(tuple(positions.tolist()), tuple(values.tolist()), str(path))

    def as_value(self) -> str:
        """What a TOML file would have."""
        return self.source

    def mean(self, length: float | None) -> float:
        """Mean temperature (K) of a bed of a `length` (m), of one that only its mesh knows over its own positions."""
        begin, end = (self.positions[0], self.positions[-1]) if length is None else (0.0, length)
        if end <= begin:
            return self.values[0]
        low, high = self._integral(np.array([begin, end]))
        return float((high - low) / (end - begin))

    def require_place(self, length: float) -> None:
        """Raise `InputError` where none of it lies in a bed of a `length` (m)."""
        first, last = self.positions[0], self.positions[-1]
        if last < 0.0 or first > length:
            allowed = f"lies from {first:.4g} to {last:.4g} m, outside the bed, which is {length:.4g} m long"
            raise InputError(PROFILE, self.source, allowed)

    def _integral(self, places: Floats) -> Floats:
        """Of the temperature from the first position to places (K m)."""
        positions, values = np.array(self.positions), np.array(self.values)
        heat = np.append(0.0, np.cumsum(0.5 * np.diff(positions) * (values[1:] + values[:-1])))
        inside = np.clip(places, positions[0], positions[-1])
        piece = np.clip(np.searchsorted(positions, inside, side="right") - 1, 0, max(len(positions) - 2, 0))
        here = np.interp(inside, positions, values)
        found = heat[piece] + 0.5 * (inside - positions[piece]) * (values[piece] + here)
        return np.asarray(found + (places - inside) * here)

    @property
    def range(self) -> tuple[float, float]:
        """Lowest and highest temperature (K)."""
        return min(self.values), max(self.values)

    def digest(self) -> str:
        """Of its content."""
        return hashlib.sha256(repr((self.positions, self.values)).encode()).hexdigest()

    def at(self, places: Floats, spans: Floats, *, of_beads: bool) -> Floats:
        """Temperatures (K) of places; those of fluid, beads and wall are the same.

        `spans` (n, 3) has, in m from where the bed begins, the begin of what a place stands for, the place, and the end. Where
        the profile has a corner among that it is the mean over it: a step between two places keeps its heat.
        """
        positions, values = np.array(self.positions), np.array(self.values)
        low, place, high = spans.T
        means, little = (self._integral(high) - self._integral(low)) / (high - low), 1e-6 * (high - low)
        has_corner = np.searchsorted(positions, high - little) > np.searchsorted(positions, low + little)
        return np.where(has_corner, means, np.interp(place, positions, values))


@dataclass(frozen=True)
class LastState:
    """The temperatures at the end of the run in a folder."""

    folder: Path
    key: ClassVar[str] = STATE

    @classmethod
    def read(cls, folder: Path, where: str | None) -> "LastState":
        """Of a folder. Raises `InputError` where it holds no fields that can be read."""
        if not (folder / FIELDS).is_file():
            allowed = "must be the folder of a run that wrote its fields (fields.xdmf)"
            raise InputError(STATE, str(folder), allowed, where)
        state = cls(folder)
        try:
            state._last  # noqa: B018 - read now, to fail now
        except (OSError, ValueError, LookupError, AttributeError, SyntaxError) as error:
            raise InputError(STATE, str(folder), f"has fields that cannot be read: {error}", where) from error
        return state

    @cached_property
    def _last(self) -> tuple[Floats, Integers, dict[str, Floats]]:
        from ..files.xdmf import read_fields  # h5py takes a tenth of a second, paid by those who start from a run

        nodes, cells, steps = read_fields(self.folder / FIELDS)
        fields = steps[max(steps)]
        return nodes, cells, {name: fields[name] for name in ("temperature", "bead_temperature", "in_bed")}

    def as_value(self) -> str:
        """What a TOML file would have."""
        return str(self.folder)

    def require_kind(self, *, axisymmetric: bool) -> None:
        """Raise `InputError` where the run's bed was about an axis and this one is not, or the other way round."""
        path = self.folder / "scene.toml"
        geometry = read_toml(STATE, path).get("geometry", {}) if path.is_file() else {}
        if not geometry:
            return
        was = geometry.get("kind") in ("pipe", "annulus") or geometry.get("symmetry") == "axisymmetric"
        if was != axisymmetric:
            kinds = ("a plane bed", "a bed about an axis")
            raise InputError(STATE, str(self.folder), f"is of {kinds[was]}, and this one is {kinds[axisymmetric]}")

    @property
    def length(self) -> float:
        """Of the mesh along the flow, m."""
        return float(np.ptp(self._last[0][:, 0]))

    def require_place(self, low: Floats, high: Floats) -> None:
        """Raise `InputError` for a mesh between the corners `low` and `high` (m) that lies where the run's did not.

        Along x[0] it must be as long; across it may be narrower, as without the cells of a wall.
        """
        nodes = self._last[0]
        if nodes.shape[1] != len(low):
            allowed = f"is of a bed in {nodes.shape[1]} dimensions, and this one has {len(low)}"
            raise InputError(STATE, str(self.folder), allowed)
        least, most = nodes.min(axis=0), nodes.max(axis=0)
        slack = SAME_EXTENT * (most - least)
        for axis in range(len(low)):
            beyond = low[axis] < least[axis] - slack[axis] or high[axis] > most[axis] + slack[axis]
            within = low[axis] > least[axis] + slack[axis] or high[axis] < most[axis] - slack[axis]
            if beyond or (axis == 0 and within):
                allowed = (
                    f"is of a run between x[{axis}] = {least[axis]:.4g} and {most[axis]:.4g} m, and this mesh lies between "
                    f"{low[axis]:.4g} and {high[axis]:.4g} m: it has no temperatures there"
                )
                raise InputError(STATE, str(self.folder), allowed)

    def require_bed(self, low: Floats, high: Floats) -> None:
        """Raise `InputError` for a bed between the corners `low` and `high` (m) where the run had a wall or a core, or the other
        way round."""
        nodes, _, fields = self._last
        bed = nodes[fields["in_bed"] > 0.5]
        least, most = bed.min(axis=0), bed.max(axis=0)
        for axis in range(1, len(low)):
            slack = SAME_EXTENT * (most[axis] - least[axis])
            if max(abs(low[axis] - least[axis]), abs(high[axis] - most[axis])) > slack:
                allowed = (
                    f"has its bed between x[{axis}] = {least[axis]:.4g} and {most[axis]:.4g} m, and this one lies between "
                    f"{low[axis]:.4g} and {high[axis]:.4g} m"
                )
                raise InputError(STATE, str(self.folder), allowed)

    def mean(self, length: float | None) -> float:
        """Mean temperature (K) of the fluid in the bed, weighted by the boxes around its cells; `length` is not asked for."""
        nodes, cells, fields = self._last
        in_bed = cells[(fields["in_bed"][cells] > 0.5).all(axis=1)]
        sizes = np.prod(np.ptp(nodes[in_bed], axis=1), axis=1)
        return float(np.average(fields["temperature"][in_bed].mean(axis=1), weights=sizes))

    @property
    def range(self) -> tuple[float, float]:
        """Lowest and highest temperature (K)."""
        *_, fields = self._last
        beads = fields["bead_temperature"][fields["in_bed"] > 0.5]
        values = np.concatenate([fields["temperature"], beads])
        return float(values.min()), float(values.max())

    def digest(self) -> str:
        """Of its content."""
        nodes, _, fields = self._last
        return hashlib.sha256(b"".join(array.tobytes() for array in (nodes, *fields.values()))).hexdigest()

    def at(self, places: Floats, spans: Floats, *, of_beads: bool) -> Floats:
        """Temperatures (K) of fluid and wall, or of beads, at places (n, 3) in m: those of the nodes where there are nodes,
        linear between them elsewhere."""
        from scipy.interpolate import LinearNDInterpolator
        from scipy.spatial import cKDTree

        nodes, cells, fields = self._last
        values, centres = fields["bead_temperature" if of_beads else "temperature"], nodes[cells].mean(axis=1)
        if of_beads:
            kept = fields["in_bed"] > 0.5
            nodes, values, centres = nodes[kept], values[kept], centres[kept[cells].all(axis=1)]
        wanted = places[:, : nodes.shape[1]]
        extent = float(np.ptp(nodes, axis=0).max())
        distances, nearest = cKDTree(nodes).query(wanted)
        found = values[nearest].astype(float)
        elsewhere = distances > SAME_PLACE * extent
        if elsewhere.any():
            sizes = np.maximum(np.ptp(nodes, axis=0), 1e-300)
            between, scaled = LinearNDInterpolator(nodes / sizes, values), wanted[elsewhere] / sizes
            inwards = centres[cKDTree(centres / sizes).query(scaled)[1]] / sizes - scaled
            of_rest = between(scaled)
            for part in INWARDS:  # of those on the rim, that rounding or a curved side puts beyond it
                missing = np.isnan(of_rest)
                of_rest[missing] = between(scaled[missing] + part * inwards[missing])
            found[elsewhere] = np.where(np.isnan(of_rest), found[elsewhere], of_rest)
        return found


Start = Profile | LastState
