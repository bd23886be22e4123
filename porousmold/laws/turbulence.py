r"""Two-layer k-epsilon model with the bead sources of Nakayama and Kuwahara.

Transport (thesis eq. 6.17-6.18, here per phi; advective form):

    rho u.grad k   = div(phi (mu + mu_t/sigma_k) grad k)/phi + G_k - rho epsilon + S_k
    rho u.grad eps = div(phi (mu + mu_t/sigma_eps) grad eps)/phi + (eps/k) (C_1 G_k - C_2 rho eps) + C_2 S_eps

Near the wall (enhanced wall treatment with y+ about 1, which is the two-layer model): with Re_y = rho y sqrt(k)/mu,

    l_mu  = y C_l (1 - exp(-Re_y/A_mu)),  l_eps = y C_l (1 - exp(-Re_y/A_eps)),
    mu_t  = rho C_mu l_mu sqrt(k),        eps   = k^1.5/l_eps       where Re_y < 200,

C_l = kappa C_mu^-3/4, A_mu = 70, A_eps = 2 C_l (Chen and Patel, AIAA J. 26 (1988) 641-648), blended into the outer
layer by (1 + tanh((Re_y - 200)/A))/2 (Jongen's blend, as in Fluent's theory guide), A = W/atanh(0.98).

Two choices of ours, both of them keys of a scene (`model.blend_half_width`, `model.longest_eddy`):

- W = 120 in place of Fluent's 20. Between beads without bead sources Re_y settles at 200 to 270 over most of the bed; with
  W = 20 all of it lies inside the blend, where the two layers' epsilon differ, and Newton's method goes to and fro.
- epsilon >= k^1.5 (1/(5 C_l y) + 1/L) in the outer layer, with L one bead diameter: no eddy between beads is longer than
  a bead. Without it the lengths grow to tens of bead diameters where bead sources fade out, with mu_t/mu up to 1800.

`docs/theory.md` has their effect. W = 20 and a large `longest_eddy` are the published form.

Beads (eq. 6.19-6.22): S_k = f_d rho eps_inf, S_eps = f_d rho eps_inf^2/k_inf; f_d of eq. 7.33 fades them out
below a local bead Reynolds number of 900. A uniform bed settles at k = f_d k_inf, epsilon = f_d eps_inf.

Constants: Launder and Spalding, Comput. Methods Appl. Mech. Eng. 3 (1974) 269-289. The thesis prints C_1 = 1.14
while citing them; their value, 1.44, stands here (the heating time moves by < 0.1 %).
"""

from math import atanh

from .functions import Value, exp, one_minus_exp_over, smooth_step, sqrt

C_MU = 0.09
C_EPSILON_1 = 1.44
C_EPSILON_2 = 1.92
SIGMA_K = 1.0
SIGMA_EPSILON = 1.3
KAPPA = 0.4187
PRANDTL_TURBULENT = 0.85
C_LENGTH = KAPPA * C_MU**-0.75
A_MU = 70.0
A_EPSILON = 2.0 * C_LENGTH
REYNOLDS_SWITCH = 200.0
BLEND_LEVEL = atanh(0.98)
LONGEST_WALL_LENGTH = 5.0
DAMPING_START, DAMPING_END = 800.0, 900.0


def wall_reynolds_number(density: Value, wall_distance: Value, kinetic_energy: Value, viscosity: Value) -> Value:
    """Re_y = rho y sqrt(k)/mu."""
    return density * wall_distance * sqrt(kinetic_energy) / viscosity


def outer_fraction(reynolds_wall: Value, half_width: Value) -> Value:
    """Weight (1 + tanh x)/2, x = atanh(0.98) (Re_y - 200)/`half_width`, of the outer (k-epsilon) layer.

    It rises from 1 % at Re_y = 200 - half_width to 99 % at 200 + half_width. Written 1/(1 + exp(-2 x)): UFL's derivative
    of tanh overflows beyond x = 355, which Re_y = 3300 reaches.
    """
    return 1.0 / (1.0 + exp(-2.0 * BLEND_LEVEL * (reynolds_wall - REYNOLDS_SWITCH) / half_width))


def least_dissipation_rate(kinetic_energy: Value, wall_distance: Value, largest_eddy: Value) -> Value:
    """k^1.5 (1/(5 C_l y) + 1/L) in m2/s3: epsilon of the longest length k^1.5/epsilon that the outer layer may have.

    That is five times the length of a wall layer, and `largest_eddy` L (m), whichever is shorter.
    """
    return kinetic_energy**1.5 * (1.0 / (LONGEST_WALL_LENGTH * C_LENGTH * wall_distance) + 1.0 / largest_eddy)


def inner_dissipation_rate(
    kinetic_energy: Value, reynolds_wall: Value, wall_distance: Value, kinematic_viscosity: Value
) -> Value:
    """epsilon = k^1.5/l_eps in m2/s3, written as 2 nu k/(y^2 g(Re_y/A_eps)), g(x) = (1 - exp(-x))/x.

    The two are equal; the second has no 0/0 where k vanishes. wall_distance > 0.
    """
    decay = one_minus_exp_over(reynolds_wall / A_EPSILON)
    return 2.0 * kinematic_viscosity * kinetic_energy / (wall_distance**2 * decay)


def inner_eddy_viscosity(density: Value, kinetic_energy: Value, reynolds_wall: Value, wall_distance: Value) -> Value:
    """mu_t = rho C_mu l_mu sqrt(k) in Pa s."""
    length = wall_distance * C_LENGTH * (reynolds_wall / A_MU) * one_minus_exp_over(reynolds_wall / A_MU)
    return density * C_MU * length * sqrt(kinetic_energy)


def outer_eddy_viscosity(density: Value, kinetic_energy: Value, dissipation_rate: Value) -> Value:
    """mu_t = C_mu rho k^2/epsilon in Pa s (eq. 6.16)."""
    return C_MU * density * kinetic_energy**2 / dissipation_rate


def bead_kinetic_energy(porosity: Value, speed: Value) -> Value:
    """k_inf = 3.7 phi^1.5 (1 - phi) |u|^2 in m2/s2 (eq. 6.22); 0 where phi = 1."""
    return 3.7 * porosity**1.5 * (1.0 - porosity) * speed**2


def bead_dissipation_rate(porosity: Value, speed: Value, bead_diameter: Value) -> Value:
    """eps_inf = 39 phi^2 (1 - phi)^2.5 |u|^3/d in m2/s3 (eq. 6.21); 0 where phi = 1."""
    return 39.0 * porosity**2 * (1.0 - porosity) ** 2.5 * speed**3 / bead_diameter


def bead_dissipation_squared_over_energy(porosity: Value, speed: Value, bead_diameter: Value) -> Value:
    """eps_inf^2/k_inf in m2/s4, with the factor (1 - phi) divided out so that it is 0 where phi = 1."""
    return (39.0**2 / 3.7) * porosity**2.5 * (1.0 - porosity) ** 4 * speed**4 / bead_diameter**2


def bead_decay_rate(porosity: Value, speed: Value, bead_diameter: Value) -> Value:
    """eps_inf/k_inf = (39/3.7) phi^0.5 (1 - phi)^1.5 |u|/d in 1/s: how fast the beads renew the turbulence between them."""
    return (39.0 / 3.7) * sqrt(porosity) * (1.0 - porosity) ** 1.5 * speed / bead_diameter


def damping(bead_reynolds_number: Value) -> Value:
    """f_d of eq. 7.33: 0 below Re_s = 800, 1 above 900, cubic between."""
    return smooth_step(bead_reynolds_number, DAMPING_START, DAMPING_END)
