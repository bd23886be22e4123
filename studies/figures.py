"""The thesis's parametric curves: runs the twelve studies of `pipe/curves` and `mold/curves`, draws the thirteen pictures
and writes docs/parametric.md, each beside what the thesis says of it. Run: make figures (minutes; on two cores).

Runs that are done already are not run again (`runs/curves`). With --against-full (make figures COMPARED=--against-full, minutes
more) the document tells how far the curves are from those of full flow.
"""

import argparse
import json
import time
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from mpi4py import MPI
from scipy.optimize import curve_fit

from porousmold.laws.material_library import FLUIDS
from porousmold.output.figures import STYLE, plt, save
from porousmold.study.definition import OF_EVERY_CASE, Study
from porousmold.study.running import run_study

HERE = Path(__file__).parent
OUT, FULL = HERE.parent / "runs" / "curves", HERE.parent / "runs" / "curves-full"
PICTURES = HERE.parent / "docs" / "parametric"
AGREEMENT = 0.02
"""Difference, of the time at the start, up to which a statement counts as met."""
TEMPERATURE_RISE = 65.0
"""Kelvin, of the mold's air in eq. 8.13."""
PUBLISHED = tomllib.loads((HERE.parent / "tests" / "published.toml").read_text())


def power_law(x, a, b):
    """a x^b"""
    return a * x**b


def line(x, a, b):
    """a + b x"""
    return a + b * x


@dataclass(frozen=True)
class Claim:
    """A statement of the thesis: from `start` to `end` of the key (SI) the heating time changes to `wanted` times itself."""

    start: float
    end: float
    wanted: float
    note: str = ""

    def told(self, curve, x, y):
        """The statement, what was computed, and a plain verdict."""
        first, last = (np.exp(np.interp(np.log(v), np.log(x), np.log(y))) for v in (self.start, self.end))
        found = last / first
        ends = " to ".join(f"{curve.factor * v:.4g}" for v in (self.start, self.end))
        text = (
            f"The thesis: from {ends} the heating time falls to"
            if self.wanted < 1
            else f"The thesis: from {ends} it rises to"
        )
        text += f" {self.wanted:.0%}. Here: to {found:.1%}."
        verdict = "Agrees" if abs(found - self.wanted) < AGREEMENT else "Does not agree"
        text += f" **{verdict}** ({found - self.wanted:+.1%} of the time at the start)."
        if self.wanted == 0.7 and y.min() <= 0.7 * first:
            order = np.argsort(y)
            needed = np.interp(0.7 * first, y[order], x[order])
            text += f" 70 % is reached at {curve.factor * needed:.4g}."
        return f"{text} {self.note}".strip()


@dataclass(frozen=True)
class Shape:
    """A statement of the thesis in words, and the condition on the points (values of the key, heating times) it comes to."""

    said: str
    condition: object

    def told(self, curve, x, y):
        """The statement and a plain verdict."""
        return f"The thesis: {self.said}. **{'Agrees' if self.condition(x, y) else 'Does not agree'}**."


def falls_ever_less(x, y):
    """Whether y falls with x, and its slope fades."""
    slopes = np.diff(y) / np.diff(x)
    return bool(np.all(slopes < 0.0) and np.all(np.diff(slopes) > 0.0))


def flat_at_the_end(x, y):
    """Whether y falls by more than a tenth in the first half of its points and changes by less than a tenth in the rest."""
    half = len(x) // 2
    return bool(y[0] > 1.1 * y[half] and np.ptp(y[half:]) < 0.1 * y[half])


def nearly_linear(x, y):
    """Whether a straight line leaves less than a hundredth of the variance."""
    return bool(np.corrcoef(x, y)[0, 1] ** 2 > 0.99)


@dataclass(frozen=True)
class Curve:
    """A picture: the figure's number, the study, the key on the axis, its unit there, baseline (SI), the fit, if any, and
    what the thesis says of it."""

    figure: str
    study: str
    key: str
    label: str
    factor: float
    baseline: float
    fit: Callable | None = None
    statements: tuple = ()
    energy: bool = False


