"""Locally developed flow over any mesh: one scalar equation of the pressure (`equations.locally_developed`).

Newton's method, each iteration about the profiles at the present pressure gradient of every node. Where the mass flow is
given, the pressure at the inlet follows by elimination: with dp/dP of one more solve with the same matrix the mass flow is
linear in it.
"""

import functools
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from ..equations.flow import FlowEquations
from ..equations.locally_developed import CarriedByPressure, LocallyDeveloped, NodalProfile, NodalProfiles
from ..errors import SolveError
from ..mesh import fenicsx, ranks
from ..mesh.aliases import Space
from ..mesh.domain import BED, INLET, OUTLET, Domain
from .developed_profiles import ProfileTable
from .linear_solution import LinearSolution
from .multigrid import LEAST_UNKNOWNS, Preconditioner
from .newton import Beside, NewtonSystem
from .newton_iterations import Iterations
from .nodal_means import NodalMeans
from .parts import TRACE_OF_TURBULENCE
from .protocols import FlowCounts, Inflow, Observer, silent
from .state import ArrayOf, Arrays, Saved, State

PRESSURE_LOST = 1e-6
"""Part of the reference pressure that the reference flow loses at inlet and outlet."""
CONVERGED, MOST_ITERATIONS = 1e-9, 40
"""Relative update of the pressure at which a flow that starts is found."""
FOLLOWED = 0.05
"""Of the flow's tolerance, that the pressure's update may be: what it leaves of the mass balance the heat misses."""
UNRELAXED, RELAXED = 6, 0.5
"""Iterations after which the profiles follow the pressure gradient of the nodes by that part alone."""
LINEAR_REDUCTION = 1e-8
"""Of the residual of iterated linear systems."""
LARGEST_CHANGE = 0.5
"""Of the inlet's pressure in an iteration, as a part of itself or of the reference pressure."""


