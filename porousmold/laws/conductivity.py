r"""Conduction and dispersion of heat in a bed, per total volume.

The fluid conducts what its molecules conduct and what dispersion and eddies carry; the beads conduct by a law of their own.

| `model.bead_conduction`   | beads                     | fluid at rest | beads at the wall              |
|---------------------------|---------------------------|---------------|--------------------------------|
| `bulk`                    | (1 - phi) lambda_s        | phi lambda_f  | insulated                      |
| `zehner-bauer-schluender` | lambda_0 less the fluid's | phi lambda_f  | at rest T_s = T_w, insulated with flow |

`bulk` is the thesis's (eq. 7.11): beads and fluid side by side, as if each ran through the bed. Beads touch at points, and most
of the heat between them crosses the fluid in the gaps: a measured bed of steel beads conducts 21 times as much as its air, where
`bulk` gives 900. Zehner and Schluender's cell model, with Bauer's contacts and radiation (VDI Heat Atlas D6.3), gives the
conductivity of the whole bed at rest. With kappa = lambda_s/lambda_f, the flattened share c of a bead's section and
r = 4 sigma T^3 d/((2/e - 1) lambda_f) for the emissivity e,

    lambda_0/lambda_f = (1 - s)(1 + phi r) + s [c kappa + (1 - c) k_c],   s = sqrt(1 - phi),
    k_c = 2/N [B (kappa + r - 1)/(N^2 kappa) ln((kappa + r)/B) + (B + 1)/(2 B) (r - B) - (B - 1)/N],
    B = 1.25 ((1 - phi)/phi)^(10/9),   N = 1 + (r - B)/kappa.

k_c is regular at N = 0; written with x = N kappa/B it has no small divisor (`_core_conductivity`). With radiation it does not end
as phi -> 1: what radiation adds is taken from the core, in proportion to the solids. Published scatter +-30 % for kappa < 1000.

**The wall.** Heat transfer through the layer next to the wall depends on the flow. Without flow, heat crosses the thin gaps
around the contact points of beads and wall. Schluender's contact coefficient gives a resistance of 0.6 d/lambda_0 from the wall
to the centre of the first beads, and a measured bed of steel beads shows no resistance beyond that of the bed. Therefore the
stagnant conductivity of the whole bed extends to the wall: T_s = T_w, with the bulk's lambda_0. With flow, measured wall heat
transfer agrees with a model without this path: lambda_0 follows the porosity phi -> 1, the beads are insulated from the wall,
and all heat is transferred by dispersion in the fluid (eight correlation sets; an additional contact coefficient overestimates
them). The weight w = exp(-Pe_c/5), with Pe_c on the superficial speed of the core, blends the two limits:

    lambda_0 = lambda_0(phi) + [lambda_0(phi_b) - lambda_0(phi)] w,  heat from wall to beads h (T_w - T_s), h = 10^4 w lambda_f/d.

Both ends are measured, the passage between them (Re_d 0 to 40 in air) is not. Limits: without flow both temperatures follow
each other, and the bed is one slab of lambda_0(phi_b), held at T_w within 0.02 d of its thickness or less; with fast exchange
the sum of both equations is that of Winterberg and Tsotsas with one temperature; phi -> 1 at the wall gives lambda_f with flow;
lambda_s = lambda_f gives lambda_f everywhere.

| `model.dispersion`        | across the flow                              | along it |
|---------------------------|----------------------------------------------|----------|
| `none`                    | phi C_f mu_t/Pr_t                            | the same |
| `winterberg-tsotsas`      | the larger of that and K_1 Pe f(y) lambda_f  | phi C_f mu_t/Pr_t |
| `winterberg-tsotsas-axial`| the same                                     | the larger of that and Pe/2 lambda_f |

(Winterberg, Tsotsas, Krischke, Vortmeyer, Chem. Eng. Sci. 55 (2000) 967-979): K_1 = 1/8, f = min(y/(K_2 d), 1)^2, K_2 = 0.44 +
4 exp(-Re_d/70). Their Pe is on the core's speed and their Re_d on the mean one, of a model with one temperature; here both are
local, which a curved bed has as well, and with two temperatures comes closer to the measurements. Eddies and dispersion are two
descriptions of the same mixing: their sum is 14 to 18 % above measured heat transfer, the larger of the two is not. Fitted for
D/d >= 4, Pe <= 1e4.

A law gives a number or, where conduction along and across the flow differ, `Anisotropic`. Stirred beads carry heat besides
(`laws.stirring`), which is added to what they conduct.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

from .functions import Value, exp, ln, maximum, minimum, scaled, sqrt, where_less
from .registry import Registry
from .stirring import stirring_conductivity
from .turbulence import PRANDTL_TURBULENT

STEFAN_BOLTZMANN = 5.670374419e-8
"""W/m2/K4."""
REST = 5.0
"""Pe of the core above which the gaps at the wall count as swept by the flow."""
TOUCHING = 1e4
"""h d/lambda_f between the wall and beads at rest: its resistance is that of 0.002 bead diameters of a bed of steel beads in air
(lambda_0 = 18 lambda_f), 0.02 of one of aluminium beads."""
LEAST_SOLIDS = 1e-6
"""Share of the volume below which the beads are taken as constant: 1 - sqrt(1e-6) of the section is fluid then."""


@dataclass(frozen=True)
class LocalBed:
    """The bed at a point, as a conductivity law sees it: porosity, lengths (m), the fluid's density (kg/m3), viscosity (Pa s),
    heat capacity (J/kg/K), intrinsic speed (m/s) and eddy viscosity (Pa s; 0 without turbulence), the conductivities (W/m/K)
    of both, the porosity and the superficial speed (m/s) of the core beside the place, the temperature (K) of radiation between
    beads, their emissivity, the flattened share of a bead's section and the heat capacity of the beads' volume (J/m3/K).
    Numbers, arrays or UFL."""

    porosity: Value
    wall_distance: Value
    bead_diameter: Value
    density: Value
    viscosity: Value
    heat_capacity: Value
    speed: Value
    eddy_viscosity: Value
    fluid_conductivity: Value
    bead_conductivity: Value
    bulk_porosity: Value
    core_speed: Value
    temperature: Value
    emissivity: Value = 0.0
    contact_flattening: Value = 0.0
    bead_heat_capacity: Value = 0.0

    @property
    def peclet_number(self) -> Value:
        """rho C |u| phi d/lambda_f, on the superficial speed."""
        carried = self.density * self.heat_capacity * self.porosity * self.speed
        return carried * self.bead_diameter / self.fluid_conductivity

    @property
    def reynolds_number(self) -> Value:
        """rho |u| phi d/mu, on the superficial speed."""
        return self.density * self.porosity * self.speed * self.bead_diameter / self.viscosity


class Anisotropic(NamedTuple):
    """Conductivities along the flow and across it, W/m/K."""

    along: Value
    across: Value


@dataclass(frozen=True)
class BeadConduction:
    """Conduction at rest: `formula` gives W/m/K per total volume of a `LocalBed`, of the beads alone or, `whole_bed`, of the bed
    with its fluid, which ends at the wall."""

    formula: Callable[[LocalBed], Value]
    source: str
    whole_bed: bool = False
    factor: Value = 1.0
    """On what the beads conduct, for the scatter of its measurements."""
    mixing_rate: Value = 0.0
    """c gamma of beads that are stirred, 1/s (`laws.stirring`)."""

    def fluid(self, bed: LocalBed) -> Value:
        """What the fluid conducts by its molecules, W/m/K per total volume: no more than the whole bed does."""
        alone = bed.porosity * bed.fluid_conductivity
        return minimum(alone, self.formula(bed)) if self.whole_bed else alone

    def beads(self, bed: LocalBed) -> Value:
        """What the beads conduct and carry, W/m/K per total volume: of the whole bed's what the fluid leaves."""
        still = times(self.factor, self.formula(bed) - self.fluid(bed) if self.whole_bed else self.formula(bed))
        if isinstance(self.mixing_rate, float) and self.mixing_rate == 0.0:
            return still
        stirred = stirring_conductivity(bed.porosity, bed.bead_heat_capacity, self.mixing_rate, bed.bead_diameter)
        return added(still, stirred)


