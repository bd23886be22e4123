"""Soft-sphere dynamics: collisions, friction, Verlet lists."""

import math

import numpy as np
import pytest

from porousmold.packing import dynamics

FLOOR = np.array([[0.0, 0.0, 1.0, 0.0]])
NOWHERE = np.array([[0.0, 0.0, 1.0, 1e6]])
OPEN = np.zeros(2)
STIFFNESS = 2e4


def material(restitution=1.0, friction=0.0, spin_decay=0.0):
    zeta = -math.log(restitution) / math.hypot(math.pi, math.log(restitution))
    return STIFFNESS, 2.0 * zeta * math.sqrt(STIFFNESS), friction, spin_decay, dynamics.SPRING_RATIO


def integrate(body, settings, dt, steps, planes=NOWHERE, size=None, period=OPEN):
    """Advance `body` in place with one Verlet list that holds every pair."""
    count = len(body)
    size = np.column_stack((np.full(count, 0.5), np.ones(count))) if size is None else size
    springs, load = np.zeros((count, len(planes) + 1, 3)), np.zeros((count, 6))
    none = (np.zeros(count + 1, np.int64), np.zeros(0, np.int64), np.zeros(0), np.zeros((0, 3)))
    pairs = dynamics.renew_pairs(body, size, np.arange(count), springs, none, 100.0, period, settings[1])
    walls = (planes, 0.0, period, np.zeros((len(planes) + 1, 3)))
    beads, span = dynamics.Beads(body, load, size, springs), dynamics.Span(dt, steps, 1e9)
    dynamics.advance(beads, pairs, walls, settings, np.array([0.0, 0.0, -1.0]), span)


def test_bead_bounces_with_its_restitution():
    """The contact ends where its force would pull, before the spring is relaxed (Schwager and Pöschel, Granular Matter
    9 (2007) 465-469): e = exp(-(beta / omega) (pi - arctan(2 beta omega / (omega^2 - beta^2))))."""
    body = np.zeros((1, 9))
    body[0, 2], body[0, 5] = 0.5 + 1e-9, -20.0
    settings = material(restitution=0.5)
    integrate(body, settings, 1e-6, int(1.3 * math.pi / math.sqrt(STIFFNESS) / 1e-6), FLOOR)
    beta = 0.5 * settings[1]
    omega = math.sqrt(STIFFNESS - beta**2)
    expected = math.exp(-beta / omega * (math.pi - math.atan(2.0 * beta * omega / (omega**2 - beta**2))))
    assert body[0, 5] == pytest.approx(20.0 * expected, rel=2e-3)


def test_elastic_head_on_collision_swaps_velocities():
    body = np.zeros((2, 9))
    body[1, 0], body[0, 3] = 1.001, 3.0
    integrate(body, material(), 2e-6, 9000)
    falling = -2e-6 * 9000
    assert body[:, 3] == pytest.approx([0.0, 3.0], abs=2e-4)
    assert body[:, 5] == pytest.approx(falling)


@pytest.mark.parametrize("friction", [0.1, 0.8])
def test_oblique_collision_keeps_momentum_and_angular_momentum(friction):
    rng = np.random.default_rng(4)
    body, size = np.zeros((2, 9)), np.array([[0.5, 1.0], [0.35, 0.343]])
    body[1, :3] = (0.6, 0.5, 0.3)
    body[0, 3:] = rng.normal(size=6)
    body[0, 3] += 3.0

    def momenta():
        inertia = 0.4 * size[:, 1] * size[:, 0] ** 2
        angular = np.cross(body[:, :3], size[:, 1:] * body[:, 3:6]) + inertia[:, None] * body[:, 6:]
        return size[:, 1] @ body[:, 3:6], angular.sum(axis=0)

    before, spun = momenta()
    dt, steps = 1e-6, 40_000
    integrate(body, material(0.6, friction), dt, steps, size=size)
    after, angular = momenta()
    gravity = np.array([0.0, 0.0, -size[:, 1].sum() * dt * steps])
    assert after == pytest.approx(before + gravity, abs=1e-10)
    assert not np.allclose(body[1, 3:5], 0.0)  # they have met
    # gravity turns the pair about the origin, which moves with the centre of mass: its torque is m g x
    centre = size[:, 1] @ body[:, :3] / size[:, 1].sum()
    start = centre - after / size[:, 1].sum() * dt * steps + 0.5 * gravity / size[:, 1].sum() * dt * steps
    middle = 0.5 * (centre + start)
    torque = np.cross(middle, gravity / (dt * steps))
    assert angular == pytest.approx(spun + torque * dt * steps, abs=2e-4)


