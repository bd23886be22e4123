"""The budget of a heating time against what is known of it, and against samples."""

import json
import math
from dataclasses import replace

import pytest

from porousmold import InputError, Scene
from porousmold.cli import main
from porousmold.output.report import write_report
from porousmold.scene.chosen_laws import Laws
from porousmold.scene.features.tolerances import TOLERANCES
from porousmold.study.uncertainty import (
    CELLS,
    Sample,
    alternatives_of,
    budget,
    cases_of,
    inputs_of,
    sample_cases,
    sampled,
    summary_text,
    without_tolerance,
    write,
)

from ..support import ALUMINIUM, PIPE, STUDIES, under_mpirun

PARTS = {
    "bed.bead_heat_capacity",
    "wall.heat_capacity",
    "bed.bead_density",
    "operation.pressure_drop",
    "model.drag_factor",
}
CHEAP = {
    "model.flow": "plug",
    "model.turbulence": "none",
    "solver.axial_cells": 6,
    "solver.keep_bounds": False,  # cells that are first order in one run and not in the next are noise of 1e-4 here
    "bed.porosity_model": "constant",
    **{f"tolerance.{name}": 0 for name in TOLERANCES if name not in PARTS},
}
"""Plug flow, with tolerances of a few inputs alone."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("uncertainty")


@pytest.fixture(scope="module")
def found(folder):
    return budget(Scene.load(ALUMINIUM, CHEAP), folder)


def test_inputs_are_those_of_the_scene_with_half_their_tolerance():
    mold, pipe = inputs_of(Scene.load(ALUMINIUM)), inputs_of(Scene.load(PIPE))
    assert mold["wall.thickness"] == pytest.approx((3e-3, 0.5 * 0.05 * 3e-3))
    assert mold["bed.bulk_porosity"] == pytest.approx((0.4, 0.005))
    assert mold["operation.inlet_temperature"] == pytest.approx((363.15, 0.5))
    assert "geometry.diameter" in pipe and "geometry.diameter" not in mold and "operation.mass_flow" not in mold
    given = inputs_of(Scene.load(ALUMINIUM, {"tolerance.wall.thickness": "0.1 mm", "tolerance.bed.bulk_porosity": 0}))
    assert given["wall.thickness"][1] == pytest.approx(5e-5) and "bed.bulk_porosity" not in given
    without = inputs_of(Scene.load(ALUMINIUM, {"model.wall": "insulated", "model.energy": "one-temperature"}))
    assert not [name for name in without if name.startswith("wall.")] and "model.exchange_factor" not in without


def test_tolerances_may_be_written_as_dotted_keys(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(ALUMINIUM.read_text() + '\n[tolerance]\nwall.thickness = "0.2 mm"\n"bed.bulk_porosity" = "5 %"\n')
    found = inputs_of(Scene.load(path))
    assert found["wall.thickness"][1] == pytest.approx(1e-4) and found["bed.bulk_porosity"][1] == pytest.approx(0.01)


@pytest.mark.parametrize(("name", "value"), [("wall.thickness", "1 s"), ("wall.thickness", "80 %"), ("wall.thick", "1 %"),
                                             ("bed.bulk_porosity", "-0.1")])  # fmt: skip
def test_impossible_tolerances_are_refused(name, value):
    with pytest.raises(InputError, match=f"tolerance.{name}"):
        Scene.load(ALUMINIUM, {f"tolerance.{name}": value})


def test_tolerances_are_no_part_of_a_result():
    from porousmold.scene.identity import identity_of

    assert identity_of(Scene.load(ALUMINIUM)) == identity_of(Scene.load(ALUMINIUM, {"tolerance.wall.thickness": "1 %"}))


def test_a_mesh_of_ones_own_counts_its_wall_and_its_steps():
    scene = Scene.load(STUDIES / "mold" / "curved.toml")
    assert {"wall.density", "wall.conductivity"} <= inputs_of(scene).keys() and "wall.thickness" not in inputs_of(scene)
    assert cases_of(scene)[-1].name == "finer" and cases_of(scene)[-1].scene is not None


def test_a_wall_of_given_temperature_is_refused_at_once(tmp_path, capsys):
    steel = STUDIES / "beds" / "steel_heated_from_above.toml"
    assert main(["uncertainty", str(steel), "--out", str(tmp_path / "out")]) == 2
    assert "model.wall" in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_alternatives_are_those_of_the_scene():
    assert alternatives_of(Scene.load(ALUMINIUM)) == {
        "bed.porosity_model": "hunt-tien-spheres",
        "model.turbulence": "nakayama-kuwahara",
    }
    assert alternatives_of(Scene.load(ALUMINIUM, CHEAP)) == {}


def test_solid_heat_sets_the_time_scale(found):
    """The time follows the heat capacity of beads and wall: 3 % of both are 3 % of it. Its middle is the scene's own time, as
    no law has an alternative; the interval holds 1.96 standard deviations."""
    parts = {entry.name: entry.deviation for entry in found.contributions}
    assert parts["bed.bead_heat_capacity"] + parts["wall.heat_capacity"] == pytest.approx(0.015, rel=0.02)
    assert parts["bed.bead_density"] / parts["bed.bead_heat_capacity"] == pytest.approx(1.0 / 3.0, rel=0.02)
    assert parts["operation.pressure_drop"] < 0.0 < parts["model.drag_factor"]
    assert found.middle == found.value
    assert math.log(found.high / found.low) == pytest.approx(2 * 1.96 * found.deviation)
    assert sum(found.shares.values()) == pytest.approx(1.0)
    assert [abs(entry.deviation) for entry in found.contributions] == sorted(map(abs, parts.values()), reverse=True)


def test_drag_enters_as_the_pressure_drop_does(found):
    """Without inertia and compressibility one per cent more drag is one per cent less pressure; here the gas expands as well."""
    parts = {entry.name: entry.deviation for entry in found.contributions}
    assert parts["model.drag_factor"] / 0.075 == pytest.approx(-parts["operation.pressure_drop"] / 0.01, rel=0.06)


def test_a_sample_has_the_budgets_deviation(found, folder):
    """24 cases: the standard deviation of so few is itself uncertain by 15 %."""
    scene = Scene.load(ALUMINIUM, CHEAP)
    sample = sampled(scene, folder / "sample", 24, 1)
    assert sample.answered == 24
    assert sample.deviation == pytest.approx(found.of_inputs, rel=0.3)
    cells = next(one.deviation for one in found.contributions if one.name == CELLS)
    assert math.hypot(found.of_inputs, cells) == pytest.approx(found.deviation, rel=1e-9)
    assert sample.low < sample.median < sample.high
    assert sample.median == pytest.approx(found.value, rel=0.03)
    first, second = (sample_cases(scene, 3, seed)[0].settings for seed in (1, 2))
    assert first != second and first == sample_cases(scene, 3, 1)[0].settings
    assert "sampled" in summary_text(found, sample)


def test_the_budget_is_written_and_reported(found, folder):
    first, *others = found.contributions
    found = replace(found, contributions=(replace(first, reason="below it there is no answer"), *others))
    assert all(path.is_file() for path in write(found, None, folder))
    content = json.loads((folder / "uncertainty.json").read_text())
    assert content["deviation"] == pytest.approx(found.deviation) and len(content["contributions"]) == len(
        found.contributions
    )
    page = write_report(folder).read_text()
    assert "95 % within" in page and "model.drag_factor" in page
    assert "below it there is no answer" in page


def test_a_sample_of_which_some_never_answer_is_strict_json(found, folder, tmp_path):
    some = Sample(12, 9, 0.1, 100.0, math.inf, math.inf)
    write(found, some, tmp_path)
    text = (tmp_path / "uncertainty.json").read_text()
    assert json.loads(text, parse_constant=pytest.fail)["sample"]["high"] is None
    assert "100 to beyond the end of the run" in summary_text(found, some)


def test_the_command_goes_on_where_it_was(found, folder):
    """On two ranks, in the folder of the finished budget: nothing is run again."""
    settings = [option for name, value in CHEAP.items() for option in ("--set", f"{name}={json.dumps(value)}")]
    before = {path: path.stat().st_mtime_ns for path in folder.glob("*/result.json")}
    ran = under_mpirun(2, "-m", "porousmold", "uncertainty", str(ALUMINIUM), *settings, "--out", str(folder))
    assert ran.returncode == 0 and f"{found.value:.0f} s, 95 % within" in ran.stdout
    assert before == {path: path.stat().st_mtime_ns for path in folder.glob("*/result.json")}
    assert len(before) == len(cases_of(Scene.load(ALUMINIUM, CHEAP)))


def test_impossible_options_are_refused(capsys):
    assert main(["uncertainty", str(ALUMINIUM), "--sample", "1"]) == 2
    assert main(["uncertainty", str(ALUMINIUM), "--seed", "-1"]) == 2
    assert main(["uncertainty", "absent.toml"]) == 2
    told = capsys.readouterr().err
    assert "--sample" in told and "--seed" in told and "absent.toml" in told


def test_layers_are_varied_and_what_is_not_is_named():
    """Their conductivities, and a blower's curve, were neither: 10 % of an insulation's decided whether a part cured."""
    scene = Scene.load(STUDIES / "mold" / "workshop.toml")
    found = inputs_of(scene)
    for place in ("wall.layer[1]", "wall.layer[3]"):
        for name, part in (("thickness", 0.05), ("heat_capacity", 0.03), ("conductivity", 0.05)):
            value, deviation = found[f"{place}.{name}"]
            assert deviation == pytest.approx(0.5 * part * value)
    changed = scene.changed({"tolerance.wall.conductivity": "10 %"})
    assert inputs_of(changed)["wall.layer[3].conductivity"][1] == pytest.approx(
        2.0 * found["wall.layer[3].conductivity"][1]
    )
    named = without_tolerance(scene)
    assert "operation.blower" in named and "cure of materials.prepreg" in named and "materials.prepreg" not in named


def test_a_layer_s_own_property_replaces_a_part_of_its_material_s_law():
    scene = Scene.load(STUDIES / "mold" / "workshop.toml")
    own, changed = (Laws.of(one).walls for one in (scene, scene.changed({"wall.layer[3].conductivity": "110 %"})))
    name = scene.wall.layer[2].name or scene.wall.layer[2].material
    for temperature in (300.0, 400.0):
        ratio = changed[name].conductivity(temperature) / own[name].conductivity(temperature)
        assert ratio == pytest.approx(1.1)
    number = Laws.of(scene.changed({"wall.layer[3].conductivity": 0.05})).walls[name]
    assert number.conductivity(400.0) == pytest.approx(0.05)


def test_a_tolerance_of_what_changes_in_time_is_refused():
    """It was ignored in silence."""
    series = {
        "operation.inlet_temperature": ([0.0, 100.0], [300.0, 360.0]),
        "tolerance.operation.inlet_temperature": "2 K",
    }
    with pytest.raises(InputError, match="no single value"):
        inputs_of(
            Scene.load(ALUMINIUM, {"operation.inlet_temperature": ([0.0, 100.0], [300.0, 360.0])}).changed(series)
        )


@pytest.mark.parametrize(
    ("name", "given", "told"),
    [
        ("wall.thickness", 0.1, "must be below half of wall.thickness = 0.003 m"),
        ("operation.inlet_temperature", "1 %", "must be in K"),
        ("operation.mass_flow", "2 %", "is no input of this scene"),
    ],
)
def test_a_tolerance_that_cannot_be_meant_is_refused(name, given, told):
    """0.1 for 0.1 mm counted as nothing and made the interval narrower; 1 % of a temperature counted from 0 K."""
    with pytest.raises(InputError, match=told):
        inputs_of(Scene.load(ALUMINIUM, {f"tolerance.{name}": given}))


def test_an_input_with_an_answer_on_one_side_alone_is_told(found):
    """Its interval is mirrored: no run has shown the other side; and what has no answer counts as 0."""
    assert found.doubt == "" and "warning" not in summary_text(found, None)
    first, second, *others = found.contributions
    lame = (replace(first, reason=f"of {first.name},up alone"), replace(second, deviation=None, reason="not reached"))
    doubtful = replace(found, contributions=(*lame, *others))
    text = summary_text(doubtful, None)
    count = len(found.contributions)
    assert f"1 of {count} have an answer on one side alone" in text and f"1 of {count} have none" in text
    assert f"(of {first.name},up alone)" in text
