"""Typed specifications of a simulation, made from a scene: the numerical code uses these only, never the scene.

Lengths in m, times in s, temperatures in K. None stands for what the scene leaves to the program.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from ..errors import InputError
from ..laws.air_supply import Blower
from ..laws.conductivity import STEFAN_BOLTZMANN
from ..laws.materials import Solid
from ..laws.phases import other_phase
from ..laws.porosity import Porosity
from ..laws.turbulence_models import TurbulenceModel
from ..mesh.gmsh_model import Conventions
from ..scene.checks import ASKED, RESERVED_PLACES, SMALLEST_RATIO, target_name
from ..scene.chosen_laws import Laws
from ..scene.geometries import GEOMETRIES, BedSize, dimension_of
from ..scene.phases import DRIVES, reverses
from ..scene.scene import Scene
from ..scene.sensors import sensor_names
from ..scene.series import TimeSeries
from ..scene.start import Start
from .air_loop_spec import AirLoopSpec, air_loop_of, first_point
from .course import Course, followed
from .targets import Target

CONTACT_THICKNESS = 1e-6
"""Of the layer (m) that stands for a contact resistance."""
MOST_TIMES = 2000
"""Of output that may be asked for."""
LARGEST_FLOW_TOLERANCE = 0.05
"""To which fewer steps raise the flow's tolerance at most."""
FlowKind = Literal["full", "developed", "plug"]
FlowUpdate = Literal["quasi-steady", "frozen", "transient"]
WallKind = Literal["conjugate", "thin", "fixed-temperature", "insulated"]
RevTerms = Literal["off", "consistent", "as-published"]


@dataclass(frozen=True, kw_only=True)
class MeshSpec:
    """The mesh: `size` of a straight bed, or the `file` of a mesh, whose commands are run if it is `trusted`, read by its
    `conventions`. `layers` are those of a wall with cells of its own, `opposite_layers` those of the wall opposite.

    With `is_symmetric` its two ends are alike. Cells are those of the scene before `refinement`, which counts
    `axial_refinement` times along the flow. `sensors` is the file of recorded places, `scene_file` is named in errors.
    """

    size: BedSize | None
    file: Path | None
    trusted: bool
    conventions: Conventions
    dimension: int
    axisymmetric: bool
    refine_wall: bool
    bead_diameter: float
    narrowest: float | None
    layers: tuple["LayerSpec", ...]
    opposite_layers: tuple["LayerSpec", ...]
    axial_cells: int | None
    first_cell: float | None
    cell_growth: float
    refinement: float
    axial_refinement: float
    unknowns_per_node: int
    is_symmetric: bool
    sensors: Path | None
    scene_file: str | None

    @property
    def beads_across(self) -> float | None:
        """Bead diameters in the narrowest walled width; None where that is not known."""
        return None if self.narrowest is None else self.narrowest / self.bead_diameter

    @property
    def is_too_narrow(self) -> bool:
        """Whether averages over a packing lose their meaning in it."""
        return self.beads_across is not None and self.beads_across < SMALLEST_RATIO * (1.0 - 1e-9)


@dataclass(frozen=True, kw_only=True)
class FlowSpec:
    """The flow. `drive` is one of `pressure_drop` (Pa), `inlet_velocity` (m/s, superficial) and `mass_flow` (kg/s), its course
    in time is `driven_by`. `by_blower` the pressure drop follows from the operating point of a blower."""

    kind: FlowKind
    update: FlowUpdate
    drive: str
    driven_by: TimeSeries
    by_blower: bool
    turbulence: TurbulenceModel | None
    outlet_pressure: float
    gravity: float
    rev_terms: RevTerms
    largest_averaging_diameter: float
    tolerance: float