@pytest.mark.parametrize("friction", [0.1, 0.4])
def test_sliding_bead_ends_up_rolling_at_five_sevenths(friction):
    body = np.zeros((1, 9))
    body[0, 2], body[0, 3] = 0.5 - 1.0 / STIFFNESS, 1.0
    dt = 2e-4
    integrate(body, material(0.5, friction), dt, int(1.5 * 2.0 / 7.0 / friction / dt), FLOOR)
    assert body[0, 3] == pytest.approx(5.0 / 7.0, rel=2e-3)
    assert body[0, 7] * 0.5 == pytest.approx(body[0, 3], rel=2e-3)


def test_spin_decay_alone_slows_a_free_spin():
    body = np.zeros((1, 9))
    body[0, 6] = 1.0
    integrate(body, material(spin_decay=10.0), 1e-4, 1000)
    assert body[0, 6] == pytest.approx(math.exp(-1.0), rel=1e-3)


@pytest.mark.parametrize("period", [(0.0, 0.0), (0.0, 4.3), (5.0, 2.5)])
def test_verlet_list_holds_every_close_pair_once(period):
    rng, count, skin = np.random.default_rng(0), 300, 0.2
    size = np.column_stack((rng.uniform(0.3, 0.5, count), np.ones(count)))
    body = np.zeros((count, 9))
    body[:, :3] = rng.uniform((-2.5, -2.1, 0.0), (2.5, 2.1, 6.0), (count, 3))
    name, springs = np.arange(count), np.zeros((count, 2, 3))
    none = (np.zeros(count + 1, np.int64), np.zeros(0, np.int64), np.zeros(0), np.zeros((0, 3)))
    first = dynamics.renew_pairs(body, size, name, springs, none, skin, np.array(period), 1.0)

    def listed(pairs):
        begin = np.repeat(np.arange(count), np.diff(pairs[0]))
        return [tuple(sorted(pair)) for pair in zip(name[begin], name[pairs[1]], strict=True)]

    back = np.argsort(name)
    step = body[back, None, :3] - body[None, back, :3]
    for axis, length in enumerate(period):
        if length:
            step[..., axis] -= length * np.round(step[..., axis] / length)
    reach = size[back, None, 0] + size[None, back, 0] + skin
    expected = {(i, j) for i, j in np.argwhere(np.linalg.norm(step, axis=2) < reach) if i < j}
    assert set(listed(first)) == expected and len(listed(first)) == len(expected)

    # springs stay with their pairs when the beads move and change places, with the sign of the pair's order
    first[3][:] = rng.normal(size=first[3].shape)
    begin = np.repeat(np.arange(count), np.diff(first[0]))
    sign = np.where(name[begin] < name[first[1]], 1.0, -1.0)
    kept = dict(zip(listed(first), first[3] * sign[:, None], strict=True))
    body[:, :3] += rng.normal(scale=0.02, size=(count, 3))
    second = dynamics.renew_pairs(body, size, name, springs, first, skin, np.array(period), 1.0)
    begin = np.repeat(np.arange(count), np.diff(second[0]))
    sign = np.where(name[begin] < name[second[1]], 1.0, -1.0)
    common = 0
    for pair, spring in zip(listed(second), second[3] * sign[:, None], strict=True):
        assert spring == pytest.approx(kept.get(pair, np.zeros(3)))
        common += pair in kept
    assert common > 0.8 * len(kept)


def test_placing_leaves_no_contact():
    rng, radius = np.random.default_rng(1), np.repeat([0.5, 0.3], [100, 300])
    position = np.empty((400, 3))
    placed = dynamics.place(
        rng, position, radius, np.array([-3.0, -3.0, 0.0]), np.array([3.0, 3.0, 12.0]), 3.0, OPEN, 10_000
    )
    assert placed == 400
    distance = np.linalg.norm(position[:, None] - position[None], axis=2) + 10.0 * np.eye(400)
    assert (distance >= radius[:, None] + radius[None]).all()
    assert (np.hypot(position[:, 0], position[:, 1]) <= 3.0 - radius).all()
