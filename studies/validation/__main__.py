"""The closures against measurements: writes docs/validation.md with pictures. Run: make validation (minutes)."""

import argparse
import statistics
import time
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

import porousmold
from porousmold import Scene
from porousmold.experiment.comparison import Deviation, compare
from porousmold.laws.porosity import benyahia_oneill_mean_porosity, dixon_mean_porosity
from porousmold.output.figures import plt, save
from porousmold.scene.closures import CLOSURES
from studies.page import Page

from . import at_rest, texts
from .beds import Bed, Settings, run_along
from .correlations import AIR as FLUID
from .correlations import (
    PRESSURE_DROP,
    WALL,
    li_finlayson,
    overall_sets,
    radial_specchia,
    radial_vdi,
    stagnant,
    wall_of,
)
from .texts import paragraphs

HERE = Path(__file__).parent.parent
DOCS = HERE.parent / "docs"
PUBLISHED = tomllib.loads((HERE.parent / "tests" / "published.toml").read_text())["permeability"]["bed"]
WIDTHS = (10, 15, 20, 30)
SPEEDS = (100, 200, 420, 700, 1000, 1500, 2000, 3000)
SLOW_TO_FAST = (50, 100, 200, 420, 1000, 2000, 5000)
THESIS: Settings = {}
MEASURED: Settings = {"model.closures": "measured"}
MODELS: Mapping[str, Settings] = {
    "thesis, laminar": {"model.turbulence": "none"},
    "thesis, k-epsilon": {"model.turbulence": "k-epsilon"},
    "thesis, N-K": {"model.turbulence": "nakayama-kuwahara"},
    "thesis, damped N-K": THESIS,
    "measured": MEASURED,
}
LATERAL = {"model.bead_conduction": "zehner-bauer-schluender", "model.dispersion": "winterberg-tsotsas"}
SHIPPED = {
    "aluminium mold": HERE / "mold" / "aluminium.toml",
    "FRP mold": HERE / "mold" / "frp.toml",
    "pipe": HERE / "pipe" / "baseline.toml",
}
DRAWN = {"output.pictures": False, "output.fields": False}
STEEL = HERE / "beds" / "steel_heated_from_above.toml"


def spread(values: list[float]) -> str:
    """Smallest to largest."""
    return f"{min(values):.2f} to {max(values):.2f}"


def verdict(ratios: list[float], allowed: float) -> str:
    """What ratios to correlations say of a set of closures, with the scatter that is allowed."""
    low, high = min(ratios) - 1.0, max(ratios) - 1.0
    return ("within" if max(-low, high) <= allowed else "beyond") + f" {allowed:.0%}: {low:+.0%} to {high:+.0%}"


def _at_measured_void(beds: list[Bed]) -> list[float]:
    """Pressure drops over the median of the correlations at Dixon's mean void."""
    ratios = []
    for bed in beds:
        void = dixon_mean_porosity(bed.n)
        measured = statistics.median(law.factor(bed.re, void, bed.n) for law in PRESSURE_DROP.values()) * _weight(void)
        ratios.append(bed.drag_factor * _weight(bed.mean_porosity) / measured)
    return ratios


def _weight(void: float) -> float:
    return (1.0 - void) / void**3


def _scatter(medians: Mapping[tuple[int, int], float]) -> dict[str, float]:
    """How far the eight sets lie from their median."""
    points = [(n, re) for n in WIDTHS for re in SPEEDS]
    ratios = np.array([[value / medians[n, re] for value in overall_sets(re, n).values()] for n, re in points])
    near = ratios[[420 <= re <= 1000 for _, re in points]]
    rms, close = (float(np.sqrt(np.mean((part - 1.0) ** 2))) for part in (ratios, near))
    return {"rms": rms, "near": close, "low": float(ratios.min()), "high": float(ratios.max())}


