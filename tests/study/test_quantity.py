"""What uncertainty and sensitivity may ask for beside the heating time."""

import pytest

from porousmold import InputError, Scene
from porousmold.cli import main
from porousmold.scene.features.tolerances import TOLERANCES
from porousmold.study.definition import Case
from porousmold.study.quantity import Quantity, quantity_of
from porousmold.study.running import Row
from porousmold.study.sensitivity import elasticities
from porousmold.study.uncertainty import budget, without_tolerance

from ..support import ALUMINIUM, FIELD_CASES, cured_mold

HEATED = {"operation.heater_power": 9e3}
PLUG = {"model.flow": "plug", "solver.axial_cells": 8, "solver.cell_growth": 1.6}


def curing(**more):
    return cured_mold(PLUG | {"solver.step_refinement": 0.6} | more)


def test_the_first_target_is_what_a_scene_with_targets_is_about():
    quantity = quantity_of(curing(), None)
    assert quantity.record.startswith("targets.") and quantity.unit == "s" and "target" in quantity.words
    assert quantity_of(curing(**HEATED | {"operation.energy_price": 0.3}), "energy.cost").text(3.14159) == "3.1416"
    assert quantity_of(curing(), "spread_at_end").text(3.14159) == "3.1416 K"


def row(status, reason, **values):
    return Row(Case("one", {}, None), status, reason, values)


def test_what_is_counted_up_to_an_answer_is_none_of_cases_without_it():
    """A tool that never gets warm costs what its end_time says: uncertainties of the cost were several times too large."""
    cost, late = Quantity("energy.cost", "1"), "target 'hot' not met by operation.end_time 10800 s"
    met, unmet = (row("done", reason, **{"energy.cost": 0.7}) for reason in ("", late))
    assert cost.in_row(met, met) == 0.7 and cost.in_row(unmet, met) is None and cost.is_beyond(unmet, met)
    assert cost.in_row(unmet, unmet) == 0.7 and cost.in_row(met, unmet) is None and not cost.is_beyond(met, unmet)
    assert cost.reason(unmet, met) == late and "what the scene itself does not" in cost.reason(met, unmet)
    time = Quantity("targets.warm", "s")
    warm, never = (row("done", late, **{"targets.warm": value}) for value in (100.0, None))
    assert time.in_row(warm, met) == 100.0 and time.is_beyond(never, met)  # another target is not met
    negative = row("done", "", heat_stored=-4e5)
    assert "not positive" in Quantity("heat_stored", "J").reason(negative, negative)


@pytest.mark.parametrize(
    ("record", "words"),
    [
        ("nothing", "must be of heating_time"),
        ("targets.other", "its targets are"),
        ("heating_time", "ends with its targets"),
        ("last_cycle.heat_in", "needs .*operation.phase"),
    ],
)
def test_what_no_run_records_is_refused(record, words):
    with pytest.raises(InputError, match=words):
        quantity_of(curing(), record)


def test_a_cost_without_a_price_is_refused_by_the_key_that_is_missing():
    with pytest.raises(InputError, match=r"needs operation\.energy_price"):
        quantity_of(curing(**HEATED), "energy.cost")


def test_what_a_layered_wall_leaves_out_of_the_budget_is_named():
    given = {"wall.layer[1].contact_resistance": 1e-3, "bed.emissivity": 0.8}
    missing = without_tolerance(curing(**given))
    assert {"density of layers", "cure of materials.resin", "bed.emissivity"} < set(missing)
    assert any("contact_resistance" in name for name in missing)
    assert not without_tolerance(Scene.load(ALUMINIUM))


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


@pytest.fixture
def store():
    """A store that is charged, without a breakthrough, and discharged."""
    given = {"operation.mass_flow": None, "operation.inlet_temperature": None, "operation.end_time": None}
    charge = {"name": "charge", "mass_flow": 0.01, "temperature": 773.15, "duration": "1 h"}
    back = {"name": "discharge", "mass_flow": -0.01, "temperature": 298.15, "duration": "1 h"}
    more = {"operation.phase": [charge, back], "solver.axial_cells": 10}
    return Scene.load(FIELD_CASES / "17-tes-cycle" / "tes.toml", given | more)


def test_heat_of_a_charge_goes_with_its_flow_its_time_and_its_temperature(store, tmp_path):
    """m C_f (T_in - T_0) t, as what leaves is as cold as at the start: elasticities of 1."""
    heat = quantity_of(store, "last_cycle.heat_in")
    found = {entry.parameter: entry.value for entry in elasticities(store, tmp_path, heat)}
    for name in ("operation.mass_flow", "operation.inlet_temperature", "operation.phase[1].duration"):
        assert found[name] == pytest.approx(1.0, abs=0.02)
    assert abs(found["operation.phase[2].duration"]) < 0.02 and abs(found["bed.bead_diameter"]) < 0.02


def test_tolerances_of_phases_are_part_of_the_budget(store, tmp_path):
    given = dict.fromkeys((f"tolerance.{name}" for name in TOLERANCES), "0") | {"tolerance.operation.mass_flow": "10 %"}
    given |= {"tolerance.operation.inlet_temperature": "9.5 K"}
    found = budget(store.changed(given), tmp_path, quantity_of(store, "last_cycle.heat_in"))
    parts = {entry.name: entry.deviation for entry in found.contributions}
    assert parts["operation.mass_flow"] == pytest.approx(0.05, rel=0.03)
    assert parts["operation.inlet_temperature"] == pytest.approx(0.5 * 9.5 / 475.0, rel=0.03)
