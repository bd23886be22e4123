"""A feature of a scene: one frozen dataclass whose fields carry their keys, with the rules that its values must obey together.

    class Stirring(Feature):
        shear_rate: float = key("bed.shear_rate", "1/s", "shear rate of the bed", 0.0, low=0.0, closed=True)

`Stirring.of(scene)` has the values of a scene in SI. The schema, its page, the JSON schema and the checks are loops over
`features.FEATURES`; nothing else lists keys.
"""

from collections.abc import Collection
from dataclasses import field, fields
from typing import TYPE_CHECKING, Any, Self

from ...laws.material_library import SOLIDS
from ..keys import Key

if TYPE_CHECKING:
    from ..scene import Scene

FULL_NAME, KEY = "full name", "key"
OWN_MATERIAL = "a material of your own, [materials.NAME]"


def key(full_name: str, kind: str, meaning: str, default: object = None, **rules: Any) -> Any:
    """The field of a `Key`, which stands in a scene as "table.name"; of a list of tables, [[target]], as "target.list"."""
    return field(default=default, metadata={FULL_NAME: full_name, KEY: Key(kind, meaning, default, **rules)})


def choice(full_name: str, meaning: str, choices: Collection[str], default: object = None, **rules: object) -> Any:
    """The field of a key that takes one of some names."""
    return key(full_name, "choice", meaning, default, choices=choices, **rules)


def measure(full_name: str, meaning: str) -> Any:
    """The field of a key that takes a length."""
    return key(full_name, "m", meaning, low=0.0, high=1e4)


def solid(full_name: str, meaning: str, default: str | None = None) -> Any:
    """The field of a key that names a solid."""
    return choice(full_name, meaning, SOLIDS, default, else_allowed=OWN_MATERIAL)


def own_property(full_name: str, kind: str, meaning: str) -> Any:
    """The field of a key that is a property in place of the material's, or a part of that."""
    return key(full_name, kind, meaning, low=0.0, high=1e7, of_law=True)


class Feature:
    """What all features share; they are dataclasses, whose fields are made by `key`."""

    @classmethod
    def keys(cls) -> dict[str, Key]:
        """Every key by its full name."""
        return {one.metadata[FULL_NAME]: one.metadata[KEY] for one in fields(cls)}

    @classmethod
    def of(cls, scene: "Scene") -> Self:
        """With the values (SI) of a scene."""
        return cls(**{one.name: scene.value(one.metadata[FULL_NAME]) for one in fields(cls)})

    def check(self, scene: "Scene") -> None:
        """Raise `InputError` where values do not go together, with each other or with those of other features."""
