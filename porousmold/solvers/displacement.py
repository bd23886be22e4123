"""Mass that a fluid displaces as its density changes with the temperature."""

from collections.abc import Callable

from dolfinx import fem

from ..arrays import Floats
from ..laws.functions import Value


class Displacement:
    """-d(rho)/dt of the fluid in the bed, a function of the nodes: `rate` (kg/m3/s), for the flow of each time step.

    `density(T)` gives that of a temperature (K), which begins as the function `temperature`. `counted` (kg/m3) is the density
    down to which the flow has carried the fluid away. A step's rate is that to the temperature extrapolated to its end; what an
    earlier one was off by follows with it, so that the mass is conserved in the long run and the flow is of second order.
    """

    def __init__(self, temperature: fem.Function, density: Callable[[Floats], Value]) -> None:
        self._density = density
        self.rate, self.counted = (fem.Function(temperature.function_space) for _ in range(2))
        self.counted.x.array[:] = density(temperature.x.array)

    def follow(self, present: Floats, ahead: Floats, step: float, last_step: float, *, flows: bool) -> None:
        """Take the rate of a `step` (s) from the `present` temperatures (K) to those `ahead`, after one of `last_step` (s): what
        that was off by follows in no less time. Nothing where nothing `flows`."""
        counted, now, then = self.counted.x.array, self._density(present), self._density(ahead)
        if not flows:
            self.rate.x.array[:], counted[:] = 0.0, then
            return
        change = (then - now) / step + (now - counted) / max(step, last_step)
        self.rate.x.array[:] = -change
        counted += change * step

    def missed(self, end: Floats) -> Floats:
        """By how much (kg/m3) the density at a step's `end` (K) is beyond that which its flow was for."""
        return self._density(end) - self.counted.x.array