@dataclass(frozen=True, kw_only=True)
class OuterWallSpec:
    """What the outer wall exchanges: `heat_flux` in (W/m2) times a factor, `coefficient` (W/m2/K) and radiation by an
    `emissivity` to `ambient` (K)."""

    heat_flux: TimeSeries | None
    heat_flux_factor: float
    coefficient: float | None
    emissivity: float | None
    ambient: TimeSeries | None

    def film(self, temperature: float) -> float:
        """Coefficient (W/m2/K) about a temperature (K) of the outer wall, radiation included; 0 without either."""
        return (self.coefficient or 0.0) + 4.0 * (self.emissivity or 0.0) * STEFAN_BOLTZMANN * temperature**3

    @property
    def exchanges(self) -> bool:
        """Whether heat passes to the surroundings."""
        return self.coefficient is not None or self.emissivity is not None


@dataclass(frozen=True, kw_only=True)
class LayerSpec:
    """A layer of the wall: its `thickness` (None where only the mesh knows), its `solid`, what heats it (W/m3), and its cells."""

    name: str
    solid: Solid
    thickness: float | None
    heat_source: TimeSeries | None = None
    cells: int | None = None
    is_contact: bool = False


@dataclass(frozen=True, kw_only=True)
class HeatSpec:
    """The temperatures: two or one in the bed, `bead_modes` inside the beads, beads that move along the flow, and the wall,
    whose `layers` are counted outwards: a plain wall is one; there are none without a wall. Those of the wall opposite,
    `opposite_layers`, have a place of their own only where the whole cavity is modelled. At first everything has the
    `initial_temperature`, or what `start` tells, of which that is the mean."""

    two_temperatures: bool
    bead_modes: int | None
    exchange_factor: float
    emissivity: float
    wall: WallKind
    layers: tuple[LayerSpec, ...]
    opposite_layers: tuple[LayerSpec, ...]
    wall_temperature: TimeSeries | None
    outer_wall: OuterWallSpec
    initial_temperature: float
    start: Start | None
    inlet_temperature: TimeSeries
    air_loop: AirLoopSpec | None
    bead_velocity: float
    bead_inlet_temperature: TimeSeries | None

    @property
    def all_layers(self) -> tuple[LayerSpec, ...]:
        """Of both walls, as the mesh's tags count them."""
        return self.layers + self.opposite_layers

    @property
    def given_elsewhere(self) -> list[TimeSeries]:
        """Temperatures (K) that are given besides that of the fluid: outside, of the wall, of beads that enter."""
        series = (self.outer_wall.ambient, self.wall_temperature, self.bead_inlet_temperature)
        return [one for one in series if one is not None]

    @property
    def first_temperatures(self) -> tuple[float, float]:
        """Lowest and highest temperature (K) at the start."""
        return (self.initial_temperature,) * 2 if self.start is None else self.start.range

    def is_heated_by_inflow(self, margin: float) -> bool:
        """Whether the wall is waited for until it is within a margin (K) of the fluid that flows in."""
        differences = [
            abs(value - first) for value in self.inlet_temperature.range for first in self.first_temperatures
        ]
        return self.wall != "fixed-temperature" and max(differences) > margin


@dataclass(frozen=True, kw_only=True)
class TimeSpec:
    """The march: steps before `refinement`, `breakpoints` at which steps end, whether it `keeps_bounds` of the temperatures, and
    when the `heated_place` (the wall, or a part) counts as heated: all of it within `margin` (K) of the inlet's temperature. With
    `targets` the march goes on until these are met; `until_steady` ends it where the temperatures are steady before that."""

    first_step: float | None
    step_growth: float
    largest_step: float | None
    refinement: float
    tolerance: float | None
    keeps_bounds: bool
    end_time: float
    until_steady: bool
    margin: float
    heated_place: str
    targets: tuple[Target, ...]
    breakpoints: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class OutputSpec:
    """What is kept: fields at `field_times` times, or at given `times` (s) together with profiles along the bed; a checkpoint
    every `checkpoint_interval` s of the clock."""

    fields: bool
    field_times: int
    times: tuple[float, ...]
    checkpoint_interval: float


