"""Tabulated porosity profiles: CSV files with wall distance over bead diameter, phi_V and phi_A."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

from ..errors import InputError
from ..tables import read_rows
from ..whole_files import output_file

HEAD = ("wall_distance_over_bead_diameter", "phi_v", "phi_a")
MORE = ("phi_v_standard_error", "phi_a_standard_error", "samples")


@dataclass(frozen=True)
class PorosityProfile:
    """phi_V and phi_A at points y/d, constant beyond the last.

    Between the points the monotone cubic of Fritsch and Carlson (PCHIP): continuous slope, so that grad phi exists
    everywhere, and no overshoot above 1 or below 0 between measured points.
    """

    positions: np.ndarray
    volume_porosity: np.ndarray
    area_porosity: np.ndarray

    @classmethod
    def read(cls, key, path):
        """From a CSV file whose head begins with `HEAD` (later columns, and lines that start with #, are ignored).

        Raises `InputError` for a file that is unreadable, has another head, positions that do not increase from 0,
        or porosities outside (0, 1].
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
        return cls(position, porosities[:, 0], porosities[:, 1])

    def __call__(self, wall_distance, bead_diameter):
        """phi_V and phi_A (arrays) at wall distances (m)."""
        place = np.clip(np.asarray(wall_distance) / bead_diameter, 0.0, self.positions[-1])
        return tuple(
            PchipInterpolator(self.positions, values)(place) for values in (self.volume_porosity, self.area_porosity)
        )

    @property
    def bulk_porosity(self):
        """phi_V at the last point."""
        return float(self.volume_porosity[-1])


def write_profile(path, profile, comments=(), phi_v=None, phi_a=None):
    """A `MeasuredProfile` as a CSV file that scenes read; phi_v, phi_a (functions of position) in place of what it measured.

    A fit has no standard errors: with it the file has the first three columns. `InputError` if it cannot be written.
    """
    columns, head = [profile.position], list(HEAD)
    if phi_v is None:
        columns += [profile.phi_v, profile.phi_a, profile.phi_v_error, profile.phi_a_error, profile.samples]
        head += MORE
    else:
        columns += [phi_v(profile.position), phi_a(profile.position)]
    with output_file(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        file.writelines(f"# {line}\n" for line in comments)
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(head)
        writer.writerows([f"{cell:.6g}" for cell in row] for row in zip(*columns, strict=True))