@dataclass(frozen=True)
class Dispersion:
    """What the moving fluid mixes, eddies included: `formula` gives W/m/K per total volume of a `LocalBed`, a number or
    `Anisotropic`; `factor` is for the scatter of its measurements."""

    formula: Callable[[LocalBed], Value]
    source: str
    factor: Value = 1.0

    def mixed(self, bed: LocalBed) -> Value:
        """The formula times the factor."""
        return times(self.factor, self.formula(bed))


def times(factor: Value, conductivity: Value) -> Value:
    """A conductivity, number or `Anisotropic`, times a number."""
    if isinstance(conductivity, Anisotropic):
        return Anisotropic(*(scaled(part, factor) for part in conductivity))
    return scaled(conductivity, factor)


def added(conductivity: Value, more: Value) -> Value:
    """Sum of two conductivities, numbers or `Anisotropic`."""
    if not isinstance(conductivity, Anisotropic) and not isinstance(more, Anisotropic):
        return conductivity + more
    (along, across), (more_along, more_across) = (
        part if isinstance(part, Anisotropic) else (part, part) for part in (conductivity, more)
    )
    return Anisotropic(along + more_along, across + more_across)


def eddy_conductivity(bed: LocalBed) -> Value:
    """phi C_f mu_t/Pr_t, W/m/K per total volume."""
    return bed.porosity * bed.heat_capacity * bed.eddy_viscosity / PRANDTL_TURBULENT


