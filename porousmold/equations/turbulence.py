r"""Weak form of the two-layer k-epsilon equations with bead sources.

Theory, constants and the bound on epsilon (`least_dissipation_rate`): `porousmold.closures.turbulence`. That bound is
active in converged solutions: at the wall's side of the outer layer, and where bead sources fade out.

In the inner layer epsilon is tied to its algebraic value by a relaxation 100 times faster than its own turnover
(`INNER_RELAXATION`), which is the smooth form of "epsilon is not solved there": the k equation and the eddy viscosity use
the algebraic value itself, weighted by the blend.
"""

from dataclasses import dataclass
from typing import Any

import ufl

from ..closures import turbulence as closure
from ..closures.functions import positive_part
from .stabilisation import streamline_time_scale

INNER_RELAXATION = 100.0


@dataclass(frozen=True)
class TurbulenceModel:
    """Which terms a scene switches on: bead sources at all, and their damping.

    `blend_half_width` is that of `closures.turbulence.outer_fraction`, `longest_eddy` the bound on k^1.5/epsilon over the
    bead diameter; numbers or UFL constants.
    """

    bead_sources: bool = False
    damped: bool = False
    blend_half_width: Any = 120.0
    longest_eddy: Any = 1.0

    def source_fraction(self, bead_reynolds_number):
        """f_d of the bead sources: 0, 1 or the damping of eq. 7.33."""
        if not self.bead_sources:
            return 0.0
        return closure.damping(bead_reynolds_number) if self.damped else 1.0


class TwoLayerState:
    """Everything of the turbulence that follows from k, epsilon, density, viscosity and wall distance at a point.

    `scale` (m2/s2) sets the width of the smooth positive part of k, `half_width` is that of the layers' blend,
    `largest_eddy` (m) the bound on k^1.5/epsilon; arguments are UFL or numpy.
    """

    def __init__(
        self, kinetic_energy, dissipation_rate, density, viscosity, wall_distance, scale, half_width, largest_eddy
    ):
        self.kinetic_energy = kinetic_energy
        self.kinematic_viscosity = viscosity / density
        k = positive_part(kinetic_energy, 1e-9 * scale)
        least = closure.least_dissipation_rate(k, wall_distance, largest_eddy)
        self.dissipation_positive = least + positive_part(
            dissipation_rate - least, 1e-3 * least + 1e-9 * scale**1.5 / wall_distance
        )
        reynolds = closure.wall_reynolds_number(density, wall_distance, k, viscosity)
        self.reynolds_wall = reynolds
        self.outer = closure.outer_fraction(reynolds, half_width)
        self.turnover_inner = closure.inner_dissipation_rate(1.0, reynolds, wall_distance, self.kinematic_viscosity)
        self.turnover_outer = self.dissipation_positive / k
        self.eddy_viscosity = self.outer * closure.outer_eddy_viscosity(density, k, self.dissipation_positive) + (
            1.0 - self.outer
        ) * closure.inner_eddy_viscosity(density, k, reynolds, wall_distance)

    @property
    def dissipation(self):
        """epsilon of the blend, as the k equation takes it."""
        return self.outer * self.dissipation_positive + (1.0 - self.outer) * self.turnover_inner * self.kinetic_energy


def turbulence_terms(state, m, bed, model, shear_rate_squared):
    """(unknown, diffusivity, production, reaction) of the k and the epsilon equation, per total volume, so multiplied by the
    porosity.

    `state` is the flow's `FlowState`, `m` its `Momentum`, `shear_rate_squared` 2 S:S; what is transported is
    reaction - production - div(diffusivity grad unknown). Of the two, the reaction needs the fields at a point alone.
    """
    k, epsilon = state.kinetic_energy, state.dissipation_rate
    phi, density, speed, layers = bed.porosity, m.density, m.speed, m.turbulence
    production = layers.eddy_viscosity * shear_rate_squared
    k_sink = density * layers.dissipation
    epsilon_sink = closure.C_EPSILON_2 * density * layers.turnover_outer * epsilon
    if model.bead_sources:
        bead_source = model.source_fraction(bed.reynolds_number(density, speed, m.viscosity)) * density
        k_sink -= bead_source * closure.bead_dissipation_rate(phi, speed, bed.bead_diameter)
        epsilon_sink -= (
            closure.C_EPSILON_2
            * bead_source
            * closure.bead_dissipation_squared_over_energy(phi, speed, bed.bead_diameter)
        )
    tie = (
        INNER_RELAXATION
        * density
        * layers.turnover_inner
        * (1.0 - layers.outer)
        * (epsilon - layers.turnover_inner * k)
    )
    return (
        (k, phi * (m.viscosity + layers.eddy_viscosity / closure.SIGMA_K), phi * production, phi * k_sink),
        (
            epsilon,
            phi * (m.viscosity + layers.eddy_viscosity / closure.SIGMA_EPSILON),
            phi * layers.outer * layers.turnover_outer * closure.C_EPSILON_1 * production,
            phi * (tie + layers.outer * epsilon_sink),
        ),
    )


def turbulence_residual(state, tests, m, bed, model, coordinates, metric, dx, nodes):
    """Residual of the k and epsilon equations over the bed without boundary and pseudo-time terms (form).

    `tests` are the two test functions, `nodes` is dx with quadrature at the nodes. Streamline upwinding: first order along
    the flow, where both vary little, in exchange for fields without undershoots behind the inlet. The reaction acts at each
    node by itself: else k undershoots beside beads that feed it, in cells longer than it lives.
    """
    advection = bed.porosity * m.density * state.velocity
    terms = turbulence_terms(state, m, bed, model, coordinates.shear_rate_squared(state.velocity))
    form = 0
    for (unknown, diffusivity, production, reaction), test in zip(terms, tests, strict=True):
        along = ufl.dot(advection, ufl.grad(unknown))
        upwind = streamline_time_scale(metric, advection, diffusivity)
        form += (
            coordinates.weight
            * (
                (along - production) * test
                + diffusivity * ufl.dot(ufl.grad(unknown), ufl.grad(test))
                + upwind * along * ufl.dot(advection, ufl.grad(test))
            )
            * dx
        )
        form += coordinates.nodal_weight * reaction * test * nodes
    return form