@dataclass(frozen=True, kw_only=True)
class Specs:
    """All parts of a scene, its laws, and the `course` of a flow that reverses or has phases."""

    mesh: MeshSpec
    flow: FlowSpec
    heat: HeatSpec
    time: TimeSpec
    output: OutputSpec
    laws: Laws
    course: Course | None = None

    @property
    def waits_for_heat(self) -> bool:
        """Whether the wall is waited for until it is as warm as what flows in."""
        is_one = self.course is None or self.course.waits_for_heat
        return is_one and self.heat.is_heated_by_inflow(self.time.margin)

    @property
    def porosity(self) -> Porosity:
        """Porosity against wall distance."""
        return self.laws.porosity


def specs_of(scene: Scene) -> Specs:
    """The parts of a scene."""
    laws = Laws.of(scene)
    _require_phase(scene, laws)
    air_loop, course = air_loop_of(scene, laws.fluid), Course.of(scene)
    return Specs(
        mesh=_mesh(scene, laws),
        flow=_flow(scene, laws, None if air_loop is None else air_loop.blower, course),
        heat=_heat(scene, laws, air_loop, course),
        time=_time(scene, course),
        course=course,
        output=OutputSpec(
            fields=scene.output.fields,
            field_times=scene.output.field_times,
            times=_output_times(scene),
            checkpoint_interval=scene.output.checkpoint_interval,
        ),
        laws=laws,
    )


def _given_to_the_fluid(scene: Scene) -> Iterator[tuple[str, float]]:
    """(key, temperature in K) of what the fluid is given: the ends of every range."""
    operation = scene.operation
    yield from (
        ("initial_temperature", one) for one in (scene.start.range if scene.start else (operation.initial_temperature,))
    )
    for name in ("inlet_temperature", "return_temperature", "fresh_temperature"):
        value = getattr(operation, name)
        if value is not None:
            yield from ((name, one) for one in (value.range if isinstance(value, TimeSeries) else (value,)))


def _require_phase(scene: Scene, laws: Laws) -> None:
    """Raise `InputError` where a temperature that is given for the fluid makes another phase of it, or nonsense of a material:
    a polynomial far outside its range."""
    pressure = scene.operation.outlet_pressure
    materials = laws.materials(scene.model.wall in ("conjugate", "thin"))
    for name, temperature in _given_to_the_fluid(scene):
        key = f"operation.{name}"
        if (text := other_phase(laws.fluid.name, pressure, temperature)) is not None:
            raise InputError(key, temperature, f"does not fit fluid.material: {text}", scene.source)
        for owner, material in materials.items():
            for what, law in material.laws().items():
                arguments = (pressure,) if owner == "fluid" and what == "density" else ()
                found = float(law(*arguments, temperature))
                if not 0.0 < found < math.inf:
                    low, high = (f"{limit - 273.15:.1f}" for limit in law.temperature_range)
                    allowed = f"{material.name} {what}, which is given for {low} to {high} °C, has no value there"
                    raise InputError(key, temperature, allowed, scene.source)


def _mesh(scene: Scene, laws: Laws) -> MeshSpec:
    geometry, solver = scene.geometry, scene.solver
    kind = GEOMETRIES[geometry.kind]
    size = kind.size(geometry)
    widths = [getattr(geometry, n) for n in kind.widths if not (n == "width" and geometry.sides == "symmetry")]
    dimension = dimension_of(geometry)
    turbulent = 0 if laws.turbulence is None else len(laws.turbulence.unknowns)
    velocity_and_pressure = {"full": dimension + 1, "developed": 1, "plug": 0}[scene.model.flow]
    if scene.model.flow == "developed" and (size is None or size.half_width is not None):
        turbulent = 0  # one equation of the pressure, whatever the profiles hold
    return MeshSpec(
        size=size,
        file=geometry.mesh,
        trusted=scene.allow_extensions,
        conventions=Conventions(geometry.scale, geometry.groups or {}, geometry.join_nodes),
        dimension=dimension,
        refine_wall=geometry.refine_wall,
        axisymmetric=geometry.symmetry == "axisymmetric" if size is None else size.axisymmetric,
        bead_diameter=scene.bed.bead_diameter,
        narrowest=min((width for width in widths if width), default=None),
        layers=_layers(scene, laws) if scene.model.wall == "conjugate" else (),
        opposite_layers=_layers_of(scene.wall.opposite_layer or (), laws),
        axial_cells=solver.axial_cells,
        first_cell=solver.first_cell,
        cell_growth=solver.cell_growth,
        refinement=solver.mesh_refinement,
        axial_refinement=solver.axial_refinement,
        unknowns_per_node=max(velocity_and_pressure + turbulent, 1),
        is_symmetric=reverses(scene),
        sensors=geometry.sensors,
        scene_file=scene.source,
    )


