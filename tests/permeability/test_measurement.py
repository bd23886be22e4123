"""Falling-head tests as files: the shipped synthetic one, and everything that scales and people do wrong."""

import json
import time

import numpy as np
import pytest

from porousmold.cli import main
from porousmold.errors import InputError
from porousmold.permeability.measurement import evaluate, read_levels, read_setup

from ..support import STUDIES
from .test_falling_head import SILICONE

SHIPPED = STUDIES / "permeability"
SETUP = """[setup]
bed_length = "101.6 mm"
pipe_diameter = "101.6 mm"
initial_head = "350 mm"
outlet_resistance = 5.93e8
outlet_pressure = "-2742 Pa"
[liquid]
name = "silicone-oil"
"""


def rows(count=400, k=1e-8):
    """Lines 'time, grams' of a test."""
    times = np.linspace(0.0, SILICONE.duration(k), count)
    return [f"{t:.6f}, {1e3 * m:.4f}" for t, m in zip(times, SILICONE.mass(times, k), strict=True)]


def pairs(lines):
    return [line.split(",") for line in lines]


def read(tmp_path, text, setup=SETUP):
    (tmp_path / "setup.toml").write_text(setup)
    (tmp_path / "data.csv").write_text(text)
    test = read_setup(tmp_path / "setup.toml")
    return test, *read_levels(tmp_path / "data.csv", test.setup, test.averaging_time)


def test_the_shipped_synthetic_test_gives_back_what_made_it(tmp_path, capsys):
    """Permeability 0.93e-8 m2, c0 5.93e8, c1 -2742, from the bed's run and the one without beads."""
    command = ["permeability", str(SHIPPED / "synthetic_bed.csv"), "--setup", str(SHIPPED / "silicone.toml")]
    assert main([*command, "--out", str(tmp_path)]) == 0
    content = json.loads((tmp_path / "permeability.json").read_text())
    complete = content["approaches"]["complete"]
    assert complete["global"]["permeability"] == pytest.approx(0.93e-8, rel=2e-3)
    assert complete["instantaneous"]["permeability"] == pytest.approx(0.93e-8, rel=0.01)
    assert content["setup"]["outlet_resistance"] == pytest.approx(5.93e8, rel=5e-3)
    assert content["setup"]["outlet_pressure"] == pytest.approx(-2742.0, rel=5e-3)
    assert content["reynolds_number"] < 0.1 and not content["warnings"]
    assert (tmp_path / "permeability.png").is_file() and (tmp_path / "permeability.csv").is_file()
    assert "macdonald predicts" in capsys.readouterr().out


@pytest.mark.parametrize(
    "change",
    [
        lambda lines: ["time [min], mass [kg]", *(f"{float(a) / 60}, {float(b) / 1e3}" for a, b in pairs(lines))],
        lambda lines: ["time [s]; mass [g]", *(r.replace(", ", ";").replace(".", ",") for r in lines)],
        lambda lines: ["# scale 7", "", "time [s]\tmass [g]", *(r.replace(", ", "\t") for r in lines)],
        lambda lines: ["time [s], level [mm]",
                       *(f"{a}, {350 - float(b) / 966.0 / SILICONE.cross_section}" for a, b in pairs(lines))],
    ],
    ids=["minutes-kilograms", "semicolons", "tabs-comments", "levels"],
)  # fmt: skip
def test_however_it_is_written_it_is_the_same_test(tmp_path, change):
    test, levels, warnings = read(tmp_path, "\n".join(change(rows())) + "\n")
    assert evaluate(test, levels)["approaches"]["complete"]["global"].permeability == pytest.approx(1e-8, rel=2e-3)
    assert not warnings


HEAD = "time [s], mass [g]\n"


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "head"),
        ("\n".join(rows()), "head with units"),
        ("time, mass\n" + "\n".join(rows()), "units"),
        ("time [s], mass [mm]\n" + "\n".join(rows()), "mass"),
        ("time [s], weight [g]\n" + "\n".join(rows()), "'mass [g]'"),
        (HEAD + "\n".join([*rows()[:50], rows()[49], *rows()[50:]]), "row 52 does not increase"),
        (HEAD + "\n".join([*rows()[:50], *rows()[48:]]), "row 52 does not increase"),
        (HEAD + "\n".join([*rows()[:50], rows()[50].replace(", ", ";"), *rows()[51:]]), "row 52 has 1 cells"),
        (HEAD + "\n".join([*rows()[:50], "9, abc"]), "'abc'"),
        (HEAD + "\n".join([*rows()[:300], "9e3, 10"]), "falls by"),
        (HEAD + "\n".join(rows()[:5]), "intervals"),
        (HEAD + "\n".join(f"{t}, 7" for t in range(20)), "running out"),
        (HEAD + "0, 0\n1, 1\n", "below 4"),
        ("time [s], level [mm]\n" + "\n".join(f"{t}, {200 - t}" for t in range(20)), "starts at 0.2 m"),
        ("time [], mass []\n" + "\n".join(rows()), "unit"),
    ],
    ids=[
        "empty",
        "no-head",
        "no-units",
        "wrong-unit",
        "wrong-name",
        "repeated",
        "decreasing",
        "mixed",
        "word",
        "falling",
        "short",
        "still",
        "few",
        "other-head",
        "empty-unit",
    ],
)
def test_bad_data_is_refused_by_one_line(tmp_path, text, word):
    with pytest.raises(InputError) as caught:
        read(tmp_path, text)
    assert word in str(caught.value) and "\n" not in str(caught.value)


