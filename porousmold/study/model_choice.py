"""The cheapest model of a scene: only what its heating time needs (`porousmold simplify`). It is sought once for a family of
scenes: the runs on coarse cells cost about one run of the fullest model (docs/model-choice.md).

The fullest model has a two-dimensional flow that follows the temperature, its turbulence, temperatures of fluid and beads, also
inside the beads, and a resolved wall. Keys of [model] that the scene gives are kept; each other one is simplified in turn where

1. what is predicted of it (from a Biot number, the transfer units, the Reynolds number) does not rule it out, and
2. two runs on coarse cells, with and without what is left out, differ by no more than the rest of the wanted accuracy.

The differences that were accepted are added up, whatever their signs: their sum bounds what the chosen model is away from the
fullest one, as measured on the coarse cells. There the discretisation errors of two runs are nearly equal and cancel.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

from ..errors import InputError, SolveError
from ..scene.scene import Scene
from ..simulation.estimates import Estimates, estimate
from ..simulation.specs import specs_of

COARSE = 0.5
"""Of the cells in each direction and of the steps, in the runs that are compared."""
BEAD_MODES = 1
"""Of the fullest model: with one mode heating times are within 0.01 % of those with eight (docs/bead-interior.md)."""
LAMINAR_REYNOLDS_NUMBER = 150.0
"""Of the beads, below which the flow between them is laminar."""
HOPELESS = 1.5
"""Times the wanted accuracy: what is predicted to be worth more is kept without a run."""


@dataclass(frozen=True)
class Choice:
    """What may be left out: `key` = `value`, in words, whether it was, what that is worth and why.

    `worth` is the relative change of the heating time on coarse cells; None where no run was made for it.
    """

    key: str
    value: object
    leaves_out: str
    chosen: bool
    worth: float | None
    reason: str


@dataclass(frozen=True)
class ModelChoice:
    """The chosen scene, `accuracy` (wanted) and `worth` (of all that was left out), relative, and each `Choice`."""

    scene: Scene
    accuracy: float
    worth: float
    choices: tuple[Choice, ...]
    note: str = ""

    @property
    def text(self) -> str:
        """The keys of [model] that leave out what the heating time does not notice, and what was kept and why."""
        if self.note:
            return self.note
        left_out = [choice for choice in self.choices if choice.chosen]
        keys = {choice.key for choice in left_out}
        added = [one for one in self.choices if one.key not in keys and self.scene.is_given(one.key)]
        if not left_out:
            lines = [f"nothing can be left out within {self.accuracy:.2%} of the heating time"]
        else:
            lines = [
                f"changes the heating time by about {self.worth:.2%} (on coarse cells; allowed {self.accuracy:.2%}):"
            ]
        if left_out or added:
            lines.append("[model]")
        for choice in left_out:
            _, _, name = choice.key.partition(".")
            line = f'{name} = "{choice.value}"' if choice.value is not None else f"# no {name}"
            lines.append(f"{line:32s} # without {choice.leaves_out}: {choice.worth:+.2%}")
        for choice in added:
            line = f"{choice.key.partition('.')[2]} = {self.scene.value(choice.key)}"
            lines.append(f"{line:32s} # with {choice.leaves_out}")
        for choice in self.choices:
            if not choice.chosen:
                worth = f"{choice.worth:+.2%}, " if choice.worth is not None else ""
                lines.append(f"kept: {choice.leaves_out} ({worth}{choice.reason})")
        return "\n".join(lines)


@dataclass(frozen=True)
class _Known:
    """The fullest scene, its estimates (None before it has a mesh), and the accuracy that is wanted."""

    scene: Scene
    estimates: Estimates | None
    accuracy: float


@dataclass(frozen=True)
class _Candidate:
    """A simplification: settings whose first is the choice, what it leaves out, and what is predicted of it before any run."""

    settings: Mapping[str, object]
    leaves_out: str
    predict: "Callable[[_Known], _Prediction | None]"

    @property
    def key(self) -> str:
        return next(iter(self.settings))


def choose_model(scene: Scene, accuracy: float, integrate: Callable[[Scene], float | None]) -> ModelChoice:
    """The cheapest model of a scene within a relative `accuracy`; `integrate(scene)` gives a heating time (s; None where the wall
    is not heated) or raises `SolveError`. Where the fullest model is not heated, or has no steady flow on coarse cells, nothing
    is left out.
    """
    open_keys = {candidate.key for candidate in _CANDIDATES if not scene.is_given(candidate.key)}
    full = _fullest(scene, open_keys)
    try:
        reference = integrate(_coarse(full))
    except SolveError as error:
        return ModelChoice(full, accuracy, 0.0, (), f"nothing is left out: on coarse cells {error}")
    if reference is None:
        return ModelChoice(
            full, accuracy, 0.0, (), "nothing is left out: without a heating time there is no comparison"
        )
    known, chosen, before = _Known(full, _estimates(full), accuracy), full, reference
    choices: list[Choice] = []
    worth = 0.0
    for candidate in _CANDIDATES:
        if candidate.key not in open_keys or _is_settled(chosen, candidate, choices):
            continue
        value = candidate.settings[candidate.key]
        refused = Choice(candidate.key, value, candidate.leaves_out, chosen=False, worth=None, reason="")
        try:
            simpler = chosen.changed(candidate.settings)
        except InputError as error:
            choices.append(replace(refused, reason=f"{error.key} {error.allowed}"))
            continue
        predicted = candidate.predict(known)
        if predicted is not None and predicted.worth > HOPELESS * accuracy:
            choices.append(replace(refused, reason=f"{predicted.text}: expected effect about {predicted.worth:.2g}"))
            continue
        try:
            time = integrate(_coarse(simpler))
        except SolveError:
            time = None
        if time is None:
            choices.append(replace(refused, reason="no heating time"))
            continue
        change = time / before - 1.0
        fits = worth + abs(change) <= accuracy
        reason = "" if fits else f"more than the {accuracy - worth:.2%} that are left of {accuracy:.2%}"
        choices.append(replace(refused, chosen=fits, worth=change, reason=reason))
        if fits:
            chosen, before, worth = simpler, time, worth + abs(change)
    return ModelChoice(chosen, accuracy, worth, tuple(choices))


def _fullest(scene: Scene, open_keys: set[str]) -> Scene:
    """The scene with the fullest model that its open keys allow, to be taken as it is given."""
    if "model.bead_modes" not in open_keys:
        return scene
    try:
        return scene.changed({"model.bead_modes": BEAD_MODES})
    except InputError:
        return scene


def _coarse(scene: Scene) -> Scene:
    settings = {"solver.accuracy": None, "solver.step_refinement": COARSE * scene.solver.step_refinement}
    if scene.geometry.kind != "mesh":
        settings["solver.mesh_refinement"] = COARSE * scene.solver.mesh_refinement
    return scene.changed(settings)


def _estimates(scene: Scene) -> Estimates | None:
    """Of a scene whose size is known before it has a mesh."""
    specs = specs_of(scene)
    return None if specs.mesh.size is None else estimate(specs, specs.mesh.size)


def _is_settled(chosen: Scene, candidate: _Candidate, choices: list[Choice]) -> bool:
    """Whether a cheaper value of the same key was chosen, or the scene has this one anyway."""
    if any(choice.chosen and choice.key == candidate.key for choice in choices):
        return True
    return bool(chosen.value(candidate.key) == candidate.settings[candidate.key])


class _Prediction(NamedTuple):
    """Relative change of the heating time to be expected of a simplification, an order of magnitude, and what it follows from."""

    worth: float
    text: str


def _unknown(known: _Known) -> None:
    return None


def _without_turbulence(known: _Known) -> _Prediction | None:
    """Turbulence thins the layer at the wall: a tenth where the beads' own flow is turbulent."""
    if known.estimates is None:
        return None
    reynolds = known.estimates.reynolds_number
    return _Prediction(0.1 if reynolds > LAMINAR_REYNOLDS_NUMBER else 0.0, f"bead Reynolds number {reynolds:.3g}")


