"""The HTML page about a run or a study."""

import json
import re
import subprocess

import pytest
from mpi4py import MPI

from porousmold import InputError, Scene, run
from porousmold.cli import main
from porousmold.output.report import write_report
from porousmold.output.report_page import Markup, Section, Sentence, Table, rendered
from porousmold.output.stored import require_run
from porousmold.study.definition import Study
from porousmold.study.running import run_study

from ..support import ALUMINIUM, STUDIES, coarse_scene


def test_a_run_s_page_holds_everything_and_needs_no_network(tmp_path):
    out = tmp_path / "a <run>"
    result = run(coarse_scene({"model.turbulence": "none", "operation.heating_margin": 50.0}), out, MPI.COMM_SELF)
    page = write_report(out).read_text()
    assert f"{result.heating_time:.0f} s" in page
    assert "a &lt;run&gt;" in page and "<run>" not in page
    assert page.count('<img alt="') == 3
    assert not re.search(r'(src|href)="(?!data:)', page) and "http" not in page
    for text in (*result.summary["sources"].values(), "wall.thickness", "Macdonald"):
        assert text.split(",")[0] in page
    for warning in result.summary["warnings"]:
        assert warning[:20] in page


@pytest.mark.docs
def test_the_slider_shows_the_fields_of_another_time(tmp_path):
    """In a browser without a window (tools/docs-packages): the picture changes when the slider is moved to its end."""
    run(coarse_scene({"model.turbulence": "none", "model.flow": "plug"}), tmp_path / "run", MPI.COMM_SELF)
    page = write_report(tmp_path / "run").read_text()
    moved = """<script>window.addEventListener("load", () => setTimeout(() => {
        const picture = document.querySelector(".animation img"), slider = document.querySelector("input.anim-slider");
        const before = picture.src; slider.value = slider.max; slider.dispatchEvent(new Event("input")); slider.onchange?.();
        document.title = before !== picture.src && picture.src.startsWith("data:image/png") ? "moved" : "stuck";
    }, 500));</script>"""
    (tmp_path / "page.html").write_text(
        page.replace("</body>", f"{moved}</body>") if "</body>" in page else page + moved
    )
    command = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=5000", "--dump-dom"]
    shown = subprocess.run(
        [*command, str(tmp_path / "page.html")], capture_output=True, text=True, timeout=60, check=True
    )
    assert "<title>moved</title>" in shown.stdout


def test_a_comparison_stands_in_the_page_until_the_next_run(tmp_path):
    (tmp_path / "sensors.csv").write_text("name, x [m], y [m]\nmiddle, 0.5, 0\n")
    scene = coarse_scene(
        {
            "model.turbulence": "none",
            "model.flow": "plug",
            "operation.end_time": 200.0,
            "geometry.sensors": str(tmp_path / "sensors.csv"),
        }
    )
    out = tmp_path / "run"
    run(scene, out, MPI.COMM_SELF)
    assert "Beside the measurement" not in write_report(out).read_text()
    (tmp_path / "measured.csv").write_text("time [s], middle [degC]\n50, 30\n150, 40\n")
    assert main(["compare", str(out), str(tmp_path / "measured.csv")]) == 0
    page = write_report(out).read_text()
    assert "measurement" in page and "middle" in page and page.count('<img alt="') == 4
    run(scene, out, MPI.COMM_SELF, force=True)
    assert "Beside the measurement" not in write_report(out).read_text()


