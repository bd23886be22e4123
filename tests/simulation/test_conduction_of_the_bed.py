"""Stirred beads and tabulated conductivities in whole runs, beside scenes that are the same in other words."""

import pytest

from porousmold import InputError, Scene
from porousmold.laws.conductivity import stagnant_conductivity
from porousmold.laws.stirring import COEFFICIENT
from porousmold.scene.chosen_laws import Laws

from ..laws.test_stirring import BED
from ..support import ALUMINIUM, COARSE, simulation_of

CONSTANT = {
    **COARSE,
    "model.flow": "plug",
    "model.turbulence": "none",
    "bed.bead_density": 2500.0,
    "bed.bead_heat_capacity": 800.0,
    "bed.bead_conductivity": 2.0,
    "fluid.conductivity": 0.03,
    "bed.porosity_model": "constant",
    "bed.bulk_porosity": 0.4,
}


def heating_time(**changes):
    settings = CONSTANT | {name.replace("__", "."): value for name, value in changes.items()}
    simulation = simulation_of(Scene.load(ALUMINIUM, settings)).integrate()
    assert abs(simulation.problem.heat.balance.imbalance) < 1e-4
    return simulation.recorder.heating_time


def test_stirring_is_a_conductivity_of_the_beads():
    """lambda_s + rho_s C_s c gamma d^2 in place of lambda_s, with the bulk law: the same equations."""
    carried = 2500.0 * 800.0 * COEFFICIENT * 5.0 * 0.005**2
    stirred = heating_time(bed__shear_rate="5 1/s")
    assert stirred == pytest.approx(heating_time(bed__bead_conductivity=2.0 + carried), rel=1e-6)
    assert abs(stirred - heating_time()) > 1.0


def test_a_tabulated_conductivity_is_that_of_the_bed(tmp_path):
    """A table with what Zehner, Bauer and Schluender give for this bed everywhere: the same equations again."""
    law = {"model__bead_conduction": "zehner-bauer-schluender", "bed__contact_flattening": 0.0}
    value = float(stagnant_conductivity(BED, 0.4))
    path = tmp_path / "table.csv"
    path.write_text(f"wall_distance [m],conductivity [W/(m*K)]\n0,{value!r}\n0.1,{value!r}\n")
    assert heating_time(bed__conductivity_profile=str(path)) == pytest.approx(heating_time(**law), rel=1e-6)


def test_what_would_have_no_effect_is_refused(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("wall_distance [m],conductivity [W/(m*K)]\n0,0.5\n")
    with pytest.raises(InputError, match="has no place beside"):
        Scene.load(ALUMINIUM, {"bed.conductivity_profile": str(path), "bed.emissivity": 0.5})
    scene = Scene.load(ALUMINIUM, {"bed.conductivity_profile": str(path), "bed.shear_rate": 2.0})
    sources = Laws.of(scene).sources(bead_modes=False)
    assert sources["bead conduction"] == str(path) and "shear" in sources["stirring"]
