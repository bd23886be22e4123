"""A sheared bed beside what Forgber and Radl state of theirs: writes docs/sheared-bed.md. Run: make sheared-bed (10 minutes).

The paper's figures are not at hand: each statement of its text is held against numbers computed here, and agrees or does not.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from porousmold.laws.stirring import COEFFICIENT
from porousmold.shear.cell import ShearCell
from porousmold.shear.motion import Shearing
from studies.page import Page

DOCS = Path(__file__).parent.parent / "docs"
PECLET, BIOT = (0.01, 1.0, 100.0), (0.0, 0.1, 1.0, 10.0, 50.0)
FRACTIONS = (0.50, 0.53, 0.56, 0.58, 0.60, 0.62, 0.64)
STRAINS = {1e-1: 100.0, 1e-2: 100.0, 1e-3: 20.0}
FRICTIONS = (0.0, 0.1, 0.3)
JAMMED = 4.0
"""Contacts per bead from which a bed counts as jammed: of frictional spheres at least four."""


def measured(cell):
    """Of one cell."""
    return Shearing(cell).integrate()


def main():
    """Shear all cells, two at a time, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=DOCS / "sheared-bed.md")
    out = parser.parse_args().out
    common = {"peclet": PECLET, "biot": BIOT}
    cells = {(f, r, 0.5, 1): ShearCell(f, r, strains=s, **common) for r, s in STRAINS.items() for f in FRACTIONS}
    cells |= {
        (0.62, r, mu, 1): ShearCell(0.62, r, mu, strains=STRAINS[r], **common) for r in (1e-2, 1e-3) for mu in FRICTIONS
    }
    cells |= {(0.60, 1e-2, 0.5, seed): ShearCell(0.60, 1e-2, seed=seed, **common) for seed in (2, 3)}
    half_step = ShearCell(0.60, 1e-2, steps_per_contact=32, **common)
    others = {"half": half_step, "flat": ShearCell(0.60, 1e-2, walls="flat", **common)}
    for rate in (1e-2, 1e-3):
        for friction in (0.5, 0.0):
            settings = {"strains": STRAINS[rate], "walls": "flat"} | common
            others["flat", rate, friction] = ShearCell(0.62, rate, friction, **settings)
    with ProcessPoolExecutor(2, mp_context=get_context("fork")) as pool:
        futures = {key: pool.submit(measured, cell) for key, cell in (cells | others).items()}
        runs = {}
        for key, future in futures.items():
            runs[key] = future.result()
            print(key, f"conduction {runs[key].conduction[0, 0]:.3g}", flush=True)
    page = Page(
        "# A sheared bed",
        "",
        "Written by `make sheared-bed`; do not edit. T. Forgber and S. Radl (2016) sheared beads between flat walls; here the",
        "walls are rough (`porousmold shear`), as dense beads slip along flat ones. Distance of the walls 15 d, friction 0.5",
        "unless said, coefficient of restitution 0.9. The numbers of the paper's figures are not at hand; its text is quoted.",
        "",
        "A seed gives the same last digits, but for the first run after an installation: it compiles, its sums are rounded in",
        "another order (in the 14th digit after ten strains), and the motion is chaotic. Means differ within their",
        "standard errors.",
    )
    _statements(page, runs)
    _tables(page, runs)
    page.write(out)


def flux(run, peclet, biot, name="conduction"):
    """A mean flux of a run."""
    return getattr(run, name)[run.cell.pairs.index((peclet, biot)), 0]


