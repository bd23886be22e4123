"""The state of a run on disk, from which it goes on to the same answer, on any number of ranks.

Arrays are stored by the places of their nodes, in an order that no partition changes: along x[0], then x[1], then x[2].
Beside the fields stands what the next step depends on: step sizes, history, balance, and what the reused Jacobian of the flow
was made of, because iterations with another one end elsewhere within their tolerance. The file ends with the SHA-256 of what
stands before, which HDF5 leaves alone.
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

from ..arrays import Floats
from ..errors import InputError
from ..mesh.aliases import Communicator, Space
from ..mesh.nodes import array_length, leaves
from ..solvers.state import Stateful

NAME = "checkpoint.h5"


class NodeOrder:
    """Brings arrays of one function space into the order that no partition changes, and back (collective)."""

    def __init__(self, space: Space) -> None:
        self._communicator, self._length = space.mesh.comm, array_length(space)
        self._function_space = space
        self._parts = []
        for collapsed, numbers in leaves(space):
            size = collapsed.dofmap.index_map_bs
            owned = collapsed.dofmap.index_map.size_local
            places = self._communicator.gather(collapsed.tabulate_dof_coordinates()[:owned])
            order = None
            if places is not None:
                everywhere = np.concatenate(places)
                extent = max(float(np.ptp(everywhere)), 1e-300)
                order = np.lexsort(np.round(everywhere / extent, 10).T[::-1])
            self._parts.append((numbers[: owned * size].reshape(owned, size), order))

    def gather(self, array: Floats) -> Floats | None:
        """The whole array on rank 0, None on the others."""
        wholes = []
        for numbers, order in self._parts:
            pieces = self._communicator.gather(array[numbers])
            if pieces is not None:
                wholes.append(np.concatenate(pieces)[order].ravel())
        return np.concatenate(wholes) if wholes else None

    def scatter(self, whole: Floats) -> Floats:
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


class NodeOrders:
    """The `NodeOrder` of every space met so far."""

    def __init__(self) -> None:
        self._orders: list[tuple[Any, NodeOrder]] = []

    def of(self, space: Space) -> NodeOrder:
        """Made at the first meeting (collective)."""
        for known, order in self._orders:
            if known is space or known == space:
                return order
        self._orders.append((space, NodeOrder(space)))
        return self._orders[-1][1]


@dataclass
class Checkpoint:
    """As it was read, whole on every rank: the `identity` of its run, `outcomes` of earlier integrations, and `numbers` and
    `arrays` of the last one's `Saved`."""

    identity: str
    outcomes: list[Any]
    numbers: dict[str, Any]
    arrays: dict[str, Floats]

    def restore(self, part: Stateful) -> None:
        """Bring a newly made simulation of the same scene to the saved state (collective)."""
        orders = NodeOrders()
        part.restore(self.numbers, lambda name, space: orders.of(space).scatter(self.arrays[name]))


def packed(part: Stateful, outcomes: list[Any], orders: NodeOrders, identity: str, rank: int) -> bytes | None:
    """Content of a checkpoint file, on rank 0, None on the others (collective)."""
    saved = part.save()
    wholes = {name: orders.of(space).gather(array) for name, (space, array) in saved.arrays.items()}
    if rank:
        return None
    memory = io.BytesIO()
    with h5py.File(memory, "w") as file:
        file.attrs["identity"] = identity
        content = json.dumps({"outcomes": outcomes, "numbers": saved.numbers})
        file["numbers"] = np.frombuffer(content.encode(), dtype=np.uint8)
        for name, whole in wholes.items():
            file[f"fields/{name}"] = whole
    content_of_file = memory.getvalue()
    return content_of_file + hashlib.sha256(content_of_file).digest()


def _sound(content: bytes) -> bytes:
    """The HDF5 file before its digest. Raises `ValueError` where they do not fit: a flipped bit may look like a state."""
    size = hashlib.sha256().digest_size
    if hashlib.sha256(content[:-size]).digest() != content[-size:]:
        raise ValueError("its checksum does not fit")
    return content[:-size]


def read(path: Path, communicator: Communicator) -> Checkpoint | None:
    """The `Checkpoint` of a file, None where there is none (collective); `InputError` if it is damaged."""
    found = problem = None
    if communicator.rank == 0 and path.is_file():
        try:
            with h5py.File(io.BytesIO(_sound(path.read_bytes()))) as file:
                content = json.loads(file["numbers"][()].tobytes())
                arrays: dict[str, Floats] = {}

                def keep(name: str, item: object) -> None:
                    if isinstance(item, h5py.Dataset):
                        arrays[name] = item[()]

                file["fields"].visititems(keep)
                found = Checkpoint(file.attrs["identity"], content["outcomes"], content["numbers"], arrays)
        except (OSError, LookupError, ValueError, TypeError, AttributeError, RuntimeError) as error:
            problem = str(error)
    found, problem = communicator.bcast((found, problem))
    if problem is not None:
        raise InputError("--resume", str(path), f"is damaged ({problem}); start without --resume")
    return found
