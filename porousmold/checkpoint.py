"""The state of a run on disk, from which it goes on to the same answer, on any number of ranks.

Arrays are stored by the places of their nodes, in an order that no partition changes: along x[0], then x[1], then x[2].
Beside the fields stands what the next step depends on: step sizes, history, balance, and what the kept factors of the flow
were made of, because iterations with other factors end elsewhere within their tolerance.
"""

import hashlib
import io
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from dolfinx import fem

from . import __version__, fenicsx
from .errors import InputError
from .scene import KEYS
from .series import TimeSeries

NAME = "checkpoint.h5"
FREE_TO_CHANGE = {
    "operation": ("end_time",),
    "solver": ("first_step", "step_growth", "largest_step", "step_tolerance", "flow_tolerance"),
}
"""Keys that may have other values when a run goes on, besides all of [output]."""


def fingerprint(scene, *, going_on=False):
    """Text that is the same for scenes with the same values, contents of their files and program version.

    With `going_on`, keys that may change in the middle of a march do not count.
    """
    values = {}
    for table, keys in KEYS.items():
        for name in keys:
            free = FREE_TO_CHANGE.get(table, ()) if going_on else ()
            if table == "output" or name in free:
                continue
            value = getattr(getattr(scene, table), name)
            if isinstance(value, TimeSeries):
                value = value.content
            elif isinstance(value, Path):
                value = scene.file_digests[f"{table}.{name}"]
            values[f"{table}.{name}"] = value
    return hashlib.sha256(json.dumps([__version__, values], sort_keys=True).encode()).hexdigest()


class NodeOrder:
    """Brings arrays of one function space into the order that no partition changes, and back (collective)."""

    def __init__(self, space):
        self._communicator, self._length = space.mesh.comm, _array_length(space)
        self._function_space = space
        self._parts = []
        for collapsed, numbers in _leaves(space):
            size = collapsed.dofmap.index_map_bs
            owned = collapsed.dofmap.index_map.size_local
            places = self._communicator.gather(collapsed.tabulate_dof_coordinates()[:owned])
            order = None
            if places is not None:
                everywhere = np.concatenate(places)
                extent = max(float(np.ptp(everywhere)), 1e-300)
                order = np.lexsort(np.round(everywhere / extent, 10).T[::-1])
            self._parts.append((numbers[: owned * size].reshape(owned, size), order))

    def gather(self, array):
        """The whole array on rank 0, None on the others."""
        wholes = []
        for numbers, order in self._parts:
            pieces = self._communicator.gather(array[numbers])
            if pieces is not None:
                wholes.append(np.concatenate(pieces)[order].ravel())
        return np.concatenate(wholes) if wholes else None

    def scatter(self, whole):
        """The local array, ghosts included, from rank 0's whole one."""
        function = fem.Function(self._function_space)
        start = 0
        for numbers, order in self._parts:
            counts = self._communicator.gather(len(numbers))
            pieces = None
            if counts is not None:
                values = np.empty((sum(counts), numbers.shape[1]))
                values[order] = whole[start : start + values.size].reshape(values.shape)
                start += values.size
                pieces = np.split(values, np.cumsum(counts)[:-1])
            function.x.array[numbers] = self._communicator.scatter(pieces)
        function.x.scatter_forward()
        return function.x.array.copy()


def _array_length(space):
    return (space.dofmap.index_map.size_local + space.dofmap.index_map.num_ghosts) * space.dofmap.index_map_bs


def _leaves(space):
    """(space, numbers in the whole) of every scalar or vector part of a space."""
    if space.num_sub_spaces == 0 or space.dofmap.index_map_bs > 1:
        return [(space, np.arange(_array_length(space)))]
    return [fenicsx.collapse(space, part) for part in range(space.num_sub_spaces)]


class NodeOrders:
    """The `NodeOrder` of every space met so far."""

    def __init__(self):
        self._orders: list[tuple[Any, NodeOrder]] = []

    def of(self, space):
        """Made at the first meeting (collective)."""
        for known, order in self._orders:
            if known is space or known == space:
                return order
        self._orders.append((space, NodeOrder(space)))
        return self._orders[-1][1]


@dataclass
class Saved:
    """A checkpoint as it was read, whole on every rank: `outcomes` of earlier marches, `numbers` and `fields` of the last."""

    outcomes: list
    numbers: dict
    fields: dict[str, np.ndarray]

    def restore(self, simulation):
        """Bring a newly made simulation of the same scene to the saved state (collective)."""
        orders = NodeOrders()
        simulation.recall(self.numbers, lambda name, space: orders.of(space).scatter(self.fields[name]))


def packed(simulation, outcomes, orders, mark):
    """Content of a checkpoint file as bytes, on rank 0, None on the others (collective); `mark` is its run's fingerprint."""
    numbers, fields = simulation.memory()
    wholes = {name: orders.of(space).gather(array) for name, (space, array) in fields.items()}
    if simulation.problem.communicator.rank:
        return None
    memory = io.BytesIO()
    with h5py.File(memory, "w") as file:
        file.attrs["fingerprint"] = mark
        file["numbers"] = np.frombuffer(json.dumps({"outcomes": outcomes, **numbers}).encode(), dtype=np.uint8)
        for name, whole in wholes.items():
            file[f"fields/{name}"] = whole
    return memory.getvalue()


def read(path, communicator):
    """(fingerprint, `Saved`) of a checkpoint file, None where there is none (collective); `InputError` if it is damaged."""
    found = problem = None
    if communicator.rank == 0 and path.is_file():
        try:
            with h5py.File(path) as file:
                numbers = json.loads(file["numbers"][()].tobytes())
                fields: dict[str, np.ndarray] = {}

                def keep(name, item):
                    if isinstance(item, h5py.Dataset):
                        fields[name] = item[()]

                file["fields"].visititems(keep)
                found = file.attrs["fingerprint"], Saved(numbers.pop("outcomes"), numbers, fields)
        except (OSError, LookupError, ValueError, TypeError, AttributeError, RuntimeError) as error:
            problem = str(error)
    found, problem = communicator.bcast((found, problem))
    if problem is not None:
        raise InputError("--resume", str(path), f"is damaged ({problem}); start without --resume")
    return found
