"""Typed specifications of a simulation, made from a scene: the numerical code uses these only, never the scene.

Lengths in m, times in s, temperatures in K. None stands for what the scene leaves to the program.
"""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from ..laws.air_supply import Blower
from ..laws.porosity import Porosity
from ..laws.turbulence_models import TurbulenceModel
from ..mesh.gmsh_model import Conventions
from ..scene.chosen_laws import Laws, require_phase
from ..scene.features import KEYS
from ..scene.features.air_loop import share_of
from ..scene.features.bed import SMALLEST_RATIO, AveragingVolume
from ..scene.features.drive import Drive
from ..scene.features.energy_model import EnergyModel
from ..scene.features.flow_model import FlowModel
from ..scene.features.geometries import GEOMETRIES, BedSize, dimension_of
from ..scene.features.moving_beads import BeadMotion
from ..scene.features.numerics import Cells, TimeSteps
from ..scene.features.outer_wall import OuterWall
from ..scene.features.output import Output
from ..scene.features.own_mesh import OwnMesh
from ..scene.features.phases import reverses
from ..scene.features.sensors import Sensors
from ..scene.features.targets import Heated, series_of
from ..scene.features.wall import BedWall, Layer
from ..scene.keys import key_of
from ..scene.scene import Scene
from ..scene.series import TimeSeries
from ..scene.start import Start
from ..scene.thinning import scale_of, with_thinned_series
from .air_loop_spec import AirLoopSpec, air_loop_of, first_point
from .course import Course, followed
from .heat_capacity_peaks import heats_where_it_melts
from .targets import Target, targets_of

BEYOND_GIVEN = 100.0
"""Kelvins beyond all that is given, which sources, cure and a given flux may bring a wall to."""
LEAST_BEND = 0.1
"""Of the scale of a series, a bend within a largest step after which steps start small again; at a weaker one they only end."""


@dataclass(frozen=True, kw_only=True)
class MeshSpec:
    """The mesh: `size` of a straight bed, or the `file` of a mesh, whose commands are run if it is `trusted`, read by its
    `conventions`. `layers` are those of a wall with cells of its own, `opposite_layers` those of the wall opposite.

    With `is_symmetric` its two ends are alike. `sensors` are recorded places, `scene_file` is named in errors.
    """

    size: BedSize | None
    own: OwnMesh
    trusted: bool
    dimension: int
    axisymmetric: bool
    bead_diameter: float
    narrowest: float | None
    layers: tuple[Layer, ...]
    opposite_layers: tuple[Layer, ...]
    cells: Cells
    unknowns_per_node: int
    is_symmetric: bool
    sensors: Sensors
    scene_file: str | None

    @property
    def conventions(self) -> Conventions:
        """How the file of a mesh is read."""
        return Conventions(self.own.scale, self.own.groups or {}, self.own.join_nodes)

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
    in time is `driven_by`. `by_blower` the pressure drop follows from the operating point of a blower; `tolerance` is that of
    the flow in a run's own steps."""

    model: FlowModel
    drive: str
    driven_by: TimeSeries
    by_blower: bool
    turbulence: TurbulenceModel | None
    outlet_pressure: float
    gravity: float
    averaging: AveragingVolume
    tolerance: float


