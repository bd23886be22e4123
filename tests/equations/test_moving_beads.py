"""Beads that move as a plug: exact solutions of a moving-bed heat exchanger, and the front that runs through it."""

import math

import numpy as np
import pytest
from mpi4py import MPI
from scipy.integrate import quad

from porousmold import InputError, Scene, run
from studies.exact_solutions import schumann

LENGTH, HOT, COLD = 0.5, 400.0, 300.0
POROSITY, DIAMETER, SUPERFICIAL = 0.4, 5e-3, 0.5
FLUID = {"density": 1.0, "viscosity": 2e-5, "heat_capacity": 1000.0, "conductivity": 0.03}
BEADS = {"bead_density": 2400.0, "bead_heat_capacity": 800.0, "bead_conductivity": 1e-6}
WEAK = 0.02
"""Factor on the exchange that leaves one or two transfer units."""


def exchanger(velocity, settings=None):
    """A pipe of uniform porosity in plug flow, beads that move in it, no wall, all properties constant."""
    tables = {
        "geometry": {"kind": "pipe", "length": LENGTH, "diameter": 0.1},
        "bed": {"bead_diameter": DIAMETER, "porosity_model": "constant", "bulk_porosity": POROSITY, **BEADS},
        "fluid": FLUID,
        "operation": {
            "initial_temperature": COLD,
            "inlet_temperature": HOT,
            "inlet_velocity": SUPERFICIAL,
            "bead_velocity": velocity,
            "bead_inlet_temperature": COLD,
            "end_time": min(6.0 * LENGTH / abs(velocity), 1e8),
            "heating_margin": 1e-3,
        },
        "model": {"flow": "plug", "turbulence": "none", "wall": "insulated", "exchange_factor": WEAK},
        "solver": {"axial_cells": 20, "step_tolerance": 1.0},
        "output": {"pictures": False, "fields": False},
    }
    return Scene(tables).changed(settings or {})


def exchange(velocity):
    """a_v h_sf past beads of a velocity, W/m3/K."""
    reynolds, prandtl = abs(SUPERFICIAL - POROSITY * velocity) * DIAMETER / 2e-5, 2e-5 * 1000.0 / 0.03
    nusselt = 2.0 + 1.1 * reynolds**0.6 * prandtl ** (1 / 3)
    return WEAK * nusselt * 0.03 / DIAMETER * 6.0 * (1.0 - POROSITY) / DIAMETER


def outlets(velocity):
    """Temperatures of fluid and beads where each leaves, by the number of transfer units."""
    of_fluid, of_beads = SUPERFICIAL * 1000.0, (1.0 - POROSITY) * 2400.0 * 800.0 * abs(velocity)
    area = exchange(velocity) * LENGTH
    if velocity > 0.0:
        heat = -math.expm1(-area * (1.0 / of_fluid + 1.0 / of_beads)) / (1.0 / of_fluid + 1.0 / of_beads)
    else:
        part = math.exp(-area * (1.0 / of_fluid - 1.0 / of_beads))
        heat = of_fluid * (1.0 - part) / (1.0 - part * of_fluid / of_beads)
    heat *= HOT - COLD
    return HOT - heat / of_fluid, COLD + heat / of_beads


@pytest.mark.parametrize("velocity", [4e-4, 2e-3, -2e-3, -1e-3])
def test_co_and_counter_current_exchangers_give_what_their_transfer_units_say(velocity):
    result = run(exchanger(velocity), communicator=MPI.COMM_SELF)
    fluid, beads = outlets(velocity)
    assert result["outlet_temperature"][-1] == pytest.approx(fluid, abs=0.03)
    assert result["bead_outlet_temperature"][-1] == pytest.approx(beads, abs=0.03)
    assert abs(result.summary["energy_imbalance"]) < 1e-8
    low, high = result.summary["temperature_bounds"]
    assert low > COLD - 0.1 and high < HOT + 0.1


def test_the_heat_in_the_beads_converges_at_least_with_the_square_of_the_cells():
    """Temperatures at the ends converge faster still."""
    stored = []
    for cells in (6, 12, 24):
        settings = {"solver.axial_cells": cells, "operation.end_time": 12.0 * LENGTH / 2e-3}
        stored.append(run(exchanger(-2e-3, settings), communicator=MPI.COMM_SELF)["heat_stored"][-1])
    assert math.log2((stored[0] - stored[1]) / (stored[1] - stored[2])) > 1.9


