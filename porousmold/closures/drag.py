r"""Resistance of the bead packing to the flow.

Per total volume, for the intrinsic velocity u, the beads hold the fluid back by (thesis eq. 8.4, and 6.4 with
6.6-6.7)

    f = A (1 - phi)^2 mu u / (phi d^2) + B (1 - phi) rho |u| u / d,

which is the Ergun form -dp/dz = A (1 - phi)^2 mu U/(phi^3 d^2) + B (1 - phi) rho U^2/(phi^3 d) with the superficial
velocity U = phi u, multiplied by phi.

| law        | A   | B    | source |
|------------|-----|------|--------|
| macdonald  | 180 | 1.8  | Macdonald, El-Sayed, Mow, Dullien, Ind. Eng. Chem. Fundam. 18 (1979) 199-208 (smooth beads) |
| ergun      | 150 | 1.75 | Ergun, Chem. Eng. Prog. 48 (1952) 89-94 |
"""

from dataclasses import dataclass

from .functions import sqrt


@dataclass(frozen=True)
class DragLaw:
    """The two constants of an Ergun-type law and where they come from."""

    viscous: float
    inertial: float
    source: str

    def coefficient(self, porosity, bead_diameter, density, viscosity, speed):
        """Drag force per total volume and per intrinsic velocity, f/u, in kg m-3 s-1.

        Arguments (floats, arrays or UFL): porosity in (0, 1], bead_diameter in m, density in kg m-3, viscosity in
        Pa s, speed = |u| intrinsic in m/s. Valid for packed beds of spheres; zero where the porosity is 1.
        """
        solids = 1.0 - porosity
        return (
            self.viscous * solids**2 * viscosity / (porosity * bead_diameter**2)
            + self.inertial * solids * density * speed / bead_diameter
        )

    def permeability(self, porosity, bead_diameter):
        """Darcy permeability K = d^2 phi^3 / (A (1 - phi)^2) in m2 (eq. 6.6)."""
        return bead_diameter**2 * porosity**3 / (self.viscous * (1.0 - porosity) ** 2)

    def speed(self, force, porosity, bead_diameter, density, viscosity):
        """Intrinsic speed (m/s) at which the drag per total volume is `force` >= 0 (N/m3): the root of a quadratic.

        Arguments as for `coefficient`, porosity < 1.
        """
        viscous = self.coefficient(porosity, bead_diameter, density, viscosity, 0.0)
        inertial = self.coefficient(porosity, bead_diameter, density, viscosity, 1.0) - viscous
        return 2.0 * force / (viscous + sqrt(viscous**2 + 4.0 * inertial * force))


DRAG_LAWS = {
    "macdonald": DragLaw(180.0, 1.8, "Macdonald et al., Ind. Eng. Chem. Fundam. 18 (1979) 199-208"),
    "ergun": DragLaw(150.0, 1.75, "Ergun, Chem. Eng. Prog. 48 (1952) 89-94"),
}
