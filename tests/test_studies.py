"""Every study on a tiny instance: its functions run and give what its page is made of."""

import importlib
from pathlib import Path

import numpy as np
import pytest

import studies
from porousmold import Scene
from studies.page import Page, factorisations, yardstick

from .support import ALUMINIUM

TOOLS = {"page", "hypercube", "crossed_draws", "exact_solutions", "openterrace_store"}
"""Used by studies, no study themselves."""
MODULES = sorted({path.stem for path in Path(studies.__file__).parent.glob("[a-z]*.py")} - TOOLS)
TINY = {"model.flow": "plug", "model.turbulence": "none", "solver.mesh_refinement": 0.4, "solver.step_refinement": 0.4}
SHORT = TINY | {"operation.end_time": 60.0}


def study(name):
    return importlib.import_module(f"studies.{name}")


@pytest.mark.parametrize("name", MODULES)
def test_every_study_is_a_module_with_a_way_in(name):
    """Importing one runs nothing; the command of the Makefile is its `main`."""
    assert callable(study(name).main)
    makefile = (Path(studies.__file__).parents[1] / "Makefile").read_text()
    assert f"studies.{name}" in makefile


def test_page(tmp_path, capsys):
    page = Page("# Title")
    page.table(["a", "b"], [[1, 2.5], ["x", "y"]])
    page.write(tmp_path / "page.md")
    text = (tmp_path / "page.md").read_text()
    assert "| a | b |\n|---|---|\n| 1 | 2.5 |\n| x | y |\n" in text and text in capsys.readouterr().out + "\n"
    assert 0.05 < min(factorisations(1)[0], yardstick(), yardstick(of_cpu=True)) < 20.0


def test_tables():
    tables = study("tables")
    simulation, seconds = tables.heated(
        tables.refined(Scene.load(ALUMINIUM, TINY | {"solver.axial_cells": 10}), 0.5, 0.5)
    )
    assert 500.0 < simulation.recorder.heating_time < 4000.0 and seconds > 0.0
    best, order = tables.extrapolated(100.0 + 8.0, 100.0 + 2.0, 100.0 + 8.0 / 9.0)  # second order on meshes x 1, 2, 3
    assert best == pytest.approx(100.0, abs=1e-6) and order == pytest.approx(2.0, abs=1e-6)


def test_peers():
    """This program's part: with finer cells and steps it comes to what Schumann's solution, without conduction, is known for."""
    peers = study("peers")
    scene = Scene.load(peers.SCENE)
    store = peers.store_of(scene)
    assert store["coefficient"] == pytest.approx(34.64, abs=0.01)  # Wakao by hand, Re 94.3, Pr 0.754
    assert max(peers.ours(scene, {}).errors(store)) < 1.5
    assert max(peers.ours(scene, {"solver.mesh_refinement": 0.25}).errors(store)) > 3.0


def test_work_precision(tmp_path):
    """Errors of a second-order method, made up: the page has the median and 95 % of every place, the picture is drawn."""
    work = study("work_precision")
    factors = work.settings_of(0, {work.CELLS: 0.5, work.STEPS: 0.5})
    own = work.scene_of(0).solver
    assert factors == {work.CELLS: 0.5 * own.mesh_refinement, work.STEPS: 0.5 * own.step_refinement}
    assert work.settings_of(0, {"solver.accuracy": 0.01}) == {"solver.accuracy": 0.01}
    points = [
        work.Point(scene, path, place, (1.0 + scene) * 1e-3 / 4.0**place, 2.0**place)
        for path, places in work.PATHS.items()
        for place in range(len(places))
        for scene in range(3)
    ]
    work.write_page(tmp_path / "page.md", points, 4)
    text = (tmp_path / "page.md").read_text()
    assert "3 scenes (of 4 drawn" in text and "| 0.200% | 0.290% | 1.00 |" in text
    assert (tmp_path / "page.png").stat().st_size > 10_000


