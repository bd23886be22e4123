"""The modes of the temperature inside the beads, taken along at the nodes through the stages of a time step."""

from collections.abc import Sequence
from typing import Any

from dolfinx import fem

from ..arrays import Floats
from ..equations.energy import EnergyEquations
from ..laws.bead_interior import remaining_resistance
from ..mesh import fenicsx, ranks
from ..mesh.domain import BED, Domain


class BeadModes:
    """Values of every mode at the nodes, `functions` (K): no unknowns, as a stage gives them from its heat flux.

    `equations` are `EnergyEquations` with an `interior`, `parts` the two temperatures that they are solved for; the beads'
    properties are taken at `property_temperature`.
    """

    depends_on_temperature = False  # within a stage: the equations themselves have what the modes take up

    def __init__(
        self, domain: Domain, equations: EnergyEquations, parts: tuple[Any, Any], property_temperature: fem.Function
    ) -> None:
        assert equations.interior is not None, "beads that are isothermal have no modes"
        self._interior = interior = equations.interior
        self._communicator = domain.communicator
        space = interior.lag.function_space
        self.functions = [fem.Function(space) for _ in interior.eigenvalues]
        self._in_bed = fem.locate_dofs_topological(space, domain.mesh.topology.dim, domain.cells(BED))
        self._flux, self._ratio, self._unit_resistance = (
            (fem.Function(space), fenicsx.compiled_expression(expression, space))
            for expression in (
                equations.transfer.bead_heat_flux(*parts, property_temperature),
                interior.step_ratio(property_temperature),
                interior.unit_resistance(property_temperature),
            )
        )
        self._starts: list[Floats] = []
        self._rates: list[list[Floats]] = []

    def _values(self, function_and_expression: tuple[fem.Function, Any]) -> Any:
        """Present values at the bed's nodes."""
        function, expression = function_and_expression
        function.interpolate(expression)
        return function.x.array[self._in_bed]

    def begin_step(self, step: float, gamma: float) -> None:
        """Start a step (s) whose stages all have theta = `gamma` times it."""
        self._interior.inverse_time.value = 1.0 / (gamma * step)
        self._step_ratio, self._step_resistance = self._values(self._ratio), self._values(self._unit_resistance)
        self._starts = [mode.x.array[self._in_bed] for mode in self.functions]
        self._rates = []

    def begin_stage(self, weights: Sequence[float]) -> None:
        """Start a stage: `weights` (s) are those of the earlier stages' rates."""
        ratio, lag = self._step_ratio, self._interior.lag.x.array
        self._known = [
            start + sum(weight * rates[number] for weight, rates in zip(weights, self._rates, strict=False))
            for number, start in enumerate(self._starts)
        ]
        lag[self._in_bed] = sum(
            ratio * known / (ratio + mu**2) for known, mu in zip(self._known, self._interior.eigenvalues, strict=True)
        )

    def update(self) -> None:
        """Nothing changes before the stage's end."""

    def end_stage(self) -> None:
        """Take the modes that belong to the temperatures which the stage was solved for."""
        ratio, driven = self._step_ratio, 2.0 * self._step_resistance * self._values(self._flux)
        rates = []
        for mode, known, mu in zip(self.functions, self._known, self._interior.eigenvalues, strict=True):
            now = (ratio * known + driven) / (ratio + mu**2)
            mode.x.array[self._in_bed] = now
            rates.append((now - known) * self._interior.inverse_time.value)
        self._rates.append(rates)

    def largest_difference(self) -> float:
        """Largest distance (K) of a bead's surface from its mean in the bed, at the last stage (collective)."""
        rest = remaining_resistance(self._interior.eigenvalues)
        difference = rest * self._values(self._unit_resistance) * self._values(self._flux)
        difference += sum(mode.x.array[self._in_bed] for mode in self.functions)
        return ranks.largest_magnitude(self._communicator, difference)
