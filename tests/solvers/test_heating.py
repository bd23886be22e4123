"""The heating steps: what they leave behind."""

import resource

from ..equations.test_wall_layers import solid, wall_alone

MEGABYTE = 1024.0
"""In units of ru_maxrss, KiB."""


def test_steps_leave_no_memory_behind():
    """PETSc's vectors are not freed by Python: those of 20 steps would take 20 MB here."""
    heat, _ = wall_alone([(solid(), 0.1, 20, None)], coefficient=5.0, along=400)
    heat.step(0.0, 1.0)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for number in range(20):
        heat.step(1.0 + number, 1.0)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 6.0 * MEGABYTE


def test_of_repeated_steps_that_with_the_least_excess_is_kept(monkeypatch):
    """Marking more cells may take temperatures further beyond their bounds: solution and balance are then the better ones."""
    heat, _ = wall_alone([(solid(), 0.1, 20, None)], coefficient=5.0)
    heat.step(0.0, 100.0)
    outcomes = iter([(3.0, True), (0.5, True), (2.0, True), (1.0, False), (0.7, False)])
    attempts = []

    def take(time, parts):
        attempts.append(len(parts))
        heat.unknown.x.array[:] = 300.0 + len(attempts)
        return {"by_fluid": float(len(attempts))}, 0.0, None

    monkeypatch.setattr(heat, "_take_all", take)
    monkeypatch.setattr(heat.bounded_steps, "mark", lambda bounds: next(outcomes))
    before = heat.balance.by_fluid
    heat.step(100.0, 10.0)
    # marking that no longer helps gives way to the damped step, and that to backward Euler
    assert attempts == [1, 1, 1, 2, 2]
    assert (heat.unknown.x.array == 302.0).all() and heat.balance.by_fluid - before == 2.0
