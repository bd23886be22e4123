"""What a result belongs to: the scene, its files, the laws from outside, and the code."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import porousmold
from porousmold.scene.identity import COMPUTING, code_digest, digest_of, identity_of
from porousmold.scene.scene import Scene

from ..support import ALUMINIUM


def test_identity_tells_scenes_apart_by_what_they_compute(tmp_path):
    scene = Scene.load(ALUMINIUM)
    other_file = tmp_path / "copy.toml"
    other_file.write_text(ALUMINIUM.read_text())
    assert identity_of(Scene.load(other_file, {"output.pictures": False})) == identity_of(scene)
    assert identity_of(Scene.load(ALUMINIUM, {"wall.thickness": "2 mm"})) != identity_of(scene)
    inlet = tmp_path / "inlet.csv"
    found = []
    for value in (90, 91):
        inlet.write_text(f"time [s], temperature [degC]\n0, 25\n60, {value}\n")
        found.append(identity_of(Scene.load(ALUMINIUM, {"operation.inlet_temperature": str(inlet)})))
    assert found[0] != found[1]


def test_a_result_of_other_formulas_is_not_handed_out(tmp_path):
    """The package with one number of a law changed does not take the old result for its own, and says something else."""
    package = tmp_path / "changed" / "porousmold"
    shutil.copytree(Path(porousmold.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__"))
    drag = package / "laws" / "drag.py"
    text = drag.read_text()
    assert "ergun_form(180.0, 1.8," in text
    drag.write_text(text.replace("ergun_form(180.0, 1.8,", "ergun_form(180.0, 2.4,"))
    plug = ("--set", "model.flow=plug", "--set", "solver.mesh_refinement=0.3", "--set", "output.fields=false")

    def run_with(root):
        command = [sys.executable, "-m", "porousmold", "run", str(ALUMINIUM), *plug, "--quiet", "--resume", "--force"]
        done = subprocess.run(
            [*command, "--set", "output.pictures=false", "--out", str(tmp_path / "run")],
            env={"PATH": "/usr/bin:/bin", "PYTHONPATH": str(root), "HOME": str(Path.home())},
            cwd=tmp_path,  # else Python imports the package that lies there
            capture_output=True,
            text=True,
            timeout=300,
        )
        assert done.returncode == 0, done.stderr
        return json.loads((tmp_path / "run" / "result.json").read_text())

    old = run_with(Path(porousmold.__file__).parent.parent)
    again = run_with(Path(porousmold.__file__).parent.parent)
    assert again["wall_seconds"] == old["wall_seconds"], "the same code gives what is there"
    new = run_with(package.parent)
    assert new["identity"] != old["identity"] and new["heating_time"] > 1.02 * old["heating_time"]
    assert {"dolfinx", "petsc"} <= new["versions"].keys()


def test_the_code_that_draws_and_reports_does_not_count(tmp_path):
    """Only what computes is hashed: a digest of laws, mesh, equations, solvers and simulation."""
    assert len(code_digest()) == 64 and code_digest() == code_digest()


def test_every_source_that_computes_is_part_of_the_identity(tmp_path):
    """A result of other code is no answer, whichever file of the rooms that compute has changed."""
    package = tmp_path / "porousmold"
    shutil.copytree(Path(porousmold.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__"))
    before = digest_of(package, COMPUTING)
    assert before == code_digest()
    files = [
        path for room in COMPUTING for path in (package / room).rglob("*") if path.suffix in (".py", ".toml", ".csv")
    ]
    assert len(files) > 80
    for path in files:
        content = path.read_bytes()
        path.write_bytes(content + b"\n")
        assert digest_of(package, COMPUTING) != before, path
        path.write_bytes(content)
    for room in ("output", "study", "packing"):  # what only shows, repeats or prepares
        next((package / room).glob("*.py")).write_text("changed")
    assert digest_of(package, COMPUTING) == before
