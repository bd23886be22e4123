"""What a scene asks for beyond the limits of the model: told before a run, and after it."""

import math

import numpy as np

from ..arrays import Floats
from ..laws.porosity import LawPorosity, benyahia_oneill_mean_porosity, dixon_mean_porosity, mean_porosity
from ..laws.stirring import SOLID_FRACTIONS
from ..mesh import domain as geometry
from ..mesh import fenicsx, ranks
from ..mesh.domain import Domain
from ..mesh.point_values import nodal_values
from ..scene.chosen_laws import width_ratio
from ..scene.features.bed import SMALLEST_RATIO
from ..scene.features.geometries import BedSize
from ..scene.features.targets import series_of
from ..scene.plausibility import implausible_values
from ..scene.scene import Scene
from ..scene.series import ProfileSeries
from ..scene.start import Profile
from .estimates import LEAST_JUMP, Estimates, flow_change, fluid_at
from .expansion import heat_of_expansion
from .heat_capacity_peaks import NARROW, sharpest_change
from .mesh_quality import few_straight_cells
from .simplifications import HIGHEST_BIOT_NUMBER, is_heated_by_its_wall, of_simplifications
from .specs import Specs

SHARPEST_CHANGE = 3.0
"""Factor on a fluid's heat capacity within a narrow part of all temperature differences, up to which nothing is said: of 2 to
8 kJ/(kg K) and back within 40 of 180 K the heat is right within 0.3 %, of 2 to 42 and back within 10 K it is 6 % off."""
LATEST_BEGIN = 0.05
"""Part of the time of a series from the run's start to its first row without a word."""
LARGEST_POROSITY_ERROR = 0.02
COARSEST_FIRST_CELL = 3.0
"""Of what the wall needs."""
HIGHEST_BEAD_CONDUCTION = 2.0
"""Of the beads, over what measurements give for the whole bed across the flow. Up to twice that, bulk conduction stands for the
dispersion that the thesis leaves out (ceramic beads in air: 1 to 1.5); beyond, nothing makes up for it."""
LARGEST_FLOW_CHANGE = 4.0
"""Of the mass flow between the initial and the inlet temperature, up to which developed and full flow agree within 0.1 % of the
heating time; at 26 (thermal oil of 20 and 150 degC in the aluminium mold) they differ by 2 %."""
LARGEST_RESISTANCE_RATIO = 10.0
"""Of the fluid displaced over that which enters, up to which answers do not depend on the cells: at 4 (water-glycol of -10 and
80 degC) 0.2 % of the heating time, at 22 to 25 (thermal oil of 20 and 120, 180 degC) up to 5 %, at 60 to 320 10 to 15 %."""
LARGEST_RADIATION, LARGEST_RADIATION_ALONE = 0.2, 0.05
"""Over what the bed conducts without it: about the scatter of measured conductivities of beds; where that alone heats it less."""


THINNEST_CORE = 5.0
"""Radius of a wall in bead diameters, below which profiles beside plane walls are told (1.1 % of a heating time at 2.5 with a
porosity that rises towards the wall)."""
LONGEST_PROFILE, SHORTEST_PROFILE = 1.5, 0.1
"""Of a bed's length, up to which a profile along it may, and has to, tell its values without a word."""
LARGEST_FILM_OF_BED = 0.2
"""Of the time in which the bed conducts, that heat takes to pass the film at the wall."""
LARGEST_EXPANSION = 0.005
"""Of the heat that fluid and beads store, what a change of density displaces (VP-1 of 100 and 350 degC: 4.6 %, water of 5 and
95 degC: 1.4 %)."""
LARGEST_VISCOSITY_RATIO = 2.0
"""Of a liquid between the temperatures given, up to which profiles of one viscosity will do: a mold of steel is heated 1.0 % too
fast at 3.5 (VP-1 of 100 and 250 degC), 1.1 % at 5 (water of 5 and 95 degC), 2.6 % in water-glycol of -5 and 85 degC; where
turbulence begins in the layer at the wall, 3.2 % at 5, and 0.7 % without turbulence."""
LARGEST_FRICTION = 0.01
"""Of all differences of temperature, by which friction in a liquid heats it."""
HIGHEST_KNUDSEN_NUMBER = 0.01
"""Mean free path over bead diameter, beyond which a gas slips."""


