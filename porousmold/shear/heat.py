r"""Heat that sheared beads carry and pass on: temperatures of the beads, for many cases on one trajectory.

The temperatures do not act on the motion, so that one trajectory serves all pairs of Peclet and Biot numbers. In units of the
bead diameter d, the shear rate gamma and the beads' conductivity lambda (Forgber and Radl, eq. 9 to 13, 18, 19),

    4 Pe pi/6 dT_i/dt = sum_j 2 sqrt(A_ij) (T_j - T_i) + pi Bi' (T_f - T_i),

    Pe = (d/2)^2 gamma rho C/lambda,   Bi = alpha d/lambda,   Bi' = Bi/(1 + Bi/10).

A is the area of a contact: the paper and LIGGGHTS take sqrt(A) where Batchelor and O'Brien (1977) have the radius of the
contact, so that contacts conduct 1.77 times as much. Bi' has the resistance R/(5 lambda) of the bead's inside in series with
the film: no mode kept (`laws.bead_interior`). Walls are at -1/2 and 1/2, the fluid at 0. The fluxes over a volume V are

    conduction  q = 1/V sum_contacts 2 sqrt(A) (T_i - T_j) (z_j - z_i),    convection  q = 1/V sum_i 4 Pe pi/6 T_i v_z,i.

Heat is exchanged in steps of some steps of the motion, each with the mean conductance of every contact over them, and in parts
of these where the exchange is fast. With mean positions and temperatures over a step, the sum of both fluxes is the flux
through the walls less what the beads store, to rounding errors, whatever the step.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from ..arrays import Floats, Integers
from ..laws.bead_interior import ALL_MODES, overall_coefficient
from ..packing import dynamics

AREA_ROOT = math.sqrt(math.pi)
"""sqrt(A) over the radius of a contact."""
FIXED = dynamics.FIXED


class Heat(NamedTuple):
    """Temperatures of the beads and what is summed up of the heat that they exchange.

    `temperature` (n, m) is of bead name[i] in row name[i], `cases` are those of `cases_of`, `height` is that between the walls.
    Added to are `fluxes` (bins over the height, m, 2), integrals over time and volume of conduction and convection towards
    greater z, and `into_beads` (m, 3), heat from the lower wall, the upper one and the film.
    """

    name: Integers
    temperature: Floats
    cases: Floats
    height: float
    fluxes: Floats
    into_beads: Floats


def cases_of(peclet_numbers: tuple[float, ...], biot_numbers: tuple[float, ...]) -> Floats:
    """Heat capacity of a bead 4 Pe pi/6 and film conductance pi Bi', in units of d lambda, of every pair of them (m, 2)."""
    inside = 0.5 * ALL_MODES  # R/(5 lambda) in units of d/lambda
    return np.array([
        (4.0 * peclet * math.pi / 6.0, math.pi * overall_coefficient(biot, inside))
        for peclet in peclet_numbers
        for biot in biot_numbers
    ])  # fmt: skip


@njit(cache=True, error_model="numpy", fastmath=True)
def shear(
    beads: dynamics.Beads,
    pairs: dynamics.Pairs,
    walls: dynamics.Walls,
    material: dynamics.Material,
    span: dynamics.Span,
    interval: int,
    stress: Floats,
    heat: Heat,
) -> int:  # pragma: no cover
    """The motion of a span with the exchange of heat after every `interval` of its steps; gives the steps done.

    For the others see `packing.dynamics.advance`; stress: the sums of `advance`.
    """
    gravity, body = np.zeros(3), beads.body
    dt, steps, slack = span
    done = 0
    in_pairs, with_walls = np.zeros(pairs[1].size), np.zeros((body.shape[0], 2))
    while done < steps and slack > 0.0:
        in_pairs[:] = 0.0
        with_walls[:] = 0.0
        before = body[:, 2].copy()
        ahead, contacts = dynamics.Span(dt, min(interval, steps - done), slack), (in_pairs, with_walls, stress)
        some, slack = dynamics.advance(beads, pairs, walls, material, gravity, ahead, contacts)
        exchange(
            heat, before, body[:, 2], beads.size, (pairs[0], pairs[1]), in_pairs / some, with_walls / some, dt * some
        )
        done += some
    return done


@njit(cache=True, error_model="numpy", fastmath=True)
def exchange(
    heat: Heat,
    before: Floats,
    after: Floats,
    size: Floats,
    pairs: tuple[Integers, Integers],
    in_pairs: Floats,
    with_walls: Floats,
    span: float,
) -> None:  # pragma: no cover
    """Change the temperatures of `heat` over `span`, and add to its sums; the positions z go from `before` to `after`.

    in_pairs, with_walls: mean radii of the contacts of pairs j > i (partner[start[i]:start[i + 1]] of the `pairs` start, partner)
    and with the two walls.
    """
    name, temperature, cases, height, fluxes, into_beads = heat
    start, partner = pairs
    count, bins = name.size, fluxes.shape[0]
    middle = 0.5 * (before + after)
    first, second = np.empty(partner.size, np.int64), np.empty(partner.size, np.int64)
    conductance = np.empty(partner.size)
    total, found = np.zeros(count), 0
    for i in range(count):
        for at in range(start[i], start[i + 1]):
            if in_pairs[at] > 0.0:
                first[found], second[found] = i, partner[at]
                conductance[found] = 2.0 * AREA_ROOT * in_pairs[at]
                total[i] += conductance[found]
                total[partner[at]] += conductance[found]
                found += 1
    largest = 0.0
    for i in range(count):
        if size[i, 1] < FIXED:
            largest = max(largest, total[i] + 2.0 * AREA_ROOT * (with_walls[i, 0] + with_walls[i, 1]))
    warm, gain = np.empty(count), np.empty(count)
    for case in range(cases.shape[0]):
        capacity, film = cases[case]
        parts = 1 + int(2.0 * largest / capacity * span)
        part = span / parts
        for i in range(count):
            warm[i] = temperature[name[i], case]
        for _ in range(parts):
            gain[:] = 0.0
            for c in range(found):
                i, j = first[c], second[c]
                passed = part * conductance[c] * (warm[i] - warm[j])
                gain[i] -= passed
                gain[j] += passed
                fluxes[_bin(0.5 * (middle[i] + middle[j]), height, bins), case, 0] += passed * (middle[j] - middle[i])
            for i in range(count):
                if size[i, 1] >= FIXED:  # of a wall: what it loses comes from the wall
                    into_beads[case, 0 if middle[i] < 0.5 * height else 1] -= gain[i]
                    continue
                for wall in range(2):
                    if with_walls[i, wall] > 0.0:
                        passed = part * 2.0 * AREA_ROOT * with_walls[i, wall] * (wall - 0.5 - warm[i])
                        gain[i] += passed
                        into_beads[case, wall] += passed
                        place = 0.5 * (middle[i] + wall * height)
                        fluxes[_bin(place, height, bins), case, 0] += passed * (middle[i] - wall * height)
                warm[i] += gain[i] / capacity
        kept = math.exp(-film / capacity * span)
        for i in range(count):
            if size[i, 1] >= FIXED:
                continue
            into_beads[case, 2] += capacity * (kept - 1.0) * warm[i]
            warm[i] *= kept
            old = temperature[name[i], case]
            carried = capacity * 0.5 * (old + warm[i]) * (after[i] - before[i])
            fluxes[_bin(middle[i], height, bins), case, 1] += carried
            temperature[name[i], case] = warm[i]


@njit(cache=True, inline="always")
def _bin(place: float, height: float, bins: int) -> int:  # pragma: no cover
    return min(max(int(place / height * bins), 0), bins - 1)
