"""Cells through the layers of a wall, by what heats or cools them from either side."""

import pytest

from porousmold import Scene, run

from ..support import problem_of

TOOL = {
    "geometry": {"kind": "mold", "length": 0.2, "cavity_height": 0.05},
    "bed": {"bead_diameter": 5e-3, "bead_material": "ceramic"},
    "wall": {"layer": [{"name": "skin", "material": "aluminium", "thickness": 2e-3},
                       {"name": "part", "material": "gfrp", "thickness": 0.02}]},
    "model": {"flow": "plug"},
    "operation": {"initial_temperature": "20 degC", "inlet_temperature": "90 degC", "pressure_drop": 0.0,
                  "end_time": "2 h"},
    "target": [{"name": "part", "place": "part", "above": "40 degC"}],
    "solver": {"refine_in_doubt": False},
}  # fmt: skip
"""A part behind a skin, as in an oven."""
HEATER = {"wall.layer[1].heat_source": 3e5}
OVEN = {"operation.outer_coefficient": 500.0, "operation.ambient_temperature": "90 degC"}


@pytest.mark.parametrize(
    "outside", [OVEN, OVEN | {"operation.pressure_drop": 5.0}, {"operation.outer_heat_flux": 1000.0}, HEATER]
)
def test_a_part_heated_from_outside_is_hot_in_time_by_default_cells(outside):
    """It had one cell where the bed is at rest: 33 % too soon, 1 % at 5 Pa, by a flux 11 % too late, beside a skin that heats
    5 %."""
    scene = Scene(TOOL).changed(outside)
    finer = scene.changed({"wall.layer[2].cells": 40, "solver.step_refinement": 3.0})
    assert run(scene).summary["targets"]["part"] == pytest.approx(run(finer).summary["targets"]["part"], rel=5e-3)


def test_surroundings_that_only_take_what_the_wall_loses_ask_for_no_cells():
    """Their temperature is that of the start, but for 5 K."""

    def unknowns(**operation):
        scene = Scene(TOOL).changed({f"operation.{name}": value for name, value in operation.items()})
        return problem_of(scene).unknowns["energy"]

    lost = {"outer_coefficient": 10.0, "ambient_temperature": "15 degC"}
    assert unknowns(**lost) == unknowns() < unknowns(outer_coefficient=10.0, ambient_temperature="90 degC")