def test_gaps_are_bridged_and_told(tmp_path):
    lines = rows()
    test, levels, warnings = read(tmp_path, HEAD + "\n".join([*lines[:100], *lines[150:]]))
    assert "gap of" in warnings[0] and "row 102" in warnings[0]
    assert evaluate(test, levels)["approaches"]["complete"]["global"].permeability == pytest.approx(1e-8, rel=5e-3)


def test_missing_values_are_told(tmp_path):
    lines = rows()
    lines[50] = lines[50].split(",")[0] + ","
    assert "1 missing value(s), interpolated" in read(tmp_path, HEAD + "\n".join(lines))[2][0]


def test_a_range_in_which_darcys_law_does_not_hold_is_told(tmp_path, capsys):
    """Water was promised up to where its Reynolds number is 29, at which `permeability` calls a test invalid."""
    (tmp_path / "setup.toml").write_text(SETUP + '[bed]\nbead_diameter = "0.97 mm"\n')
    assert main(["test-range", str(tmp_path / "setup.toml"), "--samples", "20", "--out", str(tmp_path / "out")]) == 0
    told = capsys.readouterr().out.splitlines()
    after_water = told[next(i for i, line in enumerate(told) if line.startswith("water")) + 1]
    assert "the particle Reynolds number exceeds 1" in after_water


@pytest.mark.parametrize("side", ["first", "last"])
def test_readings_while_nothing_runs_out_are_told(tmp_path, side):
    """Half a minute before the valve opens made the permeability 40 % too small, a plateau at the end 20 %."""
    given = np.array([[float(cell) for cell in line] for line in pairs(rows()[:280])])  # the valve is closed then
    span = given[-1, 0]
    still = np.linspace(0.005, 0.3, 60)[:, None] * span
    if side == "first":
        given = np.vstack([np.hstack([still - still[0], 0.0 * still]), given + np.array([0.3 * span, 0.0])])
    else:
        given = np.vstack([given, np.hstack([span + still, np.full_like(still, given[-1, 1])])])
    _, _, warnings = read(tmp_path, HEAD + "\n".join(f"{t:.6f}, {m:.4f}" for t, m in given))
    assert [f"nothing runs out in the {side}" in text for text in warnings] == [True]
    assert read(tmp_path, HEAD + "\n".join(rows()))[2] == ()


def test_a_million_rows_take_seconds(tmp_path):
    start = time.perf_counter()
    _, levels, _ = read(tmp_path, HEAD + "\n".join(rows(1_000_000)))
    assert len(levels.level) > 10 and time.perf_counter() - start < 60.0


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ('bed_length = "101.6 mm"\n', "", "setup.bed_length"),
        ('"350 mm"', '"350 g"', "setup.initial_head"),
        ('outlet_pressure = "-2742 Pa"\n', "", "setup.baseline"),
        ('"silicone-oil"', '"honey"', "liquid.name"),
        ('name = "silicone-oil"', "density = 900", "liquid.viscosity"),
        ('"-2742 Pa"', '"2742 Pa"', "setup.outlet_pressure"),
        ("[liquid]", 'cross_section = "81 cm^2"\n[liquid]', "setup.pipe_diameter"),
        ("[liquid]", "colour = 1\n[liquid]", "setup.colour"),
        ('outlet_pressure = "-2742 Pa"\n', 'baseline = "setup.toml"\n', "setup.baseline"),
        ('bed_length = "101.6 mm"', f"bed_length = 1{'0' * 400}", "setup.bed_length"),
    ],
)
def test_impossible_set_ups_are_refused_with_their_key(tmp_path, old, new, key):
    (tmp_path / "setup.toml").write_text(SETUP.replace(old, new))
    with pytest.raises(InputError, match=key.replace(".", r"\.")):
        read_setup(tmp_path / "setup.toml")


def test_water_is_warned_of(tmp_path):
    """Too fast for Darcy, and the set-up takes nearly all of the pressure."""
    setup = SETUP.replace("silicone-oil", "water") + '[bed]\nbead_diameter = "3.26 mm"\n'
    times = np.linspace(0.0, 250.0, 400)
    levels = 350.0 - 1.3 * times
    text = "time [s], level [mm]\n" + "\n".join(f"{t}, {h}" for t, h in zip(times, levels, strict=True))
    test, found, _ = read(tmp_path, text, setup.replace("5.93e8", "4.9e8"))
    warnings = " ".join(evaluate(test, found)["warnings"])
    assert "Darcy's law does not hold" in warnings


def test_range_of_a_set_up_by_the_command(tmp_path, capsys):
    (tmp_path / "setup.toml").write_text(SETUP)
    assert (
        main(["test-range", str(tmp_path / "setup.toml"), "--samples", "20", "--out", str(tmp_path / "out"), "--quiet"])
        == 0
    )
    content = json.loads((tmp_path / "out" / "test-range.json").read_text())
    assert content["silicone-oil"]["range"][1] > 10.0 * content["water"]["range"][1]
    assert main(["test-range", str(tmp_path / "setup.toml"), "--samples", "x"]) == 2
    assert "--samples" in capsys.readouterr().err
