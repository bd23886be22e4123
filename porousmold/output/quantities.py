"""Every quantity that is recorded, named and written: one table for history, result, tables, fields, axes and report.

An entry with a value is a column of the history: another quantity of a run is another entry here, and nothing else.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np


@dataclass(frozen=True, kw_only=True)
class Moment:
    """The end of a step (s), which values are taken of: `problem` is the discrete one (`simulation.problem.Problem`).

    Mass flow (kg/s) and pressure drop (Pa) have the sign of the flow's direction. `extremes` (K) are the lowest and highest
    temperature of every place, `deficits` (K) its largest distance from the inlet's; `ends` (m) where the wall's bed side is
    coldest and hottest; `at_places` the values at stations and sensors; `nodal_range` (K) the lowest and highest temperature of
    all nodes.
    """

    time: float
    step: float
    problem: Any
    set_point: float
    mass_flow: float
    pressure_drop: float
    extremes: Mapping[str, tuple[float, float]]
    nodal_range: tuple[float, float]
    deficits: Mapping[str, float]
    ends: tuple[float, float]
    at_places: Mapping[str, Mapping[str, float]]


@dataclass(frozen=True)
class Quantity:
    """A recorded quantity: `symbol` as in formulas (TeX), `label` in words, its SI unit, and its `value` at the end of a step
    where it is a column of the history, None in runs that have none; a quantity of named places has a value for each."""

    symbol: str
    label: str
    unit: str
    value: Callable[[Moment], float | None] | None = None
    values: Callable[[Moment], Mapping[str, float]] | None = None

    @property
    def axis_label(self) -> str:
        """Words, symbol and unit, as an axis has them."""
        unit = "" if self.unit == "1" else f" in {self.unit.replace('2', '²').replace('3', '³')}"
        return f"{self.label} ${self.symbol}${unit}" if self.symbol else f"{self.label}{unit}"


def _of_supply(now: Moment, name: str) -> float | None:
    return None if now.problem.air_loop is None else now.problem.air_loop.powers[name]


QUANTITIES: Mapping[str, Quantity] = {
    "time": Quantity("t", "time", "s", value=lambda now: now.time),
    "step": Quantity(r"\Delta t", "time step", "s", value=lambda now: now.step),
    "inlet_temperature": Quantity(
        r"T_\mathrm{in}", "inlet temperature", "K", value=lambda now: now.problem.inlet_temperature
    ),
    "set_point": Quantity(
        r"T_\mathrm{set}", "set-point of the inlet temperature", "K", value=lambda now: now.set_point
    ),
    "outlet_temperature": Quantity(
        r"T_\mathrm{out}", "mean outlet temperature", "K", value=lambda now: now.problem.balances.outlet_temperature
    ),
    "mass_flow": Quantity(r"\dot{m}", "mass flow", "kg/s", value=lambda now: now.mass_flow),
    "pressure_drop": Quantity(r"\Delta p", "pressure drop", "Pa", value=lambda now: now.pressure_drop),
    "heat_by_fluid": Quantity(
        "Q_f", "heat transferred from the fluid", "J", value=lambda now: now.problem.heat.balance.by_fluid
    ),
    "heat_through_outer_wall": Quantity(
        "Q_o", "heat in through the outer wall", "J", value=lambda now: now.problem.heat.balance.through_outer_wall
    ),
    "heat_stored": Quantity("Q_s", "heat stored", "J", value=lambda now: now.problem.heat.balance.stored),
    "heat_by_beads": Quantity(
        "Q_v",
        "net heat supplied by moving beads",
        "J",
        value=lambda now: now.problem.heat.balance.by_beads if now.problem.beads_move else None,
    ),
    "bead_outlet_temperature": Quantity(
        r"T_{s,\mathrm{out}}",
        "mean temperature of the beads that leave",
        "K",
        value=lambda now: now.problem.balances.bead_outlet_temperature,
    ),
    "heat_by_rev_terms": Quantity(
        "Q_b", "heat created by REV terms", "J", value=lambda now: now.problem.heat.balance.by_rev_terms
    ),
    "lowest_temperature": Quantity(r"T_\min", "lowest temperature", "K", value=lambda now: now.nodal_range[0]),
    "highest_temperature": Quantity(
        r"T_\max",
        "highest temperature",
        "K",
        value=lambda now: now.nodal_range[1],
    ),
    "heater_power": Quantity(
        "P_h", "heater's power for the whole tool", "W", value=lambda now: _of_supply(now, "heater_power")
    ),
    "blower_power": Quantity(
        "P_b", "blower's power for the whole tool", "W", value=lambda now: _of_supply(now, "blower_power")
    ),
    "coldest_place": Quantity(
        "x", "place of the coldest point of the wall's bed side along the flow", "m", value=lambda now: now.ends[0]
    ),
    "hottest_place": Quantity(
        "x", "place of the hottest point of the wall's bed side along the flow", "m", value=lambda now: now.ends[1]
    ),
    "largest_bead_difference": Quantity(
        r"\Delta T_s",
        "largest difference between surface and mean temperature of a bead",
        "K",
        value=lambda now: now.problem.heat.largest_bead_difference(),
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
    "temperature": Quantity("T", "temperature of fluid or wall", "K", values=lambda now: now.at_places["temperature"]),
    "sensor": Quantity("T", "temperature at a sensor", "K", values=lambda now: now.at_places["sensor"]),
    "lowest": Quantity(
        r"T_\min",
        "lowest temperature of a place",
        "K",
        values=lambda now: {place: low for place, (low, _) in now.extremes.items()},
    ),
    "highest": Quantity(
        r"T_\max",
        "highest temperature of a place",
        "K",
        values=lambda now: {place: high for place, (_, high) in now.extremes.items()},
    ),
    "cure": Quantity(
        r"\alpha",
        "least degree of cure of a layer",
        "1",
        values=lambda now: {name: least for name, (least, _) in now.problem.degrees_of_cure().items()},
    ),
    "deficit": Quantity(
        r"\Delta T",
        "largest difference between a place and the inlet temperature",
        "K",
        values=lambda now: now.deficits,
    ),
    "fluid": Quantity("T_f", "fluid temperature along the bed at the end of a phase", "K"),
    "beads": Quantity("T_s", "bead temperature along the bed at the end of a phase", "K"),
    "gradient": Quantity(
        r"|\nabla T|", "temperature gradient at a sensor", "K/m", values=lambda now: now.at_places["gradient"]
    ),
}
"""Quantities at named places: `temperature_outer_L` is the temperature at `outer_L`."""


JOULES_A_KWH = 3.6e6
ENERGY_NAMES = {
    "heater": "heater",
    "blower": "blower",
    "cure": "cure",
    "sources": "sources in the wall",
    "fluid": "fluid in the bed",
    "wall": "wall",
    "beads": "beads",
    "exhaust": "exhaust",
    "return_duct": "return duct",
    "outer_wall": "outer wall",
}
"""What gives energy to a tool, and where it goes, in words."""
ENERGY_GIVEN = ("heater", "blower", "cure", "sources")


def row_of(now: Moment) -> dict[str, float]:
    """The row of a history at the end of a step (collective)."""
    row: dict[str, float] = {}
    for name, one in QUANTITIES.items():
        if one.value is not None and (value := one.value(now)) is not None:
            row[name] = value
    for name, one in FAMILIES.items():
        if one.values is not None:
            row |= {f"{name}_{place}": value for place, value in one.values(now).items()}
    return row


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
