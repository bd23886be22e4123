"""A scene made discrete."""

from dataclasses import replace

import pytest
import ufl
from mpi4py import MPI
from ufl.constantvalue import RealValue
from ufl.corealg.traversal import unique_pre_traversal

from porousmold import InputError, Scene
from porousmold.mesh import fenicsx
from porousmold.mesh.deferred_forms import DeferredForm
from porousmold.simulation.observation import profile_near_wall

from ..support import ALUMINIUM, PIPE, STUDIES, coarse_scene, problem_of

PROFILE = STUDIES / "profiles" / "cylinder_ratio_20.csv"

PROPERTIES = {
    **{
        f"bed.bead_{name}": value
        for name, value in (("density", 2000.0), ("heat_capacity", 900.0), ("conductivity", 1.2))
    },
    **{f"wall.{name}": value for name, value in (("density", 2000.0), ("heat_capacity", 900.0), ("conductivity", 1.2))},
    "bed.bead_diameter": 0.005,
    "bed.bulk_porosity": 0.4,
    "wall.thickness": 0.003,
    "operation.inlet_temperature": 350.0,
    "operation.outlet_pressure": 1.0e5,
    "operation.gravity": 9.0,
    "model.exchange_factor": 0.9,
}
OUTER = {
    "operation.outer_coefficient": 5.0,
    "operation.ambient_temperature": 290.0,
    "operation.outer_heat_flux_factor": 0.9,
}
LIQUID = {"fluid.density": 900.0, "fluid.viscosity": 1e-3, "fluid.heat_capacity": 2000.0, "fluid.conductivity": 0.5}


LAMINAR = {"model.turbulence": "none"}
HEIGHT, DIAMETER = {"geometry.cavity_height": 0.06}, {"geometry.diameter": 0.06}


@pytest.mark.parametrize(
    ("path", "numbers", "choices"),
    [
        (ALUMINIUM, {"geometry.length": 0.9} | HEIGHT | OUTER, {"model.bead_modes": 1}),
        (ALUMINIUM, {"geometry.width": 0.1, "operation.mass_flow": 0.002} | HEIGHT | OUTER,
         {"operation.pressure_drop": None, "solver.axial_cells": 3} | LAMINAR),
        (PIPE, {"operation.inlet_velocity": 0.1} | DIAMETER | OUTER | LIQUID,
         {"operation.pressure_drop": None, "model.wall": "thin"} | LAMINAR),
        (PIPE, {"geometry.length": 0.9} | DIAMETER | OUTER, {"model.flow": "developed"}),
        (PIPE, DIAMETER | OUTER, {"model.flow": "plug"} | LAMINAR),
        (ALUMINIUM, {"operation.wall_temperature": 340.0} | HEIGHT, {"model.wall": "fixed-temperature"} | LAMINAR),
        (ALUMINIUM, {"bed.averaging_diameter_ratio": 0.9} | HEIGHT,
         {"model.rev_terms": "consistent", "bed.porosity_profile": str(PROFILE), "bed.bulk_porosity": None} | LAMINAR),
    ],
    ids=["mold", "box", "liquid", "developed", "plug", "held", "rev"],
)  # fmt: skip
def test_no_number_of_a_scene_is_compiled_in(path, numbers, choices, tmp_path, monkeypatch):
    """Another value costs no compilation: expressions hold the same literals, and numbers of the scene as constants."""
    flux = tmp_path / "flux.csv"
    found, seen, original = [], [], fenicsx.expression_at

    def note(what):
        parts = [integral.integrand() for integral in what.integrals()] if isinstance(what, ufl.Form) else [what]
        found.extend(
            float(each) for part in parts for each in unique_pre_traversal(part) if isinstance(each, RealValue)
        )

    def compiled(expression, *arguments):
        note(expression)
        return original(expression, *arguments)

    monkeypatch.setattr(fenicsx, "expression_at", compiled)
    monkeypatch.setattr(
        DeferredForm, "__init__", lambda self, form: note(form)
    )  # the forms are looked at, none is compiled
    for factor in (1.0, 1.04):
        flux.write_text(f"time [s], {0.1 * factor} m [W/m^2], {0.5 * factor} m [W/m^2]\n0, 10, {20 * factor}\n")
        found.clear()
        changed = {key: value * factor for key, value in (PROPERTIES | numbers).items()}
        given = {"operation.outer_heat_flux": str(flux)} if OUTER.keys() <= numbers.keys() else {}
        problem_of(coarse_scene(path, changed | given | choices), MPI.COMM_SELF)
        seen.append(sorted(found))
    assert seen[0] == seen[1] and len(seen[0]) > 20


def test_there_is_no_profile_where_the_middle_of_the_bed_is_at_its_wall():
    """As in coarse meshes of one's own, whose node nearest to the middle may be the wall's."""
    problem = problem_of(coarse_scene({"model.flow": "plug", "model.turbulence": "none"}))
    place = problem.domain.stations(0.5)["bed_side"]
    problem.domain = replace(problem.domain, stations=lambda part: {"bed_side": place, "centre": place})
    assert profile_near_wall(problem) is None


def test_a_gas_that_no_pressure_drives_so_fast_is_refused():
    """In a bed of 100 m: (p_out/p_in)^2 would be negative, whatever the pressure."""
    long = {"operation.pressure_drop": None, "operation.inlet_velocity": 2.0, "geometry.length": 100.0}
    with pytest.raises(InputError, match="has no steady flow: a gas that enters so fast"):
        problem_of(Scene.load(ALUMINIUM, long | {"solver.axial_cells": 10}))