def _statements(page, runs):
    """The statements of the paper, one by one."""
    at = {rate: [runs[f, rate, 0.5, 1] for f in FRACTIONS] for rate in STRAINS}
    orders = {rate: np.log10(flux(row[-1], 0.01, 0.1) / flux(row[0], 0.01, 0.1)) for rate, row in at.items()}
    jammed = {
        rate: [run.cell.solid_fraction for run in row if run.coordination_number > JAMMED] for rate, row in at.items()
    }
    drop = {}
    for rate in (1e-2, 1e-3):
        rough, smooth = runs[0.62, rate, 0.5, 1], runs[0.62, rate, 0.0, 1]
        drop[rate] = np.log10(flux(rough, 0.01, 0.1) / flux(smooth, 0.01, 0.1))
    flat_drop, flat_rate = {}, {}
    for rate in (1e-2, 1e-3):
        rough, smooth = runs["flat", rate, 0.5], runs["flat", rate, 0.0]
        flat_drop[rate] = np.log10(flux(rough, 0.01, 0.1) / flux(smooth, 0.01, 0.1))
        flat_rate[rate] = abs(smooth.core_shear_rate)
    same = [flux(runs[0.62, rate, 0.5, 1], 0.01, 0.1) for rate in STRAINS]
    carried = {rate: np.array([flux(run, 1.0, 0.0, "convection") / 4.0 for run in row]) for rate, row in at.items()}
    spread = {rate: values.max() / values.min() for rate, values in carried.items()}
    exponents = _exponents(runs)
    by_biot = [flux(runs[0.6, 1e-2, 0.5, 1], 0.01, biot) for biot in (0.1, 50.0)]
    soft, fast, stiff = (
        _over_biot(runs[0.6, *case[:1], 0.5, 1], case[1]) for case in ((1e-1, 1.0), (1e-1, 100.0), (1e-3, 1.0))
    )
    rows = [
        ("conduction rises upon jamming by up to five orders of magnitude (4.2)",
         f"from 0.50 to 0.64: {10.0 ** orders[1e-2]:.0f} times at 1e-2, {10.0 ** orders[1e-3]:.0f} times at 1e-3",
         f"in part: {max(orders.values()):.1f} orders"),
        ("no jump at a shear rate of 1e-1 (4.2)",
         f"{10.0 ** orders[1e-1]:.0f} times, without a step",
         "yes" if orders[1e-1] < 1.0 else "no"),
        ("jammed at 0.64 (1e-2), 0.62 (1e-3) (4.2)",
         f"more than {JAMMED:g} contacts per bead from {min(jammed[1e-2]):g} (1e-2), {min(jammed[1e-3]):g} (1e-3) on",
         "yes" if min(jammed[1e-2]) == 0.64 else "no: at lower fractions, behind rough walls"),
        ("at 0.62 and friction 0.5 conduction is nearly constant over the shear rate (4.1)",
         ", ".join(f"{value:.3f} at {rate:g}" for value, rate in zip(same, STRAINS, strict=True)),
         "yes" if max(same) < 1.3 * min(same) else "no"),
        ("friction 0.5 to 0 at 0.62: conduction drops by around seven orders (4.1)",
         ", ".join(f"{value:.1f} orders at {rate:g}" for rate, value in drop.items()),
         "yes" if max(drop.values()) > 5.0 else "in part: less"),
        ("the same between flat walls, as in the paper",
         ", ".join(f"{value:.1f} orders at {rate:g}" for rate, value in flat_drop.items())
         + f", growing with time: the core is sheared at {max(flat_rate.values()):.3f} of the rate at most",
         "in part: without friction flat walls do not shear the bed, which comes to rest"),
        ("convective flux 1e-2 of q_s times a Peclet number (4.4)",
         "over gamma d^2/a = 4 Pe: "
         + ", ".join(f"{carried[rate].min():.4f} to {carried[rate].max():.4f} at {rate:g}" for rate in (1e-2, 1e-3)),
         "yes, with 4 Pe" if 0.005 < carried[1e-2].mean() < 0.03 else "no"),
        ("convective flux nearly constant over the solid fraction, no effect of jamming (4.5)",
         f"largest over smallest {spread[1e-2]:.2f} at 1e-2, {spread[1e-3]:.2f} at 1e-3",
         "yes" if spread[1e-3] < 3.0 else "no"),
        ("soft beads (1e-1), Pe 1: convection up to two orders lower at large Bi (4.5)",
         f"Bi 0 over Bi 50: {soft:.0f} times", "yes" if 30.0 < soft < 300.0 else "in part"),
        ("soft beads, Pe 100: little effect of Bi (4.5)",
         f"Bi 0 over Bi 50: {fast:.1f} times", "yes" if fast < 2.0 else "no"),
        ("hard beads: convection independent of Bi (4.5, at 1e-4)",
         f"Bi 0 over Bi 50 at 1e-3, Pe 1: {stiff:.0f} times", "yes" if stiff < 2.0 else "no"),
        ("conduction proportional to p d/k (4.3)",
         f"exponents {exponents[0]:.2f} (unjammed), {exponents[1]:.2f} (jammed) at Bi 0",
         "yes" if min(exponents) > 0.9 else "no: linear springs give 3/4 and 1/2"),
        ("conduction proportional to Bi^-0.82 (4.3)",
         f"Bi 0.1 over Bi 50 at 0.60, 1e-2: {by_biot[0] / by_biot[1]:.2f} times",
         "yes" if by_biot[0] > 50.0 * by_biot[1] else "no: behind rough walls; of flat ones it is the gap to the first beads"),
    ]  # fmt: skip
    page.add("", "## The paper's statements")
    page.table(["paper (section)", "computed", "agrees"], rows)


