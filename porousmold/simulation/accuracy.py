"""Accuracy on request: the mesh and the steps that bring every answer of a scene within a wanted relative error.

Answers are the heating time, the time at which each target is met, and the highest temperature of each layer that cures (its rise
above the lowest temperature of the run); of a run that gives no time the temperatures and the heat stored at its end. Each has an
error estimate of its own; the worst of them asks for the refinement.

With t(l, c, s) an answer at refinements of the cells along the flow, of those across it, and of the steps, the errors of
a run come from three cheaper ones (Richardson):

    e_c = [t(l/2, 0.7 c, s/2) - t(l/2, c, s/2)] / (0.7^-p_c - 1),
    e_s = [t(l/2, 0.7 c, s/2) - t(l/2, 0.7 c, s)] / (2^p_s - 1),
    e_l = [t(l/2, 0.7 c, s) - t(l, c, s) - t(l/2, 0.7 c, s/2) + t(l/2, c, s/2)] / (2^p_l - 1),

all with their signs, as they may cancel; the estimate is |e_l + e_c + e_s|, and half of the root of the sum of their squares at
least. The three do without the bounds of the temperatures, which spread a front over coarse cells and hide their order. The
orders are what random scenes show from such coarse runs (seeds 17 to 19 of `studies.random_scenes`; docs/accuracy.md has others):
p_c = p_s = p_l = 2.5, near the order 2 of the cells. Where fewer cells along heat sooner, the front is sharper
than they resolve, and the error falls faster: p_l = 4 there.

If the estimate exceeds the target, finer runs follow, with cells along, cells across and steps each refined as needed at order 2,
the first of them by a factor of 1.7 at most. Its error estimate is e_l, e_c and e_s scaled at that order, those of what was
refined times what its difference from the run before was of what they foresaw, a quarter at least. In directions that coarser
runs tell nothing of the first finer run has `FIRST_FACTOR` times as much, and their order is 1. This is the discretisation error,
not the model error.

Without an accuracy asked for, a run whose answers may be off (`answers.doubt_of`) compares itself with the coarsest of these
runs. Where an answer differs by more than `LARGEST_DIFFERENCE`, it is repeated with `IN_DOUBT` times the cells or steps in the
directions whose part of a difference is that large. Where that moves an answer by more than `STILL_IN_DOUBT`, it is repeated once
more with `IN_DOUBT` times all of them: coarse runs may have hidden a direction. The difference from the run before bounds the
error by experience (`studies.crossed_scenes`), not by theory.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple, TypeAlias

from ..errors import InputError, SolveError
from ..scene.features.geometries import dimension_of
from ..scene.scene import Scene

ORDER, ORDER_OF_HIDDEN = 2.0, 1.0
"""Of convergence, where a run is refined further; in a direction that coarser runs tell nothing of."""
FIRST_FACTOR = 1.7
"""Largest factor on a refinement in the first run that is finer than the scene's own: it shows how good the estimates were."""
LEAST_PART = 0.25
"""Of the errors predicted, that are taken as known from the difference of two runs: differences may cancel."""
FINEST = 8.0
"""Largest refinement that is tried."""
FINER = 1.5
"""Factor on the cells in each direction where a solve has failed."""
COARSEST_OF_ALL = 2.0
"""Refinement from which on a failed solve is the scene's own failure."""
IN_DOUBT = 2.0
"""Factor on cells and steps in the directions that answers in doubt depend on."""
STILL_IN_DOUBT = 0.006
"""Of what a repeat moves an answer, relative, above which it is repeated once more, with all cells and steps: some third of it is
left at order 2."""
FINEST_IN_DOUBT = IN_DOUBT**2
"""Refinement from which on no run is repeated."""
MOST_WORK = 2e6
"""Unknowns of flow and energy times time steps, beyond which no run is repeated: some 20 s of the first integration
(docs/growth.md), two minutes of the second."""
MOST_WORK_AGAIN = 5e5
"""The same of the second integration, beyond which there is no third of twice all cells and steps: some 40 s of that; of one of
fewer in proportion."""
CELLS_AND_STEPS = (
    *("mesh_refinement", "axial_refinement", "step_refinement"),
    *("axial_cells", "first_cell", "cell_growth", "wall_cells"),
)
"""Keys of [solver] with which a user chooses them."""
MARGIN = 1.1
"""Factor on a refinement beyond what the estimate asks for."""


class Answer(NamedTuple):
    """What a run answers (SI), and what its errors are a part of."""

    value: float
    scale: float

    @classmethod
    def by_itself(cls, value: float) -> "Answer":
        """One whose errors are a part of its own value."""
        return cls(value, abs(value) or 1.0)


class Refinements(NamedTuple):
    """Factors on the cells along the flow and across it, and on the steps; or of one run over those of another."""

    along: float = 1.0
    across: float = 1.0
    steps: float = 1.0

    def times(self, along: float, across: float, steps: float) -> "Refinements":
        """These, times factors."""
        return Refinements(self.along * along, self.across * across, self.steps * steps)

    def of(self, scene: Scene) -> Scene:
        """The scene with these refinements."""
        return scene.changed(
            {
                "solver.accuracy": None,
                "solver.mesh_refinement": self.across,
                "solver.axial_refinement": None if self.along == self.across else self.along / self.across,
                "solver.step_refinement": self.steps,
            }
        )


