"""Only what a scene needs: every choice removes unknowns and terms, and meets the fuller model in its limit."""

import numpy as np
import pytest
from mpi4py import MPI

from porousmold import InputError, SolveError, run
from porousmold.mesh.point_values import nodal_values
from porousmold.scene.scene import Scene
from porousmold.solvers import transport

from .support import ALUMINIUM, FRP, PIPE, coarse_scene, problem_of, simulation_of

ENERGIES = ("one-temperature", "two-temperature")
FINE = {"solver.cell_growth": 1.33, "solver.largest_step": None}


def integrated(*given):
    """A coarse scene, laminar (seconds), after its integration."""
    return simulation_of(coarse_scene({"model.turbulence": "none", "solver.axial_cells": 18}, *given)).integrate()


@pytest.fixture(scope="module")
def full():
    """The coarse mold with everything on."""
    return integrated()


def test_thin_aluminium_skin_is_the_resolved_one(monkeypatch):
    """Bi = h t / lambda = 0.001: no gradient through 3 mm of aluminium. Its cells are gone."""
    monkeypatch.setattr(transport, "OVERSHOOT", float("inf"))  # monotone cells differ from run to run
    full, thin = integrated(), integrated({"model.wall": "thin"})
    assert thin.recorder.heating_time == pytest.approx(full.recorder.heating_time, rel=3e-4)
    assert thin.problem.heat.unknowns < full.problem.heat.unknowns
    assert not thin.problem.domain.has_wall
    assert abs(thin.problem.heat.balance.imbalance) < 1e-4


def test_thin_wall_stores_what_a_resolved_one_does():
    """A pipe's ring and its outer surface: heat balances of both models to 1 % over a wall that hardly conducts."""
    changes = {
        "wall.conductivity": 400.0,
        "operation.outer_coefficient": 5.0,
        "operation.ambient_temperature": 296.15,
        "operation.heating_margin": 6.0,
    }
    resolved, thin = integrated(PIPE, changes), integrated(PIPE, {"model.wall": "thin", **changes})
    for name in ("stored", "through_outer_wall", "by_fluid"):
        assert getattr(thin.problem.heat.balance, name) == pytest.approx(
            getattr(resolved.problem.heat.balance, name), rel=2e-3
        )
    assert thin.recorder.heating_time == pytest.approx(resolved.recorder.heating_time, rel=2e-3)


def test_thin_polymer_skin_heats_too_soon():
    """Without the gradient through 3 mm of polymer the outer surface is ahead: the error of the choice, of a few percent."""
    assert (
        0.94
        < integrated(FRP, {"model.wall": "thin"}).recorder.heating_time / integrated(FRP).recorder.heating_time
        < 0.99
    )


def test_insulated_bed_has_no_wall_to_heat(full):
    bed = integrated({"model.wall": "insulated"})
    assert bed.recorder.heating_time < 0.8 * full.recorder.heating_time
    assert bed.problem.heat.balance.stored < full.problem.heat.balance.stored
    assert [list(m.specs.laws.materials(m.problem.has_wall)) for m in (bed, full)] == [
        ["fluid", "beads"],
        ["fluid", "beads", "wall"],
    ]
    thin_air = integrated({"model.wall": "thin", "wall.density": 1e-3, "wall.conductivity": 1e-3})
    assert bed.recorder.heating_time == pytest.approx(thin_air.recorder.heating_time, rel=2e-3)


def test_one_temperature_halves_the_unknowns(full):
    one = integrated({"model.energy": "one-temperature"})
    assert one.problem.heat.unknowns < 0.6 * full.problem.heat.unknowns
    assert abs(one.problem.heat.balance.imbalance) < 1e-4
    # beads that lag behind the fluid smear the front that the wall waits for: without eddies by a fifth, on resolved walls
    times = [integrated({"model.energy": energy, **FINE}).recorder.heating_time for energy in ENERGIES]
    assert times[0] / times[1] == pytest.approx(0.80, abs=0.01)


