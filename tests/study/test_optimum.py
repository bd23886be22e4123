"""The search for the best parameters, on surfaces whose minima are known and on the mold."""

import json
import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from porousmold import InputError
from porousmold.cli import main
from porousmold.study.definition import Case, Study
from porousmold.study.optimum import Aim, _Surface, best, front, load
from porousmold.study.running import Row

from ..support import ALUMINIUM

TEXT = f"""
[study]
scene = "{ALUMINIUM}"
record = ["heating_time", "mean_power", "energy_spent"]
[set]
model.turbulence = "none"
model.flow = "plug"
solver.axial_cells = 4
operation.heating_margin = "30 K"
[vary]
operation.pressure_drop = {{ from = "2 kPa", to = "16 kPa", count = 4, spacing = "geometric" }}
[optimum]
below = {{ mean_power = "3 kW" }}
trade_off = "energy_spent"
"""


def analytic_rows():
    """time = 1/(p^0.7 d^0.5), power = p d^2, on a grid of p in 1 to 16 and d in 1 to 4."""
    rows = []
    for p in np.geomspace(1.0, 16.0, 5).round(4):
        for d in np.geomspace(1.0, 4.0, 4).round(4):
            case = Case(f"{p},{d}", {"operation.pressure_drop": p, "bed.bead_diameter": d}, None)
            rows.append(Row(case, "done", "", {"heating_time": p**-0.7 * d**-0.5, "mean_power": p * d**2}))
    return rows


def test_power_laws_are_met_exactly_and_so_is_their_minimum_under_a_limit():
    """On the limit p d^2 = 8 the time is 8^-0.7 d^0.9: the least d, 1, is best, with p = 8."""
    rows = analytic_rows()
    study = Study([row.case for row in rows], ["operation.pressure_drop", "bed.bead_diameter"])
    surface = _Surface(study, rows, ["heating_time", "mean_power"])
    place = surface.minimum("heating_time", {"mean_power": 8.0})
    found = surface.settings(place)
    assert found["operation.pressure_drop"] == pytest.approx(8.0, rel=2e-3)
    assert found["bed.bead_diameter"] == pytest.approx(1.0, rel=2e-3)
    assert surface("heating_time", place) == pytest.approx(-0.7 * math.log(8.0), abs=2e-3)
    free = surface.settings(surface.minimum("heating_time", {}))
    assert free == pytest.approx({"operation.pressure_drop": 16.0, "bed.bead_diameter": 4.0})


def test_a_place_run_under_two_names_counts_once():
    """'16' and 16.0 are the same place: twice in the interpolation it would be singular."""
    rows = analytic_rows()
    twin = Row(Case("twin", {"operation.pressure_drop": 16, "bed.bead_diameter": 4}, None), "done", "", rows[-1].values)
    surface = _Surface(Study([], ["operation.pressure_drop", "bed.bead_diameter"]), [*rows, twin], ["heating_time"])
    assert surface.settings(surface.minimum("heating_time", {})) == pytest.approx(
        {"operation.pressure_drop": 16.0, "bed.bead_diameter": 4.0}
    )


def test_runs_that_do_not_reach_their_target_are_none_of_the_surface():
    """The cheapest runs are those that never get warm, below p = 5: the search comes from above, by halves."""
    names, text = ["operation.pressure_drop", "bed.bead_diameter"], "target 'warm' not met by operation.end_time"
    rows = [
        replace(row, reason=text, values={"mean_power": 0.1}) if row.case.settings[names[0]] < 5.0 else row
        for row in analytic_rows()
    ]
    for _ in range(6):
        surface = _Surface(Study([], names), rows, ["mean_power"])
        settings = surface.settings(surface.minimum("mean_power", {}))
        p, d = (settings[name] for name in names)
        if any(row.case.settings == settings for row in rows):
            break
        power = {"mean_power": p * d**2 if p > 5.0 else 0.1}
        rows.append(Row(Case(f"{p} {d}", settings, None), "done", "" if p > 5.0 else text, power))
    assert d == 1.0 and 5.0 < min(row.values["mean_power"] for row in rows if row.is_reached) < 6.0


def test_too_few_places_to_search_between_are_refused():
    rows = [row for row in analytic_rows() if row.case.settings["operation.pressure_drop"] == pytest.approx(16.0)]
    with pytest.raises(InputError, match="too few"):
        _Surface(Study([], ["operation.pressure_drop", "bed.bead_diameter"]), rows, ["heating_time"])


