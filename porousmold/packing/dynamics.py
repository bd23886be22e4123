r"""Soft-sphere dynamics of beads: compiled kernels on arrays, without units.

Linear spring and dashpot with Coulomb friction (Cundall and Strack, Géotechnique 29 (1979) 47-65). Where beads i and j
overlap by delta, with n from i to j, relative velocity v of j's surface against i's and m = m_i m_j / (m_i + m_j):

    F_n = k delta - 2 zeta sqrt(m k) v.n          (never pulling; on j)
    F_t = -k_t xi - 2 zeta sqrt(m_t k_t) v_t      with |F_t| <= mu F_n, xi the tangential spring since first touch
    k_t = s k,  m_t = s m                         (s = 2/7: equal normal and tangential periods of solid spheres)
    zeta = -ln e / sqrt(pi^2 + ln^2 e)            for the coefficient of restitution e (0.55 for e = 0.5: no pull)

and likewise against the walls, with m the bead's own mass. Spins may decay at a given rate besides: it stands for rolling
resistance, carries no load at rest, and without it a few beads roll on top of a poured bed for as long as it took to fall.
Lengths are in mean bead diameters and masses in masses of the mean bead. A poured bed has accelerations in g, so that
gravity is 1 and time is in sqrt(d/g); a sheared one has no gravity, and time in strains. Semi-implicit Euler steps. A bead
of mass `FIXED` keeps its velocity whatever pushes it: it is part of a wall.

Pairs come from a Verlet list (each pair once, at the lower index) that holds all pairs within a skin and is renewed
from cells as soon as the fastest bead may have crossed half of it; beads are put into the order of the cells on the
way, which keeps neighbours close in memory. One thread, fixed order: same start, same end.

Arrays of `Beads`: `body` (n, 9) position, velocity, spin; `load` (n, 6) force, torque; `size` (n, 2) radius, mass.
"""

import math
from typing import NamedTuple, TypeAlias

import numpy as np
from numba import njit

from ..arrays import Floats, Integers

Pairs: TypeAlias = tuple[Integers, Integers, Floats, Floats]
"""A Verlet list (`renew_pairs`)."""
Walls: TypeAlias = tuple[Floats, float, Floats, Floats]
Material: TypeAlias = tuple[float, float, float, float, float]
SPRING_RATIO = 2.0 / 7.0
FIXED = 1e30
"""Mass of a bead that nothing moves."""
STRESSES = 4
"""Sums over contacts that `advance` adds up: F.r, F_z r_z, F_x r_z and their number."""


class Beads(NamedTuple):
    """Beads in the order of their cells, with the springs of their contacts with the walls (n, w + 1, 3)."""

    body: Floats
    load: Floats
    size: Floats
    wall_spring: Floats


class Span(NamedTuple):
    """Up to `steps` steps of length `dt`, fewer if a bead has gone its `slack`: the way that it may go with a Verlet list, half
    of its skin at first."""

    dt: float
    steps: int
    slack: float


def material_of(
    stiffness: float, restitution: float, friction: float, *, spin_decay: float = 0.0, ratio: float = SPRING_RATIO
) -> Material:
    """What `advance` takes as material; `ratio` is that of tangential to normal stiffness."""
    return stiffness, 2.0 * _damping(restitution) * math.sqrt(stiffness), friction, spin_decay, ratio


def contact_time(stiffness: float, restitution: float, mass: float = 1.0) -> float:
    """Time of a collision of two beads of that mass."""
    return math.pi * math.sqrt(0.5 * mass / (stiffness * (1.0 - _damping(restitution) ** 2)))


def no_pairs(count: int) -> Pairs:
    """The Verlet list of so many beads before the first one is made."""
    return np.zeros(count + 1, np.int64), np.zeros(0, np.int64), np.zeros(0), np.zeros((0, 3))


def _damping(restitution: float) -> float:
    """zeta."""
    return -math.log(restitution) / math.hypot(math.pi, math.log(restitution))


