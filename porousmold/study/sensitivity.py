r"""Elasticities of the heating time at a scene: what shortens it, and by how much.

The elasticity of t to a parameter p is d ln t/d ln p, the per cent of t for a per cent of p. It is taken by central
differences of the logarithms, e = [ln t(p (1 + h)) - ln t(p/(1 + h))]/[2 ln(1 + h)], of the order h^2; the relative
discretisation error, nearly the same in both runs, hardly enters: with 0.7 of the scene's cells in each direction and half its
steps elasticities are those of the scene to 0.008 (aluminium mold; in half the time). Temperatures count as the difference of
inlet and initial temperature, which drives everything; so do the other temperatures that a scene gives.

Parameters are every quantity that the scene gives, and `PARAMETERS` that it has without giving them.
"""

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..files.atomic_files import output_file
from ..scene.chosen_laws import Laws
from ..scene.features import KEYS
from ..scene.keys import WITHOUT_UNIT, key_of
from ..scene.scene import Scene
from .definition import Case, Study
from .parameters import case_around, phase_values, scaled, value_of
from .quantity import Quantity, quantity_of
from .running import IN_DOUBT, run_study

PARAMETERS = (
    "bed.bead_density", "bed.bead_heat_capacity", "bed.bulk_porosity", "wall.density", "wall.heat_capacity", "wall.conductivity",
    "operation.pressure_drop", "operation.inlet_velocity", "operation.mass_flow", "operation.outlet_pressure",
    "operation.inlet_temperature", "operation.heating_margin", "model.exchange_factor",
)  # fmt: skip
"""What a scene has of a material, by a default, or of its phases."""
TABLES = ("geometry", "bed", "wall", "operation", "model")
"""Whose quantities are parameters where they are given."""
NO_PARAMETERS = (
    "operation.initial_temperature", "operation.gravity", "operation.end_time", "operation.energy_price",
    "operation.cycle_tolerance",
)  # fmt: skip
"""Given quantities that are none: what temperatures count from, a constant, and what limits or prices the answer."""
OF_LAYERS = ("thickness", "contact_resistance", "heat_capacity", "conductivity")
STEP = 0.05
COARSER = {"solver.mesh_refinement": 0.7, "solver.step_refinement": 0.5}
"""Factors on the scene's own refinements."""


@dataclass(frozen=True)
class Elasticity:
    """Of the quantity of interest to one parameter: `value`, or None and the `reason` why there is none; a `reason` beside a
    value says that it is of one side alone, or in doubt."""

    parameter: str
    value: float | None
    reason: str = ""


def _given_quantities(scene: Scene) -> list[str]:
    """Names of keys of `TABLES` that the scene gives, and whose values are numbers."""
    names = [(f"{table}.{name}", key) for table in TABLES for name, key in KEYS[table].items()]
    given = [name for name, key in names if key.kind not in WITHOUT_UNIT and scene.is_given(name)]
    return [name for name in given if name not in NO_PARAMETERS]


def _origin(scene: Scene, name: str) -> float:
    """What a parameter counts from: the initial temperature for temperatures."""
    return scene.operation.initial_temperature if key_of(KEYS, name).kind == "K" else 0.0


def not_varied(scene: Scene) -> list[str]:
    """Given numbers that are no parameters: what changes in time or is zero, thresholds of phases, properties of layers and of
    materials of the scene's own."""
    varied = parameters_of(scene)
    listed = [
        name
        for name in scene.given()
        if "[" in name
        and name.split(".")[0] in TABLES
        and key_of(KEYS, name).kind not in WITHOUT_UNIT
        and scene.value(name) is not None
        and not any(name in phase_values(scene, one) for one in varied)
    ]
    names = [*_given_quantities(scene), *listed]
    return [name for name in names if name not in varied] + [f"materials.{name}" for name in scene.materials]


def parameters_of(scene: Scene) -> dict[str, float]:
    """{name: value (SI)} of the parameters that the scene has, temperatures as differences from the initial one; of
    properties of materials, whose laws are scaled, the value in the middle."""
    laws, found = Laws.of(scene), dict[str, float]()
    layers = [f"{place}.{key}" for place in scene.layers for key in OF_LAYERS]
    phases = [f"operation.phase[{number}].duration" for number, _ in enumerate(scene.operation.phase or (), start=1)]
    for name in dict.fromkeys((*PARAMETERS, *_given_quantities(scene), *layers, *phases)):
        of_phases = [abs(one) for one in phase_values(scene, name).values()]
        table, value = name.split(".")[0], max(of_phases) if of_phases else value_of(scene, laws, name)
        without_wall = scene.model.wall in ("insulated", "fixed-temperature") or scene.geometry.kind == "mesh"
        if value is not None and value != _origin(scene, name) and not (table == "wall" and without_wall):
            found[name] = value
    if scene.bed.porosity_profile is not None:
        found.pop("bed.bulk_porosity")
    return found