def test_best_and_front_are_rows_that_nothing_beats():
    rows = analytic_rows()
    assert best(rows, "heating_time", {"mean_power": 0.5}) is None
    least = best(rows, "heating_time", {"mean_power": 4.0})
    assert least.values["mean_power"] <= 4.0 * 1.003
    kept = front(rows, Aim("heating_time", {}, "mean_power"))
    assert all(a.values["heating_time"] > b.values["heating_time"] for a, b in pairwise(kept))
    for row in kept:
        assert not [
            other for other in rows
            if other.values["heating_time"] < row.values["heating_time"] and other.values["mean_power"] < row.values["mean_power"]
        ]  # fmt: skip


def test_the_mold_heats_fastest_at_the_power_there_is(tmp_path, capsys):
    """More pressure heats faster and takes more power: the optimum lies on the limit."""
    path, out = tmp_path / "search.toml", tmp_path / "out"
    path.write_text(TEXT)
    assert main(["optimum", str(path), "--out", str(out)]) == 0
    assert "least heating_time with mean_power below 3 kW" in (told := capsys.readouterr().out)
    assert " min\n" in told and " kPa" in told
    content = json.loads((out / "optimum.json").read_text())
    assert content["agreed"]
    assert content["optimum"]["mean_power"] == pytest.approx(3e3, rel=0.005)
    times = [entry["heating_time"] for entry in content["trade_off"]]
    assert len(times) >= 5 and times == sorted(times, reverse=True)
    assert (out / "trade_off.png").is_file()
    before = (out / "table.csv").read_bytes()
    assert main(["optimum", str(path), "--out", str(out), "--quiet"]) == 0  # nothing is run again
    assert (out / "table.csv").read_bytes() == before


def test_the_cheapest_run_that_never_gets_warm_is_no_answer(tmp_path, capsys):
    """At low pressure the target is not met by the end; the least energy is that of a run that meets it."""
    path, out, scene = tmp_path / "search.toml", tmp_path / "out", tmp_path / "scene.toml"
    scene.write_text(ALUMINIUM.read_text() + '[[target]]\nname = "warm"\nabove = "70 degC"\n')
    text = TEXT.replace(str(ALUMINIUM), str(scene)).replace(
        '"heating_time", "mean_power"', '"targets.warm", "mean_power"'
    )
    text = (
        text.replace("count = 4", "count = 6")
        .replace("[vary]", 'operation.end_time = "30 min"\n[vary]')
        .replace('below = { mean_power = "3 kW" }', "")
    )
    text = text.replace('trade_off = "energy_spent"', 'minimise = "energy_spent"\ntrade_off = "targets.warm"')
    path.write_text(text)
    assert main(["optimum", str(path), "--out", str(out), "--quiet"]) == 0
    content = json.loads((out / "optimum.json").read_text())
    assert content["optimum"]["targets.warm"] < 1800.0
    assert all(entry["targets.warm"] < 1800.0 for entry in content["trade_off"])
    rows = json.loads((out / "table.json").read_text())
    unmet = [row for row in rows if row["targets.warm"] is None]
    assert unmet and all("target 'warm' not met" in row["reason"] for row in unmet)
    assert min(row["energy_spent"] for row in unmet) < content["optimum"]["energy_spent"]


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ('mean_power = "3 kW"', 'mean_power = "3 km"', "optimum.below.mean_power"),
        ('mean_power = "3 kW"', "time_steps = 5", "optimum.below"),
        ('mean_power = "3 kW"', "mean_power = -1", "optimum.below.mean_power"),
        ('mean_power = "3 kW"', "energy.cost = 3", 'stands in quotes: "energy.cost"'),
        ('"energy_spent"\n', '"heating_time"\n', "optimum.trade_off"),
        ("count = 4", "count = 2", "vary.operation.pressure_drop"),
        ("trade_off", "tradeoff", "optimum.tradeoff"),
        ("[optimum]", "solver.wall_cells = [1, 2, 3]\n[optimum]", "vary.solver.wall_cells"),
    ],
)
def test_impossible_aims_are_refused_with_their_key(tmp_path, old, new, key):
    path = tmp_path / "search.toml"
    path.write_text(TEXT.replace(old, new))
    with pytest.raises(InputError, match=key.replace(".", r"\.")):
        load(path)