def test_a_core_below_the_threshold_is_the_same_in_full_and_developed_flow():
    """Of the cold pipe, Re_s = 600 in the core: with sources that are damped alone its eddies are those of its history."""
    ratios = {}
    for turbulence in ("damped-nakayama-kuwahara", "decaying-nakayama-kuwahara"):
        for flow in ("developed", "full"):
            problem = problem_of(Scene.load(PIPE, {"model.flow": flow, "model.turbulence": turbulence}))
            problem.flow.start()
            space = problem.medium.flow_temperature.function_space
            momentum = problem.medium.equations.momentum(problem.flow.state, problem.medium.flow_temperature)
            values = nodal_values(momentum.turbulence.eddy_viscosity / momentum.viscosity, space)
            place = space.tabulate_dof_coordinates()
            axis = np.isclose(place[:, 1], 0.0) & (place[:, 0] > 0.3) & (place[:, 0] < 0.6)
            in_bed = place[:, 1] < problem.medium.size.half_height
            ratios[turbulence, flow] = float(np.max(values[axis])), float(np.max(values[in_bed & (place[:, 0] > 0.3)]))
    assert ratios["damped-nakayama-kuwahara", "developed"][0] > 1.5 * ratios["damped-nakayama-kuwahara", "full"][0]
    developed, full = (ratios["decaying-nakayama-kuwahara", flow] for flow in ("developed", "full"))
    assert developed[0] < 0.05 and full[0] < 0.05
    assert full[1] == pytest.approx(developed[1], rel=0.03)


def test_fast_exchange_is_one_temperature():
    """The limit of local thermal equilibrium, a slow one: what is left at 1e4 times the exchange is halved at 1e5, 0.4 % then."""
    one = integrated({"model.energy": "one-temperature", **FINE}).recorder.heating_time
    times = [integrated({"model.exchange_factor": factor, **FINE}).recorder.heating_time for factor in (1e4, 1e5)]
    assert abs(times[1] - one) < 0.5 * abs(times[0] - one)
    assert times[1] == pytest.approx(one, rel=0.004)


def test_beads_with_an_inside():
    """Beads that conduct badly heat late, the wall behind them too; no unknown is added, and no heat is lost."""
    poor = {"bed.bead_conductivity": 0.2}
    lumped, resistance, resolved = (integrated({"model.bead_modes": modes, **poor}) for modes in (None, 0, 4))
    assert resolved.recorder.heating_time == pytest.approx(resistance.recorder.heating_time, rel=5e-4)
    assert 1.02 < resolved.recorder.heating_time / lumped.recorder.heating_time < 1.05
    assert resolved.problem.unknowns == lumped.problem.unknowns
    assert abs(resolved.problem.heat.balance.imbalance) < 1e-4
    assert 5.0 < max(resolved.recorder.history["largest_bead_difference"]) < 65.0
    assert min(resolved.recorder.history["lowest_temperature"]) > 298.15 - 0.1
    assert max(resolved.recorder.history["highest_temperature"]) < 363.15 + 0.1


def test_a_repeated_step_begins_where_the_first_attempt_did():
    """Bounds that nothing can keep take a step through all its ways; from there, and from the start again, the same ends."""
    changes = {"model.flow": "plug", "model.bead_modes": 2, "operation.end_time": 200.0, "solver.axial_cells": 10}
    heat = (simulation := integrated(changes)).problem.heat
    start = simulation.problem.state.copy()
    ends, errors = [], []
    for bounds in ((300.0, 350.0), (-1e9, 1e9)) * 2:
        simulation.problem.state.put_back(start)
        before = heat.repetitions
        errors.append(heat.step(simulation.time, 40.0, bounds=lambda bounds=bounds: bounds))
        ends.append(list(heat.solution.arrays().values()))
        assert (heat.repetitions > before + 1) == (bounds[0] > 0.0)
    assert errors[:2] == errors[2:]
    assert (errors[0].order, errors[1].order) == (2, 3) and errors[0].temperature > errors[1].temperature
    for one, other in zip(ends[:2], ends[2:], strict=True):
        for a, b in zip(one, other, strict=True):
            assert np.array_equal(a, b)


