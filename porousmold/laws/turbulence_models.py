r"""Turbulence models as objects: each brings its unknowns, equations, wall and inflow values, and its initial guess.

A model with n unknowns is transported by n equations per total volume,

    phi rho u.grad f = div(phi D grad f) + phi P - phi R,

with diffusivity phi D, production phi P and reaction phi R of `terms`. Where a model has unknowns, the first is the turbulent
kinetic energy. A model without unknowns, as a mixing length, gives the eddy viscosity alone. Formulas take floats, arrays and
UFL alike (`functions`). Theory of k-epsilon and its constants: `laws.turbulence`.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

from . import turbulence as closure
from .functions import Value, number_of, positive_part
from .nusselt import bead_reynolds_number
from .registry import Registry

INNER_RELAXATION = 100.0
"""Rate, in turnovers of the wall's layer, at which epsilon there is tied to its algebraic value."""

INLET_INTENSITY = 1e-5
"""k of the inflow over |u|^2 where no bead source acts: 0.26 % intensity. Changes no heating time by > 0.01 %."""

NO_TURBULENCE = 5e-7
"""Width of the smooth positive part of k over the bed's speed squared, and the least k of epsilon/k: its eddies are 0.04 times as
viscous as the fluid. With less, k of either sign in a laminar core makes Jacobians that hold for no neighbouring flow; heating
times are the same to 1e-6 from 1e-9 to 1e-5."""


@dataclass(frozen=True)
class LocalFlow:
    """The flow at a point, as a turbulence model sees it: porosity, lengths (m), density (kg/m3), viscosity (Pa s), |u| (m/s),
    and the `reference_speed` (m/s) of the bed. Numbers, arrays or UFL."""

    porosity: Value
    bead_diameter: Value
    wall_distance: Value
    density: Value
    viscosity: Value
    speed: Value
    reference_speed: Value

    @property
    def reynolds_number(self) -> Value:
        """Local superficial bead Reynolds number (eq. 6.12)."""
        return bead_reynolds_number(self.porosity, self.density, self.speed, self.bead_diameter, self.viscosity)


@dataclass(frozen=True)
class TurbulentUnknown:
    """A transported quantity: `name` of its field, `symbol` and `unit`; whether it is 0 at a wall, else free there."""

    name: str
    symbol: str
    unit: str
    zero_at_wall: bool


@dataclass(frozen=True)
class TransportTerms:
    """Diffusivity (Pa s), production and reaction of one equation, each multiplied by the porosity."""

    diffusivity: Value
    production: Value
    reaction: Value


@dataclass(frozen=True)
class Continuation:
    """Parameter continuation: start at the `easy` value, change it by this `factor` up to the required value."""

    parameter: str
    easy: float
    factor: float


class TurbulenceModel(ABC):
    """What the flow's equations ask of a model. Subclasses are frozen dataclasses.

    `parameters` name the fields that are numbers (keys of a scene's [model] of the same name give them): the equations take
    them as UFL constants, so that another value needs no compilation.
    """

    unknowns: ClassVar[tuple[TurbulentUnknown, ...]] = ()
    parameters: ClassVar[tuple[str, ...]] = ()
    continuation: ClassVar[Continuation | None] = None
    source: ClassVar[str] = ""

    def with_parameters(self, convert: Callable[[float], Value]) -> Self:
        """The model with its parameters converted, for example to UFL constants."""
        changes: dict[str, Any] = {name: convert(getattr(self, name)) for name in self.parameters}
        return replace(self, **changes)

    def magnitudes(self, speed: Value, length: Value) -> tuple[Value, ...]:
        """Values (SI) that count as 1 of the unknowns, of a reference speed (m/s) and length (m)."""
        return ()

    @abstractmethod
    def state(self, values: Sequence[Value], flow: LocalFlow, shear_rate_squared: Value) -> Any:
        """What follows from the unknowns' values (SI): an object with `eddy_viscosity` (Pa s); `terms` gets it back.

        `shear_rate_squared` is 2 S:S (1/s2).
        """

    def terms(
        self, values: Sequence[Value], flow: LocalFlow, state: Any, shear_rate_squared: Value
    ) -> tuple[TransportTerms, ...]:
        """`TransportTerms` of every unknown's equation."""
        return ()

    def inflow(self, flow: LocalFlow) -> tuple[Value, ...]:
        """Values of the unknowns in what flows in."""
        return ()

    def guess(self, flow: LocalFlow) -> tuple[Value, ...]:
        """First guess of the unknowns (arrays) in a flow that drag and beads alone would make."""
        return self.inflow(flow)

    def has_bead_sources(self, reynolds_number: float) -> bool:
        """Whether beads make turbulence anywhere, at the largest local bead Reynolds number: then no flow is laminar."""
        return False

    def starts_near(self) -> bool:
        """Whether the first guess is so near that Newton's method should be tried from it."""
        return False