def curves():
    """All thirteen, in the thesis's order."""
    pipe, mold = PUBLISHED["pipe"]["study"], PUBLISHED["mold"]

    def seventy(baseline, change, note=""):
        return (Claim(baseline, baseline * (1.0 + change), 0.7, note),)

    not_both = "It cannot hold beside the statement on the heat capacity: both change the wall's heat alike."
    return [
        Curve("7.10", "pipe/curves/bead_diameter", "bed.bead_diameter", "bead diameter in mm", 1e3, 5e-3, power_law,
              seventy(5e-3, pipe["bead_diameter_for_70_percent"])),
        Curve("7.11", "pipe/curves/pressure_drop", "operation.pressure_drop", "pressure drop in kPa", 1e-3, 2e3, power_law,
              seventy(2e3, pipe["pressure_drop_for_70_percent"])),
        Curve("7.12", "pipe/curves/wall_thickness", "wall.thickness", "wall thickness in mm", 1e3, 6.35e-3, line,
              seventy(6.35e-3, pipe["wall_thickness_for_70_percent"], not_both)),
        Curve("7.13", "pipe/curves/wall_heat_capacity", "wall.heat_capacity",
              "heat capacity of the wall in kJ/kg/K (constant)", 1e-3, 1456.0, line,
              seventy(1456.0, pipe["wall_heat_capacity_for_70_percent"])),
        Curve("7.14", "pipe/curves/wall_conductivity", "wall.conductivity", "conductivity of the wall in W/m/K", 1.0, 0.2,
              None, (Claim(5.0, 180.0, 1.0 + pipe["wall_conductivity_5_to_180"], "The print fits acrylic's 0.2 better:"),
                     Claim(0.2, 180.0, 1.0 + pipe["wall_conductivity_5_to_180"]))),
        Curve("7.15", "pipe/curves/bead_heat_capacity", "bed.bead_heat_capacity", "heat capacity of the beads in kJ/kg/K",
              1e-3, 846.7, line,
              (Claim(846.7, 1.5 * 846.7, 1.0 + pipe["bead_heat_capacity_plus_50_percent"]),)),
        Curve("8.4", "mold/curves/skin_thickness", "wall.thickness", "skin thickness in mm", 1e3, 3e-3, line,
              seventy(3e-3, mold["skin_thickness_for_70_percent"], not_both)),
        Curve("8.5", "mold/curves/skin_heat_capacity", "wall.heat_capacity", "heat capacity of the skin in kJ/kg/K", 1e-3,
              903.0, line, seventy(903.0, mold["skin_heat_capacity_for_70_percent"])),
        Curve("8.6", "mold/curves/bead_heat_capacity", "bed.bead_heat_capacity", "heat capacity of the beads in kJ/kg/K",
              1e-3, 846.7, line,
              (Claim(846.7, 0.23 * 846.7, 1.0 + mold["bead_heat_capacity_minus_77_percent"],
                     "A reduction TO 77 % is what fits the print:"),
               Claim(846.7, 0.77 * 846.7, 1.0 + mold["bead_heat_capacity_minus_77_percent"]))),
        Curve("8.7", "mold/curves/skin_conductivity", "wall.conductivity", "conductivity of the skin in W/m/K", 1.0, 237.0,
              None, (Shape("a sharp fall at low conductivities, then nearly constant", flat_at_the_end),)),
        Curve("8.8", "mold/curves/bead_diameter", "bed.bead_diameter", "bead diameter in mm", 1e3, 5e-3, power_law,
              (Shape("larger beads heat faster", lambda x, y: bool(np.all(np.diff(y) < 0.0))),)),
        Curve("8.9", "mold/curves/cavity_height", "geometry.cavity_height", "cavity height in mm, 10 beads", 1e3, 0.05, None,
              (Shape("the heating time falls with the height, ever less", falls_ever_less),)),
        Curve("8.10", "mold/curves/cavity_height", "geometry.cavity_height", "cavity height in mm, 10 beads", 1e3, 0.05,
              line, (Shape("Q_air rises linearly with the height", nearly_linear),), energy=True),
    ]  # fmt: skip


def run_studies(names):
    """Run every study by the ranks there are (collective); gives the seconds."""
    begun = time.perf_counter()
    for name in names:
        run_study(Study.load(HERE / f"{name}.toml"), OUT / name)
    return time.perf_counter() - begun


def deviation_from_full_flow(names):
    """Run every case with full flow too (collective): a sentence about how far the heating times are apart."""
    found = []
    for name in names:
        study = Study.load(HERE / f"{name}.toml")
        full = study.with_cases(
            [replace(case, scene=case.scene.changed({"model.flow": "full"})) for case in study.cases]
        )
        for one, other in zip(rows(name), run_study(full, FULL / name), strict=True):
            if one["heating_time"] and other.values["heating_time"]:
                found.append(abs(one["heating_time"] / other.values["heating_time"] - 1.0))
    return (
        f"With full flow the heating times of {len(found)} of them differ by {np.median(found):.2%} on the median and "
        f"{max(found):.2%} at most."
    )