def test_regression(tmp_path):
    regression = study("regression")
    assert len({name for name, _, _ in regression.cases()}) == len(list(regression.cases())) > 40
    numbers = regression.numbers_of(ALUMINIUM, SHORT)
    assert regression.difference("heating_time", None, None) == 0.0
    assert regression.difference("heating_time", None, 1.0) == float("inf")
    assert regression.difference("heat_stored", numbers["heat_stored"], 1.01 * numbers["heat_stored"]) > 9e-3


def test_hard_cases(tmp_path):
    hard = study("hard_cases")
    rows = list(hard.cases(tmp_path))
    assert len(rows) > 70 and {row for row, *_ in rows} == set(range(1, 16))
    cells, good, found = hard.told(ALUMINIUM, SHORT)
    assert good and cells[0] == "done" and len(cells) == 10 and found == {}  # plug flow has nothing to find
    flow = SHORT | {"operation.pressure_drop": None, "operation.mass_flow": 0.03}
    assert hard.told(ALUMINIUM, flow)[0][0] == "done"
    assert hard.told(ALUMINIUM, {"wall.thickness": -1.0})[0][0] == "refused"


def test_random_scenes():
    random_scenes = study("random_scenes")
    drawn = list(random_scenes.scenes(8, 1))
    assert len(drawn) == 8 and len({scene.geometry.kind for scene in drawn}) == 2
    outcome = random_scenes.outcome((0, SHORT | {"solver.first_step": 1.0}, 60.0))
    assert outcome.steps > 3 and not outcome.reason


def test_growth():
    growth = study("growth")
    rows = [{"n": n, "s": 3.0 * n**1.5} for n in (10, 20, 40)]
    assert growth.slope(rows, "s", "n") == pytest.approx(1.5)
    assert [title.split(",")[0] for title in growth.sections(growth.HERE.parent / "docs" / "growth.md")] == [
        *(f"{dimensions} dimensions" for dimensions, *_ in growth.TABLES),
        growth.TO_THE_HEATING_TIME.split(",")[0],
    ]
    found = growth.measure(2, 0.3, "factorised")
    assert found["flow_unknowns"] > found["energy_unknowns"] > 100 and found["krylov_iterations"] == 1


def test_speed_against_error():
    speed = study("speed_against_error")
    heating_time, seconds, unknowns, imbalance = speed.integrated(Scene.load(ALUMINIUM, TINY))
    assert heating_time > 500.0 and seconds > 0.0 and unknowns > 100 and imbalance < 1e-3
    assert speed.row("x", None, 1.0, 1.0).count("|") == speed.HEAD[0].count("|")


def test_chapter_6(tmp_path):
    chapter = study("chapter_6")
    changes = {"model.turbulence": "none", "model.flow": "developed", "operation.end_time": 100.0}
    found = chapter.outcome(tmp_path, chapter.settings(tmp_path), changes | {"solver.mesh_refinement": 0.4})
    assert found.at("fluid 250", 90.0) > 22.9 and found.wall_flux.max() > 0.0
    assert chapter.apart(found, found, "fluid") == 0.0


def test_bead_interior(monkeypatch):
    interior = study("bead_interior")
    monkeypatch.setattr(interior, "REPEATED", 1)
    monkeypatch.setattr(interior, "MODES", (None, 1))
    found = interior.outcomes(Scene.load(ALUMINIUM, TINY | {"bed.bead_conductivity": 0.2}))
    rows = list(interior.rows("poor", found))
    assert len(rows) == 2 and all(len(cells) == len(interior.HEAD) for cells in rows)
    assert found[1][0]["heating_time"] > found[None][0]["heating_time"]


def test_figures():
    figures = study("figures")
    assert len(list(figures.curves())) > 10
    assert figures.power_law(2.0, 3.0, 2.0) > 0.0


def test_permeability_tests():
    tests = study("permeability_tests")
    assert tests.table(["a"], [["1"]]) == ["", "| a |", "|---|", "| 1 |"]
    assert len(tests.predictions()) > 3


