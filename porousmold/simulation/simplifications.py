"""What the simplifications of the model that a scene chooses leave out of its heating, and by about how much."""

import math

from ..laws.natural_convection import GRAVITY
from ..scene.features import KEYS
from ..scene.features.geometries import BedSize
from ..scene.scene import Scene
from .estimates import Estimates, flow_change, fluid_at, mass_flow_ratio, resistances
from .specs import Specs

HIGHEST_BIOT_NUMBER = 0.1
"""Up to which what is lumped has one temperature."""
FEWEST_TRANSFER_UNITS = 200.0
"""Between fluid and beads over the bed, where they count as of one temperature: a front is wider by a tenth of the bed (aluminium
mold: 104 units, 11 % of the heating time)."""
STIRRED = 170.0
"""Bead Reynolds number in the middle of the bed, from which on beads stir the fluid beside the wall, where it is faster: the
times of walls are 2 to 11 % longer without that at 220 to 330, 0.5 % at 130."""
LARGEST_BUOYANCY = 0.1
"""Of the drag, that the fluid's weight may change by without a word: at 6 times it the time is 6 % off."""
NOTICEABLE_RISE = 0.01
"""Of the porosity at the wall over that of the bulk, up to which it counts as constant."""
LARGEST_FROZEN_CHANGE = 0.01
"""Of the mass flow, or of the resistance, that a frozen flow leaves out."""
LARGEST_FILM = 0.01
"""Of the heating time, in which heat passes the film of fluid at the wall that one temperature leaves out."""
LONGEST_LAG = 5e-3
"""Of the heat through a wall lumped in thickness, over the time of heating: the error of that time is some two times as large."""


def of_simplifications(scene: Scene, specs: Specs, estimates: Estimates, size: BedSize) -> list[str]:
    """A sentence for each that counts, before a run as after it."""
    found = _of_what_is_left_out(scene, specs, estimates, size)
    found += _of_a_frozen_flow(specs, estimates, size) if specs.flow.model.update == "frozen" else []
    return found + _of_one_temperature(specs, estimates) + _of_a_thin_wall(specs, estimates)


def is_heated_by_its_wall(specs: Specs, estimates: Estimates) -> bool:
    """Whether what conducts across the bed heats or cools it, not the flow."""
    if not estimates.flows:
        return specs.heat.is_wall_held or specs.heat.outer_wall.exchanges
    return specs.heat.is_wall_held and estimates.conduction_time < estimates.flow_duration


def _of_what_is_left_out(scene: Scene, specs: Specs, estimates: Estimates, size: BedSize) -> list[str]:
    """Of the flow beside the wall, of turbulence, of the wall and of gravity, where a scene is simpler than its heating."""
    found, is_plug = [], specs.flow.model.kind == "plug"
    if specs.heat.wall.kind == "insulated" and any(scene.is_given(f"wall.{name}") for name in KEYS["wall"]):
        found.append(
            "model.wall 'insulated' leaves out the wall that [wall] describes: it stores no heat, and the times are those of the "
            "bed alone (see model.wall 'conjugate')"
        )
    if not estimates.flows:
        return found
    at_wall = float(specs.porosity.volume(0.0, specs.mesh.bead_diameter))
    is_even = at_wall <= specs.porosity.bulk_porosity * (1.0 + NOTICEABLE_RISE)
    asks_for_wall = specs.waits_for_heat or bool(specs.time.targets)  # a store gives its heat back
    if (is_plug or is_even) and asks_for_wall and specs.heat.wall.kind != "insulated":
        what, remedy = (
            ("a porosity that is constant", "bed.porosity_model")
            if is_even
            else ("plug flow", "model.flow 'developed'")
        )
        found.append(
            f"{what} leaves out that the fluid flows faster beside the wall of poured beads, and heats it sooner: the times of a "
            f"wall are up to a third too long (see {remedy})"
        )
    reynolds, is_thesis = estimates.reynolds_number, not specs.laws.bead_conduction.whole_bed
    has_none = scene.model.turbulence in ("none", "k-epsilon") and scene.model.dispersion == "none"
    if has_none and is_thesis and not is_plug and reynolds > STIRRED and specs.heat.wall.kind != "insulated":
        found.append(
            f"what beads stir beside the wall at a bead Reynolds number of {reynolds:.3g} is left out by model.turbulence "
            f"{scene.model.turbulence!r}: the wall is heated up to a tenth too late (see 'damped-nakayama-kuwahara')"
        )
    low, high = specs.heat.given_bounds
    fluid, pressure = specs.laws.fluid, specs.flow.outlet_pressure
    lighter = abs(float(fluid.density(pressure, low)) - float(fluid.density(pressure, high)))
    buoyancy = lighter * GRAVITY * size.length
    drag = estimates.driven_gradient * size.length
    if specs.flow.gravity == 0.0 and not is_plug and buoyancy > LARGEST_BUOYANCY * drag:
        found.append(
            f"operation.gravity is left out: the fluid's weight changes by {buoyancy:.2g} Pa over the bed with the temperature, "
            f"and its drag is {drag:.2g} Pa; upright it flows otherwise, and rises across a bed that lies"
        )
    return found


