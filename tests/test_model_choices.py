"""Only what a scene needs: every choice removes unknowns and terms, and meets the fuller model in its limit."""

import pytest
from mpi4py import MPI

from porousmold import InputError, run
from porousmold.simulation import Simulation

from .support import ALUMINIUM, FRP, PIPE, coarse_scene


def marched(path=ALUMINIUM, **overrides):
    """A coarse scene, laminar (seconds), after its march."""
    overrides.setdefault("model__turbulence", "none")
    return Simulation(coarse_scene(path, **overrides), MPI.COMM_SELF).march()


@pytest.fixture(scope="module")
def full():
    """The coarse mold with everything on."""
    return marched()


def test_thin_aluminium_skin_is_the_resolved_one(full):
    """Bi = h t / lambda = 0.001: no gradient through 3 mm of aluminium. Its cells are gone."""
    thin = marched(model__wall="thin")
    assert thin.heating_time == pytest.approx(full.heating_time, rel=3e-4)
    assert thin.problem.heat.unknowns < full.problem.heat.unknowns
    assert not thin.problem.domain.has_wall
    assert abs(thin.problem.heat.balance.imbalance) < 1e-4


def test_thin_wall_stores_what_a_resolved_one_does():
    """A pipe's ring and its outer surface: heat balances of both models to 1 % over a wall that hardly conducts."""
    changes = {
        "wall__conductivity": 400.0,
        "operation__outer_coefficient": 5.0,
        "operation__ambient_temperature": 296.15,
        "operation__heating_margin": 6.0,
    }
    resolved, thin = marched(PIPE, **changes), marched(PIPE, model__wall="thin", **changes)
    for name in ("stored", "through_outer_wall", "by_fluid"):
        assert getattr(thin.problem.heat.balance, name) == pytest.approx(
            getattr(resolved.problem.heat.balance, name), rel=2e-3
        )
    assert thin.heating_time == pytest.approx(resolved.heating_time, rel=2e-3)


def test_thin_polymer_skin_heats_too_soon():
    """Without the gradient through 3 mm of polymer the outer surface is ahead: the error of the choice, of a few percent."""
    assert 0.94 < marched(FRP, model__wall="thin").heating_time / marched(FRP).heating_time < 0.99


def test_insulated_bed_has_no_wall_to_heat(full):
    bed = marched(model__wall="insulated")
    assert bed.heating_time < 0.8 * full.heating_time
    assert bed.problem.heat.balance.stored < full.problem.heat.balance.stored
    assert "aluminium density" not in bed.problem.sources() and "aluminium density" in full.problem.sources()
    thin_air = marched(model__wall="thin", wall__density=1e-3, wall__conductivity=1e-3)
    assert bed.heating_time == pytest.approx(thin_air.heating_time, rel=2e-3)


def test_one_temperature_halves_the_unknowns(full):
    one = marched(model__energy="one-temperature")
    assert one.problem.heat.unknowns < 0.6 * full.problem.heat.unknowns
    assert abs(one.problem.heat.balance.imbalance) < 1e-4
    # beads that lag behind the fluid smear the front that the wall waits for
    assert 0.80 < one.heating_time / full.heating_time < 0.96


def test_fast_exchange_is_one_temperature():
    """The limit of local thermal equilibrium: 1e4 times the exchange, on cells that resolve the front to half a percent."""
    fine = {"solver__axial_cells": 40, "solver__largest_step": 30.0}
    one = marched(model__energy="one-temperature", **fine).heating_time
    assert marched(model__exchange_factor=1e4, **fine).heating_time == pytest.approx(one, rel=0.006)


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"model__wall": "paper"}, "conjugate"),
        ({"model__wall": "insulated", "operation__outer_heat_flux": 5.0}, "outer_heat_flux"),
        ({"model__energy": "three-temperature"}, "one-temperature"),
        ({"model__exchange_factor": 0.0}, "exchange_factor"),
    ],
)
def test_choices_that_cannot_be_are_refused(changes, word):
    with pytest.raises(InputError, match=word):
        coarse_scene(**changes)


def test_choices_stand_in_the_result():
    summary = run(coarse_scene(model__energy="one-temperature", model__wall="thin", model__turbulence="none"),
                  communicator=MPI.COMM_SELF).summary  # fmt: skip
    assert summary["model"]["energy"] == "one-temperature" and summary["model"]["wall"] == "thin"
    assert set(summary["unknowns"]) == {"flow", "energy"}
