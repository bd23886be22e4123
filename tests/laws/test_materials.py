"""Property laws: values, integrals, sources."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from porousmold import InputError
from porousmold.laws.material_files import read_materials
from porousmold.laws.material_library import FLUIDS, SOLIDS
from porousmold.laws.materials import PiecewiseLinear, beyond_ranges


def test_air_at_300_kelvin():
    """Textbook values (Incropera, table A.4): 1.846e-5 Pa s, 0.0263 W/m/K, 1007 J/kg/K, 1.161 kg/m3."""
    assert FLUIDS["air"].viscosity(300.0) == pytest.approx(1.846e-5, rel=5e-3)
    assert FLUIDS["air"].conductivity(300.0) == pytest.approx(0.0263, rel=5e-3)
    assert FLUIDS["air"].heat_capacity(300.0) == pytest.approx(1007.0, rel=5e-3)
    assert FLUIDS["air"].density(101325.0, 300.0) == pytest.approx(1.177, rel=1e-3)


@given(temperature=st.floats(250.0, 400.0))
def test_enthalpy_is_the_integral_of_the_heat_capacity(temperature):
    for law in (FLUIDS["air"].heat_capacity, SOLIDS["acrylic"].heat_capacity):
        h = 1e-3
        slope = (law.integral(temperature + h) - law.integral(temperature - h)) / (2 * h)
        assert slope == pytest.approx(law(temperature), rel=1e-7)


def test_sutherland_returns_its_reference():
    assert FLUIDS["thesis_air"].viscosity(273.15) == pytest.approx(1.716e-5)


def test_a_material_beyond_its_ranges_is_told_of_in_one_sentence():
    """Four lines for one material that is 3 K too hot hid the others."""
    (told,) = beyond_ranges(SOLIDS["gfrp"], 280.0, 467.0)
    laws = "density, heat_capacity, conductivity, conductivity_in_plane"
    assert told == f"gfrp is used for 6.9 to 193.9 °C, given for 6.9 to 186.9 °C ({laws})"
    (told,) = beyond_ranges(SOLIDS["acrylic"], 343.0, 400.0)
    ranges = "-43.1 to 101.9 °C (heat_capacity), -180.1 to 89.9 °C (conductivity)"
    assert told == f"acrylic is used for 69.9 to 126.9 °C, given for {ranges}"
    assert not beyond_ranges(SOLIDS["acrylic"], 300.0, 310.0)


def test_every_law_has_unit_source_and_range():
    for material in (*FLUIDS.values(), *SOLIDS.values()):
        for name, law in material.laws().items():
            assert law.source and law.unit, (material.name, name)
            low, high = law.temperature_range
            assert 0.0 <= low < high and high >= 300.0, (material.name, name)


def test_arrays_and_coefficients_of_any_kind():
    law = SOLIDS["acrylic"].heat_capacity
    temperatures = np.array([300.0, 320.0])
    assert law(temperatures) == pytest.approx([166.95 + 4.0289 * T for T in temperatures])
    assert law.with_coefficients(c for c in law.coefficients)(310.0) == law(310.0)


def test_every_law_of_a_temperature_times_a_factor_is_that_everywhere():
    temperatures = np.linspace(250.0, 900.0, 30)
    for material in (*SOLIDS.values(), *FLUIDS.values()):
        for name, law in material.laws().items():
            if material in FLUIDS.values() and name == "density":
                continue
            assert law.times(1.07)(temperatures) == pytest.approx(1.07 * law(temperatures), rel=1e-12), material.name
            if name == "heat_capacity":
                assert law.times(1.07).integral(500.0) == pytest.approx(1.07 * law.integral(500.0), rel=1e-12)


def test_the_fluids_of_the_library_are_near_textbook_values():
    """Incropera, DeWitt, tables A.4 and A.6: fitted elsewhere, from CoolProp."""
    nitrogen, helium, water = (FLUIDS[name] for name in ("nitrogen", "helium", "water"))
    assert nitrogen.conductivity(400.0) == pytest.approx(0.0327, rel=0.02)
    assert helium.conductivity(300.0) == pytest.approx(0.152, rel=0.04)
    assert helium.density(101325.0, 300.0) == pytest.approx(0.1625, rel=0.005)
    assert water.viscosity(320.0) == pytest.approx(577e-6, rel=0.02)
    assert water.density(1e5, 350.0) == pytest.approx(973.7, rel=0.005)
    assert FLUIDS["steam"].heat_capacity(500.0) == pytest.approx(1985.0, rel=0.02)


def test_straight_lines_between_points_and_their_integral():
    law = PiecewiseLinear((300.0, 1.0, 400.0, 3.0, 500.0, 2.0), "J/(kg K)", "test")
    temperatures = np.linspace(250.0, 550.0, 61)
    assert law(temperatures) == pytest.approx(np.interp(temperatures, [300.0, 400.0, 500.0], [1.0, 3.0, 2.0]))
    h = 1e-3
    slopes = (law.integral(temperatures + 0.3 + h) - law.integral(temperatures + 0.3 - h)) / (2 * h)
    assert slopes == pytest.approx(law(temperatures + 0.3), rel=1e-7)


def test_a_table_of_many_rows_is_thinned_within_what_it_says(tmp_path):
    places = np.linspace(280.0, 480.0, 201)
    values = 900.0 + 300.0 * np.exp(-(((places - 400.0) / 15.0) ** 2))
    rows = "".join(f"{T - 273.15:.4f}, {c / 1000.0:.6f}\n" for T, c in zip(places, values, strict=True))
    (tmp_path / "c.csv").write_text("temperature [degC], heat_capacity [kJ/(kg*K)]\n" + rows)
    tables = {"mine": {"density": 1200, "heat_capacity": {"table": "c.csv"}, "conductivity": "0.3 W/m/K"}}
    law = read_materials(tables, tmp_path, None)["mine"].heat_capacity
    assert len(law.coefficients) <= 32 and "of 201 rows" in law.source
    assert np.max(np.abs(law(places) - values)) < 0.01 * np.max(values)


@pytest.mark.parametrize(
    ("table", "key"),
    [
        ({"density": 1.0, "heat_capacity": 2.0}, "materials.mine.conductivity"),
        ({"density": -1.0, "heat_capacity": 2.0, "conductivity": 1.0}, "materials.mine.density"),
        ({"density": 1.0, "heat_capacity": 2.0, "conductivity": {"polynom": [1]}}, "materials.mine.conductivity"),
        (
            {"density": 1.0, "heat_capacity": {"polynomial": [3000.0, -10.0]}, "conductivity": 1.0},
            "materials.mine.heat_capacity",
        ),
        ({"density": 1.0, "heat_capacity": 2.0, "conductivity": 1.0, "colour": "red"}, "materials.mine.colour"),
        ({"density": 1.0, "heat_capacity": 2.0, "conductivity": 1.0, "cure": {"rate_1": 1.0}}, "materials.mine.cure"),
        ({"viscosity": 1e-5, "heat_capacity": 2.0, "conductivity": 1.0}, "materials.mine"),
    ],
)
def test_materials_that_cannot_be_are_refused(table, key, tmp_path):
    with pytest.raises(InputError) as refused:
        read_materials({"mine": table}, tmp_path, "scene.toml")
    assert refused.value.key == key and "scene.toml" in str(refused.value)


def shomate(kelvin, a, b, c, d, e):
    """Heat capacity of the NIST WebBook, J/mol/K."""
    t = kelvin / 1000.0
    return a + b * t + c * t**2 + d * t**3 + e / t**2


@pytest.mark.parametrize(
    ("name", "molar_mass", "temperatures", "coefficients"),
    [
        ("alumina", 0.101961, (300, 400, 600, 800, 1000, 1200, 1500), (102.4290, 38.74980, -15.91090, 2.628181, -3.007551)),
        ("quartzite", 0.0600843, (300, 400, 600, 800), (-6.076591, 251.6755, -324.7964, 168.5604, 0.002548)),
        ("quartzite", 0.0600843, (900, 1000, 1200), (58.75340, 10.27925, -0.131384, 0.025210, 0.025601)),
    ],
    ids=["alumina", "quartz below its transition", "above it"],
)  # fmt: skip
def test_heat_capacity_of_crystals_against_the_nist_webbook(name, molar_mass, temperatures, coefficients):
    for kelvin in temperatures:
        expected = shomate(kelvin, *coefficients) / molar_mass
        assert SOLIDS[name].heat_capacity(kelvin) == pytest.approx(expected, rel=0.02), kelvin


def test_rocks_at_hand_heat_are_as_measured_ones():
    """Seven rocks of Seyitini et al. (Data in Brief 63, 2025): 767 to 861 J/kg/K at room temperature, 942 to 1090 at 250 degC."""
    for name in ("granite", "basalt", "quartzite"):
        heat_capacity = SOLIDS[name].heat_capacity
        assert 0.95 * 767.0 < heat_capacity(298.0) < 1.05 * 861.0
        assert 0.95 * 942.0 < heat_capacity(523.15) < 1.05 * 1090.0


def test_solar_salt_as_its_users_compute_it():
    """Zavoico's polynomials in degC at 290 and 565 degC, the temperatures of a tower's tanks."""
    salt = FLUIDS["solar_salt"]
    for celsius in (290.0, 565.0):
        kelvin = celsius + 273.15
        viscosity = 1e-3 * (22.714 - 0.120 * celsius + 2.281e-4 * celsius**2 - 1.474e-7 * celsius**3)
        assert salt.density(1e5, kelvin) == pytest.approx(2090.0 - 0.636 * celsius)
        assert salt.viscosity(kelvin) == pytest.approx(viscosity, rel=1e-6)
        assert salt.heat_capacity(kelvin) == pytest.approx(1443.0 + 0.172 * celsius)
        assert salt.conductivity(kelvin) == pytest.approx(0.443 + 1.9e-4 * celsius)


def test_conductivities_fall_and_insulations_rise_with_temperature():
    for name in ("alumina", "magnesia", "granite", "basalt", "quartzite", "graphite", "carbon_steel"):
        law = SOLIDS[name].conductivity
        assert law(480.0) > law(750.0), name
    for name in ("mineral_wool", "calcium_silicate", "ceramic_fibre", "firebrick", "insulating_firebrick"):
        law = SOLIDS[name].conductivity
        assert law(680.0) < law(749.0), name


@pytest.mark.parametrize(
    ("name", "temperature", "published"),
    [("thesis_air", 1300.0, 1190.0), ("carbon_dioxide", 1773.0, 1357.0), ("nitrogen", 1700.0, 1265.0)],
)
def test_a_heat_capacity_goes_on_along_its_tangent_beyond_its_range(name, temperature, published):
    """The polynomials went to 1136, 1749 and 1398 J/kg/K; those of the ideal gas (JANAF) are within 2.5 % of the tangents."""
    law = FLUIDS[name].heat_capacity
    low, high = law.temperature_range
    assert law(temperature) == pytest.approx(published, rel=0.025)
    inside = np.linspace(low, high, 7)
    assert law(inside) == pytest.approx(np.polynomial.Polynomial(law.coefficients)(inside), rel=1e-12)
    for end, away in ((low, -60.0), (high, 300.0)):
        values = [law(end), law(end + 0.5 * away), law(end + away)]
        assert values[2] - values[1] == pytest.approx(values[1] - values[0], rel=1e-9)
        gained = law.integral(end + away) - law.integral(end)  # Simpson's rule is exact for straight lines
        assert gained == pytest.approx(away * (values[0] + 4.0 * values[1] + values[2]) / 6.0, rel=1e-9)


@pytest.mark.parametrize("name", ["water", "water_glycol", "thermal_oil", "therminol_vp1"])
def test_the_viscosity_of_a_liquid_goes_on_along_its_tangent_beyond_its_range(name):
    """A polynomial's exponent of degree 8 would be 1e38 Pa s two hundred kelvins on; inside it is the polynomial's own."""
    law = FLUIDS[name].viscosity
    low, high = law.temperature_range
    inside = np.linspace(low, high, 7)
    own = np.exp(np.polynomial.Polynomial(law.coefficients)(inside))
    assert law(inside) == pytest.approx(own, rel=1e-9)
    for end, away in ((low, -100.0), (high, 100.0)):
        step = 1e-3 * np.sign(away)
        logarithms = np.log([law(end - step), law(end), law(end + step), law(end + away), law(end + 2.0 * away)])
        slope = logarithms[1] - logarithms[0]
        assert logarithms[2] - logarithms[1] == pytest.approx(slope, rel=1e-3)
        assert logarithms[4] - logarithms[3] == pytest.approx(logarithms[3] - logarithms[1], rel=1e-9)
        assert (logarithms[3] - logarithms[1]) / away == pytest.approx(slope / step, rel=1e-3)