def _frozen(known: _Known) -> _Prediction | None:
    """Density and viscosity change with the absolute temperature."""
    operation = known.scene.operation
    low, high = operation.inlet_temperature.range
    change = max(high, operation.initial_temperature) / min(low, operation.initial_temperature) - 1.0
    return _Prediction(0.4 * change, f"the absolute temperature changes by {change:.0%}")


def _isothermal(known: _Known) -> _Prediction | None:
    """docs/bead-interior.md."""
    if known.estimates is None:
        return None
    biot = known.estimates.bead_biot_number
    return _Prediction(0.03 * biot, f"bead Biot number {biot:.2g}")


def _thin(known: _Known) -> _Prediction | None:
    """The wall's outer side follows its inner one after a part of the wall's own time, Bi/2."""
    if known.estimates is None:
        return None
    biot = known.estimates.wall_biot_number
    return _Prediction(0.05 * biot, f"wall Biot number {biot:.2g}")


def _one_temperature(known: _Known) -> _Prediction | None:
    """The exchange spreads the front by sqrt(2/NTU) of the time in which it passes."""
    if known.estimates is None:
        return None
    units = known.estimates.transfer_units
    return _Prediction(0.5 * math.sqrt(2.0 / units), f"{units:.3g} transfer units")


_CANDIDATES = (
    _Candidate({"model.flow": "plug", "model.turbulence": "none"}, "velocity profile and turbulence", _unknown),
    _Candidate({"model.flow": "developed"}, "entrance effects of the flow", _unknown),
    _Candidate({"model.turbulence": "none"}, "turbulence", _without_turbulence),
    _Candidate({"model.flow_update": "frozen"}, "the flow's change with the temperature", _frozen),
    _Candidate({"model.bead_modes": None}, "the temperature inside the beads", _isothermal),
    _Candidate({"model.wall": "thin"}, "the temperature through the wall", _thin),
    _Candidate({"model.energy": "one-temperature"}, "the difference of fluid and beads", _one_temperature),
)