@njit(cache=True, error_model="numpy", fastmath=True)
def place(
    rng: np.random.Generator,
    position: Floats,
    radius: Floats,
    low: Floats,
    high: Floats,
    cylinder_radius: float,
    period: Floats,
    largest_tries: int,
) -> int:  # pragma: no cover
    """Random sequential placing, in the order given, without overlap; gives the number of beads placed.

    position (n, 3) is filled; beads lie within the box `low` to `high`, but for its periodic sides, and within the
    cylinder about z if its radius is > 0. Stops at the first bead that finds no place in `largest_tries` tries.
    """
    cells = _grid(high - low, 2.0 * radius.max(), period, radius.size)
    around = np.empty(27, np.int64)
    head = np.full(cells[0] * cells[1] * cells[2], -1, np.int64)
    following = np.full(radius.size, -1, np.int64)
    at, cell = np.empty(3), np.empty(3, np.int64)
    for i in range(radius.size):
        for _ in range(largest_tries):
            for a in range(3):
                margin = 0.0 if a < 2 and period[a] > 0.0 else radius[i]
                at[a] = low[a] + margin + rng.random() * (high[a] - low[a] - 2.0 * margin)
                cell[a] = min(int((at[a] - low[a]) / (high[a] - low[a]) * cells[a]), cells[a] - 1)
            if cylinder_radius > 0.0 and math.hypot(at[0], at[1]) > cylinder_radius - radius[i]:
                continue
            free = True
            for k in range(_around(cell, cells, period, around)):
                j = head[around[k]]
                while j >= 0 and free:
                    distance = 0.0
                    for a in range(3):
                        step = position[j, a] - at[a]
                        if a < 2 and period[a] > 0.0:
                            step -= period[a] * round(step / period[a])
                        distance += step * step
                    free = distance >= (radius[i] + radius[j]) ** 2
                    j = following[j]
                if not free:
                    break
            if free:
                position[i] = at
                c = (cell[0] * cells[1] + cell[1]) * cells[2] + cell[2]
                following[i], head[c] = head[c], i
                break
        else:
            return i
    return radius.size


@njit(cache=True)
def _grid(span: Floats, size: float, period: Floats, count: int) -> Integers:  # pragma: no cover
    """Cells of at least `size` along each side, some ten per bead at most; a periodic side has one cell or at least three,
    so that none is met twice."""
    cells = np.empty(3, np.int64)
    size = max(size, (span[0] * span[1] * span[2] / (10.0 * count + 1000.0)) ** (1.0 / 3.0), span.max() / 1e5)
    for a in range(3):
        cells[a] = max(1, math.floor(span[a] / size))
        if a < 2 and period[a] > 0.0 and cells[a] < 3:
            cells[a] = 1
    return cells


@njit(cache=True)
def _around(cell: Integers, cells: Integers, period: Floats, found: Integers) -> int:  # pragma: no cover
    """Fills `found` (27) with the numbers of the cell and its neighbours; gives how many."""
    count = 0
    for da in range(-1, 2):
        a = cell[0] + da
        if period[0] > 0.0 and cells[0] > 1:
            a %= cells[0]
        if not 0 <= a < cells[0]:
            continue
        for db in range(-1, 2):
            b = cell[1] + db
            if period[1] > 0.0 and cells[1] > 1:
                b %= cells[1]
            if not 0 <= b < cells[1]:
                continue
            for c in range(max(cell[2] - 1, 0), min(cell[2] + 2, cells[2])):
                found[count] = (a * cells[1] + b) * cells[2] + c
                count += 1
    return count


@njit(cache=True, error_model="numpy", fastmath=True)
def _pairs(
    place: Floats,
    cell: Integers,
    first: Integers,
    cells: Integers,
    skin: float,
    period: Floats,
    start: Integers,
    partner: Integers,
) -> int:  # pragma: no cover
    """Fills start and partner of a Verlet list; gives the number of pairs, of which those that fit are in `partner`."""
    total = 0
    for i in range(start.size - 1):
        px, py, pz, farthest = place[i, 0], place[i, 1], place[i, 2], place[i, 3] + skin
        for da in range(-1, 2):
            a = cell[i, 0] + da
            if period[0] > 0.0 and cells[0] > 1:
                a %= cells[0]
            if not 0 <= a < cells[0]:
                continue
            for db in range(-1, 2):
                b = cell[i, 1] + db
                if period[1] > 0.0 and cells[1] > 1:
                    b %= cells[1]
                if not 0 <= b < cells[1]:
                    continue
                row = (a * cells[1] + b) * cells[2]
                begin = first[row + max(cell[i, 2] - 1, 0)]
                end = first[row + min(cell[i, 2] + 2, cells[2])]
                for j in range(max(begin, i + 1), end):
                    dx, dy, dz = place[j, 0] - px, place[j, 1] - py, place[j, 2] - pz
                    if period[0] > 0.0:
                        dx -= period[0] * math.floor(dx / period[0] + 0.5)
                    if period[1] > 0.0:
                        dy -= period[1] * math.floor(dy / period[1] + 0.5)
                    reach = farthest + place[j, 3]
                    if dx * dx + dy * dy + dz * dz < reach * reach:
                        if total < partner.size:
                            partner[total] = j
                        total += 1
        start[i + 1] = total
    return total


