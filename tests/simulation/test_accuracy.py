"""Accuracy on request: its estimate, its refinements, and the true error of scenes drawn at random."""

import itertools
import math

import pytest

from porousmold import InputError, run
from porousmold.errors import SolveError
from porousmold.scene.scene import Scene
from porousmold.simulation.accuracy import (
    COARSER,
    FINEST,
    IN_DOUBT,
    LEAST_PART,
    OBSERVED_ORDERS,
    ORDER_OF_SHARP_FRONTS,
    Answer,
    Errors,
    Refinements,
    errors_after,
    estimated_errors,
    needed_factor,
    run_to_accuracy,
)
from studies.accuracy import outcome_of, refinements_of

from ..support import ALUMINIUM, coarse_scene, cured_mold


@pytest.mark.parametrize("number", [2, 5, 21, 33])
def test_the_estimate_is_that_of_the_true_error(number):
    """Within a factor of 3, on scenes drawn at random; `make accuracy` shows it on 40."""
    outcome = outcome_of(("random", number, 0.003))
    assert outcome.is_right and outcome.true <= 0.003


class Integration:
    """Heating times whose errors by cells along, cells across and steps fall with an order each."""

    def __init__(self, along, across, steps, orders=(2.0, 2.0, 3.0)):
        self._errors, self._orders, self.asked = (along, across, steps), orders, []

    def error(self, refinements):
        parts = zip(self._errors, refinements, self._orders, strict=True)
        return sum(error / refinement**order for error, refinement, order in parts)

    def __call__(self, scene):
        self.asked.append(refinements_of(scene))
        return {"heating_time": Answer.by_itself(1000.0 * (1.0 + self.error(self.asked[-1])))}


@pytest.mark.parametrize(
    "errors",
    [
        (0.02, 0.0, 0.001),
        (0.0, 0.02, 0.001),
        (5e-4, 5e-4, 0.02),
        (0.01, 0.01, 0.01),
        (5e-6, 5e-6, 1e-5),
        (0.01, -1e-3, 1e-4),
    ],
)
@pytest.mark.parametrize("wanted", [1e-3, 1e-4])
def test_each_direction_and_the_steps_are_refined_as_each_needs_it(errors, wanted):
    integrate = Integration(*errors)
    error = run_to_accuracy(Scene.load(ALUMINIUM, {"solver.accuracy": wanted}), integrate)["heating_time"]
    settled, true = integrate.asked[-1], integrate.error(integrate.asked[-1])
    assert error is not None and (error <= wanted or max(settled) == FINEST)
    assert abs(true) < 1.5 * error
    for one, other in itertools.permutations(range(3), 2):
        if abs(errors[one]) > 5.0 * abs(errors[other]) and 1.0 < settled[one] < FINEST:
            assert settled[one] > settled[other]
    assert len(integrate.asked) <= 6


class HidesAlong(Integration):
    """The error by cells along falls at order 1, and coarser cells than the default ones do not show it."""

    def error(self, refinements):
        return super().error(refinements._replace(along=max(1.0, refinements.along)))


def test_an_error_that_coarser_cells_hide_is_that_of_finer_ones():
    integrate, scene = HidesAlong(0.015, 1e-4, 1e-4, (1.0, 2.0, 2.0)), Scene.load(ALUMINIUM, {"solver.accuracy": 3e-3})
    assert run_to_accuracy(scene, integrate)["heating_time"] < 0.1 * integrate.error(integrate.asked[-1])  # certified
    integrate.asked.clear()
    error = run_to_accuracy(scene, integrate, lambda: Refinements(along=IN_DOUBT))["heating_time"]
    settled = integrate.asked[-1]
    assert integrate.error(settled) <= 3e-3 and integrate.error(settled) / 3.0 < error <= 3e-3
    assert settled.along > 4.0 and settled.across == settled.steps == 1.0


def test_a_default_run_that_is_good_enough_is_the_last():
    integrate = Integration(2e-4, -1e-4, 1e-4)
    assert run_to_accuracy(Scene.load(ALUMINIUM, {"solver.accuracy": 1e-3}), integrate)
    assert len(integrate.asked) == 4 and integrate.asked[-1] == Refinements()


def test_estimate_is_zero_only_without_any_difference():
    def errors(*values):
        return estimated_errors(*map(Answer.by_itself, values))

    assert errors(*[100.0] * 4) == Errors(0.0, 0.0, 0.0)
    assert errors(99.0, 99.0, 99.0, 100.0).along < 0.0 < errors(101.0, 100.0, 101.0, 100.0).across
    assert errors(101.0, 101.0, 100.0, 100.0).steps > 0.0
    assert errors(101.0, 101.0, 100.0, 100.0).steps == pytest.approx(
        10.0 * estimated_errors(*(Answer(value, 1000.0) for value in (101.0, 101.0, 100.0, 100.0))).steps
    )


def test_errors_that_cancel_count_by_half_at_least():
    assert Errors(2e-3, 1e-3, 1e-3).all == pytest.approx(4e-3)
    assert Errors(2e-3, 1e-3, -1e-3).all == pytest.approx(2e-3)
    assert Errors(2e-3, 1e-3, -3e-3).all == pytest.approx(0.5 * math.sqrt(14.0) * 1e-3)


@pytest.mark.parametrize(("along", "order"), [(2e-3, OBSERVED_ORDERS.along), (-2e-3, ORDER_OF_SHARP_FRONTS)])
def test_richardson_is_exact_at_the_orders_that_are_taken(along, order):
    integrate = Integration(along, 1e-3, -2e-3, OBSERVED_ORDERS._replace(along=order))
    scene = Scene.load(ALUMINIUM)
    runs = COARSER, COARSER._replace(across=1.0), COARSER._replace(steps=1.0), Refinements()
    errors = estimated_errors(*(integrate(refinements.of(scene))["heating_time"] for refinements in runs))
    assert errors == pytest.approx((along, 1e-3, -2e-3), rel=5e-3)