def _flow(scene: Scene, laws: Laws, blower: Blower | None, course: Course | None) -> FlowSpec:
    operation, model, bed = scene.operation, scene.model, scene.bed
    if blower is None:
        drive = next(name for name in DRIVES if getattr(operation, name) is not None)
        driven_by = getattr(operation, drive).thinned()
        if course is not None:
            driven_by = followed([driven_by], course.drive)
    else:
        drive, driven_by = "pressure_drop", TimeSeries.constant(first_point(scene, laws, blower))
    return FlowSpec(
        kind=model.flow,
        update=model.flow_update,
        drive=drive,
        driven_by=driven_by,
        by_blower=blower is not None,
        turbulence=laws.turbulence,
        outlet_pressure=operation.outlet_pressure,
        gravity=operation.gravity,
        rev_terms=model.rev_terms,
        largest_averaging_diameter=bed.averaging_diameter_ratio * bed.bead_diameter,
        tolerance=_flow_tolerance(scene.solver.flow_tolerance, scene.solver.step_refinement),
    )


def _flow_tolerance(tolerance: float, step_refinement: float) -> float:
    """That of a run's own steps."""
    return min(tolerance / step_refinement, max(tolerance, LARGEST_FLOW_TOLERANCE))


def _thinned(series: TimeSeries | None) -> TimeSeries | None:
    return None if series is None else series.thinned()


def _layers(scene: Scene, laws: Laws) -> tuple[LayerSpec, ...]:
    if scene.wall.layer is None:
        if scene.model.wall not in ("conjugate", "thin"):
            return ()
        cells = scene.solver.wall_cells
        return (LayerSpec(name="wall", solid=laws.walls["wall"], thickness=scene.wall.thickness, cells=cells),)
    return _layers_of(scene.wall.layer, laws)


def _layers_of(entries: Sequence[Any], laws: Laws) -> tuple[LayerSpec, ...]:
    """The layers of one wall from its entries in the scene, with its contacts."""
    layers = []
    for given in entries:
        name, source, cells = given.name or given.material, _thinned(given.heat_source), given.cells
        solid = laws.walls[name]
        layers.append(LayerSpec(name=name, solid=solid, thickness=given.thickness, heat_source=source, cells=cells))
        if given.contact_resistance > 0.0:
            layers.append(contact(f"{name} contact", given.contact_resistance))
    return tuple(layers)


def contact(name: str, resistance: float) -> LayerSpec:
    """A contact resistance (m2 K/W) as a layer of one cell that conducts as much through it, nothing along it, and stores
    nothing: within `CONTACT_THICKNESS` over the wall's own exact."""
    nothing, source = 1e-9, "contact resistance of the scene"
    solid = Solid(name, nothing, 1.0, CONTACT_THICKNESS / resistance, source, conductivity_in_plane=nothing)
    return LayerSpec(name=name, solid=solid, thickness=CONTACT_THICKNESS, cells=1, is_contact=True)