def _knudsen_number(specs: Specs) -> float:
    """Of the beads at the inlet's temperature: mu/p sqrt(pi R T/2) over d; 0 in a liquid."""
    fluid, pressure = specs.laws.fluid, specs.flow.outlet_pressure
    if not fluid.density.compressible:
        return 0.0
    temperature = specs.heat.inlet_temperature.range[1]
    specific = pressure / (float(fluid.density(pressure, temperature)) * temperature)
    path = float(fluid.viscosity(temperature)) / pressure * math.sqrt(0.5 * math.pi * specific * temperature)
    return path / specs.mesh.bead_diameter


def warnings_of_the_scene(scene: Scene, specs: Specs, estimates: Estimates, size: BedSize) -> list[str]:
    """A sentence for every limit of the model that the scene is beyond, before a run as after it."""
    found = implausible_values(scene) + _of_series(scene)
    found += _of_the_interior(specs, estimates)
    low, high = specs.laws.nusselt.reynolds_range
    if estimates.flows and not low <= estimates.reynolds_number <= high:
        found.append(
            f"bead Reynolds number {estimates.reynolds_number:.3g} is outside {low:g} to {high:g}, "
            f"the range of model.nusselt {scene.model.nusselt!r}"
        )
    if estimates.flows and estimates.prandtl_number > specs.laws.nusselt.highest_prandtl_number:
        found.append(
            f"the Prandtl number {estimates.prandtl_number:.3g} is above {specs.laws.nusselt.highest_prandtl_number:g}, up to "
            f"which model.nusselt {scene.model.nusselt!r} holds: it is of gases"
        )
    if size.length < SMALLEST_RATIO * specs.mesh.bead_diameter:
        found.append(
            f"the bed is {size.length / specs.mesh.bead_diameter:.2g} bead diameters long: averages over beads need "
            f"{SMALLEST_RATIO:g} or more"
        )
    knudsen = _knudsen_number(specs)
    if knudsen > HIGHEST_KNUDSEN_NUMBER:
        found.append(
            f"the mean free path of the gas is {knudsen:.1%} of a bead's diameter: drag, exchange and conduction are those of a "
            "dense gas, and less here"
        )
    if specs.flow.model.kind == "plug" and scene.is_given("model.turbulence") and scene.model.turbulence != "none":
        found.append("plug flow carries no turbulence: model.turbulence has no effect")
    resists = (
        is_heated_by_its_wall(specs, estimates)
        and estimates.film_time > LARGEST_FILM_OF_BED * estimates.conduction_time
    )
    if resists and specs.heat.model.two_temperatures:
        found.append(
            "by model.bead_conduction beads give no heat to the wall, which heats or cools this bed: the fluid beside it has to "
            "carry all of that, and it takes several times as long as by closures that let them (model.closures 'measured')"
        )
    elif estimates.conduction_ratio > HIGHEST_BEAD_CONDUCTION and scene.conductivity_profile is None:
        found.append(
            f"the beads conduct {estimates.conduction_ratio:.2g} times as much as measured for the whole bed: "
            "conduction in the bed is overestimated (see model.closures 'measured', or model.bead_conduction)"
        )
    is_gas = specs.laws.fluid.density.compressible
    if scene.bed.emissivity and not is_gas:
        found.append(
            "bed.emissivity lets beads radiate to each other through a gas; a liquid absorbs that within millimetres"
        )
    if (
        scene.model.drag == "eisfeld-schnitzlein"
        and scene.bed.porosity_model != "constant"
        and specs.flow.model.kind != "plug"
    ):
        found.append(
            "model.drag 'eisfeld-schnitzlein' holds for means over the section: with a porosity that varies towards the wall it "
            "counts the wall twice (bed.porosity_model 'constant')"
        )
    largest = LARGEST_RADIATION_ALONE if is_heated_by_its_wall(specs, estimates) else LARGEST_RADIATION
    if is_gas and estimates.radiation_ratio > largest:
        found.append(
            f"radiation between the beads, which bed.emissivity = 0 leaves out, would add some {estimates.radiation_ratio:.0%} "
            "to what the bed conducts across the flow where it is hottest (bed.emissivity, with model.closures 'measured')"
        )
    solid_fraction = 1.0 - specs.porosity.bulk_porosity
    if scene.bed.shear_rate and not SOLID_FRACTIONS[0] <= solid_fraction <= SOLID_FRACTIONS[1]:
        found.append(
            f"the solid fraction {solid_fraction:.2f} is outside {SOLID_FRACTIONS[0]:g} to {SOLID_FRACTIONS[1]:g}, "
            "the range of what stirring carries (bed.shear_rate)"
        )
    for name in ("emissivity", "contact_flattening"):
        if not specs.laws.bead_conduction.whole_bed and getattr(scene.bed, name):
            law = scene.model.bead_conduction
            found.append(f"bed.{name} has no effect with model.bead_conduction {law!r}")
    found += of_simplifications(scene, specs, estimates, size)
    if few := few_straight_cells(specs, estimates).text:
        found.append(
            f"the scene asks for few cells (beside the default): {few}; every answer may be off by some per cent "
            "(solver.axial_cells, solver.wall_cells, solver.mesh_refinement)"
        )
    ends = specs.heat.initial_temperature, specs.heat.inlet_temperature.values[-1]
    change = math.exp(flow_change(specs, size, *(fluid_at(specs, one) for one in ends)))
    if specs.flow.model.kind == "developed" and change > LARGEST_FLOW_CHANGE and specs.flow.model.update != "frozen":
        found.append(
            f"the flow changes by a factor of {change:.2g} between the initial and the inlet temperature: developed flow leaves "
            "out what crosses the bed as it changes, some per cent of the heating time (see model.flow 'full')"
        )
    found += _of_the_viscosity(specs)
    if estimates.resistance_ratio > LARGEST_RESISTANCE_RATIO:
        found.append(
            f"the bed resists {estimates.resistance_ratio:.2g} times less to the fluid that enters than to the one it displaces: "
            "fingers form between them (viscous fingering) that follow cells and steps, heating times are good to some 5 to 15 % "
            "on any mesh, and no estimated error tells"
        )
    if estimates.jump > LEAST_JUMP:
        found.append(
            f"{math.exp(-estimates.transfer_units):.0%} of a change at the inlet passes the bed as a jump of the fluid alone, "
            f"with {estimates.transfer_units:.2g} transfer units between fluid and beads: cells smear it, and what leaves "
            "passes a temperature within the jump earlier or later by some per cent of the time in which the fluid passes the bed"
        )
    found += _of_positions(scene, size.length) + _of_the_porosity(scene, specs, size)
    found += _of_expansion(specs, estimates) + _of_friction(specs, estimates, size) + _of_a_peak(specs)
    beads_across = specs.mesh.beads_across
    return found + (_of_the_width(beads_across) if beads_across is not None and specs.mesh.is_too_narrow else [])


