"""Scenes: what is accepted, what is refused and how."""

import subprocess
import sys
import tomllib

import numpy as np
import pytest
import tomli_w
from hypothesis import example, given, settings
from hypothesis import strategies as st

from porousmold.errors import InputError
from porousmold.scene.chosen_laws import Laws
from porousmold.scene.features import KEYS
from porousmold.scene.scene import Scene

from ..support import ALUMINIUM, FRP, PIPE, STUDIES

SHIPPED = sorted([*STUDIES.glob("mold/*.toml"), *STUDIES.glob("pipe/*.toml")])


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_shipped_scenes_load_and_survive_writing_with_every_default(path, tmp_path):
    scene = Scene.load(path)
    copy = tmp_path / "scene.toml"
    copy.write_text(tomli_w.dumps(scene.as_tables()))
    assert Scene.load(copy).as_tables() == scene.as_tables()


def test_units_become_si():
    scene = Scene.load(ALUMINIUM, {"operation.inlet_temperature": "90 degC", "wall.thickness": "0.2 cm"})
    assert scene.operation.inlet_temperature(0.0) == pytest.approx(363.15)
    assert scene.wall.thickness == pytest.approx(2e-3)
    assert scene.operation.pressure_drop(5.0) == 8000.0
    assert scene.bed.bead_diameter == pytest.approx(5e-3)


def test_a_property_in_per_cent_is_that_part_of_the_law():
    given = {"wall.conductivity": "90 %", "bed.bead_heat_capacity": "105 %", "fluid.viscosity": "120 %"}
    own, plain = (Laws.of(Scene.load(PIPE, changes)) for changes in (given, {}))
    for temperature in (300.0, 340.0):
        for law, plain_law, factor in (
            (own.walls["wall"].conductivity, plain.walls["wall"].conductivity, 0.9),
            (own.beads.heat_capacity, plain.beads.heat_capacity, 1.05),
            (own.fluid.viscosity, plain.fluid.viscosity, 1.2),
        ):
            assert law(temperature) == pytest.approx(factor * plain_law(temperature), rel=1e-14)
    assert own.walls["wall"].name == "acrylic, but conductivity of the scene"


def test_thesis_scenes_hold_the_printed_numbers():
    mold, frp, pipe = Scene.load(ALUMINIUM), Scene.load(FRP), Scene.load(PIPE)
    assert (mold.geometry.length, mold.geometry.cavity_height, mold.wall.thickness) == (1.0, 0.05, 0.003)
    assert frp.wall.material == "frp" and frp.operation.heating_margin == 2.0
    assert pipe.geometry.diameter == pytest.approx(0.1016) and pipe.wall.thickness == pytest.approx(6.35e-3)
    assert pipe.operation.initial_temperature == 296.15 and pipe.operation.inlet_temperature(0.0) == 333.15


