"""What a scene has of a parameter that a study changes, and the cases around it."""

from collections.abc import Mapping

from ..errors import InputError
from ..scene.chosen_laws import Laws
from ..scene.features import KEYS
from ..scene.features.phases import drive_name
from ..scene.features.wall import name_of
from ..scene.keys import Part, key_of
from ..scene.scene import Scene
from .definition import OF_EVERY_CASE, Case, with_units


def value_of(scene: Scene, laws: Laws, name: str) -> float | None:
    """Value (SI) of the key "table.key", None where the scene has none or one that changes in time or from place to place.

    A property of the beads or the wall that is not given as a number is its material's, in the middle of initial and inlet
    temperature; `scaled` changes the law.
    """
    if name == "operation.initial_temperature" and scene.start is not None:  # its mean is not the scene
        return None
    value = scene.value(name)
    if hasattr(value, "values"):
        return float(value.values[0]) if len(value.values) == 1 else None
    middle = 0.5 * (scene.operation.initial_temperature + scene.operation.inlet_temperature.values[-1])
    layers = ((f"{place}.", laws.walls[name_of(layer)]) for place, layer in scene.layers.items())
    others = ("bed.bead_", laws.beads), ("wall.", laws.walls.get("wall")), ("fluid.", laws.fluid)
    for prefix, material in (*layers, *others):
        of_law = isinstance(value, Part) or (value is None and prefix != "fluid.")
        if of_law and name.startswith(prefix) and hasattr(material, name.removeprefix(prefix)):
            value = getattr(material, name.removeprefix(prefix))(middle)
    return None if value is None else float(value)


def scaled(scene: Scene, name: str, value: float, factor: float) -> float | str:
    """The setting of a key that multiplies its `value` (as of `value_of`) by a factor: of a property that is a law of its
    material that part of the law. A table that peaks where beads melt became its value at the middle, throughout."""
    given = scene.value(name)
    if not key_of(KEYS, name).of_law or isinstance(given, float):
        return factor * value
    return str(Part(factor if given is None else factor * given.factor))


def case_around(scene: Scene, name: str, settings: Mapping[str, object]) -> Case:
    """The case of a scene with other settings {"table.key": value}; with the reason where no scene can have them."""
    try:
        changes = {"bed.allow_small_ratio": True, **OF_EVERY_CASE, **with_units(settings)}
        return Case(name, dict(settings), scene.changed(changes))
    except InputError as error:
        return Case(name, dict(settings), None, str(error))


def phase_values(scene: Scene, name: str) -> dict[str, float]:
    """{key: value} of every phase that stands for the key "operation.inlet_temperature" or that of the drive; empty for other
    keys, and without phases."""
    drive = drive_name(scene.operation.phase or ())
    key = {"operation.inlet_temperature": "temperature", f"operation.{drive}": drive}.get(name)
    if key is None or scene.operation.phase is None:
        return {}
    numbered = enumerate(scene.operation.phase, start=1)
    return {
        f"operation.phase[{number}].{key}": value
        for number, phase in numbered
        if (value := getattr(phase, key)) is not None and value
    }
