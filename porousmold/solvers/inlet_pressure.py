"""The pressure before the inlet of a locally developed flow, found with the pressure in the bed where the mass flow is given.

By elimination: with dp/dP of one more solve with the same matrix the mass flow is linear in the inlet's pressure P.
"""

from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from ..arrays import Integers
from ..equations.locally_developed import LocallyDeveloped
from ..mesh import fenicsx, ranks
from ..mesh.deferred_forms import DeferredForm
from ..mesh.domain import Domain
from .newton import NewtonSystem
from .protocols import Inflow

LARGEST_CHANGE = 0.5
"""Of the inlet's pressure in an iteration, as a part of itself or of the reference pressure."""


class InletPressure:
    """Gauge pressure (Pa) `at_boundary`, a function, at the inlet's nodes, as the `inflow` drives the flow of a `system` of
    `local` forms; `ds` is the inlet's measure."""

    def __init__(
        self,
        domain: Domain,
        inflow: Inflow,
        at_boundary: fem.Function,
        nodes: Integers,
        system: NewtonSystem,
        local: LocallyDeveloped,
        ds: ufl.Measure,
    ) -> None:
        self._communicator, self._inflow, self._system = domain.communicator, inflow, system
        self._at_boundary, self._nodes, self._equations = at_boundary, nodes, local.equations
        space = at_boundary.function_space
        weight, test = local.equations.coordinates.weight, ufl.TestFunction(space)
        self._entering = DeferredForm(-weight * local.outward * ds)
        self._by_pressure = DeferredForm(weight * local.conductance * test * ds)
        self._gain, self._push = fem.Function(space), system.new_vector()
        self._gained = DeferredForm(weight * local.conductance * (1.0 - self._gain) * ds)
        self.changed = 0.0
        """Change by the last update, over the pressure itself or the reference pressure."""

    @property
    def value(self) -> float:
        """At present (collective)."""
        low, high = ranks.extremes(self._communicator, self._at_boundary.x.array[self._nodes])
        return float(low if abs(low) > abs(high) else high)

    @value.setter
    def value(self, pressure: float) -> None:
        self._at_boundary.x.array[self._nodes] = pressure
        self._at_boundary.x.scatter_forward()

    def follow_mass_flow(self, update: Any) -> None:
        """Change a Newton update of the pressure, and the inlet's, so that the mass flow is as given (collective)."""
        self.changed = 0.0
        inlet, given = self.value, self._given(self.value)
        if given is None:
            return
        pressure = self._system.unknown
        fenicsx.petsc_vector(pressure).axpy(-1.0, update)
        pressure.x.scatter_forward()
        fenicsx.assemble_vector(self._push, self._by_pressure.form)
        self._system.apply_inverse(self._push, fenicsx.petsc_vector(self._gain))
        self._gain.x.scatter_forward()
        entering, slope = (ranks.integral(self._communicator, form.form) for form in (self._entering, self._gained))
        more = self._given(inlet + 1.0)
        assert more is not None, "the drive is the same"
        scale = max(abs(inlet), float(self._equations.scales.pressure.value))
        change = float(
            np.clip((given - entering) / (slope - (more - given)), -LARGEST_CHANGE * scale, LARGEST_CHANGE * scale)
        )
        update.axpy(-change, fenicsx.petsc_vector(self._gain))
        self.value = inlet + change
        self.changed = abs(change) / scale

    def _given(self, inlet_pressure: float) -> float | None:
        """Mass flow (kg/s) that the drive gives at a gauge pressure (Pa) at the inlet; None where it gives the pressure drop."""
        return self._inflow.mass_flow(inlet_pressure + float(self._equations.fluid.reference_pressure.value))