REFUSED = [
    ({"wall.thickness": "-2 mm"}, "wall.thickness"),
    ({"wall.thickness": 0}, "wall.thickness"),
    ({"wall.thickness": "2 kg"}, "wall.thickness"),
    ({"wall.thickness": True}, "wall.thickness"),
    ({"wall.thickness": [1, 2]}, "wall.thickness"),
    ({"wall.thicknes": "2 mm"}, "did you mean 'wall.thickness'"),
    ({"wal.thickness": "2 mm"}, "did you mean 'wall.thickness'"),
    ({"wall.kind": "steel"}, "layer, opposite_layer; there is 'geometry.kind'"),
    (
        {"wall.layer": [{"material": "steel", "thickness": "3 mm", "emissivity": 0.2}]},
        "wall.layer[1] has name, material",
    ),
    ({"wall.material": "tin"}, "'aluminium'"),
    ({"wall.density": float("nan")}, "finite"),
    ({"wall.density": float("inf")}, "finite"),
    ({"wall.density": "-5 %"}, "= '-5 %': must be > 0 % and <= 1000 % of the material's"),
    ({"bed.bead_heat_capacity": "nan %"}, "bed.bead_heat_capacity"),
    ({"bed.bead_diameter": "105 %"}, "bed.bead_diameter"),
    ({"fluid.density": "105 %"}, "fluid.density"),
    (
        {f"fluid.{name}": value for name, value in [("density", 1e3), ("viscosity", 1e-3), ("heat_capacity", 4e3)]}
        | {"fluid.conductivity": "90 %"},
        "has no material",
    ),
    ({"bed.bulk_porosity": 0}, "bed.bulk_porosity"),
    ({"bed.bulk_porosity": 1.0}, "bed.bulk_porosity"),
    ({"bed.bulk_porosity": 0.6, "bed.porosity_model": "cheng-hsu"}, "<= 0.5"),
    ({"bed.porosity_profile": "nowhere.csv"}, "existing file"),
    ({"wall.material": "aluminum"}, "did you mean 'aluminium'?"),
    ({"wall.thickness": "2,5 mm"}, "decimal point"),
    ({"wall.thickness": "-2 mm"}, "= '-2 mm': must be > 0"),
    ({"bed.bead_diameter": "6 mm"}, "at least 10 bead diameters"),
    ({"bed.bead_diameter": "60 mm", "bed.allow_small_ratio": True}, "bed.bead_diameter"),
    ({"geometry.kind": "sphere"}, "'mold'"),
    ({"geometry.diameter": "1 m"}, "has no place in a mold"),
    ({"operation.heating_margin": "65 K"}, "operation.heating_margin"),
    ({"operation.heating_margin": "2 degC"}, "give it in K"),
    ({"operation.inlet_velocity": 1.0}, "exactly one of"),
    ({"operation.pressure_drop": "-1 kPa"}, "operation.pressure_drop"),
    ({"operation.pressure_drop": "2 MPa"}, "outlet_pressure"),
    ({"operation.outlet_pressure": 0}, "operation.outlet_pressure"),
    ({"operation.inlet_temperature": "-300 degC"}, "operation.inlet_temperature"),
    ({"operation.inlet_temperature": "missing.csv"}, "operation.inlet_temperature"),
    ({"operation.outer_coefficient": 5.0}, "together"),
    ({"model.nusselt": "wakoa"}, "'wakao'"),
    ({"solver.axial_cells": 1}, "whole number"),
    ({"solver.axial_cells": 10.5}, "whole number"),
    ({"solver.first_cell": "30 mm"}, "solver.first_cell"),
    ({"fluid.density": 1000.0}, "all four"),
    ({"output.pictures": "maybe"}, "true or false"),
    ({"operation.blower_efficiency": 0.9}, "no meaning without a blower"),
    (
        {"operation.duct_conductance": 3.0, "operation.heater_power": "5 kW"},
        "no meaning without operation.recirculation",
    ),
    ({"bed.stirring_coefficient": 0.1}, "no meaning without bed.shear_rate"),
]


@pytest.mark.parametrize(("changes", "word"), REFUSED, ids=[",".join(changes) for changes, _ in REFUSED])
def test_bad_values_are_refused_by_one_line(changes, word):
    with pytest.raises(InputError) as caught:
        Scene.load(ALUMINIUM, changes)
    message = str(caught.value)
    assert word in message and "\n" not in message


@pytest.mark.parametrize(
    ("key", "head", "place"),
    [
        ("operation.inlet_temperature", "time [s], temperature [degC]", "at 10 s"),
        ("operation.inlet_temperature", "time [s], temperature [K], gauge [K]", None),
        ("operation.initial_temperature", "x [m], temperature [degC]", "at 10 m"),
    ],
)
def test_a_row_out_of_bounds_is_named_with_its_unit(tmp_path, key, head, place):
    path = tmp_path / "logged.csv"
    path.write_text(f"{head}\n0, 20\n10, -300\n20, 30\n")
    value: object = str(path)
    if place is None:  # a channel of a logger's file
        path.write_text(f"{head}\n0, 20, 20\n10, -5, 20\n20, 30, 20\n")
        value = {"file": str(path), "column": "temperature"}
    with pytest.raises(InputError) as caught:
        Scene.load(ALUMINIUM, {key: value})
    shown = (
        f"{key} = '{'-5' if place is None else '-26.85'} K': must be > 0 and < 5000 K (in {path}, {place or 'at 10 s'})"
    )
    assert str(caught.value) == shown


@pytest.mark.parametrize(
    "content", [b"", b"\x00\xff\xfe", b"[geometry", b"kind = 3", b"[geometry]\nkind = 'mold'\n", b"geometry = 1"]
)
def test_broken_files_are_refused_by_one_line(tmp_path, content):
    path = tmp_path / "scene.toml"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        Scene.load(path)
    assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match="no such file"):
        Scene.load(tmp_path / "absent.toml")


