"""Cells and steps in time that a scene asks for in place of those by default, and the accuracy that it wants."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from .feature import Feature, key, measure

if TYPE_CHECKING:
    from ..scene import Scene


@dataclass(frozen=True, kw_only=True)
class Cells(Feature):
    """The cells of a straight bed before `refinement`, which counts `refinement_along` times along the flow."""

    along: int | None = key(
        "solver.axial_cells",
        "integer",
        "cells along the flow; default from the expected width of the front, at least 18",
        low=2,
        high=100000,
        closed=True,
    )
    first: float | None = measure(
        "solver.first_cell", "height of the cell at the wall; default from the expected wall shear"
    )
    growth: float = key(
        "solver.cell_growth",
        "",
        "largest growth ratio of cells across the bed; its root within 1.5 bead diameters of the wall",
        1.33,
        low=1.001,
        high=3.0,
    )
    refinement: float = key(
        "solver.mesh_refinement",
        "",
        "factor on the number of cells in each direction, given or by default; of a plane mesh of your own 1, 2, 4 or 8",
        1.0,
        low=0.1,
        high=20.0,
        closed=True,
    )
    refinement_along: float = key(
        "solver.axial_refinement",
        "",
        "another factor on the number of cells along the flow alone",
        1.0,
        low=0.01,
        high=20.0,
        closed=True,
    )


@dataclass(frozen=True, kw_only=True)
class Accuracy(Feature):
    """The relative error that answers may have."""

    wanted: float | None = key(
        "solver.accuracy",
        "",
        "wanted relative error of heating time, targets and peaks of cure, and where not all of these are reached of the "
        "temperatures at the end: chooses all refinements, reports heating_time_error, target_errors, peak_errors, end_errors",
        low=1e-4,
        high=0.2,
        closed=True,
    )

    in_doubt: bool = key(
        "solver.refine_in_doubt",
        "flag",
        "repeat a run on finer cells, twice at most, where a coarser one has other answers of a front at the end, an exotherm, "
        "a place that heat from elsewhere brings beyond the inlet's temperature, or a time that comes early (within the first "
        "steps, a sensor near the inlet), and where a fluid forms fingers in another; "
        "without solver.accuracy, in two dimensions, with default cells",
        True,
    )

    def check(self, scene: "Scene") -> None:
        """It chooses the refinements itself."""
        if self.wanted is None:
            return
        for name in ("mesh_refinement", "axial_refinement", "step_refinement"):
            if scene.differs_from_default(f"solver.{name}"):
                scene.refuse(f"solver.{name}", "is chosen by solver.accuracy")


@dataclass(frozen=True, kw_only=True)
class TimeSteps(Feature):
    """Steps before `refinement`, their error, and whether temperatures are kept within bounds."""

    refinement: float = key(
        "solver.step_refinement",
        "",
        "factor on the number of time steps",
        1.0,
        low=0.1,
        high=100.0,
        closed=True,
    )
    first: float | None = key(
        "solver.first_step",
        "s",
        "first time step; default, and at most, a twentieth of the largest",
        low=0.0,
        high=1e6,
    )
    growth: float = key("solver.step_growth", "", "ratio of successive steps", 1.5, low=1.0, high=10.0, closed=True)
    largest: float | None = key(
        "solver.largest_step",
        "s",
        "largest time step; default from the front's passage time and the wall's time constant",
        low=0.0,
        high=1e7,
    )
    tolerance: float | None = key(
        "solver.step_tolerance",
        "delta_degC",
        "largest estimated error of a time step (root mean square over bed or layer), besides 0.2 % of the temperature "
        "differences there are, or of 8 times the change that is waited for where that is less",
        low=0.0,
        high=1e3,
    )
    keep_bounds: bool = key(
        "solver.keep_bounds",
        "flag",
        "keep temperatures within those given: first order in the cells of a sharp front; else they may pass them by a few "
        "kelvin there",
        True,
    )
