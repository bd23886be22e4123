"""Two named sets of closures: the thesis's, and those that measurements support.

| key                     | `thesis`                 | `measured`                 |
|-------------------------|--------------------------|----------------------------|
| `model.bead_conduction` | bulk                     | zehner-bauer-schluender    |
| `model.dispersion`      | none                     | winterberg-tsotsas-axial   |
| `model.drag`            | macdonald                | kta                        |
| `model.turbulence`      | damped-nakayama-kuwahara | decaying-nakayama-kuwahara |
| `bed.porosity_model`    | hunt-tien                | hunt-tien-spheres          |
| `bed.bulk_porosity`     | 0.4                      | 0.383                      |
| `fluid.material`        | thesis_air               | air                        |

Measured: a bed at rest conducts a fifth of the bulk's (ceramic beads in air) to a fiftieth (steel); heat crosses a flow by
mixing even where it is laminar; the inertial drag falls with the Reynolds number; poured spheres have this mean void fraction
(Dixon; Benyahia and O'Neill); a front widens by dispersion along the flow, with which the exchange between fluid and beads was
evaluated (Wakao); the thesis's air conducts 2.5 % less at 300 K and 6.3 % more at 600 K than tables have. Not
measured, but needed for one answer whatever the flow's history: turbulence that decays between beads whose own flow is laminar
(`laws.turbulence_models`).

A set gives the values of keys that the scene leaves open; a key that is set wins, and the run says so. `docs/validation.md` holds
both against measurements.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from .keys import Settings, Tables

if TYPE_CHECKING:
    from .scene import Scene

THESIS = "thesis"
CLOSURES: Mapping[str, Mapping[str, object]] = {
    THESIS: {
        "model.bead_conduction": "bulk",
        "model.dispersion": "none",
        "model.drag": "macdonald",
        "model.turbulence": "damped-nakayama-kuwahara",
        "bed.porosity_model": "hunt-tien",
        "bed.bulk_porosity": 0.4,
        "fluid.material": "thesis_air",
    },
    "measured": {
        "model.bead_conduction": "zehner-bauer-schluender",
        "model.dispersion": "winterberg-tsotsas-axial",
        "model.drag": "kta",
        "model.turbulence": "decaying-nakayama-kuwahara",
        "bed.porosity_model": "hunt-tien-spheres",
        "bed.bulk_porosity": 0.383,
        "fluid.material": "air",
    },
}


def completed(tables: Tables) -> Settings:
    """The tables of a scene with what its set of closures gives where they leave it open."""
    result = dict(tables)
    chosen = tables.get("model", {}).get("closures", THESIS)
    for full_name, value in (CLOSURES.get(chosen, {}) if isinstance(chosen, str) else {}).items():
        table, name = full_name.split(".")
        given = {key: entry for key, entry in result.get(table, {}).items() if entry is not None}
        result[table] = {name: value, **given}
    return result


def departures(scene: "Scene") -> Settings:
    """{"table.key": value} of what a scene has otherwise than its set of closures; a fluid that is no air is no departure."""
    values = {name: _value(scene, name) for name in CLOSURES[scene.model.closures]}
    if values["fluid.material"] not in {closures["fluid.material"] for closures in CLOSURES.values()}:
        del values["fluid.material"]
    if scene.bed.porosity_profile is not None:
        values |= {"bed.porosity_model": "bed.porosity_profile", "bed.bulk_porosity": scene.porosity.bulk_porosity}
    if scene.conductivity_profile is not None:
        values["model.bead_conduction"] = "bed.conductivity_profile"
    return {name: value for name, value in values.items() if value != CLOSURES[scene.model.closures][name]}


def _value(scene: "Scene", full_name: str) -> Any:
    table, name = full_name.split(".")
    return getattr(getattr(scene, table), name)
