"""Locally developed flow over any mesh: one scalar equation of the pressure (`equations.locally_developed`).

Newton's method, each iteration about the profiles at the present pressure gradient of every node. Where the mass flow is
given, the pressure at the inlet follows by elimination: with dp/dP of one more solve with the same matrix the mass flow is
linear in it.
"""

from collections.abc import Callable

import numpy as np
import ufl
from dolfinx import fem

from ..equations.flow import FlowEquations
from ..equations.locally_developed import CarriedByPressure, LocallyDeveloped
from ..errors import SolveError
from ..mesh import fenicsx, ranks
from ..mesh.aliases import Space
from ..mesh.deferred_forms import DeferredForm
from ..mesh.domain import BED, INLET, OUTLET, Domain
from ..mesh.point_values import PointValues
from .developed_profiles import ProfileTable
from .inlet_pressure import InletPressure
from .linear_solution import LinearSolution
from .local_profiles import LocalProfiles
from .multigrid import LEAST_UNKNOWNS, Preconditioner
from .newton import Beside, NewtonSystem
from .newton_iterations import Iterations
from .nodal_means import NodalMeans
from .parts import TRACE_OF_TURBULENCE
from .protocols import FlowCounts, Inflow, Observer, silent
from .state import ArrayOf, Arrays, Saved, SavedNumbers, State

LENGTH_OF_LOSS = 1e-6
"""Part of the bed's length in which as much pressure is lost as at inlet and outlet."""
CONVERGED, MOST_ITERATIONS = 1e-9, 100
"""Relative update of the pressure at which a flow that starts is found."""
FOLLOWED = 0.05
"""Of the flow's tolerance, that the pressure's update may be: what it leaves of the mass balance the heat misses."""
UNRELAXED = 6
"""Iterations after which the profiles are relaxed."""
PATIENT, CREEPING = 80, 1e-6
"""Iterations after which an update of the pressure is small enough: the profile of a node where the fluid nearly stands may
change on and on, and nothing else."""
LINEAR_REDUCTION = 1e-8
"""Of the residual of iterated linear systems."""


