"""Heat, work and energy of a run up to its answer, and how far its heat balance is off."""

from typing import Any

import numpy as np

from ..output.quantities import JOULES_A_KWH
from .energy_use import energy_use
from .time_integration import Simulation

SPENT = ("fluid_heat", "pumping_work", "energy_spent", "mean_power")


def spent_of(simulation: Simulation) -> dict[str, float | None]:
    """Heat, work and mean power; None of a run that has not begun."""
    recorder, problem, specs = simulation.recorder, simulation.problem, simulation.specs
    spent: dict[str, float | None] = dict.fromkeys(SPENT)
    if not len(recorder.history):
        return spent
    spent |= energy_use(
        recorder.history,
        specs.laws.fluid,
        outlet_pressure=specs.flow.outlet_pressure,
        initial_temperature=specs.heat.initial_temperature,
        end=recorder.answered_at if problem.air_loop is None else recorder.ended_at,
        jumps=() if specs.course is None else specs.course.ends,
    )
    if problem.air_loop is not None:
        spent |= _spent_by_the_supply(simulation, spent["pumping_work"])
    return spent


def imbalance_of(simulation: Simulation) -> float:
    """Of the heat, as a fraction of the largest that was moved, set free or stored (collective)."""
    problem, history = simulation.problem, simulation.recorder.history
    set_free = problem.heat_kept()["cure"] if problem.heat.curing else 0.0
    stored = float(np.max(np.abs(history["heat_stored"]))) if len(history) else 0.0
    return problem.heat.balance.imbalance_beside(max(abs(set_free), stored))


def _spent_by_the_supply(simulation: Simulation, ideal_work: float | None) -> dict[str, float]:
    """What heater and blower gave what is computed until the answer, or the end of the run; of a given pressure drop the ideal
    work."""
    air_loop, ended_at = simulation.problem.air_loop, simulation.recorder.ended_at
    assert air_loop is not None
    given = {name: value / air_loop.spec.share for name, value in _tool_energy(simulation).items()}
    work = given["blower"] if air_loop.spec.blower is not None else float(ideal_work or 0.0)
    spent = given["heater"] + work
    return {
        "fluid_heat": given["heater"],
        "pumping_work": work,
        "energy_spent": spent,
        "mean_power": spent / ended_at if ended_at > 0.0 else 0.0,
    }


def _tool_energy(simulation: Simulation) -> dict[str, float]:
    """Energies (J) of the whole tool by source and use up to the answer (collective)."""
    recorder = simulation.recorder
    assert recorder.tool_energy is not None
    if len(recorder.history) < 2:
        return recorder.tool_energy.until(1.0)
    begun, end = recorder.history["time"][-2:]
    return recorder.tool_energy.until((recorder.ended_at - begun) / (end - begun) if end > begun else 1.0)


def energy_of_the_tool(simulation: Simulation) -> dict[str, Any]:
    """What heater and blower gave to the whole tool up to the answer and where it went (J), the largest power (W), and the
    cost (collective)."""
    problem, history = simulation.problem, simulation.recorder.history
    assert problem.air_loop is not None
    energy: dict[str, Any] = dict(_tool_energy(simulation))
    spec, spent = problem.air_loop.spec, energy["heater"] + energy["blower"]
    powers = np.array(history["heater_power"]) + np.array(history["blower_power"])
    energy |= {
        "peak_power": float(np.max(powers)),
        "until": simulation.recorder.ended_at if len(history) else 0.0,
        "share": spec.share,
        "loop_imbalance": problem.heat.balance.loop_imbalance,
        "spent": spent,
        "cost": None if spec.price is None else spec.price * spent / JOULES_A_KWH,
    }
    return energy