def pressure_drop(page: Page, pictures: Path) -> None:
    """Against flow in tubes and slabs, each at its own mean void."""
    page.add("", "## Pressure drop", "", *paragraphs(texts.PRESSURE))
    shapes = [(n, False) for n in (10, 20, 30)] + [(n, True) for n in (20, 30)]
    sets: Mapping[str, Settings] = {"thesis": {"model.turbulence": "none"}, "measured": MEASURED}
    beds = {(name, n, slab, re): Bed.of(re, n, settings, slab=slab)
            for name, settings in sets.items() for n, slab in shapes for re in SLOW_TO_FAST}  # fmt: skip
    ranges = [f"{name}, Re_d {low} to {high}" for name in sets for low, high in ((50, 1000), (2000, 5000))]
    page.head("correlation", "valid", "its scatter", *ranges, "measured, Re_d up to 1000")
    for label, law in PRESSURE_DROP.items():
        cells, slow_ratios = [], []
        for name in sets:
            for low, high in ((50, 1000), (2000, 5000)):
                if label.startswith("Dixon"):
                    low = max(low, 100)
                ratios = [bed.drag_factor / law.factor(re, bed.mean_porosity, n) for (s, n, _, re), bed in beds.items()
                          if s == name and low <= re <= high]  # fmt: skip
                slow_ratios = ratios if high == 1000 else slow_ratios
                cells.append(spread(ratios))
        page.row(label, law.valid, law.scatter, *cells, verdict(slow_ratios, 0.15))
    page.add("", *paragraphs(texts.PRESSURE_AT_MEASURED_VOID))
    page.head("closures", *(f"D/d = {n}" for n in (10, 20, 30)))
    for name in sets:
        page.row(
            name,
            *(
                spread(_at_measured_void([beds[name, n, False, re] for re in (100, 200, 420, 1000)]))
                for n in (10, 20, 30)
            ),
        )
    page.add(
        "", *paragraphs(texts.PRESSURE_END), "![Drag factor against Reynolds number](validation/pressure_drop.png)"
    )
    figure, axes = plt.subplots(1, 2, figsize=(10, 4), sharey=True, layout="constrained")
    for axis, n in zip(axes, (10, 30), strict=True):
        re = np.geomspace(50, 5000, 60)
        for name, colour in (("thesis", "C3"), ("measured", "C0")):
            chosen = [(r, bed) for (s, m, slab, r), bed in beds.items() if s == name and m == n and not slab]
            axis.loglog(
                [r for r, _ in chosen],
                [bed.drag_factor for _, bed in chosen],
                f"{colour}o-",
                label=f"model, closures {name}",
            )
        void = beds["measured", n, False, 420].mean_porosity
        for law in PRESSURE_DROP.values():
            axis.loglog(re, [law.factor(r, void, n) for r in re], lw=0.8, color="0.5")
        kta = np.array([PRESSURE_DROP["KTA 1981"].factor(r, void, n) for r in re])
        axis.fill_between(re, 0.85 * kta, 1.15 * kta, color="0.85", label="KTA 1981, ±15 %")
        axis.set_title(f"tube, D/d = {n} (grey: six correlations)")
        axis.set_xlabel("Re$_d$")
    axes[0].set_ylabel("F = Δp/L · φ³d/[(1−φ)ρU²]")
    axes[0].legend()
    save(figure, pictures / "pressure_drop.png")
    shares = {name: [1e2 * beds[name, n, False, 420].near_wall_share for n in (10, 20, 30)] for name in sets}
    page.add("", "### Flow near the wall and mean void", "")
    page.head("D/d", "mean void, thesis", "measured", "Dixon 1988", "Benyahia, O'Neill 2005",
              "flow within d/2 of the wall at Re_d 420, thesis", "measured")  # fmt: skip
    for place, n in enumerate((10, 20, 30)):
        voids = [f"{beds[name, n, False, 420].mean_porosity:.3f}" for name in sets]
        flows = [f"{shares[name][place]:.1f} %" for name in sets]
        page.row(n, *voids, f"{dixon_mean_porosity(n):.3f}", f"{benyahia_oneill_mean_porosity(n):.3f}", *flows)
    page.add("", *paragraphs(texts.VOID_END))


