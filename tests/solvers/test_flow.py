"""The steady flow: found from any start, however it is driven, on the side that a stated rule names."""

import numpy as np
import pytest
from mpi4py import MPI

from porousmold import InputError, Scene, SolveError, run
from porousmold.simulation import time_integration
from porousmold.simulation.initial_guess import NEAR
from porousmold.simulation.regimes import is_also_laminar
from porousmold.simulation.specs import specs_of
from porousmold.solvers import steady

from ..support import ALUMINIUM, PIPE, coarse_scene, problem_of

CELLS = {"solver.axial_cells": 9, "solver.cell_growth": 1.4}
DRIVES = {
    "pressure drop": {},
    "mass flow": {"operation.pressure_drop": None, "operation.mass_flow": 0.0395},
    "velocity": {"operation.pressure_drop": None, "operation.inlet_velocity": 1.5},
}


def started(*given):
    """Discretisation of a shipped scene with changes, its flow found."""
    problem = problem_of(coarse_scene(CELLS, *given))
    problem.flow.start()
    return problem


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("turbulence", ["k-epsilon", "damped-nakayama-kuwahara"])
def test_found_however_it_is_driven_without_undershoots(drive, turbulence):
    """k is nowhere clearly negative, at the inlet's nodes neither, and what comes in goes out."""
    problem = started({"model.turbulence": turbulence, **DRIVES[drive]})
    energy = problem.flow.fields()["turbulent_kinetic_energy"].x.array
    assert problem.flow.is_turbulent()
    assert energy.min() > -5e-3 * energy.max()
    assert abs(problem.balances.mass_imbalance) < 1e-8


@pytest.mark.parametrize(
    "path, changes",
    [
        (ALUMINIUM, {"operation.pressure_drop": 3e4}),
        (ALUMINIUM, {"geometry.cavity_height": 0.08, "bed.bead_diameter": 0.008}),
        (ALUMINIUM, {"geometry.length": 0.1, "operation.pressure_drop": 2e4}),
        (ALUMINIUM, {"bed.porosity_model": "vortmeyer-schuster"}),
        (PIPE, {"bed.bead_diameter": 0.01}),
    ],
)
@pytest.mark.parametrize("kind", ["full", "developed"])
def test_found_where_bead_sources_fade_out_in_the_bulk(path, changes, kind):
    """Scenes whose flow was not found once, within few iterations."""
    problem = started(path, {"model.flow": kind, **changes})
    assert problem.flow.counts.newton_iterations < 60


def test_a_coarser_mesh_needs_no_more_iterations():
    iterations = [
        started({"solver.mesh_refinement": size, "model.flow": "developed"}).flow.counts.newton_iterations
        for size in (1.0, 3.0)
    ]
    assert iterations[0] <= iterations[1] + 5


def test_the_published_form_of_the_wall_layer_is_reached():
    """By Newton's method or along ever narrower blends; its mass flow is that of the wide blend within 1 %."""
    changes = {"model.blend_half_width": 20.0, "model.longest_eddy": 1e6}
    published, ours = started(changes), started()
    assert published.balances.mass_flow == pytest.approx(ours.balances.mass_flow, rel=0.01)
    model = published.medium.equations.model
    assert float(model.blend_half_width.value) == 20.0
    assert published.flow._find_by_continuation(0.0)  # the long way leads to the same flow
    assert published.balances.mass_flow == pytest.approx(ours.balances.mass_flow, rel=0.01)
    assert float(model.blend_half_width.value) == 20.0


@pytest.mark.parametrize("kind", ["full", "developed"])
def test_of_two_steady_flows_the_turbulent_one_is_taken_and_told(kind):
    """Plain k-epsilon at 8 kPa has both, whatever mesh and flow; the summary and a warning say so."""
    result = run(
        coarse_scene({"model.turbulence": "k-epsilon", "model.flow": kind, "operation.end_time": 5.0, **CELLS}),
        communicator=MPI.COMM_SELF,
    )
    assert result.summary["flow_regimes"] == ["turbulent", "laminar"]
    assert any("laminar flow is steady, too" in warning for warning in result.summary["warnings"])


def test_a_slow_flow_is_laminar_alone():
    changes = {"model.turbulence": "k-epsilon", "operation.pressure_drop": 100.0, "operation.end_time": 5.0}
    summary = run(coarse_scene(CELLS, changes), communicator=MPI.COMM_SELF).summary
    assert summary["flow_regimes"] == ["laminar"]


def test_the_laminar_flow_beside_a_turbulent_one_leaves_it_as_it_is():
    problem = started({"model.turbulence": "k-epsilon", "model.flow": "developed"})
    before = problem.flow.solution.arrays()
    assert is_also_laminar(problem)
    for now, then in zip(problem.flow.solution.arrays().values(), before.values(), strict=True):
        assert np.array_equal(now, then)