def test_a_finer_run_shows_how_good_the_estimates_were():
    """At order 2 errors of 1e-3 leave 2.5e-4 and move the answer by 7.5e-4; what moves otherwise is in error otherwise."""
    errors, factors = Errors(5e-4, 5e-4, 0.0), Refinements(2.0, 2.0, 1.0)
    for difference, part in ((7.5e-4, 1.0), (7.5e-3, 10.0), (3.75e-4, 0.5), (0.0, LEAST_PART)):
        assert errors_after(errors, factors, difference).all == pytest.approx(part * 2.5e-4)


def test_the_factor_brings_each_error_to_its_share():
    assert needed_factor(1e-5, 1e-3) == 1.0
    assert 4e-3 / needed_factor(4e-3, 1e-3) ** 2 < 1e-3 / 3.0


def test_failed_coarse_run_is_followed_by_a_finer_one():
    refinements = []

    def integrate(scene):
        refinements.append(scene.solver.mesh_refinement)
        raise SolveError("flow", 0.0, "detail", "advice")

    with pytest.raises(SolveError):
        run_to_accuracy(Scene.load(ALUMINIUM, {"solver.accuracy": 0.003}), integrate)
    assert refinements[1] == 2.0 * refinements[0] and len(refinements) == 2


def test_the_worst_answer_asks_for_the_refinement():
    """Two answers, one with an error by steps and one by cells: both are brought down, and an answer that a coarse run lacks
    has no estimate."""
    cells, steps = Integration(0.01, 0.0, 0.0), Integration(0.0, 0.0, 0.02)

    def integrate(scene):
        found = {"heating_time": cells(scene)["heating_time"], "targets.cured": steps(scene)["heating_time"]}
        if scene.solver.step_refinement >= 1.0:
            found["targets.even"] = Answer.by_itself(100.0)
        return found

    errors = run_to_accuracy(Scene.load(ALUMINIUM, {"solver.accuracy": 1e-3}), integrate)
    assert set(errors) == {"heating_time", "targets.cured"} and max(errors.values()) <= 1e-3
    settled = cells.asked[-1]
    assert settled.along > 1.5 and settled.steps > 1.5 and settled.across == 1.0


def test_every_answer_of_a_scene_has_its_error():
    """A part that cures: heating time, target and peak, each against a run of its own that is twice finer."""
    settings = {"model.flow": "plug", "operation.end_time": 20000.0, "model.turbulence": "none"}
    result = run(cured_mold(settings | {"solver.accuracy": 0.01}))
    assert set(result.summary["target_errors"]) == {"cured"} and set(result.summary["peak_errors"]) == {"part"}
    finer = run(cured_mold(settings | {"solver.mesh_refinement": 2.0, "solver.step_refinement": 2.0}))
    error = abs(result.summary["targets"]["cured"] / finer.summary["targets"]["cured"] - 1.0)
    assert error < 0.01 and result.summary["target_errors"]["cured"] < 0.01
    rise = [max(one["highest_part"]) - min(one["lowest_temperature"]) for one in (result, finer)]
    assert rise[0] == pytest.approx(rise[1], rel=0.01)


def test_the_scene_as_run_tells_what_chose_its_refinements(tmp_path):
    settings = {"model.flow": "plug", "model.turbulence": "none", "solver.accuracy": 0.05}
    run(coarse_scene(settings), tmp_path / "run")
    text = (tmp_path / "run" / "scene.toml").read_text()
    assert text.startswith("# solver.accuracy = 0.05 chose") and Scene.load(tmp_path / "run" / "scene.toml")


def front_in_the_bed(settings=()):
    """A scene that ends while the thermal front stands in the middle of the bed."""
    return coarse_scene(
        {"model.flow": "plug", "model.turbulence": "none", "operation.end_time": 120.0, **dict(settings)}
    )


def test_an_accuracy_of_a_run_without_times_is_that_of_the_temperatures_at_its_end():
    result = run(front_in_the_bed({"solver.accuracy": 0.004}))
    errors = result.summary["end_errors"]
    assert result.summary["heating_time"] is None and 0.0 < max(errors.values()) <= 0.004
    assert {"temperature_centre_L/2", "outlet_temperature", "heat_stored"} <= set(errors)
    finer = run(front_in_the_bed({"solver.mesh_refinement": 4.0, "solver.step_refinement": 4.0}))
    span = max(finer["highest_temperature"]) - min(finer["lowest_temperature"])
    for name in ("temperature_centre_L/8", "temperature_centre_L/4", "temperature_centre_L/2"):
        assert result[name][-1] == pytest.approx(finer[name][-1], abs=0.004 * span)


def test_an_accuracy_that_has_nothing_to_act_on_says_so():
    warm = {"operation.inlet_temperature": 293.15, "operation.initial_temperature": 293.15, "operation.end_time": 60.0}
    fixed = {"model.wall": "fixed-temperature", "operation.wall_temperature": 293.151}
    result = run(
        coarse_scene(warm | fixed | {"model.flow": "plug", "model.turbulence": "none", "solver.accuracy": 0.01})
    )
    assert any("solver.accuracy has nothing to act on" in warning for warning in result.summary["warnings"])


def test_accuracy_chooses_the_refinement_itself():
    with pytest.raises(InputError, match="accuracy"):
        Scene.load(ALUMINIUM, {"solver.accuracy": 0.01, "solver.mesh_refinement": 2.0})