def rows(name):
    """The table of a study that was run."""
    return json.loads((OUT / name / "table.json").read_text())


def points(curve):
    """Values (SI) of the key and heating times in s, or Q_air in J per metre width, of the cases that were heated."""
    found = []
    for row in rows(curve.study):
        value = row["heating_time"]
        if value is None:
            print(f"{curve.study}: {row['folder']} is {row['status']}: {row['reason']}")
            continue
        if curve.energy:  # eq. 8.13, whole cavity: the model's mass flow is that of half of it
            value *= 2.0 * row["mass_flow_final"] * FLUIDS["air"].heat_capacity(363.15) * TEMPERATURE_RISE
        found.append((row[curve.key], value))
    return np.array(sorted(found)).T


def draw(curve, x, y, fitted):
    """The picture of one curve."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(5.2, 3.8))
        figure.subplots_adjust(left=0.14, right=0.97, bottom=0.14, top=0.92)
        axes.plot(curve.factor * x, y / (1e6 if curve.energy else 1.0), "o", color="tab:blue", label="computed")
        if fitted is not None:
            fine = np.linspace(x.min(), x.max(), 200)
            values = curve.fit(fine / curve.baseline, *fitted) / (1e6 if curve.energy else 1.0)
            axes.plot(curve.factor * fine, values, color="0.5", label=f"fit {curve.fit.__doc__}")
        if "conductivity" in curve.label:
            axes.set_xscale("log")
        unit = "Q_air in MJ per metre width" if curve.energy else "heating time in s"
        axes.set(xlabel=curve.label, ylabel=unit, ylim=(0, None))
        axes.set_title(f"as thesis figure {curve.figure}", fontsize=10)
        axes.legend(fontsize=9)
        save(figure, PICTURES / f"figure-{curve.figure}.png")


def report(curve):
    """Draw one curve, and give its lines of the document."""
    x, y = points(curve)
    fitted, lines = None, [f"## Figure {curve.figure}: {curve.label}", ""]
    lines += [f"![figure {curve.figure}](parametric/figure-{curve.figure}.png)", ""]
    what = "Q_air, MJ/m" if curve.energy else "heating time, s"
    lines += [f"| {curve.label} | " + " | ".join(f"{curve.factor * v:.4g}" for v in x) + " |"]
    lines += [
        "|---|" + "---|" * len(x),
        f"| {what} | " + " | ".join(f"{v / (1e6 if curve.energy else 1):.4g}" for v in y) + " |",
    ]
    lines += [""]
    if curve.fit is not None:
        fitted = curve_fit(curve.fit, x / curve.baseline, y, p0=(y.mean(), 0.1))[0]
        residual = y - curve.fit(x / curve.baseline, *fitted)
        r2 = 1.0 - np.sum(residual**2) / np.sum((y - y.mean()) ** 2)
        a, b = f"{fitted[0]:.4g}", f"{fitted[1]:.4g}"
        unit = "J" if curve.energy else "s"
        lines += [f"Fit {curve.fit.__doc__} ({unit}, x in baselines): a = {a}, b = {b}, R² = {r2:.4f}.", ""]
    draw(curve, x, y, fitted)
    for statement in curve.statements:
        lines += [statement.told(curve, x, y), ""]
    return lines


def main():
    """Run on all ranks; draw and write on the first."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--against-full", action="store_true", help="run all cases with full flow too, and tell the difference"
    )
    names = list(dict.fromkeys(curve.study for curve in curves()))
    compared = parser.parse_args().against_full
    seconds = run_studies(names)
    difference = deviation_from_full_flow(names) if compared else ""
    if MPI.COMM_WORLD.rank > 0:
        return
    PICTURES.mkdir(parents=True, exist_ok=True)
    command = " COMPARED=--against-full" if compared else ""
    given = Study.load(HERE / f"{names[0]}.toml").common
    chosen = ", ".join(f"{key} {value}" for key, value in given.items() if key not in OF_EVERY_CASE)
    cases, ranks = sum(len(rows(name)) for name in names), MPI.COMM_WORLD.size
    lines = ["# The thesis's parametric curves", "", f"Written by `make figures{command}`; do not edit.", ""]
    lines += [f"{cases} runs took {seconds:.0f} s on {ranks} ranks, one case each (those done before are not counted anew).",
              f"All with {chosen}. {difference}".strip(),
              "The thesis's curves themselves are not available as numbers; its statements are.", ""]  # fmt: skip
    for curve in curves():
        lines += report(curve)
    (HERE.parent / "docs" / "parametric.md").write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