def test_the_inlets_mean_static_pressure_is_the_one_given():
    """Of a short bed whose flow has a dynamic pressure of several per cent of it."""
    problem = started({"geometry.length": 0.1, "operation.pressure_drop": 2e4, "model.turbulence": "none"})
    assert problem.balances.pressure_drop == pytest.approx(2e4, rel=5e-3)
    velocity = problem.flow.fields()["velocity"].x.array
    assert 0.5 * np.max(velocity**2) > 0.01 * 2e4


def test_switched_off_and_on_needs_no_false_transient_of_its_own(tmp_path):
    """After a jump the flow starts from the initial guess for the new drive."""
    series = tmp_path / "switched.csv"
    series.write_text("time [s], dp [kPa]\n0, 8\n20, 8\n20.5, 0\n40, 0\n40.5, 8\n4000, 8\n")
    scene = coarse_scene({"operation.pressure_drop": str(series), "operation.end_time": 60.0, **CELLS})
    summary = run(scene, communicator=MPI.COMM_SELF).summary
    assert summary["rejected_steps"] == 0 and summary["newton_iterations"]["flow"] < 300


def test_a_regime_that_sets_in_later_is_noted(tmp_path):
    series = tmp_path / "late.csv"
    series.write_text("time [s], dp [kPa]\n0, 0\n20, 0\n20.5, 8\n4000, 8\n")
    changes = {"operation.pressure_drop": str(series), "operation.end_time": 40.0, "model.flow": "developed", **CELLS}
    summary = run(coarse_scene(changes), communicator=MPI.COMM_SELF).summary
    assert summary["flow_regimes"] == ["laminar", "turbulent"]
    assert not any("laminar flow is steady" in warning for warning in summary["warnings"])


def test_a_recorded_mass_flow_fed_back_gives_the_same_heating_time(tmp_path):
    """Which it does where the flow recorded at a time is that of the time."""
    # on fewer cells the bounds' monotone cells, which last for a number of steps, would differ between both
    scene = coarse_scene({"model.turbulence": "none", "model.flow": "developed", **CELLS, "solver.axial_cells": 18})
    first = run(scene, communicator=MPI.COMM_SELF)
    rows = zip(first.history["time"], first.history["mass_flow"], strict=True)
    series = tmp_path / "mass_flow.csv"
    series.write_text("time [s], m [kg/s]\n" + "".join(f"{float(t)!r}, {float(m)!r}\n" for t, m in rows))
    again = run(
        scene.changed({"operation.pressure_drop": None, "operation.mass_flow": str(series)}), communicator=MPI.COMM_SELF
    )
    assert again.heating_time == pytest.approx(first.heating_time, rel=1e-3)


def test_what_is_left_in_a_few_nodes_does_not_grow_from_step_to_step():
    """Saw teeth of the velocity across a pipe of ten beads, in which turbulence begins in cell after cell: no flow was found in 3
    time steps, and took 658 iterations."""
    tables = {
        "geometry": {"kind": "pipe", "length": 0.4, "diameter": 0.06},
        "bed": {"bead_diameter": 0.006, "bead_material": "alumina"},
        "wall": {"material": "steel", "thickness": 0.002},
        "operation": {
            "initial_temperature": 293.15,
            "inlet_temperature": 423.15,
            "mass_flow": 0.01,
            "outer_heat_flux": 500.0,
        },
        "solver": {"refine_in_doubt": False},
    }
    summary = run(Scene({**tables, "output": {"pictures": False, "fields": False}}), communicator=MPI.COMM_SELF).summary
    assert summary["rejected_steps"] == 0
    assert summary["newton_iterations"]["flow"] < 560


def test_what_cannot_be_found_fails_soon_and_finer_cells_are_tried(monkeypatch):
    """The run tries finer cells by itself, and ends with the failure where they do not help either."""
    meshes = []
    original = time_integration.Simulation.__init__

    def noted(self, specs, *arguments):
        meshes.append(specs.mesh.cells.refinement)
        original(self, specs, *arguments)

    monkeypatch.setattr(time_integration.Simulation, "__init__", noted)
    monkeypatch.setattr(steady.SteadySolver, "_converged", lambda self, update, last: False)
    monkeypatch.setattr(steady.SteadySolver.find, "__defaults__", (0.0, steady.FAST._replace(most_steps=5)))
    with pytest.raises(SolveError, match="flow"):
        run(coarse_scene({"model.flow": "developed", **CELLS}), communicator=MPI.COMM_SELF)
    assert meshes == [1.0, 1.5]


def test_a_mesh_beyond_the_memory_is_refused_before_it_is_built():
    scene = coarse_scene(CELLS | {"solver.axial_cells": 100000, "solver.cell_growth": 1.01})
    with pytest.raises(InputError, match="GiB of memory"):
        problem_of(scene, MPI.COMM_SELF)


