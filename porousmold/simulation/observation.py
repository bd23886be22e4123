"""What a run shows of its fields: the profile near the wall and the snapshots over time."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from dolfinx import fem
from numpy.typing import NDArray

from ..laws.turbulence_models import LocalFlow
from ..mesh import domain as geometry
from ..mesh.probe import PointProbe
from ..output.quantities import Columns
from .problem import Problem


def profile_near_wall(problem: Problem, fraction: float = 0.5, points: int = 120) -> Columns | None:
    """Columns of porosity and flow against wall distance on the line from wall to centre at a fraction
    of the length (collective); None where the domain has no centre line within the mesh."""
    stations = problem.domain.stations(fraction)
    if "centre" not in stations:
        return None
    wall, centre = np.array(stations["bed_side"]), np.array(stations["centre"])
    distance = np.linalg.norm(centre - wall) * np.concatenate([[0.0], np.geomspace(2e-4, 1.0, points - 1)])
    line = wall + np.outer(distance / distance[-1], centre - wall)
    try:
        probe = PointProbe(problem.domain, line)
    except ValueError:  # the straight line leaves a mesh that is not convex; on every rank alike
        return None
    values = {name: probe(function) for name, function in problem.flow.fields().items()}
    temperature, beads = (probe(function)[:, 0] for function in (problem.temperature, problem.bead_temperature))
    specs, laws = problem.specs, problem.specs.laws
    diameter = specs.mesh.bead_diameter
    porosity = specs.porosity.volume(distance, diameter)
    speed = np.linalg.norm(values["velocity"], axis=1)
    profile = Columns()
    profile.add("wall_distance", distance)
    profile.add("porosity", porosity)
    profile.add("speed", speed)
    profile.add("fluid_temperature", temperature)
    profile.add("bead_temperature", beads)
    if laws.turbulence is not None:
        viscosity = laws.fluid.viscosity(temperature)
        density = laws.fluid.density(values["pressure"][:, 0] + specs.flow.outlet_pressure, temperature)
        off_wall = np.maximum(distance, 1e-12)
        local = LocalFlow(porosity, diameter, off_wall, density, viscosity, speed, problem.medium.estimates.speed)
        shear = np.gradient(speed, distance) ** 2
        unknowns = [values[unknown.name][:, 0] for unknown in laws.turbulence.unknowns]
        if unknowns:
            profile.add(laws.turbulence.unknowns[0].name, unknowns[0])
        eddies = laws.turbulence.state(unknowns, local, shear).eddy_viscosity
        profile.add("eddy_viscosity_ratio", eddies / viscosity)
    return profile


def field_snapshots(
    problem: Problem, snapshots: Sequence[tuple[float, list[NDArray[Any]]]], end_time: float
) -> Iterator[tuple[float, list[fem.Function]]]:
    """(time, functions) at `output.field_times` times spread geometrically up to the end (collective)."""
    wanted = end_time * 0.5 ** np.arange(problem.specs.output.field_times - 1, -1, -1)
    times = np.array([snapshot[0] for snapshot in snapshots])
    space = problem.medium.flow_temperature.function_space
    in_bed = fem.Function(space, name="in_bed")
    dimension = problem.domain.mesh.topology.dim
    in_bed.x.array[fem.locate_dofs_topological(space, dimension, problem.domain.cells(geometry.BED))] = 1.0
    now, flow_temperature = problem.state(), problem.medium.flow_temperature.x.array.copy()
    for index in sorted({int(np.argmin(np.abs(times - time))) for time in wanted}):
        time, state = snapshots[index]
        problem.set_state(state)
        temperature, beads = problem.temperature, problem.bead_temperature
        problem.medium.flow_temperature.x.array[:] = temperature.x.array  # the density that the velocity belongs to
        temperature.name, beads.name = "temperature", "bead_temperature"
        yield time, [in_bed, temperature, beads, *problem.flow.fields().values()]
    problem.set_state(now)
    problem.medium.flow_temperature.x.array[:] = flow_temperature