def coarser(scene: Scene) -> Scene:
    """The scene on `COARSER` cells and steps, where it does not ask for an accuracy of its own; a mesh stays as it is, and so do
    phases, whose number and ends depend on them."""
    if scene.solver.accuracy is not None or scene.operation.phase:
        return scene
    chosen = {name: factor * scene.value(name) for name, factor in COARSER.items()}
    if scene.geometry.kind == "mesh":
        chosen.pop("solver.mesh_refinement")
    return scene.changed(chosen)


def cases_around(scene: Scene, step: float = STEP) -> list[Case]:
    """The cases whose heating times give the elasticities: a higher and a lower value of every parameter."""
    scene, cases = coarser(scene), []
    for name, value in parameters_of(scene).items():
        for side, factor in (("up", 1.0 + step), ("down", 1.0 / (1.0 + step))):
            values = phase_values(scene, name) or {name: value}
            origin = _origin(scene, name)
            changed: dict[str, float | str] = {
                key: scaled(scene, key, float(one), factor)
                if origin == 0.0
                else float(origin + (one - origin) * factor)
                for key, one in values.items()
            }
            cases.append(case_around(scene, f"{name},{side}", changed))
    return cases


def elasticities(
    scene: Scene,
    out: Path,
    quantity: Quantity | None = None,
    *,
    step: float = STEP,
    progress: Any = None,
    stop: Callable[[], bool] = lambda: False,
) -> list[Elasticity] | None:
    """Run what is missing in `out` and give the `Elasticity` of a quantity (default: `quantity_of`) to every parameter, largest
    first (collective); None where it was stopped. Raises `InputError` where the scene itself has none.

    Writes elasticities.json beside the tables of the study.
    """
    quantity = quantity or quantity_of(scene, None)
    (given,) = run_study(Study([case_around(coarser(scene), "as given", {})], [], [quantity.record]), out, stop=stop)
    if given.status in ("done", "refused", "failed") and quantity.in_row(given, given) is None:
        raise quantity.no_answer(scene, quantity.reason(given, given))
    study = Study(cases_around(scene, step), [], [quantity.record])
    rows = run_study(study, out, progress=progress, stop=stop)
    if any(row.status == "missing" for row in (given, *rows)):
        return None
    here, found = quantity.in_row(given, given), []
    for pair in zip(rows[::2], rows[1::2], strict=True):
        name = pair[0].case.name.rsplit(",", 1)[0]
        up, down = (quantity.in_row(row, given) for row in pair)
        lacking = "; ".join(quantity.reason(row, given) for row in pair if quantity.in_row(row, given) is None)
        steps, (high, low) = 2 - (up is None) - (down is None), (up or here, down or here)
        value = math.log(high / low) / (steps * math.log(1.0 + step)) if steps and high and low else None
        doubt = "in doubt (table.csv says why)" if any(IN_DOUBT.search(row.reason) for row in pair) else ""
        reason = f"of one side alone: {lacking}" if value is not None and lacking else lacking or doubt
        found.append(Elasticity(name, value, reason))
    return sorted(found, key=lambda entry: -abs(entry.value or 0.0))


def write(found: Any, out: Path, quantity: Quantity) -> Path:
    """elasticities.json, and the tornado picture; gives the picture's path."""
    from ..output.figures import STYLE, plt, save

    content = {entry.parameter: entry.value for entry in found}
    with output_file(out / "elasticities.json") as temporary:
        temporary.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    shown = [entry for entry in found if entry.value is not None][::-1]
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(8.0, 0.9 + 0.34 * len(shown)))
        figure.subplots_adjust(left=0.33, right=0.97, bottom=0.75 / (0.9 + 0.34 * len(shown)), top=0.97)
        colours = ["tab:red" if entry.value > 0.0 else "tab:green" for entry in shown]
        axes.barh([entry.parameter for entry in shown], [entry.value for entry in shown], color=colours)
        axes.axvline(0.0, color="k", linewidth=0.8)
        axes.set_xlabel(f"per cent of {quantity.words} for one per cent of the parameter")
        axes.grid(axis="y", visible=False)
        return save(figure, out / "tornado.png")