@njit(cache=True, error_model="numpy", fastmath=True)
def renew_pairs(
    body: Floats,
    size: Floats,
    name: Integers,
    wall_spring: Floats,
    pairs: Pairs,
    skin: float,
    period: Floats,
    dashpot_rate: float,
) -> Pairs:  # pragma: no cover
    """Puts the beads into the order of their cells and gives the Verlet list (start, partner, dashpot, spring).

    body, size, wall_spring and name (n; each bead's first number) are reordered in place and periodic positions wrapped.
    start (n + 1) indexes the others: partners j > i with a gap below `skin`; dashpot = dashpot_rate sqrt(m_ij) of the
    pair; spring (pairs, 3) keeps what it held in the old list.
    """
    old_start, old_partner, _, old_spring = pairs
    count = name.size
    low, span = np.empty(3), np.empty(3)
    for a in range(3):
        if a < 2 and period[a] > 0.0:
            for i in range(count):
                body[i, a] -= period[a] * math.floor(body[i, a] / period[a] + 0.5)
            low[a], span[a] = -0.5 * period[a], period[a]
        else:
            low[a] = body[:, a].min()
            span[a] = body[:, a].max() - low[a] + 1e-9
    cells = _grid(span, 2.0 * size[:, 0].max() + skin, period, count)
    cell = np.empty((count, 3), np.int64)
    number = np.empty(count, np.int64)
    first = np.zeros(cells[0] * cells[1] * cells[2] + 1, np.int64)
    for i in range(count):
        for a in range(3):
            cell[i, a] = min(max(int((body[i, a] - low[a]) / span[a] * cells[a]), 0), cells[a] - 1)
        number[i] = (cell[i, 0] * cells[1] + cell[i, 1]) * cells[2] + cell[i, 2]
        first[number[i] + 1] += 1
    for c in range(first.size - 1):
        first[c + 1] += first[c]
    filled = first[:-1].copy()
    order, moved = np.empty(count, np.int64), np.empty(count, np.int64)
    for i in range(count):
        moved[i] = filled[number[i]]
        order[moved[i]] = i
        filled[number[i]] += 1
    body[:], size[:], wall_spring[:], name[:] = body[order], size[order], wall_spring[order], name[order]
    cell = cell[order]

    start = np.zeros(count + 1, np.int64)
    place = np.empty((count, 4))
    place[:, :3], place[:, 3] = body[:, :3], size[:, 0]
    partner = np.empty(6 * count, np.int64)
    total = _pairs(place, cell, first, cells, skin, period, start, partner)
    if total > partner.size:
        partner = np.empty(total, np.int64)
        _pairs(place, cell, first, cells, skin, period, start, partner)
    dashpot, spring = np.empty(total), np.zeros((total, 3))
    for i in range(count):
        for at in range(start[i], start[i + 1]):
            m, other = size[i, 1], size[partner[at], 1]
            dashpot[at] = dashpot_rate * math.sqrt(m * other / (m + other))
    for old in range(old_start.size - 1):
        for at in range(old_start[old], old_start[old + 1]):
            if old_spring[at, 0] != 0.0 or old_spring[at, 1] != 0.0 or old_spring[at, 2] != 0.0:
                i, j = moved[old], moved[old_partner[at]]
                sign = 1.0
                if i > j:
                    i, j, sign = j, i, -1.0
                for k in range(start[i], start[i + 1]):
                    if partner[k] == j:
                        for a in range(3):
                            spring[k, a] = sign * old_spring[at, a]
                        break
    return start, partner[:total].copy(), dashpot, spring


@njit(error_model="numpy", fastmath=True, inline="always")
def _friction(
    spring: Floats,
    at: int,
    direction: tuple[float, float, float],
    velocity: tuple[float, float, float],
    normal: float,
    dashpot: float,
    law: tuple[float, float, float],
) -> tuple[float, float, float]:  # pragma: no cover
    """Tangential force of spring[at], which is stretched, turned into the tangent plane and cut by Coulomb's law; `law` is the
    tangential stiffness, the friction coefficient and the time step."""
    (nx, ny, nz), (vx, vy, vz), (stiffness, friction, dt) = direction, velocity, law
    along = spring[at, 0] * nx + spring[at, 1] * ny + spring[at, 2] * nz
    sx = spring[at, 0] - along * nx + vx * dt
    sy = spring[at, 1] - along * ny + vy * dt
    sz = spring[at, 2] - along * nz + vz * dt
    tx, ty, tz = -stiffness * sx - dashpot * vx, -stiffness * sy - dashpot * vy, -stiffness * sz - dashpot * vz
    square, limit = tx * tx + ty * ty + tz * tz, friction * normal
    if square > limit * limit:
        cut = limit / math.sqrt(square)
        tx, ty, tz = tx * cut, ty * cut, tz * cut
        soft = -1.0 / stiffness
        sx, sy, sz = soft * (tx + dashpot * vx), soft * (ty + dashpot * vy), soft * (tz + dashpot * vz)
    spring[at, 0], spring[at, 1], spring[at, 2] = sx, sy, sz
    return tx, ty, tz