def bulk_bead_conductivity(bed: LocalBed) -> Value:
    """(1 - phi) lambda_s, W/m/K."""
    return (1.0 - bed.porosity) * bed.bead_conductivity


def stagnant_conductivity(bed: LocalBed, porosity: Value) -> Value:
    """lambda_0 of Zehner, Bauer and Schluender at a porosity, W/m/K: of the whole bed at rest.

    Porosity in (0, 1], any conductivities; lambda_f where the porosity is 1 or both conduct alike without radiation.
    """
    solids = maximum(1.0 - porosity, LEAST_SOLIDS)
    ratio = bed.bead_conductivity / bed.fluid_conductivity
    radiation: Value = 0.0
    if not (isinstance(bed.emissivity, float) and bed.emissivity == 0.0):
        exchanged = 4.0 * STEFAN_BOLTZMANN * bed.temperature**3 * bed.bead_diameter
        radiation = exchanged * bed.emissivity / ((2.0 - bed.emissivity) * bed.fluid_conductivity)
    cylinder = sqrt(solids)
    shape = 1.25 * (solids / porosity) ** (10.0 / 9.0)
    core = _core_conductivity(ratio, shape, radiation)
    touching = bed.contact_flattening
    through = touching * ratio + (1.0 - touching) * core
    at_rest = (1.0 - cylinder) * (1.0 + porosity * radiation) + cylinder * through
    return bed.fluid_conductivity * at_rest


def rest(bed: LocalBed) -> Value:
    """w = exp(-Pe_c/`REST`): 1 where the fluid rests, 0 where it flows."""
    peclet = bed.density * bed.heat_capacity * bed.core_speed * bed.bead_diameter / bed.fluid_conductivity
    return exp(-peclet / REST)


def conductivity_up_to_the_wall(bed: LocalBed) -> Value:
    """lambda_0(phi) + [lambda_0(phi_b) - lambda_0(phi)] w, W/m/K.

    Radiation is that of the core, with the share of the solids: the cell model has none at phi -> 1, where its beads vanish but
    not what they radiate.
    """
    dark = replace(bed, emissivity=0.0)
    local, core = stagnant_conductivity(dark, bed.porosity), stagnant_conductivity(bed, bed.bulk_porosity)
    if bed.emissivity is not dark.emissivity:
        radiated = core - stagnant_conductivity(dark, bed.bulk_porosity)
        local += radiated * (1.0 - bed.porosity) / (1.0 - bed.bulk_porosity)
    return local + (core - local) * rest(bed)


