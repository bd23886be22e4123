"""What a scene may have: a room for each feature, and the loops over all of them."""

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING

from ...errors import InputError
from ..keys import Key
from .air_loop import AirLoop
from .bed import AveragingVolume, Beads, BedPorosity, Stirring
from .drive import Drive
from .energy_model import EnergyModel
from .extensions import Extensions
from .feature import Feature
from .flow_model import FlowModel
from .fluid import BedFluid
from .inlet import AtStart, Inflow
from .moving_beads import BeadMotion
from .numerics import Accuracy, Cells, TimeSteps
from .outer_wall import OuterWall
from .output import Output
from .own_mesh import OwnMesh
from .phases import Reversal
from .sensors import Sensors
from .straight_bed import StraightBed
from .targets import Heated, Targets
from .tolerances import Tolerances
from .wall import BedWall

if TYPE_CHECKING:
    from ..scene import Scene

FEATURES: tuple[type[Feature], ...] = (
    *(
        StraightBed,
        OwnMesh,
        Beads,
        BedPorosity,
        Stirring,
        AtStart,
        Inflow,
        Reversal,
        Drive,
        AirLoop,
        FlowModel,
        EnergyModel,
    ),
    *(AveragingVolume, BedWall, Sensors, BeadMotion, OuterWall, Heated, Accuracy, Cells, TimeSteps, BedFluid, Targets),
    *(Tolerances, Extensions, Output),
)
"""In the order in which a user fills in a scene, which is also that of the checks."""
TABLES = (
    *(
        "geometry",
        "bed",
        "wall",
        "fluid",
        "operation",
        "model",
        "solver",
        "target",
        "tolerance",
        "extensions",
        "output",
    ),
)
"""Of a scene, in the order in which they are written."""


def _keys() -> dict[str, dict[str, Key]]:
    found: dict[str, dict[str, Key]] = {table: {} for table in TABLES}
    for feature in FEATURES:
        for full_name, key in feature.keys().items():
            table, _, name = full_name.partition(".")
            if name in found[table]:
                raise ValueError(f"{full_name} belongs to two features")
            found[table][name] = key
    return found


KEYS: Mapping[str, Mapping[str, Key]] = _keys()
"""{table: {name: key}} of a scene."""


def check_together(scene: "Scene") -> None:
    """The rules of every feature: raises `InputError` where values do not go together."""
    for feature in FEATURES:
        feature.of(scene).check(scene)


def require_used(scene: "Scene", used: Collection[str], what: str) -> None:
    """Raise `InputError` for a key with another value than its default that is not among those `used`, such as
    "operation.mass_flow" or, of tables in a list, "wall.layer.thickness"; `what` is on which it would have no effect."""
    allowed = f"has no effect on {what}"
    for table, keys in KEYS.items():
        for name, key in keys.items():
            full_name = f"{table}.{name}"
            if full_name not in used and scene.differs_from_default(full_name):
                scene.refuse(full_name, allowed, value=str(scene.value(full_name)))
            for number, entry in enumerate((scene.value(full_name) or ()) if key.entries else (), start=1):
                for part, value in entry:
                    if f"{full_name}.{part}" not in used and value != key.entries[part].default:
                        raise InputError(f"{full_name}[{number}].{part}", str(value), allowed, scene.source)
