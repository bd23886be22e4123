"""Conduction through a packing: equal conductivities, a lattice, contacts, bounds, and what is refused."""

import json

import numpy as np
import pytest

from porousmold import InputError
from porousmold.cli import main
from porousmold.packing.conduction import conduction, hertz_contact_radius, line_conductance, pair_conductance
from porousmold.packing.container import Slab, container
from porousmold.packing.files import write_packing
from porousmold.packing.generator import Mixture, pack
from porousmold.packing.packing import Packing
from studies.lattices import LATTICES, network, resolved

ACROSS, WIDTH = 10, 6


def lattice(gap=0.0):
    """Simple cubic lattice with spacing 1 between walls in its planes of symmetry."""
    counts = (ACROSS, WIDTH, WIDTH)
    places = np.stack(np.meshgrid(*(np.arange(count) + 0.5 for count in counts), indexing="ij"), axis=-1).reshape(-1, 3)
    places -= [0.5 * ACROSS, 0.5 * WIDTH, 0.0]
    places += 1e-7 * np.random.default_rng(0).standard_normal(places.shape)  # Voronoi cells of a lattice are degenerate
    return Packing(places, np.full(len(places), 1.0 - gap), Slab(float(ACROSS), float(WIDTH)))


@pytest.fixture(scope="module")
def poured():
    return pack(container("slab", {"gap": 0.05, "width": 0.035}), Mixture((0.005,)), bed_height=0.06)


def test_equal_conductivities_give_that_conductivity(poured):
    """In a lattice and a poured bed alike, from wall to wall."""
    assert conduction(lattice(), 3.0, 3.0, height=float(WIDTH)).core == pytest.approx(3.0, rel=1e-4)
    found = conduction(poured, 0.7, 0.7)
    assert found.overall == pytest.approx(0.7, rel=0.02) and found.core == pytest.approx(0.7, rel=0.02)


def test_a_lattice_conducts_as_one_pair_of_its_beads():
    for ratio, gap in ((10.0, 0.0), (300.0, 0.02)):
        one = pair_conductance(0.5 * (1.0 - gap), np.array([0.5 * gap]), np.array([1.0 / np.sqrt(np.pi)]), ratio, 1.0)
        found = conduction(lattice(gap), ratio, 1.0, height=float(WIDTH))
        assert found.core == pytest.approx(float(one[0]), rel=1e-4)
        assert found.overall == pytest.approx(float(one[0]), rel=1e-4)  # walls in planes of symmetry resist nothing


def test_beads_of_infinite_conductivity_leave_the_gas_in_the_gap():
    """int 2 pi r dr k_f/(2 (R + H - sqrt(R^2 - r^2))) up to the rim, in closed form for c = sqrt(R^2 - r^2)."""
    radius, half_gap, face = 0.5, 0.01, 0.4
    rim = face
    reach, least = radius + half_gap, np.sqrt(radius**2 - rim**2)
    exact = np.pi * (reach * np.log((reach - least) / half_gap) - (radius - least))
    found = line_conductance(radius, np.array([half_gap]), np.array([face]), 1e12, 1.0)
    assert found[0] == pytest.approx(exact, rel=1e-6)


def test_contacts_add_what_batchelor_and_obrien_give():
    plain, touching = (
        conduction(lattice(-1e-6), 1e6, 1.0, height=float(WIDTH), contact_radius=a).core for a in (0.0, 0.01)
    )
    assert touching - plain == pytest.approx(2.0 * 1e6 * 0.01, rel=1e-2)


def test_a_poured_bed_lies_between_its_bounds_and_grows_with_the_ratio(poured):
    """Hashin's and Shtrikman's, to the scatter of the core's slope."""
    values = []
    for ratio in (0.5, 1.5, 3.0, 10.0, 100.0, 1000.0):
        found = conduction(poured, ratio, 1.0)
        solid = 1.0 - found.core_porosity
        lower = 1.0 + 3.0 * solid * (ratio - 1.0) / (ratio + 2.0 - solid * (ratio - 1.0))
        upper = ratio + found.core_porosity / (1.0 / (1.0 - ratio) + solid / (3.0 * ratio))
        lower, upper = sorted((lower, upper))
        assert 0.98 * lower < found.core < 1.02 * upper
        assert found.wall_coefficient > 0.0 and np.all(np.diff(found.temperature) < 0.0)
        values.append(found.core)
    assert np.all(np.diff(values) > 0.0)


@pytest.mark.parametrize("lattice", LATTICES.values(), ids=LATTICES)
def test_a_small_contrast_gives_the_mean_over_the_volume(lattice):
    """Exact to first order in k_s - k_f, but for cones in place of the pyramids of a Voronoi cell (2 %)."""
    slope = (network(lattice, 0.0, 1.0001) - network(lattice, 0.0, 0.9999)) / 2e-4
    assert slope == pytest.approx(len(lattice.beads) * np.pi / 6.0 * lattice.spacing**3, rel=0.02)


