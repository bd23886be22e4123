"""Regimes of the flow that occur in a run."""

from collections.abc import Mapping
from typing import Any

from .problem import Problem

TURBULENT, LAMINAR = "turbulent", "laminar"


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
        if self._problem.is_also_laminar():
            self.is_also_laminar = True
            self._add(LAMINAR)

    def _add(self, regime: str) -> None:
        if regime not in self.seen:
            self.seen.append(regime)

    def save(self) -> dict[str, Any]:
        """Those so far."""
        return {"seen": self.seen, "is_also_laminar": self.is_also_laminar}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        """Go on from what `save()` gave."""
        self.seen, self.is_also_laminar = list(numbers["seen"]), numbers["is_also_laminar"]
