"""The stream function of a straight bed's flow."""

import numpy as np
import pytest
import ufl
from mpi4py import MPI

from porousmold.mesh import domain as geometry
from porousmold.solvers.stations import Streamfunction


@pytest.mark.parametrize("turning", [0.2, 1.0, 2.0])
def test_the_stream_function_carries_what_flows_back_at_the_wall(turning):
    """A flux 1 - turning y/h: forwards throughout, back at the wall, and as much back as forwards."""
    across = [geometry.Across.to_wall(np.linspace(0.0, 1.0, 9), [np.array([0.0, 0.1])])]
    domain = geometry.straight_bed(MPI.COMM_WORLD, np.linspace(0.0, 2.0, 6), across)
    place = ufl.SpatialCoordinate(domain.mesh)[1]
    flux = domain.constant(1.0) * (1.0 - turning * place)
    stream = Streamfunction(domain, flux)
    stream.renew()
    points = stream.function.function_space.tabulate_dof_coordinates()[:, 1]
    exact = points - 0.5 * turning * points**2
    inside = points < 1.0 + 1e-9
    assert np.allclose(stream.function.x.array[inside], exact[inside], atol=1e-9)
