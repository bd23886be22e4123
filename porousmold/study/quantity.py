"""The quantity of interest of a study of one scene: the heating time, a target's time, or any positive number of a result."""

from dataclasses import dataclass

from ..errors import InputError
from ..scene.features.air_loop import has_air_loop
from ..scene.scene import Scene
from .definition import RECORDS, target_names, unit_of_record
from .running import Row

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

    @property
    def is_answer(self) -> bool:
        """Whether it is what a run waits for, not something that is counted up to that."""
        return self.record == "heating_time" or self.record.startswith("targets.")

    def text(self, value: float) -> str:
        """A value with its unit."""
        return (
            f"{value:.0f} s" if self.unit == "s" and value >= 100.0 else f"{value:.5g} {self.unit}".removesuffix(" 1")
        )

    def in_row(self, row: Row, here: Row) -> float | None:
        """The positive value of a case beside that of the scene itself, None where there is none. What is no time is counted up
        to the answer of a run: where the scene reaches that, a case that does not has none, and the other way round."""
        if not self.is_answer and row.status == here.status == "done" and row.is_reached != here.is_reached:
            return None
        value = row.values[self.record]
        return value if value is not None and value > 0.0 else None

    def is_beyond(self, row: Row, here: Row) -> bool:
        """Whether a case has no value as it does not reach an answer that the scene itself does: its value is larger."""
        if row.status != "done" or self.in_row(row, here) is not None:
            return False
        return row.values[self.record] is None if self.is_answer else here.is_reached and not row.is_reached

    def reason(self, row: Row, here: Row) -> str:
        """Why `in_row` is None."""
        if row.reason:
            return row.reason
        if row.status == "done" and row.is_reached != here.is_reached:
            return "reaches what the scene itself does not"
        value = row.values[self.record]
        return "not reached" if value is None else f"{value:.6g} is not positive"

    def no_answer(self, scene: Scene, reason: str) -> InputError:
        """The refusal of a scene that has none."""
        return InputError("SCENE", scene.source, f"has no {self.words}: {reason}")


def check_record(scene: Scene, record: str, key: str) -> None:
    """Refuse (`InputError` of a `key`) what no run of the scene records, and heating times of runs that end when targets are met,
    be that before or after."""
    targets, name = target_names(scene), record.removeprefix("targets.")
    known = f"its targets are {', '.join(targets)}" if targets else "it has no [[target]]"
    if name != record and name not in targets:
        raise InputError(key, record, f"is no target of the scene: {known}", scene.source)
    if record.startswith("heating_time") and targets:
        allowed = f"is unknown where a run ends with its targets: take one of them ({known})"
        raise InputError(key, record, allowed, scene.source)
    if record.startswith("energy.") and not has_air_loop(scene):
        raise InputError(key, record, "needs a blower, a heater or returned air in the scene", scene.source)
    if record == "energy.cost" and scene.operation.energy_price is None:
        raise InputError(key, record, "needs operation.energy_price in the scene", scene.source)
    if record.startswith("last_cycle.") and scene.operation.phase is None:
        raise InputError(key, record, "needs [[operation.phase]] in the scene", scene.source)


def quantity_of(scene: Scene, record: str | None) -> Quantity:
    """That of a name; without one the time of the first target of a scene that has targets, else the heating time.

    Raises `InputError` for what no run records.
    """
    if record is None:
        targets = target_names(scene)
        record = f"targets.{targets[0]}" if targets else "heating_time"
    unit = unit_of_record(record)
    if unit is None:
        raise InputError(KEY, record, f"must be of {', '.join(RECORDS)}, or targets.NAME")
    check_record(scene, record, KEY)
    if record == "heating_time" and scene.model.wall == "fixed-temperature":
        raise InputError(
            "model.wall", scene.model.wall, "leaves no heating time: give another record by --of", scene.source
        )
    return Quantity(record, unit)
