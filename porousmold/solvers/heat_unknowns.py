"""The unknowns of the temperatures over bed and wall."""

from collections.abc import Sequence
from itertools import zip_longest
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from ..arrays import Integers
from ..mesh import fenicsx
from ..mesh.domain import BED, INTERFACE, Domain
from .flow import unknowns_outside


class HeatUnknowns:
    """T (fluid and wall) and T_s (beads) as one `function`, or with one temperature T alone.

    `parts` and `tests` are T and T_s, the same twice with one temperature. `constrained` are the numbers of T_s in the wall,
    where there are no beads, `regions` those of every region that stores heat: the bed's beads, every layer of the wall that
    `stores` any (default: all), and the bed's surface under a wall that `is_thin`; `of_cells` has those of each cell in a row,
    `fields` the numbers of beads and fluid.
    """

    def __init__(
        self,
        domain: Domain,
        two_temperatures: bool,
        initial_temperature: float,
        stores: Sequence[bool] = (),
        *,
        is_thin: bool = False,
    ) -> None:
        element = fenicsx.lagrange_element(domain.mesh, 1)
        self.parts: tuple[Any, Any]
        self.tests: tuple[Any, Any]
        if two_temperatures:
            self.space = fenicsx.mixed_space(domain.mesh, [element, element])
            self.function = fem.Function(self.space)
            self.parts, self.tests = ufl.split(self.function), ufl.TestFunctions(self.space)
            self.constrained = unknowns_outside(domain, self.space, (1,), BED)
            beads = np.setdiff1d(fenicsx.collapse(self.space, 1)[1], self.constrained)
            of_wall = self.space.sub(0)
            self.of_cells = np.hstack([fenicsx.dof_table(self.space.sub(part)) for part in (0, 1)])
        else:
            self.space = fenicsx.lagrange_space(domain.mesh)
            self.function = fem.Function(self.space)
            test = ufl.TestFunction(self.space)
            self.parts, self.tests = (self.function, self.function), (test, test)
            self.constrained, of_wall = np.empty(0, np.int64), self.space
            beads = fem.locate_dofs_topological(self.space, domain.mesh.topology.dim, domain.cells(BED))
            self.of_cells = fenicsx.dof_table(self.space)
        self._two_temperatures = two_temperatures
        dimension = domain.mesh.topology.dim
        storing = [tag for tag, one in zip_longest(domain.wall_tags, stores, fillvalue=True) if one]
        layers = [fem.locate_dofs_topological(of_wall, dimension, domain.cells(tag)) for tag in storing]
        self.regions = [beads, *layers]
        if is_thin:
            self.regions.append(fem.locate_dofs_topological(of_wall, dimension - 1, domain.facets(INTERFACE)))
        self.function.x.array[:] = initial_temperature

    @property
    def fields(self) -> dict[str, Integers]:
        """Local numbers of the unknowns of "beads" and "fluid", or of "bed" with one temperature."""
        if not self._two_temperatures:
            return {"bed": np.arange(len(self.function.x.array))}
        return {name: np.asarray(fenicsx.collapse(self.space, part)[1]) for name, part in (("beads", 1), ("fluid", 0))}

    @property
    def trials(self) -> tuple[Any, tuple[Any, Any]]:
        """A trial function, and its parts for T and T_s."""
        trial = ufl.TrialFunction(self.space)
        if not self._two_temperatures:
            return trial, (trial, trial)
        fluid, beads = ufl.split(trial)
        return trial, (fluid, beads)
