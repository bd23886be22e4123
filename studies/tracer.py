"""A tracer in the fluid of a bed: when it comes through, beside the bed's residence time.

It is also the example of a second transported quantity: a form of what is stored and of what leaves, and `solvers.sdirk` to
integrate it. Run: python -m studies.tracer [SCENE] (seconds; the aluminium mold where no scene is named).
"""

import argparse
from pathlib import Path

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from porousmold import Scene
from porousmold.equations.streamline import Carried, Streamline
from porousmold.mesh import fenicsx, ranks
from porousmold.mesh.deferred_forms import DeferredForm
from porousmold.mesh.domain import BED
from porousmold.simulation.specs import specs_of
from porousmold.simulation.time_integration import Simulation
from porousmold.solvers.newton import NewtonSystem
from porousmold.solvers.sdirk import BACKWARD_EULER, STAGES, Sdirk
from porousmold.solvers.stages import StageSolver

HERE = Path(__file__).parent
DIFFUSIVITY = 2e-5
"""Of the tracer in the fluid, m2/s; mixing by the beads, 0.5 u d along the flow, comes on top."""
STEPS, DURATION = 800, 5.0
"""Of the integration, and its length in residence times."""
ERROR = 1e-10


class Tracer:
    """The mass fraction c of a tracer in the fluid of a problem whose flow is found, 1 in what enters from time 0 on:

    phi rho dc/dt + phi rho u.grad c = div(D grad c),    phi rho u.n (c - 1) in at the inlet.
    """

    def __init__(self, problem):
        energy, domain = problem.energy_equations, problem.domain
        space = fenicsx.lagrange_space(domain.mesh)
        self.fraction, test = fem.Function(space), ufl.TestFunction(space)
        flux, weight = energy.flow.mass_flux(energy.flow_state, energy.flow_temperature), energy.coordinates.weight
        density, porosity, diameter = energy.transfer.density, energy.bed.porosity, energy.bed.bead_diameter
        mixing = porosity * density * DIFFUSIVITY + 0.5 * diameter * ufl.sqrt(ufl.dot(flux, flux) + 1e-30)
        nothing = fem.Constant(domain.mesh, 0.0)
        cells = Streamline.of(
            energy.coordinates, Carried(flux, mixing, None), energy.entrance, nothing, energy.straight
        ).without_monotone_cells()
        held = porosity * density
        stored = weight * cells.stored_downstream(lambda fraction: held * fraction, self.fraction, test) * energy.dx_bed
        leaving = cells.carried(flux, self.fraction, test) + cells.conducted(mixing, self.fraction, test)
        leaving = weight * leaving * energy.dx_bed
        leaving -= weight * energy.entering_mass_flux * (1.0 - self.fraction) * test * energy.inlet
        inverse_stage = fem.Constant(domain.mesh, 1.0)
        inside = fem.locate_dofs_topological(space, domain.mesh.topology.dim, domain.cells(BED))
        outside = np.setdiff1d(np.arange(len(self.fraction.x.array)), inside)
        residual = inverse_stage * stored + leaving + nothing * self.fraction * test * domain.wall_measure(1)
        system = NewtonSystem("tracer", residual, self.fraction, outside, keep_jacobian=True)
        stored = DeferredForm(stored)
        solver = StageSolver(system, tuple, ERROR)
        self._steps = Sdirk(
            system,
            lambda vector: fenicsx.assemble_vector(vector, stored.form),
            inverse_stage,
            solver,
            lambda time: None,
        )
        self._out = DeferredForm(weight * energy.outward_mass_flux * self.fraction * energy.outlet)
        self._communicator = domain.communicator

    def leaving(self) -> float:
        """Mass flow of tracer out of the bed, kg/s (collective)."""
        return ranks.integral(self._communicator, self._out.form)

    def step(self, time, step, *, first=False):
        """Integrate; gives what is stored more (kg), and what has left (kg)."""
        left = []
        gained = self._steps.take(
            time, step, BACKWARD_EULER if first else STAGES, lambda weight: left.append(weight * self.leaving())
        )
        return gained, sum(left)


def breakthrough(scene):
    """Times over the residence time, mean mass fractions at the outlet then, and: the mean time that the fluid took over the
    residence time; the tracer unaccounted for, as a part of what the bed holds."""
    simulation = Simulation(specs_of(scene), MPI.COMM_WORLD)
    problem = simulation.problem
    problem.find_flow(problem.flow.start, 0.0)
    energy, mass_flow = problem.energy_equations, problem.balances.mass_flow
    held = fenicsx.compiled_form(
        energy.coordinates.weight * energy.bed.porosity * energy.transfer.density * energy.dx_bed
    )
    residence = ranks.integral(problem.communicator, held) / mass_flow
    tracer, step = Tracer(problem), DURATION * residence / STEPS
    times, out, stored, left = [0.0], [0.0], 0.0, 0.0
    for number in range(STEPS):
        gained, gone = tracer.step(number * step, step, first=number == 0)
        stored, left = stored + gained, left + gone
        times.append((number + 1) * step)
        out.append(tracer.leaving() / mass_flow)
    entered = mass_flow * times[-1]
    simulation.free()
    mean = (entered - left) / (mass_flow * residence)
    return np.array(times) / residence, np.array(out), mean, (entered - left - stored) / (mass_flow * residence)


def main():
    """Print when the tracer comes through."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", nargs="?", type=Path, default=HERE / "mold" / "aluminium.toml")
    times, out, mean, missing = breakthrough(Scene.load(parser.parse_args().scene))
    if MPI.COMM_WORLD.rank == 0:
        for part in (0.05, 0.5, 0.95):
            print(f"{part:.0%} at the outlet after {np.interp(part, out, times):.3f} residence times")
        print(f"mean time of the fluid in the bed: {mean:.6f} residence times; tracer unaccounted for: {missing:.1e}")


if __name__ == "__main__":
    main()