@pytest.mark.parametrize(("lattice", "low", "high"), [("simple cubic", 0.79, 1.08), ("body-centred", 0.86, 1.03)])
def test_the_network_is_near_resolved_solutions_of_lattices(lattice, low, high):
    """With a gap and with contacts; the table of docs/packed-conductivity.md has the others."""
    ratios = (2.0, 30.0, 1000.0)
    for gap in (0.02, -0.00125):
        values, solid = resolved(LATTICES[lattice], gap, ratios)
        exact = len(LATTICES[lattice].beads) * np.pi / 6.0 * (LATTICES[lattice].spacing * (1.0 - gap)) ** 3
        assert solid == pytest.approx(exact, rel=5e-3)
        for ratio, value in zip(ratios, values, strict=True):
            assert low < network(LATTICES[lattice], gap, ratio) / value < high


def test_contacts_of_hertz():
    """a^3 = 3 F R*/(4 E*) with R* = d/4, E* = E/(2 (1 - nu^2))."""
    diameter, modulus, force = 0.006, 7e10, 0.03
    pressure = force * 0.6 * 6.0 / (np.pi * diameter**2)
    radius = hertz_contact_radius(pressure, modulus, diameter, 0.6, 6.0)
    assert radius**3 == pytest.approx(0.75 * force * (diameter / 4.0) / (modulus / (2.0 * (1.0 - 0.3**2))))


def test_units_scale_out(poured):
    one, other = conduction(poured, 2.0, 0.03), conduction(poured, 200.0, 3.0)
    assert other.core == pytest.approx(100.0 * one.core) and other.wall_coefficient == pytest.approx(
        100.0 * one.wall_coefficient
    )


def test_what_has_no_walls_to_conduct_between_is_refused():
    beads = np.array([[0.0, 0.0, 0.5], [0.0, 0.0, 1.5]])
    with pytest.raises(InputError, match="slab"):
        conduction(Packing(beads, np.ones(2), container("cylinder", {"diameter": 2.0})), 1.0, 1.0)
    with pytest.raises(InputError, match="bead diameters wide"):
        conduction(Packing(beads, np.ones(2), Slab(4.0, 4.0)), 1.0, 1.0)
    with pytest.raises(InputError, match="one size"):
        conduction(Packing(beads, np.array([1.0, 0.9]), Slab(12.0, 4.0)), 1.0, 1.0)


def test_what_is_above_the_bed_or_below_it_does_not_conduct(poured):
    """Up to 1 m a bed of 60 mm had a seventh of its conductivity, in silence."""
    with pytest.raises(InputError, match="its top"):
        conduction(poured, 40.0, 0.03, height=1.0)
    above = Packing(poured.positions + np.array([0.0, 0.0, 0.02]), poured.diameters, poured.container)
    with pytest.raises(InputError, match="is --floor missing"):
        conduction(above, 40.0, 0.03)
    with pytest.raises(InputError, match="no heat passes"):
        conduction(Packing(poured.positions, poured.diameters, Slab(0.08, 0.035)), 40.0, 0.03)
    with pytest.raises(InputError, match="no beads of the packing touch"):
        hertz_contact_radius(2e3, 2e11, 0.005, 0.6, 0.0)


def test_the_command_refuses_large_contacts_and_temperatures_without_properties(poured, tmp_path, capsys):
    write_packing(poured, tmp_path / "a.h5")
    command = ["conductivity", str(tmp_path / "a.h5"), "--beads", "steel", "--out", str(tmp_path / "k.csv")]
    assert main([*command, "--pressure", "200 MPa", "--youngs-modulus", "200 MPa"]) == 2
    assert main([*command, "--fluid", "water", "--temperature", "2000 K"]) == 2
    told = capsys.readouterr().err
    assert "law of Hertz" in told and "beyond the laws' range" in told and not (tmp_path / "k.csv").exists()
    assert main([*command, "--temperature", "1400 K"]) == 0
    assert "air is used for 1126.8 to 1126.8 °C, given for -73.1 to 1026.8 °C (conductivity)" in capsys.readouterr().err


def test_the_command_writes_profile_and_picture(poured, tmp_path, capsys):
    write_packing(poured, tmp_path / "bed.h5")
    words = ["conductivity", str(tmp_path / "bed.h5"), "--beads", "steel", "--fluid", "air", "--temperature", "350 K"]
    assert main([*words, "--out", str(tmp_path / "k.csv")]) == 0
    told = capsys.readouterr().out
    assert "Zehner" in told and (tmp_path / "k.png").is_file()
    head, *rows = (tmp_path / "k.csv").read_text().splitlines()
    assert head == "wall_distance [m],conductivity [W/(m*K)]" and len(rows) >= 4
    summary = json.loads((tmp_path / "k.json").read_text())
    assert 0.1 < summary["core_conductivity"] < 1.0
    assert main([*words, "--pressure", "2 kPa", "--out", str(tmp_path / "k.csv")]) == 2
    assert "--youngs-modulus" in capsys.readouterr().err
    under_load = ["--pressure", "2 kPa", "--youngs-modulus", "200 GPa"]
    assert main([*words, *under_load, "--out", str(tmp_path / "loaded.csv")]) == 0
    assert "contacts: 0.00" in capsys.readouterr().out
    loaded = json.loads((tmp_path / "loaded.json").read_text())
    assert loaded["core_conductivity"] > 1.1 * summary["core_conductivity"]
    assert main([*words, "--contact-radius", "0.6", "--out", str(tmp_path / "k.csv")]) == 2
    assert "--contact-radius" in capsys.readouterr().err
    assert main([*words[:3], "unobtainium", "--out", str(tmp_path / "k.csv")]) == 2
