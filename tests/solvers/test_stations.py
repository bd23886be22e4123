"""The stream function of a straight bed's flow."""

import numpy as np
import pytest
import ufl
from mpi4py import MPI

from porousmold.mesh import domain as geometry
from porousmold.solvers.stations import Columns, Streamfunction


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


def columns_of_a_bed(cells):
    across = [geometry.Across.to_wall(np.linspace(0.0, 1.0, 3))]
    return Columns(geometry.straight_bed(MPI.COMM_WORLD, 2.0 * np.linspace(0.0, 1.0, cells + 1) ** 1.3, across))


def test_the_square_of_a_gas_s_pressure_falls_evenly_on_any_cells():
    columns = columns_of_a_bed(5)
    exact = np.sqrt(4.0 + 96.0 * (1.0 - columns.along / 2.0))
    assert columns.pressure(-24.0 / exact, 2.0) == pytest.approx(exact - 2.0, rel=1e-9)


@pytest.mark.parametrize("gas_at", [None, 2.0, 1e6])
def test_the_matrix_is_the_derivative_of_the_pressure(gas_at):
    columns = columns_of_a_bed(4)
    gradient, change = np.array([-3.0, -1.0, -2.0, 0.5, -4.0]), np.array([0.3, -1.0, 0.2, 2.0, 0.7])
    low, high = (columns.pressure(gradient + part * change, gas_at) for part in (-1e-4, 1e-4))
    assert columns.pressure_matrix(gradient, gas_at) @ change == pytest.approx((high - low) / 2e-4, rel=1e-4, abs=1e-5)


def test_a_gas_of_high_pressure_is_as_a_liquid():
    columns, gradient = columns_of_a_bed(4), np.array([-3.0, -1.0, -2.0, 0.5, -4.0])
    assert columns.pressure(gradient, 1e6) == pytest.approx(columns.pressure(gradient), rel=1e-5)
