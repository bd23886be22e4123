"""Packings and their porosity against the thesis, LIGGGHTS and de Klerk, and heating times on their profiles.

Writes docs/packing.md, docs/packing.png and the profiles in studies/profiles. Run: make packing (about 25 minutes).
LIGGGHTS is compared with if it is installed (Debian's package of that name).
"""

import argparse
import shutil
import subprocess
import time
from functools import cache
from pathlib import Path

import numpy as np
from mpi4py import MPI

from porousmold import Scene
from porousmold.laws.oscillating_porosity import de_klerk
from porousmold.laws.porosity import POROSITY_MODELS
from porousmold.laws.porosity_profile import write_profile
from porousmold.packing.averaging import grid_profile, stratified_profile, thin_shell_porosity
from porousmold.packing.container import Cylinder, Slab
from porousmold.packing.files import read_packing, write_packing
from porousmold.packing.fitting import model_scores, piecewise_linear, profile_fits, r_squared
from porousmold.packing.generator import DEFAULT_FRICTION, RESTITUTION, STEPS_PER_CONTACT, Mixture, pack
from porousmold.packing.pictures import draw_profile
from porousmold.simulation.specs import specs_of
from porousmold.simulation.time_integration import Simulation
from studies.page import Page, yardstick

HERE = Path(__file__).parent
PIPE, HEIGHT, BEAD, BEADS = Cylinder(101.6e-3), 0.2, 6.27e-3, 7461


@cache
def bed(size, seed=1):
    """A bed of beads of one size (m) in the thesis's pipe: 7461 of them for its own size, else a height of 200 mm."""
    return pack(PIPE, Mixture((size,)), beads=BEADS if size == BEAD else None, bed_height=HEIGHT, seed=seed)


def timed(*arguments, **options):
    """(packing, seconds)."""
    start = time.perf_counter()
    packing = pack(*arguments, **options)
    return packing, time.perf_counter() - start


def thesis_bed(page):
    """The bed of section 5.6, three seeds."""
    page.add("## The bed of section 5.6: 7461 beads of 6.27 mm in 101.6 mm", "")
    pack(PIPE, Mixture((BEAD,)), beads=20)  # compiles
    rows = []
    for seed in (1, 2, 3):
        y = yardstick()
        packing, seconds = timed(PIPE, Mixture((BEAD,)), beads=BEADS, bed_height=HEIGHT, seed=seed)
        rows.append([f"{seed}", f"{seconds:.1f}", f"{seconds / y:.1f}", f"{packing.void_fraction(HEIGHT):.4f}",
                     f"{packing.mean_overlap:.3%}", f"{packing.coordination_number:.2f}",
                     f"{packing.bead_coordination_number:.2f}", f"{packing.made['kinetic_energy']:.1e}",
                     f"{packing.made['residual_force']:.1e}"])  # fmt: skip
    page.table(["seed", "seconds", "in Y", "void fraction, 0-200 mm", "mean overlap / d", "contacts per bead",
                "with beads alone", "kinetic energy, m g d", "residual force, m g"], rows)  # fmt: skip
    page.add("Thesis: 7461 beads, void fraction 0.406. Friction is the default 0.1.")