class LocallyDevelopedFlow:
    """`equations` are `FlowEquations`; `table()` gives the profiles."""

    streamfunction = growth = inlet = None
    factored_at: None = None

    def __init__(
        self,
        domain: Domain,
        equations: FlowEquations,
        temperature: fem.Function,
        inflow: Inflow,
        table: Callable[[], ProfileTable],
        quadrature_degree: int,
    ) -> None:
        self.domain, self._equations = domain, equations
        self._inflow = inflow
        space = fenicsx.lagrange_space(domain.mesh)
        self._means = NodalMeans(domain, space, equations.coordinates.nodal_weight)
        self._profiles = LocalProfiles(domain, space, self._means, 1 + len(equations.turbulent_unknowns), table)
        self.pressure, self._at_boundary = fem.Function(space), fem.Function(space)
        loss = domain.constant(LENGTH_OF_LOSS * domain.length)
        self.local = LocallyDeveloped(
            equations, self.pressure, temperature, self._profiles.nodal, self._at_boundary, loss
        )
        self._profiles.follow(self.local.logarithm)
        self.state = self.local.state
        kept = {"pressure": self.pressure, "pressure_at_boundary": self._at_boundary}
        self.solution = State(kept | self._profiles.functions)
        self._build(space, quadrature_degree)
        self._is_uniform, self._iteration = False, 0
        self.counts = FlowCounts()
        self.observe: Observer = silent

    def _build(self, space: Space, quadrature_degree: int) -> None:
        domain, test = self.domain, ufl.TestFunction(space)
        dimension = domain.mesh.topology.dim
        cells, facets = domain.cell_measure(quadrature_degree), domain.facet_measure(quadrature_degree)
        nothing = fem.Constant(domain.mesh, 0.0)
        residual = self.local.residual(test, cells(BED), facets((INLET, OUTLET)))
        residual += nothing * self.pressure * test * domain.wall_measure(1)
        inside = fem.locate_dofs_topological(space, dimension, domain.cells(BED))
        self._outside = np.setdiff1d(np.arange(len(self.pressure.x.array)), inside)
        self.system = NewtonSystem(
            "pressure",
            residual,
            self.pressure,
            self._outside,
            linear=LinearSolution(pivoting=False, preconditioner=self._preconditioner(space)),
            beside=Beside(
                self._renew_profiles,
                lambda update: self._inlet.follow_mass_flow(update),
                lambda update: max(update, self._inlet.changed),
            ),
        )
        inlet_nodes = fem.locate_dofs_topological(space, dimension - 1, domain.facets(INLET))
        self._inlet = InletPressure(
            domain, self._inflow, self._at_boundary, inlet_nodes, self.system, self.local, facets(INLET)
        )
        self._energies = [DeferredForm(self._means.form(part)) for part in self.state.turbulence[:1]]

    def _preconditioner(self, space: Space) -> Preconditioner | None:
        mesh = self.domain.mesh
        if space.dofmap.index_map.size_global < LEAST_UNKNOWNS[mesh.topology.dim]:
            return None
        cells = PointValues(mesh)
        permeance = cells.add(self.local.middle_permeance)
        cells.compile()
        trial, test = ufl.TrialFunction(space), ufl.TestFunction(space)
        nodes = self.domain.nodal_measure()
        form = self.local.nearby(trial, test, permeance, nodes(BED), self.domain.nodal_facet_measure()((INLET, OUTLET)))
        form += fem.Constant(mesh, 0.0) * trial * test * self.domain.wall_measure(1)
        return Preconditioner(form, cells.renew, {"bed": np.arange(len(self.pressure.x.array))})

    def carrier(self, equations: FlowEquations) -> CarriedByPressure:
        """The equations with the mass flux of this flow."""
        return CarriedByPressure(**vars(equations), local=self.local)

    def observe_with(self, observe: Observer) -> None:
        """Have `observe(text)` called at every iteration; it may raise."""
        self.observe = observe

    @property
    def unknowns(self) -> int:
        """Number of unknowns solved for."""
        return self.system.active_unknowns

    def is_turbulent(self) -> bool:
        """Whether there is more than negligible turbulence (collective)."""
        if not self._energies:  # without a transported one eddies follow from the flow itself
            return self._equations.model is not None
        energy = fem.Function(self.pressure.function_space)
        self._means.take(self._energies[0].form, energy)
        largest = ranks.extremes(self.domain.communicator, energy.x.array)[1]
        return bool(largest > TRACE_OF_TURBULENCE * float(self._equations.scales.speed.value) ** 2)

    def is_also_laminar(self) -> bool:
        """Whether its profiles have a laminar flow beside the present turbulent one."""
        return self.is_turbulent() and self._profiles.table.is_also_laminar()

    def start(self, time: float = 0.0) -> None:
        """Find the flow, from the pressure of a uniform permeability; raises `SolveError`."""
        drive, scale = self._inflow.drive(), float(self._equations.scales.pressure.value)
        self._inlet.value = drive.value if drive.kind == "pressure_drop" else scale
        places, domain = self.pressure.function_space.tabulate_dof_coordinates(), self.domain
        along = (places[:, 0] - domain.begin) / domain.length
        # of any mesh: what is harmonic has the gradients of the section's changes
        self.pressure.x.array[:] = self._inlet.value * np.clip(1.0 - along, 0.0, 1.0)
        self.pressure.x.array[self._outside] = 0.0
        self._is_uniform = True
        self._renew_profiles()  # before the matrix is made, whose zeros are those of its preconditioner for good
        self._solve(time, CONVERGED)

    def renew(self, time: float, tolerance: float) -> None:
        """Follow a changed temperature or drive until the pressure's update is below `tolerance`; raises `SolveError`."""
        drive = self._inflow.drive()
        if drive.kind == "pressure_drop":
            self._inlet.value = drive.value
        self._solve(time, FOLLOWED * tolerance)

    def _solve(self, time: float, tolerance: float) -> None:
        self.counts.solves += 1
        self._iteration = 0

        def prepare(update: float, last: float) -> None:
            self._is_uniform = False
            self._iteration += 1
            self.system.solve_to(LINEAR_REDUCTION)

        def converged(update: float) -> bool:
            self.counts.newton_iterations += 1
            self.observe("")
            return update < (max(tolerance, CREEPING) if self._iteration > PATIENT else tolerance)

        try:
            is_solved = self.system.solve(Iterations(MOST_ITERATIONS, converged, prepare))
        except SolveError as error:
            cure = (
                "model.flow = 'full', or another drive: the developed profiles at its pressure gradient are not found"
            )
            raise SolveError("locally developed flow (profiles)", time, str(error), cure) from None
        self.counts.largest_undershoot = self._profiles.table.largest_undershoot()
        if not self.counts.note("newton", found=is_solved):
            raise SolveError(
                "locally developed flow (p)",
                time,
                f"last update {self.system.relative_update:.3e}",
                "a finer mesh, model.flow = 'full', or a drive that changes more slowly",
            )

    def _renew_profiles(self) -> None:
        # at a corner of the boundary they may go to and fro
        self._profiles.renew(uniform=self._is_uniform, relaxed=self._iteration > UNRELAXED)

    def extrapolate(self, previous: Arrays, factor: float) -> None:
        """Extrapolate the pressure `factor` times as far ahead as `previous` lies behind."""
        self.pressure.x.array[:] += factor * (self.pressure.x.array - previous["pressure"])

    def save(self) -> Saved:
        """The table's place and the counts."""
        numbers = {"counts": vars(self.counts), "table": self._profiles.table.middle}
        return Saved(numbers)

    def restore(self, numbers: SavedNumbers, array_of: ArrayOf) -> None:
        """Go on from what `save()` gave (collective)."""
        self.counts = FlowCounts(**numbers["counts"])
        self._profiles.table.cover(numbers["table"])

    def fields(self) -> dict[str, fem.Function]:
        """Present velocity, pressure and turbulence (SI) as functions by name, means at the nodes (collective)."""
        dimension, space = self.domain.mesh.geometry.dim, self.pressure.function_space
        velocity = fem.Function(fenicsx.lagrange_space(self.domain.mesh, 1, dimension), name="velocity")
        component = fem.Function(space)
        for axis in range(dimension):
            self._means.take(fenicsx.compiled_form(self._means.form(self.state.velocity[axis])), component)
            velocity.x.array[axis::dimension] = component.x.array
        pressure = fem.Function(space, name="pressure")
        pressure.x.array[:] = self.pressure.x.array
        fields = {"velocity": velocity, "pressure": pressure}
        names = [unknown.name for unknown in self._equations.turbulent_unknowns]
        for name, expression in zip(names, self.state.turbulence, strict=True):
            fields[name] = fem.Function(space, name=name)
            self._means.take(fenicsx.compiled_form(self._means.form(expression)), fields[name])
        return fields
