"""What a scene asks for, cut into typed parts at the door: nothing behind it sees the scene.

Lengths in m, times in s, temperatures in K. None stands for what the scene leaves to the program.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from ..laws.porosity import Porosity
from ..laws.turbulence_models import TurbulenceModel
from ..scene.checks import DRIVES, SMALLEST_RATIO
from ..scene.chosen_laws import Laws
from ..scene.geometries import GEOMETRIES, BedSize
from ..scene.scene import Scene
from ..scene.series import TimeSeries

FlowKind = Literal["full", "developed", "plug"]
FlowUpdate = Literal["quasi-steady", "frozen", "transient"]
WallKind = Literal["conjugate", "thin", "fixed-temperature", "insulated"]
RevTerms = Literal["off", "consistent", "as-published"]


@dataclass(frozen=True, kw_only=True)
class MeshSpec:
    """The mesh: `size` of a straight bed, or the `file` of a mesh. `wall_thickness` is that of a wall with cells of its own.

    Cells are those of the scene before `refinement`. `sensors` is the file of recorded places, `scene_file` is named in errors.
    """

    size: BedSize | None
    file: Path | None
    axisymmetric: bool
    bead_diameter: float
    narrowest: float | None
    wall_thickness: float | None
    axial_cells: int | None
    first_cell: float | None
    cell_growth: float
    wall_cells: int | None
    refinement: float
    unknowns_per_node: int
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
    in time is `driven_by`."""

    kind: FlowKind
    update: FlowUpdate
    drive: str
    driven_by: TimeSeries
    turbulence: TurbulenceModel | None
    outlet_pressure: float
    gravity: float
    rev_terms: RevTerms
    largest_averaging_diameter: float
    tolerance: float


@dataclass(frozen=True, kw_only=True)
class OuterWallSpec:
    """What the outer wall exchanges: `heat_flux` in (W/m2) times a factor, `coefficient` (W/m2/K) to `ambient`."""

    heat_flux: TimeSeries | None
    heat_flux_factor: float
    coefficient: float | None
    ambient: TimeSeries | None


@dataclass(frozen=True, kw_only=True)
class HeatSpec:
    """The temperatures: two or one in the bed, `bead_modes` inside the beads, and the wall."""

    two_temperatures: bool
    bead_modes: int | None
    exchange_factor: float
    emissivity: float
    wall: WallKind
    wall_thickness: float | None
    wall_temperature: TimeSeries | None
    outer_wall: OuterWallSpec
    initial_temperature: float
    inlet_temperature: TimeSeries


@dataclass(frozen=True, kw_only=True)
class TimeSpec:
    """The march: steps before `refinement`, `kinks` at which steps end, and when the wall counts as heated: all of it within
    `margin` (K) of the inlet's temperature."""

    first_step: float
    step_growth: float
    largest_step: float | None
    refinement: float
    tolerance: float
    end_time: float
    margin: float
    kinks: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class OutputSpec:
    """What is kept: fields at `field_times` times, a checkpoint every `checkpoint_interval` s of the clock."""

    fields: bool
    field_times: int
    checkpoint_interval: float


@dataclass(frozen=True, kw_only=True)
class Specs:
    """All parts of a scene, and its laws."""

    mesh: MeshSpec
    flow: FlowSpec
    heat: HeatSpec
    time: TimeSpec
    output: OutputSpec
    laws: Laws

    @property
    def porosity(self) -> Porosity:
        """Porosity against wall distance."""
        return self.laws.porosity


def specs_of(scene: Scene) -> Specs:
    """The parts of a scene."""
    laws = Laws.of(scene)
    return Specs(
        mesh=_mesh(scene, laws),
        flow=_flow(scene, laws),
        heat=_heat(scene),
        time=_time(scene),
        output=OutputSpec(
            fields=scene.output.fields,
            field_times=scene.output.field_times,
            checkpoint_interval=scene.output.checkpoint_interval,
        ),
        laws=laws,
    )


def _mesh(scene: Scene, laws: Laws) -> MeshSpec:
    geometry, solver = scene.geometry, scene.solver
    kind = GEOMETRIES[geometry.kind]
    size = kind.size(geometry)
    widths = [getattr(geometry, n) for n in kind.widths if not (n == "width" and geometry.sides == "symmetry")]
    dimension = 2 if size is None or size.half_width is None else 3
    turbulent = 0 if laws.turbulence is None else len(laws.turbulence.unknowns)
    velocity_and_pressure = {"full": dimension + 1, "developed": 1, "plug": 0}[scene.model.flow]
    return MeshSpec(
        size=size,
        file=geometry.mesh,
        axisymmetric=geometry.symmetry == "axisymmetric" if size is None else size.axisymmetric,
        bead_diameter=scene.bed.bead_diameter,
        narrowest=min((width for width in widths if width), default=None),
        wall_thickness=scene.wall.thickness if scene.model.wall == "conjugate" else None,
        axial_cells=solver.axial_cells,
        first_cell=solver.first_cell,
        cell_growth=solver.cell_growth,
        wall_cells=solver.wall_cells,
        refinement=solver.mesh_refinement,
        unknowns_per_node=max(velocity_and_pressure + turbulent, 1),
        sensors=geometry.sensors,
        scene_file=scene.source,
    )


def _flow(scene: Scene, laws: Laws) -> FlowSpec:
    operation, model, bed = scene.operation, scene.model, scene.bed
    drive = next(name for name in DRIVES if getattr(operation, name) is not None)
    return FlowSpec(
        kind=model.flow,
        update=model.flow_update,
        drive=drive,
        driven_by=getattr(operation, drive),
        turbulence=laws.turbulence,
        outlet_pressure=operation.outlet_pressure,
        gravity=operation.gravity,
        rev_terms=model.rev_terms,
        largest_averaging_diameter=bed.averaging_diameter_ratio * bed.bead_diameter,
        tolerance=scene.solver.flow_tolerance,
    )


def _heat(scene: Scene) -> HeatSpec:
    operation, model = scene.operation, scene.model
    return HeatSpec(
        two_temperatures=model.energy == "two-temperature",
        bead_modes=model.bead_modes,
        exchange_factor=model.exchange_factor,
        emissivity=scene.bed.emissivity,
        wall=model.wall,
        wall_thickness=scene.wall.thickness,
        wall_temperature=operation.wall_temperature,
        outer_wall=OuterWallSpec(
            heat_flux=operation.outer_heat_flux,
            heat_flux_factor=operation.outer_heat_flux_factor,
            coefficient=operation.outer_coefficient,
            ambient=operation.ambient_temperature,
        ),
        initial_temperature=operation.initial_temperature,
        inlet_temperature=operation.inlet_temperature,
    )


def _time(scene: Scene) -> TimeSpec:
    operation, solver = scene.operation, scene.solver
    series: list[Any] = [value for _, value in operation if isinstance(value, TimeSeries)]
    return TimeSpec(
        first_step=solver.first_step,
        step_growth=solver.step_growth,
        largest_step=solver.largest_step,
        refinement=solver.step_refinement,
        tolerance=solver.step_tolerance,
        end_time=operation.end_time,
        margin=operation.heating_margin,
        kinks=tuple(sorted({kink for each in series for kink in each.kinks if kink > 0.0})),
    )