def _of_the_interior(specs: Specs, estimates: Estimates) -> list[str]:
    """Whether beads count as isothermal, or as of one heat capacity inside, and are not."""
    if estimates.bead_biot_number <= HIGHEST_BIOT_NUMBER:
        return []
    melts = sharpest_change(specs.laws.beads.heat_capacity, *specs.heat.reached) > SHARPEST_CHANGE
    if specs.heat.model.bead_modes is None:
        remedy = "; modes of beads that melt would not do either" if melts else " (see model.bead_modes)"
        limit = f"bead Biot number {estimates.bead_biot_number:.2g} > {HIGHEST_BIOT_NUMBER}"
        return [f"{limit}: the assumption of isothermal beads is not valid{remedy}"]
    if melts:
        return [
            "model.bead_modes takes the heat capacity that beads have on average for all of their inside: how they melt from "
            "their surface inwards is not resolved"
        ]
    return []


def _of_expansion(specs: Specs, estimates: Estimates) -> list[str]:
    """Whether the mass that a change of density displaces counts, and is left out."""
    off = heat_of_expansion(specs)
    is_left_out = specs.flow.model.update == "frozen" or specs.heat.air_loop is not None
    if not estimates.flows or not is_left_out or abs(off) <= LARGEST_EXPANSION:
        return []
    low, high = specs.heat.given_bounds
    fluid, pressure = specs.laws.fluid, specs.flow.outlet_pressure
    change = 1.0 - fluid.density(pressure, high) / fluid.density(pressure, low)
    return [
        f"the fluid's density changes by {abs(change):.0%} from {low:.0f} to {high:.0f} K, and a flow that is frozen or in an "
        "air loop leaves out the mass that this displaces: of a given mass flow, fronts pass places late in a bed that is "
        f"heated, early in one that is cooled, by up to {abs(off):.1%}; the heat stored is off by as much, a time at which all "
        "is heated by a fifth of that"
    ]


