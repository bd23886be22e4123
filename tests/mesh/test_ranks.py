"""What all ranks come to together."""

import numpy as np
import pytest
from mpi4py import MPI

from porousmold.mesh import ranks

WORLD = MPI.COMM_WORLD


@pytest.mark.mpi
def test_sums_and_largest_by_elements():
    mine = np.array([1.0, -2.0 * WORLD.rank])
    assert ranks.total(WORLD, mine).tolist() == [WORLD.size, -1.0 * WORLD.size * (WORLD.size - 1)]
    assert ranks.total(WORLD, 3) == 3.0 * WORLD.size
    assert ranks.maximum(WORLD, mine).tolist() == [1.0, 0.0]
    assert mine.tolist() == [1.0, -2.0 * WORLD.rank]


@pytest.mark.mpi
def test_extremes_are_those_of_ranks_that_have_elements():
    last = np.array([-3.0, 2.0]) if WORLD.rank == WORLD.size - 1 else np.empty(0)
    assert ranks.extremes(WORLD, last) == (-3.0, 2.0)
    assert ranks.extremes(WORLD, np.empty(0)) == (np.inf, -np.inf)
    assert ranks.largest_magnitude(WORLD, last) == 3.0
    assert ranks.largest_magnitude(WORLD, np.empty(0)) == 0.0


@pytest.mark.mpi
def test_a_flag_of_one_rank_is_seen_by_all():
    assert ranks.anywhere(WORLD, WORLD.rank == WORLD.size - 1) is True
    assert ranks.anywhere(WORLD, False) is False