def wall_coefficient(bed: LocalBed) -> Value:
    """h between the wall and the beads of a whole bed, W/m2/K."""
    return TOUCHING * rest(bed) * bed.fluid_conductivity / bed.bead_diameter


def _core_conductivity(ratio: Value, shape: Value, radiation: Value) -> Value:
    """k_c with x = N kappa/B = (kappa + r - B)/B and g = [ln(1 + x)/x - 1 + x/2]/x^2, without a small divisor.

    k_c = (B + 1) kappa/B + 2 (kappa/B)^2 [g (x B + B - 1) - B/2], as kappa + r - 1 = x B + B - 1 and
    ln((kappa + r)/B) = ln(1 + x).
    """
    x = (ratio + radiation - shape) / shape
    relative = ratio / shape
    return (shape + 1.0) * relative + 2.0 * relative**2 * (
        _logarithm_remainder(x) * (x * shape + shape - 1.0) - shape / 2.0
    )


def _logarithm_remainder(x: Value) -> Value:
    """[ln(1 + x)/x - 1 + x/2]/x^2 for x > -1, by its series 1/3 - x/4 + x^2/5 - ... where |x| < 0.1."""
    series = 0.0 * x + 1.0 / 13.0
    for number in range(12, 2, -1):
        series = 1.0 / number - x * series
    near = where_less(x * x, 0.01, 1.0, 0.0)
    safe = near + (1.0 - near) * x
    closed = (ln(1.0 + safe) / safe - 1.0 + 0.5 * safe) / safe**2
    return near * series + (1.0 - near) * closed


def core_dispersion(bed: LocalBed) -> Value:
    """K_1 Pe lambda_f of Winterberg and Tsotsas, W/m/K: across the flow far from the wall."""
    return bed.peclet_number / 8.0 * bed.fluid_conductivity


def _transverse(bed: LocalBed) -> Value:
    """K_1 Pe f(y) lambda_f, W/m/K."""
    reach = (0.44 + 4.0 * exp(-bed.reynolds_number / 70.0)) * bed.bead_diameter
    return core_dispersion(bed) * minimum(bed.wall_distance / reach, 1.0) ** 2


def _across(bed: LocalBed) -> Anisotropic:
    eddies = eddy_conductivity(bed)
    return Anisotropic(along=eddies, across=maximum(eddies, _transverse(bed)))


def _across_and_along(bed: LocalBed) -> Anisotropic:
    along, across = _across(bed)
    return Anisotropic(maximum(along, bed.peclet_number / 2.0 * bed.fluid_conductivity), across)


BEAD_CONDUCTION_LAWS: Registry[BeadConduction] = Registry("bead conduction")
BEAD_CONDUCTION_LAWS.register("bulk", BeadConduction(bulk_bead_conductivity, "thesis eq. 7.11"))
BEAD_CONDUCTION_LAWS.register(
    "zehner-bauer-schluender",
    BeadConduction(conductivity_up_to_the_wall, "Zehner, Bauer, Schluender, VDI Heat Atlas D6.3", whole_bed=True),
)
DISPERSION_LAWS: Registry[Dispersion] = Registry("dispersion")
_WINTERBERG_TSOTSAS = "Winterberg, Tsotsas, Krischke, Vortmeyer, Chem. Eng. Sci. 55 (2000) 967-979"
DISPERSION_LAWS.register("none", Dispersion(eddy_conductivity, "thesis eq. 7.11"))
DISPERSION_LAWS.register("winterberg-tsotsas", Dispersion(_across, _WINTERBERG_TSOTSAS))
DISPERSION_LAWS.register("winterberg-tsotsas-axial", Dispersion(_across_and_along, _WINTERBERG_TSOTSAS))