def test_settings_that_are_no_table_are_refused():
    with pytest.raises(InputError, match="must be a dict"):
        Scene.load(ALUMINIUM).changed([("wall.thickness", "2 mm")])


@pytest.mark.parametrize("value", ["\0", "\0.csv", 10**400])
def test_null_bytes_and_endless_integers_are_refused(value):
    for name in ("operation.inlet_temperature", "bed.porosity_profile", "geometry.length"):
        with pytest.raises(InputError, match=name):
            Scene.load(ALUMINIUM, {name: value})


names = st.sampled_from([f"{table}.{key}" for table, keys in KEYS.items() for key in keys])
values = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=20),
    st.builds(
        "{} {}".format,
        st.floats(-1e3, 1e3),
        st.sampled_from(["mm", "K", "degC", "kPa", "W/m/K", "s", "%", "1/", "m**"]),
    ),
    st.lists(st.integers(), max_size=2),
    st.dictionaries(st.text(max_size=3), st.integers(), max_size=2),
)


@settings(max_examples=400)
@example(changes={"bed.porosity_profile": "\n"})
@example(changes={"operation.inlet_temperature": "a\r\n\x1b.csv"})
@given(changes=st.dictionaries(names, values, min_size=1, max_size=3))
def test_any_value_is_accepted_or_refused_by_one_line_that_names_a_key(changes):
    try:
        scene = Scene.load(ALUMINIUM, changes)
    except InputError as error:
        message = str(error)
        assert "\n" not in message
        assert any(table in message for table in KEYS)
    else:
        tables = scene.as_tables()
        assert tomllib.loads(tomli_w.dumps(tables)) == tables


def test_overrides_leave_the_original_alone():
    scene = Scene.load(ALUMINIUM)
    changed = scene.changed({"wall.thickness": "5 mm"})
    assert scene.wall.thickness == pytest.approx(3e-3) and changed.wall.thickness == pytest.approx(5e-3)


def test_reference_page_is_what_the_program_prints():
    """In a process of its own: laws that another test registered would be listed as well."""
    printed = subprocess.run([sys.executable, "-m", "porousmold", "keys"], capture_output=True, text=True, check=True)
    page = STUDIES.parent / "docs" / "scene.md"
    assert page.read_text() == printed.stdout, "run: porousmold keys > docs/scene.md"


def test_mesh_of_a_file_takes_no_mesh_settings():
    """They would be ignored; the scene as run leaves them out, so that it can be read again."""
    curved = STUDIES / "mold" / "curved.toml"
    for name, value in (("axial_cells", 20), ("first_cell", 1e-5), ("cell_growth", 1.2), ("wall_cells", 3)):
        with pytest.raises(InputError, match=f"solver.{name}.*has no place in a mesh"):
            Scene.load(curved, {f"solver.{name}": value})
        assert name not in Scene.load(curved).as_tables()["solver"]
    Scene(Scene.load(curved).as_tables())


def test_a_scene_shows_what_it_was_given():
    scene = Scene.load(ALUMINIUM, {"wall.thickness": "2 mm"})
    assert "wall.thickness = 2 mm" in repr(scene) and "aluminium.toml" in repr(scene)
    assert "<td>wall.thickness</td><td>2 mm</td><td>thickness of the wall</td>" in scene._repr_html_()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("wall.layer.1.thickness", "did you mean 'wall.layer[1].thickness'"),
        ("target.2.above", r"did you mean 'target\[2\].above'"),
        ("wall.layer[1].thickness", r"needs tables \[\[wall.layer\]\]"),
    ],
)
def test_a_value_in_a_list_is_named_by_its_number_in_brackets(name, words):
    with pytest.raises(InputError, match=words.replace("layer[1]", r"layer\[1\]")):
        Scene.load(ALUMINIUM, {name: "2 mm"})


def test_numbers_of_numpy_are_numbers():
    """Loops over np.linspace give them."""
    values = {
        "wall.thickness": np.float32(0.002),
        "solver.axial_cells": np.int64(8),
        "output.pictures": np.bool_(False),
    }
    scene = Scene.load(ALUMINIUM, values | {"bed.bead_diameter": np.array(0.004)})
    assert scene.wall.thickness == pytest.approx(0.002) and scene.solver.axial_cells == 8
    assert scene.output.pictures is False and scene.bed.bead_diameter == 0.004
