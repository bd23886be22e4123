"""Estimates before a run: the force of gravity, properties without a value, steps of moving beads."""

import pytest
from mpi4py import MPI

from porousmold import InputError, Scene, run
from porousmold.simulation.estimates import estimate
from porousmold.simulation.specs import specs_of
from porousmold.simulation.time_integration import Simulation

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
    with pytest.raises(InputError, match=r"operation\.inlet_temperature.*water is no liquid above 373.9 °C"):
        estimates_of(
            coarse_scene({**WATER, "operation.inlet_temperature": "500 degC", "operation.outlet_pressure": "300 bar"})
        )


def test_insulation_with_a_table_of_its_conductivity_has_cells_for_it():
    """Mineral wool behind a heated skin, whose conductivity doubles through it: heat stored as on 12 cells; one is 0.3 % off."""
    hot = {
        "operation.pressure_drop": 0.0,
        "operation.outer_coefficient": 30.0,
        "operation.ambient_temperature": 293.15,
        "operation.initial_temperature": 293.15,
        "operation.inlet_temperature": 900.0,
        "operation.end_time": 40000.0,
        "model.turbulence": "none",
        "model.flow": "plug",
    }
    stored = {}
    for cells in (None, 1, 12):
        tables = coarse_scene(hot).as_tables()
        tables["solver"].pop("wall_cells", None)
        wool = {"name": "wool", "material": "mineral_wool", "thickness": 0.02} | ({"cells": cells} if cells else {})
        skin = {"name": "skin", "material": "carbon_steel", "thickness": 5e-3, "heat_source": 4e5}
        result = run(Scene(tables | {"wall": {"layer": [skin, wool]}}), communicator=MPI.COMM_SELF)
        stored[cells] = result["heat_stored"][-1]
    assert stored[None] == pytest.approx(stored[12], rel=1e-3)
    assert abs(stored[1] / stored[12] - 1.0) > 2e-3


def test_fast_beads_do_not_hold_the_steps_back():
    path = STUDIES / "beds" / "moving_bed.toml"
    slow, fast = (estimates_of(coarse_scene(path, {"operation.bead_velocity": v})) for v in (5e-3, 0.5))
    assert 0.1 * slow.bead_residence_time < slow.largest_step <= 0.25 * slow.bead_residence_time
    assert 5.0 * 0.25 * fast.bead_residence_time < fast.largest_step < slow.largest_step


def test_a_front_wider_than_the_bed_does_not_lengthen_the_steps():
    """Beads that conduct well spread it over the whole bed, which is then heated as one: its steps have to follow that."""
    conducting = {"bed.bead_conductivity": 80.0, "operation.pressure_drop": 50.0, "model.turbulence": "none"}
    estimates = estimates_of(coarse_scene(conducting))
    assert estimates.front_width > estimates.length
    assert estimates.heating_duration > 10.0 * estimates.largest_step

    def heating_time(steps):
        settings = {"model.flow": "developed", "solver.mesh_refinement": 0.4, "solver.step_refinement": steps}
        simulation = Simulation(specs_of(coarse_scene(conducting | settings)), MPI.COMM_SELF)
        return simulation.integrate().recorder.heating_time

    assert heating_time(1.0) == pytest.approx(heating_time(4.0), rel=2e-3)


UNIFORM = {
    "model.flow": "plug",
    "model.turbulence": "none",
    "model.wall": "insulated",
    "bed.porosity_model": "constant",
}


@pytest.mark.parametrize(
    ("setting", "value"),
    [
        ("model.flow", "developed"),
        ("model.wall", "conjugate"),
        ("bed.porosity_model", "hunt-tien"),
    ],
)
def test_a_bed_is_uniform_across_where_nothing_in_it_depends_on_the_wall(setting, value):
    scene = Scene.load(STUDIES / "mold" / "aluminium.toml", UNIFORM)
    assert estimates_of(scene).uniform_across and not estimates_of(scene.changed({setting: value})).uniform_across


def test_conduction_that_depends_on_the_wall_makes_a_bed_not_uniform(tmp_path):
    profile = tmp_path / "conductivity.csv"
    profile.write_text("wall_distance [mm],conductivity [W/(m*K)]\n0,0.2\n3,0.8\n")
    scene = Scene.load(STUDIES / "mold" / "aluminium.toml", UNIFORM)
    assert not estimates_of(scene.changed({"bed.conductivity_profile": str(profile)})).uniform_across


def test_a_uniform_bed_has_the_answer_of_one_with_cells_at_its_wall():
    """The exact problem has one dimension: a fifth of the unknowns, and the same temperatures (on coarse cells along the flow its
    streamline diffusion differs a little between thin cells and thick ones)."""
    fine = {"operation.end_time": "5 min", "solver.axial_refinement": 4.0, "solver.keep_bounds": False}
    scene = Scene.load(STUDIES / "mold" / "aluminium.toml", UNIFORM | fine)
    few, many = (run(scene.changed({"solver.first_cell": first})) for first in (None, 5e-5))
    assert few.summary["unknowns"]["energy"] < 0.25 * many.summary["unknowns"]["energy"]
    for name in ("outlet_temperature", "temperature_centre_L/2", "temperature_bed_side_L/4"):
        assert few[name][-1] == pytest.approx(many[name][-1], abs=0.005)


def test_only_a_fluid_that_flows_far_more_easily_than_what_it_displaces_is_unstable():
    """Hot oil into cold oil, by the ratio of viscosities where drag is viscous; nothing of the kind in plug flow, backwards, in a
    gas or in water, where inertia counts."""
    oil = {"fluid.material": "thermal_oil", "operation.initial_temperature": "10 degC", "model.turbulence": "none"}
    slow = oil | {"operation.inlet_temperature": "100 degC", "operation.pressure_drop": 1.0}
    viscosity = specs_of(coarse_scene(slow)).laws.fluid.viscosity
    ratio = viscosity(283.15) / viscosity(373.15)
    assert estimates_of(coarse_scene(slow)).resistance_ratio == pytest.approx(ratio, rel=0.1)
    assert estimates_of(coarse_scene(slow | {"operation.pressure_drop": 5e4})).resistance_ratio < 0.9 * ratio
    back = {"operation.initial_temperature": "100 degC", "operation.inlet_temperature": "10 degC"}
    for stable in (slow | {"model.flow": "plug"}, slow | back):
        assert estimates_of(coarse_scene(stable)).resistance_ratio == 1.0
    assert estimates_of(coarse_scene(WATER)).resistance_ratio < 2.0
    assert estimates_of(coarse_scene()).resistance_ratio == 1.0
