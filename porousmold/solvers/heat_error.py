"""The estimated error of a step of the temperatures (`solvers.step_error`), and of what cures with them."""

import functools
from collections.abc import Callable, Sequence

import numpy as np
from petsc4py import PETSc

from ..arrays import Floats, Integers
from ..mesh import fenicsx
from ..mesh.aliases import Communicator
from ..mesh.deferred_forms import DeferredForm
from .curing import Curing
from .newton import NewtonSystem
from .sdirk import Sdirk, Stages
from .step_error import RegionNorm, StepError


class HeatError:
    """`steps` take the temperatures of a `system`, `store(vector)` assembles the heat that is stored at present; `volumes` is the
    form of the unknowns' volumes, `regions` are the numbers of those that store heat together; where one of them melts between
    two temperatures (K), `melting`, an error counts by its heat, too (`solvers.step_error`)."""

    def __init__(
        self,
        system: NewtonSystem,
        steps: Sdirk,
        store: Callable[[PETSc.Vec], None],
        curing: Sequence[Curing],
        volumes: DeferredForm,
        regions: Sequence[Integers],
        communicator: Communicator,
        melting: tuple[float, float] | None = None,
    ) -> None:
        self._system, self._steps, self._store, self._curing = system, steps, store, curing
        self._volumes, self._regions, self._communicator = volumes, regions, communicator
        self._melting, self._error = melting, system.new_vector()
        self.of_temperatures: Floats = np.zeros(0)
        """Of the owned unknowns (K), in the part of a step that was taken last."""

    @functools.cached_property
    def norm(self) -> RegionNorm:
        """Root mean square over the regions that store heat (collective)."""
        volumes = self._system.new_vector()
        fenicsx.assemble_vector(volumes, self._volumes.form)
        return RegionNorm(self._communicator, volumes.array.copy(), self._regions)

    def of_step(self, stages: Stages, inverse_stage: float) -> StepError:
        """Of the step that was taken last, with `inverse_stage` (1/s) as its stages have it (collective)."""
        difference, weights = self._steps.difference(stages)
        cure = 0.0
        if self._curing:  # what they release between the two solutions heats the difference
            errors = [part.change([weights.of_start, *weights.of_stages]) for part in self._curing]
            cure = max(part.largest(error) for part, error in zip(self._curing, errors, strict=True))
            difference.axpy(-inverse_stage, self._steps.stored_now)
            for part, error in zip(self._curing, errors, strict=True):
                part.add(-error)
            self._store(self._error)
            difference.axpy(inverse_stage, self._error)
            for part, error in zip(self._curing, errors, strict=True):
                part.add(error)
        self._system.apply_inverse(difference, self._error)
        error = self.of_temperatures = self._error.array.copy()
        if self._melting is not None:
            error = np.maximum(np.abs(error), np.abs(self._of_heat(error)))
        return StepError(self.norm(error), cure, weights.order)

    def _of_heat(self, error: Floats) -> Floats:
        """Temperatures (K) whose heat, by the mean capacity between those `melting`, is that of an error (collective)."""
        unknown, owned = self._system.unknown.x, len(error)
        present = unknown.array.copy()
        self._store(self._error)
        heat = self._error.array.copy()
        unknown.array[:owned] += error
        unknown.scatter_forward()
        self._store(self._error)
        unknown.array[:] = present
        mean = self._mean_capacities
        return np.divide(self._error.array - heat, mean, out=np.zeros_like(mean), where=mean > 0.0)

    @functools.cached_property
    def _mean_capacities(self) -> Floats:
        """Of every unknown (J/K), between the temperatures of `melting` (collective)."""
        assert self._melting is not None
        present, heats = self._system.unknown.x.array.copy(), []
        for temperature in self._melting:
            self._system.unknown.x.array[:] = temperature
            self._store(self._error)
            heats.append(self._error.array.copy())
        self._system.unknown.x.array[:] = present
        low, high = self._melting
        return (heats[1] - heats[0]) / (high - low)