def _of_a_peak(specs: Specs) -> list[str]:
    """Whether the fluid's heat capacity changes by more than cells follow."""
    low, high = specs.heat.given_bounds
    largest = sharpest_change(specs.laws.fluid.heat_capacity, low, high)
    if not largest > SHARPEST_CHANGE:
        return []
    return [
        f"the heat capacity of {specs.laws.fluid.substance} changes by a factor of {largest:.2g} within "
        f"{NARROW * (high - low):.2g} K, less than "
        "the differences within a cell: the heat that the flow carries may be off by some per cent (see the heat balance), and "
        "steps may fail; a heat capacity spread over more kelvins, with the same integral, and more solver.axial_cells help"
    ]


def _of_the_viscosity(specs: Specs) -> list[str]:
    """Whether a liquid's viscosity changes across the layer at the wall, where profiles of one viscosity are taken."""
    is_from_a_table = specs.mesh.own.mesh is not None or specs.mesh.dimension == 3
    if specs.flow.model.kind != "developed" or not is_from_a_table or specs.laws.fluid.density.compressible:
        return []
    heat = specs.heat
    of_bed = [
        *heat.first_temperatures,
        *heat.inlet_temperature.range,
    ]  # surroundings cool the bed's wall, hardly the bed
    low, high = heat.given_bounds if heat.is_wall_held else (min(of_bed), max(of_bed))
    ratio = float(specs.laws.fluid.viscosity(low) / specs.laws.fluid.viscosity(high))
    if max(ratio, 1.0 / ratio) <= LARGEST_VISCOSITY_RATIO:
        return []
    return [
        f"the viscosity changes by a factor of {ratio:.2g} from {low:.0f} to {high:.0f} K: in this geometry developed flow takes "
        "that of each place, not how it changes across the layer at the wall, whose heating time may be off by 1 to 4 % "
        "(see model.flow 'full')"
    ]


def _of_friction(specs: Specs, estimates: Estimates, size: BedSize) -> list[str]:
    """Whether friction in a liquid, which is left out, heats it; in a gas that expands it does not."""
    fluid, heat = specs.laws.fluid, specs.heat
    low, high = heat.given_bounds
    if fluid.density.compressible or not estimates.flows or any(heat.is_open):
        return []
    temperature, drop = heat.inlet_temperature.range[1], estimates.pressure_gradient * size.length
    rise = drop / float(fluid.density(specs.flow.outlet_pressure, temperature) * fluid.heat_capacity(temperature))
    if rise <= LARGEST_FRICTION * (high - low):
        return []
    return [
        f"friction, which is left out, heats the fluid by up to {rise:.2g} K along a pressure drop of {drop / 1e5:.2g} bar, all "
        f"differences of temperature are {high - low:.3g} K"
    ]


def _of_the_width(beads_across: float) -> list[str]:
    """Of a bed so many beads wide."""
    return [
        f"the bed is {beads_across:.1f} beads wide, below {SMALLEST_RATIO:g}: "
        "volume averages are not meaningful at this width"
    ]


def _of_the_porosity(scene: Scene, specs: Specs, size: BedSize) -> list[str]:
    """Whether spheres pour like that, of a law in a tube or a gap; a profile from a file is the user's own."""
    diameter = specs.mesh.bead_diameter
    if not isinstance(specs.porosity, LawPorosity) or specs.mesh.size is None or size.half_width is not None:
        return []
    mean = mean_porosity(specs.porosity, diameter, size.half_height, axisymmetric=size.is_disk)
    measured = [correlation(width_ratio(scene)) for correlation in (dixon_mean_porosity, benyahia_oneill_mean_porosity)]
    if min(abs(mean - other) for other in measured) <= LARGEST_POROSITY_ERROR:
        return []
    return [
        f"the mean porosity {mean:.3f} is not that of poured spheres, {min(measured):.3f} to {max(measured):.3f} at this width "
        "(Dixon; Benyahia, O'Neill): see bed.bulk_porosity"
    ]


