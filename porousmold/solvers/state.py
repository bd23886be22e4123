"""The state of a simulation: functions and numbers by name. One list for all that is done with it: copied before a step and put
back, kept as a snapshot, extrapolated, and written to a checkpoint."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol, TypeAlias

from dolfinx import fem

from ..arrays import Floats
from ..mesh.aliases import Space

SavedNumbers: TypeAlias = dict[str, Any]
"""Numbers and texts of a part by name, ready for JSON."""
Arrays = dict[str, Floats]
"""Of functions, by their names."""
ArrayOf = Callable[[str, Space], Floats]
"""Gives the local array of a saved name and its function space (collective)."""


@dataclass
class Saved:
    """What a checkpoint holds of a part of a simulation: `numbers` ready for JSON, `arrays` by name, with their spaces."""

    numbers: SavedNumbers = field(default_factory=dict)
    arrays: dict[str, tuple[Space, Floats]] = field(default_factory=dict)


class Stateful(Protocol):
    """A part of a simulation that saves and restores itself."""

    def save(self) -> Saved:
        """Everything that it goes on from."""

    def restore(self, numbers: SavedNumbers, array_of: ArrayOf) -> None:
        """Go on from what `save()` gave."""


class Numbers(Protocol):
    """Anything whose numbers belong to a state."""

    def save(self) -> SavedNumbers:
        """Its numbers, ready for JSON: a copy."""

    def restore(self, numbers: SavedNumbers) -> None:
        """Go on from what `save()` gave."""


class Copy(NamedTuple):
    """Of a state: the arrays of its functions, and its numbers."""

    arrays: Arrays
    numbers: dict[str, SavedNumbers]


class State:
    """Functions and numbers by name."""

    def __init__(self, functions: Mapping[str, fem.Function], numbers: Mapping[str, Numbers] | None = None) -> None:
        self.functions, self._numbers = dict(functions), dict(numbers or {})

    @classmethod
    def joined(cls, parts: Mapping[str, "State"]) -> "State":
        """Of the functions of parts, which get the part's name before their own."""
        return cls({f"{name}/{one}": f for name, part in parts.items() for one, f in part.functions.items()})

    def copy(self) -> Copy:
        """As it is now."""
        return Copy(self.arrays(), {name: part.save() for name, part in self._numbers.items()})

    def put_back(self, copy: Copy) -> None:
        """Go back to what `copy()` gave."""
        self.set(copy.arrays)
        for name, part in self._numbers.items():
            part.restore(copy.numbers[name])

    def arrays(self) -> Arrays:
        """Copies of the arrays of its functions."""
        return {name: function.x.array.copy() for name, function in self.functions.items()}

    def set(self, arrays: Arrays) -> None:
        """Give its functions the values of arrays, of which there may be more."""
        for name, function in self.functions.items():
            function.x.array[:] = arrays[name]

    def save(self) -> Saved:
        """For a checkpoint."""
        return Saved({name: part.save() for name, part in self._numbers.items()}, self.spaces_of(self.arrays()))

    def restore(self, numbers: SavedNumbers, array_of: ArrayOf) -> None:
        """Go on from what `save()` gave (collective)."""
        self.set(self.read(array_of))
        for name, part in self._numbers.items():
            part.restore(numbers[name])

    def spaces_of(self, arrays: Arrays, prefix: str = "") -> dict[str, tuple[Space, Floats]]:
        """Arrays of its functions for a checkpoint, under names with a prefix."""
        return {f"{prefix}{name}": (f.function_space, arrays[name]) for name, f in self.functions.items()}

    def read(self, array_of: ArrayOf, prefix: str = "") -> Arrays:
        """What `spaces_of` gave, from a checkpoint (collective)."""
        return {name: array_of(f"{prefix}{name}", f.function_space) for name, f in self.functions.items()}
