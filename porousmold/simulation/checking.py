"""Checks of a scene before a run: mesh, unknowns, memory, computing time, expected flow, and warnings.

Only the mesh is made. The number of time steps is within a factor of two in 84 % of 93 crossed scenes, the seconds of one process
on an office machine in 75 %; half of them take 0.7 to 1.5 times as long. What varies is the number of steps that errors ask for.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from dolfinx import fem

from ..mesh import domain as geometry
from ..mesh import fenicsx, ranks
from ..mesh.aliases import Communicator
from ..mesh.domain import Domain
from ..output.console import outer_wall_text
from ..scene.scene import Scene
from .accuracy import may_be_repeated
from .answers import UNSTABLE_DISPLACEMENT
from .course import Course
from .estimates import FROM_THE_WALL, Estimates
from .expected_flow import expected_mass_flow
from .mesh_quality import few_cells
from .meshing import BYTES_AN_UNKNOWN, build_domain
from .problem import sensors_of
from .run_warnings import outside_ranges
from .scene_warnings import (
    first_cell,
    of_a_narrow_bed,
    of_a_thin_core,
    warnings_of_the_first_cell,
    warnings_of_the_scene,
)
from .specs import Specs, specs_of

SECONDS_AT_THE_START, SECONDS_A_STEP = 0.9, {2: (6e-6, 4e-6), 3: (4e-5, 4e-5)}
"""For an unknown of the flow, and of the temperatures, by dimensions of space."""
OF_LOCALLY_DEVELOPED_FLOW = 1.2e-5, 3.4e-5
"""The same in three dimensions with locally developed flow, both solved by iteration (docs/growth.md)."""
STEPS_AT_THE_START, STEPS_AT_A_BREAKPOINT, STEPS_AT_A_WEAK_ONE, HEATING_TIMES = 10, 4, 0.5, 1.7
"""Steps until the largest one is reached, at the start and of every phase; those that a breakpoint of a series adds, and one at
which steps only end; heating times that the estimated duration stands for."""
STEPS_WITH_THE_WALL = 20.0
"""Of the largest length, after which the bed goes with a wall that is heated from outside: then steps grow."""
CYCLES_UNTIL_PERIODIC = 6
"""Of a run of phases that ends when its cycles repeat themselves."""
LONGEST_MESH, SHORTEST_MESH = 30.0, 0.01
"""In m: beyond, its unit is questionable."""


@dataclass(frozen=True)
class Checked:
    """`facts` and `warnings`, a sentence each."""

    facts: list[str]
    warnings: list[str]


def check(scene: Scene, communicator: Communicator) -> Checked:
    """The mesh of a scene and what follows from it (collective). Raises `InputError` for a mesh that cannot be used."""
    specs = specs_of(scene)
    domain, size, estimates = build_domain(specs, communicator)
    sensors_of(specs, domain)
    dimension, nodes = domain.mesh.topology.dim, _nodes(domain)
    flow = nodes["bed"] * specs.mesh.unknowns_per_node
    energy = nodes["all"] + (nodes["bed"] if specs.heat.model.two_temperatures else 0)
    memory = BYTES_AN_UNKNOWN[dimension] * flow
    first = first_cell(domain)
    mass_flow = expected_mass_flow(specs, size, estimates)
    least = estimates.flow_duration * (estimates.mass_flow / mass_flow if mass_flow else 1.0)
    steps = expected_steps(specs, estimates)
    iterated = dimension == 3 and scene.is_locally_developed
    of_flow, of_heat = OF_LOCALLY_DEVELOPED_FLOW if iterated else SECONDS_A_STEP[dimension]
    seconds = SECONDS_AT_THE_START + (of_flow * flow + of_heat * energy) * steps
    unit = "m2" if dimension == 3 or domain.axisymmetric else "m2 per metre of width"
    facts = [
        f"mesh: length {domain.length:.4g} m, inlet area {size.area:.4g} {unit}, {nodes['all']} nodes, {nodes['bed']} in the bed",
        f"height of the first cell at the wall: {1e3 * first:.3g} mm; {_recommended(specs, estimates)}",
        f"unknowns: about {flow} of the flow and {energy} of the temperatures; {memory / 2**30:.2g} GiB",
        f"expected computing time: {seconds:.0f} s, within a factor of two in three of four scenes, for {steps:.0f} time steps"
        f"{_repeat_text(scene, specs, estimates, (flow + energy) * steps)}",
        _flow_text(estimates, mass_flow),
        f"time steps of up to {specs.time.steps.largest or estimates.largest_step:.3g} s: {_limit_text(specs, estimates)}",
        f"bead Biot number: {estimates.bead_biot_number:.2g}",
        *(
            [f"outer wall: {outer_wall_text(dict(scene.operation))}"]
            if domain.has_outer_wall or specs.heat.wall.kind == "thin"
            else []
        ),
        *(_bound_text(estimates, least) if specs.course is None else [_phases_text(specs.course)]),
    ]
    warnings = warnings_of_the_scene(scene, specs, estimates, size) + outside_ranges(
        specs, bool(specs.heat.all_layers), {}
    )
    few = few_cells(specs, domain, size)
    warnings += [f"{few}: every answer may be off by some per cent (see solver.mesh_refinement)"] if few else []
    warnings += of_a_thin_core(scene, domain) + of_a_narrow_bed(scene, domain)
    return Checked(facts, warnings + _warnings_of_the_mesh(specs, domain, estimates, first, least))


def expected_steps(specs: Specs, estimates: Estimates) -> float:
    """Time steps until heating is over: of the largest length, and more where steps start small again."""
    time, course = specs.time, specs.course
    largest = time.largest_step(estimates.largest_step)
    duration = min(
        max(HEATING_TIMES * estimates.heating_duration, *specs.heat.inlet_temperature.breakpoints, 0.0), time.end_time
    )
    if course is not None and course.repeats:
        cycles = course.cycles if course.tolerance is None else min(course.cycles, CYCLES_UNTIL_PERIODIC)
        passages = [min(phase.duration, estimates.flow_duration) for phase in course.phases]
        duration = min(cycles * sum(passages), time.end_time)
        begins: float = STEPS_AT_THE_START * cycles * len(passages)
    elif course is not None and course.waits_for_heat:
        begins = STEPS_AT_THE_START * int(duration / course.phase.duration)
    else:
        bends = set(time.bends(largest))
        ends = sum(instant < duration for instant in time.kinks if instant not in bends)
        begins = STEPS_AT_A_BREAKPOINT * sum(instant < duration for instant in bends) + STEPS_AT_A_WEAK_ONE * ends
    changes = (0.0, *(instant for instant in time.kinks if instant < duration), duration)
    most = math.inf if estimates.step_limit != FROM_THE_WALL or time.steps.largest else STEPS_WITH_THE_WALL
    return float(
        STEPS_AT_THE_START + begins + sum(_growing((b - a) / largest, most) for a, b in pairwise(sorted(changes)))
    )


def _growing(largest_steps: float, most: float) -> float:
    """Steps in place of so many of the largest length, where from `most` on they grow with the time."""
    return largest_steps if largest_steps <= most else most * (1.0 + math.log(largest_steps / most))


def _repeat_text(scene: Scene, specs: Specs, estimates: Estimates, work: float) -> str:
    """That a run may be repeated, where it ends before all is heated, as it does where beads move against the flow, or is by a
    fluid that forms fingers in another."""
    if estimates.resistance_ratio > UNSTABLE_DISPLACEMENT and may_be_repeated(scene, work):
        return "; some ten times that, as it is repeated on finer cells (solver.refine_in_doubt)"
    is_short = specs.course is None and specs.time.end_time < HEATING_TIMES * estimates.heating_duration
    if not ((is_short or estimates.beads_against) and may_be_repeated(scene, work)):
        return ""
    return "; several times that if a front stands in the bed at the end (solver.refine_in_doubt)"


def _recommended(specs: Specs, estimates: Estimates) -> str:
    """What the first cell at the wall should be like."""
    if estimates.uniform_across and specs.mesh.size is not None:
        return "any is right: nothing changes across the bed"
    return f"recommended: about {1e3 * estimates.first_cell:.3g} mm"


def _flow_text(estimates: Estimates, mass_flow: float) -> str:
    if not estimates.flows:
        return "no flow: nothing drives the fluid"
    return (
        f"estimated flow: {estimates.driven_part * estimates.speed:.3g} m/s between the beads, bead Reynolds number "
        f"{estimates.reynolds_number:.3g}, "
        f"mass flow {mass_flow:.3g} kg/s of the modelled part"
    )


def _limit_text(specs: Specs, estimates: Estimates) -> str:
    """What keeps the steps from being longer, besides their estimated errors."""
    if specs.time.steps.largest is not None:
        return "solver.largest_step"
    name, others = estimates.step_limit, "longer" if estimates.step_limit == FROM_THE_WALL else "shorter"
    return f"the {name} takes about {estimates.step_limits[name]:.3g} s; the estimated errors may ask for {others} ones"


def _phases_text(course: Course) -> str:
    """What the run goes through."""
    names = ", ".join(phase.name for phase in course.phases)
    if not course.repeats:
        return f"the flow reverses: {names}"
    longest = f", {course.longest / 3600.0:.4g} h at most" if math.isfinite(course.longest) else ""
    return f"phases: {names}; {course.cycles} cycles at most{longest}"


def _bound_text(estimates: Estimates, least: float) -> list[str]:
    """How long heating takes at least: by what the fluid brings, or with what comes through the wall."""
    if not math.isfinite(estimates.conduction_time):
        return [f"lower bound of the heating time, from the heat capacities and the mass flow: about {least:.0f} s"]
    return [f"time constant of bed and wall that are heated from outside: about {estimates.conduction_time:.0f} s"]


def _nodes(domain: Domain) -> dict[str, int]:
    """Numbers of the mesh's nodes, and of those in the bed (collective)."""
    space = fenicsx.lagrange_space(domain.mesh)
    owned = space.dofmap.index_map.size_local
    dofs = fem.locate_dofs_topological(space, domain.mesh.topology.dim, domain.cells(geometry.BED))
    counts = {"all": owned, "bed": int(np.sum(np.asarray(dofs) < owned))}
    return {name: int(ranks.total(domain.communicator, count)) for name, count in counts.items()}


def _warnings_of_the_mesh(specs: Specs, domain: Domain, estimates: Estimates, first: float, least: float) -> list[str]:
    found = []
    is_file = specs.mesh.own.mesh is not None
    if is_file and not SHORTEST_MESH <= domain.length <= LONGEST_MESH:
        unit = (
            "mm: a mesh is read in m, so scale it by 0.001" if domain.length > LONGEST_MESH else "another unit than m"
        )
        found.append(f"geometry.mesh is {domain.length:.4g} m long: it may be in {unit}")
    found += warnings_of_the_first_cell(specs, estimates, first)
    if specs.waits_for_heat and not math.isfinite(estimates.conduction_time) and specs.time.end_time < least:
        found.append(
            f"operation.end_time {specs.time.end_time:g} s is before the lower bound of the heating time, {least:.0f} s"
        )
    last = max(specs.heat.inlet_temperature.breakpoints, default=0.0)
    if specs.course is None and specs.time.end_time < last:
        found.append(
            f"operation.end_time {specs.time.end_time:g} s is before the inlet's temperature is set last, {last:g} s"
        )
    return found
