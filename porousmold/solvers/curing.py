"""The degrees of cure of the wall's layers at the nodes, taken along through the stages of a time step."""

from collections.abc import Sequence

import numpy as np
from dolfinx import fem

from ..arrays import Floats
from ..laws.cure import Cure
from ..laws.functions import Value
from ..mesh import fenicsx, ranks
from ..mesh.domain import Domain

LEAST_DEGREE = 1e-6
"""That growth is taken at: below it a cure of an order below 1 is soon through, at any rate."""


class Curing:
    """`degree` (a function) in a layer of `domain` whose cells have a tag; no unknown, as a stage gives it from its
    `temperature`, an expression of the unknowns."""

    depends_on_temperature = True

    def __init__(self, domain: Domain, tag: int, cure: Cure, degree: fem.Function, temperature: Value) -> None:
        self.cure, self.degree = cure, degree
        self._communicator = domain.communicator
        space, dimension = degree.function_space, domain.mesh.topology.dim
        self._temperature = fem.Function(space), fenicsx.compiled_expression(temperature, space)
        self._places = fem.locate_dofs_topological(space, dimension, domain.cells(tag))
        degree.x.array[self._places] = cure.initial
        self._rates: list[Floats] = []

    def begin_step(self, step: float, gamma: float) -> None:
        """Start a step (s) whose stages all have theta = `gamma` times it."""
        self._step, self._theta, self._rates = step, gamma * step, []
        self._start = self.degree.x.array[self._places]
        self._temperature_before = self._present_temperature()

    def begin_stage(self, weights: Sequence[float]) -> None:
        """Start a stage: `weights` (s) are those of the earlier stages' rates."""
        self._known = self._start + sum(w * rate for w, rate in zip(weights, self._rates, strict=False))

    def update(self) -> None:
        """Take the degree that belongs to the present temperature."""
        temperature = self._present_temperature()
        guess = self.degree.x.array[self._places]
        self.degree.x.array[self._places] = self.cure.after(self._known, self._theta, temperature, guess)

    def _present_temperature(self) -> Floats:
        function, expression = self._temperature
        function.interpolate(expression)
        values: Floats = function.x.array[self._places]
        return values

    def end_stage(self) -> None:
        """Keep the rate of the stage."""
        self._rates.append((self.degree.x.array[self._places] - self._known) / self._theta)

    def change(self, weights: Sequence[float]) -> Floats:
        """Change of the degree over the last step by `weights` of its rates at the start and in its stages."""
        rates = [self.cure.rate(self._start, self._temperature_before), *self._rates]
        return np.asarray(self._step * sum(w * rate for w, rate in zip(weights, rates, strict=True)))

    def add(self, change: Floats) -> None:
        """Add a change to the degree."""
        self.degree.x.array[self._places] += change

    def fastest_growth(self, degree: float) -> float:
        """The largest rate (1/s) at which the cure grows by itself where it is below a degree; 0 where nowhere (collective)."""
        present = self.degree.x.array[self._places]
        growth = self.cure.growth(np.maximum(present, LEAST_DEGREE), self._present_temperature())[present < degree]
        return self.largest(np.maximum(growth, 0.0))

    def largest(self, change: Floats) -> float:
        """Largest magnitude over all ranks (collective)."""
        return ranks.largest_magnitude(self._communicator, change)

    def extremes(self) -> tuple[float, float]:
        """Smallest and largest degree of cure in the layer (collective)."""
        return ranks.extremes(self._communicator, self.degree.x.array[self._places])
