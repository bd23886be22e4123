"""Plug flow: a uniform superficial mass flux, with the pressure drop of the bulk porosity."""

from collections.abc import Callable

import numpy as np
import ufl
from dolfinx import fem
from scipy.optimize import brentq

from ..arrays import Floats
from ..equations.flow import FlowEquations, FlowState
from ..equations.openings import Opening
from ..errors import SolveError
from ..laws.functions import Value
from ..laws.materials import Fluid
from ..mesh import fenicsx
from ..mesh.domain import Domain
from .protocols import Drive, FlowCounts, Observer
from .state import ArrayOf, Arrays, Saved, SavedNumbers, State
from .stations import Columns, MassFlowAlong, nearest

LARGEST_MASS_FLUX = 1e9
"""kg/m2/s beyond which none is sought."""
CONVERGED_DENSITY, MOST_DENSITIES = 1e-12, 60
"""Part of the outlet's pressure, or of the largest, by which a further density would change the pressure; two reach it of an
ideal gas."""


def shares_of_section(across: Floats, *, axisymmetric: bool) -> Floats:
    """Parts of a section that the nodes (m) across it stand for, of a function that is linear between them; 1 in all."""
    inner, outer = across[:-1], across[1:]
    of_inner, of_outer = (2.0 * inner + outer, inner + 2.0 * outer) if axisymmetric else (3.0, 3.0)
    heights = np.diff(across)
    shares = np.append(heights * of_inner, 0.0) + np.append(0.0, heights * of_outer)
    return shares / shares.sum()


