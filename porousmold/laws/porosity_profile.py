"""Tabulated porosity profiles: CSV files with wall distance over bead diameter, phi_V and phi_A."""

import csv
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Floats
from ..errors import InputError
from ..files.atomic_files import output_file
from ..files.tables import read_rows
from .functions import Value, number_of

HEAD = ("wall_distance_over_bead_diameter", "phi_v", "phi_a")
MORE = ("phi_v_standard_error", "phi_a_standard_error", "samples")


@dataclass(frozen=True)
class PorosityProfile:
    """phi_V and phi_A at points y/d, constant beyond the last.

    Between the points the monotone cubic of Fritsch and Carlson (PCHIP): continuous slope, so that grad phi exists
    everywhere, and no overshoot above 1 or below 0 between measured points.
    """

    positions: Floats
    volume_porosity: Floats
    area_porosity: Floats
    source: str

    @classmethod
    def read(cls, key: str, path: str | Path) -> "PorosityProfile":
        """From a CSV file whose head begins with `HEAD` (later columns, and lines that start with #, are ignored).

        Raises `InputError` for a file that is unreadable, has another head, positions that do not increase from 0,
        porosities outside (0, 1], or a gap that no bead reaches into.
        """
        path = Path(path)
        rows = read_rows(key, path)
        if not rows or tuple(name.strip().lower() for name in rows[0][:3]) != HEAD:
            raise InputError(key, str(path), f"must begin with the head {','.join(HEAD)}")
        try:
            table = np.array([[float(cell) for cell in row[:3]] for row in rows[1:]])
        except ValueError as error:
            raise InputError(key, str(path), f"holds a cell that is no number: {error}") from error
        if table.ndim != 2 or table.shape[0] < 2 or table.shape[1] != 3:
            raise InputError(key, str(path), "must have at least two rows of three columns")
        position, porosities = table[:, 0], table[:, 1:]
        if not np.all(np.isfinite(position)):
            raise InputError(key, str(path), "must have finite wall distances")
        if position[0] != 0.0 or np.any(np.diff(position) <= 0.0):
            raise InputError(key, str(path), "must have wall distances that increase from 0")
        if not np.all((porosities > 0.0) & (porosities <= 1.0)):
            raise InputError(key, str(path), "must have porosities within (0, 1]")
        if porosities[-1, 0] >= 1.0:
            raise InputError(key, str(path), "must end in a bed: phi_v < 1 in the last row")
        if np.any(gap := (porosities[1:, 0] >= 1.0) & (porosities[:-1, 0] >= 1.0)):
            first = int(np.argmax(gap))
            allowed = (
                f"has phi_v = 1 from {position[first]:g} to {position[first + 1]:g} bead diameters: where no bead reaches into "
                "there is none to have a temperature; 0.999 leaves next to none"
            )
            raise InputError(key, str(path), allowed)
        return cls(position, porosities[:, 0], porosities[:, 1], str(path))

    def volume(self, wall_distance: Value, bead_diameter: Value) -> Value:
        """phi_V (array) at wall distances (m)."""
        return self._interpolated(self.volume_porosity, wall_distance, bead_diameter)

    def area(self, wall_distance: Value, bead_diameter: Value) -> Value:
        """phi_A (array) at wall distances (m)."""
        return self._interpolated(self.area_porosity, wall_distance, bead_diameter)

    def _interpolated(self, values: Floats, wall_distance: Value, bead_diameter: float) -> Value:
        place = np.clip(np.asarray(wall_distance) / bead_diameter, 0.0, self.positions[-1])
        from scipy.interpolate import PchipInterpolator  # a tenth of a second, which laws do without

        return PchipInterpolator(self.positions, values)(place)

    def over(
        self,
        wall_distance: Value,
        bead_diameter: Value,
        constant: Callable[[float], Value],
        at_nodes: Callable[[Callable[[Value], Value]], Value],
    ) -> Value:
        """phi_V at the nodes: a table is no expression."""
        diameter = number_of(bead_diameter)
        return at_nodes(lambda distance: self.volume(distance, diameter))

    @property
    def bulk_porosity(self) -> float:
        """phi_V at the last point."""
        return float(self.volume_porosity[-1])


def write_profile(
    path: Path,
    profile: Any,
    comments: Sequence[str] = (),
    phi_v: Callable[[Any], Any] | None = None,
    phi_a: Callable[[Any], Any] | None = None,
) -> None:
    """A `MeasuredProfile` as a CSV file that scenes read; phi_v, phi_a (functions of position) in place of what it measured.

    A fit has no standard errors: with it the file has the first three columns. `InputError` if it cannot be written.
    """
    columns, head = [profile.position], list(HEAD)
    if phi_v is None or phi_a is None:
        columns += [profile.phi_v, profile.phi_a, profile.phi_v_error, profile.phi_a_error, profile.samples]
        head += MORE
    else:
        columns += [phi_v(profile.position), phi_a(profile.position)]
    with output_file(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        file.writelines(f"# {line}\n" for line in comments)
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(head)
        writer.writerows([f"{cell:.6g}" for cell in row] for row in zip(*columns, strict=True))
