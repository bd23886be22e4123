"""Output of fields: the profile near the wall, and snapshots over time."""

import contextlib
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from ..arrays import Floats
from ..laws.turbulence_models import LocalFlow
from ..mesh import domain as geometry
from ..mesh import fenicsx
from ..mesh.aliases import Space
from ..mesh.point_values import nodal_values
from ..mesh.probe import PointProbe
from ..output.quantities import Columns
from ..solvers.state import Arrays
from .course import Course
from .problem import Problem
from .snapshots import SAME_TIME, Snapshot

DECIMALS_OF_TIME = 6
"""By which dolfinx names fields in a file: times (s) that they do not tell apart would be one name."""


def profile_near_wall(problem: Problem, fraction: float = 0.5, points: int = 120) -> Columns | None:
    """Columns of porosity and flow against wall distance on the line from wall to centre at a fraction
    of the length (collective); None where the domain has no centre line within the mesh."""
    stations = problem.domain.stations(fraction)
    if "centre" not in stations:
        return None
    wall, centre = np.array(stations["bed_side"]), np.array(stations["centre"])
    if np.array_equal(wall, centre):  # at the end of a mesh whose nearest nodes are one
        return None
    distance = np.linalg.norm(centre - wall) * np.concatenate([[0.0], np.geomspace(2e-4, 1.0, points - 1)])
    line = np.asarray(wall + np.outer(distance / distance[-1], centre - wall), float)
    try:
        probe = PointProbe(problem.domain, line)
    except ValueError:  # the straight line leaves a mesh that is not convex; on every rank alike
        return None
    depths = fem.Function(fenicsx.lagrange_space(problem.domain.mesh))
    depths.x.array[:] = nodal_values(problem.domain.wall_distance, depths.function_space).clip(min=0.0)
    distance = probe(depths)[:, 0]  # the line is not along the normal of a curved wall
    fields = problem.flow.fields()
    temperature, beads = (probe(function)[:, 0] for function in (problem.temperature, problem.bead_temperature))
    specs, laws = problem.specs, problem.specs.laws
    porosity = specs.porosity.volume(distance, specs.mesh.bead_diameter)
    speed = np.linalg.norm(probe(fields["velocity"]), axis=1)
    profile = Columns()
    profile.add("wall_distance", distance)
    profile.add("porosity", porosity)
    profile.add("speed", speed)
    profile.add("fluid_temperature", temperature)
    profile.add("bead_temperature", beads)
    if laws.turbulence is not None:
        for unknown in laws.turbulence.unknowns[:1]:
            profile.add(unknown.name, probe(fields[unknown.name])[:, 0])
        # of the nodes: k^2/epsilon of values that are linear between them would have a cusp in every cell
        eddies = _FieldsOfTheBed(problem, problem.medium.flow_temperature.function_space).now()[-1]
        profile.add("eddy_viscosity_ratio", probe(eddies)[:, 0])
    return profile


def _eddy_viscosity_ratio(
    problem: Problem,
    distance: Floats,
    speed: Floats,
    pressure: Floats,
    temperature: Floats,
    unknowns: Sequence[Floats],
    shear_rate_squared: Floats,
) -> Any:
    """mu_t/mu at points of the bed, from the turbulence's unknowns and the rest of the flow there (SI)."""
    specs, laws = problem.specs, problem.specs.laws
    assert laws.turbulence is not None
    diameter = specs.mesh.bead_diameter
    viscosity = laws.fluid.viscosity(temperature)
    density = laws.fluid.density(pressure + specs.flow.outlet_pressure, temperature)
    porosity, off_wall = specs.porosity.volume(distance, diameter), np.maximum(distance, 1e-12)
    local = LocalFlow(porosity, diameter, off_wall, density, viscosity, speed, problem.medium.estimates.speed)
    return laws.turbulence.state(unknowns, local, shear_rate_squared).eddy_viscosity / viscosity


def field_snapshots(
    problem: Problem, snapshots: Sequence[Snapshot], end_time: float
) -> Iterator[tuple[float, list[fem.Function]]]:
    """(time, functions) at `output.times` and the end, or at about `output.field_times` times evenly spread up to it: linear
    between snapshots that are one step apart, else the nearest one, at its own time (collective)."""
    snapshots = snapshots or [Snapshot(end_time, 0, problem.solution.arrays())]
    output, course = problem.specs.output, problem.specs.course
    shown: Iterable[tuple[float, Arrays]] = (
        ((one.time, one.solution) for one in snapshots)
        if output.times
        else _near(snapshots, end_time * np.linspace(0.0, 1.0, output.field_times + 1)[1:], course)
    )
    of_the_bed = _FieldsOfTheBed(problem, problem.medium.flow_temperature.function_space)
    named = None
    for time, solution in shown:
        if round(time, DECIMALS_OF_TIME) == named:
            continue
        named = round(time, DECIMALS_OF_TIME)
        turned = course is not None and course.direction(time) < 0
        with _shown(problem, solution):
            temperature, beads = problem.temperature, problem.bead_temperature
            temperature.name, beads.name = "temperature", "bead_temperature"
            fields = problem.flow.fields()
            functions = [temperature, beads, *fields.values(), *of_the_bed.now()]
        if turned:
            problem.mirror.vectors(fields["velocity"])
            problem.mirror(*(function for function in functions if function is not fields["velocity"]))
        yield time, functions


