"""Small domains, beds and equations that tests of forms and solvers build on."""

import functools
import operator
import os
import subprocess
import sys
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from porousmold.equations.coordinates import Coordinates
from porousmold.equations.flow import FlowEquations, FlowScales
from porousmold.equations.medium import Bed, FluidState
from porousmold.equations.openings import Opening
from porousmold.files.tables import read_toml
from porousmold.laws.drag import DRAG_LAWS
from porousmold.laws.material_library import FLUIDS, SOLIDS
from porousmold.laws.materials import ConstantDensity, constant
from porousmold.laws.nusselt import NUSSELT_CORRELATIONS
from porousmold.mesh import domain as geometry
from porousmold.mesh import fenicsx
from porousmold.scene.scene import Scene
from porousmold.simulation.assembly import assemble
from porousmold.simulation.specs import specs_of
from porousmold.simulation.time_integration import Simulation

STUDIES = Path(__file__).parent.parent / "studies"
MESHES = STUDIES.parent / "meshes"
FIELD_CASES = Path(__file__).parent / "field_cases"
"""Inputs as users of other programs brought them; README.md has the right values."""
AIR, CERAMIC = FLUIDS["thesis_air"], SOLIDS["ceramic"]
ALUMINIUM, FRP, PIPE = (
    STUDIES / "mold" / "aluminium.toml",
    STUDIES / "mold" / "frp.toml",
    STUDIES / "pipe" / "baseline.toml",
)
COARSE = {"solver.axial_cells": 8, "solver.cell_growth": 1.6, "solver.largest_step": 80.0}


def coarse_scene(*given):
    """A shipped scene (a path, by default the aluminium mold) with settings (dicts) on a coarse mesh with large steps: seconds,
    and within 2 % of the answer."""
    path = next((each for each in given if isinstance(each, Path)), ALUMINIUM)
    settings = [each for each in given if isinstance(each, dict)]
    return Scene.load(path, functools.reduce(operator.or_, settings, COARSE))


RESIN = {
    "density": 1850.0,
    "heat_capacity": 1200.0,
    "conductivity": 0.35,
    "source": "of the tests",
    "cure": {
        **{"rate_1": 1e5, "activation_energy_1": 6.65e4, "rate_2": 0.0, "activation_energy_2": 0.0},
        **{"order_m": 0.8, "order_n": 1.5, "heat": 1.9e5, "initial": 0.01},
    },
}
"""Material of a part that cures."""


def cured_mold(settings):
    """The aluminium mold with a part of 5 mm on its skin, a target of its cure to 0.8, and other settings."""
    layers = [
        {"name": "skin", "material": "aluminium", "thickness": 0.003},
        {"name": "part", "material": "resin", "thickness": 0.005},
    ]
    given = {name: dict(table) for name, table in read_toml("scene", ALUMINIUM).items() if name != "wall"}
    given |= {"materials": {"resin": RESIN}, "wall": {"layer": layers}}
    given["target"] = {"list": [{"name": "cured", "place": "part", "cured": 0.8}]}
    return Scene(given).changed({"operation.inlet_temperature": 430.0} | settings)


def problem_of(scene, communicator=MPI.COMM_SELF):
    """The discrete problem of a scene."""
    return assemble(specs_of(scene), communicator)


def simulation_of(scene, communicator=MPI.COMM_SELF):
    """A scene ready to be integrated."""
    return Simulation(specs_of(scene), communicator)


def under_mpirun(ranks, *arguments, timeout=300):
    """Python with these arguments on so many ranks, in a world of their own and not of this process: the finished process."""
    outside = {name: value for name, value in os.environ.items() if not name.startswith(("OMPI_", "PMIX_"))}
    command = ["mpirun", "--oversubscribe", *(["--allow-run-as-root"] if os.geteuid() == 0 else []), "-n", str(ranks)]
    return subprocess.run(
        [*command, sys.executable, *arguments], env=outside, capture_output=True, text=True, timeout=timeout
    )


def liquid(density=1.0, viscosity=0.1, heat_capacity=1.0, conductivity=1.0):
    """A fluid of constant properties."""
    return replace(
        AIR,
        name="liquid",
        density=ConstantDensity(density, "test"),
        viscosity=constant(viscosity, "Pa s", "test"),
        heat_capacity=constant(heat_capacity, "J/(kg K)", "test"),
        conductivity=constant(conductivity, "W/(m K)", "test"),
    )