def liggghts(page):
    """The same bed by LIGGGHTS: the same contact law, its own random start of the same solid fraction."""
    page.add("## LIGGGHTS on the same task", "")
    program = shutil.which("liggghts")
    if program is None:
        page.add("LIGGGHTS was not installed: no comparison.")
        return
    folder = Path("runs") / "liggghts"
    folder.mkdir(parents=True, exist_ok=True)
    mass = 2500.0 * np.pi / 6.0 * BEAD**3
    stiffness = bed(BEAD).made["stiffness"] * mass * 9.81 / BEAD
    zeta = -np.log(RESTITUTION) / np.hypot(np.pi, np.log(RESTITUTION))
    damping = 2.0 * zeta * np.sqrt(stiffness / (0.5 * mass))
    step = np.pi * np.sqrt(0.5 * mass / (stiffness * (1.0 - zeta**2))) / STEPS_PER_CONTACT
    top = BEADS * np.pi / 6.0 * BEAD**3 / (0.30 * PIPE.cross_section)
    model = "model hooke/stiffness tangential history"
    (folder / "in.pack").write_text(f"""
units si
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
region box block -0.052 0.052 -0.052 0.052 -0.005 {top + 0.01} units box
create_box 1 box
neighbor 0.0008 bin
neigh_modify delay 0
fix kn all property/global kn peratomtypepair 1 {stiffness}
fix kt all property/global kt peratomtypepair 1 {stiffness * 2 / 7}
fix gn all property/global gamman peratomtypepair 1 {damping}
fix gt all property/global gammat peratomtypepair 1 {damping * 2 / 7}
fix mu all property/global coefficientFriction peratomtypepair 1 {DEFAULT_FRICTION}
pair_style gran {model}
pair_coeff * *
timestep {step}
fix gravity all gravity 9.81 vector 0 0 -1
fix side all wall/gran {model} primitive type 1 zcylinder {PIPE.radius} 0 0
fix floor all wall/gran {model} primitive type 1 zplane 0.0
fix pts all particletemplate/sphere 15485863 atom_type 1 density constant 2500 radius constant {BEAD / 2}
fix pdd all particledistribution/discrete 32452843 1 pts 1.0
region column cylinder z 0 0 {PIPE.radius} 0 {top} units box
fix ins all insert/pack seed 86028121 distributiontemplate pdd maxattempt 500 insert_every once overlapcheck yes &
  all_in yes vel constant 0 0 0 particles_in_region {BEADS} region column
fix integrate all nve/sphere
thermo_style custom step atoms ke
thermo 2000
thermo_modify lost ignore norm no
variable energy equal ke/({BEADS}*{mass * 9.81 * BEAD})
run 4000
label loop
run 1000
if "${{energy}} < 1e-6" then "jump SELF rest"
variable count equal step
if "${{count}} > 60000" then "jump SELF rest"
jump SELF loop
label rest
dump all all custom 1 packing.dump id type x y z radius
run 0
""")
    y = yardstick()
    start = time.perf_counter()
    run = subprocess.run([program, "-in", "in.pack"], cwd=folder, capture_output=True, text=True, timeout=1800)
    seconds = time.perf_counter() - start
    (folder / "screen").write_text(run.stdout + run.stderr)
    if run.returncode:
        page.add(f"LIGGGHTS ended with status {run.returncode}: see {folder}/screen.")
        return
    theirs = read_packing(folder / "packing.dump", PIPE)
    rows_of_thermo = [line.split() for line in run.stdout.splitlines() if line.split()[1:2] == [str(BEADS)]]
    steps = next(row[0] for row in reversed(rows_of_thermo) if row[0].isdecimal())
    page.add(f"LIGGGHTS took {seconds:.1f} s ({seconds / y:.1f} Y) on one core for {steps} steps of {step * 1e6:.1f} µs: "
             f"{theirs.diameters.size} beads, void fraction {theirs.void_fraction(HEIGHT):.4f}, mean overlap "
             f"{theirs.mean_overlap:.3%}, {theirs.coordination_number:.2f} contacts per bead. It has the same springs, "
             "dashpots and friction, but no decay of spins, and stops at the same kinetic energy.")  # fmt: skip
    rows = []
    # four times the points of the default: the samples' own scatter would be half of the difference
    reference = [stratified_profile(bed(BEAD), HEIGHT), thin_shell_porosity(bed(BEAD), HEIGHT, samples=40_000)[1]]
    for name, packing in (("LIGGGHTS", theirs), ("ours, seed 2", bed(BEAD, 2)), ("ours, seed 3", bed(BEAD, 3))):
        profile, shells = stratified_profile(packing, HEIGHT), thin_shell_porosity(packing, HEIGHT, samples=40_000)[1]
        rms = [np.sqrt(np.mean((a - b) ** 2)) for a, b in ((profile.phi_v, reference[0].phi_v),
               (profile.phi_a, reference[0].phi_a), (shells, reference[1]))]  # fmt: skip
        rows.append([name, *(f"{value:.4f}" for value in rms)])
    page.add("", "Root mean square differences from our seed 1:")
    page.table(["bed", "phi_V", "phi_A", "thin shells"], rows)


