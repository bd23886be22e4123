"""Fronts in fluids that expand, against finite volumes of their own: writes docs/expanding-liquids.md.

Run: make expanding-liquids (a quarter of an hour).

Insulated beds of constant porosity drawn at random: six fluids between random temperatures, heated or cooled, a given mass flow;
plug, developed or full flow. What is compared is the time at which the fluid that leaves is half-way to the inlet's temperature.
The finite volumes solve mass, enthalpy of the fluid and heat of the beads in one dimension, as conservation laws (150 cells,
second order, Heun's method), with the film of the inlet's mass flux. "Without" is what they give where the same mass flow passes
all of the bed.
"""

import argparse
from pathlib import Path

import numpy as np
from mpi4py import MPI
from scipy.interpolate import PchipInterpolator

from porousmold import Scene, run
from porousmold.simulation.specs import specs_of
from studies.page import Page

DOCS = Path(__file__).parent.parent / "docs"
SCENES, SEED = 24, 5
FLUIDS = (
    *(("therminol_vp1", 100.0, 350.0), ("thermal_oil", 150.0, 300.0), ("solar_salt", 290.0, 560.0)),
    *(("water", 5.0, 95.0), ("water_glycol", -5.0, 85.0), ("air", 20.0, 300.0)),
)
"""With the range (degC) that temperatures are drawn from."""
FLOWS = ("plug", "plug", "developed", "full")
COURANT, DIFFUSION = 0.25, 0.2
"""Of the finite volumes' step, over that in which the fluid passes a cell, and over the smallest time constant of a cell."""


def outlet_by_finite_volumes(scene, end, cells=150, *, expands=True):
    """Time (s, up to `end`) and temperature (K) at the outlet of an insulated bed of constant porosity in plug flow."""
    specs = specs_of(scene)
    laws, phi, diameter = specs.laws, specs.porosity.bulk_porosity, specs.mesh.bead_diameter
    fluid, beads, pressure = laws.fluid, laws.beads, specs.flow.outlet_pressure
    inlet, size = specs.heat.inlet_temperature(0.0), specs.mesh.size
    inflow, width = float(specs.flow.driven_by(0.0)) / size.area, size.length / cells
    temperature = np.full(cells, specs.heat.initial_temperature)
    of_beads, enthalpy, everywhere = temperature.copy(), fluid.heat_capacity.integral, np.ones(cells)

    def conducted(conductivity, values):
        inner = 0.5 * (conductivity[1:] + conductivity[:-1]) * np.diff(values) / width
        return np.diff(np.concatenate([[0.0], inner, [0.0]]))

    def exchange(values):
        viscosity, conductivity = fluid.viscosity(values), fluid.conductivity(values) * everywhere
        prandtl = viscosity * fluid.heat_capacity(values) / conductivity
        film = laws.nusselt(inflow * diameter / viscosity, prandtl, phi) * conductivity / diameter
        return 6.0 * (1.0 - phi) / diameter * film

    def rates(values, solid):
        density, capacity = fluid.density(pressure, values), fluid.heat_capacity(values)
        slope = (fluid.density(pressure, values + 0.5) - fluid.density(pressure, values - 0.5)) * everywhere * expands
        exchanged = exchange(values) * (values - solid) * width
        steps = np.diff(np.append(inlet, values))
        limited = np.where(steps[:-1] * steps[1:] > 0.0, np.sign(steps[1:]), 0.0)
        limited *= np.minimum(np.abs(steps[:-1]), np.abs(steps[1:]))
        at_faces = enthalpy(np.concatenate([[inlet], values[:-1] + 0.5 * limited, values[-1:]]))
        entering, leaving = at_faces[:-1] - enthalpy(values), at_faces[1:] - enthalpy(values)
        gained = conducted(phi * fluid.conductivity(values) * everywhere, values) - exchanged
        storage, flux, change = phi * density * capacity * width * everywhere, inflow, np.empty(cells)
        for cell in range(cells):
            by_rate = phi * slope[cell] * width
            gain = flux * (entering[cell] - leaving[cell]) + gained[cell]
            change[cell] = gain / (storage[cell] - by_rate * leaving[cell])
            flux -= by_rate * change[cell]
        in_beads = conducted((1.0 - phi) * beads.conductivity(solid) * everywhere, solid) + exchanged
        return change, in_beads / ((1.0 - phi) * beads.density(solid) * beads.heat_capacity(solid) * width)

    ends = np.array([inlet, temperature[0]])
    of_fluid = phi * float(np.min(fluid.density(pressure, ends) * fluid.heat_capacity(ends)))
    in_solid = (1.0 - phi) * float(np.min(beads.density(ends) * beads.heat_capacity(ends)))
    conductivities = phi * np.max(fluid.conductivity(ends)), (1.0 - phi) * np.max(beads.conductivity(ends))
    constants = [of_fluid / float(np.max(exchange(np.full(cells, one)))) for one in ends]
    constants += [c * width**2 / k for c, k in zip((of_fluid, in_solid), conductivities, strict=True)]
    passing = width * phi * float(np.min(fluid.density(pressure, ends))) / inflow
    times = np.linspace(0.0, end, int(np.ceil(end / min(COURANT * passing, DIFFUSION * min(constants)))) + 1)
    outlet = [temperature[-1]]
    for step in np.diff(times):
        first = rates(temperature, of_beads)
        second = rates(temperature + step * first[0], of_beads + step * first[1])
        temperature = temperature + 0.5 * step * (first[0] + second[0])
        of_beads = of_beads + 0.5 * step * (first[1] + second[1])
        outlet.append(temperature[-1])
    return times, np.array(outlet)


