"""Default steps and cells where heat does not come with the flow: exact solutions, and what a run waits for."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp, trapezoid
from scipy.optimize import brentq
from scipy.special import j0, jn_zeros

from porousmold import InputError, Scene, run
from porousmold.simulation.step_rules import STEP_ERROR
from studies.exact_solutions import schumann

from ..support import RESIN, STUDIES, coarse_scene, cured_mold

CONDUCTIVITY, CAPACITY, HALF = 0.4 * 0.05 + 0.6 * 0.8, 0.6 * 2000.0 * 800.0, 0.025
"""Of the bed at rest, per total volume, and its half height or radius, m."""


COLD, HOT = 300.0, 360.0


def bed_at_rest(settings, kind="mold"):
    """A bed of constant properties without flow, at 300 K, with settings."""
    tables = tables_of_bed(kind) | {"wall": {"material": "aluminium", "thickness": 1e-4}}
    for full_name, value in settings.items():
        table, key = full_name.split(".")
        tables.setdefault(table, {})[key] = value
    return Scene(tables)


def tables_of_bed(kind="mold"):
    width = "cavity_height" if kind == "mold" else "diameter"
    return {
        "geometry": {"kind": kind, "length": 0.5, width: 2.0 * HALF},
        "bed": {
            **{"bead_diameter": 0.004, "bead_density": 2000.0, "bead_heat_capacity": 800.0},
            **{"bead_conductivity": 0.8, "porosity_model": "constant", "bulk_porosity": 0.4},
        },
        "fluid": {"density": 1.0, "viscosity": 2e-5, "heat_capacity": 1000.0, "conductivity": 0.05},
        "operation": {"initial_temperature": COLD, "inlet_temperature": COLD, "pressure_drop": 0.0},
        "model": {"flow": "developed", "turbulence": "none", "energy": "one-temperature"},
    }


def heated_part(temperature):
    return (temperature - COLD) / (HOT - COLD)


@pytest.mark.parametrize("kind", ["mold", "pipe"])
@pytest.mark.parametrize("fourier_number", [0.1, 0.3, 1.0])
def test_a_bed_heated_from_its_wall(kind, fourier_number):
    """The middle of a plane wall, or of a cylinder, whose surface is held (Carslaw, Jaeger, sections 3.3 and 7.6)."""
    end = fourier_number * CAPACITY * HALF**2 / CONDUCTIVITY
    given = {"model.wall": "fixed-temperature", "operation.wall_temperature": HOT, "operation.end_time": end}
    middle = run(bed_at_rest(given, kind))["lowest_bed"][-1]
    if kind == "mold":
        odd = np.arange(1, 200, 2) * np.pi / 2.0
        rest = np.sum(2.0 * np.sin(odd) / odd * np.exp(-(odd**2) * fourier_number))
    else:
        roots = jn_zeros(0, 100)
        derivative = -(j0(roots + 1e-6) - j0(roots - 1e-6)) / 2e-6
        rest = np.sum(2.0 / (roots * derivative) * np.exp(-(roots**2) * fourier_number))
    assert heated_part(middle) == pytest.approx(1.0 - rest, abs=3e-3)


@pytest.mark.parametrize("biot_number", [0.2, 2.0])
def test_a_bed_in_an_oven(biot_number):
    """A plane wall behind a film, seen through a wall that stores nothing: time to within 2 K, to 0.3 %."""
    film = biot_number * CONDUCTIVITY / HALF
    given = {
        **{"operation.outer_coefficient": film, "operation.ambient_temperature": HOT, "operation.end_time": 1e6},
        **{"wall.thickness": 1e-4, "wall.density": 1e-3, "wall.heat_capacity": 1.0, "wall.conductivity": 100.0},
    }
    result = run(bed_at_rest(given | {"target.list": [{"name": "hot", "place": "bed", "above": HOT - 2.0}]}))
    roots = [brentq(lambda z: z * np.tan(z) - biot_number, n * np.pi, (n + 0.5) * np.pi - 1e-9) for n in range(6)]

    def middle(fourier_number):
        terms = [4.0 * np.sin(z) / (2.0 * z + np.sin(2.0 * z)) * np.exp(-(z**2) * fourier_number) for z in roots]
        return sum(terms)

    exact = brentq(lambda fourier: middle(fourier) - 2.0 / (HOT - COLD), 0.1, 100.0) * CAPACITY * HALF**2 / CONDUCTIVITY
    assert result.summary["targets"]["hot"] == pytest.approx(exact, rel=3e-3)


def test_heat_into_thick_insulation():
    """The surface of a half-space under a constant flux: 2 q sqrt(t/(pi k rho C))."""
    given = {
        **{"wall.thickness": 0.2, "wall.density": 100.0, "wall.heat_capacity": 800.0, "wall.conductivity": 0.04},
        **{"operation.outer_heat_flux": 20.0, "operation.end_time": 900.0},
    }
    exact = 2.0 * 20.0 * np.sqrt(900.0 / (np.pi * 0.04 * 100.0 * 800.0))
    assert run(bed_at_rest(given))["highest_wall"][-1] - COLD == pytest.approx(exact, rel=3e-3)


def isothermal_cure(cure, temperature, *degrees):
    """Times (s) at which a part of a temperature (K) without heat of cure reaches degrees of it, by default steps."""
    isothermal = RESIN | {"cure": cure | {"heat": 1e-3}}
    layers = [
        {"material": "carbon_steel", "thickness": 0.003},
        {"name": "part", "material": "resin", "thickness": 0.004},
    ]
    scene = Scene(
        tables_of_bed()
        | {
            "operation": {
                **{"initial_temperature": temperature, "inlet_temperature": temperature},
                **{"pressure_drop": 0.0, "end_time": 1e5},
            },
            "wall": {"layer": layers},
            "materials": {"resin": isothermal},
            "target": {"list": [{"name": f"to {degree:.0%}", "place": "part", "cured": degree} for degree in degrees]},
        }
    )
    found = run(scene).summary["targets"]
    return [found[f"to {degree:.0%}"] for degree in degrees]


def test_a_resin_that_reacts_at_the_start():
    """Without heat of cure d alpha/dt = k (1 - alpha)^1.5 has a solution in closed form."""
    temperature, cure, parts = 450.0, RESIN["cure"], (0.2, 0.8)
    found = isothermal_cure(cure, temperature, *parts)
    rate = cure["rate_1"] * np.exp(-cure["activation_energy_1"] / (8.31446 * temperature))
    exact = [2.0 * ((1.0 - part) ** -0.5 - (1.0 - cure["initial"]) ** -0.5) / rate for part in parts]
    assert found == pytest.approx(exact, rel=5e-3)


@pytest.mark.parametrize(("order_m", "initial"), [(1.0, 1e-9), (1.0, 1e-6), (0.8, 1e-7)])
def test_a_cure_that_grows_from_next_to_nothing(order_m, initial):
    """d alpha/dt = k alpha^m (1 - alpha)^1.5: from 1e-9 on it never came, from 1e-7 on 11 % late, with an error of 7e-9."""
    cure = {"rate_1": 0.0, "activation_energy_1": 0.0, "rate_2": 1e8, "activation_energy_2": 7.5e4}
    cure |= {"order_m": order_m, "order_n": 1.5, "initial": initial}
    rate = 1e8 * np.exp(-7.5e4 / (8.31446 * 343.15))
    steps = np.linspace(np.log(initial), np.log(0.5), 20001)  # d alpha/alpha
    exact = trapezoid(np.exp(steps) ** (1.0 - order_m) / (1.0 - np.exp(steps)) ** 1.5, steps) / rate
    assert isothermal_cure(cure, 343.15, 0.5) == pytest.approx([exact], rel=3e-3)


def test_cold_gas_through_a_hot_tube_ends_steady():
    """Plug flow with one temperature, inlet as cold as the start: the outlet's mean is Graetz's series, 255.92 °C."""
    tube = {"kind": "pipe", "length": 1.0, "diameter": 0.05}
    scene = Scene(
        {
            "geometry": tube,
            "bed": {
                **{"bead_diameter": 0.004, "bead_density": 2000.0, "bead_heat_capacity": 800.0},
                **{"bead_conductivity": 0.5, "porosity_model": "constant", "bulk_porosity": 0.4},
            },
            "fluid": {"density": 1.0, "viscosity": 2e-5, "heat_capacity": 1000.0, "conductivity": 0.05},
            "wall": {"material": "aluminium", "thickness": 1e-4},
            "operation": {
                **{"initial_temperature": 293.15, "inlet_temperature": 293.15, "wall_temperature": 573.15},
                "inlet_velocity": 2.0,
            },
            "model": {"flow": "plug", "turbulence": "none", "wall": "fixed-temperature", "energy": "one-temperature"},
        }
    )
    conductivity = 0.4 * 0.05 + 0.6 * 0.5
    roots = jn_zeros(0, 200)
    rest = np.sum(4.0 / roots**2 * np.exp(-(roots**2) * conductivity / (2.0 * 1000.0 * 0.025**2)))
    result = run(scene)
    assert result["outlet_temperature"][-1] == pytest.approx(573.15 - 280.0 * rest, abs=0.5)
    assert result.summary["end_time"] < 2e4 and result.summary["heating_time"] is None


def test_an_unreachable_target_ends_in_the_steady_state_and_says_so():
    settings = {"model.flow": "plug", "model.turbulence": "none", "operation.end_time": None}
    scene = coarse_scene(settings | {"target.list": [{"place": "wall", "above": 400.0}]})
    result = run(scene)
    assert result.summary["end_time"] < 2e4
    assert any("not met in the steady state" in warning for warning in result.summary["warnings"])


def test_nothing_to_heat_is_refused_only_where_nothing_heats():
    plain = {"operation.inlet_temperature": 298.15}
    with pytest.raises(InputError, match="nothing to heat"):
        coarse_scene(plain)
    with pytest.raises(InputError, match="nothing to heat"):
        coarse_scene(plain | {"operation.outer_coefficient": 5.0, "operation.ambient_temperature": 298.15})
    for other in (
        {"operation.outer_coefficient": 5.0, "operation.ambient_temperature": 350.0},
        {"operation.outer_heat_flux": 100.0},
        {"model.wall": "fixed-temperature", "operation.wall_temperature": 350.0},
        {"operation.bead_velocity": 1e-3, "operation.bead_inlet_temperature": 350.0},
    ):
        coarse_scene(plain | other)


def test_the_mean_temperature_of_plug_flow_is_that_of_the_volume():
    """Oil flows by its viscosity: cells that crowd at the cold wall must not count more than their part of the section."""
    settings = {
        **{"model.flow": "plug", "model.turbulence": "none", "fluid.material": "thermal_oil"},
        **{"operation.pressure_drop": 20e3, "solver.largest_step": None, "solver.axial_cells": 18},
    }
    times = [run(coarse_scene(settings | {"solver.first_cell": first})).heating_time for first in (5e-5, 2e-6)]
    assert times[0] == pytest.approx(times[1], rel=2e-3)


@pytest.mark.parametrize("bead_material", ["ceramic", "acrylic"])
def test_a_curved_mesh_keeps_within_the_temperatures_given(bead_material):
    """Where gas enters evenly and then crosses to the wall, at right angles to the cells."""
    changes = {"operation.pressure_drop": None, "operation.inlet_velocity": 0.5, "model.turbulence": "none"}
    changes |= {"operation.end_time": 400.0, "bed.bead_material": bead_material, "operation.inlet_temperature": 473.15}
    low, high = run(Scene.load(STUDIES / "mold" / "curved.toml", changes)).summary["temperature_bounds"]
    assert low > 298.15 - 0.1 and high < 473.15 + 0.1


def test_one_temperature_has_no_wiggles_behind_a_sharp_front():
    """Of a front without dispersion nothing is left behind but the temperature of the inlet, though nothing keeps bounds."""
    tables = tables_of_bed("pipe")
    tables["bed"]["bead_conductivity"] = 0.05
    tables["operation"] |= {"inlet_temperature": HOT, "pressure_drop": 4000.0, "end_time": 300.0}
    tables["model"] |= {"flow": "plug", "wall": "insulated"}
    tables["solver"] = {"keep_bounds": False}
    result = run(Scene(tables))
    front, behind = (heated_part(result[f"temperature_centre_{place}"]) for place in ("L/2", "L/8"))
    passed = front > 0.4
    assert passed.sum() > 3
    assert np.abs(behind[passed] - 1.0).max() < 3e-3


def test_the_outlet_of_a_bed_at_rest_has_a_temperature():
    """Nothing flows: that of its area, not of what rounding carries."""
    given = {"model.wall": "fixed-temperature", "operation.wall_temperature": HOT, "operation.end_time": 300.0}
    result = run(bed_at_rest(given))
    assert np.all(np.diff(result["outlet_temperature"]) > -1e-6)
    at_outlet = result["temperature_centre_L"][-1], result["temperature_bed_side_L"][-1]
    assert at_outlet[0] < result["outlet_temperature"][-1] < at_outlet[1]


@pytest.mark.parametrize("coefficient", [None, 8.0])
@pytest.mark.parametrize("wall", ["conjugate", "thin"])
def test_a_hot_wall_radiates_to_its_surroundings(wall, coefficient):
    """A metal sheet at 900 K on a bed that stores and conducts nothing: the ordinary differential equation of a body of one
    temperature, d(rho C delta T)/dt = -e sigma (T^4 - T_a^4) - h (T - T_a)."""
    given = {
        "wall.thickness": 0.003, "model.wall": wall, "bed.bead_heat_capacity": 1e-3, "bed.bead_conductivity": 1e-6,
        "fluid.conductivity": 1e-6, "fluid.density": 1e-3, "operation.initial_temperature": 900.0,
        "operation.inlet_temperature": 900.0, "operation.ambient_temperature": 300.0, "operation.outer_emissivity": 0.8,
        "operation.end_time": 600.0, "wall.density": 2700.0, "wall.heat_capacity": 900.0, "wall.conductivity": 2e4,
    } | ({} if coefficient is None else {"operation.outer_coefficient": coefficient})  # fmt: skip

    def rate(_, warm):
        lost = 0.8 * 5.670374419e-8 * (warm**4 - 300.0**4) + (coefficient or 0.0) * (warm - 300.0)
        return -lost / (2700.0 * 900.0 * 0.003)

    exact = solve_ivp(rate, (0.0, 600.0), [900.0], rtol=1e-10, dense_output=True).sol
    worst = []
    for refinement in (1.0, 2.0):
        result = run(bed_at_rest(given | {"solver.step_refinement": refinement}))
        worst.append(np.max(np.abs(np.array(result["lowest_wall"]) - exact(np.array(result["time"]))[0])) / 600.0)
        assert abs(result.summary["energy_imbalance"]) < 1e-4
    assert worst[0] < STEP_ERROR[3] and worst[1] < 0.4 * worst[0]


@pytest.mark.parametrize("opens", ["cure", "source", "flux"])
def test_a_wall_that_heats_itself_leaves_the_bed_its_bounds(opens):
    """Coarse cells, whose front overshoots without bounds: the bed is never hotter than the gas and the wall have been."""
    settings = {
        "model.flow": "plug",
        "model.turbulence": "none",
        "solver.mesh_refinement": 0.5,
        "solver.step_refinement": 0.5,
    }
    settings |= {"operation.end_time": 600.0}
    scene = cured_mold(settings)
    if opens != "cure":
        weak = {"source": {"wall.layer[1].heat_source": 1e3}, "flux": {"operation.outer_heat_flux": 10.0}}[opens]
        scene = cured_mold(settings).changed(weak | {"wall.layer[2].material": "gfrp"} | {"target.list": None})
    result, free = run(scene), run(scene.changed({"solver.keep_bounds": False}))

    def beyond(of):
        given = np.maximum(430.0, np.maximum.accumulate(of["highest_wall"]))
        return np.max(np.array(of["highest_bed"]) - given)

    assert beyond(result) < 0.1 < beyond(free)
    assert not any("beyond those given" in warning for warning in result.summary["warnings"])


@pytest.mark.parametrize("flux", [5000.0, -2000.0])
def test_a_wall_that_was_heated_leaves_its_heat_to_the_bed(flux):
    """Once the flux stops, the wall is colder than the bed downstream, which was bounded by it: 5 % more heat was left."""
    pulse = ([0.0, 1000.0, 1000.001], [flux, flux, 0.0])
    scene = Scene(
        {
            "geometry": {"kind": "pipe", "length": 0.5, "diameter": 0.1},
            "bed": {"bead_diameter": 0.004, "bead_material": "ceramic"},
            "operation": {
                **{"initial_temperature": COLD, "inlet_temperature": COLD, "inlet_velocity": 0.2},
                **{"outer_heat_flux": pulse, "end_time": 4000.0},
            },
            "model": {"flow": "plug", "turbulence": "none", "wall": "thin"},
            "wall": {"material": "aluminium", "thickness": 0.003},
        }
    )
    result, free = run(scene), run(scene.changed({"solver.keep_bounds": False}))
    assert result["heat_stored"][-1] == pytest.approx(free["heat_stored"][-1], rel=1e-3)
    assert result.summary["repeated_steps"] <= 3


def plug_of_water(settings):
    """A bed that stores as much as the water that heats it by 60 K; half of it is heated in 70 s."""
    scene = Scene(
        {
            "geometry": {"kind": "pipe", "length": 0.5, "diameter": 0.1},
            "bed": {
                **{"bead_diameter": 0.005, "porosity_model": "constant", "bulk_porosity": 0.4},
                **{"bead_density": 2400.0, "bead_heat_capacity": 800.0, "bead_conductivity": 1e-6},
            },
            "fluid": {"density": 1000.0, "viscosity": 1e-3, "heat_capacity": 4180.0, "conductivity": 0.6},
            "operation": {
                **{"initial_temperature": COLD, "inlet_temperature": HOT},
                **{"inlet_velocity": 5e-3, "end_time": 70.0},
            },
            "model": {"flow": "plug", "turbulence": "none", "wall": "insulated"},
        }
    )
    return scene.changed(settings)


def test_a_front_in_a_liquid_that_stores_as_much_as_the_beads():
    """Schumann's front, in its retarded time, past stations at default cells and steps (2.1 % off where the fluid's storage was
    lumped at the nodes and not upwinded as its flow)."""
    length, speed, porosity, diameter = 0.5, 5e-3, 0.4, 0.005
    density, fluid_capacity, solid_capacity, fluid_conductivity = 1000.0, 4180.0, 0.6 * 2400.0 * 800.0, 0.6
    result = run(plug_of_water({"model.exchange_factor": 0.1}))
    reynolds, prandtl = density * speed * diameter / 1e-3, 1e-3 * fluid_capacity / fluid_conductivity
    coefficient = 0.1 * (2.0 + 1.1 * reynolds**0.6 * prandtl ** (1.0 / 3.0)) * fluid_conductivity / diameter
    exchange, carried = coefficient * 6.0 * 0.6 / diameter, density * speed * fluid_capacity
    for station, part in (("L/4", 0.25), ("L/2", 0.5), ("L", 1.0)):
        place = part * length
        passed = result["time"][-1] - place * porosity * density * fluid_capacity / carried
        exact = schumann(exchange * place / carried, exchange * passed / solid_capacity)
        assert heated_part(result[f"temperature_centre_{station}"][-1]) == pytest.approx(exact, abs=1.5e-3)


def test_a_wall_that_is_held_hot_from_the_start_keeps_the_bed_within_its_bounds():
    """Beads move against hot steam beside a wall of its temperature: the first step is damped, not marked cell by cell, and the
    surface that jumps does not count in the steps' error."""
    scene = bed_at_rest(
        {
            **{"model.wall": "fixed-temperature", "model.energy": "two-temperature", "model.flow": "plug"},
            **{"operation.wall_temperature": HOT, "operation.inlet_temperature": HOT, "operation.inlet_velocity": 2.0},
            **{"operation.bead_velocity": 1e-3, "operation.bead_inlet_temperature": COLD, "operation.end_time": 300.0},
            "operation.pressure_drop": None,
        },
        "pipe",
    )
    result = run(scene)
    assert min(result["lowest_temperature"]) > COLD - 0.1 and max(result["highest_temperature"]) < HOT + 0.1
    assert result.summary["rejected_steps"] <= 2 and result.summary["repeated_steps"] < 15