def scaling(page):
    """Seconds against the number of beads, beds of one shape."""
    page.add("## Growth", "")
    rows, numbers, all_seconds = [], [2000, 7461, 20_000, 50_000], []
    for number in numbers:
        y = yardstick()
        box = Cylinder(PIPE.diameter * (number / BEADS) ** (1 / 3))
        packing, seconds = timed(box, Mixture((BEAD,)), beads=number)
        all_seconds.append(seconds / y)
        rows.append([f"{number}", f"{seconds:.1f}", f"{seconds / y:.1f}", f"{packing.mean_overlap:.3%}",
                     f"{packing.void_fraction():.4f}"])  # fmt: skip
    page.table(["beads", "seconds", "in Y", "mean overlap / d", "void fraction to the levelled height"], rows)
    slope = np.polyfit(np.log(numbers), np.log(all_seconds), 1)[0]
    page.add(f"Slope {slope:.2f}: a taller bed falls longer, and its weight needs stiffer springs and shorter steps.")


def sizes(page):
    """Profiles of 3, 6.27 and 9 mm beads, the laws pooled over them, as in section 5.7."""
    page.add("## Profiles of 3, 6.27 and 9 mm beads (sections 5.6 and 5.7)", "")
    beds = {size * 1e3: bed(size) for size in (3e-3, BEAD, 9e-3)}
    rows, grids = [], []
    for size, packing in beds.items():
        fine, grid = stratified_profile(packing, HEIGHT), grid_profile(packing, 5e-3, HEIGHT)
        grids.append(grid)
        (difference, place), (on_grid, grid_place) = fine.largest_difference, grid.largest_difference
        rows.append([f"{size:g}", f"{PIPE.diameter / packing.bead_diameter:.1f}", f"{packing.diameters.size}",
                     f"{packing.void_fraction(HEIGHT):.4f}", f"{fine.bulk_porosity:.4f}", f"{difference:+.4f} at {place:.2f}",
                     f"{on_grid:+.4f} at {grid_place:.2f}"])  # fmt: skip
    page.table(["beads, mm", "D/d", "number", "void fraction, 0-200 mm", "bulk porosity (y >= 2.75 d)",
                "largest phi_V - phi_A (at y/d)", "the same on the thesis's 5 mm grid"], rows)  # fmt: skip
    page.add("Thesis: |phi_V - phi_A| up to about 0.09 for 0.3 < y/d < 2.75, phi_b about 0.4.", "")
    position, phi = (np.concatenate([getattr(grid, name)[1:] for grid in grids]) for name in ("position", "phi_v"))
    published = {"hunt-tien": "0.94", "white-tien": "0.79"}
    page.add("R² of phi_V over the three beds, pooled, on the thesis's grid:")
    rows = [[name, f"{score.given:.3f}", f"{score.fitted:.3f}", f"{score.fitted_bulk_porosity:.3f}", published.get(name, "-")]
            for name, score in model_scores(position, phi).items()]  # fmt: skip
    fit = piecewise_linear(position, phi)
    rows.append(["piecewise linear", "-", f"{r_squared(phi, fit(position)):.3f}", "-", "0.97"])
    page.table(["law", "phi_b = 0.4", "phi_b fitted", "that phi_b", "thesis"], rows)
    profile, shells = stratified_profile(bed(BEAD), HEIGHT), thin_shell_porosity(bed(BEAD), HEIGHT)
    bulk = profile.bulk_porosity
    rms = np.sqrt(np.mean((shells[1] - de_klerk(shells[0], bulk)) ** 2))
    page.add(f"Thin shells (0.05 d wide, to 5 d) of the 6.27 mm bed against de Klerk (2003) with the bed's bulk porosity "
             f"{bulk:.3f}: rms {rms:.4f}.")  # fmt: skip
    fits = profile_fits(profile)
    draw_profile(HERE.parent / "docs" / "packing.png", profile, fits, shells)
    page.add("", "![profiles of the 6.27 mm bed](packing.png)")