COARSER = Refinements(along=0.5, across=0.7, steps=0.5)
"""What the runs have less that the errors are estimated from."""
ALL_IN_DOUBT = Refinements(IN_DOUBT, IN_DOUBT, IN_DOUBT)
"""Where it is not known which of them an answer depends on."""
ORDERS = Refinements(ORDER, ORDER, ORDER)
"""Of convergence from the scene's own cells and steps on."""
OBSERVED_ORDERS = Refinements(along=2.5, across=2.5, steps=2.5)
"""Of convergence from such runs."""
ORDER_OF_SHARP_FRONTS = 4.0
"""The same by cells along the flow where fewer of them heat sooner."""


def refinements_of(scene: Scene) -> Refinements:
    """Those that a scene is integrated with."""
    across, axial, steps = (getattr(scene.solver, f"{name}_refinement") for name in ("mesh", "axial", "step"))
    return Refinements(across * axial, across, steps)


class Errors(NamedTuple):
    """Relative errors of an answer by its cells along and across the flow and by its steps, with their signs."""

    along: float
    across: float
    steps: float

    @property
    def all(self) -> float:
        """Of all together, where they cancel half of what they are as independent ones at least."""
        return max(abs(sum(self)), 0.5 * math.hypot(*self))


Answers: TypeAlias = Mapping[str, Answer]
"""Answers of a run by their names."""
PEAKS, AT_END = "peaks.", "end."
"""Beginnings of the names of peaks, and of what holds at the end."""
LARGEST_DIFFERENCE = 3e-3
"""From a coarser run, relative, above which a run is repeated, or warns: errors were up to twice that (docs/theory.md)."""


def run_to_accuracy(
    scene: Scene, integrate: Callable[[Scene], Answers], hidden: Callable[[], Refinements] = Refinements
) -> dict[str, float] | None:
    """Integrate a scene as often as its `solver.accuracy` needs; gives the estimated relative errors of the last integration's
    answers.

    `integrate(scene)` gives the answers that there are, or raises `SolveError`. Without an accuracy that is the scene itself, or
    if that fails on finer cells, and no error is estimated: None. An answer that one of the runs does not have has no estimate.
    `hidden()` has factors above 1 in the directions in which coarser runs do not show the error of the last integration.
    Raises `SolveError` where refinement does not help.
    """
    if scene.solver.accuracy is None:
        try:
            integrate(scene)
        except SolveError:
            if scene.geometry.kind == "mesh":
                raise
            integrate(scene.changed({"solver.mesh_refinement": FINER * scene.solver.mesh_refinement}))
        return None
    wanted, present = scene.solver.accuracy, Refinements()
    unbounded = scene.changed({"solver.keep_bounds": False})
    while True:
        coarse = present.times(*COARSER)
        coarser = [coarse, coarse._replace(across=present.across), coarse._replace(steps=present.steps)]
        try:
            runs = [integrate(run.of(unbounded)) for run in coarser] + [integrate(present.of(scene))]
        except SolveError:  # coarse cells may have no steady flow
            if present.across >= COARSEST_OF_ALL:
                raise
            present = present.times(2.0, 2.0, 1.0)
            continue
        break
    now = runs[-1]
    errors = {name: estimated_errors(*(run[name] for run in runs)) for name in now if all(name in run for run in runs)}
    most, unseen = FIRST_FACTOR, [factor > 1.0 for factor in hidden()]
    orders = Refinements(*(ORDER_OF_HIDDEN if one else ORDER for one in unseen))
    if errors and any(unseen):
        before, finer = now, present.times(*(FIRST_FACTOR if one else 1.0 for one in unseen))
        now = integrate(finer.of(scene))
        errors = {
            name: _with_hidden(one, unseen, difference(before[name], now[name]))
            for name, one in errors.items()
            if name in now
        }
        present, most = finer, FINEST
    while errors and max(one.all for one in errors.values()) > wanted and max(present) < FINEST:
        worst = (max(abs(error) for error in direction) for direction in zip(*errors.values(), strict=True))
        needed = Refinements(
            *(min(needed_factor(error, wanted, order), most) for error, order in zip(worst, orders, strict=True))
        )
        finer = Refinements(*(min(FINEST, one) for one in present.times(*needed)))
        before, now = now, integrate(finer.of(scene))
        factors = Refinements(*(more / one for more, one in zip(finer, present, strict=True)))
        errors = {
            name: errors_after(one, factors, difference(before[name], now[name]), orders)
            for name, one in errors.items()
            if name in now
        }
        present, most = finer, FINEST
    return {name: one.all for name, one in errors.items()}


def difference(other: Answer, own: Answer) -> float:
    """Relative difference of an answer of another run from the own one."""
    return abs(other.value - own.value) / own.scale


