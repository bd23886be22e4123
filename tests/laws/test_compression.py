"""Ideal work of a flow: gases against gamma, small pressure differences, there and back."""

from dataclasses import replace

import numpy as np
import pytest

from porousmold.laws.compression import isentropic_work
from porousmold.laws.material_library import FLUIDS

from ..support import liquid

AIR = replace(FLUIDS["air"], heat_capacity=1005.0)


def test_of_a_gas_it_is_the_enthalpy_of_isentropic_compression():
    specific = 1e5 / float(AIR.density(1e5, 300.0)) / 300.0
    capacity = float(AIR.heat_capacity(300.0))
    exact = capacity * 300.0 * (2.25 ** (specific / capacity) - 1.0)
    assert isentropic_work(AIR, 1e5, 300.0, 1.25e5) == pytest.approx(exact, rel=1e-12)


def test_of_a_small_pressure_difference_it_is_that_over_the_density():
    assert isentropic_work(AIR, 1e5, 300.0, 1.0) == pytest.approx(1.0 / AIR.density(1e5, 300.0), rel=1e-5)
    assert isentropic_work(liquid(), 1e5, 300.0, 9e4) == pytest.approx(9e4 / liquid().density(1e5, 300.0), rel=1e-12)


def test_an_expansion_gives_back_what_the_compression_took():
    rises = np.array([1e3, 1e4, 1e5])
    capacity = float(AIR.heat_capacity(300.0))
    taken = isentropic_work(AIR, 1e5, 300.0, rises)
    assert isentropic_work(AIR, 1e5 + rises, 300.0 + taken / capacity, -rises) == pytest.approx(-taken, rel=1e-9)