def test_beads_that_conduct_well_are_isothermal(monkeypatch):
    monkeypatch.setattr(transport, "OVERSHOOT", float("inf"))  # monotone cells differ from run to run
    conducting = {"bed.bead_conductivity": 2000.0}
    lumped, resolved = (
        integrated({"model.bead_modes": modes, **conducting}).recorder.heating_time for modes in (None, 1)
    )
    assert resolved == pytest.approx(lumped, rel=1e-5)
    assert resolved != lumped


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"model.wall": "paper"}, "conjugate"),
        ({"model.wall": "insulated", "operation.outer_heat_flux": 5.0}, "outer_heat_flux"),
        ({"model.energy": "three-temperature"}, "one-temperature"),
        ({"model.exchange_factor": 0.0}, "exchange_factor"),
        ({"model.bead_modes": 1, "model.energy": "one-temperature"}, "bead_modes"),
        ({"model.bead_modes": 1, "model.flow_update": "transient"}, "bead_modes"),
    ],
)
def test_choices_that_cannot_be_are_refused(changes, word):
    with pytest.raises(InputError, match=word):
        coarse_scene(changes)


def test_choices_stand_in_the_result():
    summary = run(coarse_scene({"model.energy": "one-temperature", "model.wall": "thin", "model.turbulence": "none"}),
                  communicator=MPI.COMM_SELF).summary  # fmt: skip
    assert summary["model"]["energy"] == "one-temperature" and summary["model"]["wall"] == "thin"
    assert set(summary["unknowns"]) == {"flow", "energy"}


def test_developed_flow_is_the_full_one_without_its_entrance():
    """Far fewer unknowns, the same heating time to half a percent; the mass flow is one at all stations."""
    full, developed = (integrated({"model.flow": flow}) for flow in ("full", "developed"))
    assert developed.problem.flow.unknowns < 0.4 * full.problem.flow.unknowns
    assert developed.recorder.heating_time == pytest.approx(full.recorder.heating_time, rel=5e-3)
    assert abs(developed.problem.balances.mass_imbalance) < 1e-9
    assert developed.problem.balances.mass_flow == pytest.approx(full.problem.balances.mass_flow, rel=5e-3)


def test_developed_flow_is_found_where_turbulence_dies_in_the_middle_of_the_bed():
    """A damped model at a bead Reynolds number below 800: a long false transient, at whose end the forces have to follow."""
    flows = []
    for flow in ("full", "developed"):
        scene = Scene.load(
            ALUMINIUM, {"geometry.cavity_height": "70 mm", "bed.bead_diameter": "7 mm", "model.flow": flow}
        )
        problem = simulation_of(scene, MPI.COMM_SELF).problem
        problem.flow.start()
        flows.append(problem.balances.mass_flow)
    assert flows[1] == pytest.approx(flows[0], rel=2e-3)


@pytest.mark.parametrize("path", [ALUMINIUM, PIPE], ids=["mold", "pipe"])
def test_plug_flow_has_no_unknowns_and_misses_the_fast_layer_at_the_wall(path):
    plug, developed = (integrated(path, {"model.flow": flow}) for flow in ("plug", "developed"))
    assert plug.problem.flow.unknowns == 0
    assert plug.recorder.heating_time > 1.1 * developed.recorder.heating_time
    assert abs(plug.problem.heat.balance.imbalance) < 1e-4


def test_plug_flow_takes_the_drag_of_the_bulk():
    """Macdonald's law at the bulk's porosity, at the mean density: the mass flow by hand."""
    simulation = integrated({"model.flow": "plug", "bed.porosity_model": "constant", "operation.end_time": 1.0})
    problem, specs = simulation.problem, simulation.specs
    phi, d, temperature = 0.4, specs.mesh.bead_diameter, 298.15
    laws = problem.specs.laws
    viscosity = laws.fluid.viscosity(temperature)
    density = laws.fluid.density(101325.0 + 4000.0, temperature)
    flux = simulation.recorder.history["mass_flow"][0] / specs.mesh.size.half_height
    gradient = laws.drag.coefficient(phi, d, density, viscosity, flux / (phi * density)) * flux / (phi**2 * density)
    assert gradient * specs.mesh.size.length == pytest.approx(8000.0, rel=2e-3)


