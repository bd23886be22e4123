"""The worked examples of docs/extending.md, and what becomes of laws that are wrong."""

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

import porousmold as pm
from porousmold import InputError, Scene, run
from porousmold.cli import main
from porousmold.scene.identity import identity_of

from .support import ALUMINIUM, COARSE

PAGE = (Path(__file__).parents[1] / "docs" / "extending.md").read_text(encoding="utf-8")
SMALL = COARSE | {
    "operation.end_time": 400.0,
    "solver.first_step": 1.0,
    "output.pictures": False,
    "output.fields": False,
}


def examples():
    """(title, Python text, settings of the scene that follows it) of every section that has both."""
    for section in PAGE.split("\n## ")[1:]:
        blocks = dict(reversed(re.findall(r"```(python|toml)\n(.*?)```", section, re.DOTALL)))
        if {"python", "toml"} <= blocks.keys():
            tables = tomllib.loads(blocks["toml"])
            settings = {f"{table}.{key}": value for table, keys in tables.items() for key, value in keys.items()}
            yield section.split("\n")[0], blocks["python"], settings


@pytest.mark.parametrize(("title", "code", "settings"), [pytest.param(*each, id=each[0]) for each in examples()])
def test_every_example_runs_in_its_scene(title, code, settings, tmp_path):
    """With the law's source in the result, another answer than without it, and heat that is accounted for."""
    path = tmp_path / "mylaws.py"
    path.write_text(code, encoding="utf-8")
    given = SMALL | settings | {"extensions.python": str(path)}
    with pytest.raises(InputError, match="--allow-extensions"):
        Scene.load(ALUMINIUM, given)
    scene = Scene.load(ALUMINIUM, given, allow_extensions=True)
    ours = run(scene).summary
    plain = {key: value for key, value in settings.items() if value == "none"}
    theirs = run(Scene.load(ALUMINIUM, SMALL | plain)).summary
    assert abs(ours["energy_imbalance"]) < 1e-3
    assert [ours[name] for name in ("sources", "materials")] != [theirs[name] for name in ("sources", "materials")]
    assert ours["heat_by_fluid"] != pytest.approx(theirs["heat_by_fluid"], rel=1e-4)


def test_the_script_of_the_page_runs(capsys):
    code = re.findall(r"```python\n(.*?)```", PAGE.split("## In a script")[1], re.DOTALL)[0]
    exec(compile(code, "script.py", "exec"), {"__name__": "script"})
    heating_time, highest, unit = capsys.readouterr().out.split()
    assert 500.0 < float(heating_time) < 4000.0 and 361.0 < float(highest) < 363.2 and unit == "K"


def test_the_text_of_a_law_is_part_of_the_identity(tmp_path):
    """Another number in the law's formula is another run; a comment beside it is none."""
    text = "import porousmold as pm\n@pm.nusselt('n', reynolds=(1, 1e4), source='s')\ndef n(re, pr, phi):\n    return {} + re\n"

    def identity(content):
        path = tmp_path / "mylaws.py"
        path.write_text(content)
        settings = {"extensions.python": str(path), "model.nusselt": "n"}
        return identity_of(Scene.load(ALUMINIUM, settings, allow_extensions=True))

    first = identity(text.format(2.0))
    assert identity("# what this file is for\n" + text.format(2.0)) == first
    assert identity(text.format(3.0)) != first


def register(function, kind=pm.nusselt, **options):
    kind("tried", source="test", **({"reynolds": (1, 1e4)} if kind is pm.nusselt else {}) | options)(function)


