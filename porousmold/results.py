"""The folder of a run: result.json, history.csv, near_wall.csv, fields.h5 + fields.xdmf, scene.toml."""

import csv
import json
import os
from pathlib import Path

import tomli_w
from dolfinx import io

from . import fenicsx
from .errors import InputError
from .observation import field_snapshots, profile_near_wall
from .whole_files import whole_file

OUTPUTS = [
    *("result.json", "history.csv", "near_wall.csv", "fields.h5", "fields.xdmf", "scene.toml"),
    *("temperatures.png", "near_wall.png", "fields.png"),
]


class RunFolder:
    """A folder that a run writes; made at once, so that one that cannot be written is found before the run."""

    def __init__(self, path, communicator):
        self.path, self._communicator = Path(path), communicator
        problem = None
        if communicator.rank == 0:
            try:
                self.path.mkdir(parents=True, exist_ok=True)
                for name in OUTPUTS:  # an older run's files would pass for this one's
                    (self.path / name).unlink(missing_ok=True)
                if not os.access(self.path, os.W_OK):
                    problem = "is not writable"
            except OSError as error:
                problem = f"cannot be made: {error.strerror}"
        problem = communicator.bcast(problem)
        if problem:
            raise InputError("--out", str(path), problem)

    def write_data(self, simulation):
        """Everything but the summary (collective)."""
        profile = profile_near_wall(simulation.problem)
        if self._communicator.rank == 0:
            self._replace("scene.toml", tomli_w.dumps(simulation.scene.as_tables()))
            history = simulation.history
            self._write_table("history.csv", history.columns, history.units)
            if profile is not None:
                self._write_table("near_wall.csv", *profile)
        if simulation.scene.output.fields:
            self._write_fields(simulation)

    def write_summary(self, summary):
        """result.json (rank 0 writes)."""
        if self._communicator.rank == 0:
            self._replace("result.json", json.dumps(summary, indent=2) + "\n")

    def _write_table(self, name, columns, units):
        with whole_file(self.path / name) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow([f"{column} [{units[column]}]" for column in columns])
            writer.writerows(zip(*columns.values(), strict=True))

    def _replace(self, name, text):
        with whole_file(self.path / name) as temporary:
            temporary.write_text(text, encoding="utf-8")

    def _write_fields(self, simulation):
        with io.XDMFFile(simulation.problem.domain.communicator, str(self.path / "fields.xdmf"), "w") as file:
            fenicsx.write_mesh(file, simulation.problem.domain.mesh)
            for time, functions in field_snapshots(simulation.problem, simulation.snapshots, simulation.time):
                for function in functions:
                    file.write_function(function, time)


def read_table(path):
    """Columns and units of a table that `RunFolder` wrote: ({name: list of floats}, {name: unit})."""
    with Path(path).open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    names = [cell.split(" [")[0] for cell in head]
    units = {name: cell.split("[")[1].rstrip("]") for name, cell in zip(names, head, strict=True)}
    columns = {name: [float(row[i]) for row in rows] for i, name in enumerate(names)}
    return columns, units