def heat_transfer(page: Page, pictures: Path) -> None:
    """From a wall of fixed temperature, whole and split."""
    medians = {(n, re): float(np.median(list(overall_sets(re, n).values()))) for n in WIDTHS for re in SPEEDS}
    found: dict[tuple[str, int, int], float] = {}
    cores: dict[tuple[str, int, int], float] = {}
    for name, settings in MODELS.items():
        for n in WIDTHS:
            for re in SPEEDS:
                bed = Bed.of(re, n, settings)
                found[name, n, re] = bed.overall_nusselt_number()
                cores[name, n, re] = bed.core_conductivity
    groups = {"100 to 200": (100, 200), "420": (420, 420), "700 to 1000": (700, 1000), "1500 to 3000": (1500, 3000)}
    page.add("", "## Heat transfer from a wall of fixed temperature", "", *paragraphs(texts.HEAT))
    page.add(*texts.SET_RANGES.split("\n"), *paragraphs(texts.SCATTER, **_scatter(medians)))
    page.head(
        "closures",
        *(f"Re_d {group}" for group in groups),
        "all 32 points",
        "Li, Finlayson alone (D/d ≤ 20)",
        "all points",
    )
    for name in MODELS:
        ratios = {group: [found[name, n, re] / medians[n, re] for n in WIDTHS for re in SPEEDS if a <= re <= b]
                  for group, (a, b) in groups.items()}  # fmt: skip
        everything = [ratio for values in ratios.values() for ratio in values]
        alone = [found[name, n, re] / li_finlayson(re, n) for n in WIDTHS if n <= 20 for re in SPEEDS]
        page.row(name, *map(spread, ratios.values()), spread(everything), spread(alone),
                 "-" if name == "thesis, k-epsilon" else verdict(everything, 0.15))  # fmt: skip
    page.add(
        "",
        *paragraphs(texts.BRANCHES),
        "![Overall heat transfer against Reynolds number](validation/heat_transfer.png)",
    )
    _draw_heat_transfer(found, medians, pictures / "heat_transfer.png")
    page.add("", "### Split into the core and the wall", "", *paragraphs(texts.SPLIT))
    page.head("Re_d", "k_r: thesis", "measured", "VDI, Specchia", "Nu_w: thesis", "measured", "four correlations")
    pr, at_rest = FLUID.prandtl_number, stagnant(0.4, 5e-3)
    for re in (100, 420, 1000, 3000):
        core = [cores[name, 20, re] for name in ("thesis, damped N-K", "measured")]
        wall = [wall_of(found[name, 20, re], cores[name, 20, re], 20.0) for name in ("thesis, damped N-K", "measured")]
        radial = sorted([radial_vdi(re, 20, at_rest, pr), radial_specchia(re, 20, at_rest, pr)])
        published = [nu(re, 20, at_rest, pr) for nu in WALL.values()]
        page.row(re, *(f"{k:.0f}" for k in core), "{:.0f} to {:.0f}".format(*radial), *(f"{w:.0f}" for w in wall),
                 f"{min(published):.0f} to {max(published):.0f}")  # fmt: skip

    lengths = (0.6, 1.2)
    checks = {
        name: (found[name, 10, 420], run_along(420, 10, MODELS[name], lengths))
        for name in ("thesis, damped N-K", "measured")
    }
    told = "; ".join(f"{name} {a:.2f} and {b:.2f}" for name, (a, b) in checks.items())
    page.add("", *paragraphs(texts.SPLIT_END, short=lengths[0], long=lengths[1], told=told))