TURBULENCE_MODELS: Registry[TurbulenceModel | None] = Registry("turbulence")
TURBULENCE_MODELS.register("none", None)


class TwoLayerState:
    """Everything that follows from k, epsilon, density, viscosity and wall distance at a point.

    `scale` (m2/s2) sets the width of the smooth positive part of k, `half_width` is that of the layers' blend,
    `largest_eddy` (m) the bound on k^1.5/epsilon; arguments are UFL or numpy.
    """

    def __init__(
        self,
        kinetic_energy: Value,
        dissipation_rate: Value,
        density: Value,
        viscosity: Value,
        wall_distance: Value,
        scale: Value,
        half_width: Value,
        largest_eddy: Value,
    ) -> None:
        self.kinetic_energy = kinetic_energy
        self.kinematic_viscosity = viscosity / density
        k = positive_part(kinetic_energy, NO_TURBULENCE * scale)
        least = closure.least_dissipation_rate(k, wall_distance, largest_eddy)
        self.dissipation_positive = least + positive_part(
            dissipation_rate - least, 1e-3 * least + 1e-9 * scale**1.5 / wall_distance
        )
        reynolds = closure.wall_reynolds_number(density, wall_distance, k, viscosity)
        self.reynolds_wall = reynolds
        self.outer = closure.outer_fraction(reynolds, half_width)
        self.turnover_inner = closure.inner_dissipation_rate(1.0, reynolds, wall_distance, self.kinematic_viscosity)
        self.turnover_outer = self.dissipation_positive / (k + NO_TURBULENCE * scale)  # no faster where k is none
        self.eddy_viscosity = self.outer * closure.outer_eddy_viscosity(density, k, self.dissipation_positive) + (
            1.0 - self.outer
        ) * closure.inner_eddy_viscosity(density, k, reynolds, wall_distance)

    @property
    def dissipation(self) -> Value:
        """epsilon of the blend, as the k equation takes it."""
        return self.outer * self.dissipation_positive + (1.0 - self.outer) * self.turnover_inner * self.kinetic_energy


