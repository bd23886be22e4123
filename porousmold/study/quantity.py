"""The quantity of interest of a study of one scene: the heating time, a target's time, or any positive number of a result."""

from dataclasses import dataclass

from ..errors import InputError
from ..scene.features.targets import target_name
from ..scene.scene import Scene
from .definition import RECORDS, unit_of_record

KEY = "--of"


@dataclass(frozen=True)
class Quantity:
    """An entry of result.json by its name, such as "targets.cured" or "energy.cost", and its SI unit."""

    record: str
    unit: str

    @property
    def words(self) -> str:
        """What it is called in a sentence."""
        if self.record.startswith("targets."):
            return f"time of target {self.record.removeprefix('targets.')!r}"
        return self.record.replace("_", " ").replace(".", ", ")

    @property
    def is_time(self) -> bool:
        """Whether it grows where things are slower."""
        return self.unit == "s"

    def text(self, value: float) -> str:
        """A value with its unit."""
        return (
            f"{value:.0f} s" if self.unit == "s" and value >= 100.0 else f"{value:.5g} {self.unit}".removesuffix(" 1")
        )

    def no_answer(self, scene: Scene, reason: str) -> InputError:
        """The refusal of a scene that has none."""
        return InputError("SCENE", scene.source, f"has no {self.words}: {reason}")


def quantity_of(scene: Scene, record: str | None) -> Quantity:
    """That of a name; without one the time of the first target of a scene that has targets, else the heating time.

    Raises `InputError` for what no run records.
    """
    targets = [target_name(target) for target in scene.target.list or ()]
    if record is None:
        record = f"targets.{targets[0]}" if targets else "heating_time"
    unit = unit_of_record(record)
    if unit is None:
        raise InputError(KEY, record, f"must be of {', '.join(RECORDS)}, or targets.NAME")
    name = record.removeprefix("targets.")
    if name != record and name not in targets:
        known = f"its targets are {', '.join(targets)}" if targets else "it has no [[target]]"
        raise InputError(KEY, record, f"is no target of the scene: {known}", scene.source)
    if record == "heating_time" and scene.model.wall == "fixed-temperature":
        raise InputError(
            "model.wall", scene.model.wall, "leaves no heating time: give another record by --of", scene.source
        )
    return Quantity(record, unit)
