"""Estimates before a run: the force of gravity, properties without a value, steps of moving beads."""

import pytest
from mpi4py import MPI

from porousmold import InputError
from porousmold.simulation.estimates import estimate
from porousmold.simulation.march import Simulation
from porousmold.simulation.specs import specs_of

from ..support import STUDIES, coarse_scene

WATER = {"fluid.material": "water", "model.turbulence": "none"}


def estimates_of(scene):
    specs = specs_of(scene)
    return estimate(specs, specs.mesh.size)


def test_gravity_drives_as_the_pressure_drop_of_its_weight_does():
    gravity = 9.81
    by_weight = estimates_of(coarse_scene({**WATER, "operation.pressure_drop": 0.0, "operation.gravity": gravity}))
    density = specs_of(coarse_scene(WATER)).laws.fluid.density(101325.0, 363.15)
    by_pressure = estimates_of(coarse_scene({**WATER, "operation.pressure_drop": density * gravity}))  # over 1 m
    assert by_weight.speed == pytest.approx(by_pressure.speed, rel=1e-3)
    against = {"operation.pressure_drop": 2.0 * density * gravity, "operation.gravity": -gravity}
    assert estimates_of(coarse_scene({**WATER, **against})).speed == pytest.approx(by_pressure.speed, rel=1e-3)


def test_a_property_without_a_value_is_refused_by_its_name():
    with pytest.raises(InputError, match=r"operation\.inlet_temperature.*water .*is given for"):
        estimates_of(
            coarse_scene({**WATER, "operation.inlet_temperature": "500 degC", "operation.outlet_pressure": "300 bar"})
        )


def test_fast_beads_do_not_hold_the_steps_back():
    path = STUDIES / "beds" / "moving_bed.toml"
    slow, fast = (estimates_of(coarse_scene(path, {"operation.bead_velocity": v})) for v in (5e-3, 0.5))
    assert slow.largest_step == pytest.approx(0.25 * slow.bead_residence_time)
    assert 10.0 * 0.25 * fast.bead_residence_time < fast.largest_step < slow.largest_step


def test_a_front_wider_than_the_bed_does_not_lengthen_the_steps():
    """Beads that conduct well spread it over the whole bed, which is then heated as one: its steps have to follow that."""
    conducting = {"bed.bead_conductivity": 80.0, "operation.pressure_drop": 50.0, "model.turbulence": "none"}
    estimates = estimates_of(coarse_scene(conducting))
    assert estimates.front_width > estimates.length
    assert estimates.heating_duration > 10.0 * estimates.largest_step

    def heating_time(steps):
        settings = {"model.flow": "developed", "solver.mesh_refinement": 0.4, "solver.step_refinement": steps}
        simulation = Simulation(specs_of(coarse_scene(conducting | settings)), MPI.COMM_SELF)
        return simulation.march().recorder.heating_time

    assert heating_time(1.0) == pytest.approx(heating_time(4.0), rel=2e-3)