def oil_through_a_pipe():
    """Tables of an insulated pipe that a hot liquid enters in plug flow, whose drive is to be given."""
    return tables_of_bed("pipe") | {
        "geometry": {"kind": "pipe", "length": 0.5, "diameter": 0.5},
        "fluid": {"density": 850.0, "viscosity": 1e-3, "heat_capacity": 2200.0, "conductivity": 0.11},
        "operation": {"initial_temperature": COLD, "inlet_temperature": HOT},
        "model": {"flow": "plug", "turbulence": "none", "wall": "insulated"},
    }


def test_a_jump_of_a_fluid_that_beads_do_not_hold_up_is_followed_and_told():
    """Schumann's first front: exp(-N) of the inlet's change passes as a jump, with the fluid. With steps of a front that half a
    transfer unit spreads, its middle left 14 % of that time late, without a word."""
    tables = oil_through_a_pipe()
    tables["bed"] |= {"bead_diameter": 0.04, "allow_small_ratio": True}
    tables["operation"] |= {"mass_flow": 4.0, "end_time": 20.0}
    result = run(Scene(tables))
    passed = 0.4 * 850.0 * 0.5 * np.pi / 4.0 * 0.5**2 / 4.0
    assert any("as a jump of the fluid alone" in text for text in result.summary["warnings"])
    jump = result["outlet_temperature"] > COLD + 0.3 * (HOT - COLD)
    assert result["time"][np.argmax(jump)] == pytest.approx(passed, rel=0.05)
    finer = tables | {"bed": tables["bed"] | {"bead_diameter": 0.01}}
    assert not any("as a jump" in text for text in run(Scene(finer)).summary["warnings"])


