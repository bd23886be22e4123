"""Initial guesses of a full flow, from cheaper flow models over the same bed."""

import contextlib
from collections.abc import Callable, Iterator

import numpy as np
from dolfinx import fem

from ..arrays import Floats
from ..errors import SolveError
from ..mesh import fenicsx
from ..mesh.domain import Domain
from ..mesh.point_values import nodal_values
from ..mesh.probe import PointProbe
from ..solvers.developed import DevelopedFlow
from ..solvers.equilibrium import local_equilibrium
from ..solvers.flow import FullFlow
from ..solvers.locally_developed import LocallyDevelopedFlow
from ..solvers.protocols import Observer, silent
from .problem import Medium
from .specs import Specs

Fields = dict[str, fem.Function]

NEAR = 0.02
"""Update at which the developed flow is near enough: less than what is between it and the full one."""


LARGE = 10_000
"""Unknowns from which the locally developed flow (a second) takes less than iterations from a guess that is far."""


class InitialGuesses:
    """Gives a `FullFlow` its initial guesses: the developed profiles where the bed is straight, in three dimensions the flow over
    two of them at the same distance from the wall; in other meshes the local equilibrium of drag and beads, which takes no
    time, and the locally developed flow, which is near.

    `developed` is the developed flow over the same bed, None where there is none; `in_the_plane(specs)` gives the domain and the
    fields of the scene's flow in two dimensions; `anywhere()` makes the locally developed flow.
    """

    def __init__(
        self,
        specs: Specs,
        medium: Medium,
        developed: DevelopedFlow | None,
        in_the_plane: Callable[[Specs], tuple[Domain, Fields]],
        anywhere: Callable[[], LocallyDevelopedFlow],
        observe: Observer = silent,
    ) -> None:
        self._specs, self._medium, self.observe = specs, medium, observe
        self._in_the_plane, self._anywhere = in_the_plane, anywhere
        self._developed = developed

    def __call__(self, flow: FullFlow) -> Iterator[bool]:
        """Give the flow one guess after another; tells of each whether it is so near that Newton's method should be tried from
        it. A straight bed whose developed flow is not found has the uniform one."""
        if self._medium.domain.straight:
            found = False
            with contextlib.suppress(SolveError):
                flow.guess(self._of_straight_bed())
                found = True
            yield found or self._specs.laws.turbulence is None
            return
        guesses = [(self._local_equilibrium, self._specs.laws.turbulence is None), (self._locally_developed, True)]
        for make, is_near in guesses if flow.unknowns < LARGE else reversed(guesses):
            try:
                fields = make()
            except SolveError:
                continue
            flow.guess(fields)
            yield is_near

    def _of_straight_bed(self) -> Fields:
        if self._developed is None:
            return self._spread(*self._in_the_plane(self._specs))
        self._developed.observe_with(self.observe)
        self._developed.start(near=NEAR)
        return self._developed.fields()

    def _locally_developed(self) -> Fields:
        flow = self._anywhere()
        flow.observe_with(self.observe)
        flow.start()
        return flow.fields()

    def _spread(self, plane: Domain, fields: Fields) -> Fields:
        """Fields of a plane bed on this three-dimensional mesh, by the distance along and to the wall."""
        mesh, space = self._medium.domain.mesh, self._medium.flow_temperature.function_space
        nodes = space.tabulate_dof_coordinates()
        distance = np.maximum(nodal_values(self._medium.domain.wall_distance, space), 0.0)
        half_height = self._medium.domain.stations(0.0)["bed_side"][1]
        probe = PointProbe(plane, np.column_stack([nodes[:, 0], half_height - distance]))
        spread = {}
        for name, values in ((name, probe(function)) for name, function in fields.items()):
            components = mesh.geometry.dim if name == "velocity" else 1
            spread[name] = fem.Function(fenicsx.lagrange_space(mesh, 1, components))
            spread[name].x.array[::components] = values[:, 0]
        return spread

    def _local_equilibrium(self) -> Fields:
        """Fields of the local equilibrium of drag and beads along x[0], for a mesh whose stations are not known."""
        medium, space = self._medium, self._medium.flow_temperature.function_space
        length, estimates = medium.domain.length, medium.estimates
        along = (space.tabulate_dof_coordinates()[:, 0] - medium.domain.begin) / length
        drive = medium.boundary.present_drive()
        pressure_drop = drive.value if drive.kind == "pressure_drop" else estimates.pressure_gradient * length
        pressure = pressure_drop * np.clip(1.0 - along, 0.0, 1.0)
        gradient = max(pressure_drop / length, 1e-6 * estimates.pressure_gradient)
        temperature = medium.flow_temperature.x.array
        arrays = local_equilibrium(medium.equations, self._specs.laws.fluid, space, gradient, temperature, pressure)

        def function_of(values: Floats) -> fem.Function:
            function = fem.Function(space)
            function.x.array[:] = values
            return function

        speed, *turbulence = map(function_of, arrays)
        velocity = fem.Function(fenicsx.lagrange_space(medium.domain.mesh, 1, medium.domain.mesh.geometry.dim))
        velocity.sub(0).interpolate(speed)
        names = [unknown.name for unknown in medium.equations.turbulent_unknowns]
        return {"velocity": velocity, "pressure": function_of(pressure)} | dict(zip(names, turbulence, strict=True))
