"""What the console shows while a run goes on."""

import logging

from porousmold.output.console import PART, Bar, RunProgress, log_to_console, outer_wall_text, summary_text
from porousmold.simulation.running import run

from ..support import coarse_scene, problem_of

PLUG = {"model.flow": "plug", "model.turbulence": "none"}


def test_the_summary_names_what_is_modelled_and_whether_it_is_cooled(tmp_path):
    cold = {"operation.initial_temperature": "90 degC", "operation.inlet_temperature": "20 degC"}
    scene = coarse_scene({**PLUG, **cold})
    text = summary_text(scene, run(scene).summary, tmp_path, [])
    assert text.startswith("cooling time (wall within 2 K of the inlet): ")
    assert "of half of the cavity, per metre of width" in text and "MJ to cool the fluid" in text


def test_targets_come_first_and_replace_a_heating_time_that_is_not_reached(tmp_path):
    target = {"target.list": [{"name": "warm", "place": "wall", "above": "40 degC"}], "operation.end_time": 1500.0}
    scene = coarse_scene(
        {**PLUG, **target, "operation.outer_coefficient": 500.0, "operation.ambient_temperature": 293.0}
    )
    text = summary_text(scene, run(scene).summary, tmp_path, [])
    assert text.startswith("warm: ") and "heating time" not in text


def test_a_quiet_bar_shows_nothing(capsys):
    bar = Bar(quiet=True)
    bar.phase("meshing")
    bar.show(1, 2, "cases")
    bar.close()
    assert capsys.readouterr().err == ""


def test_there_is_no_bar_without_a_terminal(capsys):
    bar = Bar()
    bar.show(0.5, 1.0, "half", PART)
    bar.close()
    assert capsys.readouterr().err == ""


def test_a_bar_shows_phase_and_progress(capsys):
    bar = Bar(always=True)
    bar.phase("meshing")
    bar.show(0.5, 1.0, "half", PART)
    bar.close()
    shown = capsys.readouterr().err
    assert "meshing" in shown and "half" in shown and "50 %" in shown


def test_phases_are_shown_until_the_first_step():
    texts = []

    class Noted(Bar):
        def phase(self, text):
            texts.append(text)

        def show(self, done, total, text, shape=""):
            texts.append(f"{done:g} of {total:g}")

    class Simulation:
        class problem:  # noqa: N801
            class medium:  # noqa: N801
                class estimates:  # noqa: N801
                    heating_duration = 100.0

    bar = Noted()
    progress = RunProgress(bar, 2.0, 1000.0)
    progress.phase("compiling")
    progress(10.0, 60.0, Simulation)
    progress.phase("flow: iteration 1")
    progress(20.0, 20.0, Simulation)
    assert texts[0] == "compiling" and texts[1] == "10 of 170" and len(texts) == 3
    # predicted from the fall from 60 K to 20 K in 10 s: ln(20/2)/(ln(60/20)/10 s) more
    assert texts[2] == f"20 of {20.0 + 2.302585 / 0.1098612:g}"


def test_verbosity_tells_steps_then_iterations_with_residuals(caplog):
    logger = logging.getLogger("porousmold")
    before = logger.level, logger.propagate, logger.handlers
    try:
        for verbosity, level in ((0, logging.WARNING), (1, logging.INFO), (2, logging.DEBUG), (5, logging.DEBUG)):
            log_to_console(verbosity, first_rank=False)
            assert logger.level == level
        logger.propagate = True
        problem_of(coarse_scene({"model.flow": "developed", "model.turbulence": "none"})).flow.start()
    finally:
        logger.level, logger.propagate, logger.handlers = before
    told = [record.getMessage() for record in caplog.records if "iteration" in record.getMessage()]
    assert told and all("residuals" in text for text in told)
    first, last = (float(text.split("residuals ")[1].split()[0]) for text in (told[0], told[-1]))
    assert last < 1e-6 * first or last < 1e-12


def test_all_that_the_outer_wall_exchanges_is_told():
    """A given heat flux was left out beside radiation."""
    both = outer_wall_text({"outer_emissivity": 0.9, "outer_heat_flux": -100.0})
    assert both == "radiation with an emissivity of 0.9 to the surroundings, given heat flux"
    assert "adiabatic" in outer_wall_text({})


def test_a_flow_that_reverses_has_no_heating_time_to_be_told(tmp_path):
    """It was "not reached", at a wall as warm as the inlet."""
    given = {"model.flow": "plug", "model.turbulence": "none", "operation.end_time": 20.0}
    given |= {"operation.pressure_drop": ([0.0, 10.0, 20.0], [500.0, -500.0, -500.0])}
    given |= {"operation.return_temperature": 363.15}
    scene = coarse_scene(given)
    assert "not reached" not in summary_text(scene, run(scene).summary, tmp_path, [])


def test_an_inlet_as_warm_as_the_start_has_no_heating_time(tmp_path):
    """Heat comes through the outer wall alone: no time is "not reached", and the run says how to ask for one."""
    changes = {
        "model.flow": "plug",
        "model.turbulence": "none",
        "operation.inlet_temperature": 298.15,
        "operation.outer_heat_flux": 500.0,
        "operation.end_time": 200.0,
    }
    scene = coarse_scene(changes)
    result = run(scene)
    text = summary_text(scene, result.summary, tmp_path, [])
    assert "not reached" not in text and "there is no heating time: what flows in is within 2 K" in text
    assert (
        result.summary["has_heating_time"] is False and "heating time" not in result._repr_html_().split("warnings")[0]
    )
    target = scene.changed({"target": [{"name": "warm", "place": "wall", "above": 299.0}]})
    assert not any("there is no heating time" in one for one in run(target).warnings)
