"""Every quantity that is recorded, named and written: one table for history, result, tables, fields, axes and report."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np


@dataclass(frozen=True)
class Quantity:
    """A recorded quantity: `symbol` as in formulas (TeX), `label` in words, and its SI unit."""

    symbol: str
    label: str
    unit: str

    @property
    def axis_label(self) -> str:
        """Words, symbol and unit, as an axis has them."""
        unit = "" if self.unit == "1" else f" in {self.unit.replace('2', '²').replace('3', '³')}"
        return f"{self.label} ${self.symbol}${unit}" if self.symbol else f"{self.label}{unit}"


QUANTITIES: Mapping[str, Quantity] = {
    "time": Quantity("t", "time", "s"),
    "step": Quantity(r"\Delta t", "time step", "s"),
    "inlet_temperature": Quantity(r"T_\mathrm{in}", "inlet temperature", "K"),
    "set_point": Quantity(r"T_\mathrm{set}", "set-point of the inlet temperature", "K"),
    "outlet_temperature": Quantity(r"T_\mathrm{out}", "mean outlet temperature", "K"),
    "deficit_wall": Quantity(r"\Delta T_w", "largest difference between inlet and wall temperature", "K"),
    "deficit_bed_side": Quantity(
        r"\Delta T_b", "largest difference between inlet and wall temperature on the bed side", "K"
    ),
    "mass_flow": Quantity(r"\dot{m}", "mass flow", "kg/s"),
    "pressure_drop": Quantity(r"\Delta p", "pressure drop", "Pa"),
    "heat_by_fluid": Quantity("Q_f", "heat transferred from the fluid", "J"),
    "heat_through_outer_wall": Quantity("Q_o", "heat in through the outer wall", "J"),
    "heat_stored": Quantity("Q_s", "heat stored", "J"),
    "heat_by_beads": Quantity("Q_v", "net heat supplied by moving beads", "J"),
    "bead_outlet_temperature": Quantity(r"T_{s,\mathrm{out}}", "mean temperature of the beads that leave", "K"),
    "heat_by_rev_terms": Quantity("Q_b", "heat created by REV terms", "J"),
    "lowest_temperature": Quantity(r"T_\min", "lowest temperature", "K"),
    "highest_temperature": Quantity(r"T_\max", "highest temperature", "K"),
    "heater_power": Quantity("P_h", "heater's power for the whole tool", "W"),
    "blower_power": Quantity("P_b", "blower's power for the whole tool", "W"),
    "coldest_place": Quantity("x", "place of the coldest point of the wall's bed side along the flow", "m"),
    "hottest_place": Quantity("x", "place of the hottest point of the wall's bed side along the flow", "m"),
    "largest_bead_difference": Quantity(
        r"\Delta T_s", "largest difference between surface and mean temperature of a bead", "K"
    ),
    "distance_from_inlet": Quantity("x", "distance from the inlet", "m"),
    "wall_distance": Quantity("y", "wall distance", "m"),
    "porosity": Quantity(r"\phi_V", "porosity", "1"),
    "speed": Quantity("|u|", "speed", "m/s"),
    "velocity": Quantity("u", "velocity", "m/s"),
    "pressure": Quantity("p", "gauge pressure", "Pa"),
    "fluid_temperature": Quantity("T_f", "fluid temperature", "K"),
    "bead_temperature": Quantity("T_s", "bead temperature", "K"),
    "turbulent_kinetic_energy": Quantity("k", "turbulent kinetic energy", "m2/s2"),
    "dissipation_rate": Quantity(r"\epsilon", "dissipation rate", "m2/s3"),
    "eddy_viscosity_ratio": Quantity(r"\mu_t/\mu", "eddy viscosity over viscosity", "1"),
    "in_bed": Quantity("", "1 in the bed, 0 in the wall", "1"),
    "region": Quantity("", "0 of cells of the bed, 1, 2, ... of the wall's layers outwards", "1"),
}
FAMILIES: Mapping[str, Quantity] = {
    "temperature": Quantity("T", "temperature of fluid or wall", "K"),
    "sensor": Quantity("T", "temperature at a sensor", "K"),
    "lowest": Quantity(r"T_\min", "lowest temperature of a place", "K"),
    "highest": Quantity(r"T_\max", "highest temperature of a place", "K"),
    "cure": Quantity(r"\alpha", "least degree of cure of a layer", "1"),
    "deficit": Quantity(r"\Delta T", "largest difference between a place and the inlet temperature", "K"),
    "fluid": Quantity("T_f", "fluid temperature along the bed at the end of a phase", "K"),
    "beads": Quantity("T_s", "bead temperature along the bed at the end of a phase", "K"),
    "gradient": Quantity(r"|\nabla T|", "temperature gradient at a sensor", "K/m"),
}
"""Quantities at named places: `temperature_outer_L` is the temperature at `outer_L`."""


JOULES_A_KWH = 3.6e6
ENERGY_NAMES = {
    "heater": "heater",
    "blower": "blower",
    "cure": "cure",
    "sources": "sources in the wall",
    "wall": "wall",
    "beads": "beads",
    "exhaust": "exhaust",
    "return_duct": "return duct",
    "outer_wall": "outer wall",
}
"""What gives energy to a tool, and where it goes, in words."""
ENERGY_GIVEN = ("heater", "blower", "cure", "sources")


def quantity(name: str) -> Quantity:
    """The quantity of a column's name; raises `KeyError` for one that no table has."""
    return QUANTITIES[name] if name in QUANTITIES else FAMILIES[name.split("_")[0]]


@dataclass
class Columns:
    """Recorded columns by name, each a list; their units follow from the names."""

    columns: dict[str, list[float]] = field(default_factory=dict)

    def append(self, row: Mapping[str, float]) -> None:
        """Append one row."""
        for name, value in row.items():
            self.columns.setdefault(name, []).append(float(value))

    def add(self, name: str, values: Iterable[float]) -> None:
        """Add a whole column."""
        self.columns[name] = [float(value) for value in values]

    @property
    def units(self) -> dict[str, str]:
        """Unit of every column."""
        return {name: quantity(name).unit for name in self.columns}

    def items(self) -> Iterable[tuple[str, list[float]]]:
        """Names and values of the columns."""
        return self.columns.items()

    def __getitem__(self, name: str) -> list[float]:
        return self.columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        """Number of rows."""
        return len(next(iter(self.columns.values()), []))


class Recorded(np.ndarray[Any, np.dtype[np.float64]]):
    """A column as an array, with its `unit`."""

    unit: str

    @classmethod
    def of(cls, name: str, values: Iterable[float]) -> "Recorded":
        """The column of a name."""
        array = np.asarray(list(values), dtype=float).view(cls)
        array.unit = quantity(name).unit
        return array

    def __array_finalize__(self, source: object) -> None:
        self.unit = getattr(source, "unit", "")


History: TypeAlias = Columns | Mapping[str, Recorded]
"""Columns by name."""