def test_cells_and_steps_follow_beads_that_move_with_the_fluid():
    """They spread the front less and take it along: on those of beads at rest it came 1.4 % of the time off, 8 % of the range."""
    tables = oil_through_a_pipe()
    tables["operation"] |= {
        "inlet_velocity": 0.02,
        "bead_velocity": 0.008,
        "bead_inlet_temperature": COLD,
        "end_time": 60.0,
    }
    levels, found = COLD + np.array([0.1, 0.3, 0.5]) * (HOT - COLD), []
    for finer in (1.0, 3.0):
        result = run(Scene(tables | {"solver": {"mesh_refinement": finer, "step_refinement": finer}}))
        rises = slice(0, int(np.argmax(result["outlet_temperature"])) + 1)
        found.append(np.interp(levels, result["outlet_temperature"][rises], result["time"][rises]))
    assert found[0] == pytest.approx(found[1], rel=4e-3)


def test_a_liquid_that_gets_viscous_as_it_cools_is_followed():
    """Oil that a pressure drop drives slows down tenfold while it cools a bed: the bed's mean temperature hardly tells."""
    scene = Scene(
        {
            "geometry": {"kind": "pipe", "length": 0.45, "diameter": 0.0167},
            "bed": {"bead_diameter": 0.00157, "bead_material": "glass"},
            "wall": {"material": "frp", "thickness": 0.001},
            "fluid": {"material": "thermal_oil"},
            "operation": {
                **{"initial_temperature": 451.0, "inlet_temperature": 322.0, "pressure_drop": 380.0},
                **{"heating_margin": 5.0, "end_time": 50_000.0},
            },
            "model": {"flow": "plug", "turbulence": "none"},
            "output": {"pictures": False},
        }
    )
    own, finer = (run(scene.changed({"solver.step_refinement": finer})) for finer in (1.0, 5.0))
    assert max(own["mass_flow"]) > 10.0 * own["mass_flow"][-1]
    assert own.summary["heating_time"] == pytest.approx(finer.summary["heating_time"], rel=4e-3)


