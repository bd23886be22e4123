"""Transport coefficients of a time step, frozen at its start, with monotone cells where temperatures violate bounds."""

import functools
from dataclasses import replace

import numpy as np
import ufl
from dolfinx import fem

from ..arrays import Floats, Integers
from ..equations.energy import EnergyEquations, Transport
from ..mesh import fenicsx, ranks
from ..mesh.deferred_forms import DeferredForm
from ..mesh.domain import INLET, INTERFACE, Domain
from ..mesh.point_values import PointValues
from .protocols import Bounds

OVERSHOOT = 0.07
"""Kelvin out of bounds at which a cell becomes monotone."""
SMALLEST_RANGE = 7.0
"""Range of the bounds (K), below which that counts in proportion: 1 % of it at most."""
MONOTONE_STEPS = 2
"""Steps after which a cell is second order again; if it is out of bounds once more it is marked once more."""
LONGER = 0.25
"""Part of these steps by which their factor grows, 2, 3, 5, 12, 48, ... steps, where a cell has to be marked again before as many
have passed: at a place that is out of bounds for ever, cells would change to and fro, and no state would be steady."""


MOST_STEPS = 1e6
"""For which a cell is monotone."""


class FrozenTransport:
    """A `Transport` at the quadrature points, renewed once a step; what is constant in a cell is that of its middle.

    That leaves the enthalpies as the only nonlinearity within a step; taken at the temperature predicted for its middle,
    the method stays second order. `monotone` marks the cells that are to be so.
    """

    def __init__(
        self, domain: Domain, equations: EnergyEquations, temperature: fem.Function, quadrature_degree: int
    ) -> None:
        self.monotone = fem.Function(fenicsx.cell_constant_space(domain.mesh))
        points, cells = PointValues(domain.mesh, quadrature_degree), PointValues(domain.mesh)
        transport = equations.transport(temperature, self.monotone)
        self.frozen = Transport(
            points.add(transport.mass_flux),
            points.add(transport.conduction),
            points.add(transport.bead_conduction),
            None if transport.exchange is None else points.add(transport.exchange),
            None if transport.touching is None else cells.add(transport.touching),
            transport.streamline.held(cells.add, points.add),
        )
        self._conduction = None
        if not equations.two_temperatures:
            self._conduction = ConductedHeat(domain, equations, temperature, self.frozen)
            self.frozen = replace(self.frozen, heat_conducted=self._conduction.function)
        self._values = points, cells
        for values in self._values:
            values.compile()

    def renew(self) -> None:
        """Take the values of the present flow and temperature."""
        for values in self._values:
            values.renew()
        if self._conduction is not None:
            self._conduction.renew()


class ConductedHeat:
    """`function`: the heat (W/m3) that conduction in the bed brings to each node, div(K grad T) by a lumped mass matrix; 0 at
    the inlet and the wall, where heat crosses the boundary."""

    def __init__(
        self, domain: Domain, equations: EnergyEquations, temperature: fem.Function, transport: Transport
    ) -> None:
        space = temperature.function_space
        test = ufl.TestFunction(space)
        self.function = fem.Function(space)
        self._heat = DeferredForm(equations.heat_conducted(temperature, test, transport))
        volumes = equations.coordinates.nodal_weight * test * equations.nodes_bed
        self._volume_form = DeferredForm(volumes)
        facets = np.concatenate([domain.facets(tag) for tag in (INLET, INTERFACE)])
        dimension = domain.mesh.topology.dim
        self._boundary = fem.locate_dofs_topological(space, dimension - 1, np.sort(facets).astype(np.int32))

    @functools.cached_property
    def _volumes(self) -> Floats:
        vector = fenicsx.petsc_vector(self.function)
        fenicsx.assemble_vector(vector, self._volume_form.form)
        return np.maximum(vector.array.copy(), 1e-300)  # none in the wall

    def renew(self) -> None:
        """Take the values of the present temperature (collective)."""
        volumes, vector = self._volumes, fenicsx.petsc_vector(self.function)
        fenicsx.assemble_vector(vector, self._heat.form)
        vector.array[:] /= volumes
        self.function.x.scatter_forward()
        self.function.x.array[self._boundary] = 0.0


class MonotoneCells:
    """Marks the cells whose temperatures leave their bounds, in `marks` (1 where monotone).

    `steps` counts for how many more steps each stays so, below 0 since when it is not, and `held` is for how many it was marked
    last. `unknowns` are the numbers of every local cell's temperatures, a row each, `bed` those of the bed's cells.
    """

    def __init__(self, marks: fem.Function, unknowns: Integers, bed: Integers) -> None:
        self._marks, self._unknowns = marks, unknowns
        self._in_bed = np.zeros((len(unknowns), 1), bool)
        self._in_bed[bed] = True
        self.steps, self.held = (fem.Function(marks.function_space) for _ in range(2))
        self._cells = fenicsx.dof_table(marks.function_space)[:, 0]
        self._communicator = marks.function_space.mesh.comm

    @property
    def are_there(self) -> bool:
        """Whether any is marked, on any rank (collective)."""
        return ranks.anywhere(self._communicator, bool(self._marks.x.array.any()))

    def mark(self, values: Floats, bounds: Bounds) -> tuple[float, bool]:
        """Make the cells monotone that have one of the `values` (K, NaN where none) out of bounds: by how much (K) they are at
        most, 0 where none is, and whether there are new ones, on any rank."""
        of_cells, marks = values[self._unknowns], self._marks.x.array
        low, high, *of_wall = bounds
        beyond = OVERSHOOT * min(1.0, max(high - low, 1e-6) / SMALLEST_RANGE)
        lows, highs = (np.where(self._in_bed, *pair) for pair in zip((low, high), of_wall or (low, high), strict=True))
        excess = np.nan_to_num(np.maximum(lows - of_cells, of_cells - highs), nan=-np.inf).max(axis=1, initial=-np.inf)
        out = excess > beyond
        new = out & (marks[self._cells] == 0.0)
        marks[self._cells[new]] = 1.0
        held = self.held.x.array
        before = held[self._cells[new]]
        held[self._cells[new]] = np.maximum(np.minimum(before * (1.0 + LONGER * before), MOST_STEPS), MONOTONE_STEPS)
        self.steps.x.array[self._cells[out]] = np.maximum(held[self._cells[out]], MONOTONE_STEPS)
        most, any_new = ranks.maximum(self._communicator, [np.max(excess[out], initial=0.0), new.any()])
        return float(most), bool(any_new)

    def mark_steep(self, values: Floats, fields: int, steepest: float) -> None:
        """Make the bed's cells monotone for a step, within which one of the `fields` in `values` (K) changes by more than
        `steepest` (K)."""
        of_fields = values[self._unknowns].reshape(len(self._unknowns), fields, -1)
        spans = of_fields.max(axis=2) - of_fields.min(axis=2)
        steep = self._cells[(spans > steepest).any(axis=1) & self._in_bed[:, 0]]
        self.steps.x.array[steep] = np.maximum(self.steps.x.array[steep], 1.0)
        self._marks.x.array[steep] = 1.0

    def release(self) -> None:
        """Give the cells second order again that have been monotone for a while: by then the front has spread."""
        left, held = self.steps.x.array, self.held.x.array
        left[:] = np.maximum(left - 1.0, -held)
        held[left <= -held] = 0.0
        self._marks.x.array[:] = left > 0.0