def _draw_heat_transfer(
    found: Mapping[tuple[str, int, int], float], medians: Mapping[tuple[int, int], float], path: Path
) -> None:
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
    for axis, n in zip(axes, (10, 20), strict=True):
        every = {name: [overall_sets(re, n)[name] for re in SPEEDS] for name in overall_sets(SPEEDS[0], n)}
        middle = np.array([medians[n, re] for re in SPEEDS])
        for values in every.values():
            axis.loglog(SPEEDS, values, color="0.6", lw=0.8)
        axis.fill_between(SPEEDS, 0.88 * middle, 1.12 * middle, color="0.85", label="median of eight sets, ±12 %")
        for name, style in zip(MODELS, ("C1:", "C2:", "C4--", "C3-", "C0-"), strict=True):
            axis.loglog(SPEEDS, [found[name, n, re] for re in SPEEDS], style, label=name)
        axis.set_title(f"D/d = {n} (grey: the eight sets)")
        axis.set_xlabel("Re$_d$")
    axes[0].set_ylabel("overall Nu = h d/λ$_f$")
    axes[0].legend(fontsize=8)
    save(figure, path)


def permeability(page: Page) -> None:
    """The thesis's five measured beds."""
    page.add("", "## Permeability", "", *paragraphs(texts.PERMEABILITY))
    page.head(
        "bed", "bead diameter, mm", "measured, 1e-8 m²", "Macdonald (180)", "Ergun (150)", "viscous constant inferred"
    )
    for bed in PUBLISHED:
        ratios = [bed[name] / bed["k_global"] for name in ("macdonald", "ergun")]
        page.row(bed["id"], f"{1e3 * bed['diameter']:.2f}", f"{1e8 * bed['k_global']:.2f}", *(f"{r:.2f}" for r in ratios),
                 f"{180.0 * ratios[0]:.0f}")  # fmt: skip
    inferred = [180.0 * bed["macdonald"] / bed["k_global"] for bed in PUBLISHED]
    page.add(
        "", *paragraphs(texts.PERMEABILITY_END, mean=statistics.mean(inferred), deviation=statistics.stdev(inferred))
    )


def steel(page: Page, pictures: Path, runs: Path) -> None:
    """The measured bed of steel beads."""
    page.add("", "## A bed of steel beads heated from above", "", *paragraphs(texts.STEEL))
    page.head("closures of the model", "after 4000 s at 40 / 60 / 73 mm, °C", "rms, K", "rms of all, K", "within 2 K")
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.8), sharey=True, layout="constrained")
    files = sorted((HERE / "beds" / "steel_heated_from_above").glob("measured_*.csv"))
    end: list[str] = []
    rises = ""
    choices = {
        "measured": {},
        "measured, no radiation": {"bed.emissivity": 0.0},
        "thesis": {"model.closures": "thesis"},
    }
    for (name, settings), style in zip(choices.items(), ("C0-", "C0:", "C3-"), strict=True):
        folder = runs / name.replace(", ", "-").replace(" ", "-")
        porousmold.run(Scene.load(STEEL, {**DRAWN, **settings}), out=folder)
        deviations: list[Deviation] = [each for path in files for each in compare(folder, path).deviations]
        errors = [each.simulated - each.measured for each in deviations]
        end = [f"{each.measured[-1] - 273.15:.1f}" for each in deviations]
        all_errors = np.concatenate(errors)
        if name == "measured":
            parts = [(d.simulated[-1] - d.simulated[0]) / (np.mean(d.measured[-5:]) - 293.15) for d in deviations]
            rises = " / ".join(f"{part:.0%}" for part in parts)
        page.row(name, " / ".join(f"{each.simulated[-1] - 273.15:.1f}" for each in deviations),
                 " / ".join(f"{np.sqrt(np.mean(e**2)):.2f}" for e in errors), f"{np.sqrt(np.mean(all_errors**2)):.2f}",
                 f"{np.mean(np.abs(all_errors) <= 2.0):.0%}")  # fmt: skip
        for axis, each in zip(axes, deviations, strict=True):
            if style == "C0-":
                axis.fill_between(
                    each.time, each.measured - 275.15, each.measured - 271.15, color="0.88", label="measured ±2 K"
                )
                axis.plot(each.time, each.measured - 273.15, "k.", ms=3, label="measured")
                axis.set_title(f"{each.name} below the wall")
                axis.set_xlabel("time in s")
            axis.plot(each.time, each.simulated - 273.15, style, label=f"model, closures {name}")
    page.row("(measurement)", " / ".join(end), "", "", "")
    axes[0].set_ylabel("temperature in °C")
    axes[0].legend(fontsize=8)
    save(figure, pictures / "steel.png")
    page.add("", *paragraphs(texts.STEEL_END, rises=rises), "![Steel beads](validation/steel.png)")


