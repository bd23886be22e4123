"""A fluidised bed of one temperature: how far it expands, and its exchange with its fluid and its wall (`laws.fluidisation`)."""

from dataclasses import dataclass

from ..errors import InputError
from ..laws import fluidisation
from ..laws.nusselt import prandtl_number, specific_surface
from ..scene.chosen_laws import Laws
from ..scene.features.geometries import BedSize
from ..scene.scene import Scene


@dataclass(frozen=True)
class State:
    """The bed at a temperature, SI: superficial velocities of the fluid, at minimum fluidisation and of a single bead; porosity,
    height, coefficient at the wall (W/m2/K), transfer units between fluid and beads, mass flow and the fluid's density."""

    velocity: float
    minimum_velocity: float
    terminal_velocity: float
    porosity: float
    height: float
    wall_coefficient: float
    transfer_units: float
    mass_flow: float
    fluid_density: float


def state_of(scene: Scene, laws: Laws, size: BedSize, time: float, temperature: float) -> State:
    """The bed of a scene at a time (s), all of it at a temperature (K). Raises `InputError` where the gas does not lift the
    beads, or carries them away."""
    fluid, beads, at_rest = laws.fluid, laws.beads, laws.bulk_porosity
    diameter, operation = scene.bed.bead_diameter, scene.operation
    density = fluid.density(operation.outlet_pressure, temperature)
    viscosity, conductivity = fluid.viscosity(temperature), fluid.conductivity(temperature)
    capacity, bead_density = fluid.heat_capacity(temperature), beads.density(temperature)
    if operation.mass_flow is not None:
        mass_flow = operation.mass_flow(time)
    else:
        inlet = fluid.density(operation.outlet_pressure, operation.inlet_temperature(time))
        mass_flow = inlet * operation.inlet_velocity(time) * size.area
    velocity = mass_flow / (density * size.area)
    archimedes = fluidisation.archimedes_number(diameter, density, bead_density, viscosity)
    minimum = fluidisation.minimum_fluidisation_reynolds_number(archimedes, at_rest)
    terminal = fluidisation.terminal_reynolds_number(archimedes)
    to_velocity = viscosity / (density * diameter)
    if not minimum < velocity / to_velocity < terminal:
        allowed = (
            f"gives {velocity:.3g} m/s at {temperature:.4g} K: must be above {minimum * to_velocity:.3g} m/s, which "
            f"lifts the beads, and below {terminal * to_velocity:.3g} m/s, which carries them away"
        )
        key = "inlet_velocity" if operation.mass_flow is None else "mass_flow"
        value = getattr(operation, key)(time)
        raise InputError(f"operation.{key}", value, allowed, scene.source)
    porosity = fluidisation.expanded_porosity(velocity / to_velocity, minimum, terminal, at_rest)
    height = size.length * (1.0 - at_rest) / (1.0 - porosity)
    prandtl = prandtl_number(viscosity, capacity, conductivity)
    film = laws.nusselt(velocity / to_velocity, prandtl, porosity) * conductivity / diameter
    exchange = scene.model.exchange_factor * film * specific_surface(porosity, diameter)
    return State(
        velocity=velocity,
        minimum_velocity=minimum * to_velocity,
        terminal_velocity=terminal * to_velocity,
        porosity=porosity,
        height=height,
        wall_coefficient=_wall_coefficient(scene, laws, temperature, density, porosity, prandtl, archimedes),
        transfer_units=float(exchange * height / (density * velocity * capacity)),
        mass_flow=mass_flow,
        fluid_density=density,
    )


def _wall_coefficient(
    scene: Scene, laws: Laws, temperature: float, density: float, porosity: float, prandtl: float, archimedes: float
) -> float:
    """Between bed and wall, W/m2/K, for the gas's density (kg/m3) and the bed's porosity."""
    fluid, beads = laws.fluid, laws.beads
    diameter, pressure = scene.bed.bead_diameter, scene.operation.outlet_pressure
    conductivity = fluid.conductivity(temperature)
    path = fluidisation.modified_mean_free_path(
        temperature,
        pressure,
        conductivity,
        fluid.heat_capacity(temperature),
        pressure / (density * temperature),
        fluidisation.GAS_CONSTANTS.get(scene.fluid.material, 2.8),
    )
    bed = fluidisation.BubblingBed(
        diameter=diameter,
        porosity=porosity,
        porosity_at_minimum=laws.bulk_porosity,
        bead_heat_capacity=beads.density(temperature) * beads.heat_capacity(temperature),
        bead_conductivity=beads.conductivity(temperature),
        conductivity=conductivity,
        mean_free_path=path,
        prandtl=prandtl,
        archimedes=archimedes,
        emissivity=scene.bed.emissivity,
        temperature=temperature,
    )
    return float(bed.wall_nusselt_number() * conductivity / diameter)
