r"""Stirring: a bed that is sheared mixes its beads, and they carry their heat with them.

Beads of a sheared bed wander across the flow like molecules, with a self-diffusion coefficient D = c gamma d^2, gamma the shear
rate. What they carry is a conductivity of the beads (Forgber, Radl 2016, eq. 9, as `porousmold shear` measures it),

    lambda_stir = c (1 - phi) rho_s C_s gamma d^2.

c was measured with rough walls, friction 0.5, solid fractions 0.50 to 0.64 and dimensionless shear rates 1e-3 to 1e-1, by the
convective flux over the local gradient and by the self-diffusion of the same beads (table in `docs/moving-beads.md`). What a bead
exchanges with the fluid on its way is in the energy equations. At a wall beads do not move across it: the layer next to it, where
1 - phi vanishes, carries less.
"""

from .functions import Value

COEFFICIENT = 0.043
"""c, mean over solid fractions 0.50 to 0.64 and dimensionless shear rates 1e-3 and 1e-2; it grows from 0.03 at 0.50 to 0.05."""
SOURCE = "porousmold shear; Forgber, Radl 2016, eq. 9"
SOLID_FRACTIONS = (0.50, 0.64)
"""Range of c."""


def stirring_conductivity(
    porosity: Value, volumetric_heat_capacity: Value, mixing_rate: Value, bead_diameter: Value
) -> Value:
    """lambda_stir per total volume, W/m/K: heat capacity rho_s C_s (J/m3/K) of the beads, `mixing_rate` c gamma (1/s)."""
    return (1.0 - porosity) * volumetric_heat_capacity * mixing_rate * bead_diameter**2
