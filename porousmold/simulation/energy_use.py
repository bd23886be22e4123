r"""What heating costs: the heat that the fluid is given before it enters, and the work of driving it through the bed.

The heat Q = int m |h(T_in) - h(T_0)| dt brings the mass flow m from the initial to the inlet temperature (thesis eq. 8.13 with
C constant); what leaves the outlet warm is lost. The work W = int m w dt is that of an ideal blower that brings the fluid from
the outlet's pressure to the inlet's state (w by `laws.compression`, dp/rho_in of a liquid, and of a gas where dp is small): a
real one needs more by its efficiency. Both up to the answer of a run (its last target, or its heating time).
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ..arrays import Floats
from ..laws.compression import isentropic_work
from ..laws.materials import Fluid
from ..output.quantities import Columns


def pumping_power(
    fluid: Fluid, outlet_pressure: float, mass_flow: Floats, pressure_drop: Floats, inlet: Floats
) -> Floats:
    """Power (W) that brings mass flows (kg/s) from the outlet's absolute pressure (Pa) over the pressure drops (Pa, signed as the
    mass flows) to the temperatures (K) that they enter with: what an ideal expansion through the bed would give back."""
    drop = pressure_drop * np.sign(mass_flow)
    return -np.abs(mass_flow) * np.asarray(isentropic_work(fluid, outlet_pressure + drop, inlet, -drop))


def energy_use(
    history: Mapping[str, Sequence[float]] | Columns,
    fluid: Fluid,
    *,
    outlet_pressure: float,
    initial_temperature: float,
    end: float | None = None,
    jumps: Sequence[float] = (),
) -> dict[str, float]:
    """{"fluid_heat": J, "pumping_work": J, "energy_spent": J of both, "mean_power": W} of a run up to a time `end` (s), or all.

    history: columns time (s), mass_flow (kg/s), pressure_drop (Pa), inlet_temperature (K). The trapezoidal rule over the steps;
    in a step from one of the `jumps` (s), where a phase ends and what is given changes at once, the rate at its end.
    """
    time, mass_flow, pressure_drop, inlet = (
        np.array(history[name]) for name in ("time", "mass_flow", "pressure_drop", "inlet_temperature")
    )
    enthalpy = fluid.heat_capacity.integral
    heat_rate = np.abs(mass_flow) * np.abs(enthalpy(inlet) - enthalpy(initial_temperature))
    until = time[-1] if end is None else end
    after_jump = np.isin(np.append(time[:1], time[:-1]), jumps)

    def integral(rate: Floats) -> float:
        # the trapezoidal rule by hand: every run would import scipy.integrate for it alone
        steps = np.diff(time, prepend=time[0])
        middles = 0.5 * (rate + np.where(after_jump, rate, np.append(rate[:1], rate[:-1])))
        return float(np.interp(until, time, np.cumsum(steps * middles)))

    heat, work = integral(heat_rate), integral(pumping_power(fluid, outlet_pressure, mass_flow, pressure_drop, inlet))
    spent = heat + work
    return {
        "fluid_heat": heat,
        "pumping_work": work,
        "energy_spent": spent,
        "mean_power": spent / until if until > 0.0 else 0.0,
    }
