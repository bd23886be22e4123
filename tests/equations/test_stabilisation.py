"""Time scales of the stabilisation on cells of any shape."""

import numpy as np
import pytest
import ufl
from dolfinx import fem

from porousmold.equations.stabilisation import metric, streamline_time_scale, time_scale

from ..support import box, integral

LENGTH, WIDTH = 0.3, 0.02


def test_time_scales_tend_to_their_limits():
    """h/2|a| for advection, 1/s for reaction; along the flow a flat cell's height does not count."""
    domain = box((1, 1), length=LENGTH, width=WIDTH)
    dx, area, tensor = domain.cell_measure(4), LENGTH * WIDTH, metric(domain.mesh)
    along = ufl.as_vector([fem.Constant(domain.mesh, 5.0), fem.Constant(domain.mesh, 0.0)])
    still = ufl.as_vector([fem.Constant(domain.mesh, 0.0)] * 2)

    def mean(expression):
        return integral(expression * dx) / area

    assert mean(time_scale(tensor, along, 0.0, 0.0)) == pytest.approx(LENGTH / 10.0)
    assert mean(time_scale(tensor, still, 0.0, fem.Constant(domain.mesh, 8.0))) == pytest.approx(1.0 / 8.0)
    flat = mean(streamline_time_scale(tensor, along, fem.Constant(domain.mesh, 1e-3)))
    assert flat == pytest.approx(LENGTH / 10.0, rel=1e-3)
    assert np.isfinite(flat)
