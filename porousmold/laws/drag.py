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

With Re_m = rho phi |u| d/(mu (1 - phi)) the Ergun form is A/Re_m + B. Laws fitted to spheres alone let the inertial part fall:

| law                 | F(Re_m)                      | Re_m        | source |
|---------------------|------------------------------|-------------|--------|
| carman              | 180/Re_m + 2.871/Re_m^0.1    | 0.1 to 6e4  | Carman, Trans. Inst. Chem. Eng. 15 (1937) 150-166 |
| kta                 | 160/Re_m + 3/Re_m^0.1        | 1 to 1e5    | KTA 3102.3 (1981), +-15 % at 95 % confidence |
| erdim               | 160/Re_m + 2.81/Re_m^0.096   | 2 to 3582   | Erdim, Akgiray, Demir, Powder Technol. 283 (2015) 488-504 |
| eisfeld-schnitzlein | 154 A_w^2/Re_m + A_w/B_w     | 0.01 to 1.8e4 | Eisfeld, Schnitzlein, Chem. Eng. Sci. 56 (2001) 4321-4329 |

A_w = 1 + 2/(3 N (1 - phi)) and B_w = (1.15/N^2 + 0.87)^2 bring in the wall of a bed that is N bead diameters wide (a gap H counts
as N = 2 H/d). They belong to a mean over the section: beside a porosity that varies towards the wall they count it twice, so that
this law goes with `bed.porosity_model = "constant"` or plug flow.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .functions import Value, is_symbolic, maximum, scaled, sqrt
from .registry import Registry

LEAST_SPEED = 1e-300
MOST_ITERATIONS, SYMBOLIC_ITERATIONS = 200, 3
"""Least speed (m/s) and iterations of the search for the speed that belongs to a force; a law of Ergun's form needs two."""


@dataclass(frozen=True)
class DragLaw:
    """A law of resistance and its source: `formula` has the arguments of `coefficient`, and N where it has terms for the wall."""

    formula: Callable[..., Value]
    source: str
    width_ratio: Value | None = None
    """N of a law with terms for the wall; None for the others."""
    factor: Value = 1.0
    """For the scatter of its measurements."""

    def coefficient(
        self, porosity: Value, bead_diameter: Value, density: Value, viscosity: Value, speed: Value
    ) -> Value:
        """Drag force per total volume and per intrinsic velocity, f/u, in kg m-3 s-1.

        Arguments (floats, arrays or UFL): porosity in (0, 1], bead_diameter in m, density in kg m-3, viscosity in
        Pa s, speed = |u| intrinsic in m/s. Valid for packed beds of spheres; zero where the porosity is 1.
        """
        arguments = (porosity, bead_diameter, density, viscosity, speed)
        found = self.formula(*arguments) if self.width_ratio is None else self.formula(*arguments, self.width_ratio)
        return scaled(found, self.factor)

    def for_width(self, width_ratio: float) -> "DragLaw":
        """The law in a bed that is so many bead diameters wide."""
        return self if self.width_ratio is None else replace(self, width_ratio=width_ratio)

    def permeability(self, porosity: Value, bead_diameter: Value) -> Value:
        """Darcy permeability K = phi^2 mu/(f/u) at rest, in m2 (eq. 6.6)."""
        return porosity**2 / self.coefficient(porosity, bead_diameter, 0.0, 1.0, 0.0)

    def speed(self, force: Value, porosity: Value, bead_diameter: Value, density: Value, viscosity: Value) -> Value:
        """Intrinsic speed (m/s) at which the drag per total volume is `force` >= 0 (N/m3).

        Arguments as for `coefficient`, porosity < 1. Of Ergun's form, for which f/u is linear in u, through the law at rest
        and at the last speed: iterated until that stands still, in UFL `SYMBOLIC_ITERATIONS` times, which is exact for Ergun's
        form and within 0.5 % for one that falls as Re^-0.1.
        """
        at_rest = self.coefficient(porosity, bead_diameter, density, viscosity, 0.0)
        speed = maximum(force / at_rest, LEAST_SPEED)
        symbolic = is_symbolic(speed)
        for _ in range(SYMBOLIC_ITERATIONS if symbolic else MOST_ITERATIONS):
            slope = (self.coefficient(porosity, bead_diameter, density, viscosity, speed) - at_rest) / speed
            following = 2.0 * force / (at_rest + sqrt(at_rest**2 + 4.0 * slope * force))
            last, speed = speed, maximum(following, LEAST_SPEED)
            if not symbolic and np.max(np.abs(speed - last)) <= 1e-12 * np.max(np.abs(speed)):
                break
        return speed


DRAG_LAWS: Registry[DragLaw] = Registry("drag")


def ergun_form(viscous: float, inertial: float, source: str) -> DragLaw:
    """The law of Ergun's form with the constants A = `viscous` and B = `inertial`."""

    def coefficient(porosity: Value, bead_diameter: Value, density: Value, viscosity: Value, speed: Value) -> Value:
        solids = 1.0 - porosity
        return (
            viscous * solids**2 * viscosity / (porosity * bead_diameter**2)
            + inertial * solids * density * speed / bead_diameter
        )

    return DragLaw(coefficient, source)


DRAG_LAWS.register("macdonald", ergun_form(180.0, 1.8, "Macdonald et al., Ind. Eng. Chem. Fundam. 18 (1979) 199-208"))
DRAG_LAWS.register("ergun", ergun_form(150.0, 1.75, "Ergun, Chem. Eng. Prog. 48 (1952) 89-94"))


LEAST_REYNOLDS_NUMBER = 1e-6
"""Of a power of Re_m whose slope is infinite at rest."""


def falling_form(viscous: float, inertial: float, exponent: float, source: str) -> DragLaw:
    """The law F = `viscous`/Re_m + `inertial`/Re_m^`exponent`."""

    def coefficient(porosity: Value, bead_diameter: Value, density: Value, viscosity: Value, speed: Value) -> Value:
        solids = 1.0 - porosity
        reynolds = density * porosity * speed * bead_diameter / viscosity
        modified = maximum(reynolds, LEAST_REYNOLDS_NUMBER) / maximum(solids, LEAST_REYNOLDS_NUMBER)
        at_rest = viscous * solids**2 * viscosity / (porosity * bead_diameter**2)
        return at_rest + inertial * solids * density * speed / bead_diameter / modified**exponent

    return DragLaw(coefficient, source)


def _eisfeld_schnitzlein(
    porosity: Value, bead_diameter: Value, density: Value, viscosity: Value, speed: Value, width_ratio: Value
) -> Value:
    walled = (1.0 - porosity) + 2.0 / (3.0 * width_ratio)  # A_w (1 - phi)
    at_rest = 154.0 * walled**2 * viscosity / (porosity * bead_diameter**2)
    return at_rest + walled / (1.15 / width_ratio**2 + 0.87) ** 2 * density * speed / bead_diameter


DRAG_LAWS.register("carman", falling_form(180.0, 2.871, 0.1, "Carman, Trans. Inst. Chem. Eng. 15 (1937) 150-166"))
DRAG_LAWS.register("kta", falling_form(160.0, 3.0, 0.1, "KTA 3102.3 (1981)"))
DRAG_LAWS.register(
    "erdim", falling_form(160.0, 2.81, 0.096, "Erdim, Akgiray, Demir, Powder Technol. 283 (2015) 488-504")
)
DRAG_LAWS.register(
    "eisfeld-schnitzlein",
    DragLaw(_eisfeld_schnitzlein, "Eisfeld, Schnitzlein, Chem. Eng. Sci. 56 (2001) 4321-4329", float("inf")),
)
