"""What is known of a scene before it is solved: speeds, wall shear, heat capacities, and what follows for the mesh.

Order-of-magnitude figures from the scene's own correlations in the middle of the bed. They choose defaults (first
cell, cells through the wall, largest step) and scale the unknowns; no result depends on them.
"""

import math
from dataclasses import dataclass

from .closures.nusselt import prandtl_number, specific_surface

FIRST_CELL_IN_WALL_UNITS = 1.0
FEWEST_AXIAL_CELLS = 18
LARGEST_CELL, LARGEST_STEP = 0.42, 0.25
"""Of the front's width at the outlet, and of the time in which the wall's temperature changes there."""
AXIAL_GRADING = 1.25
"""Axial nodes at L (i/n)^1.25: the thermal front that starts sharp at the inlet meets small cells, and widens as they do."""
LEAST_END_LENGTH = 1e-3
"""Of the bed's length: shorter ends of the wall move the heating time by less than 0.05 %."""


@dataclass(frozen=True)
class Estimates:
    """Of the developed flow in the middle of the bed at the inlet temperature (SI units).

    `front_width` is the standard deviation (m) of the thermal front at the outlet, `wall_time` that (s) in which the wall
    follows the bed, `end_length` that over which the wall's insulated end at the outlet is felt along it.
    """

    speed: float
    pressure_gradient: float
    mass_flux: float
    mass_flow: float
    reynolds_number: float
    exchange_coefficient: float
    bead_biot_number: float
    first_cell: float
    wall_cells: int
    heating_duration: float
    end_length: float

    front_width: float
    wall_time: float
    length: float

    @property
    def axial_cells(self) -> int:
        """Default number of cells along the flow: those at the outlet are shorter than the front is wide."""
        shortest = LARGEST_CELL * self.front_width
        return max(FEWEST_AXIAL_CELLS, math.ceil(AXIAL_GRADING * self.length / shortest))

    @property
    def largest_step(self) -> float:
        """Default cap of the time steps, s: a part of the time in which the front passes and the wall follows it."""
        passing = self.front_width / self.length * self.heating_duration
        return LARGEST_STEP * math.hypot(passing, self.wall_time)


def estimate(scene, bed_size, laws):
    """Estimates of a scene with its `laws.Laws`.

    `bed_size` is (length, width, cross-section) of the bed as `bed_size(scene)` gives it for molds and pipes.
    """
    operation, bead_diameter, phi = scene.operation, scene.bed.bead_diameter, laws.bulk_porosity
    fluid, beads, wall, drag, nusselt = laws.fluid, laws.beads, laws.wall, laws.drag, laws.nusselt
    temperature = operation.inlet_temperature.values[-1]
    pressure = operation.outlet_pressure
    if operation.pressure_drop is not None:
        pressure += 0.5 * operation.pressure_drop.range[1]
    viscosity, conductivity = fluid.viscosity(temperature), fluid.conductivity(temperature)
    heat_capacity, density = fluid.heat_capacity(temperature), fluid.density(pressure, temperature)
    length, width, area = bed_size
    slowest = viscosity / (density * bead_diameter)  # Re = 1: the scale of a scene without flow
    if operation.pressure_drop is not None:
        force = phi * operation.pressure_drop.range[1] / length
        speed = drag.speed(force, phi, bead_diameter, density, viscosity)
    elif operation.inlet_velocity is not None:
        speed = operation.inlet_velocity.range[1] / phi
    else:
        speed = operation.mass_flow.range[1] / (density * phi * area)
    speed = max(speed, slowest)
    gradient = drag.coefficient(phi, bead_diameter, density, viscosity, speed) * speed / phi
    reynolds = density * phi * speed * bead_diameter / viscosity
    coefficient = (
        nusselt(reynolds, prandtl_number(viscosity, heat_capacity, conductivity), phi) * conductivity / bead_diameter
    )
    layer = math.sqrt(2.0 * viscosity * speed / gradient)
    friction_velocity = math.sqrt(gradient * layer / density)
    first_cell = min(FIRST_CELL_IN_WALL_UNITS * viscosity / (density * friction_velocity), 0.01 * bead_diameter)
    solids = 1.0 - phi
    bead_heat = solids * beads.density(temperature) * beads.heat_capacity(temperature) * area * length
    advection = density * phi * speed * heat_capacity
    exchange = specific_surface(phi, bead_diameter) * coefficient
    # dispersion of a front by the film between fluid and beads, and by conduction along the beads
    spreading = advection / exchange + solids * beads.conductivity(temperature) / advection
    wall_heat, wall_cells, end_length, wall_time = 0.0, 1, length, 0.0
    if scene.wall.thickness is not None:
        thickness = scene.wall.thickness
        if scene.geometry.kind == "pipe":
            perimeter = 2.0 * math.pi * (width + thickness / 2)
        else:
            perimeter = area / width + (width if scene.geometry.width and scene.geometry.sides == "wall" else 0.0)
        wall_heat = wall.density(temperature) * wall.heat_capacity(temperature) * perimeter * thickness * length
        biot = coefficient * thickness / wall.conductivity(temperature)
        wall_coefficient = wall_nusselt_number(reynolds) * conductivity / bead_diameter
        resistance = 1.0 / wall_coefficient + 0.5 * thickness / wall.conductivity(temperature)
        wall_time = wall.density(temperature) * wall.heat_capacity(temperature) * thickness * resistance
        wall_cells = min(max(math.ceil(8.0 * math.sqrt(biot)), 1), 12)
        end_length = max(thickness * max(1.0, 1.0 / math.sqrt(biot)), LEAST_END_LENGTH * length)
    return Estimates(
        speed=speed,
        pressure_gradient=gradient,
        mass_flux=density * phi * speed,
        mass_flow=density * phi * speed * area,
        reynolds_number=reynolds,
        exchange_coefficient=coefficient,
        bead_biot_number=coefficient * bead_diameter / 6.0 / beads.conductivity(temperature),
        first_cell=first_cell,
        wall_cells=wall_cells,
        end_length=end_length,
        front_width=math.sqrt(2.0 * length * spreading),
        wall_time=wall_time,
        length=length,
        heating_duration=(bead_heat + wall_heat) / (advection * area),
    )


def wall_nusselt_number(reynolds_number: float) -> float:
    """Nu of the bed's wall with the bead diameter, 2 + 0.17 Re^0.79: an order of magnitude (Li, Finlayson, Chem. Eng. Sci. 32
    (1977) 1055-1066, and a bed at rest)."""
    return 2.0 + 0.17 * reynolds_number**0.79


def bed_size(scene):
    """Length, half height or radius, and cross-section of the computed part of a bed in m, m, m2.

    A mold without a width counts as a metre wide.
    """
    geometry = scene.geometry
    if geometry.kind == "mold":
        half_width = 1.0 if geometry.width is None else geometry.width / 2
        return geometry.length, geometry.cavity_height / 2, half_width * geometry.cavity_height / 2
    radius = geometry.diameter / 2
    return geometry.length, radius, math.pi * radius**2