def half_way(times, outlet, scene):
    """Time (s) at which the fluid that leaves is half-way to the inlet's temperature."""
    heat = specs_of(scene).heat
    halves = PchipInterpolator(times, outlet).solve(0.5 * (heat.initial_temperature + heat.inlet_temperature(0.0)))
    return float(halves[(halves >= 0.0) & (halves <= times[-1])][0])


def drawn(generator):
    """A scene at random."""
    fluid, low, high = FLUIDS[generator.integers(len(FLUIDS))]
    ends = sorted(generator.uniform(low, high, 2))
    if ends[1] - ends[0] < 0.5 * (high - low):
        ends = [low, high]
    if generator.random() < 0.4:
        ends.reverse()
    diameter, flux = (
        generator.uniform(0.2, 1.0),
        10.0 ** (generator.uniform(0.3, 1.7) - (1.2 if fluid == "air" else 0.0)),
    )
    return Scene(
        {
            "geometry": {"kind": "pipe", "length": generator.uniform(0.3, 3.0), "diameter": diameter},
            "bed": {
                "bead_diameter": float(generator.choice([0.006, 0.012, 0.02])),
                "bead_material": str(generator.choice(["steel", "ceramic", "quartzite"])),
                "porosity_model": "constant",
                "bulk_porosity": generator.uniform(0.3, 0.55),
            },
            "fluid": {"material": fluid},
            "operation": {
                "initial_temperature": f"{ends[0]:.1f} degC",
                "inlet_temperature": f"{ends[1]:.1f} degC",
                "mass_flow": flux * 0.25 * np.pi * diameter**2,
                "outlet_pressure": float(generator.choice([30e5, 80e5])) if fluid == "air" else 15e5,
                "end_time": 1e6,
            },
            "model": {"flow": str(generator.choice(FLOWS)), "turbulence": "none", "wall": "insulated"},
            "output": {"pictures": False},
        }
    )


def main():
    """Run everything and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=SCENES)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--out", type=Path, default=DOCS / "expanding-liquids.md")
    options = parser.parse_args()
    generator, errors = np.random.default_rng(options.seed), []
    page = Page("# Fluids that expand", "", "Written by `make expanding-liquids`; do not edit.", "",
             *__doc__.split("\n\n", 2)[2].strip().splitlines())  # fmt: skip
    page.head(*("fluid", "°C", "flow", "kg/m2/s", "half-way, s", "finite volumes, s", "error", "without", "steps"))
    for _ in range(options.scenes):
        scene = drawn(generator)
        specs = specs_of(scene)
        first, inlet = specs.heat.initial_temperature, specs.heat.inlet_temperature(0.0)
        history = run(scene, communicator=MPI.COMM_SELF).history
        ours = half_way(history["time"], history["outlet_temperature"], scene)
        exact, without = (
            half_way(*outlet_by_finite_volumes(scene, 1.3 * ours, expands=expands), scene) for expands in (True, False)
        )
        errors.append(ours / exact - 1.0)
        ends, flux = f"{first - 273.15:.0f} to {inlet - 273.15:.0f}", specs.flow.driven_by(0.0) / specs.mesh.size.area
        page.row(
            *(scene.fluid.material, ends, scene.model.flow, f"{flux:.3g}", f"{ours:.2f}", f"{exact:.2f}"),
            *(f"{errors[-1]:+.3%}", f"{without / exact - 1.0:+.2%}", len(history["time"]) - 1),
        )
    sizes = np.abs(errors)
    page.add(
        "", f"Errors: median {np.median(sizes):.3%}, 95 % {np.quantile(sizes, 0.95):.3%}, largest {sizes.max():.3%}."
    )
    page.write(options.out)


if __name__ == "__main__":
    main()