@dataclass(frozen=True, kw_only=True)
class HeatSpec:
    """The temperatures in the bed, those of beads that move along it, and the wall, whose `layers` are counted outwards, with
    those of the wall opposite. At first everything has the `initial_temperature`, or what `start` tells, of which that is the
    mean."""

    model: EnergyModel
    emissivity: float
    wall: BedWall
    layers: tuple[Layer, ...]
    opposite_layers: tuple[Layer, ...]
    outer_wall: OuterWall
    initial_temperature: float
    start: Start | None
    inlet_temperature: TimeSeries
    air_loop: AirLoopSpec | None
    bead_motion: BeadMotion

    @property
    def all_layers(self) -> tuple[Layer, ...]:
        """Of both walls, as the mesh's tags count them."""
        return self.layers + self.opposite_layers

    @property
    def given_elsewhere(self) -> list[TimeSeries]:
        """Temperatures (K) that are given besides that of the fluid: outside, of the wall, of beads that enter."""
        series = (self.outer_wall.ambient, self.wall.temperature, self.bead_motion.inlet_temperature)
        return [one for one in series if one is not None]

    @property
    def first_temperatures(self) -> tuple[float, float]:
        """Lowest and highest temperature (K) at the start."""
        return (self.initial_temperature,) * 2 if self.start is None else self.start.range

    @property
    def given_bounds(self) -> tuple[float, float]:
        """Lowest and highest temperature (K) that are given."""
        given = [*self.first_temperatures, *self.inlet_temperature.range]
        for series in self.given_elsewhere:
            given += series.range
        if self.air_loop is not None:
            given.append(self.air_loop.supply.fresh_temperature)
        return min(given), max(given)

    @property
    def is_open(self) -> tuple[bool, bool]:
        """Whether the wall may become colder, and hotter, than all that is given: by sources, cure, or a given flux."""
        ranges = [layer.heat_source.range for layer in self.all_layers if layer.heat_source is not None]
        if self.outer_wall.heat_flux is not None:
            ranges.append(self.outer_wall.heat_flux.range)
        cures = any(layer.solid.cure is not None for layer in self.all_layers)
        return any(least < 0.0 for least, _ in ranges), cures or any(most > 0.0 for _, most in ranges)

    @property
    def reached(self) -> tuple[float, float]:
        """Lowest and highest temperature (K) that are given, or may be reached beyond them."""
        (low, high), (colder, hotter) = self.given_bounds, self.is_open
        return low - BEYOND_GIVEN * colder, high + BEYOND_GIVEN * hotter

    @property
    def is_wall_held(self) -> bool:
        """Whether the wall has the temperature that is given for it."""
        return self.wall.kind == "fixed-temperature"

    @property
    def largest_of_inflow(self) -> float:
        """Largest difference (K) of what flows in from the start."""
        return max(abs(value - first) for value in self.inlet_temperature.range for first in self.first_temperatures)

    def is_heated_by_inflow(self, place: str, margin: float) -> bool:
        """Whether a place is waited for until it is within a margin (K) of the fluid that flows in: beside a wall whose
        temperature is given only the bed."""
        return (place == "bed" or not self.is_wall_held) and self.largest_of_inflow > margin