@njit(cache=True, error_model="numpy", fastmath=True)
def advance(
    beads: Beads,
    pairs: Pairs,
    walls: Walls,
    material: Material,
    gravity: Floats,
    span: Span,
    contacts: tuple[Floats, Floats, Floats] | None = None,
    bonds: Floats | None = None,
) -> tuple[int, float]:  # pragma: no cover
    """The steps of a span; gives the number of steps done and the slack left.

    walls: planes (w, 4; inward unit normal and offset), cylinder radius (0 for none), period (2; 0 for none), velocities of the
    walls (w + 1, 3); material: stiffness, dashpot_rate = 2 zeta sqrt(stiffness), friction coefficient, spin_decay, tangential
    over normal stiffness; gravity (3). contacts: None, or sums over the steps that are added to: radii of the contacts of pairs
    (pairs), with planes (n, w), and `STRESSES`. bonds: None, or forces (n) of which the smaller one of two beads in contact
    pulls them together.
    """
    body, load, size, wall_spring = beads
    dt, steps, slack = span
    planes, cylinder_radius, period, wall_velocity = walls
    start, partner, dashpots, spring = pairs
    stiffness, dashpot_rate, friction, spin_decay, ratio = material
    law = ratio * stiffness, friction, dt
    count = body.shape[0]
    kept = 1.0 - spin_decay * dt
    for done in range(steps):
        for i in range(count):
            mass = size[i, 1] if size[i, 1] < FIXED else 0.0
            load[i, 0], load[i, 1], load[i, 2] = gravity[0] * mass, gravity[1] * mass, gravity[2] * mass
            load[i, 3], load[i, 4], load[i, 5] = 0.0, 0.0, 0.0
        for i in range(count):
            # what the inner loop reads and adds up for bead i stands in locals: arrays might alias, for the compiler
            px, py, pz, radius = body[i, 0], body[i, 1], body[i, 2], size[i, 0]
            ux, uy, uz, ox, oy, oz = body[i, 3], body[i, 4], body[i, 5], body[i, 6], body[i, 7], body[i, 8]
            fx, fy, fz, mx, my, mz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for at in range(start[i], start[i + 1]):
                j = partner[at]
                nx, ny, nz = body[j, 0] - px, body[j, 1] - py, body[j, 2] - pz
                if period[0] > 0.0:
                    nx -= period[0] * math.floor(nx / period[0] + 0.5)
                if period[1] > 0.0:
                    ny -= period[1] * math.floor(ny / period[1] + 0.5)
                square, reach = nx * nx + ny * ny + nz * nz, radius + size[j, 0]
                if square >= reach * reach:
                    spring[at, 0], spring[at, 1], spring[at, 2] = 0.0, 0.0, 0.0
                    continue
                distance = math.sqrt(square)
                inverse = 1.0 / distance
                nx, ny, nz = nx * inverse, ny * inverse, nz * inverse
                overlap = reach - distance
                ai, aj = radius - 0.5 * overlap, size[j, 0] - 0.5 * overlap
                wx, wy, wz = ai * ox + aj * body[j, 6], ai * oy + aj * body[j, 7], ai * oz + aj * body[j, 8]
                # surface of j against surface of i: v_j - v_i - (a_i w_i + a_j w_j) x n
                vx = body[j, 3] - ux - (wy * nz - wz * ny)
                vy = body[j, 4] - uy - (wz * nx - wx * nz)
                vz = body[j, 5] - uz - (wx * ny - wy * nx)
                vn = vx * nx + vy * ny + vz * nz
                normal = max(stiffness * overlap - dashpots[at] * vn, 0.0)
                slip = vx - vn * nx, vy - vn * ny, vz - vn * nz
                tx, ty, tz = _friction(spring, at, (nx, ny, nz), slip, normal, ratio * dashpots[at], law)
                cx, cy, cz = ny * tz - nz * ty, nz * tx - nx * tz, nx * ty - ny * tx
                if bonds is not None:
                    normal -= min(bonds[i], bonds[j])
                tx, ty, tz = tx + normal * nx, ty + normal * ny, tz + normal * nz
                if contacts is not None and (size[i, 1] < FIXED or size[j, 1] < FIXED):
                    # the circle of the lens that the two spheres share
                    along = 0.5 * (square + radius * radius - size[j, 0] * size[j, 0]) * inverse
                    contacts[0][at] += math.sqrt(max(radius * radius - along * along, 0.0))
                    contacts[2][0] += distance * (tx * nx + ty * ny + tz * nz)
                    contacts[2][1] += distance * tz * nz
                    contacts[2][2] += distance * tx * nz
                    contacts[2][3] += 1.0
                fx, fy, fz = fx - tx, fy - ty, fz - tz
                mx, my, mz = mx - ai * cx, my - ai * cy, mz - ai * cz
                load[j, 0] += tx
                load[j, 1] += ty
                load[j, 2] += tz
                load[j, 3] -= aj * cx
                load[j, 4] -= aj * cy
                load[j, 5] -= aj * cz
            load[i, 0] += fx
            load[i, 1] += fy
            load[i, 2] += fz
            load[i, 3] += mx
            load[i, 4] += my
            load[i, 5] += mz
        fastest = 0.0
        for i in range(count):
            radius, mass = size[i, 0], size[i, 1]
            for wall in range(planes.shape[0] + 1):
                nx, ny, nz = 0.0, 0.0, 0.0
                if wall < planes.shape[0]:
                    nx, ny, nz = planes[wall, 0], planes[wall, 1], planes[wall, 2]
                    gap = nx * body[i, 0] + ny * body[i, 1] + nz * body[i, 2] + planes[wall, 3]
                elif cylinder_radius > 0.0:
                    square = body[i, 0] ** 2 + body[i, 1] ** 2
                    gap = radius
                    if square > (cylinder_radius - radius) ** 2:
                        axial = math.sqrt(square)
                        nx, ny = -body[i, 0] / axial, -body[i, 1] / axial
                        gap = cylinder_radius - axial
                else:
                    continue
                if gap >= radius:
                    wall_spring[i, wall, 0], wall_spring[i, wall, 1], wall_spring[i, wall, 2] = 0.0, 0.0, 0.0
                    continue
                # n points from the wall to the bead's centre; the bead moves against the wall: v - v_wall - gap w x n
                vx = body[i, 3] - wall_velocity[wall, 0] - gap * (body[i, 7] * nz - body[i, 8] * ny)
                vy = body[i, 4] - wall_velocity[wall, 1] - gap * (body[i, 8] * nx - body[i, 6] * nz)
                vz = body[i, 5] - wall_velocity[wall, 2] - gap * (body[i, 6] * ny - body[i, 7] * nx)
                vn = vx * nx + vy * ny + vz * nz
                dashpot = dashpot_rate * math.sqrt(mass)
                normal = max(stiffness * (radius - gap) - dashpot * vn, 0.0)
                slip = vx - vn * nx, vy - vn * ny, vz - vn * nz
                tx, ty, tz = _friction(wall_spring[i], wall, (nx, ny, nz), slip, normal, ratio * dashpot, law)
                if contacts is not None and mass < FIXED and wall < planes.shape[0]:
                    contacts[1][i, wall] += math.sqrt(max(radius * radius - gap * gap, 0.0))
                    contacts[2][0] += gap * (normal + tx * nx + ty * ny + tz * nz)
                    contacts[2][1] += gap * (normal * nz + tz) * nz
                    contacts[2][2] += gap * (normal * nx + tx) * nz
                    contacts[2][3] += 1.0
                load[i, 0] += normal * nx + tx
                load[i, 1] += normal * ny + ty
                load[i, 2] += normal * nz + tz
                load[i, 3] -= gap * (ny * tz - nz * ty)
                load[i, 4] -= gap * (nz * tx - nx * tz)
                load[i, 5] -= gap * (nx * ty - ny * tx)
            push, turn = dt / mass, dt / (0.4 * mass * radius * radius)
            speed = 0.0
            for a in range(3):
                body[i, 3 + a] += push * load[i, a]
                body[i, 6 + a] = kept * (body[i, 6 + a] + turn * load[i, 3 + a])
                body[i, a] += dt * body[i, 3 + a]
                speed += body[i, 3 + a] ** 2
            fastest = max(fastest, speed)
        slack -= dt * math.sqrt(fastest)
        if slack <= 0.0:
            return done + 1, slack
    return steps, slack