def test_a_guess_of_another_flow_is_near_it_in_fewer_iterations():
    flows = [problem_of(coarse_scene(CELLS, {"model.flow": "developed"})).flow for _ in range(2)]
    flows[0].start()
    flows[1].start(near=NEAR)
    speeds = [flow.fields()["velocity"].x.array for flow in flows]
    assert flows[1].counts.newton_iterations < flows[0].counts.newton_iterations
    assert 0.0 < np.linalg.norm(speeds[1] - speeds[0]) < NEAR * np.linalg.norm(speeds[0])


@pytest.mark.parametrize("flow", ["developed", "plug"])
@pytest.mark.parametrize("expansion", [3.0, 10.5])
def test_the_mass_flow_of_a_gas_that_expands_is_exact_on_few_cells(expansion, flow):
    """Creeping isothermal flow is as p dp/dx, that at a mean pressure p by the same drop times p over the outlet's."""
    outlet = 2e4
    creeping = {
        "bed.bead_diameter": 2e-5,
        "model.flow": flow,
        "model.turbulence": "none",
        "operation.outlet_pressure": outlet,
    }
    weak = started({**creeping, "operation.pressure_drop": 1.0}).balances.mass_flow
    problem = started({**creeping, "operation.pressure_drop": (expansion - 1.0) * outlet})
    exact = weak * (expansion - 1.0) * outlet * 0.5 * (1.0 + expansion) / (1.0 + 0.5 / outlet)
    assert problem.balances.mass_flow == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("flow", ["developed", "full"])
def test_a_turbulent_gas_that_expands_sevenfold_is_found(flow):
    """No start found it from a pressure that falls evenly along the bed: that of a gas falls at its outlet."""
    strong = {"bed.bead_diameter": 5e-4, "geometry.cavity_height": 0.04, "operation.pressure_drop": 6.5e5}
    problem = started({**strong, "model.flow": flow})
    plug = started({**strong, "model.flow": "plug"})
    assert problem.balances.mass_flow == pytest.approx(plug.balances.mass_flow, rel=0.05)


@pytest.mark.parametrize("drive", ["pressure_drop", "mass_flow", "inlet_velocity"])
def test_a_gas_that_expands_along_the_bed_is_followed_by_newtons_method(drive):
    """Its density follows the pressure, here 2.4 bar at the inlet, within each iteration: updates fall quadratically, not by a
    constant factor, and the same flow is found however it is driven (on a mesh of 12 or 13 cells along)."""
    fine = {
        "bed.bead_diameter": 1e-3,
        "geometry.cavity_height": 0.02,
        "model.flow": "developed",
        "model.turbulence": "none",
    }
    by_pressure = {**fine, "operation.pressure_drop": 1.4e5}
    expected = started(by_pressure).balances.mass_flow
    density = specs_of(coarse_scene(by_pressure)).laws.fluid.density(101325.0 + 1.4e5, 363.15)
    drives = {"pressure_drop": 1.4e5, "mass_flow": expected, "inlet_velocity": expected / (0.01 * density)}
    problem = started({**fine, "operation.pressure_drop": None, f"operation.{drive}": drives[drive]})
    assert problem.balances.mass_flow == pytest.approx(expected, rel=3e-4)
    problem.medium.flow_temperature.x.array[:] *= 1.05
    solver, updates = problem.flow.solver, []
    for _ in range(5):
        solver.system.renew_jacobian()
        updates.append(solver.counted_iteration())
    assert updates[0] > 1e-3 and updates[4] < 1e-9


@pytest.mark.parametrize("mass_flow", [0.002, 0.02])
def test_a_liquid_that_rises_by_a_given_mass_flow_is_found(mass_flow):
    """The developed flow began with the drag's pressure drop alone, a hundredth of the water's weight, and was not found; full
    flow starts from that. Both have the same pressure drop, as the flow is developed but for the entrance."""
    changes = {
        "fluid.material": "water",
        "geometry.diameter": 0.06,
        "geometry.length": 1.0,
        "bed.bead_diameter": 0.004,
        "operation.pressure_drop": None,
        "operation.mass_flow": mass_flow,
        "operation.gravity": -9.81,
        "operation.initial_temperature": 293.15,
        "operation.inlet_temperature": 293.15,
        "operation.wall_temperature": 353.15,
        "model.wall": "fixed-temperature",
        "model.turbulence": "none",
    }
    scene, drops = Scene.load(PIPE, {"wall.thickness": None, "wall.material": None, **changes}), {}
    for flow in ("developed", "full"):
        problem = problem_of(scene.changed({"model.flow": flow}))
        problem.flow.start()
        drops[flow] = problem.balances.pressure_drop
        assert problem.balances.mass_flow == pytest.approx(mass_flow, rel=1e-6)
    assert drops["developed"] > 9.81 * 995.0 and drops["developed"] == pytest.approx(drops["full"], rel=1e-3)
