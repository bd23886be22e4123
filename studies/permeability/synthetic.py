"""Writes synthetic_baseline.csv and synthetic_bed.csv: SYNTHETIC falling-head tests, computed and made noisy, nothing measured.

Permeability 0.93e-8 m2, c0 and c1 as printed in the thesis (eq. 4.8), a reading every half second, noise of 0.1 g on the scale.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from porousmold.permeability.falling_head import Setup

HERE = Path(__file__).parent
SETUP = Setup(0.1016, np.pi / 4 * 0.1016**2, 0.250, 966.0, 0.099, 5.93e8, -2742.0)
PERMEABILITY = 0.93e-8
NOISE = 1e-4


def main():
    """Write both files."""
    random = np.random.default_rng(20211)
    empty = replace(SETUP, viscosity=1e-12)  # what a run without beads leaves of the bed
    for name, setup in (("synthetic_baseline", empty), ("synthetic_bed", SETUP)):
        time = np.arange(0.0, setup.duration(PERMEABILITY), 0.5)
        mass = setup.mass(time, PERMEABILITY) + random.normal(0.0, NOISE, len(time))
        rows = "".join(f"{t:.1f}, {1e3 * m:.2f}\n" for t, m in zip(time, mass, strict=True))
        (HERE / f"{name}.csv").write_text(f"# synthetic, by synthetic.py: nothing measured\ntime [s], mass [g]\n{rows}")


if __name__ == "__main__":
    main()
