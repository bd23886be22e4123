"""What is extrapolated from step to step, relaxed where it goes to and fro.

The flow of a step is that of temperatures extrapolated to its middle. Where beads are passed by their fluid many times in a step,
and the flow depends strongly on the temperature, as a viscous liquid does along a hot wall, the temperature that a step ends with
answers to the one that was assumed, dT = -s dG, and with T + (T - T_before) / 2 assumed for the next step this grows from
s = 1/2 on, though the steady state is stable. With the part w of what was missed, G + w (M - G), M the mean over the last step,
it decays for w < 2/s.
"""

import numpy as np
from dolfinx import fem

from ..arrays import Floats
from ..mesh.aliases import Space

FREE_TURNS = 1.0
"""Misses to and fro in succession that relax nothing: a front that has passed leaves one."""
MOST_TURNS = 7.0
"""The most that count."""
FORGOTTEN = 0.5
"""Turns that a step takes back which misses to the same side again: what is relaxed lags behind."""


class Relaxation:
    """Of values at the nodes of a scalar `space`: `missed` is by how much the last ones assumed missed what the step brought,
    `turns` how often it missed to and fro."""

    def __init__(self, space: Space) -> None:
        self.missed, self.turns = fem.Function(space), fem.Function(space)

    def begin(self) -> None:
        """Forget what was: after a jump extrapolation misses."""
        self.missed.x.array[:] = self.turns.x.array[:] = 0.0

    def relaxed(self, assumed: Floats, became: Floats, expected: Floats, least: float) -> Floats:
        """What to assume next, of what was `assumed` of the last step's middle, what `became` of that, and what is `expected` of
        the next one; misses below `least` are none."""
        before, now = self.missed.x.array, became - assumed
        now[np.abs(now) < least] = 0.0
        side, turns = np.sign(before * now), self.turns.x.array
        turns[:] = np.clip(np.where(side < 0.0, turns + 1.0, turns - FORGOTTEN * side), 0.0, MOST_TURNS)
        before[now != 0.0] = now[now != 0.0]
        part = 0.5 ** np.maximum(turns - FREE_TURNS, 0.0)
        return np.asarray(
            np.where(part == 1.0, expected, assumed + part * (became + part * (expected - became) - assumed))
        )