def _of_a_frozen_flow(specs: Specs, estimates: Estimates, size: BedSize) -> list[str]:
    """Whether the flow that is kept from the start is another one later: of a given pressure drop, or that which drives it."""
    if not estimates.flows:
        return []
    start, inlet = fluid_at(specs, specs.heat.initial_temperature), specs.heat.inlet_temperature.range
    temperature = max(inlet, key=lambda one: flow_change(specs, size, start, fluid_at(specs, one)))
    is_driven = specs.flow.drive == "pressure_drop"  # of a velocity, the inlet's density tells the mass flow
    ratio = mass_flow_ratio(specs, size, start, fluid_at(specs, temperature)) if is_driven else 1.0
    remedy = "(see model.flow_update 'quasi-steady')"
    if abs(ratio - 1.0) > LARGEST_FROZEN_CHANGE:
        return [
            f"the flow is frozen as it begins: with fluid of {temperature - 273.15:.4g} °C in the bed its mass flow would be "
            f"{ratio:.3g} times as large, and heating times are off by up to as much {remedy}"
        ]
    found = resistances(specs, estimates.mass_flux)
    if max(found) > (1.0 + LARGEST_FROZEN_CHANGE) * min(found):
        return [
            f"the flow is frozen as it begins: the bed resists by a factor of up to {max(found) / min(found):.3g} "
            f"more at one temperature than at another, and pressure drop and pumping work are off by up to as much {remedy}"
        ]
    return []


def _of_one_temperature(specs: Specs, estimates: Estimates) -> list[str]:
    """Whether fluid and beads count as of one temperature, and are not: along the bed, or at the wall."""
    heat, found = specs.heat, []
    if heat.model.two_temperatures:
        return []
    if estimates.flows and estimates.transfer_units < FEWEST_TRANSFER_UNITS:
        found.append(
            f"here it has {estimates.transfer_units:.2g} transfer units over the bed: a front is wider by some "
            f"{math.sqrt(2.0 / estimates.transfer_units):.0%} of the bed"
        )
    low, high = heat.given_bounds
    decay = math.log(max((high - low) / specs.time.heated.margin, math.e))
    duration = estimates.heating_duration + decay * estimates.wall_time_constant
    part = estimates.film_time / duration
    if math.isinf(estimates.conduction_time):  # the wall follows the bed, until it is within the margin
        part *= math.sqrt(decay)
    if part > LARGEST_FILM:
        found.append(
            "by model.bead_conduction beads give no heat to the wall, which the fluid beside it resists to: that takes of the "
            f"order of {part:.1%} of the heating time"
        )
    if not found:
        return []
    return [
        f"with one temperature the exchange between fluid and beads counts as perfect; {'; '.join(found)}; heating takes "
        "longer by as much (see model.energy 'two-temperature')"
    ]


def _of_a_thin_wall(specs: Specs, estimates: Estimates) -> list[str]:
    """Whether a wall that is lumped in its thickness s resists: outside by h s/lambda, as lag by s^2/(2 alpha) of the time."""
    heat = specs.heat
    if heat.wall.kind != "thin" or heat.layers[0].thickness is None:
        return []
    thickness, solid, temperature = heat.layers[0].thickness, heat.layers[0].solid, heat.initial_temperature
    resistance = thickness / float(solid.conductivity(temperature))
    hottest = max(*heat.first_temperatures, heat.inlet_temperature.range[1])
    outside = heat.outer_wall.film(hottest) * resistance
    capacity = float(solid.density(temperature) * solid.heat_capacity(temperature))
    lag = 0.5 * resistance * thickness * capacity / estimates.heating_duration
    given = 0.0
    if heat.outer_wall.heat_flux is not None:
        most = max(abs(value) for value in heat.outer_wall.heat_flux.range) * heat.outer_wall.heat_flux_factor
        given = most * resistance / max(hottest - min(*heat.first_temperatures, heat.inlet_temperature.range[0]), 1.0)
    if max(outside, given) <= HIGHEST_BIOT_NUMBER and lag <= LONGEST_LAG:
        return []
    beside = f", {outside:.2g} times that to the surroundings" if outside > HIGHEST_BIOT_NUMBER else ""
    return [
        f"the wall resists by {resistance:.2g} m2K/W{beside}, and heat takes some {lag:.0%} of the heating to pass it: "
        "model.wall 'thin' leaves both out (see model.wall 'conjugate')"
    ]