def test_the_front_in_beads_that_move_along_is_schumanns_in_their_frame():
    """Beads that were in the bed see, at the place from which on they are the first, the steady exchanger's fluid."""
    velocity = 1e-3
    per_place = exchange(velocity) / (SUPERFICIAL * 1000.0)
    per_time = exchange(velocity) / ((1.0 - POROSITY) * 2400.0 * 800.0)
    time = 0.4 * LENGTH / velocity
    settings = {"operation.end_time": time, "solver.axial_cells": 60, "solver.step_refinement": 2.0}
    result = run(exchanger(velocity, settings), communicator=MPI.COMM_SELF)

    rate = per_place + per_time / velocity  # at which the steady exchanger's difference of fluid and beads decays
    of_fluid, of_beads = SUPERFICIAL * 1000.0, (1.0 - POROSITY) * 2400.0 * 800.0 * velocity
    share = of_beads / (of_fluid + of_beads)  # the fluid there is 1 - share (1 - exp(-rate velocity t))
    y = per_place * (LENGTH - velocity * time)
    rise = rate * velocity
    later = quad(lambda at: math.exp(-rise * at) * schumann(y, per_time * (time - at)), 0.0, time)[0]
    expected = schumann(y, per_time * time) - share * rise * later
    assert result["outlet_temperature"][-1] == pytest.approx(COLD + (HOT - COLD) * expected, abs=0.1)


def test_heat_exchange_follows_the_velocity_past_the_beads():
    """Beads that come against the fluid as fast as a fifth of it take up heat with 1.2^0.6 of Wakao's convective part."""
    velocity = -0.2 * SUPERFICIAL / POROSITY
    result = run(exchanger(velocity), communicator=MPI.COMM_SELF)
    assert 1.08 < exchange(velocity) / exchange(1e-12) < 1.2**0.6
    fluid, _ = outlets(velocity)
    assert result["outlet_temperature"][-1] == pytest.approx(fluid, abs=0.03)


def test_drag_follows_the_velocity_past_the_beads():
    """Fluid that moves with the beads needs no pressure; beads that come against it need more than beads at rest."""
    drops = {}
    for ratio in (1.0, 1e-6, -0.5):
        velocity = ratio * SUPERFICIAL / POROSITY
        settings = {"operation.end_time": 0.05, "solver.first_step": 0.01}
        drops[ratio] = run(exchanger(velocity, settings), communicator=MPI.COMM_SELF)["pressure_drop"][-1]
    assert abs(drops[1.0]) < 1e-9 * drops[1e-6]
    assert 1.5 * drops[1e-6] < drops[-0.5] < 2.25 * drops[1e-6]


@pytest.mark.parametrize("flow", ["full", "developed"])
def test_every_flow_has_less_resistance_from_beads_that_move_with_it(flow):
    """The mass flow under a pressure drop rises by that of the beads' own motion, where the profile is flat."""
    flows = []
    for velocity in (1e-9, 0.1):
        settings = {
            "model.flow": flow,
            "operation.inlet_velocity": None,
            "operation.pressure_drop": 200.0,
            "operation.end_time": 0.5,
            "solver.first_step": 0.1,
            "bed.porosity_model": "constant",
        }
        flows.append(run(exchanger(velocity, settings), communicator=MPI.COMM_SELF)["mass_flow"][-1])
    gained = (flows[1] - flows[0]) / (math.pi * 0.05**2 * POROSITY * 1.0 * 0.1)
    assert 0.9 < gained < 1.001  # a thin layer at the wall does not move


@pytest.mark.parametrize(
    ("settings", "key"),
    [
        ({"operation.bead_inlet_temperature": None}, "bead_inlet_temperature"),
        ({"operation.bead_velocity": 0.0}, "bead_inlet_temperature"),
        ({"model.bead_modes": 2}, "model.bead_modes"),
        ({"model.energy": "one-temperature"}, "model.energy"),
        ({"operation.bead_velocity": 11.0}, "bead_velocity"),
    ],
)
def test_what_does_not_go_with_moving_beads_is_refused(settings, key):
    with pytest.raises(InputError, match=key):
        exchanger(1e-3, settings)


@pytest.mark.mpi
def test_ranks_agree():
    alone = run(exchanger(-2e-3), communicator=MPI.COMM_SELF)
    together = run(exchanger(-2e-3), communicator=MPI.COMM_WORLD)
    assert np.allclose(together["bead_outlet_temperature"], alone["bead_outlet_temperature"], rtol=1e-10)
    assert together["heat_by_beads"][-1] == pytest.approx(alone["heat_by_beads"][-1], rel=1e-9)


def test_a_front_much_sharper_than_the_cells_keeps_its_bounds_against_moving_beads():
    """Beads that come hot into cold gas: what they carry was not monotone, and they got 20 K hotter than all that is given."""
    settings = {
        "model.exchange_factor": 1.0,
        "operation.initial_temperature": HOT,
        "operation.inlet_temperature": COLD,
        "operation.bead_inlet_temperature": HOT,
        "operation.end_time": 200.0,
        "bed.bead_diameter": 1.5e-3,
        "bed.bead_conductivity": 0.2,
    }
    result = run(exchanger(-8e-4, settings), communicator=MPI.COMM_SELF)
    low, high = result.summary["temperature_bounds"]
    assert low > COLD - 0.1 and high < HOT + 0.1
    assert max(result["bead_outlet_temperature"]) < HOT + 0.1
    assert result.summary["repeated_steps"] > 0
    assert abs(result.summary["energy_imbalance"]) < 1e-6
