"""What uncertainty and sensitivity may ask for beside the heating time."""

import pytest

from porousmold import InputError
from porousmold.cli import main
from porousmold.study.quantity import quantity_of
from porousmold.study.sensitivity import elasticities
from porousmold.study.uncertainty import budget

from ..support import ALUMINIUM, cured_mold

PLUG = {"model.flow": "plug", "solver.axial_cells": 8, "solver.cell_growth": 1.6}


def curing(**more):
    return cured_mold(PLUG | {"solver.step_refinement": 0.6} | more)


def test_the_first_target_is_what_a_scene_with_targets_is_about():
    quantity = quantity_of(curing(), None)
    assert quantity.record.startswith("targets.") and quantity.unit == "s" and "target" in quantity.words
    assert quantity_of(curing(), "energy.cost").text(3.14159) == "3.1416"
    assert quantity_of(curing(), "spread_at_end").text(3.14159) == "3.1416 K"


@pytest.mark.parametrize(
    ("record", "words"), [("nothing", "must be of heating_time"), ("targets.other", "its targets are")]
)
def test_what_no_run_records_is_refused(record, words):
    with pytest.raises(InputError, match=words):
        quantity_of(curing(), record)


def test_a_scene_without_the_answer_is_refused_before_the_other_runs(tmp_path):
    short = curing(**{"operation.end_time": 60.0})
    for study in (budget, elasticities):
        with pytest.raises(InputError, match="has no time of target"):
            study(short, tmp_path / study.__name__)
        assert len(list((tmp_path / study.__name__).glob("*/"))) == 1


@pytest.mark.slow
def test_a_part_cures_later_with_a_thicker_skin_and_sooner_with_more_pressure(tmp_path):
    found = {entry.parameter: entry.value for entry in elasticities(curing(), tmp_path)}
    assert found["wall.layer[1].thickness"] > 0.0 > found["operation.pressure_drop"]
    assert found["operation.inlet_temperature"] < 0.0


@pytest.mark.slow
def test_uncertainty_of_the_pumping_work(tmp_path, capsys):
    settings = [part for name, value in PLUG.items() for part in ("--set", f"{name}={value}")]
    command = ["uncertainty", str(ALUMINIUM), *settings, "--of", "pumping_work", "--out", str(tmp_path)]
    assert main(command) == 0
    told = capsys.readouterr().out
    assert "pumping work: " in told and " J, 95 % within" in told and "operation.pressure_drop" in told
