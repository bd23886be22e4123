"""Heat that stirred beads carry."""

import numpy as np
import pytest
import ufl

from porousmold.laws.conductivity import BEAD_CONDUCTION_LAWS, BeadConduction, LocalBed
from porousmold.laws.stirring import stirring_conductivity

BED = LocalBed(
    porosity=0.4,
    wall_distance=1.0,
    bead_diameter=0.005,
    density=1.2,
    viscosity=2e-5,
    heat_capacity=1e3,
    speed=0.0,
    eddy_viscosity=0.0,
    fluid_conductivity=0.03,
    bead_conductivity=2.0,
    bulk_porosity=0.4,
    core_speed=0.0,
    temperature=300.0,
    bead_heat_capacity=2e6,
)


def test_stirring_carries_like_self_diffusion():
    """(1 - phi) rho C D with D = c gamma d^2."""
    assert stirring_conductivity(0.4, 2e6, 0.05 * 3.0, 0.005) == pytest.approx(0.6 * 2e6 * 0.15 * 2.5e-5)


@pytest.mark.parametrize("name", ["bulk", "zehner-bauer-schluender"])
def test_it_is_added_to_what_any_law_gives(name):
    law = BEAD_CONDUCTION_LAWS[name]
    stirred = BeadConduction(law.formula, law.source, law.whole_bed, law.factor, mixing_rate=0.15)
    assert stirred.beads(BED) - law.beads(BED) == pytest.approx(stirring_conductivity(0.4, 2e6, 0.15, 0.005))
    assert stirred.fluid(BED) == law.fluid(BED)


def test_numbers_arrays_and_ufl():
    porosity = np.array([0.4, 1.0])
    assert stirring_conductivity(porosity, 2e6, 0.1, 0.005).tolist() == pytest.approx([3.0, 0.0])
    assert isinstance(stirring_conductivity(ufl.as_ufl(0.4), 2e6, 0.1, 0.005), ufl.core.expr.Expr)
