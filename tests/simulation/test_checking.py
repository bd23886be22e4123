"""What `porousmold check` tells of a scene before anything is computed."""

import pytest
from mpi4py import MPI

from porousmold import InputError, Scene
from porousmold.cli import main
from porousmold.simulation.checking import check, first_cell
from porousmold.simulation.specs import specs_of

from ..support import ALUMINIUM, STUDIES, box, problem_of

CURVED = STUDIES / "mold" / "curved.toml"


def test_unknowns_are_those_that_are_solved_for():
    scene = Scene.load(ALUMINIUM, {"solver.axial_cells": 8, "solver.cell_growth": 1.6})
    facts, unknowns = " ".join(check(scene, MPI.COMM_SELF).facts), problem_of(scene).unknowns
    assert f"{unknowns['energy']} of the temperatures" in facts
    counted = int(facts.split("unknowns: about ")[1].split()[0])
    assert counted == pytest.approx(unknowns["flow"], rel=0.1)


def test_the_first_cell_is_that_of_the_mesh():
    assert first_cell(box((4, 8), width=0.5, wall=0.1)) == pytest.approx(0.5 / 8)


@pytest.mark.mpi
def test_the_check_is_the_same_on_any_number_of_ranks():
    scene = Scene.load(ALUMINIUM, {"solver.axial_cells": 8})
    assert check(scene, MPI.COMM_WORLD) == check(scene, MPI.COMM_SELF)


def mesh_like(tmp_path, **replaced):
    text = (STUDIES.parent / "meshes" / "mold.geo").read_text()
    for old, new in replaced.values():
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "mold.geo"
    path.write_text(text)
    return path


def test_a_mesh_in_millimetres_and_one_too_coarse_are_warned_of(tmp_path, capsys):
    in_mm = mesh_like(
        tmp_path, a=("length = 1.0", "length = 1000.0"), b=("width = 0.025", "width = 25"), c=("= 0.003", "= 3")
    )
    assert main(["check", str(CURVED), "--set", f"geometry.mesh={in_mm}"]) == 0
    assert "mm" in capsys.readouterr().out.split("warning: geometry.mesh")[1]
    coarse = mesh_like(tmp_path, a=("across = 22", "across = 6"))
    assert main(["check", str(CURVED), "--set", f"geometry.mesh={coarse}"]) == 0
    told = capsys.readouterr().out
    assert "times too high" in told and "see geometry.refine_wall" in told and "solver.first_cell" not in told


def test_a_programme_that_the_end_cuts_short_is_told():
    programme = ([0.0, 4000.0, 9000.0], [300.0, 360.0, 420.0])
    scene = Scene.load(ALUMINIUM, {"operation.inlet_temperature": programme, "operation.end_time": 8000.0})
    told = "end_time 8000 s is before the inlet's temperature is set last, 9000 s"
    assert any(told in text for text in check(scene, MPI.COMM_SELF).warnings)
    longer = scene.changed({"operation.end_time": 9500.0})
    assert not any("is set last" in text for text in check(longer, MPI.COMM_SELF).warnings)


def test_missing_groups_are_named_in_a_sentence(tmp_path, capsys):
    path = mesh_like(tmp_path, a=('Physical Curve("inlet")', 'Physical Curve("entry")'))
    assert main(["check", str(CURVED), "--set", f"geometry.mesh={path}"]) == 2
    error = capsys.readouterr().err
    assert "it has no physical curve named 'inlet' (physical surfaces: bed, wall; physical curves: entry" in error
    assert len(error.splitlines()) == 1


@pytest.mark.parametrize("key", ["operation.initial_temperature", "operation.inlet_temperature"])
def test_a_temperature_that_makes_nonsense_of_the_fluid_is_refused(key):
    """The density of an oil is negative there (found by the fuzz: a traceback in the middle of the run)."""
    with pytest.raises(InputError, match=r"thermal_oil density, which is given for .* has no value there"):
        specs_of(Scene.load(ALUMINIUM, {key: "2910 K", "fluid.material": "thermal_oil"}))


def test_what_developed_flow_leaves_out_of_a_flow_that_changes_is_warned_of(capsys):
    """Cold thermal oil that gets 26 times as fluid: 2 % of the heating time (full flow 277.2 s, developed 282.8 s)."""
    oil = [
        "--set",
        "fluid.material=thermal_oil",
        "--set",
        "model.turbulence=none",
        "--set",
        "operation.heating_margin=5 K",
    ]
    hot = [*oil, "--set", "operation.initial_temperature=20 degC", "--set", "operation.inlet_temperature=150 degC"]
    warm = [*oil, "--set", "operation.initial_temperature=80 degC", "--set", "operation.inlet_temperature=150 degC"]
    for settings, flow, is_told in ((hot, "developed", True), (hot, "full", False), (warm, "developed", False)):
        assert main(["check", str(ALUMINIUM), *settings, "--set", f"model.flow={flow}"]) == 0
        assert ("developed flow leaves out what crosses the bed" in capsys.readouterr().out) == is_told


def test_a_bed_of_a_few_beads_along_the_flow_is_warned_of():
    short, long = (Scene.load(ALUMINIUM, {"geometry.length": length}) for length in (0.02, 0.06))
    told = [" ".join(check(scene, MPI.COMM_SELF).warnings) for scene in (short, long)]
    assert "4 bead diameters long" in told[0] and "diameters long" not in told[1]


def test_a_run_that_may_be_repeated_is_told_of():
    """One that ends before it is heated, where cells and steps are the program's own choice."""
    short = Scene.load(ALUMINIUM, {"operation.end_time": 200.0})
    for settings, is_told in (
        ({}, True),
        ({"solver.mesh_refinement": 0.5}, False),
        ({"operation.end_time": 1e5}, False),
    ):
        facts = " ".join(check(short.changed(settings), MPI.COMM_SELF).facts)
        assert ("a front stands in the bed" in facts) == is_told
