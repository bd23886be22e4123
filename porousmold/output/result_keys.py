"""Every key of result.json: unit, meaning, and a JSON Schema of the file."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from ..scene.json_schema import DIALECT

Summary: TypeAlias = Mapping[str, Any]
"""What result.json holds."""


@dataclass(frozen=True)
class ResultKey:
    """`kind` is a type of JSON, `unit` the SI unit of a number. An `optional` one may be null."""

    kind: str
    meaning: str
    unit: str = ""
    optional: bool = False


def _number(unit: str, meaning: str, *, optional: bool = False) -> ResultKey:
    return ResultKey("number", meaning, unit, optional)


RESULT_KEYS: Mapping[str, ResultKey] = {
    "status": ResultKey("string", "done, failed or interrupted"),
    "failure": ResultKey("string", "reason of the failure: time, equations, residuals, advice", optional=True),
    "heating_time": _number(
        "s",
        "time at which all of operation.heated_place is within operation.heating_margin of the inlet temperature, or by heat "
        "from elsewhere beyond all temperatures given until then",
        optional=True,
    ),
    "has_heating_time": ResultKey(
        "boolean",
        "whether the run has one: not where the wall is held at its temperature, what flows in is as warm as the start, or "
        "phases turn the flow",
    ),
    "heating_time_error": _number(
        "1",
        "estimated relative error of the discretisation with solver.accuracy; else, where answers are in doubt (a front "
        "stands in the bed at the end, a cure gets hot, fingers form, a mesh has few cells), the difference from a coarser run",
        optional=True,
    ),
    "target_errors": ResultKey("object", "the same of each target's time"),
    "peak_errors": ResultKey(
        "object",
        "the same of the highest temperature of each layer that cures, of its rise above the lowest of the run",
    ),
    "end_errors": ResultKey(
        "object",
        "the same of each temperature at the end, over the largest difference of the run, and of the heat stored, of a run that "
        "gives no heating time and meets no target",
    ),
    "heating_time_bed_side": _number("s", "heating time of the bed side of the wall alone", optional=True),
    "targets": ResultKey("object", "time (s) at which each target was met, or null"),
    "targets_kept": ResultKey(
        "object",
        "of each target that was met: first met, lost (s, or null), kept_from (s; null where it does not hold at the end)",
    ),
    "target_meanings": ResultKey("object", "each target in words"),
    "end_time": _number("s", "end of the run"),
    "mass_flow_initial": _number("kg/s", "initial mass flow into the modelled part", optional=True),
    "mass_flow_final": _number("kg/s", "final mass flow into the modelled part", optional=True),
    "mass_flow_error": _number(
        "1",
        "estimated relative error of the mass flow (of the pressure drop where the flow is given) on a mesh of one's own whose "
        "cells are coarse where the flow gathers: about the largest that it may be",
        optional=True,
    ),
    "pressure_drop_initial": _number("Pa", "initial pressure drop of the bed", optional=True),
    "pressure_drop_final": _number("Pa", "final pressure drop of the bed", optional=True),
    "mass_imbalance": _number("1", "(in - out)/out of the mass flow at the end", optional=True),
    "energy_imbalance": _number("1", "relative imbalance of the heat balance"),
    "energy_rev_residual": _number("1", "heat created by the REV terms, relative to the heat from the fluid"),
    "heat_by_fluid": _number(
        "J", "heat transferred from the fluid to bed and wall; of a fluid that expands, from the initial temperature on"
    ),
    "heat_stored": _number("J", "heat stored in fluid, beads and wall, less what a cure has set free"),
    "fluid_heat": _number(
        "J",
        "heat to bring the fluid from initial to inlet temperature up to the answer, or the end (of a run that starts from "
        "a state or a profile its mean counts as initial); with a heater, blower or "
        "returned air what the heater gave up to the end. Of the modelled part, as the next three",
        optional=True,
    ),
    "pumping_work": _number(
        "J",
        "ideal work (of a gas isentropic) from the outlet's pressure to the inlet's state, by the static pressure drop (with "
        "operation.gravity the weight of the fluid's column is in it); with a blower what that took, its efficiency included",
        optional=True,
    ),
    "energy_spent": _number("J", "fluid_heat plus pumping_work", optional=True),
    "mean_power": _number("W", "energy_spent over the time that it is of", optional=True),
    "cycles": ResultKey(
        "array", "cycles of [[operation.phase]] that are through: heat, work, efficiencies, and their phases"
    ),
    "last_cycle": ResultKey(
        "object",
        "the last of them, without its phases, and whether it is_periodic (null if not asked)",
        optional=True,
    ),
    "energy": ResultKey(
        "object",
        "energy (J) of the whole tool by source and use, spent (of heater and blower), until when (s: the answer, or the end), "
        "peak_power (W), share (the tool over the modelled part), cost and its currency",
        optional=True,
    ),
    "spread_at_end": _number(
        "K",
        "difference of temperature over the wall's bed side when the last of what was asked for is met, or at the end",
        optional=True,
    ),
    "layers_at_end": ResultKey("object", "lowest and highest temperature (K) of each layer of the wall at the end"),
    "temperature_bounds": ResultKey("array", "lowest and highest temperature (K)", optional=True),
    "time_steps": ResultKey("integer", "time steps"),
    "rejected_steps": ResultKey("integer", "time steps repeated with a smaller step size"),
    "repeated_steps": ResultKey(
        "integer", "time steps whose energy solve was repeated to keep temperatures within bounds"
    ),
    "flow_regimes": ResultKey(
        "array",
        "laminar or turbulent: the flow at the start, the other one if it is steady there, too, or occurred later",
    ),
    "flow_solves": ResultKey("integer", "solves of the flow"),
    "flow_strategies": ResultKey(
        "object",
        "how often each strategy found a flow, or was given up: reused or renewed Jacobian, Newton's method, false transient "
        "(careful from a flow that is near), continuation in a parameter of the turbulence model",
    ),
    "continuation_steps": ResultKey("integer", "pseudo-time steps of the flow solver (false transient)"),
    "newton_iterations": ResultKey("object", "of flow and energy"),
    "unknowns": ResultKey("object", "of flow and energy"),
    "bead_biot_number": _number("1", "h R/(3 lambda_s), estimated"),
    "bead_reynolds_number": _number("1", "superficial, estimated"),
    "refinements": ResultKey(
        "object",
        "factors on the default number of cells along and across the flow, and of steps, that the result is of",
    ),
    "date": ResultKey("string", "date and time of the run, ISO 8601"),
    "model": ResultKey("object", "the table [model] with every default"),
    "closures": ResultKey("object", "set of closures, and the keys that differ from it"),
    "sources": ResultKey("object", "source of every closure"),
    "materials": ResultKey("object", "materials used: value at the mean temperature, unit and source of each property"),
    "versions": ResultKey("object", "versions of the libraries used, and the number of ranks"),
    "warnings": ResultKey("array", "warnings of this run, such as exceeded limits of the model"),
    "identity": ResultKey("string", "digest of the scene, its files, its laws and the code that computes"),
    "given": ResultKey("object", "keys that are set in the scene, as written"),
    "wall_seconds": ResultKey("object", "wall-clock time in total and by task"),
    "checksum": ResultKey("string", "SHA-256 of this content and of history.csv; in the file alone"),
}


def result_schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of result.json."""
    properties = {
        name: {
            "type": [key.kind, "null"] if key.optional else key.kind,
            "description": f"{key.meaning} [{key.unit}]" if key.unit else key.meaning,
        }
        for name, key in RESULT_KEYS.items()
    }
    return {
        "$schema": DIALECT,
        "title": "Result of a run of porousmold",
        "type": "object",
        "properties": properties,
        "required": list(RESULT_KEYS),
        "additionalProperties": False,
    }


def reference() -> str:
    """Markdown page of every key of result.json."""
    rows = [
        f"| {name} | {key.unit or key.kind} | {key.meaning}{' (may be null)' if key.optional else ''} |"
        for name, key in RESULT_KEYS.items()
    ]
    head = ["# Keys of a result", "", "Written by `porousmold keys --result`: the content of `result.json`."]
    return "\n".join([*head, "", "| key | unit or kind | meaning |", "|---|---|---|", *rows]) + "\n"
