"""Where a tool is coldest and hottest."""

import pytest

from ..support import coarse_scene, problem_of

PLUG = {"model.flow": "plug", "model.turbulence": "none"}


def test_where_all_is_alike_the_first_place_along_the_flow_counts():
    """What rounding leaves chose one of them, another on every number of ranks."""
    problem = problem_of(coarse_scene(PLUG))
    values, along = problem.heat.unknown.x.array, problem.places._along
    values[:] = 300.0 + 1e-9 * along
    assert problem.places.extreme_places("bed_side") == (0.0, 0.0)
    values[:] = 300.0 - 10.0 * along
    assert problem.places.extreme_places("bed_side") == pytest.approx((problem.domain.length, 0.0))