def first_cell(domain: Domain) -> float:
    """Median height (m) of the bed's cells at the wall (collective)."""
    space = fenicsx.lagrange_space(domain.mesh)
    distance = nodal_values(domain.wall_distance, space)
    of_cells = distance[fenicsx.dof_table(space)[domain.cells(geometry.BED)]]
    scale = ranks.largest_magnitude(domain.communicator, of_cells)
    touching = np.sum(of_cells <= 1e-9 * scale, axis=1) >= domain.mesh.topology.dim
    heights = of_cells[touching].max(axis=1)
    return float(np.median(np.concatenate(domain.communicator.allgather(heights)) if scale else [0.0]))


def _nodes_of_the_bed(domain: Domain) -> tuple[Floats, Floats]:
    """Distance from the wall and place (m) of the nodes of the bed's cells, of each cell by itself."""
    space = fenicsx.lagrange_space(domain.mesh)
    nodes = fenicsx.dof_table(space)[domain.cells(geometry.BED)].ravel()
    return nodal_values(domain.wall_distance, space)[nodes], space.tabulate_dof_coordinates()[nodes]


def of_a_narrow_bed(scene: Scene, domain: Domain) -> list[str]:
    """Whether the bed of a mesh of one's own is too narrow for averages over beads (collective)."""
    if scene.geometry.kind != "mesh":
        return []
    distance, _ = _nodes_of_the_bed(domain)
    wide = 2.0 * ranks.extremes(domain.communicator, distance)[1] / scene.bed.bead_diameter
    return _of_the_width(wide) if wide < SMALLEST_RATIO * (1.0 - 1e-9) else []


def of_a_thin_core(scene: Scene, domain: Domain) -> list[str]:
    """Whether locally developed flow, whose profiles are those beside a plane wall, is off beside a thin core (collective)."""
    if not (scene.is_locally_developed and domain.axisymmetric):
        return []
    distance, places = _nodes_of_the_bed(domain)
    at_wall = distance <= 1e-9 * ranks.largest_magnitude(domain.communicator, distance)
    smallest = ranks.extremes(domain.communicator, places[at_wall, 1])[0]
    if smallest >= THINNEST_CORE * scene.bed.bead_diameter:
        return []
    return [
        f"developed flow has the profile beside a plane wall, and the bed's wall has a radius of {1e3 * smallest:.3g} mm: times "
        "may be off by a per cent (model.flow 'full', or geometry.kind 'pipe' or 'annulus')"
    ]


def warnings_of_the_first_cell(specs: Specs, estimates: Estimates, first: float) -> list[str]:
    """Whether the bed's cells at the wall, of a height `first` (m), are too high for flow and heat there."""
    if estimates.uniform_across or not estimates.flows or first <= COARSEST_FIRST_CELL * estimates.first_cell:
        return []
    remedy = "see geometry.refine_wall" if specs.mesh.own.mesh is not None else "see solver.first_cell"
    is_plug = specs.flow.model.kind == "plug"
    part, results = ("the exchange of heat", "every time") if is_plug else ("the flow", "the mass flow and every time")
    wrong = f"{part} near the wall, and with it {results}, may be off, by half a per cent at 10 times and by 10 % at 50"
    return [f"the first cell at the wall is {first / estimates.first_cell:.0f} times too high: {wrong} ({remedy})"]


def _of_positions(scene: Scene, length: float) -> list[str]:
    """Of profiles along a bed of a `length` (m) whose positions are not those of such a bed."""
    series = {name: one.positions for name, one in series_of(scene).items() if isinstance(one, ProfileSeries)}
    profiles = series | ({scene.start.key: scene.start.positions} if isinstance(scene.start, Profile) else {})
    return [
        f"{name} tells values up to {positions[-1]:.4g} m from the inlet of a bed of {length:.4g} m: distances in another unit?"
        for name, positions in profiles.items()
        if not SHORTEST_PROFILE <= positions[-1] / length <= LONGEST_PROFILE
    ]


def _of_series(scene: Scene) -> list[str]:
    """Of values that a file lacks, and of series that begin after the run, which keep their first value until then."""
    found = []
    for name, series in series_of(scene).items():
        if series.gaps:
            found.append(f"{name}: {series.gaps} missing value(s) of {series.source}, interpolated")
        if series.times[0] > LATEST_BEGIN * (series.times[-1] - series.times[0]):
            found.append(f"{name} begins at {series.times[0]:g} s: up to then it is its first value")
    return found
