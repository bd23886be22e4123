"""`porousmold shear`: files, summary, refusals, and ranks that share the combinations."""

import csv

import pytest

from porousmold.cli import main

from ..support import under_mpirun

SMALL = ["--shear-rate", "0.03", "--strains", "1", "--distance", "6", "--width", "5"]


def test_table_pictures_and_summary(tmp_path, capsys):
    out = tmp_path / "deep" / "shear.csv"
    arguments = [
        "shear",
        "--solid-fraction",
        "0.45",
        "0.55",
        *SMALL,
        "--biot",
        "0",
        "5",
        "--out",
        str(out),
        "--animate",
    ]
    assert main(arguments) == 0
    rows = list(csv.DictReader(out.open()))
    assert [(row["solid_fraction"], row["biot"]) for row in rows] == [
        ("0.45", "0"),
        ("0.45", "5"),
        ("0.55", "0"),
        ("0.55", "5"),
    ]
    assert float(rows[2]["conduction"]) > float(rows[0]["conduction"]) > 0.0
    assert rows[1]["stirring_coefficient"] == ""  # the film leaves the core no gradient
    assert sorted(path.name for path in out.parent.iterdir()) == ["shear.csv", "shear.gif", "shear.png"]
    text = capsys.readouterr().out
    assert "self-diffusion" in text
    assert str(out) in text


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--solid-fraction", "0.9"], "--solid-fraction = 0.9: must be"),
        (["--solid-fraction", "0.5", "--peclet", "-1"], "--peclet = -1.0: must be"),
        (["--solid-fraction", "0.5", "--walls", "0"], "--walls = '0': must be rough or flat"),
        (["--solid-fraction", "0.5", "--seed", "1.5"], "--seed = '1.5': must be a whole number"),
        (["--solid-fraction", "0.5", "--out", "shear.txt"], "--out = 'shear.txt': must end with .csv"),
        (["--solid-fraction", "dense"], "--solid-fraction = 'dense'"),
    ],
)
def test_bad_input_is_refused_in_one_line(arguments, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["shear", "--shear-rate", "0.01", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_ranks_share_the_combinations_and_write_the_same_table(tmp_path):
    tables = []
    for ranks in (1, 2):
        out = tmp_path / f"{ranks}.csv"
        arguments = ["--solid-fraction", "0.4", "0.45", "0.5", *SMALL, "--out", str(out), "--quiet"]
        assert under_mpirun(ranks, "-m", "porousmold", "shear", *arguments).returncode == 0
        tables.append(out.read_text())
    assert tables[0] == tables[1]