def differences(other: Answers, own: Answers) -> dict[str, float]:
    """Relative differences of another run's answers from the own ones, as far as it has them."""
    return {name: difference(other[name], one) for name, one in own.items() if name in other}


def coarser_answers(scene: Scene, fewer: Refinements, integrate: Callable[[Scene], Answers]) -> Answers:
    """Answers of a scene with fewer cells and steps and without bounds; none where coarse cells have no steady flow, or are fewer
    than are allowed."""
    try:
        return integrate(refinements_of(scene).times(*fewer).of(scene.changed({"solver.keep_bounds": False})))
    except (SolveError, InputError):
        return {}


def may_be_repeated(scene: Scene, work: float, most: float = MOST_WORK) -> bool:
    """Whether a run whose answers are in doubt is repeated on finer cells: in two dimensions, where its `work`, unknowns times
    steps, is no more than `most`, and the number of cells and steps not the user's choice."""
    is_chosen = any(scene.differs_from_default(f"solver.{name}") for name in CELLS_AND_STEPS)
    is_asked_for = scene.solver.refine_in_doubt and scene.solver.accuracy is None and not is_chosen
    return is_asked_for and dimension_of(scene.geometry) == 2 and work <= most


def refinements_in_doubt(
    scene: Scene, own: Answers, coarsest: Answers, integrate: Callable[[Scene], Answers]
) -> Refinements:
    """`IN_DOUBT` in the directions that move an answer by more than `LARGEST_DIFFERENCE`, or else most; in all where that is not
    known, and of times, which coarse steps move far: what they hide of cells is found by none of these runs."""
    moved = differences(coarsest, own)
    if not moved or not max(moved, key=moved.__getitem__).startswith((PEAKS, AT_END)):
        return ALL_IN_DOUBT
    across, steps = (
        coarser_answers(scene, COARSER._replace(**one), integrate) for one in ({"across": 1.0}, {"steps": 1.0})
    )
    parts = [
        [abs(part) / one.scale for part in by_direction(coarsest[name], across[name], steps[name], one)]
        for name, one in own.items()
        if name in coarsest and name in across and name in steps
    ]
    worst = [max(column) for column in zip(*parts, strict=True)] or [math.inf] * len(COARSER)
    least = min(LARGEST_DIFFERENCE, max(worst))
    return Refinements(*(IN_DOUBT if part >= least else 1.0 for part in worst))


def is_still_in_doubt(moved: Mapping[str, float], refined: Refinements) -> bool:
    """Whether a repeat moved an answer by so much that there is to be another one."""
    return bool(moved) and max(moved.values()) > STILL_IN_DOUBT and max(refined) < FINEST_IN_DOUBT


def by_direction(
    coarse: Answer, coarse_but_across: Answer, coarse_but_steps: Answer, now: Answer
) -> tuple[float, float, float]:
    """What fewer cells along, fewer across and fewer steps add to an answer, of the values of four runs: the first is that of one
    with all that is `COARSER`, the next two are with the last one's cells across and with its steps."""
    across, steps = coarse.value - coarse_but_across.value, coarse.value - coarse_but_steps.value
    return coarse_but_steps.value - now.value - across, across, steps


def estimated_errors(coarse: Answer, coarse_but_across: Answer, coarse_but_steps: Answer, now: Answer) -> Errors:
    """Errors of the last of four values of an answer (see `by_direction`)."""
    parts = by_direction(coarse, coarse_but_across, coarse_but_steps, now)
    orders = OBSERVED_ORDERS if parts[0] > 0.0 else OBSERVED_ORDERS._replace(along=ORDER_OF_SHARP_FRONTS)
    return Errors(
        *(part / now.scale / (fewer**-order - 1.0) for part, fewer, order in zip(parts, COARSER, orders, strict=True))
    )


def _with_hidden(errors: Errors, unseen: Iterable[bool], moved: float) -> Errors:
    """Errors where the unseen ones are what is left of how far `FIRST_FACTOR` moved an answer."""
    left = moved / (FIRST_FACTOR**ORDER_OF_HIDDEN - 1.0)
    return Errors(*(left if one else error for one, error in zip(unseen, errors, strict=True)))


def needed_factor(error: float, wanted: float, order: float = ORDER) -> float:
    """Factor on a refinement that brings its error down to a third of what is wanted in all, 1 at least."""
    return max(1.0, MARGIN * (3.0 * error / wanted) ** (1.0 / order))


def errors_after(errors: Errors, factors: Refinements, moved: float, orders: Refinements = ORDERS) -> Errors:
    """Errors of a run refined by these factors, which `moved` by this, relative, from the run before."""
    scaled = [error / factor**order for error, factor, order in zip(errors, factors, orders, strict=True)]
    predicted = abs(sum(errors) - sum(scaled))
    part = max(LEAST_PART, moved / predicted) if predicted else 1.0
    return Errors(*(part * error if factor > 1.0 else error for error, factor in zip(scaled, factors, strict=True)))
