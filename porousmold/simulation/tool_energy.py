"""Energy of the whole tool where air is supplied by heater and blower: by source and use, up to the answer of a run.

A run ends with the step in which its answer comes; what heater and blower give after it is not part of what the answer costs, and
would make that jump from step to step. Of the last step counts the part up to the answer, all energies taken as linear in it.
"""

from collections.abc import Mapping

from .problem import Problem


class ToolEnergy:
    """That of a problem with an air supply, at the last two rows of its history."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._before: dict[str, float] = {}
        self._now: dict[str, float] = {}

    def record(self) -> None:
        """Note the present energies at the end of a step (collective)."""
        self._before, self._now = self._now, self._parts()

    def until(self, part: float) -> dict[str, float]:
        """Energies (J) up to a `part` of the last step, the present ones of a run that has no row yet (collective)."""
        present = self._now or self._parts()
        return {name: now - (1.0 - part) * (now - self._before.get(name, now)) for name, now in present.items()}

    def _parts(self) -> dict[str, float]:
        problem, balance = self._problem, self._problem.heat.balance
        assert problem.air_loop is not None
        kept, share = problem.heat_kept(), problem.air_loop.spec.share
        cure, wall = (
            kept.get("cure", 0.0),
            kept.get("wall", 0.0),
        )  # a heat of cure that is left is not among what is stored
        parts = {
            "heater": balance.by_heater,
            "blower": balance.by_blower,
            "cure": cure,
            "sources": balance.by_sources,
            "fluid": balance.stored + cure - wall - kept["beads"],
            "wall": wall,
            "beads": kept["beads"] - balance.by_beads,
            "exhaust": balance.by_exhaust,
            "return_duct": balance.by_duct,
            "outer_wall": -balance.through_outer_wall,
        }
        return {name: share * value for name, value in parts.items()}

    def save(self) -> list[dict[str, float]]:
        """Both rows."""
        return [self._before, self._now]

    def restore(self, rows: list[Mapping[str, float]]) -> None:
        """Go on from what `save()` gave."""
        self._before, self._now = (dict(row) for row in rows)
