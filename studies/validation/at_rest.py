"""Measured conductivities of beds at rest, a profile in vacuum and a pressure drop of helium, beside the program's laws.

Nothing is tuned. What an experiment does not state is varied over what it can be, and the page shows each.
"""

import csv
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from porousmold.laws.conductivity import LocalBed, stagnant_conductivity
from porousmold.laws.drag import DRAG_LAWS
from porousmold.laws.material_library import FLUIDS

DATA = Path(__file__).parent / "data"
ZERO_CELSIUS = 273.15
NO_GAS = 1e-3
"""W/m/K of the gas that is left in a vacuum: a hundredth of what radiation between pebbles of 60 mm carries, and less."""
CERAMIC, STEEL = 0.0077, 0.0013
"""Flattened share of a bead's section, VDI Heat Atlas D6.3: the program's default for ceramic and for steel beads."""
Values = NDArray[np.float64]


def columns(name: str) -> Values:
    """The columns of a measured file."""
    with (DATA / name).open() as file:
        return np.array([[float(cell) for cell in row] for row in list(csv.reader(file))[1:]]).T


def helium(kelvin: Values) -> Values:
    """Conductivity of helium that the source of the data takes, W/m/K."""
    return 0.0025 * kelvin**0.72


def nitrogen(kelvin: Values) -> Values:
    """Conductivity of nitrogen, W/m/K: that of the program's library, 200 to 1300 K."""
    return np.asarray(FLUIDS["nitrogen"].conductivity(kelvin), dtype=float)


def graphite(kelvin: Values) -> Values:
    """Conductivity of the graphite of SANA and COMET, W/m/K: the line that the source draws through seven values."""
    given = [25.0, 100.0, 200.0, 300.0, 400.0, 500.0, 1000.0], [110.0, 100.0, 92.0, 85.0, 79.0, 75.0, 50.0]
    return np.polyval(np.polyfit(*given, 1), kelvin - ZERO_CELSIUS)


def li2tio3(kelvin: Values, own_void: float) -> Values:
    """Conductivity of Li2TiO3 with a void of its own, W/m/K (as the source of the data)."""
    return (1.0 - own_void) ** 2.9 * (5.35 - 4.78e-3 * kelvin + 2.87e-6 * kelvin**2)


def graphite_in_vacuum(kelvin: Values) -> Values:
    """Conductivity of De Beer's graphite, W/m/K (as the source of the data)."""
    return np.polyval([1.595e-14, -7.255e-11, 6.566e-8, 1.403e-4, -0.3179, 230.01], kelvin)


def of_bed(
    void: float,
    diameter: float,
    gas: Values,
    beads: Values,
    kelvin: Values,
    emissivity: float,
    flattening: float | Values,
) -> Values:
    """Conductivity of a bed at rest by the program's law (Zehner, Bauer, Schluender), W/m/K."""
    bed = LocalBed(
        void, 0.3, diameter, 1e-3, 2e-5, 1000.0, 0.0, 0.0, gas, beads, void, 0.0, kelvin, emissivity, flattening
    )
    return np.asarray(stagnant_conductivity(bed, void), dtype=float)


@dataclass(frozen=True)
class Measured:
    """A set of measured conductivities, and the beds that it can have been measured on."""

    name: str
    file: str
    diameter: float
    gas: Callable[[Values], Values]
    beds: Mapping[str, tuple[float, Callable[[Values], Values], float]]
    """{words: (void, conductivity of the beads, flattening)}."""
    emissivity: float = 0.8

    def ratios(self, words: str) -> Values:
        """Computed over measured at every point, for one of the beds."""
        celsius, measured = columns(self.file)
        void, beads, flattening = self.beds[words]
        kelvin = celsius + ZERO_CELSIUS
        found = of_bed(void, self.diameter, self.gas(kelvin), beads(kelvin), kelvin, self.emissivity, flattening)
        return found / measured


def _li2tio3(own_void: float) -> Callable[[Values], Values]:
    return lambda kelvin: li2tio3(kelvin, own_void)


SETS = (
    Measured("Li2TiO3 1.91 mm in helium", "hatano_li2tio3_helium.csv", 1.91e-3, helium,
             {f"void {void}, beads {own:.0%} void": (void, _li2tio3(own), CERAMIC)
              for own in (0.1, 0.2) for void in (0.36, 0.40)}),
    Measured("graphite 1 mm in helium (COMET)", "comet_graphite_helium.csv", 1e-3, helium,
             {f"void {void}, flattening {flat}": (void, graphite, flat) for void in (0.36, 0.40) for flat in (0.0, CERAMIC)}),
    Measured("graphite 60 mm in helium (SANA)", "sana_helium.csv", 0.06, helium,
             {f"void 0.41, flattening {flat}": (0.41, graphite, flat) for flat in (0.0, CERAMIC, 0.02)}),
    Measured("graphite 60 mm in nitrogen (SANA)", "sana_nitrogen.csv", 0.06, nitrogen,
             {f"void 0.41, flattening {flat}": (0.41, graphite, flat) for flat in (0.0, CERAMIC, 0.02)}),
)  # fmt: skip


def compilation(void: float, flattening: float | None = None) -> tuple[Values, Values, Values]:
    """Ratios of conductivities beads to gas, bed to gas as measured and as computed; without a flattening, that of ceramic
    below a ratio of 300 and of steel above it."""
    beads, measured = columns("van_antwerpen_compilation.csv")
    touching = np.where(beads < 300.0, CERAMIC, STEEL) if flattening is None else flattening
    one = np.ones_like(beads)
    return beads, measured, of_bed(void, 1e-3, one, beads, 300.0 * one, 0.0, touching)


class Profile(NamedTuple):
    """A steady profile: distances (m), measured and computed temperatures (K)."""

    places: Values
    measured: Values
    computed: Values

    @property
    def rms(self) -> float:
        """Of the inner points, K; the outer two are boundary values."""
        return float(np.sqrt(np.mean((self.computed - self.measured)[1:-1] ** 2)))


def vacuum(void: float, flattening: float) -> Profile:
    """Graphite pebbles in vacuum between their outermost thermocouples: lambda(T) dT/dx = constant."""
    places, celsius = columns("debeer_graphite_vacuum.csv")
    kelvin = celsius + ZERO_CELSIUS
    warm = np.linspace(kelvin[-1], kelvin[0], 400)
    bed = of_bed(void, 0.06, np.full_like(warm, NO_GAS), graphite_in_vacuum(warm), warm, 0.8, flattening)
    carried = cumulative_trapezoid(bed, warm, initial=0.0)
    share = (places[-1] - places) / (places[-1] - places[0])
    return Profile(places, kelvin, np.interp(share * carried[-1], carried, warm))


def helium_pressure_drop(name: str, pressure: float) -> list[float]:
    """Computed over measured slope of the pressure from 0.15 to 0.55 m, at 0.5 and 1.0 m/s, by a drag law of the program."""
    void, diameter, width, kelvin = 0.373, 1e-3, 0.028, 293.15
    density, viscosity = pressure / (2077.1 * kelvin), 1.96e-5
    law = DRAG_LAWS[name].for_width(width / diameter)
    speeds, places, pressures = columns("cheng_helium_pressure_drop.csv")
    ratios = []
    for speed in np.unique(speeds):
        chosen = speeds == speed
        slope = np.ptp(pressures[chosen]) / np.ptp(places[chosen])
        inside = speed / void
        force = law.coefficient(void, diameter, density, viscosity, inside) * inside / void
        ratios.append(float(force) / slope)
    return ratios
