r"""The program's beds at a bead Reynolds number: developed flow, and the heat that a wall of fixed temperature gives it.

The flow is the program's own developed flow of air with constant properties. On its section the steady two-temperature equations
without conduction along the flow have the solution exp(-gamma z) far from the inlet:

    rho C phi u gamma T_f = -div(K_f grad T_f) + a_v h_sf (T_f - T_s),   0 = -div(K_s grad T_s) + a_v h_sf (T_s - T_f),

with temperatures over the wall's and the smallest gamma; h = gamma m C/P then is the overall coefficient between wall and mixed
mean. `run_along` measures the same h with the program's own energy equation in two beds of different length.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from mpi4py import MPI
from scipy.linalg import eig

from porousmold import Scene
from porousmold.laws.conductivity import Anisotropic, LocalBed, added, wall_coefficient
from porousmold.laws.nusselt import specific_surface
from porousmold.mesh.point_values import nodal_values
from porousmold.simulation.assembly import assemble
from porousmold.simulation.problem import Problem
from porousmold.simulation.specs import specs_of
from porousmold.simulation.time_integration import Simulation

from .correlations import AIR, CERAMIC
from .section import Array, Section

BEAD_DIAMETER = 5e-3
Settings = Mapping[str, Any]


def scene(re: float, n: float, settings: Settings, *, slab: bool = False, length: float = 0.1) -> Scene:
    """A tube (or a gap with N = 2 H/d) of ceramic beads at a superficial Re_d, with a wall of fixed temperature."""
    width = n * BEAD_DIAMETER
    shape: dict[str, Any] = (
        {"kind": "mold", "cavity_height": width / 2} if slab else {"kind": "pipe", "diameter": width}
    )
    tables = {
        "geometry": {"length": length, **shape},
        "bed": {"bead_diameter": BEAD_DIAMETER, "bead_conductivity": CERAMIC},
        "fluid": {
            "density": AIR.density,
            "viscosity": AIR.viscosity,
            "heat_capacity": AIR.heat_capacity,
            "conductivity": AIR.conductivity,
        },
        "operation": {
            "initial_temperature": 300.0,
            "inlet_temperature": 310.0,
            "inlet_velocity": re * AIR.viscosity / (AIR.density * BEAD_DIAMETER),
            "wall_temperature": 300.0,
        },
        "model": {"flow": "developed", "wall": "fixed-temperature"},
        "solver": {"axial_cells": 2, "mesh_refinement": 1.5},
    }
    return Scene(tables).changed(settings)


@dataclass(frozen=True)
class Bed:
    """A bed with its developed flow: `section`, values at its nodes, and dp/L (Pa/m)."""

    re: float
    n: float
    section: Section
    porosity: Array
    speed: Array
    eddy_viscosity: Array
    pressure_gradient: float
    problem: Problem

    @classmethod
    def of(cls, re: float, n: float, settings: Settings, *, slab: bool = False) -> "Bed":
        """Its flow is found."""
        problem = assemble(specs_of(scene(re, n, settings, slab=slab)), MPI.COMM_SELF)
        problem.flow.start()
        medium, equations = problem.medium, problem.medium.equations
        space = medium.flow_temperature.function_space
        places = space.tabulate_dof_coordinates()
        column = np.flatnonzero(np.isclose(places[:, 0], np.sort(places[:, 0])[len(places) // 2]))
        column = column[np.argsort(places[column, 1])]
        momentum = equations.momentum(problem.flow.state, medium.flow_temperature)
        turbulence = momentum.turbulence
        eddies = None if turbulence is None else nodal_values(turbulence.eddy_viscosity, space)[column]
        speed = nodal_values(momentum.speed, space)[column]
        return cls(
            re,
            n,
            Section(places[column, 1], axisymmetric=not slab),
            nodal_values(equations.bed.porosity, space)[column],
            speed,
            np.zeros_like(speed) if eddies is None else eddies,
            problem.balances.pressure_drop / problem.domain.length,
            problem,
        )

    @property
    def mean_porosity(self) -> float:
        """Over the section."""
        return self.section.mean(self.porosity)

    @property
    def drag_factor(self) -> float:
        """F of dp/L = F (1 - phi)/phi^3 rho U^2/d with the mean porosity."""
        phi, mean = self.mean_porosity, self.re * AIR.viscosity / (AIR.density * BEAD_DIAMETER)
        return self.pressure_gradient / ((1.0 - phi) / phi**3 * AIR.density * mean**2 / BEAD_DIAMETER)

    @property
    def near_wall_share(self) -> float:
        """Part of the volume flow within d/2 of the wall."""
        flow = self.section.weights * self.porosity * self.speed
        inside = self.section.nodes < self.section.nodes[-1] - 0.5 * BEAD_DIAMETER
        cumulated = np.cumsum(flow) - 0.5 * flow
        edge = self.section.nodes[-1] - 0.5 * BEAD_DIAMETER
        return 1.0 - float(np.interp(edge, self.section.nodes, cumulated) / flow.sum()) if inside.any() else 1.0

    def _local(self) -> LocalBed:
        equations = self.problem.medium.equations
        laws, phi = self.problem.specs.laws, self.problem.specs.porosity.bulk_porosity
        core = laws.drag.speed(phi * self.pressure_gradient, phi, BEAD_DIAMETER, AIR.density, AIR.viscosity)
        assert equations.gravity is None
        return LocalBed(
            porosity=self.porosity,
            wall_distance=self.section.nodes[-1] - self.section.nodes,
            bead_diameter=BEAD_DIAMETER,
            density=AIR.density,
            viscosity=AIR.viscosity,
            heat_capacity=AIR.heat_capacity,
            speed=self.speed,
            eddy_viscosity=self.eddy_viscosity,
            fluid_conductivity=AIR.conductivity,
            bead_conductivity=CERAMIC,
            bulk_porosity=phi,
            core_speed=phi * core,
            temperature=300.0,
            contact_flattening=laws.beads.contact_flattening,
        )

    @property
    def core_conductivity(self) -> float:
        """k_r/lambda_f in the middle: fluid and beads together, across the flow."""
        fluid, beads = self._conductivities()
        return float((fluid[0] + beads[0]) / AIR.conductivity)

    def _conductivities(self) -> tuple[Array, Array]:
        laws, local = self.problem.specs.laws, self._local()
        parts = (
            added(laws.bead_conduction.fluid(local), laws.dispersion.mixed(local)),
            laws.bead_conduction.beads(local),
        )
        return tuple(part.across if isinstance(part, Anisotropic) else part for part in parts)  # type: ignore[return-value]

    def overall_nusselt_number(self) -> float:
        """h d/lambda_f between the wall and the mixed mean, far from the inlet."""
        laws, section = self.problem.specs.laws, self.section
        reynolds = AIR.density * self.porosity * self.speed * BEAD_DIAMETER / AIR.viscosity
        nusselt = laws.nusselt(reynolds, AIR.prandtl_number, self.porosity)
        exchange = specific_surface(self.porosity, BEAD_DIAMETER) * nusselt * AIR.conductivity / BEAD_DIAMETER
        exchange = section.weights * exchange
        carried = section.weights * AIR.density * AIR.heat_capacity * self.porosity * self.speed
        fluid, beads = self._conductivities()
        free = len(fluid) - 1  # nodes whose fluid is not at the wall's temperature
        of_fluid = (section.stiffness(fluid) + np.diag(exchange))[:free, :free]
        of_beads = section.stiffness(beads) + np.diag(exchange)
        if laws.bead_conduction.whole_bed:
            of_beads[-1, -1] += section.perimeter * np.broadcast_to(wall_coefficient(self._local()), free + 1)[-1]
        between = -np.diag(exchange)[:free]
        reduced = of_fluid - between @ np.linalg.solve(of_beads, between.T)
        rate = float(np.min(eig(reduced, np.diag(carried[:free]), right=False).real))
        return rate * carried.sum() / section.perimeter * BEAD_DIAMETER / AIR.conductivity


def run_along(re: float, n: float, settings: Settings, lengths: tuple[float, float]) -> float:
    """The same h d/lambda_f from the program's energy equation: steady mixed means at the ends of beds of two lengths (m)."""
    steady = {
        "operation.end_time": 1e6,
        "solver.largest_step": 1e5,
        "solver.first_step": 10.0,
        "solver.step_growth": 3.0,
    }
    cells = {"solver.axial_cells": 40, "solver.mesh_refinement": 1.0}
    over = []
    for length in lengths:
        simulation = Simulation(
            specs_of(scene(re, n, {**settings, **steady, **cells}, length=length)), MPI.COMM_SELF
        ).integrate()
        over.append(simulation.recorder.history["outlet_temperature"][-1] - 300.0)
    width, mean = n * BEAD_DIAMETER, re * AIR.viscosity / BEAD_DIAMETER
    rate = np.log(over[0] / over[1]) / (lengths[1] - lengths[0])
    return float(rate * mean * AIR.heat_capacity * width / 4.0 * BEAD_DIAMETER / AIR.conductivity)