@contextlib.contextmanager
def _shown(problem: Problem, snapshot: Arrays) -> Iterator[None]:
    """The problem with the solution of a snapshot, for a while; then its state is as it was, whatever happens."""
    now = problem.state.copy()
    try:
        problem.solution.set(snapshot)
        problem.medium.flow_temperature.x.array[:] = (
            problem.temperature.x.array
        )  # what the velocity's density belongs to
        yield
    finally:
        problem.state.put_back(now)


def _near(snapshots: Sequence[Snapshot], wanted: Floats, course: Course | None) -> Iterator[tuple[float, Arrays]]:
    """(time, solution) at or near the times (s) wanted."""
    times = np.array([one.time for one in snapshots])
    for time in map(float, wanted):
        after = min(int(np.searchsorted(times, time * (1.0 - SAME_TIME))), len(times) - 1)
        early, late = snapshots[max(after - 1, 0)], snapshots[after]
        in_one_phase = course is None or course.phase_number(early.time) == course.phase_number(late.time)
        if early.time < time < late.time and late.step == early.step + 1 and in_one_phase:
            part, ends = (time - early.time) / (late.time - early.time), late.solution
            yield time, {name: (1.0 - part) * array + part * ends[name] for name, array in early.solution.items()}
        else:
            nearest = min(early, late, key=lambda one: abs(one.time - time))
            yield nearest.time, nearest.solution


class _FieldsOfTheBed:
    """Where bed and wall are, the porosity, and the eddy viscosity of the present flow, as functions."""

    def __init__(self, problem: Problem, space: Space) -> None:
        self._problem, domain = problem, problem.domain
        mesh = domain.mesh
        self._nodes = fem.locate_dofs_topological(space, mesh.topology.dim, domain.cells(geometry.BED))
        self._distance = nodal_values(domain.wall_distance, space).clip(min=0.0)[self._nodes]
        self._in_bed, self._porosity, self._eddies = (
            fem.Function(space, name=name) for name in ("in_bed", "porosity", "eddy_viscosity_ratio")
        )
        self._shear: tuple[fem.Function, Any, fem.Function] | None = None
        self._in_bed.x.array[self._nodes] = 1.0
        self._porosity.x.array[self._nodes] = problem.specs.porosity.volume(
            self._distance, problem.specs.mesh.bead_diameter
        )
        self._region = fem.Function(fenicsx.cell_constant_space(mesh), name="region")
        for number, tag in enumerate(domain.wall_tags, start=1):
            self._region.x.array[domain.cells(tag)] = number

    def now(self) -> list[fem.Function]:
        """The functions, with what changes with the flow renewed."""
        turbulence = self._problem.specs.laws.turbulence
        if turbulence is None:
            return [self._in_bed, self._porosity, self._region]
        fields, at = self._problem.flow.fields(), self._nodes
        velocity = fields["velocity"]
        speed = np.linalg.norm(velocity.x.array.reshape(len(self._eddies.x.array), -1), axis=1)[at]
        pressure, temperature = fields["pressure"].x.array[at], self._problem.temperature.x.array[at]
        unknowns = [fields[unknown.name].x.array[at] for unknown in turbulence.unknowns]
        self._eddies.x.array[at] = _eddy_viscosity_ratio(
            self._problem,
            self._distance,
            speed,
            pressure,
            temperature,
            unknowns,
            self._shear_rate_squared(velocity)[at],
        )
        return [self._in_bed, self._porosity, self._region, self._eddies]

    def _shear_rate_squared(self, velocity: fem.Function) -> Floats:
        """2 S:S at the nodes."""
        if self._shear is None:
            strain, space = ufl.sym(ufl.grad(velocity)), self._eddies.function_space
            expression = fenicsx.compiled_expression(2.0 * ufl.inner(strain, strain), space)
            self._shear = velocity, expression, fem.Function(space)
        held, expression, nodal = self._shear
        held.x.array[:] = velocity.x.array
        nodal.interpolate(expression)
        return nodal.x.array
