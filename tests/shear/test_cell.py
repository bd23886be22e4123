"""Beads sheared between walls: what is measured, seeds, checkpoints, and input that is refused."""

import dataclasses

import numpy as np
import pytest

from porousmold.errors import InputError
from porousmold.shear import evaluation
from porousmold.shear import motion as module
from porousmold.shear.cell import ShearCell
from porousmold.shear.motion import Shearing

SMALL = {"distance": 8.0, "width": 6.0, "strains": 10.0, "peclet": (1.0,)}


def sheared(fraction, rate=0.03, **settings):
    return Shearing(ShearCell(fraction, rate, **(SMALL | settings))).integrate()


@pytest.fixture(scope="module")
def dense():
    return sheared(0.6)


def numbers(result):
    return {
        field.name: np.asarray(getattr(result, field.name))
        for field in dataclasses.fields(result)
        if field.name not in ("cell", "pictured")
    }


def test_beads_follow_the_walls_and_fill_the_bed(dense):
    assert dense.velocity[0] < -2.0
    assert dense.velocity[-1] > 2.0
    assert 0.5 < dense.core_shear_rate < 1.2
    assert dense.core_solid_fraction == pytest.approx(0.6, abs=0.05)
    assert dense.steps == pytest.approx(23.0 / Shearing(dense.cell).dt, abs=1.0)


def test_convection_is_that_of_self_diffusion(dense):
    """Beads that wander carry their heat as a conductivity (1 - phi) rho C D does: two measurements of one coefficient."""
    assert dense.stirring[0] == pytest.approx(dense.self_diffusion[0], rel=0.3)
    assert 0.02 < dense.self_diffusion[0] < 0.1


def test_contacts_conduct_where_the_bed_jams(dense):
    """Orders of magnitude between a bed that flows freely and a dense one of hard beads (Forgber and Radl, section 4.2)."""
    loose, jammed = sheared(0.45, 3e-3, strains=2.0), sheared(0.62, 3e-3, strains=2.0)
    assert jammed.pressure > 100.0 * loose.pressure
    assert jammed.conduction[0, 0] > 20.0 * loose.conduction[0, 0]
    assert jammed.coordination_number > 4.0 > 1.0 > loose.coordination_number


def test_flat_walls_slip_where_rough_ones_do_not(dense):
    assert sheared(0.62, walls="flat").core_shear_rate < 0.6 * dense.core_shear_rate


def test_half_the_time_step_gives_the_same_pressure(dense):
    fine = sheared(0.6, steps_per_contact=32)
    assert fine.pressure == pytest.approx(dense.pressure, rel=0.05)
    assert fine.conduction[0, 0] == pytest.approx(dense.conduction[0, 0], rel=0.06)


def test_same_seed_same_numbers_another_seed_other_ones():
    short = {"strains": 1.0, "distance": 6.0, "width": 5.0}
    first, again, other = sheared(0.5, **short), sheared(0.5, **short), sheared(0.5, seed=2, **short)
    for name, values in numbers(first).items():
        np.testing.assert_array_equal(values, numbers(again)[name], err_msg=name)
    assert first.pressure != other.pressure


def test_a_run_that_was_killed_goes_on_to_the_same_numbers(tmp_path, monkeypatch):
    cell = ShearCell(0.5, 0.03, strains=1.0, distance=6.0, width=5.0)
    whole = Shearing(cell, pictures=5).integrate()
    writes = iter(range(4))
    write = Shearing._write

    def killed(self):
        write(self)
        if next(writes, None) is None:
            raise KeyboardInterrupt

    monkeypatch.setattr(Shearing, "_write", killed)
    with pytest.raises(KeyboardInterrupt):
        Shearing(cell, tmp_path / "checkpoint.npz", pictures=5).integrate()
    monkeypatch.undo()
    resumed = Shearing(cell, tmp_path / "checkpoint.npz", pictures=5)
    assert 0 < len(resumed._blocks) < module.BLOCKS
    result = resumed.integrate()
    for name, values in numbers(whole).items():
        np.testing.assert_array_equal(values, numbers(result)[name], err_msg=name)
    np.testing.assert_array_equal(whole.pictured, result.pictured)


def test_a_drifting_flux_is_not_steady():
    rng = np.random.default_rng(3)
    noise = 0.01 * rng.standard_normal((8, 3))
    fluxes = noise + np.array([1.0, 1.0, 1.0]) + np.outer(np.arange(8), [0.0, 0.1, 0.0])
    stored = noise + np.array([0.0, 0.0, 0.5])
    assert evaluation._steady(fluxes, stored).tolist() == [True, False, False]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"solid_fraction": 0.8}, "--solid-fraction = 0.8: must be >= 0.3 and <= 0.68"),
        ({"shear_rate": 0.0}, "--shear-rate = 0.0: must be >= 1e-05 and <= 0.3"),
        ({"peclet": (1.0, -1.0)}, "--peclet = -1.0: must be >= 0.001 and <= 1e\\+06"),
        ({"biot": ()}, "give at least one Peclet and one Biot number"),
        ({"walls": "none"}, "--walls = 'none': must be rough or flat"),
        ({"friction": float("nan")}, "--friction = nan: must be"),
        ({"width": 100.0, "distance": 100.0, "solid_fraction": 0.6}, "more than 1000000 beads"),
    ],
)
def test_bad_input_is_refused(settings, message):
    with pytest.raises(InputError, match=message):
        ShearCell(**({"solid_fraction": 0.5, "shear_rate": 0.01} | settings))


def test_fluxes_that_are_not_those_through_the_walls_are_not_steady():
    """52 with an error of 20 beside 0.02 at the walls counted as steady, as three errors hide any difference."""
    noisy = 50.0 + 60.0 * np.array([[1.0], [-1.0]] * 5)
    quiet = 0.5 + 0.01 * np.array([[1.0], [-1.0]] * 5)
    assert not evaluation._passes_the_walls(noisy, np.array([0.02])).any()
    assert not evaluation._passes_the_walls(quiet, np.array([0.2])).any()
    assert evaluation._passes_the_walls(quiet, np.array([0.51])).all()
