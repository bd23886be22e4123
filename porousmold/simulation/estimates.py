"""What is known of a scene before it is solved: speeds, wall shear, heat capacities, and what follows for the mesh.

Order-of-magnitude figures from the scene's own correlations in the middle of the bed. They choose defaults (first
cell, cells through the wall, largest step) and scale the unknowns; no result depends on them.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..laws.conductivity import Anisotropic, LocalBed, added, core_dispersion, stagnant_conductivity
from ..laws.functions import Value
from ..laws.natural_convection import rayleigh_darcy_number
from ..laws.nusselt import bead_reynolds_number, prandtl_number, specific_surface
from ..scene.features.geometries import BedSize
from ..scene.series import TimeSeries
from .heat_capacity_peaks import melts
from .specs import Specs
from .wall_estimates import (
    Store,
    conduction_time,
    is_heated_from_outside,
    wall_estimate,
    wall_nusselt_number,
)

FIRST_CELL_IN_WALL_UNITS = 1.0
FEWEST_AXIAL_CELLS = 18
FINER_IF_MELTING = 2
"""Factor on the cells along the flow where beads melt: those of steep fronts are of first order (`solvers.bounded_steps`)."""
FINER_IF_UNIFORM = 2
"""Factor on the cells along a bed with few across: those as thick as long spread a front more than thin ones do (by 4.5 % of a
tracer's spread for 1.7 %, on default cells), and as many more make it 0.6 %."""
STEADY_BEADS = 0.1
"""Part of the slowest time in which beads that move cross the bed fast enough to count as steady."""
FROM_THE_WALL = "conduction from the wall"
"""Name of a limit of the time steps."""
LARGEST_CELL, LARGEST_STEP = 0.42, 0.25
"""Of the front's width at the outlet, and of the time in which the wall's temperature changes there."""
STANDING_FRONT = 0.5
"""Of that width, the one of a front that beads against the flow keep near the inlet, where it has spread less (crossed scenes 30,
201, 234: 0.8 to 1 % of the heat on cells for a front that passes, 0.1 to 0.4 % on half as long ones)."""
LEAST_JUMP, SHARP_FRONT = 0.03, 0.04
"""Part of all heat from which on what comes through as a jump counts, and the part of the bed's length as wide as which that is
taken, which no cells resolve, and what beads as fast as the fluid spread less."""
WIDEST_FRONT = 0.35
"""Of the bed's length, in that time: what is wider passes no faster, as the bed is heated as a whole then."""
AXIAL_GRADING = 1.25
"""Axial nodes at L (i/n)^1.25: the thermal front that starts sharp at the inlet meets small cells, and widens as they do."""
SLOWEST_MODE = {False: math.pi**2 / 4.0, True: 5.783}
"""Decay rate of the slowest mode of a plane wall and of a cylinder (`axisymmetric`), times depth squared over diffusivity
(Carslaw, Jaeger, Conduction of Heat in Solids, sections 3.3 and 7.6)."""
NO_FLOW = 1e-9
"""Of the speed at which Re = 1: below, nothing flows."""
LEAST_SPREADING = 0.5
"""Of a bead, along the flow, by which a front of one temperature counts as spread: what beads mix, D = u d/2. A model that leaves
mixing out has sharper ones, of no meaning."""
COMMON_EMISSIVITY = 0.8
"""Of oxidised metal, ceramic and stone."""
WALL_REGION = 20.0
"""Bead diameters from the wall, over which its laws may change."""
ROUNDING = 1e-9


@dataclass(frozen=True)
class Estimates:
    """Of the developed flow in the middle of the bed at the inlet temperature (SI units).

    `conduction_ratio` is what the beads conduct by the scene's law over what measurements give for the whole bed across the flow,
    `radiation_ratio` what radiation between beads of emissivity `COMMON_EMISSIVITY` would carry over what the bed conducts
    across the flow at the highest inlet temperature, 0 where the scene has an emissivity.

    `transfer_units` are those of the exchange between fluid and beads over the bed's length, `jump` is the part of all heat whose
    front leaves the bed as sharp as it enters, with fluid that beads have not held up, `wall_biot_number` the largest of
    the wall's layers.

    `speed` (m/s), `pressure_gradient`, `mass_flux` and `mass_flow` are those of Re = 1 at least: they are the scale of a flow
    that may be none, which `flows` tells. `driven_part` of the speed is what drives it, of `driven_gradient` (Pa/m) and
    `reynolds_number`.

    `film_time` (s) is that in which heat passes the film of fluid at the wall, which beads of another temperature have no contact
    with, into what the wall stores or, where the bed is heated by its wall, the bed; 0 where they have contact.

    `flow_duration` (s) is the least time in which the fluid brings the heat that bed and wall take up, `conduction_time` (s) the
    slowest time constant of bed and wall that are heated from their outside, infinite where they are not: `heating_duration` is
    that of both together.

    `front_width` is the standard deviation (m) of the thermal front at the outlet, `wall_time_constant` (s) that with which
    the wall follows the bed, `end_length` that over which the wall's insulated end at the outlet is felt along it,
    `inlet_time` (s) that in which the inlet temperature changes, `bead_residence_time` (s) that in which moving beads cross
    the bed; `resistance_ratio` is how many times more the bed resists to the same mass flow where it holds the fluid that is
    displaced than where it holds that which enters, 1 where the velocity does not depend on it; `wall_cells` are those through
    each layer of the wall, `thick_layers` tells through which no heat comes while the bed is heated. In a bed that is
    `uniform_across` nothing changes across the flow; `beads_melt` where their heat capacity has a peak.
    """

    flows: bool
    speed: float
    driven_part: float
    driven_gradient: float
    pressure_gradient: float
    mass_flux: float
    mass_flow: float
    reynolds_number: float
    prandtl_number: float
    exchange_coefficient: float
    bead_biot_number: float
    transfer_units: float
    jump: float
    film_time: float
    wall_biot_number: float
    conduction_ratio: float
    radiation_ratio: float
    first_cell: float
    wall_cells: tuple[int, ...]
    thick_layers: tuple[bool, ...]
    flow_duration: float
    conduction_time: float
    end_length: float
    front_width: float
    wall_time_constant: float
    inlet_time: float
    bead_residence_time: float
    beads_against: bool
    uniform_across: bool
    resistance_ratio: float
    length: float
    beads_melt: bool = False

    @property
    def axial_cells(self) -> int:
        """Default number of cells along the flow: those at the outlet are shorter than the front is wide; more where they are all
        that there is."""
        more = (FINER_IF_UNIFORM if self.uniform_across else 1) * (FINER_IF_MELTING if self.beads_melt else 1)
        shortest = LARGEST_CELL * self.front_width * (STANDING_FRONT if self.beads_against else 1.0)
        return more * max(FEWEST_AXIAL_CELLS, math.ceil(AXIAL_GRADING * self.length / shortest))

    @property
    def heating_duration(self) -> float:
        """By what the fluid brings and by what comes through the wall, s."""
        return 1.0 / (1.0 / self.flow_duration + 1.0 / self.conduction_time)

    @property
    def step_limits(self) -> dict[str, float]:
        """What limits the time steps, by its name: times (s) of which a step is a part."""
        passing = min(self.front_width / self.length, WIDEST_FRONT) * self.flow_duration
        slowest = math.hypot(passing, self.wall_time_constant, self.inlet_time)
        limits = {"rise of the temperature at one place": slowest, FROM_THE_WALL: self.conduction_time}
        if math.isfinite(self.bead_residence_time):  # beads that cross the bed far faster are steady
            limits["residence time of the beads"] = max(self.bead_residence_time, STEADY_BEADS * slowest)
        return limits

    @property
    def step_limit(self) -> str:
        """The name of the shortest of these."""
        limits = self.step_limits
        return min(limits, key=lambda one: limits[one])

    @property
    def largest_step(self) -> float:
        """Default cap of the time steps, s: a part of the time in which the front passes and the wall follows it, or of that in
        which heat comes through the wall; of moving beads that in which they cross the bed."""
        limits = dict(self.step_limits)
        residence = limits.pop("residence time of the beads", math.inf)
        return LARGEST_STEP * min(1.0 / math.hypot(*(1.0 / limit for limit in limits.values())), residence)


def estimate(specs: Specs, size: BedSize) -> Estimates:
    """Estimates of a scene whose bed has this size."""
    heat = specs.heat
    fluid = fluid_at(specs, heat.inlet_temperature.values[-1])
    phi, diameter, laws = specs.porosity.bulk_porosity, specs.mesh.bead_diameter, specs.laws
    driven, slow = _speed(specs, size, fluid), fluid.viscosity / (fluid.density * diameter)
    speed, flowing, flows = max(driven, slow), max(driven, NO_FLOW * slow), driven > NO_FLOW * slow
    gradient = laws.drag.coefficient(phi, diameter, fluid.density, fluid.viscosity, speed) * speed / phi
    reynolds = bead_reynolds_number(phi, fluid.density, speed, diameter, fluid.viscosity)
    prandtl = prandtl_number(fluid.viscosity, fluid.heat_capacity, fluid.conductivity)
    coefficient = laws.nusselt(reynolds, prandtl, phi) * fluid.conductivity / diameter
    layer = math.sqrt(2.0 * fluid.viscosity * speed / gradient)
    friction_velocity = math.sqrt(gradient * layer / fluid.density)
    in_wall_units = FIRST_CELL_IN_WALL_UNITS * fluid.viscosity / (fluid.density * friction_velocity)
    temperature, beads = heat.inlet_temperature.values[-1], laws.beads
    conductivity = beads.conductivity(temperature)
    bead_heat = (1.0 - phi) * beads.density(temperature) * beads.heat_capacity(temperature) * size.area * size.length
    fluid_heat = fluid.density * phi * fluid.heat_capacity * size.area * size.length
    bed_heat = bead_heat + fluid_heat
    advection = fluid.density * phi * flowing * fluid.heat_capacity
    exchange = specific_surface(phi, diameter) * coefficient
    # a front spreads by the film between fluid and beads, by conduction along the beads and by dispersion along the flow; the
    # film by what the beads store of it, as S T_t + q T_x = s (T - T_s)_t with T - T_s = s T_t/E, S = s + phi rho C_f. Beads
    # along with the flow carry it, too: they spread it as (1 - u_s/u)^2, and it passes sooner
    along_with = max(heat.bead_motion.velocity, 0.0)
    carried = advection + along_with * bead_heat / (size.area * size.length)
    core = _core(specs, fluid, speed, conductivity)
    conduction = added(laws.bead_conduction.beads(core), laws.dispersion.mixed(core))
    along, across = (
        (conduction.along, conduction.across) if isinstance(conduction, Anisotropic) else (conduction, conduction)
    )
    transfer_units, jump = exchange * size.length / advection, 0.0
    spreading = along / carried
    if heat.model.two_temperatures:
        film = advection / exchange * (bead_heat / bed_heat) ** 2
        at_rest = math.sqrt(2.0 * size.length * (along / advection + film))
        spreading += film * (1.0 - along_with / speed) ** 2 * advection / carried
        jump = fluid_heat / bed_heat * math.exp(-transfer_units) if flows else 0.0
        width = max(math.sqrt(2.0 * size.length * spreading), min(SHARP_FRONT * size.length, at_rest))
        width = min(width, SHARP_FRONT * size.length) if jump > LEAST_JUMP else width
    else:
        width = math.sqrt(2.0 * size.length * max(spreading, LEAST_SPREADING * diameter))
    depth = 0.5 * size.half_height if size.is_disk else size.half_height  # volume over the area of the wall
    decay = SLOWEST_MODE[size.is_disk] * (across + phi * fluid.conductivity) / size.half_height**2
    bed = Store(bed_heat / (size.area * size.length) * depth, 1.0 / (depth * decay))
    wall = wall_estimate(
        specs,
        size,
        bed,
        coefficient,
        wall_nusselt_number(reynolds) * fluid.conductivity / diameter,
        bed_heat / (advection * size.area),
    )
    of_wall = wall.heat_capacity / (size.length * sum(around for around, _ in size.walls))
    by_flow = (bed_heat + wall.heat_capacity) / (carried * size.area)
    by_conduction = math.inf if flows and not is_heated_from_outside(specs) else conduction_time(specs, bed)
    is_by_wall = not flows or (heat.is_wall_held and by_conduction < by_flow)
    stored_beyond = bed.capacity if is_by_wall else of_wall  # J/m2/K, behind the film of fluid at the wall
    return Estimates(
        flows=flows,
        speed=speed,
        driven_part=driven / speed,
        driven_gradient=laws.drag.coefficient(phi, diameter, fluid.density, fluid.viscosity, driven) * driven / phi,
        pressure_gradient=gradient,
        mass_flux=fluid.density * phi * speed,
        mass_flow=fluid.density * phi * speed * size.area,
        reynolds_number=reynolds * driven / speed,
        prandtl_number=prandtl,
        exchange_coefficient=coefficient,
        bead_biot_number=coefficient * diameter / 6.0 / conductivity,
        transfer_units=transfer_units,
        jump=jump,
        film_time=_film_resistance(specs, core, across, exchange) * stored_beyond,
        wall_biot_number=wall.biot_number,
        conduction_ratio=_conduction_ratio(specs, core),
        radiation_ratio=_radiation_ratio(specs, core),
        first_cell=min(in_wall_units, 0.01 * diameter) / max(prandtl, 1.0) ** (1.0 / 3.0),
        wall_cells=wall.cells,
        thick_layers=wall.thick,
        end_length=wall.end_length,
        front_width=width,
        wall_time_constant=wall.time,
        inlet_time=_inlet_time(heat.inlet_temperature),
        bead_residence_time=size.length / abs(heat.bead_motion.velocity) if heat.bead_motion.velocity else math.inf,
        beads_against=heat.bead_motion.velocity < 0.0,
        uniform_across=_is_uniform_across(specs, core),
        resistance_ratio=_resistance_ratio(specs, fluid.density * speed) if flows else 1.0,
        length=size.length,
        flow_duration=by_flow,
        conduction_time=by_conduction,
        beads_melt=melts(specs.laws.beads.heat_capacity, heat),
    )


def _is_uniform_across(specs: Specs, core: LocalBed) -> bool:
    """Whether nothing changes across the bed: of plug flow between adiabatic walls, where porosity and conduction along the flow
    are the same at any wall distance."""
    is_plug, is_adiabatic = specs.flow.model.kind == "plug", specs.heat.wall.kind == "insulated"
    if not (is_plug and is_adiabatic) or specs.heat.opposite_layers:
        return False
    distances, diameter = np.linspace(0.0, WALL_REGION, 24) * core.bead_diameter, core.bead_diameter
    porosities = specs.porosity.volume(distances, diameter), specs.porosity.area(distances, diameter)
    conductivities = []
    for distance in distances:
        near = replace(core, wall_distance=float(distance))
        conduction = added(specs.laws.bead_conduction.beads(near), specs.laws.dispersion.mixed(near))
        conductivities.append(conduction.along if isinstance(conduction, Anisotropic) else conduction)
    return all(np.ptp(values) <= ROUNDING * np.max(values) for values in (*porosities, conductivities))


def rayleigh_darcy(specs: Specs, low: float, high: float, height: float) -> float:
    """Rayleigh-Darcy number of the bed at rest, with fluid from `low` to `high` (K) over a height (m)."""
    mean, step = 0.5 * (low + high), 0.5 * max(high - low, 0.1)
    fluid, density = fluid_at(specs, mean), specs.laws.fluid.density
    cold, hot = (density(specs.flow.outlet_pressure, mean + side) for side in (-step, step))
    core = replace(_core(specs, fluid, 0.0, specs.laws.beads.conductivity(mean)), temperature=mean)
    phi, diameter = specs.porosity.bulk_porosity, specs.mesh.bead_diameter
    return rayleigh_darcy_number(
        density=fluid.density,
        heat_capacity=fluid.heat_capacity,
        viscosity=fluid.viscosity,
        expansion=float((cold - hot) / (2.0 * step * fluid.density)),
        permeability=float(specs.laws.drag.permeability(phi, diameter)),
        conductivity=float(stagnant_conductivity(core, phi)),
        difference=high - low,
        height=height,
    )


def _inlet_time(series: TimeSeries) -> float:
    """Standard deviation (s) of the time at which a temperature that only rises, or only falls, changes; 0 for others."""
    changes, times = np.diff(series.values), np.array(series.times)
    if len(changes) == 0 or np.min(changes) * np.max(changes) < 0.0 or not np.any(changes):
        return 0.0
    parts, middles = changes / changes.sum(), 0.5 * (times[1:] + times[:-1])
    spread = (middles - parts @ middles) ** 2 + np.diff(times) ** 2 / 12.0
    return float(np.sqrt(parts @ spread))


def _film_resistance(specs: Specs, core: LocalBed, of_beads: float, exchange: float) -> float:
    """What two temperatures resist (m2 K/W) at the wall beyond one, as beads give it no heat: over the depth
    delta = sqrt[K_f K_s/((K_f + K_s) a_v h)] heat goes over from beads that conduct `of_beads` K_s (W/m/K) to the fluid, by
    `exchange` a_v h (W/m3/K), so that R = delta K_s/[K_f (K_f + K_s)], without eddies."""
    law, of_fluid = specs.laws.bead_conduction, core.porosity * core.fluid_conductivity
    if law.whole_bed:
        return 0.0
    together = of_fluid + of_beads
    return float(math.sqrt(of_fluid * of_beads / (together * exchange)) * of_beads / (of_fluid * together))


def _core(specs: Specs, fluid: "FluidProperties", speed: float, bead_conductivity: float) -> LocalBed:
    """The bed far from the wall, without eddies."""
    diameter, temperature = specs.mesh.bead_diameter, specs.heat.inlet_temperature.values[-1]
    return LocalBed(
        porosity=specs.porosity.bulk_porosity,
        wall_distance=1e3 * diameter,
        bead_diameter=diameter,
        density=fluid.density,
        viscosity=fluid.viscosity,
        heat_capacity=fluid.heat_capacity,
        speed=speed,
        eddy_viscosity=0.0,
        fluid_conductivity=fluid.conductivity,
        bead_conductivity=bead_conductivity,
        bulk_porosity=specs.porosity.bulk_porosity,
        core_speed=specs.porosity.bulk_porosity * speed,
        temperature=temperature,
        emissivity=specs.heat.emissivity,
        contact_flattening=specs.laws.beads.contact_flattening,
        bead_heat_capacity=specs.laws.beads.density(temperature) * specs.laws.beads.heat_capacity(temperature),
    )


def _conduction_ratio(specs: Specs, core: LocalBed) -> float:
    found = replace(specs.laws.bead_conduction, mixing_rate=0.0).beads(core)
    across = found.across if isinstance(found, Anisotropic) else found
    return float(across / (stagnant_conductivity(core, core.porosity) + core_dispersion(core)))


def _radiation_ratio(specs: Specs, core: LocalBed) -> float:
    if specs.heat.emissivity:
        return 0.0
    hottest = float(np.max(specs.heat.inlet_temperature.values))
    law, shining = specs.laws.bead_conduction, replace(core, emissivity=COMMON_EMISSIVITY, temperature=hottest)
    conducted = added(added(law.fluid(core), law.beads(core)), specs.laws.dispersion.mixed(core))
    across = conducted.across if isinstance(conducted, Anisotropic) else conducted
    return float((stagnant_conductivity(shining, core.porosity) - stagnant_conductivity(core, core.porosity)) / across)


class FluidProperties(NamedTuple):
    """Properties at a temperature and the bed's mean pressure, SI."""

    density: float
    viscosity: float
    heat_capacity: float
    conductivity: float


def fluid_at(specs: Specs, temperature: Value) -> FluidProperties:
    """Of the scene's fluid at a temperature (K), arrays of an array."""
    fluid, flow = specs.laws.fluid, specs.flow
    half = 0.5 * flow.driven_by.range[1] if flow.drive == "pressure_drop" else 0.0
    return FluidProperties(
        fluid.density(flow.outlet_pressure + half, temperature),
        fluid.viscosity(temperature),
        fluid.heat_capacity(temperature),
        fluid.conductivity(temperature),
    )


def viscosity_ratio(specs: Specs) -> float:
    """The largest viscosity of the fluid at all temperatures that are given over the smallest."""
    heat = specs.heat
    elsewhere = (one for series in heat.given_elsewhere for one in series.range)
    given = (*heat.first_temperatures, *heat.inlet_temperature.range, *elsewhere)
    viscosities = [float(specs.laws.fluid.viscosity(temperature)) for temperature in given]
    return max(viscosities) / min(viscosities)


def resistances(specs: Specs, flux: float) -> tuple[float, ...]:
    """Of the bed (Pa/m) at an intrinsic mass flux (kg/m2/s): at the initial temperature, and at both ends of the inlet's."""
    found = []
    for temperature in (specs.heat.initial_temperature, *specs.heat.inlet_temperature.range):
        fluid, phi, diameter = fluid_at(specs, temperature), specs.porosity.bulk_porosity, specs.mesh.bead_diameter
        speed = flux / fluid.density
        found.append(float(specs.laws.drag.coefficient(phi, diameter, fluid.density, fluid.viscosity, speed) * speed))
    return tuple(found)


def _resistance_ratio(specs: Specs, flux: float) -> float:
    """The largest of all temperatures that are given over that of what enters; 1 where the velocity does not depend on it."""
    if specs.flow.model.kind == "plug" or specs.flow.model.update == "frozen":
        return 1.0
    at_start, *entering = resistances(specs, flux)
    return max(at_start, *entering) / min(entering)


def flow_change(specs: Specs, size: BedSize, before: FluidProperties, after: FluidProperties) -> float:
    """Relative change of the mass flow that a drive brings, between two states of the fluid in the whole bed."""
    return abs(math.log(mass_flow_ratio(specs, size, before, after)))


def mass_flow_ratio(specs: Specs, size: BedSize, before: FluidProperties, after: FluidProperties) -> float:
    """Mass flow that a drive brings with a state of the fluid in the whole bed, over that with the state before; 1 of none."""
    fluxes = [fluid.density * _speed(specs, size, fluid) for fluid in (before, after)]
    return fluxes[1] / fluxes[0] if min(fluxes) > 0.0 else 1.0


def _speed(specs: Specs, size: BedSize, fluid: FluidProperties) -> float:
    """Intrinsic speed (m/s) in the middle of the bed at the strongest drive."""
    phi, strongest = specs.porosity.bulk_porosity, specs.flow.driven_by.range[1]
    if specs.flow.drive == "pressure_drop":
        gravity = 0.0 if specs.flow.by_blower else specs.flow.gravity  # a blower has as heavy a column beside the bed
        force = phi * abs(strongest / size.length + fluid.density * gravity)
        diameter = specs.mesh.bead_diameter
        return float(specs.laws.drag.speed(force, phi, diameter, fluid.density, fluid.viscosity))
    if specs.flow.drive == "inlet_velocity":
        return strongest / phi
    return strongest / (fluid.density * phi * size.area)