def mixture(page):
    """A two-size bed beside the one of one size (thesis, section 10.2)."""
    page.add("## A mixture of two sizes", "")
    two = pack(PIPE, Mixture((4e-3, 8e-3), (0.5, 0.5)), bed_height=HEIGHT)
    rows = []
    for name, packing in (("6.27 mm", bed(BEAD)), ("4 mm and 8 mm, half the mass each", two)):
        profile, shells = stratified_profile(packing, HEIGHT), thin_shell_porosity(packing, HEIGHT)
        difference, place = profile.largest_difference
        score = model_scores(profile.position, profile.phi_v)["hunt-tien"]
        low = shells[1][(shells[0] > 0.3) & (shells[0] < 0.9)].min()
        high = shells[1][(shells[0] > 0.7) & (shells[0] < 1.4)].max()
        rows.append([name, f"{packing.diameters.size}", f"{packing.bead_diameter * 1e3:.2f}",
                     f"{packing.void_fraction(HEIGHT):.4f}", f"{profile.bulk_porosity:.4f}",
                     f"{difference:+.4f} at {place:.2f}", f"{low:.2f}, {high:.2f}",
                     f"{score.fitted:.3f} ({score.fitted_bulk_porosity:.3f})"])  # fmt: skip
    page.table(["beads", "number", "Sauter mean, mm", "void fraction", "bulk porosity", "largest phi_V - phi_A (at y/d)",
                "first minimum and maximum of thin shells", "Hunt-Tien, R² (fitted phi_b)"], rows)  # fmt: skip
    page.add("y/d is taken with the Sauter mean diameter.")


def walls(page):
    """Slab walls against cylinder walls at D/d from 10 to 34."""
    page.add("## Slab against cylinder", "")
    rows = []
    for size in (10.16e-3, BEAD, 3e-3):
        ratio = PIPE.diameter / size
        round_bed = bed(size)
        flat_bed = pack(Slab(PIPE.diameter, max(12.0 * size, 0.04)), Mixture((size,)), bed_height=HEIGHT)
        cylinder, slab = stratified_profile(round_bed, HEIGHT), stratified_profile(flat_bed, HEIGHT)
        near = int((cylinder.position <= 3.0).sum())  # both have the same strata there
        rms = [
            np.sqrt(np.mean((getattr(slab, name)[:near] - getattr(cylinder, name)[:near]) ** 2))
            for name in ("phi_v", "phi_a")
        ]
        error = np.sqrt(np.mean(slab.phi_v_error[:near] ** 2 + cylinder.phi_v_error[:near] ** 2))
        rows.append([f"{ratio:.1f}", f"{flat_bed.diameters.size}, {round_bed.diameters.size}", f"{slab.bulk_porosity:.4f}",
                     f"{cylinder.bulk_porosity:.4f}", f"{slab.largest_difference[0]:+.4f}",
                     f"{cylinder.largest_difference[0]:+.4f}", f"{rms[0]:.4f}", f"{rms[1]:.4f}", f"{error:.4f}"])  # fmt: skip
    page.table(["D/d", "beads in slab, cylinder", "bulk, slab", "bulk, cylinder", "phi_V - phi_A, slab", "cylinder",
                "rms of phi_V, slab - cylinder, y <= 3 d", "of phi_A", "standard error of that difference"], rows)  # fmt: skip