@dataclass(frozen=True, kw_only=True)
class TimeSpec:
    """The integration: its steps, what it waits for, the place to be `heated`, or `targets` until these are met, and by how much
    what is given bends (1/s, over its scale) at which times: `kinks`. `until_steady` ends it where the temperatures are steady
    before `end_time`."""

    steps: TimeSteps
    heated: Heated
    end_time: float
    until_steady: bool
    targets: tuple[Target, ...]
    kinks: Mapping[float, float]

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times (s) at which steps end."""
        return tuple(sorted(self.kinks))

    def largest_step(self, estimated: float) -> float:
        """The one given (s), else an estimated one, no longer than the run."""
        return self.steps.largest or min(estimated, self.end_time)

    def bends(self, largest_step: float) -> tuple[float, ...]:
        """Those of them after which steps start small again: where a series bends by much within a largest step (s)."""
        return tuple(sorted(time for time, bend in self.kinks.items() if bend * largest_step > LEAST_BEND))


@dataclass(frozen=True, kw_only=True)
class Specs:
    """All parts of a scene, its laws, and the `course` of a flow that reverses or has phases."""

    mesh: MeshSpec
    flow: FlowSpec
    heat: HeatSpec
    time: TimeSpec
    output: Output
    laws: Laws
    course: Course | None = None

    @property
    def waits_for_heat(self) -> bool:
        """Whether the wall is waited for until it is as warm as what flows in."""
        is_one = self.course is None or self.course.waits_for_heat
        return is_one and self.heat.is_heated_by_inflow(self.time.heated.place, self.time.heated.margin)

    def least_change_needed(self, met: Collection[str] = ()) -> float:
        """Least change (K) of a place that is waited for, but for the targets that are `met`; infinite where there is none."""
        if self.time.targets:
            return min(
                (target.change_needed for target in self.time.targets if target.name not in met), default=math.inf
            )
        return self.heat.largest_of_inflow - self.time.heated.margin if self.waits_for_heat else math.inf

    @property
    def porosity(self) -> Porosity:
        """Porosity against wall distance."""
        return self.laws.porosity


def specs_of(scene: Scene) -> Specs:
    """The parts of a scene, with its series as steps in time follow them."""
    scene = with_thinned_series(scene)
    laws = Laws.of(scene)
    require_phase(scene, laws)
    air_loop, course = air_loop_of(scene, laws.fluid), Course.of(scene)
    heat = _heat(scene, laws, air_loop, course)
    return Specs(
        mesh=_mesh(scene, laws),
        flow=_flow(scene, laws, None if air_loop is None else air_loop.blower, course),
        heat=heat,
        time=_time(scene, course, targets_of(scene, heats_where_it_melts(heat, laws.beads))),
        course=course,
        output=Output.of(scene).with_times(scene),
        laws=laws,
    )


def _mesh(scene: Scene, laws: Laws) -> MeshSpec:
    geometry, own, wall = scene.geometry, OwnMesh.of(scene), BedWall.of(scene)
    kind = GEOMETRIES[geometry.kind]
    size = kind.size(geometry)
    dimension = dimension_of(geometry)
    turbulent = 0 if laws.turbulence is None else len(laws.turbulence.unknowns)
    velocity_and_pressure = {"full": dimension + 1, "developed": 1, "plug": 0}[scene.model.flow]
    if scene.is_locally_developed:
        turbulent = 0  # one equation of the pressure, whatever the profiles hold
    return MeshSpec(
        size=size,
        own=own,
        trusted=scene.allow_extensions,
        dimension=dimension,
        axisymmetric=own.symmetry == "axisymmetric" if size is None else size.axisymmetric,
        bead_diameter=scene.bed.bead_diameter,
        narrowest=min(kind.widths(geometry).values(), default=None),
        layers=wall.layers(laws.walls) if wall.kind == "conjugate" else (),
        opposite_layers=wall.opposite_layers(laws.walls),
        cells=Cells.of(scene),
        unknowns_per_node=max(velocity_and_pressure + turbulent, 1),
        is_symmetric=reverses(scene),
        sensors=Sensors.of(scene),
        scene_file=scene.source,
    )


def _flow(scene: Scene, laws: Laws, blower: Blower | None, course: Course | None) -> FlowSpec:
    given, model = Drive.of(scene), FlowModel.of(scene)
    if blower is None:
        drive = given.chosen[0]
        driven_by = getattr(given, drive)
        if course is not None:
            driven_by = followed([driven_by], course.drive)
    else:
        size, operation = GEOMETRIES[scene.geometry.kind].size(scene.geometry), scene.operation
        given_to_bed = operation.outlet_pressure, operation.initial_temperature, scene.bed.bead_diameter
        first = first_point(size, laws, blower, share_of(scene), *given_to_bed)
        drive, driven_by = "pressure_drop", TimeSeries.constant(first)
    return FlowSpec(
        model=model,
        drive=drive,
        driven_by=driven_by,
        by_blower=blower is not None,
        turbulence=laws.turbulence,
        outlet_pressure=scene.operation.outlet_pressure,
        gravity=given.gravity,
        averaging=AveragingVolume.of(scene),
        tolerance=model.tolerance_with(scene.solver.step_refinement),
    )


def _heat(scene: Scene, laws: Laws, air_loop: AirLoopSpec | None, course: Course | None) -> HeatSpec:
    operation, wall = scene.operation, BedWall.of(scene)
    inlet_temperature = operation.inlet_temperature
    if course is not None:
        back = () if operation.return_temperature is None else (operation.return_temperature,)
        inlet_temperature = followed([*back, inlet_temperature], course.temperature)
    return HeatSpec(
        model=EnergyModel.of(scene),
        emissivity=scene.bed.emissivity,
        wall=wall,
        layers=wall.layers(laws.walls),
        opposite_layers=wall.opposite_layers(laws.walls),
        outer_wall=OuterWall.of(scene),
        initial_temperature=operation.initial_temperature,
        start=scene.start,
        inlet_temperature=inlet_temperature,
        air_loop=air_loop,
        bead_motion=BeadMotion.of(scene),
    )


def _time(scene: Scene, course: Course | None, targets: tuple[Target, ...]) -> TimeSpec:
    kinks: dict[float, float] = {}
    for name, each in series_of(scene).items():
        for instant, change in each.kinks(scale_of(each, key_of(KEYS, name), scene)).items():
            if instant > 0.0:
                kinks[instant] = max(change, kinks.get(instant, 0.0))
    return TimeSpec(
        steps=TimeSteps.of(scene),
        heated=Heated.of(scene),
        end_time=_end_time(scene, course),
        until_steady=not scene.is_given("operation.end_time") and not (course is not None and course.repeats),
        targets=targets,
        kinks=kinks,
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
