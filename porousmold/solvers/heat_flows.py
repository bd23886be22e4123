"""Heat that crosses the boundary of bed and wall, or comes from within: by what, and how much so far."""

from typing import Protocol

import numpy as np
from dolfinx import fem

from ..arrays import Floats
from ..equations.energy import EnergyEquations
from ..equations.heat_budget import HeatBudget
from ..laws.functions import Value
from ..mesh import ranks
from ..mesh.aliases import Communicator
from ..mesh.deferred_forms import DeferredForm
from .protocols import HeatBalance, StageUpdate


class Supply(StageUpdate, Protocol):
    """What gives the inlet its temperature."""

    @property
    def rates(self) -> dict[str, float]:
        """What entries of the `HeatBalance` gain, W."""


class HeatFlows:
    """What brings heat to `temperature` and `bead_temperature` (unknowns in UFL), and the `balance` of what it brought.

    `supply` gives the inlet's temperature where that follows the outlet's.
    """

    def __init__(
        self, communicator: Communicator, equations: EnergyEquations, temperature: Value, bead_temperature: Value
    ) -> None:
        self._communicator = communicator
        budget = HeatBudget(equations)
        forms = {
            "by_fluid": budget.brought_by_fluid(temperature),
            "through_outer_wall": equations.wall.heat_through_outer_wall(temperature),
            "by_sources": equations.wall.heat_by_sources(),
            "stored": budget.displaced(temperature),
            "by_rev_terms": None if equations.rev is None else equations.rev.heat(temperature, bead_temperature),
            "by_beads": None
            if equations.moving_beads is None
            else equations.moving_beads.heat_brought(bead_temperature),
        }
        self._forms = {name: DeferredForm(form) for name, form in forms.items() if form is not None}
        self.balance = HeatBalance()
        self.supply: Supply | None = None

    @property
    def none(self) -> dict[str, float]:
        """No heat (J) of any kind."""
        return dict.fromkeys([*self._forms, *self.of_supply], 0.0)

    @property
    def of_supply(self) -> dict[str, float]:
        """What the inlet's supply adds, W."""
        return self.supply.rates if self.supply else {}

    def here(self) -> Floats:
        """What this rank's cells make of each that is an integral, W."""
        return np.array([fem.assemble_scalar(form.form) for form in self._forms.values()])

    def of_all_ranks(self, crossed: Floats) -> dict[str, float]:
        """Heat (J) of each, from what `here` amounts to over a time on every rank (collective)."""
        return dict(zip(self._forms, ranks.total(self._communicator, crossed), strict=True))
