"""Pictures of a measured porosity profile, like figures 5.4 and 5.5 of the thesis."""

from pathlib import Path
from typing import Any

import numpy as np

from ..laws.oscillating_porosity import de_klerk
from ..laws.porosity import POROSITY_MODELS
from ..output.figures import STYLE, plt, save


def draw_profile(path: Path, profile: Any, fits: Any, shells: Any, bulk_porosity: float = 0.4) -> Path:
    """phi_V and phi_A with fits; phi_V beside the laws of table 5.1; thin shells beside de Klerk (2003). Gives the path.

    profile: a `MeasuredProfile`; fits: those of its phi_V and phi_A, functions of y/d with `knots`; shells: what
    `thin_shell_porosity` gives; bulk_porosity: of the laws.
    """
    with plt.rc_context(STYLE):
        figure, (averages, laws, layers) = plt.subplots(1, 3, figsize=(15.0, 4.4))
        figure.subplots_adjust(left=0.045, right=0.99, bottom=0.13, top=0.92, wspace=0.16)
        for values, errors, fit, label, colour in (
            (profile.phi_v, profile.phi_v_error, fits[0], "$\\phi_V$", "tab:blue"),
            (profile.phi_a, profile.phi_a_error, fits[1], "$\\phi_A$", "tab:orange"),
        ):
            averages.errorbar(profile.position, values, 2.0 * errors, fmt="o", markersize=3, color=colour, label=label)
            at = np.union1d(np.linspace(0.0, profile.position[-1], 400), fit.knots)
            averages.plot(at, fit(at), color=colour, linewidth=1.0, label=f"{label}, piecewise linear")
        averages.set_title("averaging spheres (bars: two standard errors)", fontsize=10)
        laws.plot(profile.position, profile.phi_v, "ok", markersize=3, label="$\\phi_V$ of the packing")
        at = np.linspace(0.0, profile.position[-1], 400)
        for name, law in POROSITY_MODELS.items():
            if name != "constant":
                laws.plot(at, law(at, 1.0, bulk_porosity), linewidth=1.2, label=name)
        laws.set_title(f"exponential laws with bulk porosity {bulk_porosity:g}", fontsize=10)
        position, void, errors = shells
        layers.errorbar(position, void, 2.0 * errors, fmt="-", color="tab:blue", linewidth=1.0, label="thin shells")
        at = np.linspace(0.0, position[-1], 400)
        layers.plot(at, de_klerk(at, profile.bulk_porosity), "k--", linewidth=1.0, label="de Klerk (2003)")
        layers.set_title("void fraction of thin shells", fontsize=10)
        for axes in (averages, laws):
            axes.set(xlim=(0.0, min(6.0, profile.position[-1])), ylim=(0.3, 1.02))
        layers.set(xlim=(0.0, position[-1]), ylim=(0.0, 1.02))
        for axes in (averages, laws, layers):
            axes.set_xlabel("wall distance / bead diameter")
            axes.legend(fontsize=8)
        return save(figure, path)


def draw_conduction(path: Path, found: Any, reference: float, diameter: float) -> Path:
    """Temperature and conductivity against wall distance: `found` is a `Conduction`, `reference` another conductivity (W/m/K)."""
    with plt.rc_context(STYLE):
        figure, (temperature, conductivity) = plt.subplots(1, 2, figsize=(10.0, 4.0), layout="constrained")
        place = found.wall_distance / diameter
        temperature.plot([0.0, *place], [0.5, *found.temperature], "o-", markersize=4)
        temperature.set(ylabel="temperature over the difference of the walls", ylim=(0.0, 0.52))
        between = found.conductivity_places / diameter
        conductivity.plot(between, found.conductivity, "o-", markersize=4, label="between layers of beads")
        conductivity.axhline(found.core, color="tab:blue", linestyle="--", label="core")
        conductivity.axhline(reference, color="0.4", linestyle=":", label="Zehner, Bauer, Schluender")
        conductivity.set(ylabel="conductivity in W/(m K)", ylim=(0.0, None))
        conductivity.legend(fontsize=9)
        for axes in (temperature, conductivity):
            axes.set(xlabel="wall distance / bead diameter", xlim=(0.0, None))
        return save(figure, path)