def test_kill_test(tmp_path):
    kill = study("kill_test")
    command = kill.COMMANDS["pack"]
    seconds, answer = kill.undisturbed(command)
    kills, difference, problem = kill.one_command(1, command, seconds, answer)
    assert not problem and difference == 0.0 and kills >= 0
    other = {name: values * 1.001 for name, values in answer.items()}
    assert kill.largest_difference(answer, other) == pytest.approx(1e-3, rel=0.01)
    assert kill.one_command(1, command, seconds, other)[2] == "another answer"


def test_fuzz(tmp_path):
    import random

    fuzz = study("fuzz")
    draw = random.Random(3)
    assert any(fuzz.mutated(fuzz.SCENE, draw) != fuzz.SCENE for _ in range(5))
    assert fuzz.wrong(0, "", tmp_path) == "" and fuzz.wrong(1, "Traceback", tmp_path)


def test_adjoint():
    """Elasticities by the adjoint are those of two runs; the inlet temperature's goal moves with it."""
    adjoint = study("adjoint")
    cells = {"solver.mesh_refinement": 0.4, "solver.step_refinement": 0.7}
    scene = Scene.load(ALUMINIUM, cells)
    course = adjoint.Course(scene)
    sweep, own = adjoint.Sweep(course), adjoint.residuals(course, course.forms)
    parameters = adjoint.parameters_of(scene)
    for name in ("wall.density", "operation.pressure_drop", "operation.inlet_temperature"):
        found = adjoint.elasticity(scene, course, sweep, own, name, parameters[name])
        assert found == pytest.approx(adjoint.difference(scene, name, parameters[name]), abs=0.02)
        assert abs(found) > 0.1


def test_droplet(tmp_path, monkeypatch):
    """The page of outcomes: what the seeds differ by, and the difference of two temperatures with its error."""
    droplet = study("droplet")
    monkeypatch.setattr(droplet, "DOCS", tmp_path)
    cases = [(celsius, {"seed": seed}) for seed in droplet.SEEDS for celsius in droplet.TEMPERATURES]
    cases += [(celsius, settings) for settings in droplet.VARIANTS.values() for celsius in droplet.VARIED_AT]
    names = [
        "speed",
        "early",
        "late",
        "bouncing",
        "by_beads",
        "inside",
        "forces",
        "floor",
        "highest",
        "water",
        "imbalance",
    ]
    outcomes = []
    for celsius, settings in cases:
        depth = 1e-3 * celsius + 0.1 * settings.get("seed", 2)
        outcomes.append(dict.fromkeys([*names, "seconds"], 1.0) | {
            "celsius": celsius, "settings": settings, "depth": [depth] * 4, "chimney": float("nan"), "ended": "",
            "times": [0.0, 1.0], "depths": [0.0, depth]})  # fmt: skip
    droplet.write_page(tmp_path / "droplet.md", outcomes)
    droplet.draw(tmp_path / "droplet.png", outcomes)
    text = (tmp_path / "droplet.md").read_text()
    assert "0.60 ± 0.06" in text and "-0.20 D, standard error 0.08 D (3 seeds each)" in text
    assert "| no bonds | 0.60 | 0.60 | 1 | 0.80 | 0.80 | 1 |" in text
    assert (tmp_path / "droplet.png").exists()


def test_a_tracer_spreads_as_beads_mix_it():
    """Uniform plug flow: from 5 to 95 % in 3.29 standard deviations of sqrt(2 D/(u L)), D = u d/2 and the fluid's own."""
    settings = {
        "model.flow": "plug",
        "model.turbulence": "none",
        "bed.porosity_model": "constant",
        "model.wall": "insulated",
    }
    scene = Scene.load(ALUMINIUM, settings | {"wall.thickness": None})
    times, out, mean, missing = study("tracer").breakthrough(scene)
    spread = np.interp(0.95, out, times) - np.interp(0.05, out, times)
    assert spread == pytest.approx(3.29 * np.sqrt(scene.bed.bead_diameter / scene.geometry.length), rel=0.03)
    assert mean == pytest.approx(1.0, abs=1e-6) and abs(missing) < 1e-9
