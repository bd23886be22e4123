"""What the inside of the beads does to the heating time, and what it costs: writes docs/bead-interior.md.

Run: make bead-interior (minutes).

The shipped molds and the pipe, with their ceramic beads and with beads that differ from these only by a conductivity of
0.2 W/(m K), as of a polymer. Isothermal beads (no model.bead_modes) are compared with N modes of the temperature inside them.
"""

import argparse
import statistics
from pathlib import Path

from porousmold import Scene, run
from studies.page import Page

HERE = Path(__file__).parent
SCENES = {
    "aluminium mold": HERE / "mold" / "aluminium.toml",
    "FRP mold": HERE / "mold" / "frp.toml",
    "pipe": HERE / "pipe" / "baseline.toml",
}
BEADS = {"ceramic, 2.09 W/(m K)": None, "poor conductor, 0.2 W/(m K)": 0.2}
MODES = (None, 0, 1, 2, 4, 8)
REPEATED = 3
HEAD = (
    *("beads", "Bi = h R/(3 lambda)", "modes", "heating time, s", "against isothermal", "against 8 modes"),
    *("surface from mean, K", "solver seconds against isothermal"),
)


def outcomes(scene):
    """(summary, largest difference inside a bead (K), solver seconds) by modes; all of them in turn, `REPEATED` times."""
    found, seconds = {}, {modes: [] for modes in MODES}
    for _ in range(REPEATED):
        for modes in MODES:
            result = run(scene.changed({"model.bead_modes": modes}))
            spent = result.summary["wall_seconds"]
            seconds[modes].append(spent["flow"] + spent["energy"])
            found[modes] = result.summary, max(result.history.get("largest_bead_difference", [0.0]))
    return {modes: (*found[modes], statistics.median(seconds[modes])) for modes in MODES}


def rows(beads, found):
    """Lines of a scene's table for one kind of beads."""
    isothermal, finest = found[None], found[MODES[-1]]
    for modes, (summary, difference, seconds) in found.items():
        time = summary["heating_time"]
        yield (
            *(beads, f"{summary['bead_biot_number']:.2g}", "isothermal" if modes is None else modes, f"{time:.2f}"),
            *(f"{time / isothermal[0]['heating_time'] - 1.0:+.3%}", f"{time / finest[0]['heating_time'] - 1.0:+.4%}"),
            *("" if modes is None else f"{difference:.1f}", f"{seconds / isothermal[2]:.2f}"),
        )


def main():
    """Run everything and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=HERE.parent / "docs" / "bead-interior.md")
    out = parser.parse_args().out
    page = Page("# Beads that are not isothermal", "", "Written by `make bead-interior`; do not edit.", "",
             *__doc__.split("\n\n", 2)[2].strip().splitlines(),
             f"Seconds are medians of {REPEATED} runs. The modes add no unknowns to the equations (docs/theory.md).")  # fmt: skip
    for name, path in SCENES.items():
        page.add("", f"## {name[0].upper()}{name[1:]}")
        page.head(*HEAD)
        for beads, conductivity in BEADS.items():
            for cells in rows(beads, outcomes(Scene.load(path, {"bed.bead_conductivity": conductivity}))):
                page.row(*cells)
    page.write(out)


if __name__ == "__main__":
    main()
