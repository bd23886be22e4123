"""A scene made discrete."""

import pytest
import ufl
from mpi4py import MPI
from ufl.constantvalue import RealValue
from ufl.corealg.traversal import unique_pre_traversal

from porousmold import fenicsx
from porousmold.discretisation import Discretisation

from .support import ALUMINIUM, PIPE, STUDIES, coarse_scene

PROFILE = STUDIES / "profiles" / "cylinder_ratio_20.csv"

PROPERTIES = {
    **{
        f"bed__bead_{name}": value
        for name, value in (("density", 2000.0), ("heat_capacity", 900.0), ("conductivity", 1.2))
    },
    **{
        f"wall__{name}": value for name, value in (("density", 2000.0), ("heat_capacity", 900.0), ("conductivity", 1.2))
    },
    "bed__bead_diameter": 0.005,
    "bed__bulk_porosity": 0.4,
    "wall__thickness": 0.003,
    "operation__inlet_temperature": 350.0,
    "operation__outlet_pressure": 1.0e5,
    "operation__gravity": 9.0,
    "model__exchange_factor": 0.9,
}
OUTER = {
    "operation__outer_coefficient": 5.0,
    "operation__ambient_temperature": 290.0,
    "operation__outer_heat_flux_factor": 0.9,
}
LIQUID = {"fluid__density": 900.0, "fluid__viscosity": 1e-3, "fluid__heat_capacity": 2000.0, "fluid__conductivity": 0.5}


LAMINAR = {"model__turbulence": "none"}
HEIGHT, DIAMETER = {"geometry__cavity_height": 0.06}, {"geometry__diameter": 0.06}


@pytest.mark.parametrize(
    ("path", "numbers", "choices"),
    [
        (ALUMINIUM, {"geometry__length": 0.9} | HEIGHT | OUTER, {"model__bead_modes": 1}),
        (ALUMINIUM, {"geometry__width": 0.1, "operation__mass_flow": 0.002} | HEIGHT | OUTER,
         {"operation__pressure_drop": None, "solver__axial_cells": 3} | LAMINAR),
        (PIPE, {"operation__inlet_velocity": 0.1} | DIAMETER | OUTER | LIQUID,
         {"operation__pressure_drop": None, "model__wall": "thin"} | LAMINAR),
        (PIPE, {"geometry__length": 0.9} | DIAMETER | OUTER, {"model__flow": "developed"}),
        (PIPE, DIAMETER | OUTER, {"model__flow": "plug"} | LAMINAR),
        (ALUMINIUM, {"operation__wall_temperature": 340.0} | HEIGHT, {"model__wall": "fixed-temperature"} | LAMINAR),
        (ALUMINIUM, {"bed__averaging_diameter_ratio": 0.9} | HEIGHT,
         {"model__rev_terms": "consistent", "bed__porosity_profile": str(PROFILE)} | LAMINAR),
    ],
    ids=["mold", "box", "liquid", "developed", "plug", "held", "rev"],
)  # fmt: skip
def test_no_number_of_a_scene_is_compiled_in(path, numbers, choices, tmp_path, monkeypatch):
    """Another value costs no compilation: expressions hold the same literals, and numbers of the scene as constants."""
    flux = tmp_path / "flux.csv"
    found, seen = [], []
    for name in ("compiled_form", "_expression_at"):
        original = getattr(fenicsx, name)

        def compiled(what, *arguments, original=original):
            parts = [integral.integrand() for integral in what.integrals()] if isinstance(what, ufl.Form) else [what]
            found.extend(
                float(each) for part in parts for each in unique_pre_traversal(part) if isinstance(each, RealValue)
            )
            return original(what, *arguments)

        monkeypatch.setattr(fenicsx, name, compiled)
    for factor in (1.0, 1.04):
        flux.write_text(f"time [s], {0.1 * factor} m [W/m^2], {0.5 * factor} m [W/m^2]\n0, 10, {20 * factor}\n")
        found.clear()
        changed = {key: value * factor for key, value in (PROPERTIES | numbers).items()}
        given = {"operation__outer_heat_flux": str(flux)} if OUTER.keys() <= numbers.keys() else {}
        Discretisation(coarse_scene(path, **changed, **given, **choices), MPI.COMM_SELF)
        seen.append(sorted(found))
    assert seen[0] == seen[1] and len(seen[0]) > 20