@pytest.mark.parametrize("flow", ["developed", "plug"])
@pytest.mark.parametrize(
    ("drive", "value", "bead_diameter"),
    [("inlet_velocity", 1.2, 5e-3), ("mass_flow", 0.03, 5e-3), ("inlet_velocity", 1.2, 1e-3)],
    ids=["velocity", "mass flow", "velocity, the inlet at 2 bar"],
)
def test_simpler_flows_meet_what_drives_them(flow, drive, value, bead_diameter):
    changes = {"model.flow": flow, "model.turbulence": "none", "operation.end_time": 5.0}
    tables = coarse_scene({**changes, "bed.bead_diameter": bead_diameter}).as_tables()
    del tables["operation"]["pressure_drop"]
    tables["operation"][drive] = value
    simulation = simulation_of(Scene(tables), MPI.COMM_SELF).integrate()
    inlet = float(simulation.problem.flow.pressure.x.array.max()) + 101325.0
    expected = {"mass_flow": value, "inlet_velocity": value * 0.025 * inlet / (287.055 * 363.15)}[drive]
    assert simulation.problem.balances.mass_flow == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"operation.pressure_drop": 1.0, "operation.gravity": -9.81}, "runs backwards"),
        ({"operation.pressure_drop": None, "operation.inlet_velocity": 5.0}, "no mass flow"),
    ],
    ids=["against gravity", "faster than any mass flow enters"],
)
def test_a_plug_flow_that_there_is_none_of_is_told(changes, reason):
    given = {"model.flow": "plug", "model.turbulence": "none", "operation.end_time": 5.0, **changes}
    with pytest.raises(SolveError, match=reason):
        simulation_of(coarse_scene(given), MPI.COMM_SELF).integrate()


def test_wall_of_fixed_temperature_stays_there_and_takes_the_heat():
    simulation = integrated(
        {"model.wall": "fixed-temperature", "operation.wall_temperature": 310.0, "operation.end_time": 200.0}
    )
    low, high = simulation.problem.places.extremes("bed_side")
    assert low == pytest.approx(310.0, abs=0.05) and high == pytest.approx(310.0, abs=0.05)
    balance = simulation.problem.heat.balance
    assert balance.through_outer_wall < 0.0 and abs(balance.imbalance) < 1e-3
    assert simulation.recorder.heating_time is None
    with pytest.raises(InputError, match="wall_temperature"):
        coarse_scene({"model.wall": "fixed-temperature"})


def test_coupled_transient_shows_that_the_flow_is_quasi_steady():
    """Air crosses the mold in 0.2 s: every time derivative of the flow together moves the heating time by < 0.05 %."""
    coupled = integrated({"model.flow_update": "transient"})
    quasi_steady = integrated()
    assert coupled.problem.heat.unknowns > quasi_steady.problem.flow.unknowns
    assert coupled.recorder.heating_time == pytest.approx(quasi_steady.recorder.heating_time, rel=5e-4)
    assert abs(coupled.problem.heat.balance.imbalance) < 1e-3


def test_coupled_transient_balances_a_liquid_whose_density_changes():
    """What the bed no longer holds leaves with its heat: 8 % of that of water, heated by 65 K."""
    water = {"fluid.material": "water", "operation.pressure_drop": 500.0, "model.turbulence": "none"}
    coupled = integrated({**water, "model.flow_update": "transient"})
    assert coupled.recorder.heating_time is not None and abs(coupled.problem.heat.balance.imbalance) < 1e-3


WATER = {
    "fluid.density": 997.0,
    "fluid.viscosity": 6e-4,
    "fluid.heat_capacity": 4180.0,
    "fluid.conductivity": 0.63,
    "operation.pressure_drop": 500.0,
    "operation.end_time": 30.0,
}


@pytest.mark.parametrize(
    "hard",
    [{}, WATER, {"bed.bead_conductivity": 0.1}, {"bed.bead_diameter": 1e-3}],
    ids=["air", "water", "poor", "fine"],
)
def test_monotone_cells_keep_the_bounds(hard):
    """A cold start on 9 cells a metre: second order leaves the bounds by kelvins, the marked cells by less than 0.1 K."""
    coarse = {"solver.axial_cells": 9, "solver.cell_growth": 1.3, "solver.largest_step": 60.0}
    simulation = integrated(coarse | {"operation.end_time": 400.0} | hard)
    assert simulation.problem.heat.repetitions > 0
    assert min(simulation.recorder.history["lowest_temperature"]) > 298.15 - 0.1
    assert max(simulation.recorder.history["highest_temperature"]) < 363.15 + 0.1