class PlugFlow:
    """Uniform superficial mass flux, whose pressure drop is that of the bulk's porosity. `drive` as for `DevelopedFlow`.

    `resistance(mass_flux, density, viscosity)` is dp/dx (Pa/m) of the bulk at a superficial mass flux (kg/m2/s).
    """

    inlet: Opening | None = None
    unknowns = 0

    def __init__(
        self,
        domain: Domain,
        equations: FlowEquations,
        temperature: fem.Function,
        drive: Callable[[], Drive],
        area: float,
        fluid: Fluid,
        resistance: Callable[[Value, Value, Value], Value],
    ) -> None:
        self.domain, self._temperature = domain, temperature
        self._drive, self._area, self._fluid, self._resistance = drive, area, fluid, resistance
        self._reference_pressure = float(equations.fluid.reference_pressure.value)
        scalars = fenicsx.lagrange_space(domain.mesh)
        self.pressure, self.streamfunction, self._mass_flux = (fem.Function(scalars) for _ in range(3))
        fields = {"pressure": self.pressure, "streamfunction": self.streamfunction, "mass_flux": self._mass_flux}
        self.columns = Columns(domain)
        self._mass_flow = MassFlowAlong(self.columns, equations)
        self.growth = self._mass_flow.growth
        self.solution = State(fields if self.growth is None else fields | {"growth": self.growth})
        density = equations.fluid.density(self.pressure, temperature)
        velocity = ufl.as_vector([self._mass_flux / (equations.bed.porosity * density), 0.0])
        self.state = FlowState(velocity, self.pressure)
        nodes = scalars.tabulate_dof_coordinates()
        self._column, owned = self.columns.of(nodes), scalars.dofmap.index_map.size_local
        low, high = self.columns.across[[0, -1]]
        across = np.clip(nodes[:, 1], low, high)
        self._section = np.pi * across**2 if domain.axisymmetric else across
        self._in_bed = np.flatnonzero(np.abs(nodes[:owned, 1] - across[:owned]) <= 1e-9 * (high - low))
        shares = shares_of_section(self.columns.across, axisymmetric=domain.axisymmetric)
        self._share = shares[nearest(self.columns.across, nodes[self._in_bed, 1])]
        self.factored_at = None
        self.counts = FlowCounts()

    def start(self, time: float = 0.0) -> None:
        """The mass flux that belongs to the pressure drop, or the pressure that belongs to the mass flux."""
        columns = self._column[self._in_bed]
        temperature = self.columns.total(columns, self._share * self._temperature.x.array[self._in_bed])
        drive = self._drive()
        is_given = drive.kind == "mass_flow"
        displaced = self._mass_flow.displaced()
        more = displaced / self._area
        mass_flux = drive.value / self._area if is_given else self._flux_of(drive, more, temperature, time)
        self._mass_flow.carry(mass_flux * self._area, displaced)
        pressures = self._pressures(mass_flux + more, temperature, time)
        self._mass_flux.x.array[:] = (mass_flux + more)[self._column]
        self.pressure.x.array[:] = pressures[self._column]
        self.streamfunction.x.array[:] = mass_flux * self._section
        self.counts.solves += 1

    def _pressures(self, mass_flux: Floats, temperature: Floats, time: float) -> Floats:
        """Gauge pressures (Pa) at the stations, of given mass fluxes (kg/m2/s) and temperatures (K). Raises `SolveError`."""
        gauge, outlet = np.zeros(len(temperature)), self._reference_pressure
        for _ in range(MOST_DENSITIES):
            density = self._fluid.density(gauge + outlet, temperature) + 0.0 * temperature
            gradient = -self._resistance(mass_flux, density, self._fluid.viscosity(temperature))
            before = gauge
            if self._fluid.density.compressible:  # p dp/dx of a gas hardly depends on p
                squares = outlet**2 + 2.0 * self.columns.pressure((before + outlet) * gradient)
                gauge = np.sqrt(np.maximum(squares, 0.0)) - outlet
            else:
                gauge = self.columns.pressure(gradient)
            if np.max(np.abs(gauge - before)) < CONVERGED_DENSITY * max(outlet, np.max(np.abs(gauge))):
                return gauge
        raise SolveError("plug flow", time, "its pressure and density do not converge", "less flow")

    def _flux_of(self, drive: Drive, more: Floats, temperature: Floats, time: float) -> float:
        """Mass flux (kg/m2/s) that a pressure drop (Pa) drives, or that enters at a velocity (m/s) as dense as at the inlet;
        `more` than it passes each station."""

        def beyond(flux: float) -> float:
            inlet = float(self._pressures(flux + more, temperature, time)[0])
            if drive.kind == "pressure_drop":
                return inlet - drive.value
            return flux - float(drive.value * self._fluid.density(inlet + self._reference_pressure, drive.temperature))

        if beyond(0.0) > 0.0:
            cure = (
                "a larger operation.pressure_drop, which must overcome operation.gravity and beads that move against it"
            )
            raise SolveError("plug flow", time, "it runs backwards", cure)
        largest = 1.0
        while beyond(largest) < 0.0:
            largest *= 4.0
            if largest > LARGEST_MASS_FLUX:
                raise SolveError("plug flow", time, "no mass flow is large enough", f"a smaller operation.{drive.kind}")
        return float(brentq(beyond, 0.0, largest, rtol=1e-12))

    def renew(self, time: float, tolerance: float) -> None:
        """Follow a changed temperature."""
        self.start(time)

    def extrapolate(self, previous: Arrays, factor: float) -> None:
        """Nothing is iterated."""

    def observe_with(self, observe: Observer) -> None:
        """Nothing is iterated."""

    def is_turbulent(self) -> bool:
        """It is not."""
        return False

    def is_also_laminar(self) -> bool:
        """There is no other flow."""
        return False

    def save(self) -> Saved:
        """The counts."""
        return Saved({"counts": vars(self.counts)})

    def restore(self, numbers: SavedNumbers, array_of: ArrayOf) -> None:
        """Go on from what `save()` gave."""
        self.counts = FlowCounts(**numbers["counts"])

    def fields(self) -> dict[str, fem.Function]:
        """Present velocity and pressure (SI) as functions by name (collective)."""
        vectors = fem.Function(fenicsx.lagrange_space(self.domain.mesh, 1, 2), name="velocity")
        vectors.interpolate(fenicsx.compiled_expression(self.state.velocity, vectors.function_space))
        pressure = fem.Function(self.pressure.function_space, name="pressure")
        pressure.x.array[:] = self.pressure.x.array
        return {"velocity": vectors, "pressure": pressure}
