"""How far the flow through a mesh of one's own is off by its cells, and what is to be said of it."""

from ..solvers.gradient_error import gradient_error
from .time_integration import Simulation

FACTOR = 1.5
"""Error of the mass flow over `gradient_error`: 0.7 to 2.2 in tools fed through ports in three dimensions, 0.2 to 1.2 in a plane
bed fed through a third of its end, where errors of either sign cancel (docs/meshes.md)."""
LARGEST_ERROR = 0.03
"""Of the mass flow, that is left without a word."""
AT_REST = 1e-6
"""Of the largest mass flow, below which a flow has no error to be told."""


def mass_flow_error(simulation: Simulation) -> float | None:
    """Estimated relative error of the mass flow; None of the built-in beds, which are straight, and of one at rest at the end
    (collective)."""
    problem, mass_flows = simulation.problem, [abs(flow) for flow in simulation.recorder.history["mass_flow"]]
    if simulation.specs.mesh.own.mesh is None or not mass_flows or mass_flows[-1] <= AT_REST * max(mass_flows):
        return None
    fields = problem.flow.fields()
    coordinates = problem.medium.equations.coordinates
    return FACTOR * gradient_error(problem.domain, coordinates, fields["pressure"], fields["velocity"])


def of_coarse_cells(simulation: Simulation, error: float | None) -> list[str]:
    """That the cells are too coarse for the flow, and what is off with it."""
    if error is None or error < LARGEST_ERROR:
        return []
    flow = simulation.specs.flow
    given = flow.drive == "pressure_drop" and not flow.by_blower
    what = "mass flow, and with it times, are" if given else "pressure drop, and what follows from it, are"
    return [
        f"cells are too coarse where the flow gathers or turns (the edges of ports): the {what} off by up to about {error:.0%}; "
        "a finer mesh there lessens it"
    ]
