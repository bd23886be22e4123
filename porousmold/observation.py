"""What a run shows of its fields: the profile near the wall and the snapshots over time."""

import numpy as np
from dolfinx import fem

from . import geometry
from .equations.turbulence import TwoLayerState
from .porosity.models import POROSITY_MODELS
from .probe import PointProbe


def profile_near_wall(problem, fraction=0.5, points=120):
    """Columns and units of porosity and flow against wall distance on the line from wall to centre at a fraction
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
    if problem.scene.profile is None:
        bed = problem.scene.bed
        porosity = POROSITY_MODELS[bed.porosity_model](distance, bed.bead_diameter, bed.bulk_porosity)
    else:
        porosity = problem.scene.profile(distance, problem.scene.bed.bead_diameter)[0]
    columns = {
        "wall_distance": distance,
        "porosity": porosity + np.zeros_like(distance),
        "speed": np.linalg.norm(values["velocity"], axis=1),
        "fluid_temperature": temperature,
        "bead_temperature": beads,
    }
    units = {
        "wall_distance": "m",
        "porosity": "1",
        "speed": "m/s",
        "fluid_temperature": "K",
        "bead_temperature": "K",
    }
    if problem.equations.model is not None:
        absolute = values["pressure"][:, 0] + problem.scene.operation.outlet_pressure
        viscosity = problem.laws.fluid.viscosity(temperature)
        layers = TwoLayerState(
            values["turbulent_kinetic_energy"][:, 0],
            values["dissipation_rate"][:, 0],
            problem.laws.fluid.density(absolute, temperature),
            viscosity,
            np.maximum(distance, 1e-12),
            problem.estimates.speed**2,
            problem.laws.turbulence.blend_half_width,
            problem.laws.turbulence.longest_eddy * problem.scene.bed.bead_diameter,
        )
        columns["turbulent_kinetic_energy"] = values["turbulent_kinetic_energy"][:, 0]
        columns["eddy_viscosity_ratio"] = layers.eddy_viscosity / viscosity
        units |= {"turbulent_kinetic_energy": "m2/s2", "eddy_viscosity_ratio": "1"}
    return {name: list(map(float, column)) for name, column in columns.items()}, units


def field_snapshots(problem, snapshots, end_time):
    """(time, functions) at `output.field_times` times spread geometrically up to the end (collective)."""
    wanted = end_time * 0.5 ** np.arange(problem.scene.output.field_times - 1, -1, -1)
    times = np.array([snapshot[0] for snapshot in snapshots])
    space = problem.flow_temperature.function_space
    in_bed = fem.Function(space, name="in_bed")
    dimension = problem.domain.mesh.topology.dim
    in_bed.x.array[fem.locate_dofs_topological(space, dimension, problem.domain.cells(geometry.BED))] = 1.0
    now, flow_temperature = problem.state(), problem.flow_temperature.x.array.copy()
    for index in sorted({int(np.argmin(np.abs(times - time))) for time in wanted}):
        time, state = snapshots[index]
        problem.set_state(state)
        temperature, beads = problem.temperature, problem.bead_temperature
        problem.flow_temperature.x.array[:] = temperature.x.array  # the density that the velocity belongs to
        temperature.name, beads.name = "temperature", "bead_temperature"
        yield time, [in_bed, temperature, beads, *problem.flow.fields().values()]
    problem.set_state(now)
    problem.flow_temperature.x.array[:] = flow_temperature
