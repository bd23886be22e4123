"""The mass flow that `porousmold check` tells beside that of the run."""

import pytest
from mpi4py import MPI

from porousmold import Scene, run
from porousmold.simulation.estimates import estimate
from porousmold.simulation.expected_flow import expected_mass_flow
from porousmold.simulation.specs import specs_of

from ..support import ALUMINIUM, PIPE

AT_ONE_TEMPERATURE = {
    "operation.initial_temperature": 320.0,
    "operation.inlet_temperature": 320.5,
    "operation.heating_margin": 0.1,
    "operation.end_time": 1.0,
    "model.flow": "developed",
}
LAMINAR = {"model.turbulence": "none"}


def both(path, settings):
    """Mass flow that is expected, that of the run, and that of the middle of the bed alone."""
    scene = Scene.load(path, AT_ONE_TEMPERATURE | settings)
    specs = specs_of(scene)
    found = estimate(specs, specs.mesh.size)
    result = run(scene, communicator=MPI.COMM_SELF)
    return expected_mass_flow(specs, specs.mesh.size, found), result.summary["mass_flow_initial"], found.mass_flow


@pytest.mark.parametrize(
    ("path", "settings"),
    [
        (ALUMINIUM, {}),
        (
            ALUMINIUM,
            {"bed.porosity_model": "vortmeyer-schuster", "model.drag": "ergun", "operation.pressure_drop": 200.0},
        ),
        (ALUMINIUM, {"bed.porosity_model": "white-tien", "model.drag": "kta", "model.turbulence": "nakayama-kuwahara"}),
        (PIPE, {"operation.mass_flow": None, "operation.pressure_drop": 50.0, "model.drag": "erdim"} | LAMINAR),
        (ALUMINIUM, {"fluid.material": "water", "operation.pressure_drop": 300.0} | LAMINAR),
        (ALUMINIUM, {"geometry.cavity_height": 0.1, "bed.bead_diameter": 0.009, "model.drag": "eisfeld-schnitzlein"}),
    ],
)
def test_it_is_that_of_the_run_within_five_per_cent(path, settings):
    expected, found, middle = both(path, settings)
    assert expected == pytest.approx(found, rel=0.05)
    assert abs(expected / found - 1.0) < abs(middle / found - 1.0)


def test_where_the_porosity_is_uniform_only_the_layer_at_the_wall_is_slower():
    expected, found, middle = both(ALUMINIUM, {"bed.porosity_model": "constant"} | LAMINAR)
    assert 0.98 * middle < expected < middle and expected == pytest.approx(found, rel=1e-3)


def test_plug_flow_and_a_given_mass_flow_are_what_they_are():
    expected, found, _ = both(ALUMINIUM, {"model.flow": "plug"} | LAMINAR)
    assert expected == pytest.approx(found, rel=2e-3)
    expected, found, _ = both(ALUMINIUM, {"operation.pressure_drop": None, "operation.mass_flow": 0.03})
    assert expected == pytest.approx(0.03) == pytest.approx(found, rel=1e-6)


def test_a_creeping_flow_is_not_that_of_a_reynolds_number_of_one():
    """Water at 0.01 Pa: the flow of `check` was many times too large, and the bead Reynolds number of the result, too."""
    water = {"fluid.material": "water", "operation.inlet_velocity": None, "operation.pressure_drop": 0.01, **LAMINAR}
    expected, of_run, scale = both(PIPE, water | {"operation.outlet_pressure": "2 bar"})
    assert expected == pytest.approx(of_run, rel=0.1) and scale > 3.0 * expected
