"""Initial guess of a full flow, from a cheaper flow model over the same bed."""

import contextlib
from collections.abc import Callable

import numpy as np
from dolfinx import fem

from ..arrays import Floats
from ..errors import SolveError
from ..mesh import fenicsx
from ..mesh.domain import Domain
from ..mesh.probe import PointProbe
from ..solvers.developed import DevelopedFlow
from ..solvers.equilibrium import local_equilibrium
from ..solvers.flow import FullFlow
from ..solvers.protocols import Observer, silent
from .problem import Medium
from .specs import Specs

Fields = dict[str, fem.Function]

NEAR = 0.02
"""Update at which the developed flow is near enough: less than what is between it and the full one."""


class InitialGuess:
    """Gives a `FullFlow` its initial guess: the developed profiles where the bed is straight, in three dimensions the flow over
    two of them at the same distance from the wall, else the local equilibrium of drag and beads.

    `developed` is the developed flow over the same bed, None where there is none; `in_the_plane(specs)` gives the domain and the
    fields of the scene's flow in two dimensions.
    """

    def __init__(
        self,
        specs: Specs,
        medium: Medium,
        developed: DevelopedFlow | None,
        in_the_plane: Callable[[Specs], tuple[Domain, Fields]],
        observe: Observer = silent,
    ) -> None:
        self._specs, self._medium, self.observe = specs, medium, observe
        self._in_the_plane = in_the_plane
        self.developed = developed

    def __call__(self, flow: FullFlow) -> bool:
        """Give the flow its guess; tells whether it is so near that Newton's method should be tried from it."""
        domain = self._medium.domain
        with contextlib.suppress(SolveError):  # then the uniform one has to do
            if self.developed is not None:
                self.developed.observe_with(self.observe)
                self.developed.start(near=NEAR)
                flow.guess(self.developed.fields())
                return True
            if domain.straight:
                flow.guess(self._spread(*self._in_the_plane(self._specs)))
                return True
        if not domain.straight:
            flow.guess(self._local_equilibrium())
        return self._specs.laws.turbulence is None

    def _spread(self, plane: Domain, fields: Fields) -> Fields:
        """Fields of a plane bed on this three-dimensional mesh, by the distance along and to the wall."""
        mesh, space = self._medium.domain.mesh, self._medium.flow_temperature.function_space
        nodes = space.tabulate_dof_coordinates()
        distance = np.maximum(fenicsx.nodal_values(self._medium.domain.wall_distance, space), 0.0)
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
        along = space.tabulate_dof_coordinates()[:, 0] / length
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