def test_a_study_s_page_has_a_row_for_every_case(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(f'[study]\nscene = "{ALUMINIUM}"\n[set]\nmodel.flow = "plug"\nsolver.axial_cells = 4\n'
                    'operation.heating_margin = "60 K"\n[vary]\nbed.bead_diameter = ["4 mm", "8 mm"]\n')  # fmt: skip
    run_study(Study.load(path), tmp_path / "out")
    page = write_report(tmp_path / "out").read_text()
    assert "1 done, 1 refused" in page and page.count("<tr>") == 3 and "at least 10 bead diameters" in page


def test_a_folder_without_a_run_is_refused(tmp_path, capsys):
    with pytest.raises(InputError, match="not the folder of a run"):
        write_report(tmp_path)
    (tmp_path / "scene.toml").write_text(ALUMINIUM.read_text())
    for content in ("{", "[]", '{"heating_time": 1}'):
        (tmp_path / "result.json").write_text(content)
        assert main(["report", str(tmp_path)]) == 2
    assert "damaged" in capsys.readouterr().err


def test_the_folder_of_another_command_is_not_called_damaged(tmp_path, capsys):
    scene = STUDIES / "beds" / "fluidised.toml"
    assert main(["fluidised", str(scene), "--out", str(tmp_path / "bed")]) == 0
    for command in ("report", "show"):
        assert main([command, str(tmp_path / "bed")]) == 2
        message = capsys.readouterr().err
        assert "damaged" not in message and ("another command" in message or "not the folder of a run" in message)


@pytest.mark.docs
def test_a_page_prints_to_pdf(tmp_path):
    run(coarse_scene({"model.flow": "plug", "operation.end_time": 50.0}), tmp_path / "run", MPI.COMM_SELF)
    page, printed = write_report(tmp_path / "run"), tmp_path / "report.pdf"
    command = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", f"--print-to-pdf={printed}", page.as_uri()]
    subprocess.run(
        command, check=True, timeout=120, capture_output=True, env={"HOME": str(tmp_path), "PATH": "/usr/bin:/bin"}
    )
    assert printed.read_bytes().startswith(b"%PDF") and printed.stat().st_size > 20_000


def test_a_tool_s_page_has_targets_energy_materials_and_what_was_given(tmp_path):
    scene = Scene.load(
        STUDIES / "mold" / "workshop.toml",
        {"operation.end_time": 60.0, "solver.axial_cells": 6, "model.flow": "plug", "output.fields": False},
    )
    run(scene, tmp_path / "run", MPI.COMM_SELF)
    page = write_report(tmp_path / "run").read_text()
    for text in (
        "Targets: not all met",
        "cured to 0.85",
        "return duct",
        "carbon_steel",
        "3 K/min",
        "half of the cavity",
    ):
        assert text in page, text
    assert "tolerance." not in page and page.count('<img alt="') == 4


def test_a_study_s_page_has_curves_or_a_map_and_its_optimum(tmp_path):
    for names, picture in ((("wall.thickness",), "curves"), (("wall.thickness", "operation.pressure_drop"), "map")):
        folder = tmp_path / picture
        folder.mkdir()
        values = [(a, b) for a in (1.0, 2.0, 3.0) for b in ((4.0, 5.0) if len(names) == 2 else (4.0,))]
        entries = [
            {
                **dict(zip(names, pair, strict=False)),
                "status": "done",
                "heating_time": sum(pair),
                "reason": "",
                "folder": "x",
            }
            for pair in values
        ]
        (folder / "table.json").write_text(json.dumps(entries))
        (folder / "table.csv").write_text(",".join([*names, "status", "heating_time [s]", "reason", "folder"]) + "\n")
        found = {name: entries[0][name] for name in (*names, "heating_time")}
        best = {
            "minimise": "heating_time",
            "below": {"heating_time": 600.0},
            "agreed": True,
            "optimum": found,
            "trade_off": [],
        }
        best["units"] = {"wall.thickness": "m", "operation.pressure_drop": "Pa", "heating_time": "s"}
        (folder / "optimum.json").write_text(json.dumps(best))
        page = write_report(folder).read_text()
        assert "Least heating_time with heating_time below 10 min: 5 s<" in page and "<td>1 m</td>" in page
        assert f'alt="{picture}"' in page


def test_a_page_s_texts_are_escaped_and_empty_sections_left_out(tmp_path):
    sections = [
        Section("Nothing", []),
        Section("Some <b>", [Sentence("a & b <i>", "large"), Table(["<u>"], [["<s>"], [1.23456789]]), Markup("<hr>")]),
    ]
    page = rendered("<title>", sections)
    assert "<h1>&lt;title&gt;</h1>" in page and "Nothing" not in page and "<hr>" in page
    assert "<h2>Some &lt;b&gt;</h2>" in page and '<p class="large">a &amp; b &lt;i&gt;</p>' in page
    assert "<th>&lt;u&gt;</th>" in page and "<td>&lt;s&gt;</td>" in page and '<td class="number">1.23457</td>' in page


def test_title_and_currency_are_the_scene_s(tmp_path):
    blower = {"operation.blower_pressure": 2e4, "operation.blower_flow": 0.3, "operation.heater_power": 2e4}
    price = {"operation.energy_price": 0.3, "operation.currency": "€", "output.title": "Our mold, trial 2"}
    scene = coarse_scene({"model.turbulence": "none", "model.flow": "plug", "operation.end_time": 60.0} | price | blower
                         | {"operation.pressure_drop": None})  # fmt: skip
    result = run(scene, tmp_path / "run", MPI.COMM_SELF)
    assert result.summary["energy"]["currency"] == "€"
    page = write_report(tmp_path / "run").read_text()
    assert "<h1>Our mold, trial 2</h1>" in page and "<td>€</td>" in page
    with pytest.raises(InputError, match=r"output.title = .*: must be a line of text"):
        scene.changed({"output.title": "two\nlines"})


def test_pictures_in_other_formats(tmp_path, capsys):
    run(coarse_scene({"model.turbulence": "none", "model.flow": "plug", "operation.end_time": 60.0}), tmp_path / "run")
    for kind, begin in (("pdf", b"%PDF"), ("svg", b"<?xml")):
        assert main(["show", str(tmp_path / "run"), "--format", kind]) == 0
        assert f"temperatures.{kind}" in capsys.readouterr().out
        assert (tmp_path / "run" / f"temperatures.{kind}").read_bytes().startswith(begin)


def test_a_run_whose_tables_were_edited_is_not_reported(tmp_path):
    """A cut history and a heating time changed by hand were taken as they stood."""
    run(coarse_scene({"model.flow": "plug", "model.turbulence": "none", "operation.end_time": 50.0}), tmp_path / "run")
    require_run(tmp_path / "run")
    table = tmp_path / "run" / "history.csv"
    table.write_text("\n".join(table.read_text().splitlines()[:-1]) + "\n")
    with pytest.raises(InputError, match="not what was written"):
        require_run(tmp_path / "run")
    assert main(["report", str(tmp_path / "run")]) == 2
