r"""Weak form of a turbulence model's transport equations over the bed.

The terms are the model's own (`laws.turbulence_models`). The bound on epsilon of k-epsilon (`least_dissipation_rate`) is active
in converged solutions: at the wall's side of the outer layer, and where bead sources fade out.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import ufl

from ..laws.functions import Value
from ..laws.turbulence_models import TransportTerms
from .coordinates import Coordinates
from .stabilisation import metric, streamline_time_scale

if TYPE_CHECKING:
    from .flow import BedMeasures, FlowEquations, FlowState, Momentum


def transport_residual(
    unknowns: Sequence[Value],
    tests: Sequence[Value],
    terms: Sequence[TransportTerms],
    advection: Value,
    coordinates: Coordinates,
    dx: ufl.Measure,
    nodes: ufl.Measure,
) -> Value:
    """Residual of the model's equations over the bed without boundary and pseudo-time terms (form).

    `unknowns` (SI), `tests` and `terms` have one entry an equation, `advection` is phi rho u (kg/m2/s), `nodes` is dx with
    quadrature at the nodes. Streamline upwinding: first order along the flow, where both vary little, in exchange for fields
    without undershoots behind the inlet. The reaction acts at each node by itself: else k undershoots beside beads that feed
    it, in cells longer than it lives.
    """
    form = 0
    for unknown, test, term in zip(unknowns, tests, terms, strict=True):
        along = ufl.dot(advection, ufl.grad(unknown))
        upwind = streamline_time_scale(metric(coordinates.mesh), advection, term.diffusivity)
        form += (
            coordinates.weight
            * (
                (along - term.production) * test
                + term.diffusivity * ufl.dot(ufl.grad(unknown), ufl.grad(test))
                + upwind * along * ufl.dot(advection, ufl.grad(test))
            )
            * dx
        )
        form += coordinates.nodal_weight * term.reaction * test * nodes
    return form


def residual(
    equations: "FlowEquations",
    state: "FlowState",
    old: "FlowState",
    tests: Sequence[Value],
    m: "Momentum",
    inverse_step: Value,
    measures: "BedMeasures",
) -> Value:
    """The same in the flow's equations with a pseudo-time step: all test functions of the flow, each equation of the size of
    one."""
    model, coordinates = equations.model, equations.coordinates
    assert model is not None
    storage = coordinates.weight * equations.bed.porosity * m.density * inverse_step
    tests = [size * test for size, test in zip(equations.turbulence_sizes(), tests[2:], strict=True)]
    shear = coordinates.shear_rate_squared(state.velocity)
    local = equations.local_flow(m.density, m.viscosity, m.speed)
    terms = model.terms(state.turbulence, local, m.turbulence, shear)
    advection = equations.bed.porosity * m.density * state.velocity
    form = transport_residual(state.turbulence, tests, terms, advection, coordinates, *measures)
    for now, before, test in zip(state.turbulence, old.turbulence, tests, strict=True):
        form += storage * (now - before) * test * measures.dx
    return form
