"""Regimes of the flow that occur in a run."""

import numpy as np

from ..mesh import ranks
from ..mesh.point_values import nodal_values
from ..solvers.state import SavedNumbers
from .problem import Problem

TURBULENT, LAMINAR = "turbulent", "laminar"
BEGUN = 0.1
"""Of the largest turbulent kinetic energy, from which on the flow counts as turbulent."""


class Regimes:
    """Those that a problem's flow has had, in the order in which they came; `is_also_laminar` tells whether at the start a
    laminar flow stood beside the turbulent one."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self.seen: list[str] = []
        self.is_also_laminar = False

    def note(self) -> None:
        """Note that of the present flow (collective)."""
        self._add(TURBULENT if self._problem.flow.is_turbulent() else LAMINAR)

    def note_beside(self) -> None:
        """Note whether there is a laminar flow beside the present one (collective)."""
        if is_also_laminar(self._problem):
            self.is_also_laminar = True
            self._add(LAMINAR)

    def _add(self, regime: str) -> None:
        if regime not in self.seen:
            self.seen.append(regime)

    def save(self) -> SavedNumbers:
        """Those so far."""
        return {"seen": self.seen, "is_also_laminar": self.is_also_laminar}

    def restore(self, numbers: SavedNumbers) -> None:
        """Go on from what `save()` gave."""
        self.seen, self.is_also_laminar = list(numbers["seen"]), numbers["is_also_laminar"]


def is_also_laminar(problem: Problem) -> bool:
    """Whether beside the present turbulent flow there is a laminar one: sought where no bead source acts (collective).

    Of the developed flow, where the bed is straight.
    """
    model = problem.specs.laws.turbulence
    if model is None or not problem.flow.is_turbulent() or model.has_bead_sources(highest_reynolds_number(problem)):
        return False
    return problem.flow.is_also_laminar()


def turbulence_begins_at(problem: Problem) -> float:
    """Part of the bed's length behind the inlet from which on the flow is turbulent; 0 for a laminar flow, and on a mesh of one's
    own, where the length is not along an axis (collective)."""
    if problem.specs.mesh.own.mesh is not None or not problem.flow.is_turbulent():
        return 0.0
    energy = problem.flow.fields().get("turbulent_kinetic_energy")
    if energy is None:
        return 0.0
    places, values = energy.function_space.tabulate_dof_coordinates()[:, 0], energy.x.array
    _, most = ranks.extremes(problem.communicator, values)
    begin, _ = ranks.extremes(problem.communicator, places[values >= BEGUN * most])
    return begin / problem.domain.length


def highest_reynolds_number(problem: Problem) -> float:
    """Largest local bead Reynolds number (collective)."""
    equations, temperature = problem.medium.equations, problem.medium.flow_temperature
    m = equations.momentum(problem.flow.state, temperature)
    reynolds = equations.bed.reynolds_number(m.density, m.speed, m.viscosity)
    values = nodal_values(reynolds, temperature.function_space)
    return ranks.largest_magnitude(problem.communicator, np.nan_to_num(values))
