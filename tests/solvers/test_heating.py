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
