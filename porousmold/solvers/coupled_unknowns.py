"""Unknowns of flow and heat as those of one system."""

import functools
from typing import Any

import numpy as np
from dolfinx import fem

from ..arrays import Floats
from ..mesh import fenicsx
from ..mesh.domain import Domain
from .flow import FullFlow
from .heating import TransientHeat


class CoupledUnknowns:
    """Those of a full flow and of the heat, in one function `coupled`: velocity, pressure, turbulence (`flow_parts` in all), then
    the temperatures. `flow_temperature` follows that of fluid and wall."""

    def __init__(self, domain: Domain, flow: FullFlow, heat: TransientHeat, flow_temperature: fem.Function) -> None:
        self._flow, self._heat, self._flow_temperature = flow, heat, flow_temperature
        self.flow_parts = 2 + len(flow.equations.turbulent_unknowns)
        scalars = self.flow_parts - 1 + (2 if heat.equations.two_temperatures else 1)
        elements = [fenicsx.lagrange_element(domain.mesh, 1, domain.mesh.geometry.dim)]
        elements += [fenicsx.lagrange_element(domain.mesh, 1)] * scalars
        self.space = fenicsx.mixed_space(domain.mesh, elements)
        self.coupled = fem.Function(self.space)
        self._parts = [fenicsx.collapse(self.space, part) for part in range(len(elements))]

    def gather(self) -> None:
        """Take the unknowns of flow and heat."""
        sources = [self._flow.unknown.sub(part) for part in range(self.flow_parts)]
        heat = self._heat.unknown
        sources += [heat.sub(0), heat.sub(1)] if self._heat.equations.two_temperatures else [heat]
        for (space, numbers), source in zip(self._parts, sources, strict=True):
            values = fem.Function(space)
            values.interpolate(source)
            self.coupled.x.array[numbers] = values.x.array
        self.coupled.x.scatter_forward()

    def scatter(self) -> None:
        """Give flow and heat the coupled unknowns."""
        targets: list[Any] = [(self._flow.unknown, self._flow.space, part) for part in range(self.flow_parts)]
        two = self._heat.equations.two_temperatures
        targets += [(self._heat.unknown, self._heat.space, part if two else None) for part in range(2 if two else 1)]
        for index, (function, space, part) in enumerate(targets):
            if part is None:
                function.interpolate(self.coupled.sub(index))
                continue
            subspace, numbers = fenicsx.collapse(space, part)
            values = fem.Function(subspace)
            values.interpolate(self.coupled.sub(index))
            function.x.array[numbers] = values.x.array
        self._flow_temperature.interpolate(self.coupled.sub(self.flow_parts))
        for function in (self._flow.unknown, self._heat.unknown, self._flow_temperature):
            function.x.scatter_forward()

    def of_heat(self, values: Floats) -> Floats:
        """Those of the heat's unknowns among the coupled ones."""
        result = np.zeros(len(self._heat.unknown.x.array))
        for (space, numbers), target in zip(self._parts[self.flow_parts :], self._heat_parts, strict=True):
            part = fem.Function(space)
            part.x.array[:] = values[numbers]
            if target is None:
                own = fem.Function(self._heat.space)
                own.interpolate(part)
                return np.asarray(own.x.array)
            subspace, own_numbers = target
            own = fem.Function(subspace)
            own.interpolate(part)
            result[own_numbers] = own.x.array
        return result

    @functools.cached_property
    def _heat_parts(self) -> list[Any]:
        two = self._heat.equations.two_temperatures
        return [fenicsx.collapse(self._heat.space, part) for part in range(2)] if two else [None]