@pytest.mark.parametrize(
    ("law", "word"),
    [
        (lambda: register(lambda re, pr, phi: re / 0.0 * 0.0), "finite"),
        (lambda: register(lambda re, pr, phi: re[:3]), "shape"),
        (lambda: register(lambda re, pr: re), "TypeError"),
        (lambda: register(lambda re, pr, phi: np.sqrt(re)), "UFL"),
        (lambda: register(lambda s, bulk: 2.0 + 0.0 * s, pm.porosity), r"\(0, 1\]"),
        (lambda: register(lambda phi, d, rho, mu, u: 1.0 / u, pm.drag), "finite"),
        (lambda: register(lambda bed: np.exp(-bed.porosity), pm.dispersion), "UFL"),
        (lambda: register(lambda bed: -1.0 + 0.0 * bed.porosity, pm.dispersion), "negative"),
        (lambda: register(lambda bed: pm.Anisotropic(1.0, 2.0), pm.bead_conduction, whole_bed=True), "one number"),
        (lambda: pm.register(pm.Solid("x", density=-1.0, heat_capacity=1.0, conductivity=1.0)), "positive"),
        (lambda: pm.register(pm.Solid("aluminium", density=1.0, heat_capacity=1.0, conductivity=1.0)), "has"),
        (lambda: pm.nusselt("wakao", reynolds=(1, 10), source="s")(lambda re, pr, phi: re + 0.0), "has"),
    ],
)
def test_wrong_laws_are_refused_with_one_line(law, word):
    with pytest.raises(InputError, match=word) as caught:
        law()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("law", "word"),
    [
        (lambda: register(lambda re, pr, phi: -8.0 + 1.1 * re**0.6 * pr ** (1 / 3)), "must be positive over its range"),
        (lambda: register(lambda prandtl, reynolds, porosity: reynolds + prandtl), "in the order reynolds, prandtl"),
        (lambda: register(lambda phi, d, rho, mu, speed: 100.0 * speed - 1.0, pm.drag), "must be positive for"),
        (lambda: register(lambda y, phi: 0.9 - 0.04 * y, pm.porosity), "up to 1000 bead diameters"),
        (lambda: hot_solid("kJ/(kg K)"), r"must be in J/\(kg\*K\)"),
    ],
)
def test_laws_of_the_wrong_sign_order_or_unit_are_refused(law, word):
    with pytest.raises(InputError, match=word):
        law()


def hot_solid(unit):
    """A solid whose conductivity makes no sense at room temperature, which it is not for."""
    hot = (600.0, 1200.0)
    return pm.register(
        pm.Solid(
            f"hot {unit}",
            3000.0,
            pm.Polynomial((900.0,), unit, "test", hot),
            pm.Polynomial((-10.0, 0.03), "W/(m K)", "test", hot),
            "test",
        )
    )


def test_a_law_is_tried_over_its_own_range():
    assert hot_solid("J/(kg K)").conductivity(1000.0) == pytest.approx(20.0)


def test_a_broken_file_is_refused_with_one_line(tmp_path, capsys):
    (tmp_path / "mylaws.py").write_text("1 / 0\n")
    scene = tmp_path / "scene.toml"
    scene.write_text(ALUMINIUM.read_text() + '\n[extensions]\npython = "mylaws.py"\n')
    assert main(["run", str(scene), "--out", str(tmp_path / "out"), "--allow-extensions"]) == 2
    told = capsys.readouterr().err
    assert "ZeroDivisionError" in told and told.count("\n") == 1
    assert main(["run", str(scene), "--out", str(tmp_path / "out")]) == 2
    assert "--allow-extensions" in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_values_of_every_kind_give_the_same_scene():
    """A CSV file apart: (times, values), a function and texts with units."""
    base = Scene.load(ALUMINIUM)
    pair = base.changed({"operation.inlet_temperature": ([0, 100], ["25 degC", "90 degC"])})
    line = base.changed({"operation.inlet_temperature": lambda t: min(298.15 + 0.65 * t, 363.15)})
    for time in (0.0, 33.0, 100.0, 5000.0):
        there = pair.operation.inlet_temperature(time), line.operation.inlet_temperature(time)
        assert there[0] == pytest.approx(there[1], abs=0.02)
    assert pair.operation.inlet_temperature.breakpoints == (0.0, 100.0)
    assert all(abs(instant - 100.0) < 0.2 for instant in line.operation.inlet_temperature.breakpoints)
    jump = base.changed({"operation.inlet_temperature": lambda t: 363.15 if t > 60.0 else 300.0})
    assert all(abs(instant - 60.0) < 0.2 for instant in jump.operation.inlet_temperature.breakpoints)
    assert len(jump.operation.inlet_temperature.breakpoints) >= 2
    with pytest.raises(InputError, match="inlet_temperature"):
        base.changed({"operation.inlet_temperature": lambda t: 1.0 / 0.0})
    with pytest.raises(InputError, match="one length"):
        base.changed({"operation.inlet_temperature": ([0, 1, 2], [300, 350])})


def test_a_scene_is_frozen():
    scene = Scene.load(ALUMINIUM)
    with pytest.raises(AttributeError, match="frozen"):
        scene.wall.thickness = -5
    with pytest.raises(AttributeError, match="frozen"):
        scene.wall = None
    with pytest.raises(AttributeError, match="no key"):
        _ = scene.wall.thicknes