PLACES = (0.3, 0.7, 0.98)


def liquid_in_steel_beads(viscosity, density=950.0):
    """A liquid of constant properties but for its viscosity, a law of the temperature, cools hot steel beads."""
    return {
        "geometry": {"kind": "mold", "length": 1.0, "cavity_height": 0.05},
        "bed": {
            **{"bead_diameter": 0.005, "bead_material": "steel", "bead_density": 7747.0, "bead_heat_capacity": 480.0},
            **{"bead_conductivity": 1.0, "porosity_model": "constant", "bulk_porosity": 0.4},
        },
        "materials": {
            "oil": {"density": density, "heat_capacity": 1800.0, "conductivity": 0.11, "viscosity": viscosity}
        },
        "fluid": {"material": "oil"},
        "operation": {
            **{"initial_temperature": 423.15, "inlet_temperature": 293.15, "pressure_drop": 20e3, "end_time": 18e3},
        },
        "model": {"flow": "plug", "turbulence": "none", "wall": "insulated"},
        "solver": {"refine_in_doubt": False},
        "output": {"pictures": False},
        "target": [{"name": f"at_{n}", "place": f"place_{n}", "below": 358.15} for n in range(len(PLACES))],
    }


@pytest.mark.parametrize("steepness", [0.0, 0.04])
def test_a_liquid_that_gets_viscous_is_as_late_as_finite_volumes_have_it(tmp_path, steepness):
    """Two hundredfold: by the errors of the first steps alone the flow was 3 % too little for long (s at 0.7 m 1.6 % late). The
    times of its finite volumes (a thousand cells, van Leer, two temperatures) are 7.555, 33.582 and 66.163 s."""
    tables = liquid_in_steel_beads({"log_polynomial": [9.0, -0.04]} if steepness else 0.05)
    tables["geometry"]["sensors"] = str(tmp_path / "sensors.csv")
    rows = [f"place_{n}, {1e3 * place}, 5" for n, place in enumerate(PLACES)]
    (tmp_path / "sensors.csv").write_text("\n".join(["name, x [mm], y [mm]", *rows]) + "\n")
    targets = run(Scene(tables)).summary["targets"]
    if steepness:
        times = [targets[f"at_{n}"] for n in range(len(PLACES))]
        assert times == pytest.approx([7.555, 33.582, 66.163], rel=6e-3)
    else:
        assert None not in targets.values()  # a constant density was a traceback
