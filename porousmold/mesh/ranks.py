"""What the values of all ranks come to together. Every function is collective.

The reductions are of numpy buffers: mpi4py's reductions of Python objects take ten times as long.
"""

import numpy as np
from dolfinx import fem
from mpi4py import MPI
from numpy.typing import ArrayLike

from ..arrays import Floats
from .aliases import Communicator, Form


def total(communicator: Communicator, values: ArrayLike) -> Floats:
    """Sum over the ranks, by elements: a number of a number, an array of an array."""
    return _reduced(communicator, values, MPI.SUM)


def maximum(communicator: Communicator, values: ArrayLike) -> Floats:
    """Largest over the ranks, by elements."""
    return _reduced(communicator, values, MPI.MAX)


def anywhere(communicator: Communicator, flag: bool) -> bool:
    """Whether the flag is set on any rank."""
    return bool(_reduced(communicator, flag, MPI.MAX))


def extremes(communicator: Communicator, values: Floats) -> tuple[float, float]:
    """Smallest and largest of all elements on all ranks; (inf, -inf) where there are none."""
    ends = [-np.min(values, initial=np.inf), np.max(values, initial=-np.inf)]
    low, high = _reduced(communicator, ends, MPI.MAX)
    return -float(low), float(high)


def largest_magnitude(communicator: Communicator, values: Floats) -> float:
    """Largest magnitude of all elements on all ranks; 0 where there are none."""
    return float(_reduced(communicator, np.max(np.abs(values), initial=0.0), MPI.MAX))


def integral(communicator: Communicator, form: Form) -> float:
    """Value of a compiled scalar form."""
    return float(total(communicator, fem.assemble_scalar(form)))


def _reduced(communicator: Communicator, values: ArrayLike, operation: MPI.Op) -> Floats:
    result = np.array(values, dtype=float)
    if communicator.size > 1:
        communicator.Allreduce(MPI.IN_PLACE, result, op=operation)
    return result if result.ndim else result[()]
