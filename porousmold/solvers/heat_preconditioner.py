"""What large systems of the temperatures are iterated with: nodal matrices and one multigrid cycle each (`solvers.multigrid`)."""

from dolfinx import fem

from ..equations.energy import EnergyEquations
from ..equations.energy_blocks import Temperatures, energy_blocks
from ..laws.functions import Value
from ..mesh.point_values import PointValues
from .heat_unknowns import HeatUnknowns
from .multigrid import LEAST_UNKNOWNS, Preconditioner


def heat_preconditioner(
    equations: EnergyEquations, unknowns: HeatUnknowns, properties: fem.Function, monotone: Value, inverse_stage: Value
) -> Preconditioner | None:
    """Preconditioner of a stage's linear systems, 1/`inverse_stage` (s) long; None where they are small enough to factorise.

    Coefficients are those of the temperature `properties` (K), with the cells that are `monotone`.
    """
    space = unknowns.space
    mesh = space.mesh
    if space.dofmap.index_map.size_global * space.dofmap.index_map_bs < LEAST_UNKNOWNS[mesh.topology.dim]:
        return None
    cells = PointValues(mesh)
    parts = Temperatures(unknowns.function, unknowns.parts[0], *unknowns.trials, unknowns.tests)
    form = energy_blocks(equations, parts, properties, monotone, inverse_stage, cells.add)
    cells.compile()
    return Preconditioner(form, cells.renew, unknowns.fields)