def beds_at_rest(page: Page, pictures: Path) -> None:
    """Measured conductivities and a profile in vacuum."""
    page.add("", "## Conductivity of beds at rest", "", *paragraphs(texts.AT_REST))
    page.head("measured on", "computed for", "computed over measured, median", "least to most")
    for measured in at_rest.SETS:
        for words in measured.beds:
            ratios = measured.ratios(words)
            page.row(measured.name, words, f"{np.median(ratios):.2f}", spread(list(ratios)))
    page.add("", *texts.AT_REST_END.split("\n"), *paragraphs(texts.COMPILATION))
    page.head("void", "flattening", "below 10", "10 to 1000", "above 1000", "median deviation", "within 30 %",
              "rms, a factor of")  # fmt: skip
    for void in (0.36, 0.40, 0.42):
        for flattening in (None, at_rest.CERAMIC, at_rest.STEEL):
            beads, measured_ratio, found = at_rest.compilation(void, flattening)
            off = found / measured_ratio
            parts = [off[(beads > low) & (beads <= high)] for low, high in ((0.0, 10.0), (10.0, 1e3), (1e3, 1e5))]
            page.row(void, "0.0077 below 300, 0.0013 above" if flattening is None else flattening,
                     *(f"{np.median(part):.2f}" for part in parts), f"{np.median(np.abs(off - 1.0)):.0%}",
                     f"{np.mean(np.abs(off - 1.0) < 0.3):.0%}",
                     f"{np.exp(np.sqrt(np.mean(np.log(off) ** 2))):.2f}")  # fmt: skip
    page.add("", "![Conductivity of beds at rest](validation/at_rest.png)", "", *paragraphs(texts.VACUUM))
    page.head("void", "flattening", "rms, K", "of the range")
    for void in (0.39, 0.49):
        for flattening in (0.0, at_rest.CERAMIC, 0.01, 0.02):
            rms = at_rest.vacuum(void, flattening).rms
            page.row(void, flattening, f"{rms:.1f}", f"{rms / 458.0:.1%}")
    _draw_beds_at_rest(pictures / "at_rest.png")


def _draw_beds_at_rest(path: Path) -> None:
    figure, (scatter, profile) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
    beads, measured, _ = at_rest.compilation(0.40)
    order = np.argsort(beads)
    for void, style in ((0.36, "C0--"), (0.40, "C0-")):
        computed = at_rest.compilation(void)[2][order]
        scatter.loglog(beads[order], computed, style, label=f"law, void {void}")
    middle = at_rest.compilation(0.40)[2][order]
    scatter.fill_between(beads[order], 0.7 * middle, 1.3 * middle, color="0.88", label="±30 %")
    scatter.loglog(beads, measured, "k.", label="measured (van Antwerpen's compilation)")
    scatter.set(xlabel="conductivity of beads over gas", ylabel="conductivity of bed over gas", title="beds in gas")
    for flattening, style in ((0.0, "C3-"), (at_rest.CERAMIC, "C0-"), (0.02, "C2-")):
        found = at_rest.vacuum(0.49, flattening)
        profile.plot(found.places, found.computed - 273.15, style, label=f"law, flattening {flattening}")
    profile.plot(found.places, found.measured - 273.15, "k.", ms=7, label="measured (De Beer)")
    profile.set(xlabel="distance from the hot wall in m", ylabel="temperature in °C", title="pebbles in vacuum")
    for axis in (scatter, profile):
        axis.legend(fontsize=8)
    save(figure, path)