def _heat(scene: Scene, laws: Laws, air_loop: AirLoopSpec | None, course: Course | None) -> HeatSpec:
    operation, model = scene.operation, scene.model
    inlet_temperature = operation.inlet_temperature.thinned()
    if course is not None:
        back = () if operation.return_temperature is None else (operation.return_temperature.thinned(),)
        inlet_temperature = followed([*back, inlet_temperature], course.temperature)
    return HeatSpec(
        two_temperatures=model.energy == "two-temperature",
        bead_modes=model.bead_modes,
        exchange_factor=model.exchange_factor,
        emissivity=scene.bed.emissivity,
        wall=model.wall,
        layers=_layers(scene, laws),
        opposite_layers=_layers_of(scene.wall.opposite_layer or (), laws),
        wall_temperature=_thinned(operation.wall_temperature),
        outer_wall=OuterWallSpec(
            heat_flux=_thinned(operation.outer_heat_flux),
            heat_flux_factor=operation.outer_heat_flux_factor,
            coefficient=operation.outer_coefficient,
            emissivity=operation.outer_emissivity,
            ambient=_thinned(operation.ambient_temperature),
        ),
        initial_temperature=operation.initial_temperature,
        start=scene.start,
        inlet_temperature=inlet_temperature,
        air_loop=air_loop,
        bead_velocity=operation.bead_velocity,
        bead_inlet_temperature=_thinned(operation.bead_inlet_temperature),
    )


def _targets(scene: Scene) -> tuple[Target, ...]:
    found, operation, sensors = [], scene.operation, sensor_names(scene.geometry.sensors)
    layers = [layer.name or layer.material for layer in scene.layers.values()]
    for target in scene.target.list or ():
        asks = next(name for name in ASKED if getattr(target, name) is not None)
        initial = operation.initial_temperature
        farthest = max(operation.inlet_temperature.values, key=lambda value: abs(value - initial))
        found.append(
            Target(
                name=target_name(target),
                place=target.place,
                asks=asks,
                limit=getattr(target, asks),
                is_sensor=target.place in sensors and target.place not in (*RESERVED_PLACES, *layers),
                initial=initial,
                final=farthest,
                keep=target.keep,
            )
        )
    return tuple(found)


def _time(scene: Scene, course: Course | None) -> TimeSpec:
    operation, solver = scene.operation, scene.solver
    series: list[Any] = [value.thinned() for _, value in operation if isinstance(value, TimeSeries)]
    series += [layer.heat_source.thinned() for layer in scene.layers.values() if layer.heat_source is not None]
    return TimeSpec(
        first_step=solver.first_step,
        step_growth=solver.step_growth,
        largest_step=solver.largest_step,
        refinement=solver.step_refinement,
        tolerance=solver.step_tolerance,
        keeps_bounds=solver.keep_bounds,
        end_time=_end_time(scene, course),
        until_steady=not scene.is_given("operation.end_time") and not (course is not None and course.repeats),
        margin=operation.heating_margin,
        heated_place=operation.heated_place,
        targets=_targets(scene),
        breakpoints=tuple(sorted({instant for each in series for instant in each.breakpoints if instant > 0.0})),
    )


def _end_time(scene: Scene, course: Course | None) -> float:
    """Of phases that end by themselves, when they are through; without a given end each may last as long as the default."""
    given = float(scene.operation.end_time)
    if course is None or not course.repeats:
        return given
    if scene.is_given("operation.end_time"):
        return min(course.longest, given)
    phases = (min(phase.duration, given) if phase.side is not None else phase.duration for phase in course.phases)
    return course.cycles * sum(phases)


def _output_times(scene: Scene) -> tuple[float, ...]:
    every, times = scene.output.every, scene.output.times
    if every is None:
        return times or ()
    count = int(scene.operation.end_time / every)
    if count > MOST_TIMES:
        allowed = f"makes {count} times up to operation.end_time {scene.operation.end_time:g} s: at most {MOST_TIMES}"
        raise InputError("output.every", every, allowed, scene.source)
    return tuple(every * number for number in range(1, count + 1))