def solid(density=1.0, heat_capacity=1.0, conductivity=1.0):
    """A solid of constant properties."""
    return replace(
        CERAMIC,
        density=constant(density, "kg/m^3", "test"),
        heat_capacity=constant(heat_capacity, "J/(kg K)", "test"),
        conductivity=constant(conductivity, "W/(m K)", "test"),
    )


def box(cells, *, axisymmetric=False, length=1.0, width=1.0, wall=0.0, wall_cells=1, communicator=MPI.COMM_SELF):
    """Uniform mesh of `cells` = (along, across) over a bed, with a wall of thickness `wall` outside it if > 0."""
    layers = [np.linspace(0.0, wall, wall_cells + 1)] if wall else []
    across = geometry.Across.to_wall(np.linspace(0.0, width, cells[1] + 1), layers)
    axial_nodes = np.linspace(0.0, length, cells[0] + 1)
    return geometry.straight_bed(communicator, axial_nodes, [across], axisymmetric=axisymmetric)


def flow_equations(
    domain,
    porosity,
    *,
    fluid=None,
    bead_diameter=0.5,
    beads=None,
    model=None,
    speed=1.0,
    pressure=1.0,
    rev=None,
    published_pressure_term=False,
    equations=FlowEquations,
    reference_pressure=0.0,
    wall_distance=None,
):
    """`FlowEquations` over a domain for a porosity expression."""

    def number(value):
        return fem.Constant(domain.mesh, float(value))

    diameter = number(bead_diameter)
    bed = Bed(porosity, number(0.4), wall_distance or domain.wall_distance, diameter, beads or solid(),
              DRAG_LAWS["macdonald"], NUSSELT_CORRELATIONS["wakao"], rev)  # fmt: skip
    return equations(
        bed,
        FluidState(fluid or liquid(), number(reference_pressure)),
        Coordinates(domain.mesh, domain.axisymmetric),
        FlowScales(number(speed), number(pressure), diameter),
        model,
        published_pressure_term=published_pressure_term,
    )


def opening(domain, tag, quadrature_degree, **terms):
    """`Opening` of the boundary's part with the tag."""
    return Opening(domain.facet_measure(quadrature_degree)(tag), **terms)


@dataclass(frozen=True)
class GivenFlow(FlowEquations):
    """Flow equations whose fields are prescribed: the mass flux is phi rho u, without the solver's fine scales."""

    def core_speed(self, state, temperature):
        return self.bed.porosity * state.speed(self.scales)

    def mass_flux(self, state, temperature):
        return self.mass_flux_through_boundary(state, temperature)


def nodal(domain, expression):
    """The expression at the nodes as a linear function."""
    space = fenicsx.lagrange_space(domain.mesh)
    function = fem.Function(space)
    function.interpolate(fenicsx.compiled_expression(expression, space))
    return function


def fill_part(function, part, expression):
    """Give a part of a mixed function the values of an expression at its nodes."""
    subspace, numbers = fenicsx.collapse(function.function_space, part)
    values = fem.Function(subspace)
    values.interpolate(fenicsx.compiled_expression(expression, subspace))
    function.x.array[numbers] = values.x.array


def integral(form):
    """Value of a scalar form on a communicator of one rank."""
    return fem.assemble_scalar(fenicsx.compiled_form(form))


def error_norm(domain, difference, coordinates):
    """L2 norm of a scalar or vector expression over the bed."""
    dx = ufl.Measure("dx", domain=domain.mesh, subdomain_data=domain.cell_tags, metadata={"quadrature_degree": 6})
    return integral(coordinates.weight * ufl.inner(difference, difference) * dx(geometry.BED)) ** 0.5


def observed_orders(errors):
    """log2 of the ratio of errors on successively halved meshes."""
    return [float(np.log2(coarse / fine)) for coarse, fine in pairwise(errors)]


def divergence_of_tensor(tensor, coordinates):
    """Divergence of a symmetric tensor as `Coordinates.stress` gives it (3 x 3 with the hoop part if axisymmetric)."""
    x = ufl.SpatialCoordinate(coordinates.mesh)
    plane = coordinates.meridional(tensor)
    result = ufl.div(plane)
    if not coordinates.axisymmetric:
        return result
    return result + ufl.as_vector([plane[0, 1] / x[1], (plane[1, 1] - tensor[2, 2]) / x[1]])


def divergence_of_vector(vector, coordinates):
    """Divergence of a plane vector, with the r-part if axisymmetric."""
    x = ufl.SpatialCoordinate(coordinates.mesh)
    return ufl.div(vector) + (vector[1] / x[1] if coordinates.axisymmetric else 0.0)