def helium(page: Page) -> None:
    """A measured pressure drop of helium."""
    page.add("", "### A pressure drop that was measured", "", *paragraphs(texts.HELIUM))
    page.head("law", "computed over measured at 1 bar", "at 2 bar")
    for name in ("kta", "erdim", "eisfeld-schnitzlein", "ergun", "macdonald", "carman"):
        slopes = [at_rest.helium_pressure_drop(name, pressure) for pressure in (1e5, 2e5)]
        page.row(name, *(" and ".join(f"{ratio:.2f}" for ratio in ratios) for ratios in slopes))


def heating_times(page: Page) -> None:
    """Both sets, all shipped scenes and turbulence models."""
    page.add("", "## Heating times of the shipped scenes", "", *paragraphs(texts.TIMES))
    turbulence = ("none", "k-epsilon", "nakayama-kuwahara", "damped-nakayama-kuwahara", "decaying-nakayama-kuwahara")
    page.head("scene", "closures", "laminar", "k-epsilon", "N-K", "damped N-K", "decaying N-K")
    for name, path in SHIPPED.items():
        for closures in ("thesis", "measured"):
            chosen = {"model.closures": closures}
            page.row(name, closures, *(f"{_heated(path, chosen | {'model.turbulence': t})[0]:.1f}" for t in turbulence))
    page.add("", *paragraphs(texts.TIMES_LATERAL))
    page.head(
        "scene",
        "thesis",
        "lateral",
        "lateral and axial",
        "measured without axial",
        "measured",
        "solver time, measured over thesis (median of 5)",
    )
    axial = LATERAL | {"model.dispersion": "winterberg-tsotsas-axial"}
    across = {**MEASURED, "model.dispersion": "winterberg-tsotsas"}
    for name, path in SHIPPED.items():
        times = [_heated(path, settings)[0] for settings in (THESIS, LATERAL, axial, across, MEASURED)]
        pairs = [[_heated(path, settings)[1] for settings in (THESIS, MEASURED)] for _ in range(5)]
        cost = statistics.median(measured / thesis for thesis, measured in pairs)
        changes = [f"{time:.1f} ({time / times[0] - 1.0:+.1%})" for time in times[1:]]
        page.row(name, f"{times[0]:.1f}", *changes, f"{cost:.2f}")
    beads = {"bed.bead_material": "aluminium"}
    slow, fast = (_heated(SHIPPED["aluminium mold"], beads | dict(s))[0] for s in (THESIS, MEASURED))
    page.add("", *paragraphs(texts.TIMES_END, slow=slow, fast=fast))


def _heated(path: Path, settings: Settings) -> tuple[float, float]:
    result = porousmold.run(Scene.load(path, {"model.flow": "developed", **DRAWN, **settings}))
    assert result.heating_time is not None
    spent = result.summary["wall_seconds"]
    return result.heating_time, spent["flow"] + spent["energy"]


def main() -> None:
    """Compute everything and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=DOCS / "validation.md")
    out = parser.parse_args().out
    start, pictures = time.perf_counter(), out.parent / "validation"
    pictures.mkdir(parents=True, exist_ok=True)
    page = Page(
        "# Validation: the closures against measurements",
        "",
        "Written by `make validation`; do not edit.",
        "",
        *paragraphs(texts.OPENING),
        "| key | `thesis`, the default | `measured` |",
        "|---|---|---|",
        *(f"| `{key}` | {value} | {CLOSURES['measured'][key]} |" for key, value in CLOSURES["thesis"].items()),
        "",
        *paragraphs(texts.SETS),
    )
    sections: list[Callable[[], None]] = [
        lambda: pressure_drop(page, pictures),
        lambda: helium(page),
        lambda: heat_transfer(page, pictures),
        lambda: permeability(page),
        lambda: steel(page, pictures, HERE.parent / "runs" / "validation"),
        lambda: beds_at_rest(page, pictures),
        lambda: heating_times(page),
    ]
    for section in sections:
        section()
    page.add("", f"Made in {time.perf_counter() - start:.0f} s.")
    page.write(out)


if __name__ == "__main__":
    main()