@dataclass(frozen=True)
class KEpsilon(TurbulenceModel):
    """Two-layer k-epsilon, with the bead sources of Nakayama and Kuwahara and their damping where these are switched on.

    `damped`: the beads feed no turbulence where the flow between them is laminar (eq. 7.33). What has come there from elsewhere
    is destroyed by the two-equation model alone, over many metres: the core of a bed below that threshold keeps what it was
    given at the inlet, or, of a developed flow, what came from the wall in an infinite time; its eddies are arbitrary.
    `decaying` lets the beads take it as fast as they would renew it: with f_d eps_inf as source, (1 - f_d) k eps_inf/k_inf is a
    sink of k, and C_2 (1 - f_d) epsilon eps_inf/k_inf one of epsilon. Nakayama and Kuwahara's terms tie the turbulence between
    beads to theirs at the rate eps_inf/k_inf, within d/3; where they make none, k falls at that rate, and as no eddy is
    longer than `longest_eddy` mu_t is gone within some four beads. Full and developed flow then agree.

    `blend_half_width` is that of `laws.turbulence.outer_fraction`, `longest_eddy` the bound on k^1.5/epsilon over the bead
    diameter; numbers or UFL constants.

    In the inner layer epsilon is tied to its algebraic value by a relaxation 100 times faster than its own turnover
    (`INNER_RELAXATION`), which is the smooth form of "epsilon is not solved there": the k equation and the eddy viscosity use
    the algebraic value itself, weighted by the blend.
    """

    bead_sources: bool = False
    damped: bool = False
    decaying: bool = False
    blend_half_width: Value = 120.0
    longest_eddy: Value = 1.0

    unknowns = (
        TurbulentUnknown("turbulent_kinetic_energy", "k", "m2/s2", zero_at_wall=True),
        TurbulentUnknown("dissipation_rate", "epsilon", "m2/s3", zero_at_wall=False),
    )
    parameters = ("blend_half_width", "longest_eddy")
    continuation = Continuation("blend_half_width", easy=120.0, factor=0.85)
    source = "Launder, Spalding 1974; Chen, Patel 1988; Nakayama, Kuwahara 1999; thesis eq. 7.33"

    def magnitudes(self, speed: Value, length: Value) -> tuple[Value, ...]:
        return speed**2, speed**3 / length

    def source_fraction(self, bead_reynolds_number: Value) -> Value:
        """f_d of the bead sources: 0, 1 or the damping of eq. 7.33."""
        if not self.bead_sources:
            return 0.0
        return closure.damping(bead_reynolds_number) if self.damped else 1.0

    def state(self, values: Sequence[Value], flow: LocalFlow, shear_rate_squared: Value) -> TwoLayerState:
        energy, dissipation = values
        return TwoLayerState(
            energy,
            dissipation,
            flow.density,
            flow.viscosity,
            flow.wall_distance,
            flow.reference_speed**2,
            self.blend_half_width,
            self.longest_eddy * flow.bead_diameter,
        )

    def terms(
        self, values: Sequence[Value], flow: LocalFlow, state: TwoLayerState, shear_rate_squared: Value
    ) -> tuple[TransportTerms, ...]:
        k, epsilon = values
        phi, density, speed, diameter = flow.porosity, flow.density, flow.speed, flow.bead_diameter
        production = state.eddy_viscosity * shear_rate_squared
        k_sink = density * state.dissipation
        epsilon_sink = closure.C_EPSILON_2 * density * state.turnover_outer * epsilon
        if self.bead_sources:
            bead_source = self.source_fraction(flow.reynolds_number) * density
            k_sink -= bead_source * closure.bead_dissipation_rate(phi, speed, diameter)
            squared = closure.bead_dissipation_squared_over_energy(phi, speed, diameter)
            epsilon_sink -= closure.C_EPSILON_2 * bead_source * squared
            if self.decaying:
                undone = (1.0 - self.source_fraction(flow.reynolds_number)) * density
                rate = closure.bead_decay_rate(phi, speed, diameter)
                k_sink += undone * rate * state.kinetic_energy
                epsilon_sink += closure.C_EPSILON_2 * undone * rate * epsilon
        tie = (
            INNER_RELAXATION
            * density
            * state.turnover_inner
            * (1.0 - state.outer)
            * (epsilon - state.turnover_inner * k)
        )
        return (
            TransportTerms(
                phi * (flow.viscosity + state.eddy_viscosity / closure.SIGMA_K), phi * production, phi * k_sink
            ),
            TransportTerms(
                phi * (flow.viscosity + state.eddy_viscosity / closure.SIGMA_EPSILON),
                phi * state.outer * state.turnover_outer * closure.C_EPSILON_1 * production,
                phi * (tie + state.outer * epsilon_sink),
            ),
        )

    def inflow(self, flow: LocalFlow) -> tuple[Value, ...]:
        """In equilibrium with the beads, k = f_d k_inf and epsilon = f_d eps_inf, on a small floor."""
        phi, speed, diameter = flow.porosity, flow.speed, flow.bead_diameter
        fraction = self.source_fraction(flow.reynolds_number)
        energy = fraction * closure.bead_kinetic_energy(phi, speed) + INLET_INTENSITY * speed**2
        return energy, (
            fraction * closure.bead_dissipation_rate(phi, speed, diameter) + INLET_INTENSITY * speed**3 / diameter
        )

    def guess(self, flow: LocalFlow) -> tuple[Value, ...]:
        """The beads' undamped turbulence, with the wall layer's epsilon near the wall."""
        phi, speed, diameter = flow.porosity, flow.speed, flow.bead_diameter
        energy = closure.bead_kinetic_energy(phi, speed) + 0.01 * speed**2
        between_beads = closure.bead_dissipation_rate(phi, speed, diameter) + 0.01 * speed**3 / diameter
        off_wall = flow.wall_distance
        reynolds = closure.wall_reynolds_number(flow.density, off_wall, energy, flow.viscosity)
        outer = closure.outer_fraction(reynolds, number_of(self.blend_half_width))
        at_wall = closure.inner_dissipation_rate(energy, reynolds, off_wall, flow.viscosity / flow.density)
        return energy, outer * between_beads + (1.0 - outer) * at_wall

    def has_bead_sources(self, reynolds_number: float) -> bool:
        return self.bead_sources and (not self.damped or reynolds_number > closure.DAMPING_START)

    def starts_near(self) -> bool:
        return self.bead_sources and not self.damped


for _name, _model in {
    "k-epsilon": KEpsilon(),
    "nakayama-kuwahara": KEpsilon(bead_sources=True),
    "damped-nakayama-kuwahara": KEpsilon(bead_sources=True, damped=True),
    "decaying-nakayama-kuwahara": KEpsilon(bead_sources=True, damped=True, decaying=True),
}.items():
    TURBULENCE_MODELS.register(_name, _model)