def _over_biot(run, peclet):
    """Convection without a film over that with the strongest."""
    return flux(run, peclet, 0.0, "convection") / flux(run, peclet, 50.0, "convection")


def _exponents(runs):
    """Of conduction over pressure, for unjammed and jammed beds."""
    found = []
    for is_jammed in (False, True):
        chosen = [
            run
            for key, run in runs.items()
            if key[0] not in ("h", "f", "flat") and key[2] == 0.5 and (run.coordination_number > JAMMED) == is_jammed
        ]
        pressures, fluxes = [run.pressure for run in chosen], [flux(run, 0.01, 0.0) for run in chosen]
        found.append(np.polyfit(np.log(pressures), np.log(fluxes), 1)[0])
    return found


def _tables(page, runs):
    """Pressure, fluxes and stirring of all runs, and the checks."""
    page.add(
        "## Numbers",
        "",
        "Fluxes over lambda (T_top - T_bottom)/H, with standard errors; c of `laws.stirring` at Pe 100, Bi 0.",
    )
    head = ["solid fraction", "shear rate", "friction", "p d/k", "contacts"]
    head += ["conduction (Pe 0.01, Bi 0)", "convection (Pe 1, Bi 0)", "c", "self-diffusion/(gamma d^2)"]
    rows, coefficients = [], []
    for key, run in runs.items():
        if key in ("half", "flat") or key[0] == "flat" or key[3] != 1:
            continue
        conduction, convection = (
            run.conduction[run.cell.pairs.index((0.01, 0.0))],
            run.convection[run.cell.pairs.index((1.0, 0.0))],
        )
        stirring = run.stirring[run.cell.pairs.index((100.0, 0.0))]
        if key[2] == 0.5 and key[1] < 0.05:
            coefficients.append(stirring)
        row = [f"{key[0]:g}", f"{key[1]:g}", f"{key[2]:g}", f"{run.pressure:.3g}", f"{run.coordination_number:.2f}"]
        row += [f"{mean:.3g} ± {error:.1g}" for mean, error in (conduction, convection)]
        rows.append([*row, f"{stirring:.4f}", f"{run.self_diffusion[0]:.4f} ± {run.self_diffusion[1]:.1g}"])
    page.table(head, rows)
    usual = runs[0.6, 1e-2, 0.5, 1]
    others = [runs[0.6, 1e-2, 0.5, seed] for seed in (2, 3)]
    walls = [abs(usual.wall_flux[0] / (usual.conduction[0, 0] + usual.convection[0, 0]) - 1.0)]
    page.add(
        f"Mean of c at friction 0.5 and shear rates 1e-2 and 1e-3: **{np.mean(coefficients):.3f}**, {min(coefficients):.3f} to "
        f"{max(coefficients):.3f}; `bed.stirring_coefficient` has {COEFFICIENT:g}.",
        "",
        "## Checks (0.60, 1e-2)",
        "",
        f"- Mean flux over the volume against that through the walls (Pe 0.01, Bi 0): {walls[0]:.1%}, which is stored.",
        f"- Half the time step: pressure {_change(usual, runs['half'], 'pressure')}, conduction {_change(usual, runs['half'])}.",
        f"- Other seeds: conduction {_change(usual, others[0])} and {_change(usual, others[1])}, "
        f"pressure {_change(usual, others[0], 'pressure')} and {_change(usual, others[1], 'pressure')}.",
        f"- Shear rate of the core over the nominal one: {runs['flat'].core_shear_rate:.2f} between flat walls, "
        f"{usual.core_shear_rate:.2f} between rough ones.",
    )


def _change(run, other, name="conduction"):
    first, second = (getattr(r, name) if name == "pressure" else r.conduction[0, 0] for r in (run, other))
    return f"{second / first - 1.0:+.1%}"


if __name__ == "__main__":
    main()