class LocallyDevelopedFlow:
    """`equations` are `FlowEquations`; `table()` gives the profiles, `reference_flux` (kg/m2/s) is that of the reference
    pressure."""

    streamfunction = inlet = None
    factored_at: Any = None

    def __init__(
        self,
        domain: Domain,
        equations: FlowEquations,
        temperature: fem.Function,
        inflow: Inflow,
        table: Callable[[], ProfileTable],
        reference_flux: float,
        quadrature_degree: int,
    ) -> None:
        self.domain, self._equations = domain, equations
        self._inflow, self._make_table = inflow, table
        space = fenicsx.lagrange_space(domain.mesh)
        count = 1 + len(equations.turbulent_unknowns)
        self.pressure, self._at_boundary, logarithm = (fem.Function(space) for _ in range(3))
        fields = tuple(NodalProfile(fem.Function(space), fem.Function(space)) for _ in range(count))
        self._profiles = NodalProfiles(logarithm, fields)
        conductance = domain.constant(reference_flux / (PRESSURE_LOST * float(equations.scales.pressure.value)))
        self.local = LocallyDeveloped(
            equations, self.pressure, temperature, self._profiles, self._at_boundary, conductance
        )
        self.state = self.local.state
        parts = {
            f"{part}_{number}": getattr(one, part) for number, one in enumerate(fields) for part in ("value", "slope")
        }
        boundary = {"pressure_at_boundary": self._at_boundary, "logarithm": logarithm}
        self.solution = State({"pressure": self.pressure} | boundary | parts)
        self._distance = np.maximum(fenicsx.nodal_values(domain.wall_distance, space), 0.0)
        self._build(space, quadrature_degree)
        self._is_uniform, self._changed, self._iteration = False, 0.0, 0
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
        self._inlet_nodes = fem.locate_dofs_topological(space, dimension - 1, domain.facets(INLET))
        self.system = NewtonSystem(
            "pressure",
            residual,
            self.pressure,
            self._outside,
            linear=LinearSolution(pivoting=False, preconditioner=self._preconditioner(space)),
            beside=Beside(self._renew_profiles, self._follow_mass_flow, lambda update: max(update, self._changed)),
        )
        weight, ds = self._equations.coordinates.weight, facets(INLET)
        self._entering = fenicsx.DeferredForm(-weight * self.local.outward * ds)
        self._by_pressure = fenicsx.DeferredForm(weight * self.local.conductance * test * ds)
        self._gain, self._push = fem.Function(space), self.system.new_vector()
        self._gained = fenicsx.DeferredForm(weight * self.local.conductance * (1.0 - self._gain) * ds)
        self._means = NodalMeans(domain, space, self._equations.coordinates.nodal_weight)
        self._energies = [fenicsx.DeferredForm(self._means.form(part)) for part in self.state.turbulence[:1]]
        self._logarithm_form = fenicsx.DeferredForm(self._means.form(self.local.logarithm))

    def _preconditioner(self, space: Space) -> Preconditioner | None:
        mesh = self.domain.mesh
        if space.dofmap.index_map.size_global < LEAST_UNKNOWNS[mesh.topology.dim]:
            return None
        cells = fenicsx.PointValues(mesh)
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

    @functools.cached_property
    def _table(self) -> ProfileTable:
        return self._make_table()

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
        return self.is_turbulent() and self._table.is_also_laminar()

    def start(self, time: float = 0.0) -> None:
        """Find the flow, from the pressure of a uniform permeability; raises `SolveError`."""
        drive, scale = self._inflow.drive(), float(self._equations.scales.pressure.value)
        self._set_inlet(drive.value if drive.kind == "pressure_drop" else scale)
        places, domain = self.pressure.function_space.tabulate_dof_coordinates(), self.domain
        along = (places[:, 0] - domain.begin) / domain.length
        # of any mesh: what is harmonic has the gradients of the section's changes
        self.pressure.x.array[:] = self._inlet_pressure * np.clip(1.0 - along, 0.0, 1.0)
        self.pressure.x.array[self._outside] = 0.0
        self._is_uniform = True
        self._renew_profiles()  # before the matrix is made, whose zeros are those of its preconditioner for good
        self._solve(time, CONVERGED)

    def renew(self, time: float, tolerance: float) -> None:
        """Follow a changed temperature or drive until the pressure's update is below `tolerance`; raises `SolveError`."""
        drive = self._inflow.drive()
        if drive.kind == "pressure_drop":
            self._set_inlet(drive.value)
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
            return update < tolerance

        try:
            is_solved = self.system.solve(Iterations(MOST_ITERATIONS, converged, prepare))
        except SolveError as error:
            cure = (
                "model.flow = 'full', or another drive: the developed profiles at its pressure gradient are not found"
            )
            raise SolveError("locally developed flow (profiles)", time, str(error), cure) from None
        self.counts.largest_undershoot = self._table.largest_undershoot()
        if not self.counts.note("newton", found=is_solved):
            raise SolveError(
                "locally developed flow (p)",
                time,
                f"last update {self.system.relative_update:.3e}",
                "a finer mesh, model.flow = 'full', or a drive that changes more slowly",
            )

    def _follow_mass_flow(self, update: Any) -> None:
        """Change a Newton update of the pressure, and the inlet's, so that the mass flow is as given."""
        self._changed = 0.0
        inlet, given = self._inlet_pressure, self._given(self._inlet_pressure)
        if given is None:
            return
        communicator = self.domain.communicator
        fenicsx.petsc_vector(self.pressure).axpy(-1.0, update)
        self.pressure.x.scatter_forward()
        fenicsx.assemble_vector(self._push, self._by_pressure.form)
        self.system.apply_inverse(self._push, fenicsx.petsc_vector(self._gain))
        self._gain.x.scatter_forward()
        entering, slope = (ranks.integral(communicator, form.form) for form in (self._entering, self._gained))
        more = self._given(inlet + 1.0)
        assert more is not None, "the drive is the same"
        scale = max(abs(inlet), float(self._equations.scales.pressure.value))
        change = float(
            np.clip((given - entering) / (slope - (more - given)), -LARGEST_CHANGE * scale, LARGEST_CHANGE * scale)
        )
        update.axpy(-change, fenicsx.petsc_vector(self._gain))
        self._set_inlet(inlet + change)
        self._changed = abs(change) / scale

    def _given(self, inlet_pressure: float) -> float | None:
        """Mass flow (kg/s) that the drive gives at a gauge pressure (Pa) at the inlet; None where it gives the pressure drop."""
        absolute = inlet_pressure + float(self._equations.fluid.reference_pressure.value)
        return self._inflow.mass_flow(absolute)

    @property
    def _inlet_pressure(self) -> float:
        """Gauge pressure (Pa) before the inlet (collective)."""
        here = self._at_boundary.x.array[self._inlet_nodes]
        low, high = ranks.extremes(self.domain.communicator, here)
        return float(low if abs(low) > abs(high) else high)

    def _set_inlet(self, pressure: float) -> None:
        self._at_boundary.x.array[self._inlet_nodes] = pressure
        self._at_boundary.x.scatter_forward()

    def _renew_profiles(self) -> None:
        """Take the profiles about the present pressure gradient (collective); at first that far from walls everywhere, whatever
        the gradient. Raises `SolveError` where they are not found."""
        uniform, logarithm = self._is_uniform, self._profiles.logarithm
        before = logarithm.x.array.copy()
        self._means.take(self._logarithm_form.form, logarithm)
        if self._iteration > UNRELAXED:  # at a corner of the boundary it may go to and fro
            logarithm.x.array[:] = before + RELAXED * (logarithm.x.array - before)
        owned = logarithm.x.array[: len(self._means.volumes)]
        sums = ranks.total(self.domain.communicator, [np.sum(self._means.volumes * owned), np.sum(self._means.volumes)])
        mean = float(sums[0] / sums[1])
        self._table.cover(mean)
        if uniform:
            logarithm.x.array[:] = mean
        distance = np.full_like(self._distance, np.max(self._distance)) if uniform else self._distance
        for number, ((values, slopes), field) in enumerate(
            zip(self._table.at(distance, logarithm.x.array), self._profiles.fields, strict=True)
        ):
            if number == 0:  # m is the scaled speed over G
                values, slopes = values * np.exp(-logarithm.x.array), slopes - 1.0
            field.value.x.array[:] = values
            field.slope.x.array[:] = 0.0 if uniform else slopes

    def extrapolate(self, previous: Arrays, factor: float) -> None:
        """Extrapolate the pressure `factor` times as far ahead as `previous` lies behind."""
        self.pressure.x.array[:] += factor * (self.pressure.x.array - previous["pressure"])

    def save(self) -> Saved:
        """The table's place and the counts."""
        numbers = {"counts": vars(self.counts), "table": self._table.middle}
        return Saved(numbers)

    def restore(self, numbers: Mapping[str, Any], array_of: ArrayOf) -> None:
        """Go on from what `save()` gave (collective)."""
        self.counts = FlowCounts(**numbers["counts"])
        self._table.cover(numbers["table"])

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