def heating(page):
    """Heating times with the laws of table 5.1, with the fitted profile and with the raw one (section 6.6.4)."""
    page.add("## Heating times with laws and profiles", "")
    folder = HERE / "profiles"
    folder.mkdir(exist_ok=True)
    scenes = {"aluminium mold": (HERE / "mold" / "aluminium.toml", Slab(0.05, 0.06), "slab_ratio_10"),
              "pipe": (HERE / "pipe" / "baseline.toml", PIPE, "cylinder_ratio_20")}  # fmt: skip
    # damped sources switch on and off across the wide profile of Cheng and Hsu: that needs cells which resolve it
    finer = {"solver.cell_growth": 1.1}
    settings = {name: {"bed.porosity_model": name} for name in POROSITY_MODELS}
    rows: dict[str, list[str]] = {}
    for path, box, name in scenes.values():
        packing = pack(box, Mixture((5e-3,)), bed_height=HEIGHT)
        write_packing(packing, Path("runs") / f"{name}.h5")
        profile = stratified_profile(packing, HEIGHT)
        source = [
            f"{packing.diameters.size} beads of 5 mm in {box}, friction {packing.made['friction']:g}, seed 1: make packing"
        ]
        raw, fitted = folder / f"{name}.csv", folder / f"{name}_fitted.csv"
        write_profile(raw, profile, source)
        fits = profile_fits(profile)
        write_profile(fitted, profile, [*source, "piecewise-linear fits"], *fits)
        cases = settings | {"packing, piecewise-linear fit": {"bed.porosity_profile": str(fitted.resolve())},
                            "packing, raw": {"bed.porosity_profile": str(raw.resolve())},
                            "packing, raw, consistent REV terms": {"bed.porosity_profile": str(raw.resolve()),
                                                                   "model.rev_terms": "consistent"}}  # fmt: skip
        base = None
        for case, changes in cases.items():
            simulation = Simulation(specs_of(Scene.load(path, finer | changes)), MPI.COMM_WORLD).integrate()
            base = base or simulation.recorder.heating_time
            imbalance = abs(simulation.problem.heat.balance.imbalance)
            seconds = simulation.recorder.heating_time
            rows.setdefault(case, []).extend([f"{seconds:.1f}", f"{seconds / base - 1:+.1%}", f"{imbalance:.0e}"])
            print(case, rows[case], flush=True)
    page.table(["porosity", *(f"{name}{more}" for name in scenes for more in (", s", " against Hunt-Tien", ", imbalance"))],
               [[case, *cells] for case, cells in rows.items()])  # fmt: skip
    page.add("Cells grow by 1.1 across the bed here (default 1.3). The laws have bulk porosity 0.4, the profiles that")
    page.add("of their packings (slab of 10 d, cylinder of 20.3 d).")


PARTS = {"thesis": thesis_bed, "liggghts": liggghts, "growth": scaling, "sizes": sizes, "mixture": mixture, "walls": walls,
         "heating": heating}  # fmt: skip
HEAD = """# Packings and porosity

Written by `make packing`; do not edit.

Seconds are those of one core; Y is the median time of one sparse LU factorisation of the Laplacian on 300 x 300 points, taken
just before. Void fractions cut spheres exactly; profiles are means over averaging spheres of diameter min(2 y, 5.5 d).
"""


def main():
    """Compute the parts asked for, all by default, and put them into the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--only", nargs="*", choices=PARTS, default=list(PARTS), help="renew these parts of the page alone"
    )
    only, path = parser.parse_args().only, HERE.parent / "docs" / "packing.md"
    old = path.read_text(encoding="utf-8").split("\n## ")[1:] if path.is_file() else []
    sections = {text.split("\n", 1)[0]: text for text in old} if len(only) < len(PARTS) else {}
    for name in only:
        page = Page()
        PARTS[name](page)
        text = "\n".join(page.lines).strip().removeprefix("## ")
        sections[text.split("\n", 1)[0]] = text
    path.write_text("\n## ".join([HEAD, *(text.rstrip() + "\n" for text in sections.values())]), encoding="utf-8")


if __name__ == "__main__":
    main()
